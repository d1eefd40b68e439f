//! Scenes made in code, for tests that need no file.

use glam::{Affine3A, Vec3, Vec4};
use snell::pack::{Background, Packed, View, pack};
use snell::scene::{
    AlphaMode, Camera, Instance, Material, Mesh, MetallicRoughness, Model, Primitive, Projection,
    Scene,
};

/// Random numbers with a fixed seed (Steele, Lea and Flood 2014, SplitMix64).
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / 16_777_216.0
    }

    pub fn range(&mut self, from: f32, to: f32) -> f32 {
        from + (to - from) * self.unit()
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.bits() % count as u64) as usize
    }

    /// In the cube from -1 to 1.
    pub fn cube(&mut self) -> Vec3 {
        Vec3::new(
            self.range(-1.0, 1.0),
            self.range(-1.0, 1.0),
            self.range(-1.0, 1.0),
        )
    }

    pub fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.cube();
            if v.length_squared() > 0.01 && v.length_squared() <= 1.0 {
                return v.normalize();
            }
        }
    }
}

/// A grey double-sided metallic-roughness material.
pub fn material() -> Material {
    Material {
        name: "grey".to_owned(),
        model: Model::MetallicRoughness(MetallicRoughness {
            base_color: Vec4::new(0.5, 0.5, 0.5, 1.0),
            base_color_texture: None,
            metallic: 0.0,
            roughness: 0.5,
            metallic_roughness_texture: None,
            ior: 1.5,
            extensions: Box::default(),
        }),
        alpha_mode: AlphaMode::Opaque,
        double_sided: true,
        emissive: Vec3::ZERO,
        emissive_texture: None,
        normal_texture: None,
        normal_scale: 1.0,
    }
}

/// Separate triangles with flat normals.
pub fn flat(triangles: &[[Vec3; 3]]) -> Mesh {
    let positions: Vec<Vec3> = triangles.iter().flatten().copied().collect();
    let normals = triangles
        .iter()
        .flat_map(|[p0, p1, p2]| [(p1 - p0).cross(p2 - p0).normalize_or_zero(); 3])
        .collect();
    let corners = (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]);
    mesh(Primitive {
        triangles: corners.collect(),
        positions,
        normals,
        ..Primitive::default()
    })
}

pub fn mesh(primitive: Primitive) -> Mesh {
    Mesh {
        name: "mesh".to_owned(),
        primitives: vec![primitive],
    }
}

/// `count` triangles of edge `size` somewhere in the cube from -1 to 1.
pub fn soup(random: &mut Random, count: usize, size: f32) -> Mesh {
    let triangles: Vec<_> = (0..count)
        .map(|_| {
            let p = random.cube();
            [
                p,
                p + size * random.direction(),
                p + size * random.direction(),
            ]
        })
        .collect();
    flat(&triangles)
}

/// A height field over the square from -1 to 1 in x and z, `n` cells a side, corners shared, facing up.
pub fn grid(n: u32, height: impl Fn(f32, f32) -> f32) -> Mesh {
    let mut primitive = Primitive::default();
    for j in 0..=n {
        for i in 0..=n {
            let x = 2.0 * i as f32 / n as f32 - 1.0;
            let z = 2.0 * j as f32 / n as f32 - 1.0;
            primitive.positions.push(Vec3::new(x, height(x, z), z));
            primitive.normals.push(Vec3::Y);
        }
    }
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            let c = a + n + 1;
            primitive.triangles.push([a, c, a + 1]);
            primitive.triangles.push([a + 1, c, c + 1]);
        }
    }
    mesh(primitive)
}

/// A closed sphere about the origin, `n` cells from pole to pole, corners shared.
pub fn sphere(n: u32, radius: f32) -> Mesh {
    let mut primitive = Primitive::default();
    for j in 0..=n {
        for i in 0..2 * n {
            let theta = std::f32::consts::PI * j as f32 / n as f32;
            let phi = std::f32::consts::PI * i as f32 / n as f32;
            let pole = j == 0 || j == n;
            let sin = if pole { 0.0 } else { theta.sin() };
            let normal = Vec3::new(sin * phi.cos(), theta.cos(), sin * phi.sin());
            primitive.positions.push(radius * normal);
            primitive.normals.push(normal);
        }
    }
    for j in 0..n {
        for i in 0..2 * n {
            let next = (i + 1) % (2 * n);
            let (a, b) = (j * 2 * n + i, j * 2 * n + next);
            let (c, d) = (a + 2 * n, b + 2 * n);
            if j > 0 {
                primitive.triangles.push([a, b, c]);
            }
            if j + 1 < n {
                primitive.triangles.push([b, d, c]);
            }
        }
    }
    mesh(primitive)
}

pub fn instance(mesh: usize, world_from_object: Affine3A) -> Instance {
    Instance {
        mesh,
        world_from_object,
        motion: Box::default(),
        node: 0,
        animated: false,
    }
}

/// Meshes with one grey material, placed as given.
pub fn scene(meshes: Vec<Mesh>, instances: Vec<Instance>) -> Scene {
    Scene {
        meshes: meshes.into_iter().map(std::sync::Arc::new).collect(),
        instances,
        materials: vec![material()],
        ..Scene::default()
    }
}

/// The same with two levels of hierarchies: nothing of it is baked.
pub fn two_levels(mut scene: Scene) -> Scene {
    for instance in &mut scene.instances {
        instance.animated = true;
    }
    scene
}

pub fn view() -> View {
    View {
        camera: Camera {
            name: String::new(),
            world_from_camera: Affine3A::IDENTITY,
            closing: None,
            lens: None,
            projection: Projection::Perspective {
                yfov: 1.0,
                aspect: None,
                near: 0.01,
            },
        },
        film_size: [16, 16],
        seed: 0,
        max_depth: 4,
        background: Background::Environment,
        clamp: None,
    }
}

pub fn packed(scene: &Scene) -> Packed {
    pack(scene, &view()).unwrap_or_else(|error| panic!("{error}"))
}
