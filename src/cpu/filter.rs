//! The pixel filter: a Blackman-Harris window three pixels wide. Samples lie evenly in their pixel and count,
//! by the filter's weight, for the nine pixels around. The mean is the same as of samples drawn from the filter for one
//! pixel each, and its variance that over `FILTER_OVERLAP`.

use crate::cpu::math::PI;
use glam::{DVec2, UVec2};

/// Half the window's width, pixels: its usual support of three pixels.
pub const FILTER_RADIUS_PX: f64 = 1.5;

/// How many pixels beside a pixel have samples that count for it.
pub const FILTER_REACH: u32 = 1;

// The window w(t) = sum of BLACKMAN_HARRIS_k cos(k pi t) for t in [-1, 1]: Harris 1978, "On the use
// of windows for harmonic analysis with the discrete Fourier transform", table I, minimum 4-term.
pub const BLACKMAN_HARRIS_0: f64 = 0.35875;
pub const BLACKMAN_HARRIS_1: f64 = 0.48829;
pub const BLACKMAN_HARRIS_2: f64 = 0.14128;
pub const BLACKMAN_HARRIS_3: f64 = 0.01168;

/// Over an even picture, how many pixels' worth of samples a pixel's mean is made of: the inverse of the integral over
/// the plane of the squared filter, 2.24. As neighbours share them, the average over a picture is so many times as
/// uncertain, squared, as its pixels' errors would make it were they independent.
pub const FILTER_OVERLAP: f64 = {
    let [a0, a1, a2, a3] = [
        BLACKMAN_HARRIS_0,
        BLACKMAN_HARRIS_1,
        BLACKMAN_HARRIS_2,
        BLACKMAN_HARRIS_3,
    ];
    let along_axis =
        (2.0 * a0 * a0 + a1 * a1 + a2 * a2 + a3 * a3) / (4.0 * FILTER_RADIUS_PX * a0 * a0);
    1.0 / (along_axis * along_axis)
};

/// Samples lie on a lattice of 2^`PLACE_BITS` places each way, so that a word keeps one.
pub const PLACE_BITS: u32 = 15;
pub const PLACES: f64 = 32768.0;

/// The place in its pixel of a sample with random numbers `u`.
pub fn filter_place(u: DVec2) -> UVec2 {
    (u * PLACES).as_uvec2()
}

/// From the pixel's centre, pixels.
pub fn filter_offset(place: UVec2) -> DVec2 {
    (place.as_dvec2() + 0.5) / PLACES - 0.5
}

/// The window where its first cosine is `c`; its integral over pixels is 1.
// cpu only: the shader's window is a polynomial of the distance.
fn window_of_cosine(c: f64) -> f64 {
    let b0 = BLACKMAN_HARRIS_0 - BLACKMAN_HARRIS_2;
    let b1 = BLACKMAN_HARRIS_1 - 3.0 * BLACKMAN_HARRIS_3;
    let b2 = 2.0 * BLACKMAN_HARRIS_2;
    let b3 = 4.0 * BLACKMAN_HARRIS_3;
    (b0 + c * (b1 + c * (b2 + c * b3))) / (2.0 * BLACKMAN_HARRIS_0 * FILTER_RADIUS_PX)
}

/// The window across one axis, at a distance from its middle up to `FILTER_RADIUS_PX`.
pub fn blackman_harris(distance: f64) -> f64 {
    window_of_cosine((PI / FILTER_RADIUS_PX * distance).cos())
}

/// `blackman_harris` at `offset` - 1, `offset` and `offset` + 1. The window being three pixels wide, they are a third of
/// a turn apart.
// cpu only: kernels evaluate each where they need it, which costs them less than to keep it.
pub fn filter_windows(offset: f64) -> [f64; 3] {
    const SIN_THIRD: f64 = 0.866_025_403_784_438_6;
    let (sin, cos) = (PI / FILTER_RADIUS_PX * offset).sin_cos();
    let [across, along] = [SIN_THIRD * sin, -0.5 * cos];
    [along + across, cos, along - across].map(window_of_cosine)
}

/// Of a sample so far, in pixels, from a pixel's centre.
pub fn filter_weight(offset: DVec2) -> f64 {
    blackman_harris(offset.x) * blackman_harris(offset.y)
}
