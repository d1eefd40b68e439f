//! Scenes whose radiance has a closed form: furnaces, and a rectangle of light over a floor.

use super::document::Document;
use super::mesh::{block, faceted_sphere, level};
use serde_json::{Value, json};

/// Of the furnace's sphere, which must show just this in a room of radiance 1.
pub const FURNACE_REFLECTANCE: [f64; 3] = [0.8, 0.5, 0.2];

/// Half the height of what its camera sees, in radii of the body.
pub const FURNACE_HALF_HEIGHT: f64 = 1.4;

/// A convex Lambertian body in a room of radiance 1: its radiance is its reflectance, everywhere.
pub fn furnace() -> String {
    let mut document = Document::default();
    let room = document.emitter("room", [1.0; 3]);
    let model = json!({"model": "lambertian", "reflectance": FURNACE_REFLECTANCE});
    let body = document.bsdf("body", model);
    document.add("room", &block([-4.0; 3], [4.0; 3]).inside_out(), room);
    // Flat faces: interpolated normals would lean over some faces' horizons and lose a little light.
    document.add("body", &faceted_sphere(32, 16), body);
    look_along_z(&mut document, FURNACE_HALF_HEIGHT);
    document.finish()
}

pub const WHITE_FURNACE_RADIANCE: f64 = 0.5;

/// What loses nothing cannot be seen in a room of uniform radiance; what can be seen loses light.
/// In the upper row nothing may show; the lower row are single-scattering facets of growing roughness,
/// in a room of its own, so that their loss does not dim the upper one.
pub fn white_furnace() -> String {
    let white = [1.0; 3];
    let facets = |alpha: f64| {
        json!({"model": "torrance-sparrow", "fresnel": {"constant": white},
               "distribution": {"name": "ggx", "alpha": alpha}})
    };
    let rows: [[(&str, Value); 4]; 2] = [
        [
            (
                "Lambertian",
                json!({"model": "lambertian", "reflectance": white}),
            ),
            (
                "energy-preserving Oren-Nayar",
                json!({"model": "oren-nayar", "reflectance": white,
                       "form": "energy-preserving", "roughness": 1.0}),
            ),
            (
                "mirror",
                json!({"model": "specular-reflection", "fresnel": {"constant": white}}),
            ),
            ("glass", json!({"model": "dielectric", "eta": 1.5})),
        ],
        [
            ("facets, alpha 0.1", facets(0.1)),
            ("facets, alpha 0.3", facets(0.3)),
            ("facets, alpha 0.6", facets(0.6)),
            ("facets, alpha 1", facets(1.0)),
        ],
    ];
    let mut document = Document::default();
    let room = document.emitter("room", [WHITE_FURNACE_RADIANCE; 3]);
    let mut rooms = block([-8.0, 0.0, -8.0], [8.0, 16.0, 8.0]).inside_out();
    rooms.append(&block([-8.0, -16.0, -8.0], [8.0, 0.0, 8.0]).inside_out());
    document.add("rooms", &rooms, room);
    let shape = document.shape(&faceted_sphere(48, 24));
    for (row, models) in rows.into_iter().enumerate() {
        for (column, (name, model)) in models.into_iter().enumerate() {
            let material = document.bsdf(name, model);
            let mesh = document.mesh(name, &[(shape, material)]);
            let at = [1.15 * (column as f64 - 1.5), 0.8 - 1.6 * row as f64, 0.0];
            document.place(name, mesh, 0.5, at);
        }
    }
    look_along_z(&mut document, 1.8);
    document.finish()
}

/// The lamp: a rectangle of radiance `LAMP` facing down from y = `LAMP_HEIGHT`, centred on the y axis.
pub const LAMP: [f64; 3] = [4.0, 3.6, 3.0];
pub const LAMP_HEIGHT: f64 = 1.0;
pub const LAMP_HALF_EXTENTS: [f64; 2] = [0.75, 0.5];
pub const FLOOR_REFLECTANCE: [f64; 3] = [0.5, 0.6, 0.7];
/// Half extents of what the camera sees of the floor, along x and z.
pub const FLOOR_SEEN: [f64; 2] = [2.0, 1.5];

/// A rectangle of light over a Lambertian floor, seen from above through the lamp's unlit back.
pub fn area_light() -> String {
    let mut document = Document::default();
    let lamp = document.emitter("lamp", LAMP);
    let model = json!({"model": "lambertian", "reflectance": FLOOR_REFLECTANCE});
    let floor = document.bsdf("floor", model);
    let [x, z] = LAMP_HALF_EXTENTS;
    let shape = level([-x, x], [-z, z], LAMP_HEIGHT).inside_out();
    document.add("lamp", &shape, lamp);
    document.add("floor", &level([-5.0, 5.0], [-5.0, 5.0], 0.0), floor);
    let camera = orthographic(FLOOR_SEEN[0], FLOOR_SEEN[1]);
    let downwards = -std::f64::consts::FRAC_PI_2;
    document.camera(camera, [0.0, 3.0, 0.0], downwards);
    document.finish()
}

/// Irradiance at the floor's point (x, z) over the lamp's radiance, by Lambert's formula: half the
/// sum over the edges of (angle that the edge spans) times (vertical part of its plane's normal).
pub fn lamp_form(x: f64, z: f64) -> f64 {
    let [hx, hz] = LAMP_HALF_EXTENTS;
    let corners =
        [[-hx, -hz], [hx, -hz], [hx, hz], [-hx, hz]].map(|[a, b]| [a - x, LAMP_HEIGHT, b - z]);
    let mut sum = 0.0;
    for i in 0..4 {
        let (p, q) = (corners[i], corners[(i + 1) % 4]);
        let length = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
        let dot: f64 = (0..3).map(|k| p[k] * q[k]).sum();
        let cross = [
            p[1] * q[2] - p[2] * q[1],
            p[2] * q[0] - p[0] * q[2],
            p[0] * q[1] - p[1] * q[0],
        ];
        let angle = (dot / (length(p) * length(q))).clamp(-1.0, 1.0).acos();
        sum += angle * cross[1] / length(cross);
    }
    0.5 * sum.abs()
}

fn orthographic(xmag: f64, ymag: f64) -> Value {
    json!({"type": "orthographic", "orthographic":
        {"xmag": xmag, "ymag": ymag, "znear": 0.01, "zfar": 20.0}})
}

fn look_along_z(document: &mut Document, half_height: f64) {
    let camera = orthographic(half_height * 4.0 / 3.0, half_height);
    document.camera(camera, [0.0, 0.0, 3.0], 0.0);
}
