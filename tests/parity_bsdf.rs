//! Every WGSL reflection function against its float64 twin, over 100 000 random inputs each, grazing
//! and degenerate ones included: relative error under 1e-4. Run with `--no-capture` to see a table.
//!
//! Where float32 cannot do that, the limit below says so and why.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]
#![allow(non_snake_case, reason = "the letters of the functions under test")]

mod common;
mod queries;

use glam::DVec3;
use queries::{Inputs, Query, compare, on_lavapipe, relative, within};
use snell::cpu::bsdf::{
    dielectric::*, fresnel::*, lambertian::*, oren_nayar::*, specular::*, torrance_sparrow::*,
};

fn always(_: &Query, _: usize) -> bool {
    true
}

#[test]
fn fresnel() {
    let queries = Inputs::new(10).queries(|inputs, q| {
        let eta = inputs.eta();
        q.bsdf.eta = [eta, inputs.log_range(0.03, 10.0), inputs.unit()];
        q.bsdf.k = [[0.0, inputs.log_range(0.01, 12.0)][inputs.pick(8).min(1) as usize]; 3];
        if eta < 1.0 && inputs.pick(4) == 0 {
            // At the critical angle, and on either side of it by a few bits.
            let critical = (1.0 - f64::from(eta).powi(2)).sqrt() as f32;
            q.cos_theta = critical * (1.0 + f32::EPSILON * (inputs.pick(9) as f32 - 4.0));
        }
        q.wi[0] = inputs.unit();
    });
    let gpu = on_lavapipe(
        "import package::bsdf::fresnel::{F_dielectric, T_dielectric, T_dielectric_cosines, F_conductor, F_conductor_approximate, F_schlick, snell_root};",
        "",
        &[
            "snell_root(q.cos_theta, q.bsdf.eta.x)",
            "F_dielectric(q.cos_theta, q.bsdf.eta.x)",
            "T_dielectric(q.cos_theta, q.bsdf.eta.x)",
            "T_dielectric_cosines(q.cos_theta, q.wi.x, q.bsdf.eta.x)",
            "F_conductor(q.cos_theta, q.bsdf.eta.y, q.bsdf.k.x)",
            "F_conductor_approximate(q.cos_theta, q.bsdf.eta.y, q.bsdf.k.x)",
            "F_schlick(q.cos_theta, q.bsdf.eta.zzz).x",
        ],
        &queries,
    );
    compare(
        "fresnel",
        &[
            // A root: where its argument, a sum of squares rounded at 1e-11, vanishes, 3e-6 remain.
            within("snell_root", 0.03),
            relative("F_dielectric"),
            relative("T_dielectric"),
            relative("T_dielectric_cosines"),
            // Below 1e-4 (an index near 1 and no k) the difference of indices itself is rounded.
            within("F_conductor", 1e-4),
            within("F_conductor_approximate", 1e-4),
            relative("F_schlick"),
        ],
        &queries,
        &gpu,
        |q| {
            let (c, b) = (q.cos_theta, &q.bsdf);
            vec![
                snell_root(c, b.eta.x),
                F_dielectric(c, b.eta.x),
                T_dielectric(c, b.eta.x),
                T_dielectric_cosines(c, q.wi.x, b.eta.x),
                F_conductor(c, b.eta.y, b.k.x),
                F_conductor_approximate(c, b.eta.y, b.k.x),
                F_schlick(c, DVec3::splat(b.eta.z)).x,
            ]
        },
        // T goes like the root there: relative to itself it is float32's rounding that is left.
        |q, value| value != 2 || !is_near_critical(q),
    );
    // And there it is still right to 1e-5 of the whole.
    let near: Vec<_> = queries
        .iter()
        .zip(&gpu)
        .filter(|(query, _)| is_near_critical(&Query::from(*query)))
        .collect();
    assert!(near.len() > 500);
    for (query, answer) in near {
        let q = Query::from(query);
        let T = T_dielectric(q.cos_theta, q.bsdf.eta.x);
        assert!((f64::from(answer[2]) - T).abs() < 1e-4, "{query:?}");
    }
}

/// Within 1e-8 of the critical angle in the squared cosine of the refracted ray.
fn is_near_critical(q: &Query) -> bool {
    let eta = q.bsdf.eta.x;
    eta < 1.0 && (eta * eta - 1.0 + q.cos_theta * q.cos_theta).abs() < 1e-8
}

