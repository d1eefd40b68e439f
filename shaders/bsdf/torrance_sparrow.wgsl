// Mirror facets: f = F(wi . wm) D(wm) G / (4 cos theta_o cos theta_i).

import package::shared::{Bsdf, DISTRIBUTION_BECKMANN};
import package::bsdf::lobe::{BsdfEval, BsdfSample, no_eval, no_sample, sample_of, is_reflected, MIN_COS};
import package::bsdf::fresnel::{fresnel_F};
import package::bsdf::specular::{reflection_direction};
import package::bsdf::distribution::{is_ggx, facet_D, facet_alpha, facet_exponents, sample_exponential};
import package::bsdf::visible_normal::{sample_visible_ggx, sample_visible_beckmann, sample_bounded_visible_ggx, pdf_bounded_visible_ggx};
import package::bsdf::masking::{facet_G2, G1_smith};

// The facet that mirrors wi to wo, and in w the cosine between it and either of them; zero where the
// two are opposite.
fn half_vector(wo: vec3<f32>, wi: vec3<f32>) -> vec4<f32> {
    let sum = wo + wi;
    let norm = sqrt(dot(sum, sum));
    if norm <= 0.0 {
        return vec4(0.0);
    }
    // wo . wm = |wo + wi| / 2: no cancellation, and exactly symmetric.
    return vec4(sum / norm, 0.5 * norm);
}

// d omega_m / d omega_i at a facet that mirrors; cos_m is the cosine between wm and wi.
fn half_vector_jacobian(cos_m: f32) -> f32 {
    // Lecture, "Relating Half-Angle to Outgoing Change".
    return 1.0 / (4.0 * cos_m);
}

// Density of facet_sample, per solid angle of wm; cos_o is the cosine between wm and wo.
fn facet_pdf(bsdf: Bsdf, wo: vec3<f32>, wm: vec3<f32>, cos_o: f32) -> f32 {
    if is_ggx(bsdf) || bsdf.distribution == DISTRIBUTION_BECKMANN {
        return G1_smith(bsdf, wo) * facet_D(bsdf, wm) * cos_o / wo.z;
    }
    return facet_D(bsdf, wm) * max(wm.z, 0.0);
}

// A facet normal: of the visible ones where the distribution has them in closed form.
fn facet_sample(bsdf: Bsdf, wo: vec3<f32>, u: vec2<f32>) -> vec3<f32> {
    if is_ggx(bsdf) {
        return sample_visible_ggx(wo, facet_alpha(bsdf), u);
    }
    if bsdf.distribution == DISTRIBUTION_BECKMANN {
        return sample_visible_beckmann(wo, facet_alpha(bsdf), u);
    }
    return sample_exponential(facet_exponents(bsdf), u);
}

// Density of mirror_sample's mirrored direction, per its own solid angle.
fn mirror_pdf(bsdf: Bsdf, wo: vec3<f32>, wm: vec3<f32>, cos_m: f32) -> f32 {
    if is_ggx(bsdf) {
        return pdf_bounded_visible_ggx(wo, facet_alpha(bsdf), facet_D(bsdf, wm));
    }
    return facet_pdf(bsdf, wo, wm, cos_m) * half_vector_jacobian(cos_m);
}

// A facet normal for those who only reflect there.
fn mirror_sample(bsdf: Bsdf, wo: vec3<f32>, u: vec2<f32>) -> vec3<f32> {
    if is_ggx(bsdf) {
        return sample_bounded_visible_ggx(wo, facet_alpha(bsdf), u);
    }
    return facet_sample(bsdf, wo, u);
}

// D G / (4 cos theta_o cos theta_i): all of the lobe but its colour.
fn mirror_shape(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>, wm: vec3<f32>, cos_m: f32) -> f32 {
    let G = facet_G2(bsdf, wo, wi, wm, cos_m, cos_m);
    return facet_D(bsdf, wm) * G / (4.0 * wo.z * wi.z);
}

// The same in x and the density of wi in y.
fn torrance_sparrow_shape(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>, wm: vec3<f32>, cos_m: f32) -> vec2<f32> {
    return vec2(mirror_shape(bsdf, wo, wi, wm, cos_m), mirror_pdf(bsdf, wo, wm, cos_m));
}

fn torrance_sparrow_eval(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    // Lecture, "Torrance-Sparrow"; Torrance and Sparrow 1967, "Theory for Off-Specular Reflection From
    // Roughened Surfaces". With MASKING_NONE it is the lecture's formula, which can reflect more than
    // it receives at grazing angles.
    if !is_reflected(wo, wi) {
        return no_eval();
    }
    let wm = half_vector(wo, wi);
    let shape = torrance_sparrow_shape(bsdf, wo, wi, wm.xyz, wm.w);
    return BsdfEval(bsdf.reflectance * fresnel_F(bsdf, wm.w) * shape.x, shape.y);
}

fn torrance_sparrow_sample(bsdf: Bsdf, wo: vec3<f32>, u: vec2<f32>) -> BsdfSample {
    if wo.z < MIN_COS {
        return no_sample();
    }
    let wi = reflection_direction(wo, mirror_sample(bsdf, wo, u));
    return sample_of(wi, torrance_sparrow_eval(bsdf, wo, wi));
}
