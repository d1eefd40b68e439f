//! Cameras against closed forms: lenses that blur, lenses that distort, pictures of all around.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod common;
#[path = "common/picture.rs"]
mod picture;

use common::shapes::{self, Random};
use glam::{Affine3A, DVec2, DVec3, Quat, UVec2, Vec3, Vec4};
use picture::*;
use snell::cpu::camera::{camera_at, camera_ray, distort};
use snell::pack::{PackError, View, pack};
use snell::scene::{Distortion, Environment, Intrinsics, Lens, Model, Projection, Scene};
use snell::shared::Camera;

fn packed_camera(view: &View) -> Result<Camera, PackError> {
    pack(&Scene::default(), view).map(|packed| packed.frame.camera)
}

fn through(intrinsics: Intrinsics) -> View {
    let mut view = shapes::view();
    view.film_size = intrinsics.size;
    view.camera.projection = Projection::Intrinsics(intrinsics);
    view
}

fn undistorted() -> Distortion {
    Distortion::BrownConrady {
        radial: [0.0; 6],
        tangential: [0.0; 2],
        prism: [0.0; 4],
    }
}

/// Lenses as calibrations find them: mild, wide with a rational model, and a tilted sensor.
fn lenses() -> Vec<Intrinsics> {
    let brown = |focal: f32, radial, tangential, prism| Intrinsics {
        size: [640, 480],
        focal: [focal, 1.01 * focal],
        center: [311.3, 248.1],
        distortion: Distortion::BrownConrady {
            radial,
            tangential,
            prism,
        },
    };
    vec![
        brown(
            600.0,
            [-0.28, 0.09, -0.01, 0.0, 0.0, 0.0],
            [1e-3, -5e-4],
            [0.0; 4],
        ),
        brown(
            450.0,
            [0.6, 0.06, 0.002, 0.95, 0.18, 0.008],
            [3e-4, 2e-4],
            [0.0; 4],
        ),
        brown(
            500.0,
            [0.12, -0.2, 0.1, 0.0, 0.0, 0.0],
            [-2e-3, 3e-3],
            [2e-3, -1e-3, -3e-3, 5e-4],
        ),
    ]
}

fn fisheye() -> Intrinsics {
    Intrinsics {
        size: [640, 480],
        focal: [190.0, 190.0],
        center: [320.5, 238.0],
        distortion: Distortion::Fisheye([0.05, -0.01, 0.004, -0.0008]),
    }
}

const RAYS: &str = "
import package::shared::{Camera};
import package::ray::{Ray};
import package::camera::{camera_at, camera_ray};
struct Query { camera: Camera, position: vec2<f32>, size: vec2<u32>, lens: vec2<f32>, time: f32, reserved: f32 }
@group(3) @binding(0) var<storage, read> queries: array<Query>;
@group(3) @binding(1) var<storage, read_write> answers: array<Ray>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&queries) { return; }
    let q = queries[id.x];
    answers[id.x] = camera_ray(camera_at(q.camera, q.time), q.size, q.position, q.lens);
}";

