//! Mirror facets: f = F(wi . wm) D(wm) G / (4 cos theta_o cos theta_i).

use super::Bsdf;
use super::distribution::{facet_D, facet_alpha, facet_exponents, is_ggx, sample_exponential};
use super::fresnel::fresnel_F;
use super::lobe::{BsdfEval, BsdfSample, MIN_COS, is_reflected, no_eval, no_sample, sample_of};
use super::masking::{G1_smith, facet_G2};
use super::specular::reflection_direction;
use super::visible_normal::{
    pdf_bounded_visible_ggx, sample_bounded_visible_ggx, sample_visible_beckmann,
    sample_visible_ggx,
};
use crate::shared::DISTRIBUTION_BECKMANN;
use glam::{DVec2, DVec3, DVec4};

/// The facet that mirrors wi to wo, and in w the cosine between it and either of them; zero where the
/// two are opposite.
pub fn half_vector(wo: DVec3, wi: DVec3) -> DVec4 {
    let sum = wo + wi;
    let norm = sum.dot(sum).sqrt();
    if norm <= 0.0 {
        return DVec4::ZERO;
    }
    // wo . wm = |wo + wi| / 2: no cancellation, and exactly symmetric.
    (sum / norm).extend(0.5 * norm)
}

/// d omega_m / d omega_i at a facet that mirrors; cos_m is the cosine between wm and wi.
pub fn half_vector_jacobian(cos_m: f64) -> f64 {
    // Lecture, "Relating Half-Angle to Outgoing Change".
    1.0 / (4.0 * cos_m)
}

/// Density of `facet_sample`, per solid angle of wm; cos_o is the cosine between wm and wo.
pub fn facet_pdf(bsdf: &Bsdf, wo: DVec3, wm: DVec3, cos_o: f64) -> f64 {
    if is_ggx(bsdf) || bsdf.distribution == DISTRIBUTION_BECKMANN {
        return G1_smith(bsdf, wo) * facet_D(bsdf, wm) * cos_o / wo.z;
    }
    facet_D(bsdf, wm) * wm.z.max(0.0)
}

/// A facet normal: of the visible ones where the distribution has them in closed form.
pub fn facet_sample(bsdf: &Bsdf, wo: DVec3, u: DVec2) -> DVec3 {
    if is_ggx(bsdf) {
        return sample_visible_ggx(wo, facet_alpha(bsdf), u);
    }
    if bsdf.distribution == DISTRIBUTION_BECKMANN {
        return sample_visible_beckmann(wo, facet_alpha(bsdf), u);
    }
    sample_exponential(facet_exponents(bsdf), u)
}

/// Density of `mirror_sample`'s mirrored direction, per its own solid angle.
pub fn mirror_pdf(bsdf: &Bsdf, wo: DVec3, wm: DVec3, cos_m: f64) -> f64 {
    if is_ggx(bsdf) {
        return pdf_bounded_visible_ggx(wo, facet_alpha(bsdf), facet_D(bsdf, wm));
    }
    facet_pdf(bsdf, wo, wm, cos_m) * half_vector_jacobian(cos_m)
}

/// A facet normal for those who only reflect there.
pub fn mirror_sample(bsdf: &Bsdf, wo: DVec3, u: DVec2) -> DVec3 {
    if is_ggx(bsdf) {
        return sample_bounded_visible_ggx(wo, facet_alpha(bsdf), u);
    }
    facet_sample(bsdf, wo, u)
}

/// D G / (4 cos theta_o cos theta_i): all of the lobe but its colour.
pub fn mirror_shape(bsdf: &Bsdf, wo: DVec3, wi: DVec3, wm: DVec3, cos_m: f64) -> f64 {
    let G = facet_G2(bsdf, wo, wi, wm, cos_m, cos_m);
    facet_D(bsdf, wm) * G / (4.0 * wo.z * wi.z)
}

/// The same in x and the density of wi in y.
pub fn torrance_sparrow_shape(bsdf: &Bsdf, wo: DVec3, wi: DVec3, wm: DVec3, cos_m: f64) -> DVec2 {
    DVec2::new(
        mirror_shape(bsdf, wo, wi, wm, cos_m),
        mirror_pdf(bsdf, wo, wm, cos_m),
    )
}

pub fn torrance_sparrow_eval(bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> BsdfEval {
    // Lecture, "Torrance-Sparrow"; Torrance and Sparrow 1967, "Theory for Off-Specular Reflection From
    // Roughened Surfaces". With MASKING_NONE it is the lecture's formula, which can reflect more than
    // it receives at grazing angles.
    if !is_reflected(wo, wi) {
        return no_eval();
    }
    let wm = half_vector(wo, wi);
    let shape = torrance_sparrow_shape(bsdf, wo, wi, wm.truncate(), wm.w);
    BsdfEval {
        f: bsdf.reflectance * fresnel_F(bsdf, wm.w) * shape.x,
        pdf: shape.y,
    }
}

pub fn torrance_sparrow_sample(bsdf: &Bsdf, wo: DVec3, u: DVec2) -> BsdfSample {
    if wo.z < MIN_COS {
        return no_sample();
    }
    let wi = reflection_direction(wo, mirror_sample(bsdf, wo, u));
    sample_of(wi, torrance_sparrow_eval(bsdf, wo, wi))
}
