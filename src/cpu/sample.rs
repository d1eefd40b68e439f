//! Warps: from the unit square (or interval) to the shapes that a renderer samples, each with a
//! density that is constant or stated beside it. u are multiples of 2^-24 in [0, 1).

use crate::cpu::math::{INV_PI, PI};
use glam::{DVec2, DVec3};

/// Radius of `sample_disk_concentric`'s point, exact in float32.
pub fn concentric_radius(u: DVec2) -> f64 {
    (2.0 * u - 1.0).abs().max_element()
}

/// Uniform on the unit disk; Shirley and Chiu 1997, "A low distortion map between disk and square".
pub fn sample_disk_concentric(u: DVec2) -> DVec2 {
    let square = 2.0 * u - 1.0;
    let radius = concentric_radius(u);
    if radius == 0.0 {
        return DVec2::ZERO;
    }
    // Angle from the nearer axis; the negative half of that axis comes from the radius' sign.
    if square.x.abs() > square.y.abs() {
        let (sin, cos) = (0.25 * PI * (square.y / square.x)).sin_cos();
        return square.x * DVec2::new(cos, sin);
    }
    let (sin, cos) = (0.25 * PI * (square.x / square.y)).sin_cos();
    square.y * DVec2::new(sin, cos)
}

/// Cosine-weighted about +z; Malley's method (Pharr, Jakob and Humphreys 2023, "Physically based
/// rendering", section A.5.3). The height comes from the disk's radius without cancellation.
pub fn sample_cosine_hemisphere(u: DVec2) -> DVec3 {
    let radius = concentric_radius(u);
    sample_disk_concentric(u).extend(((1.0 - radius) * (1.0 + radius)).sqrt())
}

/// Per solid angle.
pub fn pdf_cosine_hemisphere(cos_theta: f64) -> f64 {
    cos_theta.max(0.0) * INV_PI
}

/// Uniform on a triangle, as weights of corners 1 and 2; Heitz 2019, "A low-distortion map between
/// triangle and square".
pub fn sample_triangle(u: DVec2) -> DVec2 {
    if u.y > u.x {
        let x = 0.5 * u.x;
        return DVec2::new(x, u.y - x);
    }
    let y = 0.5 * u.y;
    DVec2::new(u.x - y, y)
}
