//! Lights: the tables that choose them, their densities, what arrives from them, on lavapipe and in
//! the reference.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]
#![allow(non_snake_case, reason = "the field's letters: Le")]

mod common;

use bytemuck::Zeroable;
use common::packed::{empty_packed, identity_texture, no_texture};
use common::shapes::Random;
use common::statistics::{assert_p, chi_square_p};
use glam::{DVec2, DVec3, DVec4, UVec2, Vec3};
use snell::cpu::light::environment::*;
use snell::cpu::light::light::*;
use snell::cpu::light::punctual::{irradiance_punctual, range_attenuation, spot_attenuation};
use snell::cpu::light::tree::light_share;
use snell::cpu::rng::{next_1d, next_2d, rng_init};
use snell::pack::Packed;
use snell::pack::environment::build_environment;
use snell::pack::lights::*;
use snell::scene::{Environment, Profile, PunctualKind, PunctualLight};
use snell::shared::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
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
        packed.vertices.extend([0.0, 0.0, 1.0, uv[0], uv[1]]);
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

/// Direction of a place on the unturned map, by DESIGN's formula solved for d.
fn map_direction(u: f64, v: f64) -> DVec3 {
    let (theta, phi) = (PI * v, 2.0 * PI * (u - 0.5));
    DVec3::new(
        theta.sin() * phi.cos(),
        theta.cos(),
        theta.sin() * phi.sin(),
    )
}

/// The same, turned by the map's rotation.
fn world_direction(environment: &Environment, u: f64, v: f64) -> DVec3 {
    glam::DQuat::from_rotation_y(environment.rotation.into()) * map_direction(u, v)
}

#[test]
fn the_map_lies_and_turns_as_documented() {
    // 8 x 4 texels, each its own radiance; looked up at texel centres.
    let mut environment = Environment {
        width: 8,
        height: 4,
        radiance: (0..32).map(|i| [i as f32, 1.0, 2.0]).collect(),
        strength: 2.0,
        rotation: 0.0,
    };
    let at =
        |environment: &Environment, d: DVec3| Le_environment(&only_environment(environment), d);
    for (x, y) in [(0, 0), (3, 1), (7, 3), (5, 2)] {
        let d = map_direction((f64::from(x) + 0.5) / 8.0, (f64::from(y) + 0.5) / 4.0);
        let expected = DVec3::new(f64::from(2 * (8 * y + x)), 2.0, 4.0);
        assert!(
            (at(&environment, d) - expected).length() < 1e-9,
            "texel {x} {y}"
        );
    }
    // +x is the map's middle, -x its seam where the first and the last column meet, row 0 is up.
    assert_eq!(
        at(&environment, DVec3::X).x,
        2.0 * (11.0 + 12.0 + 19.0 + 20.0) / 4.0
    );
    assert!((at(&environment, -DVec3::X).x - 2.0 * (8.0 + 15.0 + 16.0 + 23.0) / 4.0).abs() < 1e-9);
    assert!(at(&environment, DVec3::Y).x < 2.0 * 7.0);
    // Turned a quarter counter-clockwise seen from above, what was at +x is at -z.
    let before = at(&environment, DVec3::new(0.8, 0.6, 0.0));
    environment.rotation = std::f32::consts::FRAC_PI_2;
    let after = at(&environment, DVec3::new(0.0, 0.6, -0.8));
    assert!((before - after).length() < 1e-5, "{before} {after}");
}

#[test]
fn the_environment_density_integrates_to_one() {
    for environment in [
        sky(37, 19, 500.0),
        sky(1, 1, 1.0),
        sky(1500, 700, 1e6),
        sky(8, 4, 0.0),
    ] {
        let packed = only_environment(&environment);
        let [cells_x, cells_y] = packed.frame.environment_cells.map(f64::from);
        let (mut sum, mut over_sphere) = (0.0, 0.0);
        for y in 0..cells_y as u32 {
            for x in 0..cells_x as u32 {
                let u = (f64::from(x) + 0.5) / cells_x;
                let v = (f64::from(y) + 0.5) / cells_y;
                sum += environment_density(&packed, x, y) / (cells_x * cells_y);
                let d = world_direction(&environment, u, v);
                // Exact: the density per solid angle varies as 1 / sin(theta) inside a cell.
                over_sphere += environment_pdf(&packed, d) * 2.0 * PI * PI * (PI * v).sin()
                    / (cells_x * cells_y);
            }
        }
        assert!(
            (sum - 1.0).abs() < 1e-6,
            "{} x {}: {sum}",
            environment.width,
            environment.height
        );
        assert!(
            (over_sphere - 1.0).abs() < 1e-6,
            "over the sphere: {over_sphere}"
        );
    }
}

