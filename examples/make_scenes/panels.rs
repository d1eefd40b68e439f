//! Emissive panels seen in mirrors and through slabs of glass, by a parallel camera.

use super::document::Document;
use super::mesh::{extrude, level, upright};
use serde_json::json;

/// The mirror's camera looks down by this angle, radians.
pub const MIRROR_PITCH: f64 = std::f64::consts::FRAC_PI_6;
pub const MIRROR_HALF_EXTENTS: [f64; 2] = [2.0, 1.5];
/// Three strips of mirror side by side, each 1 m wide and centred on x = -1, 0, 1.
pub const MIRROR_REFLECTANCES: [[f64; 3]; 3] = [[1.0, 1.0, 1.0], [0.5, 0.5, 0.5], [1.0, 0.6, 0.2]];
/// The panel's columns, 0.5 m wide from x = -1.5, and rows, from y = 0.3 in steps of 0.6.
pub const PANEL: [[[f64; 3]; 6]; 2] = [
    [
        [0.7, 0.1, 0.1],
        [0.7, 0.7, 0.7],
        [0.1, 0.6, 0.1],
        [0.7, 0.7, 0.1],
        [0.15, 0.2, 0.8],
        [0.7, 0.7, 0.7],
    ],
    [
        [0.3, 0.3, 0.3],
        [0.1, 0.5, 0.6],
        [0.7, 0.4, 0.1],
        [0.3, 0.3, 0.3],
        [0.6, 0.6, 0.6],
        [0.6, 0.1, 0.5],
    ],
];

/// A panel standing over a mirror floor: its image hangs below it, times the mirror's reflectance.
/// Seen along (0, -sin, -cos) of the pitch, a point at height y of the panel stands at y cos(pitch) up
/// the picture, and its image at -y cos(pitch).
pub fn mirror() -> String {
    let mut document = Document::default();
    for (i, reflectance) in MIRROR_REFLECTANCES.into_iter().enumerate() {
        let name = format!("mirror {i}");
        let model = json!({"model": "specular-reflection", "fresnel": {"constant": reflectance}});
        let material = document.bsdf(&name, model);
        let left = i as f64 - 1.5;
        document.add(&name, &level([left, left + 1.0], [0.0, 3.2], 0.0), material);
    }
    for (j, row) in PANEL.into_iter().enumerate() {
        for (i, radiance) in row.into_iter().enumerate() {
            let name = format!("panel {j} {i}");
            let material = document.emitter(&name, radiance);
            let (left, low) = (0.5 * i as f64 - 1.5, 0.3 + 0.6 * j as f64);
            let shape = upright([left, left + 0.5], [low, low + 0.6], 0.0);
            document.add(&name, &shape, material);
        }
    }
    let (sin, cos) = MIRROR_PITCH.sin_cos();
    let position = [0.0, 6.0 * sin, 6.0 * cos];
    document.camera(orthographic(MIRROR_HALF_EXTENTS), position, -MIRROR_PITCH);
    document.finish()
}

pub const SLAB_ETA: f64 = 1.5;
/// Angles of incidence, degrees, of the slabs from the left; the third is Brewster's, atan(1.5).
pub const SLAB_TILTS: [f64; 4] = [0.0, 40.0, 56.309_932_474_020_215, 75.0];
pub const SLAB_THICKNESS: f64 = 0.04;
/// Half extents of a slab as seen: it covers this much of the picture whatever its tilt.
pub const SLAB_SEEN: [f64; 2] = [0.38, 1.1];
pub const SLAB_HALF_EXTENTS: [f64; 2] = [2.0, 1.5];
pub const SLAB_PANEL: [f64; 3] = [0.8, 0.8, 0.8];

/// x of a slab's middle.
pub fn slab_x(i: usize) -> f64 {
    i as f64 - 1.5
}

/// Slabs of glass at four tilts before a uniform panel. With all the reflections inside, a slab passes
/// (1 - F) / (1 + F) of the light, F being one surface's reflectance at the angle of incidence.
pub fn slab() -> String {
    // Far enough that no reflection off a tilted slab comes back to the panel.
    const PANEL_DISTANCE: f64 = 10.0;
    let mut document = Document::default();
    let panel = document.emitter("panel", SLAB_PANEL);
    let glass = document.bsdf("glass", json!({"model": "dielectric", "eta": SLAB_ETA}));
    let shape = upright([-1.95, 1.95], [-1.3, 1.3], -PANEL_DISTANCE);
    document.add("panel", &shape, panel);
    for (i, tilt) in SLAB_TILTS.into_iter().enumerate() {
        let (sin, cos) = tilt.to_radians().sin_cos();
        let (half_length, half_thickness) = (SLAB_SEEN[1] / cos, 0.5 * SLAB_THICKNESS);
        let outline = [
            [-half_length, -half_thickness],
            [half_length, -half_thickness],
            [half_length, half_thickness],
            [-half_length, half_thickness],
        ];
        let sides = [slab_x(i) - SLAB_SEEN[0], slab_x(i) + SLAB_SEEN[0]];
        // Turned about the x axis, which completes (y, z) to a right-handed frame.
        let shape = extrude(&outline, sides, |b, c, x| {
            [x, b * cos - c * sin, b * sin + c * cos]
        });
        document.add(&format!("slab at {tilt:.0} degrees"), &shape, glass);
    }
    document.camera(orthographic(SLAB_HALF_EXTENTS), [0.0, 0.0, 4.0], 0.0);
    document.finish()
}

fn orthographic([xmag, ymag]: [f64; 2]) -> serde_json::Value {
    json!({"type": "orthographic", "orthographic":
        {"xmag": xmag, "ymag": ymag, "znear": 0.01, "zfar": 20.0}})
}
