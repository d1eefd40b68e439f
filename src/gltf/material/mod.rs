//! Materials and the textures that they use.

mod extensions;
mod factor;
mod query;
mod texture;

pub use query::material_of_query;

use super::buffer::Buffers;
use super::error::GltfError;
use super::extension::ExtensionUse;
use super::image::Images;
use super::json::Json;
use super::notes::Notes;
use super::source::Source;
use crate::scene::bsdf_model::BsdfModel;
use crate::scene::{
    AlphaMode, Material, MetallicRoughness, Model, SpecularGlossiness, Texture, Textured,
};
use extensions::{EXTENSIONS, extensions, ior};
use factor::{color, known_keys, strength};
use glam::{Vec3, Vec4};
use serde::Deserialize as _;

/// No mesh of a glTF in use has more sets of texture coordinates than this.
pub const MAX_TEXCOORDS: usize = 16;

/// The index of refraction behind glTF's reflectance of 0.04 (KHR_materials_ior).
const DEFAULT_IOR: f32 = 1.5;

/// What a reader of materials does with what is not a number in its range.
trait Policy<'a> {
    /// The texture of a textureInfo; `None` for one that is left out.
    fn texture(&mut self, info: &Json<'a>, srgb: bool) -> Result<Option<Texture>, GltfError>;

    /// Something that cannot be drawn as it is told: `what` it is, and what `becomes` of it.
    fn doubt(&mut self, at: &Json<'a>, what: &str, becomes: &str) -> Result<(), GltfError>;
}

/// Reads the materials of a file; collects the images that they need.
pub struct Materials<'s> {
    pub images: &'s mut Images,
    pub buffers: &'s Buffers,
    pub source: &'s Source,
    pub extensions: &'s mut Vec<ExtensionUse>,
    pub notes: &'s mut Notes,
}

impl Materials<'_> {
    pub fn material(&mut self, json: &Json<'_>) -> Result<Material, GltfError> {
        let read = material(json, self)?;
        if let Model::MetallicRoughness(model) = &read.model
            && model.extensions.clearcoat.coat.factor > 0.0
            && read.emissive != Vec3::ZERO
        {
            self.notes.add(
                "a clear coat does not dim what the surface under it emits",
                &json.at,
            );
        }
        Ok(read)
    }
}

/// A file is drawn all the same, and says so.
impl<'a> Policy<'a> for Materials<'_> {
    fn texture(&mut self, info: &Json<'a>, srgb: bool) -> Result<Option<Texture>, GltfError> {
        self.file_texture(info, srgb)
    }

    fn doubt(&mut self, at: &Json<'a>, what: &str, becomes: &str) -> Result<(), GltfError> {
        self.notes.add(format!("{what} {becomes}"), &at.at);
        Ok(())
    }
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
            extensions: Box::default(),
        }),
        alpha_mode: AlphaMode::Opaque,
        double_sided: false,
        emissive: Vec3::ZERO,
        emissive_texture: None,
        normal_texture: None,
        normal_scale: 1.0,
    }
}

fn material<'a>(json: &Json<'a>, policy: &mut dyn Policy<'a>) -> Result<Material, GltfError> {
    known_keys(
        json,
        &[
            "name",
            "pbrMetallicRoughness",
            "normalTexture",
            "occlusionTexture",
            "emissiveTexture",
            "emissiveFactor",
            "alphaMode",
            "alphaCutoff",
            "doubleSided",
        ],
        policy,
    )?;
    let model = model(json, policy)?;
    let (normal_texture, normal_scale) = normal_texture(json, "normalTexture", policy)?;
    if let Some(occlusion) = json.get("occlusionTexture") {
        policy.doubt(
            &occlusion,
            "occlusionTexture",
            "is ignored: a path tracer finds the occlusion itself",
        )?;
    }
    Ok(Material {
        name: json.name(),
        model,
        alpha_mode: alpha_mode(json)?,
        double_sided: json.boolean("doubleSided")?.unwrap_or(false),
        emissive: emissive(json)?,
        emissive_texture: texture(json, "emissiveTexture", true, policy)?,
        normal_texture,
        normal_scale,
    })
}

