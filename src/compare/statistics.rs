//! The tail of Student's distribution, by the regularised incomplete beta function.

/// The level for each of `tests` independent tests that gives `alpha` for all of them together:
/// 1 - (1 - alpha)^(1/n) (Sidak 1967), by expm1 and ln_1p since it is tiny.
pub fn sidak(alpha: f64, tests: usize) -> f64 {
    -((-alpha).ln_1p() / tests.max(1) as f64).exp_m1()
}

/// Two-sided p-value of a Student t statistic: I_x(freedom/2, 1/2) with x = freedom/(freedom + t^2)
/// (Abramowitz, Stegun 1964, 26.7.1 and 26.5.27). Near the normal distribution for many degrees.
pub fn p_value_student(t: f64, freedom: f64) -> f64 {
    if t.is_nan() {
        return 1.0;
    }
    if t.is_infinite() {
        return 0.0;
    }
    // Written so that neither x nor 1 - x loses digits where the other is near 1.
    let x = freedom / (freedom + t * t);
    let y = t * t / (freedom + t * t);
    incomplete_beta(x, y, 0.5 * freedom, 0.5).clamp(0.0, 1.0)
}

/// I_x(a, b) with y = 1 - x, by the continued fraction (Abramowitz, Stegun 1964, 26.5.8) where it
/// converges fast and by its mirror image elsewhere.
fn incomplete_beta(x: f64, y: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if y <= 0.0 {
        return 1.0;
    }
    let front = (a * x.ln() + b * y.ln() + ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b)).exp();
    if x < (a + 1.0) / (a + b + 2.0) {
        front * beta_fraction(x, a, b) / a
    } else {
        1.0 - front * beta_fraction(y, b, a) / b
    }
}

/// The continued fraction of I_x(a, b), evaluated forwards (Thompson, Barnett 1986, after Lentz).
fn beta_fraction(x: f64, a: f64, b: f64) -> f64 {
    /// Far more terms than the parameters of a film need; each adds digits.
    const TERMS: usize = 10_000;
    const TINY: f64 = 1e-300;
    let away_from_zero = |v: f64| if v.abs() < TINY { TINY } else { v };
    let mut c = 1.0;
    let mut d = 1.0 / away_from_zero(1.0 - (a + b) * x / (a + 1.0));
    let mut value = d;
    for term in 1..TERMS {
        let m = term as f64;
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        d = 1.0 / away_from_zero(1.0 + even * d);
        c = away_from_zero(1.0 + even / c);
        value *= c * d;
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        d = 1.0 / away_from_zero(1.0 + odd * d);
        c = away_from_zero(1.0 + odd / c);
        value *= c * d;
        if (c * d - 1.0).abs() < f64::EPSILON {
            break;
        }
    }
    value
}

/// Logarithm of the gamma function for x > 0: Stirling's series (Abramowitz, Stegun 1964, 6.1.41)
/// after moving x beyond 10 by the recurrence.
fn ln_gamma(x: f64) -> f64 {
    let (mut x, mut shift) = (x, 0.0);
    while x < 10.0 {
        shift += x.ln();
        x += 1.0;
    }
    let r = 1.0 / (x * x);
    let series = (1.0 / 12.0 - r * (1.0 / 360.0 - r * (1.0 / 1260.0 - r / 1680.0))) / x;
    (x - 0.5) * x.ln() - x + 0.5 * std::f64::consts::TAU.ln() + series - shift
}
