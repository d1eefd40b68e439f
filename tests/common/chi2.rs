//! Bins of directions for Pearson's chi-square test, and integrals of a density over them.
//!
//! The sphere is cut by the samples themselves: a k-d tree over (theta, phi), grown from a training set,
//! whose leaves hold about equal shares of it. So bins are small where a lobe is narrow. The density is
//! integrated over them, adaptively and many cells at a time (it may live on a GPU). Then a fresh set of
//! samples is to be counted.
#![allow(dead_code, reason = "each test file uses a part of this")]

use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Three nodes of Gauss and Legendre on [0, 1].
const NODES: [(f64, f64); 3] = [
    (0.112_701_665_379_258_3, 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.887_298_334_620_741_7, 5.0 / 18.0),
];
/// Radians; cells are graded towards a peak down to this size, and further by what they hold.
const FINEST: f64 = 2e-4;
/// Cuts at most, should many samples be the same.
const DEPTH_MAX: usize = 40;
/// Halvings of a cell's sides at most.
const LEVELS: usize = 9;

/// Significance for one of `tests` tests, so that all together have `level`.
pub fn sidak(level: f64, tests: usize) -> f64 {
    1.0 - (1.0 - level).powf(1.0 / tests as f64)
}

#[derive(Clone, Copy, Debug)]
struct Cell {
    theta: [f64; 2],
    phi: [f64; 2],
}

impl Cell {
    fn halves(self, axis: usize, at: f64) -> [Self; 2] {
        let (mut low, mut high) = (self, self);
        if axis == 0 {
            (low.theta[1], high.theta[0]) = (at, at);
        } else {
            (low.phi[1], high.phi[0]) = (at, at);
        }
        [low, high]
    }

    fn quarters(self) -> [Self; 4] {
        let middle = |[a, b]: [f64; 2]| 0.5 * (a + b);
        let [a, b] = self.halves(0, middle(self.theta));
        let ([a, c], [b, d]) = (a.halves(1, middle(self.phi)), b.halves(1, middle(self.phi)));
        [a, b, c, d]
    }

    /// The cell cut so that no part is wider than it is far from every peak: a bin at the edge of a narrow
    /// lobe is huge, and what is in it lies at one of its corners.
    fn graded(self, peaks: &[[f64; 2]], parts: &mut Vec<Self>) {
        let [t0, t1] = self.theta;
        let widest = if t0 < FRAC_PI_2 && t1 > FRAC_PI_2 {
            1.0
        } else {
            t0.sin().max(t1.sin())
        };
        let sizes = [t1 - t0, (self.phi[1] - self.phi[0]) * widest];
        let away = peaks
            .iter()
            .map(|&peak| self.distance(peak))
            .fold(f64::INFINITY, f64::min);
        if sizes[0].max(sizes[1]) <= away.max(FINEST) {
            parts.push(self);
            return;
        }
        let halves = if sizes[0] > sizes[1] {
            self.halves(0, 0.5 * (t0 + t1))
        } else {
            self.halves(1, 0.5 * (self.phi[0] + self.phi[1]))
        };
        for half in halves {
            half.graded(peaks, parts);
        }
    }

    /// Roughly, from a direction to the nearest point of the cell.
    fn distance(self, [theta, phi]: [f64; 2]) -> f64 {
        let gap = |x: f64, [a, b]: [f64; 2]| (a - x).max(x - b).max(0.0);
        let turned = [-TAU, 0.0, TAU].map(|turn| gap(phi + turn, self.phi));
        let along = turned.into_iter().fold(f64::INFINITY, f64::min) * theta.sin();
        gap(theta, self.theta).hypot(along)
    }

    /// Directions and weights per solid angle of the product rule.
    fn nodes(self) -> impl Iterator<Item = (DVec3, f64)> {
        let ([t0, t1], [p0, p1]) = (self.theta, self.phi);
        NODES.into_iter().flat_map(move |(x, wx)| {
            NODES.into_iter().map(move |(y, wy)| {
                let (sin, cos) = (t0 + (t1 - t0) * x).sin_cos();
                let (sin_phi, cos_phi) = (p0 + (p1 - p0) * y).sin_cos();
                let weight = wx * wy * (t1 - t0) * (p1 - p0) * sin;
                (DVec3::new(sin * cos_phi, sin * sin_phi, cos), weight)
            })
        })
    }
}

enum Node {
    /// Axis (0 theta, 1 phi), place, children.
    Split(usize, f64, [usize; 2]),
    /// Bin.
    Leaf(usize),
}

/// The sphere cut into bins.
pub struct Partition {
    nodes: Vec<Node>,
    /// What the density is integrated over, and the bin that each cell is part of.
    cells: Vec<(usize, Cell)>,
    bin_count: usize,
}

/// theta from the pole, accurate near it (an arc cosine is not), and phi from 0 to 2 pi.
fn angles(w: DVec3) -> [f64; 2] {
    [w.x.hypot(w.y).atan2(w.z), w.y.atan2(w.x).rem_euclid(TAU)]
}

