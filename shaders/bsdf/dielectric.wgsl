// Boundaries that reflect and transmit, smooth and rough. eta is the far side's index over the near
// side's, seen from wo. Radiance is transported: f carries eta_o^2 / eta_i^2 through the surface.

import package::shared::{Bsdf};
import package::math::{sqr};
import package::exact::{product_sum};
import package::bsdf::lobe::{BsdfEval, BsdfSample, no_eval, no_sample, sample_of, is_reflected, is_transmitted, MIN_COS, ETA_MATCHED};
import package::bsdf::fresnel::{F_dielectric, T_dielectric, T_dielectric_cosines};
import package::bsdf::specular::{reflection_direction, refraction_direction};
import package::bsdf::distribution::{facet_D, is_smooth};
import package::bsdf::masking::{facet_G2};
import package::bsdf::torrance_sparrow::{half_vector, half_vector_jacobian, facet_pdf, facet_sample, mirror_shape};

// Whether the boundary acts as a smooth one: by its facets, or because both sides are nearly alike.
fn is_smooth_dielectric(bsdf: Bsdf) -> bool {
    return is_smooth(bsdf) || abs(bsdf.eta.x - 1.0) < ETA_MATCHED;
}

// Reflection with probability F, transmission with probability 1 - F.
fn smooth_dielectric_sample(bsdf: Bsdf, wo: vec3<f32>, u: f32) -> BsdfSample {
    if wo.z < MIN_COS {
        return no_sample();
    }
    let eta = bsdf.eta.x;
    let F = F_dielectric(wo.z, eta);
    if u < F {
        return BsdfSample(vec3(-wo.x, -wo.y, wo.z), bsdf.reflectance * (F / wo.z), F, 1u);
    }
    let T = T_dielectric(wo.z, eta);
    let wi = refraction_direction(wo, vec3(0.0, 0.0, 1.0), eta);
    if T <= 0.0 || wi.z > -MIN_COS {
        return no_sample();
    }
    return BsdfSample(wi, bsdf.reflectance * (T / (sqr(eta) * -wi.z)), T, 1u);
}

// The facet that refracts wi to wo, on the upper side, and in w the length of wo + eta wi.
fn half_vector_transmission(wo: vec3<f32>, wi: vec3<f32>, eta: f32) -> vec4<f32> {
    // Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", eq. 16. The two terms
    // nearly cancel, and the rest over alpha is the slope: it needs every bit of them.
    let sum = vec3(
        product_sum(eta, wi.x, wo.x),
        product_sum(eta, wi.y, wo.y),
        product_sum(eta, wi.z, wo.z),
    );
    let norm = sqrt(dot(sum, sum));
    if norm <= 0.0 {
        return vec4(0.0);
    }
    return vec4(sum / select(norm, -norm, sum.z < 0.0), norm);
}

// d omega_m / d omega_i at a facet that refracts; cos_i is the cosine between wm and wi, norm |wo + eta wi|.
fn half_vector_transmission_jacobian(cos_i: f32, norm: f32, eta: f32) -> f32 {
    // Walter et al. 2007, eq. 17, with eta_o (wo . wm) + eta_i (wi . wm) = eta_o |wo + eta wi|.
    return sqr(eta) * abs(cos_i) / sqr(norm);
}

fn rough_dielectric_reflection(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    // Walter et al. 2007, eq. 20.
    let wm = half_vector(wo, wi);
    let F = F_dielectric(wm.w, bsdf.eta.x);
    // By facets that refract too: those of facet_sample.
    let pdf = facet_pdf(bsdf, wo, wm.xyz, wm.w) * half_vector_jacobian(wm.w);
    return BsdfEval(bsdf.reflectance * (F * mirror_shape(bsdf, wo, wi, wm.xyz, wm.w)), F * pdf);
}

// f and density of a boundary that lets everything pass (x, y), with the factor 1 / eta^2; the cosine
// between facet and wo (z) and T_dielectric there (w). All 0 where no facet refracts wi to wo.
fn rough_transmission_shape(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> vec4<f32> {
    // Walter et al. 2007, eq. 21, times eta_o^2 / eta_i^2 for radiance (section 2 there).
    let eta = bsdf.eta.x;
    let half = half_vector_transmission(wo, wi, eta);
    let wm = half.xyz;
    let norm = half.w;
    let cos_o = dot(wo, wm);
    let cos_i = dot(wi, wm);
    if norm <= 0.0 || cos_o <= 0.0 || cos_i >= 0.0 {
        return vec4(0.0);
    }
    let T = T_dielectric_cosines(cos_o, -cos_i, eta);
    let G = facet_G2(bsdf, wo, wi, wm, cos_o, cos_i);
    let f = facet_D(bsdf, wm) * G * cos_o * -cos_i / (wo.z * -wi.z * sqr(norm));
    let pdf = facet_pdf(bsdf, wo, wm, cos_o) * half_vector_transmission_jacobian(cos_i, norm, eta);
    return vec4(f, pdf, cos_o, T);
}

fn rough_dielectric_transmission(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    let shape = rough_transmission_shape(bsdf, wo, wi);
    return BsdfEval(bsdf.reflectance * (shape.w * shape.x), shape.w * shape.y);
}

fn rough_dielectric_eval(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    if is_reflected(wo, wi) {
        return rough_dielectric_reflection(bsdf, wo, wi);
    }
    if is_transmitted(wo, wi) {
        return rough_dielectric_transmission(bsdf, wo, wi);
    }
    return no_eval();
}

// A facet, then reflection there with probability F and transmission with probability 1 - F.
fn rough_dielectric_sample(bsdf: Bsdf, wo: vec3<f32>, u: vec3<f32>) -> BsdfSample {
    if wo.z < MIN_COS {
        return no_sample();
    }
    let wm = facet_sample(bsdf, wo, u.yz);
    let cos_o = dot(wo, wm);
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
    return sample_of(wi, rough_dielectric_transmission(bsdf, wo, wi));
}