#[test]
fn the_environment_table_is_monotone_and_complete() {
    let built = build_environment(&sky(300, 200, 1e9));
    let [cells_x, cells_y] = built.cells_size.map(|n| n as usize);
    assert_eq!(built.cells.len(), (cells_x + 1) * cells_y);
    let rows: Vec<_> = built.cells.chunks_exact(cells_x + 1).collect();
    let up_to = |values: Vec<f32>| {
        assert!(values.is_sorted());
        assert_eq!(*values.last().unwrap(), 1.0);
        assert!(
            values
                .iter()
                .all(|&value| (value * (1 << 24) as f32).fract() == 0.0)
        );
    };
    up_to(rows.iter().map(|row| row[cells_x][0]).collect());
    for row in rows {
        up_to(row[..cells_x].iter().map(|cell| cell[0]).collect());
    }
}

#[test]
fn whatever_shines_can_be_sampled() {
    // One texel alone, in maps finer and coarser than the table, at the seam and at the pole; and
    // one beside a sun that outshines it a billion times.
    for (width, height, x, y) in [
        (5, 3, 0, 1),
        (1500, 700, 1499, 350),
        (90, 45, 40, 0),
        (3, 900, 1, 899),
    ] {
        for sun in [0.0, 1e9] {
            let mut environment = sky(width, height, 0.0);
            environment.radiance.fill([0.0; 3]);
            environment.radiance[(width * (height / 2) + width / 2) as usize] = [sun; 3];
            environment.radiance[(width * y + x) as usize] = [1.0; 3];
            let packed = only_environment(&environment);
            let mut uniform = Random(7);
            let mut shining = 0;
            for _ in 0..20_000 {
                // Within two texels of the lone one.
                let u = (f64::from(x) + f64::from(uniform.range(-2.0, 3.0))) / f64::from(width);
                let v = (f64::from(y) + f64::from(uniform.range(-2.0, 3.0))) / f64::from(height);
                let d = world_direction(&environment, u, v.clamp(1e-5, 1.0 - 1e-5));
                if Le_environment(&packed, d).x > 0.0 {
                    shining += 1;
                    assert!(
                        environment_pdf(&packed, d) > 0.0,
                        "{width} x {height}, uv {u} {v}"
                    );
                }
            }
            assert!(shining > 1000);
        }
    }
}

#[test]
fn a_black_map_weighs_nothing() {
    let mut environment = sky(16, 8, 0.0);
    environment.radiance.fill([0.0, -1.0, 0.0]);
    let packed = only_environment(&environment);
    assert_eq!(packed.frame.light_weight_total, 0.0);
    assert_eq!(packed.frame.environment_weight, 0.0);
    assert_eq!(
        light_sample(&packed, DVec3::ZERO, 0.3, DVec2::splat(0.4), 0.0).pdf,
        0.0
    );
    assert_eq!(environment_sample(&packed, DVec2::splat(0.4)).w, 0.0);
    assert_eq!(light_pdf_environment(&packed, DVec3::X), 0.0);
}

fn environment_samples_gpu(packed: &Packed, us: &[[f32; 2]]) -> Vec<[f32; 4]> {
    let root = "
import package::light::environment::{environment_sample};
@group(3) @binding(0) var<storage, read> us: array<vec2<f32>>;
@group(3) @binding(1) var<storage, read_write> answers: array<vec4<f32>>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&us) { return; }
    answers[id.x] = environment_sample(us[id.x]);
}";
    let bytes = bytemuck::cast_slice(us);
    let answers = common::run_scene(root, packed, &[bytes], us.len() * 16, us.len() as u32);
    bytemuck::pod_collect_to_vec(&answers)
}

