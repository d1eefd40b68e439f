//! From where: a camera of the scene, one on an orbit, or one that frames everything.

use glam::{Affine3A, DVec2, DVec3, Mat3, Quat, UVec2, Vec3};

use super::render::RenderArgs;
use super::value::Orbit;
use crate::cpu::bvh::trace_closest;
use crate::cpu::camera::{PlacedCamera, camera_at, camera_ray};
use crate::error::Error;
use crate::gltf::{self, framing_camera};
use crate::pack::Packed;
use crate::scene::{Camera, Distortion, Intrinsics, Lens, Projection, Scene};
use crate::shared::NONE;

/// The choice of a camera that looks all around.
const PANORAMA: &str = "panorama";

/// Vertical field of view of cameras on an orbit, radians.
const YFOV: f32 = std::f32::consts::FRAC_PI_4;

/// What a camera is placed by where the scene's own do not say all.
pub struct Stage {
    center: Vec3,
    /// The one that frames everything.
    framing: Camera,
    /// What a turntable turns about.
    pivot: Vec3,
}

impl Stage {
    /// `bounds`: of all that is to be seen, which may be more than this scene.
    pub fn new(scene: &Scene, bounds: Option<(Vec3, Vec3)>, args: &RenderArgs) -> Self {
        let [width, height] = args.size;
        let turning = args.turntable.is_some();
        let (low, high) = bounds.unwrap_or_default();
        let center = low.midpoint(high);
        let mut stage = Self {
            center,
            framing: framing_camera(scene, bounds, width as f32 / height as f32, turning),
            pivot: center,
        };
        if turning && let Ok((camera, _)) = standing(scene, args, Some(&stage)) {
            stage.pivot = pivot(scene, &camera, args, &stage);
        }
        stage
    }
}

/// The box around two boxes.
pub fn around(one: Option<(Vec3, Vec3)>, other: Option<(Vec3, Vec3)>) -> Option<(Vec3, Vec3)> {
    match (one, other) {
        (Some((low, high)), Some((l, h))) => Some((low.min(l), high.max(h))),
        (one, other) => one.or(other),
    }
}

/// Whether the camera asked for is placed or turned by a [`Stage`].
pub fn is_staged(scene: &Scene, args: &RenderArgs) -> bool {
    args.turntable.is_some()
        || match args.camera.as_deref() {
            Some(choice) => choice == "auto" || choice == PANORAMA,
            None => args.orbit.is_some() || scene.cameras.is_empty(),
        }
}

/// The camera asked for and what to call it. Without a choice it is the scene's first; a scene without
/// cameras is framed. `turn`: by so many degrees about +y through the stage's pivot.
pub fn choose(
    scene: &Scene,
    args: &RenderArgs,
    stage: Option<&Stage>,
    turn: Option<f64>,
) -> Result<(Camera, String), Error> {
    let (mut camera, mut name) = standing(scene, args, stage)?;
    if let (Some(degrees), Some(stage)) = (turn, stage) {
        let turn = Quat::from_rotation_y(degrees.to_radians() as f32);
        let about = Affine3A::from_rotation_translation(turn, stage.pivot - turn * stage.pivot);
        camera.world_from_camera = about * camera.world_from_camera;
        camera.closing = camera.closing.map(|pose| about * pose);
        name = format!("{name} turned by {degrees}");
    }
    if let Some(calibration) = &args.calibration {
        if camera.projection == Projection::Panorama {
            return Err(Error::Usage(
                "--intrinsics and --camera panorama are two cameras; give one".into(),
            ));
        }
        camera.projection = Projection::Intrinsics(calibration.intrinsics);
    }
    if args.aperture > 0.0 {
        if let Some(without) = without_lens(&camera.projection) {
            return Err(Error::Usage(format!(
                "--aperture is of a lens, and {without} camera has none; leave it away or take a perspective camera"
            )));
        }
        camera.lens = Some(Lens {
            aperture: args.aperture as f32,
            focus: args.focus.map(|metres| metres as f32),
        });
    }
    Ok((camera, name))
}

/// What a camera turns about: an orbit's target, the scene's centre where everything is framed, and else
/// what the middle of the picture shows, so that it stays there. Where that is nothing, the point ahead that
/// is nearest to the scene's centre.
fn pivot(scene: &Scene, camera: &Camera, args: &RenderArgs, stage: &Stage) -> Vec3 {
    let pose = camera.world_from_camera;
    if let Some(orbit) = args.orbit {
        return orbit
            .target
            .map_or(stage.center, |target| DVec3::from(target).as_vec3());
    }
    if camera.projection == Projection::Panorama || pose == stage.framing.world_from_camera {
        return stage.center;
    }
    let origin = Vec3::from(pose.translation);
    let forward = Vec3::from(-pose.matrix3.z_axis).normalize_or_zero();
    let distance = first_along(scene, origin, forward)
        .unwrap_or_else(|| (stage.center - origin).dot(forward).max(0.0));
    origin + distance * forward
}

