//! Images: PNG, JPEG, WebP and KTX2, told apart by their first bytes and not by what the file calls
//! them.

use super::buffer::Buffers;
use super::error::GltfError;
use super::extension::{ExtensionUse, undeclared};
use super::json::Json;
#[cfg(feature = "basisu")]
use super::ktx2::{self, Ktx2};
use super::notes::Notes;
use super::source::Source;
use crate::scene::{Image, Pixels};
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use rayon::prelude::*;
use std::collections::HashMap;
use std::io::Cursor;
use std::sync::Arc;

/// The images that materials use, in the order of their first use, each read and decoded once.
#[derive(Default)]
pub struct Images {
    images: Vec<Entry>,
    /// From the glTF's index.
    found: HashMap<usize, Found>,
}

struct Entry {
    /// The glTF's index.
    index: usize,
    format: &'static str,
    state: State,
    remarks: Remarks,
}

/// What the container says that a texture may have to say more about.
#[derive(Default)]
struct Remarks {
    /// Whether its colours are coded in sRGB, where it tells.
    srgb: Option<bool>,
    oddities: Vec<&'static str>,
}

enum State {
    /// The bytes of one that has a URI; a buffer view's are where they are.
    Encoded(Format, Option<Vec<u8>>),
    Decoded(Arc<Image>),
}

#[derive(Clone, Copy)]
enum Found {
    /// The index in `Scene::images`.
    Read(usize),
    /// In a format that is not read: the extension that brings it, and its name.
    Left(&'static str, &'static str),
}

impl Images {
    /// The index in `Scene::images` that the image will have.
    pub fn index(
        &mut self,
        index: usize,
        json: &Json<'_>,
        (buffers, source): (&Buffers, &Source),
        extensions: &mut Vec<ExtensionUse>,
        notes: &mut Notes,
    ) -> Result<Option<usize>, GltfError> {
        let found = match self.found.get(&index) {
            Some(&found) => found,
            None => {
                let (bytes, owned) = read(json, buffers, source)?;
                let bytes = owned.as_deref().unwrap_or(bytes);
                let found = match Container::of(bytes) {
                    Some(Container::Read(format)) => {
                        let remarks = match format {
                            Format::Image(_) => Remarks::default(),
                            #[cfg(feature = "basisu")]
                            Format::Ktx2 => ktx2_remarks(json, bytes)?,
                        };
                        self.images.push(Entry {
                            index,
                            format: format.name(),
                            state: State::Encoded(format, owned),
                            remarks,
                        });
                        Found::Read(self.images.len() - 1)
                    }
                    Some(Container::Extension(name, kind)) => Found::Left(name, kind),
                    None => return Err(json.invalid("it is neither PNG, JPEG, WebP nor KTX2")),
                };
                self.found.insert(index, found);
                found
            }
        };
        Ok(match found {
            Found::Read(place) => Some(place),
            Found::Left(name, kind) => {
                undeclared(extensions, name, &json.at);
                notes.add(format!("{kind} images are left out"), &json.at);
                None
            }
        })
    }

