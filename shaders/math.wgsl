// Arithmetic that everything else stands on. Drivers may be off by thousands of ulps in exp, log,
// sin, pow and their like (the specifications of Vulkan and WGSL allow it, lavapipe does it), so
// these are our own, each within a few ulps of float32 and made of + - * / and sqrt alone.

const PI: f32 = 3.14159265358979;
const INV_PI: f32 = 0.318309886183791;
const LN_2_HIGH: f32 = 0.693359375; // 15 bits, so that its product with an exponent is exact
const LN_2_LOW: f32 = -2.12194440e-4;
const PI_2_HIGH: f32 = 1.5703125;   // pi / 2 in three parts, the first two short
const PI_2_MIDDLE: f32 = 4.837512969970703e-4;
const PI_2_LOW: f32 = 7.54978995489188e-8;

// An orthonormal frame: tangent, bitangent, normal.
struct Basis {
    t: vec3<f32>,
    b: vec3<f32>,
    n: vec3<f32>,
}

fn sqr(x: f32) -> f32 {
    return x * x;
}

fn safe_sqrt(x: f32) -> f32 {
    return sqrt(max(x, 0.0));
}

// Relative luminance of linear Rec. 709 (ITU-R BT.709).
fn luminance(rgb: vec3<f32>) -> f32 {
    return dot(rgb, vec3(0.2126, 0.7152, 0.0722));
}

// Unit length; a vector of no length stays what it is.
fn normalize_accurate(v: vec3<f32>) -> vec3<f32> {
    let norm = sqrt(dot(v, v));
    if norm > 0.0 {
        return v / norm;
    }
    return v;
}

// z below which the basis of a normal is made the other way round.
const BASIS_SEAM: f32 = -0.37;

fn basis_from_normal(n: vec3<f32>) -> Basis {
    // Duff et al. 2017, "Building an Orthonormal Basis, Revisited", listing 3, but for where its two
    // halves meet: not among the normals of upright walls, which rounding would put on either side.
    let s = select(-1.0, 1.0, n.z >= BASIS_SEAM);
    let a = -1.0 / (s + n.z);
    let b = n.x * n.y * a;
    return Basis(
        vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x),
        vec3(b, s + n.y * n.y * a, -n.y),
        n,
    );
}

// The frame with normal n whose tangent is t made orthogonal to n (glTF 2.0, 3.7.2.1: the bitangent is
// cross(n, t) * handedness); any frame about n where t says nothing. With handedness -1 the frame is
// left-handed, and to_local and to_world are still each other's inverses.
fn basis_from_tangent(n: vec3<f32>, t: vec3<f32>, handedness: f32) -> Basis {
    let across = t - dot(t, n) * n;
    let length_squared = dot(across, across);
    // Below this share of t the direction is mostly rounding.
    if !(length_squared > 1e-10 * dot(t, t)) {
        return basis_from_normal(n);
    }
    let tangent = across / sqrt(length_squared);
    return Basis(tangent, cross(n, tangent) * handedness, n);
}

fn to_local(basis: Basis, v: vec3<f32>) -> vec3<f32> {
    return vec3(dot(v, basis.t), dot(v, basis.b), dot(v, basis.n));
}

fn to_world(basis: Basis, v: vec3<f32>) -> vec3<f32> {
    return v.x * basis.t + v.y * basis.b + v.z * basis.n;
}

// e^x; 0 below the smallest normal number, the largest finite number above it.
fn exp_accurate(x: f32) -> f32 {
    if x < -87.3 {
        return 0.0;
    }
    if x > 88.72 {
        return 3.4028234e38;
    }
    let k = round(x * 1.44269504);
    let r = (x - k * LN_2_HIGH) - k * LN_2_LOW;
    // Taylor's series, |r| < 0.347: the rest is below 1e-8.
    var p = 1.0 / 5040.0;
    p = p * r + 1.0 / 720.0;
    p = p * r + 1.0 / 120.0;
    p = p * r + 1.0 / 24.0;
    p = p * r + 1.0 / 6.0;
    p = p * r + 0.5;
    let m = 1.0 + (r + r * r * p);
    // Two factors, since 2^128 is no float32.
    let k1 = i32(k) / 2;
    let k2 = i32(k) - k1;
    return m * bitcast<f32>(u32(127 + k1) << 23u) * bitcast<f32>(u32(127 + k2) << 23u);
}

// e^x - 1 without the cancellation near 0.
fn expm1_accurate(x: f32) -> f32 {
    if abs(x) > 0.35 {
        return exp_accurate(x) - 1.0;
    }
    var p = 1.0 / 40320.0;
    p = p * x + 1.0 / 5040.0;
    p = p * x + 1.0 / 720.0;
    p = p * x + 1.0 / 120.0;
    p = p * x + 1.0 / 24.0;
    p = p * x + 1.0 / 6.0;
    p = p * x + 0.5;
    return x + x * x * p;
}

