//! Fresnel's equations as bands of a mirror floor in a room of radiance 1: what a pixel shows is F.
//!
//! The camera stands 1 m above the floor and looks down by 45 degrees with a field of view of 90, so
//! the angle of incidence runs from 0 at the lower edge to 90 degrees at the upper edge. The bands fan
//! out from under the camera, which makes them upright stripes of equal width in the picture.

use super::document::Document;
use super::mesh::{block, level, polygon};
use serde_json::{Value, json};

pub const CAMERA_HEIGHT: f64 = 1.0;
/// The floor ends here, at 89.3 degrees; behind it is the room's wall, of radiance 1.
pub const FLOOR_END: f64 = 80.0;
/// Dark part of a band's width, on each of its sides.
pub const GAP: f64 = 0.04;

/// What reflects in each band, from the left: dielectrics, gold by both formulas, and a weak absorber
/// on which the two formulas for conductors part (k = 0 in red, where the exact one is glass).
pub fn bands() -> Vec<(&'static str, Value)> {
    let gold = |form: &str| json!({"conductor": {"eta": GOLD_ETA, "k": GOLD_K, "form": form}});
    let absorber =
        |form: &str| json!({"conductor": {"eta": ABSORBER_ETA, "k": ABSORBER_K, "form": form}});
    vec![
        ("water", json!({"dielectric": {"eta": 1.333}})),
        ("glass", json!({"dielectric": {"eta": 1.5}})),
        ("diamond", json!({"dielectric": {"eta": 2.417}})),
        ("gold, exact", gold("exact")),
        ("gold, approximate", gold("approximate")),
        ("weak absorber, exact", absorber("exact")),
        ("weak absorber, approximate", absorber("approximate")),
    ]
}

/// Gold (Johnson and Christy 1972, "Optical constants of the noble metals").
pub const GOLD_ETA: [f64; 3] = [0.188, 0.544, 1.332];
pub const GOLD_K: [f64; 3] = [3.403, 2.231, 1.869];
pub const ABSORBER_ETA: [f64; 3] = [1.5, 1.5, 1.5];
pub const ABSORBER_K: [f64; 3] = [0.0, 0.5, 1.5];

/// The picture's width over its height.
pub const ASPECT: f64 = 4.0 / 3.0;

/// Cosine of the angle of incidence at the picture's point (x, y), in halves of its height, y up.
pub fn cos_incidence(x: f64, y: f64) -> f64 {
    // The ray's direction in the camera's frame is (x, y, -1); the floor's normal there (0, 1, 1)/sqrt 2.
    (1.0 - y) / (2.0 * (x * x + y * y + 1.0)).sqrt()
}

pub fn scene() -> String {
    let mut document = Document::default();
    let room = document.emitter("room", [1.0; 3]);
    let black = document.bsdf(
        "black",
        json!({"model": "lambertian", "reflectance": [0.0, 0.0, 0.0]}),
    );
    document.add("room", &block([-100.0; 3], [100.0; 3]).inside_out(), room);
    document.add(
        "gaps",
        &level([-95.0, 95.0], [-FLOOR_END, 2.0], -0.01),
        black,
    );

    let bands = bands();
    let width = 2.0 * ASPECT / bands.len() as f64;
    for (i, (name, fresnel)) in bands.into_iter().enumerate() {
        let material = document.bsdf(
            name,
            json!({"model": "specular-reflection", "fresnel": fresnel}),
        );
        let left = -ASPECT + width * (i as f64 + GAP);
        let right = -ASPECT + width * (i as f64 + 1.0 - GAP);
        // The line that is seen in the picture's column k: x = k (camera height - z) / sqrt 2.
        let at = |k: f64, z: f64| {
            [
                k * (CAMERA_HEIGHT - z) * std::f64::consts::FRAC_1_SQRT_2,
                0.0,
                z,
            ]
        };
        let (near, far) = (0.2, -FLOOR_END);
        let corners = [
            at(left, near),
            at(right, near),
            at(right, far),
            at(left, far),
        ];
        document.add(name, &polygon(&corners), material);
    }

    let right_angle = std::f64::consts::FRAC_PI_2;
    let camera = json!({"type": "perspective", "perspective":
        {"yfov": right_angle, "aspectRatio": ASPECT, "znear": 0.01}});
    document.camera(camera, [0.0, CAMERA_HEIGHT, 0.0], -0.5 * right_angle);
    document.finish()
}
