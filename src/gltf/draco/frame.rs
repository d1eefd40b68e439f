//! A walk over a Draco stream that reads its sizes and leaves out its values: whether tables of
//! these sizes can be in so many bytes is known before the decoder allocates them.
//!
//! "Draco Bitstream Specification", version 2.2, Google 2017; sections are named below.

use draco_oxide_core::attribute::{AttributeDomain, ComponentDataType};
use draco_oxide_core::bit_coder::Reader;
use draco_oxide_core::codec::header::EncoderMethod;
use draco_oxide_core::types::CornerIdx;
use draco_oxide_core::utils::bit_coder::leb128_read;
use draco_oxide_decoder::connectivity::{
    Connectivity, EdgebreakerConnectivity, decode_connectivity,
};
use draco_oxide_decoder::entropy::start_symbol_decoder;
use draco_oxide_decoder::header::decode_header;

/// Attributes that a stream may have; glTF primitives have a handful.
const MAX_ATTRIBUTES: usize = 32;
/// One byte of a table of frequencies can stand for so many symbols without any.
const SYMBOLS_PER_BYTE: usize = 64;
/// Symbols of 18 bits are the longest.
const MAX_SYMBOLS: usize = 1 << 18;
/// Metadata nested more deeply than any program writes it.
const MAX_NESTING: usize = 16;

/// A stream whose sizes are known and can be.
pub struct Frame {
    pub connectivity: Connectivity,
    pub attributes: usize,
    /// The most that an attribute has.
    pub values: usize,
}

/// A place in a stream.
pub struct Walk<'a> {
    bytes: &'a [u8],
    reader: Reader<'a>,
    method: EncoderMethod,
}

/// An attribute's header.
struct Header {
    component: ComponentDataType,
    components: usize,
    values: usize,
    encoding: u8,
}

/// Reads as far as the sizes of a stream of so many triangles, and how many points a sequential one
/// says that it has; another has three for each triangle at most.
pub fn open(bytes: &[u8], triangles: usize) -> Result<(Walk<'_>, usize), String> {
    let mut reader = Reader::new(bytes);
    let header = decode_header(&mut reader).map_err(text)?;
    let mut walk = Walk {
        bytes,
        reader,
        method: header.encoder_method,
    };
    if header.metadata {
        for _ in 0..walk.number()? {
            walk.number()?;
            walk.metadata(0)?;
        }
        walk.metadata(0)?;
    }
    let points = match walk.method {
        EncoderMethod::Edgebreaker => walk.edgebreaker(triangles).map(|()| 0)?,
        EncoderMethod::Sequential => walk.sequential(triangles)?,
    };
    Ok((walk, points))
}

/// Reads on to the end.
pub fn survey(mut walk: Walk<'_>, points: usize) -> Result<Frame, String> {
    let connectivity = decode_connectivity(&mut walk.reader, walk.method).map_err(text)?;
    let decoders = walk.headers(&connectivity, points)?;
    for headers in &decoders {
        for header in headers {
            walk.values(header)?;
        }
        for header in headers {
            walk.skip(match header.encoding {
                // The minimum, the range and the number of bits; the number of bits.
                2 => 4 * header.components + 5,
                3 => 1,
                _ => 0,
            })?;
        }
    }
    let headers = decoders.iter().flatten();
    Ok(Frame {
        attributes: headers.clone().count(),
        values: headers.map(|header| header.values).max().unwrap_or(0),
        connectivity,
    })
}

fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}

fn too_large(what: &str, size: usize) -> String {
    format!("{what} of {size} cannot be in so few bytes")
}

impl<'a> Walk<'a> {
    fn number(&mut self) -> Result<usize, String> {
        Ok(leb128_read(&mut self.reader).map_err(text)? as usize)
    }

    fn byte(&mut self) -> Result<u8, String> {
        self.reader.read_u8().map_err(text)
    }

    fn skip(&mut self, count: usize) -> Result<(), String> {
        self.reader.read_bytes(count).map(|_| ()).map_err(text)
    }