// ln(1 + f) for f between sqrt(1/2) - 1 and sqrt(2) - 1.
// shader only: a part of log_accurate and log1p_accurate, which float64 has built in.
fn log1p_reduced(f: f32) -> f32 {
    // ln(1 + f) = 2 atanh(s), s = f / (2 + f), its series cut where the rest is below 1e-9.
    let s = f / (2.0 + f);
    let z = s * s;
    var p = 2.0 / 11.0;
    p = p * z + 2.0 / 9.0;
    p = p * z + 2.0 / 7.0;
    p = p * z + 2.0 / 5.0;
    p = p * z + 2.0 / 3.0;
    let half_square = 0.5 * f * f;
    return f - (half_square - s * (half_square + p * z));
}

// A positive x as (1 + f) 2^k with f as log1p_reduced takes it: (f, k).
// shader only: as log1p_reduced.
fn log_reduction(x: f32) -> vec2<f32> {
    let bits = bitcast<u32>(x);
    // The exponent is counted so that the mantissa lies between sqrt(1/2) and sqrt(2).
    let k = (i32(bits) - 0x3f3504f3) >> 23u;
    let m = bitcast<f32>(bits - bitcast<u32>(k << 23u));
    return vec2(m - 1.0, f32(k));
}

// Natural logarithm of a positive number; the lowest finite number at 0.
fn log_accurate(x: f32) -> f32 {
    if x <= 0.0 {
        return -3.4028234e38;
    }
    let r = log_reduction(x);
    return r.y * LN_2_HIGH + (log1p_reduced(r.x) + r.y * LN_2_LOW);
}

// ln(1 + x), x > -1, without the cancellation near 0.
fn log1p_accurate(x: f32) -> f32 {
    if x <= -1.0 {
        return -3.4028234e38;
    }
    // One series for both ways: drivers copy it to each place.
    let r = select(log_reduction(1.0 + x), vec2(x, 0.0), x > -0.29 && x < 0.41);
    return r.y * LN_2_HIGH + (log1p_reduced(r.x) + r.y * LN_2_LOW);
}

// x^y for x >= 0.
fn pow_accurate(x: f32, y: f32) -> f32 {
    if x <= 0.0 {
        return select(0.0, 1.0, y == 0.0);
    }
    return exp_accurate(y * log_accurate(x));
}

// (sin x, cos x); |x| up to a few thousand.
fn sincos_accurate(x: f32) -> vec2<f32> {
    let k = round(x * 0.636619772);
    // Cody and Waite 1980, "Software Manual for the Elementary Functions": pi / 2 in three parts.
    let r = ((x - k * PI_2_HIGH) - k * PI_2_MIDDLE) - k * PI_2_LOW;
    let z = r * r;
    var s = 1.0 / 362880.0;
    s = s * z - 1.0 / 5040.0;
    s = s * z + 1.0 / 120.0;
    s = s * z - 1.0 / 6.0;
    s = r + r * z * s;
    var c = -1.0 / 3628800.0;
    c = c * z + 1.0 / 40320.0;
    c = c * z - 1.0 / 720.0;
    c = c * z + 1.0 / 24.0;
    c = 1.0 - (0.5 * z - z * z * c);
    let quadrant = i32(k) & 3;
    let swapped = select(vec2(s, c), vec2(c, s), (quadrant & 1) == 1);
    return vec2(
        select(swapped.x, -swapped.x, quadrant >= 2),
        select(swapped.y, -swapped.y, quadrant == 1 || quadrant == 2),
    );
}

// The angle of the point (x, y), -pi to pi; 0 at the origin.
fn atan2_accurate(y: f32, x: f32) -> f32 {
    let ax = abs(x);
    let ay = abs(y);
    let high = max(ax, ay);
    if high == 0.0 {
        return 0.0;
    }
    let t = min(ax, ay) / high;
    // Above tan(pi / 8) turn by pi / 4.
    let turned = t > 0.41421356;
    let v = select(t, (t - 1.0) / (t + 1.0), turned);
    let z = v * v;
    // Chebyshev fit of (atan(v) / v) over v^2, error 6e-10.
    var p = -0.06033241701;
    p = p * z + 0.1057281448;
    p = p * z - 0.1423998292;
    p = p * z + 0.199982108;
    p = p * z - 0.3333330749;
    var angle = v + v * z * p;
    if turned {
        angle += 0.785398163397448;
    }
    if ay > ax {
        angle = 1.57079632679490 - angle;
    }
    if x < 0.0 {
        angle = PI - angle;
    }
    return select(angle, -angle, y < 0.0);
}

fn acos_accurate(x: f32) -> f32 {
    return 2.0 * atan2_accurate(safe_sqrt(1.0 - x), safe_sqrt(1.0 + x));
}

fn asin_accurate(x: f32) -> f32 {
    return atan2_accurate(x, safe_sqrt((1.0 - x) * (1.0 + x)));
}
