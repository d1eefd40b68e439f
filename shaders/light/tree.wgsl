// The choice among many lights with a place, by their power and their distance: a binary tree over them, in
// which a walk from the root takes each child in proportion to a bound on what it sends. Conty Estevez and
// Kulla 2018, "Importance sampling of many lights with adaptive tree splitting", without the splitting and
// the cones; Pharr, Jakob and Humphreys 2023, "Physically based rendering", section 12.6.3.
//
// Nodes are numbered as in a heap: the root is 1, the children of k are 2k and 2k + 1, and leaves come last.
// TREE_WORDS words of each are in `texels`: centre and squared radius of a sphere around the lights, the sum
// of their weights, and at a leaf the light's index. Node 0 is none, and its first word says how many
// triangles are among the lights; they come first of those in the tree, by instance and triangle.

import package::shared::{NONE};
import package::variant::{LIGHT_TREE};
import package::rng::{hash_combine, unit_from_bits};
import package::texture::{texel_word};
import package::bindings::{frame, lights};

const TREE_WORDS: u32 = 6u;

// A uniform number is used for choices down to this probability; then it has too few bits left.
const TREE_REFRESH: f32 = 0x1p-8f;

struct TreePick {
    index: u32, // of the light
    p: f32,     // probability of this choice
}

fn tree_word(node: u32, word: u32) -> u32 {
    return texel_word(frame.light_tree + TREE_WORDS * node + word);
}

// What the node's lights may send to p, but for a factor that all nodes share: above 0 if one of them does.
fn tree_importance(node: u32, p: vec3<f32>) -> f32 {
    let centre = bitcast<vec3<f32>>(vec3<u32>(tree_word(node, 0u), tree_word(node, 1u), tree_word(node, 2u)));
    let radius2 = bitcast<f32>(tree_word(node, 3u));
    let weight = bitcast<f32>(tree_word(node, 4u));
    let to_centre = centre - p;
    // No nearer than the radius: lights are somewhere in the sphere, and p may be in it too.
    return weight / max(dot(to_centre, to_centre), radius2);
}

// A light for p, by the uniform number u; `seed` makes further ones of it.
fn tree_pick(p: vec3<f32>, u: f32, seed: u32) -> TreePick {
    var node = 1u;
    var probability = 1.0;
    var rest = u;
    var used = 1.0;
    while node < frame.light_tree_leaves {
        let left = tree_importance(2u * node, p);
        let right = tree_importance(2u * node + 1u, p);
        let p_left = left / (left + right);
        var p_taken = p_left;
        node = 2u * node;
        if rest < p_left {
            rest = rest / p_left;
        } else {
            rest = (rest - p_left) / (1.0 - p_left);
            p_taken = right / (left + right);
            node += 1u;
        }
        probability *= p_taken;
        used *= p_taken;
        if used < TREE_REFRESH {
            rest = unit_from_bits(hash_combine(seed, node));
            used = 1.0;
        }
    }
    return TreePick(tree_word(node, 5u), probability);
}

// The probability with which tree_pick takes the light of this leaf.
fn tree_probability(p: vec3<f32>, leaf: u32) -> f32 {
    var node = leaf;
    var probability = 1.0;
    while node > 1u {
        let own = tree_importance(node, p);
        probability *= own / (own + tree_importance(node ^ 1u, p));
        node = node / 2u;
    }
    return probability;
}

// The light that a triangle of an instance is, or NONE.
fn light_of_triangle(instance: u32, triangle: u32) -> u32 {
    var first = frame.light_count;
    var remaining = tree_word(0u, 0u);
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
    let of_tree = bitcast<f32>(tree_word(1u, 4u)) / frame.light_weight_total;
    return of_tree * tree_probability(p, lights[index].alias_index) / lights[index].weight;
}
