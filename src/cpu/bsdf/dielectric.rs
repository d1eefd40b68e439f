//! Boundaries that reflect and transmit, smooth and rough. eta is the far side's index over the near
//! side's, seen from wo. Radiance is transported: f carries eta_o^2 / eta_i^2 through the surface.

use super::Bsdf;
use super::distribution::{facet_D, is_smooth};
use super::fresnel::{F_dielectric, T_dielectric, T_dielectric_cosines};
use super::lobe::{
    BsdfEval, BsdfSample, ETA_MATCHED, MIN_COS, is_reflected, is_transmitted, no_eval, no_sample,
    sample_of,
};
use super::masking::facet_G2;
use super::specular::{reflection_direction, refraction_direction};
use super::torrance_sparrow::{
    facet_pdf, facet_sample, half_vector, half_vector_jacobian, mirror_shape,
};
use crate::cpu::exact::product_sum;
use crate::cpu::math::sqr;
use glam::{DVec2, DVec3, DVec4};

/// Whether the boundary acts as a smooth one: by its facets, or because both sides are nearly alike.
pub fn is_smooth_dielectric(bsdf: &Bsdf) -> bool {
    is_smooth(bsdf) || (bsdf.eta.x - 1.0).abs() < ETA_MATCHED
}

/// Reflection with probability F, transmission with probability 1 - F.
pub fn smooth_dielectric_sample(bsdf: &Bsdf, wo: DVec3, u: f64) -> BsdfSample {
    if wo.z < MIN_COS {
        return no_sample();
    }
    let eta = bsdf.eta.x;
    let F = F_dielectric(wo.z, eta);
    if u < F {
        return BsdfSample {
            wi: DVec3::new(-wo.x, -wo.y, wo.z),
            f: bsdf.reflectance * (F / wo.z),
            pdf: F,
            delta: 1,
        };
    }
    let T = T_dielectric(wo.z, eta);
    let wi = refraction_direction(wo, DVec3::Z, eta);
    if T <= 0.0 || wi.z > -MIN_COS {
        return no_sample();
    }
    BsdfSample {
        wi,
        f: bsdf.reflectance * (T / (sqr(eta) * -wi.z)),
        pdf: T,
        delta: 1,
    }
}

/// The facet that refracts wi to wo, on the upper side, and in w the length of wo + eta wi.
pub fn half_vector_transmission(wo: DVec3, wi: DVec3, eta: f64) -> DVec4 {
    // Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", eq. 16. The two terms
    // nearly cancel, and the rest over alpha is the slope: it needs every bit of them.
    let sum = DVec3::new(
        product_sum(eta, wi.x, wo.x),
        product_sum(eta, wi.y, wo.y),
        product_sum(eta, wi.z, wo.z),
    );
    let norm = sum.dot(sum).sqrt();
    if norm <= 0.0 {
        return DVec4::ZERO;
    }
    (sum / if sum.z < 0.0 { -norm } else { norm }).extend(norm)
}

/// d omega_m / d omega_i at a facet that refracts; cos_i is the cosine between wm and wi, norm |wo + eta wi|.
pub fn half_vector_transmission_jacobian(cos_i: f64, norm: f64, eta: f64) -> f64 {
    // Walter et al. 2007, eq. 17, with eta_o (wo . wm) + eta_i (wi . wm) = eta_o |wo + eta wi|.
    sqr(eta) * cos_i.abs() / sqr(norm)
}

pub fn rough_dielectric_reflection(bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> BsdfEval {
    // Walter et al. 2007, eq. 20.
    let wm = half_vector(wo, wi);
    let F = F_dielectric(wm.w, bsdf.eta.x);
    // By facets that refract too: those of `facet_sample`.
    let pdf = facet_pdf(bsdf, wo, wm.truncate(), wm.w) * half_vector_jacobian(wm.w);
    BsdfEval {
        f: bsdf.reflectance * (F * mirror_shape(bsdf, wo, wi, wm.truncate(), wm.w)),
        pdf: F * pdf,
    }
}

/// f and density of a boundary that lets everything pass (x, y), with the factor 1 / eta^2; the cosine
/// between facet and wo (z) and `T_dielectric` there (w). All 0 where no facet refracts wi to wo.
pub fn rough_transmission_shape(bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> DVec4 {
    // Walter et al. 2007, eq. 21, times eta_o^2 / eta_i^2 for radiance (section 2 there).
    let eta = bsdf.eta.x;
    let half = half_vector_transmission(wo, wi, eta);
    let wm = half.truncate();
    let norm = half.w;
    let cos_o = wo.dot(wm);
    let cos_i = wi.dot(wm);
    if norm <= 0.0 || cos_o <= 0.0 || cos_i >= 0.0 {
        return DVec4::ZERO;
    }
    let T = T_dielectric_cosines(cos_o, -cos_i, eta);
    let G = facet_G2(bsdf, wo, wi, wm, cos_o, cos_i);
    let f = facet_D(bsdf, wm) * G * cos_o * -cos_i / (wo.z * -wi.z * sqr(norm));
    let pdf = facet_pdf(bsdf, wo, wm, cos_o) * half_vector_transmission_jacobian(cos_i, norm, eta);
    DVec4::new(f, pdf, cos_o, T)
}

pub fn rough_dielectric_transmission(bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> BsdfEval {
    let shape = rough_transmission_shape(bsdf, wo, wi);
    BsdfEval {
        f: bsdf.reflectance * (shape.w * shape.x),
        pdf: shape.w * shape.y,
    }
}

pub fn rough_dielectric_eval(bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> BsdfEval {
    if is_reflected(wo, wi) {
        return rough_dielectric_reflection(bsdf, wo, wi);
    }
    if is_transmitted(wo, wi) {
        return rough_dielectric_transmission(bsdf, wo, wi);
    }
    no_eval()
}

/// A facet, then reflection there with probability F and transmission with probability 1 - F.
pub fn rough_dielectric_sample(bsdf: &Bsdf, wo: DVec3, u: DVec3) -> BsdfSample {
    if wo.z < MIN_COS {
        return no_sample();
    }
    let wm = facet_sample(bsdf, wo, DVec2::new(u.y, u.z));
    let cos_o = wo.dot(wm);
    if cos_o <= 0.0 {
        return no_sample();
    }
    if u.x < F_dielectric(cos_o, bsdf.eta.x) {
        let wi = reflection_direction(wo, wm);
        if !is_reflected(wo, wi) {
            return no_sample();
        }
        return sample_of(wi, rough_dielectric_reflection(bsdf, wo, wi));
    }
    let wi = refraction_direction(wo, wm, bsdf.eta.x);
    if !is_transmitted(wo, wi) {
        return no_sample();
    }
    sample_of(wi, rough_dielectric_transmission(bsdf, wo, wi))
}
