//! Scenes whose pictures are known in closed form, rendered by both renderers.

#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

#[path = "../common/mod.rs"]
mod common;
mod expect;
#[path = "../../examples/make_scenes/main.rs"]
#[allow(dead_code, reason = "main is the example's")]
mod make_scenes;
mod optics;

use expect::{Seen, check};
use make_scenes::{closed_forms, fresnel, panels, prism, water};
use optics::{reflectance, reflectance_approximate, reflectance_from_inside};
use snell::film::Film;
use snell::pack::{Background, View, pack};
use snell::render::Settings;
use std::f64::consts::FRAC_1_PI;
use std::path::Path;

/// Width over height of every picture here.
const ASPECT: f64 = 4.0 / 3.0;
/// Bounces: what a slab and a faceted ball of glass reflect inside must have come out.
const MAX_DEPTH: u32 = 256;

/// A committed scene as both renderers see it, each with its name.
fn films(name: &str, film_size: [u32; 2], samples: u32) -> Vec<(String, Film)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("scenes")
        .join(name);
    let loaded = snell::gltf::load(&path, &Default::default()).unwrap();
    let view = View {
        camera: loaded.scene.cameras[0].clone(),
        film_size,
        seed: 0,
        max_depth: MAX_DEPTH,
        background: Background::Color([0.0; 3]),
        clamp: None,
    };
    let packed = pack(&loaded.scene, &view).unwrap();
    let settings = Settings {
        crop: [0, 0, film_size[0], film_size[1]],
        samples: 0..samples,
    };
    let (cpu, _) = snell::cpu::render::render(&packed, &settings, &|_| {});
    let mut gpu = common::gpu();
    let (lavapipe, _) =
        snell::gpu::render::render(&mut gpu, &packed, &settings, &mut |_| {}).unwrap();
    vec![
        (format!("{name} on the CPU"), cpu),
        (format!("{name} on lavapipe"), lavapipe),
    ]
}

/// Renders and compares; every part's mean must be known to `standard_error`, or the test sees little.
fn compare(
    name: &str,
    film_size: [u32; 2],
    samples: u32,
    standard_error: f64,
    seen: impl Fn(f64, f64) -> Seen,
) {
    for (what, film) in films(name, film_size, samples) {
        let power = check(&what, &film, &seen);
        assert!(
            power.standard_error < standard_error,
            "{what}: the standard error is {:.2e}",
            power.standard_error
        );
    }
}

#[test]
fn a_lambertian_body_in_a_furnace_shows_its_reflectance() {
    compare("furnace.gltf", [80, 60], 32, 2e-3, |x, y| {
        let radius = closed_forms::FURNACE_HALF_HEIGHT * (ASPECT * x).hypot(y);
        // The body is a polyhedron inside of the unit sphere.
        match radius {
            r if r < 0.96 => Some((0, closed_forms::FURNACE_REFLECTANCE)),
            r if r > 1.0 => Some((1, [1.0; 3])),
            _ => None,
        }
    });
}

#[test]
fn bodies_that_lose_nothing_vanish_in_a_furnace() {
    compare("white_furnace.gltf", [96, 72], 48, 2e-3, |_, y| {
        let radiance = [closed_forms::WHITE_FURNACE_RADIANCE; 3];
        (y > 0.0).then_some((0, radiance))
    });
}

#[test]
fn a_rectangle_of_light_gives_lamberts_irradiance() {
    compare("area_light.gltf", [80, 60], 64, 2e-3, |x, y| {
        let form = closed_forms::lamp_form(
            closed_forms::FLOOR_SEEN[0] * x,
            -closed_forms::FLOOR_SEEN[1] * y,
        );
        let floor = closed_forms::FLOOR_REFLECTANCE;
        let radiance = [0, 1, 2].map(|c| floor[c] * FRAC_1_PI * closed_forms::LAMP[c] * form);
        Some((0, radiance))
    });
}

