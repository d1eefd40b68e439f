//! Light from infinitely far: an equirectangular map of radiance and the table that samples it.
//! (u, v) of a direction: u = atan2(z, x) / (2 pi) + 1/2, v = acos(y) / pi from the top row, after
//! the map's rotation about +y is taken back. A density over (u, v) becomes one per solid angle by
//! d omega = 2 pi^2 sin(theta) du dv.

use crate::cpu::math::{INV_PI, PI, sqr};
use crate::pack::Packed;
use glam::{DVec2, DVec3, DVec4};

/// The sampler's numbers are multiples of one over this, and so are the table's probabilities.
pub const SAMPLE_STEPS: f64 = (1u32 << 24) as f64;

/// Where a direction, of any length, falls on the map: [0, 1]^2.
pub fn environment_uv(packed: &Packed, d: DVec3) -> DVec2 {
    let (cos, sin) = (
        f64::from(packed.frame.environment_cos),
        f64::from(packed.frame.environment_sin),
    );
    let x = d.x * cos - d.z * sin;
    let z = d.x * sin + d.z * cos;
    let theta = (x * x + z * z).sqrt().atan2(d.y);
    DVec2::new(z.atan2(x) * (0.5 * INV_PI) + 0.5, theta * INV_PI)
}

/// The inverse: a unit vector.
pub fn environment_direction(packed: &Packed, uv: DVec2) -> DVec3 {
    let (cos, sin) = (
        f64::from(packed.frame.environment_cos),
        f64::from(packed.frame.environment_sin),
    );
    let (sin_theta, cos_theta) = (PI * uv.y).sin_cos();
    let (sin_phi, cos_phi) = (PI * (2.0 * uv.x - 1.0)).sin_cos();
    let x = sin_theta * cos_phi;
    let z = sin_theta * sin_phi;
    DVec3::new(x * cos + z * sin, cos_theta, z * cos - x * sin)
}

/// One texel of the map; wraps around horizontally, ends at the poles.
pub fn environment_texel(packed: &Packed, x: i32, y: i32) -> DVec3 {
    let [width, height] = packed.frame.environment_size.map(|side| side as i32);
    // Both lie one texel outside at most.
    let x = if x < 0 { x + width } else { x };
    let x = if x < width { x } else { x - width };
    let place = y.clamp(0, height - 1) * width + x;
    let [r, g, b, _] = packed.environment[place as usize];
    DVec3::new(f64::from(r), f64::from(g), f64::from(b))
}

/// Radiance that arrives from direction d, filtered bilinearly between texel centres.
pub fn Le_environment(packed: &Packed, d: DVec3) -> DVec3 {
    if packed.frame.environment_strength == 0.0 {
        return DVec3::ZERO;
    }
    let [width, height] = packed.frame.environment_size.map(f64::from);
    let place = environment_uv(packed, d) * DVec2::new(width, height) - 0.5;
    let corner = place.floor();
    let fraction = place - corner;
    let (x, y) = (corner.x as i32, corner.y as i32);
    let texel = |x, y| environment_texel(packed, x, y);
    let top = texel(x, y).lerp(texel(x + 1, y), fraction.x);
    let bottom = texel(x, y + 1).lerp(texel(x + 1, y + 1), fraction.x);
    f64::from(packed.frame.environment_strength) * top.lerp(bottom, fraction.y)
}

/// Cumulative probability of the row's cells up to and with cell x; that of the rows in column
/// `environment_cells.x`. A multiple of 2^-24, as the sampler's numbers are.
pub fn environment_cumulative(packed: &Packed, x: u32, y: u32) -> f64 {
    let stride = packed.frame.environment_cells[0] + 1;
    f64::from(packed.environment_cells[(y * stride + x) as usize][0])
}

/// Density of a cell over the unit square of (u, v).
pub fn environment_density(packed: &Packed, x: u32, y: u32) -> f64 {
    let stride = packed.frame.environment_cells[0] + 1;
    f64::from(packed.environment_cells[(y * stride + x) as usize][1])
}

