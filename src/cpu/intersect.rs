//! The two tests of a traversal: eight boxes of a node at once, and one triangle.

use crate::pack::Packed;
use crate::shared::Triangle;
use glam::{DVec3, UVec2, UVec4, Vec3, Vec4};

/// A ray in the space of one hierarchy. `t` means the same in all of them, so in an object's space
/// the direction is not of unit length.
#[derive(Clone, Copy, Debug)]
pub struct LocalRay {
    pub origin: DVec3,
    /// Order of children, a bit per axis: 1 where the ray goes up.
    pub octant: u32,
    pub direction: DVec3,
    /// Of the direction, finite.
    pub inverse: DVec3,
}

/// What a ray meets in a node: inner children as the traversal's next group, and primitives.
#[derive(Clone, Copy, Debug)]
pub struct NodeHit {
    /// Index of the first inner child; bits 24 to 31: children met, 0 to 7: inner children.
    pub inner: UVec2,
    /// Number of the first primitive; bits 0 to 23: primitives met.
    pub leaves: UVec2,
}

#[derive(Clone, Copy, Debug, Default)]
pub struct TriangleHit {
    pub t: f64,
    pub u: f64,
    pub v: f64,
    /// The ray met the side from which the corners go counter-clockwise.
    pub front: bool,
    /// `false`: missed, the rest means nothing.
    pub hit: bool,
}

/// A direction's component below this part of the largest one is replaced by it, so that its
/// reciprocal is finite. A ray is bent by this angle at most, which the boxes' padding covers.
pub const MIN_COMPONENT: f64 = 1e-12;

/// Boxes grow by this part of their distance from the ray's origin and of their node's size, which
/// bounds the rounding of the test in float32; without it a ray along a face is lost between two
/// boxes. 2^-21.
pub const BOX_PADDING: f32 = 1.0 / 2_097_152.0;

/// Triangles grow by this part of the distance to their first corner, which bounds the rounding of
/// the edge tests in float32, so that rays do not slip through a shared edge. 2^-22.
pub const EDGE_TOLERANCE: f64 = 2.384185791015625e-7;

pub fn local_ray(origin: DVec3, direction: DVec3) -> LocalRay {
    let size = direction.abs();
    let smallest = MIN_COMPONENT * size.max_element();
    let guard = |component: f64| match component {
        c if c.abs() >= smallest => c,
        c if c < 0.0 => -smallest,
        _ => smallest,
    };
    let guarded = DVec3::new(guard(direction.x), guard(direction.y), guard(direction.z));
    let bit = |component: f64, bit: u32| if component < 0.0 { 0 } else { bit };
    LocalRay {
        origin,
        octant: bit(direction.x, 4) | bit(direction.y, 2) | bit(direction.z, 1),
        direction,
        inverse: guarded.recip(),
    }
}

pub fn unpack_bytes(word: u32) -> UVec4 {
    UVec4::new(word & 0xff, word >> 8 & 0xff, word >> 16 & 0xff, word >> 24)
}

/// The bytes of a word, half by half.
// cpu only: the shader takes a word's bytes apart in registers.
fn bytes(word: &[u32; 4]) -> &[[u8; 8]; 2] {
    bytemuck::cast_ref(word)
}

/// The children of a node, all eight at once where the shader has four: which of them the ray meets, as
/// bits of `NodeHit`. `info` has a byte a child, its place in the mask in the low five bits and what to set
/// there in the high three. `near` and `far` have, for each axis, a byte a child: its planes in the order
/// in which the ray meets them.
///
/// In float32, as in the shader: boxes only have to hold what is in them, and their padding sees to that.
#[inline(always)]
#[expect(
    clippy::too_many_arguments,
    reason = "the shader's function, whose arguments are registers"
)]
pub fn intersect_children(
    info: &[u8; 8],
    octant: u32,
    near: [&[u8; 8]; 3],
    far: [&[u8; 8]; 3],
    scale: Vec3,
    near_origin: Vec3,
    far_origin: Vec3,
    t_min: f32,
    t_max: f32,
) -> u32 {
    // Ylitie, Karras and Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed
    // Wide BVHs", algorithm 1 and section 3. Inner children alone have both bits; their place is
    // turned by the octant, so that the highest bit of the mask is the nearest child.
    // Four at a time: what is written for eight is not made into vectors by the compiler.
    let half = |half: usize| {
        let planes = |bytes: &[u8; 8], scale: f32, origin: f32| {
            let byte = |child: usize| f32::from(bytes[4 * half + child]);
            Vec4::new(byte(0), byte(1), byte(2), byte(3)) * scale + origin
        };
        let enter = planes(near[0], scale.x, near_origin.x)
            .max(planes(near[1], scale.y, near_origin.y))
            .max(planes(near[2], scale.z, near_origin.z))
            .max(Vec4::splat(t_min));
        let leave = planes(far[0], scale.x, far_origin.x)
            .min(planes(far[1], scale.y, far_origin.y))
            .min(planes(far[2], scale.z, far_origin.z))
            .min(Vec4::splat(t_max));
        enter.cmple(leave).bitmask()
    };
    let mut children = half(0) | half(1) << 4;
    let mut met = 0;
    while children != 0 {
        let info = u32::from(info[children.trailing_zeros() as usize]);
        let inner = (info & (info << 1) & 0x10) >> 4;
        let place = (info ^ (inner * octant)) & 0x1f;
        met |= (info >> 5) << place;
        children &= children - 1;
    }
    met
}

