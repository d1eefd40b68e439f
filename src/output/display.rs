//! Formats for displays (PNG, JPEG, WebP: 8 bits of sRGB after a tone map) and Radiance HDR.

use image::codecs::hdr::HdrEncoder;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::codecs::webp::WebPEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageResult, Rgb};

use super::tonemap::srgb_encode;
use super::{Channels, Format, Look, OutputError};
use crate::film::{Film, FilmPixel};

/// JPEG quality: visually lossless, still a third of a PNG.
const JPEG_QUALITY: u8 = 95;

/// 8-bit sRGB; straight alpha where the background is transparent.
pub fn png(film: &Film, channels: Channels, look: Look) -> Result<Vec<u8>, OutputError> {
    with_alpha_or_not(film, Format::Png, channels, look, |bytes, pixels, color| {
        PngEncoder::new_with_quality(bytes, CompressionType::Default, FilterType::Adaptive)
            .write_image(pixels, film.width, film.height, color)
    })
}

/// Lossless WebP of what `png` holds.
pub fn webp(film: &Film, channels: Channels, look: Look) -> Result<Vec<u8>, OutputError> {
    with_alpha_or_not(
        film,
        Format::Webp,
        channels,
        look,
        |bytes, pixels, color| {
            WebPEncoder::new_lossless(bytes).write_image(pixels, film.width, film.height, color)
        },
    )
}

/// 8-bit sRGB; JPEG has no alpha, so a transparent background shows black.
pub fn jpeg(film: &Film, look: Look) -> Result<Vec<u8>, OutputError> {
    let pixels: Vec<u8> = film
        .pixels
        .iter()
        .flat_map(|p| rgb8(p, 1.0, look))
        .collect();
    encoded(Format::Jpeg, |bytes| {
        JpegEncoder::new_with_quality(bytes, JPEG_QUALITY).write_image(
            &pixels,
            film.width,
            film.height,
            ExtendedColorType::Rgb8,
        )
    })
}

/// Linear radiance with a shared exponent (Ward 1991, "Real Pixels"): 8 bits of mantissa a channel.
pub fn hdr(film: &Film) -> Result<Vec<u8>, OutputError> {
    let pixels: Vec<Rgb<f32>> = film
        .pixels
        .iter()
        .map(|p| Rgb(p.mean().map(|x| finite_or_black(x) as f32)))
        .collect();
    encoded(Format::Hdr, |bytes| {
        HdrEncoder::new(bytes).encode(&pixels, film.width as usize, film.height as usize)
    })
}

fn with_alpha_or_not(
    film: &Film,
    format: Format,
    channels: Channels,
    look: Look,
    write: impl FnOnce(&mut Vec<u8>, &[u8], ExtendedColorType) -> ImageResult<()>,
) -> Result<Vec<u8>, OutputError> {
    let (pixels, color): (Vec<u8>, _) = if channels.transparent {
        let rgba = film.pixels.iter().flat_map(|p| {
            let alpha = finite_or_black(p.coverage()).clamp(0.0, 1.0);
            let [r, g, b] = rgb8(p, alpha, look);
            [r, g, b, quantize(alpha)]
        });
        (rgba.collect(), ExtendedColorType::Rgba8)
    } else {
        let rgb = film.pixels.iter().flat_map(|p| rgb8(p, 1.0, look));
        (rgb.collect(), ExtendedColorType::Rgb8)
    };
    encoded(format, |bytes| write(bytes, &pixels, color))
}

/// The colour of a pixel as sRGB code values, freed of the `alpha` that it was multiplied with.
fn rgb8(pixel: &FilmPixel, alpha: f64, look: Look) -> [u8; 3] {
    if alpha <= 0.0 {
        return [0; 3];
    }
    let scale = look.exposure_ev.exp2() / alpha;
    let shown = look.tonemap.apply(pixel.mean().map(|x| x * scale));
    shown.map(|x| quantize(srgb_encode(x)))
}

/// [0, 1] to the nearest of 256 values.
fn quantize(x: f64) -> u8 {
    (x * 255.0).round() as u8
}

/// A pixel without any finite sample shows black; the film has counted its samples.
fn finite_or_black(x: f64) -> f64 {
    if x.is_finite() { x } else { 0.0 }
}

fn encoded(
    format: Format,
    write: impl FnOnce(&mut Vec<u8>) -> ImageResult<()>,
) -> Result<Vec<u8>, OutputError> {
    let mut bytes = Vec::new();
    write(&mut bytes).map_err(|e| OutputError::Encode {
        format: format.name(),
        reason: e.to_string(),
    })?;
    Ok(bytes)
}
