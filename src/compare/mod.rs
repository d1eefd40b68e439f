//! When are two pictures the same? By relative error where both took the same samples, and by
//! statistics where they did not.

pub mod map;
pub mod statistics;

use crate::cpu::filter::FILTER_OVERLAP;
use crate::film::{Film, FilmPixel};
use statistics::{p_value_student, sidak};

/// How many of the worst pixels a verdict names.
const WORST: usize = 8;

/// A pixel that differs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelDifference {
    pub x: u32,
    pub y: u32,
    pub a: [f64; 3],
    pub b: [f64; 3],
    /// `relative_within`: largest relative error of a channel. `z_test`: largest abs(z).
    pub size: f64,
}

/// What `relative_within` finds.
#[must_use]
#[derive(Clone, Debug)]
pub struct Within {
    /// The share of pixels whose three channels agree.
    pub fraction: f64,
    /// Worst first.
    pub worst: Vec<PixelDifference>,
}

/// Compares means pixel by pixel: abs(a - b) <= tolerance * max(abs(a), abs(b), floor). A pixel that
/// is not finite on either side does not agree.
///
/// # Panics
/// If the films differ in size.
pub fn relative_within(a: &Film, b: &Film, tolerance: f64, floor: f64) -> Within {
    let mut agree = 0usize;
    let worst = worst_of(a, b, |i| {
        let (ma, mb) = (a.pixels[i].mean(), b.pixels[i].mean());
        let size = (0..3)
            .map(|c| {
                let scale = ma[c].abs().max(mb[c].abs()).max(floor);
                let error = (ma[c] - mb[c]).abs() / scale;
                if ma[c] == mb[c] {
                    0.0
                } else if error.is_finite() {
                    error
                } else {
                    f64::INFINITY
                }
            })
            .fold(0.0, f64::max);
        agree += usize::from(size <= tolerance);
        (size > tolerance).then_some(size)
    });
    Within {
        fraction: agree as f64 / a.pixels.len().max(1) as f64,
        worst,
    }
}

/// What `z_test` finds. Probabilities are those of a difference at least as large by chance alone.
#[must_use]
#[derive(Clone, Debug)]
pub struct Verdict {
    /// Nothing differs at the level asked for.
    pub same: bool,
    /// Pixels whose mean differs at the corrected level.
    pub rejected: usize,
    pub pixels: usize,
    /// The level that each pixel's channel was tested at.
    pub alpha_pixel: f64,
    /// Smallest p-value of any pixel and channel: the corrected level at which the test would pass.
    pub p_pixel: f64,
    /// The level that each of the six pictures' averages below was tested at.
    pub alpha_average: f64,
    /// p-value of the average difference of the means over all pixels, by channel.
    pub p_mean: [f64; 3],
    /// p-value of the average difference of the sample variances over all pixels, by channel.
    pub p_variance: [f64; 3],
    /// Worst first.
    pub worst: Vec<PixelDifference>,
}

/// Tests whether two films are estimates of one picture, with a chance of `alpha` to say no to two
/// that are. Half of alpha goes to the pixels' means, each tested on its own with Sidak's correction;
/// half to the averages over the picture of the differences of means and of variances, which see a
/// small bias that no single pixel shows.
///
/// A pixel's variance is pooled from both films: what is compared is one estimator, and a rare bright
/// sample that only one film met must widen the interval of both. (Sidak 1967, "Rectangular
/// Confidence Regions for the Means of Multivariate Normal Distributions"; Student 1908.)
///
/// # Panics
/// If the films differ in size.
pub fn z_test(a: &Film, b: &Film, alpha: f64) -> Verdict {
    let pixels = a.pixels.len();
    let alpha_pixel = sidak(alpha / 2.0, 3 * pixels);
    let alpha_average = sidak(alpha / 2.0, 6);
    let (mut rejected, mut p_pixel) = (0usize, 1.0f64);
    let worst = worst_of(a, b, |i| {
        let tests: [(f64, f64); 3] = std::array::from_fn(|c| pixel_test(a, b, i, c));
        let p = tests.iter().fold(1.0f64, |p, t| p.min(t.1));
        p_pixel = p_pixel.min(p);
        rejected += usize::from(p < alpha_pixel);
        (p < alpha_pixel).then(|| tests.iter().fold(0.0, |z: f64, t| z.max(t.0.abs())))
    });
    let p_mean = std::array::from_fn(|c| {
        let mean = |pixel: &FilmPixel| pixel.mean()[c];
        average_test(a, b, mean, mean)
    });
    // A variance is a difference of sums of squares, and is rounded as they are.
    let p_variance = std::array::from_fn(|c| {
        average_test(
            a,
            b,
            |pixel| pixel.sample_variance()[c],
            |pixel| pixel.mean_square()[c],
        )
    });
    let averages_same = p_mean
        .iter()
        .chain(&p_variance)
        .all(|&p| p >= alpha_average);
    Verdict {
        same: rejected == 0 && averages_same,
        rejected,
        pixels,
        alpha_pixel,
        p_pixel,
        alpha_average,
        p_mean,
        p_variance,
        worst,
    }
}

