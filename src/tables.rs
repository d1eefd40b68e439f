//! The tables that reflection models look up, integrated in f64 by fixed rules. The binary holds what came
//! of it (`tables/tables.bin`, which `examples/make_tables.rs` writes and a test makes again): to integrate
//! takes longer than a small picture, and its last bit depends on the machine. Rough dielectrics' are in `dielectric`, the sheen layer's in `sheen`;
//! here is the directional albedo of the single-scattering GGX lobe, E = F0 x + F90 y, as pairs (x, y).
//!
//! The lobe is isotropic GGX, alpha = roughness^2, Smith's height-correlated masking, Schlick's
//! Fresnel. Axes, both with their ends on the grid:
//! - rows: glTF roughness `j / (ROUGHNESSES - 1)`;
//! - columns: `albedo_coordinate(cos, roughness) = i / (COSINES - 1)`, a warp of the cosine that follows
//!   the lobe's own dip at cos ~ alpha (a plain cosine axis errs by 0.11 there).
//!
//! Entry number `j * COSINES + i` is a pair of 16-bit fractions of 1, x in the low half. A lookup is
//! bilinear with indices clamped; the column is taken at the roughness asked for, not at the rows'. The
//! averages, pair `j`, are those of the lookup, and linear in roughness.
//!
//! The entries stand a margin above the truth, so that what is interpolated between them is never below
//! it, for any F0, from the roughest lobe down to `ALPHA_SMOOTH`: what a model makes of 1 - E or 1 / E
//! then never makes energy. E is at most 0.0033 above, 0.0046 where roughness is below 0.2; it is capped at
//! 1, which leaves up to 0.001 too little at cosines under 0.02.

pub mod dielectric;
pub mod film;
pub mod sheen;

use crate::cpu::bsdf::albedo;
use crate::shared::{ALBEDO_COSINES, ALBEDO_ROUGHNESSES, Tables};
use bytemuck::Zeroable;
use glam::DVec2;
use rayon::prelude::*;

const COSINES: usize = ALBEDO_COSINES as usize;
const ROUGHNESSES: usize = ALBEDO_ROUGHNESSES as usize;

/// Midpoints in azimuth over half a turn; the integrand is even and periodic, so they converge fast.
const AZIMUTHS: usize = 24;

/// Nodes in elevation.
const ELEVATIONS: usize = 20;

/// Nodes of an average inside one cell of the cosine.
const CELL_NODES: usize = 3;

/// Steps that find the horizon (the integrand vanishes there, so few digits do) and the cosines.
const BISECTIONS: usize = 16;

/// What linear interpolation lacks at most of x + y and of y, relative to the value. E is linear in F0
/// between y and x + y, so what holds for both holds for every F0. `tests/tables.rs` checks it.
struct Margin {
    sum: f64,
    white: f64,
}
const MARGIN: Margin = Margin {
    sum: 0.0018,
    white: 0.0028,
};
/// The same of rows below roughness `NARROW`, whose dip is steeper than the columns follow.
const MARGIN_NARROW: Margin = Margin {
    sum: 0.002,
    white: 0.0045,
};
const NARROW: f64 = 0.22;

/// Row 0 is made at this roughness, where the lobe is a mirror for every purpose but keeps its shape
/// in the warped cosine; models never ask for less than the square root of `ALPHA_SMOOTH`.
const ROUGHNESS_FLOOR: f64 = 0.01;

/// All tables, as words of four bytes, the lowest first.
static KEPT: &[u8; size_of::<Tables>()] = include_bytes!("tables/tables.bin");

/// All tables.
pub fn tables() -> Box<Tables> {
    let mut tables = Box::new(Tables::zeroed());
    let words: &mut [u32] = bytemuck::cast_slice_mut(bytemuck::bytes_of_mut(&mut *tables));
    for (word, bytes) in words.iter_mut().zip(KEPT.as_chunks().0) {
        *word = u32::from_le_bytes(*bytes);
    }
    tables
}

/// Makes all tables: some tenths of a second.
pub fn integrate() -> Box<Tables> {
    let mut tables = Box::new(Tables::zeroed());
    fill_ggx(&mut tables);
    film::fill(&mut tables);
    dielectric::fill(&mut tables);
    sheen::fill(&mut tables);
    tables
}

