//! Reflectances by textbook formulas, written apart from the renderer's.

use std::ops::{Add, Div, Mul, Sub};

#[derive(Clone, Copy)]
pub struct Complex {
    re: f64,
    im: f64,
}

impl Complex {
    fn new(re: f64, im: f64) -> Complex {
        Complex { re, im }
    }

    fn norm_sqr(self) -> f64 {
        self.re * self.re + self.im * self.im
    }

    /// The root with a positive real part.
    fn sqrt(self) -> Complex {
        let (r, phi) = (self.norm_sqr().sqrt().sqrt(), self.im.atan2(self.re));
        Complex::new(r * (0.5 * phi).cos(), r * (0.5 * phi).sin())
    }
}

impl Add for Complex {
    type Output = Complex;
    fn add(self, other: Complex) -> Complex {
        Complex::new(self.re + other.re, self.im + other.im)
    }
}

impl Sub for Complex {
    type Output = Complex;
    fn sub(self, other: Complex) -> Complex {
        Complex::new(self.re - other.re, self.im - other.im)
    }
}

impl Mul for Complex {
    type Output = Complex;
    fn mul(self, other: Complex) -> Complex {
        Complex::new(
            self.re * other.re - self.im * other.im,
            self.re * other.im + self.im * other.re,
        )
    }
}

impl Div for Complex {
    type Output = Complex;
    fn div(self, other: Complex) -> Complex {
        let n = other.norm_sqr();
        self * Complex::new(other.re / n, -other.im / n)
    }
}

/// Unpolarised reflectance of an interface with the relative index eta + i k (Born, Wolf 1999,
/// "Principles of Optics", section 1.5.2 with a complex index as in section 14.2).
pub fn reflectance(eta: f64, k: f64, cos_i: f64) -> f64 {
    let n = Complex::new(eta, k);
    let cos = Complex::new(cos_i, 0.0);
    let sin2 = Complex::new(1.0 - cos_i * cos_i, 0.0);
    let cos_t = (Complex::new(1.0, 0.0) - sin2 / (n * n)).sqrt();
    let s = (cos - n * cos_t) / (cos + n * cos_t);
    let p = (n * cos - cos_t) / (n * cos + cos_t);
    0.5 * (s.norm_sqr() + p.norm_sqr())
}

/// The lecture's two quotients, which hold where eta^2 + k^2 is large.
pub fn reflectance_approximate(eta: f64, k: f64, cos_i: f64) -> f64 {
    let (size, cos2) = (eta * eta + k * k, cos_i * cos_i);
    let twice = 2.0 * eta * cos_i;
    let p = (size * cos2 - twice + 1.0) / (size * cos2 + twice + 1.0);
    let s = (size - twice + cos2) / (size + twice + cos2);
    0.5 * (p + s)
}

/// The same seen from the dense side: 1 beyond the critical angle.
pub fn reflectance_from_inside(eta: f64, cos_i: f64) -> f64 {
    let sin_o = eta * (1.0 - cos_i * cos_i).sqrt();
    if sin_o >= 1.0 {
        return 1.0;
    }
    // Both ways through an interface the reflectance is one (Stokes 1849).
    reflectance(eta, 0.0, (1.0 - sin_o * sin_o).sqrt())
}

#[test]
fn reflectances_have_their_known_values() {
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} is not {b}");
    near(reflectance(1.5, 0.0, 1.0), 0.04);
    near(reflectance(1.5, 0.0, 0.0), 1.0);
    near(reflectance(0.2, 3.0, 1.0), (0.64 + 9.0) / (1.44 + 9.0));
    // At Brewster's angle only the perpendicular half is left: ((eta^2 - 1) / (eta^2 + 1))^2 / 2.
    let brewster = 1.5f64.atan().cos();
    near(
        reflectance(1.5, 0.0, brewster),
        0.5 * (1.25f64 / 3.25).powi(2),
    );
    near(reflectance_from_inside(1.5, 1.0), 0.04);
    near(reflectance_from_inside(1.5, 0.7), 1.0);
}
