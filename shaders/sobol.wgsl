// Two dimensions of the Sobol' sequence by bit operations, and nested uniform ("Owen") scrambling
// by a hash. Integers only, so that every adapter and the reference see the same bits.
// Points are 32-bit fixed-point fractions: bit 31 is worth one half.

// The radical inverse in base 2 (van der Corput 1935), Sobol's first dimension.
fn sobol_dimension0(index: u32) -> u32 {
    return reverseBits(index);
}

// Sobol's second dimension.
fn sobol_dimension1(index: u32) -> u32 {
    return reverseBits(sobol_reversed1(index));
}

// The same with its bits in reverse. The generator matrix is Pascal's triangle modulo 2, which is the
// fivefold Kronecker power of [[1, 1], [0, 1]] and is applied one factor at a time.
fn sobol_reversed1(index: u32) -> u32 {
    var x = index;
    x ^= x >> 16u;
    x ^= (x & 0xff00ff00u) >> 8u;
    x ^= (x & 0xf0f0f0f0u) >> 4u;
    x ^= (x & 0xccccccccu) >> 2u;
    x ^= (x & 0xaaaaaaaau) >> 1u;
    return x;
}

// A permutation in which each bit depends on lower bits only: Laine and Karras 2011, "Stratified
// sampling for stochastic transparency", section 3.1, in the form and with the constants of
// Vegdahl 2021, "Building a better LK hash".
fn laine_karras(bits: u32, seed: u32) -> u32 {
    var x = bits;
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16u) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

// Nested uniform scrambling (Owen 1995) of a point, or shuffling of an index: Burley 2020,
// "Practical hash-based Owen scrambling", sections 3.2 and 3.3. It turns aligned power-of-two
// intervals into aligned intervals of the same size, hence keeps every stratification.
fn owen_scramble(x: u32, seed: u32) -> u32 {
    return reverseBits(laine_karras(reverseBits(x), seed));
}

// sobol_dimension0 and sobol_dimension1, scrambled. Reversing twice is left out: it takes a driver without an
// instruction for it twenty others.
fn sobol_scrambled0(index: u32, seed: u32) -> u32 {
    return reverseBits(laine_karras(index, seed));
}

fn sobol_scrambled1(index: u32, seed: u32) -> u32 {
    return reverseBits(laine_karras(sobol_reversed1(index), seed));
}
