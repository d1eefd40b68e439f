//! KTX2 images: KTX File Format Specification 2.0, narrowed to what KHR_texture_basisu allows and a
//! little wider: plain texels of 8 or 16 bits a channel are read too. Of the levels only the largest
//! is used.
//!
//! The container is read field by field: `ktx2::Reader` panics at some descriptors.

use super::etc1s::{Codebooks, Streams};
use super::uastc;
use crate::scene::Pixels;
use ktx2::{
    ColorModel, Format, Header, KeyValueDataIterator, LevelIndex, SupercompressionScheme,
    TransferFunction,
};
use rayon::prelude::*;
use ruzstd::decoding::StreamingDecoder;
use std::borrow::Cow;
use std::io::Read as _;

/// What is wrong with the data, said after "the KTX2 image is damaged:".
pub type Damaged = &'static str;

/// Why an image cannot be had.
#[derive(Debug)]
pub enum Fault {
    /// It breaks the format's rules.
    Damaged(Damaged),
    /// It is whole, and not a picture that glTF can mean.
    Refused(String),
}

impl From<Damaged> for Fault {
    fn from(what: Damaged) -> Self {
        Self::Damaged(what)
    }
}

/// An image whose container was read and whose sizes were compared with its bytes.
pub struct Ktx2<'a> {
    bytes: &'a [u8],
    pub width: u32,
    pub height: u32,
    /// What its descriptor says that the colours are coded in: sRGB or linear; `None` for neither.
    pub srgb: Option<bool>,
    /// Rules of KHR_texture_basisu that it breaks without harm, for the notes.
    pub oddities: Vec<&'static str>,
    coding: Coding,
    levels: u32,
    scheme: Option<SupercompressionScheme>,
    level: LevelIndex,
    global: &'a [u8],
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Coding {
    Etc1s(Second),
    Uastc(Second),
    /// The place of red, green, blue and alpha in a texel of so many channels.
    Plain {
        channels: usize,
        places: [Option<usize>; 4],
        wide: bool,
    },
}

/// What the second slice, or the fourth channel of UASTC, holds.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Second {
    Nothing,
    Alpha,
    Green,
}

const SIDE: u32 = 4;

impl<'a> Ktx2<'a> {
    pub fn read(bytes: &'a [u8]) -> Result<Self, Fault> {
        /// Blocks are counted and texels addressed with 32 bits.
        const MAX_SIDE: u32 = 1 << 16;
        let header = bytes
            .first_chunk::<{ Header::LENGTH }>()
            .ok_or("it ends in its header")?;
        let header = Header::from_bytes(header)
            .map_err(|_| Fault::Damaged("its width or its number of faces is zero"))?;
        let kind = match header {
            _ if header.pixel_depth > 0 => Some("a volume"),
            _ if header.pixel_height == 0 => Some("a one-dimensional texture"),
            _ if header.face_count > 1 => Some("a cube map"),
            _ if header.layer_count > 0 => Some("an array of textures"),
            _ => None,
        };
        if let Some(kind) = kind {
            return Err(Fault::Refused(format!(
                "the KTX2 image is {kind}, and glTF's textures are plain two-dimensional ones"
            )));
        }
        let (width, height) = (header.pixel_width, header.pixel_height);
        if width.max(height) > MAX_SIDE {
            return Err(Fault::Refused(format!(
                "the KTX2 image is {width} x {height} texels and sides of up to {MAX_SIDE} are read"
            )));
        }
        let levels = header.level_count.max(1);
        let index_bytes = LevelIndex::LENGTH as u64 * u64::from(levels);
        let level = part(bytes, Header::LENGTH as u64, index_bytes)
            .and_then(|index| index.first_chunk::<{ LevelIndex::LENGTH }>())
            .ok_or("it ends in its list of levels")?;
        let descriptor = part(
            bytes,
            header.index.dfd_byte_offset,
            header.index.dfd_byte_length,
        )
        .ok_or("its descriptor lies outside")?;
        let descriptor = Descriptor::read(descriptor).ok_or("its descriptor is cut off")?;
        let coding = coding(&header, &descriptor)?;
        let mut ktx2 = Self {
            bytes,
            width,
            height,
            srgb: match TransferFunction::new(descriptor.transfer) {
                Some(TransferFunction::SRGB) => Some(true),
                Some(TransferFunction::Linear) => Some(false),
                _ => None,
            },
            oddities: Vec::new(),
            coding,
            levels,
            scheme: header.supercompression_scheme,
            level: LevelIndex::from_bytes(level),
            global: part(
                bytes,
                header.index.sgd_byte_offset,
                header.index.sgd_byte_length,
            )
            .ok_or("its global data lie outside")?,
        };
        ktx2.check()?;
        let values = part(
            bytes,
            header.index.kvd_byte_offset,
            header.index.kvd_byte_length,
        )
        .ok_or("its key and value data lie outside")?;
        ktx2.oddities.extend(oddities(values, &ktx2));
        Ok(ktx2)
    }