/// The distance to the first triangle along a ray, `direction` of unit length; no hierarchy is built for a
/// single ray.
fn first_along(scene: &Scene, origin: Vec3, direction: Vec3) -> Option<f32> {
    let mut nearest = f32::INFINITY;
    for instance in &scene.instances {
        // Distances along the ray are the same in the object's space.
        let object_from_world = instance.world_from_object.inverse();
        let from = object_from_world.transform_point3(origin);
        let along = object_from_world.transform_vector3(direction);
        for primitive in &scene.meshes[instance.mesh].primitives {
            for triangle in &primitive.triangles {
                let [p0, p1, p2] = triangle.map(|corner| primitive.positions[corner as usize]);
                let (e1, e2) = (p1 - p0, p2 - p0);
                let pvec = along.cross(e2);
                let qvec = (from - p0).cross(e1);
                let det = e1.dot(pvec);
                let (u, v) = ((from - p0).dot(pvec) / det, along.dot(qvec) / det);
                let t = e2.dot(qvec) / det;
                if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < nearest {
                    nearest = t;
                }
            }
        }
    }
    nearest.is_finite().then_some(nearest)
}

/// What a camera is called that a thin lens says nothing of.
fn without_lens(projection: &Projection) -> Option<&'static str> {
    match projection {
        Projection::Orthographic { .. } => Some("an orthographic"),
        Projection::Panorama => Some("a panorama"),
        Projection::Intrinsics(Intrinsics {
            distortion: Distortion::Fisheye(_),
            ..
        }) => Some("a fisheye"),
        Projection::Perspective { .. } | Projection::Intrinsics(_) => None,
    }
}

/// Puts in focus what the middle of the picture shows, if a lens was asked for and nothing else said: the
/// scene's centre where it shows nothing.
pub fn focus(scene: &Scene, args: &RenderArgs, packed: &mut Packed) -> Result<(), Error> {
    if args.aperture <= 0.0 || args.focus.is_some() {
        return Ok(());
    }
    let camera = camera_at(&packed.frame.camera, 0.0);
    let pinhole = PlacedCamera {
        lens_radius: 0.0,
        ..camera
    };
    let film_size = UVec2::from(packed.frame.film_size);
    let ray = camera_ray(&pinhole, film_size, 0.5 * film_size.as_dvec2(), DVec2::ZERO);
    let hit = trace_closest(packed, ray, 0);
    let shown = match (hit.instance, gltf::bounds(scene)) {
        (NONE, None) => None,
        (NONE, Some((low, high))) => Some(low.midpoint(high).as_dvec3()),
        _ => Some(ray.origin + hit.t * ray.direction),
    };
    let distance = shown.map_or(0.0, |p| (p - camera.origin).dot(camera.forward));
    if distance <= 0.0 {
        return Err(Error::Usage(
            "--aperture needs --focus: there is nothing ahead of the camera to focus on".into(),
        ));
    }
    packed.frame.camera.focus = distance as f32;
    Ok(())
}

/// The same without a turn.
fn standing(
    scene: &Scene,
    args: &RenderArgs,
    stage: Option<&Stage>,
) -> Result<(Camera, String), Error> {
    if let Some(pose) = args
        .calibration
        .and_then(|calibration| calibration.world_from_camera)
    {
        let mut camera = orbiting(Vec3::ZERO, 0.0, 90.0, 1.0);
        camera.world_from_camera = pose;
        return Ok((camera, "intrinsics".to_owned()));
    }
    if let (Some(orbit), Some(stage)) = (args.orbit, stage) {
        let Orbit {
            theta,
            phi,
            radius,
            target,
        } = orbit;
        let around = target.map_or_else(String::new, |[x, y, z]| format!(",{x},{y},{z}"));
        let target = target.map_or(stage.center, |target| DVec3::from(target).as_vec3());
        let camera = orbiting(target, theta, phi, radius);
        return Ok((camera, format!("orbit {theta},{phi},{radius}{around}")));
    }
    if let Some(choice) = args
        .camera
        .as_deref()
        .and_then(|choice| choice.strip_prefix(PANORAMA))
    {
        let camera = match (choice.strip_prefix(':'), stage) {
            (Some(choice), _) => Some(find(scene, choice)?.0),
            (None, Some(stage)) if choice.is_empty() => {
                let mut camera = orbiting(stage.center, 0.0, 90.0, 1.0);
                camera.world_from_camera = Affine3A::from_translation(stage.center);
                Some(camera)
            }
            _ => None,
        };
        if let Some(mut camera) = camera {
            camera.projection = Projection::Panorama;
            return Ok((camera, args.camera.clone().unwrap_or_default()));
        }
    }
    let framing = stage.map(|stage| (stage.framing.clone(), "auto".to_owned()));
    match (args.camera.as_deref(), scene.cameras.first(), framing) {
        (None, Some(camera), _) => Ok((camera.clone(), named(camera, 0))),
        (None | Some("auto"), _, Some(framing)) => Ok(framing),
        (choice, ..) => {
            let choice = choice.unwrap_or("auto");
            find(scene, choice)
        }
    }
}

/// A camera of the scene, and what to call it.
fn find(scene: &Scene, choice: &str) -> Result<(Camera, String), Error> {
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
        closing: None,
        lens: None,
        projection: Projection::Perspective {
            yfov: YFOV,
            aspect: None,
            near: (NEAR * radius) as f32,
        },
    }
}
