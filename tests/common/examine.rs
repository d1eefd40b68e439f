//! One lobe at one angle: sampled, integrated, and compared.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

use crate::chi2::Partition;
use crate::common::statistics::chi_square_p;
use crate::lobes::{Lobe, direction, uniforms};
use glam::DVec3;
use snell::lab::{Input, Lab, Stage};
use std::fmt::Write;

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
pub fn examine(lab: &Lab, lobe: &Lobe, degrees: f64, seed: u64) -> (f64, String) {
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
                let received = output.f * (output.wi.z.abs() * scale);
                [output.pdf, received.x, received.y, received.z]
            })
            .collect()
    });
    let mass: f64 = integrals.iter().map(|integral| integral[0]).sum();
    let albedo = (1..4)
        .map(|channel| integrals.iter().map(|integral| integral[channel]).sum())
        .fold(0.0, f64::max);
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
    (chi_square_p(&observed, &expected), faults)
}
