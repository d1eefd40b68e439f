// Any reflection model: what it reflects and transmits, and how it is sampled.
//
// wo and wi are in the local frame. A wo below the surface is the mirror image of one above it, with
// wi mirrored too; eta of a dielectric is always the far side's index over the near side's, seen from wo.

import package::shared::{Bsdf, BSDF_LAMBERTIAN, BSDF_OREN_NAYAR, BSDF_OREN_NAYAR_EON, BSDF_SPECULAR_REFLECTION, BSDF_SPECULAR_TRANSMISSION, BSDF_DIELECTRIC, BSDF_ROUGH_DIELECTRIC, BSDF_TORRANCE_SPARROW, BSDF_GLTF};
import package::variant::{HAS_OREN_NAYAR, HAS_SPECULAR, HAS_ROUGH_DIELECTRIC, HAS_TORRANCE_SPARROW, HAS_GLTF, HAS_OTHER_MODELS};
import package::sample::{sample_cosine_hemisphere, pdf_cosine_hemisphere};
import package::bsdf::lobe::{BsdfEval, BsdfSample, EvalAndSample, no_eval, no_sample, sample_of, is_reflected, mirrored};
import package::bsdf::specular::{specular_reflection_sample, specular_transmission_sample};
import package::bsdf::lambertian::{f_lambertian};
import package::bsdf::oren_nayar::{f_oren_nayar, f_oren_nayar_eon};
import package::bsdf::distribution::{is_smooth};
import package::bsdf::torrance_sparrow::{torrance_sparrow_eval, torrance_sparrow_sample};
import package::bsdf::dielectric::{is_smooth_dielectric, smooth_dielectric_sample, rough_dielectric_eval, rough_dielectric_sample};
import package::bsdf::gltf::{gltf_is_delta, gltf_transmits, gltf_eval, gltf_sample, gltf_eval_and_sample, gltf_straight_transmittance};

// Whether the model has nothing but deltas, so that no light can be sampled for it.
fn bsdf_is_delta(bsdf: Bsdf) -> bool {
    if HAS_GLTF && (!HAS_OTHER_MODELS || bsdf.model == BSDF_GLTF) {
        return gltf_is_delta(bsdf);
    }
    if !HAS_SPECULAR && !HAS_ROUGH_DIELECTRIC && !HAS_TORRANCE_SPARROW {
        return false;
    }
    switch bsdf.model {
        case BSDF_SPECULAR_REFLECTION, BSDF_SPECULAR_TRANSMISSION, BSDF_DIELECTRIC: {
            return true;
        }
        case BSDF_ROUGH_DIELECTRIC: {
            return is_smooth_dielectric(bsdf);
        }
        case BSDF_TORRANCE_SPARROW: {
            return is_smooth(bsdf);
        }
        default: {
            return false;
        }
    }
}

// Whether light from the other side may come through.
fn bsdf_transmits(bsdf: Bsdf) -> bool {
    if HAS_GLTF && (!HAS_OTHER_MODELS || bsdf.model == BSDF_GLTF) {
        return gltf_transmits(bsdf);
    }
    return HAS_ROUGH_DIELECTRIC && bsdf.model == BSDF_ROUGH_DIELECTRIC;
}

// A diffuse model's answer.
fn diffuse_eval(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    if !is_reflected(wo, wi) {
        return no_eval();
    }
    var f = f_lambertian(bsdf.reflectance);
    if HAS_OREN_NAYAR && bsdf.model == BSDF_OREN_NAYAR {
        f = f_oren_nayar(bsdf.reflectance, bsdf.roughness, wo, wi);
    } else if HAS_OREN_NAYAR && bsdf.model == BSDF_OREN_NAYAR_EON {
        f = f_oren_nayar_eon(bsdf.reflectance, bsdf.roughness, wo, wi);
    }
    return BsdfEval(f, pdf_cosine_hemisphere(wi.z));
}

// f and the density with which bsdf_sample finds wi, deltas left out: both 0 for pure deltas.
fn bsdf_eval(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    // One call for both sides: a driver puts a copy of all models in the place of each.
    let below = wo.z < 0.0;
    return bsdf_eval_above(bsdf, select(wo, mirrored(wo), below), select(wi, mirrored(wi), below));
}

fn bsdf_eval_above(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    if bsdf_is_delta(bsdf) {
        return no_eval();
    }
    if HAS_GLTF && (!HAS_OTHER_MODELS || bsdf.model == BSDF_GLTF) {
        return gltf_eval(bsdf, wo, wi);
    }
    return other_eval(bsdf, wo, wi);
}