#[test]
fn environment_samples_follow_their_density() {
    for environment in [sky(37, 19, 500.0), sky(1, 1, 1.0), sky(512, 200, 3e4)] {
        let packed = only_environment(&environment);
        let [cells_x, cells_y] = packed.frame.environment_cells;
        // Bins of 2 x 2 cells of the turned map, expected from the density function alone.
        let bins_x = cells_x / 2;
        let mut expected = vec![0.0; (bins_x * (cells_y / 2)) as usize];
        let bin = |u: f64, v: f64| {
            let x = ((u * f64::from(bins_x)) as u32).min(bins_x - 1);
            let y = ((v * f64::from(cells_y / 2)) as u32).min(cells_y / 2 - 1);
            (y * bins_x + x) as usize
        };
        for y in 0..cells_y {
            for x in 0..cells_x {
                let u = (f64::from(x) + 0.5) / f64::from(cells_x);
                let v = (f64::from(y) + 0.5) / f64::from(cells_y);
                let pdf = environment_pdf(&packed, world_direction(&environment, u, v));
                expected[bin(u, v)] += COUNT as f64 * pdf * 2.0 * PI * PI * (PI * v).sin()
                    / f64::from(cells_x * cells_y);
            }
        }
        let mut uniform = Random(8);
        let us: Vec<[f32; 2]> = (0..COUNT)
            .map(|_| [uniform.unit(), uniform.unit()])
            .collect();
        let gpu = environment_samples_gpu(&packed, &us);
        let gpu = gpu.iter().map(|a| DVec4::from_array(a.map(f64::from)));
        let cpu = us
            .iter()
            .map(|u| environment_sample(&packed, DVec2::new(u[0].into(), u[1].into())));
        for samples in [gpu.collect::<Vec<_>>(), cpu.collect()] {
            let mut observed = vec![0.0; expected.len()];
            let (mut odd, mut mean_inverse) = (0, 0.0);
            for sample in samples {
                let turned = glam::DQuat::from_rotation_y(-f64::from(environment.rotation));
                let d = turned * sample.truncate();
                assert!((d.length() - 1.0).abs() < 1e-6);
                let uv = DVec2::new(
                    d.z.atan2(d.x) / (2.0 * PI) + 0.5,
                    d.y.clamp(-1.0, 1.0).acos() / PI,
                );
                observed[bin(uv.x, uv.y)] += 1.0;
                let pdf = environment_pdf(&packed, sample.truncate());
                // Rounding takes a few directions into the cell next door.
                odd += usize::from((sample.w - pdf).abs() > 1e-4 * pdf);
                mean_inverse += 1.0 / sample.w / COUNT as f64;
            }
            assert!(odd < COUNT / 1000, "{odd} samples state another density");
            let p = chi_square_p(&observed, &expected);
            assert_p(
                &format!("{} x {}", environment.width, environment.height),
                p,
                6,
            );
            // The mean of 1 / pdf is the solid angle of what can be sampled.
            if environment.width == 1 {
                assert!((mean_inverse - 4.0 * PI).abs() < 0.05, "{mean_inverse}");
            }
        }
    }
}

#[test]
fn the_alias_table_keeps_every_probability() {
    let mut uniform = Random(10);
    for n in [1, 2, 3, 17, 1000, 30_000] {
        let mut weights: Vec<f64> = (0..n).map(|_| f64::from(uniform.unit()).powi(8)).collect();
        weights[n / 2] = 5.0;
        if n > 2 {
            weights[0] = 0.0;
        }
        let mut shares = vec![0.0; n];
        for (i, (alias, threshold)) in alias_table(&weights).into_iter().enumerate() {
            shares[i] += f64::from(threshold);
            shares[alias as usize] += 1.0 - f64::from(threshold);
        }
        let total: f64 = weights.iter().sum();
        for (i, (&share, &weight)) in shares.iter().zip(&weights).enumerate() {
            let expected = weight * n as f64 / total;
            // Each entry that leans on this one brings half a unit in float32's last place.
            assert!(
                (share - expected).abs() < 1e-7 * (1.0 + expected),
                "{n}: entry {i}"
            );
            assert!(
                weight > 0.0 || share == 0.0,
                "{n}: entry {i} weighs nothing"
            );
        }
    }
    assert_eq!(alias_table(&[0.0, 0.0]), [(0, 1.0), (1, 1.0)]);
    assert_eq!(alias_table(&[]), []);
}