    /// What is odd about the image at `place` of `Scene::images` for a texture that takes its colours
    /// as sRGB or as linear; the texture has the last word.
    pub fn remarks(&self, place: usize, srgb: bool) -> impl Iterator<Item = &'static str> {
        let remarks = &self.images[place].remarks;
        let other = match remarks.srgb {
            Some(true) if !srgb => Some("the KTX2 image says sRGB and is used as linear"),
            Some(false) if srgb => Some("the KTX2 image says linear and is used as sRGB"),
            _ => None,
        };
        remarks.oddities.iter().copied().chain(other)
    }

    /// What each is encoded as.
    pub fn formats(&self) -> Vec<&'static str> {
        self.images.iter().map(|entry| entry.format).collect()
    }

    /// All of them, decoded in parallel where they are not yet.
    pub fn decode(
        &mut self,
        root: &Json<'_>,
        buffers: &Buffers,
        source: &Source,
    ) -> Result<Vec<Arc<Image>>, GltfError> {
        let list = root.objects("images")?;
        let decoded: Vec<Result<Arc<Image>, GltfError>> = self
            .images
            .par_iter()
            .map(|entry| match &entry.state {
                State::Decoded(image) => Ok(Arc::clone(image)),
                State::Encoded(format, owned) => {
                    let json = &list[entry.index];
                    let bytes = match owned {
                        Some(bytes) => bytes,
                        None => read(json, buffers, source)?.0,
                    };
                    decode(json, bytes, *format, source).map(Arc::new)
                }
            })
            .collect();
        // In order, so that a file with two faults always shows the same one.
        let decoded = decoded.into_iter().collect::<Result<Vec<_>, _>>()?;
        for (entry, image) in self.images.iter_mut().zip(&decoded) {
            entry.state = State::Decoded(Arc::clone(image));
        }
        Ok(decoded)
    }
}

/// One image by itself, and whether it is a PNG with alpha.
pub fn single(
    json: &Json<'_>,
    buffers: &Buffers,
    source: &Source,
) -> Result<(Image, bool), GltfError> {
    let (bytes, owned) = read(json, buffers, source)?;
    let bytes = owned.as_deref().unwrap_or(bytes);
    match Container::of(bytes) {
        Some(Container::Read(format)) => {
            let image = decode(json, bytes, format, source)?;
            // The byte of the header that holds the kind of colour; 6 is RGBA (ISO/IEC 15948, 11.2.2).
            let png = matches!(format, Format::Image(ImageFormat::Png));
            let alpha = png && bytes.get(25) == Some(&6);
            Ok((image, alpha))
        }
        _ => Err(json.invalid("it is neither PNG, JPEG nor WebP")),
    }
}

/// The encoded bytes: those of a buffer view, or else those that a URI led to.
fn read<'b>(
    json: &Json<'_>,
    buffers: &'b Buffers,
    source: &Source,
) -> Result<(&'b [u8], Option<Vec<u8>>), GltfError> {
    match buffers.view(json, "bufferView")? {
        Some(view) => Ok((view.bytes, None)),
        None => match json.get("uri") {
            Some(uri) => Ok((&[], Some(source.resolve(&uri)?))),
            None => Err(json.invalid("it has neither `uri` nor `bufferView`")),
        },
    }
}

#[derive(Clone, Copy)]
enum Format {
    /// What the crate `image` decodes.
    Image(ImageFormat),
    #[cfg(feature = "basisu")]
    Ktx2,
}

impl Format {
    fn name(self) -> &'static str {
        match self {
            Self::Image(ImageFormat::Png) => "PNG",
            Self::Image(ImageFormat::Jpeg) => "JPEG",
            Self::Image(_) => "WebP",
            #[cfg(feature = "basisu")]
            Self::Ktx2 => "KTX2",
        }
    }
}

enum Container {
    Read(Format),
    /// The extension that brings the format, and the format's name.
    Extension(&'static str, &'static str),
}

impl Container {
    fn image(format: ImageFormat) -> Self {
        Self::Read(Format::Image(format))
    }

    fn of(bytes: &[u8]) -> Option<Self> {
        const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";
        const JPEG: &[u8] = b"\xff\xd8\xff";
        const KTX2: &[u8] = b"\xabKTX 20\xbb\r\n\x1a\n";
        match bytes {
            _ if bytes.starts_with(PNG) => Some(Self::image(ImageFormat::Png)),
            _ if bytes.starts_with(JPEG) => Some(Self::image(ImageFormat::Jpeg)),
            [
                b'R',
                b'I',
                b'F',
                b'F',
                _,
                _,
                _,
                _,
                b'W',
                b'E',
                b'B',
                b'P',
                ..,
            ] => Some(Self::image(ImageFormat::WebP)),
            #[cfg(feature = "basisu")]
            _ if bytes.starts_with(KTX2) => Some(Self::Read(Format::Ktx2)),
            #[cfg(not(feature = "basisu"))]
            _ if bytes.starts_with(KTX2) => Some(Self::Extension("KHR_texture_basisu", "KTX2")),
            _ if bytes.starts_with(b"DDS ") => Some(Self::Extension("MSFT_texture_dds", "DDS")),
            [
                _,
                _,
                _,
                _,
                b'f',
                b't',
                b'y',
                b'p',
                b'a',
                b'v',
                b'i',
                b'f',
                ..,
            ] => Some(Self::Extension("EXT_texture_avif", "AVIF")),
            _ => None,
        }
    }
}

