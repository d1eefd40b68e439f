//! ETC1S under BasisLZ supercompression: Khronos Data Format Specification 1.4, "ETC1S", and KTX File
//! Format Specification 2.0, section "BasisLZ Global Data" with the bit stream that it defines.
//!
//! Read here and not by the transcoder of its authors (C++), which ends the process at streams that
//! break its assertions; tests compare the two.

use super::ktx2::Damaged;

/// Rows of a codebook, and the codes of the slices that refer to them.
pub struct Codebooks {
    endpoints: Vec<Endpoint>,
    /// Four rows from the top, two bits a texel from the left.
    selectors: Vec<[u8; 4]>,
    predictions: Huffman,
    deltas: Huffman,
    choices: Huffman,
    runs: Huffman,
    history: usize,
}

/// A base colour of five bits a channel, and the row of `MODIFIERS`.
#[derive(Clone, Copy, Default)]
struct Endpoint {
    color: [u8; 3],
    table: u8,
}

/// What is added to a block's colour, by its table and a texel's selector.
const MODIFIERS: [[i32; 4]; 8] = [
    [-8, -2, 2, 8],
    [-17, -5, 5, 17],
    [-29, -9, 9, 29],
    [-42, -13, 13, 42],
    [-60, -18, 18, 60],
    [-80, -24, 24, 80],
    [-106, -33, 33, 106],
    [-183, -47, 47, 183],
];

const DAMAGED_CODES: Damaged = "its Huffman tables are damaged";
const DAMAGED_BLOCKS: Damaged = "its block data are damaged";

/// The three streams that the slices of a file share, with the number of entries of the first two.
pub struct Streams<'a> {
    pub endpoints: &'a [u8],
    pub endpoint_count: usize,
    pub selectors: &'a [u8],
    pub selector_count: usize,
    pub tables: &'a [u8],
}

impl Codebooks {
    /// Counts are of 16 bits, so that the codebooks take little.
    pub fn read(streams: &Streams<'_>) -> Result<Self, Damaged> {
        let endpoints = endpoints(streams)?;
        let selectors = selectors(streams)?;
        if endpoints.is_empty() || selectors.is_empty() {
            return Err("its codebooks are empty");
        }
        let mut bits = Bits::new(streams.tables);
        let mut table = || Huffman::read(&mut bits)?.ok_or(DAMAGED_CODES);
        let (predictions, deltas, choices, runs) = (table()?, table()?, table()?, table()?);
        let history = bits.take(13)? as usize;
        if history == 0 {
            return Err(DAMAGED_CODES);
        }
        Ok(Self {
            endpoints,
            selectors,
            predictions,
            deltas,
            choices,
            runs,
            history,
        })
    }

    /// Decodes the blocks of a slice in rows from the top and hands each one's 4 x 4 texels to
    /// `put(block x, block y, texels in rows)`.
    pub fn slice(
        &self,
        data: &[u8],
        [blocks_x, blocks_y]: [usize; 2],
        mut put: impl FnMut(usize, usize, [[u8; 3]; 16]),
    ) -> Result<(), Damaged> {
        /// Where a block's endpoint comes from.
        const LEFT: u32 = 0;
        const ABOVE: u32 = 1;
        const ABOVE_LEFT: u32 = 2;
        const REPEAT_PREDICTION: u32 = 256;
        const SHORTEST_REPEAT: u32 = 3;
        const LONG_RUN: u32 = 63;
        const SHORTEST_RUN: u32 = 3;

        let mut bits = Bits::new(data);
        let mut recent = Recent::new(self.history);
        let run_symbol = self.selectors.len() + self.history;
        // One symbol predicts 2 x 2 blocks: the upper two by its low bits, the lower two by its high
        // ones, which wait here for the next row.
        let mut lower = vec![0; blocks_x.div_ceil(2)];
        let (mut symbol, mut repeats) = (0, 0);
        let mut above = vec![0; blocks_x];
        let mut row = vec![0; blocks_x];
        let mut previous = 0;
        let mut run = 0;
        for y in 0..blocks_y {
            let mut predictions = 0;
            for x in 0..blocks_x {
                if x % 2 == 0 {
                    predictions = if y % 2 == 1 {
                        lower[x / 2]
                    } else {
                        if repeats > 0 {
                            repeats -= 1;
                        } else {
                            match self.predictions.symbol(&mut bits)? {
                                REPEAT_PREDICTION => {
                                    repeats = bits.variable(4)?.saturating_add(SHORTEST_REPEAT - 1);
                                }
                                read if read < REPEAT_PREDICTION => symbol = read,
                                _ => return Err(DAMAGED_BLOCKS),
                            }
                        }
                        lower[x / 2] = symbol >> 4;
                        symbol
                    };
                }
                let endpoint = match predictions & 3 {
                    LEFT if x > 0 => previous,
                    ABOVE if y > 0 => above[x],
                    ABOVE_LEFT if x > 0 && y > 0 => above[x - 1],
                    LEFT | ABOVE | ABOVE_LEFT => return Err(DAMAGED_BLOCKS),
                    _ => {
                        let sum = previous + self.deltas.symbol(&mut bits)? as usize;
                        if sum < self.endpoints.len() {
                            sum
                        } else {
                            sum - self.endpoints.len()
                        }
                    }
                };
                predictions >>= 2;
                row[x] = endpoint;
                previous = endpoint;

                let choice = if run > 0 {
                    run -= 1;
                    self.selectors.len()
                } else {
                    match self.choices.symbol(&mut bits)? as usize {
                        choice if choice == run_symbol => {
                            let length = match self.runs.symbol(&mut bits)? {
                                LONG_RUN => bits.variable(7)?,
                                short => short,
                            };
                            run = length.saturating_add(SHORTEST_RUN - 1);
                            self.selectors.len()
                        }
                        choice => choice,
                    }
                };
                let selector = match choice.checked_sub(self.selectors.len()) {
                    Some(place) => recent.take(place).ok_or(DAMAGED_BLOCKS)?,
                    None => {
                        recent.add(choice);
                        choice
                    }
                };
                let endpoint = self.endpoints.get(endpoint).ok_or(DAMAGED_BLOCKS)?;
                let selectors = self.selectors.get(selector).ok_or(DAMAGED_BLOCKS)?;
                put(x, y, endpoint.texels(selectors));
            }
            std::mem::swap(&mut above, &mut row);
        }
        Ok(())
    }
}

