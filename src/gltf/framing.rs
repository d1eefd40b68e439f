//! A camera for a scene that brings none.

use crate::scene::{Camera, Projection, Scene};
use glam::{Affine3A, Mat3, Vec3};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

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

/// The smallest box around all instances, in world space; `None` for an empty scene.
pub fn bounds(scene: &Scene) -> Option<(Vec3, Vec3)> {
    let points = world_positions(scene);
    points.fold(None, |bounds, p| match bounds {
        None => Some((p, p)),
        Some((low, high)) => Some((p.min(low), p.max(high))),
    })
}

fn world_positions(scene: &Scene) -> impl Iterator<Item = Vec3> + '_ {
    scene.instances.iter().flat_map(|instance| {
        let primitives = &scene.meshes[instance.mesh].primitives;
        primitives.iter().flat_map(|primitive| {
            let place = |p: &Vec3| instance.world_from_object.transform_point3(*p);
            primitive.positions.iter().map(place)
        })
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

/// The sum of all triangles' area vectors, in world space.
fn mean_normal(scene: &Scene) -> Vec3 {
    let mut sum = Vec3::ZERO;
    for instance in &scene.instances {
        for primitive in &scene.meshes[instance.mesh].primitives {
            let place = |index: u32| {
                let p = primitive.positions[index as usize];
                instance.world_from_object.transform_point3(p)
            };
            for triangle in &primitive.triangles {
                let [a, b, c] = triangle.map(place);
                sum += (b - a).cross(c - a);
            }
        }
    }
    sum
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