fn fill_ggx(tables: &mut Tables) {
    let rule = gauss_legendre(ELEVATIONS);
    let row_roughness = |j| grid(j, ROUGHNESSES).max(ROUGHNESS_FLOOR);
    let rows: Vec<[u32; COSINES]> = (0..ROUGHNESSES)
        .into_par_iter()
        .map(|j| {
            let roughness = row_roughness(j);
            let margin = if roughness < NARROW {
                MARGIN_NARROW
            } else {
                MARGIN
            };
            std::array::from_fn(|i| {
                let cos = cosine_of(grid(i, COSINES), roughness);
                unorm16x2(raise(albedo_ggx(cos, roughness, &rule), &margin))
            })
        })
        .collect();
    for (index, pair) in rows.iter().flatten().enumerate() {
        tables.albedo[index / 4][index % 4] = *pair;
    }
    // Averages of the lookups, interpolation and margins included: what a model puts back of 1 - E then
    // adds up to 1 - E.
    let rule = gauss_legendre(CELL_NODES);
    for j in 0..ROUGHNESSES {
        let roughness = row_roughness(j);
        let average = hemispherical_average(roughness, COSINES, &rule, |cos| {
            albedo::albedo_ggx(tables, cos, roughness, false)
        });
        write_pair(&mut tables.albedo_average, j, average);
    }
}

/// 2 * integral of E cos over cos, cell by cell of the columns at this roughness.
fn hemispherical_average(
    roughness: f64,
    columns: usize,
    rule: &[(f64, f64)],
    albedo: impl Fn(f64) -> DVec2,
) -> [f64; 2] {
    let mut sum = DVec2::ZERO;
    let mut low = 0.0;
    for column in 1..columns {
        let high = cosine_of(grid(column, columns), roughness);
        for &(node, weight) in rule {
            let cos = low + (high - low) * node;
            sum += 2.0 * weight * (high - low) * cos * albedo(cos);
        }
        low = high;
    }
    sum.to_array()
}

/// Node number `index` of `count` on an axis from 0 to 1.
fn grid(index: usize, count: usize) -> f64 {
    index as f64 / (count - 1) as f64
}

/// Two fractions of 1 as 16-bit integers, the first in the low half.
fn unorm16x2(pair: [f64; 2]) -> u32 {
    let [low, high] = pair.map(|value| (value.clamp(0.0, 1.0) * 65535.0).round() as u32);
    low | high << 16
}

fn write_pair(table: &mut [[f32; 4]], index: usize, pair: [f64; 2]) {
    let half = 2 * (index % 2);
    table[index / 2][half] = pair[0] as f32;
    table[index / 2][half + 1] = pair[1] as f32;
}

/// Adds the margins without passing 1.
fn raise([x, y]: [f64; 2], margin: &Margin) -> [f64; 2] {
    let sum = (1.0_f64).min((1.0 + margin.sum) * (x + y));
    let white = sum.min((1.0 + margin.white) * y);
    [sum - white, white]
}

/// Where a cosine lies on the tables' columns, 0 to 1: half by the square root of the cosine, half by
/// that of the cosine against the lobe's width.
pub fn albedo_coordinate(cos: f64, roughness: f64) -> f64 {
    if cos <= 0.0 {
        return 0.0;
    }
    let alpha = roughness * roughness;
    0.5 * (cos.sqrt() + (cos / (cos + alpha * (1.0 - cos))).sqrt())
}

/// Inverse of `albedo_coordinate`.
fn cosine_of(coordinate: f64, roughness: f64) -> f64 {
    if coordinate >= 1.0 {
        return 1.0;
    }
    last_true(1.0, |root| {
        albedo_coordinate(root * root, roughness) < coordinate
    })
    .powi(2)
}