/// Node number `index`, between `t_min` and `t_max` of the ray.
#[inline(always)]
pub fn intersect_node(
    packed: &Packed,
    ray: &LocalRay,
    t_min: f64,
    t_max: f64,
    index: u32,
) -> NodeHit {
    let first = 5 * index as usize;
    let [corner, header, x, y, z]: &[[u32; 4]; 5] = packed.nodes[first..]
        .first_chunk()
        .expect("invariant: a node has five words");
    // Planes are corner + byte * 2^exponent; a float's exponent bits make the power of two.
    let exponents = unpack_bytes(corner[3]);
    let power = |exponent: u32| f64::from(f32::from_bits(exponent << 23));
    let step = DVec3::new(power(exponents.x), power(exponents.y), power(exponents.z));
    let lower = Vec3::new(
        f32::from_bits(corner[0]),
        f32::from_bits(corner[1]),
        f32::from_bits(corner[2]),
    );
    // The difference in float64: what the origin loses by rounding may be more than a box.
    let scale = (step * ray.inverse).as_vec3();
    let entry = ((lower.as_dvec3() - ray.origin) * ray.inverse).as_vec3();
    let padding = BOX_PADDING * (entry.abs() + 255.0 * scale.abs());
    // Lower planes of children 0 to 7, then upper planes.
    let [x, y, z] = [bytes(x), bytes(y), bytes(z)];
    let first = |bit: u32| usize::from(ray.octant & bit == 0);
    let (near_x, near_y, near_z) = (first(4), first(2), first(1));
    let met = intersect_children(
        &bytes(header)[1],
        ray.octant,
        [&x[near_x], &y[near_y], &z[near_z]],
        [&x[1 - near_x], &y[1 - near_y], &z[1 - near_z]],
        scale,
        entry - padding,
        entry + padding,
        t_min as f32,
        t_max as f32,
    );
    NodeHit {
        inner: UVec2::new(header[0], (met & 0xff00_0000) | (corner[3] >> 24)),
        leaves: UVec2::new(header[1], met & 0x00ff_ffff),
    }
}

/// Both sides are hit, with tolerances from the rounding of the terms in float32. A triangle seen so
/// nearly edge-on, or so thin, that its determinant is all rounding is missed.
#[inline(always)]
pub fn intersect_triangle(ray: &LocalRay, triangle: &Triangle) -> TriangleHit {
    // Möller and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection".
    let e1 = Vec3::from_array(triangle.e1).as_dvec3();
    let e2 = Vec3::from_array(triangle.e2).as_dvec3();
    let pvec = ray.direction.cross(e2);
    let tvec = ray.origin - Vec3::from_array(triangle.p0).as_dvec3();
    let qvec = tvec.cross(e1);
    let det = e1.dot(pvec);
    let facing = if det < 0.0 { -1.0 } else { 1.0 };
    let u = tvec.dot(pvec) * facing;
    let v = ray.direction.dot(qvec) * facing;
    let size = det.abs();
    let along = EDGE_TOLERANCE * largest_component(ray.direction);
    let length1 = largest_component(e1);
    let length2 = largest_component(e2);
    let away = along * largest_component(tvec);
    let inside =
        u >= -away * length2 && v >= -away * length1 && u + v <= size + away * (length1 + length2);
    if !(inside && size > along * length1 * length2) {
        return TriangleHit::default();
    }
    // The rim that the tolerance adds belongs to the edge.
    let (u, v) = ((u / size).max(0.0), (v / size).max(0.0));
    let sum = (u + v).max(1.0);
    TriangleHit {
        t: e2.dot(qvec) / det,
        u: u / sum,
        v: v / sum,
        front: det > 0.0,
        hit: true,
    }
}

pub fn largest_component(v: DVec3) -> f64 {
    v.abs().max_element()
}
