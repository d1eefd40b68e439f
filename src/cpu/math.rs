//! Arithmetic that everything else stands on: vectors, frames, and the functions that shaders cannot
//! leave to the driver. Here they are the standard library's, or series carried to float64.

use glam::{DVec2, DVec3};

pub use std::f64::consts::PI;
pub const INV_PI: f64 = std::f64::consts::FRAC_1_PI;
pub const SQRT_PI: f64 = 1.772_453_850_905_516;

const FIXED_ONE: f64 = 16_777_216.0; // where squares_minus_one cuts

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

pub fn basis_from_normal(n: DVec3) -> Basis {
    // Duff et al. 2017, "Building an Orthonormal Basis, Revisited", listing 3.
    let s = if n.z >= 0.0 { 1.0 } else { -1.0 };
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

/// a * b as (rounded product, its rounding error).
pub fn two_product(a: f64, b: f64) -> DVec2 {
    let p = a * b;
    DVec2::new(p, a.mul_add(b, -p))
}

/// a * b + c, rounded about once: where product and c cancel, their difference is exact.
pub fn product_sum(a: f64, b: f64, c: f64) -> f64 {
    let p = two_product(a, b);
    (p.x + c) + p.y
}

/// a^2 + b^2 - c^2 - 1 to 1e-15 of itself, or to 1e-19 where it cancels to less.
pub fn squares_minus_one(a: f64, b: f64, c: f64) -> f64 {
    let aa = two_product(a, a);
    let bb = two_product(b, b);
    let cc = two_product(c, c);
    // Cut at a fixed place, the high parts sum exactly and the low parts to very little.
    let squares = DVec3::new(aa.x, bb.x, cc.x);
    let high = (squares * FIXED_ONE).floor() / FIXED_ONE;
    let low = squares - high;
    let low_sum = (low.x + low.y - low.z) + (aa.y + bb.y - cc.y);
    (high.x - 1.0 + high.y - high.z) + low_sum
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

/// e^(x^2) erfc(x), x >= 0: the complementary error function without its steep part.
pub fn erfcx_accurate(x: f64) -> f64 {
    // Shepherd and Laframboise 1981, "Chebyshev Approximation of (1 + 2x) exp(x^2) erfc x in
    // 0 <= x < infinity": the same quantity in t = (x - 3) / (x + 3); own expansion, error 1e-17.
    let t = (x - 3.0) / (x + 3.0);
    // Clenshaw's summation of the Chebyshev series.
    let (mut b1, mut b2) = (0.0, 0.0);
    for &c in ERFCX_CHEBYSHEV[1..].iter().rev() {
        (b1, b2) = (2.0 * t * b1 - b2 + c, b1);
    }
    (t * b1 - b2 + ERFCX_CHEBYSHEV[0]) / (1.0 + 2.0 * x)
}

pub fn erfc_accurate(x: f64) -> f64 {
    let tail = (-x * x).exp() * erfcx_accurate(x.abs());
    if x < 0.0 { 2.0 - tail } else { tail }
}

pub fn erf_accurate(x: f64) -> f64 {
    if x.abs() > 0.5 {
        return if x < 0.0 {
            erfc_accurate(-x) - 1.0
        } else {
            1.0 - erfc_accurate(x)
        };
    }
    // Maclaurin's series: x^(2n+1) (-1)^n / (n! (2n+1)); 15 terms reach 1e-20.
    let (mut power, mut sum) = (x, x);
    for n in 1..16 {
        power *= -x * x / f64::from(n);
        sum += power / f64::from(2 * n + 1);
    }
    2.0 / SQRT_PI * sum
}

/// The x with erfc(-x) / 2 = u: a number distributed as e^(-x^2) / sqrt(pi) for u uniform in [0, 1).
pub fn normal_quantile(u: f64) -> f64 {
    let v = u.min(1.0 - u).max(1.490_116_119_384_765_6e-8); // 2^-26: half of the smallest u above 0
    // Start: Winitzki 2008, "A handy approximation for the error function and its inverse", eq. 7.
    let l = (4.0 * v * (1.0 - v)).ln();
    let h = 2.0 / (0.147 * PI) + 0.5 * l;
    let mut t = safe_sqrt((h * h - l / 0.147).max(0.0).sqrt() - h);
    // Four steps of Halley's method on erfc(t) / 2 = v (cubic: the shader needs two).
    for _ in 0..4 {
        let newton = (0.5 * erfcx_accurate(t) - v * (t * t).exp()) * SQRT_PI;
        t += newton / (1.0 - t * newton);
    }
    if u < 0.5 { -t } else { t }
}

const ERFCX_CHEBYSHEV: [f64; 32] = [
    1.17756257419656,
    0.005353904539615676,
    -0.09377550342284209,
    0.05436652555744322,
    -0.018976596707845208,
    0.004453426061462712,
    -0.0006335531710553147,
    1.7661719523171593e-05,
    1.2841532864056671e-05,
    -2.0072285659059913e-06,
    -1.807522790414837e-07,
    7.549828343825093e-08,
    1.885668523838603e-09,
    -2.699519049798364e-09,
    -1.460079119939105e-11,
    1.0361607445969489e-10,
    1.475715976623473e-12,
    -4.277340064396911e-12,
    -2.07922492859799e-13,
    1.8134502003176963e-13,
    1.973425574544739e-14,
    -7.287943737592673e-15,
    -1.5169878690228116e-15,
    2.3514112258781403e-16,
    1.0006111691821667e-16,
    -2.0572528169538546e-18,
    -5.608608218863183e-18,
    -5.546884725994431e-19,
    2.4432011577263517e-19,
    6.446123955093521e-20,
    -5.1532250422574224e-21,
    -4.5890412587723566e-21,
];
