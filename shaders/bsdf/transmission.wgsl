// Light through glTF's facets (KHR_materials_transmission): refracted into a medium, or straight through
// a wall too thin to bend it. The tint is the caller's.

import package::shared::{Bsdf};
import package::math::{sqr};
import package::bsdf::lobe::{BsdfSample, no_sample, mirrored, is_reflected, is_transmitted, DELTA, DELTA_STRAIGHT, MIN_COS};
import package::bsdf::fresnel::{T_dielectric};
import package::bsdf::specular::{reflection_direction, refraction_direction};
import package::bsdf::torrance_sparrow::{facet_sample, half_vector, mirror_sample, torrance_sparrow_shape};
import package::bsdf::dielectric::{rough_transmission_shape};
import package::bsdf::boundary::{is_refractive, transmits_smoothly};

// f of a facet that lets everything pass in x, with its factor 1 / eta^2; the density of wi in y; in z
// the cosine between facet and wo and in w T_dielectric there. For wi below and rough facets.
fn transmission_shape(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> vec4<f32> {
    if is_refractive(bsdf) {
        return rough_transmission_shape(bsdf, wo, wi);
    }
    // KHR_materials_transmission, "Transmission BTDF": the reflected lobe on the other side.
    let above = mirrored(wi);
    let wm = half_vector(wo, above);
    let shape = torrance_sparrow_shape(bsdf, wo, above, wm.xyz, wm.w);
    return vec4(shape, wm.w, T_dielectric(wm.w, bsdf.eta.x));
}

// A direction on the other side; of a delta with f of a surface that lets everything pass. pdf is 1.
fn transmission_sample(bsdf: Bsdf, wo: vec3<f32>, u: vec2<f32>) -> BsdfSample {
    let is_delta = transmits_smoothly(bsdf);
    if !is_refractive(bsdf) {
        if is_delta {
            return BsdfSample(-wo, vec3(1.0 / wo.z), 1.0, DELTA_STRAIGHT);
        }
        let above = reflection_direction(wo, mirror_sample(bsdf, wo, u));
        if !is_reflected(wo, above) {
            return no_sample();
        }
        return BsdfSample(mirrored(above), vec3(0.0), 1.0, 0u);
    }
    let eta = bsdf.eta.x;
    var wm = vec3(0.0, 0.0, 1.0);
    if !is_delta {
        wm = facet_sample(bsdf, wo, u);
    }
    let wi = refraction_direction(wo, wm, eta);
    if dot(wo, wm) <= 0.0 || !is_transmitted(wo, wi) {
        return no_sample();
    }
    if is_delta {
        return BsdfSample(wi, vec3(1.0 / (sqr(eta) * -wi.z)), 1.0, DELTA);
    }
    return BsdfSample(wi, vec3(0.0), 1.0, 0u);
}
