//! From where: a camera of the scene, one on an orbit, or one that frames everything.

use glam::{Affine3A, Mat3, Vec3};

use crate::error::Error;
use crate::gltf::{bounds, default_camera};
use crate::scene::{Camera, Projection, Scene};

/// Vertical field of view of cameras on an orbit, radians.
const YFOV: f32 = std::f32::consts::FRAC_PI_4;

/// The camera asked for and what to call it. Without a choice it is the scene's first; a scene without
/// cameras is framed.
pub fn choose(
    scene: &Scene,
    choice: Option<&str>,
    orbit: Option<[f64; 3]>,
    size: [u32; 2],
) -> Result<(Camera, String), Error> {
    if let Some([theta, phi, radius]) = orbit {
        let (low, high) = bounds(scene).unwrap_or_default();
        let camera = orbiting(low.midpoint(high), theta, phi, radius);
        return Ok((camera, format!("orbit {theta},{phi},{radius}")));
    }
    let framing = || {
        let aspect = size[0] as f32 / size[1] as f32;
        (default_camera(scene, aspect), "auto".to_owned())
    };
    match choice {
        None => Ok(match scene.cameras.first() {
            Some(camera) => (camera.clone(), named(camera, 0)),
            None => framing(),
        }),
        Some("auto") => Ok(framing()),
        Some(choice) => {
            // A name wins over a number: a camera may be named "2".
            let index = scene
                .cameras
                .iter()
                .position(|camera| camera.name == choice)
                .or_else(|| choice.parse().ok().filter(|&i| i < scene.cameras.len()))
                .ok_or_else(|| no_such_camera(scene, choice))?;
            let camera = &scene.cameras[index];
            Ok((camera.clone(), named(camera, index)))
        }
    }
}

fn named(camera: &Camera, index: usize) -> String {
    if camera.name.is_empty() {
        index.to_string()
    } else {
        camera.name.clone()
    }
}

fn no_such_camera(scene: &Scene, choice: &str) -> Error {
    let cameras: Vec<String> = scene
        .cameras
        .iter()
        .enumerate()
        .map(|(i, camera)| format!("{i} '{}'", camera.name))
        .collect();
    Error::Usage(if cameras.is_empty() {
        format!(
            "there is no camera '{choice}': the scene has none; leave --camera away to have it framed"
        )
    } else {
        format!(
            "there is no camera '{choice}'; the scene has {}",
            cameras.join(", ")
        )
    })
}

/// `theta` about +y from +z, `phi` down from +y, in degrees (the convention of <model-viewer>'s
/// camera-orbit and of its render-fidelity tests); `radius` in metres.
fn orbiting(target: Vec3, theta: f64, phi: f64, radius: f64) -> Camera {
    /// The near plane, as a part of the radius.
    const NEAR: f64 = 1e-3;
    let (sin_theta, cos_theta) = theta.to_radians().sin_cos();
    let (sin_phi, cos_phi) = phi.to_radians().sin_cos();
    // The axes are written out and not made from a vector of "up", so that looking straight down or
    // up needs no exception.
    let vec3 = |x: f64, y: f64, z: f64| Vec3::new(x as f32, y as f32, z as f32);
    let right = vec3(cos_theta, 0.0, -sin_theta);
    let up = vec3(-cos_phi * sin_theta, sin_phi, -cos_phi * cos_theta);
    let back = vec3(sin_phi * sin_theta, cos_phi, sin_phi * cos_theta);
    Camera {
        name: String::new(),
        world_from_camera: Affine3A::from_mat3_translation(
            Mat3::from_cols(right, up, back),
            target + back * radius as f32,
        ),
        projection: Projection::Perspective {
            yfov: YFOV,
            aspect: None,
            near: (NEAR * radius) as f32,
        },
    }
}
