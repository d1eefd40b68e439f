//! The environment map and the table that samples it (see `shaders/light/environment.wgsl`).

use crate::scene::Environment;
use rayon::prelude::*;
use std::f64::consts::PI;

/// The most cells of the importance table, 17 MB: the density only has to follow the radiance roughly,
/// but the sun of a computed sky is three texels wide, and cells of two texels have three times the
/// variance.
const CELLS_MAX: [u32; 2] = [2048, 1024];

/// The fewest: the sine of the polar angle has to be followed, however small the map is.
const CELLS_MIN: [u32; 2] = [64, 32];

/// Cumulative probabilities are multiples of 1 / 2^24, as the sampler's numbers are, so that a cell
/// is met with exactly the probability that its density is made from.
const PROBABILITY_UNITS: u32 = 1 << 24;

/// An environment map as `Packed` holds it.
#[derive(Clone, Debug)]
pub struct PackedEnvironment {
    pub texels: Vec<[f32; 4]>,
    pub size: [u32; 2],
    /// `cells_size[1]` rows of `cells_size[0] + 1` entries, see `Packed::environment_cells`.
    pub cells: Vec<[f32; 2]>,
    pub cells_size: [u32; 2],
    /// Luminance averaged over all directions, the strength not included; 0: do not sample it.
    pub mean_luminance: f32,
}

/// Packs a map. The density of a cell is the mean, over the cell, of the bilinearly filtered
/// luminance times the mean of sin(theta), so it is positive wherever some of the cell shines.
/// Negative radiance weighs nothing.
pub fn build_environment(environment: &Environment) -> PackedEnvironment {
    let size = [environment.width, environment.height];
    let cells_size = [0, 1].map(|axis| size[axis].clamp(CELLS_MIN[axis], CELLS_MAX[axis]));
    let weights = cell_weights(environment, cells_size);
    let texels = environment.radiance.iter();
    let mut packed = PackedEnvironment {
        texels: texels.map(|&[r, g, b]| [r, g, b, 1.0]).collect(),
        size,
        cells: vec![[1.0, 0.0]; 2],
        cells_size: [1, 1],
        mean_luminance: 0.0,
    };
    let mean = weights.iter().sum::<f64>() / weights.len() as f64;
    // The mean of sin(theta) over the map's area is 2 / pi.
    packed.mean_luminance = (mean * PI / 2.0) as f32;
    if packed.mean_luminance > 0.0 {
        packed.cells = cell_table(&weights, cells_size[0] as usize);
        packed.cells_size = cells_size;
    }
    packed
}

/// The cells' weights by rows: filtered luminance times sin(theta), averaged over each cell.
fn cell_weights(environment: &Environment, [cells_x, cells_y]: [u32; 2]) -> Vec<f64> {
    let (width, height) = (environment.width as usize, environment.height as usize);
    let footprints_x: Vec<_> = (0..cells_x)
        .map(|cell| footprint(cell, cells_x, environment.width))
        .collect();
    // First along the rows of texels ...
    let mut narrowed = vec![0.0; cells_x as usize * height];
    let rows = environment.radiance.par_chunks_exact(width);
    let cells = narrowed.par_chunks_exact_mut(cells_x as usize);
    cells.zip(rows).for_each(|(cells, row)| {
        let luminances: Vec<f64> = row.iter().map(|&texel| luminance(texel)).collect();
        for (cell, footprint) in cells.iter_mut().zip(&footprints_x) {
            let terms = footprint.iter();
            *cell = terms
                .map(|&(x, share)| share * luminances[x.rem_euclid(width as i64) as usize])
                .sum::<f64>();
        }
    });
    // ... then along the columns.
    let mut weights = vec![0.0; (cells_x * cells_y) as usize];
    let rows = weights.par_chunks_exact_mut(cells_x as usize).enumerate();
    rows.for_each(|(cell_y, row)| {
        let edge = |y: usize| (PI * y as f64 / f64::from(cells_y)).cos();
        let mean_sin = (edge(cell_y) - edge(cell_y + 1)) / PI * f64::from(cells_y);
        for (y, share) in footprint(cell_y as u32, cells_y, environment.height) {
            let y = y.clamp(0, height as i64 - 1) as usize;
            let texels = &narrowed[y * cells_x as usize..];
            for (weight, texel) in row.iter_mut().zip(texels) {
                *weight += mean_sin * share * texel;
            }
        }
    });
    weights
}

