//! Visible normals for reflection alone: the bound, what it gains, and both sides alike.
#![allow(non_snake_case, reason = "the letters of the functions under test")]

mod common;
mod queries;
mod subjects;

use glam::{DVec2, DVec3};
use queries::{Inputs, compare, on_lavapipe, relative, within, xy, yz};
use snell::cpu::bsdf::distribution::{D_ggx, facet_alpha};
use snell::cpu::bsdf::specular::reflection_direction;
use snell::cpu::bsdf::torrance_sparrow::{
    facet_pdf, facet_sample, half_vector, half_vector_jacobian, mirror_pdf, mirror_sample,
    mirror_shape,
};
use snell::cpu::bsdf::visible_normal::*;
use snell::shared::*;
use subjects::{direction, lattice, lobe};

/// No direction above the surface is left out: seen where the roughness is one, all lie in the cap.
#[test]
fn the_bound_leaves_nothing_out() {
    let mut least = f64::INFINITY;
    for alpha in [
        [0.001, 0.001],
        [0.1, 0.1],
        [0.5, 0.5],
        [1.0, 1.0],
        [0.1, 0.9],
        [1.0, 0.3],
    ] {
        let alpha = DVec2::from_array(alpha);
        for p in lattice(400) {
            let wo = direction(p.x.acos(), std::f64::consts::TAU * p.y);
            let view = stretched_view(wo, alpha);
            let rest = bounded_cap_rest(wo, alpha);
            assert!((0.0..=1.0).contains(&rest));
            for q in lattice(400) {
                // Grazing light is what comes near the edge.
                let wi = direction((q.x.powi(4)).acos(), std::f64::consts::TAU * q.y);
                let wm = half_vector(wo, wi).truncate();
                let stretched = (wm / alpha.extend(1.0)).normalize();
                let mirrored = reflection_direction(view, stretched);
                least = least.min(mirrored.z + (1.0 - rest) * view.z);
            }
        }
    }
    println!("nearest to the edge {least}");
    assert!(least > -1e-9, "{least} below the edge");
    // And at alpha 1 nothing is wasted.
    assert_eq!(bounded_cap_rest(direction(0.7, 0.1), DVec2::ONE), 1.0);
}

/// Mean and variance of f cos / pdf in the white furnace, bounded or by plain visible normals.
fn furnace(alpha: f64, degrees: f64, bounded: bool) -> (f64, f64) {
    const COUNT: u32 = 200_000;
    let bsdf = lobe(DISTRIBUTION_GGX, [alpha; 2], MASKING_SMITH);
    let wo = direction(degrees.to_radians(), 0.4);
    let (mut sum, mut squares) = (0.0, 0.0);
    for u in lattice(COUNT) {
        let sampled = if bounded {
            mirror_sample(&bsdf, wo, yz(u))
        } else {
            facet_sample(&bsdf, wo, yz(u))
        };
        let wi = reflection_direction(wo, sampled);
        if wi.z <= 0.0 {
            continue;
        }
        let half = half_vector(wo, wi);
        let (wm, cos_m) = (half.truncate(), half.w);
        let pdf = if bounded {
            mirror_pdf(&bsdf, wo, wm, cos_m)
        } else {
            facet_pdf(&bsdf, wo, wm, cos_m) * half_vector_jacobian(cos_m)
        };
        let weight = mirror_shape(&bsdf, wo, wi, wm, cos_m) * wi.z / pdf;
        assert!(
            weight <= 1.0 + 1e-9,
            "{weight} at {degrees} degrees, alpha {alpha}"
        );
        sum += weight;
        squares += weight * weight;
    }
    let mean = sum / f64::from(COUNT);
    (mean, squares / f64::from(COUNT) - mean * mean)
}

#[test]
fn bounded_normals_halve_the_variance() {
    for alpha in [0.5, 1.0] {
        for degrees in [0.0, 45.0] {
            let (mean, plain) = furnace(alpha, degrees, false);
            let (same, bounded) = furnace(alpha, degrees, true);
            println!(
                "alpha {alpha}, {degrees} degrees: variance {plain:.5} -> {bounded:.5} ({:.1} x), deviation {:.4} -> {:.4}",
                plain / bounded,
                plain.sqrt(),
                bounded.sqrt()
            );
            assert!((mean - same).abs() < 2e-4, "{mean} {same}");
            assert!(2.0 * bounded < plain, "{plain} {bounded}");
        }
    }
}

#[test]
fn bounded_normals_on_lavapipe() {
    let queries = Inputs::new(52).queries(|inputs, q| {
        q.bsdf.distribution = DISTRIBUTION_GGX;
        q.bsdf.alpha[0] = inputs.log_range(1e-3, 1.0);
        q.bsdf.alpha[1] = match inputs.pick(2) {
            0 => q.bsdf.alpha[0],
            _ => inputs.log_range(1e-3, 1.0),
        };
        q.wo[2] = q.wo[2].max(1e-9);
        let query = queries::Query::from(&*q);
        let wm = sample_bounded_visible_ggx(query.wo, query.bsdf.alpha, xy(query.u));
        q.wi = wm.as_vec3().into();
    });
    let gpu = on_lavapipe(
        "import package::bsdf::visible_normal::{bounded_cap_rest, sample_bounded_visible_ggx, pdf_bounded_visible_ggx};
import package::bsdf::distribution::{D_ggx, facet_alpha};",
        "let alpha = facet_alpha(q.bsdf);
         let m = sample_bounded_visible_ggx(q.wo, alpha, q.u.yz);",
        &[
            "bounded_cap_rest(q.wo, alpha)",
            "pdf_bounded_visible_ggx(q.wo, alpha, D_ggx(q.wi, alpha))",
            "m.x",
            "m.y",
            "m.z",
        ],
        &queries,
    );
    compare(
        "bounded normals",
        &[
            relative("bounded_cap_rest"),
            relative("pdf"),
            within("normal.x", 1.0),
            within("normal.y", 1.0),
            within("normal.z", 1.0),
        ],
        &queries,
        &gpu,
        |q| {
            let alpha = facet_alpha(&q.bsdf);
            let m: DVec3 = sample_bounded_visible_ggx(q.wo, alpha, yz(q.u));
            vec![
                bounded_cap_rest(q.wo, alpha),
                pdf_bounded_visible_ggx(q.wo, alpha, D_ggx(q.wi, alpha)),
                m.x,
                m.y,
                m.z,
            ]
        },
        // As with plain visible normals: at u near 1 the sum of view and mirrored view nearly vanishes.
        |q, value| value < 2 || q.u.z < 0.999,
    );
}
