//! UASTC, the larger of Basis Universal's two codings: Khronos Data Format Specification 1.4, "UASTC
//! Compressed Texture Image Format". Blocks of 16 bytes, each for itself: one colour, or lines in
//! colour space of one to three parts of the block with a weight for each texel, quantised as in ASTC
//! (section "ASTC Compressed Texture Image Formats"). Tests compare it with its authors' transcoder.

use super::ktx2::Damaged;

pub const BLOCK: usize = 16;

/// How a mode spends its bits.
struct Mode {
    /// The mode's prefix code, from the lowest bit on, and its length.
    code: (u128, usize),
    /// Bits that help transcoding to other formats.
    hints: usize,
    /// Bits of a weight.
    weight: usize,
    endpoint: Range,
    subsets: usize,
    planes: usize,
    /// 2: luminance and alpha.
    components: usize,
}

/// The steps of an endpoint: bits, together with a digit of base 3 or 5 or, for base 1, alone.
#[derive(Clone, Copy)]
struct Range {
    bits: usize,
    base: u32,
}

const SOLID: usize = 8;
/// The one of the modes with two planes whose second plane is always alpha's.
const LUMINANCE_ALPHA_PLANES: usize = 17;
/// The one of two parts that come from three of BC7.
const FROM_THREE: usize = 7;

#[rustfmt::skip]
const MODES: [Mode; 19] = {
    const fn mode(
        code: (u128, usize), hints: usize, weight: usize, (bits, base): (usize, u32),
        subsets: usize, planes: usize, components: usize,
    ) -> Mode {
        Mode { code, hints, weight, endpoint: Range { bits, base }, subsets, planes, components }
    }
    [
        mode((0x01, 4), 15, 4, (6, 3), 1, 1, 3),
        mode((0x35, 6), 15, 2, (8, 1), 1, 1, 3),
        mode((0x1d, 5), 15, 3, (4, 1), 2, 1, 3),
        mode((0x03, 5), 15, 2, (2, 3), 3, 1, 3),
        mode((0x13, 5), 15, 2, (3, 5), 2, 1, 3),
        mode((0x0b, 5), 15, 3, (8, 1), 1, 1, 3),
        mode((0x1b, 5), 15, 2, (5, 5), 1, 2, 3),
        mode((0x07, 5), 15, 2, (3, 5), 2, 1, 3),
        mode((0x17, 5), 0, 0, (8, 1), 0, 0, 4),
        mode((0x0f, 5), 23, 2, (4, 1), 2, 1, 4),
        mode((0x02, 3), 17, 4, (4, 3), 1, 1, 4),
        mode((0x00, 2), 17, 2, (4, 3), 1, 2, 4),
        mode((0x06, 3), 17, 3, (6, 3), 1, 1, 4),
        mode((0x1f, 5), 23, 1, (8, 1), 1, 2, 4),
        mode((0x0d, 5), 23, 2, (8, 1), 1, 1, 4),
        mode((0x05, 7), 23, 4, (8, 1), 1, 1, 2),
        mode((0x15, 6), 23, 2, (8, 1), 2, 1, 2),
        mode((0x25, 6), 23, 2, (8, 1), 1, 2, 2),
        mode((0x09, 4), 15, 5, (5, 1), 1, 1, 3),
    ]
};

/// Which part a texel is of: two bits each, the first texel lowest.
#[rustfmt::skip]
const TWO_PARTS: [u32; 30] = [
    0x50505050, 0x40404040, 0x01010101, 0x54505040, 0x05151555, 0x55545450, 0x00010515, 0x01051555,
    0x50400000, 0x00000105, 0x55544000, 0x01155555, 0x00000115, 0x00005555, 0x55555500, 0x00555555,
    0x55551501, 0x40545555, 0x00405054, 0x00004050, 0x15050100, 0x50545555, 0x15050501, 0x00404050,
    0x50545455, 0x14141414, 0x55000055, 0x11111111, 0x00550055, 0x05145041,
];
#[rustfmt::skip]
const TWO_PARTS_FROM_THREE: [u32; 19] = [
    0x00005500, 0x10101010, 0x00010505, 0x50504000, 0x55005555, 0x04040404, 0x55555040, 0x50505054,
    0x05500005, 0x00005454, 0x15150000, 0x05000005, 0x00005054, 0x55554000, 0x14555555, 0x01050505,
    0x01015555, 0x01051450, 0x00005455,
];
#[rustfmt::skip]
const THREE_PARTS: [u32; 11] = [
    0xa5a50000, 0xaa005555, 0xaa000055, 0x0000aa55, 0x25252525, 0x94949494, 0x58585858, 0x56560202,
    0x92929292, 0x55aa0055, 0xa05050a0,
];

