//! From linear radiance to display-linear colour in [0, 1]: what happens before the sRGB curve.

use clap::ValueEnum;

/// How unbounded radiance becomes a displayable colour.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Tonemap {
    /// Clips at 1.
    Linear,
    /// Khronos PBR Neutral: keeps base colours as they are and compresses highlights only.
    #[default]
    Neutral,
    /// ACES filmic, as fitted by Stephen Hill to the reference and output device transforms.
    Aces,
    /// AgX, as fitted by Benjamin Wrensch to Troy Sobotka's.
    Agx,
}

impl Tonemap {
    /// As spelled on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Tonemap::Linear => "linear",
            Tonemap::Neutral => "neutral",
            Tonemap::Aces => "aces",
            Tonemap::Agx => "agx",
        }
    }

    /// Display-linear Rec. 709 in [0, 1]. Negative or undefined input shows as black (the film has
    /// counted it), infinite input as white.
    pub fn apply(self, rgb: [f64; 3]) -> [f64; 3] {
        /// Beyond this a curve has long reached white; keeps infinities out of quotients.
        const BRIGHTEST: f64 = 1e12;
        let rgb = rgb.map(|x| {
            if x > 0.0 { x.min(BRIGHTEST) } else { 0.0 } // NaN compares false
        });
        let mapped = match self {
            Tonemap::Linear => rgb,
            Tonemap::Neutral => neutral(rgb),
            Tonemap::Aces => aces(rgb),
            Tonemap::Agx => agx(rgb),
        };
        mapped.map(|x| x.clamp(0.0, 1.0))
    }
}

/// Khronos Group 2024, "Khronos PBR Neutral Tone Mapper" (specification, section "Definition").
fn neutral(rgb: [f64; 3]) -> [f64; 3] {
    const F90: f64 = 0.04; // Fresnel reflection of a dielectric, taken off as an offset
    const COMPRESSION_START: f64 = 0.8 - F90;
    const DESATURATION: f64 = 0.15;
    let darkest = rgb[0].min(rgb[1]).min(rgb[2]);
    let offset = if darkest < 2.0 * F90 {
        darkest - darkest * darkest / (4.0 * F90)
    } else {
        F90
    };
    let rgb = rgb.map(|x| x - offset);
    let peak = rgb[0].max(rgb[1]).max(rgb[2]);
    if peak < COMPRESSION_START {
        return rgb;
    }
    let room = 1.0 - COMPRESSION_START;
    let new_peak = 1.0 - room * room / (peak + room - COMPRESSION_START);
    let keep = 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    rgb.map(|x| new_peak + (x * new_peak / peak - new_peak) * keep)
}

/// Stephen Hill 2016, ACES fit in "BakingLab" (MJP, Hill): the sRGB to RRT matrix, a rational fit of
/// RRT and ODT, and the matrix back to sRGB. No further exposure factor.
fn aces(rgb: [f64; 3]) -> [f64; 3] {
    const TO_RRT: [[f64; 3]; 3] = [
        [0.59719, 0.35458, 0.04823],
        [0.07600, 0.90834, 0.01566],
        [0.02840, 0.13383, 0.83777],
    ];
    const FROM_ODT: [[f64; 3]; 3] = [
        [1.60475, -0.53108, -0.07367],
        [-0.10208, 1.10813, -0.00605],
        [-0.00327, -0.07276, 1.07602],
    ];
    let fitted = multiply(&TO_RRT, rgb)
        .map(|v| (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081));
    multiply(&FROM_ODT, fitted)
}

/// Troy Sobotka's AgX in the form of Benjamin Wrensch 2023, "Minimal AgX Implementation": inset,
/// logarithm over 16.5 stops, a sixth-degree fit of the base contrast, outset, and the 2.2 power that
/// returns to linear light.
fn agx(rgb: [f64; 3]) -> [f64; 3] {
    const INSET: [[f64; 3]; 3] = [
        [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
        [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
        [0.0423756549057051, 0.0784336, 0.879142973793104],
    ];
    const OUTSET: [[f64; 3]; 3] = [
        [1.19687900512017, -0.0980208811401368, -0.0990297440797205],
        [-0.0528968517574562, 1.15190312990417, -0.0989611768448433],
        [-0.0529716355144438, -0.0980434501171241, 1.15107367264116],
    ];
    const DARKEST_EV: f64 = -12.47393;
    const BRIGHTEST_EV: f64 = 4.026069;
    const DISPLAY_EXPONENT: f64 = 2.2;
    /// Coefficients of x^0 ... x^6.
    const CONTRAST: [f64; 7] = [-0.00232, 0.1191, 0.4298, -6.868, 31.96, -40.14, 15.5];
    let encoded = multiply(&INSET, rgb).map(|v| {
        let ev = v.max(f64::MIN_POSITIVE).log2();
        let x = ((ev - DARKEST_EV) / (BRIGHTEST_EV - DARKEST_EV)).clamp(0.0, 1.0);
        CONTRAST.iter().rev().fold(0.0, |sum, c| sum * x + c)
    });
    multiply(&OUTSET, encoded).map(|v| v.max(0.0).powf(DISPLAY_EXPONENT))
}

fn multiply(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// Display-linear [0, 1] to its sRGB code value (IEC 61966-2-1:1999).
pub fn srgb_encode(linear: f64) -> f64 {
    if linear <= 0.0031308 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// The inverse of `srgb_encode`.
pub fn srgb_decode(code: f64) -> f64 {
    if code <= 0.04045 {
        code / 12.92
    } else {
        ((code + 0.055) / 1.055).powf(2.4)
    }
}
