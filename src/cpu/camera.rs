//! Camera rays. The film's aspect is in `half_width` and `half_height` already.

use crate::cpu::ray::Ray;
use crate::shared::{CAMERA_ORTHOGRAPHIC, Camera};
use glam::{DVec2, UVec2, Vec3};

/// Farther than any scene, metres: near the largest float32, and finite.
pub const CAMERA_FAR: f64 = 1e30;

/// The ray through `position` on the film, pixels, row 0 on top: glTF 2.0 section 3.10.3. Starts
/// at the camera and counts from its near plane.
pub fn camera_ray(camera: &Camera, film_size: UVec2, position: DVec2) -> Ray {
    let ndc = 2.0 * position / film_size.as_dvec2() - 1.0;
    let across = ndc.x * f64::from(camera.half_width) * Vec3::from(camera.right).as_dvec3()
        - ndc.y * f64::from(camera.half_height) * Vec3::from(camera.up).as_dvec3();
    let origin = Vec3::from(camera.origin).as_dvec3();
    let forward = Vec3::from(camera.forward).as_dvec3();
    let near = f64::from(camera.near);
    if camera.kind == CAMERA_ORTHOGRAPHIC {
        return Ray {
            origin: origin + across,
            t_min: near,
            direction: forward,
            t_max: CAMERA_FAR,
            time: 0.0,
        };
    }
    let direction = forward + across;
    // The camera's axes are orthonormal, so this is also how far along the ray one metre of depth is.
    let length = direction.length();
    Ray {
        origin,
        t_min: near * length,
        direction: direction / length,
        t_max: CAMERA_FAR,
        time: 0.0,
    }
}
