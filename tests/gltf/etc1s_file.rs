//! ETC1S slices and their codebooks, written in code for the reader to read.
#![allow(dead_code, reason = "each test binary uses the parts that it needs")]

use crate::ktx2_file::{BASIS_LZ, Bits, Code, ETC1S, Ktx2File, UNDEFINED, table};

/// What the blocks choose from.
#[derive(Clone)]
pub struct Books {
    /// Five bits a channel, and the table of modifiers.
    pub endpoints: Vec<([u8; 3], u8)>,
    pub selectors: Vec<[u8; 4]>,
    /// How the selectors are stored: plainly, or as differences.
    pub raw: bool,
    /// All channels of each endpoint are equal, and stored once.
    pub grey: bool,
}

/// (endpoint, selectors) of each block in rows.
pub type Blocks = Vec<(usize, usize)>;

const HISTORY: usize = 11;

impl Books {
    fn endpoint_stream(&self) -> Vec<u8> {
        let mut bits = Bits::default();
        let codes = [32, 32, 32, 8].map(Code::uneven);
        for (lengths, _) in &codes {
            table(lengths, &mut bits);
        }
        bits.put(u32::from(self.grey), 1);
        let (mut color, mut modifiers) = ([16; 3], 0);
        for &(next, next_modifiers) in &self.endpoints {
            codes[3]
                .1
                .put(usize::from((next_modifiers + 8 - modifiers) & 7), &mut bits);
            modifiers = next_modifiers;
            for channel in 0..if self.grey { 1 } else { 3 } {
                let code = match color[channel] {
                    0..=9 => 0,
                    10..=21 => 1,
                    _ => 2,
                };
                let delta = (next[channel] + 32 - color[channel]) & 31;
                codes[code].1.put(usize::from(delta), &mut bits);
                color[channel] = next[channel];
            }
        }
        bits.bytes
    }

    fn selector_stream(&self) -> Vec<u8> {
        let mut bits = Bits::default();
        bits.put(u32::from(self.raw) << 2, 3);
        let (lengths, code) = Code::uneven(256);
        if !self.raw {
            table(&lengths, &mut bits);
        }
        let mut last = [0; 4];
        for (i, rows) in self.selectors.iter().enumerate() {
            for (row, last) in rows.iter().zip(last) {
                if self.raw || i == 0 {
                    bits.put(u32::from(*row), 8);
                } else {
                    code.put(usize::from(row ^ last), &mut bits);
                }
            }
            last = *rows;
        }
        bits.bytes
    }

    fn codes(&self) -> [(Vec<u32>, Code); 4] {
        [
            Code::uneven(257),
            Code::uneven(self.endpoints.len().max(2)),
            Code::uneven(self.selectors.len() + HISTORY + 1),
            Code::uneven(64),
        ]
    }

    fn table_stream(&self) -> Vec<u8> {
        let mut bits = Bits::default();
        for (lengths, _) in self.codes() {
            table(&lengths, &mut bits);
        }
        bits.put(HISTORY as u32, 13);
        bits.bytes
    }