// Of the models that are not glTF's.
fn other_eval(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    switch bsdf.model {
        case BSDF_LAMBERTIAN, BSDF_OREN_NAYAR, BSDF_OREN_NAYAR_EON: {
            return diffuse_eval(bsdf, wo, wi);
        }
        case BSDF_ROUGH_DIELECTRIC: {
            if HAS_ROUGH_DIELECTRIC {
                return rough_dielectric_eval(bsdf, wo, wi);
            }
            return no_eval();
        }
        case BSDF_TORRANCE_SPARROW: {
            if HAS_TORRANCE_SPARROW {
                return torrance_sparrow_eval(bsdf, wo, wi);
            }
            return no_eval();
        }
        default: { // BSDF_UNLIT
            return no_eval();
        }
    }
}

// A direction of light for wo: u.x picks the lobe, u.yz the direction in it.
fn bsdf_sample(bsdf: Bsdf, wo: vec3<f32>, u: vec3<f32>) -> BsdfSample {
    let below = wo.z < 0.0;
    let above = bsdf_sample_above(bsdf, select(wo, mirrored(wo), below), u);
    return BsdfSample(select(above.wi, mirrored(above.wi), below), above.f, above.pdf, above.delta);
}

fn bsdf_sample_above(bsdf: Bsdf, wo: vec3<f32>, u: vec3<f32>) -> BsdfSample {
    if HAS_GLTF && (!HAS_OTHER_MODELS || bsdf.model == BSDF_GLTF) {
        return gltf_sample(bsdf, wo, u);
    }
    return other_sample(bsdf, wo, u);
}

fn other_sample(bsdf: Bsdf, wo: vec3<f32>, u: vec3<f32>) -> BsdfSample {
    switch bsdf.model {
        case BSDF_LAMBERTIAN, BSDF_OREN_NAYAR, BSDF_OREN_NAYAR_EON: {
            let wi = sample_cosine_hemisphere(u.yz);
            return sample_of(wi, diffuse_eval(bsdf, wo, wi));
        }
        case BSDF_SPECULAR_REFLECTION: {
            if !HAS_SPECULAR {
                return no_sample();
            }
            return specular_reflection_sample(bsdf, wo);
        }
        case BSDF_SPECULAR_TRANSMISSION: {
            if !HAS_SPECULAR {
                return no_sample();
            }
            return specular_transmission_sample(bsdf, wo);
        }
        case BSDF_DIELECTRIC: {
            if !HAS_SPECULAR {
                return no_sample();
            }
            return smooth_dielectric_sample(bsdf, wo, u.x);
        }
        case BSDF_ROUGH_DIELECTRIC: {
            if !HAS_ROUGH_DIELECTRIC {
                return no_sample();
            }
            if is_smooth_dielectric(bsdf) {
                return smooth_dielectric_sample(bsdf, wo, u.x);
            }
            return rough_dielectric_sample(bsdf, wo, u);
        }
        case BSDF_TORRANCE_SPARROW: {
            if !HAS_TORRANCE_SPARROW {
                return no_sample();
            }
            if is_smooth(bsdf) {
                return specular_reflection_sample(bsdf, wo);
            }
            return torrance_sparrow_sample(bsdf, wo, u.yz);
        }
        default: { // BSDF_UNLIT
            return no_sample();
        }
    }
}

// bsdf_eval for wi, which is 0 where there is none, and bsdf_sample by u.
fn bsdf_eval_and_sample(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>, u: vec3<f32>) -> EvalAndSample {
    let below = wo.z < 0.0;
    let wo_above = select(wo, mirrored(wo), below);
    let wi_above = select(wi, mirrored(wi), below);
    var both: EvalAndSample;
    if HAS_GLTF && (!HAS_OTHER_MODELS || bsdf.model == BSDF_GLTF) {
        both = gltf_eval_and_sample(bsdf, wo_above, wi_above, u);
    } else {
        if !bsdf_is_delta(bsdf) {
            both.eval = other_eval(bsdf, wo_above, wi_above);
        }
        both.sample = other_sample(bsdf, wo_above, u);
    }
    both.sample.wi = select(both.sample.wi, mirrored(both.sample.wi), below);
    return both;
}

// What of the light from straight behind the surface goes on to wo unbent: that of smooth thin walls, and
// the mean of the samples that are DELTA_STRAIGHT. 0 of all else.
fn straight_transmittance(bsdf: Bsdf, wo: vec3<f32>) -> vec3<f32> {
    if HAS_GLTF && bsdf.model == BSDF_GLTF {
        return gltf_straight_transmittance(bsdf, vec3(wo.xy, abs(wo.z)));
    }
    return vec3(0.0);
}
