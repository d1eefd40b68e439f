//! Arithmetic that everything else stands on: vectors, frames, and the functions that shaders cannot
//! leave to the driver. Here they are the standard library's, or series carried to float64.

use glam::{DVec2, DVec3};

pub use std::f64::consts::PI;
pub const INV_PI: f64 = std::f64::consts::FRAC_1_PI;

/// An orthonormal frame: tangent, bitangent, normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    pub t: DVec3,
    pub b: DVec3,
    pub n: DVec3,
}

pub fn sqr(x: f64) -> f64 {
    x * x
}

pub fn safe_sqrt(x: f64) -> f64 {
    x.max(0.0).sqrt()
}

/// Relative luminance of linear Rec. 709 (ITU-R BT.709).
pub fn luminance(rgb: DVec3) -> f64 {
    rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// Unit length; a vector of no length stays what it is.
pub fn normalize_accurate(v: DVec3) -> DVec3 {
    let norm = v.dot(v).sqrt();
    if norm > 0.0 {
        return v / norm;
    }
    v
}

/// z below which the basis of a normal is made the other way round.
pub const BASIS_SEAM: f64 = -0.37;

pub fn basis_from_normal(n: DVec3) -> Basis {
    // Duff et al. 2017, "Building an Orthonormal Basis, Revisited", listing 3, but for where its two
    // halves meet: not among the normals of upright walls, which rounding would put on either side.
    let s = if n.z >= BASIS_SEAM { 1.0 } else { -1.0 };
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    Basis {
        t: DVec3::new(1.0 + s * n.x * n.x * a, s * b, -s * n.x),
        b: DVec3::new(b, s + n.y * n.y * a, -n.y),
        n,
    }
}

/// The frame with normal `n` whose tangent is `t` made orthogonal to `n` (glTF 2.0, 3.7.2.1: the
/// bitangent is cross(n, t) * handedness); any frame about `n` where `t` says nothing. With handedness
/// -1 the frame is left-handed, and `to_local` and `to_world` are still each other's inverses.
pub fn basis_from_tangent(n: DVec3, t: DVec3, handedness: f64) -> Basis {
    let across = t - t.dot(n) * n;
    let length_squared = across.dot(across);
    // Below this share of t the direction is mostly rounding (in float32).
    if length_squared.is_nan() || length_squared <= 1e-10 * t.dot(t) {
        return basis_from_normal(n);
    }
    let tangent = across / length_squared.sqrt();
    Basis {
        t: tangent,
        b: n.cross(tangent) * handedness,
        n,
    }
}

pub fn to_local(basis: Basis, v: DVec3) -> DVec3 {
    DVec3::new(v.dot(basis.t), v.dot(basis.b), v.dot(basis.n))
}

pub fn to_world(basis: Basis, v: DVec3) -> DVec3 {
    v.x * basis.t + v.y * basis.b + v.z * basis.n
}

pub fn exp_accurate(x: f64) -> f64 {
    x.exp()
}

/// e^x - 1 without the cancellation near 0.
pub fn expm1_accurate(x: f64) -> f64 {
    x.exp_m1()
}

pub fn log_accurate(x: f64) -> f64 {
    x.ln()
}

/// ln(1 + x), x > -1, without the cancellation near 0.
pub fn log1p_accurate(x: f64) -> f64 {
    x.ln_1p()
}

/// x^y for x >= 0.
pub fn pow_accurate(x: f64, y: f64) -> f64 {
    x.powf(y)
}

/// (sin x, cos x).
pub fn sincos_accurate(x: f64) -> DVec2 {
    let (s, c) = x.sin_cos();
    DVec2::new(s, c)
}

/// The angle of the point (x, y), -pi to pi.
pub fn atan2_accurate(y: f64, x: f64) -> f64 {
    y.atan2(x)
}

pub fn acos_accurate(x: f64) -> f64 {
    2.0 * safe_sqrt(1.0 - x).atan2(safe_sqrt(1.0 + x))
}

pub fn asin_accurate(x: f64) -> f64 {
    x.atan2(safe_sqrt((1.0 - x) * (1.0 + x)))
}