#[test]
fn lights_are_picked_by_weight() {
    for n in [7, 300, 5000] {
        let mut packed = empty_packed();
        let mut uniform = Random(11);
        for _ in 0..n {
            let mut light = punctual(PunctualKind::Point, Vec3::ZERO, None);
            light.radiance = [uniform.unit().powi(4) + 1e-3; 3];
            packed.lights.push(light);
        }
        let packed = with_tables(packed);
        let mut observed = vec![0.0; n];
        let draws = 500_000;
        for _ in 0..draws {
            let (u_pick, x, y) = (uniform.unit(), uniform.unit(), uniform.unit());
            let u = DVec2::new(x.into(), y.into());
            observed[light_pick(&packed, u_pick.into(), u).index as usize] += 1.0;
        }
        let total = f64::from(packed.frame.light_weight_total);
        let expected: Vec<_> = (packed.lights.iter())
            .map(|light| f64::from(light.weight) / total * f64::from(draws))
            .collect();
        assert_p(
            &format!("{n} lights"),
            chi_square_p(&observed, &expected),
            3,
        );
    }
}

#[test]
fn weights_are_powers_in_one_unit() {
    let packed = all_lights();
    let luminance = 0.2126 * 3.0 + 0.7152 * 2.0 + 0.0722;
    let near = |a: f32, b: f64| assert!((f64::from(a) - b).abs() < 1e-5 * b, "{a} {b}");
    near(packed.lights[0].weight, 4.0 * luminance);
    near(
        packed.lights[2].weight,
        2.0 * luminance * (1.0 - 0.5 * (0.3_f64.cos() + 0.9_f64.cos())),
    );
    let area = |light: &Light| {
        let edges = [light.direction, light.edge2].map(|e| Vec3::from(e).as_dvec3());
        0.5 * edges[0].cross(edges[1]).length()
    };
    let emission = 0.2126 * 4.0 + 0.7152 * 5.0 + 0.0722 * 6.0;
    near(packed.lights[4].weight, emission * area(&packed.lights[4]));
    // Lights without a place keep their proportion, 9 E to 36 pi L, and at most three quarters.
    let (directional, sky_light) = (packed.lights[3], packed.lights[7]);
    let proportion = 4.0 * PI * f64::from(sky_light.radiance[0]) / luminance;
    near(sky_light.weight / directional.weight, proportion);
    let infinite = f64::from(directional.weight) + f64::from(sky_light.weight);
    assert!(infinite <= 0.750001 * f64::from(packed.frame.light_weight_total));
    let (lamp, profile) = measured(&mut empty_packed());
    near(packed.lights[8].weight, 4.0 * luminance * profile.mean());
    assert!((f64::from(lamp.cos_inner) - profile.mean()).abs() < 1e-6);
    // A triangle's power is pi L A, a point's 4 pi I: at equal power they weigh the same.
    let mut one = [punctual(PunctualKind::Point, Vec3::ZERO, None)];
    one[0].radiance = [0.25; 3];
    near(build_lights(&mut one, 1.0).total, 1.0);
    let right = [Vec3::ZERO, Vec3::X, 2.0 * Vec3::Y];
    near(triangle_light(right, [1.0; 3], 1.0, 0, 0).weight, 1.0);
    // The environment's mean is over directions: of a map bright in its upper half, one half.
    let mut half = sky(64, 64, 0.0);
    for (i, texel) in half.radiance.iter_mut().enumerate() {
        *texel = [f32::from(i < 64 * 32); 3];
    }
    near(build_environment(&half).mean_luminance, 0.5);
}

