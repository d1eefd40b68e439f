// Vertex attributes of a triangle, interpolated where a ray met it or a light was sampled.
// `barycentrics` are the weights of corners 1 and 2. See LAYOUT_* for what a vertex holds.

import package::shared::{Triangle, LAYOUT_TANGENT, LAYOUT_COLOR, LAYOUT_TEXCOORDS_SHIFT};
import package::bindings::{vertices};

// Words of the normal, which comes first and is always there.
const ATTRIBUTE_NORMAL_WORDS: u32 = 3u;

fn attribute_color_offset(vertex_layout: u32) -> u32 {
    return ATTRIBUTE_NORMAL_WORDS + select(0u, 4u, (vertex_layout & LAYOUT_TANGENT) != 0u);
}

fn attribute_texcoord_offset(vertex_layout: u32) -> u32 {
    return attribute_color_offset(vertex_layout) + select(0u, 4u, (vertex_layout & LAYOUT_COLOR) != 0u);
}

// One word of an attribute, `offset` words into each of the three vertices.
fn attribute_word(triangle: Triangle, barycentrics: vec2<f32>, offset: u32) -> f32 {
    return (1.0 - barycentrics.x - barycentrics.y) * vertices[triangle.vertex0 + offset]
        + barycentrics.x * vertices[triangle.vertex1 + offset]
        + barycentrics.y * vertices[triangle.vertex2 + offset];
}

// Object space; not normalised, since the object-to-world map comes first.
fn attribute_normal(triangle: Triangle, barycentrics: vec2<f32>) -> vec3<f32> {
    return vec3<f32>(
        attribute_word(triangle, barycentrics, 0u),
        attribute_word(triangle, barycentrics, 1u),
        attribute_word(triangle, barycentrics, 2u),
    );
}

// Object space, w = handedness; zero where the mesh has no tangents.
fn attribute_tangent(triangle: Triangle, barycentrics: vec2<f32>) -> vec4<f32> {
    if (triangle.vertex_layout & LAYOUT_TANGENT) == 0u {
        return vec4<f32>(0.0);
    }
    return vec4<f32>(
        attribute_word(triangle, barycentrics, ATTRIBUTE_NORMAL_WORDS),
        attribute_word(triangle, barycentrics, ATTRIBUTE_NORMAL_WORDS + 1u),
        attribute_word(triangle, barycentrics, ATTRIBUTE_NORMAL_WORDS + 2u),
        // The same at all three corners, so it is read and not interpolated.
        vertices[triangle.vertex0 + ATTRIBUTE_NORMAL_WORDS + 3u],
    );
}

// COLOR_0, linear; white where the mesh has none.
fn attribute_color(triangle: Triangle, barycentrics: vec2<f32>) -> vec4<f32> {
    if (triangle.vertex_layout & LAYOUT_COLOR) == 0u {
        return vec4<f32>(1.0);
    }
    let offset = attribute_color_offset(triangle.vertex_layout);
    return vec4<f32>(
        attribute_word(triangle, barycentrics, offset),
        attribute_word(triangle, barycentrics, offset + 1u),
        attribute_word(triangle, barycentrics, offset + 2u),
        attribute_word(triangle, barycentrics, offset + 3u),
    );
}

// TEXCOORD_n of n = texcoord; zero where the mesh has no such set.
fn attribute_texcoord(triangle: Triangle, barycentrics: vec2<f32>, texcoord: u32) -> vec2<f32> {
    if texcoord >= triangle.vertex_layout >> LAYOUT_TEXCOORDS_SHIFT {
        return vec2<f32>(0.0);
    }
    let offset = attribute_texcoord_offset(triangle.vertex_layout) + 2u * texcoord;
    return vec2<f32>(
        attribute_word(triangle, barycentrics, offset),
        attribute_word(triangle, barycentrics, offset + 1u),
    );
}
