// How much of a facet is hidden: from the viewer, from the light.

import package::shared::{Bsdf, MASKING_V_CAVITY, MASKING_SMITH};
import package::variant::{ONLY_SMITH};
import package::math::{sqr, exp_accurate};
import package::erf::{SQRT_PI, erfc_accurate, erfcx_accurate};
import package::bsdf::distribution::{is_ggx, facet_alpha};

// Smith's Lambda of GGX.
fn Lambda_ggx(w: vec3<f32>, alpha: vec2<f32>) -> f32 {
    // Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", eq. 72:
    // (sqrt(1 + t) - 1) / 2, expanded by the sum.
    let t = (sqr(alpha.x * w.x) + sqr(alpha.y * w.y)) / sqr(w.z);
    return 0.5 * t / (1.0 + sqrt(1.0 + t));
}

// Smith's Lambda of Beckmann, exact.
fn Lambda_beckmann(w: vec3<f32>, alpha: vec2<f32>) -> f32 {
    // Heitz 2014, eq. 66: with a = 1 / (alpha tan theta), (e^(-a^2) / (a sqrt(pi)) - erfc(a)) / 2.
    let slope = sqrt(sqr(alpha.x * w.x) + sqr(alpha.y * w.y));
    if slope <= 0.0 {
        return 0.0;
    }
    let a = abs(w.z) / slope;
    return 0.5 * exp_accurate(-a * a) * (1.0 / (a * SQRT_PI) - erfcx_accurate(a));
}

fn facet_Lambda(bsdf: Bsdf, w: vec3<f32>) -> f32 {
    if is_ggx(bsdf) {
        return Lambda_ggx(w, facet_alpha(bsdf));
    }
    // Blinn, Ashikhmin and Shirley: by their Beckmann equivalent, as Walter et al. 2007, 5.2.
    return Lambda_beckmann(w, facet_alpha(bsdf));
}

fn G1_smith(bsdf: Bsdf, w: vec3<f32>) -> f32 {
    return 1.0 / (1.0 + facet_Lambda(bsdf, w));
}

fn G2_smith(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    let Lambda_o = facet_Lambda(bsdf, wo);
    let Lambda_i = facet_Lambda(bsdf, wi);
    if wi.z * wo.z > 0.0 {
        // Height-correlated, Heitz 2014, eq. 99.
        return 1.0 / (1.0 + Lambda_o + Lambda_i);
    }
    // Through the surface the heights that hide do not go together: Walter et al. 2007, eq. 23.
    return 1.0 / ((1.0 + Lambda_o) * (1.0 + Lambda_i));
}

// cos_o and cos_i are those between wm and wo, wi.
fn G2_v_cavity(wo: vec3<f32>, wi: vec3<f32>, wm: vec3<f32>, cos_o: f32, cos_i: f32) -> f32 {
    // Torrance and Sparrow 1967, "Theory for Off-Specular Reflection From Roughened Surfaces".
    return min(1.0, 2.0 * wm.z * min(abs(wo.z / cos_o), abs(wi.z / cos_i)));
}

fn facet_G2(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>, wm: vec3<f32>, cos_o: f32, cos_i: f32) -> f32 {
    if ONLY_SMITH || bsdf.masking == MASKING_SMITH {
        return G2_smith(bsdf, wo, wi);
    }
    switch bsdf.masking {
        case MASKING_V_CAVITY: {
            return G2_v_cavity(wo, wi, wm, cos_o, cos_i);
        }
        default: { // MASKING_NONE, the lecture's derivation
            return 1.0;
        }
    }
}
