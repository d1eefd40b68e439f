//! glTF's material, energy-sound. reflectance is base colour * (1 - metallic), eta is F0 mixed between
//! dielectric and base colour, k.x the dielectric part's own F0, alpha roughness^2 twice.
//!
//! glTF 2.0 appendix B adds diffuse and specular by fresnel_mix, 1 - F(wo . wm) of the diffuse part: that
//! is not reciprocal in energy and exceeds 1 in a white furnace. Here the diffuse part gets what the
//! dielectric's specular lobe leaves over on the way in and on the way out (Kelemen and Szirmay-Kalos
//! 2001, "A Microfacet Based Coupled Specular-Matte BRDF Model with Importance Sampling", eq. 14).

use super::Bsdf;
use super::albedo::{albedo_average_ggx, albedo_ggx};
use super::distribution::is_smooth;
use super::fresnel::fresnel_F;
use super::lobe::{BsdfEval, BsdfSample, MIN_COS, is_reflected, no_eval, no_sample, sample_of};
use super::specular::reflection_direction;
use super::torrance_sparrow::{facet_sample, half_vector, torrance_sparrow_shape};
use crate::cpu::math::{INV_PI, luminance};
use crate::cpu::sample::{pdf_cosine_hemisphere, sample_cosine_hemisphere};
use crate::shared::Tables;
use glam::{DVec2, DVec3};

/// Where both lobes exist, neither is chosen less often than this: a lobe can be brighter than its
/// mean over directions, and weights stay bounded.
pub const LOBE_PROBABILITY_MIN: f64 = 0.1;
/// What the diffuse part divides by at least; only a dielectric that reflects everything gets there.
pub const DIFFUSE_AVERAGE_MIN: f64 = 1e-4;

/// What the dielectric's lobe leaves over, 1 - E.
pub fn diffuse_share(tables: &Tables, bsdf: &Bsdf, cos_theta: f64) -> f64 {
    let E = albedo_ggx(tables, cos_theta, bsdf.roughness, is_smooth(bsdf));
    (1.0 - (bsdf.k.x * E.x + E.y)).max(0.0)
}

/// f of the diffuse part.
pub fn f_metallic_roughness_diffuse(tables: &Tables, bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> DVec3 {
    let average = albedo_average_ggx(tables, bsdf.roughness, is_smooth(bsdf));
    let share_average = (1.0 - (bsdf.k.x * average.x + average.y)).max(DIFFUSE_AVERAGE_MIN);
    let shares = diffuse_share(tables, bsdf, wo.z) * diffuse_share(tables, bsdf, wi.z);
    bsdf.reflectance * (INV_PI * shares / share_average)
}

/// Probability of sampling the specular part: its share of what is reflected towards wo.
pub fn specular_probability(tables: &Tables, bsdf: &Bsdf, wo: DVec3) -> f64 {
    let E = albedo_ggx(tables, wo.z, bsdf.roughness, is_smooth(bsdf));
    let specular = luminance(bsdf.eta * E.x + E.y);
    let diffuse = luminance(bsdf.reflectance) * diffuse_share(tables, bsdf, wo.z);
    if luminance(bsdf.reflectance) <= 0.0 {
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
        f += fresnel_F(bsdf, wm.w) * shape.x;
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
                f: fresnel_F(bsdf, wo.z) / wo.z,
                pdf: p,
                delta: 1,
            };
        }
        wi = reflection_direction(wo, facet_sample(bsdf, wo, u_direction));
    }
    sample_of(wi, metallic_roughness_eval(tables, bsdf, wo, wi))
}