fn decode(
    json: &Json<'_>,
    bytes: &[u8],
    format: Format,
    source: &Source,
) -> Result<Image, GltfError> {
    let format = match format {
        Format::Image(format) => format,
        #[cfg(feature = "basisu")]
        Format::Ktx2 => return decode_ktx2(json, bytes, source),
    };
    let broken = |error: image::ImageError| json.invalid(format!("the image is damaged: {error}"));
    let reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut decoder = reader.into_decoder().map_err(broken)?;
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 {
        return Err(json.invalid(format!("the image is {width} x {height} pixels")));
    }
    let color = decoder.color_type();
    let wide = color.bytes_per_pixel() / color.channel_count() > 1;
    // What the header claims is paid for before anything is decoded: the result, and the decoder's
    // own pixels, which go away again.
    let pixel: u64 = if wide { 8 } else { 4 };
    let size = (u64::from(width) * u64::from(height)).saturating_mul(pixel);
    let budget = &source.budget;
    budget.take(size, json.file(), &json.at)?;
    if decoder.total_bytes() > budget.left() {
        budget.take(decoder.total_bytes(), json.file(), &json.at)?;
    }
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(budget.left());
    decoder.set_limits(limits).map_err(broken)?;
    let image = DynamicImage::from_decoder(decoder).map_err(broken)?;
    Ok(Image {
        name: name(json),
        width,
        height,
        pixels: pixels(image, color),
    })
}

#[cfg(feature = "basisu")]
fn ktx2_remarks(json: &Json<'_>, bytes: &[u8]) -> Result<Remarks, GltfError> {
    let image = Ktx2::read(bytes).map_err(|fault| unreadable(json, fault))?;
    Ok(Remarks {
        srgb: image.srgb,
        oddities: image.oddities,
    })
}

#[cfg(feature = "basisu")]
fn decode_ktx2(json: &Json<'_>, bytes: &[u8], source: &Source) -> Result<Image, GltfError> {
    let image = Ktx2::read(bytes).map_err(|fault| unreadable(json, fault))?;
    source
        .budget
        .take(image.bytes_needed(), json.file(), &json.at)?;
    let pixels = image
        .decode()
        .map_err(|what| unreadable(json, what.into()))?;
    Ok(Image {
        name: name(json),
        width: image.width,
        height: image.height,
        pixels,
    })
}

#[cfg(feature = "basisu")]
fn unreadable(json: &Json<'_>, fault: ktx2::Fault) -> GltfError {
    json.invalid(match fault {
        ktx2::Fault::Damaged(what) => format!("the KTX2 image is damaged: {what}"),
        ktx2::Fault::Refused(what) => what,
    })
}

/// Grey, palette and opaque images become RGBA; 16-bit ones stay 16-bit. Colour profiles are
/// ignored, as glTF 2.0 section 3.8.3 asks.
fn pixels(image: DynamicImage, color: ColorType) -> Pixels {
    match color {
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16 => {
            Pixels::Rgba16(image.into_rgba16().into_raw())
        }
        _ => Pixels::Rgba8(image.into_rgba8().into_raw()),
    }
}

fn name(json: &Json<'_>) -> String {
    match json.string("uri") {
        Ok(Some(uri)) if json.name() == json.at && !uri.starts_with("data:") => uri.to_owned(),
        _ => json.name(),
    }
}
