// The sampler: each call takes a fresh one- or two-dimensional Owen-scrambled Sobol' set, padded
// together from independently shuffled sets (Burley 2020, "Practical hash-based Owen scrambling",
// section 3.4). The stream is a function of (pixel, sample, seed, calls so far) alone.

import package::sobol::{sobol_scrambled0, sobol_scrambled1, owen_scramble};

struct Rng {
    pixel_seed: u32, // of the pixel and the picture's seed
    index: u32,      // of the sample in the pixel
    dimension: u32,  // sets taken so far
}

// Integer hash with near-ideal avalanche: Wellons 2018, "Prospecting for hash functions", with
// the later constants of bias 0.107 for the xor-shifts 16, 15, 15. The offset keeps zero from mapping to zero.
fn hash_u32(key: u32) -> u32 {
    var x = key + 0x9e3779b9u;
    x = (x ^ (x >> 16u)) * 0x21f0aaadu;
    x = (x ^ (x >> 15u)) * 0x735a2d97u;
    return x ^ (x >> 15u);
}

// The hash of a sequence of words, one word longer. Not symmetric.
fn hash_combine(hash: u32, word: u32) -> u32 {
    return hash_u32(hash ^ hash_u32(word));
}

fn rng_init(pixel: vec2<u32>, sample: u32, seed: u32) -> Rng {
    let pixel_seed = hash_combine(hash_combine(hash_u32(seed), pixel.x), pixel.y);
    return Rng(pixel_seed, sample, 0u);
}

// A fraction of 24 bits, which float32 holds exactly; below 1.
fn unit_from_bits(bits: u32) -> f32 {
    // By way of a signed number, which processors convert at once.
    return f32(i32(bits >> 8u)) * 0x1p-24f;
}

// Uniform in [0, 1), a multiple of 2^-24.
fn next_1d(rng: ptr<function, Rng>) -> f32 {
    let seed = hash_combine((*rng).pixel_seed, (*rng).dimension);
    (*rng).dimension += 1u;
    let index = owen_scramble((*rng).index, seed);
    return unit_from_bits(sobol_scrambled0(index, hash_u32(seed)));
}

// Uniform in [0, 1)^2, multiples of 2^-24.
fn next_2d(rng: ptr<function, Rng>) -> vec2<f32> {
    let seed = hash_combine((*rng).pixel_seed, (*rng).dimension);
    (*rng).dimension += 1u;
    let index = owen_scramble((*rng).index, seed);
    let seed_x = hash_u32(seed);
    let seed_y = hash_u32(seed_x);
    return vec2<f32>(
        unit_from_bits(sobol_scrambled0(index, seed_x)),
        unit_from_bits(sobol_scrambled1(index, seed_y)),
    );
}
