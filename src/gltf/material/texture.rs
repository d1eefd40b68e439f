//! A texture as a material uses it: image, sampler, coordinates and their transform.

use super::super::error::GltfError;
use super::super::json::Json;
use super::{MAX_TEXCOORDS, Materials};
use crate::scene::material::IDENTITY_ROWS;
use crate::scene::{Filter, Texture, Wrap};
use glam::Vec3;
use gltf::json::texture::{CLAMP_TO_EDGE, LINEAR, MIRRORED_REPEAT, NEAREST, REPEAT};

/// Extensions whose images are read in place of a texture's own, the better ones first: WebP loses less
/// than the blocks of Basis Universal, and PNG and JPEG are fallbacks beside either.
const READ: &[&str] = if cfg!(feature = "basisu") {
    &["EXT_texture_webp", "KHR_texture_basisu"]
} else {
    &["EXT_texture_webp"]
};

impl Materials<'_> {
    /// The texture that a textureInfo names.
    pub fn file_texture(
        &mut self,
        info: &Json<'_>,
        srgb: bool,
    ) -> Result<Option<Texture>, GltfError> {
        let (_, texture) = info.required("index")?.follow("textures")?;
        let mut source = texture.get("source");
        for name in READ.iter().rev() {
            let extension = texture.extension(name)?;
            source = extension.and_then(|e| e.get("source")).or(source);
        }
        let Some(source) = source else {
            self.notes
                .add("a texture without a readable image is left out", &info.at);
            return Ok(None);
        };
        let (index, image) = source.follow("images")?;
        let Some(image) = self.images.index(
            index,
            &image,
            (self.buffers, self.source),
            self.extensions,
            self.notes,
        )?
        else {
            return Ok(None);
        };
        for remark in self.images.remarks(image, srgb) {
            self.notes.add(remark, &info.at);
        }
        let transform = info.extension("KHR_texture_transform")?;
        let texcoord = match &transform {
            Some(transform) if transform.get("texCoord").is_some() => transform.uint("texCoord")?,
            _ => info.uint("texCoord")?,
        };
        let texcoord = texcoord.unwrap_or(0);
        if texcoord >= MAX_TEXCOORDS as u64 {
            return Err(info.invalid(format!(
                "texCoord is {texcoord}; sets 0 to {} can be used",
                MAX_TEXCOORDS - 1
            )));
        }
        let sampler = texture.reference("sampler", "samplers")?;
        let sampler = sampler.as_ref().map(|(_, sampler)| sampler);
        Ok(Some(Texture {
            image,
            srgb,
            wrap_s: wrap(sampler, "wrapS")?,
            wrap_t: wrap(sampler, "wrapT")?,
            filter: filter(sampler)?,
            texcoord: texcoord as usize,
            rows: transform.as_ref().map_or(Ok(IDENTITY_ROWS), rows)?,
        }))
    }
}

/// KHR_texture_transform: translation * rotation * scale; a positive rotation turns the
/// coordinates counter-clockwise as seen with v pointing down.
fn rows(transform: &Json<'_>) -> Result<[Vec3; 2], GltfError> {
    let [x, y] = transform.vector("offset")?.unwrap_or([0.0, 0.0]);
    let [scale_x, scale_y] = transform.vector("scale")?.unwrap_or([1.0, 1.0]);
    let (sin, cos) = transform.number("rotation")?.unwrap_or(0.0).sin_cos();
    Ok([
        Vec3::new(cos * scale_x, sin * scale_y, x),
        Vec3::new(-sin * scale_x, cos * scale_y, y),
    ])
}

fn wrap(sampler: Option<&Json<'_>>, key: &str) -> Result<Wrap, GltfError> {
    let Some(mode) = sampler.and_then(|sampler| sampler.get(key)) else {
        return Ok(Wrap::Repeat);
    };
    match u32::try_from(mode.as_uint()?) {
        Ok(REPEAT) => Ok(Wrap::Repeat),
        Ok(CLAMP_TO_EDGE) => Ok(Wrap::Clamp),
        Ok(MIRRORED_REPEAT) => Ok(Wrap::Mirror),
        _ => Err(mode.invalid("it is none of 33071, 33648, 10497")),
    }
}

fn filter(sampler: Option<&Json<'_>>) -> Result<Filter, GltfError> {
    let Some(mode) = sampler.and_then(|sampler| sampler.get("magFilter")) else {
        return Ok(Filter::Linear);
    };
    match u32::try_from(mode.as_uint()?) {
        Ok(NEAREST) => Ok(Filter::Nearest),
        Ok(LINEAR) => Ok(Filter::Linear),
        _ => Err(mode.invalid("it is neither 9728 nor 9729")),
    }
}
