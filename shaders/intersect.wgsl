// The two tests of a traversal: eight boxes of a node at once, and one triangle.

import package::shared::{Triangle};
import package::bindings::{nodes};

// A ray in the space of one hierarchy. `t` means the same in all of them, so in an object's space
// the direction is not of unit length.
struct LocalRay {
    origin: vec3<f32>,
    octant: u32, // order of children, a bit per axis: 1 where the ray goes up
    direction: vec3<f32>,
    inverse: vec3<f32>, // of the direction, finite
}

// What a ray meets in a node: inner children as the traversal's next group, and primitives.
struct NodeHit {
    inner: vec2<u32>,  // index of the first inner child; bits 24 to 31: children met, 0 to 7: inner children
    leaves: vec2<u32>, // number of the first primitive; bits 0 to 23: primitives met
}

struct TriangleHit {
    t: f32,
    u: f32,
    v: f32,
    front: u32, // 1: the ray met the side from which the corners go counter-clockwise
    hit: u32,   // 0: missed, the rest means nothing
}

// A direction's component below this part of the largest one is replaced by it, so that its
// reciprocal is finite. A ray is bent by this angle at most, which the boxes' padding covers.
const MIN_COMPONENT: f32 = 1e-12;

// Boxes grow by this part of their distance from the ray's origin and of their node's size, which
// bounds the rounding of the test below; without it a ray along a face is lost between two boxes. 2^-21.
const BOX_PADDING: f32 = 4.76837158203125e-7;

// Triangles grow by this part of the distance to their first corner, which bounds the rounding of
// the edge tests, so that rays do not slip through a shared edge. 2^-22.
const EDGE_TOLERANCE: f32 = 2.384185791015625e-7;

fn local_ray(origin: vec3<f32>, direction: vec3<f32>) -> LocalRay {
    let size = abs(direction);
    let smallest = MIN_COMPONENT * max(size.x, max(size.y, size.z));
    let signed_smallest = select(vec3<f32>(smallest), vec3<f32>(-smallest), direction < vec3<f32>(0.0));
    let guarded = select(direction, signed_smallest, size < vec3<f32>(smallest));
    let octant = select(4u, 0u, direction.x < 0.0)
        | select(2u, 0u, direction.y < 0.0)
        | select(1u, 0u, direction.z < 0.0);
    return LocalRay(origin, octant, direction, 1.0 / guarded);
}

fn unpack_bytes(word: u32) -> vec4<u32> {
    return (vec4<u32>(word) >> vec4<u32>(0u, 8u, 16u, 24u)) & vec4<u32>(0xffu);
}

// Four children of a node: which of them the ray meets, as bits of `NodeHit`. `info` has a byte a
// child, its place in the mask in the low five bits and what to set there in the high three. `near`
// and `far` have, for each axis, a byte a child: its planes in the order in which the ray meets them.
//
// Ylitie, Karras and Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide
// BVHs", algorithm 1 and section 3.
fn intersect_children(
    info: u32, octant: u32, near: vec3<u32>, far: vec3<u32>, scale: vec3<f32>,
    near_origin: vec3<f32>, far_origin: vec3<f32>, t_min: f32, t_max: f32,
) -> u32 {
    // Inner children alone have both bits; their place is turned by the octant, so that the highest
    // bit of the mask is the nearest child.
    let inner = ((info & (info << 1u)) & 0x10101010u) >> 4u;
    let place = unpack_bytes((info ^ (inner * octant)) & 0x1f1f1f1fu);
    let bits = unpack_bytes((info >> 5u) & 0x07070707u) << place;
    let enter = max(
        max(vec4<f32>(unpack_bytes(near.x)) * scale.x + near_origin.x, vec4<f32>(unpack_bytes(near.y)) * scale.y + near_origin.y),
        max(vec4<f32>(unpack_bytes(near.z)) * scale.z + near_origin.z, vec4<f32>(t_min)));
    let leave = min(
        min(vec4<f32>(unpack_bytes(far.x)) * scale.x + far_origin.x, vec4<f32>(unpack_bytes(far.y)) * scale.y + far_origin.y),
        min(vec4<f32>(unpack_bytes(far.z)) * scale.z + far_origin.z, vec4<f32>(t_max)));
    let met = select(vec4<u32>(0u), bits, enter <= leave);
    return met.x | met.y | met.z | met.w;
}