/// Bisection for the first of `count` cells of row y (or rows, where `rows`) whose cumulative
/// probability is above u, and how far into it u lies, in (0, 1).
pub fn environment_find(packed: &Packed, u: f64, count: u32, y: u32, rows: bool) -> DVec2 {
    let cumulative = |cell: u32| {
        if rows {
            environment_cumulative(packed, packed.frame.environment_cells[0], cell)
        } else {
            environment_cumulative(packed, cell, y)
        }
    };
    let mut first = 0;
    let mut remaining = count - 1;
    while remaining > 0 {
        let half = remaining / 2;
        // Without a branch, which would be mispredicted every other time.
        let beyond = cumulative(first + half) <= u;
        first += if beyond { half + 1 } else { 0 };
        remaining = if beyond { remaining - half - 1 } else { half };
    }
    let above = cumulative(first);
    let below = if first > 0 {
        cumulative(first - 1)
    } else {
        0.0
    };
    // Each of the sampler's numbers stands for an interval of one step; taking its middle keeps
    // cells that few numbers reach from being met at one edge only.
    let place = ((u - below) * SAMPLE_STEPS + 0.5) / ((above - below) * SAMPLE_STEPS);
    DVec2::new(f64::from(first), place)
}

/// (Direction, pdf per solid angle), the choice of this light not included. pdf 0: no light.
pub fn environment_sample(packed: &Packed, u: DVec2) -> DVec4 {
    if packed.frame.environment_weight == 0.0 {
        return DVec4::ZERO;
    }
    let [cells_x, cells_y] = packed.frame.environment_cells;
    let row = environment_find(packed, u.y, cells_y, 0, true);
    let column = environment_find(packed, u.x, cells_x, row.x as u32, false);
    let uv = DVec2::new(column.x + column.y, row.x + row.y)
        / DVec2::new(f64::from(cells_x), f64::from(cells_y));
    let density = environment_density(packed, column.x as u32, row.x as u32);
    let sin_theta = (PI * uv.y).sin();
    environment_direction(packed, uv).extend(density / (2.0 * sqr(PI) * sin_theta))
}

/// Directions that `environment_sample_facing` chooses between.
pub const ENVIRONMENT_CANDIDATES: f64 = 2.0;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvironmentSample {
    pub wi: DVec3,
    /// Per solid angle, of both candidates together, whose integral is their number; 0: no light.
    pub pdf: f64,
    /// One over the probability with which this one of the two was taken.
    pub weight: f64,
}

/// One of two directions of `environment_sample`, by the number `u_choice` in proportion to the cosine with ns: of the
/// side of ns, or of both where the surface transmits.
///
/// Two samples x of density p may both be taken, as the sum of w g / (2 p) with a heuristic's weight w of 2 p
/// against the density of the other technique (Veach and Guibas 1995, "Optimally combining sampling techniques", the
/// multi-sample model). Of the two terms one is taken with probability cos / (cos + cos'), and divided by it: the
/// same expectation for one ray, if terms without a cosine are 0. Which is resampled importance sampling (Talbot,
/// Cline and Egbert 2005) of the product p cos, and asks nothing of how the two depend on each other. The second is
/// half of the square further in both axes: somewhere else in the sky, and as even as the first over a pixel's
/// samples.
pub fn environment_sample_facing(
    packed: &Packed,
    ns: DVec3,
    transmits: bool,
    u_choice: f64,
    u: DVec2,
) -> EnvironmentSample {
    let candidates = [u, (u + 0.5).fract()].map(|u| environment_sample(packed, u));
    let shares = candidates.map(|candidate| {
        let cosine = candidate.truncate().dot(ns);
        if transmits {
            cosine.abs()
        } else {
            cosine.max(0.0)
        }
    });
    let sum = shares[0] + shares[1];
    // The second where both could be.
    let taken = usize::from(shares[1] > 0.0 && u_choice * sum <= shares[1]);
    if shares[taken] == 0.0 {
        return EnvironmentSample {
            wi: DVec3::ZERO,
            pdf: 0.0,
            weight: 0.0,
        };
    }
    EnvironmentSample {
        wi: candidates[taken].truncate(),
        pdf: ENVIRONMENT_CANDIDATES * candidates[taken].w,
        weight: sum / shares[taken],
    }
}

/// Density of `environment_sample` at the unit vector d.
pub fn environment_pdf(packed: &Packed, d: DVec3) -> f64 {
    let sin_theta = (d.x * d.x + d.z * d.z).sqrt();
    if packed.frame.environment_weight == 0.0 || sin_theta == 0.0 {
        return 0.0;
    }
    let [cells_x, cells_y] = packed.frame.environment_cells;
    let cell = environment_uv(packed, d) * DVec2::new(f64::from(cells_x), f64::from(cells_y));
    let x = (cell.x as u32).min(cells_x - 1);
    let y = (cell.y as u32).min(cells_y - 1);
    environment_density(packed, x, y) / (2.0 * sqr(PI) * sin_theta)
}
