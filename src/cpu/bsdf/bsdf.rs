//! Any reflection model: what it reflects and transmits, and how it is sampled.
//!
//! wo and wi are in the local frame. A wo below the surface is the mirror image of one above it, with
//! wi mirrored too; eta of a dielectric is always the far side's index over the near side's, seen from wo.

use super::Bsdf;
use super::dielectric::{
    is_smooth_dielectric, rough_dielectric_eval, rough_dielectric_sample, smooth_dielectric_sample,
};
use super::distribution::is_smooth;
use super::gltf::{
    gltf_eval, gltf_eval_and_sample, gltf_is_delta, gltf_sample, gltf_straight_transmittance,
    gltf_transmits,
};
use super::lambertian::f_lambertian;
use super::lobe::{
    BsdfEval, BsdfSample, EvalAndSample, is_reflected, mirrored, no_eval, no_sample, sample_of,
};
use super::oren_nayar::{f_oren_nayar, f_oren_nayar_eon};
use super::specular::{specular_reflection_sample, specular_transmission_sample};
use super::torrance_sparrow::{torrance_sparrow_eval, torrance_sparrow_sample};
use crate::cpu::sample::{pdf_cosine_hemisphere, sample_cosine_hemisphere};
use crate::shared::{
    BSDF_DIELECTRIC, BSDF_GLTF, BSDF_LAMBERTIAN, BSDF_OREN_NAYAR, BSDF_OREN_NAYAR_EON,
    BSDF_ROUGH_DIELECTRIC, BSDF_SPECULAR_REFLECTION, BSDF_SPECULAR_TRANSMISSION,
    BSDF_TORRANCE_SPARROW, Tables,
};
use glam::{DVec2, DVec3};

/// Whether the model has nothing but deltas, so that no light can be sampled for it.
pub fn bsdf_is_delta(bsdf: &Bsdf) -> bool {
    match bsdf.model {
        BSDF_SPECULAR_REFLECTION | BSDF_SPECULAR_TRANSMISSION | BSDF_DIELECTRIC => true,
        BSDF_ROUGH_DIELECTRIC => is_smooth_dielectric(bsdf),
        BSDF_TORRANCE_SPARROW => is_smooth(bsdf),
        BSDF_GLTF => gltf_is_delta(bsdf),
        _ => false,
    }
}

/// Whether light from the other side may come through.
pub fn bsdf_transmits(bsdf: &Bsdf) -> bool {
    if bsdf.model == BSDF_GLTF {
        return gltf_transmits(bsdf);
    }
    bsdf.model == BSDF_ROUGH_DIELECTRIC
}

