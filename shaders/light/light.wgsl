// The choice of a light and of a point on it, for next-event estimation.

import package::shared::{LIGHT_TRIANGLE, LIGHT_ENVIRONMENT, LIGHT_DIRECTIONAL, LIGHT_CLUSTER};
import package::variant::{LIGHT_TREE, MANY_LIGHTS, HAS_TRIANGLE_LIGHTS, HAS_ENVIRONMENT_LIGHT, HAS_DIRECTIONAL_LIGHTS, HAS_POINT_LIGHTS};
import package::rng::{hash_combine};
import package::math::{normalize_accurate};
import package::sample::{sample_triangle};
import package::light::environment::{Le_environment, environment_sample_facing, environment_pdf, ENVIRONMENT_CANDIDATES};
import package::light::punctual::{irradiance_punctual};
import package::light::tree::{tree_pick};
import package::light::triangle::{light_at, light_normal, Le_triangle, cos_emission};
import package::bindings::{frame, lights, triangles, materials};

// How far a light without a place is, metres: beyond every scene, and its square is finite.
const LIGHT_DISTANCE_INFINITE: f32 = 1e18;

struct LightSample {
    wi: vec3<f32>,   // unit length, to the light
    distance: f32,   // metres to the light
    Le: vec3<f32>,   // radiance; of a delta light: irradiance on a surface that faces it; times `pdf` over the density that the sample had
    pdf: f32,        // by which it is weighed: per solid angle, of a delta light discrete; the choice included; 0: no sample
    delta: u32,      // 1: no other technique finds this light
}

// The upper word of a product of two words.
fn multiply_high(a: u32, b: u32) -> u32 {
    let low = (a & 0xffffu) * (b & 0xffffu);
    let middle1 = (a >> 16u) * (b & 0xffffu) + (low >> 16u);
    let middle2 = (a & 0xffffu) * (b >> 16u) + (middle1 & 0xffffu);
    return (a >> 16u) * (b >> 16u) + (middle1 >> 16u) + (middle2 >> 16u);
}

// A choice from a table, and what is left of the uniform number that made it: uniform again.
struct LightPick {
    index: u32,
    rest: f32,
}

// Index of an entry of the table, with probability weight / light_weight_total: the alias method (Walker 1977,
// "An efficient method for generating discrete random variables with general distributions").
// The 24 bits of u_pick are too few to choose among many lights and then compare with a
// threshold, so eight more come from a hash of all three numbers.
fn light_pick(u_pick: f32, u: vec2<f32>) -> LightPick {
    if !MANY_LIGHTS {
        return LightPick(0u, u_pick);
    }
    let pick = u32(u_pick * 0x1p24f);
    let hash = hash_combine(hash_combine(pick, u32(u.x * 0x1p24f)), u32(u.y * 0x1p24f));
    let word = (pick << 8u) | (hash >> 24u);
    let index = multiply_high(word, frame.light_count);
    let fraction = f32((word * frame.light_count) >> 8u) * 0x1p-24f;
    let threshold = lights[index].alias_threshold;
    if fraction < threshold {
        return LightPick(index, fraction / threshold);
    }
    return LightPick(lights[index].alias_index, (fraction - threshold) / (1.0 - threshold));
}

// Density per solid angle, choice included, with which light_sample meets a point of a triangle
// whose material has this `emission_weight`, `distance` metres away at cosine `cos_light`, where lights
// are chosen with the probability `share` per unit of weight.
fn light_pdf_triangle(share: f32, emission_weight: f32, distance: f32, cos_light: f32) -> f32 {
    if cos_light <= 0.0 {
        return 0.0;
    }
    return emission_weight * share * distance * distance / cos_light;
}

// A direction to where a light is at `time`, not yet tested for what stands between, for a surface at p with
// the normal ns on the viewer's side.
fn light_sample(p: vec3<f32>, ns: vec3<f32>, transmits: bool, u_pick: f32, u: vec2<f32>, time: f32) -> LightSample {
    var result = LightSample(vec3<f32>(0.0), 0.0, vec3<f32>(0.0), 0.0, 0u);
    if frame.light_count == 0u || frame.light_weight_total <= 0.0 {
        return result;
    }
    let pick = light_pick(u_pick, u);
    var light = lights[pick.index];
    var share = 1.0 / frame.light_weight_total;
    var weight = 1.0;
    if LIGHT_TREE && light.kind == LIGHT_CLUSTER {
        let leaf = tree_pick(p, ns, transmits, pick.rest, u32(u.x * 0x1p24f));
        if leaf.p <= 0.0 {
            return result;
        }
        share *= light.weight * leaf.p;
        light = lights[leaf.index];
        share /= light.weight;
        weight = leaf.weight;
    }
    if HAS_ENVIRONMENT_LIGHT && light.kind == LIGHT_ENVIRONMENT {
        let sample = environment_sample_facing(ns, transmits, pick.rest, u);
        if sample.pdf <= 0.0 {
            return result;
        }
        result.wi = sample.wi;
        result.distance = LIGHT_DISTANCE_INFINITE;
        result.Le = sample.weight * Le_environment(sample.wi);
        result.pdf = sample.pdf * (light.weight * share);
        return result;
    }
    if HAS_DIRECTIONAL_LIGHTS && light.kind == LIGHT_DIRECTIONAL {
        result.wi = -light.direction;
        result.distance = LIGHT_DISTANCE_INFINITE;
        result.Le = light.radiance;
        result.pdf = light.weight * share;
        result.delta = 1u;
        return result;
    }
    if !HAS_TRIANGLE_LIGHTS && !HAS_POINT_LIGHTS {
        return result;
    }
    if HAS_TRIANGLE_LIGHTS && light.kind == LIGHT_TRIANGLE {
        light = light_at(light, time);
    }
    var target_point = light.position;
    let barycentrics = sample_triangle(u);
    if HAS_TRIANGLE_LIGHTS && light.kind == LIGHT_TRIANGLE {
        target_point += barycentrics.x * light.direction + barycentrics.y * light.edge2;
    }
    let to_light = target_point - p;
    let distance = sqrt(dot(to_light, to_light));
    if distance == 0.0 {
        return result;
    }
    result.wi = normalize_accurate(to_light);
    result.distance = distance;
    if HAS_TRIANGLE_LIGHTS && (!HAS_POINT_LIGHTS || light.kind == LIGHT_TRIANGLE) {
        let cos_light = cos_emission(light, -dot(result.wi, light_normal(light, time)));
        let emission_weight = materials[triangles[light.triangle].material].emission_weight;
        result.pdf = light_pdf_triangle(share, emission_weight, distance, cos_light);
        if result.pdf > 0.0 {
            result.Le = weight * Le_triangle(light, barycentrics);
        }
        return result;
    }
    result.Le = weight * irradiance_punctual(light, result.wi, distance);
    result.pdf = light.weight * share;
    result.delta = 1u;
    return result;
}

// Density per solid angle, choice included, of light_sample's candidates at direction d to the
// environment.
fn light_pdf_environment(d: vec3<f32>) -> f32 {
    if !HAS_ENVIRONMENT_LIGHT || frame.light_weight_total <= 0.0 {
        return 0.0;
    }
    return ENVIRONMENT_CANDIDATES * environment_pdf(d) * (frame.environment_weight / frame.light_weight_total);
}
