//! Where instances are: their matrices' rows at a time, and the way back into an object's space.
//!
//! Only `world_from_object` is stored. Its inverse is made where a ray enters an instance: an instance
//! stays at 64 bytes, and of a moving one there is none to store.

use crate::pack::Packed;
use crate::shared::{INSTANCE_FLIPPED, INSTANCE_KEYS_MASK, INSTANCE_KEYS_SHIFT, Instance};
use glam::{DMat3, DVec3, DVec4, Vec4};

/// Rows of a matrix, in float64 what `Instance` holds in float32.
pub type Rows = [DVec4; 3];

/// Of what stands in the world as it is.
pub const IDENTITY: Rows = [DVec4::X, DVec4::Y, DVec4::Z];

/// An instance at a moment.
#[derive(Clone, Copy, Debug)]
pub struct PlacedInstance {
    pub world_from_object: Rows,
    pub root: u32,
    pub first_triangle: u32,
    pub flags: u32,
}

/// The instance as it is at `time`, in [0, 1] of the shutter's opening.
pub fn instance_at(packed: &Packed, number: u32, time: f64) -> PlacedInstance {
    let instance = &packed.instances[number as usize];
    let mut placed = PlacedInstance {
        world_from_object: matrix_rows(instance),
        root: instance.root,
        first_triangle: instance.first_triangle,
        flags: instance.flags,
    };
    let keys = (instance.flags >> INSTANCE_KEYS_SHIFT) & INSTANCE_KEYS_MASK;
    if keys == 0 {
        return placed;
    }
    let further = |key: u32| matrix_rows(&packed.instances[(instance.motion + key) as usize]);
    let place = time * f64::from(keys);
    let key = (place as u32).min(keys - 1);
    let part = place - f64::from(key);
    if key > 0 {
        placed.world_from_object = further(key - 1);
    }
    let next = further(key);
    for (row, next) in placed.world_from_object.iter_mut().zip(next) {
        *row = row.lerp(next, part);
    }
    // Keys may mirror each other: the sign is that of the matrix in between.
    let flipped = determinant_sign(placed.world_from_object) < 0.0;
    placed.flags = if flipped { INSTANCE_FLIPPED } else { 0 };
    placed
}

/// Of the linear part: 1, -1, or 0 where it has no inverse.
pub fn determinant_sign(rows: Rows) -> f64 {
    let [x, y, z] = columns(rows);
    let determinant = x.dot(y.cross(z));
    if determinant == 0.0 {
        0.0
    } else {
        determinant.signum()
    }
}

// cpu only: the shader's are of one precision.
fn matrix_rows(instance: &Instance) -> Rows {
    let row = |row: usize| Vec4::from_array(instance.world_from_object[row]).as_dvec4();
    [row(0), row(1), row(2)]
}

/// Rows times a point; the fourth column is the translation.
pub fn transform_point(rows: Rows, p: DVec3) -> DVec3 {
    transform_vector(rows, p) + transform_translation(rows)
}

/// Rows times a direction.
pub fn transform_vector(rows: Rows, v: DVec3) -> DVec3 {
    let row = |row: usize| rows[row].truncate().dot(v);
    DVec3::new(row(0), row(1), row(2))
}

pub fn transform_translation(rows: Rows) -> DVec3 {
    DVec3::new(rows[0].w, rows[1].w, rows[2].w)
}

/// A normal of the object's in the world: the side is kept, the length is not.
pub fn transform_normal(rows: Rows, n: DVec3) -> DVec3 {
    if rows == IDENTITY {
        return n;
    }
    normal_matrix(rows) * n
}

/// How far from the origin along the world's axes a point may be, whose coordinates in the object are as
/// large as `reach`.
pub fn transform_reach(rows: Rows, reach: DVec3) -> DVec3 {
    DVec3::from_array(rows.map(|row| row.abs().dot(reach.extend(1.0))))
}

/// How much higher a height over a plane is in the world than in the object, where `n` is the plane's
/// unit normal; up to a factor of sqrt(3) more, as in the shader.
pub fn transform_height(rows: Rows, n: DVec3) -> f64 {
    if rows == IDENTITY {
        return 1.0;
    }
    transform_normal(rows, n).abs().max_element().recip()
}

/// The columns of the linear part.
// cpu only: the shader scales them at once.
pub fn columns(rows: Rows) -> [DVec3; 3] {
    let [x, y, z] = rows;
    [
        DVec3::new(x.x, y.x, z.x),
        DVec3::new(x.y, y.y, z.y),
        DVec3::new(x.z, y.z, z.z),
    ]
}

/// The linear part's inverse, transposed: its columns are the inverse's rows, by cofactors. `N * n`
/// takes a normal into the world; it keeps the side, not the length.
pub fn normal_matrix(rows: Rows) -> DMat3 {
    let [x, y, z] = columns(rows);
    let yz = y.cross(z);
    let factor = x.dot(yz).recip();
    DMat3::from_cols(factor * yz, factor * z.cross(x), factor * x.cross(y))
}

/// A vector of the world in the object's space: `N` is the rows' `normal_matrix`. In float64 the inverse
/// needs no refinement.
pub fn vector_in_object(_rows: Rows, N: DMat3, v: DVec3) -> DVec3 {
    DVec3::new(N.x_axis.dot(v), N.y_axis.dot(v), N.z_axis.dot(v))
}

/// What the inverse's own rounding in float32 adds to the shift, along the world's unit normal `ng` and
/// in metres, of a ray that `vector_in_object` takes to a triangle of the object. `reach`: the triangle's
/// largest absolute coordinates there. `rounding`: of a sum of products in float32, and the unit of the
/// result. The derivation stands in the shader.
pub fn inverse_error(rows: Rows, reach: DVec3, ng: DVec3, rounding: f64) -> f64 {
    if rows == IDENTITY {
        return 0.0;
    }
    let columns = columns(rows);
    let (x, y, z) = (columns[0].abs(), columns[1].abs(), columns[2].abs());
    let minors = [cross_sums(y, z), cross_sums(z, x), cross_sums(x, y)];
    let determinant = columns[0].dot(columns[1].cross(columns[2])).abs();
    let D = x.dot(minors[0]) / determinant;
    let through =
        |w: DVec3| DVec3::new(minors[0].dot(w), minors[1].dot(w), minors[2].dot(w)) / determinant;
    let w = x * reach.x + y * reach.y + z * reach.z;
    let shift = through(w);
    let r = rounding * (x * shift.x + y * shift.y + z * shift.z + D * w);
    let along = DVec3::new(ng.dot(columns[0]), ng.dot(columns[1]), ng.dot(columns[2])).abs();
    along.dot(through(r)) + D * ng.abs().dot(r)
}

/// The cross product with plus for minus.
pub fn cross_sums(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::new(
        a.y * b.z + a.z * b.y,
        a.z * b.x + a.x * b.z,
        a.x * b.y + a.y * b.x,
    )
}
