//! From spectra to linear Rec. 709, in float64.
//!
//! The observer is CIE 1931, 2 degrees, in closed form; a spectrum is a function of the wavelength in
//! nanometres, from `WAVELENGTH_MIN` to `WAVELENGTH_MAX`.
//!
//! Each channel is normalised so that a constant spectrum of 1 is (1, 1, 1): white is the equal-energy
//! spectrum. Spectra here are ratios, of reflected to incident light or of one wavelength's light to
//! that of all, and they multiply RGB radiance. A surface that reflects all wavelengths alike must leave
//! that radiance alone, whatever the hue of its white point, and colours of a film or of a prism must
//! add up to the light that came in. Normalising by D65 instead would give the same white and tilt the
//! rest by its own few percent, for an illuminant that the scene need not have.

use glam::DVec3;

/// Ends of the visible spectrum, nanometres: 0.1 % of the observer's response lies outside.
pub const WAVELENGTH_MIN: f64 = 380.0;
pub const WAVELENGTH_MAX: f64 = 780.0;

/// Rows of the matrix from CIE XYZ to linear Rec. 709 (the primaries and the white of ITU-R BT.709, 1.3
/// and 1.4), each divided by what it makes of the constant spectrum, in 1 / nm.
const RED: DVec3 = DVec3::new(
    2.528_305_428_931e-2,
    -1.199_324_370_134e-2,
    -3.889_700_659_893e-3,
);
const GREEN: DVec3 = DVec3::new(
    -9.536_995_617_591e-3,
    1.845_882_002_308e-2,
    4.088_862_547_519e-4,
);
const BLUE: DVec3 = DVec3::new(
    5.734_253_336_877e-4,
    -2.102_559_556_855e-3,
    1.089_508_134_007e-2,
);

/// A bell whose halves have inverse widths `below` and `above` its mean.
fn bell(wavelength: f64, mean: f64, below: f64, above: f64) -> f64 {
    let t = (wavelength - mean) * if wavelength < mean { below } else { above };
    (-0.5 * t * t).exp()
}

/// The observer's response (X, Y, Z) at a wavelength.
pub fn xyz(wavelength: f64) -> DVec3 {
    // Wyman, Sloan and Shirley 2013, "Simple Analytic Approximations to the CIE XYZ Color Matching
    // Functions", eq. 4 and table 1.
    let bell = |mean, below, above| bell(wavelength, mean, below, above);
    DVec3::new(
        1.056 * bell(599.8, 0.0264, 0.0323) + 0.362 * bell(442.0, 0.0624, 0.0374)
            - 0.065 * bell(501.1, 0.0490, 0.0382),
        0.821 * bell(568.8, 0.0213, 0.0247) + 0.286 * bell(530.9, 0.0613, 0.0322),
        1.217 * bell(437.0, 0.0845, 0.0278) + 0.681 * bell(459.0, 0.0385, 0.0725),
    )
}

/// The linear Rec. 709 response at a wavelength, per nanometre; the integral of each channel is 1.
/// Spectral colours lie outside Rec. 709's triangle, so some of it is negative.
pub fn color_matching(wavelength: f64) -> DVec3 {
    let xyz = xyz(wavelength);
    DVec3::new(RED.dot(xyz), GREEN.dot(xyz), BLUE.dot(xyz))
}

/// Wavelengths and weights that integrate over the visible spectrum: `count` midpoints.
pub fn wavelengths(count: usize) -> impl Iterator<Item = (f64, f64)> {
    let step = (WAVELENGTH_MAX - WAVELENGTH_MIN) / count as f64;
    (0..count).map(move |i| (WAVELENGTH_MIN + step * (i as f64 + 0.5), step))
}