#[test]
fn a_mirrors_image_is_the_emitter_times_its_reflectance() {
    compare("mirror.gltf", [120, 90], 16, 1e-3, |x, y| {
        let [half_width, half_height] = panels::MIRROR_HALF_EXTENTS;
        let height = y * half_height / panels::MIRROR_PITCH.cos();
        let column = (x * half_width + 1.5) / 0.5;
        let row = (height.abs() - 0.3) / 0.6;
        if !(0.0..6.0).contains(&column) || !(0.0..2.0).contains(&row) {
            return None;
        }
        let (i, j) = (column as usize, row as usize);
        let mut radiance = panels::PANEL[j][i];
        let mut part = (6 * j + i) as u32;
        if height < 0.0 {
            let mirror = panels::MIRROR_REFLECTANCES[i / 2];
            radiance = [0, 1, 2].map(|c| radiance[c] * mirror[c]);
            part += 12;
        }
        Some((part, radiance))
    });
}

#[test]
fn a_slab_passes_what_its_endless_reflections_leave() {
    compare("slab.gltf", [160, 120], 64, 4e-3, |x, y| {
        let [half_width, half_height] = panels::SLAB_HALF_EXTENTS;
        let (x, y) = (x * half_width, y * half_height);
        for (i, tilt) in panels::SLAB_TILTS.into_iter().enumerate() {
            let aside = (x - panels::slab_x(i)).abs();
            if aside < panels::SLAB_SEEN[0] {
                let f = reflectance(panels::SLAB_ETA, 0.0, tilt.to_radians().cos());
                let through = panels::SLAB_PANEL.map(|l| l * (1.0 - f) / (1.0 + f));
                // Near its ends a slab's reflections run out through its sides.
                let inside = y.abs() < 0.7 * panels::SLAB_SEEN[1];
                return inside.then_some((i as u32, through));
            }
        }
        (x.abs() < 1.9 && y.abs() < 1.25).then_some((4, panels::SLAB_PANEL))
    });
}

#[test]
fn the_floor_mirrors_by_fresnels_equations() {
    let bands = fresnel::bands().len();
    compare("fresnel.gltf", [160, 120], 16, 1e-3, |x, y| {
        let band = 0.5 * (x + 1.0) * bands as f64;
        let (band, part) = (band.floor(), band.fract());
        let cos = fresnel::cos_incidence(fresnel::ASPECT * x, y);
        // The last degrees belong to the room's far wall.
        if !(fresnel::GAP..1.0 - fresnel::GAP).contains(&part) || cos < 0.02 {
            return None;
        }
        let metal = |eta: [f64; 3], k: [f64; 3], form: fn(f64, f64, f64) -> f64| {
            [0, 1, 2].map(|c| form(eta[c], k[c], cos))
        };
        let (gold, absorber) = (
            (fresnel::GOLD_ETA, fresnel::GOLD_K),
            (fresnel::ABSORBER_ETA, fresnel::ABSORBER_K),
        );
        let f = match band as u32 {
            0 => [reflectance(1.333, 0.0, cos); 3],
            1 => [reflectance(1.5, 0.0, cos); 3],
            2 => [reflectance(2.417, 0.0, cos); 3],
            3 => metal(gold.0, gold.1, reflectance),
            4 => metal(gold.0, gold.1, reflectance_approximate),
            5 => metal(absorber.0, absorber.1, reflectance),
            _ => metal(absorber.0, absorber.1, reflectance_approximate),
        };
        Some((band as u32, f))
    });
}

/// What is seen through water's surface from below in the direction (x, 1, z), and where it lies.
fn above_water(x: f64, z: f64) -> Option<(u32, [f64; 3])> {
    let tan_i = x.hypot(z);
    let sin_o = water::ETA * tan_i / tan_i.hypot(1.0);
    if sin_o >= 1.0 {
        return None;
    }
    let tan_o = sin_o / (1.0 - sin_o * sin_o).sqrt();
    // From the surface's point (x, z) onwards along (x, z) / tan_i, to the nearer pair of walls.
    let aside = |at: f64| (water::HALF_SIZE - at.abs()) * tan_i / at.abs();
    let to_wall = aside(x * water::CAMERA_DEPTH).min(aside(z * water::CAMERA_DEPTH));
    if to_wall < water::HALF_SIZE * tan_o {
        Some((1, water::HORIZON))
    } else {
        Some((2, water::SKY))
    }
}

