//! What is said of a render that is done: the record, and the one line.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use super::render::RenderArgs;
use super::renderer::Rendered;
use super::studio::Job;
use super::value::Background;
use crate::error::Error;
use crate::gltf::EnvironmentSource;
use crate::gpu::device::Gpu;
use crate::output::Place;
use crate::progress::human;
use crate::render::Settings;
use crate::report::{
    Achieved, Adapter, Facts, Input, LitBy, Memory, Moment, Rays, Report, Times, limits_in_use,
    packed_hash, shader_hash,
};

/// The files that a run reads.
pub struct Inputs {
    scene: Input,
    environment: Option<LitBy>,
}

impl Inputs {
    pub fn read(args: &RenderArgs) -> Result<Self, Error> {
        Ok(Self {
            scene: input(&args.scene)?,
            environment: args.env.as_ref().map(lit_by).transpose()?,
        })
    }
}

/// A picture that is done.
pub struct Made<'a> {
    pub args: &'a RenderArgs,
    pub settings: &'a Settings,
    pub moment: Option<Moment>,
    pub gpu: Option<&'a Gpu>,
    pub job: &'a Job,
    pub rendered: &'a Rendered,
}

impl Made<'_> {
    /// The repeatable part.
    pub fn facts(&self, inputs: &Inputs) -> Facts {
        let Made {
            args,
            settings,
            job,
            rendered,
            ..
        } = self;
        Facts {
            snell: env!("CARGO_PKG_VERSION"),
            scene: inputs.scene.clone(),
            environment: inputs.environment.clone(),
            packed_hash: packed_hash(&job.packed),
            shader_hash: shader_hash(),
            adapter: self.adapter(),
            limits: self
                .gpu
                .map_or_else(BTreeMap::new, |gpu| limits_in_use(&gpu.limits)),
            // None is asked for.
            features: Vec::new(),
            size: args.size,
            crop: settings.crop,
            samples: [settings.samples.start, settings.samples.end],
            seed: job.shot.seed,
            max_depth: args.max_depth,
            clamp: args.clamp,
            clamped_samples: args.clamp.map(|_| rendered.counts.clamped_samples),
            moment: self.moment.clone(),
            variant: args.variant.clone(),
            frame: job.shot.frame,
            camera: job.camera_name.clone(),
            background: match args.background {
                Background::Environment => "env".into(),
                Background::Transparent => "transparent".into(),
                Background::Color([r, g, b]) => format!("{r},{g},{b}"),
            },
            exposure_ev: args.exposure,
            tonemap: args.tonemap.name(),
            rays: Some(Rays {
                closest: rendered.counts.closest_rays,
                shadow: rendered.counts.shadow_rays,
            }),
            error: Achieved::of(&rendered.film),
            non_finite_samples: rendered.film.non_finite(),
            extensions: job.loaded.extensions.clone(),
        }
    }

    fn adapter(&self) -> Adapter {
        self.gpu
            .map_or_else(Adapter::cpu, |gpu| Adapter::gpu(&gpu.info))
    }

    /// All of it.
    pub fn report(&self, facts: Facts, times_ms: Times) -> Report {
        let name = |place: &Place| match place {
            Place::Stdout => "-".to_owned(),
            Place::File(path) => path.display().to_string(),
        };
        let targets = self.job.shot.targets.iter();
        Report {
            facts,
            times_ms,
            memory: Memory::of(&self.job.packed),
            outputs: targets.map(|target| name(&target.place)).collect(),
            metadata: self.job.loaded.metadata.clone(),
            notes: self.job.loaded.notes.clone(),
        }
    }

    /// What was rendered, where to, on what, in how long, at what error.
    pub fn summary(&self, elapsed: Duration) -> String {
        let film = &self.rendered.film;
        let targets = self.job.shot.targets.iter();
        let outputs: Vec<String> = targets
            .map(|target| match &target.place {
                Place::Stdout => "standard output".into(),
                Place::File(path) => path.display().to_string(),
            })
            .collect();
        let samples = self.settings.samples.len();
        let error = film.error().map_or_else(String::new, |error| {
            format!(", error {}", percent(error.relative))
        });
        let dropped = match film.non_finite() {
            0 => String::new(),
            bad => format!(", {bad} samples not finite"),
        };
        let clamped = self.args.clamp.map_or_else(String::new, |limit| {
            let samples = self.rendered.counts.clamped_samples;
            format!(", {samples} samples clamped to {limit}")
        });
        format!(
            "{} -> {}: {}x{}, {samples} {} a pixel, on {}, in {}{error}{dropped}{clamped}",
            self.args.scene.display(),
            outputs.join(", "),
            film.width,
            film.height,
            if samples == 1 { "sample" } else { "samples" },
            self.adapter().name,
            human(elapsed),
        )
    }
}

/// What a sequence took.
pub fn sequence_summary(args: &RenderArgs, frames: usize, elapsed: Duration) -> String {
    format!(
        "{}: {frames} {} in {}, {} each",
        args.scene.display(),
        if frames == 1 { "frame" } else { "frames" },
        human(elapsed),
        human(elapsed.div_f64(frames as f64)),
    )
}

fn input(path: &Path) -> Result<Input, Error> {
    match std::fs::read(path) {
        Ok(bytes) => Ok(Input::of(path, &bytes)),
        Err(source) => Err(Error::Input {
            path: path.to_owned(),
            source,
        }),
    }
}

/// A computed environment is told by the text that gives the same again, all of its keys included.
fn lit_by(environment: &EnvironmentSource) -> Result<LitBy, Error> {
    Ok(match environment {
        EnvironmentSource::File(path) => LitBy::File(input(path)?),
        EnvironmentSource::Constant([r, g, b]) => LitBy::Computed(format!("{r},{g},{b}")),
        EnvironmentSource::Sky(sky) => LitBy::Computed(format!(
            "sky:elevation={},azimuth={},turbidity={},albedo={},sun={}",
            sky.elevation,
            sky.azimuth,
            sky.turbidity,
            sky.albedo,
            u8::from(sky.sun)
        )),
    })
}

/// Two digits that count.
fn percent(share: f64) -> String {
    let percent = share * 100.0;
    if percent == 0.0 {
        "0 %".into()
    } else if percent >= 10.0 {
        format!("{percent:.0} %")
    } else {
        let digits = (1.0 - percent.log10().floor()).max(1.0) as usize;
        format!("{percent:.digits$} %")
    }
}
