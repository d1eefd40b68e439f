//! Media that absorb, lie in each other and overlap, against closed forms, on both renderers.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

#[path = "../common/mod.rs"]
mod common;
mod dispersion;
#[path = "../analytic/expect.rs"]
mod expect;
mod nested;
mod panes;
mod parity;
#[path = "../common/picture.rs"]
mod picture;
mod stage;

use std::f64::consts::FRAC_1_PI;

use glam::{DVec3, Vec3};
use snell::scene::{PunctualKind, PunctualLight};
use stage::{CAMERA_HEIGHT, SEEN, Stage, lambertian, lamp, rectangle, slab, turned, wide};

const PANEL: [f64; 3] = [0.9, 1.0, 0.7];
const ABSORPTION: [f64; 3] = [0.1, 0.4, 1.1];
const REFLECTANCE: [f64; 3] = [0.8, 0.5, 0.2];
/// Metres from the floor to the surface of what stands on it.
const DEPTH: f64 = 1.2;

fn single(a: [f64; 3]) -> [f32; 3] {
    a.map(|x| x as f32)
}

/// A panel under a stack of media.
fn over_panel() -> Stage {
    let mut stage = Stage::default();
    stage.add(wide(-5.0), lamp(single(PANEL)));
    stage
}

/// One of the layers that light passes head-on.
#[derive(Clone, Copy)]
struct Layer {
    ior: f64,
    absorption: [f64; 3],
    thickness: f64,
}

/// What a stack of layers in a vacuum passes head-on, with everything that is reflected in it.
fn passed(layers: &[Layer], channel: usize) -> f64 {
    // By adding one element after the other (Stokes 1862, "On the intensity of the light reflected
    // from or transmitted through a pile of plates"): through what is there already, and what is there
    // already reflects seen from its far end.
    let (mut through, mut reflected, mut ior) = (1.0, 0.0, 1.0);
    let vacuum = Layer {
        ior: 1.0,
        absorption: [0.0; 3],
        thickness: 0.0,
    };
    for layer in layers.iter().chain([&vacuum]) {
        let f = ((layer.ior - ior) / (layer.ior + ior)).powi(2);
        let again = 1.0 / (1.0 - reflected * f);
        through *= (1.0 - f) * again;
        reflected = f + (1.0 - f).powi(2) * reflected * again;
        let left = (-layer.absorption[channel] * layer.thickness).exp();
        through *= left;
        reflected *= left * left;
        ior = layer.ior;
    }
    through
}

/// The panel as it is seen through layers.
fn panel_behind(layers: &[Layer]) -> [f64; 3] {
    [0, 1, 2].map(|c| PANEL[c] * passed(layers, c))
}

#[test]
fn an_index_matched_body_only_absorbs() {
    let mut stage = over_panel();
    stage.add_medium(slab(-0.7, 0.8), 1.0, single(ABSORPTION));
    let expected = [0, 1, 2].map(|c| PANEL[c] * (-1.5 * ABSORPTION[c]).exp());
    stage.check("an index-matched slab", 16, 1e-5, |_, _| {
        Some((0, expected))
    });
}

#[test]
fn an_absorbing_slab_passes_what_its_endless_reflections_leave() {
    let mut stage = over_panel();
    stage.add_medium(slab(-0.7, 0.8), 1.5, single(ABSORPTION));
    let expected = panel_behind(&[Layer {
        ior: 1.5,
        absorption: ABSORPTION,
        thickness: 1.5,
    }]);
    stage.check("a slab of glass", 256, 2e-3, |_, _| Some((0, expected)));
}

#[test]
fn a_camera_inside_of_a_body_sees_through_it() {
    let mut stage = over_panel();
    let (top, ior) = (CAMERA_HEIGHT + 2.0, 1.5f64);
    let absorption = [0.01, 0.04, 0.1];
    stage.add_medium(slab(0.0, top as f32), ior as f32, single(absorption));
    let f = ((ior - 1.0) / (ior + 1.0)).powi(2);
    let expected = [0, 1, 2].map(|c| {
        // Down from the camera, and then up and down again any number of times.
        let first = (-absorption[c] * CAMERA_HEIGHT).exp();
        let round = f * f * (-absorption[c] * 2.0 * top).exp();
        PANEL[c] * first * (1.0 - f) * ior * ior / (1.0 - round)
    });
    stage.check("a camera in glass", 256, 2e-3, |_, _| Some((0, expected)));
}

/// Irradiance on the plane z = 0 at (x, y), light by light, each with its share for a way in the medium.
fn floor_seen(
    from: impl Fn(DVec3) -> f64,
    channel: usize,
    (x, y): (f64, f64),
    absorption: f64,
) -> f64 {
    let up = (-absorption * DEPTH).exp();
    REFLECTANCE[channel] * FRAC_1_PI * from(DVec3::new(x, y, 0.0)) * up
}

/// A floor at the bottom of an absorbing liquid of index 1.
fn pool() -> Stage {
    let mut stage = Stage::default();
    stage.add(wide(0.0), lambertian(single(REFLECTANCE)));
    stage.add_medium(slab(-1.0, DEPTH as f32), 1.0, single(ABSORPTION));
    stage
}

#[test]
fn a_point_light_in_a_medium_is_weakened_on_its_way() {
    let mut stage = pool();
    let place = DVec3::new(0.3, 0.1, 0.7);
    stage.scene.lights.push(PunctualLight {
        name: String::new(),
        kind: PunctualKind::Point,
        intensity: Vec3::ONE,
        position: place.as_vec3(),
        direction: Vec3::NEG_Z,
        range: None,
    });
    stage.check("a point light in a liquid", 256, 2e-3, |x, y| {
        let radiance = [0, 1, 2].map(|c| {
            let from = |p: DVec3| {
                let d = place - p;
                d.z / d.length().powi(3) * (-ABSORPTION[c] * d.length()).exp()
            };
            floor_seen(from, c, (SEEN * x, SEEN * y), ABSORPTION[c])
        });
        Some((0, radiance))
    });
}

/// By light that is chosen and by light that is found: the floor is as wide as the lamp is near.
#[test]
fn a_lamp_in_a_medium_is_weakened_on_its_way() {
    let mut stage = pool();
    let (lower, upper) = (DVec3::new(0.8, -0.7, 0.5), DVec3::new(2.0, 0.6, 0.5));
    stage.add(
        turned(rectangle(lower.as_vec3(), upper.as_vec3())),
        lamp([1.0; 3]),
    );
    const CELLS: u32 = 24;
    stage.check("a lamp in a liquid", 1024, 4e-3, |x, y| {
        let radiance = [0, 1, 2].map(|c| {
            let from = |p: DVec3| {
                let step = (upper - lower) / f64::from(CELLS);
                let cell = |i: u32, j: u32| {
                    let at = DVec3::new(f64::from(i) + 0.5, f64::from(j) + 0.5, 0.0);
                    let d = lower + step * at - p;
                    let r = d.length();
                    (d.z / r).powi(2) / (r * r) * (-ABSORPTION[c] * r).exp()
                };
                let cells = (0..CELLS).flat_map(|i| (0..CELLS).map(move |j| cell(i, j)));
                cells.sum::<f64>() * step.x * step.y
            };
            floor_seen(from, c, (SEEN * x, SEEN * y), ABSORPTION[c])
        });
        Some((0, radiance))
    });
}
