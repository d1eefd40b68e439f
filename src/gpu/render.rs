//! Renders a packed scene on an adapter: tiles of the picture, each through all its samples.

use super::device::{Fault, Gpu};
use super::kernel::{Kernel, KernelError};
use super::upload::{Scene, UploadError};
use super::variant::Variants;
use super::wavefront::{FilmCell, STAGES, Wavefront, kernels};
use crate::cpu::filter::FILTER_REACH;
use crate::film::{Film, FilmPixel, Weighted};
use crate::pack::Packed;
use crate::pack::outline::Outline;
use crate::render::{Counts, Progress, Settings};
use crate::shared::Frame;
use std::ops::Range;
use std::time::{Duration, Instant};
use thiserror::Error;

/// Side of a tile in pixels. A tile's film stays on the device until all its samples are in.
const TILE: u32 = 256;
/// Paths of the first dispatch, whose time says how many the next ones may have: a sample of a whole tile. Software
/// has no watchdog that would end a long one, and begins with `MOST_PATHS`.
const FIRST_PATHS: u32 = (TILE + 2 * FILTER_REACH).pow(2);
/// No more paths than this at a time: 53 MiB of state.
const MOST_PATHS: u32 = 4 * FIRST_PATHS;
/// No more samples of a pixel than this at a time: `accumulate` adds them and their neighbours in loops, and Mesa up
/// to 22.3 ends all loops of an invocation after 65 536 rounds in all.
const MOST_SAMPLES: u32 = 1 << 12;
/// A submission is to stay within these, well under the two seconds of common GPU watchdogs and
/// long enough that waiting for the device costs nothing.
const SHORT: Duration = Duration::from_millis(120);
const LONG: Duration = Duration::from_millis(500);

/// What a render leaves besides its film.
#[derive(Clone, Copy, Debug, Default)]
pub struct Statistics {
    pub counts: Counts,
    /// Sending the scene to the device.
    pub upload: Duration,
    /// Linking, validating and compiling; a software adapter compiles at the first dispatch instead.
    pub compile: Duration,
    pub render: Duration,
    /// The longest submission (a whole batch of paths through all its bounces).
    pub longest_submission: Duration,
    pub submissions: u64,
}

