//! The sampler's streams bit for bit, their stratification, and the warps and camera rays made from
//! them, on lavapipe and in the reference.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod common;

use bytemuck::Zeroable;
use common::shapes::Random;
use common::statistics::{assert_p, assert_uniform, chi_square_p};
use glam::{DVec2, DVec3, UVec2, Vec3};
use snell::cpu::camera::{camera_at, camera_ray};
use snell::cpu::filter::*;
use snell::cpu::rng::{hash_combine, hash_u32, next_1d, next_2d, rng_init};
use snell::cpu::sample::*;
use snell::cpu::sobol::{
    owen_scramble, sobol_dimension0, sobol_dimension1, sobol_scrambled0, sobol_scrambled1,
};
use snell::shared::{CAMERA_ORTHOGRAPHIC, CAMERA_PERSPECTIVE, Camera};
use std::f64::consts::{PI, TAU};

const COUNT: usize = 100_000;

#[test]
fn streams_are_equal_bit_for_bit() {
    let mut uniform = Random(1);
    // Pixel, sample, first dimension, seed; small numbers as a picture has them, and any at all.
    let queries: Vec<[u32; 8]> = (0..COUNT)
        .map(|i| {
            let mut word = |small: u32| match i % 4 {
                0 => uniform.bits() as u32,
                _ => uniform.bits() as u32 % small,
            };
            [
                word(4096),
                word(4096),
                word(1024),
                word(64),
                word(8),
                0,
                0,
                0,
            ]
        })
        .collect();
    let root = "
import package::rng::{Rng, rng_init, next_1d, next_2d, hash_u32, hash_combine};
@group(3) @binding(0) var<storage, read> queries: array<array<u32, 8>>;
@group(3) @binding(1) var<storage, read_write> answers: array<array<u32, 8>>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&queries) { return; }
    let q = queries[id.x];
    var rng = rng_init(vec2<u32>(q[0], q[1]), q[2], q[4]);
    rng.dimension = q[3];
    let a = next_1d(&rng);
    let b = next_2d(&rng);
    let c = next_1d(&rng);
    answers[id.x] = array<u32, 8>(bitcast<u32>(a), bitcast<u32>(b.x), bitcast<u32>(b.y),
        bitcast<u32>(c), rng.dimension, rng.pixel_seed, hash_u32(q[0]), hash_combine(q[0], q[1]));
}";
    let bytes = common::run(
        root,
        &[bytemuck::cast_slice(&queries)],
        COUNT * 32,
        COUNT as u32,
    );
    let answers: Vec<[u32; 8]> = bytemuck::pod_collect_to_vec(&bytes);
    for (q, answer) in queries.iter().zip(&answers) {
        let mut rng = rng_init(UVec2::new(q[0], q[1]), q[2], q[4]);
        rng.dimension = q[3];
        let a = next_1d(&mut rng);
        let b = next_2d(&mut rng);
        let c = next_1d(&mut rng);
        // float32 must hold each number exactly, else the two sides would not draw the same one.
        let exact = |value: f64| {
            assert_eq!(f64::from(value as f32), value);
            assert!((0.0..1.0).contains(&value));
            (value as f32).to_bits()
        };
        let expected = [
            exact(a),
            exact(b.x),
            exact(b.y),
            exact(c),
            rng.dimension,
            rng.pixel_seed,
            hash_u32(q[0]),
            hash_combine(q[0], q[1]),
        ];
        assert_eq!(*answer, expected, "at {q:?}");
    }
}

#[test]
fn sobol_dimensions_follow_their_direction_numbers() {
    // Joe and Kuo 2008, "Constructing Sobol sequences with better two-dimensional projections":
    // the recurrence of the primitive polynomial x + 1, v_k = v_(k-1) xor v_(k-1) / 2.
    let mut direction = 1u32 << 31;
    for bit in 0..32 {
        assert_eq!(sobol_dimension0(1 << bit), 1 << (31 - bit));
        assert_eq!(
            sobol_dimension1(1 << bit),
            direction,
            "direction number {bit}"
        );
        direction ^= direction >> 1;
    }
    // Linear over xor.
    let (a, b) = (0x1234_5678, 0x9abc_def1);
    assert_eq!(
        sobol_dimension1(a ^ b),
        sobol_dimension1(a) ^ sobol_dimension1(b)
    );
}

