// What the sentences of the path loop share: weights, roulette, and which random dimension goes where.

import package::rng::{Rng, hash_combine, next_1d};
import package::variant::{MOTION};

// Dimension 0 places the sample in its pixel; each bounce takes a block of its own, so that a draw
// that one path skips does not shift the next bounce's draws.
const DIMENSION_PIXEL: u32 = 0u;
const DIMENSION_LENS: u32 = 0xfffffffeu;
const DIMENSION_TIME: u32 = 0xffffffffu; // behind all bounces, so that still pictures do not depend on it
const DIMENSION_BOUNCE: u32 = 1u;
const DIMENSIONS_PER_BOUNCE: u32 = 8u;
const DIMENSION_LIGHT: u32 = 0u;    // choice (1d), then point (2d)
const DIMENSION_BSDF: u32 = 2u;     // lobe (1d), then direction (2d)
const DIMENSION_ROULETTE: u32 = 4u;
const DIMENSION_WAVELENGTH: u32 = 5u;

// Bounces that no path is ended in by chance.
const ROULETTE_START: u32 = 1u;
// Paths end where their throughput is below the inverse of this: chosen with the two others for the least
// error in equal time (benches/RESULTS.md).
const ROULETTE_SCALE: f32 = 2.0;
// A path that has lost little goes on for sure, lest what is seen in a mirror or through glass be noisy for
// nothing: `max_depth` ends light that is caught between mirrors.
const ROULETTE_MAX: f32 = 1.0;

// A shadow ray ends this fraction before its light, so that it does not meet the light itself.
const SHADOW_SHORTENING: f32 = 1e-4;

// Veach and Guibas 1995, "Optimally combining sampling techniques", the power heuristic, exponent 2,
// of the technique with density `pdf` against the one with density `other`.
fn power_heuristic(pdf: f32, other: f32) -> f32 {
    // As a ratio, so that a density near the end of float's range does not overflow when squared.
    if pdf == 0.0 {
        return 0.0;
    }
    let ratio = other / pdf;
    return 1.0 / (1.0 + ratio * ratio);
}

// Probability of going on with throughput `beta`. `eta_scale` takes out the factor eta^2 that
// radiance carries inside a medium and will give back on leaving it.
fn roulette_probability(beta: vec3<f32>, eta_scale: f32) -> f32 {
    let size = abs(beta);
    return min(ROULETTE_SCALE * max(size.x, max(size.y, size.z)) * eta_scale, ROULETTE_MAX);
}

fn bounce_dimension(bounce: u32, draw: u32) -> u32 {
    return DIMENSION_BOUNCE + bounce * DIMENSIONS_PER_BOUNCE + draw;
}

// When the shutter is open for a path: the same for all its rays, and drawn anew wherever it is needed
// rather than kept.
fn path_time(rng: Rng) -> f32 {
    if !MOTION {
        return 0.0;
    }
    var at_time = rng;
    at_time.dimension = DIMENSION_TIME;
    return next_1d(&at_time);
}

// The seed of the opacity decisions along one ray of a path: `ray` is 2 * bounce for the path's own
// ray and 2 * bounce + 1 for its shadow ray.
fn ray_alpha_seed(rng: Rng, ray: u32) -> u32 {
    return hash_combine(hash_combine(rng.pixel_seed, rng.index), ray);
}

// False for NaN and infinities, by the exponent's bits: comparisons may be assumed away.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

// Scales the radiance of a sample so that no channel exceeds `limit`; 0 is no limit.
fn clamp_radiance(L: vec3<f32>, limit: f32) -> vec3<f32> {
    let size = abs(L);
    let largest = max(size.x, max(size.y, size.z));
    if limit <= 0.0 || largest <= limit {
        return L;
    }
    return L * (limit / largest);
}

// Whether a direction is on the same side of the shading surface (`wi`, local frame) and of the
// geometric one: if not, light would leak through, and the direction carries nothing.
fn sides_agree(wi: vec3<f32>, wi_dot_ng: f32) -> bool {
    return wi.z * wi_dot_ng > 0.0;
}
