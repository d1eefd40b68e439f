// glTF's material, energy-sound. reflectance is base colour * (1 - metallic), eta is F0 mixed between
// dielectric and base colour, k.x the dielectric part's own F0, alpha roughness^2 twice.
//
// glTF 2.0 appendix B adds diffuse and specular by fresnel_mix, 1 - F(wo . wm) of the diffuse part: that
// is not reciprocal in energy and exceeds 1 in a white furnace. Here the diffuse part gets what the
// dielectric's specular lobe leaves over on the way in and on the way out (Kelemen and Szirmay-Kalos
// 2001, "A Microfacet Based Coupled Specular-Matte BRDF Model with Importance Sampling", eq. 14).

import package::shared::{Bsdf, ALBEDO_TABLE_SIZE};
import package::bindings::{tables};
import package::math::{INV_PI, luminance};
import package::sample::{sample_cosine_hemisphere, pdf_cosine_hemisphere};
import package::bsdf::lobe::{BsdfEval, BsdfSample, no_eval, no_sample, sample_of, is_reflected, MIN_COS};
import package::bsdf::fresnel::{schlick_weight};
import package::bsdf::distribution::{is_smooth};
import package::bsdf::specular::{specular_reflection_sample, reflection_direction};
import package::bsdf::torrance_sparrow::{facet_sample, half_vector, torrance_sparrow_shape};
import package::bsdf::fresnel::{fresnel_F};

// Where both lobes exist, neither is chosen less often than this: a lobe can be brighter than its
// mean over directions, and weights stay bounded.
const LOBE_PROBABILITY_MIN: f32 = 0.1;
// What the diffuse part divides by at least; only a dielectric that reflects everything gets there.
const DIFFUSE_AVERAGE_MIN: f32 = 1e-4;

// Where a cosine lies on the tables' columns, 0 to 1: see src/tables.rs.
fn albedo_column(cos_theta: f32, roughness: f32) -> f32 {
    let alpha = roughness * roughness;
    return 0.5 * (sqrt(cos_theta) + sqrt(cos_theta / (cos_theta + alpha * (1.0 - cos_theta))));
}

fn albedo_entry(row: u32, column: u32) -> vec2<f32> {
    let index = row * ALBEDO_TABLE_SIZE + column;
    let pair = tables.albedo[index / 2u];
    return select(pair.xy, pair.zw, (index & 1u) == 1u);
}

fn albedo_average_entry(row: u32) -> vec2<f32> {
    let pair = tables.albedo_average[row / 2u];
    return select(pair.xy, pair.zw, (row & 1u) == 1u);
}

// Directional albedo of the GGX lobe as factors of F0 and F90; of a mirror where the lobe is a delta.
fn albedo_ggx(cos_theta: f32, roughness: f32, smooth_lobe: bool) -> vec2<f32> {
    if smooth_lobe {
        let white = schlick_weight(cos_theta);
        return vec2(1.0 - white, white);
    }
    let last = f32(ALBEDO_TABLE_SIZE - 1u);
    let x = clamp(albedo_column(clamp(cos_theta, MIN_COS, 1.0), roughness), 0.0, 1.0) * last;
    let y = clamp(roughness, 0.0, 1.0) * last;
    let column = u32(min(floor(x), last - 1.0));
    let row = u32(min(floor(y), last - 1.0));
    let s = x - f32(column);
    let t = y - f32(row);
    let below = mix(albedo_entry(row, column), albedo_entry(row, column + 1u), s);
    let above = mix(albedo_entry(row + 1u, column), albedo_entry(row + 1u, column + 1u), s);
    return mix(below, above, t);
}

// The hemispherical average of the same.
fn albedo_average_ggx(roughness: f32, smooth_lobe: bool) -> vec2<f32> {
    if smooth_lobe {
        // 2 * integral of (1 - c)^5 c dc = 1 / 21.
        return vec2(20.0 / 21.0, 1.0 / 21.0);
    }
    let last = f32(ALBEDO_TABLE_SIZE - 1u);
    let y = clamp(roughness, 0.0, 1.0) * last;
    let row = u32(min(floor(y), last - 1.0));
    return mix(albedo_average_entry(row), albedo_average_entry(row + 1u), y - f32(row));
}

// What the dielectric's lobe leaves over, 1 - E.
fn diffuse_share(bsdf: Bsdf, cos_theta: f32) -> f32 {
    let E = albedo_ggx(cos_theta, bsdf.roughness, is_smooth(bsdf));
    return max(0.0, 1.0 - (bsdf.k.x * E.x + E.y));
}

// f of the diffuse part.
fn f_metallic_roughness_diffuse(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    let average = albedo_average_ggx(bsdf.roughness, is_smooth(bsdf));
    let share_average = max(1.0 - (bsdf.k.x * average.x + average.y), DIFFUSE_AVERAGE_MIN);
    return bsdf.reflectance * (INV_PI * diffuse_share(bsdf, wo.z) * diffuse_share(bsdf, wi.z) / share_average);
}

// Probability of sampling the specular part: its share of what is reflected towards wo.
fn specular_probability(bsdf: Bsdf, wo: vec3<f32>) -> f32 {
    let E = albedo_ggx(wo.z, bsdf.roughness, is_smooth(bsdf));
    let specular = luminance(bsdf.eta * E.x + E.y);
    let diffuse = luminance(bsdf.reflectance) * diffuse_share(bsdf, wo.z);
    if luminance(bsdf.reflectance) <= 0.0 {
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
        f += fresnel_F(bsdf, wm.w) * shape.x;
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
            return BsdfSample(vec3(-wo.x, -wo.y, wo.z), fresnel_F(bsdf, wo.z) / wo.z, p, 1u);
        }
        wi = reflection_direction(wo, facet_sample(bsdf, wo, u.yz));
    }
    return sample_of(wi, metallic_roughness_eval(bsdf, wo, wi));
}