#[derive(Debug, Error)]
pub enum RenderError {
    #[error(transparent)]
    Upload(#[from] UploadError),
    #[error(transparent)]
    Kernel(#[from] KernelError),
    #[error("the device was lost while rendering ({0}); try again, or use --cpu")]
    Lost(String),
    #[error("the device ran out of memory while rendering ({0}); use --cpu or a smaller picture")]
    OutOfMemory(String),
    #[error("the device failed while rendering: {0}")]
    Failed(String),
}

impl From<Fault> for RenderError {
    fn from(fault: Fault) -> Self {
        match fault {
            Fault::Lost(message) => Self::Lost(message),
            Fault::OutOfMemory(message) => Self::OutOfMemory(message),
            Fault::Other(message) => Self::Failed(message),
        }
    }
}

/// Renders the crop; `progress` counts pixel samples.
///
/// The picture does not depend on how samples fall into dispatches, which follows measured times:
/// each pixel's samples are added one after another in the order of their numbers. A device that is
/// lost is opened again once for each tile, and the tile rendered anew.
pub fn render(
    gpu: &mut Gpu,
    packed: &Packed,
    settings: &Settings,
    progress: &mut dyn FnMut(Progress),
) -> Result<(Film, Statistics), RenderError> {
    let first = match gpu.info.device_type {
        wgpu::DeviceType::Cpu => MOST_PATHS,
        _ => FIRST_PATHS,
    };
    render_in_batches(gpu, packed, settings, first..MOST_PATHS, progress)
}

/// `render` with the number of paths of the first dispatch, and the most of any.
pub fn render_in_batches(
    gpu: &mut Gpu,
    packed: &Packed,
    settings: &Settings,
    paths: Range<u32>,
    progress: &mut dyn FnMut(Progress),
) -> Result<(Film, Statistics), RenderError> {
    let mut statistics = Statistics::default();
    let wavefront = prepare(gpu, packed, settings, paths.end, &mut statistics)?;
    let start = Instant::now();
    let [_, _, width, height] = settings.crop;
    let samples = settings.samples.len() as u32;
    let mut film = Film::new(width, height);
    let mut work = Work {
        gpu,
        wavefront,
        packed,
        settings,
        paths: paths.start,
        most_paths: paths.end,
        done: 0,
        total: u64::from(width) * u64::from(height) * u64::from(samples),
        statistics,
        progress,
    };
    for tile in tiles(settings.crop) {
        let [x, y, ..] = tile;
        for (index, cell) in (0..).zip(&work.tile_or_again(tile)?) {
            let (column, row) = (index % tile[2], index / tile[2]);
            *film.pixel_mut(x + column, y + row) = film_pixel(cell, samples);
        }
    }
    let mut statistics = work.statistics;
    statistics.render = start.elapsed();
    Ok((film, statistics))
}

/// x, y, width, height in the crop, row by row.
fn tiles([_, _, width, height]: [u32; 4]) -> impl Iterator<Item = [u32; 4]> {
    let steps = |size: u32| (0..size).step_by(TILE as usize);
    steps(height).flat_map(move |y| {
        steps(width).map(move |x| [x, y, TILE.min(width - x), TILE.min(height - y)])
    })
}

/// Pixels whose samples count for a tile of this size: its own and a frame around it.
pub fn sampled_pixels([width, height]: [u32; 2]) -> u32 {
    (width + 2 * FILTER_REACH) * (height + 2 * FILTER_REACH)
}

/// A part of a tile's samples, from number `sample` on.
fn part(
    packed: &Packed,
    settings: &Settings,
    [x, y, width, height]: [u32; 4],
    sample: u32,
    sample_count: u32,
) -> Frame {
    Frame {
        tile_origin: [settings.crop[0] + x, settings.crop[1] + y],
        tile_size: [width, height],
        first_sample: sample,
        sample_count,
        capacity: sampled_pixels([width, height]) * sample_count,
        ..packed.frame
    }
}

/// Renders the crop so many times over with each dispatch waited for by itself, and throws the films
/// away: the time of each of the wavefront's `STAGES`, for each time over.
pub fn time_stages(
    gpu: &Gpu,
    packed: &Packed,
    settings: &Settings,
    repetitions: usize,
) -> Result<Vec<[Duration; STAGES.len()]>, RenderError> {
    let wavefront = prepare(
        gpu,
        packed,
        settings,
        MOST_PATHS,
        &mut Statistics::default(),
    )?;
    let once = |_| {
        let mut sums = [Duration::ZERO; STAGES.len()];
        for tile in tiles(settings.crop) {
            let most = wavefront.capacity / sampled_pixels([tile[2], tile[3]]);
            let most = most.clamp(1, MOST_SAMPLES);
            let Range { start, end } = settings.samples;
            for sample in (start..end).step_by(most as usize) {
                let frame = part(packed, settings, tile, sample, most.min(end - sample));
                let times = wavefront.run_timed(gpu, &frame, sample == start)?;
                for (sum, time) in sums.iter_mut().zip(times) {
                    *sum += time;
                }
            }
        }
        Ok(sums)
    };
    (0..repetitions).map(once).collect()
}

/// Uploads the scene and compiles the kernels.
fn prepare(
    gpu: &Gpu,
    packed: &Packed,
    settings: &Settings,
    most_paths: u32,
    statistics: &mut Statistics,
) -> Result<Wavefront, RenderError> {
    let start = Instant::now();
    let scene = Scene::upload(gpu, packed)?;
    statistics.upload += start.elapsed();
    let start = Instant::now();
    let [_, _, width, height] = settings.crop;
    let [width, height] = [width.min(TILE), height.min(TILE)];
    let sampled = u64::from(sampled_pixels([width, height]));
    let most = u64::from(most_paths).min(Wavefront::largest_capacity(gpu));
    let capacity = (sampled * settings.samples.len() as u64)
        .min(most)
        // At least one sample of a whole tile.
        .max(sampled);
    let more = [scene.constants(), gpu.constants()].concat();
    let variants = Variants::of(&Outline::of(packed), &more);
    let wavefront = Wavefront::new(gpu, scene, &variants, capacity as u32, width * height)?;
    if let Some(fault) = gpu.take_fault() {
        return Err(fault.into());
    }
    statistics.compile += start.elapsed();
    Ok(wavefront)
}

/// Compiles the kernels of a scene that is still being packed. Where the scene turns out otherwise, those that it
/// needs are compiled when it is rendered.
pub fn compile_ahead(gpu: &Gpu, outline: &Outline) -> Result<(), KernelError> {
    let variants = Variants::of(outline, &gpu.constants());
    let compile = || Kernel::compile(gpu, &kernels(&variants));
    // Threads of its own: packing would wait for those that all share until they have compiled.
    match rayon::ThreadPoolBuilder::new().build() {
        Ok(pool) => pool.install(compile),
        Err(_) => compile(),
    }
}

/// A render under way.
struct Work<'a> {
    gpu: &'a mut Gpu,
    wavefront: Wavefront,
    packed: &'a Packed,
    settings: &'a Settings,
    /// How many the next dispatch gets.
    paths: u32,
    most_paths: u32,
    /// Pixel samples.
    done: u64,
    total: u64,
    statistics: Statistics,
    progress: &'a mut dyn FnMut(Progress),
}

impl Work<'_> {
    /// All samples of a tile; if the device is lost on the way, once more on a new one.
    fn tile_or_again(&mut self, tile: [u32; 4]) -> Result<Vec<FilmCell>, RenderError> {
        let (done, counts) = (self.done, self.statistics.counts);
        match self.tile(tile) {
            Err(Fault::Lost(message)) => {
                log::warn!("the device was lost ({message}); opening it again");
                self.gpu.reopen().map_err(|_| RenderError::Lost(message))?;
                self.wavefront = prepare(
                    self.gpu,
                    self.packed,
                    self.settings,
                    self.most_paths,
                    &mut self.statistics,
                )?;
                self.done = done;
                self.statistics.counts = counts;
                Ok(self.tile(tile)?)
            }
            other => Ok(other?),
        }
    }