/// What light_sample says, as GPU and CPU answer it.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct Answer {
    wi: [f32; 3],
    distance: f32,
    Le: [f32; 3],
    pdf: f32,
    delta: u32,
    pick: u32,
    pdf_environment: f32,
    reserved: u32,
}

fn light_samples_gpu(packed: &Packed, queries: &[[f32; 8]]) -> Vec<Answer> {
    let root = "
import package::light::light::{LightSample, light_sample, light_pick, light_pdf_environment};
struct Answer { s: LightSample, pick: u32, pdf_environment: f32 }
@group(3) @binding(0) var<storage, read> queries: array<array<vec4<f32>, 2>>;
@group(3) @binding(1) var<storage, read_write> answers: array<array<vec4<f32>, 3>>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&queries) { return; }
    let p = queries[id.x][0].xyz;
    let u_pick = queries[id.x][0].w;
    let u = queries[id.x][1].xy;
    let s = light_sample(p, u_pick, u, 0.0);
    answers[id.x] = array<vec4<f32>, 3>(vec4(s.wi, s.distance), vec4(s.Le, s.pdf),
        vec4(bitcast<f32>(s.delta), bitcast<f32>(light_pick(u_pick, u).index),
            light_pdf_environment(s.wi), 0.0));
}";
    let bytes = bytemuck::cast_slice(queries);
    let answers = common::run_scene(
        root,
        packed,
        &[bytes],
        queries.len() * 48,
        queries.len() as u32,
    );
    bytemuck::pod_collect_to_vec(&answers)
}

#[test]
fn light_samples_agree_with_float64() {
    let packed = all_lights();
    let mut uniform = Random(12);
    let queries: Vec<[f32; 8]> = (0..COUNT)
        .map(|_| {
            let [x, y, z] = (2.0 * uniform.direction()).to_array();
            [
                x,
                y,
                z,
                uniform.unit(),
                uniform.unit(),
                uniform.unit(),
                0.0,
                0.0,
            ]
        })
        .collect();
    let answers = light_samples_gpu(&packed, &queries);
    let brightest = 1.5 * 500.0;
    let mut seen = [0; 9];
    let (mut apart, mut met) = (0, 0);
    for (q, answer) in queries.iter().zip(&answers) {
        let p = Vec3::new(q[0], q[1], q[2]).as_dvec3();
        let u = DVec2::new(q[4].into(), q[5].into());
        let pick = light_pick(&packed, q[3].into(), u).index;
        assert_eq!(answer.pick, pick, "at {q:?}");
        seen[pick as usize] += 1;
        let s = light_sample(&packed, p, q[3].into(), u, 0.0);
        assert_eq!(answer.delta, s.delta);
        let Le = Vec3::from(answer.Le).as_dvec3();
        let wi = Vec3::from(answer.wi).as_dvec3();
        // A density has a divisor that is mostly rounding where it is small: the cosine at a
        // triangle seen edge on, the sine of the angle to the map's pole.
        let kind = packed.lights[pick as usize].kind;
        let cosine = if kind == LIGHT_ENVIRONMENT {
            s.wi.x.hypot(s.wi.z)
        } else if kind == LIGHT_TRIANGLE && s.pdf > 0.0 {
            let weight = packed.materials[pick as usize - 4].emission_weight;
            let share = light_share(&packed, p, 0, 0);
            light_pdf_triangle(share, weight.into(), s.distance, 1.0) / s.pdf
        } else {
            1.0
        };
        if cosine < 1e-4 || (answer.pdf == 0.0) != (s.pdf == 0.0) {
            apart += 1;
            continue;
        }
        met += usize::from(s.pdf > 0.0);
        let at = format!("at {q:?}, light {pick}: {answer:?}, float64 {s:?}");
        assert!((wi - s.wi).length() < 2e-6, "{at}");
        assert!(
            (f64::from(answer.distance) - s.distance).abs() < 1e-6 * s.distance,
            "{at}"
        );
        assert!(
            (f64::from(answer.pdf) - s.pdf).abs() <= (1e-5 + 2e-6 / cosine) * s.pdf,
            "{at}"
        );
        // The place on the map is rounded, by a share of a texel that grows with the map's width.
        let place = f64::from(f32::EPSILON) * 37.0;
        let error = (Le - s.Le).length();
        assert!(error <= 1e-5 * s.Le.length() + place * brightest, "{at}");
    }
    assert!(apart < COUNT / 1000, "{apart} queries on an edge");
    assert!(met > COUNT / 2, "{met} samples");
    assert!(seen.iter().all(|&n| n > 100), "{seen:?}");
}

