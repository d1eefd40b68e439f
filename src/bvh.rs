//! Bounding volume hierarchies: obvhs builds them, here they become the packed words that both
//! renderers traverse.
//!
//! Compressed wide nodes of Ylitie, Karras and Laine 2017, "Efficient Incoherent Ray Traversal on
//! GPUs Through Compressed Wide BVHs", section 3: eight children, boxes of eight bits a plane, 80
//! bytes, read as five words of 16 bytes.

use glam::Vec3A;
use obvhs::{
    Boundable, BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, node::Bvh2Node, reinsertion::ReinsertionOptimizer},
    cwbvh::{CwBvh, bvh2_to_cwbvh::bvh2_to_cwbvh, node::CwBvhNode},
    ploc::PlocBuilder,
};

/// Entries of the traversal's stack, in `shaders/bvh.wgsl` and `src/cpu/bvh.rs` alike.
pub const STACK_SIZE: usize = 32;

/// Levels that one hierarchy may have. A traversal keeps at most one entry for each level, and two
/// more where it goes from the top level into a mesh, so two hierarchies fit on the stack.
pub const MAX_DEPTH: usize = (STACK_SIZE - 2) / 2;

/// Words of 16 bytes in a packed node.
pub const NODE_WORDS: usize = 5;

/// Triangles in a leaf: what the node format can hold.
const MAX_TRIANGLES_PER_LEAF: u32 = 3;

/// An axis-aligned box, `min <= max` on every axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    pub min: Vec3A,
    pub max: Vec3A,
}

impl Bounds {
    /// The box of no points: the neutral element of `union`.
    pub const EMPTY: Self = Self {
        min: Vec3A::INFINITY,
        max: Vec3A::NEG_INFINITY,
    };

    pub fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    pub fn of_points(points: impl IntoIterator<Item = Vec3A>) -> Self {
        points.into_iter().fold(Self::EMPTY, |bounds, p| Self {
            min: bounds.min.min(p),
            max: bounds.max.max(p),
        })
    }
}

impl Boundable for Bounds {
    fn aabb(&self) -> Aabb {
        Aabb::new(self.min, self.max)
    }
}

/// A packed hierarchy. Child indices count from its own first node, leaves from its own first
/// primitive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hierarchy {
    pub nodes: Vec<[u32; 4]>,
    /// Leaf position to index of the primitive that was given.
    pub order: Vec<u32>,
    pub depth: usize,
}

/// Builds the hierarchy over `bounds`; none for no boxes. Leaves hold up to three primitives.
///
/// The same input gives the same nodes, whatever the number of threads. Where obvhs' hierarchy is
/// deeper than `MAX_DEPTH`, as it is for hundreds of boxes that coincide, a balanced one is built
/// instead. The caller checks the depth all the same.
pub fn build(bounds: &[Bounds]) -> Option<Hierarchy> {
    if bounds.is_empty() {
        return None;
    }
    let mut binary = cluster(bounds);
    reinsert(&mut binary);
    let hierarchy = if binary_depth(&binary) <= RECURSION_LIMIT {
        pack(&compress(&binary))
    } else {
        Hierarchy::default()
    };
    if !hierarchy.nodes.is_empty() && hierarchy.depth <= MAX_DEPTH {
        return Some(hierarchy);
    }
    Some(pack(&compress(&balance(bounds))))
}

/// obvhs descends binary hierarchies by recursion; this keeps it well within a thread's stack.
const RECURSION_LIMIT: usize = 1000;

/// How much boxes are grown, at most, while they are clustered: part of the largest coordinate.
const JITTER: f32 = 1e-5;

/// Metres; grows boxes all of which are at the origin.
const MIN_GROWTH: f32 = 1e-12;

fn jitter(bounds: &[Bounds]) -> f32 {
    let all = bounds
        .iter()
        .fold(Bounds::EMPTY, |all, &one| all.union(one));
    JITTER * all.min.abs().max(all.max.abs()).max_element()
}

/// Parallel locally-ordered clustering (Meister and Bittner 2018).
///
/// It merges neighbours that are each other's nearest. Among boxes in a row, or in one place, all are
/// equally near, one pair is merged a pass, and the time grows with the square of their number. So
/// each box is grown by a little that its number decides, and the boxes of the nodes are made anew.
fn cluster(bounds: &[Bounds]) -> Bvh2 {
    let settings = BvhBuildParams::medium_build();
    let all = bounds
        .iter()
        .fold(Bounds::EMPTY, |all, &one| all.union(one));
    let reach = JITTER * all.min.abs().max(all.max.abs()).max_element();
    let grown: Vec<Bounds> = bounds
        .iter()
        .enumerate()
        .map(|(number, bounds)| {
            // Multiplicative hashing (Knuth 1998, section 6.4): 2^32 over the golden ratio.
            let hash = (number as u32).wrapping_mul(0x9e37_79b9).reverse_bits();
            let by = Vec3A::splat(reach * (hash as f32 / u32::MAX as f32));
            Bounds {
                min: bounds.min - by,
                max: bounds.max + by,
            }
        })
        .collect();
    let mut binary = PlocBuilder::with_capacity(bounds.len()).build(
        settings.ploc_search_distance,
        &grown,
        (0..bounds.len() as u32).collect(),
        settings.sort_precision,
        settings.search_depth_threshold,
    );
    for index in (0..binary.nodes.len()).rev() {
        let node = binary.nodes[index];
        let first = node.first_index as usize;
        let aabb = if node.is_leaf() {
            bounds[binary.primitive_indices[first] as usize].aabb()
        } else {
            // Children stand behind their parents.
            binary.nodes[first]
                .aabb()
                .union(binary.nodes[first + 1].aabb())
        };
        binary.nodes[index].set_aabb(aabb);
    }
    binary
}