/// A diffuse model's answer.
pub fn diffuse_eval(bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> BsdfEval {
    if !is_reflected(wo, wi) {
        return no_eval();
    }
    let f = match bsdf.model {
        BSDF_OREN_NAYAR => f_oren_nayar(bsdf.reflectance, bsdf.roughness, wo, wi),
        BSDF_OREN_NAYAR_EON => f_oren_nayar_eon(bsdf.reflectance, bsdf.roughness, wo, wi),
        _ => f_lambertian(bsdf.reflectance),
    };
    BsdfEval {
        f,
        pdf: pdf_cosine_hemisphere(wi.z),
    }
}

/// f and the density with which `bsdf_sample` finds wi, deltas left out: both 0 for pure deltas.
pub fn bsdf_eval(tables: &Tables, bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> BsdfEval {
    if wo.z < 0.0 {
        return bsdf_eval_above(tables, bsdf, mirrored(wo), mirrored(wi));
    }
    bsdf_eval_above(tables, bsdf, wo, wi)
}

pub fn bsdf_eval_above(tables: &Tables, bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> BsdfEval {
    if bsdf_is_delta(bsdf) {
        return no_eval();
    }
    if bsdf.model == BSDF_GLTF {
        return gltf_eval(tables, bsdf, wo, wi);
    }
    other_eval(bsdf, wo, wi)
}

/// Of the models that are not glTF's.
pub fn other_eval(bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> BsdfEval {
    match bsdf.model {
        BSDF_LAMBERTIAN | BSDF_OREN_NAYAR | BSDF_OREN_NAYAR_EON => diffuse_eval(bsdf, wo, wi),
        BSDF_ROUGH_DIELECTRIC => rough_dielectric_eval(bsdf, wo, wi),
        BSDF_TORRANCE_SPARROW => torrance_sparrow_eval(bsdf, wo, wi),
        _ => no_eval(), // BSDF_UNLIT
    }
}

/// A direction of light for wo: u.x picks the lobe, u.yz the direction in it.
pub fn bsdf_sample(tables: &Tables, bsdf: &Bsdf, wo: DVec3, u: DVec3) -> BsdfSample {
    if wo.z < 0.0 {
        let below = bsdf_sample_above(tables, bsdf, mirrored(wo), u);
        return BsdfSample {
            wi: mirrored(below.wi),
            ..below
        };
    }
    bsdf_sample_above(tables, bsdf, wo, u)
}

pub fn bsdf_sample_above(tables: &Tables, bsdf: &Bsdf, wo: DVec3, u: DVec3) -> BsdfSample {
    if bsdf.model == BSDF_GLTF {
        return gltf_sample(tables, bsdf, wo, u);
    }
    other_sample(bsdf, wo, u)
}

pub fn other_sample(bsdf: &Bsdf, wo: DVec3, u: DVec3) -> BsdfSample {
    let u_direction = DVec2::new(u.y, u.z);
    match bsdf.model {
        BSDF_LAMBERTIAN | BSDF_OREN_NAYAR | BSDF_OREN_NAYAR_EON => {
            let wi = sample_cosine_hemisphere(u_direction);
            sample_of(wi, diffuse_eval(bsdf, wo, wi))
        }
        BSDF_SPECULAR_REFLECTION => specular_reflection_sample(bsdf, wo),
        BSDF_SPECULAR_TRANSMISSION => specular_transmission_sample(bsdf, wo),
        BSDF_DIELECTRIC => smooth_dielectric_sample(bsdf, wo, u.x),
        BSDF_ROUGH_DIELECTRIC => {
            if is_smooth_dielectric(bsdf) {
                return smooth_dielectric_sample(bsdf, wo, u.x);
            }
            rough_dielectric_sample(bsdf, wo, u)
        }
        BSDF_TORRANCE_SPARROW => {
            if is_smooth(bsdf) {
                return specular_reflection_sample(bsdf, wo);
            }
            torrance_sparrow_sample(bsdf, wo, u_direction)
        }
        _ => no_sample(), // BSDF_UNLIT
    }
}

/// `bsdf_eval` for `wi`, where there is one, and `bsdf_sample` by `u`.
pub fn bsdf_eval_and_sample(
    tables: &Tables,
    bsdf: &Bsdf,
    wo: DVec3,
    wi: Option<DVec3>,
    u: DVec3,
) -> EvalAndSample {
    let upright = |w: DVec3| if wo.z < 0.0 { mirrored(w) } else { w };
    let wo_above = upright(wo);
    let wi_above = wi.map(upright);
    let mut both;
    if bsdf.model == BSDF_GLTF {
        both = gltf_eval_and_sample(tables, bsdf, wo_above, wi_above, u);
    } else {
        both = EvalAndSample {
            eval: no_eval(),
            sample: other_sample(bsdf, wo_above, u),
        };
        if let Some(wi) = wi_above.filter(|_| !bsdf_is_delta(bsdf)) {
            both.eval = other_eval(bsdf, wo_above, wi);
        }
    }
    both.sample.wi = upright(both.sample.wi);
    both
}

/// What of the light from straight behind the surface goes on to wo unbent: that of smooth thin walls,
/// and the mean of the samples that are `DELTA_STRAIGHT`. 0 of all else.
pub fn straight_transmittance(tables: &Tables, bsdf: &Bsdf, wo: DVec3) -> DVec3 {
    if bsdf.model == BSDF_GLTF {
        return gltf_straight_transmittance(tables, bsdf, wo.with_z(wo.z.abs()));
    }
    DVec3::ZERO
}
