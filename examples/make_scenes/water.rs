//! Total internal reflection: the camera is under water and looks straight up.
//!
//! Everything above the surface is squeezed into a round window whose rim lies at the critical angle,
//! asin(1 / eta) from the vertical; outside it the surface mirrors the pool's floor with F = 1.

use super::document::Document;
use super::mesh::{chessboard, level, upright};
use serde_json::json;

pub const ETA: f64 = 1.333;
/// Metres from the camera up to the surface (which is at y = 0), and down from there to the floor.
pub const CAMERA_DEPTH: f64 = 1.0;
pub const FLOOR_DEPTH: f64 = 3.0;
/// The pool and the room above it reach this far to each side; the sky is this high.
pub const HALF_SIZE: f64 = 12.0;
/// Floor squares along each side, 1.5 m wide.
pub const SQUARES: u16 = 16;
/// The camera's vertical field of view, radians.
pub const YFOV: f64 = 2.0 * std::f64::consts::FRAC_PI_3;
pub const ASPECT: f64 = 4.0 / 3.0;
pub const SKY: [f64; 3] = [0.16, 0.3, 0.55];
pub const HORIZON: [f64; 3] = [0.55, 0.36, 0.18];
/// Of the floor's two kinds of squares; the first is the one with the least x and z.
pub const FLOOR: [[f64; 3]; 2] = [[0.01, 0.035, 0.04], [0.05, 0.14, 0.14]];

/// Radius of the window's rim as a fraction of half the picture's height.
pub fn rim() -> f64 {
    (1.0 / ETA).asin().tan() / (0.5 * YFOV).tan()
}

pub fn scene() -> String {
    let mut document = Document::default();
    let water = document.bsdf("water", json!({"model": "dielectric", "eta": ETA}));
    let sky = document.emitter("sky", SKY);
    let horizon = document.emitter("horizon", HORIZON);
    let floor = FLOOR.map(|radiance| document.emitter("floor", radiance));

    let sides = [-HALF_SIZE, HALF_SIZE];
    // The surface reaches beyond the walls, so that no ray slips past its edge.
    let beyond = [-1.1 * HALF_SIZE, 1.1 * HALF_SIZE];
    document.add("water", &level(beyond, beyond, 0.0), water);
    document.add("sky", &level(sides, sides, HALF_SIZE).inside_out(), sky);

    // Four walls around, facing in, by quarter turns of the one at the back.
    let back = upright(sides, [0.0, HALF_SIZE], -HALF_SIZE);
    let mut walls = back.clone();
    let mut wall = back;
    for _ in 0..3 {
        for p in &mut wall.positions {
            *p = [-p[2], p[1], p[0]];
        }
        walls.append(&wall);
    }
    document.add("horizon", &walls, horizon);

    let (mesh, others) = chessboard(sides, sides, -FLOOR_DEPTH, [SQUARES; 2]);
    let first = document.shape(&mesh);
    let second = document.other_triangles(first, &others);
    let mesh = document.mesh("floor", &[(first, floor[0]), (second, floor[1])]);
    document.place("floor", mesh, 1.0, [0.0; 3]);

    let camera = json!({"type": "perspective", "perspective":
        {"yfov": YFOV, "aspectRatio": ASPECT, "znear": 0.01}});
    let upwards = std::f64::consts::FRAC_PI_2;
    document.camera(camera, [0.0, -CAMERA_DEPTH, 0.0], upwards);
    document.finish()
}