/// The part of the nodes that the first round of reinsertion looks at: more take longer than rays gain.
const REINSERTED: f32 = 0.05;

/// As many nodes take no time, and are all that small scenes have.
const REINSERTED_AT_LEAST: f32 = 1000.0;

/// Takes large nodes out and puts each where the others grow least, in rounds over ever fewer from the top
/// (Meister and Bittner 2018, "Parallel Reinsertion for Bounding Volume Hierarchy Optimization").
///
/// obvhs' own choice of candidates leaves those of one size in an order that its threads decide; here
/// they keep that of the nodes.
fn reinsert(binary: &mut Bvh2) {
    let mut optimizer = ReinsertionOptimizer::default();
    let all = binary.nodes.len();
    let first = (all as f32 * REINSERTED).max(REINSERTED_AT_LEAST);
    for round in (1..32).step_by(2) {
        let count = (first / round as f32) as usize;
        let last = all.min(2 * count + 1) as u32;
        let mut candidates: Vec<u32> = (1..last).collect();
        let area = |index: u32| binary.nodes[index as usize].aabb().half_area();
        candidates.sort_by(|&a, &b| area(b).total_cmp(&area(a)));
        candidates.truncate(count);
        optimizer.run_with_candidates(binary, &candidates, 1);
    }
}

fn compress(binary: &Bvh2) -> CwBvh {
    bvh2_to_cwbvh(binary, MAX_TRIANGLES_PER_LEAF, true, false)
}

fn binary_depth(binary: &Bvh2) -> usize {
    let mut deepest = 0;
    let mut stack = vec![(0_usize, 1_usize)];
    while let Some((index, depth)) = stack.pop() {
        deepest = deepest.max(depth);
        let node = &binary.nodes[index];
        if !node.is_leaf() {
            stack.push((node.first_index as usize, depth + 1));
            stack.push((node.first_index as usize + 1, depth + 1));
        }
    }
    deepest
}

/// Splits at the median along the longest axis until one box is left. All boxes are grown alike, so
/// that none is without area: the price of what has none says nothing about how to collapse it.
fn balance(bounds: &[Bounds]) -> Bvh2 {
    let by = Vec3A::splat(jitter(bounds).max(MIN_GROWTH));
    let bounds: Vec<Bounds> = bounds
        .iter()
        .map(|bounds| Bounds {
            min: bounds.min - by,
            max: bounds.max + by,
        })
        .collect();
    let mut order: Vec<u32> = (0..bounds.len() as u32).collect();
    let mut nodes = vec![Bvh2Node::default()];
    let mut work = vec![(0_usize, 0..bounds.len())];
    while let Some((index, range)) = work.pop() {
        let members = &mut order[range.clone()];
        let around = members.iter().fold(Bounds::EMPTY, |all, &member| {
            all.union(bounds[member as usize])
        });
        if members.len() == 1 {
            nodes[index] = Bvh2Node::new(around.aabb(), 1, range.start as u32);
            continue;
        }
        let size = around.max - around.min;
        let axis = (0..3).fold(
            0,
            |best, axis| {
                if size[axis] > size[best] { axis } else { best }
            },
        );
        let center = |member: &u32| {
            let b = &bounds[*member as usize];
            0.5 * b.min[axis] + 0.5 * b.max[axis]
        };
        let half = members.len() / 2;
        members.select_nth_unstable_by(half, |a, b| center(a).total_cmp(&center(b)).then(a.cmp(b)));
        let first_child = nodes.len();
        nodes.resize(first_child + 2, Bvh2Node::default());
        nodes[index] = Bvh2Node::new(around.aabb(), 0, first_child as u32);
        let middle = range.start + half;
        work.push((first_child, range.start..middle));
        work.push((first_child + 1, middle..range.end));
    }
    Bvh2 {
        nodes,
        primitive_indices: order,
        ..Bvh2::default()
    }
}

fn pack(hierarchy: &CwBvh) -> Hierarchy {
    let nodes = hierarchy
        .nodes
        .iter()
        .flat_map(|node| bytemuck::cast::<CwBvhNode, [[u32; 4]; NODE_WORDS]>(*node))
        .collect();
    Hierarchy {
        nodes,
        order: hierarchy.primitive_indices.clone(),
        depth: depth(hierarchy),
    }
}

fn depth(hierarchy: &CwBvh) -> usize {
    let mut deepest = 0;
    let mut stack = vec![(0_usize, 1_usize)];
    while let Some((index, depth)) = stack.pop() {
        deepest = deepest.max(depth);
        let node = &hierarchy.nodes[index];
        let children = node.imask.count_ones() as usize;
        let first = node.child_base_idx as usize;
        stack.extend((first..first + children).map(|child| (child, depth + 1)));
    }
    deepest
}

/// Moves a packed hierarchy's nodes to where they stand in the array of all nodes: word 4 of a node
/// is the index of its first inner child. Leaves go on counting from the hierarchy's first primitive.
pub fn rebase(nodes: &mut [[u32; 4]], first_node: u32) {
    for node in nodes.chunks_exact_mut(NODE_WORDS) {
        node[1][0] += first_node;
    }
}
