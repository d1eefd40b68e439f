//! The lobes of glTF's extensions, on lavapipe and in float64: samples follow the pdf, light goes both
//! ways alike, neutral parameters change no bit, and deltas are what they say.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

#[path = "common/chi2.rs"]
mod chi2;
mod common;
#[path = "common/examine.rs"]
mod examine;
#[path = "common/lobes.rs"]
mod lobes;

use chi2::sidak;
use glam::DVec3;
use lobes::{Lobe, direction, gltf, gltf_lobes, layered_lobes, lobes, transmissive, uniforms};
use snell::cpu;
use snell::lab::{Input, Lab, Output, Stage};
use snell::shared::{Bsdf, GLTF_INSIDE, GLTF_THIN_WALLED};
use snell::tables::tables;
use std::f64::consts::{FRAC_PI_2, TAU};
use std::fmt::Write;

/// Of all chi-square tests of a run together.
const SIGNIFICANCE: f64 = 0.01;
const TESTS: usize = 16 * 3 * 6;
/// What the tables of albedo may make of 1: half a percent. Under a film and for anisotropic facets they
/// hold by an equivalent only.
const ALBEDO_MAX: f64 = 1.005;
const ALBEDO_MAX_EQUIVALENT: f64 = 1.02;

fn examine_all(lab: &Lab, roughness: f64, seed: u64) {
    let threshold = sidak(SIGNIFICANCE, TESTS);
    let mut report = String::new();
    let mut all = gltf_lobes(roughness);
    all.extend(layered_lobes(roughness));
    assert_eq!(all.len() * 3 * 6, TESTS, "the correction counts all tests");
    for (i, lobe) in all.iter_mut().enumerate() {
        let [along, across] = lobe.bsdf.alpha;
        lobe.albedo_max = if lobe.bsdf.gltf.iridescence > 0.0 || along != across {
            ALBEDO_MAX_EQUIVALENT
        } else {
            ALBEDO_MAX
        };
        for (j, degrees) in [0.0, 50.0, 80.0].into_iter().enumerate() {
            let (p, faults) = examine::examine(lab, lobe, degrees, seed + (3 * i + j) as u64);
            if p < threshold || !faults.is_empty() {
                let name = &lobe.name;
                writeln!(report, "{name} at {degrees} degrees: p = {p:.1e} {faults}").unwrap();
            }
        }
    }
    assert!(report.is_empty(), "threshold {threshold:.1e}\n{report}");
}

fn on_gpu() -> Lab {
    Lab::gpu(common::gpu()).unwrap()
}

