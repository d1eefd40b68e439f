// Warps: from the unit square (or interval) to the shapes that a renderer samples, each with a
// density that is constant or stated beside it. u are multiples of 2^-24 in [0, 1).

import package::math::{PI, INV_PI, sincos_accurate};

// Radius of the Blackman-Harris pixel filter, pixels: its usual support of three pixels.
const FILTER_RADIUS_PX: f32 = 1.5;

// The window w(t) = sum of BLACKMAN_HARRIS_k cos(k pi t) for t in [-1, 1]: Harris 1978, "On the use
// of windows for harmonic analysis with the discrete Fourier transform", table I, minimum 4-term.
const BLACKMAN_HARRIS_0: f32 = 0.35875;
const BLACKMAN_HARRIS_1: f32 = 0.48829;
const BLACKMAN_HARRIS_2: f32 = 0.14128;
const BLACKMAN_HARRIS_3: f32 = 0.01168;

// Newton steps that take sample_blackman_harris from its first guess, which is within 7e-4, to within 2e-9
// (measured in float64 over 4096 tails of the fewest steps of 2^-24 and 200 000 further values).
const BLACKMAN_HARRIS_STEPS: u32 = 2u;

// Radius of sample_disk_concentric's point, exact in float32.
fn concentric_radius(u: vec2<f32>) -> f32 {
    let square = abs(2.0 * u - 1.0);
    return max(square.x, square.y);
}

// Uniform on the unit disk; Shirley and Chiu 1997, "A low distortion map between disk and square".
fn sample_disk_concentric(u: vec2<f32>) -> vec2<f32> {
    let square = 2.0 * u - 1.0;
    let radius = concentric_radius(u);
    if radius == 0.0 {
        return vec2<f32>(0.0);
    }
    // Angle from the nearer axis; the negative half of that axis comes from the radius' sign.
    if abs(square.x) > abs(square.y) {
        let sincos = sincos_accurate(0.25 * PI * (square.y / square.x));
        return square.x * vec2<f32>(sincos.y, sincos.x);
    }
    let sincos = sincos_accurate(0.25 * PI * (square.x / square.y));
    return square.y * sincos;
}

// Cosine-weighted about +z; Malley's method (Pharr, Jakob and Humphreys 2023, "Physically based
// rendering", section A.5.3). The height comes from the disk's radius without cancellation.
fn sample_cosine_hemisphere(u: vec2<f32>) -> vec3<f32> {
    let radius = concentric_radius(u);
    return vec3<f32>(sample_disk_concentric(u), sqrt((1.0 - radius) * (1.0 + radius)));
}

// Per solid angle.
fn pdf_cosine_hemisphere(cos_theta: f32) -> f32 {
    return max(cos_theta, 0.0) * INV_PI;
}

// Uniform on a triangle, as weights of corners 1 and 2; Heitz 2019, "A low-distortion map between
// triangle and square".
fn sample_triangle(u: vec2<f32>) -> vec2<f32> {
    if u.y > u.x {
        let x = 0.5 * u.x;
        return vec2<f32>(x, u.y - x);
    }
    let y = 0.5 * u.y;
    return vec2<f32>(u.x - y, y);
}

// The window at distance s from its end, 0 <= s <= 1, normalised: w(1 - s) / integral of w. As a
// polynomial in 1 - cos(pi s) it has positive terms only.
fn blackman_harris_density(s: f32) -> f32 {
    let c = 1.0 - sincos_accurate(PI * s).y;
    let b0 = BLACKMAN_HARRIS_0 - BLACKMAN_HARRIS_1 + BLACKMAN_HARRIS_2 - BLACKMAN_HARRIS_3;
    let b1 = BLACKMAN_HARRIS_1 - 4.0 * BLACKMAN_HARRIS_2 + 9.0 * BLACKMAN_HARRIS_3;
    let b2 = 2.0 * BLACKMAN_HARRIS_2 - 12.0 * BLACKMAN_HARRIS_3;
    let b3 = 4.0 * BLACKMAN_HARRIS_3;
    return (b0 + c * (b1 + c * (b2 + c * b3))) / (2.0 * BLACKMAN_HARRIS_0);
}

// Integral of blackman_harris_density from 0 to s.
fn blackman_harris_tail(s: f32) -> f32 {
    // The closed form below cancels near the window's end, where float32 has not one digit left
    // of it; there its Taylor series is summed, whose first term left out is 2e-9 of the sum.
    if s < 0.3 {
        let x = s * s;
        return s * (8.36236934e-5 + x * (6.48574004e-2 + x * (0.934618167 + x * (-1.03444648e-2
            + x * (-1.49245319 + x * (1.78370789 + x * (-1.16447535
            + x * (0.520646491 + x * -0.174107986))))))));
    }
    let sincos1 = sincos_accurate(PI * s);
    let sin2 = 2.0 * sincos1.x * sincos1.y;
    let sin3 = sincos1.x * (3.0 - 4.0 * sincos1.x * sincos1.x);
    let sines = BLACKMAN_HARRIS_1 * sincos1.x - BLACKMAN_HARRIS_2 * sin2 / 2.0
        + BLACKMAN_HARRIS_3 * sin3 / 3.0;
    return (BLACKMAN_HARRIS_0 * s - sines * INV_PI) / (2.0 * BLACKMAN_HARRIS_0);
}

// Offset from the pixel's centre along one axis, pixels, distributed as the Blackman-Harris
// window. The inverse of the cumulative distribution, from whichever end is nearer.
fn sample_blackman_harris(u: f32) -> f32 {
    let tail = min(u, 1.0 - u);
    // Newton's steps come down to the root of the convex tail from wherever they start right of it; so near,
    // because each costs a sine: a polynomial in the fourth root, fitted at Chebyshev's nodes over tails
    // of 1e-6 and more, and at most the tangent at 0, which the smallest tails are on. The middle, where
    // the polynomial is above 1, stays exact.
    let x = sqrt(sqrt(tail));
    let guess = -0.03443151 + x * (1.4138 + x * (0.4135 + x * (-5.5114 + x * (13.055 + x * (-13.23 + x * 5.2759)))));
    var s = min(clamp(guess, 0.01, 1.0), tail / 8.36236934e-5);
    for (var step = 0u; step < BLACKMAN_HARRIS_STEPS; step++) {
        s -= (blackman_harris_tail(s) - tail) / blackman_harris_density(s);
    }
    return FILTER_RADIUS_PX * select(1.0 - s, s - 1.0, u < 0.5);
}
