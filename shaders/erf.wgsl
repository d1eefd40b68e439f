// The error function and its kin.

import package::math::{exp_accurate, log_accurate, safe_sqrt};

const SQRT_PI: f32 = 1.77245385090552;

// e^(x^2) erfc(x), x >= 0: the complementary error function without its steep part.
fn erfcx_accurate(x: f32) -> f32 {
    // Shepherd and Laframboise 1981, "Chebyshev Approximation of (1 + 2x) exp(x^2) erfc x in
    // 0 <= x < infinity": the same quantity in t = (x - 3) / (x + 3); own fit, error 3e-9.
    let t = (x - 3.0) / (x + 3.0);
    var p = 3.861849137e-6;
    p = p * t + 7.731024224e-5;
    p = p * t - 0.0001041307143;
    p = p * t - 0.000726453679;
    p = p * t + 0.001888112865;
    p = p * t + 0.00249911687;
    p = p * t - 0.02377033468;
    p = p * t + 0.06831656777;
    p = p * t - 0.1192736913;
    p = p * t + 0.1296441143;
    p = p * t - 0.0475622927;
    p = p * t - 0.1356210694;
    p = p * t + 1.253008058;
    return p / (1.0 + 2.0 * x);
}

fn erfc_accurate(x: f32) -> f32 {
    let tail = exp_accurate(-x * x) * erfcx_accurate(abs(x));
    return select(tail, 2.0 - tail, x < 0.0);
}

fn erf_accurate(x: f32) -> f32 {
    if abs(x) > 0.5 {
        return select(1.0 - erfc_accurate(x), erfc_accurate(-x) - 1.0, x < 0.0);
    }
    // Maclaurin's series.
    let z = x * x;
    var p = 1.0 / 1320.0;
    p = -p * z + 1.0 / 216.0;
    p = -p * z + 1.0 / 42.0;
    p = -p * z + 1.0 / 10.0;
    p = -p * z + 1.0 / 3.0;
    return (2.0 / SQRT_PI) * (x - x * z * p);
}

// The x with erfc(-x) / 2 = u: a number distributed as e^(-x^2) / sqrt(pi) for u uniform in [0, 1).
fn normal_quantile(u: f32) -> f32 {
    let v = max(min(u, 1.0 - u), 1.4901161e-8); // 2^-26: half of the smallest u above 0
    // Start: Winitzki 2008, "A handy approximation for the error function and its inverse", eq. 7.
    let l = log_accurate(4.0 * v * (1.0 - v));
    let h = 4.33074675 + 0.5 * l; // 2 / (0.147 pi)
    var t = safe_sqrt(sqrt(max(h * h - l / 0.147, 0.0)) - h);
    // Two steps of Halley's method on erfc(t) / 2 = v.
    for (var i = 0; i < 2; i++) {
        let newton = (0.5 * erfcx_accurate(t) - v * exp_accurate(t * t)) * SQRT_PI;
        t += newton / (1.0 - t * newton);
    }
    return select(t, -t, u < 0.5);
}
