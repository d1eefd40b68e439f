//! The error function and its kin, to float64.

use crate::cpu::math::{PI, safe_sqrt};

pub const SQRT_PI: f64 = 1.772_453_850_905_516;

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