    /// All samples of a tile: x, y, width, height in the crop.
    fn tile(&mut self, tile: [u32; 4]) -> Result<Vec<FilmCell>, Fault> {
        let pixels = tile[2] * tile[3];
        let sampled = sampled_pixels([tile[2], tile[3]]);
        let mut sample = self.settings.samples.start;
        while sample < self.settings.samples.end {
            let sample_count = (self.paths.min(self.wavefront.capacity) / sampled)
                .clamp(1, MOST_SAMPLES.min(self.settings.samples.end - sample));
            let frame = part(self.packed, self.settings, tile, sample, sample_count);
            let start = Instant::now();
            let first = sample == self.settings.samples.start;
            let counts = self.wavefront.run(self.gpu, &frame, first)?;
            self.count(counts, frame.capacity, start.elapsed());
            sample += sample_count;
            self.done += u64::from(pixels) * u64::from(sample_count);
            (self.progress)(Progress {
                done: self.done,
                total: self.total,
            });
        }
        self.wavefront.read_film(self.gpu, pixels)
    }

    /// Takes down what a submission did, and sizes the next by it.
    fn count(&mut self, counts: Counts, paths: u32, elapsed: Duration) {
        let statistics = &mut self.statistics;
        statistics.counts.closest_rays += counts.closest_rays;
        statistics.counts.shadow_rays += counts.shadow_rays;
        statistics.counts.clamped_samples += counts.clamped_samples;
        // The first one holds a software adapter's compilation and says little.
        if statistics.submissions > 0 {
            statistics.longest_submission = statistics.longest_submission.max(elapsed);
            self.paths = next_paths(self.paths, paths, elapsed).min(self.most_paths);
        }
        statistics.submissions += 1;
    }
}

/// How many paths the next dispatch may have, when one with `ran` of them took `elapsed`.
fn next_paths(paths: u32, ran: u32, elapsed: Duration) -> u32 {
    if elapsed > LONG {
        (ran / 2).max(1)
    } else if elapsed < SHORT && ran >= paths / 2 {
        paths.saturating_mul(2)
    } else {
        paths
    }
}

/// The device's float32 sums in the host's terms; what rounding dropped is put back.
fn film_pixel(cell: &FilmCell, samples: u32) -> FilmPixel {
    let sum = |c: usize| f64::from(cell.sum[c]) - f64::from(cell.lost[c]);
    Weighted {
        weight: f64::from(cell.weight) - f64::from(cell.weight_lost),
        weight_squares: cell.weight_squares.into(),
        sum: [sum(0), sum(1), sum(2)],
        squares: cell.squares.map(f64::from),
        alpha: sum(3),
        non_finite: cell.non_finite,
    }
    .pixel(samples - cell.non_finite)
}
