// Where instances are: their matrices' rows at a time, and the way back into an object's space.
//
// Only world_from_object is stored. Its inverse is made where a ray enters an instance: an instance
// stays at 64 bytes, and of a moving one there is none to store.

import package::shared::{Instance, INSTANCE_FLIPPED, INSTANCE_KEYS_SHIFT, INSTANCE_KEYS_MASK};
import package::bindings::{instances};
import package::variant::{INSTANCES, MOTION};

// The instance as it is at `time`, in [0, 1] of the shutter's opening.
fn instance_at(number: u32, time: f32) -> Instance {
    if !INSTANCES {
        return Instance(array(vec4(1.0, 0.0, 0.0, 0.0), vec4(0.0, 1.0, 0.0, 0.0), vec4(0.0, 0.0, 1.0, 0.0)), 0u, 0u, 0u, 0u);
    }
    var instance = instances[number];
    let keys = (instance.flags >> INSTANCE_KEYS_SHIFT) & INSTANCE_KEYS_MASK;
    if !MOTION || keys == 0u {
        return instance;
    }
    let place = time * f32(keys);
    let key = min(u32(place), keys - 1u);
    let part = place - f32(key);
    var rows = instance.world_from_object;
    if key > 0u {
        rows = instances[instance.motion + key - 1u].world_from_object;
    }
    let next = instances[instance.motion + key].world_from_object;
    for (var row = 0u; row < 3u; row++) {
        rows[row] = mix(rows[row], next[row], part);
    }
    instance.world_from_object = rows;
    // Keys may mirror each other: the sign is that of the matrix in between.
    instance.flags = select(0u, INSTANCE_FLIPPED, determinant_sign(rows) < 0.0);
    return instance;
}

// Of the linear part: 1, -1, or 0 where it has no inverse.
fn determinant_sign(rows: array<vec4<f32>, 3>) -> f32 {
    let scale = column_scale(rows);
    return sign(dot(scale * rows[0].xyz, cross(scale * rows[1].xyz, scale * rows[2].xyz)));
}

// Rows times a point; the fourth column is the translation.
fn transform_point(rows: array<vec4<f32>, 3>, p: vec3<f32>) -> vec3<f32> {
    if !INSTANCES {
        return p;
    }
    let v = vec4<f32>(p, 1.0);
    return vec3<f32>(dot(rows[0], v), dot(rows[1], v), dot(rows[2], v));
}

// Rows times a direction.
fn transform_vector(rows: array<vec4<f32>, 3>, v: vec3<f32>) -> vec3<f32> {
    if !INSTANCES {
        return v;
    }
    return vec3<f32>(dot(rows[0].xyz, v), dot(rows[1].xyz, v), dot(rows[2].xyz, v));
}

fn transform_translation(rows: array<vec4<f32>, 3>) -> vec3<f32> {
    return vec3<f32>(rows[0].w, rows[1].w, rows[2].w);
}

// A normal of the object's in the world: the side is kept, the length is not.
fn transform_normal(rows: array<vec4<f32>, 3>, n: vec3<f32>) -> vec3<f32> {
    if !INSTANCES {
        return n;
    }
    return normal_matrix(rows) * n;
}

// How far from the origin along the world's axes a point may be, whose coordinates in the object are as
// large as `reach`.
fn transform_reach(rows: array<vec4<f32>, 3>, reach: vec3<f32>) -> vec3<f32> {
    if !INSTANCES {
        return reach;
    }
    let v = vec4<f32>(reach, 1.0);
    return vec3<f32>(dot(abs(rows[0]), v), dot(abs(rows[1]), v), dot(abs(rows[2]), v));
}

// How much higher a height over a plane is in the world than in the object, where `n` is the plane's unit
// normal; up to a factor of sqrt(3) more, for the sake of scales whose squares float32 does not hold.
fn transform_height(rows: array<vec4<f32>, 3>, n: vec3<f32>) -> f32 {
    if !INSTANCES {
        return 1.0;
    }
    let height = abs(transform_normal(rows, n));
    return 1.0 / max(height.x, max(height.y, height.z));
}

