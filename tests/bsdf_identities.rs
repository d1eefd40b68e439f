//! What holds of reflection functions exactly: distributions are normalised, lobes are reciprocal, and
//! the half vectors' Jacobians are what the geometry says.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]
#![allow(non_snake_case, reason = "D is the distribution's letter")]

mod common;
#[path = "common/lobes.rs"]
mod lobes;

use glam::{DVec2, DVec3};
use lobes::{bsdf, lobes, uniforms};
use snell::cpu;
use snell::lab::{Input, Lab, Stage};
use snell::shared::{Bsdf, LabQuery};
use snell::tables::gauss_legendre;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Distributions, and the widths of their lobes along the tangent and across it.
fn distributions() -> Vec<(String, DVec2)> {
    let mut all = Vec::new();
    let width = |e: f64| (2.0 / (e + 2.0)).sqrt();
    for e in [0.0, 0.5, 1.0, 7.0, 100.0, 5e3, 1e5] {
        all.push((
            format!(r#""name":"blinn","exponent":{e}"#),
            DVec2::splat(width(e)),
        ));
        for f in [0.0, 20.0, 1e5] {
            let name = format!(r#""name":"ashikhmin-shirley","exponent":[{e},{f}]"#);
            all.push((name, DVec2::new(width(e), width(f))));
        }
    }
    for name in ["beckmann", "ggx"] {
        for alpha in [
            [0.0025, 0.0025],
            [0.01, 0.3],
            [0.25, 0.25],
            [1.0, 0.1],
            [1.5, 1.5],
        ] {
            let text = format!(r#""name":"{name}","alpha":[{},{}]"#, alpha[0], alpha[1]);
            all.push((text, DVec2::from(alpha)));
        }
    }
    all
}

/// Facet normals and weights that integrate over the hemisphere, dense where a lobe so wide is: polar
/// about z in slopes divided by the widths.
fn facets(width: DVec2) -> Vec<(DVec3, f64)> {
    const AZIMUTHS: usize = 48;
    let rule = gauss_legendre(96);
    let mut facets = Vec::new();
    for (t, weight) in rule {
        // Slope s = t^2 / (1 - t)^2 of the unit lobe, so that far tails are met too.
        let s = (t / (1.0 - t)).powi(2);
        let ds = 2.0 * t / (1.0 - t).powi(3);
        for a in 0..AZIMUTHS {
            let (sin, cos) = (TAU * (a as f64 + 0.5) / AZIMUTHS as f64).sin_cos();
            let slope = width * DVec2::new(s * cos, s * sin);
            let wm = DVec3::new(slope.x, slope.y, 1.0).normalize();
            // d omega = cos^3 d slope_x d slope_y.
            let area = width.x * width.y * s * ds * weight * TAU / AZIMUTHS as f64;
            facets.push((wm, area * wm.z.powi(3)));
        }
    }
    facets
}

fn facet_bsdf(distribution: &str) -> Bsdf {
    bsdf(&format!(
        r#"{{"model":"torrance-sparrow","fresnel":{{"constant":[1,1,1]}},"distribution":{{{distribution}}}}}"#
    ))
}

/// The integral of D cos theta, from float64 and from lavapipe.
#[test]
fn every_distribution_covers_the_surface_once() {
    const ROOT: &str = "
import package::shared::{LabQuery};
import package::bsdf::distribution::{facet_D};
@group(3) @binding(0) var<storage, read> facets: array<LabQuery>;
@group(3) @binding(1) var<storage, read_write> densities: array<f32>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&facets) {
        densities[id.x] = facet_D(facets[id.x].bsdf, facets[id.x].wi);
    }
}
";
    let mut queries: Vec<LabQuery> = Vec::new();
    let mut expected = Vec::new();
    for (text, width) in distributions() {
        let bsdf = facet_bsdf(&text);
        let exact = cpu::bsdf::Bsdf::from(&bsdf);
        let facets = facets(width);
        let density = |wm| cpu::bsdf::distribution::facet_D(&exact, wm);
        let sum: f64 = facets
            .iter()
            .map(|&(wm, area)| density(wm) * wm.z * area)
            .sum();
        assert!((sum - 1.0).abs() < 1e-5, "float64, {text}: {sum}");
        queries.extend(facets.iter().map(|&(wi, _)| {
            LabQuery::from(&Input {
                bsdf,
                wo: wi,
                wi,
                u: DVec3::ZERO,
                cos_theta: 1.0,
            })
        }));
        expected.push((text, facets));
    }
    let bytes = common::run(
        ROOT,
        &[bytemuck::cast_slice(&queries)],
        4 * queries.len(),
        queries.len() as u32,
    );
    let densities: Vec<f32> = bytemuck::pod_collect_to_vec(&bytes);
    let mut densities = densities.into_iter();
    for (text, facets) in expected {
        let sum: f64 = facets
            .iter()
            .map(|&(wm, area)| f64::from(densities.next().unwrap()) * wm.z * area)
            .sum();
        assert!((sum - 1.0).abs() < 1e-4, "lavapipe, {text}: {sum}");
    }
}

#[test]
fn equal_exponents_of_ashikhmin_and_shirley_are_blinn() {
    for e in [0.0, 3.0, 1e3, 1e5_f64] {
        for (wm, _) in facets(DVec2::splat((2.0 / (e + 2.0)).sqrt())) {
            let blinn = cpu::bsdf::distribution::D_blinn(wm, e);
            let shirley = cpu::bsdf::distribution::D_ashikhmin_shirley(wm, DVec2::splat(e));
            assert!(
                (blinn - shirley).abs() <= 1e-6 * blinn,
                "{e} {wm}: {blinn} {shirley}"
            );
        }
    }
}

/// Both ways through every lobe, f is the same; with transmission, f / eta_i^2 is.
fn reciprocity(lab: &Lab, tolerance: f64) {
    let directions = |seed| -> Vec<DVec3> {
        let of = |u: DVec3| {
            let (sin, cos) = (FRAC_PI_2 * 0.98 * u.x).sin_cos();
            let (sin_phi, cos_phi) = (TAU * u.y).sin_cos();
            DVec3::new(sin * cos_phi, sin * sin_phi, cos)
        };
        uniforms(seed, 4096).into_iter().map(of).collect()
    };
    for (i, lobe) in lobes(0.6).iter().chain(&lobes(1.0)).enumerate() {
        let glass = lobe.eta() != 1.0;
        for below in [false, true] {
            if below && !glass {
                continue;
            }
            let side = if below {
                DVec3::new(1.0, 1.0, -1.0)
            } else {
                DVec3::ONE
            };
            let (wo, wi) = (directions(2 * i as u64), directions(2 * i as u64 + 1));
            let pairs: Vec<(DVec3, DVec3)> = wo
                .into_iter()
                .zip(wi.into_iter().map(|wi| wi * side))
                .collect();
            let run = |bsdf: Bsdf, swapped: bool| {
                let inputs: Vec<Input> = pairs
                    .iter()
                    .map(|&(wo, wi)| Input {
                        bsdf,
                        wo: if swapped { wi } else { wo },
                        wi: if swapped { wo } else { wi },
                        u: DVec3::ZERO,
                        cos_theta: 1.0,
                    })
                    .collect();
                lab.run(Stage::Eval, &inputs).unwrap()
            };
            let there = run(lobe.bsdf, false);
            let mut other = lobe.bsdf;
            let mut scale = 1.0;
            if below {
                // Seen from the other side the far index is over here.
                other.eta = other.eta.map(|eta| 1.0 / eta);
                scale = lobe.eta().powi(2);
            }
            let back = run(other, true);
            let mut seen = 0;
            for (k, (a, b)) in there.iter().zip(&back).enumerate() {
                let (a, b) = (a.f.x * scale, b.f.x);
                // Far out in a lobe's tail float32 has few digits of the facet's slope.
                if a.max(b) > 1e-3 {
                    seen += 1;
                    let gap = (a - b).abs() / a.max(b);
                    let (wo, wi) = pairs[k];
                    assert!(
                        gap < tolerance,
                        "{} {wo} {wi}: {a} there, {b} back",
                        lobe.name
                    );
                }
            }
            assert!(seen > 100, "{}: only {seen} pairs reflect", lobe.name);
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
    reciprocity(&Lab::gpu(common::gpu()).unwrap(), 1e-3);
}

/// The solid angle that wm sweeps while wi sweeps a small square, by differences.
fn swept(wo: DVec3, wi: DVec3, half: impl Fn(DVec3, DVec3) -> DVec3) -> f64 {
    const STEP: f64 = 1e-5;
    let (t, b) = wi.any_orthonormal_pair();
    let along =
        |d: DVec3| half(wo, (wi + d * STEP).normalize()) - half(wo, (wi - d * STEP).normalize());
    along(t).cross(along(b)).length() / (4.0 * STEP * STEP)
}

#[test]
fn jacobians_of_half_vectors_are_those_of_the_geometry() {
    use cpu::bsdf::{dielectric, torrance_sparrow};
    for (a, b) in uniforms(1, 500).into_iter().zip(uniforms(2, 500)) {
        let wo = (2.0 * a - 1.0).with_z(0.1 + a.z).normalize();
        let wi = (2.0 * b - 1.0).with_z(0.1 + b.z).normalize();
        let mirror = |wo: DVec3, wi: DVec3| (wo + wi).normalize();
        let exact = swept(wo, wi, mirror);
        let ours = torrance_sparrow::half_vector_jacobian(mirror(wo, wi).dot(wi));
        assert!(
            (ours / exact - 1.0).abs() < 1e-5,
            "mirrored {wo} {wi}: {ours} {exact}"
        );

        let below = wi * DVec3::new(1.0, 1.0, -1.0);
        for eta in [1.5, 1.0 / 1.5, 2.4] {
            let refract = |wo: DVec3, wi: DVec3| (wo + eta * wi).normalize();
            let sum = wo + eta * below;
            let cos_i = below.dot(sum.normalize());
            let exact = swept(wo, below, refract);
            let ours = dielectric::half_vector_transmission_jacobian(cos_i, sum.length(), eta);
            assert!(
                (ours / exact - 1.0).abs() < 1e-4,
                "{eta} {wo} {below}: {ours} {exact}"
            );
        }
    }
}
