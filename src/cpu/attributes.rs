//! Vertex attributes of a triangle, interpolated where a ray met it or a light was sampled.
//! `barycentrics` are the weights of corners 1 and 2. See `LAYOUT_*` for what a vertex holds.

use crate::pack::Packed;
use crate::shared::{
    LAYOUT_COLOR, LAYOUT_COLOR_UNORM, LAYOUT_TANGENT, LAYOUT_TEXCOORD_UNORM,
    LAYOUT_TEXCOORDS_SHIFT, NORMAL_STEPS, TANGENT_STEPS, Triangle,
};
use glam::{DVec2, DVec3, DVec4, IVec3, UVec2};

/// Words of the normal, which comes first and is always there.
pub const ATTRIBUTE_NORMAL_WORDS: u32 = 1;

pub fn attribute_color_offset(vertex_layout: u32) -> u32 {
    ATTRIBUTE_NORMAL_WORDS + u32::from(vertex_layout & LAYOUT_TANGENT != 0)
}

pub fn attribute_texcoord_offset(vertex_layout: u32) -> u32 {
    let words = if vertex_layout & LAYOUT_COLOR_UNORM != 0 {
        1
    } else {
        4
    };
    let there = vertex_layout & LAYOUT_COLOR != 0;
    attribute_color_offset(vertex_layout) + if there { words } else { 0 }
}

/// The direction at (x, y) of the octahedral map whose corners are `steps` from its centre, unit length;
/// zero at x = -steps - 1, which is off the map. Directions along an axis are exact.
pub fn octahedral_direction(x: i32, y: i32, steps: i32) -> DVec3 {
    // Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit Vectors", listing 1.
    if x < -steps {
        return DVec3::ZERO;
    }
    let z = steps - x.abs() - y.abs();
    let beyond = (-z).max(0);
    let towards_zero = |at: i32| if at >= 0 { at - beyond } else { at + beyond };
    let v = IVec3::new(towards_zero(x), towards_zero(y), z).as_dvec3();
    v / v.dot(v).sqrt()
}

/// x in the low half of the word, y in the high one.
pub fn unpack_normal(word: u32) -> DVec3 {
    octahedral_direction(
        (word << 16) as i32 >> 16,
        word as i32 >> 16,
        NORMAL_STEPS as i32,
    )
}

/// x in the low 15 bits of the word, y in the next 15; w, -1, 0 or 1, in the rest.
pub fn unpack_tangent(word: u32) -> DVec4 {
    let direction = octahedral_direction(
        (word << 17) as i32 >> 17,
        (word << 2) as i32 >> 17,
        TANGENT_STEPS as i32,
    );
    direction.extend(f64::from(word as i32 >> 30))
}

/// One word of an attribute in float32, `offset` words into each of the three vertices.
pub fn attribute_float(
    packed: &Packed,
    triangle: &Triangle,
    barycentrics: DVec2,
    offset: u32,
) -> f64 {
    let word = |vertex: u32| f64::from(f32::from_bits(packed.vertices[(vertex + offset) as usize]));
    (1.0 - barycentrics.x - barycentrics.y) * word(triangle.vertex0)
        + barycentrics.x * word(triangle.vertex1)
        + barycentrics.y * word(triangle.vertex2)
}

/// A word with two numbers in steps of 1/65535, the first one in the low half.
pub fn attribute_unorm2(
    packed: &Packed,
    triangle: &Triangle,
    barycentrics: DVec2,
    offset: u32,
) -> DVec2 {
    let pair = |vertex: u32| {
        let word = packed.vertices[(vertex + offset) as usize];
        UVec2::new(word & 65535, word >> 16).as_dvec2()
    };
    let sum = (1.0 - barycentrics.x - barycentrics.y) * pair(triangle.vertex0)
        + barycentrics.x * pair(triangle.vertex1)
        + barycentrics.y * pair(triangle.vertex2);
    sum / 65535.0
}

/// Four numbers in steps of 1/255, the first one in the lowest byte.
pub fn unpack_color(word: u32) -> DVec4 {
    DVec4::from_array(word.to_le_bytes().map(f64::from)) / 255.0
}

/// Object space; not normalised, since the object-to-world map comes first.
pub fn attribute_normal(packed: &Packed, triangle: &Triangle, barycentrics: DVec2) -> DVec3 {
    let normal = |vertex: u32| unpack_normal(packed.vertices[vertex as usize]);
    (1.0 - barycentrics.x - barycentrics.y) * normal(triangle.vertex0)
        + barycentrics.x * normal(triangle.vertex1)
        + barycentrics.y * normal(triangle.vertex2)
}

/// Object space, w = handedness; zero where the mesh has no tangents.
pub fn attribute_tangent(packed: &Packed, triangle: &Triangle, barycentrics: DVec2) -> DVec4 {
    if triangle.vertex_layout & LAYOUT_TANGENT == 0 {
        return DVec4::ZERO;
    }
    let tangent =
        |vertex: u32| unpack_tangent(packed.vertices[(vertex + ATTRIBUTE_NORMAL_WORDS) as usize]);
    let corner0 = tangent(triangle.vertex0);
    let sum = (1.0 - barycentrics.x - barycentrics.y) * corner0
        + barycentrics.x * tangent(triangle.vertex1)
        + barycentrics.y * tangent(triangle.vertex2);
    // The handedness is the same at all three corners, so it is read and not interpolated.
    sum.with_w(corner0.w)
}

/// COLOR_0, linear; white where the mesh has none.
pub fn attribute_color(packed: &Packed, triangle: &Triangle, barycentrics: DVec2) -> DVec4 {
    if triangle.vertex_layout & LAYOUT_COLOR == 0 {
        return DVec4::ONE;
    }
    let offset = attribute_color_offset(triangle.vertex_layout);
    if triangle.vertex_layout & LAYOUT_COLOR_UNORM != 0 {
        let color = |vertex: u32| unpack_color(packed.vertices[(vertex + offset) as usize]);
        return (1.0 - barycentrics.x - barycentrics.y) * color(triangle.vertex0)
            + barycentrics.x * color(triangle.vertex1)
            + barycentrics.y * color(triangle.vertex2);
    }
    DVec4::new(
        attribute_float(packed, triangle, barycentrics, offset),
        attribute_float(packed, triangle, barycentrics, offset + 1),
        attribute_float(packed, triangle, barycentrics, offset + 2),
        attribute_float(packed, triangle, barycentrics, offset + 3),
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
    let first = attribute_texcoord_offset(triangle.vertex_layout);
    if triangle.vertex_layout & LAYOUT_TEXCOORD_UNORM != 0 {
        return attribute_unorm2(packed, triangle, barycentrics, first + texcoord);
    }
    let word = |offset| attribute_float(packed, triangle, barycentrics, offset);
    DVec2::new(word(first + 2 * texcoord), word(first + 2 * texcoord + 1))
}