    /// Everything about sizes that can be known before anything is decoded.
    fn check(&self) -> Result<(), Fault> {
        let stored = self.stored()?.len() as u64;
        match self.scheme {
            None if stored < self.unpacked_bytes() => Err("its largest level is too short".into()),
            Some(SupercompressionScheme::Zstandard)
                if self.level.uncompressed_byte_length < self.unpacked_bytes() =>
            {
                Err("its largest level is too short once unpacked".into())
            }
            _ => Ok(()),
        }
    }

    /// The largest level as it is stored.
    fn stored(&self) -> Result<&'a [u8], Damaged> {
        let LevelIndex {
            byte_offset,
            byte_length,
            ..
        } = self.level;
        part(self.bytes, byte_offset, byte_length).ok_or("its largest level lies outside")
    }

    fn blocks(&self) -> [usize; 2] {
        [self.width, self.height].map(|side| side.div_ceil(SIDE) as usize)
    }

    /// Bytes of the largest level without supercompression; none for BasisLZ, which has no such form.
    fn unpacked_bytes(&self) -> u64 {
        let bytes = match self.coding {
            Coding::Etc1s(_) => 0,
            Coding::Uastc(_) => self.blocks().iter().product::<usize>() * uastc::BLOCK,
            Coding::Plain { channels, wide, .. } => {
                let texels = self.width as usize * self.height as usize;
                texels * channels * if wide { 2 } else { 1 }
            }
        };
        bytes as u64
    }

    /// What decoding takes: the texels, and the unpacking of the level.
    pub fn bytes_needed(&self) -> u64 {
        let wide = matches!(self.coding, Coding::Plain { wide: true, .. });
        let texel = if wide { 8 } else { 4 };
        let unpacked = match self.scheme {
            // And as much again for the window that Zstandard looks back through.
            Some(SupercompressionScheme::Zstandard) => 2 * self.unpacked_bytes(),
            _ => 0,
        };
        u64::from(self.width) * u64::from(self.height) * texel + unpacked
    }

    /// The texels of the largest level in rows from the top.
    pub fn decode(&self) -> Result<Pixels, Damaged> {
        let stored = self.stored()?;
        let data = match self.scheme {
            Some(SupercompressionScheme::Zstandard) => {
                let size = self.unpacked_bytes() as usize;
                // Every decoder of the format grants windows of this size.
                const WINDOW: u64 = 8 << 20;
                let window = self.unpacked_bytes().max(WINDOW);
                let mut frame = StreamingDecoder::new_with_max_window_size(stored, window)
                    .map_err(|_| "its Zstandard frame cannot be read")?;
                let mut unpacked = Vec::with_capacity(size);
                frame
                    .by_ref()
                    .take(size as u64)
                    .read_to_end(&mut unpacked)
                    .map_err(|_| "its Zstandard frame is damaged")?;
                if unpacked.len() < size {
                    return Err("its Zstandard frame holds too little");
                }
                Cow::Owned(unpacked)
            }
            _ => Cow::Borrowed(stored),
        };
        match self.coding {
            Coding::Etc1s(second) => self.etc1s(&data, second).map(Pixels::Rgba8),
            Coding::Uastc(second) => self.uastc(&data, second).map(Pixels::Rgba8),
            Coding::Plain {
                channels,
                places,
                wide: false,
            } => Ok(Pixels::Rgba8(plain(
                &data[..self.unpacked_bytes() as usize],
                channels,
                places,
            ))),
            Coding::Plain {
                channels,
                places,
                wide: true,
            } => {
                let (values, _) = data[..self.unpacked_bytes() as usize].as_chunks::<2>();
                let values: Vec<u16> = values.iter().map(|&v| u16::from_le_bytes(v)).collect();
                Ok(Pixels::Rgba16(plain(&values, channels, places)))
            }
        }
    }

    /// KTX2, "BasisLZ Global Data": a header, five words for each level, three streams.
    fn etc1s(&self, level: &[u8], second: Second) -> Result<Vec<u8>, Damaged> {
        const HEADER: usize = 20;
        const IMAGE: usize = 20;
        const PREDICTED_FROM_ANOTHER_FRAME: u32 = 2;
        let short = "its global data are too short";
        let word = |at: usize| -> Result<u32, Damaged> {
            let bytes = self.global.get(at..).and_then(|rest| rest.first_chunk());
            bytes.map(|&bytes| u32::from_le_bytes(bytes)).ok_or(short)
        };
        let counts = word(0)?;
        let mut at = HEADER + IMAGE * self.levels as usize;
        let mut stream = |length: u32| -> Result<&[u8], Damaged> {
            let bytes = part(self.global, at as u64, u64::from(length)).ok_or(short)?;
            at += bytes.len();
            Ok(bytes)
        };
        let codebooks = Codebooks::read(&Streams {
            endpoint_count: (counts & 0xffff) as usize,
            selector_count: (counts >> 16) as usize,
            endpoints: stream(word(4)?)?,
            selectors: stream(word(8)?)?,
            tables: stream(word(12)?)?,
        })?;
        if word(HEADER)? & PREDICTED_FROM_ANOTHER_FRAME != 0 {
            return Err("it is a frame of a video that needs another one");
        }
        let slice = |at: usize| -> Result<&[u8], Damaged> {
            let (offset, length) = (word(HEADER + at)?, word(HEADER + at + 4)?);
            part(level, offset, length).ok_or("a slice of it lies outside its level")
        };
        let mut rgba = vec![255; 4 * self.width as usize * self.height as usize];
        let blocks = self.blocks();
        codebooks.slice(slice(4)?, blocks, |x, y, texels| {
            self.put(&mut rgba, x, y, |i, out| {
                out[..3].copy_from_slice(&texels[i])
            });
        })?;
        if second == Second::Nothing {
            return Ok(rgba);
        }
        codebooks.slice(slice(12)?, blocks, |x, y, texels| {
            self.put(&mut rgba, x, y, |i, out| match second {
                Second::Green => [out[1], out[2]] = [texels[i][1], 0],
                _ => out[3] = texels[i][1],
            });
        })?;
        Ok(rgba)
    }

    /// Hands the texels of a block to `texel(number in the block, RGBA)`, as far as there are rows and
    /// columns of them.
    fn put(&self, rgba: &mut [u8], x: usize, y: usize, texel: impl Fn(usize, &mut [u8])) {
        const N: usize = SIDE as usize;
        let width = self.width as usize;
        let height = rgba.len() / (4 * width);
        for row in 0..N.min(height - N * y) {
            let first = 4 * ((N * y + row) * width + N * x);
            let count = N.min(width - N * x);
            for (column, out) in rgba[first..][..4 * count].chunks_mut(4).enumerate() {
                texel(N * row + column, out);
            }
        }
    }

    fn uastc(&self, data: &[u8], second: Second) -> Result<Vec<u8>, Damaged> {
        let [blocks_x, _] = self.blocks();
        let row_bytes = SIDE as usize * 4 * self.width as usize;
        let mut rgba = vec![0; 4 * self.width as usize * self.height as usize];
        let (blocks, _) = data.as_chunks::<{ uastc::BLOCK }>();
        rgba.par_chunks_mut(row_bytes)
            .zip(blocks.par_chunks(blocks_x))
            .try_for_each(|(row, blocks)| {
                for (x, &block) in blocks.iter().enumerate() {
                    let texels = uastc::texels(block)?;
                    self.put(row, x, 0, |i, out| {
                        let [r, g, b, a] = texels[i];
                        out.copy_from_slice(&match second {
                            Second::Nothing => [r, g, b, 255],
                            Second::Alpha => [r, g, b, a],
                            Second::Green => [r, a, 0, 255],
                        });
                    });
                }
                Ok(())
            })?;
        Ok(rgba)
    }
}

