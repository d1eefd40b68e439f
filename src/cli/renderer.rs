//! What renders: an adapter, or the CPU.

use std::panic::resume_unwind;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::thread::{Scope, ScopedJoinHandle};
use std::time::{Duration, Instant};

use crate::error::Error;
use crate::film::Film;
use crate::gpu::device::{self, DeviceError, Gpu};
use crate::pack::Packed;
use crate::pack::outline::Outline;
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

/// A renderer that is opened while something else goes on, and its kernels compiled once it is known which:
/// drivers take their time. Kernels check their indices if `checked`.
pub struct Opening<'scope> {
    thread: ScopedJoinHandle<'scope, (Result<Gpu, DeviceError>, Meanwhile)>,
    outline: Sender<Outline>,
}

/// What was done beside something else.
#[derive(Clone, Copy, Debug, Default)]
pub struct Meanwhile {
    pub open: Duration,
    /// `None`: nothing was.
    pub compile: Option<Duration>,
}

impl<'scope> Opening<'scope> {
    /// `None` without work to do: the CPU is there.
    pub fn start(
        scope: &'scope Scope<'scope, '_>,
        cpu: bool,
        adapter: Option<&'scope str>,
        checked: bool,
    ) -> Option<Self> {
        let (outline, outlines) = channel();
        let open = move || {
            let start = Instant::now();
            let opened = device::open(adapter).map(|mut gpu| {
                gpu.checked |= checked;
                gpu
            });
            let mut meanwhile = Meanwhile {
                open: start.elapsed(),
                ..Meanwhile::default()
            };
            if let (Ok(gpu), Ok(outline)) = (&opened, outlines.recv()) {
                let start = Instant::now();
                if let Err(fault) = gpu::render::compile_ahead(gpu, &outline) {
                    // It comes up again where it can be said, if these are the scene's kernels.
                    log::debug!("compiling ahead: {fault}");
                }
                meanwhile.compile = Some(start.elapsed());
            }
            (opened, meanwhile)
        };
        (!cpu).then(|| Self {
            thread: scope.spawn(open),
            outline,
        })
    }

    /// Tells what the first picture's scene is like.
    pub fn foresee(&self, outline: Outline) {
        // Nobody listens where the adapter did not open, which `Renderer::wait` says.
        let _ = self.outline.send(outline);
    }
}

impl Renderer {
    /// The adapter, or the CPU where it is asked for or there is no adapter at all; and how long what took.
    pub fn wait(
        opening: Option<Opening<'_>>,
        adapter: Option<&str>,
    ) -> Result<(Self, Meanwhile), Error> {
        let Some(Opening { thread, outline }) = opening else {
            return Ok((Self::Cpu, Meanwhile::default()));
        };
        drop(outline);
        let (opened, meanwhile) = thread.join().unwrap_or_else(|panic| resume_unwind(panic));
        match opened {
            Ok(gpu) => Ok((Self::Gpu(Box::new(gpu)), meanwhile)),
            Err(error @ (DeviceError::NoAdapter | DeviceError::BelowDefaults { .. }))
                if adapter.is_none() =>
            {
                super::say(&format!("rendering on the CPU: {error}"));
                Ok((Self::Cpu, meanwhile))
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
                let ahead = times.compile.unwrap_or(0.0);
                times.compile = Some(ahead + report::milliseconds(statistics.compile));
                times.render = report::milliseconds(statistics.render);
                let counts = statistics.counts;
                Ok(Rendered { film, counts })
            }
            Self::Cpu => {
                let start = Instant::now();
                let shared = Mutex::new(progress);
                let (film, counts) = cpu::render::render(packed, settings, &|p| {
                    let mut progress = shared.lock().unwrap_or_else(PoisonError::into_inner);
                    progress.update(p.done, p.total);
                });
                times.render = report::milliseconds(start.elapsed());
                Ok(Rendered { film, counts })
            }
        }
    }
}
