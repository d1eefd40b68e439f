//! Interference of a thin film: against Airy's sum at each wavelength, and on lavapipe.
#![allow(non_snake_case, reason = "the letters of the functions under test")]

mod common;
mod queries;

use glam::DVec3;
use queries::{Inputs, compare, on_lavapipe, within};
use snell::cpu::bsdf::fresnel::{F_dielectric, F_schlick};
use snell::cpu::bsdf::thin_film::*;
use snell::shared::Tables;
use snell::spectrum;
use snell::tables::tables;
use std::f64::consts::TAU;

#[test]
fn parity() {
    let queries = Inputs::new(41).queries(|inputs, q| {
        // Index and thickness of the film, the base's reflectance.
        q.bsdf.alpha = [
            match inputs.pick(8) {
                0 => 1.0,
                1 => 1.0 + inputs.log_range(1e-5, 0.1),
                _ => inputs.range(1.0, 2.5),
            },
            match inputs.pick(8) {
                0 => 0.0,
                1 => inputs.log_range(1e-3, 1e5),
                _ => inputs.range(0.0, 1200.0),
            },
        ];
        let F0 = match inputs.pick(4) {
            0 => [0.04; 3],
            _ => inputs.color(),
        };
        // The very same argument on both sides: where it is nearly 1, what it lacks is mostly rounding.
        let F_base = schlick(DVec3::from(F0.map(f64::from)), f64::from(q.cos_theta));
        q.bsdf.reflectance = F_base.as_vec3().into();
    });
    let gpu = on_lavapipe(
        "import package::bsdf::thin_film::{F_thin_film, interference};
import package::math::{sincos_accurate};",
        "let F = F_thin_film(q.cos_theta, q.bsdf.alpha.x, q.bsdf.alpha.y, q.bsdf.reflectance);
         let steps = q.bsdf.alpha.y * 0.25;
         let seen = interference(steps, sincos_accurate(2.0 * 3.14159265 * steps * 32.0 / 520.0));",
        &["F.x", "F.y", "F.z", "seen.x", "seen.y", "seen.z"],
        &queries,
    );
    let tables = tables();
    compare(
        "thin film",
        &[
            // What interference extinguishes is a difference of numbers near 1.
            within("F_thin_film.x", 0.05),
            within("F_thin_film.y", 0.05),
            within("F_thin_film.z", 0.05),
            within("interference.x", 1.0),
            within("interference.y", 1.0),
            within("interference.z", 1.0),
        ],
        &queries,
        &gpu,
        |q| {
            let F = F_thin_film(
                &tables,
                q.cos_theta,
                q.bsdf.alpha.x,
                q.bsdf.alpha.y,
                q.bsdf.reflectance,
            );
            let steps = q.bsdf.alpha.y * 0.25;
            let phase = TAU * steps * 32.0 / 520.0;
            let seen = interference(&tables, steps, phase.sin_cos().into());
            vec![F.x, F.y, F.z, seen.x, seen.y, seen.z]
        },
        |_, _| true,
    );
}

fn schlick(F0: DVec3, cos: f64) -> DVec3 {
    F_schlick(cos, F0)
}

/// A complex amplitude.
#[derive(Clone, Copy)]
struct Complex(f64, f64);

impl Complex {
    fn turned(modulus: f64, phase: f64) -> Self {
        Self(modulus * phase.cos(), modulus * phase.sin())
    }

    fn square(self) -> f64 {
        self.0 * self.0 + self.1 * self.1
    }
}

/// |(r12 + r23 e^(i p)) / (1 + r12 r23 e^(i p))|^2, Airy's formula (Born and Wolf 1999, "Principles of
/// Optics", 7.6).
fn airy(r12: f64, r23: f64, phase: f64) -> f64 {
    let inner = Complex::turned(r23, phase);
    let above = Complex(r12 + inner.0, inner.1);
    let below = Complex(1.0 + r12 * inner.0, r12 * inner.1);
    if below.square() == 0.0 {
        return 1.0;
    }
    above.square() / below.square()
}

fn path_difference(cos: f64, ior: f64, thickness: f64) -> f64 {
    2.0 * thickness * (ior * ior - 1.0 + cos * cos).max(0.0).sqrt()
}