    /// A second walk from here on; this one stays.
    fn ahead(&self) -> Walk<'a> {
        let bytes = &self.bytes[self.bytes.len() - self.reader.remaining()..];
        Walk {
            bytes,
            reader: Reader::new(bytes),
            method: self.method,
        }
    }

    /// "Metadata Decoder".
    fn metadata(&mut self, level: usize) -> Result<(), String> {
        if level > MAX_NESTING {
            return Err("its metadata is nested too deeply".to_owned());
        }
        for _ in 0..self.number()? {
            let name = self.byte()?;
            self.skip(usize::from(name))?;
            let length = self.number()?;
            self.skip(length)?;
        }
        for _ in 0..self.number()? {
            let name = self.byte()?;
            self.skip(usize::from(name))?;
            self.metadata(level + 1)?;
        }
        Ok(())
    }

    fn agree(&self, triangles: usize, expected: usize) -> Result<(), String> {
        if triangles == expected {
            return Ok(());
        }
        Err(format!(
            "it holds {triangles} triangles and the accessor of its indices {expected}"
        ))
    }

    /// "Sequential Decoder", the sizes only: the number of points.
    fn sequential(&self, expected: usize) -> Result<usize, String> {
        let mut ahead = self.ahead();
        let triangles = ahead.number()?;
        let points = ahead.number()?;
        self.agree(triangles, expected)?;
        if ahead.byte()? == 0 {
            ahead.symbols(3 * triangles, 1)?;
        }
        Ok(points)
    }

    /// "EdgeBreaker Decoder", the sizes only.
    fn edgebreaker(&self, expected: usize) -> Result<(), String> {
        /// Of the traversal whose symbols are sorted by the valence of a vertex, 2 to 7.
        const CONTEXTS: usize = 6;
        const VALENCE: u8 = 2;
        let mut ahead = self.ahead();
        let traversal = ahead.byte()?;
        let vertices = ahead.number()?;
        let triangles = ahead.number()?;
        let seams = usize::from(ahead.byte()?);
        let symbols = ahead.number()?;
        let split_symbols = ahead.number()?;
        self.agree(triangles, expected)?;
        if vertices > 3 * triangles || symbols > triangles || split_symbols > symbols {
            return Err("it has more vertices than corners or more symbols than triangles".into());
        }
        let splits = ahead.number()?;
        if splits > ahead.reader.remaining() / 2 {
            return Err(too_large("a list of splits", splits));
        }
        if traversal != VALENCE {
            return Ok(());
        }
        for _ in 0..2 * splits {
            ahead.number()?;
        }
        ahead.skip(splits.div_ceil(8))?;
        for _ in 0..=seams {
            ahead.bits()?;
        }
        for _ in 0..CONTEXTS {
            match ahead.number()? {
                0 => {}
                count if count <= triangles => ahead.symbols(count, 1)?,
                count => return Err(too_large("a list of symbols", count)),
            }
        }
        Ok(())
    }

    /// A stream of the binary coder: the probability, the length, the bytes.
    fn bits(&mut self) -> Result<(), String> {
        self.byte()?;
        let length = self.number()?;
        self.skip(length)
    }

    /// "Symbol Decoder": `count` symbols, `components` of which share a length.
    fn symbols(&mut self, count: usize, components: usize) -> Result<(), String> {
        let mut ahead = self.ahead();
        if ahead.byte()? == 1 {
            ahead.byte()?;
        }
        let alphabet = ahead.number()?;
        let possible = ahead.reader.remaining().saturating_mul(SYMBOLS_PER_BYTE);
        if alphabet > possible.min(MAX_SYMBOLS) {
            return Err(too_large("an alphabet", alphabet));
        }
        start_symbol_decoder(&mut self.reader, count, components).map_err(text)?;
        Ok(())
    }

    /// "Attributes Decoder": the headers of each decoder's attributes.
    fn headers(
        &mut self,
        connectivity: &Connectivity,
        points: usize,
    ) -> Result<Vec<Vec<Header>>, String> {
        let count = usize::from(self.byte()?);
        let mut values = Vec::new();
        for _ in 0..count {
            values.push(match connectivity {
                Connectivity::Sequential(_) => points,
                Connectivity::Edgebreaker(connectivity) => {
                    let seams = usize::from(self.byte()?);
                    let domain = AttributeDomain::read_from(&mut self.reader).map_err(text)?;
                    self.byte()?;
                    value_count(connectivity, domain, seams)?
                }
            });
        }
        let mut total = 0;
        let mut decoders = Vec::new();
        for values in values {
            let count = self.number()?;
            total += count;
            if count > MAX_ATTRIBUTES || total > MAX_ATTRIBUTES {
                return Err(format!("it has more than {MAX_ATTRIBUTES} attributes"));
            }
            let mut headers = Vec::new();
            for _ in 0..count {
                self.byte()?;
                let component = ComponentDataType::read_from(&mut self.reader).map_err(text)?;
                let components = usize::from(self.byte()?);
                self.byte()?;
                self.number()?;
                if !(1..=4).contains(&components) {
                    return Err(format!("an attribute has {components} components"));
                }
                headers.push(Header {
                    component,
                    components,
                    values,
                    encoding: 0,
                });
            }
            for header in &mut headers {
                header.encoding = self.byte()?;
            }
            decoders.push(headers);
        }
        Ok(decoders)
    }

    /// One attribute's values and what their prediction needs.
    fn values(&mut self, header: &Header) -> Result<(), String> {
        const OCTAHEDRAL: u8 = 3;
        const NO_PREDICTION: u8 = 0xFE;
        const CONSTRAINED_PARALLELOGRAMS: u8 = 4;
        const TEXCOORDS: u8 = 5;
        const NORMALS: u8 = 6;
        /// Creases are kept apart by how many parallelograms there were.
        const PARALLELOGRAMS: usize = 4;
        let components = match header.encoding {
            0 => return self.skip(header.values * header.components * header.component.size()),
            OCTAHEDRAL => 2,
            _ => header.components,
        };
        let count = header.values * components;
        let scheme = self.byte()?;
        let transform = match scheme {
            NO_PREDICTION => None,
            _ => Some(self.byte()?),
        };
        match self.byte()? {
            0 => self.skip(4 * count)?,
            _ => self.symbols(count, components)?,
        }
        let transform = match transform {
            None => return Ok(()),
            Some(transform) => transform,
        };
        match scheme {
            CONSTRAINED_PARALLELOGRAMS => {
                for _ in 0..PARALLELOGRAMS {
                    if self.number()? > 0 {
                        self.bits()?;
                    }
                }
            }
            TEXCOORDS => {
                let count = self.reader.read_u32().map_err(text)? as usize;
                if count > header.values {
                    return Err(too_large("a list of orientations", count));
                }
                self.bits()?;
            }
            _ => {}
        }
        self.transform(transform)?;
        match scheme {
            NORMALS => self.bits(),
            _ => Ok(()),
        }
    }

    /// "Prediction Scheme Transform": its bounds.
    fn transform(&mut self, transform: u8) -> Result<(), String> {
        const WRAP: u8 = 1;
        const OCTAHEDRAL: u8 = 3;
        if !matches!(transform, WRAP | OCTAHEDRAL) {
            return Ok(());
        }
        let a = self.reader.read_u32().map_err(text)? as i32;
        let b = self.reader.read_u32().map_err(text)? as i32;
        let sound = match transform {
            // The least and the greatest value.
            WRAP => a <= b,
            // The greatest value, 2^n - 1, and half of it.
            _ => a > 0 && (i64::from(a) + 1).count_ones() == 1 && b == a / 2,
        };
        match sound {
            true => Ok(()),
            false => Err(format!("an attribute has no values between {a} and {b}")),
        }
    }
}

/// How many values an attribute has whose seams are stream number `seams`.
fn value_count(
    connectivity: &EdgebreakerConnectivity,
    domain: AttributeDomain,
    seams: usize,
) -> Result<usize, String> {
    const POSITIONS: usize = 0xFF;
    let corners = connectivity.vertex_corners.iter();
    let vertices = corners.take(connectivity.num_vertices);
    let vertices = vertices.filter(|&&corner| corner != CornerIdx::INVALID);
    let vertices = vertices.count();
    if domain == AttributeDomain::Position || seams == POSITIONS {
        return Ok(vertices);
    }
    let seams = connectivity.seam_stats.get(seams);
    let seams = seams.ok_or("an attribute names seams that are not there")?;
    Ok(match seams.has_interior {
        true => seams.starts + vertices - seams.fans_with_starts,
        false => vertices,
    })
}
