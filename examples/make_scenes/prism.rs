//! Snell's law: three prisms of water, crown glass and flint glass before a wall with one stripe.
//!
//! A parallel camera looks along -z. Each prism's front face is square to that, so a ray bends once,
//! at the back face: from the apex angle A inside to asin(eta sin A) outside. The stripe must be seen
//! where `seen_at` says; marks on the wall, seen past the prisms, stand at those places.

use super::document::Document;
use super::mesh::{Mesh, extrude, upright};
use serde_json::json;

/// Angle between a prism's front and back face, radians.
pub const APEX: f64 = std::f64::consts::FRAC_PI_6;
/// x of the prisms' base and of their edge, metres; the front face is at z = 0.
pub const BASE_X: f64 = -0.55;
pub const EDGE_X: f64 = 0.9;
/// The wall's distance behind the front faces.
pub const WALL: f64 = 2.0;
pub const STRIPE_X: f64 = -0.45;
pub const STRIPE_HALF_WIDTH: f64 = 0.025;
pub const STRIPE_RADIANCE: [f64; 3] = [1.0, 0.92, 0.75];
/// Of the wall's two kinds of columns, each 0.1 m wide: they show where the prisms are.
pub const WALL_RADIANCE: [[f64; 3]; 2] = [[0.015, 0.02, 0.03], [0.035, 0.05, 0.075]];
pub const CAMERA_HALF_EXTENTS: [f64; 2] = [1.2, 0.9];

/// One prism: what it is, its index, and the heights that it spans.
pub struct Prism {
    pub name: &'static str,
    pub eta: f64,
    pub heights: [f64; 2],
    mark: [f64; 3],
}

pub const PRISMS: [Prism; 3] = [
    Prism {
        name: "water",
        eta: 1.333,
        heights: [0.3, 0.7],
        mark: [0.1, 0.45, 0.8],
    },
    Prism {
        name: "crown glass",
        eta: 1.5,
        heights: [-0.2, 0.2],
        mark: [0.1, 0.6, 0.2],
    },
    Prism {
        name: "flint glass",
        eta: 1.72,
        heights: [-0.7, -0.3],
        mark: [0.75, 0.2, 0.1],
    },
];

/// By how much the prism turns a ray, radians.
pub fn deviation(eta: f64) -> f64 {
    (eta * APEX.sin()).asin() - APEX
}

/// x on the film (and on the front face) at which the wall's point x = `wall_x` is seen through the
/// prism: the ray leaves the back face at depth (EDGE_X - x) tan A and walks the rest of the way
/// aside by tan(deviation) per metre.
pub fn seen_at(eta: f64, wall_x: f64) -> f64 {
    let (bend, taper) = (deviation(eta).tan(), APEX.tan());
    (wall_x + (WALL - EDGE_X * taper) * bend) / (1.0 - taper * bend)
}

pub fn scene() -> String {
    let mut document = Document::default();
    let wall = WALL_RADIANCE.map(|radiance| document.emitter("wall", radiance));
    let stripe = document.emitter("stripe", STRIPE_RADIANCE);
    let ruler = document.emitter("ruler", [0.25, 0.25, 0.25]);

    // Marks stand this far before the wall, and the stripe too.
    const PROUD: f64 = 1e-3;
    let mut columns = [Mesh::default(), Mesh::default()];
    for column in 0..26_u8 {
        let left = -1.3 + 0.1 * f64::from(column);
        columns[usize::from(column % 2)].append(&upright(
            [left, left + 0.1],
            [-1.2, 1.2],
            -WALL - PROUD,
        ));
    }
    for (column, material) in columns.iter().zip(wall) {
        document.add("wall", column, material);
    }
    let sides = [-1.0, 1.0].map(|side| STRIPE_X + side * STRIPE_HALF_WIDTH);
    document.add("stripe", &upright(sides, [-1.0, 1.0], -WALL), stripe);

    // A ruler with a tooth every 0.1 m along the picture's upper and lower edge.
    let mut teeth = Mesh::default();
    for tooth in -11..=11 {
        let x = 0.1 * f64::from(tooth);
        let length = if tooth % 5 == 0 { 0.08 } else { 0.04 };
        let sides = [x - 0.004, x + 0.004];
        if (x - STRIPE_X).abs() > 0.06 {
            teeth.append(&upright(sides, [0.9 - length, 0.9], -WALL));
            teeth.append(&upright(sides, [-0.9, -0.9 + length], -WALL));
        }
    }
    document.add("ruler", &teeth, ruler);

    for prism in PRISMS {
        let glass = document.bsdf(prism.name, json!({"model": "dielectric", "eta": prism.eta}));
        let depth = (EDGE_X - BASE_X) * APEX.tan();
        // The outline lies in the (z, x) plane, which y completes to a right-handed frame.
        let outline = [[0.0, BASE_X], [0.0, EDGE_X], [-depth, BASE_X]];
        let shape = extrude(&outline, prism.heights, |z, x, y| [x, y, z]);
        document.add(prism.name, &shape, glass);

        let mark = document.emitter(&format!("mark for {}", prism.name), prism.mark);
        let x = seen_at(prism.eta, STRIPE_X);
        let sides = [x - 0.012, x + 0.012];
        let mut marks = upright(
            sides,
            [prism.heights[1] + 0.005, prism.heights[1] + 0.045],
            -WALL,
        );
        marks.append(&upright(
            sides,
            [prism.heights[0] - 0.045, prism.heights[0] - 0.005],
            -WALL,
        ));
        document.add(&format!("marks for {}", prism.name), &marks, mark);
    }

    let [xmag, ymag] = CAMERA_HALF_EXTENTS;
    let camera = json!({"type": "orthographic", "orthographic":
        {"xmag": xmag, "ymag": ymag, "znear": 0.01, "zfar": 10.0}});
    document.camera(camera, [0.0, 0.0, 2.0], 0.0);
    document.finish()
}