/// The pair (x, y) with E = F0 x + F90 y of the GGX lobe seen at `cos_o`; `rule` is the
/// quadrature in elevation, on [0, 1].
///
/// The mirrored directions are taken in the configuration where the roughness is one, where visible
/// normals make them uniform over a spherical cap (Dupuy and Benyoub 2023, "Sampling Visible GGX
/// Normals with Spherical Caps"). That leaves F G2/G1 to integrate, bounded at any roughness and at
/// grazing view too; each meridian is cut where the true direction meets the horizon.
pub fn albedo_ggx(cos_o: f64, roughness: f64, rule: &[(f64, f64)]) -> [f64; 2] {
    let alpha = roughness * roughness;
    let sin_o = (1.0 - cos_o * cos_o).max(0.0).sqrt();
    let length = (alpha * alpha * sin_o * sin_o + cos_o * cos_o).sqrt();
    if length == 0.0 {
        return [0.0, 1.0]; // a mirror seen along itself
    }
    // The view in that configuration.
    let (x_o, z_o) = (alpha * sin_o / length, cos_o / length);
    let theta_cap = (-z_o).acos();
    let mut sum = [0.0; 2];
    for a in 0..AZIMUTHS {
        let cos_phi = (std::f64::consts::PI * (a as f64 + 0.5) / AZIMUTHS as f64).cos();
        // cos_i > 0 with the half vector multiplied out.
        let is_above = |theta: f64| {
            let (sin, cos) = theta.sin_cos();
            let w = z_o + cos;
            let dot = 1.0 + x_o * sin * cos_phi + z_o * cos;
            2.0 * dot * (length * w - cos_o * alpha * alpha) > cos_o * w * w * (1.0 - alpha * alpha)
        };
        let theta_horizon = last_true(theta_cap, is_above);
        for &(node, weight) in rule {
            // Nodes crowd at the horizon, where G2/G1 falls to zero the faster the more grazing the view.
            let theta = theta_horizon * (1.0 - (1.0 - node) * (1.0 - node));
            let (sin_i, z_i) = theta.sin_cos();
            let dot = 1.0 + x_o * sin_i * cos_phi + z_o * z_i;
            let w = z_o + z_i;
            let norm_squared = alpha * alpha * (2.0 * dot - w * w) + w * w;
            let norm = norm_squared.max(f64::MIN_POSITIVE).sqrt();
            let o_dot_h = length * dot / norm;
            let cos_i = (2.0 * o_dot_h * w / norm - cos_o).max(0.0);
            let schlick = (1.0 - o_dot_h).clamp(0.0, 1.0).powi(5);
            let measure = weight * 2.0 * (1.0 - node) * theta_horizon * sin_i;
            let value = measure * masking_ratio(cos_o, cos_i, alpha);
            sum[0] += value * (1.0 - schlick);
            sum[1] += value * schlick;
        }
    }
    // The cap's integral of sin theta d theta is 1 + z_o.
    let total = AZIMUTHS as f64 * (1.0 + z_o);
    [sum[0] / total, sum[1] / total]
}

/// The end of the interval from 0 in which `holds`, at most `end`, by bisection.
fn last_true(end: f64, holds: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, end);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Nodes and weights of Gauss and Legendre's rule on [0, 1], by Newton's method.
pub fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let n = count as f64;
    let node = |k: usize| {
        let mut x = (std::f64::consts::PI * (k as f64 + 0.75) / (n + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut p, mut previous) = (x, 1.0);
            for m in 2..=count {
                let m = m as f64;
                (p, previous) = (((2.0 * m - 1.0) * x * p - (m - 1.0) * previous) / m, p);
            }
            slope = n * (x * p - previous) / (x * x - 1.0);
            x -= p / slope;
        }
        (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(node).collect()
}

/// G2 / G1(o) of GGX, multiplied through by both cosines so that a cosine of 0 is harmless.
fn masking_ratio(cos_o: f64, cos_i: f64, alpha: f64) -> f64 {
    // root(c) = c (1 + 2 Lambda(c)), Heitz 2014 eq. 72.
    let root = |c: f64| (c * c + alpha * alpha * (1.0 - c * c)).sqrt();
    let (o, i) = (root(cos_o), root(cos_i));
    // (1 + Lambda_o) / (1 + Lambda_o + Lambda_i)
    (cos_o + o) * cos_i / (o * cos_i + i * cos_o)
}
