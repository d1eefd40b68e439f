//! Metals by name: measured spectra of the complex index eta + i k, and the index per channel that
//! stands for them.

mod table;

pub use table::METALS;

use crate::cpu::bsdf::fresnel::F_conductor;
use crate::spectrum;
use glam::DVec3;

/// A metal with its measured index relative to vacuum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metal {
    /// Chemical symbol.
    pub symbol: &'static str,
    /// English name.
    pub name: &'static str,
    /// Authors, year, title and journal of the measurement.
    pub source: &'static str,
    /// Rows of wavelength (nm, increasing), eta and k.
    pub samples: &'static [[f64; 3]],
}

/// The metal with this chemical symbol.
pub fn metal(symbol: &str) -> Option<&'static Metal> {
    METALS.iter().find(|metal| metal.symbol == symbol)
}

/// Wavelengths that integrate over the spectrum; measured samples are 10 nm or more apart.
const WAVELENGTHS: usize = 200;

/// Angles that the index is fitted at, degrees.
const FIT_ANGLES: std::ops::RangeInclusive<u32> = 0..=85;
const FIT_STEP: usize = 5;
/// Steps of the fit; it stands still after some ten.
const FIT_STEPS: usize = 100;
/// Of ln eta and ln k, for differences.
const FIT_DIFFERENCE: f64 = 1e-6;

impl Metal {
    /// Authors and year of the measurement.
    pub fn authors(&self) -> &'static str {
        let (authors, _) = self.source.split_once(", \"").expect("a title follows");
        authors
    }

    /// (eta, k) at a wavelength (nm): linear between samples, constant beyond them.
    pub fn at(&self, wavelength: f64) -> [f64; 2] {
        let after = self.samples.partition_point(|row| row[0] < wavelength);
        let row = |index: usize| self.samples[index.min(self.samples.len() - 1)];
        let (below, above) = (row(after.saturating_sub(1)), row(after));
        let span = above[0] - below[0];
        let t = if span > 0.0 {
            (wavelength - below[0]) / span
        } else {
            0.0
        };
        [1, 2].map(|i| below[i] + (above[i] - below[i]) * t)
    }

    /// The colour of white light reflected at an angle, integrated over the spectrum: linear Rec. 709, and
    /// as all colours of spectra possibly outside its gamut (gold's red is 1.006).
    pub fn reflectance(&self, cos_theta: f64) -> DVec3 {
        spectrum::wavelengths(WAVELENGTHS)
            .map(|(wavelength, weight)| {
                let [eta, k] = self.at(wavelength);
                weight * F_conductor(cos_theta, eta, k) * spectrum::color_matching(wavelength)
            })
            .sum()
    }

    /// The means of eta and k, as the observer's channels weigh them.
    pub fn mean_index(&self) -> [DVec3; 2] {
        let mut means = [DVec3::ZERO; 2];
        for (wavelength, weight) in spectrum::wavelengths(WAVELENGTHS) {
            let response = weight * spectrum::color_matching(wavelength);
            for (mean, value) in means.iter_mut().zip(self.at(wavelength)) {
                *mean += value * response;
            }
        }
        means
    }

    /// (eta, k) of red, green and blue: the two numbers whose exact Fresnel reflectance is nearest to
    /// `reflectance`, by least squares over angles. The largest error to 85 degrees is 0.0005, 0.002 for
    /// copper and 0.014 for gold, whose red no index reaches (and whose fitted one is no metal's);
    /// `mean_index` errs by up to 0.002, 0.013 and 0.033. Takes a millisecond.
    pub fn index(&self) -> [[f32; 3]; 2] {
        let [etas, ks] = self.mean_index();
        let colors: Vec<(f64, DVec3)> = FIT_ANGLES
            .step_by(FIT_STEP)
            .map(|degrees| {
                let cos = f64::from(degrees).to_radians().cos();
                // No real surface reflects more than it gets.
                (cos, self.reflectance(cos).min(DVec3::ONE))
            })
            .collect();
        let mut index = [[0.0; 3]; 2];
        for channel in 0..3 {
            let targets: Vec<_> = colors
                .iter()
                .map(|(cos, color)| (*cos, color[channel]))
                .collect();
            let [eta, k] = fit([etas[channel], ks[channel]], &targets);
            index[0][channel] = eta as f32;
            index[1][channel] = k as f32;
        }
        index
    }
}

/// The (eta, k) near `start` whose reflectances at cosines are nearest to these (Levenberg 1944, "A
/// method for the solution of certain non-linear problems in least squares"), by logarithms so that
/// both stay positive.
fn fit(start: [f64; 2], targets: &[(f64, f64)]) -> [f64; 2] {
    let residuals = |x: [f64; 2]| -> Vec<f64> {
        let [eta, k] = x.map(f64::exp);
        targets
            .iter()
            .map(|&(cos, target)| F_conductor(cos, eta, k) - target)
            .collect()
    };
    let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
    let mut x = start.map(|value| value.max(f64::from(f32::EPSILON)).ln());
    let mut r = residuals(x);
    let mut damping = 1e-3;
    for _ in 0..FIT_STEPS {
        let slopes = [0, 1].map(|i| {
            let mut moved = x;
            moved[i] += FIT_DIFFERENCE;
            let moved = residuals(moved);
            let slope = |(a, b): (&f64, &f64)| (a - b) / FIT_DIFFERENCE;
            moved.iter().zip(&r).map(slope).collect::<Vec<f64>>()
        });
        // The normal equations, their diagonal raised.
        let (a, b, d) = (
            dot(&slopes[0], &slopes[0]) * (1.0 + damping),
            dot(&slopes[0], &slopes[1]),
            dot(&slopes[1], &slopes[1]) * (1.0 + damping),
        );
        let (p, q) = (dot(&slopes[0], &r), dot(&slopes[1], &r));
        let determinant = a * d - b * b;
        if determinant <= 0.0 {
            break;
        }
        let next = [
            x[0] - (d * p - b * q) / determinant,
            x[1] - (a * q - b * p) / determinant,
        ];
        let moved = residuals(next);
        if dot(&moved, &moved) < dot(&r, &r) {
            (x, r) = (next, moved);
            damping *= 0.3;
        } else {
            damping *= 3.0;
        }
    }
    x.map(f64::exp)
}