#[test]
fn scrambled_dimensions_are_the_dimensions_scrambled() {
    let mut uniform = Random(3);
    for _ in 0..1000 {
        let (i, seed) = (uniform.bits() as u32, uniform.bits() as u32);
        assert_eq!(
            sobol_scrambled0(i, seed),
            owen_scramble(sobol_dimension0(i), seed)
        );
        assert_eq!(
            sobol_scrambled1(i, seed),
            owen_scramble(sobol_dimension1(i), seed)
        );
    }
}

#[test]
fn scrambling_nests() {
    // Two numbers that agree in their first k bits and not in the next still do so scrambled.
    let mut uniform = Random(2);
    for _ in 0..10_000 {
        let (a, seed) = (uniform.bits() as u32, uniform.bits() as u32);
        let k = uniform.bits() as u32 % 32;
        let b = a ^ (0x8000_0000 >> k) ^ (uniform.bits() as u32 & (0x7fff_ffff >> k));
        let difference = owen_scramble(a, seed) ^ owen_scramble(b, seed);
        assert_eq!(
            difference.leading_zeros(),
            k,
            "{a:#x} {b:#x} seed {seed:#x}"
        );
    }
}

#[test]
fn every_elementary_interval_has_one_point() {
    // A (0, m, 2)-net in base 2 (Niederreiter 1992), for each aligned block of 2^m samples, in
    // whatever pixel and dimension.
    for (pixel, seed, dimension) in [((0, 0), 0, 0), ((17, 4), 0, 3), ((1919, 1079), 5, 40)] {
        for m in 0..=10u32 {
            for block in [0, 1, 6] {
                let points: Vec<DVec2> = (0..1 << m)
                    .map(|i| {
                        let pixel = UVec2::from(pixel);
                        let mut rng = rng_init(pixel, (block << m) + i, seed);
                        rng.dimension = dimension;
                        next_2d(&mut rng)
                    })
                    .collect();
                for columns in 0..=m {
                    let size = DVec2::new(f64::from(1 << columns), f64::from(1 << (m - columns)));
                    let mut met = vec![0; 1 << m];
                    for &point in &points {
                        let cell = (point * size).floor();
                        met[(cell.y * size.x + cell.x) as usize] += 1;
                    }
                    assert!(
                        met.iter().all(|&n| n == 1),
                        "m {m}, {columns} columns: {met:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn one_dimensional_sets_are_stratified() {
    for m in 0..=10u32 {
        let mut met = vec![0; 1 << m];
        for i in 0..1 << m {
            let value = next_1d(&mut rng_init(UVec2::new(3, 8), i, 1));
            met[(value * f64::from(1 << m)) as usize] += 1;
        }
        assert!(met.iter().all(|&n| n == 1), "m {m}");
    }
}

/// Pairs of numbers that must be unrelated: correlation within five standard deviations, and an
/// even spread over the square.
fn assert_independent(what: &str, pairs: &[DVec2]) {
    let n = pairs.len() as f64;
    let mean: DVec2 = pairs.iter().sum::<DVec2>() / n;
    let (mut covariance, mut variance) = (0.0, DVec2::ZERO);
    for pair in pairs {
        let d = *pair - mean;
        covariance += d.x * d.y;
        variance += d * d;
    }
    let correlation = covariance / (variance.x * variance.y).sqrt();
    assert!(
        correlation.abs() < 5.0 / n.sqrt(),
        "{what}: correlation {correlation}"
    );
    let mut observed = vec![0.0; 64];
    for pair in pairs {
        let cell = (*pair * 8.0).floor();
        observed[(cell.y * 8.0 + cell.x) as usize] += 1.0;
    }
    assert_p(what, chi_square_p(&observed, &[n / 64.0; 64]), 300);
}

#[test]
fn dimensions_pixels_and_seeds_are_unrelated() {
    let draw = |x: u32, y: u32, sample: u32, dimension: u32, seed: u32| {
        let mut rng = rng_init(UVec2::new(x, y), sample, seed);
        rng.dimension = dimension;
        next_2d(&mut rng)
    };
    // Pairs of dimensions over the samples of one pixel.
    for d in 0..16 {
        for e in 0..d {
            let pairs: Vec<_> = (0..4096)
                .map(|i| DVec2::new(draw(5, 9, i, d, 0).x, draw(5, 9, i, e, 0).y))
                .collect();
            assert_independent(&format!("dimensions {d} and {e}"), &pairs);
        }
    }
    // Neighbouring pixels, neighbouring seeds: over a picture, first sample.
    let each_pixel = |f: &dyn Fn(u32, u32) -> DVec2| -> Vec<DVec2> {
        (0..16_384).map(|i| f(i % 128, i / 128)).collect()
    };
    let right = each_pixel(&|x, y| DVec2::new(draw(x, y, 0, 0, 0).x, draw(x + 1, y, 0, 0, 0).x));
    assert_independent("pixels side by side", &right);
    let below = each_pixel(&|x, y| DVec2::new(draw(x, y, 0, 0, 0).x, draw(x, y + 1, 0, 0, 0).x));
    assert_independent("pixels above each other", &below);
    let seeds = each_pixel(&|x, y| DVec2::new(draw(x, y, 0, 0, 0).x, draw(x, y, 0, 0, 1).x));
    assert_independent("seeds 0 and 1", &seeds);
    assert_independent(
        "one point a pixel",
        &each_pixel(&|x, y| draw(x, y, 0, 0, 0)),
    );
}

/// What the warps make of (u.x, u.y): disk 2, hemisphere 3, triangle 2; and the weight, half a pixel to the right,
/// of a sample at that place.
fn warps_cpu(u: DVec2) -> [f64; 8] {
    let disk = sample_disk_concentric(u);
    let hemisphere = sample_cosine_hemisphere(u);
    let triangle = sample_triangle(u);
    let offset = filter_offset(filter_place(u));
    [
        disk.x,
        disk.y,
        hemisphere.x,
        hemisphere.y,
        hemisphere.z,
        triangle.x,
        triangle.y,
        filter_weight(offset + DVec2::new(0.5, 0.0)),
    ]
}

fn warps_gpu(us: &[[f32; 2]]) -> Vec<[f32; 8]> {
    let root = "
import package::sample::{sample_disk_concentric, sample_cosine_hemisphere, sample_triangle};
import package::filter::{filter_offset, filter_place, filter_weight};
@group(3) @binding(0) var<storage, read> us: array<vec2<f32>>;
@group(3) @binding(1) var<storage, read_write> answers: array<array<f32, 8>>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&us) { return; }
    let u = us[id.x];
    let disk = sample_disk_concentric(u);
    let hemisphere = sample_cosine_hemisphere(u);
    let triangle = sample_triangle(u);
    answers[id.x] = array<f32, 8>(disk.x, disk.y, hemisphere.x, hemisphere.y, hemisphere.z,
        triangle.x, triangle.y, filter_weight(filter_offset(filter_place(u)) + vec2(0.5, 0.0)));
}";
    let bytes = common::run(
        root,
        &[bytemuck::cast_slice(us)],
        us.len() * 32,
        us.len() as u32,
    );
    bytemuck::pod_collect_to_vec(&bytes)
}

fn points(seed: u64) -> Vec<[f32; 2]> {
    let mut uniform = Random(seed);
    (0..COUNT)
        .map(|_| [uniform.unit(), uniform.unit()])
        .collect()
}

#[test]
fn warps_agree_with_float64() {
    const STEP: f32 = 1.0 / (1 << 24) as f32;
    let ends = [
        0.0,
        STEP,
        2.0 * STEP,
        1000.0 * STEP,
        0.25,
        0.5 - STEP,
        0.5,
        0.5 + STEP,
        1.0 - STEP,
    ];
    let mut us: Vec<[f32; 2]> = Vec::new();
    for x in ends {
        us.extend(ends.map(|y| [x, y]));
    }
    us.extend((0..4096).map(|i| [i as f32 * STEP, 1.0 - (i + 1) as f32 * STEP]));
    us.extend(points(3));
    let mut worst = [0.0_f64; 8];
    for (u, answer) in us.iter().zip(warps_gpu(&us)) {
        let expected = warps_cpu(DVec2::new(u[0].into(), u[1].into()));
        for (worst, (a, b)) in worst.iter_mut().zip(answer.iter().zip(expected)) {
            let error = (f64::from(*a) - b).abs();
            assert!(error < 1e-5, "at {u:?}: {answer:?}, float64 {expected:?}");
            *worst = worst.max(error);
        }
    }
    println!("largest errors: {worst:?}");
    assert!(worst[7] < 5e-6, "the filter's weight: {}", worst[7]);
    assert!(worst[..7].iter().all(|&error| error < 1e-6), "{worst:?}");
}

#[test]
fn warps_are_distributed_as_they_say() {
    let us = points(4);
    let both = [
        warps_gpu(&us)
            .iter()
            .map(|a| a.map(f64::from))
            .collect::<Vec<_>>(),
        us.iter()
            .map(|u| warps_cpu(DVec2::new(u[0].into(), u[1].into())))
            .collect(),
    ];
    for warped in both {
        let uniform = |what: &str, of: &dyn Fn(&[f64; 8]) -> f64| {
            assert_uniform(what, warped.iter().map(of), 100, 14);
        };
        // Each line maps a shape back to uniform numbers by another way than it was made.
        let turn = |y: f64, x: f64| (y.atan2(x) / TAU).rem_euclid(1.0);
        uniform("disk's radius", &|w| w[0] * w[0] + w[1] * w[1]);
        uniform("disk's angle", &|w| turn(w[1], w[0]));
        uniform("hemisphere's height", &|w| w[4] * w[4]);
        uniform("hemisphere's azimuth", &|w| turn(w[3], w[2]));
        uniform("triangle's height", &|w| (1.0 - w[5]).powi(2));
        uniform("triangle's place", &|w| w[6] / (1.0 - w[5]));
        for w in &warped {
            let length = DVec3::new(w[2], w[3], w[4]).length();
            assert!((length - 1.0).abs() < 1e-6 && w[4] >= 0.0);
            assert!(w[5] >= 0.0 && w[6] >= 0.0 && w[5] + w[6] <= 1.0);
        }
    }
}

/// The 4-term Blackman-Harris window on [-1, 1], not normalised.
fn window(t: f64) -> f64 {
    let cosines = (1..)
        .zip([0.48829, 0.14128, 0.01168])
        .map(|(k, a)| a * (f64::from(k) * PI * t).cos());
    0.35875 + cosines.sum::<f64>()
}

#[test]
fn the_filter_is_the_window_and_weighs_one() {
    // The midpoint rule over the pixels that a sample counts for.
    let n = 1 << 12;
    let (mut integral, mut squares) = (0.0, 0.0);
    for i in 0..n {
        let place = UVec2::splat((i << PLACE_BITS) / n);
        let offset = filter_offset(place).x;
        assert!((offset - ((f64::from(i) + 0.5) / f64::from(n) - 0.5)).abs() <= 0.5 / f64::from(n));
        let windows = filter_windows(offset);
        for (beside, window_there) in [-1.0, 0.0, 1.0].into_iter().zip(windows) {
            let weight = blackman_harris(offset + beside);
            assert!((window_there - weight).abs() < 1e-14);
            let expected = window((offset + beside) / 1.5) / (2.0 * 0.35875 * 1.5);
            assert!((weight - expected).abs() < 1e-14 && weight > 0.0);
            integral += weight / f64::from(n);
            squares += weight * weight / f64::from(n);
        }
    }
    assert!((integral - 1.0).abs() < 1e-6, "{integral}");
    assert!(
        (FILTER_OVERLAP * squares * squares - 1.0).abs() < 1e-6,
        "{FILTER_OVERLAP}, {squares}"
    );
}

#[test]
fn samples_lie_in_their_pixel_one_in_each_place() {
    let step = 1.0 / f64::from(1 << PLACE_BITS);
    assert_eq!(
        filter_place(DVec2::new(0.0, 1.0 - 0.5 * step)),
        UVec2::new(0, (1 << PLACE_BITS) - 1)
    );
    for place in [0, 1, 1000, (1 << PLACE_BITS) - 1] {
        let u = f64::from(place) * step;
        for within in [0.0, 0.99] {
            let found = filter_place(DVec2::new(u + within * step, 0.5));
            assert_eq!(found, UVec2::new(place, 1 << (PLACE_BITS - 1)));
        }
        assert_eq!(
            filter_offset(UVec2::new(place, 0)),
            DVec2::new(u, 0.0) + 0.5 * step - 0.5
        );
    }
}

#[test]
fn the_cosine_density_integrates_to_one() {
    // Over the hemisphere, 2 pi times the integral over cos theta.
    let n = 1000;
    let sum: f64 = (0..n)
        .map(|i| pdf_cosine_hemisphere((f64::from(i) + 0.5) / f64::from(n)))
        .sum();
    assert!((TAU * sum / f64::from(n) - 1.0).abs() < 1e-12);
    assert_eq!(pdf_cosine_hemisphere(-0.5), 0.0);
}

fn camera(kind: u32, uniform: &mut Random) -> Camera {
    let forward = uniform.direction();
    let right = forward.any_orthonormal_vector();
    Camera {
        origin: (10.0 * uniform.direction()).to_array(),
        kind,
        right: right.to_array(),
        half_width: uniform.range(0.1, 2.0),
        up: right.cross(forward).to_array(),
        half_height: uniform.range(0.1, 2.0),
        forward: forward.to_array(),
        near: uniform.range(0.01, 1.0),
        ..Camera::zeroed()
    }
}

#[test]
fn camera_rays_agree_with_float64() {
    let mut uniform = Random(5);
    let queries: Vec<(Camera, [f32; 4])> = (0..COUNT)
        .map(|i| {
            let camera = camera(i as u32 % 2, &mut uniform);
            (
                camera,
                [
                    uniform.range(0.0, 640.0),
                    uniform.range(0.0, 480.0),
                    0.0,
                    0.0,
                ],
            )
        })
        .collect();
    let mut bytes = Vec::new();
    for (camera, position) in &queries {
        bytes.extend_from_slice(bytemuck::bytes_of(camera));
        bytes.extend_from_slice(bytemuck::bytes_of(position));
    }
    let root = "
import package::shared::{Camera};
import package::ray::{Ray};
import package::camera::{camera_ray};
struct Query { camera: Camera, position: vec4<f32> }
@group(3) @binding(0) var<storage, read> queries: array<Query>;
@group(3) @binding(1) var<storage, read_write> answers: array<Ray>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&queries) { return; }
    answers[id.x] = camera_ray(queries[id.x].camera, vec2<u32>(640u, 480u), queries[id.x].position.xy, vec2(0.0));
}";
    let answers = common::run(root, &[&bytes], COUNT * 48, COUNT as u32);
    let answers: Vec<[f32; 12]> = bytemuck::pod_collect_to_vec(&answers);
    for ((camera, [x, y, ..]), a) in queries.iter().zip(&answers) {
        let position = DVec2::new((*x).into(), (*y).into());
        let ray = camera_ray(
            &camera_at(camera, 0.0),
            UVec2::new(640, 480),
            position,
            DVec2::ZERO,
        );
        let origin = DVec3::new(a[0].into(), a[1].into(), a[2].into());
        let direction = DVec3::new(a[4].into(), a[5].into(), a[6].into());
        assert!((origin - ray.origin).length() < 1e-5);
        assert!((direction - ray.direction).length() < 1e-6);
        assert!((f64::from(a[3]) - ray.t_min).abs() < 1e-6 * ray.t_min);
        assert!(f64::from(a[7]) > 0.99e30);
    }
}

#[test]
fn camera_rays_pass_through_the_film() {
    let mut uniform = Random(6);
    let film = UVec2::new(200, 100);
    for kind in [CAMERA_PERSPECTIVE, CAMERA_ORTHOGRAPHIC] {
        let camera = camera(kind, &mut uniform);
        let axis = |v: [f32; 3]| Vec3::from(v).as_dvec3();
        let (right, up, forward) = (axis(camera.right), axis(camera.up), axis(camera.forward));
        let (w, h) = (f64::from(camera.half_width), f64::from(camera.half_height));
        // Row 0 is on top, column 0 on the left.
        for (x, y, sx, sy) in [
            (0.0, 0.0, -1.0, 1.0),
            (200.0, 0.0, 1.0, 1.0),
            (100.0, 50.0, 0.0, 0.0),
            (150.0, 100.0, 0.5, -1.0),
        ] {
            let ray = camera_ray(
                &camera_at(&camera, 0.0),
                film,
                DVec2::new(x, y),
                DVec2::ZERO,
            );
            let start = ray.origin + ray.t_min * ray.direction - axis(camera.origin);
            let near = f64::from(camera.near);
            assert!(
                (start.dot(forward) - near).abs() < 1e-6,
                "starts at the near plane"
            );
            assert!((ray.direction.length() - 1.0).abs() < 1e-6);
            let spread = if kind == CAMERA_PERSPECTIVE {
                near
            } else {
                1.0
            };
            assert!((start.dot(right) - spread * sx * w).abs() < 1e-6);
            assert!((start.dot(up) - spread * sy * h).abs() < 1e-6);
        }
    }
}
