//! Where instances stand: their matrices' rows, and the way back into an object's space.
//!
//! Only `world_from_object` is stored. Its inverse is made where a ray enters an instance: an instance
//! stays at 64 bytes, and a moving one has no stored inverse anyway.

use glam::{DMat3, DVec3, Vec4};

/// Rows times a point; the fourth column is the translation.
pub fn transform_point(rows: [[f32; 4]; 3], p: DVec3) -> DVec3 {
    transform_vector(rows, p) + transform_translation(rows)
}

/// Rows times a direction.
pub fn transform_vector(rows: [[f32; 4]; 3], v: DVec3) -> DVec3 {
    let product = rows.map(|row| Vec4::from_array(row).as_dvec4().truncate().dot(v));
    DVec3::from_array(product)
}

pub fn transform_translation(rows: [[f32; 4]; 3]) -> DVec3 {
    DVec3::from_array(rows.map(|row| f64::from(row[3])))
}

/// The columns of the linear part.
// cpu only: the shader scales them at once.
pub fn columns(rows: [[f32; 4]; 3]) -> [DVec3; 3] {
    [0, 1, 2].map(|column| DVec3::from_array(rows.map(|row| f64::from(row[column]))))
}

/// The linear part's inverse, transposed: its columns are the inverse's rows, by cofactors. `N * n`
/// takes a normal into the world (keeps the side, not the length), its transpose a direction into the
/// object's space.
pub fn normal_matrix(rows: [[f32; 4]; 3]) -> DMat3 {
    let [x, y, z] = columns(rows);
    let factor = x.dot(y.cross(z)).recip();
    DMat3::from_cols(
        factor * y.cross(z),
        factor * z.cross(x),
        factor * x.cross(y),
    )
}

/// A bound, along the world's unit normal `ng` and in metres, on how far float32's rounding shifts a ray
/// that `normal_matrix` takes into an object's space, while the ray is near a triangle of that object.
/// `reach`: the largest absolute coordinates of the triangle in the object; in units of rounding. The
/// derivation stands in the shader.
pub fn inverse_error(rows: [[f32; 4]; 3], reach: DVec3, ng: DVec3) -> f64 {
    let [x, y, z] = columns(rows);
    let w = x.abs() * reach.x + y.abs() * reach.y + z.abs() * reach.z;
    let minors = DVec3::new(
        cross_sums(y.abs(), z.abs()).dot(w),
        cross_sums(z.abs(), x.abs()).dot(w),
        cross_sums(x.abs(), y.abs()).dot(w),
    );
    let along = DVec3::new(ng.dot(x), ng.dot(y), ng.dot(z)).abs();
    let determinant_sums = x.abs().dot(cross_sums(y.abs(), z.abs()));
    (along.dot(minors) + determinant_sums * ng.abs().dot(w)) / x.dot(y.cross(z)).abs()
}

/// The cross product with plus for minus.
pub fn cross_sums(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::new(
        a.y * b.z + a.z * b.y,
        a.z * b.x + a.x * b.z,
        a.x * b.y + a.y * b.x,
    )
}
