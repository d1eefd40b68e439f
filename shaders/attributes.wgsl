// Vertex attributes of a triangle, interpolated where a ray met it or a light was sampled.
// `barycentrics` are the weights of corners 1 and 2. See LAYOUT_* for what a vertex holds.

import package::shared::{Triangle, LAYOUT_TANGENT, LAYOUT_COLOR, LAYOUT_COLOR_UNORM, LAYOUT_TEXCOORD_UNORM, LAYOUT_TEXCOORDS_SHIFT};
import package::shared::{NORMAL_STEPS, TANGENT_STEPS};
import package::bindings::{vertices};
import package::variant::{VERTEX_TANGENTS, VERTEX_COLORS, FLOAT_TEXCOORDS, UNORM_TEXCOORDS};

// Words of the normal, which comes first and is always there.
const ATTRIBUTE_NORMAL_WORDS: u32 = 1u;

fn attribute_color_offset(vertex_layout: u32) -> u32 {
    return ATTRIBUTE_NORMAL_WORDS + select(0u, 1u, (vertex_layout & LAYOUT_TANGENT) != 0u);
}

fn attribute_texcoord_offset(vertex_layout: u32) -> u32 {
    let words = select(4u, 1u, (vertex_layout & LAYOUT_COLOR_UNORM) != 0u);
    return attribute_color_offset(vertex_layout) + select(0u, words, (vertex_layout & LAYOUT_COLOR) != 0u);
}

// The direction at (x, y) of the octahedral map whose corners are `steps` from its centre, unit length;
// zero at x = -steps - 1, which is off the map. Directions along an axis are exact.
fn octahedral_direction(x: i32, y: i32, steps: i32) -> vec3<f32> {
    // Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit Vectors", listing 1.
    let z = steps - abs(x) - abs(y);
    let beyond = max(-z, 0);
    let v = vec3<f32>(vec3<i32>(
        x + select(beyond, -beyond, x >= 0),
        y + select(beyond, -beyond, y >= 0),
        z,
    ));
    return select(v / sqrt(dot(v, v)), vec3<f32>(0.0), x < -steps);
}

// x in the low half of the word, y in the high one.
fn unpack_normal(word: u32) -> vec3<f32> {
    return octahedral_direction(i32(word << 16u) >> 16u, i32(word) >> 16u, i32(NORMAL_STEPS));
}

// x in the low 15 bits of the word, y in the next 15; w, -1, 0 or 1, in the rest.
fn unpack_tangent(word: u32) -> vec4<f32> {
    let direction = octahedral_direction(i32(word << 17u) >> 17u, i32(word << 2u) >> 17u, i32(TANGENT_STEPS));
    return vec4<f32>(direction, f32(i32(word) >> 30u));
}

// One word of an attribute in float32, `offset` words into each of the three vertices.
fn attribute_float(triangle: Triangle, barycentrics: vec2<f32>, offset: u32) -> f32 {
    return (1.0 - barycentrics.x - barycentrics.y) * bitcast<f32>(vertices[triangle.vertex0 + offset])
        + barycentrics.x * bitcast<f32>(vertices[triangle.vertex1 + offset])
        + barycentrics.y * bitcast<f32>(vertices[triangle.vertex2 + offset]);
}

// A word with two numbers in steps of 1/65535, the first one in the low half.
fn attribute_unorm2(triangle: Triangle, barycentrics: vec2<f32>, offset: u32) -> vec2<f32> {
    let a = vertices[triangle.vertex0 + offset];
    let b = vertices[triangle.vertex1 + offset];
    let c = vertices[triangle.vertex2 + offset];
    let sum = (1.0 - barycentrics.x - barycentrics.y) * vec2<f32>(vec2(a & 65535u, a >> 16u))
        + barycentrics.x * vec2<f32>(vec2(b & 65535u, b >> 16u))
        + barycentrics.y * vec2<f32>(vec2(c & 65535u, c >> 16u));
    return sum / 65535.0;
}

// Four numbers in steps of 1/255, the first one in the lowest byte.
fn unpack_color(word: u32) -> vec4<f32> {
    return vec4<f32>(vec4(word & 255u, (word >> 8u) & 255u, (word >> 16u) & 255u, word >> 24u)) / 255.0;
}

// Object space; not normalised, since the object-to-world map comes first.
fn attribute_normal(triangle: Triangle, barycentrics: vec2<f32>) -> vec3<f32> {
    return (1.0 - barycentrics.x - barycentrics.y) * unpack_normal(vertices[triangle.vertex0])
        + barycentrics.x * unpack_normal(vertices[triangle.vertex1])
        + barycentrics.y * unpack_normal(vertices[triangle.vertex2]);
}

// Object space, w = handedness; zero where the mesh has no tangents.
fn attribute_tangent(triangle: Triangle, barycentrics: vec2<f32>) -> vec4<f32> {
    if VERTEX_TANGENTS && (triangle.vertex_layout & LAYOUT_TANGENT) != 0u {
        let a = unpack_tangent(vertices[triangle.vertex0 + ATTRIBUTE_NORMAL_WORDS]);
        let b = unpack_tangent(vertices[triangle.vertex1 + ATTRIBUTE_NORMAL_WORDS]);
        let c = unpack_tangent(vertices[triangle.vertex2 + ATTRIBUTE_NORMAL_WORDS]);
        // The handedness is the same at all three corners, so it is read and not interpolated.
        return vec4<f32>(
            (1.0 - barycentrics.x - barycentrics.y) * a.xyz + barycentrics.x * b.xyz + barycentrics.y * c.xyz,
            a.w,
        );
    }
    return vec4<f32>(0.0);
}

// COLOR_0, linear; white where the mesh has none.
fn attribute_color(triangle: Triangle, barycentrics: vec2<f32>) -> vec4<f32> {
    if !VERTEX_COLORS || (triangle.vertex_layout & LAYOUT_COLOR) == 0u {
        return vec4<f32>(1.0);
    }
    let offset = attribute_color_offset(triangle.vertex_layout);
    if (triangle.vertex_layout & LAYOUT_COLOR_UNORM) != 0u {
        return (1.0 - barycentrics.x - barycentrics.y) * unpack_color(vertices[triangle.vertex0 + offset])
            + barycentrics.x * unpack_color(vertices[triangle.vertex1 + offset])
            + barycentrics.y * unpack_color(vertices[triangle.vertex2 + offset]);
    }
    return vec4<f32>(
        attribute_float(triangle, barycentrics, offset),
        attribute_float(triangle, barycentrics, offset + 1u),
        attribute_float(triangle, barycentrics, offset + 2u),
        attribute_float(triangle, barycentrics, offset + 3u),
    );
}

// TEXCOORD_n of n = texcoord; zero where the mesh has no such set.
fn attribute_texcoord(triangle: Triangle, barycentrics: vec2<f32>, texcoord: u32) -> vec2<f32> {
    if texcoord >= triangle.vertex_layout >> LAYOUT_TEXCOORDS_SHIFT {
        return vec2<f32>(0.0);
    }
    let first = attribute_texcoord_offset(triangle.vertex_layout);
    if UNORM_TEXCOORDS && (!FLOAT_TEXCOORDS || (triangle.vertex_layout & LAYOUT_TEXCOORD_UNORM) != 0u) {
        return attribute_unorm2(triangle, barycentrics, first + texcoord);
    }
    return vec2<f32>(
        attribute_float(triangle, barycentrics, first + 2u * texcoord),
        attribute_float(triangle, barycentrics, first + 2u * texcoord + 1u),
    );
}