/// Every kind of camera, moving ones too: the kernels' rays are the reference's.
#[test]
fn rays_agree_with_float64() {
    let mut random = Random(41);
    let mut views: Vec<View> = lenses().into_iter().map(through).collect();
    views.push(through(fisheye()));
    let mut panorama = shapes::view();
    panorama.camera.projection = Projection::Panorama;
    views.extend([panorama, shapes::view()]);
    for view in &mut views {
        let turn = Quat::from_axis_angle(random.direction(), 1.0);
        view.camera.world_from_camera = Affine3A::from_rotation_translation(turn, random.cube());
        let turn = turn * Quat::from_axis_angle(random.direction(), 0.5);
        view.camera.closing = Some(Affine3A::from_rotation_translation(turn, random.cube()));
        view.camera.lens = Some(Lens {
            aperture: 0.1,
            focus: Some(2.0),
        });
    }
    let (mut bytes, mut expected) = (Vec::new(), Vec::new());
    for view in &views {
        let camera = packed_camera(view).unwrap();
        let size = UVec2::from(view.film_size);
        for _ in 0..2000 {
            let position = [random.unit(), random.unit()];
            let position = [position[0] * size.x as f32, position[1] * size.y as f32];
            let (lens, time) = (
                [random.range(-0.7, 0.7), random.range(-0.7, 0.7)],
                random.unit(),
            );
            bytes.extend_from_slice(bytemuck::bytes_of(&camera));
            bytes.extend_from_slice(bytemuck::cast_slice(&position));
            bytes.extend_from_slice(bytemuck::cast_slice(&view.film_size));
            bytes.extend_from_slice(bytemuck::cast_slice(&[lens[0], lens[1], time, 0.0]));
            let [position, lens] = [position, lens].map(|v| glam::Vec2::from(v).as_dvec2());
            expected.push(camera_ray(
                &camera_at(&camera, time.into()),
                size,
                position,
                lens,
            ));
        }
    }
    let answers = common::run(RAYS, &[&bytes], expected.len() * 48, expected.len() as u32);
    let answers: Vec<[f32; 12]> = bytemuck::pod_collect_to_vec(&answers);
    for (number, (a, ray)) in answers.iter().zip(&expected).enumerate() {
        let vector = |at: usize| Vec3::new(a[at], a[at + 1], a[at + 2]).as_dvec3();
        let view = number / 2000;
        assert!(vector(0).distance(ray.origin) < 2e-6, "view {view}");
        let off = vector(4).distance(ray.direction);
        assert!(off < 3e-6, "view {view}: {off:e}");
        assert!((ray.direction.length() - 1.0).abs() < 1e-9);
    }
}

/// At both ends of the shutter the camera is exactly the pose that was given; in between its axes are
/// orthonormal.
#[test]
fn a_moving_camera_passes_its_poses() {
    let mut view = shapes::view();
    let turn = Quat::from_rotation_y(0.8);
    let closing = Affine3A::from_rotation_translation(turn, Vec3::new(1.0, 2.0, 3.0));
    view.camera.closing = Some(closing);
    let camera = packed_camera(&view).unwrap();
    for (time, pose) in [(0.0, Affine3A::IDENTITY), (1.0, closing)] {
        let placed = camera_at(&camera, time);
        let near =
            |v: DVec3, expected: glam::Vec3A| v.distance(Vec3::from(expected).as_dvec3()) < 1e-6;
        assert!(near(placed.origin, pose.translation));
        assert!(near(placed.right, pose.matrix3.x_axis) && near(placed.up, pose.matrix3.y_axis));
        assert!(near(placed.forward, -pose.matrix3.z_axis));
    }
    let middle = camera_at(&camera, 0.5);
    assert!(middle.origin.distance(DVec3::new(0.5, 1.0, 1.5)) < 1e-6);
    for (a, b, product) in [
        (middle.right, middle.right, 1.0),
        (middle.up, middle.up, 1.0),
        (middle.forward, middle.forward, 1.0),
        (middle.right, middle.up, 0.0),
        (middle.right, middle.forward, 0.0),
        (middle.up, middle.forward, 0.0),
    ] {
        assert!((a.dot(b) - product).abs() < 1e-9);
    }
}

/// What a lens takes to a pixel comes back from it, over the whole picture.
#[test]
fn distortion_is_undone_over_the_whole_picture() {
    for intrinsics in lenses() {
        let camera = camera_at(&packed_camera(&through(intrinsics)).unwrap(), 0.0);
        let [width, height] = intrinsics.size;
        let mut bent = 0.0_f64;
        for (x, y) in (0..=height / 8).flat_map(|y| (0..=width / 8).map(move |x| (8 * x, 8 * y))) {
            let pixel = DVec2::new(f64::from(x), f64::from(y));
            let ray = camera_ray(&camera, UVec2::new(width, height), pixel, DVec2::ZERO);
            let point = DVec2::new(ray.direction.x, -ray.direction.y) / -ray.direction.z;
            let [fx, fy] = intrinsics.focal.map(f64::from);
            let [cx, cy] = intrinsics.center.map(f64::from);
            // OpenCV counts from the first pixel's centre, which is ours at one half.
            let of = |p: DVec2| DVec2::new(fx * p.x + cx, fy * p.y + cy) + 0.5;
            assert!(of(distort(&camera, point)).distance(pixel) < 1e-4);
            bent = bent.max(of(point).distance(pixel));
        }
        assert!(bent > 5.0, "the lens bends by {bent} pixels only");
    }
}

