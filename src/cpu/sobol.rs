//! Two dimensions of the Sobol' sequence by bit operations, and nested uniform ("Owen") scrambling
//! by a hash. Integers only, so that every adapter and the reference see the same bits.
//! Points are 32-bit fixed-point fractions: bit 31 is worth one half.

/// The radical inverse in base 2 (van der Corput 1935), Sobol's first dimension.
pub fn sobol_dimension0(index: u32) -> u32 {
    index.reverse_bits()
}

/// Sobol's second dimension.
pub fn sobol_dimension1(index: u32) -> u32 {
    sobol_reversed1(index).reverse_bits()
}

/// The same with its bits in reverse. The generator matrix is Pascal's triangle modulo 2, which is the
/// fivefold Kronecker power of [[1, 1], [0, 1]] and is applied one factor at a time.
pub fn sobol_reversed1(index: u32) -> u32 {
    let mut x = index;
    x ^= x >> 16;
    x ^= (x & 0xff00_ff00) >> 8;
    x ^= (x & 0xf0f0_f0f0) >> 4;
    x ^= (x & 0xcccc_cccc) >> 2;
    x ^= (x & 0xaaaa_aaaa) >> 1;
    x
}

/// A permutation in which each bit depends on lower bits only: Laine and Karras 2011, "Stratified
/// sampling for stochastic transparency", section 3.1, in the form and with the constants of
/// Vegdahl 2021, "Building a better LK hash".
pub fn laine_karras(bits: u32, seed: u32) -> u32 {
    let mut x = bits;
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x
}

/// Nested uniform scrambling (Owen 1995) of a point, or shuffling of an index: Burley 2020,
/// "Practical hash-based Owen scrambling", sections 3.2 and 3.3. It turns aligned power-of-two
/// intervals into aligned intervals of the same size, hence keeps every stratification.
pub fn owen_scramble(x: u32, seed: u32) -> u32 {
    laine_karras(x.reverse_bits(), seed).reverse_bits()
}

/// `sobol_dimension0` and `sobol_dimension1`, scrambled. Reversing twice is left out: it takes a driver without
/// an instruction for it twenty others.
pub fn sobol_scrambled0(index: u32, seed: u32) -> u32 {
    laine_karras(index, seed).reverse_bits()
}

pub fn sobol_scrambled1(index: u32, seed: u32) -> u32 {
    laine_karras(sobol_reversed1(index), seed).reverse_bits()
}
