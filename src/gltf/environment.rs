//! Environment maps: Radiance HDR, OpenEXR and ordinary images, constants, the computed sky, and the
//! map that lights a scene without any light of its own.

use super::error::GltfError;
use super::source::Budget;
use crate::scene::Environment;
use crate::scene::sky::Sky;
use exr::prelude::{ReadChannels as _, ReadLayers as _};
use glam::DVec3;
use image::{DynamicImage, ImageDecoder as _, ImageFormat, ImageReader, Limits};
use std::f64::consts::{PI, TAU};
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// Where light from all around comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum EnvironmentSource {
    File(PathBuf),
    /// The same linear Rec. 709 radiance from everywhere.
    Constant([f32; 3]),
    Sky(Sky),
}

impl EnvironmentSource {
    /// `scene`: the file that an error names where the source is none.
    pub(super) fn load(&self, scene: &Path, budget: &Budget) -> Result<Environment, GltfError> {
        match self {
            Self::File(path) => load_environment_within(path, budget),
            Self::Constant(radiance) => Ok(Environment {
                width: 1,
                height: 1,
                radiance: vec![*radiance],
                strength: 1.0,
                rotation: 0.0,
            }),
            Self::Sky(sky) => {
                let (width, height) = Sky::SIZE;
                budget.take(u64::from(width) * u64::from(height) * TEXEL, scene, "")?;
                Ok(sky.environment())
            }
        }
    }
}

/// Reads an equirectangular map. Ordinary images are decoded from sRGB, white becomes radiance 1.
pub fn load_environment(path: &Path) -> Result<Environment, GltfError> {
    load_environment_within(path, &Budget::new(super::DEFAULT_MAX_MEMORY))
}

pub(super) fn load_environment_within(
    path: &Path,
    budget: &Budget,
) -> Result<Environment, GltfError> {
    let invalid = |what: String| GltfError::Invalid {
        file: path.to_owned(),
        at: String::new(),
        what,
    };
    let bytes = super::source::read_file(path, path, "", budget)?;
    let (width, height, radiance) = if bytes.starts_with(b"\x76\x2f\x31\x01") {
        read_exr(&bytes, path, budget)?
    } else {
        read_image(&bytes, path, budget)?
    };
    if width == 0 || height == 0 {
        return Err(invalid(format!("the map is {width} x {height} pixels")));
    }
    let bad = |texel: &[f32; 3]| texel.iter().any(|value| !value.is_finite() || *value < 0.0);
    if let Some(index) = radiance.iter().position(bad) {
        let (x, y) = (index % width as usize, index / width as usize);
        return Err(invalid(format!(
            "pixel ({x}, {y}) is {:?}: radiance must be finite and not negative",
            radiance[index]
        )));
    }
    Ok(Environment {
        width,
        height,
        radiance,
        strength: 1.0,
        rotation: 0.0,
    })
}

type Pixels = (u32, u32, Vec<[f32; 3]>);

/// Bytes of a texel here, and of the decoder's own copy.
const TEXEL: u64 = 12 + 16;

fn read_exr(bytes: &[u8], path: &Path, budget: &Budget) -> Result<Pixels, GltfError> {
    let broken = |error: exr::error::Error| GltfError::Invalid {
        file: path.to_owned(),
        at: String::new(),
        what: format!("the OpenEXR file cannot be read: {error}"),
    };
    let headers = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false);
    for header in headers.map_err(broken)?.headers {
        let texels = (header.layer_size.0 as u64).saturating_mul(header.layer_size.1 as u64);
        budget.take(texels.saturating_mul(TEXEL), path, "")?;
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |size, _| (size.0, vec![[0.0f32; 3]; size.0 * size.1]),
            |(width, texels): &mut (usize, Vec<[f32; 3]>),
             at,
             (r, g, b, _a): (f32, f32, f32, f32)| {
                texels[at.1 * *width + at.0] = [r, g, b];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(broken)?;
    let size = image.layer_data.size;
    let (_, texels) = image.layer_data.channel_data.pixels;
    Ok((size.0 as u32, size.1 as u32, texels))
}

fn read_image(bytes: &[u8], path: &Path, budget: &Budget) -> Result<Pixels, GltfError> {
    let invalid = |what: String| GltfError::Invalid {
        file: path.to_owned(),
        at: String::new(),
        what,
    };
    let broken = |error: image::ImageError| invalid(format!("the map cannot be read: {error}"));
    let format = match image::guess_format(bytes) {
        Ok(format) => format,
        Err(_) if bytes.starts_with(b"#?") => ImageFormat::Hdr,
        Err(_) => {
            return Err(invalid(
                "it is neither HDR, EXR, PNG, JPEG nor WebP".to_owned(),
            ));
        }
    };
    let reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut decoder = reader.into_decoder().map_err(broken)?;
    let (width, height) = decoder.dimensions();
    budget.take(u64::from(width) * u64::from(height) * TEXEL, path, "")?;
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(budget.left());
    decoder.set_limits(limits).map_err(broken)?;
    let image = DynamicImage::from_decoder(decoder).map_err(broken)?;
    let encoded = !matches!(
        image,
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_)
    );
    let image = image.into_rgb32f();
    let texels = image.pixels().map(|pixel| {
        if encoded {
            pixel.0.map(srgb_decode)
        } else {
            pixel.0
        }
    });
    Ok((width, height, texels.collect()))
}

/// IEC 61966-2-1.
fn srgb_decode(value: f32) -> f32 {
    if value <= 0.04045 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

/// A neutral studio: grey walls that grow brighter upwards, and one broad soft key light from the
/// upper left in front. It is grey, symmetric in nothing, and its mean radiance over all directions
/// is 1, so that a white diffuse surface shows about 1 at the default exposure.
pub fn default_environment() -> Environment {
    const WIDTH: u32 = 64;
    const HEIGHT: u32 = 32;
    // The key light: where it stands, how sharply it ends, how much brighter it is than a wall.
    let key = DVec3::new(-0.5, 0.7, 0.6).normalize();
    const SHARPNESS: f64 = 12.0;
    const KEY: f64 = 6.0;
    let studio = |direction: DVec3| {
        let wall = 0.35 + 0.65 * (0.5 + 0.5 * direction.y);
        wall + KEY * (SHARPNESS * (direction.dot(key) - 1.0)).exp()
    };
    let mut values = Vec::new();
    let (mut sum, mut weights) = (0.0, 0.0);
    for y in 0..HEIGHT {
        for x in 0..WIDTH {
            let theta = (f64::from(y) + 0.5) / f64::from(HEIGHT) * PI;
            let phi = ((f64::from(x) + 0.5) / f64::from(WIDTH) - 0.5) * TAU;
            let (sin, cos) = theta.sin_cos();
            let value = studio(DVec3::new(sin * phi.cos(), cos, sin * phi.sin()));
            sum += value * sin;
            weights += sin;
            values.push(value);
        }
    }
    let scale = weights / sum;
    Environment {
        width: WIDTH,
        height: HEIGHT,
        radiance: values
            .iter()
            .map(|value| [(value * scale) as f32; 3])
            .collect(),
        strength: 1.0,
        rotation: 0.0,
    }
}
