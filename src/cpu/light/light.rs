//! The choice of a light and of a point on it, for next-event estimation.

use crate::cpu::light::environment::{
    ENVIRONMENT_CANDIDATES, Le_environment, environment_pdf, environment_sample_facing,
};
use crate::cpu::light::punctual::irradiance_punctual;
use crate::cpu::light::tree::tree_pick;
use crate::cpu::light::triangle::{Le_triangle, cos_emission, light_at, light_normal};
use crate::cpu::math::normalize_accurate;
use crate::cpu::rng::{hash_combine, unit_from_bits};
use crate::cpu::sample::sample_triangle;
use crate::pack::Packed;
use crate::shared::{LIGHT_CLUSTER, LIGHT_DIRECTIONAL, LIGHT_ENVIRONMENT, LIGHT_TRIANGLE};
use glam::{DVec2, DVec3, Vec3};

/// How far a light without a place is, metres: beyond every scene, and its square is finite.
pub const LIGHT_DISTANCE_INFINITE: f64 = 1e18;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Unit length, to the light.
    pub wi: DVec3,
    /// Metres to the light.
    pub distance: f64,
    /// Radiance; of a delta light: irradiance on a surface that faces it; times `pdf` over the density that
    /// the sample had.
    pub Le: DVec3,
    /// By which it is weighed: per solid angle, of a delta light discrete; the choice included; 0: no sample.
    pub pdf: f64,
    /// 1: no other technique finds this light.
    pub delta: u32,
}

/// The upper word of a product of two words.
pub fn multiply_high(a: u32, b: u32) -> u32 {
    ((u64::from(a) * u64::from(b)) >> 32) as u32
}

/// A choice from a table, and what is left of the uniform number that made it: uniform again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightPick {
    pub index: u32,
    pub rest: f64,
}

/// Index of an entry of the table, with probability weight / light_weight_total: the alias method (Walker 1977,
/// "An efficient method for generating discrete random variables with general distributions").
/// The 24 bits of `u_pick` are too few to choose among many lights and then compare with a
/// threshold, so eight more come from a hash of all three numbers.
pub fn light_pick(packed: &Packed, u_pick: f64, u: DVec2) -> LightPick {
    let bits = |u: f64| (u * f64::from(1u32 << 24)) as u32;
    let pick = bits(u_pick);
    let hash = hash_combine(hash_combine(pick, bits(u.x)), bits(u.y));
    let word = (pick << 8) | (hash >> 24);
    let index = multiply_high(word, packed.frame.light_count);
    let fraction = unit_from_bits(word.wrapping_mul(packed.frame.light_count));
    let light = &packed.lights[index as usize];
    let threshold = f64::from(light.alias_threshold);
    if fraction < threshold {
        return LightPick {
            index,
            rest: fraction / threshold,
        };
    }
    LightPick {
        index: light.alias_index,
        rest: (fraction - threshold) / (1.0 - threshold),
    }
}

/// Density per solid angle, choice included, with which `light_sample` meets a point of a triangle
/// whose material has this `emission_weight`, `distance` metres away at cosine `cos_light`, where lights
/// are chosen with the probability `share` per unit of weight.
pub fn light_pdf_triangle(share: f64, emission_weight: f64, distance: f64, cos_light: f64) -> f64 {
    if cos_light <= 0.0 {
        return 0.0;
    }
    emission_weight * share * distance * distance / cos_light
}

/// A direction to where a light is at `time`, not yet tested for what stands between, for a surface at p with
/// the normal ns on the viewer's side.
pub fn light_sample(
    packed: &Packed,
    p: DVec3,
    ns: DVec3,
    transmits: bool,
    u_pick: f64,
    u: DVec2,
    time: f64,
) -> LightSample {
    let mut result = LightSample {
        wi: DVec3::ZERO,
        distance: 0.0,
        Le: DVec3::ZERO,
        pdf: 0.0,
        delta: 0,
    };
    let total = f64::from(packed.frame.light_weight_total);
    if packed.frame.light_count == 0 || total <= 0.0 {
        return result;
    }
    let pick = light_pick(packed, u_pick, u);
    let mut light = &packed.lights[pick.index as usize];
    let mut share = 1.0 / total;
    let mut weight = 1.0;
    if light.kind == LIGHT_CLUSTER {
        let seed = (u.x * f64::from(1u32 << 24)) as u32;
        let leaf = tree_pick(packed, p, ns, transmits, pick.rest, seed);
        if leaf.p <= 0.0 {
            return result;
        }
        share *= f64::from(light.weight) * leaf.p;
        light = &packed.lights[leaf.index as usize];
        share /= f64::from(light.weight);
        weight = leaf.weight;
    }
    if light.kind == LIGHT_ENVIRONMENT {
        let sample = environment_sample_facing(packed, ns, transmits, pick.rest, u);
        if sample.pdf <= 0.0 {
            return result;
        }
        result.wi = sample.wi;
        result.distance = LIGHT_DISTANCE_INFINITE;
        result.Le = sample.weight * Le_environment(packed, sample.wi);
        result.pdf = sample.pdf * (f64::from(light.weight) * share);
        return result;
    }
    if light.kind == LIGHT_DIRECTIONAL {
        result.wi = -Vec3::from(light.direction).as_dvec3();
        result.distance = LIGHT_DISTANCE_INFINITE;
        result.Le = Vec3::from(light.radiance).as_dvec3();
        result.pdf = f64::from(light.weight) * share;
        result.delta = 1;
        return result;
    }
    let barycentrics = sample_triangle(u);
    let triangle = (light.kind == LIGHT_TRIANGLE).then(|| light_at(packed, light, time));
    let target_point = match &triangle {
        Some(light) => {
            light.position + barycentrics.x * light.direction + barycentrics.y * light.edge2
        }
        None => Vec3::from(light.position).as_dvec3(),
    };
    let to_light = target_point - p;
    let distance = to_light.length();
    if distance == 0.0 {
        return result;
    }
    result.wi = normalize_accurate(to_light);
    result.distance = distance;
    if let Some(light) = &triangle {
        let cos_light = cos_emission(
            packed,
            light,
            -result.wi.dot(light_normal(packed, light, time)),
        );
        let material = packed.triangles[light.triangle as usize].material;
        let emission_weight = f64::from(packed.materials[material as usize].emission_weight);
        result.pdf = light_pdf_triangle(share, emission_weight, distance, cos_light);
        if result.pdf > 0.0 {
            result.Le = weight * Le_triangle(packed, light, barycentrics);
        }
        return result;
    }
    result.Le = weight * irradiance_punctual(packed, light, result.wi, distance);
    result.pdf = f64::from(light.weight) * share;
    result.delta = 1;
    result
}

/// Density per solid angle, choice included, of `light_sample`'s candidates at direction d to the
/// environment.
pub fn light_pdf_environment(packed: &Packed, d: DVec3) -> f64 {
    if packed.frame.light_weight_total <= 0.0 {
        return 0.0;
    }
    ENVIRONMENT_CANDIDATES
        * environment_pdf(packed, d)
        * (f64::from(packed.frame.environment_weight) / f64::from(packed.frame.light_weight_total))
}
