//! A material by itself, as the reflection laboratory takes it: without a file, and without mercy.

use super::super::error::GltfError;
use super::super::json::{Document, Json};
use super::extensions::EXTENSIONS;
use super::{Policy, material};
use crate::scene::{Material, Texture};
use serde_json::Value;
use std::path::PathBuf;

/// Refuses what a file would be drawn without: a query is written by hand, and nobody reads notes.
struct Strict;

impl<'a> Policy<'a> for Strict {
    fn texture(&mut self, info: &Json<'a>, _srgb: bool) -> Result<Option<Texture>, GltfError> {
        Err(info.invalid(
            "a query is about one point of a surface and takes no textures; give factors instead",
        ))
    }

    fn doubt(&mut self, at: &Json<'a>, what: &str, becomes: &str) -> Result<(), GltfError> {
        Err(at.invalid(format!("{what} is refused here; in a file it {becomes}")))
    }
}

/// Reads a glTF material object that stands alone. Errors tell the place in the object.
pub fn material_of_query(value: &Value) -> Result<Material, GltfError> {
    const OTHERS: [&str; 4] = [
        "KHR_materials_emissive_strength",
        "KHR_materials_unlit",
        "KHR_materials_pbrSpecularGlossiness",
        "SNELL_materials_bsdf",
    ];
    let document = Document {
        path: PathBuf::new(),
        root: value.clone(),
    };
    let json = Json::root(&document);
    if let Some(extensions) = json.object("extensions")? {
        for name in extensions
            .value()
            .as_object()
            .into_iter()
            .flat_map(|all| all.keys())
        {
            if !EXTENSIONS.contains(&name.as_str()) && !OTHERS.contains(&name.as_str()) {
                return Err(extensions.unsupported_extension(name));
            }
        }
    }
    material(&json, &mut Strict)
}