/// RGBA of texels that have some of the channels: 0 for a colour that is not there, opaque.
fn plain<T: Copy + Default + Opaque>(
    values: &[T],
    channels: usize,
    places: [Option<usize>; 4],
) -> Vec<T> {
    values
        .chunks_exact(channels)
        .flat_map(|texel| {
            let [r, g, b, a] = places.map(|place| place.map(|place| texel[place]));
            [
                r.unwrap_or_default(),
                g.unwrap_or_default(),
                b.unwrap_or_default(),
                a.unwrap_or(T::OPAQUE),
            ]
        })
        .collect()
}

trait Opaque {
    const OPAQUE: Self;
}

impl Opaque for u8 {
    const OPAQUE: Self = u8::MAX;
}

impl Opaque for u16 {
    const OPAQUE: Self = u16::MAX;
}

fn part(bytes: &[u8], offset: impl Into<u64>, length: impl Into<u64>) -> Option<&[u8]> {
    let first = offset.into();
    let last = first.checked_add(length.into())?;
    bytes.get(usize::try_from(first).ok()?..usize::try_from(last).ok()?)
}

/// The basic block of a data format descriptor: Khronos Data Format Specification 1.3, section 5.
struct Descriptor {
    model: u8,
    transfer: u8,
    /// What each sample holds, in the numbers of the colour model.
    channels: Vec<u8>,
}

