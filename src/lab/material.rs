//! A query's material: a glTF material object without textures, or one of the lecture's models.

use crate::cpu;
use crate::pack::model::{ModelError, lower_bsdf};
use crate::scene::bsdf_model::BsdfModel;
use crate::shared::{
    BSDF_GLTF, BSDF_UNLIT, Bsdf, DISTRIBUTION_GGX, FRESNEL_SCHLICK, MASKING_SMITH, Material,
};
use bytemuck::Zeroable;
use glam::Vec4;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::{Map, Value};

#[derive(Debug, PartialEq, thiserror::Error)]
pub enum MaterialError {
    #[error("{0}")]
    Json(String),
    #[error(transparent)]
    Model(#[from] ModelError),
    #[error(
        "a query is about one point of a surface and takes no textures; give factors instead of `{0}`"
    )]
    Texture(&'static str),
    #[error("the extension `{0}` is not supported")]
    Extension(String),
    #[error("`{name}` is {value}, but must be {range}")]
    Range {
        name: &'static str,
        value: f32,
        range: &'static str,
    },
}

/// glTF 2.0, 5.19 "Material". What does not reflect light (emission, coverage, sidedness) is read and
/// has no effect.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
struct GltfMaterial {
    #[serde(default)]
    pbr_metallic_roughness: MetallicRoughness,
    normal_texture: Option<IgnoredAny>,
    occlusion_texture: Option<IgnoredAny>,
    emissive_texture: Option<IgnoredAny>,
    #[serde(default)]
    extensions: Map<String, Value>,
    #[serde(rename = "name")]
    _name: Option<String>,
    #[serde(rename = "emissiveFactor")]
    _emissive_factor: Option<[f32; 3]>,
    #[serde(rename = "alphaMode")]
    _alpha_mode: Option<String>,
    #[serde(rename = "alphaCutoff")]
    _alpha_cutoff: Option<f32>,
    #[serde(rename = "doubleSided")]
    _double_sided: Option<bool>,
    #[serde(rename = "extras")]
    _extras: Option<IgnoredAny>,
}

/// glTF 2.0, 5.22 "Material PBR Metallic Roughness".
#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase", deny_unknown_fields)]
struct MetallicRoughness {
    base_color_factor: [f32; 4],
    base_color_texture: Option<IgnoredAny>,
    metallic_factor: f32,
    roughness_factor: f32,
    metallic_roughness_texture: Option<IgnoredAny>,
    #[serde(rename = "extensions")]
    _extensions: Option<Map<String, Value>>,
    #[serde(rename = "extras")]
    _extras: Option<IgnoredAny>,
}

impl Default for MetallicRoughness {
    fn default() -> Self {
        Self {
            base_color_factor: [1.0; 4],
            base_color_texture: None,
            metallic_factor: 1.0,
            roughness_factor: 1.0,
            metallic_roughness_texture: None,
            _extensions: None,
            _extras: None,
        }
    }
}

/// KHR_materials_ior.
#[derive(Deserialize)]
struct Ior {
    #[serde(default = "default_ior")]
    ior: f32,
}

fn default_ior() -> f32 {
    1.5
}

fn read<'a, T: Deserialize<'a>>(value: &'a Value) -> Result<T, MaterialError> {
    T::deserialize(value).map_err(|error| MaterialError::Json(error.to_string()))
}

/// The material that a query tells of, as the renderers have it, without its textures.
pub fn material_of(value: &Value) -> Result<Material, MaterialError> {
    let mut material = Material::zeroed();
    material.base_color = [1.0; 4];
    if value.get("model").is_some() {
        lower_bsdf(&read::<BsdfModel>(value)?, &mut material)?;
        return Ok(material);
    }
    let gltf: GltfMaterial = read(value)?;
    let pbr = &gltf.pbr_metallic_roughness;
    let textures = [
        ("baseColorTexture", &pbr.base_color_texture),
        ("metallicRoughnessTexture", &pbr.metallic_roughness_texture),
        ("normalTexture", &gltf.normal_texture),
        ("occlusionTexture", &gltf.occlusion_texture),
        ("emissiveTexture", &gltf.emissive_texture),
    ];
    if let Some((name, _)) = textures.into_iter().find(|(_, texture)| texture.is_some()) {
        return Err(MaterialError::Texture(name));
    }
    for value in pbr.base_color_factor {
        from_0_to_1("baseColorFactor", value)?;
    }
    from_0_to_1("metallicFactor", pbr.metallic_factor)?;
    from_0_to_1("roughnessFactor", pbr.roughness_factor)?;
    material.model = BSDF_GLTF;
    material.base_color = pbr.base_color_factor;
    material.metallic = pbr.metallic_factor;
    material.roughness = pbr.roughness_factor;
    material.ior = default_ior();
    material.fresnel = FRESNEL_SCHLICK;
    material.distribution = DISTRIBUTION_GGX;
    material.masking = MASKING_SMITH;
    for (name, extension) in &gltf.extensions {
        match name.as_str() {
            "KHR_materials_ior" => {
                material.ior = read::<Ior>(extension)?.ior;
                // 0 is the extension's word for "reflects everything".
                if material.ior != 0.0 && !(1.0..=f32::MAX).contains(&material.ior) {
                    return Err(MaterialError::Range {
                        name: "ior",
                        value: material.ior,
                        range: "0, or 1 or more",
                    });
                }
            }
            "KHR_materials_emissive_strength" | "KHR_materials_unlit" | "SNELL_materials_bsdf" => {}
            other => return Err(MaterialError::Extension(other.to_owned())),
        }
    }
    if let Some(model) = gltf.extensions.get("SNELL_materials_bsdf") {
        lower_bsdf(&read::<BsdfModel>(model)?, &mut material)?;
        // As pack_material does: base colour is a factor on the model's own reflectance.
        for (channel, factor) in pbr.base_color_factor[..3].iter().enumerate() {
            material.base_color[channel] *= factor;
        }
    } else if gltf.extensions.contains_key("KHR_materials_unlit") {
        material.model = BSDF_UNLIT;
    }
    Ok(material)
}

fn from_0_to_1(name: &'static str, value: f32) -> Result<(), MaterialError> {
    if (0.0..=1.0).contains(&value) {
        return Ok(());
    }
    Err(MaterialError::Range {
        name,
        value,
        range: "from 0 to 1",
    })
}

/// What the reflection functions take of it, seen from outside: by the renderer's own rule.
pub fn bsdf_of(material: &Material) -> Bsdf {
    let base_color = Vec4::from_array(material.base_color).truncate().as_dvec3();
    let (metallic, roughness) = (f64::from(material.metallic), f64::from(material.roughness));
    Bsdf::from(&cpu::material::bsdf_of(
        material,
        base_color,
        metallic,
        roughness,
        f64::from(material.ior),
    ))
}