impl Partition {
    /// Bins of at most `size` training samples; `peaks` are directions near which the density is large.
    pub fn new(samples: &[DVec3], size: usize, peaks: &[DVec3]) -> Self {
        let mut partition = Self {
            nodes: vec![Node::Leaf(0)],
            cells: Vec::new(),
            bin_count: 0,
        };
        let mut points: Vec<[f64; 2]> = samples.iter().copied().map(angles).collect();
        let peaks: Vec<[f64; 2]> = peaks.iter().copied().map(angles).collect();
        let sphere = Cell {
            theta: [0.0, PI],
            phi: [0.0, TAU],
        };
        // The horizon first: densities jump there.
        let above = to_the_front(&mut points, |p| p[0] < FRAC_PI_2);
        let [upper, lower] = sphere.halves(0, FRAC_PI_2);
        let (up, down) = points.split_at_mut(above);
        let children = [
            partition.grow(up, upper, size, &peaks, 0),
            partition.grow(down, lower, size, &peaks, 0),
        ];
        partition.nodes[0] = Node::Split(0, FRAC_PI_2, children);
        partition
    }

    fn grow(
        &mut self,
        points: &mut [[f64; 2]],
        cell: Cell,
        size: usize,
        peaks: &[[f64; 2]],
        depth: usize,
    ) -> usize {
        let index = self.nodes.len();
        self.nodes.push(Node::Leaf(self.bin_count));
        if points.len() <= size || depth > DEPTH_MAX {
            let mut parts = Vec::new();
            cell.graded(peaks, &mut parts);
            self.cells
                .extend(parts.into_iter().map(|part| (self.bin_count, part)));
            self.bin_count += 1;
            return index;
        }
        let axis = depth % 2;
        let middle = points.len() / 2;
        points.select_nth_unstable_by(middle, |a, b| a[axis].total_cmp(&b[axis]));
        let at = points[middle][axis];
        let [low, high] = cell.halves(axis, at);
        let (left, right) = points.split_at_mut(middle);
        let children = [
            self.grow(left, low, size, peaks, depth + 1),
            self.grow(right, high, size, peaks, depth + 1),
        ];
        self.nodes[index] = Node::Split(axis, at, children);
        index
    }

    /// The bin that a direction falls into.
    pub fn bin(&self, w: DVec3) -> usize {
        let point = angles(w);
        let mut node = 0;
        loop {
            match self.nodes[node] {
                Node::Split(axis, at, children) => node = children[usize::from(point[axis] >= at)],
                Node::Leaf(bin) => return bin,
            }
        }
    }

    pub fn bin_count(&self) -> usize {
        self.bin_count
    }

    /// The integrals over each bin of N quantities per solid angle, given at many directions at a time;
    /// a cell is cut in four until that changes none of its integrals by more than `tolerance`.
    pub fn integrate<const N: usize>(
        &self,
        tolerance: f64,
        density: impl Fn(&[DVec3]) -> Vec<[f64; N]>,
    ) -> Vec<[f64; N]> {
        let sums = |cells: &[(usize, Cell)]| -> Vec<[f64; N]> {
            let nodes: Vec<(DVec3, f64)> =
                cells.iter().flat_map(|(_, cell)| cell.nodes()).collect();
            let directions: Vec<DVec3> = nodes.iter().map(|node| node.0).collect();
            let values = density(&directions);
            let per_cell = NODES.len() * NODES.len();
            nodes
                .chunks(per_cell)
                .zip(values.chunks(per_cell))
                .map(|(nodes, values)| {
                    std::array::from_fn(|k| nodes.iter().zip(values).map(|(n, v)| n.1 * v[k]).sum())
                })
                .collect()
        };
        let mut totals = vec![[0.0; N]; self.bin_count];
        let mut active = self.cells.clone();
        let mut coarse = sums(&active);
        for level in 0..LEVELS {
            let quarters: Vec<(usize, Cell)> = active
                .iter()
                .flat_map(|&(bin, cell)| cell.quarters().map(|quarter| (bin, quarter)))
                .collect();
            let fine = sums(&quarters);
            let (mut next, mut next_coarse) = (Vec::new(), Vec::new());
            for (i, parts) in fine.chunks(4).enumerate() {
                let sum: [f64; N] = std::array::from_fn(|k| parts.iter().map(|p| p[k]).sum());
                let settled = (0..N).all(|k| (sum[k] - coarse[i][k]).abs() <= tolerance);
                if settled || level + 1 == LEVELS {
                    for k in 0..N {
                        totals[active[i].0][k] += sum[k];
                    }
                } else {
                    next.extend_from_slice(&quarters[4 * i..4 * i + 4]);
                    next_coarse.extend_from_slice(parts);
                }
            }
            if next.is_empty() {
                break;
            }
            (active, coarse) = (next, next_coarse);
        }
        totals
    }
}

/// Brings the points that `holds` is true of to the front; how many they are.
fn to_the_front(points: &mut [[f64; 2]], holds: impl Fn(&[f64; 2]) -> bool) -> usize {
    points.sort_by_key(|point| !holds(point));
    points.partition_point(holds)
}
