//! Twin of `shaders/estimator.wgsl`: weights, roulette, and which random dimension goes where.

use super::rng::{Rng, hash_combine, next_1d};
use glam::DVec3;

pub const DIMENSION_PIXEL: u32 = 0;
pub const DIMENSION_LENS: u32 = 4294967294;
pub const DIMENSION_TIME: u32 = u32::MAX;
pub const DIMENSION_BOUNCE: u32 = 1;
pub const DIMENSIONS_PER_BOUNCE: u32 = 8;
pub const DIMENSION_LIGHT: u32 = 0;
pub const DIMENSION_BSDF: u32 = 2;
pub const DIMENSION_ROULETTE: u32 = 4;
pub const DIMENSION_WAVELENGTH: u32 = 5;

pub const ROULETTE_START: u32 = 1;
pub const ROULETTE_SCALE: f64 = 2.0;
pub const ROULETTE_MAX: f64 = 1.0;

pub const SHADOW_SHORTENING: f64 = 1e-4;

/// Veach and Guibas 1995, "Optimally combining sampling techniques", the power heuristic, exponent
/// 2, of the technique with density `pdf` against the one with density `other`.
pub fn power_heuristic(pdf: f64, other: f64) -> f64 {
    if pdf == 0.0 {
        return 0.0;
    }
    let ratio = other / pdf;
    1.0 / (1.0 + ratio * ratio)
}

/// Probability of going on with throughput `beta`; `eta_scale` takes out the factor eta^2 that
/// radiance carries inside a medium.
pub fn roulette_probability(beta: DVec3, eta_scale: f64) -> f64 {
    (ROULETTE_SCALE * beta.abs().max_element() * eta_scale).min(ROULETTE_MAX)
}

pub fn bounce_dimension(bounce: u32, draw: u32) -> u32 {
    DIMENSION_BOUNCE + bounce * DIMENSIONS_PER_BOUNCE + draw
}

/// When the shutter is open for a path: the same for all its rays.
pub fn path_time(rng: Rng) -> f64 {
    next_1d(&mut Rng {
        dimension: DIMENSION_TIME,
        ..rng
    })
}

/// The seed of the opacity decisions along one ray of a path: `ray` is 2 * bounce for the path's
/// own ray and 2 * bounce + 1 for its shadow ray.
pub fn ray_alpha_seed(rng: Rng, ray: u32) -> u32 {
    hash_combine(hash_combine(rng.pixel_seed, rng.index), ray)
}

/// False for NaN and infinities.
pub fn is_finite(x: f64) -> bool {
    x.is_finite()
}

/// Scales the radiance of a sample so that no channel exceeds `limit`; 0 is no limit.
pub fn clamp_radiance(L: DVec3, limit: f64) -> DVec3 {
    let largest = L.abs().max_element();
    if limit <= 0.0 || largest <= limit {
        return L;
    }
    L * (limit / largest)
}

/// Whether a direction is on the same side of the shading surface (`wi`, local frame) and of the
/// geometric one: if not, light would leak through, and the direction carries nothing.
pub fn sides_agree(wi: DVec3, wi_dot_ng: f64) -> bool {
    wi.z * wi_dot_ng > 0.0
}
