//! Colours of single wavelengths (nanometres), and indices that depend on them. A path that a dispersing
//! boundary has split carries one wavelength; 0 stands for a path that carries all of them.

use super::math::{exp_accurate, log_accurate};
use crate::spectrum;
pub use crate::spectrum::{WAVELENGTH_MAX, WAVELENGTH_MIN};
use glam::{DVec2, DVec3};

/// Wavelengths are drawn from four logistic distributions, each a quarter of the time. Fitted to the
/// root of the channels' sum of squares, the density of least variance: the channels' variances add up
/// to 8.92 where 8.68 is the least (uniform wavelengths: 17.2), and no weight exceeds 4.
pub const BANDS: u32 = 4;
pub const BAND_MEANS: [f64; 4] = [446.0, 507.0, 563.0, 615.0];
pub const BAND_WIDTHS: [f64; 4] = [11.0, 23.0, 20.5, 14.5];

/// Fraunhofer's lines C, d and F, nanometres: Abbe's number is (n_d - 1) / (n_F - n_C).
pub const LINE_C: f64 = 656.27;
pub const LINE_D: f64 = 587.56;
pub const LINE_F: f64 = 486.13;

/// The linear Rec. 709 response, per nanometre; the integral of each channel is 1.
pub fn color_matching(wavelength: f64) -> DVec3 {
    spectrum::color_matching(wavelength)
}

pub fn logistic(x: f64) -> f64 {
    1.0 / (1.0 + exp_accurate(-x))
}

/// A band's share below the visible spectrum, and above it.
pub fn band_tails(band: u32) -> DVec2 {
    let mean = BAND_MEANS[band as usize];
    let width = BAND_WIDTHS[band as usize];
    DVec2::new(
        logistic((WAVELENGTH_MIN - mean) / width),
        logistic((mean - WAVELENGTH_MAX) / width),
    )
}

/// A wavelength with density `wavelength_pdf`, for u in [0, 1).
pub fn sample_wavelength(u: f64) -> f64 {
    // With four bands the remainder of u is exact.
    let band = ((u * f64::from(BANDS)) as u32).min(BANDS - 1);
    let v = u * f64::from(BANDS) - f64::from(band);
    let tails = band_tails(band);
    let inside = 1.0 - tails.x - tails.y;
    // The logistic's quantile is the logarithm of the odds, both of them without cancellation; rounding
    // may pass the ends.
    let odds = (tails.x + v * inside) / (tails.y + (1.0 - v) * inside);
    (BAND_MEANS[band as usize] + BAND_WIDTHS[band as usize] * log_accurate(odds))
        .clamp(WAVELENGTH_MIN, WAVELENGTH_MAX)
}

/// Per nanometre; 0 outside the visible spectrum.
pub fn wavelength_pdf(wavelength: f64) -> f64 {
    if !(WAVELENGTH_MIN..=WAVELENGTH_MAX).contains(&wavelength) {
        return 0.0;
    }
    let mut pdf = 0.0;
    for band in 0..BANDS {
        let tails = band_tails(band);
        let x = (wavelength - BAND_MEANS[band as usize]) / BAND_WIDTHS[band as usize];
        pdf +=
            logistic(x) * logistic(-x) / (BAND_WIDTHS[band as usize] * (1.0 - tails.x - tails.y));
    }
    pdf / f64::from(BANDS)
}

/// What a path that carries this wavelength alone is multiplied by: its mean over sampled wavelengths is
/// (1, 1, 1). Between -1.9 and 4, negative where the wavelength's colour lies outside Rec. 709.
pub fn wavelength_weight(wavelength: f64) -> DVec3 {
    let pdf = wavelength_pdf(wavelength);
    if pdf <= 0.0 {
        return DVec3::ONE; // all wavelengths
    }
    color_matching(wavelength) / pdf
}

/// The index at a wavelength of a medium whose index at the line d is `ior`; `dispersion` is 20 over
/// Abbe's number (KHR_materials_dispersion).
pub fn ior_at(ior: f64, dispersion: f64, wavelength: f64) -> f64 {
    if dispersion <= 0.0 || wavelength <= 0.0 {
        return ior;
    }
    // Cauchy's A + B / lambda^2 through n_d, with n_F - n_C = (n_d - 1) / V_d.
    let line = LINE_D / wavelength;
    let line_F = LINE_D / LINE_F;
    let line_C = LINE_D / LINE_C;
    let slope = (line - 1.0) * (line + 1.0) / ((line_F - line_C) * (line_F + line_C));
    // Dispersions beyond 30, far outside real glass, would take red below vacuum's index.
    (ior + (ior - 1.0) * (0.05 * dispersion) * slope).max(ior.min(1.0))
}
