//! glTF's material, energy-sound: a dielectric and a metal, mixed.
//!
//! glTF 2.0 appendix B adds diffuse and specular by fresnel_mix, 1 - F(wo . wm) of the diffuse part: that
//! is not reciprocal in energy and exceeds 1 in a white furnace. Here the diffuse part gets what the
//! dielectric's specular lobe leaves over on the way in and on the way out (Kelemen and Szirmay-Kalos
//! 2001, "A Microfacet Based Coupled Specular-Matte BRDF Model with Importance Sampling", eq. 14).

use super::Bsdf;
use super::albedo::{albedo_average_ggx, albedo_ggx};
use super::distribution::is_smooth;
use super::fresnel::schlick_weight;
use super::lobe::{BsdfEval, BsdfSample, MIN_COS, is_reflected, no_eval, no_sample, sample_of};
use super::specular::reflection_direction;
use super::torrance_sparrow::{half_vector, mirror_sample, torrance_sparrow_shape};
use crate::cpu::math::{INV_PI, luminance};
use crate::cpu::sample::{pdf_cosine_hemisphere, sample_cosine_hemisphere};
use crate::shared::Tables;
use glam::{DVec2, DVec3};

/// Where both lobes exist, neither is chosen less often than this: a lobe can be brighter than its
/// mean over directions, and weights stay bounded.
pub const LOBE_PROBABILITY_MIN: f64 = 0.1;
/// What the diffuse part divides by at least; only a dielectric that reflects everything gets there.
pub const DIFFUSE_AVERAGE_MIN: f64 = 1e-4;

/// Reflectance of a facet: Schlick's form, its ends mixed between dielectric and metal.
pub fn F_gltf(bsdf: &Bsdf, cos_theta: f64) -> DVec3 {
    let F0 = bsdf.gltf.F0.lerp(bsdf.reflectance, bsdf.gltf.metallic);
    let F90 = bsdf.gltf.F90 + (1.0 - bsdf.gltf.F90) * bsdf.gltf.metallic;
    F0 + (F90 - F0) * schlick_weight(cos_theta)
}

/// What the dielectric's lobe leaves over, 1 - E.
pub fn diffuse_share(tables: &Tables, bsdf: &Bsdf, cos_theta: f64) -> DVec3 {
    let E = albedo_ggx(tables, cos_theta, bsdf.roughness, is_smooth(bsdf));
    (1.0 - (bsdf.gltf.F0 * E.x + bsdf.gltf.F90 * E.y)).max(DVec3::ZERO)
}

/// f of the diffuse part.
pub fn f_metallic_roughness_diffuse(tables: &Tables, bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> DVec3 {
    let average = albedo_average_ggx(tables, bsdf.roughness, is_smooth(bsdf));
    let share_average = (1.0 - (bsdf.gltf.F0 * average.x + bsdf.gltf.F90 * average.y))
        .max(DVec3::splat(DIFFUSE_AVERAGE_MIN));
    let shares =
        diffuse_share(tables, bsdf, wo.z) * diffuse_share(tables, bsdf, wi.z) / share_average;
    bsdf.reflectance * (1.0 - bsdf.gltf.metallic) * INV_PI * shares
}

/// Probability of sampling the specular part: its share of what is reflected towards wo.
pub fn specular_probability(tables: &Tables, bsdf: &Bsdf, wo: DVec3) -> f64 {
    let E = albedo_ggx(tables, wo.z, bsdf.roughness, is_smooth(bsdf));
    let F0 = bsdf.gltf.F0.lerp(bsdf.reflectance, bsdf.gltf.metallic);
    let F90 = bsdf.gltf.F90 + (1.0 - bsdf.gltf.F90) * bsdf.gltf.metallic;
    let specular = luminance(F0 * E.x + F90 * E.y);
    let diffuse = luminance(
        bsdf.reflectance * (1.0 - bsdf.gltf.metallic) * diffuse_share(tables, bsdf, wo.z),
    );
    if diffuse <= 0.0 {
        return 1.0;
    }
    (specular / (specular + diffuse)).clamp(LOBE_PROBABILITY_MIN, 1.0 - LOBE_PROBABILITY_MIN)
}

/// The parts that are no delta; the pdf is that of `metallic_roughness_sample`, lobe's choice included.
pub fn metallic_roughness_eval(tables: &Tables, bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> BsdfEval {
    if !is_reflected(wo, wi) {
        return no_eval();
    }
    let p = specular_probability(tables, bsdf, wo);
    let mut f = f_metallic_roughness_diffuse(tables, bsdf, wo, wi);
    let mut pdf = (1.0 - p) * pdf_cosine_hemisphere(wi.z);
    if !is_smooth(bsdf) {
        let wm = half_vector(wo, wi);
        let shape = torrance_sparrow_shape(bsdf, wo, wi, wm.truncate(), wm.w);
        f += F_gltf(bsdf, wm.w) * shape.x;
        pdf += p * shape.y;
    }
    BsdfEval { f, pdf }
}

pub fn metallic_roughness_sample(tables: &Tables, bsdf: &Bsdf, wo: DVec3, u: DVec3) -> BsdfSample {
    if wo.z < MIN_COS {
        return no_sample();
    }
    let p = specular_probability(tables, bsdf, wo);
    let u_direction = DVec2::new(u.y, u.z);
    let mut wi = sample_cosine_hemisphere(u_direction);
    if u.x < p {
        if is_smooth(bsdf) {
            return BsdfSample {
                wi: DVec3::new(-wo.x, -wo.y, wo.z),
                f: F_gltf(bsdf, wo.z) / wo.z,
                pdf: p,
                delta: 1,
            };
        }
        wi = reflection_direction(wo, mirror_sample(bsdf, wo, u_direction));
    }
    sample_of(wi, metallic_roughness_eval(tables, bsdf, wo, wi))
}
