//! The reflection laboratory: the reflection functions by themselves, on an adapter through
//! `kernels/bsdf_lab` or in float64 on the CPU. Behind `snell bsdf` and the statistical tests.

mod albedo;
mod gpu;
pub mod material;
pub mod query;

use crate::cpu;
use crate::gpu::device::{Fault, Gpu};
use crate::gpu::kernel::KernelError;
use crate::gpu::link::{Linked, link};
use crate::shared::{self, LabAnswer, LabQuery, Tables};
use crate::tables::tables;
use glam::DVec3;
use query::{Kind, Query};
use rayon::prelude::*;
use serde::Serialize;

#[derive(Debug, thiserror::Error)]
pub enum LabError {
    #[error(transparent)]
    Kernel(#[from] KernelError),
    #[error(
        "the device failed while it evaluated reflection functions: {0:?}; try again, or --cpu"
    )]
    Device(Fault),
}

/// Where queries are answered.
pub enum Lab {
    /// In float64.
    Cpu(Box<Tables>),
    Gpu(Box<gpu::GpuLab>),
}

/// One of the kernel's entry points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    Fresnel,
    Eval,
    Sample,
}

/// What goes into a stage: directions in the local frame, unit length, away from the surface.
#[derive(Clone, Copy, Debug)]
pub struct Input {
    pub bsdf: shared::Bsdf,
    pub wo: DVec3,
    pub wi: DVec3,
    /// x chooses the lobe, y and z the direction; each in [0, 1).
    pub u: DVec3,
    pub cos_theta: f64,
}

/// What comes out of a stage: `f` without the cosine (F of the Fresnel stage), `pdf` per solid angle,
/// or the discrete probability where `delta`. A pdf of 0 is "no sample".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output {
    pub wi: DVec3,
    pub f: DVec3,
    pub pdf: f64,
    pub delta: bool,
}

/// The answer to a query, as it is printed.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Answer {
    Fresnel {
        #[serde(rename = "F")]
        f: [f64; 3],
    },
    Eval {
        f: [f64; 3],
        pdf: f64,
    },
    Sample {
        wi: [f64; 3],
        f: [f64; 3],
        pdf: f64,
        delta: bool,
    },
    Albedo {
        albedo: [f64; 3],
        /// Standard error of each channel.
        stderr: [f64; 3],
    },
}

impl Lab {
    pub fn cpu() -> Self {
        Self::Cpu(tables())
    }

    pub fn gpu(gpu: Gpu) -> Result<Self, LabError> {
        let linked = link("kernels/bsdf_lab").map_err(KernelError::from)?;
        Ok(Self::gpu_linked(gpu, linked))
    }

    /// With the kernel changed, for tests that break it on purpose.
    pub fn gpu_linked(gpu: Gpu, linked: Linked) -> Self {
        Self::Gpu(Box::new(gpu::GpuLab::new(gpu, linked)))
    }

    /// One output for each input, in order.
    pub fn run(&self, stage: Stage, inputs: &[Input]) -> Result<Vec<Output>, LabError> {
        match self {
            Self::Cpu(tables) => Ok(inputs
                .par_iter()
                .map(|input| run_on_cpu(tables, stage, input))
                .collect()),
            Self::Gpu(lab) => lab.run(stage, inputs),
        }
    }

    /// The answers to queries of any kinds, in order; queries of a kind go to the device together.
    pub fn answer(&self, queries: &[Query]) -> Result<Vec<Answer>, LabError> {
        let mut answers: Vec<Option<Answer>> = vec![None; queries.len()];
        for kind in [Kind::Fresnel, Kind::Eval, Kind::Sample] {
            let chosen: Vec<usize> = (0..queries.len())
                .filter(|&i| queries[i].kind == kind)
                .collect();
            let inputs: Vec<Input> = chosen.iter().map(|&i| queries[i].input).collect();
            let stage = match kind {
                Kind::Fresnel => Stage::Fresnel,
                Kind::Eval => Stage::Eval,
                Kind::Sample | Kind::Albedo => Stage::Sample,
            };
            for (&i, output) in chosen.iter().zip(self.run(stage, &inputs)?) {
                answers[i] = Some(match stage {
                    Stage::Fresnel => Answer::Fresnel {
                        f: output.f.to_array(),
                    },
                    Stage::Eval => Answer::Eval {
                        f: output.f.to_array(),
                        pdf: output.pdf,
                    },
                    Stage::Sample => Answer::Sample {
                        wi: output.wi.to_array(),
                        f: output.f.to_array(),
                        pdf: output.pdf,
                        delta: output.delta,
                    },
                });
            }
        }
        queries
            .iter()
            .zip(answers)
            .map(|(query, answer)| match answer {
                Some(answer) => Ok(answer),
                None => albedo::albedo(self, &query.input, query.samples),
            })
            .collect()
    }
}

impl Answer {
    /// False where a reflection function has failed: JSON has no such numbers.
    pub fn is_finite(&self) -> bool {
        let all = |values: &[f64]| values.iter().all(|value| value.is_finite());
        match self {
            Self::Fresnel { f } => all(f),
            Self::Eval { f, pdf } => all(f) && pdf.is_finite(),
            Self::Sample { wi, f, pdf, .. } => all(wi) && all(f) && pdf.is_finite(),
            Self::Albedo { albedo, stderr } => all(albedo) && all(stderr),
        }
    }
}

fn run_on_cpu(tables: &Tables, stage: Stage, input: &Input) -> Output {
    let bsdf = cpu::bsdf::Bsdf::from(&input.bsdf);
    let mut output = Output {
        wi: input.wi,
        f: DVec3::ZERO,
        pdf: 0.0,
        delta: false,
    };
    match stage {
        Stage::Fresnel => output.f = cpu::bsdf::fresnel::fresnel_F(&bsdf, input.cos_theta),
        Stage::Eval => {
            let eval = cpu::bsdf::bsdf::bsdf_eval(tables, &bsdf, input.wo, input.wi);
            (output.f, output.pdf) = (eval.f, eval.pdf);
        }
        Stage::Sample => {
            let sample = cpu::bsdf::bsdf::bsdf_sample(tables, &bsdf, input.wo, input.u);
            (output.wi, output.f, output.pdf) = (sample.wi, sample.f, sample.pdf);
            output.delta = sample.delta != 0;
        }
    }
    output
}

impl From<&Input> for LabQuery {
    fn from(input: &Input) -> Self {
        Self {
            bsdf: input.bsdf,
            wo: input.wo.as_vec3().to_array(),
            cos_theta: input.cos_theta as f32,
            wi: input.wi.as_vec3().to_array(),
            reserved: 0,
            // Rounding must not reach 1.
            u: input
                .u
                .as_vec3()
                .min(glam::Vec3::splat(1.0 - f32::EPSILON / 2.0))
                .to_array(),
            reserved1: 0,
        }
    }
}

impl From<&LabAnswer> for Output {
    fn from(answer: &LabAnswer) -> Self {
        Self {
            wi: DVec3::from_array(answer.wi.map(f64::from)),
            f: DVec3::from_array(answer.f.map(f64::from)),
            pdf: f64::from(answer.pdf),
            delta: answer.delta != 0,
        }
    }
}
