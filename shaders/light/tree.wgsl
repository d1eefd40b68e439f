// The choice among many lights with a place, by what they may send to a place on a surface: a binary tree
// over them, in which a walk from the root takes each child in proportion to an estimate from power, distance,
// the directions that its lights face and, for the walk alone, the surface's. Conty Estevez and Kulla 2018,
// "Importance sampling of many lights with adaptive tree splitting", without the splitting and with means in
// the place of bounds, so that every light has a probability.
//
// Nodes are numbered as in a heap: the root is 1, the children of k are 2k and 2k + 1, and leaves come last.
// Node 0 is none.

import package::shared::{NONE, LightNode};
import package::variant::{LIGHT_TREE};
import package::rng::{hash_combine, unit_from_bits};
import package::bindings::{frame, lights, light_nodes};

// Nodes in a row of their texture.
const LIGHT_NODES_IN_ROW: u32 = 2048u;

// A uniform number is used for choices down to this probability; then it has too few bits left.
const TREE_REFRESH: f32 = 0x1p-8f;

// What is left of a number is rounded to no more than this: 1 would take a child that has no light.
const BELOW_ONE: f32 = 0x1.fffffep-1f;

// What a node's lights send to a place, about, but for a factor that all nodes share; above 0.
struct TreeImportance {
    sent: f32,     // whatever the surface faces
    received: f32, // times the cosine at the surface
}

// The cosine of lights below a surface: none is left out.
const COSINE_MIN: f32 = 0.02;

struct TreePick {
    index: u32,  // of the light
    p: f32,      // probability of this choice, were it made by what is sent
    weight: f32, // p over the probability that the choice had
}

// A node but for its light.
fn light_node(node: u32) -> LightNode {
    let at = vec2<u32>(3u * (node % LIGHT_NODES_IN_ROW), node / LIGHT_NODES_IN_ROW);
    let sphere = bitcast<vec4<f32>>(textureLoad(light_nodes, at, 0));
    let facing = bitcast<vec4<f32>>(textureLoad(light_nodes, at + vec2<u32>(1u, 0u), 0));
    return LightNode(sphere.xyz, sphere.w, facing.xyz, facing.w, NONE, 0u, vec2<u32>(0u));
}

fn light_of_leaf(node: u32) -> u32 {
    return textureLoad(light_nodes, vec2<u32>(3u * (node % LIGHT_NODES_IN_ROW) + 2u, node / LIGHT_NODES_IN_ROW), 0).x;
}

// About the mean of max(x, 0) where x has this mean and four thirds of this variance: right where there is no
// variance, and 1/4 for the cosine of directions to all sides, 0 and 1/4. Above 0 where the variance is.
fn mean_above_zero(mean: f32, variance: f32) -> f32 {
    let size = sqrt(mean * mean + variance) + abs(mean);
    return 0.5 * select(variance / size, size, mean >= 0.0);
}

// cos(max(a - b, 0)) of angles a in [0, pi], b in [0, pi/2].
fn cos_beyond(cos_a: f32, cos_b: f32, sin_b: f32) -> f32 {
    let sin_a = sqrt(max(1.0 - cos_a * cos_a, 0.0));
    return select(cos_a * cos_b + sin_a * sin_b, 1.0, cos_a > cos_b);
}

// Of a node's lights to p, for a surface with the normal ns. What they send is about the mean over the sphere, the
// cosine the largest in it: a mean there would leave a light that is close by with too little probability.
fn tree_importance(node: LightNode, p: vec3<f32>, ns: vec3<f32>, transmits: bool) -> TreeImportance {
    let to_centre = node.centre - p;
    // No nearer than the radius: lights are somewhere in the sphere, and p may be in it too.
    let distance2 = max(dot(to_centre, to_centre), node.radius2);
    let direction = to_centre * inverseSqrt(distance2);
    let spread = node.radius2 / distance2; // squared sine of the angle that the sphere's radius is seen at
    let turned = 0.25 * max(1.0 - dot(node.facing, node.facing), 0.0);
    let sent = node.weight * mean_above_zero(-dot(node.facing, direction), turned + spread) / distance2;
    let cosine = cos_beyond(dot(ns, direction), sqrt(max(1.0 - spread, 0.0)), sqrt(spread));
    return TreeImportance(sent, select(sent * max(cosine, COSINE_MIN), sent, transmits));
}

// A light for a surface at p with the normal ns, by the uniform number u; `seed` makes further ones of it.
//
// The walk goes by what is received. What it would have been by what is sent alone is the density that weighs a
// sample against one of the BSDF, by which light_share knows it where it meets the light and the surface is gone:
// weights need but to be the same for both techniques.
fn tree_pick(p: vec3<f32>, ns: vec3<f32>, transmits: bool, u: f32, seed: u32) -> TreePick {
    var node = 1u;
    var probability = 1.0;
    var by_sent = 1.0;
    var rest = u;
    var used = 1.0;
    while node < frame.light_tree_leaves {
        let left = tree_importance(light_node(2u * node), p, ns, transmits);
        let right = tree_importance(light_node(2u * node + 1u), p, ns, transmits);
        let p_left = left.received / (left.received + right.received);
        let takes_left = rest < p_left;
        let p_taken = select(right.received / (left.received + right.received), p_left, takes_left);
        rest = min(select((rest - p_left) / (1.0 - p_left), rest / p_left, takes_left), BELOW_ONE);
        by_sent *= select(right.sent, left.sent, takes_left) / (left.sent + right.sent);
        node = 2u * node + select(1u, 0u, takes_left);
        probability *= p_taken;
        used *= p_taken;
        if used < TREE_REFRESH {
            rest = unit_from_bits(hash_combine(seed, node));
            used = 1.0;
        }
    }
    return TreePick(light_of_leaf(node), by_sent, by_sent / probability);
}

// The probability by what is sent with which tree_pick takes the light of this leaf.
fn tree_probability(p: vec3<f32>, leaf: u32) -> f32 {
    let no_surface = vec3<f32>(0.0);
    var node = leaf;
    var probability = 1.0;
    while node > 1u {
        let own = tree_importance(light_node(node), p, no_surface, true).sent;
        let other = tree_importance(light_node(node ^ 1u), p, no_surface, true).sent;
        probability *= own / (own + other);
        node = node / 2u;
    }
    return probability;
}

// The light that a triangle of an instance is, or NONE.
fn light_of_triangle(instance: u32, triangle: u32) -> u32 {
    var first = frame.light_count;
    var remaining = frame.light_tree_triangles;
    let end = first + remaining;
    while remaining > 0u {
        let half = remaining / 2u;
        let light_instance = lights[first + half].instance;
        let light_triangle = lights[first + half].triangle;
        if light_instance < instance || (light_instance == instance && light_triangle < triangle) {
            first += half + 1u;
            remaining -= half + 1u;
        } else {
            remaining = half;
        }
    }
    if first == end || lights[first].instance != instance || lights[first].triangle != triangle {
        return NONE;
    }
    return first;
}

// Probability with which a light is chosen for p, per unit of its weight: of the triangle of an instance.
fn light_share(p: vec3<f32>, instance: u32, triangle: u32) -> f32 {
    if frame.light_weight_total <= 0.0 {
        return 0.0;
    }
    if !LIGHT_TREE || frame.light_tree_leaves == 0u {
        return 1.0 / frame.light_weight_total;
    }
    let index = light_of_triangle(instance, triangle);
    if index == NONE {
        return 0.0;
    }
    let of_tree = light_node(1u).weight / frame.light_weight_total;
    return of_tree * tree_probability(p, lights[index].alias_index) / lights[index].weight;
}