// For each column the power of two that brings its largest entry between 1 and 2, so that no product
// of entries leaves float32's range whatever the scale along each of the object's axes.
// shader only: float64 has the range.
fn column_scale(rows: array<vec4<f32>, 3>) -> vec3<f32> {
    let size = max(abs(rows[0].xyz), max(abs(rows[1].xyz), abs(rows[2].xyz)));
    let exponent = bitcast<vec3<u32>>(size) & vec3<u32>(0x7f800000u);
    return bitcast<vec3<f32>>(vec3<u32>(0x7f000000u) - exponent);
}

// The linear part's inverse, transposed: its columns are the inverse's rows, by cofactors. `N * n` takes
// a normal into the world; it keeps the side, not the length.
fn normal_matrix(rows: array<vec4<f32>, 3>) -> mat3x3<f32> {
    let scale = column_scale(rows);
    let x = scale.x * vec3<f32>(rows[0].x, rows[1].x, rows[2].x);
    let y = scale.y * vec3<f32>(rows[0].y, rows[1].y, rows[2].y);
    let z = scale.z * vec3<f32>(rows[0].z, rows[1].z, rows[2].z);
    let yz = cross(y, z);
    let factor = scale / dot(x, yz);
    return mat3x3<f32>(factor.x * yz, factor.y * cross(z, x), factor.z * cross(x, y));
}

// A vector of the world in the object's space: `N` is the rows' normal_matrix. One step of iterative
// refinement (Wilkinson 1963, "Rounding Errors in Algebraic Processes") takes most of the inverse's own
// rounding out again, which shear makes large.
fn vector_in_object(rows: array<vec4<f32>, 3>, N: mat3x3<f32>, v: vec3<f32>) -> vec3<f32> {
    let first = v * N;
    return first + (v - transform_vector(rows, first)) * N;
}

// What the inverse's own rounding adds to the shift, along the world's unit normal `ng` and in metres, of
// a ray that vector_in_object takes to a triangle of the object. `reach`: the triangle's largest absolute
// coordinates there. `rounding`: of a sum of products in float32, and the unit of the result.
//
// An entry of the inverse is a minor over the determinant, both differences of products. Rounding errs by
// no more than a few units of the same sums with all signs plus: A of the minors over the determinant, D of
// the determinant over itself. A point w away from the object's origin, |w| at most |M| reach, is thereby
// shifted by A |w| in the object and scaled by 1 + D. The refinement leaves of that what the same inverse
// makes of the residual, r = |M| A |w| + D |w| in units: A r in the object, which is ng^T M A r along ng, and
// D r. (The residual's own rounding is of the size of |M| reach, which the caller counts.) Where columns are
// at right angles A and D are of the size of what they bound, whatever the scales, and this is nothing.
fn inverse_error(rows: array<vec4<f32>, 3>, reach: vec3<f32>, ng: vec3<f32>, rounding: f32) -> f32 {
    if !INSTANCES {
        return 0.0;
    }
    // The columns' scales, of M and of its inverse, cancel.
    let scale = column_scale(rows);
    let x = scale.x * vec3<f32>(rows[0].x, rows[1].x, rows[2].x);
    let y = scale.y * vec3<f32>(rows[0].y, rows[1].y, rows[2].y);
    let z = scale.z * vec3<f32>(rows[0].z, rows[1].z, rows[2].z);
    let minors_x = cross_sums(abs(y), abs(z));
    let minors_y = cross_sums(abs(z), abs(x));
    let minors_z = cross_sums(abs(x), abs(y));
    let determinant = abs(dot(x, cross(y, z)));
    let D = dot(abs(x), minors_x) / determinant;
    let w = abs(x) * (reach.x / scale.x) + abs(y) * (reach.y / scale.y) + abs(z) * (reach.z / scale.z);
    let shift = vec3<f32>(dot(minors_x, w), dot(minors_y, w), dot(minors_z, w)) / determinant;
    let r = rounding * (abs(x) * shift.x + abs(y) * shift.y + abs(z) * shift.z + D * w);
    let left = vec3<f32>(dot(minors_x, r), dot(minors_y, r), dot(minors_z, r)) / determinant;
    let along = abs(vec3<f32>(dot(ng, x), dot(ng, y), dot(ng, z)));
    return dot(along, left) + D * dot(abs(ng), r);
}

// The cross product with plus for minus.
fn cross_sums(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return a.yzx * b.zxy + a.zxy * b.yzx;
}
