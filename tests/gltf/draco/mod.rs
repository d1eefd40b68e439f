//! A sheet of 6 x 6 squares as Google's Draco 1.5 compressed it (DracoPy 2.2, whose `encode` was given
//! these vertices and triangles), once traversed and once in sequence, and glTF around it.
#![allow(dead_code, reason = "each test binary uses the parts that it needs")]

use crate::asset::{Asset, F32, U8, U16};
use serde_json::json;

/// 12 bits for positions, 10 for texture coordinates and normals, the rest as it was.
pub const EDGEBREAKER: &[u8] = include_bytes!("edgebreaker.drc");
pub const SEQUENTIAL: &[u8] = include_bytes!("sequential.drc");

pub const POINTS: usize = 56;
pub const TRIANGLES: usize = 72;

/// (x, y) of each point as Google's decoder counts the traversed stream.
#[rustfmt::skip]
pub const TRAVERSED: [(u8, u8); POINTS] = [
    (2, 4), (2, 3), (3, 4), (3, 4), (3, 3), (3, 3), (4, 4), (4, 3), (4, 2), (3, 2), (3, 2), (2, 2),
    (1, 2), (1, 3), (1, 4), (1, 5), (2, 5), (3, 5), (3, 5), (4, 5), (5, 5), (5, 4), (5, 3), (5, 2),
    (5, 1), (4, 1), (3, 1), (3, 1), (2, 1), (1, 1), (0, 0), (0, 1), (0, 2), (0, 3), (0, 4), (0, 5),
    (0, 6), (1, 6), (2, 6), (3, 6), (3, 6), (4, 6), (5, 6), (6, 6), (6, 5), (6, 4), (6, 3), (6, 2),
    (6, 1), (6, 0), (5, 0), (4, 0), (3, 0), (3, 0), (2, 0), (1, 0),
];

/// The sheet without a byte of its accessors in a buffer view.
pub fn sheet(stream: &[u8]) -> Asset {
    Asset::of_primitive(|asset| {
        let view = asset.view(stream);
        let mut accessor = |component: u32, kind: &str, count: usize, normalized: bool| {
            asset.push(
                "accessors",
                json!({"componentType": component, "type": kind, "count": count,
                       "normalized": normalized}),
            )
        };
        json!({
            "indices": accessor(U16, "SCALAR", 3 * TRIANGLES, false),
            "attributes": {
                "POSITION": accessor(F32, "VEC3", POINTS, false),
                "NORMAL": accessor(F32, "VEC3", POINTS, false),
                "TEXCOORD_0": accessor(F32, "VEC2", POINTS, false),
                "COLOR_0": accessor(U8, "VEC4", POINTS, true),
                "JOINTS_0": accessor(U8, "VEC4", POINTS, false),
                "WEIGHTS_0": accessor(F32, "VEC4", POINTS, false),
            },
            "extensions": {"KHR_draco_mesh_compression": {"bufferView": view, "attributes": {
                "JOINTS_0": 10, "WEIGHTS_0": 11, "COLOR_0": 12, "TEXCOORD_0": 13, "NORMAL": 14,
                "POSITION": 15}}},
        })
    })
}