#[test]
fn a_samples_pdf_is_what_the_density_functions_say() {
    let packed = all_lights();
    let mut uniform = Random(13);
    let mut met = [0; 3];
    for _ in 0..50_000 {
        let p = uniform.direction().as_dvec3() * 0.4;
        let (u_pick, x, y) = (uniform.unit(), uniform.unit(), uniform.unit());
        let u = DVec2::new(x.into(), y.into());
        let light = &packed.lights[light_pick(&packed, u_pick.into(), u).index as usize];
        let s = light_sample(&packed, p, u_pick.into(), u, 0.0);
        let share = f64::from(light.weight) / f64::from(packed.frame.light_weight_total);
        let expected = match light.kind {
            LIGHT_ENVIRONMENT => {
                met[0] += 1;
                light_pdf_environment(&packed, s.wi)
            }
            LIGHT_TRIANGLE => {
                // Meets the plane again, as a ray would, and turns the area's density about.
                let [p0, e1, e2] = [light.position, light.direction, light.edge2]
                    .map(|v| Vec3::from(v).as_dvec3());
                let ng = e1.cross(e2);
                let distance = (p0 - p).dot(ng) / s.wi.dot(ng);
                let cosine = s.wi.dot(ng).abs() / ng.length();
                let front = s.wi.dot(ng) < 0.0;
                let flipped = packed.instances[light.instance as usize].flags != 0;
                let material = &packed.materials[light.triangle as usize];
                if material.flags & MATERIAL_DOUBLE_SIDED == 0 && front == flipped {
                    met[2] += 1;
                    assert_eq!(s.pdf, 0.0, "the back of a one-sided light");
                    assert_eq!(s.Le, DVec3::ZERO);
                    continue;
                }
                met[1] += 1;
                assert!((s.distance - distance).abs() < 1e-9);
                let by_area = share / (0.5 * ng.length()) * distance * distance / cosine;
                assert!(
                    (s.pdf - by_area).abs() < 1e-6 * by_area,
                    "{} {by_area}",
                    s.pdf
                );
                let share = light_share(&packed, p, light.instance, light.triangle);
                light_pdf_triangle(share, material.emission_weight.into(), distance, cosine)
            }
            _ => share,
        };
        let close = (s.pdf - expected).abs() < 1e-6 * expected;
        // A direction on the border of two cells may be read as the other's.
        assert!(
            close || light.kind == LIGHT_ENVIRONMENT && u.x < 1e-4,
            "{} {expected}",
            s.pdf
        );
    }
    assert!(met.iter().all(|&n| n > 500), "{met:?}");
}

/// Irradiance at the origin on the plane with normal n: the mean of cos Le / pdf over the
/// renderer's own sampler, and its standard error (as if the samples were independent, so too
/// large).
fn irradiance(packed: &Packed, n: DVec3, samples: u32) -> (f64, f64) {
    let (mut sum, mut squares) = (0.0, 0.0);
    for i in 0..samples {
        let mut rng = rng_init(UVec2::ZERO, i, 3);
        let u_pick = next_1d(&mut rng);
        let s = light_sample(packed, DVec3::ZERO, u_pick, next_2d(&mut rng), 0.0);
        if s.pdf > 0.0 {
            let value = s.wi.dot(n).max(0.0) * s.Le.y / s.pdf;
            sum += value;
            squares += value * value;
        }
    }
    let mean = sum / f64::from(samples);
    let variance = (squares / f64::from(samples) - mean * mean).max(0.0);
    (mean, (variance / f64::from(samples)).sqrt())
}

