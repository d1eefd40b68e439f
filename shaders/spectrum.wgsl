// Colours of single wavelengths (nanometres), and indices that depend on them. A path that a dispersing
// boundary has split carries one wavelength; 0 stands for a path that carries all of them.

import package::math::{exp_accurate, log_accurate};

const WAVELENGTH_MIN: f32 = 380.0;
const WAVELENGTH_MAX: f32 = 780.0;

// Linear Rec. 709 from CIE XYZ, each row over the integral of its response: see src/spectrum.rs.
const RED: vec3<f32> = vec3(2.528305429e-02, -1.199324370e-02, -3.889700660e-03);
const GREEN: vec3<f32> = vec3(-9.536995618e-03, 1.845882002e-02, 4.088862548e-04);
const BLUE: vec3<f32> = vec3(5.734253337e-04, -2.102559557e-03, 1.089508134e-02);

// Wavelengths are drawn from four logistic distributions, each a quarter of the time. Fitted to the root
// of the channels' sum of squares, the density of least variance: the channels' variances add up to
// 8.92 where 8.68 is the least (uniform wavelengths: 17.2), and no weight exceeds 4.
const BANDS: u32 = 4u;
const BAND_MEANS: vec4<f32> = vec4(446.0, 507.0, 563.0, 615.0);
const BAND_WIDTHS: vec4<f32> = vec4(11.0, 23.0, 20.5, 14.5);

// Fraunhofer's lines C, d and F, nanometres: Abbe's number is (n_d - 1) / (n_F - n_C).
const LINE_C: f32 = 656.27;
const LINE_D: f32 = 587.56;
const LINE_F: f32 = 486.13;

// A bell whose halves have inverse widths below and above its mean.
// shader only: a part of color_matching, which the reference has from src/spectrum.rs.
fn bell(wavelength: f32, mean: f32, below: f32, above: f32) -> f32 {
    let t = (wavelength - mean) * select(above, below, wavelength < mean);
    return exp_accurate(-0.5 * t * t);
}

// The linear Rec. 709 response, per nanometre; the integral of each channel is 1.
fn color_matching(wavelength: f32) -> vec3<f32> {
    // Wyman, Sloan and Shirley 2013, "Simple Analytic Approximations to the CIE XYZ Color Matching
    // Functions", eq. 4 and table 1.
    let xyz = vec3(
        1.056 * bell(wavelength, 599.8, 0.0264, 0.0323) + 0.362 * bell(wavelength, 442.0, 0.0624, 0.0374)
            - 0.065 * bell(wavelength, 501.1, 0.0490, 0.0382),
        0.821 * bell(wavelength, 568.8, 0.0213, 0.0247) + 0.286 * bell(wavelength, 530.9, 0.0613, 0.0322),
        1.217 * bell(wavelength, 437.0, 0.0845, 0.0278) + 0.681 * bell(wavelength, 459.0, 0.0385, 0.0725),
    );
    return vec3(dot(RED, xyz), dot(GREEN, xyz), dot(BLUE, xyz));
}

fn logistic(x: f32) -> f32 {
    return 1.0 / (1.0 + exp_accurate(-x));
}

// A band's share below the visible spectrum, and above it.
fn band_tails(band: u32) -> vec2<f32> {
    let mean = BAND_MEANS[band];
    let width = BAND_WIDTHS[band];
    return vec2(logistic((WAVELENGTH_MIN - mean) / width), logistic((mean - WAVELENGTH_MAX) / width));
}

// A wavelength with density wavelength_pdf, for u in [0, 1).
fn sample_wavelength(u: f32) -> f32 {
    // With four bands the remainder of u is exact.
    let band = min(u32(u * f32(BANDS)), BANDS - 1u);
    let v = u * f32(BANDS) - f32(band);
    let tails = band_tails(band);
    let inside = 1.0 - tails.x - tails.y;
    // The logistic's quantile is the logarithm of the odds, both of them without cancellation; rounding
    // may pass the ends.
    let odds = (tails.x + v * inside) / (tails.y + (1.0 - v) * inside);
    return clamp(BAND_MEANS[band] + BAND_WIDTHS[band] * log_accurate(odds), WAVELENGTH_MIN, WAVELENGTH_MAX);
}

// Per nanometre; 0 outside the visible spectrum.
fn wavelength_pdf(wavelength: f32) -> f32 {
    if wavelength < WAVELENGTH_MIN || wavelength > WAVELENGTH_MAX {
        return 0.0;
    }
    var pdf = 0.0;
    for (var band = 0u; band < BANDS; band++) {
        let tails = band_tails(band);
        let x = (wavelength - BAND_MEANS[band]) / BAND_WIDTHS[band];
        pdf += logistic(x) * logistic(-x) / (BAND_WIDTHS[band] * (1.0 - tails.x - tails.y));
    }
    return pdf / f32(BANDS);
}

// What a path that carries this wavelength alone is multiplied by: its mean over sampled wavelengths is
// (1, 1, 1). Between -1.9 and 4, negative where the wavelength's colour lies outside Rec. 709.
fn wavelength_weight(wavelength: f32) -> vec3<f32> {
    let pdf = wavelength_pdf(wavelength);
    if pdf <= 0.0 {
        return vec3(1.0); // all wavelengths
    }
    return color_matching(wavelength) / pdf;
}

// The index at a wavelength of a medium whose index at the line d is ior; dispersion is 20 over Abbe's
// number (KHR_materials_dispersion).
fn ior_at(ior: f32, dispersion: f32, wavelength: f32) -> f32 {
    if dispersion <= 0.0 || wavelength <= 0.0 {
        return ior;
    }
    // Cauchy's A + B / lambda^2 through n_d, with n_F - n_C = (n_d - 1) / V_d.
    let line = LINE_D / wavelength;
    let line_F = LINE_D / LINE_F;
    let line_C = LINE_D / LINE_C;
    let slope = (line - 1.0) * (line + 1.0) / ((line_F - line_C) * (line_F + line_C));
    // Dispersions beyond 30, far outside real glass, would take red below vacuum's index.
    return max(ior + (ior - 1.0) * (0.05 * dispersion) * slope, min(ior, 1.0));
}
