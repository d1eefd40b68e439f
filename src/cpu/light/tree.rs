//! The choice among many lights with a place, by what they may send to a place on a surface: a binary tree
//! over them, in which a walk from the root takes each child in proportion to an estimate from power,
//! distance, the directions that its lights face and, for the walk alone, the surface's. Conty Estevez and
//! Kulla 2018, "Importance sampling of many lights with adaptive tree splitting", without the splitting and
//! with means in the place of bounds, so that every light has a probability.
//!
//! Nodes are numbered as in a heap: the root is 1, the children of k are 2k and 2k + 1, and leaves come
//! last. Node 0 is none.

use crate::cpu::rng::{hash_combine, unit_from_bits};
use crate::pack::Packed;
use crate::shared::{LightNode, NONE};
use glam::{DVec3, Vec3};

/// A uniform number is used for choices down to this probability; then it has too few bits left.
pub const TREE_REFRESH: f64 = 1.0 / 256.0;

/// The cosine of lights below a surface: none is left out.
pub const COSINE_MIN: f64 = 0.02;

/// What is left of a number is rounded to no more than this: 1 would take a child that has no light.
pub const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// What a node's lights send to a place, about, but for a factor that all nodes share; above 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeImportance {
    /// Whatever the surface faces.
    pub sent: f64,
    /// Times the cosine at the surface.
    pub received: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreePick {
    /// Of the light.
    pub index: u32,
    /// Probability of this choice, were it made by what is sent.
    pub p: f64,
    /// `p` over the probability that the choice had.
    pub weight: f64,
}

pub fn light_node(packed: &Packed, node: u32) -> &LightNode {
    &packed.light_nodes[node as usize]
}

pub fn light_of_leaf(packed: &Packed, node: u32) -> u32 {
    light_node(packed, node).light
}

/// About the mean of max(x, 0) where x has this mean and four thirds of this variance: right where there is
/// no variance, and 1/4 for the cosine of directions to all sides, 0 and 1/4. Above 0 where the variance is.
pub fn mean_above_zero(mean: f64, variance: f64) -> f64 {
    let size = (mean * mean + variance).sqrt() + mean.abs();
    0.5 * if mean >= 0.0 { size } else { variance / size }
}

/// cos(max(a - b, 0)) of angles a in [0, pi], b in [0, pi/2].
pub fn cos_beyond(cos_a: f64, cos_b: f64, sin_b: f64) -> f64 {
    if cos_a > cos_b {
        1.0
    } else {
        let sin_a = (1.0 - cos_a * cos_a).max(0.0).sqrt();
        cos_a * cos_b + sin_a * sin_b
    }
}

/// Of a node's lights to p, for a surface with the normal ns. What they send is about the mean over the
/// sphere, the cosine the largest in it: a mean there would leave a light that is close by with too little
/// probability.
pub fn tree_importance(node: &LightNode, p: DVec3, ns: DVec3, transmits: bool) -> TreeImportance {
    let vector = |v: [f32; 3]| Vec3::from(v).as_dvec3();
    let (facing, radius2) = (vector(node.facing), f64::from(node.radius2));
    let to_centre = vector(node.centre) - p;
    // No nearer than the radius: lights are somewhere in the sphere, and p may be in it too.
    let distance2 = to_centre.length_squared().max(radius2);
    let direction = to_centre / distance2.sqrt();
    // Squared sine of the angle that the sphere's radius is seen at.
    let spread = radius2 / distance2;
    let turned = 0.25 * (1.0 - facing.length_squared()).max(0.0);
    let sent = f64::from(node.weight) * mean_above_zero(-facing.dot(direction), turned + spread)
        / distance2;
    let received = if transmits {
        sent
    } else {
        let (cos_sphere, sin_sphere) = ((1.0 - spread).max(0.0).sqrt(), spread.sqrt());
        sent * cos_beyond(ns.dot(direction), cos_sphere, sin_sphere).max(COSINE_MIN)
    };
    TreeImportance { sent, received }
}

/// A light for a surface at p with the normal ns, by the uniform number u; `seed` makes further ones of it.
///
/// The walk goes by what is received. What it would have been by what is sent alone is the density that
/// weighs a sample against one of the BSDF, by which `light_share` knows it where it meets the light and the
/// surface is gone: weights need but to be the same for both techniques.
pub fn tree_pick(
    packed: &Packed,
    p: DVec3,
    ns: DVec3,
    transmits: bool,
    u: f64,
    seed: u32,
) -> TreePick {
    let mut node = 1;
    let mut probability = 1.0;
    let mut by_sent = 1.0;
    let mut rest = u;
    let mut used = 1.0;
    while node < packed.frame.light_tree_leaves {
        let [left, right] = [2 * node, 2 * node + 1]
            .map(|child| tree_importance(light_node(packed, child), p, ns, transmits));
        let received = left.received + right.received;
        let p_left = left.received / received;
        let (p_taken, sent) = if rest < p_left {
            rest /= p_left;
            node *= 2;
            (p_left, left.sent)
        } else {
            rest = (rest - p_left) / (1.0 - p_left);
            node = 2 * node + 1;
            (right.received / received, right.sent)
        };
        by_sent *= sent / (left.sent + right.sent);
        probability *= p_taken;
        rest = rest.min(BELOW_ONE);
        used *= p_taken;
        if used < TREE_REFRESH {
            rest = unit_from_bits(hash_combine(seed, node));
            used = 1.0;
        }
    }
    TreePick {
        index: light_of_leaf(packed, node),
        p: by_sent,
        weight: by_sent / probability,
    }
}

/// The probability by what is sent with which `tree_pick` takes the light of this leaf.
pub fn tree_probability(packed: &Packed, p: DVec3, leaf: u32) -> f64 {
    let sent = |node: u32| tree_importance(light_node(packed, node), p, DVec3::ZERO, true).sent;
    let mut node = leaf;
    let mut probability = 1.0;
    while node > 1 {
        let own = sent(node);
        probability *= own / (own + sent(node ^ 1));
        node /= 2;
    }
    probability
}

/// The light that a triangle of an instance is, or `NONE`.
pub fn light_of_triangle(packed: &Packed, instance: u32, triangle: u32) -> u32 {
    let first = packed.frame.light_count;
    let end = first + packed.frame.light_tree_triangles;
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
    let of_tree = f64::from(light_node(packed, 1).weight) / total;
    of_tree * tree_probability(packed, p, light.alias_index) / f64::from(light.weight)
}