/// RGBA of the block's texels in rows.
pub fn texels(block: [u8; BLOCK]) -> Result<[[u8; 4]; 16], Damaged> {
    const DAMAGED: Damaged = "its block data are damaged";
    let mut bits = Bits(u128::from_le_bytes(block));
    let (number, mode) = (0..)
        .zip(&MODES)
        .find(|(_, mode)| bits.0 & ((1 << mode.code.1) - 1) == mode.code.0)
        .ok_or(DAMAGED)?;
    bits.take(mode.code.1);
    if number == SOLID {
        let color = std::array::from_fn(|_| bits.take(8) as u8);
        return Ok([color; 16]);
    }
    bits.take(mode.hints);
    let pattern = match (mode.subsets, number) {
        (1, _) => Some(&0),
        (2, FROM_THREE) => TWO_PARTS_FROM_THREE.get(bits.take(5) as usize),
        (2, _) => TWO_PARTS.get(bits.take(5) as usize),
        _ => THREE_PARTS.get(bits.take(4) as usize),
    };
    let pattern = *pattern.ok_or(DAMAGED)?;
    // The component that the second plane weighs.
    let other = match (mode.planes, number) {
        (1, _) => None,
        (_, LUMINANCE_ALPHA_PLANES) => Some(3),
        _ => Some(bits.take(2) as usize),
    };
    let ends = endpoints(mode, &mut bits);
    let part = |i: usize| (pattern >> (2 * i) & 3) as usize;
    // The first texel of each part has a weight without its highest bit, which is 0.
    let mut seen = [false; 3];
    Ok(std::array::from_fn(|i| {
        let part = part(i);
        let first = !std::mem::replace(&mut seen[part], true);
        let mut weigh = || weight(bits.take(mode.weight - usize::from(first)), mode.weight);
        let near = weigh();
        let far = if mode.planes == 2 { weigh() } else { near };
        std::array::from_fn(|c| {
            let weight = if other == Some(c) { far } else { near };
            let [low, high] = ends[part][c].map(|end| end << 8 | end);
            ((low * (64 - weight) + high * weight + 32) >> 14) as u8
        })
    }))
}

/// [low, high] of RGBA for each part.
fn endpoints(mode: &Mode, bits: &mut Bits) -> [[[u32; 2]; 4]; 3] {
    let Range {
        bits: low_bits,
        base,
    } = mode.endpoint;
    let count = 2 * mode.components * mode.subsets;
    // As many digits as fit into a byte; fewer in the last group, which is shorter then.
    let (group, widths): (usize, &[usize]) = match base {
        3 => (5, &[0, 2, 4, 5, 7, 8]),
        5 => (3, &[0, 3, 5, 7]),
        _ => (count, &[]),
    };
    let mut digits = [0; 18];
    for digits in digits[..count].chunks_mut(group) {
        let mut packed = widths
            .get(digits.len())
            .map_or(0, |&width| bits.take(width));
        for digit in digits {
            *digit = packed % base;
            packed /= base;
        }
    }
    let mut values = digits;
    for value in &mut values[..count] {
        *value = unquantize(mode.endpoint, bits.take(low_bits), *value);
    }
    let mut ends = [[[255; 2]; 4]; 3];
    for (ends, values) in ends
        .iter_mut()
        .zip(values[..count].chunks(2 * mode.components))
    {
        let (pairs, _) = values.as_chunks::<2>();
        match pairs {
            [luminance, alpha] => *ends = [*luminance, *luminance, *luminance, *alpha],
            pairs => ends[..pairs.len()].copy_from_slice(pairs),
        }
    }
    ends
}

/// ASTC's "Endpoint Unquantization", to eight bits.
fn unquantize(range: Range, low: u32, digit: u32) -> u32 {
    // The factor of the digit, and which bits (a is the lowest) make up the addend.
    let (factor, pattern) = match (range.base, range.bits) {
        (3, 2) => (93, b"b000b0bb0"),
        (3, 4) => (22, b"dcb000dcb"),
        (3, _) => (5, b"fedcb000f"),
        (5, 3) => (26, b"cb0000cbc"),
        (5, _) => (6, b"edcb0000e"),
        _ => return replicate(low, range.bits, 8),
    };
    let addend = pattern.iter().fold(0, |sum, letter| {
        let bit = match letter {
            b'0' => 0,
            letter => low >> (letter - b'a') & 1,
        };
        sum << 1 | bit
    });
    let flip = if low & 1 == 1 { 0x1ff } else { 0 };
    flip & 0x80 | ((digit * factor + addend) ^ flip) >> 2
}

/// ASTC's "Weight Unquantization" of whole bits, to 0 ... 64.
fn weight(value: u32, bits: usize) -> u32 {
    let six = replicate(value, bits, 6);
    six + u32::from(six > 32)
}

/// Repeats the bits of a value until they fill `wanted`.
fn replicate(value: u32, bits: usize, wanted: usize) -> u32 {
    let filled = (0..wanted.div_ceil(bits)).fold(0, |sum, _| sum << bits | value);
    filled >> (wanted.next_multiple_of(bits) - wanted)
}

struct Bits(u128);

impl Bits {
    /// The next `count` bits, at most 32, the first one lowest; zeros after the last.
    fn take(&mut self, count: usize) -> u32 {
        let value = self.0 & ((1 << count) - 1);
        self.0 >>= count;
        value as u32
    }
}
