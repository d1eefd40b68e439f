//! A scene's camera as the kernels take it.

use crate::scene::{self, Projection};
use crate::shared::{CAMERA_ORTHOGRAPHIC, CAMERA_PERSPECTIVE, Camera};

/// The camera for a picture of `film_size` pixels.
///
/// The vertical field of view is kept and the horizontal one follows the picture's shape, so the
/// camera's own aspect ratio only says which shape shows what its author framed (glTF 2.0 section
/// 3.10.3 leaves this to the viewer). The same holds for `ymag` and `xmag`. Scale in the camera's
/// transform is not applied.
pub fn pack_camera(camera: &scene::Camera, film_size: [u32; 2]) -> Camera {
    let matrix = camera.world_from_camera.matrix3;
    // Back and up decide; right follows, so a mirroring transform does not mirror the picture.
    let forward = -matrix.z_axis.normalize_or(glam::Vec3A::Z);
    let right = forward
        .cross(matrix.y_axis)
        .try_normalize()
        .unwrap_or_else(|| forward.any_orthonormal_vector());
    let up = right.cross(forward);
    let aspect = film_size[0] as f32 / film_size[1] as f32;
    let (kind, half_height, near) = match camera.projection {
        Projection::Perspective { yfov, near, .. } => {
            (CAMERA_PERSPECTIVE, (0.5 * yfov).tan(), near)
        }
        Projection::Orthographic { ymag, near, .. } => (CAMERA_ORTHOGRAPHIC, ymag.abs(), near),
    };
    Camera {
        origin: camera.world_from_camera.translation.to_array(),
        kind,
        right: right.to_array(),
        half_width: half_height * aspect,
        up: up.to_array(),
        half_height,
        forward: forward.to_array(),
        near,
    }
}