// Node number `index`, between `t_min` and `t_max` of the ray.
fn intersect_node(ray: LocalRay, t_min: f32, t_max: f32, index: u32) -> NodeHit {
    let corner = nodes[5u * index];
    let header = nodes[5u * index + 1u];
    let x = nodes[5u * index + 2u]; // lower planes of children 0 to 3 and 4 to 7, then upper planes
    let y = nodes[5u * index + 3u];
    let z = nodes[5u * index + 4u];
    // Planes are corner + byte * 2^exponent; a float's exponent bits make the power of two.
    let step = bitcast<vec3<f32>>(unpack_bytes(corner.w).xyz << vec3<u32>(23u));
    let scale = step * ray.inverse;
    let entry = (bitcast<vec3<f32>>(corner.xyz) - ray.origin) * ray.inverse;
    let padding = BOX_PADDING * (abs(entry) + 255.0 * abs(scale));
    let near_origin = entry - padding;
    let far_origin = entry + padding;
    let up_x = (ray.octant & 4u) != 0u;
    let up_y = (ray.octant & 2u) != 0u;
    let up_z = (ray.octant & 1u) != 0u;
    let near_x = select(x.zw, x.xy, up_x);
    let near_y = select(y.zw, y.xy, up_y);
    let near_z = select(z.zw, z.xy, up_z);
    let far_x = select(x.xy, x.zw, up_x);
    let far_y = select(y.xy, y.zw, up_y);
    let far_z = select(z.xy, z.zw, up_z);
    let met = intersect_children(
        header.z, ray.octant, vec3<u32>(near_x.x, near_y.x, near_z.x), vec3<u32>(far_x.x, far_y.x, far_z.x),
        scale, near_origin, far_origin, t_min, t_max)
        | intersect_children(
        header.w, ray.octant, vec3<u32>(near_x.y, near_y.y, near_z.y), vec3<u32>(far_x.y, far_y.y, far_z.y),
        scale, near_origin, far_origin, t_min, t_max);
    return NodeHit(
        vec2<u32>(header.x, (met & 0xff000000u) | (corner.w >> 24u)),
        vec2<u32>(header.y, met & 0x00ffffffu));
}

// Möller and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection", with both sides hit
// and with tolerances from the rounding of its terms. A triangle seen so nearly edge-on, or so thin,
// that its determinant is all rounding is missed.
fn intersect_triangle(ray: LocalRay, triangle: Triangle) -> TriangleHit {
    let pvec = cross(ray.direction, triangle.e2);
    let tvec = ray.origin - triangle.p0;
    let qvec = cross(tvec, triangle.e1);
    let det = dot(triangle.e1, pvec);
    let facing = select(1.0, -1.0, det < 0.0);
    let u = dot(tvec, pvec) * facing;
    let v = dot(ray.direction, qvec) * facing;
    let size = abs(det);
    let along = EDGE_TOLERANCE * largest_component(ray.direction);
    let length1 = largest_component(triangle.e1);
    let length2 = largest_component(triangle.e2);
    let away = along * largest_component(tvec);
    let inside = u >= -away * length2 && v >= -away * length1 && u + v <= size + away * (length1 + length2);
    let hit = inside && size > along * length1 * length2;
    // The rim that the tolerance adds belongs to the edge.
    let b = max(vec2<f32>(u, v) / size, vec2<f32>(0.0));
    let clamped = b / max(b.x + b.y, 1.0);
    return TriangleHit(
        dot(triangle.e2, qvec) / det, clamped.x, clamped.y, select(0u, 1u, det > 0.0), select(0u, 1u, hit));
}

fn largest_component(v: vec3<f32>) -> f32 {
    return max(abs(v.x), max(abs(v.y), abs(v.z)));
}
