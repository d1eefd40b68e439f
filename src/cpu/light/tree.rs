//! The choice among many lights with a place, by their power and their distance: a binary tree over
//! them, in which a walk from the root takes each child in proportion to a bound on what it sends. Conty
//! Estevez and Kulla 2018, "Importance sampling of many lights with adaptive tree splitting", without the
//! splitting and the cones; Pharr, Jakob and Humphreys 2023, "Physically based rendering", section 12.6.3.
//!
//! Nodes are numbered as in a heap: see `pack::light_tree`.

use crate::cpu::rng::{hash_combine, unit_from_bits};
use crate::cpu::texture::texel_word;
use crate::pack::Packed;
use crate::pack::light_tree::TREE_WORDS;
use crate::shared::NONE;
use glam::{DVec3, Vec3};

/// A uniform number is used for choices down to this probability; then it has too few bits left.
pub const TREE_REFRESH: f64 = 1.0 / 256.0;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreePick {
    /// Of the light.
    pub index: u32,
    /// Probability of this choice.
    pub p: f64,
}

pub fn tree_word(packed: &Packed, node: u32, word: u32) -> u32 {
    texel_word(packed, packed.frame.light_tree + TREE_WORDS * node + word)
}

/// What the node's lights may send to p, but for a factor that all nodes share: above 0 if one of them
/// does.
pub fn tree_importance(packed: &Packed, node: u32, p: DVec3) -> f64 {
    let number = |word| f32::from_bits(tree_word(packed, node, word));
    let centre = Vec3::new(number(0), number(1), number(2)).as_dvec3();
    // No nearer than the radius: lights are somewhere in the sphere, and p may be in it too.
    f64::from(number(4)) / (centre - p).length_squared().max(f64::from(number(3)))
}

/// A light for p, by the uniform number u; `seed` makes further ones of it.
pub fn tree_pick(packed: &Packed, p: DVec3, u: f64, seed: u32) -> TreePick {
    let mut node = 1;
    let mut probability = 1.0;
    let mut rest = u;
    let mut used = 1.0;
    while node < packed.frame.light_tree_leaves {
        let left = tree_importance(packed, 2 * node, p);
        let right = tree_importance(packed, 2 * node + 1, p);
        let p_left = left / (left + right);
        let p_taken = if rest < p_left {
            rest /= p_left;
            node *= 2;
            p_left
        } else {
            rest = (rest - p_left) / (1.0 - p_left);
            node = 2 * node + 1;
            right / (left + right)
        };
        probability *= p_taken;
        used *= p_taken;
        if used < TREE_REFRESH {
            rest = unit_from_bits(hash_combine(seed, node));
            used = 1.0;
        }
    }
    TreePick {
        index: tree_word(packed, node, 5),
        p: probability,
    }
}

/// The probability with which `tree_pick` takes the light of this leaf.
pub fn tree_probability(packed: &Packed, p: DVec3, leaf: u32) -> f64 {
    let mut node = leaf;
    let mut probability = 1.0;
    while node > 1 {
        let own = tree_importance(packed, node, p);
        probability *= own / (own + tree_importance(packed, node ^ 1, p));
        node /= 2;
    }
    probability
}

/// The light that a triangle of an instance is, or `NONE`.
pub fn light_of_triangle(packed: &Packed, instance: u32, triangle: u32) -> u32 {
    let first = packed.frame.light_count;
    let end = first + tree_word(packed, 0, 0);
    let triangles = &packed.lights[first as usize..end as usize];
    let found = triangles.binary_search_by_key(&(instance, triangle), |light| {
        (light.instance, light.triangle)
    });
    found.map_or(NONE, |place| first + place as u32)
}

/// Probability with which a light is chosen for p, per unit of its weight: of the triangle of an instance.
pub fn light_share(packed: &Packed, p: DVec3, instance: u32, triangle: u32) -> f64 {
    let total = f64::from(packed.frame.light_weight_total);
    if total <= 0.0 {
        return 0.0;
    }
    if packed.frame.light_tree_leaves == 0 {
        return 1.0 / total;
    }
    let index = light_of_triangle(packed, instance, triangle);
    if index == NONE {
        return 0.0;
    }
    let light = &packed.lights[index as usize];
    let of_tree = f64::from(f32::from_bits(tree_word(packed, 1, 4))) / total;
    of_tree * tree_probability(packed, p, light.alias_index) / f64::from(light.weight)
}
