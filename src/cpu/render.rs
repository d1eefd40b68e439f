//! The loop over pixels and samples around the estimator of `cpu::path`, and the pixel filter.

use super::camera::{camera_at, camera_ray};
use super::estimator::{DIMENSION_LENS, DIMENSION_PIXEL, clamp_radiance, path_time};
use super::filter::{FILTER_REACH, filter_offset, filter_place, filter_windows};
use super::path::Li;
use super::rng::{next_2d, rng_init};
use super::sample::sample_disk_concentric;
use crate::film::{Film, FilmPixel, Weighted};
use crate::pack::Packed;
use crate::render::{Counts, Progress, Settings};
use glam::{DVec2, DVec3, UVec2};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

/// What a sample of a pixel brings.
#[derive(Clone, Copy)]
struct Sample {
    /// `filter_windows` across and down.
    windows: [[f64; 3]; 2],
    L: DVec3,
    alpha: f64,
}

/// One sample of a pixel: where in the pixel, which ray, what comes along it.
fn pixel_sample(packed: &Packed, pixel: UVec2, sample: u32, counts: &mut Counts) -> Sample {
    let frame = &packed.frame;
    let mut rng = rng_init(pixel, sample, frame.seed);
    rng.dimension = DIMENSION_PIXEL;
    let offset = filter_offset(filter_place(next_2d(&mut rng)));
    let position = pixel.as_ivec2().as_dvec2() + 0.5 + offset;
    let time = path_time(rng);
    let camera = camera_at(&frame.camera, time);
    let mut lens = DVec2::ZERO;
    if camera.lens_radius > 0.0 {
        rng.dimension = DIMENSION_LENS;
        lens = sample_disk_concentric(next_2d(&mut rng));
    }
    let mut ray = camera_ray(&camera, frame.film_size.into(), position, lens);
    ray.time = time;
    let (L, alpha) = Li(packed, ray, &mut rng, counts);
    let windows = [offset.x, offset.y].map(filter_windows);
    Sample { windows, L, alpha }
}

/// Side of the squares in which pixels are gone over: rays that start together find what they meet in the
/// processor's cache.
const BLOCK: u32 = 8;
/// Side of a tile, pixels. Its samples wait in memory until those of all pixels around are there.
const TILE: u32 = 256;
/// No more samples than this wait, if they are of several numbers: 24 MiB.
const WAITING: u32 = 1 << 19;

/// Renders the crop's pixels on the CPU; `progress` is called from one of the threads at a time with the pixel samples
/// that are done.
///
/// The picture does not depend on the number of threads: a pixel's samples are added in order.
pub fn render(
    packed: &Packed,
    settings: &Settings,
    progress: &(dyn Fn(Progress) + Sync),
) -> (Film, Counts) {
    let [x0, y0, width, height] = settings.crop;
    let mut film = Film::new(width, height);
    let mut counts = Counts::default();
    let origins = |size: u32| (0..size).step_by(TILE as usize);
    let tiles: Vec<Tile> = origins(height)
        .flat_map(|y| origins(width).map(move |x| UVec2::new(x, y)))
        .map(|at| Tile {
            at,
            origin: at + UVec2::new(x0, y0),
            size: UVec2::new(width, height).min(at + TILE) - at,
        })
        .collect();
    let samples = settings.samples.len() as u64;
    let total = samples
        * tiles
            .iter()
            .map(|tile| u64::from(tile.sampled()))
            .sum::<u64>();
    let done = AtomicU64::new(0);
    let more_done = |more: u64| {
        let done = done.fetch_add(more, Ordering::Relaxed) + more;
        progress(Progress { done, total });
    };
    for tile in tiles {
        let (pixels, of_tile) = tile.render(packed, settings.samples.clone(), &more_done);
        counts = sum(counts, of_tile);
        for (row, pixels) in (0..).zip(pixels.chunks(tile.size.x as usize)) {
            let start = ((tile.at.y + row) * width + tile.at.x) as usize;
            film.pixels[start..start + pixels.len()].copy_from_slice(pixels);
        }
    }
    (film, counts)
}

/// A part of the picture.
struct Tile {
    /// In the crop, pixels.
    at: UVec2,
    /// In the picture.
    origin: UVec2,
    size: UVec2,
}

/// All samples of the numbers in work, of the pixels of a block, by pixel.
type Block = Vec<Sample>;

impl Tile {
    /// Pixels whose samples count: the tile's and a frame around it.
    fn sampled_size(&self) -> UVec2 {
        self.size + 2 * FILTER_REACH
    }

    fn sampled(&self) -> u32 {
        self.sampled_size().element_product()
    }

