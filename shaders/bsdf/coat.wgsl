// A clear layer over everything else (KHR_materials_clearcoat): isotropic GGX facets of index 1.5, with
// a normal of their own. What it reflects is missing below, whatever is there.

import package::shared::{Bsdf, GLTF_INSIDE, DISTRIBUTION_GGX, MASKING_SMITH};
import package::variant::{COAT};
import package::math::{sqr, Basis, basis_from_normal, to_local, to_world};
import package::bsdf::lobe::{BsdfEval, BsdfSample, no_eval, no_sample, is_reflected, DELTA, MIN_COS};
import package::bsdf::fresnel::{schlick_weight};
import package::bsdf::distribution::{is_smooth};
import package::bsdf::specular::{reflection_direction};
import package::bsdf::torrance_sparrow::{half_vector, mirror_sample, torrance_sparrow_shape};
import package::bsdf::albedo::{albedo_ggx};

// KHR_materials_clearcoat: an index of 1.5.
const COAT_F0: f32 = 0.04;

fn is_coated(bsdf: Bsdf) -> bool {
    return COAT && bsdf.gltf.coat > 0.0 && (bsdf.gltf.flags & GLTF_INSIDE) == 0u;
}

// The coat's facets.
fn coat_facets(bsdf: Bsdf) -> Bsdf {
    var coat = bsdf;
    coat.distribution = DISTRIBUTION_GGX;
    coat.masking = MASKING_SMITH;
    coat.alpha = vec2(sqr(bsdf.gltf.coat_roughness));
    return coat;
}

fn coat_F(cos_theta: f32) -> f32 {
    return COAT_F0 + (1.0 - COAT_F0) * schlick_weight(cos_theta);
}

// What the coat reflects of the light from wo, its own strength included. Seen from behind its own
// normal it is seen edge on.
fn coat_albedo(bsdf: Bsdf, wo: vec3<f32>) -> f32 {
    let cos_theta = max(dot(wo, bsdf.gltf.coat_normal), MIN_COS);
    let E = albedo_ggx(cos_theta, bsdf.gltf.coat_roughness, is_smooth(coat_facets(bsdf)));
    return bsdf.gltf.coat * (COAT_F0 * E.x + E.y);
}

// f without the cosine of the surface's normal, and the density of coat_sample; 0 for a delta.
fn coat_eval(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    let coat = coat_facets(bsdf);
    let basis = basis_from_normal(bsdf.gltf.coat_normal);
    let coat_wo = to_local(basis, wo);
    let coat_wi = to_local(basis, wi);
    if is_smooth(coat) || !is_reflected(wo, wi) || !is_reflected(coat_wo, coat_wi) {
        return no_eval();
    }
    let wm = half_vector(coat_wo, coat_wi);
    let shape = torrance_sparrow_shape(coat, coat_wo, coat_wi, wm.xyz, wm.w);
    // The coat receives by its own cosine.
    let f = bsdf.gltf.coat * coat_F(wm.w) * shape.x * (coat_wi.z / wi.z);
    return BsdfEval(vec3(f), shape.y);
}

// A direction that the coat reflects, drawn with density 1 or, of a delta, with f.
fn coat_sample(bsdf: Bsdf, wo: vec3<f32>, u: vec2<f32>) -> BsdfSample {
    let coat = coat_facets(bsdf);
    let basis = basis_from_normal(bsdf.gltf.coat_normal);
    let coat_wo = to_local(basis, wo);
    if coat_wo.z < MIN_COS {
        return no_sample();
    }
    if is_smooth(coat) {
        let wi = reflection_direction(wo, bsdf.gltf.coat_normal);
        if wi.z < MIN_COS {
            return no_sample();
        }
        return BsdfSample(wi, vec3(bsdf.gltf.coat * coat_F(coat_wo.z) / wi.z), 1.0, DELTA);
    }
    let coat_wi = reflection_direction(coat_wo, mirror_sample(coat, coat_wo, u));
    if coat_wi.z < MIN_COS {
        return no_sample();
    }
    return BsdfSample(to_world(basis, coat_wi), vec3(0.0), 1.0, 0u);
}
