//! The functions of facets (distributions, masking, sampling), WGSL on lavapipe against float64.
#![allow(non_snake_case, reason = "the letters of the functions under test")]

mod common;
mod queries;

use glam::{DVec2, DVec3};
use queries::{Inputs, Query, compare, on_lavapipe, relative, within, xy, yz};
use snell::cpu::bsdf::{distribution::*, masking::*, torrance_sparrow::*, visible_normal::*};
use snell::shared::*;

fn always(_: &Query, _: usize) -> bool {
    true
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