impl Endpoint {
    fn texels(self, selectors: &[u8; 4]) -> [[u8; 3]; 16] {
        let colors = MODIFIERS[usize::from(self.table)].map(|modifier| {
            self.color.map(|five| {
                let eight = five << 3 | five >> 2;
                (i32::from(eight) + modifier).clamp(0, 255) as u8
            })
        });
        std::array::from_fn(|i| {
            let selector = selectors[i / 4] >> (2 * (i % 4)) & 3;
            colors[usize::from(selector)]
        })
    }
}

/// Each channel is coded as the difference to that of the entry before, by one of three codes for a
/// dark, a middling and a bright one.
fn endpoints(streams: &Streams<'_>) -> Result<Vec<Endpoint>, Damaged> {
    let mut bits = Bits::new(streams.endpoints);
    let mut table = || Huffman::read(&mut bits)?.ok_or(DAMAGED_CODES);
    let (dark, middling, bright, tables) = (table()?, table()?, table()?, table()?);
    let grey = bits.take(1)? == 1;
    let mut entry = Endpoint {
        color: [16; 3],
        table: 0,
    };
    let channels = if grey { 1 } else { 3 };
    (0..streams.endpoint_count)
        .map(|_| {
            let delta = tables.symbol(&mut bits)? as u8;
            entry.table = entry.table.wrapping_add(delta) & 7;
            for channel in &mut entry.color[..channels] {
                let code = match *channel {
                    0..=9 => &dark,
                    10..=21 => &middling,
                    _ => &bright,
                };
                *channel = channel.wrapping_add(code.symbol(&mut bits)? as u8) & 31;
            }
            let [red, ..] = entry.color;
            Ok(Endpoint {
                color: if grey { [red; 3] } else { entry.color },
                table: entry.table,
            })
        })
        .collect()
}

/// Whole bytes, or differences (exclusive or) to those of the entry before.
fn selectors(streams: &Streams<'_>) -> Result<Vec<[u8; 4]>, Damaged> {
    let mut bits = Bits::new(streams.selectors);
    let (global, hybrid, raw) = (bits.take(1)?, bits.take(1)?, bits.take(1)?);
    if global == 1 || hybrid == 1 {
        return Err("its selectors refer to a codebook that no file has");
    }
    let code = if raw == 1 {
        None
    } else {
        Huffman::read(&mut bits)?
    };
    let mut rows = [0; 4];
    (0..streams.selector_count)
        .map(|entry| {
            for row in &mut rows {
                *row = match &code {
                    Some(code) if entry > 0 => *row ^ code.symbol(&mut bits)? as u8,
                    None if entry > 0 && raw == 0 => return Err(DAMAGED_CODES),
                    _ => bits.take(8)? as u8,
                };
            }
            Ok(rows)
        })
        .collect()
}

/// The selectors of late: new ones replace each other in the rear half, those used again move ahead.
struct Recent {
    entries: Vec<usize>,
    next: usize,
}

impl Recent {
    fn new(size: usize) -> Self {
        Self {
            entries: vec![0; size],
            next: size / 2,
        }
    }

