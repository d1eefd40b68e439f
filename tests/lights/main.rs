//! Lights: the tables that choose them, their densities, what arrives from them, on lavapipe and in
//! the reference.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]
#![allow(non_snake_case, reason = "the field's letters: Le")]

mod arrival;
mod choice;
#[path = "../common/mod.rs"]
mod common;
mod environment;
mod facing;
mod samples;

use bytemuck::Zeroable;
use common::packed::{empty_packed, identity_texture, no_texture};
use common::shapes::Random;
use glam::Vec3;
use snell::pack::Packed;
use snell::pack::environment::build_environment;
use snell::pack::lights::*;
use snell::pack::vertex::pack_normal;
use snell::scene::{Environment, Profile, PunctualKind, PunctualLight};
use snell::shared::*;
use std::sync::Arc;

const COUNT: usize = 100_000;

const SCENE_RADIUS: f32 = 3.0;

/// A map with black regions, a smooth sky and a sun: awkward size, turned.
fn sky(width: u32, height: u32, sun: f32) -> Environment {
    let radiance = (0..width * height)
        .map(|i| {
            let (x, y) = (i % width, i / width);
            match (x * 8 / width, y * 8 / height) {
                (1, _) | (_, 5) => [0.0; 3],
                _ if x == width * 5 / 8 && y == height / 4 => [sun, 0.9 * sun, 0.7 * sun],
                (column, row) => [0.2 + 0.1 * column as f32, 0.5, 1.0 / (1.0 + row as f32)],
            }
        })
        .collect();
    Environment {
        width,
        height,
        radiance,
        strength: 1.5,
        rotation: 0.7,
    }
}

fn with_environment(mut packed: Packed, environment: &Environment) -> Packed {
    let built = build_environment(environment);
    let frame = &mut packed.frame;
    frame.environment_strength = environment.strength;
    frame.environment_cos = environment.rotation.cos();
    frame.environment_sin = environment.rotation.sin();
    frame.environment_size = built.size;
    frame.environment_cells = built.cells_size;
    packed.environment = built.texels;
    packed.environment_cells = built.cells;
    let light = environment_light(built.mean_luminance * environment.strength);
    packed.lights.push(light);
    packed
}

fn with_tables(mut packed: Packed) -> Packed {
    let weights = build_lights(&mut packed.lights, SCENE_RADIUS);
    packed.frame.light_count = packed.lights.len() as u32;
    packed.frame.light_weight_total = weights.total;
    packed.frame.environment_weight = weights.environment;
    packed
}

fn only_environment(environment: &Environment) -> Packed {
    with_tables(with_environment(empty_packed(), environment))
}

/// Adds an emissive triangle with its own material, instance and texture coordinates.
fn add_triangle(
    packed: &mut Packed,
    corners: [Vec3; 3],
    emissive: Vec3,
    flags: u32,
    flipped: bool,
) {
    let vertex = |packed: &mut Packed, uv: [f32; 2]| {
        let word = packed.vertices.len() as u32;
        packed.vertices.push(pack_normal(Vec3::Z));
        packed.vertices.extend(uv.map(f32::to_bits));
        word
    };
    let vertices = [[0.1, 0.2], [1.4, 0.3], [0.2, 0.9]].map(|uv| vertex(packed, uv));
    let number = packed.triangles.len() as u32;
    packed.triangles.push(Triangle {
        p0: corners[0].to_array(),
        vertex0: vertices[0],
        e1: (corners[1] - corners[0]).to_array(),
        vertex1: vertices[1],
        e2: (corners[2] - corners[0]).to_array(),
        vertex2: vertices[2],
        material: number,
        vertex_layout: 1 << LAYOUT_TEXCOORDS_SHIFT,
        ..Triangle::zeroed()
    });
    packed.instances.push(Instance {
        flags: if flipped { INSTANCE_FLIPPED } else { 0 },
        ..Instance::zeroed()
    });
    let emission_weight = emissive.dot(Vec3::new(0.2126, 0.7152, 0.0722));
    packed.materials.push(Material {
        emissive: emissive.to_array(),
        emission_weight,
        flags: flags | MATERIAL_EMISSIVE,
        emissive_texture: no_texture(),
        ..Material::zeroed()
    });
    let light = triangle_light(
        corners,
        emissive.to_array(),
        emission_weight,
        number,
        number,
    );
    packed.lights.push(light);
}

fn punctual(kind: PunctualKind, position: Vec3, range: Option<f32>) -> Light {
    punctual_light(
        &PunctualLight {
            name: String::new(),
            kind,
            intensity: Vec3::new(3.0, 2.0, 1.0),
            position,
            direction: Vec3::new(0.6, -0.8, 0.0),
            range,
        },
        &[],
    )
}

/// A lamp with a table that is rough in both angles.
fn measured(packed: &mut Packed) -> (Light, Profile) {
    let (rows, columns) = (19u32, 24u32);
    let mut uniform = Random(21);
    let profile = Profile {
        rows,
        columns,
        candela: (0..rows * columns).map(|_| 0.5 + uniform.unit()).collect(),
    };
    let places = place_profiles(&[Arc::new(profile.clone())], &mut packed.texels).unwrap();
    let lamp = PunctualLight {
        name: String::new(),
        kind: PunctualKind::Profile {
            profile: 0,
            azimuth_zero: Vec3::new(0.8, 0.6, 0.0),
        },
        intensity: Vec3::new(3.0, 2.0, 1.0),
        position: Vec3::new(0.1, 0.3, 0.2),
        direction: Vec3::new(0.6, -0.8, 0.0),
        range: None,
    };
    (punctual_light(&lamp, &places), profile)
}

/// Every kind of light at once, and a texture on one of the triangles.
fn all_lights() -> Packed {
    let mut packed = empty_packed();
    let spot = PunctualKind::Spot {
        inner_angle: 0.3,
        outer_angle: 0.9,
    };
    packed.lights.push(punctual(
        PunctualKind::Point,
        Vec3::new(1.0, 2.0, 0.5),
        None,
    ));
    packed.lights.push(punctual(
        PunctualKind::Point,
        Vec3::new(0.2, 0.1, -1.0),
        Some(1.5),
    ));
    packed
        .lights
        .push(punctual(spot, Vec3::new(-1.0, 2.0, 0.3), Some(10.0)));
    packed
        .lights
        .push(punctual(PunctualKind::Directional, Vec3::ZERO, None));
    let corners = [
        Vec3::new(-1.0, 1.5, -1.0),
        Vec3::new(1.0, 1.6, -1.0),
        Vec3::new(0.0, 1.4, 1.0),
    ];
    let moved = |by: f32| corners.map(|corner| corner + by * Vec3::new(0.3, -1.0, 0.2));
    add_triangle(&mut packed, corners, Vec3::new(4.0, 5.0, 6.0), 0, false);
    add_triangle(&mut packed, moved(1.0), Vec3::new(1.0, 2.0, 0.5), 0, true);
    add_triangle(
        &mut packed,
        moved(2.0),
        Vec3::ONE,
        MATERIAL_DOUBLE_SIDED,
        false,
    );
    let mut uniform = Random(9);
    packed.texels = (0..15).map(|_| uniform.bits() as u32).collect();
    packed.materials[0].emissive_texture =
        identity_texture([3, 5], FORMAT_RGBA8_SRGB | FILTER_LINEAR << 8);
    let mut packed = with_environment(packed, &sky(37, 19, 500.0));
    let (lamp, _) = measured(&mut packed);
    packed.lights.push(lamp);
    with_tables(packed)
}