/// The film's colour by a sum over a thousand wavelengths; one base reflectance for all channels.
fn brute_force(cos: f64, ior: f64, thickness: f64, F_base: f64) -> DVec3 {
    let r12 = -F_dielectric(cos, ior).sqrt();
    let r13 = -F_base.sqrt();
    // The inverse of r13 = (r12 + r23) / (1 + r12 r23).
    let r23 = if r12 * r13 < 1.0 {
        (r13 - r12) / (1.0 - r12 * r13)
    } else {
        -1.0
    };
    let difference = path_difference(cos, ior, thickness);
    spectrum::wavelengths(1000)
        .map(|(wavelength, weight)| {
            let reflectance = airy(r12, r23, TAU * difference / wavelength);
            weight * reflectance * spectrum::color_matching(wavelength)
        })
        .sum()
}

/// The largest difference from the truth, over films and bases at these angles (degrees).
fn worst(tables: &Tables, from: f64, to: f64) -> (f64, f64) {
    let mut inputs = Inputs::new(42);
    let (mut error, mut outside) = (0.0_f64, 0.0_f64);
    for _ in 0..20_000 {
        let cos = f64::from(inputs.range(from as f32, to as f32))
            .to_radians()
            .cos();
        let ior = f64::from(inputs.range(1.2, 2.0));
        let thickness = f64::from(match inputs.pick(3) {
            0 => inputs.range(0.0, 100.0),
            _ => inputs.range(0.0, 1200.0),
        });
        let F0 = f64::from(match inputs.pick(4) {
            0 => 0.04,
            1 => 1.0,
            _ => inputs.range(0.04, 1.0),
        });
        let F_base = schlick(DVec3::splat(F0), cos);
        let truth = brute_force(cos, ior, thickness, F_base.x);
        let ours = F_thin_film(tables, cos, ior, thickness, F_base);
        let cut = truth.clamp(DVec3::ZERO, DVec3::ONE);
        outside = outside.max((truth - cut).abs().max_element());
        error = error.max((ours - cut).abs().max_element());
    }
    (error, outside)
}

#[test]
fn colours_are_those_of_the_whole_spectrum() {
    let tables = tables();
    let (error, outside) = worst(&tables, 0.0, 85.0);
    println!("to 85 degrees: error {error:.5}, colours outside Rec. 709 by {outside:.3}");
    assert!(error < 3e-3, "{error}");
    assert!(outside < 0.09, "{outside}");
    let (error, _) = worst(&tables, 85.0, 90.0);
    println!("beyond: error {error:.5}");
    assert!(error < 0.012, "{error}");
}

#[test]
fn no_film_is_the_base() {
    let tables = tables();
    for cos in [1e-3, 0.05, 0.3, 0.8, 1.0] {
        for F0 in [0.0, 0.04, 0.3, 0.9, 1.0] {
            let base = schlick(DVec3::new(F0, 0.5 * F0, 0.04), cos);
            let film = |ior, thickness| F_thin_film(&tables, cos, ior, thickness, base);
            let gap = |F: DVec3| (F - base).abs().max_element();
            assert_eq!(film(1.5, 0.0), base);
            // An index of 1 has no boundary, whatever the thickness.
            assert!(gap(film(1.0, 400.0)) < 1e-12);
            assert!(gap(film(1.0 + 1e-6, 400.0)) < 1e-4);
            for ior in [1.2, 1.5, 2.0] {
                // Up to the orders left out.
                assert!(gap(film(ior, 1e-4)) < 0.011, "{cos} {ior} {base}");
            }
            if cos >= 0.3 {
                assert!(gap(film(1.5, 1e-3)) < 1e-4, "{cos} {base}");
            }
        }
    }
}

#[test]
fn a_mirror_stays_a_mirror_and_nothing_gains() {
    let tables = tables();
    let mut inputs = Inputs::new(43);
    for _ in 0..50_000 {
        let cos = f64::from(inputs.cosine());
        let (ior, thickness) = (
            f64::from(inputs.range(1.0, 2.5)),
            f64::from(inputs.range(0.0, 2000.0)),
        );
        let white = F_thin_film(&tables, cos, ior, thickness, DVec3::ONE);
        assert_eq!(white, DVec3::ONE);
        let base = DVec3::from(inputs.color().map(f64::from));
        let F = F_thin_film(&tables, cos, ior, thickness, base);
        assert!(F.min_element() >= 0.0 && F.max_element() <= 1.0, "{F}");
    }
}