fn assert_irradiance(what: &str, packed: &Packed, n: DVec3, expected: f64) {
    let (mean, error) = irradiance(packed, n, 1 << 16);
    let bound = 4.0 * error + 1e-6 * expected;
    assert!(
        (mean - expected).abs() < bound,
        "{what}: {mean} +- {error}, not {expected}"
    );
    assert!(
        error < 0.02 * expected,
        "{what}: noise {error} of {expected}"
    );
}

/// Lambert's formula: the irradiance from a polygon of unit radiance, all of it above the horizon.
fn polygon_irradiance(corners: [DVec3; 3], n: DVec3) -> f64 {
    let sum: f64 = (0..3)
        .map(|i| {
            let (a, b) = (corners[i].normalize(), corners[(i + 1) % 3].normalize());
            a.angle_between(b) * a.cross(b).normalize().dot(n)
        })
        .sum();
    0.5 * sum.abs()
}

#[test]
fn irradiance_has_its_closed_form() {
    let n = DVec3::new(0.1, 1.0, 0.2).normalize();
    // Triangles, near and far, seen from their front.
    let corners = [
        Vec3::new(-1.0, 1.5, -1.0),
        Vec3::new(1.0, 1.6, -1.0),
        Vec3::new(0.0, 1.4, 1.0),
    ];
    for scale in [0.3, 1.0, 20.0] {
        let corners = corners.map(|corner| scale * corner);
        let mut packed = empty_packed();
        add_triangle(&mut packed, corners, Vec3::splat(2.0), 0, false);
        let packed = with_tables(packed);
        let expected = 2.0 * polygon_irradiance(corners.map(|corner| corner.as_dvec3()), n);
        assert_irradiance("triangle", &packed, n, expected);
    }
    // A constant environment: pi L.
    let mut environment = sky(1, 1, 1.0);
    environment.radiance = vec![[1.0; 3]];
    assert_irradiance("constant sky", &only_environment(&environment), n, 1.5 * PI);
    // A cap of half angle 45 degrees about the zenith, pi L sin^2, with the row of texels at its rim
    // filtered: the radiance falls linearly from 1 to 0 about the rim.
    let mut cap = sky(256, 256, 0.0);
    cap.strength = 1.0;
    for (i, texel) in cap.radiance.iter_mut().enumerate() {
        *texel = [f32::from(i < 256 * 64); 3];
    }
    let rim = |theta: f64| (0.5 - (theta / PI * 256.0 - 64.0)).clamp(0.0, 1.0);
    let steps = 100_000;
    let expected: f64 = (0..steps)
        .map(|i| (f64::from(i) + 0.5) / f64::from(steps) * FRAC_PI_2)
        .map(|theta| {
            rim(theta) * theta.sin() * theta.cos() * 2.0 * PI * FRAC_PI_2 / f64::from(steps)
        })
        .sum();
    assert!((expected - 0.5 * PI).abs() < 1e-3);
    assert_irradiance("cap", &only_environment(&cap), DVec3::Y, expected);
    // A point: I cos / d^2. A direction: E cos.
    let mut packed = empty_packed();
    packed.lights.push(punctual(
        PunctualKind::Point,
        Vec3::new(0.0, 2.0, 0.0),
        None,
    ));
    assert_irradiance("point", &with_tables(packed), n, 2.0 * n.y / 4.0);
    let mut packed = empty_packed();
    packed
        .lights
        .push(punctual(PunctualKind::Directional, Vec3::ZERO, None));
    let expected = 2.0 * n.dot(DVec3::new(-0.6, 0.8, 0.0));
    assert_irradiance("direction", &with_tables(packed), n, expected);
    // All at once: the sum.
    let mut packed = empty_packed();
    packed
        .lights
        .push(punctual(PunctualKind::Directional, Vec3::ZERO, None));
    packed.lights.push(punctual(
        PunctualKind::Point,
        Vec3::new(0.0, 2.0, 0.0),
        None,
    ));
    add_triangle(&mut packed, corners, Vec3::splat(2.0), 0, false);
    let packed = with_tables(with_environment(packed, &environment));
    let triangle = 2.0 * polygon_irradiance(corners.map(|corner| corner.as_dvec3()), n);
    let sum = expected + 2.0 * n.y / 4.0 + triangle + 1.5 * PI;
    assert_irradiance("all", &packed, n, sum);
}

