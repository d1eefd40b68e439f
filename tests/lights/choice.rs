//! Which light is chosen how often.

use crate::common::packed::empty_packed;
use crate::common::shapes::Random;
use crate::common::statistics::{assert_p, chi_square_p};
use crate::{all_lights, measured, punctual, sky, with_tables};
use glam::{DVec2, Vec3};
use snell::cpu::light::light::*;
use snell::pack::environment::build_environment;
use snell::pack::lights::*;
use snell::scene::PunctualKind;
use snell::shared::*;
use std::f64::consts::PI;

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
