//! The sampler: each call takes a fresh one- or two-dimensional Owen-scrambled Sobol' set, padded
//! together from independently shuffled sets (Burley 2020, "Practical hash-based Owen scrambling",
//! section 3.4). The stream is a function of (pixel, sample, seed, calls so far) alone.

use crate::cpu::sobol::{owen_scramble, sobol_scrambled0, sobol_scrambled1};
use glam::{DVec2, UVec2};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rng {
    /// Of the pixel and the picture's seed.
    pub pixel_seed: u32,
    /// Of the sample in the pixel.
    pub index: u32,
    /// Sets taken so far.
    pub dimension: u32,
}

/// Integer hash with near-ideal avalanche: Wellons 2018, "Prospecting for hash functions", with
/// the later constants of bias 0.107 for the xor-shifts 16, 15, 15. The offset keeps zero from mapping to zero.
pub fn hash_u32(key: u32) -> u32 {
    let mut x = key.wrapping_add(0x9e37_79b9);
    x = (x ^ (x >> 16)).wrapping_mul(0x21f0_aaad);
    x = (x ^ (x >> 15)).wrapping_mul(0x735a_2d97);
    x ^ (x >> 15)
}

/// The hash of a sequence of words, one word longer. Not symmetric.
pub fn hash_combine(hash: u32, word: u32) -> u32 {
    hash_u32(hash ^ hash_u32(word))
}

pub fn rng_init(pixel: UVec2, sample: u32, seed: u32) -> Rng {
    let pixel_seed = hash_combine(hash_combine(hash_u32(seed), pixel.x), pixel.y);
    Rng {
        pixel_seed,
        index: sample,
        dimension: 0,
    }
}

/// A fraction of 24 bits, which float32 holds exactly; below 1.
pub fn unit_from_bits(bits: u32) -> f64 {
    f64::from(bits >> 8) / f64::from(1u32 << 24)
}

/// Uniform in [0, 1), a multiple of 2^-24.
pub fn next_1d(rng: &mut Rng) -> f64 {
    let seed = hash_combine(rng.pixel_seed, rng.dimension);
    rng.dimension = rng.dimension.wrapping_add(1);
    let index = owen_scramble(rng.index, seed);
    unit_from_bits(sobol_scrambled0(index, hash_u32(seed)))
}

/// Uniform in [0, 1)^2, multiples of 2^-24.
pub fn next_2d(rng: &mut Rng) -> DVec2 {
    let seed = hash_combine(rng.pixel_seed, rng.dimension);
    rng.dimension = rng.dimension.wrapping_add(1);
    let index = owen_scramble(rng.index, seed);
    let seed_x = hash_u32(seed);
    let seed_y = hash_u32(seed_x);
    DVec2::new(
        unit_from_bits(sobol_scrambled0(index, seed_x)),
        unit_from_bits(sobol_scrambled1(index, seed_y)),
    )
}