/// The forward model of Kannala and Brandt, written out again.
#[test]
fn a_fisheye_sees_behind_itself() {
    let intrinsics = fisheye();
    let Distortion::Fisheye(k) = intrinsics.distortion else {
        unreachable!()
    };
    let camera = camera_at(&packed_camera(&through(intrinsics)).unwrap(), 0.0);
    let mut widest = 0.0_f64;
    for (x, y) in (0..60).flat_map(|y| (0..80).map(move |x| (8 * x, 8 * y))) {
        let pixel = DVec2::new(f64::from(x), f64::from(y));
        let ray = camera_ray(&camera, UVec2::from(intrinsics.size), pixel, DVec2::ZERO);
        let theta = (-ray.direction.z).acos();
        widest = widest.max(theta);
        let powers = (1..=4).map(|i| f64::from(k[i as usize - 1]) * theta.powi(2 * i));
        let reached = 190.0 * theta * (1.0 + powers.sum::<f64>());
        let around = DVec2::new(ray.direction.x, -ray.direction.y).normalize_or_zero();
        let film = reached * around + DVec2::new(321.0, 238.5);
        assert!(film.distance(pixel) < 1e-3, "{film} is not {pixel}");
    }
    assert!(widest > 1.6, "90 degrees are passed: {widest}");
}

#[test]
fn a_lens_that_folds_is_refused() {
    let mut folding = lenses()[0];
    folding.distortion = Distortion::BrownConrady {
        radial: [-0.9, 0.0, 0.0, 0.0, 0.0, 0.0],
        tangential: [0.0; 2],
        prism: [0.0; 4],
    };
    let error = packed_camera(&through(folding)).unwrap_err();
    assert!(matches!(error, PackError::Folded { .. }), "{error}");
    let mut folding = fisheye();
    folding.distortion = Distortion::Fisheye([-0.3, 0.0, 0.0, 0.0]);
    let error = packed_camera(&through(folding)).unwrap_err();
    assert!(matches!(error, PackError::Folded { .. }), "{error}");
}

/// Without distortion and centred, intrinsics are glTF's perspective.
#[test]
fn plain_intrinsics_are_a_perspective_camera() {
    let mut view = shapes::view();
    view.film_size = [320, 200];
    let yfov = 0.9_f32;
    view.camera.projection = Projection::Perspective {
        yfov,
        aspect: None,
        near: 0.0,
    };
    let expected = packed_camera(&view).unwrap();
    let focal = 100.0 / (0.5 * yfov).tan();
    let camera = packed_camera(&through(Intrinsics {
        size: [320, 200],
        focal: [focal; 2],
        center: [159.5, 99.5],
        distortion: undistorted(),
    }))
    .unwrap();
    assert_eq!((camera.kind, camera.center), (expected.kind, [0.0; 2]));
    assert!((camera.half_width / expected.half_width - 1.0).abs() < 1e-6);
    assert!((camera.half_height / expected.half_height - 1.0).abs() < 1e-6);
}

