//! The scene that is measured where none is named: displaced spheres on a plane under a lamp and an even
//! sky, made in memory.

use std::f32::consts::{FRAC_PI_4, TAU};
use std::sync::Arc;

use glam::{Affine3A, Mat3, Vec3};

use crate::scene::{
    AlphaMode, Camera, Environment, Extensions, Instance, Material, Mesh, MetallicRoughness, Model,
    Primitive, Projection, Scene,
};

/// Squares along the side of each of a sphere's six faces: 9 spheres of 19 200 triangles.
const SQUARES: u32 = 40;
/// Of the spheres' centres, metres.
const SPACING: f32 = 2.5;

/// Nine spheres, diffuse, glossy and metallic by column.
pub fn scene() -> Scene {
    let looks = [(0.0, 0.9), (0.0, 0.3), (1.0, 0.25)];
    let colors = [[0.8, 0.35, 0.2], [0.3, 0.6, 0.35], [0.9, 0.75, 0.45]];
    let mut materials: Vec<Material> = looks
        .iter()
        .zip(colors)
        .map(|(&(metallic, roughness), color)| {
            material(Vec3::from(color), metallic, roughness, Vec3::ZERO)
        })
        .collect();
    materials.push(material(Vec3::splat(0.6), 0.0, 0.8, Vec3::ZERO));
    materials.push(material(Vec3::ZERO, 0.0, 1.0, Vec3::splat(12.0)));
    let (plane, lamp) = (looks.len(), looks.len() + 1);

    let mut meshes = Vec::new();
    let mut instances = Vec::new();
    let mut place = |primitive: Primitive, at: Vec3| {
        instances.push(Instance {
            mesh: meshes.len(),
            node: meshes.len(),
            world_from_object: Affine3A::from_translation(at),
            motion: Box::default(),
            animated: false,
        });
        meshes.push(Arc::new(Mesh {
            name: String::new(),
            primitives: vec![primitive],
        }));
    };
    for number in 0..9_u8 {
        let (column, row) = (usize::from(number % 3), f32::from(number / 3));
        let x = SPACING * (column as f32 - 1.0);
        let wavenumber = 4.0 + f32::from(number);
        place(
            sphere(wavenumber, column),
            Vec3::new(x, 1.1, SPACING * (row - 1.0)),
        );
    }
    place(rectangle(20.0, Vec3::Y, plane), Vec3::ZERO);
    place(rectangle(1.5, Vec3::NEG_Y, lamp), Vec3::new(0.0, 7.0, 0.0));
    Scene {
        meshes,
        instances,
        materials,
        cameras: vec![camera()],
        environment: Some(Environment {
            width: 1,
            height: 1,
            radiance: vec![[0.4, 0.5, 0.6]],
            strength: 1.0,
            rotation: 0.0,
        }),
        ..Scene::default()
    }
}

fn camera() -> Camera {
    let eye = Vec3::new(0.0, 6.0, 10.0);
    let back = (eye - Vec3::new(0.0, 0.7, 0.0)).normalize();
    let right = Vec3::Y.cross(back).normalize();
    let turn = Mat3::from_cols(right, back.cross(right), back);
    Camera {
        name: "bench".into(),
        world_from_camera: Affine3A::from_mat3_translation(turn, eye),
        closing: None,
        projection: Projection::Perspective {
            yfov: FRAC_PI_4,
            aspect: None,
            near: 0.0,
        },
        lens: None,
    }
}

fn material(color: Vec3, metallic: f32, roughness: f32, emissive: Vec3) -> Material {
    Material {
        name: String::new(),
        model: Model::MetallicRoughness(MetallicRoughness {
            base_color: color.extend(1.0),
            base_color_texture: None,
            metallic,
            roughness,
            metallic_roughness_texture: None,
            ior: 1.5,
            extensions: Box::<Extensions>::default(),
        }),
        alpha_mode: AlphaMode::Opaque,
        double_sided: false,
        emissive,
        emissive_texture: None,
        normal_texture: None,
        normal_scale: 1.0,
    }
}

