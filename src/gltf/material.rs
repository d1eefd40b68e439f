//! Materials and the textures that they use.

use super::error::GltfError;
use super::extension::ExtensionUse;
use super::image::Images;
use super::json::Json;
use super::notes::Notes;
use crate::scene::bsdf_model::{Alpha, BsdfModel, Distribution};
use crate::scene::{AlphaMode, Filter, Material, MetallicRoughness, Model, Texture, Wrap};
use glam::{Vec3, Vec4};
use gltf::json::texture::{CLAMP_TO_EDGE, LINEAR, MIRRORED_REPEAT, NEAREST, REPEAT};
use serde::Deserialize as _;

/// No mesh of a glTF in use has more sets of texture coordinates than this.
pub const MAX_TEXCOORDS: usize = 16;

/// Reads materials; collects the images that they need.
pub struct Materials<'s, 'a> {
    pub images: Images<'a>,
    pub extensions: &'s mut Vec<ExtensionUse>,
    pub notes: &'s mut Notes,
}

/// glTF 2.0 section 3.9.6: what a primitive without a material gets.
pub fn default_material() -> Material {
    Material {
        name: "default".to_owned(),
        model: Model::MetallicRoughness(MetallicRoughness {
            base_color: Vec4::ONE,
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            ior: DEFAULT_IOR,
        }),
        alpha_mode: AlphaMode::Opaque,
        double_sided: false,
        emissive: Vec3::ZERO,
        emissive_texture: None,
        normal_texture: None,
        normal_scale: 1.0,
    }
}

/// The index of refraction behind glTF's reflectance of 0.04 (KHR_materials_ior).
const DEFAULT_IOR: f32 = 1.5;

impl<'a> Materials<'_, 'a> {
    pub fn material(&mut self, json: &Json<'a>) -> Result<Material, GltfError> {
        let pbr = json.object("pbrMetallicRoughness")?;
        let color = |key| match &pbr {
            Some(pbr) => self_color(pbr, key),
            None => Ok(Vec4::ONE),
        };
        let base_color = color("baseColorFactor")?;
        let base_color_texture = self.optional(pbr.as_ref(), "baseColorTexture", true)?;
        let model = if let Some(extension) = json.extension("SNELL_materials_bsdf")? {
            let bsdf = BsdfModel::deserialize(extension.value())
                .map_err(|error| extension.invalid(error.to_string()))?;
            Model::Bsdf {
                bsdf,
                base_color,
                base_color_texture,
            }
        } else if json.extension("KHR_materials_unlit")?.is_some() {
            Model::Unlit {
                base_color,
                base_color_texture,
            }
        } else {
            let factor = |key, notes: &mut Notes| match &pbr {
                Some(pbr) => unit(pbr, key, notes),
                None => Ok(1.0),
            };
            Model::MetallicRoughness(MetallicRoughness {
                base_color,
                base_color_texture,
                metallic: factor("metallicFactor", self.notes)?,
                roughness: factor("roughnessFactor", self.notes)?,
                metallic_roughness_texture: self.optional(
                    pbr.as_ref(),
                    "metallicRoughnessTexture",
                    false,
                )?,
                ior: ior(json)?,
            })
        };
        let normal_scale = match json.object("normalTexture")? {
            Some(info) => info.number("scale")?.unwrap_or(1.0),
            None => 1.0,
        };
        if json.get("occlusionTexture").is_some() {
            self.notes.add(
                "occlusionTexture is ignored: a path tracer finds the occlusion itself",
                &json.at,
            );
        }
        Ok(Material {
            name: json.name(),
            model,
            alpha_mode: alpha_mode(json)?,
            double_sided: json.boolean("doubleSided")?.unwrap_or(false),
            emissive: emissive(json)?,
            emissive_texture: self.optional(Some(json), "emissiveTexture", true)?,
            normal_texture: self.optional(Some(json), "normalTexture", false)?,
            normal_scale,
        })
    }

    /// The texture of a textureInfo property.
    fn optional(
        &mut self,
        owner: Option<&Json<'a>>,
        key: &str,
        srgb: bool,
    ) -> Result<Option<Texture>, GltfError> {
        let Some(info) = owner.map(|owner| owner.object(key)).transpose()?.flatten() else {
            return Ok(None);
        };
        let (_, texture) = info.required("index")?.follow("textures")?;
        let webp = texture.extension("EXT_texture_webp")?;
        let source = match webp.as_ref().and_then(|webp| webp.get("source")) {
            Some(source) => Some(source),
            None => texture.get("source"),
        };
        let Some(source) = source else {
            self.notes
                .add("a texture without a readable image is left out", &info.at);
            return Ok(None);
        };
        let (index, image) = source.follow("images")?;
        let Some(image) = self
            .images
            .index(index, image, self.extensions, self.notes)?
        else {
            return Ok(None);
        };
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
            rows: transform.as_ref().map_or(Ok(IDENTITY), rows)?,
        }))
    }
}

