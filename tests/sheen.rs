//! The fibres of KHR_materials_sheen: on lavapipe against float64, and what holds of them exactly.
#![allow(non_snake_case, reason = "the letters of the functions under test")]

mod common;
mod queries;

use glam::DVec3;
use queries::{Inputs, compare, on_lavapipe, relative, within};
use snell::cpu::bsdf::sheen::*;
use snell::tables::gauss_legendre;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

#[test]
fn parity() {
    let queries = Inputs::new(21).queries(|inputs, q| {
        q.wo[2] = q.wo[2].max(1e-9);
        q.wi[2] = q.wi[2].max(1e-9);
        q.bsdf.roughness = match inputs.pick(8) {
            0 => [0.0, 1.0, 0.03][inputs.pick(3) as usize],
            _ => inputs.unit(),
        };
    });
    let gpu = on_lavapipe(
        "import package::bsdf::sheen::{D_charlie, ln_Lambda_charlie, Lambda_charlie, f_sheen};",
        "let alpha = q.bsdf.roughness * q.bsdf.roughness;",
        &[
            "D_charlie(q.wo, alpha)",
            "ln_Lambda_charlie(0.5 * q.cos_theta, alpha)",
            "Lambda_charlie(q.cos_theta, alpha)",
            "f_sheen(q.bsdf.roughness, q.wo, q.wi)",
        ],
        &queries,
    );
    compare(
        "sheen",
        &[
            // An exponential that ends at 1e-38.
            within("D_charlie", 1e-30),
            // Through 0 where Lambda is 1, a sum of terms of about 5.
            within("ln_Lambda_charlie", 0.1),
            relative("Lambda_charlie"),
            within("f_sheen", 1e-30),
        ],
        &queries,
        &gpu,
        |q| {
            let alpha = q.bsdf.roughness * q.bsdf.roughness;
            vec![
                D_charlie(q.wo, alpha),
                ln_Lambda_charlie(0.5 * q.cos_theta, alpha),
                Lambda_charlie(q.cos_theta, alpha),
                f_sheen(q.bsdf.roughness, q.wo, q.wi),
            ]
        },
        |_, _| true,
    );
}

const ALPHAS: [f64; 6] = [1e-3, 0.01, 0.09, 0.3, 0.6, 1.0];

/// Directions and weights that integrate over the hemisphere, crowded at the horizon.
fn hemisphere() -> Vec<(DVec3, f64)> {
    const AZIMUTHS: usize = 256;
    let mut all = Vec::new();
    for (t, weight) in gauss_legendre(128) {
        let z = t * t * t;
        let r = (1.0 - z * z).sqrt();
        for a in 0..AZIMUTHS {
            let (sin, cos) = (TAU * (a as f64 + 0.5) / AZIMUTHS as f64).sin_cos();
            let measure = weight * 3.0 * t * t * TAU / AZIMUTHS as f64;
            all.push((DVec3::new(r * cos, r * sin, z), measure));
        }
    }
    all
}

#[test]
fn the_distribution_projects_to_one() {
    let hemisphere = hemisphere();
    for alpha in ALPHAS {
        let sum: f64 = hemisphere
            .iter()
            .map(|(wm, weight)| weight * wm.z * D_charlie(*wm, alpha))
            .sum();
        assert!((sum - 1.0).abs() < 1e-4, "{sum} at alpha {alpha}");
    }
}

/// Smith's masking is what lets the visible facets' projections add up to the viewer's own (Heitz
/// 2014, "Understanding the Masking-Shadowing Function", eq. 14): the integral of D max(wo . wm, 0) is
/// (1 + Lambda) cos. The fit keeps near that down to the roughness that the module's head names; far below
/// it hides too little (G1 of 0.82 for 0.20 at alpha = 0.001, 20 degrees).
#[test]
fn the_fit_of_Lambda_is_near_what_the_distribution_demands() {
    let hemisphere = hemisphere();
    let mut worst = 0.0_f64;
    for alpha in [0.07, 0.09, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0] {
        for degrees in [0.0_f64, 20.0, 40.0, 55.0, 65.0, 75.0, 85.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let wo = DVec3::new(sin, 0.0, cos);
            let seen: f64 = hemisphere
                .iter()
                .map(|(wm, weight)| weight * wo.dot(*wm).max(0.0) * D_charlie(*wm, alpha))
                .sum();
            let G1 = cos / seen;
            let fit = 1.0 / (1.0 + Lambda_charlie(cos, alpha));
            println!("alpha {alpha} at {degrees}: {fit:.4}, should be {G1:.4}");
            worst = worst.max((fit - G1).abs());
        }
    }
    assert!(worst < 0.045, "G1 is off by {worst}");
}

