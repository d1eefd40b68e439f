//! A clear layer over everything else (`KHR_materials_clearcoat`): isotropic GGX facets of index 1.5, with
//! a normal of their own. What it reflects is missing below, whatever is there.

use super::Bsdf;
use super::albedo::albedo_ggx;
use super::distribution::is_smooth;
use super::fresnel::schlick_weight;
use super::lobe::{BsdfEval, BsdfSample, DELTA, MIN_COS, is_reflected, no_eval, no_sample};
use super::specular::reflection_direction;
use super::torrance_sparrow::{half_vector, mirror_sample, torrance_sparrow_shape};
use crate::cpu::math::{basis_from_normal, sqr, to_local, to_world};
use crate::shared::{DISTRIBUTION_GGX, GLTF_INSIDE, MASKING_SMITH, Tables};
use glam::{DVec2, DVec3};

/// `KHR_materials_clearcoat`: an index of 1.5.
pub const COAT_F0: f64 = 0.04;

pub fn is_coated(bsdf: &Bsdf) -> bool {
    bsdf.gltf.coat > 0.0 && bsdf.gltf.flags & GLTF_INSIDE == 0
}

/// The coat's facets.
pub fn coat_facets(bsdf: &Bsdf) -> Bsdf {
    Bsdf {
        distribution: DISTRIBUTION_GGX,
        masking: MASKING_SMITH,
        alpha: DVec2::splat(sqr(bsdf.gltf.coat_roughness)),
        ..*bsdf
    }
}

pub fn coat_F(cos_theta: f64) -> f64 {
    COAT_F0 + (1.0 - COAT_F0) * schlick_weight(cos_theta)
}

/// What the coat reflects of the light from wo, its own strength included. Seen from behind its own
/// normal it is seen edge on.
pub fn coat_albedo(tables: &Tables, bsdf: &Bsdf, wo: DVec3) -> f64 {
    let cos_theta = wo.dot(bsdf.gltf.coat_normal).max(MIN_COS);
    let smooth_lobe = is_smooth(&coat_facets(bsdf));
    let E = albedo_ggx(tables, cos_theta, bsdf.gltf.coat_roughness, smooth_lobe);
    bsdf.gltf.coat * (COAT_F0 * E.x + E.y)
}

/// f without the cosine of the surface's normal, and the density of `coat_sample`; 0 for a delta.
pub fn coat_eval(bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> BsdfEval {
    let coat = coat_facets(bsdf);
    let basis = basis_from_normal(bsdf.gltf.coat_normal);
    let coat_wo = to_local(basis, wo);
    let coat_wi = to_local(basis, wi);
    if is_smooth(&coat) || !is_reflected(wo, wi) || !is_reflected(coat_wo, coat_wi) {
        return no_eval();
    }
    let wm = half_vector(coat_wo, coat_wi);
    let shape = torrance_sparrow_shape(&coat, coat_wo, coat_wi, wm.truncate(), wm.w);
    // The coat receives by its own cosine.
    let f = bsdf.gltf.coat * coat_F(wm.w) * shape.x * (coat_wi.z / wi.z);
    BsdfEval {
        f: DVec3::splat(f),
        pdf: shape.y,
    }
}

/// A direction that the coat reflects, drawn with density 1 or, of a delta, with f.
pub fn coat_sample(bsdf: &Bsdf, wo: DVec3, u: DVec2) -> BsdfSample {
    let coat = coat_facets(bsdf);
    let basis = basis_from_normal(bsdf.gltf.coat_normal);
    let coat_wo = to_local(basis, wo);
    if coat_wo.z < MIN_COS {
        return no_sample();
    }
    if is_smooth(&coat) {
        let wi = reflection_direction(wo, bsdf.gltf.coat_normal);
        if wi.z < MIN_COS {
            return no_sample();
        }
        return BsdfSample {
            wi,
            f: DVec3::splat(bsdf.gltf.coat * coat_F(coat_wo.z) / wi.z),
            pdf: 1.0,
            delta: DELTA,
        };
    }
    let coat_wi = reflection_direction(coat_wo, mirror_sample(&coat, coat_wo, u));
    if coat_wi.z < MIN_COS {
        return no_sample();
    }
    BsdfSample {
        wi: to_world(basis, coat_wi),
        f: DVec3::ZERO,
        pdf: 1.0,
        delta: 0,
    }
}
