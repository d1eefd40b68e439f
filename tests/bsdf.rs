//! Every lobe that is no delta, on lavapipe and in float64: what is sampled is what the pdf says, the
//! pdf integrates to one less what is rejected, weights are bounded, and no lobe makes energy.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

#[path = "common/chi2.rs"]
mod chi2;
mod common;
#[path = "common/lobes.rs"]
mod lobes;

use chi2::{Partition, p_value, sidak};
use glam::DVec3;
use lobes::{Lobe, direction, lobes, uniforms};
use snell::lab::{Input, Lab, Stage};
use std::fmt::Write;

/// Of all chi-square tests of a run together.
const SIGNIFICANCE: f64 = 0.01;
/// Samples that shape the bins, and samples that are counted.
const TRAINING: usize = 8_192;
const COUNTED: usize = 16_384;
/// Training samples in a bin.
const BIN: usize = 128;
/// Of each integral over a cell; there are some hundreds of cells.
const QUADRATURE_TOLERANCE: f64 = 5e-6;
/// What the quadrature and float32 may add to an albedo of one.
const FURNACE_TOLERANCE: f64 = 1e-3;
const WEIGHT_TOLERANCE: f64 = 1e-3;

fn input(lobe: &Lobe, wo: DVec3) -> Input {
    Input {
        bsdf: lobe.bsdf,
        wo,
        wi: DVec3::Z,
        u: DVec3::ZERO,
        cos_theta: 1.0,
    }
}

/// What was drawn.
struct Samples {
    directions: Vec<DVec3>,
    rejected: usize,
    /// Where the density was highest, above the surface and below it.
    peaks: Vec<DVec3>,
}

/// Draws samples; what is wrong with their weights goes to `faults`.
fn sample(
    lab: &Lab,
    lobe: &Lobe,
    wo: DVec3,
    seed: u64,
    count: usize,
    faults: &mut String,
) -> Samples {
    let inputs: Vec<Input> = uniforms(seed, count)
        .into_iter()
        .map(|u| Input {
            u,
            ..input(lobe, wo)
        })
        .collect();
    let outputs = lab.run(Stage::Sample, &inputs).unwrap();
    let mut heaviest = 0.0_f64;
    let mut directions = Vec::with_capacity(count);
    for output in &outputs {
        assert!(!output.delta, "{}: a delta", lobe.name);
        if output.pdf > 0.0 {
            let scale = if output.wi.z < 0.0 {
                lobe.eta().powi(2)
            } else {
                1.0
            };
            let weight = output.f.max_element() * output.wi.z.abs() / output.pdf * scale;
            heaviest = if weight.is_finite() {
                heaviest.max(weight)
            } else {
                f64::INFINITY
            };
            directions.push(output.wi);
        }
    }
    if heaviest > lobe.weight_max * (1.0 + WEIGHT_TOLERANCE) {
        writeln!(faults, "{}: f cos / pdf of {heaviest}", lobe.name).unwrap();
    }
    let peak = |below: bool| {
        let side = outputs
            .iter()
            .filter(|o| o.pdf > 0.0 && (o.wi.z < 0.0) == below);
        side.max_by(|a, b| a.pdf.total_cmp(&b.pdf))
            .map(|output| output.wi)
    };
    Samples {
        rejected: count - directions.len(),
        peaks: [peak(false), peak(true)].into_iter().flatten().collect(),
        directions,
    }
}

/// One lobe at one angle: the chi-square test's p-value, and any other fault in words.
fn examine(lab: &Lab, lobe: &Lobe, degrees: f64, seed: u64) -> (f64, String) {
    let mut faults = String::new();
    let wo = direction(degrees);
    let training = sample(lab, lobe, wo, 2 * seed, TRAINING, &mut faults);
    let counted = sample(lab, lobe, wo, 2 * seed + 1, COUNTED, &mut faults);
    let partition = Partition::new(&training.directions, BIN, &training.peaks);
    let integrals = partition.integrate(QUADRATURE_TOLERANCE, |directions| {
        let inputs: Vec<Input> = directions
            .iter()
            .map(|&wi| Input {
                wi,
                ..input(lobe, wo)
            })
            .collect();
        let outputs = lab.run(Stage::Eval, &inputs).unwrap();
        outputs
            .iter()
            .map(|output| {
                // Energy, not radiance: without the factor that the change of medium brings.
                let scale = if output.wi.z < 0.0 {
                    lobe.eta().powi(2)
                } else {
                    1.0
                };
                [
                    output.pdf,
                    output.f.max_element() * output.wi.z.abs() * scale,
                ]
            })
            .collect()
    });
    let mass: f64 = integrals.iter().map(|integral| integral[0]).sum();
    let albedo: f64 = integrals.iter().map(|integral| integral[1]).sum();
    let n = COUNTED as f64;
    let lost = counted.rejected as f64 / n;
    let deviation = (lost * (1.0 - lost) / n).sqrt();
    if (mass + lost - 1.0).abs() > 5.0 * deviation + 1e-3 {
        writeln!(faults, "pdf integrates to {mass}, and {lost} is rejected").unwrap();
    }
    if !(0.0..=lobe.albedo_max + FURNACE_TOLERANCE).contains(&albedo) {
        writeln!(faults, "reflects {albedo} of what it receives").unwrap();
    }
    let mut observed = vec![0.0; partition.bin_count() + 1];
    for &wi in &counted.directions {
        observed[partition.bin(wi)] += 1.0;
    }
    observed[partition.bin_count()] = counted.rejected as f64;
    let mut expected: Vec<f64> = integrals.iter().map(|integral| n * integral[0]).collect();
    expected.push((n * (1.0 - mass)).max(0.0));
    (p_value(&observed, &expected), faults)
}

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
