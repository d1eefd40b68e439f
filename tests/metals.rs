//! Metals by name: their spectra, their colours, and the index per channel that stands for them.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]
#![allow(non_snake_case, reason = "the letters of the functions under test")]

use glam::DVec3;
use snell::cpu::bsdf::fresnel::F_conductor;
use snell::scene::metals::{METALS, Metal, metal};

#[test]
fn spectra_are_complete_and_have_sources() {
    assert!(METALS.len() >= 14);
    assert!(METALS.is_sorted_by(|a, b| a.symbol < b.symbol));
    for entry in &METALS {
        assert_eq!(metal(entry.symbol), Some(entry));
        let symbol = entry.symbol;
        assert!((10..=25).contains(&entry.samples.len()), "{symbol}");
        assert!(
            entry.samples.is_sorted_by(|a, b| a[0] < b[0]),
            "{symbol} is out of order"
        );
        assert!(
            entry.samples.iter().flatten().all(|&value| value > 0.0),
            "{symbol}"
        );
        // Niobium's starts at 400 nm; beyond the ends there is hardly any response.
        let ends = (entry.samples[0][0], entry.samples.last().unwrap()[0]);
        assert!(ends.0 <= 400.0 && ends.1 >= 780.0, "{symbol}: {ends:?}");
        let gap = entry.samples.windows(2).map(|w| w[1][0] - w[0][0]);
        // Mercury was measured every 0.2 eV.
        assert!(gap.clone().fold(0.0, f64::max) < 115.0, "{symbol}");
        assert!(entry.source.contains(" 19") || entry.source.contains(" 20"));
        assert!(entry.source.matches('"').count() == 2, "{}", entry.source);
    }
    assert_eq!(metal("unobtainium"), None);
}

#[test]
fn samples_are_met_and_joined() {
    for entry in &METALS {
        for pair in entry.samples.windows(2) {
            let [eta, k] = entry.at(pair[0][0]);
            assert!((eta - pair[0][1]).abs() < 1e-9 && (k - pair[0][2]).abs() < 1e-9);
            let [eta, k] = entry.at(0.5 * (pair[0][0] + pair[1][0]));
            assert!((eta - 0.5 * (pair[0][1] + pair[1][1])).abs() < 1e-9);
            assert!((k - 0.5 * (pair[0][2] + pair[1][2])).abs() < 1e-9);
        }
        let (first, last) = (entry.samples[0], entry.samples.last().unwrap());
        assert_eq!(entry.at(0.0), [first[1], first[2]]);
        assert_eq!(entry.at(2000.0), [last[1], last[2]]);
    }
}

fn conductor(eta: [f64; 3], k: [f64; 3], cos: f64) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|i| F_conductor(cos, eta[i], k[i])))
}

/// The largest error of each channel over angles from 0 to 85 degrees.
fn error(entry: &Metal, eta: [f64; 3], k: [f64; 3]) -> DVec3 {
    (0..=85).fold(DVec3::ZERO, |worst, degrees| {
        let cos = f64::from(degrees).to_radians().cos();
        worst.max((conductor(eta, k, cos) - entry.reflectance(cos).min(DVec3::ONE)).abs())
    })
}

#[test]
fn the_index_of_a_channel_reflects_as_the_spectrum_does() {
    for entry in &METALS {
        let [eta, k] = entry.index().map(|channels| channels.map(f64::from));
        let [mean_eta, mean_k] = entry.mean_index().map(|v| v.to_array());
        let (fitted, mean) = (error(entry, eta, k), error(entry, mean_eta, mean_k));
        println!(
            "{:2} R0 {:.3} fit {fitted:.5} mean {mean:.5} eta {eta:.3?} k {k:.3?}",
            entry.symbol,
            entry.reflectance(1.0)
        );
        let limit = match entry.symbol {
            "Au" => 0.015,
            "Cu" => 2e-3,
            _ => 5e-4,
        };
        assert!(fitted.max_element() < limit, "{}: {fitted}", entry.symbol);
        assert!(fitted.max_element() <= mean.max_element());
    }
}

/// Colours in wide use, linear Rec. 709 (S. Lagarde 2011, "Feeding a physically based shading model",
/// table of metals). Those of silver, iron, nickel and titanium stem from other measurements.
#[test]
fn colours_are_those_one_knows() {
    let known = [
        ("Ag", [0.972, 0.960, 0.915], 0.07),
        ("Al", [0.913, 0.921, 0.925], 0.01),
        ("Au", [1.000, 0.766, 0.336], 0.04),
        ("Co", [0.662, 0.655, 0.634], 0.03),
        ("Cr", [0.549, 0.556, 0.554], 0.01),
        ("Cu", [0.955, 0.637, 0.538], 0.05),
        ("Fe", [0.560, 0.570, 0.580], 0.10),
        ("Ni", [0.660, 0.609, 0.526], 0.04),
        ("Pt", [0.672, 0.637, 0.585], 0.01),
        ("Ti", [0.542, 0.497, 0.449], 0.10),
    ];
    for (symbol, want, tolerance) in known {
        let [eta, k] = metal(symbol).unwrap().index().map(|v| v.map(f64::from));
        let got = conductor(eta, k, 1.0);
        assert!(
            (got - DVec3::from(want)).abs().max_element() < tolerance,
            "{symbol}: {got:.3} for {want:?}"
        );
    }
    let color = |symbol| metal(symbol).unwrap().reflectance(1.0);
    assert!(color("Ag").min_element() > 0.95);
    let (Au, Cu) = (color("Au"), color("Cu"));
    assert!(Au.x > Au.y && Au.y > 2.0 * Au.z, "gold is yellow: {Au}");
    assert!(Cu.x > 1.3 * Cu.y && Cu.y > Cu.z, "copper is red: {Cu}");
}

/// The schema of models offers the metals that there are.
#[test]
fn the_schema_lists_them() {
    let text = include_str!("../schema/bsdf.schema.json");
    let schema: serde_json::Value = serde_json::from_str(text).unwrap();
    let listed = &schema["$defs"]["conductor"]["oneOf"][0]["properties"]["metal"]["enum"];
    let known: Vec<_> = METALS.iter().map(|metal| metal.symbol).collect();
    assert_eq!(*listed, serde_json::json!(known));
}
