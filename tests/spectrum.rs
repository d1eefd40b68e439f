//! The observer, wavelengths drawn for it, and indices that depend on them.
#![allow(non_snake_case, reason = "Fraunhofer's lines are called C, d and F")]

mod common;
mod queries;

use glam::DVec3;
use queries::{Inputs, compare, on_lavapipe, relative, within};
use snell::cpu::spectrum::*;
use snell::spectrum;

#[test]
fn parity() {
    let queries = Inputs::new(31).queries(|inputs, q| {
        q.bsdf.roughness = match inputs.pick(16) {
            0 => 0.0,
            _ => inputs.range(380.0, 780.0),
        };
        // Index and dispersion.
        q.bsdf.alpha = [
            inputs.range(1.0, 3.0),
            match inputs.pick(4) {
                0 => 0.0,
                1 => inputs.range(0.0, 60.0),
                _ => inputs.unit(),
            },
        ];
    });
    let gpu = on_lavapipe(
        "import package::spectrum::{color_matching, sample_wavelength, wavelength_pdf, wavelength_weight, ior_at};",
        "let response = color_matching(q.bsdf.roughness);
         let weight = wavelength_weight(q.bsdf.roughness);",
        &[
            "response.x",
            "response.z",
            "sample_wavelength(q.u.x)",
            "wavelength_pdf(q.bsdf.roughness)",
            "weight.x",
            "weight.y",
            "weight.z",
            "ior_at(q.bsdf.alpha.x, q.bsdf.alpha.y, q.bsdf.roughness)",
        ],
        &queries,
    );
    compare(
        "spectrum",
        &[
            // Through 0 where a wavelength's colour leaves Rec. 709.
            within("color_matching.x", 1e-4),
            within("color_matching.z", 1e-4),
            relative("sample_wavelength"),
            relative("wavelength_pdf"),
            within("wavelength_weight.x", 0.05),
            within("wavelength_weight.y", 0.05),
            within("wavelength_weight.z", 0.05),
            relative("ior_at"),
        ],
        &queries,
        &gpu,
        |q| {
            let response = color_matching(q.bsdf.roughness);
            let weight = wavelength_weight(q.bsdf.roughness);
            vec![
                response.x,
                response.z,
                sample_wavelength(q.u.x),
                wavelength_pdf(q.bsdf.roughness),
                weight.x,
                weight.y,
                weight.z,
                ior_at(q.bsdf.alpha.x, q.bsdf.alpha.y, q.bsdf.roughness),
            ]
        },
        |_, _| true,
    );
}

/// The closed form against the standard observer's printed table (CIE 015:2018, "Colorimetry", table of
/// the CIE 1931 colour-matching functions).
#[test]
fn the_observer_is_the_standard_one() {
    let table = [
        (400.0, [0.014_31, 0.000_396, 0.067_85]),
        (450.0, [0.336_20, 0.038_00, 1.772_11]),
        (500.0, [0.004_90, 0.323_00, 0.272_00]),
        (550.0, [0.433_45, 0.994_95, 0.008_75]),
        (555.0, [0.512_05, 1.000_00, 0.005_75]),
        (600.0, [1.062_20, 0.631_00, 0.000_80]),
        (650.0, [0.283_50, 0.107_00, 0.000_00]),
        (700.0, [0.011_36, 0.004_10, 0.000_00]),
    ];
    let mut worst = 0.0_f64;
    for (wavelength, want) in table {
        let gap = spectrum::xyz(wavelength) - DVec3::from(want);
        worst = worst.max(gap.abs().max_element());
    }
    println!("off by at most {worst:.4}");
    assert!(worst < 0.03, "off by {worst}");
}

#[test]
fn a_flat_spectrum_is_white() {
    let white: DVec3 = spectrum::wavelengths(400)
        .map(|(wavelength, weight)| weight * spectrum::color_matching(wavelength))
        .sum();
    assert!((white - 1.0).abs().max_element() < 1e-6, "{white}");
    // The tails left out.
    let tail: DVec3 = (0..380)
        .chain(780..900)
        .map(|nm| spectrum::xyz(f64::from(nm) + 0.5))
        .sum();
    let whole: DVec3 = (0..900).map(|nm| spectrum::xyz(f64::from(nm) + 0.5)).sum();
    assert!((tail / whole).max_element() < 1.5e-3, "{}", tail / whole);
}

