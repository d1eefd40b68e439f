//! Compares a rendered film with a closed form.

use snell::cpu::filter::FILTER_OVERLAP;
use snell::film::Film;
use statrs::distribution::{ContinuousCDF, Normal};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// What the closed form says of a point of the picture: in which part of it the point lies, and its
/// radiance. Only pixels whose filter lies in one part are compared.
pub type Seen = Option<(u32, [f64; 3])>;

/// The chance that a right picture is refused, all its groups of pixels together.
const ALPHA: f64 = 1e-3;
/// What float32 may do to the average of a group of pixels.
const ROUNDING: f64 = 1e-4;
/// Parts of the picture are also tested in tiles of this many pixels each way, ...
const TILE: u32 = 16;
/// ... if they have this many pixels, so that their mean is nearly normal.
const MIN_PIXELS: u32 = 64;
/// Points of the midpoint rule along each axis of the pixel filter.
const FILTER_POINTS: u32 = 9;
/// Pixels, as the renderer's.
const FILTER_RADIUS: f64 = 1.5;

/// The four-term window of Blackman and Harris on [-1, 1] (Harris 1978), not normalised.
fn blackman_harris(x: f64) -> f64 {
    0.35875
        + 0.48829 * (PI * x).cos()
        + 0.14128 * (2.0 * PI * x).cos()
        + 0.01168 * (3.0 * PI * x).cos()
}

/// The closed form seen through the pixel filter. `seen` takes the picture's point, -1 to 1 each way,
/// y up.
fn filtered(film: &Film, column: u32, row: u32, seen: &dyn Fn(f64, f64) -> Seen) -> Seen {
    let offsets =
        (0..FILTER_POINTS).map(|i| 2.0 * (f64::from(i) + 0.5) / f64::from(FILTER_POINTS) - 1.0);
    let taps: Vec<(f64, f64)> = offsets
        .map(|o| (FILTER_RADIUS * o, blackman_harris(o)))
        .collect();
    let (mut part, mut sum, mut weights) = (None, [0.0; 3], 0.0);
    for (dy, wy) in &taps {
        for (dx, wx) in &taps {
            let x = 2.0 * (f64::from(column) + 0.5 + dx) / f64::from(film.width) - 1.0;
            let y = 1.0 - 2.0 * (f64::from(row) + 0.5 + dy) / f64::from(film.height);
            let (here, radiance) = seen(x, y)?;
            if *part.get_or_insert(here) != here {
                return None;
            }
            for c in 0..3 {
                sum[c] += wx * wy * radiance[c];
            }
            weights += wx * wy;
        }
    }
    part.map(|part| (part, sum.map(|s| s / weights)))
}

#[derive(Default)]
struct Group {
    pixels: u32,
    expected: [f64; 3],
    difference: [f64; 3],
    variance: [f64; 3],
}

/// What a comparison was able to see.
pub struct Power {
    pub pixels: u32,
    pub groups: usize,
    /// The largest standard error of a whole part's mean, over its radiance.
    pub standard_error: f64,
    /// The largest difference of a whole part's mean from the closed form, over its radiance.
    pub difference: f64,
}

/// Asserts that each part of the picture, and each tile of it, has the closed form's mean radiance,
/// by a z-test with Sidak's correction.
pub fn check(what: &str, film: &Film, seen: &dyn Fn(f64, f64) -> Seen) -> Power {
    assert_eq!(film.non_finite(), 0, "{what}: samples that are not finite");
    let mut groups: BTreeMap<(u32, Option<(u32, u32)>), Group> = BTreeMap::new();
    for row in 0..film.height {
        for column in 0..film.width {
            let Some((part, expected)) = filtered(film, column, row, seen) else {
                continue;
            };
            let pixel = film.pixel(column, row);
            let (mean, variance) = (pixel.mean(), pixel.variance());
            for tile in [None, Some((column / TILE, row / TILE))] {
                let group = groups.entry((part, tile)).or_default();
                group.pixels += 1;
                for c in 0..3 {
                    group.expected[c] += expected[c];
                    group.difference[c] += mean[c] - expected[c];
                    group.variance[c] += variance[c];
                }
            }
        }
    }
    groups.retain(|_, group| group.pixels >= MIN_PIXELS);
    let normal = Normal::new(0.0, 1.0).unwrap();
    let tests = 3.0 * groups.len() as f64;
    let level = -(-ALPHA).ln_1p() / tests;
    let z_limit = -normal.inverse_cdf(0.5 * level);
    let mut power = Power {
        pixels: 0,
        groups: groups.len(),
        standard_error: 0.0,
        difference: 0.0,
    };
    let mut failures = Vec::new();
    for ((part, tile), group) in &groups {
        for c in 0..3 {
            let error = (FILTER_OVERLAP * group.variance[c]).sqrt();
            let allowed = z_limit * error + ROUNDING * group.expected[c];
            // NaN is not within.
            let within = group.difference[c].abs() <= allowed;
            if !within {
                failures.push(format!(
                    "part {part}, tile {tile:?}, {} pixels, channel {c}: {:.6} instead of {:.6}, {:.6} allowed",
                    group.pixels,
                    (group.expected[c] + group.difference[c]) / f64::from(group.pixels),
                    group.expected[c] / f64::from(group.pixels),
                    allowed / f64::from(group.pixels),
                ));
            }
            if tile.is_none() && group.expected[c] > 0.0 {
                let relative = |x: f64| x.abs() / group.expected[c];
                power.standard_error = power.standard_error.max(relative(error));
                power.difference = power.difference.max(relative(group.difference[c]));
            }
        }
        if tile.is_none() {
            power.pixels += group.pixels;
        }
    }
    assert!(power.pixels > 0, "{what}: nothing was compared");
    assert!(
        failures.is_empty(),
        "{what}: {} of {} groups differ from the closed form:\n{}",
        failures.len(),
        groups.len(),
        failures[..failures.len().min(12)].join("\n")
    );
    println!(
        "{what}: {} pixels in {} groups; parts differ by at most {:.2e}, standard errors are at most {:.2e}",
        power.pixels, power.groups, power.difference, power.standard_error
    );
    power
}
