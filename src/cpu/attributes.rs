//! Vertex attributes of a triangle, interpolated where a ray met it or a light was sampled.
//! `barycentrics` are the weights of corners 1 and 2. See `LAYOUT_*` for what a vertex holds.

use crate::pack::Packed;
use crate::shared::{LAYOUT_COLOR, LAYOUT_TANGENT, LAYOUT_TEXCOORDS_SHIFT, Triangle};
use glam::{DVec2, DVec3, DVec4};

/// Words of the normal, which comes first and is always there.
pub const ATTRIBUTE_NORMAL_WORDS: u32 = 3;

pub fn attribute_color_offset(vertex_layout: u32) -> u32 {
    ATTRIBUTE_NORMAL_WORDS
        + if vertex_layout & LAYOUT_TANGENT != 0 {
            4
        } else {
            0
        }
}

pub fn attribute_texcoord_offset(vertex_layout: u32) -> u32 {
    attribute_color_offset(vertex_layout)
        + if vertex_layout & LAYOUT_COLOR != 0 {
            4
        } else {
            0
        }
}

/// One word of an attribute, `offset` words into each of the three vertices.
pub fn attribute_word(
    packed: &Packed,
    triangle: &Triangle,
    barycentrics: DVec2,
    offset: u32,
) -> f64 {
    let word = |vertex: u32| f64::from(packed.vertices[(vertex + offset) as usize]);
    (1.0 - barycentrics.x - barycentrics.y) * word(triangle.vertex0)
        + barycentrics.x * word(triangle.vertex1)
        + barycentrics.y * word(triangle.vertex2)
}

/// Object space; not normalised, since the object-to-world map comes first.
pub fn attribute_normal(packed: &Packed, triangle: &Triangle, barycentrics: DVec2) -> DVec3 {
    DVec3::new(
        attribute_word(packed, triangle, barycentrics, 0),
        attribute_word(packed, triangle, barycentrics, 1),
        attribute_word(packed, triangle, barycentrics, 2),
    )
}

/// Object space, w = handedness; zero where the mesh has no tangents.
pub fn attribute_tangent(packed: &Packed, triangle: &Triangle, barycentrics: DVec2) -> DVec4 {
    if triangle.vertex_layout & LAYOUT_TANGENT == 0 {
        return DVec4::ZERO;
    }
    DVec4::new(
        attribute_word(packed, triangle, barycentrics, ATTRIBUTE_NORMAL_WORDS),
        attribute_word(packed, triangle, barycentrics, ATTRIBUTE_NORMAL_WORDS + 1),
        attribute_word(packed, triangle, barycentrics, ATTRIBUTE_NORMAL_WORDS + 2),
        // The same at all three corners, so it is read and not interpolated.
        f64::from(packed.vertices[(triangle.vertex0 + ATTRIBUTE_NORMAL_WORDS + 3) as usize]),
    )
}

/// COLOR_0, linear; white where the mesh has none.
pub fn attribute_color(packed: &Packed, triangle: &Triangle, barycentrics: DVec2) -> DVec4 {
    if triangle.vertex_layout & LAYOUT_COLOR == 0 {
        return DVec4::ONE;
    }
    let offset = attribute_color_offset(triangle.vertex_layout);
    DVec4::new(
        attribute_word(packed, triangle, barycentrics, offset),
        attribute_word(packed, triangle, barycentrics, offset + 1),
        attribute_word(packed, triangle, barycentrics, offset + 2),
        attribute_word(packed, triangle, barycentrics, offset + 3),
    )
}

/// TEXCOORD_n of n = texcoord; zero where the mesh has no such set.
pub fn attribute_texcoord(
    packed: &Packed,
    triangle: &Triangle,
    barycentrics: DVec2,
    texcoord: u32,
) -> DVec2 {
    if texcoord >= triangle.vertex_layout >> LAYOUT_TEXCOORDS_SHIFT {
        return DVec2::ZERO;
    }
    let offset = attribute_texcoord_offset(triangle.vertex_layout) + 2 * texcoord;
    DVec2::new(
        attribute_word(packed, triangle, barycentrics, offset),
        attribute_word(packed, triangle, barycentrics, offset + 1),
    )
}