#[test]
fn specular() {
    let queries = Inputs::new(11).queries(|inputs, q| q.bsdf.eta[0] = inputs.eta());
    let gpu = on_lavapipe(
        "import package::bsdf::specular::{reflection_direction, refraction_direction, critical_angle, snell_jacobian, is_totally_reflected};",
        "let mirrored_wo = reflection_direction(q.wo, q.wi);
         let refracted = refraction_direction(q.wo, vec3(0.0, 0.0, 1.0), q.bsdf.eta.x);",
        &[
            "mirrored_wo.x",
            "mirrored_wo.z",
            "refracted.x",
            "refracted.z",
            "critical_angle(q.bsdf.eta.x)",
            "snell_jacobian(q.cos_theta, q.bsdf.eta.x)",
            "f32(is_totally_reflected(q.cos_theta, q.bsdf.eta.x))",
        ],
        &queries,
    );
    compare(
        "specular",
        &[
            within("reflection_direction.x", 1.0),
            within("reflection_direction.z", 1.0),
            within("refraction_direction.x", 1.0),
            within("refraction_direction.z", 1.0),
            relative("critical_angle"),
            relative("snell_jacobian"),
            relative("is_totally_reflected"),
        ],
        &queries,
        &gpu,
        |q| {
            let eta = q.bsdf.eta.x;
            let mirrored = reflection_direction(q.wo, q.wi);
            let refracted = refraction_direction(q.wo, DVec3::Z, eta);
            vec![
                mirrored.x,
                mirrored.z,
                refracted.x,
                refracted.z,
                critical_angle(eta),
                snell_jacobian(q.cos_theta, eta),
                f64::from(u8::from(is_totally_reflected(q.cos_theta, eta))),
            ]
        },
        // The derivative is infinite at the critical angle.
        |q, value| value < 5 || !is_near_critical(q),
    );
}

#[test]
fn diffuse() {
    let queries = Inputs::new(12).queries(|inputs, q| {
        q.bsdf.roughness = [inputs.unit(), 0.0, 1.0][inputs.pick(8).saturating_sub(5) as usize];
        q.wo[2] = q.wo[2].max(1e-9);
        q.wi[2] = q.wi[2].max(1e-9);
    });
    let gpu = on_lavapipe(
        "import package::bsdf::lambertian::{f_lambertian};
import package::bsdf::oren_nayar::{f_oren_nayar, f_oren_nayar_eon, eon_missing};",
        "let rough = q.bsdf.roughness;
         let qualitative = f_oren_nayar(q.bsdf.reflectance, rough, q.wo, q.wi);
         let eon = f_oren_nayar_eon(q.bsdf.reflectance, rough, q.wo, q.wi);",
        &[
            "f_lambertian(q.bsdf.reflectance).x",
            "qualitative.x",
            "eon.x",
            "eon.y",
            "eon_missing(q.cos_theta)",
        ],
        &queries,
    );
    compare(
        "diffuse",
        &[
            relative("f_lambertian"),
            relative("f_oren_nayar"),
            // At roughness 1 and opposite grazing directions 1 + s cancels, to 1e-7 of rho / pi.
            within("f_oren_nayar_eon.x", 1e-3),
            within("f_oren_nayar_eon.y", 1e-3),
            // A difference from 0.288 that vanishes at grazing angles.
            within("eon_missing", 1e-2),
        ],
        &queries,
        &gpu,
        |q| {
            let (b, rough) = (&q.bsdf, q.bsdf.roughness);
            let eon = f_oren_nayar_eon(b.reflectance, rough, q.wo, q.wi);
            vec![
                f_lambertian(b.reflectance).x,
                f_oren_nayar(b.reflectance, rough, q.wo, q.wi).x,
                eon.x,
                eon.y,
                eon_missing(q.cos_theta),
            ]
        },
        always,
    );
}

#[test]
fn half_vectors() {
    let queries = Inputs::new(16).queries(|inputs, q| {
        q.bsdf.eta[0] = inputs.eta();
        // A facet a little off the normal that refracts wo to wi.
        let wide = inputs.log_range(1e-3, 1.0);
        let m = DVec3::new(
            f64::from(wide * inputs.range(-1.0, 1.0)),
            f64::from(wide * inputs.range(-1.0, 1.0)),
            1.0,
        )
        .normalize();
        let query = Query::from(&*q);
        let wi = refraction_direction(query.wo, m, query.bsdf.eta.x);
        q.wi = wi.as_vec3().into();
    });
    let gpu = on_lavapipe(
        "import package::bsdf::torrance_sparrow::{half_vector};
import package::bsdf::dielectric::{half_vector_transmission, half_vector_transmission_jacobian};",
        "let m = half_vector(q.wo, vec3(q.wi.xy, -q.wi.z));
         let t = half_vector_transmission(q.wo, q.wi, q.bsdf.eta.x);",
        &[
            "m.x",
            "m.y",
            "m.w",
            "t.x",
            "t.y",
            "t.w",
            "half_vector_transmission_jacobian(q.cos_theta, max(t.w, 0.01), q.bsdf.eta.x)",
        ],
        &queries,
    );
    compare(
        "half vectors",
        &[
            relative("half_vector.x"),
            relative("half_vector.y"),
            relative("half_vector.cos"),
            // One part in 1e7 of the sum's terms over their rest.
            within("half_vector_transmission.x", 1e-4),
            within("half_vector_transmission.y", 1e-4),
            relative("half_vector_transmission.norm"),
            relative("its Jacobian"),
        ],
        &queries,
        &gpu,
        |q| {
            let m = half_vector(q.wo, DVec3::new(q.wi.x, q.wi.y, -q.wi.z));
            let t = half_vector_transmission(q.wo, q.wi, q.bsdf.eta.x);
            let jacobian = half_vector_transmission_jacobian(
                q.cos_theta,
                t.w.max(f64::from(0.01f32)),
                q.bsdf.eta.x,
            );
            vec![m.x, m.y, m.w, t.x, t.y, t.w, jacobian]
        },
        always,
    );
}
