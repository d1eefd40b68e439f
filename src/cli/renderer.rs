//! What renders: an adapter, or the CPU.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use super::render::RenderArgs;
use crate::error::Error;
use crate::film::Film;
use crate::gpu::device::{self, DeviceError, Gpu};
use crate::pack::Packed;
use crate::progress::Progress;
use crate::render::{Counts, Settings};
use crate::report::{self, Times};
use crate::{cpu, gpu};

pub enum Renderer {
    Cpu,
    Gpu(Box<Gpu>),
}

/// A film and how it came to be.
pub struct Rendered {
    pub film: Film,
    pub counts: Counts,
}

impl Renderer {
    /// The adapter, or the CPU where it is asked for or there is no adapter at all.
    pub fn open(args: &RenderArgs) -> Result<Self, Error> {
        if args.cpu {
            return Ok(Self::Cpu);
        }
        match device::open(args.adapter.as_deref()) {
            Ok(mut gpu) => {
                gpu.checked |= args.checked;
                Ok(Self::Gpu(Box::new(gpu)))
            }
            Err(error @ (DeviceError::NoAdapter | DeviceError::BelowDefaults { .. }))
                if args.adapter.is_none() =>
            {
                super::say(&format!("rendering on the CPU: {error}"));
                Ok(Self::Cpu)
            }
            Err(error) => Err(error.into()),
        }
    }

    /// `None` is the CPU.
    pub fn gpu(&self) -> Option<&Gpu> {
        match self {
            Self::Cpu => None,
            Self::Gpu(gpu) => Some(gpu),
        }
    }

    pub fn render(
        &mut self,
        packed: &Packed,
        settings: &Settings,
        progress: &mut Progress,
        times: &mut Times,
    ) -> Result<Rendered, Error> {
        match self {
            Self::Gpu(gpu) => {
                let (film, statistics) = gpu::render::render(gpu, packed, settings, &mut |p| {
                    progress.update(p.done, p.total);
                })?;
                times.upload = Some(report::milliseconds(statistics.upload));
                times.compile = Some(report::milliseconds(statistics.compile));
                times.render = report::milliseconds(statistics.render);
                let counts = statistics.counts;
                Ok(Rendered { film, counts })
            }
            Self::Cpu => {
                let start = Instant::now();
                let shared = Mutex::new(progress);
                let (film, counts) = cpu::path::render(packed, settings, &|p| {
                    let mut progress = shared.lock().unwrap_or_else(PoisonError::into_inner);
                    progress.update(p.done, p.total);
                });
                times.render = report::milliseconds(start.elapsed());
                Ok(Rendered { film, counts })
            }
        }
    }
}
