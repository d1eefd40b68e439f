//! Scenes of a few bodies, seen along -z by a parallel camera 10 m above the origin.

use crate::common::{self, shapes};
use crate::expect::{Power, Seen, check};
use glam::{Affine3A, Vec3, Vec4};
use snell::film::Film;
use snell::pack::{Background, Packed, View, pack};
use snell::render::Settings;
use snell::scene::bsdf_model::BsdfModel;
use snell::scene::{Camera, Material, Mesh, Model, Projection, Scene};

/// Metres above the origin.
pub const CAMERA_HEIGHT: f64 = 10.0;
/// The camera sees x and y up to this, metres.
pub const SEEN: f64 = 0.5;
/// What many reflections leave inside must have come out.
const MAX_DEPTH: u32 = 200;

/// Bodies with one material each, and what the scene's materials cannot say (yet) in lecture's words.
#[derive(Default)]
pub struct Stage {
    pub scene: Scene,
    pub max_depth: Option<u32>,
    change: Vec<Change>,
}

type Change = Box<dyn Fn(&mut snell::shared::Material)>;

impl Stage {
    /// Adds a body with a material of its own; returns the material's index.
    pub fn add(&mut self, mut mesh: Mesh, material: Material) -> usize {
        self.add_changed(&mut mesh, material, |_| ())
    }

    /// The same with its packed material changed.
    pub fn add_changed(
        &mut self,
        mesh: &mut Mesh,
        material: Material,
        change: impl Fn(&mut snell::shared::Material) + 'static,
    ) -> usize {
        let index = self.scene.materials.len();
        mesh.primitives[0].material = index;
        self.scene.instances.push(shapes::instance(
            self.scene.meshes.len(),
            Affine3A::IDENTITY,
        ));
        self.scene.meshes.push(mesh.clone().into());
        self.scene.materials.push(material);
        self.change.push(Box::new(change));
        index
    }

    /// A body of an absorbing dielectric, with a smooth surface.
    pub fn add_medium(&mut self, mut mesh: Mesh, ior: f32, absorption: [f32; 3]) -> usize {
        self.add_changed(
            &mut mesh,
            bsdf(BsdfModel::Dielectric {
                eta: ior,
                distribution: None,
            }),
            move |material| material.absorption = absorption,
        )
    }

    /// Down along -z.
    pub fn view(&self, film_size: [u32; 2]) -> View {
        View {
            camera: Camera {
                name: String::new(),
                world_from_camera: Affine3A::from_translation(CAMERA_HEIGHT as f32 * Vec3::Z),
                closing: None,
                lens: None,
                projection: Projection::Orthographic {
                    xmag: SEEN as f32,
                    ymag: SEEN as f32,
                    near: 0.0,
                },
            },
            film_size,
            seed: 0,
            max_depth: self.max_depth.unwrap_or(MAX_DEPTH),
            background: Background::Color([0.0; 3]),
            clamp: None,
        }
    }

    pub fn pack(&self, film_size: [u32; 2]) -> Packed {
        self.pack_view(&self.view(film_size))
    }

    pub fn pack_view(&self, view: &View) -> Packed {
        let mut packed = pack(&self.scene, view).unwrap();
        for (material, change) in packed.materials.iter_mut().zip(&self.change) {
            change(material);
        }
        packed
    }

    /// Renders on both renderers and compares each part of the picture with its radiance, which is to
    /// be known to `standard_error`.
    pub fn check(
        &self,
        what: &str,
        samples: u32,
        standard_error: f64,
        seen: impl Fn(f64, f64) -> Seen,
    ) {
        let packed = self.pack([16, 16]);
        for (renderer, film) in films(&packed, samples) {
            let Power {
                standard_error: reached,
                ..
            } = check(&format!("{what} on {renderer}"), &film, &seen);
            assert!(
                reached < standard_error,
                "{what} on {renderer}: the standard error is {reached:.2e}"
            );
        }
    }
}

pub fn settings(packed: &Packed, samples: u32) -> Settings {
    let [width, height] = packed.frame.film_size;
    Settings {
        crop: [0, 0, width, height],
        samples: 0..samples,
    }
}

/// By the reference and by the kernels on lavapipe.
pub fn films(packed: &Packed, samples: u32) -> [(&'static str, Film); 2] {
    let settings = settings(packed, samples);
    let (cpu, _) = snell::cpu::render::render(packed, &settings, &|_| {});
    let mut gpu = common::gpu();
    let (lavapipe, _) =
        snell::gpu::render::render(&mut gpu, packed, &settings, &mut |_| {}).unwrap();
    [("the CPU", cpu), ("lavapipe", lavapipe)]
}

pub fn bsdf(bsdf: BsdfModel) -> Material {
    Material {
        model: Model::Bsdf {
            bsdf,
            base_color: Vec4::ONE,
            base_color_texture: None,
        },
        double_sided: false,
        ..shapes::material()
    }
}

pub fn lambertian(reflectance: [f32; 3]) -> Material {
    bsdf(BsdfModel::Lambertian { reflectance })
}

/// Shines on everything and reflects nothing.
pub fn lamp(radiance: [f32; 3]) -> Material {
    Material {
        emissive: Vec3::from_array(radiance),
        ..lambertian([0.0; 3])
    }
}

/// The rectangle between two corners at one z, its front to +z.
pub fn rectangle(lower: Vec3, upper: Vec3) -> Mesh {
    let corner = |x: f32, y: f32| Vec3::new(x, y, lower.z);
    let (a, b) = (lower, corner(upper.x, lower.y));
    let (c, d) = (upper, corner(lower.x, upper.y));
    shapes::flat(&[[a, b, c], [a, c, d]])
}

/// Large enough to be all that the camera sees.
pub fn wide(z: f32) -> Mesh {
    rectangle(Vec3::new(-9.0, -9.0, z), Vec3::new(9.0, 9.0, z))
}

/// The same faces seen from their other side.
pub fn turned(mut mesh: Mesh) -> Mesh {
    for primitive in &mut mesh.primitives {
        primitive.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        primitive.normals.iter_mut().for_each(|n| *n = -*n);
    }
    mesh
}

/// A box, its front outwards.
pub fn cuboid(lower: Vec3, upper: Vec3) -> Mesh {
    let corner = |i: usize| {
        Vec3::new(
            [lower.x, upper.x][i & 1],
            [lower.y, upper.y][i >> 1 & 1],
            [lower.z, upper.z][i >> 2],
        )
    };
    let triangles: Vec<[Vec3; 3]> = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ]
    .iter()
    .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
    .map(|t| t.map(corner))
    .collect();
    shapes::flat(&triangles)
}

/// A box that fills what the camera sees, between two heights.
pub fn slab(from: f32, to: f32) -> Mesh {
    cuboid(Vec3::new(-9.0, -9.0, from), Vec3::new(9.0, 9.0, to))
}

/// A wedge whose front is z = 0 from x = `edge` to `end`, and whose back leaves it at an angle, radians.
pub fn prism(edge: f32, end: f32, apex: f32) -> Mesh {
    let back = -(end - edge) * apex.tan();
    let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
    let (a, b) = (at(edge, -9.0, 0.0), at(edge, 9.0, 0.0));
    let (c, d) = (at(end, -9.0, 0.0), at(end, 9.0, 0.0));
    let (e, f) = (at(end, -9.0, back), at(end, 9.0, back));
    shapes::flat(&[
        [a, c, d],
        [a, d, b],
        [a, b, f],
        [a, f, e],
        [c, e, f],
        [c, f, d],
        [a, e, c],
        [b, d, f],
    ])
}
