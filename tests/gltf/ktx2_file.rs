//! KTX2 files, made in code: KTX File Format Specification 2.0.
#![allow(dead_code, reason = "each test binary uses the parts that it needs")]

pub const UNDEFINED: u32 = 0;
pub const BASIS_LZ: u32 = 1;
pub const ZSTANDARD: u32 = 2;
pub const ETC1S: u8 = 163;
pub const UASTC: u8 = 166;
pub const LINEAR: u8 = 1;
pub const SRGB: u8 = 2;

/// A file of one level; the fields bear the specification's names.
#[derive(Clone)]
pub struct Ktx2File {
    pub vk_format: u32,
    pub size: [u32; 3],
    pub layers: u32,
    pub faces: u32,
    pub levels: u32,
    pub scheme: u32,
    pub color_model: u8,
    pub transfer: u8,
    /// One for each sample of the descriptor.
    pub channels: Vec<u8>,
    pub values: Vec<(&'static str, &'static str)>,
    pub global: Vec<u8>,
    pub level: Vec<u8>,
    pub unpacked: u64,
}

impl Ktx2File {
    pub fn new(vk_format: u32, size: [u32; 2], level: Vec<u8>) -> Self {
        Self {
            vk_format,
            size: [size[0], size[1], 0],
            layers: 0,
            faces: 1,
            levels: 1,
            scheme: 0,
            color_model: 1,
            transfer: SRGB,
            channels: vec![0],
            values: vec![("KTXorientation", "rd")],
            global: Vec::new(),
            unpacked: level.len() as u64,
            level,
        }
    }

    pub fn uastc(size: [u32; 2], channel: u8, level: Vec<u8>) -> Self {
        Self {
            color_model: UASTC,
            channels: vec![channel],
            ..Self::new(UNDEFINED, size, level)
        }
    }

    pub fn zstandard(mut self) -> Self {
        let level = ruzstd::encoding::CompressionLevel::Fastest;
        self.level = ruzstd::encoding::compress_to_vec(self.level.as_slice(), level);
        self.scheme = ZSTANDARD;
        self
    }

    pub fn bytes(&self) -> Vec<u8> {
        let words =
            |words: &[u32]| -> Vec<u8> { words.iter().flat_map(|w| w.to_le_bytes()).collect() };
        let block = 24 + 16 * self.channels.len();
        let mut descriptor = words(&[block as u32 + 4, 0, 2 | (block as u32) << 16]);
        descriptor.extend([self.color_model, 1, self.transfer, 0, 3, 3, 0, 0]);
        descriptor.extend([0; 8]);
        for &channel in &self.channels {
            descriptor.extend([0, 0, 63, channel]);
            descriptor.extend([0; 12]);
        }
        let mut values = Vec::new();
        for (key, value) in &self.values {
            let length = key.len() + value.len() + 2;
            values.extend((length as u32).to_le_bytes());
            values.extend(key.bytes().chain([0]).chain(value.bytes()).chain([0]));
            values.resize(values.len().next_multiple_of(4), 0);
        }
        let descriptor_at = 80 + 24;
        let values_at = descriptor_at + descriptor.len();
        let global_at = (values_at + values.len()).next_multiple_of(8);
        let level_at = (global_at + self.global.len()).next_multiple_of(16);
        let mut out = b"\xabKTX 20\xbb\r\n\x1a\n".to_vec();
        let [width, height, depth] = self.size;
        let (layers, faces, levels) = (self.layers, self.faces, self.levels);
        out.extend(words(&[self.vk_format, 1, width, height, depth]));
        out.extend(words(&[layers, faces, levels, self.scheme]));
        out.extend(words(&[descriptor_at as u32, descriptor.len() as u32]));
        out.extend(words(&[values_at as u32, values.len() as u32]));
        for long in [global_at, self.global.len(), level_at, self.level.len()] {
            out.extend((long as u64).to_le_bytes());
        }
        out.extend(self.unpacked.to_le_bytes());
        out.extend(descriptor);
        out.extend(values);
        out.resize(global_at, 0);
        out.extend(&self.global);
        out.resize(level_at, 0);
        out.extend(&self.level);
        out
    }
}

