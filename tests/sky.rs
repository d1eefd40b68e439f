//! The computed sun and sky and constant light from all around: what they send, against closed forms and
//! measurements, and where the renderers find it.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]
#![allow(non_snake_case, reason = "the field's letters: Le")]

use glam::{DVec2, DVec3, UVec2};
use snell::cpu::light::environment::{Le_environment, environment_sample};
use snell::cpu::rng::{next_2d, rng_init};
use snell::gltf::default_camera;
use snell::pack::{Background, Packed, View, pack};
use snell::scene::sky::{SCALE, SUN_RADIUS, Sky, sun_radiance};
use snell::scene::{Environment, Scene};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Luminous efficacy, lm / W.
const K_M: f64 = 683.0;

fn luminance(color: DVec3) -> f64 {
    color.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

fn lit_by(environment: Environment) -> Packed {
    let scene = Scene {
        environment: Some(environment),
        ..Scene::default()
    };
    let view = View {
        camera: default_camera(&scene, 1.0),
        film_size: [1, 1],
        seed: 0,
        max_depth: 1,
        background: Background::Environment,
        clamp: None,
    };
    let mut packed = pack(&scene, &view).unwrap();
    // In a scene of no extent it has no power.
    packed.frame.environment_weight = 1.0;
    packed
}

/// Towards where the documentation says that the sun stands.
fn to_sun(sky: &Sky) -> DVec3 {
    let (sin_e, cos_e) = sky.elevation.to_radians().sin_cos();
    let (sin_a, cos_a) = sky.azimuth.to_radians().sin_cos();
    DVec3::new(cos_e * sin_a, sin_e, cos_e * cos_a)
}

/// Midpoints of polar angle and azimuth in a window, and their steradians.
fn grid(theta: [f64; 2], phi: [f64; 2], n: usize) -> impl Iterator<Item = (DVec3, f64)> {
    let [dt, dp] = [theta, phi].map(|range| (range[1] - range[0]) / n as f64);
    (0..n * n).map(move |i| {
        let theta = theta[0] + dt * ((i / n) as f64 + 0.5);
        let phi = phi[0] + dp * ((i % n) as f64 + 0.5);
        let (sin, cos) = theta.sin_cos();
        (
            DVec3::new(sin * phi.sin(), cos, sin * phi.cos()),
            sin * dt * dp,
        )
    })
}

/// What a map sends from above the horizon, per unit of the models.
fn irradiance(packed: &Packed, n: DVec3) -> DVec3 {
    let sum: DVec3 = grid([0.0, FRAC_PI_2], [0.0, TAU], 500)
        .map(|(d, weight)| Le_environment(packed, d) * (weight * d.dot(n).max(0.0)))
        .sum();
    sum / SCALE
}

/// Only the sun, above the horizon.
fn sun_alone(sky: &Sky) -> Environment {
    let mut sun = sky.environment();
    let without = Sky { sun: false, ..*sky }.environment();
    let above = sun.radiance.len() / 2;
    for (texel, dark) in sun.radiance.iter_mut().zip(&without.radiance) {
        *texel = [0, 1, 2].map(|c| texel[c] - dark[c]);
    }
    sun.radiance[above..].fill([0.0; 3]);
    sun
}

#[test]
fn the_suns_disc_keeps_its_irradiance() {
    // The filter reaches a texel over the disc's edge on either side.
    const REACH: f64 = SUN_RADIUS + 0.01;
    for elevation in [0.0, 0.1, 5.0, 30.0, 70.0, 89.8, 90.0] {
        let sky = Sky {
            elevation,
            azimuth: 17.0,
            ..Sky::default()
        };
        let packed = lit_by(sun_alone(&sky));
        let to_sun = to_sun(&sky);
        // Around the sun as a pole.
        let (x, y) = to_sun.any_orthonormal_pair();
        let (mut found, mut centre) = (DVec3::ZERO, DVec3::ZERO);
        for (d, weight) in grid([0.0, REACH], [0.0, TAU], 1500) {
            let d = d.x * x + d.z * y + d.y * to_sun;
            let Le = Le_environment(&packed, d) * weight;
            found += Le * d.dot(to_sun);
            centre += d * luminance(Le);
        }
        let part = match elevation {
            0.0 => 0.5,
            // A segment as high as 0.1 degrees above the centre.
            0.1 => {
                let h: f64 = 0.1f64.to_radians() / SUN_RADIUS;
                1.0 - (h.acos() - h * (1.0 - h * h).sqrt()) / PI
            }
            _ => 1.0,
        };
        let radiance = sun_radiance(elevation.to_radians(), sky.turbidity);
        let expected = radiance * (part * PI * SUN_RADIUS.sin().powi(2) * SCALE);
        assert!(
            (found - expected).abs().max_element() < 1e-3 * expected.max_element(),
            "{elevation}: {found} is not {expected}"
        );
        if part == 1.0 {
            let off = centre.normalize().angle_between(to_sun).to_degrees();
            // A tenth of a texel.
            assert!(off < 0.0176, "{elevation}: {off} degrees off");
        }
    }
}

#[test]
fn a_white_floor_shows_one_under_the_default_sky() {
    let sky = Sky::default();
    let diffuse = irradiance(&lit_by(Sky { sun: false, ..sky }.environment()), DVec3::Y);
    let elevation = sky.elevation.to_radians();
    let sun = sun_radiance(elevation, sky.turbidity) * (PI * SUN_RADIUS.sin().powi(2));
    let floor = luminance(diffuse + sun * elevation.sin()) * SCALE / PI;
    assert!((floor - 1.0).abs() < 1e-3, "{floor}");
    // The ground sends back its part of that.
    let below = Le_environment(&lit_by(sky.environment()), DVec3::NEG_Y);
    let ratio = luminance(below) / (sky.albedo * floor);
    assert!((ratio - 1.0).abs() < 1e-3, "{ratio}");
}

#[test]
fn a_clear_day_is_as_bright_as_it_is_measured() {
    // Illuminating Engineering Society of North America 1984, "Recommended Practice for the Calculation
    // of Daylight Availability": klx of a clear day, from the sky on level ground and from the sun.
    for elevation in [20.0f64, 40.0, 60.0, 75.0] {
        let sky = Sky {
            elevation,
            turbidity: 2.0,
            sun: false,
            ..Sky::default()
        };
        let sin = elevation.to_radians().sin();
        let sky_klx = 0.8 + 15.5 * sin.sqrt();
        let sun_klx = 127.5 * (-0.21 / sin).exp();
        let found_sky = luminance(irradiance(&lit_by(sky.environment()), DVec3::Y)) * K_M / 1e3;
        let found_sun = luminance(sun_radiance(elevation.to_radians(), sky.turbidity))
            * (PI * SUN_RADIUS.sin().powi(2) * K_M / 1e3);
        assert!(
            (found_sky / sky_klx - 1.0).abs() < 0.15,
            "{elevation}: {found_sky} {sky_klx}"
        );
        assert!(
            (found_sun / sun_klx - 1.0).abs() < 0.15,
            "{elevation}: {found_sun} {sun_klx}"
        );
    }
}

#[test]
fn the_sky_is_the_models() {
    use hw_skymodel::rgb::{Channel, SkyParams, SkyState};
    for (elevation, turbidity, albedo) in [(0.0, 1.0, 0.0), (12.5, 3.3, 0.4), (90.0, 10.0, 1.0)] {
        let sky = Sky {
            elevation,
            azimuth: 90.0,
            turbidity,
            albedo,
            sun: false,
        };
        let state = SkyState::new(&SkyParams {
            elevation: elevation.to_radians() as f32,
            turbidity: turbidity as f32,
            albedo: [albedo as f32; 3],
        })
        .unwrap();
        let map = sky.environment();
        let sun = to_sun(&sky);
        let (width, height) = (map.width as usize, map.height as usize);
        for i in (0..width * height / 2).step_by(4999) {
            let theta = ((i / width) as f64 + 0.5) / height as f64 * PI;
            let phi = (((i % width) as f64 + 0.5) / width as f64 - 0.5) * TAU;
            let d = DVec3::new(
                theta.sin() * phi.cos(),
                theta.cos(),
                theta.sin() * phi.sin(),
            );
            let gamma = d.dot(sun).clamp(-1.0, 1.0).acos();
            let channels = [Channel::R, Channel::G, Channel::B];
            for (c, channel) in channels.into_iter().enumerate() {
                let expected = f64::from(state.radiance(theta as f32, gamma as f32, channel));
                let found = f64::from(map.radiance[i][c]) / SCALE;
                // The crate computes in float32.
                assert!(
                    (found - expected.max(0.0)).abs() < 1e-4 * (expected.abs() + 0.1),
                    "{elevation} {d} {c}: {found} is not {expected}"
                );
            }
        }
    }
}

#[test]
fn the_sky_is_blue_the_low_sun_red_and_both_sides_alike() {
    let sky = Sky {
        elevation: 40.0,
        azimuth: 30.0,
        ..Sky::default()
    };
    let packed = lit_by(sky.environment());
    let zenith = Le_environment(&packed, DVec3::Y);
    assert!(zenith.z > 1.5 * zenith.x, "{zenith}");
    let [low, high] = [3.0f64, 60.0].map(|e| sun_radiance(e.to_radians(), 3.0));
    assert!(
        low.x > 2.0 * low.z && low.x / low.z > 3.0 * high.x / high.z,
        "{low} {high}"
    );
    let hazy = sun_radiance(40f64.to_radians(), 8.0);
    let clear = sun_radiance(40f64.to_radians(), 2.0);
    assert!(luminance(hazy) < 0.5 * luminance(clear));
    // Mirrored in the plane of the sun and +y.
    let axis = DVec3::new(30f64.to_radians().cos(), 0.0, -30f64.to_radians().sin());
    for (d, _) in grid([0.0, PI], [0.0, TAU], 40) {
        let mirrored = d - 2.0 * d.dot(axis) * axis;
        let [a, b] = [d, mirrored].map(|d| Le_environment(&packed, d));
        assert!(
            (a - b).abs().max_element() < 1e-3 * a.max_element(),
            "{d}: {a} {b}"
        );
    }
}

#[test]
fn the_sun_stands_at_its_azimuth_and_turns_with_the_map() {
    for (azimuth, turned, towards) in [
        (0.0, 0.0f64, DVec3::Z),
        (90.0, 0.0, DVec3::X),
        (180.0, 0.0, DVec3::NEG_Z),
        (-90.0, 0.0, DVec3::NEG_X),
        (0.0, 90.0, DVec3::X),
        (40.0, 50.0, DVec3::X),
    ] {
        let sky = Sky {
            elevation: 30.0,
            azimuth,
            ..Sky::default()
        };
        let mut map = sky.environment();
        map.rotation += turned.to_radians() as f32;
        let packed = lit_by(map);
        let at = |d: DVec3| luminance(Le_environment(&packed, d));
        let sun = 30f64.to_radians().cos() * towards + 0.5 * DVec3::Y;
        assert!(at(sun) > 1e3, "{azimuth} + {turned}: {}", at(sun));
        let opposite = DVec3::new(-sun.x, sun.y, -sun.z);
        assert!(at(opposite) < 10.0);
    }
}

#[test]
fn the_importance_table_finds_the_sun_and_makes_no_fireflies() {
    const COUNT: u32 = 100_000;
    for elevation in [2.0, 30.0, 88.0] {
        let sky = Sky {
            elevation,
            ..Sky::default()
        };
        let packed = lit_by(sky.environment());
        let sun = to_sun(&sky);
        // Steradians times luminance over the sphere, and of the sun.
        let sun_power = luminance(sun_radiance(elevation.to_radians(), sky.turbidity))
            * (PI * SUN_RADIUS.sin().powi(2) * SCALE);
        let (mut hits, mut sum, mut squares, mut largest) = (0, 0.0, 0.0, 0.0f64);
        for sample in 0..COUNT {
            let mut rng = rng_init(UVec2::ZERO, sample, 3);
            let DVec2 { x, y } = next_2d(&mut rng);
            let drawn = environment_sample(&packed, DVec2::new(x, y));
            let value = luminance(Le_environment(&packed, drawn.truncate())) / drawn.w;
            largest = largest.max(value);
            sum += value;
            squares += value * value;
            hits += u32::from(drawn.truncate().dot(sun) > (SUN_RADIUS + 0.006).cos());
        }
        let power = sum / f64::from(COUNT);
        let share = f64::from(hits) / f64::from(COUNT);
        assert!(
            (share / (sun_power / power) - 1.0).abs() < 0.1,
            "{elevation}: {share} of the samples, {} of the power",
            sun_power / power
        );
        // Beside the disc a cell is bright in one corner only.
        let deviation = (squares / f64::from(COUNT) / (power * power) - 1.0).sqrt();
        assert!(
            deviation < 0.4 && largest < 16.0 * power,
            "{elevation}: {deviation} {}",
            largest / power
        );
    }
}

#[test]
fn a_constant_is_the_same_from_everywhere_and_sampled_well() {
    const COLOR: [f32; 3] = [0.5, 1.0, 2.0];
    const COUNT: u32 = 50_000;
    let color = DVec3::new(0.5, 1.0, 2.0);
    let packed = lit_by(Environment {
        width: 1,
        height: 1,
        radiance: vec![COLOR],
        strength: 1.0,
        rotation: 0.3,
    });
    for (d, _) in grid([0.0, PI], [0.0, TAU], 50) {
        assert_eq!(Le_environment(&packed, d), color);
    }
    let n = DVec3::new(0.3, 0.8, -0.5).normalize();
    let (mut sum, mut squares) = (0.0, 0.0);
    for sample in 0..COUNT {
        let mut rng = rng_init(UVec2::ZERO, sample, 5);
        let drawn = environment_sample(&packed, next_2d(&mut rng));
        let value = drawn.truncate().dot(n).max(0.0) / (PI * drawn.w);
        sum += value;
        squares += value * value;
    }
    let count = f64::from(COUNT);
    let mean = sum / count;
    let variance = squares / count - mean * mean;
    assert!(
        (mean - 1.0).abs() < 4.0 * (variance / count).sqrt(),
        "{mean}"
    );
    // Uniform directions have 5 / 3; the table's rows may add little to it.
    assert!(variance < 1.75, "{variance}");
}
