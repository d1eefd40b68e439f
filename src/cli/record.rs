//! What is said of a render that is done: the record, and the one line.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use super::render::{Job, Rendered};
use super::value::Background;
use crate::error::Error;
use crate::gltf::EnvironmentSource;
use crate::progress::human;
use crate::report::{
    Achieved, Adapter, Facts, Input, LitBy, Memory, Rays, Report, Times, limits_in_use,
    packed_hash, shader_hash,
};

/// The repeatable part.
pub fn facts(job: &Job, rendered: &Rendered) -> Result<Facts, Error> {
    let args = job.args;
    Ok(Facts {
        snell: env!("CARGO_PKG_VERSION"),
        scene: input(&args.scene)?,
        environment: args.env.as_ref().map(lit_by).transpose()?,
        packed_hash: packed_hash(&job.packed),
        shader_hash: shader_hash(),
        adapter: adapter(job),
        limits: job
            .gpu
            .as_ref()
            .map_or_else(BTreeMap::new, |gpu| limits_in_use(&gpu.limits)),
        // None is asked for.
        features: Vec::new(),
        size: args.size,
        crop: job.settings.crop,
        samples: [job.settings.samples.start, job.settings.samples.end],
        seed: args.seed,
        max_depth: args.max_depth,
        clamp: args.clamp,
        clamped_samples: args.clamp.map(|_| rendered.counts.clamped_samples),
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
    })
}

fn adapter(job: &Job) -> Adapter {
    job.gpu
        .as_ref()
        .map_or_else(Adapter::cpu, |gpu| Adapter::gpu(&gpu.info))
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

/// All of it.
pub fn report(job: &Job, facts: Facts, times_ms: Times) -> Report {
    let outputs = job.args.output.iter();
    Report {
        facts,
        times_ms,
        memory: Memory::of(&job.packed),
        outputs: outputs.map(|path| path.display().to_string()).collect(),
        notes: job.loaded.notes.clone(),
    }
}

/// What was rendered, where to, on what, in how long, at what error.
pub fn summary(job: &Job, rendered: &Rendered, elapsed: Duration) -> String {
    let film = &rendered.film;
    let outputs: Vec<String> = job
        .args
        .output
        .iter()
        .map(|path| match path.as_os_str() == "-" {
            true => "standard output".into(),
            false => path.display().to_string(),
        })
        .collect();
    let samples = job.settings.samples.len();
    let error = film.error().map_or_else(String::new, |error| {
        format!(", error {}", percent(error.relative))
    });
    let dropped = match film.non_finite() {
        0 => String::new(),
        bad => format!(", {bad} samples not finite"),
    };
    let clamped = job.args.clamp.map_or_else(String::new, |limit| {
        let samples = rendered.counts.clamped_samples;
        format!(", {samples} samples clamped to {limit}")
    });
    format!(
        "{} -> {}: {}x{}, {samples} {} a pixel, on {}, in {}{error}{dropped}{clamped}",
        job.args.scene.display(),
        outputs.join(", "),
        film.width,
        film.height,
        if samples == 1 { "sample" } else { "samples" },
        adapter(job).name,
        human(elapsed),
    )
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