#[test]
fn punctual_lights_fall_off_as_the_extension_says() {
    assert_eq!(range_attenuation(5.0, 0.0), 1.0);
    assert_eq!(range_attenuation(1.0, 2.0), 1.0 - 1.0 / 16.0);
    assert_eq!(range_attenuation(2.0, 2.0), 0.0);
    assert_eq!(range_attenuation(3.0, 2.0), 0.0);
    let (inner, outer) = (0.3_f64.cos(), 0.9_f64.cos());
    assert_eq!(spot_attenuation(0.2_f64.cos(), inner, outer), 1.0);
    assert_eq!(spot_attenuation(1.0_f64.cos(), inner, outer), 0.0);
    assert!((spot_attenuation(0.5 * (inner + outer), inner, outer) - 0.25).abs() < 1e-12);
    // A cone with a hard edge divides by the extension's floor, not by zero.
    assert_eq!(spot_attenuation(outer + 0.0011, outer, outer), 1.0);
    assert_eq!(spot_attenuation(outer - 0.0001, outer, outer), 0.0);
    // Straight below a spot that points there, and outside its cone.
    let mut light = punctual(
        PunctualKind::Spot {
            inner_angle: 0.1,
            outer_angle: 0.2,
        },
        Vec3::new(0.0, 4.0, 0.0),
        None,
    );
    light.direction = [0.0, -1.0, 0.0];
    let mut packed = empty_packed();
    packed.lights.push(light);
    let packed = with_tables(packed);
    let at = |x: f64| light_sample(&packed, DVec3::new(x, 0.0, 0.0), 0.5, DVec2::ZERO, 0.0);
    assert!((at(0.0).Le - DVec3::new(3.0, 2.0, 1.0) / 16.0).length() < 1e-7);
    assert_eq!(
        (at(0.0).wi, at(0.0).distance, at(0.0).delta),
        (DVec3::Y, 4.0, 1)
    );
    assert_eq!(at(2.0).Le, DVec3::ZERO);
}

/// At the entries of its table a lamp sends what they hold, in the middle between two their mean.
#[test]
fn measured_lamps_send_what_their_table_says() {
    let mut packed = empty_packed();
    let (lamp, profile) = measured(&mut packed);
    let (rows, columns) = (profile.rows as usize, profile.columns as usize);
    let axis = DVec3::new(0.6, -0.8, 0.0);
    let x = DVec3::new(0.8, 0.6, 0.0);
    // The light goes along -z, so y is z cross x.
    let y = (-axis).cross(x);
    let entry =
        |row: usize, column: usize| f64::from(profile.candela[row * columns + column % columns]);
    for row in 0..rows - 1 {
        for column in 0..columns {
            for (down, across) in [(0.0, 0.0), (0.5, 0.0), (0.0, 0.5), (0.25, 0.75)] {
                if row == 0 && down == 0.0 {
                    // On the axis there is no azimuth.
                    continue;
                }
                let theta = (row as f64 + down) * PI / (rows - 1) as f64;
                let phi = (column as f64 + across) * TAU / columns as f64;
                let d = theta.cos() * axis + theta.sin() * (phi.cos() * x + phi.sin() * y);
                let at =
                    |row| (1.0 - across) * entry(row, column) + across * entry(row, column + 1);
                let candela = (1.0 - down) * at(row) + down * at(row + 1);
                let found = irradiance_punctual(&packed, &lamp, -d, 2.0);
                let expected = candela / 4.0 * DVec3::new(3.0, 2.0, 1.0);
                assert!(
                    (found - expected).length() < 1e-5,
                    "{row} {column}: {found} {expected}"
                );
            }
        }
    }
}