    fn add(&mut self, entry: usize) {
        self.entries[self.next] = entry;
        self.next += 1;
        if self.next == self.entries.len() {
            self.next /= 2;
        }
    }

    fn take(&mut self, place: usize) -> Option<usize> {
        let entry = *self.entries.get(place)?;
        self.entries.swap(place, place / 2);
        Some(entry)
    }
}

/// A canonical prefix code.
struct Huffman {
    /// How many symbols have codes of each length; the first is of length 0.
    counts: [u32; Self::LONGEST + 1],
    /// By length of code, then by value.
    symbols: Vec<u32>,
}

impl Huffman {
    const LONGEST: usize = 16;

    /// From the length of each symbol's code, 0 for none. A code of a single symbol need not use all
    /// of its bits.
    fn new(lengths: &[u8]) -> Result<Self, Damaged> {
        let mut counts = [0; Self::LONGEST + 1];
        for &length in lengths {
            *counts.get_mut(usize::from(length)).ok_or(DAMAGED_CODES)? += 1;
        }
        counts[0] = 0;
        let used: u32 = counts.iter().sum();
        let space: u64 = (1..)
            .zip(&counts[1..])
            .map(|(length, &count)| u64::from(count) << (Self::LONGEST - length))
            .sum();
        if space != 1 << Self::LONGEST && used != 1 {
            return Err(DAMAGED_CODES);
        }
        let mut symbols: Vec<u32> = (0..)
            .zip(lengths)
            .filter_map(|(symbol, &length)| (length > 0).then_some(symbol))
            .collect();
        symbols.sort_by_key(|&symbol| lengths[symbol as usize]);
        Ok(Self { counts, symbols })
    }

    /// The lengths are themselves coded, with runs; `None` for a table of no symbols.
    fn read(bits: &mut Bits<'_>) -> Result<Option<Self>, Damaged> {
        /// What the lengths of the length codes belong to, in the order of the stream.
        const ORDER: [usize; 21] = [
            17, 18, 19, 20, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15, 16,
        ];
        let count = bits.take(14)? as usize;
        if count == 0 {
            return Ok(None);
        }
        let mut lengths = [0; ORDER.len()];
        let sent = bits.take(5)? as usize;
        for &place in ORDER.get(..sent).ok_or(DAMAGED_CODES)? {
            lengths[place] = bits.take(3)? as u8;
        }
        let code = Self::new(&lengths)?;
        let mut lengths = Vec::with_capacity(count);
        while lengths.len() < count {
            let last = lengths.last().copied().filter(|&length| length > 0);
            let (length, times) = match code.symbol(bits)? {
                17 => (0, 3 + bits.take(3)?),
                18 => (0, 11 + bits.take(7)?),
                19 => (last.ok_or(DAMAGED_CODES)?, 3 + bits.take(2)?),
                20 => (last.ok_or(DAMAGED_CODES)?, 7 + bits.take(7)?),
                length => (length as u8, 1),
            };
            lengths.extend(std::iter::repeat_n(length, times as usize));
        }
        if lengths.len() > count {
            return Err(DAMAGED_CODES);
        }
        Self::new(&lengths).map(Some)
    }

    fn symbol(&self, bits: &mut Bits<'_>) -> Result<u32, Damaged> {
        // `code` is compared with the first code of each length.
        let (mut code, mut first, mut index) = (0, 0, 0);
        for &count in &self.counts[1..] {
            code = code << 1 | bits.take(1)?;
            first <<= 1;
            if code - first < count {
                return Ok(self.symbols[(index + code - first) as usize]);
            }
            first += count;
            index += count;
        }
        Err(DAMAGED_CODES)
    }
}

/// Bits from the lowest of the first byte on.
struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Bits<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    /// The next `count` bits, at most 14, the first one lowest.
    fn take(&mut self, count: usize) -> Result<u32, Damaged> {
        let end = self.at + count;
        if end > 8 * self.bytes.len() {
            return Err("its data end too early");
        }
        let first = self.at / 8;
        let word = (0..3).fold(0, |word, i| {
            let byte = self.bytes.get(first + i).copied().unwrap_or(0);
            word | u32::from(byte) << (8 * i)
        });
        let value = word >> (self.at % 8) & ((1 << count) - 1);
        self.at = end;
        Ok(value)
    }

    /// Groups of `chunk` bits, the lowest first, each followed by a bit that says whether more come.
    fn variable(&mut self, chunk: usize) -> Result<u32, Damaged> {
        let mut value = 0;
        for shift in (0..32 - chunk).step_by(chunk) {
            value |= self.take(chunk)? << shift;
            if self.take(1)? == 0 {
                return Ok(value);
            }
        }
        Err(DAMAGED_BLOCKS)
    }
}
