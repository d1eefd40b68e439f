// The choice among many lights with a place, by what they may send to a place on a surface: a binary tree
// over them, in which a walk from the root takes each child in proportion to a bound of power, distance, the
// directions that its lights face and, for the walk alone, the surface's. Conty Estevez and Kulla 2018,
// "Importance sampling of many lights with adaptive tree splitting", without the splitting; Pharr, Jakob and
// Humphreys 2023, "Physically based rendering", section 12.6.3.
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

// What a node's lights may send to a place, but for a factor that all nodes share: above 0 if one of them does.
struct TreeImportance {
    sent: f32,     // whatever the surface faces
    received: f32, // times a bound on the cosine at the surface
}

struct TreePick {
    index: u32,  // of the light
    p: f32,      // probability of this choice, were it made by what is sent; 0: no light is chosen
    weight: f32, // p over the probability that the choice had
}

fn light_node(node: u32) -> LightNode {
    let at = vec2<u32>(3u * (node % LIGHT_NODES_IN_ROW), node / LIGHT_NODES_IN_ROW);
    let sphere = bitcast<vec4<f32>>(textureLoad(light_nodes, at, 0));
    let cone = bitcast<vec4<f32>>(textureLoad(light_nodes, at + vec2<u32>(1u, 0u), 0));
    let rest = textureLoad(light_nodes, at + vec2<u32>(2u, 0u), 0);
    let numbers = bitcast<vec3<f32>>(rest.xyz);
    return LightNode(sphere.xyz, sphere.w, cone.xyz, cone.w, numbers.x, numbers.y, numbers.z, rest.w);
}

// cos(max(a - b, 0)) of angles in [0, pi].
fn cos_beyond(cos_a: f32, cos_b: f32, sin_b: f32) -> f32 {
    let sin_a = sqrt(max(1.0 - cos_a * cos_a, 0.0));
    return select(cos_a * cos_b + sin_a * sin_b, 1.0, cos_a > cos_b);
}

// Of a node's lights to p, for a surface with the normal ns.
fn tree_importance(node: LightNode, p: vec3<f32>, ns: vec3<f32>, transmits: bool) -> TreeImportance {
    let to_centre = node.centre - p;
    let distance2 = dot(to_centre, to_centre);
    if distance2 <= node.radius2 {
        // Lights are somewhere in the sphere, and p is in it too.
        return TreeImportance(node.weight / node.radius2, node.weight / node.radius2);
    }
    let sin2_sphere = node.radius2 / distance2;
    let sin_sphere = sqrt(sin2_sphere);
    let cos_sphere = sqrt(1.0 - sin2_sphere);
    let direction = to_centre * inverseSqrt(distance2);
    // The least angle between a direction that a light faces and one from it to p.
    let cos_axis = clamp(-dot(node.axis, direction), -1.0, 1.0);
    let cos_facing = cos_beyond(cos_axis, node.cos_cone, node.sin_cone);
    let cos_light = cos_beyond(cos_facing, cos_sphere, sin_sphere);
    let sent = select(0.0, node.weight * max(cos_light, 0.0) / distance2, cos_light > node.cos_reach);
    let cos_centre = clamp(dot(ns, direction), -1.0, 1.0);
    let cos_surface = cos_beyond(cos_centre, cos_sphere, sin_sphere);
    return TreeImportance(sent, select(sent * max(cos_surface, 0.0), sent, transmits));
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
    var light = NONE;
    while node < frame.light_tree_leaves {
        let left_node = light_node(2u * node);
        let right_node = light_node(2u * node + 1u);
        let left = tree_importance(left_node, p, ns, transmits);
        let right = tree_importance(right_node, p, ns, transmits);
        let received = left.received + right.received;
        if received <= 0.0 {
            return TreePick(NONE, 0.0, 0.0);
        }
        let p_left = left.received / received;
        let takes_left = rest < p_left;
        let p_taken = select(right.received / received, p_left, takes_left);
        rest = select((rest - p_left) / (1.0 - p_left), rest / p_left, takes_left);
        light = select(right_node.light, left_node.light, takes_left);
        by_sent *= select(right.sent, left.sent, takes_left) / (left.sent + right.sent);
        node = 2u * node + select(1u, 0u, takes_left);
        probability *= p_taken;
        used *= p_taken;
        if used < TREE_REFRESH {
            rest = unit_from_bits(hash_combine(seed, node));
            used = 1.0;
        }
    }
    return TreePick(light, by_sent, by_sent / probability);
}

// The probability by what is sent with which tree_pick takes the light of this leaf.
fn tree_probability(p: vec3<f32>, leaf: u32) -> f32 {
    let no_surface = vec3<f32>(0.0);
    var node = leaf;
    var probability = 1.0;
    while node > 1u {
        let own = tree_importance(light_node(node), p, no_surface, true).sent;
        let other = tree_importance(light_node(node ^ 1u), p, no_surface, true).sent;
        if own <= 0.0 {
            return 0.0;
        }
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
