//! Every WGSL reflection function against its float64 twin, over 100 000 random inputs each, grazing
//! and degenerate ones included: relative error under 1e-4. Run with `--no-capture` to see a table.
//!
//! Where float32 cannot do that, the limit below says so and why.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]
#![allow(non_snake_case, reason = "the letters of the functions under test")]

mod common;
mod queries;

use glam::{DVec2, DVec3};
use queries::{Inputs, Query, compare, on_lavapipe, relative, within, xy, yz};
use snell::cpu::bsdf::{
    dielectric::*, distribution::*, fresnel::*, lambertian::*, masking::*, oren_nayar::*,
    specular::*, torrance_sparrow::*, visible_normal::*,
};
use snell::shared::*;

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

/// Widths or exponents of each kind of distribution, both axes alike half of the time.
fn facets(inputs: &mut Inputs, distribution: u32) -> [f32; 2] {
    let exponential = distribution <= DISTRIBUTION_ASHIKHMIN_SHIRLEY;
    let one = |inputs: &mut Inputs| match (exponential, inputs.pick(16)) {
        (true, 0) => 0.0,
        (true, 1) => 1e5,
        (true, _) => inputs.log_range(0.01, 1e5),
        (false, 0) => 1.0,
        (false, 1) => 1e-3,
        (false, _) => inputs.log_range(1e-3, 1.0),
    };
    let x = one(inputs);
    [x, if inputs.pick(2) == 0 { x } else { one(inputs) }]
}

/// A query of facets whose normal wi is typical of them, or anything.
fn facet_queries(seed: u64) -> Vec<LabQuery> {
    Inputs::new(seed).queries(|inputs, q| {
        let distribution = inputs.pick(4);
        q.bsdf.distribution = distribution;
        q.bsdf.alpha = facets(inputs, distribution);
        q.bsdf.masking = MASKING_SMITH;
        if inputs.pick(4) > 0 {
            let wo = DVec3::new(0.0, 0.0, 1.0);
            let query = Query::from(&*q);
            q.wi = facet_sample(&query.bsdf, wo, xy(query.u)).as_vec3().into();
        }
        q.wo[2] = q.wo[2].max(1e-9);
    })
}

#[test]
fn distributions() {
    let queries = facet_queries(13);
    let gpu = on_lavapipe(
        "import package::bsdf::distribution::{D_blinn, D_ashikhmin_shirley, D_beckmann, D_ggx, facet_D, cos_power, tan2_theta, is_smooth};",
        "let e = 0.01 + 1.0 / (q.bsdf.alpha * q.bsdf.alpha);
         let wide = min(q.bsdf.alpha, vec2(1.0));",
        &[
            "facet_D(q.bsdf, q.wi)",
            "D_blinn(q.wi, min(e.x, 1e5))",
            "D_ashikhmin_shirley(q.wi, min(e, vec2(1e5)))",
            "D_beckmann(q.wi, max(wide, vec2(1e-3)))",
            "D_ggx(q.wi, max(wide, vec2(1e-3)))",
            "cos_power(tan2_theta(q.wi), min(e.y, 1e5))",
            "f32(is_smooth(q.bsdf))",
        ],
        &queries,
    );
    compare(
        "distributions",
        &[
            // (e + 2) / (2 pi) times an exponential that ends at 1e-38.
            within("facet_D", 1e-28),
            within("D_blinn", 1e-28),
            within("D_ashikhmin_shirley", 1e-28),
            relative("D_beckmann"),
            relative("D_ggx"),
            relative("cos_power"),
            relative("is_smooth"),
        ],
        &queries,
        &gpu,
        |q| {
            let e = 0.01 + 1.0 / (q.bsdf.alpha * q.bsdf.alpha);
            let wide = q.bsdf.alpha.min(DVec2::ONE).max(DVec2::splat(1e-3));
            vec![
                facet_D(&q.bsdf, q.wi),
                D_blinn(q.wi, e.x.min(1e5)),
                D_ashikhmin_shirley(q.wi, e.min(DVec2::splat(1e5))),
                D_beckmann(q.wi, wide),
                D_ggx(q.wi, wide),
                cos_power(tan2_theta(q.wi), e.y.min(1e5)),
                f64::from(u8::from(is_smooth(&q.bsdf))),
            ]
        },
        always,
    );
}

