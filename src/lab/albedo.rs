//! Directional albedo by sampling: the mean of f |cos theta_i| / pdf.

use super::{Answer, Input, Lab, LabError, Stage};
use glam::DVec3;

/// Samples taken at a time, so that memory is bounded.
const CHUNK: u64 = 65_536;

/// The share of the light from `input.wo` that leaves the surface, with its standard error.
/// Transmission is of radiance, so what passes into a denser medium counts 1 / eta^2.
pub fn albedo(lab: &Lab, input: &Input, samples: u64) -> Result<Answer, LabError> {
    let mut sum = DVec3::ZERO;
    let mut sum_squares = DVec3::ZERO;
    let mut first = 0;
    while first < samples {
        let count = CHUNK.min(samples - first);
        let inputs: Vec<Input> = (first..first + count)
            .map(|index| Input {
                u: DVec3::from_array([0, 1, 2].map(|axis| uniform(3 * index + axis))),
                ..*input
            })
            .collect();
        for output in lab.run(Stage::Sample, &inputs)? {
            if output.pdf != 0.0 {
                let weight = output.f * (output.wi.z.abs() / output.pdf);
                sum += weight;
                sum_squares += weight * weight;
            }
        }
        first += count;
    }
    let n = samples as f64;
    let mean = sum / n;
    let variance = ((sum_squares / n - mean * mean) * (n / (n - 1.0))).max(DVec3::ZERO);
    Ok(Answer::Albedo {
        albedo: mean.to_array(),
        stderr: (variance / n).map(f64::sqrt).to_array(),
    })
}

/// Number `index` of an independent uniform stream in [0, 1), a multiple of 2^-24.
fn uniform(index: u64) -> f64 {
    // Steele, Lea and Flood 2014, "Fast Splittable Pseudorandom Number Generators", figure 15.
    let z = (index + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 40) as f64 / (1u64 << 24) as f64
}
