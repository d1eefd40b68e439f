//! The tree over many lights with a place (see `shaders/light/tree.wgsl`).

use super::geometry::Geometry;
use super::lights::{alias_table, is_infinite};
use super::{PackError, index};
use crate::shared::{
    INSTANCE_FLIPPED, LIGHT_CLUSTER, LIGHT_SPOT, LIGHT_TRIANGLE, Light, LightNode,
    MATERIAL_DOUBLE_SIDED, Material, NONE,
};
use bytemuck::Zeroable;
use glam::{DVec3, Vec3, Vec4};

/// From this many lights with a place on they are chosen by a tree; two are mostly the halves of one lamp, and
/// the walk between them costs more than it brings (benches/RESULTS.md).
pub const TREE_LIGHTS_MIN: usize = 3;

/// No sphere is smaller than this part of the scene's radius, so that a surface at a light does not give
/// it all of the choice.
const RADIUS_MIN: f32 = 1e-4;

/// The tree, and where its lights are.
pub struct LightTree {
    /// Entries of the alias table: the lights before those in the tree.
    pub light_count: u32,
    /// Triangles among the lights in the tree.
    pub triangles: u32,
    /// A power of two, and the number of the first leaf; 0: there is no tree.
    pub leaves: u32,
    /// `2 * leaves`, or one of zeros.
    pub nodes: Vec<LightNode>,
}

/// A light in the tree.
#[derive(Clone, Copy)]
struct Leaf {
    low: Vec3,
    high: Vec3,
    /// The direction that it faces, unit length, or 0: it shines to all sides.
    facing: DVec3,
    weight: f32,
    light: u32,
}

impl Leaf {
    fn new(light: &Light, index: usize, geometry: &Geometry, materials: &[Material]) -> Self {
        let place = Vec3::from(light.position);
        let mut leaf = Self {
            low: place,
            high: place,
            facing: DVec3::ZERO,
            weight: light.weight,
            light: index as u32,
        };
        match light.kind {
            LIGHT_SPOT => leaf.facing = Vec3::from(light.direction).as_dvec3(),
            LIGHT_TRIANGLE => leaf.stretch(light, geometry, materials),
            _ => {}
        }
        leaf
    }

    /// To where a triangle is at all times, which is between its places at the keys of its instance's motion.
    fn stretch(&mut self, light: &Light, geometry: &Geometry, materials: &[Material]) {
        let edges = [light.direction, light.edge2].map(Vec3::from);
        for corner in edges.map(|edge| Vec3::from(light.position) + edge) {
            self.include(corner);
        }
        let triangle = &geometry.triangles[light.triangle as usize];
        let instance = &geometry.instances[light.instance as usize];
        let further = geometry.further_keys(instance);
        if !further.is_empty() {
            let p0 = Vec3::from(triangle.p0);
            let corners = [
                p0,
                p0 + Vec3::from(triangle.e1),
                p0 + Vec3::from(triangle.e2),
            ];
            for key in further.iter().chain([instance]) {
                let rows = key.world_from_object.map(Vec4::from);
                for corner in corners {
                    self.include(Vec3::from(rows.map(|row| row.dot(corner.extend(1.0)))));
                }
            }
            return;
        }
        if materials[triangle.material as usize].flags & MATERIAL_DOUBLE_SIDED != 0 {
            return;
        }
        let [edge1, edge2] = edges.map(|edge| edge.as_dvec3());
        let side = match instance.flags & INSTANCE_FLIPPED {
            0 => 1.0,
            _ => -1.0,
        };
        let across = edge1.normalize_or_zero().cross(edge2.normalize_or_zero());
        self.facing = side * across.normalize_or_zero();
    }

    fn include(&mut self, corner: Vec3) {
        self.low = self.low.min(corner);
        self.high = self.high.max(corner);
    }
}

/// Where there are many lights with a place, puts them behind the others, triangles first by instance and
/// triangle, with one entry for all of them in the alias table, and builds their tree. Their
/// `alias_index` becomes the number of their leaf. The lights come weighed.
pub fn build_light_tree(
    lights: &mut Vec<Light>,
    geometry: &Geometry,
    materials: &[Material],
    scene_radius: f32,
) -> Result<LightTree, PackError> {
    let placed = lights.iter().filter(|light| !is_infinite(light)).count();
    if placed < TREE_LIGHTS_MIN {
        return Ok(LightTree {
            light_count: index("lights", lights.len())?,
            triangles: 0,
            leaves: 0,
            nodes: vec![LightNode::zeroed()],
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
        .map(|(index, light)| Leaf::new(light, index, geometry, materials))
        .collect();
    let first_leaf = placed.next_power_of_two();
    let radius2_min = (RADIUS_MIN * scene_radius).powi(2).max(f32::MIN_POSITIVE);
    // A leaf without a light is never taken, but asked.
    let empty = LightNode {
        radius2: radius2_min,
        light: NONE,
        ..LightNode::zeroed()
    };
    let mut tree = Tree {
        nodes: vec![empty; 2 * first_leaf],
        first_leaf,
        radius2_min,
    };
    tree.plant(1, &mut leaves);
    for (number, node) in tree.nodes.iter().enumerate().skip(first_leaf) {
        if let Some(light) = lights.get_mut(node.light as usize) {
            light.alias_index = number as u32;
        }
    }
    let triangles = lights[light_count..].iter();
    Ok(LightTree {
        light_count: index("lights", light_count)?,
        triangles: triangles
            .filter(|light| light.kind == LIGHT_TRIANGLE)
            .count() as u32,
        leaves: index("nodes of the light tree", 2 * first_leaf)? / 2,
        nodes: tree.nodes,
    })
}

struct Tree {
    nodes: Vec<LightNode>,
    first_leaf: usize,
    radius2_min: f32,
}

impl Tree {
    /// Writes a node and what is below it. Halves the lights at the median of their places along the
    /// longest axis; each node's number of lights fits the leaves below it.
    fn plant(&mut self, node: usize, leaves: &mut [Leaf]) {
        let low = (leaves.iter().map(|leaf| leaf.low)).fold(Vec3::INFINITY, Vec3::min);
        let high = (leaves.iter().map(|leaf| leaf.high)).fold(Vec3::NEG_INFINITY, Vec3::max);
        let centre = low.midpoint(high);
        let radius2 = (high - centre).length_squared();
        let weight: f64 = leaves.iter().map(|leaf| f64::from(leaf.weight)).sum();
        let facing: DVec3 = (leaves.iter())
            .map(|leaf| f64::from(leaf.weight) * leaf.facing)
            .sum();
        self.nodes[node] = LightNode {
            centre: centre.to_array(),
            radius2: radius2.max(self.radius2_min),
            facing: (facing / weight.max(f64::MIN_POSITIVE))
                .as_vec3()
                .to_array(),
            weight: weight as f32,
            light: NONE,
            ..LightNode::zeroed()
        };
        if let ([leaf], true) = (&*leaves, node >= self.first_leaf) {
            self.nodes[node].light = leaf.light;
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
        if !right.is_empty() {
            self.plant(2 * node + 1, right);
        }
    }
}
