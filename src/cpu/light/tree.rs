//! The choice among many lights with a place, by what they may send to a place on a surface: a binary tree
//! over them, in which a walk from the root takes each child in proportion to a bound of power, distance,
//! the directions that its lights face and, for the walk alone, the surface's. Conty Estevez and Kulla 2018,
//! "Importance sampling of many lights with adaptive tree splitting", without the splitting; Pharr, Jakob
//! and Humphreys 2023, "Physically based rendering", section 12.6.3.
//!
//! Nodes are numbered as in a heap: the root is 1, the children of k are 2k and 2k + 1, and leaves come
//! last. Node 0 is none.

use crate::cpu::rng::{hash_combine, unit_from_bits};
use crate::pack::Packed;
use crate::shared::{LightNode, NONE};
use glam::{DVec3, Vec3};

/// A uniform number is used for choices down to this probability; then it has too few bits left.
pub const TREE_REFRESH: f64 = 1.0 / 256.0;

/// What a node's lights may send to a place, but for a factor that all nodes share: above 0 if one of them
/// does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeImportance {
    /// Whatever the surface faces.
    pub sent: f64,
    /// Times a bound on the cosine at the surface.
    pub received: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreePick {
    /// Of the light.
    pub index: u32,
    /// Probability of this choice, were it made by what is sent; 0: no light is chosen.
    pub p: f64,
    /// `p` over the probability that the choice had.
    pub weight: f64,
}

pub fn light_node(packed: &Packed, node: u32) -> &LightNode {
    &packed.light_nodes[node as usize]
}

/// cos(max(a - b, 0)) of angles in [0, pi].
pub fn cos_beyond(cos_a: f64, cos_b: f64, sin_b: f64) -> f64 {
    if cos_a > cos_b {
        1.0
    } else {
        let sin_a = (1.0 - cos_a * cos_a).max(0.0).sqrt();
        cos_a * cos_b + sin_a * sin_b
    }
}

/// Of a node's lights to p, for a surface with the normal ns.
pub fn tree_importance(node: &LightNode, p: DVec3, ns: DVec3, transmits: bool) -> TreeImportance {
    let vector = |v: [f32; 3]| Vec3::from(v).as_dvec3();
    let (radius2, weight) = (f64::from(node.radius2), f64::from(node.weight));
    let to_centre = vector(node.centre) - p;
    let distance2 = to_centre.length_squared();
    if distance2 <= radius2 {
        // Lights are somewhere in the sphere, and p is in it too.
        return TreeImportance {
            sent: weight / radius2,
            received: weight / radius2,
        };
    }
    let sin2_sphere = radius2 / distance2;
    let (sin_sphere, cos_sphere) = (sin2_sphere.sqrt(), (1.0 - sin2_sphere).sqrt());
    let direction = to_centre / distance2.sqrt();
    // The least angle between a direction that a light faces and one from it to p.
    let cos_axis = (-vector(node.axis).dot(direction)).clamp(-1.0, 1.0);
    let (cos_cone, sin_cone) = (f64::from(node.cos_cone), f64::from(node.sin_cone));
    let cos_facing = cos_beyond(cos_axis, cos_cone, sin_cone);
    let cos_light = cos_beyond(cos_facing, cos_sphere, sin_sphere);
    let sent = if cos_light > f64::from(node.cos_reach) {
        weight * cos_light.max(0.0) / distance2
    } else {
        0.0
    };
    let received = if transmits || sent == 0.0 {
        sent
    } else {
        let cos_centre = ns.dot(direction).clamp(-1.0, 1.0);
        sent * cos_beyond(cos_centre, cos_sphere, sin_sphere).max(0.0)
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
        if received <= 0.0 {
            return TreePick {
                index: NONE,
                p: 0.0,
                weight: 0.0,
            };
        }
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
        used *= p_taken;
        if used < TREE_REFRESH {
            rest = unit_from_bits(hash_combine(seed, node));
            used = 1.0;
        }
    }
    TreePick {
        index: light_node(packed, node).light,
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
        if own <= 0.0 {
            return 0.0;
        }
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
