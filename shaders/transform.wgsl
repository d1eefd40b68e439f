// Where instances stand: their matrices' rows, and the way back into an object's space.
//
// Only world_from_object is stored. Its inverse is made where a ray enters an instance: an instance
// stays at 64 bytes, and a moving one has no stored inverse anyway.

// Rows times a point; the fourth column is the translation.
fn transform_point(rows: array<vec4<f32>, 3>, p: vec3<f32>) -> vec3<f32> {
    let v = vec4<f32>(p, 1.0);
    return vec3<f32>(dot(rows[0], v), dot(rows[1], v), dot(rows[2], v));
}

// Rows times a direction.
fn transform_vector(rows: array<vec4<f32>, 3>, v: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(dot(rows[0].xyz, v), dot(rows[1].xyz, v), dot(rows[2].xyz, v));
}

fn transform_translation(rows: array<vec4<f32>, 3>) -> vec3<f32> {
    return vec3<f32>(rows[0].w, rows[1].w, rows[2].w);
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
// a normal into the world (keeps the side, not the length), `v * N` a direction into the object's space.
fn normal_matrix(rows: array<vec4<f32>, 3>) -> mat3x3<f32> {
    let scale = column_scale(rows);
    let x = scale.x * vec3<f32>(rows[0].x, rows[1].x, rows[2].x);
    let y = scale.y * vec3<f32>(rows[0].y, rows[1].y, rows[2].y);
    let z = scale.z * vec3<f32>(rows[0].z, rows[1].z, rows[2].z);
    let yz = cross(y, z);
    let factor = scale / dot(x, yz);
    return mat3x3<f32>(factor.x * yz, factor.y * cross(z, x), factor.z * cross(x, y));
}

// A bound, along the world's unit normal `ng` and in metres, on how far rounding shifts a ray that
// `normal_matrix` takes into an object's space, while the ray is near a triangle of that object.
// `reach`: the largest absolute coordinates of the triangle in the object; in units of float32's
// rounding, of which the caller knows the number.
//
// The inverse's entry (k, j) is a minor over the determinant, both differences of products. Rounding
// errs by no more than a few units of the same sums with all signs plus: A(k, j) of the minors, and D of
// the determinant. So coordinate k of a point w from the object's origin errs by the sum of A(k, j) |w(j)|
// over j, and |w| is at most |M| reach, M being the linear part. In the world that shifts the point along
// ng by ng^T M times it. The determinant's error scales the whole by a factor 1 + D / |det|. Where the
// columns are at right angles both sums are of the size of what they bound, whatever the scales; shear
// makes them larger, and rays really are that uncertain then.
fn inverse_error(rows: array<vec4<f32>, 3>, reach: vec3<f32>, ng: vec3<f32>) -> f32 {
    let scale = column_scale(rows);
    let x = scale.x * vec3<f32>(rows[0].x, rows[1].x, rows[2].x);
    let y = scale.y * vec3<f32>(rows[0].y, rows[1].y, rows[2].y);
    let z = scale.z * vec3<f32>(rows[0].z, rows[1].z, rows[2].z);
    let w = abs(x) * (reach.x / scale.x) + abs(y) * (reach.y / scale.y) + abs(z) * (reach.z / scale.z);
    let minors = vec3<f32>(
        dot(cross_sums(abs(y), abs(z)), w),
        dot(cross_sums(abs(z), abs(x)), w),
        dot(cross_sums(abs(x), abs(y)), w));
    // The columns' scales, of M and of its inverse, cancel.
    let along = abs(vec3<f32>(dot(ng, x), dot(ng, y), dot(ng, z)));
    let determinant_sums = dot(abs(x), cross_sums(abs(y), abs(z)));
    return (dot(along, minors) + determinant_sums * dot(abs(ng), w)) / abs(dot(x, cross(y, z)));
}

// The cross product with plus for minus.
fn cross_sums(a: vec3<f32>, b: vec3<f32>) -> vec3<f32> {
    return a.yzx * b.zxy + a.zxy * b.yzx;
}