const IDENTITY: [Vec3; 2] = [Vec3::X, Vec3::Y];

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

fn alpha_mode(json: &Json<'_>) -> Result<AlphaMode, GltfError> {
    match json.string("alphaMode")? {
        None | Some("OPAQUE") => Ok(AlphaMode::Opaque),
        Some("BLEND") => Ok(AlphaMode::Blend),
        Some("MASK") => Ok(AlphaMode::Mask {
            cutoff: json.number("alphaCutoff")?.unwrap_or(0.5),
        }),
        Some(other) => Err(json.invalid(format!(
            "alphaMode is `{other}`, none of OPAQUE, MASK, BLEND"
        ))),
    }
}

/// Never negative; glTF allows 0 to 1, and more is taken as it is.
fn self_color(json: &Json<'_>, key: &str) -> Result<Vec4, GltfError> {
    let color = Vec4::from(json.vector(key)?.unwrap_or([1.0; 4]));
    Ok(color.max(Vec4::ZERO))
}

/// A factor from 0 to 1, 1 by default; what lies outside is moved to the nearer end.
fn unit(json: &Json<'_>, key: &str, notes: &mut Notes) -> Result<f32, GltfError> {
    let value = json.number(key)?.unwrap_or(1.0);
    let inside = value.clamp(0.0, 1.0);
    if inside != value {
        notes.add("a factor outside of 0 to 1 is clamped", &json.place(key));
    }
    Ok(inside)
}

fn emissive(json: &Json<'_>) -> Result<Vec3, GltfError> {
    let factor = Vec3::from(json.vector("emissiveFactor")?.unwrap_or([0.0; 3]));
    let strength = match json.extension("KHR_materials_emissive_strength")? {
        Some(extension) => extension.number("emissiveStrength")?.unwrap_or(1.0),
        None => 1.0,
    };
    let emissive = factor * strength;
    if emissive.is_finite() && emissive.min_element() >= 0.0 {
        Ok(emissive)
    } else {
        Err(json.invalid("its emission is negative or not finite"))
    }
}

/// KHR_materials_ior: 1 or more, or 0 for a surface that reflects everything.
fn ior(json: &Json<'_>) -> Result<f32, GltfError> {
    let Some(extension) = json.extension("KHR_materials_ior")? else {
        return Ok(DEFAULT_IOR);
    };
    let ior = extension.number("ior")?.unwrap_or(DEFAULT_IOR);
    if ior == 0.0 || ior >= 1.0 {
        Ok(ior)
    } else {
        Err(extension.invalid(format!("ior is {ior}; it must be 0 or at least 1")))
    }
}

/// Which texture's coordinates the tangents must follow, where the material needs tangents: the
/// normal texture's, or the first set's for a lobe that is not round.
pub fn tangent_source(material: &Material) -> Option<(usize, [Vec3; 2])> {
    if let Some(texture) = &material.normal_texture {
        return Some((texture.texcoord, texture.rows));
    }
    let Model::Bsdf { bsdf, .. } = &material.model else {
        return None;
    };
    let distribution = match bsdf {
        BsdfModel::Dielectric { distribution, .. } | BsdfModel::Conductor { distribution, .. } => {
            distribution.as_ref()?
        }
        BsdfModel::TorranceSparrow { distribution, .. } => distribution,
        _ => return None,
    };
    let round = match distribution {
        Distribution::Blinn { .. } => true,
        Distribution::AshikhminShirley { exponent } => exponent[0] == exponent[1],
        Distribution::Beckmann { alpha } | Distribution::Ggx { alpha } => match alpha {
            Alpha::Isotropic(_) => true,
            Alpha::Anisotropic([x, y]) => x == y,
        },
    };
    (!round).then_some((0, IDENTITY))
}

/// Sets of texture coordinates that the material's textures read: the highest, plus one.
pub fn texcoord_count(material: &Material) -> usize {
    let (first, second) = match &material.model {
        Model::MetallicRoughness(model) => {
            (&model.base_color_texture, &model.metallic_roughness_texture)
        }
        Model::Unlit {
            base_color_texture, ..
        }
        | Model::Bsdf {
            base_color_texture, ..
        } => (base_color_texture, &None),
    };
    [
        first,
        second,
        &material.emissive_texture,
        &material.normal_texture,
    ]
    .into_iter()
    .flatten()
    .map(|texture| texture.texcoord + 1)
    .max()
    .unwrap_or(0)
}
