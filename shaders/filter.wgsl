// The pixel filter: a Blackman-Harris window three pixels wide. Samples lie evenly in their pixel and count,
// by the filter's weight, for the nine pixels around. The mean is the same as of samples drawn from the filter for one
// pixel each, and its variance 0.45 times that (FILTER_OVERLAP of src/cpu/filter.rs).

// Half the window's width, pixels: its usual support of three pixels.
const FILTER_RADIUS_PX: f32 = 1.5;

// How many pixels beside a pixel have samples that count for it.
const FILTER_REACH: u32 = 1u;

// Samples lie on a lattice of 2^PLACE_BITS places each way, so that a word keeps one.
const PLACE_BITS: u32 = 15u;
const PLACES: f32 = 32768.0;

// The place in its pixel of a sample with random numbers u.
fn filter_place(u: vec2<f32>) -> vec2<u32> {
    // By way of signed numbers, for which processors have an instruction.
    return vec2<u32>(vec2<i32>(u * PLACES));
}

// From the pixel's centre, pixels.
fn filter_offset(place: vec2<u32>) -> vec2<f32> {
    return (vec2<f32>(vec2<i32>(place)) + 0.5) / PLACES - 0.5;
}

// The window of Harris 1978, "On the use of windows for harmonic analysis with the discrete Fourier transform", table
// I, minimum 4-term, across one axis; at a distance from its middle up to FILTER_RADIUS_PX. Its integral over pixels
// is 1. A polynomial through Chebyshev's nodes, within 4e-6.
fn blackman_harris(distance: f32) -> f32 {
    let t = distance / FILTER_RADIUS_PX;
    let z = t * t;
    return 0.929150607 + z * (-5.3118208 + z * (13.9271439 + z * (-22.3173865 + z * (24.3999845
        + z * (-18.8986357 + z * (10.1324861 + z * (-3.39512964 + z * 0.534264473)))))));
}

// Of a sample so far, in pixels, from a pixel's centre.
fn filter_weight(offset: vec2<f32>) -> f32 {
    return blackman_harris(offset.x) * blackman_harris(offset.y);
}