/// Rec. 709; what is no light (negative, or not a number) counts as none.
fn luminance([r, g, b]: [f32; 3]) -> f64 {
    let value = 0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b);
    if value.is_finite() {
        value.max(0.0)
    } else {
        0.0
    }
}

/// Along one axis: the texels whose linear filter (a hat two texels wide) reaches into a cell,
/// each with the filter's mean over the cell. Indices may lie one beyond the map.
fn footprint(cell: u32, cells: u32, texels: u32) -> Vec<(i64, f64)> {
    let scale = f64::from(texels) / f64::from(cells);
    let (from, to) = (f64::from(cell) * scale, f64::from(cell + 1) * scale);
    // Integral of the hat about 0 up to t.
    let integral = |t: f64| {
        let t = t.clamp(-1.0, 1.0);
        if t < 0.0 {
            0.5 * (1.0 + t) * (1.0 + t)
        } else {
            1.0 - 0.5 * (1.0 - t) * (1.0 - t)
        }
    };
    let first = (from - 0.5).floor() as i64;
    let last = (to + 0.5).ceil() as i64 - 1;
    (first..=last)
        .map(|texel| {
            let centre = texel as f64 + 0.5;
            let share = (integral(to - centre) - integral(from - centre)) / (to - from);
            (texel, share)
        })
        .filter(|&(_, share)| share > 0.0)
        .collect()
}

/// The table that the shader searches.
fn cell_table(weights: &[f64], cells_x: usize) -> Vec<[f32; 2]> {
    let row_weights: Vec<f64> = weights
        .chunks_exact(cells_x)
        .map(|r| r.iter().sum())
        .collect();
    let rows = cumulative_units(&row_weights);
    let unit = 1.0 / f64::from(PROBABILITY_UNITS);
    let before = |row: usize| row.checked_sub(1).map_or(0, |row| rows[row]);
    let table = weights.par_chunks_exact(cells_x).enumerate();
    let table = table.flat_map_iter(|(number, row)| {
        let row_probability = f64::from(rows[number] - before(number)) * unit;
        let rows_up_to = (f64::from(rows[number]) * unit) as f32;
        let mut before = 0;
        let cells = cumulative_units(row).into_iter().map(move |up_to| {
            let probability = row_probability * f64::from(up_to - before) * unit;
            before = up_to;
            [
                (f64::from(up_to) * unit) as f32,
                (probability * weights.len() as f64) as f32,
            ]
        });
        cells.chain(std::iter::once([rows_up_to, 0.0]))
    });
    table.collect()
}

/// Cumulative probabilities in units: monotone, the last is `PROBABILITY_UNITS`, and whatever
/// weighs anything gets a unit at least. The last also of weights that are all zero (a row that
/// is never chosen).
fn cumulative_units(weights: &[f64]) -> Vec<u32> {
    let total: f64 = weights.iter().sum();
    let positive = weights.iter().filter(|&&weight| weight > 0.0).count() as u32;
    if total <= 0.0 {
        return vec![PROBABILITY_UNITS; weights.len()];
    }
    let shared = f64::from(PROBABILITY_UNITS - positive);
    let mut sum = 0.0;
    let mut given = 0;
    weights
        .iter()
        .map(|&weight| {
            sum += weight;
            given += u32::from(weight > 0.0);
            given + (sum / total * shared).floor() as u32
        })
        .collect()
}
