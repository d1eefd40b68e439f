//! A scene's camera as the kernels take it.

use super::PackError;
use crate::cpu::camera::{
    PlacedCamera, camera_at, distort, distort_derivative, fisheye_angle, fisheye_slope, undistort,
};
use crate::scene::{self, Distortion, Intrinsics, Projection};
use crate::shared::{
    CAMERA_BROWN_CONRADY, CAMERA_FISHEYE, CAMERA_ORTHOGRAPHIC, CAMERA_PANORAMA, CAMERA_PERSPECTIVE,
    Camera,
};
use bytemuck::Zeroable;
use glam::{Affine3A, DVec2, Vec3A};

/// The camera for a picture of `film_size` pixels.
///
/// The vertical field of view is kept and the horizontal one follows the picture's shape, so the
/// camera's own aspect ratio only says which shape shows what its author framed (glTF 2.0 section
/// 3.10.3 leaves this to the viewer). The same holds for `ymag` and `xmag`. Scale in the camera's
/// transform is not applied.
pub fn pack_camera(camera: &scene::Camera, film_size: [u32; 2]) -> Result<Camera, PackError> {
    let [right, up, forward] = axes(&camera.world_from_camera);
    let closing = camera.closing.unwrap_or(camera.world_from_camera);
    let [closing_right, _, closing_forward] = axes(&closing);
    let mut packed = Camera {
        origin: camera.world_from_camera.translation.to_array(),
        right: right.to_array(),
        up: up.to_array(),
        forward: forward.to_array(),
        closing_origin: closing.translation.to_array(),
        closing_right: closing_right.to_array(),
        closing_forward: closing_forward.to_array(),
        moves: u32::from(camera.closing.is_some()),
        ..Camera::zeroed()
    };
    if let Some(lens) = camera.lens {
        packed.lens_radius = 0.5 * lens.aperture;
        // One that is not given is measured in the packed scene.
        packed.focus = lens.focus.unwrap_or(1.0);
    }
    let aspect = film_size[0] as f32 / film_size[1] as f32;
    match camera.projection {
        Projection::Perspective { yfov, near, .. } => {
            packed.kind = CAMERA_PERSPECTIVE;
            packed.half_height = (0.5 * yfov).tan();
            packed.half_width = packed.half_height * aspect;
            packed.near = near;
        }
        Projection::Orthographic { ymag, near, .. } => {
            packed.kind = CAMERA_ORTHOGRAPHIC;
            packed.half_height = ymag.abs();
            packed.half_width = packed.half_height * aspect;
            packed.near = near;
        }
        Projection::Panorama => packed.kind = CAMERA_PANORAMA,
        Projection::Intrinsics(intrinsics) => {
            pack_intrinsics(&mut packed, &intrinsics);
            check_lens(&camera_at(&packed, 0.0), film_size)?;
        }
    }
    Ok(packed)
}

/// Right, up, forward. Back and up decide; right follows, so a mirroring transform does not mirror the
/// picture.
fn axes(world_from_camera: &Affine3A) -> [Vec3A; 3] {
    let matrix = world_from_camera.matrix3;
    let forward = -matrix.z_axis.normalize_or(Vec3A::Z);
    let right = forward
        .cross(matrix.y_axis)
        .try_normalize()
        .unwrap_or_else(|| forward.any_orthonormal_vector());
    [right, right.cross(forward), forward]
}

/// OpenCV's pixel (0, 0) has its centre there, ours at (1/2, 1/2); at another size of the same shape all
/// scales alike, so the film is measured in the calibration's own pixels.
fn pack_intrinsics(packed: &mut Camera, intrinsics: &Intrinsics) {
    let along = |axis: usize| {
        let half = 0.5 * f64::from(intrinsics.size[axis]);
        let focal = f64::from(intrinsics.focal[axis]);
        let center = half - 0.5 - f64::from(intrinsics.center[axis]);
        [(half / focal) as f32, (center / focal) as f32]
    };
    let ([half_width, x], [half_height, y]) = (along(0), along(1));
    (packed.half_width, packed.half_height, packed.center) = (half_width, half_height, [x, y]);
    match intrinsics.distortion {
        Distortion::BrownConrady {
            radial: [k1, k2, k3, k4, k5, k6],
            tangential: [p1, p2],
            prism,
        } => {
            packed.distortion = [[k1, k2, p1, p2], [k3, k4, k5, k6], prism];
            packed.kind = if packed.distortion == [[0.0; 4]; 3] {
                CAMERA_PERSPECTIVE
            } else {
                CAMERA_BROWN_CONRADY
            };
        }
        Distortion::Fisheye(k) => {
            packed.kind = CAMERA_FISHEYE;
            packed.distortion[0] = k;
        }
    }
}

/// Points of the film, along each side, at which a lens is tried.
const TRIED: u32 = 64;
/// Points between the axis and each of them at which it must not turn back.
const BETWEEN: u32 = 16;
/// The pixel filter reaches this far over the film's border, pixels.
const BORDER_PX: f64 = 1.5;
/// What the steps may leave of the way to the root, at one metre of depth.
const CONVERGED: f64 = 1e-6;

/// Whether the renderer's own steps find, for every point of the film, the one direction that the lens
/// shows there: the lens must not fold the picture over inside its frame.
fn check_lens(camera: &PlacedCamera, film_size: [u32; 2]) -> Result<(), PackError> {
    for row in 0..=TRIED {
        for column in 0..=TRIED {
            let side = |at: u32, size: u32| {
                let reach = 1.0 + 2.0 * BORDER_PX / f64::from(size);
                (2.0 * f64::from(at) / f64::from(TRIED) - 1.0) * reach
            };
            let ndc = DVec2::new(side(column, film_size[0]), side(row, film_size[1]));
            let film = ndc * camera.half + camera.center;
            let seen = match camera.kind {
                CAMERA_BROWN_CONRADY => shows_once(camera, film),
                CAMERA_FISHEYE => turns_on(camera, film.length()),
                _ => film.is_finite(),
            };
            if !seen {
                let pixel = (ndc + 1.0) * 0.5;
                return Err(PackError::Folded {
                    column: (pixel.x * f64::from(film_size[0])).floor() as i64,
                    row: (pixel.y * f64::from(film_size[1])).floor() as i64,
                });
            }
        }
    }
    Ok(())
}

fn shows_once(camera: &PlacedCamera, film: DVec2) -> bool {
    let p = undistort(camera, film);
    let left = (distort(camera, p) - film).length();
    // From the axis outwards the picture keeps its side.
    left <= CONVERGED * (1.0 + film.length())
        && (0..=BETWEEN).all(|step| {
            let on_the_way = p * (f64::from(step) / f64::from(BETWEEN));
            distort_derivative(camera, on_the_way).determinant() > 0.0
        })
}

fn turns_on(camera: &PlacedCamera, distance: f64) -> bool {
    let k = camera.distortion[0];
    let (theta, left) = fisheye_angle(k, distance);
    left.abs() <= CONVERGED
        && (0.0..=std::f64::consts::PI).contains(&theta)
        && (0..=BETWEEN)
            .all(|step| fisheye_slope(k, theta * f64::from(step) / f64::from(BETWEEN)) > 0.0)
}