impl Descriptor {
    fn read(bytes: &[u8]) -> Option<Self> {
        const TOTAL_SIZE: usize = 4;
        const SIZE: usize = 6;
        const MODEL: usize = 8;
        const TRANSFER: usize = 10;
        const SAMPLES: usize = 24;
        const SAMPLE: usize = 16;
        const CHANNEL: usize = 3;
        let block = bytes.get(TOTAL_SIZE..)?;
        let size = u16::from_le_bytes([*block.get(SIZE)?, *block.get(SIZE + 1)?]);
        let samples = block.get(SAMPLES..usize::from(size))?;
        Some(Self {
            model: block[MODEL],
            transfer: block[TRANSFER],
            channels: samples
                .chunks_exact(SAMPLE)
                .map(|sample| sample[CHANNEL] & 0xf)
                .collect(),
        })
    }
}

/// How the texels are coded. `Format::new` is `None` for VK_FORMAT_UNDEFINED, which Basis Universal's
/// formats have.
fn coding(header: &Header, descriptor: &Descriptor) -> Result<Coding, Fault> {
    const ETC1S_GREEN: u8 = 4;
    const UASTC_RGBA: u8 = 3;
    const UASTC_RRRG: u8 = 5;
    let refused = |what: String| Err(Fault::Refused(what));
    let scheme = header.supercompression_scheme;
    let model = ColorModel::new(descriptor.model);
    if header.format.is_none() && model == Some(ColorModel::ETC1S) {
        if scheme != Some(SupercompressionScheme::BasisLZ) {
            return Err("ETC1S without BasisLZ is not defined".into());
        }
        return Ok(Coding::Etc1s(match descriptor.channels[..] {
            [_] => Second::Nothing,
            [_, ETC1S_GREEN] => Second::Green,
            [_, _] => Second::Alpha,
            _ => return Err("its descriptor has neither one slice nor two".into()),
        }));
    }
    match scheme {
        None | Some(SupercompressionScheme::Zstandard) => {}
        Some(SupercompressionScheme::BasisLZ) => {
            return Err("BasisLZ is defined for ETC1S only".into());
        }
        Some(other) => {
            return refused(format!(
                "the KTX2 image is packed by scheme {}, and BasisLZ and Zstandard are read",
                other.value()
            ));
        }
    }
    let Some(format) = header.format else {
        return match (model, descriptor.channels.first()) {
            (Some(ColorModel::UASTC), Some(&UASTC_RGBA)) => Ok(Coding::Uastc(Second::Alpha)),
            (Some(ColorModel::UASTC), Some(&UASTC_RRRG)) => Ok(Coding::Uastc(Second::Green)),
            (Some(ColorModel::UASTC), Some(_)) => Ok(Coding::Uastc(Second::Nothing)),
            _ => refused(format!(
                "the KTX2 image has the color model {}, and ETC1S and UASTC are read",
                descriptor.model
            )),
        };
    };
    const R: [Option<usize>; 4] = [Some(0), None, None, None];
    const RG: [Option<usize>; 4] = [Some(0), Some(1), None, None];
    const RGB: [Option<usize>; 4] = [Some(0), Some(1), Some(2), None];
    const BGR: [Option<usize>; 4] = [Some(2), Some(1), Some(0), None];
    const RGBA: [Option<usize>; 4] = [Some(0), Some(1), Some(2), Some(3)];
    const BGRA: [Option<usize>; 4] = [Some(2), Some(1), Some(0), Some(3)];
    let (channels, places, wide) = match format {
        Format::R8_UNORM | Format::R8_SRGB => (1, R, false),
        Format::R8G8_UNORM | Format::R8G8_SRGB => (2, RG, false),
        Format::R8G8B8_UNORM | Format::R8G8B8_SRGB => (3, RGB, false),
        Format::B8G8R8_UNORM | Format::B8G8R8_SRGB => (3, BGR, false),
        Format::R8G8B8A8_UNORM | Format::R8G8B8A8_SRGB => (4, RGBA, false),
        Format::B8G8R8A8_UNORM | Format::B8G8R8A8_SRGB => (4, BGRA, false),
        Format::R16_UNORM => (1, R, true),
        Format::R16G16_UNORM => (2, RG, true),
        Format::R16G16B16_UNORM => (3, RGB, true),
        Format::R16G16B16A16_UNORM => (4, RGBA, true),
        other => {
            return refused(format!(
                "the KTX2 image has the format {other:?}, and ETC1S, UASTC and plain texels of 8 or \
                 16 bits are read"
            ));
        }
    };
    Ok(Coding::Plain {
        channels,
        places,
        wide,
    })
}

/// KHR_texture_basisu asks for whole blocks, for rows from the top, and for no swizzle.
fn oddities(values: &[u8], ktx2: &Ktx2<'_>) -> Vec<&'static str> {
    let mut found = Vec::new();
    if !(ktx2.width.is_multiple_of(SIDE) && ktx2.height.is_multiple_of(SIDE)) {
        found.push("the sides of the KTX2 image are no multiples of four, which glTF asks for");
    }
    let other = |key: &str, expected: &[u8]| {
        KeyValueDataIterator::new(values).any(|(name, value)| {
            name == key && value.strip_suffix(b"\0").unwrap_or(value) != expected
        })
    };
    if other("KTXorientation", b"rd") {
        found.push("the KTX2 image says that its rows are in another order than glTF's");
    }
    if other("KTXswizzle", b"rgba") {
        found.push("the KTX2 image asks for a swizzle, which glTF forbids and the picture has not");
    }
    found
}
