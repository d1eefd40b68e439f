//! The environment: how its map lies, its density, its table.

use crate::common;
use crate::common::shapes::Random;
use crate::common::statistics::{assert_p, chi_square_p};
use crate::{COUNT, only_environment, sky};
use glam::{DVec2, DVec3, DVec4};
use snell::cpu::light::environment::*;
use snell::cpu::light::light::*;
use snell::pack::Packed;
use snell::pack::environment::build_environment;
use snell::scene::Environment;
use std::f64::consts::PI;

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
        light_sample(
            &packed,
            DVec3::ZERO,
            DVec3::Y,
            false,
            0.3,
            DVec2::splat(0.4),
            0.0
        )
        .pdf,
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
