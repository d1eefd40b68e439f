//! What arrives from lights, against closed forms.

use crate::common::packed::empty_packed;
use crate::{
    add_triangle, measured, only_environment, punctual, sky, with_environment, with_tables,
};
use glam::{DVec2, DVec3, UVec2, Vec3};
use snell::cpu::light::light::*;
use snell::cpu::light::punctual::{irradiance_punctual, range_attenuation, spot_attenuation};
use snell::cpu::rng::{next_1d, next_2d, rng_init};
use snell::pack::Packed;
use snell::scene::PunctualKind;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Irradiance at the origin on the plane with normal n: the mean of cos Le / pdf over the
/// renderer's own sampler, and its standard error (as if the samples were independent, so too
/// large).
fn irradiance(packed: &Packed, n: DVec3, samples: u32) -> (f64, f64) {
    let (mut sum, mut squares) = (0.0, 0.0);
    for i in 0..samples {
        let mut rng = rng_init(UVec2::ZERO, i, 3);
        let u_pick = next_1d(&mut rng);
        let u = next_2d(&mut rng);
        let s = light_sample(packed, DVec3::ZERO, n, false, u_pick, u, 0.0);
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
    let at = |x: f64| {
        let p = DVec3::new(x, 0.0, 0.0);
        light_sample(&packed, p, DVec3::Y, false, 0.5, DVec2::ZERO, 0.0)
    };
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
