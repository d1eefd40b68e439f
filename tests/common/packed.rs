//! Packed scenes that tests fill by hand.

use bytemuck::Zeroable;
use snell::pack::Packed;
use snell::shared::{Frame, LightNode, NONE, Tables, Texture};

/// Nothing in it. Arrays that a binding cannot leave empty have one entry of zeros.
pub fn empty_packed() -> Packed {
    Packed {
        frame: Frame {
            environment_cos: 1.0,
            environment_size: [1, 1],
            environment_cells: [1, 1],
            root: NONE,
            ..Frame::zeroed()
        },
        tables: Box::new(Tables::zeroed()),
        nodes: vec![[0; 4]; 5],
        triangles: Vec::new(),
        instances: Vec::new(),
        vertices: Vec::new(),
        materials: Vec::new(),
        texels: Vec::new(),
        lights: Vec::new(),
        light_nodes: vec![LightNode::zeroed()],
        environment: vec![[0.0; 4]],
        environment_cells: vec![[1.0, 0.0]; 2],
    }
}

/// A texture that is not there.
pub fn no_texture() -> Texture {
    Texture {
        texels: NONE,
        ..identity_texture([0, 0], 0)
    }
}

/// Texels at word 0, no transform, repeating; `format` is format | filter << 8.
pub fn identity_texture(size: [u32; 2], format: u32) -> Texture {
    Texture {
        row_u: [1.0, 0.0, 0.0],
        texels: 0,
        row_v: [0.0, 1.0, 0.0],
        wrap: 0,
        size,
        texcoord: 0,
        format,
    }
}
