//! Every lobe that is no delta, on lavapipe and in float64: what is sampled is what the pdf says, the
//! pdf integrates to one less what is rejected, weights are bounded, and no lobe makes energy.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

#[path = "common/chi2.rs"]
mod chi2;
mod common;
#[path = "common/examine.rs"]
mod examine;
#[path = "common/lobes.rs"]
mod lobes;

use chi2::sidak;
use examine::examine;
use lobes::lobes;
use snell::lab::Lab;
use std::fmt::Write;

/// Of all chi-square tests of a run together.
const SIGNIFICANCE: f64 = 0.01;
fn examine_all(lab: &Lab, roughness: f64, seed: u64) {
    const TESTS: usize = 15 * 4 * 4;
    let threshold = sidak(SIGNIFICANCE, TESTS);
    let mut report = String::new();
    let all = lobes(roughness);
    assert_eq!(all.len() * 16, TESTS, "the correction counts all tests");
    for (i, lobe) in all.iter().enumerate() {
        for (j, degrees) in [0.0, 30.0, 60.0, 85.0].into_iter().enumerate() {
            let (p, faults) = examine(lab, lobe, degrees, seed + (4 * i + j) as u64);
            if p < threshold || !faults.is_empty() {
                writeln!(
                    report,
                    "{} at {degrees} degrees: p = {p:.1e} {faults}",
                    lobe.name
                )
                .unwrap();
            }
        }
    }
    assert!(report.is_empty(), "threshold {threshold:.1e}\n{report}");
}

macro_rules! statistics {
    ($($name:ident: $lab:expr, $roughness:expr, $seed:expr;)*) => {
        $(#[test] fn $name() { examine_all(&$lab, $roughness, $seed); })*
    };
}

fn on_gpu() -> Lab {
    Lab::gpu(common::gpu()).unwrap()
}

statistics! {
    cpu_roughness_5_percent: Lab::cpu(), 0.05, 1000;
    cpu_roughness_10_percent: Lab::cpu(), 0.1, 2000;
    cpu_roughness_50_percent: Lab::cpu(), 0.5, 3000;
    cpu_roughness_100_percent: Lab::cpu(), 1.0, 4000;
    gpu_roughness_5_percent: on_gpu(), 0.05, 5000;
    gpu_roughness_10_percent: on_gpu(), 0.1, 6000;
    gpu_roughness_50_percent: on_gpu(), 0.5, 7000;
    gpu_roughness_100_percent: on_gpu(), 1.0, 8000;
}