/// UASTC's mode 8: 16 texels of one colour.
pub fn solid_block([r, g, b, a]: [u8; 4]) -> [u8; 16] {
    const MODE: u128 = 0x17;
    let color = u128::from(u32::from_le_bytes([r, g, b, a]));
    (MODE | color << 5).to_le_bytes()
}

/// Bits from the lowest of the first byte on.
#[derive(Default)]
pub struct Bits {
    pub bytes: Vec<u8>,
    used: usize,
}

impl Bits {
    pub fn put(&mut self, value: u32, count: u32) {
        for i in 0..count {
            if self.used.is_multiple_of(8) {
                self.bytes.push(0);
            }
            let bit = (value >> i & 1) as u8;
            *self.bytes.last_mut().unwrap() |= bit << (self.used % 8);
            self.used += 1;
        }
    }

    pub fn variable(&mut self, mut value: u32, chunk: u32) {
        loop {
            self.put(value & ((1 << chunk) - 1), chunk);
            value >>= chunk;
            self.put(u32::from(value > 0), 1);
            if value == 0 {
                break;
            }
        }
    }
}

/// A canonical prefix code of given lengths: (code, its bits) of each symbol.
pub struct Code(Vec<(u32, u32)>);

impl Code {
    pub fn new(lengths: &[u32]) -> Self {
        let mut codes = vec![(0, 0); lengths.len()];
        let mut next = 0;
        for length in 1..=16 {
            next <<= 1;
            for (code, _) in codes.iter_mut().zip(lengths).filter(|(_, l)| **l == length) {
                *code = (next, length);
                next += 1;
            }
        }
        Self(codes)
    }

    /// For `count` symbols: the first half of them one bit longer than in a code of equal lengths
    /// would be the last ones' due. Complete for any count of at least two.
    pub fn uneven(count: usize) -> (Vec<u32>, Self) {
        let bits = count.next_power_of_two().ilog2();
        let spare = (1 << bits) - count;
        let lengths: Vec<u32> = (0..count)
            .map(|i| if i < spare { bits - 1 } else { bits })
            .collect();
        let code = Self::new(&lengths);
        (lengths, code)
    }

    pub fn put(&self, symbol: usize, bits: &mut Bits) {
        let (code, length) = self.0[symbol];
        bits.put(code.reverse_bits() >> (32 - length), length);
    }
}

/// Writes a table, as the stream has it, with runs where there are any.
pub fn table(lengths: &[u32], bits: &mut Bits) {
    const ORDER: [usize; 21] = [
        17, 18, 19, 20, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15, 16,
    ];
    // Eleven codes of four bits and ten of five are complete.
    let length_lengths: Vec<u32> = (0..21).map(|i| if i < 11 { 4 } else { 5 }).collect();
    let code = Code::new(&length_lengths);
    bits.put(lengths.len() as u32, 14);
    bits.put(21, 5);
    for place in ORDER {
        bits.put(length_lengths[place], 3);
    }
    let mut rest = lengths;
    let mut last = 0;
    while let Some(&length) = rest.first() {
        let run = rest.iter().take_while(|&&l| l == length).count();
        let (symbol, least, most, extra) = match (length, run) {
            (0, 11..) => (18, 11, 138, 7),
            (0, 3..) => (17, 3, 10, 3),
            (_, 7..) if length == last => (20, 7, 134, 7),
            (_, 3..) if length == last => (19, 3, 6, 2),
            _ => (length as usize, 1, 1, 0),
        };
        let taken = run.min(most);
        code.put(symbol, bits);
        bits.put((taken - least) as u32, extra);
        last = length;
        rest = &rest[taken..];
    }
}
