//! From a scene to the flat arrays that both renderers read: the fork in the data flow.

pub mod model;

use crate::shared::{Frame, Instance, Light, Material, Tables, Triangle};

/// Everything a renderer reads, as it goes to the GPU byte for byte.
#[derive(Clone)]
pub struct Packed {
    /// One per picture; a renderer sets tile and sample range in its own copy.
    pub frame: Frame,
    pub tables: Box<Tables>,
    /// CWBVH nodes, five words of 16 bytes each, of all hierarchies.
    pub nodes: Vec<[u32; 4]>,
    pub triangles: Vec<Triangle>,
    /// In the order of the top-level hierarchy's leaves.
    pub instances: Vec<Instance>,
    /// Words of f32: see `LAYOUT_*`; three words of normal come first in each vertex.
    pub vertices: Vec<f32>,
    pub materials: Vec<Material>,
    pub texels: Vec<u32>,
    pub lights: Vec<Light>,
    /// Radiance of the environment map, `frame.environment_size`; at least one texel.
    pub environment: Vec<[f32; 4]>,
    /// `frame.environment_cells` rows of `x + 1` entries (cumulative probability in the row, density
    /// per unit square of (u, v)); the last entry of a row holds the rows' own cumulative probability.
    pub environment_cells: Vec<[f32; 2]>,
}