/// The relative difference between one radiance summed in float32 and in float64, in another order:
/// a difference below it is no evidence.
const ROUNDING: f64 = 1e-5;

/// Student's t statistic and its p-value for the means of one pixel's channel.
fn pixel_test(a: &Film, b: &Film, i: usize, c: usize) -> (f64, f64) {
    let (pa, pb) = (&a.pixels[i], &b.pixels[i]);
    let (ma, mb) = (pa.mean()[c], pb.mean()[c]);
    let (na, nb) = (f64::from(pa.samples), f64::from(pb.samples));
    // Below the root of what float32 can hold a sample's square is zero, and there is no variance to tell by.
    let rounding = ROUNDING * ma.abs().max(mb.abs()) + f64::from(f32::MIN_POSITIVE).sqrt();
    if (ma - mb).abs() <= rounding || (na == 0.0 && nb == 0.0) {
        return (0.0, 1.0);
    }
    let freedom = na + nb - 2.0;
    if na < 2.0 || nb < 2.0 {
        // One film has nothing to compare with; a lone sample has no variance to tell by.
        return if na == 0.0 || nb == 0.0 {
            (f64::INFINITY, 0.0)
        } else {
            (0.0, 1.0)
        };
    }
    let (va, vb) = (pa.sample_variance()[c], pb.sample_variance()[c]);
    let pooled = ((na - 1.0) * va + (nb - 1.0) * vb) / freedom;
    let z = (ma - mb) / (pooled * (1.0 / na + 1.0 / nb)).sqrt();
    (z, p_value_student(z, freedom))
}

/// The p-value of the differences' average over the picture being zero. Their own spread and what neighbours share
/// say how far the average may be from zero, whatever the number of samples and the shape of their
/// distribution. `scale` is what rounding is relative to.
fn average_test(
    a: &Film,
    b: &Film,
    value: impl Fn(&FilmPixel) -> f64,
    scale: impl Fn(&FilmPixel) -> f64,
) -> f64 {
    let pairs = || a.pixels.iter().zip(&b.pixels);
    let differences: Vec<f64> = pairs()
        .map(|(pa, pb)| value(pa) - value(pb))
        .filter(|d| d.is_finite())
        .collect();
    let scale: f64 = pairs()
        .map(|(pa, pb)| scale(pa).max(scale(pb)))
        .filter(|s| s.is_finite())
        .sum::<f64>()
        / differences.len() as f64;
    let n = differences.len() as f64;
    if n < 2.0 {
        return 1.0;
    }
    let average = differences.iter().sum::<f64>() / n;
    let spread = differences
        .iter()
        .map(|d| (d - average).powi(2))
        .sum::<f64>()
        / (n - 1.0);
    if average.abs() <= ROUNDING * scale {
        return 1.0;
    }
    p_value_student(average / (FILTER_OVERLAP * spread / n).sqrt(), n - 1.0)
}

/// Runs over all pixels and keeps the largest of the sizes that `differs` returns.
fn worst_of(
    a: &Film,
    b: &Film,
    mut differs: impl FnMut(usize) -> Option<f64>,
) -> Vec<PixelDifference> {
    assert_eq!(
        (a.width, a.height),
        (b.width, b.height),
        "films of one size"
    );
    let mut found: Vec<(f64, usize)> = (0..a.pixels.len())
        .filter_map(|i| differs(i).map(|size| (size, i)))
        .collect();
    found.sort_by(|x, y| y.0.total_cmp(&x.0).then(x.1.cmp(&y.1)));
    found.truncate(WORST);
    let width = a.width as usize;
    found
        .into_iter()
        .map(|(size, i)| PixelDifference {
            x: (i % width) as u32,
            y: (i / width) as u32,
            a: a.pixels[i].mean(),
            b: b.pixels[i].mean(),
            size,
        })
        .collect()
}
