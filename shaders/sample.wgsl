// Warps: from the unit square (or interval) to the shapes that a renderer samples, each with a
// density that is constant or stated beside it. u are multiples of 2^-24 in [0, 1).

import package::math::{PI, INV_PI, sincos_accurate};

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
