//! Warps: from the unit square (or interval) to the shapes that a renderer samples, each with a
//! density that is constant or stated beside it. u are multiples of 2^-24 in [0, 1).

use crate::cpu::math::{INV_PI, PI};
use glam::{DVec2, DVec3};

/// Radius of the Blackman-Harris pixel filter, pixels: its usual support of three pixels.
pub const FILTER_RADIUS_PX: f64 = 1.5;

// The window w(t) = sum of BLACKMAN_HARRIS_k cos(k pi t) for t in [-1, 1]: Harris 1978, "On the use
// of windows for harmonic analysis with the discrete Fourier transform", table I, minimum 4-term.
pub const BLACKMAN_HARRIS_0: f64 = 0.35875;
pub const BLACKMAN_HARRIS_1: f64 = 0.48829;
pub const BLACKMAN_HARRIS_2: f64 = 0.14128;
pub const BLACKMAN_HARRIS_3: f64 = 0.01168;

/// Newton steps that take `sample_blackman_harris` from its first guess, which is within 7e-4, to within 2e-14;
/// float32 has no use for the last of them.
pub const BLACKMAN_HARRIS_STEPS: u32 = 3;

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

/// The window at distance s from its end, 0 <= s <= 1, normalised: w(1 - s) / integral of w. As a
/// polynomial in 1 - cos(pi s) it has positive terms only.
pub fn blackman_harris_density(s: f64) -> f64 {
    let c = 1.0 - (PI * s).cos();
    let b0 = BLACKMAN_HARRIS_0 - BLACKMAN_HARRIS_1 + BLACKMAN_HARRIS_2 - BLACKMAN_HARRIS_3;
    let b1 = BLACKMAN_HARRIS_1 - 4.0 * BLACKMAN_HARRIS_2 + 9.0 * BLACKMAN_HARRIS_3;
    let b2 = 2.0 * BLACKMAN_HARRIS_2 - 12.0 * BLACKMAN_HARRIS_3;
    let b3 = 4.0 * BLACKMAN_HARRIS_3;
    (b0 + c * (b1 + c * (b2 + c * b3))) / (2.0 * BLACKMAN_HARRIS_0)
}

/// Integral of `blackman_harris_density` from 0 to s.
pub fn blackman_harris_tail(s: f64) -> f64 {
    // Cancels near the window's end, where float64 still has eleven digits; the shader has none and
    // sums a series there.
    // The sines of twice and three times the angle by those of the angle itself.
    let (sin, cos) = (PI * s).sin_cos();
    let sines = sin
        * (BLACKMAN_HARRIS_1 - BLACKMAN_HARRIS_2 * cos
            + BLACKMAN_HARRIS_3 * (1.0 - 4.0 / 3.0 * sin * sin));
    (BLACKMAN_HARRIS_0 * s - sines * INV_PI) / (2.0 * BLACKMAN_HARRIS_0)
}

/// Offset from the pixel's centre along one axis, pixels, distributed as the Blackman-Harris
/// window. The inverse of the cumulative distribution, from whichever end is nearer.
pub fn sample_blackman_harris(u: f64) -> f64 {
    let tail = u.min(1.0 - u);
    // Newton's steps come down to the root of the convex tail from wherever they start right of it; so
    // near, because each costs sines: a polynomial in the fourth root, fitted at Chebyshev's nodes over
    // tails of 1e-6 and more, and at most the tangent at 0, which the smallest tails are on. The middle,
    // where the polynomial is above 1, stays exact.
    let x = tail.sqrt().sqrt();
    let guess = -0.03443151
        + x * (1.4138 + x * (0.4135 + x * (-5.5114 + x * (13.055 + x * (-13.23 + x * 5.2759)))));
    let mut s = guess.clamp(0.01, 1.0).min(tail / 8.36236934e-5);
    for _ in 0..BLACKMAN_HARRIS_STEPS {
        s -= (blackman_harris_tail(s) - tail) / blackman_harris_density(s);
    }
    FILTER_RADIUS_PX * if u < 0.5 { s - 1.0 } else { 1.0 - s }
}
