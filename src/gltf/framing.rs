//! A camera for a scene that brings none.

use crate::scene::{Camera, Mesh, Projection, Scene};
use glam::{Affine3A, Mat3, Vec3};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, TAU};
use std::sync::Arc;

/// From the front (+z), a little to the right and a little above, so that depth can be seen and a
/// board that faces +z can still be read. Radians.
const AZIMUTH: f32 = 0.3;
const ELEVATION: f32 = 0.22;
/// Onto a floor, which is nothing but a line when seen from its side. Radians.
const FLOOR_ELEVATION: f32 = 0.7;
/// A scene is flat where one extent is a smaller fraction than this of the others.
const FLAT: f32 = 0.1;
/// Vertical angle of view, radians.
const YFOV: f32 = FRAC_PI_4;
/// Room around the scene, as a factor on the distance.
const MARGIN: f32 = 1.05;
/// The near plane, as a fraction of the distance to the scene.
const NEAR: f32 = 1e-3;

/// More vertices than these, instances included, are framed by the corners of their meshes' boxes.
const EXACT_VERTICES: usize = 10_000_000;

/// A box around all instances, in world space, wherever they are while the shutter is open; the smallest
/// one for scenes of up to `EXACT_VERTICES`. `None` for an empty scene.
pub fn bounds(scene: &Scene) -> Option<(Vec3, Vec3)> {
    fn vertices(mesh: &Mesh) -> impl Iterator<Item = &Vec3> {
        let primitives = mesh.primitives.iter();
        primitives.flat_map(|primitive| &primitive.positions)
    }
    let places = || {
        scene.instances.iter().flat_map(|instance| {
            let keys = std::iter::once(&instance.world_from_object).chain(&instance.motion);
            keys.map(move |place| (instance, place))
        })
    };
    let count = |mesh: &Arc<Mesh>| -> usize {
        let primitives = mesh.primitives.iter();
        primitives.map(|primitive| primitive.positions.len()).sum()
    };
    let counts: Vec<usize> = scene.meshes.iter().map(count).collect();
    let total = places().map(|(instance, _)| counts[instance.mesh]);
    if total.fold(0, usize::saturating_add) <= EXACT_VERTICES {
        return extent(places().flat_map(|(instance, world_from_object)| {
            let place = |p: &Vec3| world_from_object.transform_point3(*p);
            vertices(&scene.meshes[instance.mesh]).map(place)
        }));
    }
    let boxes: Vec<_> = scene
        .meshes
        .iter()
        .map(|mesh| extent(vertices(mesh).copied()).map(|(low, high)| corners(low, high)))
        .collect();
    extent(places().flat_map(|(instance, world_from_object)| {
        let place = |p: &Vec3| world_from_object.transform_point3(*p);
        boxes[instance.mesh].iter().flatten().map(place)
    }))
}

fn extent(points: impl IntoIterator<Item = Vec3>) -> Option<(Vec3, Vec3)> {
    points.into_iter().fold(None, |bounds, p| match bounds {
        None => Some((p, p)),
        Some((low, high)) => Some((p.min(low), p.max(high))),
    })
}

fn corners(low: Vec3, high: Vec3) -> [Vec3; 8] {
    std::array::from_fn(|corner| {
        let pick =
            |bit: usize, low: f32, high: f32| if corner >> bit & 1 == 1 { high } else { low };
        Vec3::new(
            pick(0, low.x, high.x),
            pick(1, low.y, high.y),
            pick(2, low.z, high.z),
        )
    })
}

/// The direction from the scene to the camera. A flat scene is seen from the side that it faces,
/// since the back of a surface may be invisible.
fn viewpoint(scene: &Scene, extent: Vec3) -> Vec3 {
    let flat = FLAT * extent.max_element();
    let from = |azimuth: f32, elevation: f32| {
        Vec3::new(
            azimuth.sin() * elevation.cos(),
            elevation.sin(),
            azimuth.cos() * elevation.cos(),
        )
    };
    let (axis, back) = if extent.z <= flat {
        (Vec3::Z, from(AZIMUTH, ELEVATION))
    } else if extent.y <= flat {
        (Vec3::Y, from(AZIMUTH, FLOOR_ELEVATION))
    } else if extent.x <= flat {
        (Vec3::X, from(FRAC_PI_2 - AZIMUTH, ELEVATION))
    } else {
        return from(AZIMUTH, ELEVATION);
    };
    if mean_normal(scene).dot(axis) < 0.0 {
        back - 2.0 * back.dot(axis) * axis
    } else {
        back
    }
}

