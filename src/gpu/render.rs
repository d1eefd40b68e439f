//! Renders a packed scene on an adapter: tiles of the picture, each through all its samples.

use super::device::{Fault, Gpu};
use super::kernel::KernelError;
use super::upload::{Scene, UploadError};
use super::wavefront::{FilmCell, Wavefront};
use crate::film::{Film, FilmPixel};
use crate::pack::Packed;
use crate::render::{Progress, RayCount, Settings};
use crate::shared::Frame;
use std::time::{Duration, Instant};
use thiserror::Error;

/// Side of a tile in pixels. A tile's film stays on the device until all its samples are in.
const TILE: u32 = 128;
/// Paths of the first dispatch, whose time says how many the next ones may have.
const FIRST_PATHS: u32 = TILE * TILE;
/// No more paths than this at a time: 80 MiB of state.
const MOST_PATHS: u32 = 1 << 19;
/// A submission is to stay within these, well under the two seconds of common GPU watchdogs and
/// long enough that waiting for the device costs nothing.
const SHORT: Duration = Duration::from_millis(120);
const LONG: Duration = Duration::from_millis(500);

/// What a render leaves besides its film.
#[derive(Clone, Copy, Debug, Default)]
pub struct Statistics {
    pub rays: RayCount,
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
/// each pixel's samples are added one after another in the order of their numbers.
pub fn render(
    gpu: &Gpu,
    packed: &Packed,
    settings: &Settings,
    progress: &mut dyn FnMut(Progress),
) -> Result<(Film, Statistics), RenderError> {
    let mut statistics = Statistics::default();
    let start = Instant::now();
    let scene = Scene::upload(gpu, packed)?;
    statistics.upload = start.elapsed();

    let start = Instant::now();
    let [x0, y0, width, height] = settings.crop;
    let most = u64::from(MOST_PATHS).min(Wavefront::largest_capacity(gpu)) as u32;
    let wanted = u64::from(width.min(TILE) * height.min(TILE))
        * u64::from(settings.samples.end - settings.samples.start);
    // At least one sample of a whole tile.
    let capacity = (wanted.min(u64::from(most)) as u32).max(width.min(TILE) * height.min(TILE));
    let wavefront = Wavefront::new(gpu, scene, capacity, TILE * TILE)?;
    gpu.take_fault()
        .map_or(Ok(()), |fault| Err(RenderError::from(fault)))?;
    statistics.compile = start.elapsed();

    let start = Instant::now();
    let mut film = Film::new(width, height);
    let total = u64::from(width)
        * u64::from(height)
        * u64::from(settings.samples.end - settings.samples.start);
    let mut done = 0;
    let mut paths = FIRST_PATHS;
    for tile_y in (0..height).step_by(TILE as usize) {
        for tile_x in (0..width).step_by(TILE as usize) {
            let tile_size = [TILE.min(width - tile_x), TILE.min(height - tile_y)];
            let pixels = tile_size[0] * tile_size[1];
            let mut sample = settings.samples.start;
            while sample < settings.samples.end {
                let sample_count = (paths.min(wavefront.capacity) / pixels)
                    .clamp(1, settings.samples.end - sample);
                let frame = Frame {
                    tile_origin: [x0 + tile_x, y0 + tile_y],
                    tile_size,
                    first_sample: sample,
                    sample_count,
                    capacity: pixels * sample_count,
                    ..packed.frame
                };
                let submitted = Instant::now();
                let rays = wavefront.run(gpu, &frame, sample == settings.samples.start)?;
                let elapsed = submitted.elapsed();
                statistics.rays.closest += rays.closest;
                statistics.rays.shadow += rays.shadow;
                // The first one holds a software adapter's compilation and says little.
                if statistics.submissions > 0 {
                    statistics.longest_submission = statistics.longest_submission.max(elapsed);
                    paths = next_paths(paths, frame.capacity, elapsed);
                }
                statistics.submissions += 1;
                sample += sample_count;
                done += u64::from(pixels) * u64::from(sample_count);
                progress(Progress { done, total });
            }
            let samples = settings.samples.end - settings.samples.start;
            for (index, cell) in wavefront.read_film(gpu, pixels)?.iter().enumerate() {
                let index = index as u32;
                let (x, y) = (index % tile_size[0], index / tile_size[0]);
                *film.pixel_mut(tile_x + x, tile_y + y) = film_pixel(cell, samples);
            }
        }
    }
    statistics.render = start.elapsed();
    Ok((film, statistics))
}

/// How many paths the next dispatch may have, when one with `ran` of them took `elapsed`.
fn next_paths(paths: u32, ran: u32, elapsed: Duration) -> u32 {
    if elapsed > LONG {
        (ran / 2).max(1)
    } else if elapsed < SHORT && ran >= paths / 2 {
        paths.saturating_mul(2).min(MOST_PATHS)
    } else {
        paths
    }
}

/// The device's float32 sums in the host's terms; what rounding dropped is put back.
fn film_pixel(cell: &FilmCell, samples: u32) -> FilmPixel {
    let sum = |c: usize| f64::from(cell.sum[c]) - f64::from(cell.lost[c]);
    FilmPixel {
        sum: [sum(0), sum(1), sum(2)],
        alpha: sum(3),
        sum_sq: cell.squares.map(f64::from),
        samples: samples - cell.non_finite,
        non_finite: cell.non_finite,
    }
}
