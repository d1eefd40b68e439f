//! Directions to the environment for a surface that faces some of it.

use crate::common;
use crate::common::shapes::Random;
use crate::common::statistics::{assert_p, chi_square_p};
use crate::{COUNT, only_environment, sky};
use glam::{DVec2, DVec3, Vec3};
use snell::cpu::light::environment::*;
use snell::pack::Packed;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::f64::consts::TAU;

/// Answers of `environment_sample_facing` at vec3(u_choice, u).
fn facing_samples_gpu(
    packed: &Packed,
    ns: Vec3,
    transmits: bool,
    us: &[[f32; 3]],
) -> Vec<EnvironmentSample> {
    let root = format!(
        "
import package::light::environment::{{environment_sample_facing}};
@group(3) @binding(0) var<storage, read> us: array<f32>;
@group(3) @binding(1) var<storage, read_write> answers: array<array<f32, 5>>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
    if 3u * id.x >= arrayLength(&us) {{ return; }}
    let u = vec2(us[3u * id.x + 1u], us[3u * id.x + 2u]);
    let s = environment_sample_facing(vec3<f32>({}, {}, {}), {transmits}, us[3u * id.x], u);
    answers[id.x] = array<f32, 5>(s.wi.x, s.wi.y, s.wi.z, s.pdf, s.weight);
}}",
        ns.x, ns.y, ns.z
    );
    let bytes = bytemuck::cast_slice(us);
    let answers = common::run_scene(&root, packed, &[bytes], us.len() * 20, us.len() as u32);
    let answers: Vec<[f32; 5]> = bytemuck::pod_collect_to_vec(&answers);
    let sample = |&[x, y, z, pdf, weight]: &[f32; 5]| EnvironmentSample {
        wi: Vec3::new(x, y, z).as_dvec3(),
        pdf: pdf.into(),
        weight: weight.into(),
    };
    answers.iter().map(sample).collect()
}

/// Of 12 x 6 bins of equal solid angle.
fn bin_of(d: DVec3) -> usize {
    let column = (d.z.atan2(d.x) / TAU + 0.5) * 12.0;
    let row = (0.5 - 0.5 * d.y) * 6.0;
    (row as usize).min(5) * 12 + (column as usize).min(11)
}

/// The chosen of two candidates lies where it should, and its weights bring the irradiance from each part of the
/// sky that the table's density says.
#[test]
fn a_chosen_candidate_stands_for_both() {
    const BINS: usize = 72;
    const PAIRS: u32 = 1 << 20;
    for environment in [sky(37, 19, 500.0), sky(512, 200, 3e4)] {
        let packed = only_environment(&environment);
        // Candidates from points that lie evenly in the square, whatever part of it they are looked for in: by the roots
        // of x^3 = x + 1.
        let pairs: Vec<[DVec3; 2]> = (0..PAIRS)
            .map(|i| {
                let u = (f64::from(i) * DVec2::new(0.754877666246693, 0.569840290998053)).fract();
                [u, (u + 0.5).fract()].map(|u| environment_sample(&packed, u).truncate())
            })
            .collect();
        // The sun is behind the first normal and before the second.
        for (ns, transmits) in [
            (Vec3::new(-0.48, -0.64, 0.6), false),
            (Vec3::new(0.36, 0.48, -0.8), true),
        ] {
            let what = format!("{} texels, {ns}, {transmits}", environment.width);
            let facing = |d: DVec3| {
                let cosine = d.dot(ns.as_dvec3());
                if transmits {
                    cosine.abs()
                } else {
                    cosine.max(0.0)
                }
            };
            // A quadrature may miss what is only just over the horizon.
            let (mut counts, mut brought) = ([1e-3; BINS], [0.0; BINS]);
            let each = COUNT as f64 / f64::from(PAIRS);
            for pair in &pairs {
                let sum = facing(pair[0]) + facing(pair[1]);
                for d in pair.iter().filter(|&&d| facing(d) > 0.0) {
                    counts[bin_of(*d)] += each * facing(*d) / sum;
                }
                brought[bin_of(pair[0])] += each * ENVIRONMENT_CANDIDATES * facing(pair[0]);
            }
            let mut uniform = Random(81);
            let us: Vec<[f32; 3]> = (0..COUNT)
                .map(|_| [uniform.unit(), uniform.unit(), uniform.unit()])
                .collect();
            let cpu = us.iter().map(|u| {
                let [u_choice, x, y] = u.map(f64::from);
                let ns = ns.as_dvec3();
                environment_sample_facing(&packed, ns, transmits, u_choice, DVec2::new(x, y))
            });
            let gpu = facing_samples_gpu(&packed, ns, transmits, &us);
            for samples in [gpu, cpu.collect()] {
                let mut observed = [0.0; BINS];
                let (mut sums, mut squares) = ([0.0; BINS], [0.0; BINS]);
                let mut odd = 0;
                for s in samples.iter().filter(|s| s.pdf > 0.0) {
                    let bin = bin_of(s.wi);
                    let value = s.weight * facing(s.wi);
                    observed[bin] += 1.0;
                    sums[bin] += value;
                    squares[bin] += value * value;
                    let pdf = ENVIRONMENT_CANDIDATES * environment_pdf(&packed, s.wi);
                    odd += usize::from((s.pdf - pdf).abs() > 1e-4 * pdf);
                }
                // Rounding takes a few directions into the cell next door.
                assert!(odd < COUNT / 1000, "{odd} samples state another density");
                assert_p(&what, chi_square_p(&observed, &counts), 16);
                let (mut statistic, mut degrees) = (0.0, 0.0);
                for bin in (0..BINS).filter(|&bin| observed[bin] > 100.0) {
                    let variance = squares[bin] - sums[bin] * sums[bin] / COUNT as f64;
                    statistic += (sums[bin] - brought[bin]).powi(2) / variance;
                    degrees += 1.0;
                }
                assert!(degrees > 20.0);
                let p = 1.0 - ChiSquared::new(degrees).unwrap().cdf(statistic);
                assert_p(&what, p, 16);
            }
        }
    }
}