    /// Columns and rows of blocks.
    fn blocks(&self) -> UVec2 {
        (self.sampled_size() + (BLOCK - 1)) / BLOCK
    }

    /// All samples; `done` is told of so many more, in all `sampled` of each number.
    fn render(
        &self,
        packed: &Packed,
        samples: Range<u32>,
        done: &(dyn Fn(u64) + Sync),
    ) -> (Vec<FilmPixel>, Counts) {
        let mut counts = Counts::default();
        let mut cells = vec![(Weighted::default(), 0); self.size.element_product() as usize];
        let at_once = (WAITING / self.sampled()).max(1);
        for start in samples.clone().step_by(at_once as usize) {
            let numbers = start..samples.end.min(start.saturating_add(at_once));
            let blocks: Vec<(Block, Counts)> = (0..self.blocks().element_product())
                .into_par_iter()
                .map(|index| {
                    let block = self.block(packed, index, numbers.clone());
                    done(block.0.len() as u64);
                    block
                })
                .collect();
            counts = blocks
                .iter()
                .fold(counts, |counts, block| sum(counts, block.1));
            cells.par_iter_mut().enumerate().for_each(|(index, cell)| {
                let pixel = UVec2::new(index as u32 % self.size.x, index as u32 / self.size.x);
                self.gather(&blocks, pixel, numbers.len(), cell);
            });
        }
        let pixels = cells.iter().map(|(cell, samples)| cell.pixel(*samples));
        (pixels.collect(), counts)
    }

    /// Corner of a block from the corner of what is sampled, and its size: the last of a row or column may be smaller.
    fn block_place(&self, index: u32) -> (UVec2, UVec2) {
        let columns = self.blocks().x;
        let corner = BLOCK * UVec2::new(index % columns, index / columns);
        (
            corner,
            (self.sampled_size() - corner).min(UVec2::splat(BLOCK)),
        )
    }

    fn block(&self, packed: &Packed, index: u32, numbers: Range<u32>) -> (Block, Counts) {
        let mut counts = Counts::default();
        let (corner, size) = self.block_place(index);
        let in_tile = |place: UVec2| {
            let tile = place.wrapping_sub(UVec2::splat(FILTER_REACH));
            tile.cmplt(self.size).all()
        };
        let mut block = Vec::with_capacity(size.element_product() as usize * numbers.len());
        for y in 0..size.y {
            for x in 0..size.x {
                // Beyond the picture's upper and left edges numbers wrap, as in the kernels.
                let reach = UVec2::splat(FILTER_REACH);
                let pixel = (self.origin + corner + UVec2::new(x, y)).wrapping_sub(reach);
                let is_in_tile = in_tile(corner + UVec2::new(x, y));
                for number in numbers.clone() {
                    let mut sample = pixel_sample(packed, pixel, number, &mut counts);
                    let clamped = clamp_radiance(sample.L, f64::from(packed.frame.clamp));
                    if is_in_tile && sample.L.is_finite() && clamped != sample.L {
                        counts.clamped_samples += 1;
                    }
                    sample.L = clamped;
                    block.push(sample);
                }
            }
        }
        (block, counts)
    }

    /// Adds to a pixel of the tile the samples that count for it, and to the number of its own.
    fn gather(
        &self,
        blocks: &[(Block, Counts)],
        pixel: UVec2,
        numbers: usize,
        (cell, samples): &mut (Weighted, u32),
    ) {
        // By place in what is sampled.
        let of = |place: UVec2| {
            let block = place / BLOCK;
            let index = block.y * self.blocks().x + block.x;
            let (corner, size) = self.block_place(index);
            let within = place - corner;
            let first = (within.y * size.x + within.x) as usize * numbers;
            &blocks[index as usize].0[first..first + numbers]
        };
        let near: [&[Sample]; 9] =
            std::array::from_fn(|i| of(pixel + UVec2::new(i as u32 % 3, i as u32 / 3)));
        for number in 0..numbers {
            for (i, of_pixel) in near.iter().enumerate() {
                let Sample { windows, L, alpha } = of_pixel[number];
                let is_own = i == 4;
                if !L.is_finite() {
                    cell.non_finite += u32::from(is_own);
                    continue;
                }
                *samples += u32::from(is_own);
                cell.add(windows[0][i % 3] * windows[1][i / 3], L.to_array(), alpha);
            }
        }
    }
}

fn sum(a: Counts, b: Counts) -> Counts {
    Counts {
        closest_rays: a.closest_rays + b.closest_rays,
        shadow_rays: a.shadow_rays + b.shadow_rays,
        clamped_samples: a.clamped_samples + b.clamped_samples,
    }
}