    /// The blocks of a slice; endpoints of neighbours, recent selectors and runs are used where
    /// they can be.
    fn slice(&self, blocks: &Blocks, [blocks_x, blocks_y]: [usize; 2]) -> Vec<u8> {
        let endpoint = |x: usize, y: usize| blocks[y * blocks_x + x].0;
        // 0 left, 1 above, 2 above left, 3 a difference.
        let prediction = |x: usize, y: usize| -> usize {
            if x >= blocks_x || y >= blocks_y {
                return 0;
            }
            let wanted = endpoint(x, y);
            match () {
                () if x > 0 && endpoint(x - 1, y) == wanted => 0,
                () if y > 0 && endpoint(x, y - 1) == wanted => 1,
                () if x > 0 && y > 0 && endpoint(x - 1, y - 1) == wanted => 2,
                () => 3,
            }
        };
        let quad = |x: usize, y: usize| {
            prediction(x, y)
                | prediction(x + 1, y) << 2
                | prediction(x, y + 1) << 4
                | prediction(x + 1, y + 1) << 6
        };
        let quads: Vec<usize> = (0..blocks_y)
            .step_by(2)
            .flat_map(|y| (0..blocks_x).step_by(2).map(move |x| quad(x, y)))
            .collect();
        let [predictions, deltas, choices, runs] = self.codes().map(|(_, code)| code);
        let mut bits = Bits::default();
        let mut next_quad = 0;
        let (mut symbol, mut repeats) = (0, 0);
        let (mut recent, mut rover) = (vec![0; HISTORY], HISTORY / 2);
        let (mut previous, mut run) = (0, 0);
        for (i, &(wanted, selector)) in blocks.iter().enumerate() {
            let (x, y) = (i % blocks_x, i / blocks_x);
            if x % 2 == 0 && y % 2 == 0 {
                if repeats > 0 {
                    repeats -= 1;
                } else {
                    let same = quads[next_quad..]
                        .iter()
                        .take_while(|q| **q == symbol)
                        .count();
                    if same >= 3 {
                        predictions.put(256, &mut bits);
                        bits.variable(same as u32 - 3, 4);
                        repeats = same - 1;
                    } else {
                        symbol = quads[next_quad];
                        predictions.put(symbol, &mut bits);
                    }
                }
                next_quad += 1;
            }
            if prediction(x, y) == 3 {
                let count = self.endpoints.len();
                deltas.put((wanted + count - previous) % count, &mut bits);
            }
            previous = wanted;
            if run > 0 {
                run -= 1;
                continue;
            }
            let same = blocks[i..]
                .iter()
                .take_while(|(_, s)| *s == recent[0])
                .count();
            if selector == recent[0] && same >= 3 {
                choices.put(self.selectors.len() + HISTORY, &mut bits);
                if same - 3 < 63 {
                    runs.put(same - 3, &mut bits);
                } else {
                    runs.put(63, &mut bits);
                    bits.variable(same as u32 - 3, 7);
                }
                run = same - 1;
            } else if let Some(place) = recent.iter().position(|r| *r == selector) {
                choices.put(self.selectors.len() + place, &mut bits);
                recent.swap(place, place / 2);
            } else {
                choices.put(selector, &mut bits);
                recent[rover] = selector;
                rover += 1;
                if rover == HISTORY {
                    rover = HISTORY / 2;
                }
            }
        }
        bits.bytes
    }

    /// RGB of a block's texels in rows.
    pub fn texels(&self, (endpoint, selectors): (usize, usize)) -> [[u8; 3]; 16] {
        const SMALL: [i32; 8] = [2, 5, 9, 13, 18, 24, 33, 47];
        const LARGE: [i32; 8] = [8, 17, 29, 42, 60, 80, 106, 183];
        let (color, modifiers) = self.endpoints[endpoint];
        let (small, large) = (SMALL[modifiers as usize], LARGE[modifiers as usize]);
        std::array::from_fn(|i| {
            let selector = self.selectors[selectors][i / 4] >> (2 * (i % 4)) & 3;
            let added = [-large, -small, small, large][selector as usize];
            color.map(|five| {
                let eight = i32::from(five) * 8 + i32::from(five) / 4;
                (eight + added).clamp(0, 255) as u8
            })
        })
    }

    /// A file of one or two slices.
    pub fn file(&self, size: [u32; 2], slices: &[&Blocks], channels: &[u8]) -> Ktx2File {
        let blocks = size.map(|side| side.div_ceil(4) as usize);
        let streams = [
            self.endpoint_stream(),
            self.selector_stream(),
            self.table_stream(),
        ];
        let mut level = Vec::new();
        let mut places = [0; 4];
        for (i, slice) in slices.iter().enumerate() {
            let bytes = self.slice(slice, blocks);
            places[2 * i] = level.len() as u32;
            places[2 * i + 1] = bytes.len() as u32;
            level.extend(bytes);
        }
        let [endpoints, selectors, tables] = streams.each_ref().map(|s| s.len() as u32);
        let counts = self.endpoints.len() as u32 | (self.selectors.len() as u32) << 16;
        let head = [counts, endpoints, selectors, tables, 0, 0];
        let mut global: Vec<u8> = head
            .into_iter()
            .chain(places)
            .flat_map(u32::to_le_bytes)
            .collect();
        global.extend(streams.concat());
        Ktx2File {
            scheme: BASIS_LZ,
            color_model: ETC1S,
            channels: channels.to_vec(),
            global,
            unpacked: 0,
            ..Ktx2File::new(UNDEFINED, size, level)
        }
    }
}