#[test]
fn total_reflection_begins_at_the_critical_angle() {
    let scale = (0.5 * water::YFOV).tan();
    compare(
        "total_internal_reflection.gltf",
        [160, 120],
        32,
        5e-3,
        |x, y| {
            let (x, z) = (x * water::ASPECT * scale, y * scale);
            let cos = 1.0 / (1.0 + x * x + z * z).sqrt();
            let f = reflectance_from_inside(water::ETA, cos);
            // The mirrored floor, as if it were as far above the surface.
            let reach = water::CAMERA_DEPTH + water::FLOOR_DEPTH;
            let square = |at: f64| {
                let side = 2.0 * water::HALF_SIZE / f64::from(water::SQUARES);
                ((reach * at + water::HALF_SIZE) / side).floor() as i64
            };
            let floor = ((square(x) + square(z)) % 2) as usize;
            let (zone, above) = above_water(x, z).unwrap_or((0, [0.0; 3]));
            let into_water = (1.0 - f) * water::ETA * water::ETA;
            let radiance = [0, 1, 2].map(|c| f * water::FLOOR[floor][c] + into_water * above[c]);
            Some((2 * zone + floor as u32, radiance))
        },
    );
    // The rim, 48.6 degrees from the vertical, is a circle of 65.5 % of half the picture's height.
    assert!((water::rim() - 0.655).abs() < 1e-3);
}

/// Mean column (in the scene's x) of the light above the wall's, over rows from y0 to y1.
fn stripe_seen(film: &Film, [y0, y1]: [f64; 2]) -> f64 {
    let [half_width, half_height] = prism::CAMERA_HALF_EXTENTS;
    let (mut sum, mut weights) = (0.0, 0.0);
    for row in 0..film.height {
        let y = half_height * (1.0 - 2.0 * (f64::from(row) + 0.5) / f64::from(film.height));
        if !(y0..y1).contains(&y) {
            continue;
        }
        for column in 0..film.width {
            let x = half_width * (2.0 * (f64::from(column) + 0.5) / f64::from(film.width) - 1.0);
            // Brighter than a fifth of the stripe: neither wall nor anything seen by reflection.
            let light = film.pixel(column, row).mean()[0] - 0.2 * prism::STRIPE_RADIANCE[0];
            if light > 0.0 {
                sum += light * x;
                weights += light;
            }
        }
    }
    sum / weights
}

#[test]
fn prisms_displace_a_stripe_by_snells_law() {
    const SIZE: [u32; 2] = [240, 180];
    let pixel = 2.0 * prism::CAMERA_HALF_EXTENTS[0] / f64::from(SIZE[0]);
    for (what, film) in films("prism.gltf", SIZE, 24) {
        let beside = stripe_seen(&film, [0.225, 0.275]);
        assert!(
            (beside - prism::STRIPE_X).abs() < 0.1 * pixel,
            "{what}: beside at {beside}"
        );
        for glass in prism::PRISMS {
            let [low, high] = glass.heights;
            let seen = stripe_seen(&film, [low + 0.05, high - 0.05]);
            let expected = prism::seen_at(glass.eta, prism::STRIPE_X);
            println!(
                "{what}: the stripe behind {} stands at {seen:.4} m, by Snell's law {expected:.4} m, {:.3} pixels off",
                glass.name,
                (seen - expected) / pixel
            );
            assert!(
                (seen - expected).abs() < 0.1 * pixel,
                "{what}: {} shows the stripe at {seen}, not {expected}",
                glass.name
            );
        }
        check(&what, &film, &prism_seen);
    }
}

/// The stripe and the bare wall, behind the prisms and beside them.
fn prism_seen(x: f64, y: f64) -> Seen {
    let [half_width, half_height] = prism::CAMERA_HALF_EXTENTS;
    let (x, y) = (x * half_width, y * half_height);
    for (i, glass) in prism::PRISMS.into_iter().enumerate() {
        let [low, high] = glass.heights;
        if y > low && y < high && x > prism::BASE_X && x < prism::EDGE_X {
            let sides = [-1.0, 1.0].map(|side| {
                prism::seen_at(glass.eta, prism::STRIPE_X + side * prism::STRIPE_HALF_WIDTH)
            });
            let on_stripe = x > sides[0] && x < sides[1];
            let passed = (1.0 - reflectance(glass.eta, 0.0, 1.0))
                * (1.0 - reflectance_from_inside(glass.eta, prism::APEX.cos()));
            return on_stripe.then_some((i as u32, prism::STRIPE_RADIANCE.map(|l| l * passed)));
        }
    }
    None
}