/// Thicker than coherence reaches, intensities add up, not amplitudes: R12 + (1 - R12)^2 R23 / (1 - R12
/// R23).
#[test]
fn a_thick_film_has_no_colour() {
    let tables = tables();
    for (cos, ior, F0) in [(1.0, 1.5, 0.04), (0.5, 1.3, 0.5), (0.7, 1.9, 0.2)] {
        let F_base = schlick(DVec3::splat(F0), cos);
        let R12: f64 = F_dielectric(cos, ior);
        let (a, b) = (R12.sqrt(), F_base.x.sqrt());
        let R23 = ((b - a) / (1.0 - a * b)).powi(2);
        let want = R12 + (1.0 - R12).powi(2) * R23 / (1.0 - R12 * R23);
        let F = F_thin_film(&tables, cos, ior, 1e6, F_base);
        assert!((F - want).abs().max_element() < 1e-12, "{F} {want}");
    }
}

/// A quarter-wave coating of the geometric mean's index extinguishes the reflection at its wavelength
/// (Born and Wolf 1999, 1.6.4): magnesium fluoride's 1.38 on an index of 1.38^2, made for green.
#[test]
fn a_quarter_wave_coating_reflects_little() {
    let tables = tables();
    let index: f64 = 1.38 * 1.38;
    let F0 = ((index - 1.0) / (index + 1.0)).powi(2);
    let thickness = 545.0 / (4.0 * 1.38);
    let F = F_thin_film(&tables, 1.0, 1.38, thickness, DVec3::splat(F0));
    println!("bare {F0:.4}, coated {F}");
    assert!(F.y < 0.02 * F0 && F.max_element() < 0.2 * F0, "{F}");
}

/// The same film with indices and both polarisations exact, on a dielectric: what the averaged
/// amplitudes miss at angles where polarisations part.
#[test]
fn polarised_light_is_near() {
    let tables = tables();
    let exact = |cos: f64, ior: f64, thickness: f64, base: f64| -> DVec3 {
        let cos_film = (ior * ior - 1.0 + cos * cos).sqrt() / ior;
        let cos_base = (base * base - 1.0 + cos * cos).sqrt() / base;
        let s = |n1: f64, c1: f64, n2: f64, c2: f64| (n1 * c1 - n2 * c2) / (n1 * c1 + n2 * c2);
        let p = |n1: f64, c1: f64, n2: f64, c2: f64| (n1 * c2 - n2 * c1) / (n1 * c2 + n2 * c1);
        let difference = path_difference(cos, ior, thickness);
        spectrum::wavelengths(400)
            .map(|(wavelength, weight)| {
                let phase = TAU * difference / wavelength;
                let both = [
                    airy(
                        s(1.0, cos, ior, cos_film),
                        s(ior, cos_film, base, cos_base),
                        phase,
                    ),
                    airy(
                        p(1.0, cos, ior, cos_film),
                        p(ior, cos_film, base, cos_base),
                        phase,
                    ),
                ];
                weight * 0.5 * (both[0] + both[1]) * spectrum::color_matching(wavelength)
            })
            .sum()
    };
    for (degrees, limit) in [(0.0_f64, 5e-4), (30.0, 0.006), (50.0, 0.05), (70.0, 0.15)] {
        let cos = degrees.to_radians().cos();
        let mut error = 0.0_f64;
        for base in [1.3, 1.5, 2.0, 3.0] {
            for ior in [1.2, 1.33, 1.7, 2.0] {
                for thickness in [50.0, 150.0, 300.0, 500.0, 900.0] {
                    let F0: f64 = ((base - 1.0_f64) / (base + 1.0)).powi(2);
                    let F_base = schlick(DVec3::splat(F0), cos);
                    let ours = F_thin_film(&tables, cos, ior, thickness, F_base);
                    let truth = exact(cos, ior, thickness, base).clamp(DVec3::ZERO, DVec3::ONE);
                    error = error.max((ours - truth).abs().max_element());
                }
            }
        }
        println!("{degrees} degrees: {error:.4}");
        assert!(error < limit, "{error} at {degrees} degrees");
    }
}