macro_rules! statistics {
    ($($name:ident: $lab:expr, $roughness:expr, $seed:expr;)*) => {
        $(#[test] fn $name() { examine_all(&$lab, $roughness, $seed); })*
    };
}

statistics! {
    cpu_roughness_25_percent: Lab::cpu(), 0.25, 11_000;
    cpu_roughness_50_percent: Lab::cpu(), 0.5, 12_000;
    cpu_roughness_100_percent: Lab::cpu(), 1.0, 13_000;
    gpu_roughness_25_percent: on_gpu(), 0.25, 14_000;
    gpu_roughness_50_percent: on_gpu(), 0.5, 15_000;
    gpu_roughness_100_percent: on_gpu(), 1.0, 16_000;
}

fn input(bsdf: Bsdf, wo: DVec3, wi: DVec3, u: DVec3) -> Input {
    Input {
        bsdf,
        wo,
        wi,
        u,
        cos_theta: 1.0,
    }
}

/// Above the surface, to 88 degrees from the normal.
fn directions(seed: u64, count: usize) -> Vec<DVec3> {
    let of = |u: DVec3| {
        let (sin, cos) = (FRAC_PI_2 * 0.98 * u.x).sin_cos();
        let (sin_phi, cos_phi) = (TAU * u.y).sin_cos();
        DVec3::new(sin * cos_phi, sin * sin_phi, cos)
    };
    uniforms(seed, count).into_iter().map(of).collect()
}

/// The same surface, seen from the other side.
fn turned(lobe: &Lobe) -> Bsdf {
    let mut other = lobe.bsdf;
    if lobe.is_refractive() {
        other.eta = other.eta.map(|eta| 1.0 / eta);
        other.gltf.flags ^= GLTF_INSIDE;
    }
    other
}

fn reciprocity(lab: &Lab, tolerance: f64) {
    for (i, lobe) in gltf_lobes(0.5).iter().chain(&gltf_lobes(0.9)).enumerate() {
        for side in [1.0, -1.0] {
            let mirror = DVec3::new(1.0, 1.0, side);
            let (wo, wi) = (directions(i as u64, 2048), directions(100 + i as u64, 2048));
            let run = |bsdf: Bsdf, swapped: bool| -> Vec<Output> {
                let inputs: Vec<Input> = wo
                    .iter()
                    .zip(&wi)
                    .map(|(&wo, &wi)| {
                        let wi = wi * mirror;
                        let (a, b) = if swapped { (wi, wo) } else { (wo, wi) };
                        input(bsdf, a, b, DVec3::ZERO)
                    })
                    .collect();
                lab.run(Stage::Eval, &inputs).unwrap()
            };
            let there = run(lobe.bsdf, false);
            let other = if side < 0.0 { turned(lobe) } else { lobe.bsdf };
            let scale = if side < 0.0 { lobe.eta().powi(2) } else { 1.0 };
            for (a, b) in there.iter().zip(&run(other, true)) {
                let (a, b) = (a.f * scale, b.f);
                // Far out in a lobe's tail float32 has few digits of the facet's slope.
                let gap = (a - b).abs().max_element() / a.max_element().max(1e-3);
                assert!(gap < tolerance, "{}: {a} there, {b} back", lobe.name);
            }
        }
    }
}

#[test]
fn lobes_are_reciprocal_in_float64() {
    // A model's eta is a float32, and so is what the test takes for 1 / eta.
    reciprocity(&Lab::cpu(), 1e-5);
}

#[test]
fn lobes_are_reciprocal_on_lavapipe() {
    reciprocity(&on_gpu(), 1e-3);
}

/// What makes no difference: an extension without strength, whatever else it says.
type Change = fn(&mut Bsdf);
const NEUTRAL: [(&str, Change); 7] = [
    ("coat", |b| {
        b.gltf.coat_roughness = 0.7;
        b.gltf.coat_normal = [0.6, 0.0, 0.8];
    }),
    ("sheen", |b| b.gltf.sheen_roughness = 0.7),
    ("iridescence", |b| {
        b.gltf.film_ior = 1.8;
        b.gltf.film_thickness = 500.0;
    }),
    ("diffuse transmission", |b| {
        b.gltf.diffuse_transmission_color = [0.3, 0.8, 0.1];
    }),
    ("anisotropy", |b| b.gltf.rotation = [-0.8, 0.6]),
    ("thin walls", |b| b.gltf.flags |= GLTF_THIN_WALLED),
    // Metal has no dielectric part that could pass anything.
    ("specular", |_| {}),
];

fn neutrality(lab: &Lab) {
    let bases = [
        gltf(0.0, |b| b.reflectance = [0.8, 0.5, 0.2]),
        gltf(0.4, |b| {
            b.reflectance = [0.8, 0.5, 0.2];
            b.gltf.metallic = 0.3;
        }),
        gltf(1.0, |b| b.gltf.metallic = 1.0),
    ];
    for base in bases {
        let answers = |bsdf: Bsdf| -> Vec<[u64; 8]> {
            let (wo, wi, u) = (directions(1, 512), directions(2, 512), uniforms(3, 512));
            let inputs: Vec<Input> = (0..512).map(|i| input(bsdf, wo[i], wi[i], u[i])).collect();
            let bits = |o: Output| {
                let v = [o.f.x, o.f.y, o.f.z, o.wi.x, o.wi.y, o.wi.z, o.pdf];
                let mut bits = [0; 8];
                for (slot, v) in bits.iter_mut().zip(v) {
                    *slot = v.to_bits();
                }
                bits[7] = u64::from(o.delta);
                bits
            };
            [Stage::Eval, Stage::Sample]
                .into_iter()
                .flat_map(|stage| lab.run(stage, &inputs).unwrap())
                .map(bits)
                .collect()
        };
        let expected = answers(base);
        for (name, change) in NEUTRAL {
            let mut bsdf = base;
            change(&mut bsdf);
            assert_eq!(answers(bsdf), expected, "{name} without strength");
        }
    }
}

#[test]
fn neutral_extensions_change_no_bit_in_float64() {
    neutrality(&Lab::cpu());
}

#[test]
fn neutral_extensions_change_no_bit_on_lavapipe() {
    neutrality(&on_gpu());
}

#[test]
fn a_neutral_specular_extension_leaves_the_exact_fresnel_term() {
    for eta in [1.5_f64, 1.0 / 1.5, 1.1, 2.4] {
        let glass = cpu::bsdf::Bsdf::from(&gltf(0.3, |b| transmissive(b, eta as f32, 0)));
        let eta = glass.eta.x;
        for i in 0..=100 {
            let cos = f64::from(i) / 100.0;
            let exact = cpu::bsdf::fresnel::F_dielectric(cos, eta);
            let ours = cpu::bsdf::boundary::F_boundary(&glass, cos);
            assert!((ours - exact).abs().max_element() < 1e-7, "{eta} {cos}");
        }
    }
}

#[test]
fn total_reflection_and_an_index_of_0_lose_nothing() {
    use cpu::bsdf::boundary::F_boundary;
    let weak = gltf(0.0, |b| {
        transmissive(b, 1.0 / 1.5, GLTF_INSIDE);
        b.gltf.F90 = 0.25;
    });
    assert_eq!(F_boundary(&(&weak).into(), 0.3), DVec3::ONE);
    let matched = gltf(0.0, |b| transmissive(b, 1.0, 0));
    assert_eq!(F_boundary(&(&matched).into(), 0.3), DVec3::ZERO);
    let mut none = gltf(0.5, |b| {
        transmissive(b, 1.5, 0);
        b.gltf.F0 = [0.2; 3];
        b.eta = [0.0; 3];
    });
    let opaque = {
        let mut opaque = none;
        opaque.gltf.flags = 0;
        opaque
    };
    let tables = tables();
    for (wo, wi) in directions(1, 50).into_iter().zip(directions(2, 50)) {
        let eval = |b: &Bsdf| cpu::bsdf::bsdf::bsdf_eval(&tables, &b.into(), wo, wi);
        assert_eq!(eval(&none), eval(&opaque));
    }
    none.eta = [1.5; 3];
    assert!(none != opaque);
}

/// The mean of what passes straight on, and what the function for shadow rays says.
#[test]
fn thin_walls_pass_straight_what_their_samples_do() {
    let tables = tables();
    let thin = gltf(0.0, |b| {
        transmissive(b, 1.5, GLTF_THIN_WALLED);
        b.reflectance = [0.9, 0.5, 0.2];
        b.gltf.transmission = 0.7;
        b.gltf.metallic = 0.2;
        b.gltf.coat = 0.5;
        b.gltf.coat_roughness = 0.3;
        b.gltf.sheen_color = [0.3, 0.2, 0.1];
        b.gltf.sheen_roughness = 0.4;
        b.gltf.iridescence = 0.5;
        b.gltf.film_ior = 1.3;
        b.gltf.film_thickness = 300.0;
    });
    let rough = gltf(0.5, |b| transmissive(b, 1.5, GLTF_THIN_WALLED));
    let boundary = gltf(0.0, |b| transmissive(b, 1.5, 0));
    for bsdf in [thin, rough, boundary] {
        let bsdf = cpu::bsdf::Bsdf::from(&bsdf);
        for degrees in [0.0, 40.0, 80.0] {
            let wo = direction(degrees) * DVec3::new(1.0, 1.0, -1.0);
            let mut mean = DVec3::ZERO;
            let count = 20_000;
            for u in uniforms(5, count) {
                let s = cpu::bsdf::bsdf::bsdf_sample(&tables, &bsdf, wo, u);
                if s.delta == cpu::bsdf::lobe::DELTA_STRAIGHT {
                    assert_eq!(s.wi, -wo);
                    mean += s.f * (s.wi.z.abs() / s.pdf) / count as f64;
                }
            }
            let said = cpu::bsdf::bsdf::straight_transmittance(&tables, &bsdf, wo);
            assert_eq!(said == DVec3::ZERO, mean == DVec3::ZERO);
            let gap = (mean - said).abs().max_element();
            assert!(gap < 0.02, "{degrees}: {mean} {said}");
        }
    }
}

#[test]
fn only_materials_without_any_rough_lobe_are_deltas() {
    use cpu::bsdf::bsdf::bsdf_is_delta;
    let glass = |change: Change| {
        gltf(0.0, |b| {
            transmissive(b, 1.5, 0);
            change(b);
        })
    };
    let cases: [(Bsdf, bool); 9] = [
        (gltf(0.0, |_| {}), false),
        (gltf(0.0, |b| b.gltf.metallic = 1.0), true),
        (gltf(0.1, |b| b.gltf.metallic = 1.0), false),
        (glass(|_| {}), true),
        (glass(|b| b.gltf.transmission = 0.9), false),
        (glass(|b| b.gltf.coat = 1.0), true),
        (
            glass(|b| {
                b.gltf.coat = 1.0;
                b.gltf.coat_roughness = 0.2;
            }),
            false,
        ),
        (glass(|b| b.gltf.sheen_color = [0.0, 0.1, 0.0]), false),
        (glass(|b| b.gltf.flags |= GLTF_THIN_WALLED), true),
    ];
    let tables = tables();
    for (bsdf, is_delta) in cases {
        assert_eq!(bsdf_is_delta(&(&bsdf).into()), is_delta, "{bsdf:?}");
        if is_delta {
            let wo = direction(30.0);
            for u in uniforms(9, 200) {
                let s = cpu::bsdf::bsdf::bsdf_sample(&tables, &(&bsdf).into(), wo, u);
                assert!(s.pdf > 0.0 && s.delta != 0);
            }
        }
    }
}

#[test]
fn asked_at_once_a_lobe_answers_as_it_does_one_by_one() {
    use cpu::bsdf::bsdf::{bsdf_eval, bsdf_eval_and_sample, bsdf_sample};
    use cpu::bsdf::lobe::EvalAndSample;
    let tables = tables();
    for roughness in [0.0, 0.4] {
        let lobes = [lobes(0.4), gltf_lobes(roughness), layered_lobes(roughness)];
        for lobe in lobes.iter().flatten() {
            let bsdf = cpu::bsdf::Bsdf::from(&lobe.bsdf);
            let views = directions(1, 16).into_iter().zip(directions(2, 16));
            for ((wo, wi), u) in views.zip(uniforms(3, 16)) {
                for sides in 0..4 {
                    let wo = wo.with_z(wo.z * [1.0, -1.0][sides / 2]);
                    let wi = wi.with_z(wi.z * [1.0, -1.0][sides % 2]);
                    let EvalAndSample { eval, sample } =
                        bsdf_eval_and_sample(&tables, &bsdf, wo, Some(wi), u);
                    let name = &lobe.name;
                    assert_eq!(eval, bsdf_eval(&tables, &bsdf, wo, wi), "{name} {wo} {wi}");
                    assert_eq!(
                        sample,
                        bsdf_sample(&tables, &bsdf, wo, u),
                        "{name} {wo} {u}"
                    );
                }
            }
        }
    }
}