/// A white square far smaller than a pixel, `depth` metres ahead, through a lens that focuses at `focus`:
/// the variance of its picture along x, in square metres at one metre of depth.
fn blur(depth: f32, lens: Option<Lens>) -> f64 {
    let half = 0.002 * depth;
    let corner = |x: f32, y: f32| Vec3::new(x * half, y * half, -depth);
    let dot = shapes::flat(&[
        [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0)],
        [corner(-1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
    ]);
    let mut scene = shapes::scene(vec![dot], vec![shapes::instance(0, Affine3A::IDENTITY)]);
    scene.materials[0].model = Model::Unlit {
        base_color: Vec4::ONE,
        base_color_texture: None,
    };
    let mut view = shapes::view();
    view.film_size = [64, 64];
    view.camera.projection = Projection::Perspective {
        yfov: 2.0 * 0.08_f32.atan(),
        aspect: None,
        near: 0.0,
    };
    view.camera.lens = lens;
    let packed = pack(&scene, &view).unwrap();
    let film = on_gpu(&mut common::gpu(), &packed, &whole(&packed, 1024));
    let pixel = 2.0 * 0.08 / 64.0;
    let (mut sum, mut squares) = (0.0, 0.0);
    for (column, row) in (0..64).flat_map(|row| (0..64).map(move |column| (column, row))) {
        let weight = film.pixel(column, row).mean()[0];
        let x = (f64::from(column) + 0.5 - 32.0) * pixel;
        sum += weight;
        squares += weight * x * x;
    }
    squares / sum
}

/// The circle of confusion of a point: aperture |1 / focus - 1 / depth| at one metre of depth. A uniform
/// disk of diameter c has the variance c^2 / 16 along an axis; filter and square add theirs, which the
/// pinhole shows.
#[test]
fn the_circle_of_confusion_is_the_thin_lens_formula() {
    for (depth, focus) in [(1.0, 2.0), (4.0, 2.0)] {
        let aperture = 0.2;
        let lens = Lens {
            aperture,
            focus: Some(focus),
        };
        let added = blur(depth, Some(lens)) - blur(depth, None);
        let diameter = 4.0 * added.sqrt();
        let expected = f64::from(aperture * (1.0 / focus - 1.0 / depth).abs());
        println!("at {depth} m: {diameter} and {expected}");
        assert!((diameter / expected - 1.0).abs() < 0.03);
    }
    // In focus nothing is blurred.
    let sharp = Lens {
        aperture: 0.2,
        focus: Some(2.0),
    };
    assert!((blur(2.0, Some(sharp)) / blur(2.0, None) - 1.0).abs() < 0.03);
}

/// An environment that is photographed all around is itself.
#[test]
fn a_panorama_of_a_map_is_the_map() {
    const SIZE: [u32; 2] = [64, 32];
    // Smooth, so that the pixel filter changes little, and different along both axes.
    let value = |x: f64, y: f64| {
        let (u, v) = (2.0 * std::f64::consts::PI * x, std::f64::consts::PI * y);
        [
            1.0 + 0.5 * u.sin() * v.sin(),
            1.0 + 0.8 * v.cos(),
            1.0 + 0.5 * u.cos() * v.sin(),
        ]
    };
    let texels = |f: &dyn Fn(f64, f64) -> [f64; 3]| -> Vec<[f32; 3]> {
        (0..SIZE[1])
            .flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)))
            .map(|(x, y)| {
                let at = |i: u32, size: u32| (f64::from(i) + 0.5) / f64::from(size);
                f(at(x, SIZE[0]), at(y, SIZE[1])).map(|c| c as f32)
            })
            .collect()
    };
    let scene = Scene {
        environment: Some(Environment {
            width: SIZE[0],
            height: SIZE[1],
            radiance: texels(&value),
            strength: 1.0,
            rotation: 0.0,
        }),
        ..Scene::default()
    };
    let mut view = shapes::view();
    view.film_size = SIZE;
    view.camera.projection = Projection::Panorama;
    let packed = pack(&scene, &view).unwrap();
    let settings = whole(&packed, 64);
    for film in [
        on_gpu(&mut common::gpu(), &packed, &settings),
        on_cpu(&packed, &settings),
    ] {
        // Over a pole the filter mixes two sides.
        for (x, y) in (2..SIZE[1] - 2).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y))) {
            let at = |i: u32, size: u32| (f64::from(i) + 0.5) / f64::from(size);
            let expected = value(at(x, SIZE[0]), at(y, SIZE[1]));
            for (mean, expected) in film.pixel(x, y).mean().iter().zip(expected) {
                assert!(
                    (mean - expected).abs() < 0.03,
                    "{x},{y}: {mean}, {expected}"
                );
            }
        }
    }
    // Turned by a quarter about +y, the camera sees the map shifted by a quarter.
    view.camera.world_from_camera = Affine3A::from_rotation_y(std::f32::consts::FRAC_PI_2);
    let turned = on_cpu(&pack(&scene, &view).unwrap(), &settings);
    let expected = value((40.0 + 0.5 - 16.0) / 64.0, (10.0 + 0.5) / 32.0);
    let mean = turned.pixel(40, 10).mean();
    assert!((mean[0] - expected[0]).abs() < 0.03 && (mean[2] - expected[2]).abs() < 0.03);
}
