//! Rays, what they hit, and how a new ray starts on a surface without meeting it again.

use glam::DVec3;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    pub origin: DVec3,
    pub t_min: f64,
    /// Unit length in world space.
    pub direction: DVec3,
    pub t_max: f64,
    /// In [0, 1) from when the shutter opens to when it closes.
    pub time: f64,
}

/// Where a ray met a triangle: the point is `p0 + u e1 + v e2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    pub t: f64,
    pub u: f64,
    pub v: f64,
    /// `NONE`: nothing was hit.
    pub instance: u32,
    /// Index in `Packed::triangles`.
    pub triangle: u32,
}

/// Rounding of the sum below, a few units in the last place of f32: 2^-21.
pub const ORIGIN_ROUNDING: f64 = 4.76837158203125e-7;

/// Moves `p` off the surface with unit normal `ng`, to the side that `w` points to. `floor` is the
/// error of `p` along the normal in metres, `Surface::p_error`; the rounding of `p` itself is added.
pub fn offset_origin(p: DVec3, ng: DVec3, w: DVec3, floor: f64) -> DVec3 {
    // In the manner of Pharr, Jakob and Humphreys, "Physically Based Rendering", section 6.8:
    // bounds of the error, not a constant that fits one scale of scene. The bounds are those of
    // float32, so that both renderers' rays start in the same place.
    let distance = floor + ORIGIN_ROUNDING * ng.abs().dot(p.abs());
    p + ng * if ng.dot(w) < 0.0 { -distance } else { distance }
}
