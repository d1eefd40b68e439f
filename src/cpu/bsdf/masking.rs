//! How much of a facet is hidden: from the viewer, from the light.

use super::Bsdf;
use super::distribution::{facet_alpha, is_ggx};
use crate::cpu::erf::{SQRT_PI, erfcx_accurate};
use crate::cpu::math::{exp_accurate, sqr};
use crate::shared::{MASKING_SMITH, MASKING_V_CAVITY};
use glam::{DVec2, DVec3};

/// Smith's Lambda of GGX.
pub fn Lambda_ggx(w: DVec3, alpha: DVec2) -> f64 {
    // Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", eq. 72:
    // (sqrt(1 + t) - 1) / 2, expanded by the sum.
    let t = (sqr(alpha.x * w.x) + sqr(alpha.y * w.y)) / sqr(w.z);
    0.5 * t / (1.0 + (1.0 + t).sqrt())
}

/// Smith's Lambda of Beckmann, exact.
pub fn Lambda_beckmann(w: DVec3, alpha: DVec2) -> f64 {
    // Heitz 2014, eq. 66: with a = 1 / (alpha tan theta), (e^(-a^2) / (a sqrt(pi)) - erfc(a)) / 2.
    let slope = (sqr(alpha.x * w.x) + sqr(alpha.y * w.y)).sqrt();
    if slope <= 0.0 {
        return 0.0;
    }
    let a = w.z.abs() / slope;
    0.5 * exp_accurate(-a * a) * (1.0 / (a * SQRT_PI) - erfcx_accurate(a))
}

pub fn facet_Lambda(bsdf: &Bsdf, w: DVec3) -> f64 {
    if is_ggx(bsdf) {
        return Lambda_ggx(w, facet_alpha(bsdf));
    }
    // Blinn, Ashikhmin and Shirley: by their Beckmann equivalent, as Walter et al. 2007, 5.2.
    Lambda_beckmann(w, facet_alpha(bsdf))
}

pub fn G1_smith(bsdf: &Bsdf, w: DVec3) -> f64 {
    1.0 / (1.0 + facet_Lambda(bsdf, w))
}

pub fn G2_smith(bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> f64 {
    let Lambda_o = facet_Lambda(bsdf, wo);
    let Lambda_i = facet_Lambda(bsdf, wi);
    if wi.z * wo.z > 0.0 {
        // Height-correlated, Heitz 2014, eq. 99.
        return 1.0 / (1.0 + Lambda_o + Lambda_i);
    }
    // Through the surface the heights that hide do not go together: Walter et al. 2007, eq. 23.
    1.0 / ((1.0 + Lambda_o) * (1.0 + Lambda_i))
}

/// cos_o and cos_i are those between wm and wo, wi.
pub fn G2_v_cavity(wo: DVec3, wi: DVec3, wm: DVec3, cos_o: f64, cos_i: f64) -> f64 {
    // Torrance and Sparrow 1967, "Theory for Off-Specular Reflection From Roughened Surfaces".
    let nearer = (wo.z / cos_o).abs().min((wi.z / cos_i).abs());
    (2.0 * wm.z * nearer).min(1.0)
}

pub fn facet_G2(bsdf: &Bsdf, wo: DVec3, wi: DVec3, wm: DVec3, cos_o: f64, cos_i: f64) -> f64 {
    match bsdf.masking {
        MASKING_V_CAVITY => G2_v_cavity(wo, wi, wm, cos_o, cos_i),
        MASKING_SMITH => G2_smith(bsdf, wo, wi),
        _ => 1.0, // MASKING_NONE, the lecture's derivation
    }
}
