//! A query's material: a glTF material object without textures, or one of the lecture's models.

use crate::cpu;
use crate::cpu::material::white_texels;
use crate::gltf::{GltfError, material_of_query};
use crate::pack::PackError;
use crate::pack::material::pack_material;
use crate::pack::model::{ModelError, lower_bsdf};
use crate::pack::texture::Textures;
use crate::scene::bsdf_model::BsdfModel;
use crate::shared::{Bsdf, Material};
use bytemuck::Zeroable;
use serde::Deserialize;
use serde_json::Value;

#[derive(Debug, PartialEq, thiserror::Error)]
pub enum MaterialError {
    #[error("{0}")]
    Json(String),
    #[error(transparent)]
    Model(#[from] ModelError),
    #[error("the extension `{0}` is not supported")]
    Extension(String),
    #[error("{}{what}", place(at))]
    Gltf {
        /// Where in the material object; empty for the whole.
        at: String,
        what: String,
    },
}

fn place(at: &str) -> String {
    if at.is_empty() {
        String::new()
    } else {
        format!("{at}: ")
    }
}

impl From<GltfError> for MaterialError {
    fn from(error: GltfError) -> Self {
        match error {
            GltfError::Invalid { at, what, .. } => Self::Gltf { at, what },
            GltfError::UnsupportedExtension { name, .. } => Self::Extension(name),
            other => Self::Json(other.to_string()),
        }
    }
}

/// The material that a query tells of, as the renderers have it, without its textures.
pub fn material_of(value: &Value) -> Result<Material, MaterialError> {
    if value.get("model").is_some() {
        let bsdf = BsdfModel::deserialize(value)
            .map_err(|error| MaterialError::Json(error.to_string()))?;
        let mut material = Material::zeroed();
        lower_bsdf(&bsdf, &mut material)?;
        return Ok(material);
    }
    if !value.is_object() {
        return Err(MaterialError::Json(format!("{value} is not a material")));
    }
    let material = material_of_query(value)?;
    pack_material(&material, &Textures::default()).map_err(|error| match error {
        PackError::Model { source, .. } => source.into(),
        other => MaterialError::Json(other.to_string()),
    })
}

/// What the reflection functions take of it, seen from outside: by the renderer's own rule.
pub fn bsdf_of(material: &Material) -> Bsdf {
    let outside = f64::from(material.ior);
    Bsdf::from(&cpu::material::bsdf_of(material, &white_texels(), outside))
}