#[test]
fn light_may_go_either_way() {
    let mut inputs = Inputs::new(22);
    for _ in 0..10_000 {
        let direction = |inputs: &mut Inputs| DVec3::from(inputs.direction().map(f64::from));
        let (wo, wi) = (direction(&mut inputs), direction(&mut inputs));
        let roughness = f64::from(inputs.unit());
        let (there, back) = (f_sheen(roughness, wo, wi), f_sheen(roughness, wi, wo));
        assert!(there >= 0.0 && there == back, "{there} {back} {wo} {wi}");
    }
}

/// Printed values of the formulas of KHR_materials_sheen, "Sheen distribution" and "Sheen
/// visibility", worked out by hand: alpha = 1 and 1/4, with D = (2 + 1 / alpha) sin^(1 / alpha) / (2 pi).
#[test]
fn values_of_the_extension() {
    let wm = DVec3::new(0.6, 0.0, 0.8);
    assert!((D_charlie(wm, 1.0) - 3.0 * 0.6 / TAU).abs() < 1e-12);
    assert!((D_charlie(wm, 0.25) - 6.0 * 0.6_f64.powi(4) / TAU).abs() < 1e-12);
    assert_eq!(D_charlie(DVec3::Z, 0.25), 0.0);
    assert_eq!(D_charlie(-wm, 0.25), 0.0);
    // At the cosine of 1/2 both branches are exp(l(1/2)).
    let half = 21.5473 / (1.0 + 3.82987 * 0.5_f64.powf(0.19823)) - 1.97760 / 2.0 - 4.32054;
    assert!((Lambda_charlie(0.5, 1.0) - half.exp()).abs() < 1e-12);
    assert!((Lambda_charlie(0.5 - 1e-12, 1.0) - half.exp()).abs() < 1e-9);
}

/// Narrower fibres than the narrowest that float32 resolves are that one.
#[test]
fn no_roughness_is_the_least() {
    let grazing = |phi: f64| DVec3::new(phi.cos(), phi.sin(), 0.02).normalize();
    let (wo, wi) = (grazing(0.0), grazing(1.0));
    let least = f_sheen(1e-3_f64.sqrt(), wo, wi);
    assert!(least > 0.0);
    assert!((f_sheen(0.0, wo, wi) - least).abs() < 1e-9 * least);
    assert_eq!(
        f_sheen(0.0, DVec3::Z, wi),
        f_sheen(1e-3_f64.sqrt(), DVec3::Z, wi)
    );
}

/// What the fibres reflect of a white sky: less than all of it down to the roughness that the module's
/// head names.
#[test]
fn albedo() {
    let mut most = 0.0_f64;
    for roughness in [0.26, 0.3, 0.5, 0.7, 0.95, 1.0] {
        for degrees in [0.0_f64, 30.0, 60.0, 75.0, 85.0, 89.0, 89.5, 89.8] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let wo = DVec3::new(sin, 0.0, cos);
            let mut sum = 0.0;
            for (t, weight) in gauss_legendre(128) {
                // Crowded at the horizon, where f is highest.
                let theta = FRAC_PI_2 * (1.0 - (1.0 - t).powi(3));
                for (s, share) in gauss_legendre(64) {
                    // Half a turn, crowded where both directions go the same way.
                    let phi = PI * s * s;
                    let wi = DVec3::new(
                        theta.sin() * phi.cos(),
                        theta.sin() * phi.sin(),
                        theta.cos(),
                    );
                    let measure = weight
                        * 3.0
                        * (1.0 - t).powi(2)
                        * FRAC_PI_2
                        * theta.sin()
                        * share
                        * 2.0
                        * PI
                        * s
                        * 2.0;
                    sum += measure * wi.z * f_sheen(roughness, wo, wi);
                }
            }
            println!("roughness {roughness} at {degrees}: {sum:.4}");
            most = most.max(sum);
        }
    }
    assert!(most < 1.0, "{most} of the light comes back");
}