/// Light of one primary of ITU-R BT.709 (1.3, by chromaticity) has that channel alone, and its white has
/// all three in the same proportion that makes it up.
#[test]
fn channels_are_those_of_rec_709() {
    let of = |x: f64, y: f64| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
    let response = |xyz: DVec3| {
        // Through spectra only: three wavelengths span all colours.
        let (a, b, c) = (450.0, 540.0, 620.0);
        let basis = glam::DMat3::from_cols(spectrum::xyz(a), spectrum::xyz(b), spectrum::xyz(c));
        let colors = glam::DMat3::from_cols(
            spectrum::color_matching(a),
            spectrum::color_matching(b),
            spectrum::color_matching(c),
        );
        colors * (basis.inverse() * xyz)
    };
    for (channel, (x, y)) in [(0.64, 0.33), (0.30, 0.60), (0.15, 0.06)]
        .into_iter()
        .enumerate()
    {
        let rgb = response(of(x, y));
        let others = DVec3::select(
            glam::BVec3::from(std::array::from_fn::<_, 3, _>(|i| i == channel)),
            DVec3::ZERO,
            rgb,
        );
        assert!(rgb[channel] > 0.0);
        assert!(others.abs().max_element() < 1e-9 * rgb[channel], "{rgb}");
    }
    // D65 against the equal-energy white, which is what the channels are normalised by; the closed
    // form's X, Y and Z have integrals that differ by 0.2 %.
    let (d65, flat) = (response(of(0.3127, 0.3290)), response(DVec3::ONE));
    assert!((flat / flat.x - 1.0).abs().max_element() < 1e-2, "{flat}");
    let want = DVec3::new(1.0 / 1.2048, 1.0 / 0.9484, 1.0 / 0.9088);
    assert!(
        (d65 / flat.x - want).abs().max_element() < 1e-2,
        "{}",
        d65 / flat.x
    );
}

#[test]
fn wavelengths_follow_their_density() {
    const DRAWS: usize = 1_000_000;
    const BINS: usize = 40;
    let mut drawn = [0.0; BINS];
    let mut mean = DVec3::ZERO;
    let mut squares = DVec3::ZERO;
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for i in 0..DRAWS {
        let wavelength = sample_wavelength((i as f64 + 0.5) / DRAWS as f64);
        assert!((WAVELENGTH_MIN..=WAVELENGTH_MAX).contains(&wavelength));
        drawn[(((wavelength - 380.0) / 10.0) as usize).min(BINS - 1)] += 1.0 / DRAWS as f64;
        let weight = wavelength_weight(wavelength);
        mean += weight / DRAWS as f64;
        squares += weight * weight / DRAWS as f64;
        low = low.min(weight.min_element());
        high = high.max(weight.max_element());
    }
    for (bin, share) in drawn.into_iter().enumerate() {
        let want: f64 = (0..200)
            .map(|i| 0.05 * wavelength_pdf(380.0 + 10.0 * bin as f64 + 0.05 * (f64::from(i) + 0.5)))
            .sum();
        assert!((share - want).abs() < 1e-4, "bin {bin}: {share} {want}");
    }
    println!("weights {low:.3} to {high:.3}, variances {}", squares - 1.0);
    assert!((mean - 1.0).abs().max_element() < 1e-4, "mean {mean}");
    assert!(low > -1.9 && high < 4.0, "{low} {high}");
    assert!((squares - 1.0).element_sum() < 8.95, "{squares}");
    assert_eq!(wavelength_weight(0.0), DVec3::ONE);
}

/// Two glasses' indices at the lines d, F, C and their Abbe numbers: N-BK7 and SF10 (Schott 2023, "Optical
/// Glass").
#[test]
fn indices_are_those_of_glass() {
    for (n_d, n_F, n_C, V_d) in [
        (1.51680, 1.52238, 1.51432, 64.17),
        (1.72825, 1.74648, 1.72085, 28.41),
    ] {
        let ior = |wavelength| ior_at(n_d, 20.0 / V_d, wavelength);
        assert_eq!(ior(LINE_D), n_d);
        let abbe = (n_d - 1.0) / (ior(LINE_F) - ior(LINE_C));
        assert!((abbe / V_d - 1.0).abs() < 1e-9, "{abbe}");
        // Two terms of Cauchy's series bend a little less than the glass does.
        assert!(
            (ior(LINE_F) - n_F).abs() < 0.04 * (n_F - n_C),
            "{}",
            ior(LINE_F)
        );
        assert!(
            (ior(LINE_C) - n_C).abs() < 0.04 * (n_F - n_C),
            "{}",
            ior(LINE_C)
        );
    }
}

#[test]
fn without_dispersion_nothing_changes() {
    for ior in [1.0, 1.333_f64, 1.5, 2.42] {
        assert_eq!(ior_at(ior, 0.0, 450.0).to_bits(), ior.to_bits());
        assert_eq!(ior_at(ior, 0.5, 0.0).to_bits(), ior.to_bits());
        assert!(ior_at(ior, 100.0, 780.0) >= 1.0);
    }
    assert_eq!(ior_at(1.0, 1.0, 450.0), 1.0);
}
