//! Light through glTF's facets (`KHR_materials_transmission`): refracted into a medium, or straight through
//! a wall too thin to bend it. The tint is the caller's.

use super::Bsdf;
use super::boundary::{is_refractive, transmits_smoothly};
use super::dielectric::rough_transmission_shape;
use super::fresnel::T_dielectric;
use super::lobe::{
    BsdfSample, DELTA, DELTA_STRAIGHT, is_reflected, is_transmitted, mirrored, no_sample,
};
use super::specular::{reflection_direction, refraction_direction};
use super::torrance_sparrow::{facet_sample, half_vector, mirror_sample, torrance_sparrow_shape};
use crate::cpu::math::sqr;
use glam::{DVec2, DVec3, DVec4};

/// f of a facet that lets everything pass in x, with its factor 1 / eta^2; the density of wi in y; in z
/// the cosine between facet and wo and in w `T_dielectric` there. For wi below and rough facets.
pub fn transmission_shape(bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> DVec4 {
    if is_refractive(bsdf) {
        return rough_transmission_shape(bsdf, wo, wi);
    }
    // KHR_materials_transmission, "Transmission BTDF": the reflected lobe on the other side.
    let above = mirrored(wi);
    let wm = half_vector(wo, above);
    let shape = torrance_sparrow_shape(bsdf, wo, above, wm.truncate(), wm.w);
    DVec4::new(shape.x, shape.y, wm.w, T_dielectric(wm.w, bsdf.eta.x))
}

/// A direction on the other side; of a delta with f of a surface that lets everything pass. pdf is 1.
pub fn transmission_sample(bsdf: &Bsdf, wo: DVec3, u: DVec2) -> BsdfSample {
    let drawn = |wi: DVec3, f: f64, delta: u32| BsdfSample {
        wi,
        f: DVec3::splat(f),
        pdf: 1.0,
        delta,
    };
    let is_delta = transmits_smoothly(bsdf);
    if !is_refractive(bsdf) {
        if is_delta {
            return drawn(-wo, 1.0 / wo.z, DELTA_STRAIGHT);
        }
        let above = reflection_direction(wo, mirror_sample(bsdf, wo, u));
        if !is_reflected(wo, above) {
            return no_sample();
        }
        return drawn(mirrored(above), 0.0, 0);
    }
    let eta = bsdf.eta.x;
    let wm = if is_delta {
        DVec3::Z
    } else {
        facet_sample(bsdf, wo, u)
    };
    let wi = refraction_direction(wo, wm, eta);
    if wo.dot(wm) <= 0.0 || !is_transmitted(wo, wi) {
        return no_sample();
    }
    if is_delta {
        return drawn(wi, 1.0 / (sqr(eta) * -wi.z), DELTA);
    }
    drawn(wi, 0.0, 0)
}