/// A square about the origin with this half side, facing +y or -y.
fn rectangle(half: f32, normal: Vec3, material: usize) -> Primitive {
    let positions = [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]];
    let up = normal.y > 0.0;
    Primitive {
        positions: positions.map(|[x, z]| half * Vec3::new(x, 0.0, z)).into(),
        normals: vec![normal; 4],
        triangles: if up {
            vec![[0, 1, 2], [0, 2, 3]]
        } else {
            vec![[0, 2, 1], [0, 3, 2]]
        },
        material,
        ..Primitive::default()
    }
}

/// The unit sphere with waves on it: a cube's faces blown up, seamless, since a point depends on its
/// direction alone.
fn sphere(wavenumber: f32, material: usize) -> Primitive {
    let mut sphere = Primitive {
        material,
        ..Primitive::default()
    };
    for face in [Vec3::X, Vec3::Y, Vec3::Z]
        .map(|axis| [axis, -axis])
        .as_flattened()
    {
        // Two axes that make a right-handed frame with the face's normal.
        let u = Vec3::new(face.y, face.z, face.x).abs();
        let v = face.cross(u);
        let first = sphere.positions.len() as u32;
        let side = SQUARES + 1;
        for row in 0..side {
            for column in 0..side {
                // Equal angles give more even squares than equal lengths.
                let [s, t] = [column, row]
                    .map(|i| (TAU / 8.0 * (2.0 * i as f32 / SQUARES as f32 - 1.0)).tan());
                let direction = (*face + s * u + t * v).normalize();
                let (height, gradient) = wave(wavenumber * direction);
                let radius = 1.0 + AMPLITUDE * height;
                // Of a surface r(d) d the normal is along r d less the gradient of r on the sphere.
                let slope = AMPLITUDE * wavenumber * gradient;
                let slope = slope - slope.dot(direction) * direction;
                sphere.positions.push(radius * direction);
                sphere
                    .normals
                    .push((radius * direction - slope).normalize());
            }
        }
        for row in 0..SQUARES {
            for column in 0..SQUARES {
                let at = first + row * side + column;
                sphere.triangles.push([at, at + 1, at + side + 1]);
                sphere.triangles.push([at, at + side + 1, at + side]);
            }
        }
    }
    sphere
}

/// Height of the waves as part of the radius.
const AMPLITUDE: f32 = 0.1;

/// sin x sin y sin z, and its gradient.
fn wave(p: Vec3) -> (f32, Vec3) {
    let (sin, cos) = (p.map(f32::sin), p.map(f32::cos));
    let gradient = Vec3::new(
        cos.x * sin.y * sin.z,
        sin.x * cos.y * sin.z,
        sin.x * sin.y * cos.z,
    );
    (sin.x * sin.y * sin.z, gradient)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gltf::bounds;

    /// Faces look outwards, and normals go with them.
    #[test]
    fn spheres_are_closed_and_face_outwards() {
        let sphere = sphere(6.0, 0);
        let mut volume = 0.0;
        for triangle in &sphere.triangles {
            let [a, b, c] = triangle.map(|corner| sphere.positions[corner as usize]);
            let n = (b - a).cross(c - a);
            assert!(n.dot(a) > 0.0);
            for corner in triangle {
                assert!(n.normalize().dot(sphere.normals[*corner as usize]) > 0.9);
            }
            volume += f64::from(a.dot(b.cross(c))) / 6.0;
        }
        // The volume: the sphere's times the mean of (1 + h)^3, and h is odd.
        let ball = 4.0 / 3.0 * std::f64::consts::PI;
        assert!((volume / ball - 1.0).abs() < 0.01, "{volume}");
    }

    #[test]
    fn everything_stands_on_the_plane() {
        let (low, _) = bounds(&scene()).expect("there is something");
        assert_eq!(low.y, 0.0);
        assert_eq!(scene().instances.len(), 11);
    }
}
