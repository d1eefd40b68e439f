// glTF's material, energy-sound: a dielectric and a metal, mixed.
//
// glTF 2.0 appendix B adds diffuse and specular by fresnel_mix, 1 - F(wo . wm) of the diffuse part: that
// is not reciprocal in energy and exceeds 1 in a white furnace. Here the diffuse part gets what the
// dielectric's specular lobe leaves over on the way in and on the way out (Kelemen and Szirmay-Kalos
// 2001, "A Microfacet Based Coupled Specular-Matte BRDF Model with Importance Sampling", eq. 14).

import package::shared::{Bsdf};
import package::math::{INV_PI, luminance};
import package::sample::{sample_cosine_hemisphere, pdf_cosine_hemisphere};
import package::bsdf::lobe::{BsdfEval, BsdfSample, no_eval, no_sample, sample_of, is_reflected, MIN_COS};
import package::bsdf::albedo::{albedo_ggx, albedo_average_ggx};
import package::bsdf::fresnel::{schlick_weight};
import package::bsdf::distribution::{is_smooth};
import package::bsdf::specular::{specular_reflection_sample, reflection_direction};
import package::bsdf::torrance_sparrow::{half_vector, mirror_sample, torrance_sparrow_shape};

// Where both lobes exist, neither is chosen less often than this: a lobe can be brighter than its
// mean over directions, and weights stay bounded.
const LOBE_PROBABILITY_MIN: f32 = 0.1;
// What the diffuse part divides by at least; only a dielectric that reflects everything gets there.
const DIFFUSE_AVERAGE_MIN: f32 = 1e-4;

// Reflectance of a facet: Schlick's form, its ends mixed between dielectric and metal.
fn F_gltf(bsdf: Bsdf, cos_theta: f32) -> vec3<f32> {
    let F0 = mix(bsdf.gltf.F0, bsdf.reflectance, bsdf.gltf.metallic);
    let F90 = mix(bsdf.gltf.F90, 1.0, bsdf.gltf.metallic);
    return F0 + (F90 - F0) * schlick_weight(cos_theta);
}

// What the dielectric's lobe leaves over, 1 - E.
fn diffuse_share(bsdf: Bsdf, cos_theta: f32) -> vec3<f32> {
    let E = albedo_ggx(cos_theta, bsdf.roughness, is_smooth(bsdf));
    return max(vec3(0.0), 1.0 - (bsdf.gltf.F0 * E.x + bsdf.gltf.F90 * E.y));
}

// f of the diffuse part.
fn f_metallic_roughness_diffuse(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    let average = albedo_average_ggx(bsdf.roughness, is_smooth(bsdf));
    let share_average = max(1.0 - (bsdf.gltf.F0 * average.x + bsdf.gltf.F90 * average.y), vec3(DIFFUSE_AVERAGE_MIN));
    let shares = diffuse_share(bsdf, wo.z) * diffuse_share(bsdf, wi.z) / share_average;
    return bsdf.reflectance * (1.0 - bsdf.gltf.metallic) * INV_PI * shares;
}

// Probability of sampling the specular part: its share of what is reflected towards wo.
fn specular_probability(bsdf: Bsdf, wo: vec3<f32>) -> f32 {
    let E = albedo_ggx(wo.z, bsdf.roughness, is_smooth(bsdf));
    let F0 = mix(bsdf.gltf.F0, bsdf.reflectance, bsdf.gltf.metallic);
    let F90 = mix(bsdf.gltf.F90, 1.0, bsdf.gltf.metallic);
    let specular = luminance(F0 * E.x + F90 * E.y);
    let diffuse = luminance(bsdf.reflectance * (1.0 - bsdf.gltf.metallic) * diffuse_share(bsdf, wo.z));
    if diffuse <= 0.0 {
        return 1.0;
    }
    return clamp(specular / (specular + diffuse), LOBE_PROBABILITY_MIN, 1.0 - LOBE_PROBABILITY_MIN);
}

// The parts that are no delta; the pdf is that of metallic_roughness_sample, lobe's choice included.
fn metallic_roughness_eval(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    if !is_reflected(wo, wi) {
        return no_eval();
    }
    let p = specular_probability(bsdf, wo);
    var f = f_metallic_roughness_diffuse(bsdf, wo, wi);
    var pdf = (1.0 - p) * pdf_cosine_hemisphere(wi.z);
    if !is_smooth(bsdf) {
        let wm = half_vector(wo, wi);
        let shape = torrance_sparrow_shape(bsdf, wo, wi, wm.xyz, wm.w);
        f += F_gltf(bsdf, wm.w) * shape.x;
        pdf += p * shape.y;
    }
    return BsdfEval(f, pdf);
}

fn metallic_roughness_sample(bsdf: Bsdf, wo: vec3<f32>, u: vec3<f32>) -> BsdfSample {
    if wo.z < MIN_COS {
        return no_sample();
    }
    let p = specular_probability(bsdf, wo);
    var wi = sample_cosine_hemisphere(u.yz);
    if u.x < p {
        if is_smooth(bsdf) {
            return BsdfSample(vec3(-wo.x, -wo.y, wo.z), F_gltf(bsdf, wo.z) / wo.z, p, 1u);
        }
        wi = reflection_direction(wo, mirror_sample(bsdf, wo, u.yz));
    }
    return sample_of(wi, metallic_roughness_eval(bsdf, wo, wi));
}
