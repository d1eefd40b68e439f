//! The tree over many lights with a place (see `shaders/light/tree.wgsl`).

use super::lights::{alias_table, is_infinite};
use super::{PackError, index};
use crate::shared::{LIGHT_CLUSTER, LIGHT_TRIANGLE, Light, NONE};
use bytemuck::Zeroable;
use glam::Vec3;

/// Words of a node: centre and squared radius of a sphere around the lights, the sum of their weights, and
/// at a leaf the light's index.
pub const TREE_WORDS: u32 = 6;

/// From this many lights with a place on they are chosen by a tree: below, the walk costs more than the
/// choice by power alone makes up for in noise (benches/RESULTS.md).
pub const TREE_LIGHTS_MIN: usize = 32;

/// No sphere is smaller than this part of the scene's radius, so that a surface at a light does not give
/// it all of the choice.
const RADIUS_MIN: f32 = 1e-4;

/// Where the tree is, as `Frame` holds it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightTree {
    /// Entries of the alias table: the lights before those in the tree.
    pub light_count: u32,
    /// First of the tree's words in `texels`.
    pub first_word: u32,
    /// A power of two, and the number of the first leaf; 0: there is no tree.
    pub leaves: u32,
}

/// A light in the tree.
#[derive(Clone, Copy)]
struct Leaf {
    low: Vec3,
    high: Vec3,
    weight: f32,
    light: u32,
}

impl Leaf {
    fn new(light: &Light, index: usize) -> Self {
        let corner = Vec3::from(light.position);
        let (mut low, mut high) = (corner, corner);
        if light.kind == LIGHT_TRIANGLE {
            for edge in [light.direction, light.edge2] {
                low = low.min(corner + Vec3::from(edge));
                high = high.max(corner + Vec3::from(edge));
            }
        }
        Self {
            low,
            high,
            weight: light.weight,
            light: index as u32,
        }
    }
}

/// Where there are many lights with a place, puts them behind the others, triangles first by instance and
/// triangle, with one entry for all of them in the alias table, and appends their tree to the texels.
/// Their `alias_index` becomes the number of their leaf. The lights come weighed.
pub fn build_light_tree(
    lights: &mut Vec<Light>,
    texels: &mut Vec<u32>,
    scene_radius: f32,
) -> Result<LightTree, PackError> {
    let placed = lights.iter().filter(|light| !is_infinite(light)).count();
    if placed < TREE_LIGHTS_MIN {
        return Ok(LightTree {
            light_count: index("lights", lights.len())?,
            ..LightTree::default()
        });
    }
    lights.sort_by_key(|light| match (is_infinite(light), light.kind) {
        (true, _) => (0, 0, 0),
        (false, LIGHT_TRIANGLE) => (1, light.instance, light.triangle),
        (false, _) => (2, 0, 0),
    });
    let infinite = lights.len() - placed;
    let weight: f64 = (lights[infinite..].iter())
        .map(|light| f64::from(light.weight))
        .sum();
    lights.insert(
        infinite,
        Light {
            kind: LIGHT_CLUSTER,
            weight: weight as f32,
            ..Light::zeroed()
        },
    );
    let light_count = infinite + 1;
    let weights: Vec<f64> = (lights[..light_count].iter())
        .map(|light| f64::from(light.weight))
        .collect();
    for (light, (index, threshold)) in lights.iter_mut().zip(alias_table(&weights)) {
        light.alias_index = index;
        light.alias_threshold = threshold;
    }
    index("lights", lights.len())?;

    let mut leaves: Vec<Leaf> = (lights.iter().enumerate().skip(light_count))
        .map(|(index, light)| Leaf::new(light, index))
        .collect();
    let first_leaf = placed.next_power_of_two();
    let mut tree = Tree {
        words: vec![0; 2 * first_leaf * TREE_WORDS as usize],
        first_leaf,
        radius2_min: (RADIUS_MIN * scene_radius).powi(2).max(f32::MIN_POSITIVE),
        lights: &mut lights[..],
    };
    tree.plant(1, &mut leaves);
    let mut words = tree.words;
    let triangles = lights[light_count..].iter();
    words[0] = triangles
        .filter(|light| light.kind == LIGHT_TRIANGLE)
        .count() as u32;
    let first_word = index("texels", texels.len())?;
    texels.extend(words);
    index("texels", texels.len())?;
    Ok(LightTree {
        light_count: index("lights", light_count)?,
        first_word,
        leaves: index("leaves of the light tree", first_leaf)?,
    })
}

struct Tree<'a> {
    words: Vec<u32>,
    first_leaf: usize,
    radius2_min: f32,
    lights: &'a mut [Light],
}

impl Tree<'_> {
    /// Writes a node and what is below it. Halves the lights at the median of their places along the
    /// longest axis; each node's number of lights fits the leaves below it.
    fn plant(&mut self, node: usize, leaves: &mut [Leaf]) {
        let low = leaves
            .iter()
            .map(|leaf| leaf.low)
            .fold(Vec3::INFINITY, Vec3::min);
        let high = leaves
            .iter()
            .map(|leaf| leaf.high)
            .fold(Vec3::NEG_INFINITY, Vec3::max);
        let centre = low.midpoint(high);
        let radius2 = (high - centre).length_squared().max(self.radius2_min);
        let weight: f64 = leaves.iter().map(|leaf| f64::from(leaf.weight)).sum();
        let at = node * TREE_WORDS as usize;
        let numbers = [centre.x, centre.y, centre.z, radius2, weight as f32];
        self.words[at..at + 5].copy_from_slice(&numbers.map(f32::to_bits));
        self.words[at + 5] = NONE;
        if let ([leaf], true) = (&*leaves, node >= self.first_leaf) {
            self.words[at + 5] = leaf.light;
            self.lights[leaf.light as usize].alias_index = node as u32;
            return;
        }
        let extent = high - low;
        let axis = extent.max_position();
        let half = leaves.len().div_ceil(2);
        if leaves.len() > 1 {
            leaves.select_nth_unstable_by(half - 1, |a, b| {
                let place = |leaf: &Leaf| leaf.low[axis] + leaf.high[axis];
                place(a).total_cmp(&place(b)).then(a.light.cmp(&b.light))
            });
        }
        let (left, right) = leaves.split_at_mut(half);
        self.plant(2 * node, left);
        if right.is_empty() {
            // Never taken, but asked, and that from the origin too.
            let empty = (2 * node + 1) * TREE_WORDS as usize;
            self.words[empty + 3] = self.radius2_min.to_bits();
            return;
        }
        self.plant(2 * node + 1, right);
    }
}