/// The reflection model: of several, the one that the others are stand-ins for.
fn model<'a>(json: &Json<'a>, policy: &mut dyn Policy<'a>) -> Result<Model, GltfError> {
    if let Some(extension) = json.extension("KHR_materials_pbrSpecularGlossiness")? {
        return Ok(Model::SpecularGlossiness(specular_glossiness(
            json, &extension, policy,
        )?));
    }
    let pbr = json.object_or_empty("pbrMetallicRoughness")?;
    let keys = [
        "baseColorFactor",
        "baseColorTexture",
        "metallicFactor",
        "roughnessFactor",
        "metallicRoughnessTexture",
    ];
    known_keys(&pbr, &keys, policy)?;
    let base_color = Vec4::from(color(&pbr, "baseColorFactor", [1.0; 4], policy)?);
    let base_color_texture = texture(&pbr, "baseColorTexture", true, policy)?;
    if let Some(extension) = json.extension("SNELL_materials_bsdf")? {
        let bsdf = BsdfModel::deserialize(extension.value())
            .map_err(|error| extension.invalid(error.to_string()))?;
        return Ok(Model::Bsdf {
            bsdf,
            base_color,
            base_color_texture,
        });
    }
    if json.extension("KHR_materials_unlit")?.is_some() {
        return Ok(Model::Unlit {
            base_color,
            base_color_texture,
        });
    }
    let ior = ior(json, policy)?;
    Ok(Model::MetallicRoughness(MetallicRoughness {
        base_color,
        base_color_texture,
        metallic: strength(&pbr, "metallicFactor", 1.0, policy)?,
        roughness: strength(&pbr, "roughnessFactor", 1.0, policy)?,
        metallic_roughness_texture: texture(&pbr, "metallicRoughnessTexture", false, policy)?,
        ior,
        extensions: Box::new(extensions(json, ior, policy)?),
    }))
}

/// KHR_materials_pbrSpecularGlossiness, archived. Clients that know it use it instead of
/// metallic-roughness, and no other extension of the model goes with it.
fn specular_glossiness<'a>(
    json: &Json<'a>,
    extension: &Json<'a>,
    policy: &mut dyn Policy<'a>,
) -> Result<SpecularGlossiness, GltfError> {
    let keys = [
        "diffuseFactor",
        "diffuseTexture",
        "specularFactor",
        "glossinessFactor",
        "specularGlossinessTexture",
    ];
    known_keys(extension, &keys, policy)?;
    for name in EXTENSIONS {
        if let Some(other) = json.extension(name)? {
            policy.doubt(
                &other,
                &format!("{name} beside KHR_materials_pbrSpecularGlossiness"),
                "is left out: the two exclude each other",
            )?;
        }
    }
    Ok(SpecularGlossiness {
        diffuse: Textured {
            factor: color(extension, "diffuseFactor", [1.0; 4], policy)?.into(),
            texture: texture(extension, "diffuseTexture", true, policy)?,
        },
        specular: Textured {
            factor: color(extension, "specularFactor", [1.0; 3], policy)?.into(),
            texture: texture(extension, "specularGlossinessTexture", true, policy)?,
        },
        glossiness: strength(extension, "glossinessFactor", 1.0, policy)?,
    })
}

/// The texture of a textureInfo property.
fn texture<'a>(
    json: &Json<'a>,
    key: &str,
    srgb: bool,
    policy: &mut dyn Policy<'a>,
) -> Result<Option<Texture>, GltfError> {
    match json.object(key)? {
        Some(info) => policy.texture(&info, srgb),
        None => Ok(None),
    }
}

/// A normalTextureInfo property: the texture, and the factor on its x and y.
fn normal_texture<'a>(
    json: &Json<'a>,
    key: &str,
    policy: &mut dyn Policy<'a>,
) -> Result<(Option<Texture>, f32), GltfError> {
    let scale = match json.object(key)? {
        Some(info) => info.number("scale")?.unwrap_or(1.0),
        None => 1.0,
    };
    Ok((texture(json, key, false, policy)?, scale))
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
