//! What moves while the shutter is open.

use glam::{Affine3A, DAffine3, Vec3};
use std::collections::{BTreeSet, HashMap};

/// Equal steps from the shutter's opening to its closing at which places are asked for; a power of
/// two, so that fewer steps are among them.
pub const STEPS: usize = 16;

/// How far a corner may be from its true place, as part of its mesh's size: the sagitta of an arc of
/// 5 degrees, on which a point goes straight instead, is 0.95e-3 of the radius.
const TOLERANCE: f32 = 1e-3;

/// The nodes that move between the shutter's opening and its closing.
#[derive(Default)]
pub struct Tracks {
    /// World from node at `STEPS + 1` times.
    pub worlds: HashMap<usize, Vec<DAffine3>>,
    /// Nodes whose mesh's weights change.
    pub morphed: BTreeSet<usize>,
}

impl Tracks {
    /// Whether a node does not stand still.
    pub fn moves(&self, node: usize) -> bool {
        let track = self.worlds.get(&node);
        track.is_some_and(|track| track.iter().any(|place| *place != track[0]))
    }

    /// Where a node that moves is when the shutter closes.
    pub fn closing(&self, node: usize) -> Option<DAffine3> {
        let track = self.worlds.get(&node).filter(|_| self.moves(node));
        track.and_then(|track| track.last().copied())
    }

    /// Where an object of a node is at further times, in as few equal steps as keep its corners, which
    /// are within `reach` of its origin along its axes, close to their places.
    pub fn motion(&self, node: usize, node_from_object: DAffine3, reach: Vec3) -> Box<[Affine3A]> {
        let Some(track) = self.worlds.get(&node).filter(|_| self.moves(node)) else {
            return Box::default();
        };
        let places: Vec<Affine3A> = track
            .iter()
            .map(|world_from_node| super::node::to_f32(*world_from_node * node_from_object))
            .collect();
        keys(&places, reach)
    }
}

/// The fewest of `STEPS + 1` places, the first left out, between which straight lines are true enough.
pub fn keys(places: &[Affine3A], reach: Vec3) -> Box<[Affine3A]> {
    let columns = |matrix: &Affine3A| {
        let m = matrix.matrix3;
        [m.x_axis, m.y_axis, m.z_axis, matrix.translation]
    };
    // How far the farthest corner moves by a difference of matrices, at most.
    let distance = |columns: [glam::Vec3A; 4]| {
        let [x, y, z, translation] = columns.map(|column| column.length());
        translation + x * reach.x + y * reach.y + z * reach.z
    };
    let size = places.iter().map(|place| {
        let [x, y, z, _] = columns(place).map(|column| column.length());
        x * reach.x + y * reach.y + z * reach.z
    });
    let tolerance = TOLERANCE * size.fold(0.0, f32::max);
    let mut steps = 1;
    while steps < STEPS {
        let stride = STEPS / steps;
        let straight = (0..STEPS).all(|step| {
            let (first, t) = (step - step % stride, (step % stride) as f32 / stride as f32);
            let (a, b) = (columns(&places[first]), columns(&places[first + stride]));
            let truth = columns(&places[step]);
            let error = [0, 1, 2, 3].map(|i| a[i].lerp(b[i], t) - truth[i]);
            distance(error) <= tolerance
        });
        if straight {
            break;
        }
        steps *= 2;
    }
    let stride = STEPS / steps;
    places
        .iter()
        .copied()
        .skip(stride)
        .step_by(stride)
        .collect()
}