/// The sum of all triangles' area vectors, in world space. A matrix takes area vectors by its
/// cofactors, so that each mesh is summed once.
fn mean_normal(scene: &Scene) -> Vec3 {
    let of_mesh = |mesh: &Arc<Mesh>| {
        let mut sum = Vec3::ZERO;
        for primitive in &mesh.primitives {
            for triangle in &primitive.triangles {
                let [a, b, c] = triangle.map(|index| primitive.positions[index as usize]);
                sum += (b - a).cross(c - a);
            }
        }
        sum
    };
    let sums: Vec<Vec3> = scene.meshes.iter().map(of_mesh).collect();
    let instances = scene.instances.iter();
    instances.fold(Vec3::ZERO, |total, instance| {
        let matrix = instance.world_from_object.matrix3;
        let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
        let cofactors = Mat3::from_cols(y.cross(z).into(), z.cross(x).into(), x.cross(y).into());
        total + cofactors * sums[instance.mesh]
    })
}

/// A perspective camera that sees the whole scene in a picture of the given width over height.
pub fn default_camera(scene: &Scene, aspect: f32) -> Camera {
    framing_camera(scene, bounds(scene), aspect, false)
}

/// The same for a box that may hold more than the scene shows at this moment. `turning`: so far away
/// that all of the box stays in sight while the camera turns about +y through the box's centre.
pub fn framing_camera(
    scene: &Scene,
    bounds: Option<(Vec3, Vec3)>,
    aspect: f32,
    turning: bool,
) -> Camera {
    let (low, high) = bounds.unwrap_or((Vec3::NEG_ONE, Vec3::ONE));
    let center = low.midpoint(high);
    let back = viewpoint(scene, high - low);
    let right = Vec3::Y.cross(back).normalize();
    let up = back.cross(right);
    // The farthest points in the picture decide: each must be inside at its own depth.
    let tan_y = (0.5 * YFOV).tan();
    let tan_x = tan_y * aspect;
    let mut distance = 0.0f32;
    for p in farthest(0.5 * (high - low), turning) {
        let needed = (p.dot(right).abs() / tan_x).max(p.dot(up).abs() / tan_y);
        distance = distance.max(needed + p.dot(back));
    }
    distance *= MARGIN;
    if distance <= 0.0 || !distance.is_finite() {
        distance = 1.0;
    }
    let matrix = Mat3::from_cols(right, up, back);
    Camera {
        name: "auto".to_owned(),
        world_from_camera: Affine3A::from_mat3_translation(matrix, center + back * distance),
        closing: None,
        lens: None,
        projection: Projection::Perspective {
            yfov: YFOV,
            aspect: None,
            near: NEAR * distance,
        },
    }
}

/// The corners of a box about the origin; for one that turns about +y, points of the rims of the
/// cylinder that it fills.
fn farthest(half: Vec3, turning: bool) -> Vec<Vec3> {
    /// So close that what lies between two is no farther by more than a thousandth.
    const STEPS: u32 = 72;
    let around: Vec<[f32; 2]> = if turning {
        let radius = half.x.hypot(half.z);
        let angles = (0..STEPS).map(|step| TAU * step as f32 / STEPS as f32);
        angles
            .map(|a| [radius * a.sin(), radius * a.cos()])
            .collect()
    } else {
        let (x, z) = (half.x, half.z);
        vec![[-x, -z], [x, -z], [-x, z], [x, z]]
    };
    let both = |[x, z]: [f32; 2]| [Vec3::new(x, -half.y, z), Vec3::new(x, half.y, z)];
    around.into_iter().flat_map(both).collect()
}
