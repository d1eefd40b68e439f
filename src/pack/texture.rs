//! Images to texels, and textures as materials use them.

use super::PackError;
use crate::scene::{self, Filter, Image, Pixels, Scene, Wrap};
use crate::shared::{
    FILTER_LINEAR, FILTER_NEAREST, FORMAT_RGBA8_SRGB, FORMAT_RGBA8_UNORM, FORMAT_RGBA16_UNORM,
    NONE, Texture, WRAP_CLAMP, WRAP_MIRROR, WRAP_REPEAT,
};
use glam::DVec4;
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Weak};

/// The texels of every image that some material uses, each once for each way of decoding it.
#[derive(Clone, Debug, Default)]
pub struct Textures {
    pub texels: Vec<u32>,
    images: BTreeMap<(usize, bool), PlacedImage>,
}

#[derive(Clone, Debug)]
struct PlacedImage {
    first_word: u32,
    size: [u32; 2],
    format: u32,
    /// Mean of the decoded texels, linear.
    mean: DVec4,
}

/// An image by its address, and whether its colours are sRGB.
type ImageKey = (usize, bool);

/// Images that were encoded before. An address is not given to another image while a `Weak` is left.
#[derive(Default)]
pub struct KnownImages {
    encoded: HashMap<ImageKey, (Weak<Image>, Encoded)>,
    /// How many of them the last scene brought.
    pub new: usize,
}

type Encoded = Arc<(Vec<u32>, PlacedImage)>;

impl Textures {
    /// What is `known` is not encoded again, and becomes what this scene needs.
    pub fn gather(scene: &Scene, known: Option<&mut KnownImages>) -> Result<Self, PackError> {
        let mut images: Vec<(usize, bool)> = scene
            .materials
            .iter()
            .flat_map(scene::Material::textures)
            .map(|texture| (texture.image, texture.srgb))
            .collect();
        images.sort_unstable();
        images.dedup();
        let key = |image: usize, srgb| (Arc::as_ptr(&scene.images[image]).addr(), srgb);
        let nothing = HashMap::new();
        let before = known.as_ref().map_or(&nothing, |known| &known.encoded);
        let found: Vec<Option<Encoded>> = images
            .iter()
            .map(|&(image, srgb)| Some(Arc::clone(&before.get(&key(image, srgb))?.1)))
            .collect();
        let new = found.iter().filter(|found| found.is_none()).count();
        let encoded: Vec<Encoded> = images
            .par_iter()
            .zip(found)
            .map(|(&(image, srgb), found)| {
                found.unwrap_or_else(|| Arc::new(encode(&scene.images[image], srgb)))
            })
            .collect();
        if let Some(known) = known {
            known.new = new;
            let rows = images.iter().zip(&encoded);
            known.encoded = rows
                .map(|(&(image, srgb), encoded)| {
                    let identity = Arc::downgrade(&scene.images[image]);
                    (key(image, srgb), (identity, Arc::clone(encoded)))
                })
                .collect();
        }
        let mut textures = Self::default();
        for (key, encoded) in images.into_iter().zip(encoded) {
            let (words, image) = &*encoded;
            let first_word = super::index("texels", textures.texels.len())?;
            textures.texels.extend(words);
            let placed = PlacedImage {
                first_word,
                ..image.clone()
            };
            textures.images.insert(key, placed);
        }
        super::index("texels", textures.texels.len())?;
        Ok(textures)
    }

    /// The record of a texture; one that samples as white for none, and for an image that was not
    /// gathered.
    pub fn record(&self, texture: Option<&scene::Texture>) -> Texture {
        let placed = texture.and_then(|t| Some((t, self.images.get(&(t.image, t.srgb))?)));
        let Some((texture, image)) = placed else {
            return Texture {
                row_u: [1.0, 0.0, 0.0],
                texels: NONE,
                row_v: [0.0, 1.0, 0.0],
                wrap: 0,
                size: [1, 1],
                texcoord: 0,
                format: 0,
            };
        };
        let wrap = |wrap| match wrap {
            Wrap::Repeat => WRAP_REPEAT,
            Wrap::Clamp => WRAP_CLAMP,
            Wrap::Mirror => WRAP_MIRROR,
        };
        let filter = match texture.filter {
            Filter::Nearest => FILTER_NEAREST,
            Filter::Linear => FILTER_LINEAR,
        };
        Texture {
            row_u: texture.rows[0].to_array(),
            texels: image.first_word,
            row_v: texture.rows[1].to_array(),
            wrap: wrap(texture.wrap_s) | wrap(texture.wrap_t) << 2,
            size: image.size,
            texcoord: texture.texcoord as u32,
            format: image.format | filter << 8,
        }
    }

    /// Mean over all texels, linear; white for no texture.
    pub fn mean(&self, texture: Option<&scene::Texture>) -> DVec4 {
        texture
            .and_then(|t| self.images.get(&(t.image, t.srgb)))
            .map_or(DVec4::ONE, |image| image.mean)
    }
}

/// The words of an image, and where it will stand but for the place. Eight bits a channel stay as
/// they are and are decoded when sampled; sixteen bits are decoded here, where they have bits to
/// spare.
fn encode(image: &Image, srgb: bool) -> (Vec<u32>, PlacedImage) {
    let place = |format, mean| PlacedImage {
        first_word: NONE,
        size: [image.width, image.height],
        format,
        mean,
    };
    match &image.pixels {
        Pixels::Rgba8(bytes) => {
            let decode: Vec<f64> = (0..256)
                .map(|byte| decode(f64::from(byte) / 255.0, srgb))
                .collect();
            let (texels, _) = bytes.as_chunks::<4>();
            let sum: DVec4 = texels
                .iter()
                .map(|&[r, g, b, a]| {
                    let color = [r, g, b].map(|byte| decode[usize::from(byte)]);
                    DVec4::new(color[0], color[1], color[2], f64::from(a) / 255.0)
                })
                .sum();
            let words = texels
                .iter()
                .map(|&texel| u32::from_le_bytes(texel))
                .collect();
            let format = if srgb {
                FORMAT_RGBA8_SRGB
            } else {
                FORMAT_RGBA8_UNORM
            };
            (words, place(format, sum / texels.len() as f64))
        }
        Pixels::Rgba16(values) => {
            let (texels, _) = values.as_chunks::<4>();
            let mut sum = DVec4::ZERO;
            let words = texels
                .iter()
                .flat_map(|&texel| {
                    let [r, g, b, a] = texel.map(|value| f64::from(value) / 65535.0);
                    let linear = DVec4::new(decode(r, srgb), decode(g, srgb), decode(b, srgb), a);
                    sum += linear;
                    let [r, g, b, a] = (linear * 65535.0).round().to_array().map(|v| v as u32);
                    [r | g << 16, b | a << 16]
                })
                .collect();
            (words, place(FORMAT_RGBA16_UNORM, sum / texels.len() as f64))
        }
    }
}

/// IEC 61966-2-1, the transfer function of sRGB.
fn decode(encoded: f64, srgb: bool) -> f64 {
    if !srgb {
        encoded
    } else if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}