#[test]
fn masking() {
    let queries = facet_queries(14);
    let gpu = on_lavapipe(
        "import package::bsdf::masking::{Lambda_ggx, Lambda_beckmann, G1_smith, G2_smith, G2_v_cavity};
import package::bsdf::distribution::{facet_alpha};
import package::bsdf::torrance_sparrow::{half_vector, half_vector_jacobian, facet_pdf};
import package::bsdf::dielectric::{half_vector_transmission};",
        "let alpha = facet_alpha(q.bsdf);
         let wi = vec3(q.wi.xy, max(q.wi.z, 1e-9));
         let m = half_vector(q.wo, wi);
         let below = vec3(wi.xy, -wi.z);",
        &[
            "Lambda_ggx(q.wo, alpha)",
            "Lambda_beckmann(q.wo, alpha)",
            "G1_smith(q.bsdf, q.wo)",
            "G2_smith(q.bsdf, q.wo, wi)",
            "G2_smith(q.bsdf, q.wo, below)",
            "G2_v_cavity(q.wo, wi, m.xyz, m.w, m.w)",
            "facet_pdf(q.bsdf, q.wo, m.xyz, m.w)",
            "half_vector_jacobian(m.w)",
        ],
        &queries,
    );
    compare(
        "masking",
        &[
            relative("Lambda_ggx"),
            relative("Lambda_beckmann"),
            relative("G1_smith"),
            relative("G2_smith, one side"),
            relative("G2_smith, through"),
            relative("G2_v_cavity"),
            relative("facet_pdf"),
            relative("half_vector_jacobian"),
        ],
        &queries,
        &gpu,
        |q| {
            let alpha = facet_alpha(&q.bsdf);
            let wi = DVec3::new(q.wi.x, q.wi.y, q.wi.z.max(f64::from(1e-9f32)));
            let m = half_vector(q.wo, wi);
            let below = DVec3::new(wi.x, wi.y, -wi.z);
            vec![
                Lambda_ggx(q.wo, alpha),
                Lambda_beckmann(q.wo, alpha),
                G1_smith(&q.bsdf, q.wo),
                G2_smith(&q.bsdf, q.wo, wi),
                G2_smith(&q.bsdf, q.wo, below),
                G2_v_cavity(q.wo, wi, m.truncate(), m.w, m.w),
                facet_pdf(&q.bsdf, q.wo, m.truncate(), m.w),
                half_vector_jacobian(m.w),
            ]
        },
        always,
    );
}

#[test]
fn facet_normals() {
    let queries = facet_queries(15);
    let gpu = on_lavapipe(
        "import package::bsdf::torrance_sparrow::{facet_sample};
import package::bsdf::visible_normal::{visible_slope};",
        "let m = facet_sample(q.bsdf, q.wo, q.u.yz);
         let sine = sqrt((1.0 - q.cos_theta) * (1.0 + q.cos_theta));",
        &[
            "m.x",
            "m.y",
            "m.z",
            "visible_slope(q.cos_theta, sine, q.u.x)",
        ],
        &queries,
    );
    compare(
        "facet normals",
        &[
            within("facet_sample.x", 1.0),
            within("facet_sample.y", 1.0),
            within("facet_sample.z", 1.0),
            within("visible_slope", 1.0),
        ],
        &queries,
        &gpu,
        |q| {
            let m = facet_sample(&q.bsdf, q.wo, yz(q.u));
            let sine = ((1.0 - q.cos_theta) * (1.0 + q.cos_theta)).sqrt();
            vec![m.x, m.y, m.z, visible_slope(q.cos_theta, sine, q.u.x)]
        },
        // At u near 1 stand the facets seen edge on: the sum of view and mirrored view nearly vanishes,
        // and the mass of slopes left over is as small as the last bit of u.
        |q, value| [q.u.z, q.u.z, q.u.z, q.u.x][value] < 0.999 && q.u.y < 0.999,
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
