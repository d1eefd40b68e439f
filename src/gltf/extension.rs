//! Which extensions a file uses and what each of them gets.

use super::error::GltfError;
use super::json::Json;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

/// What the picture shows of an extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Treatment {
    Supported,
    Approximated,
    Ignored,
}

/// An extension that a file names or uses.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ExtensionUse {
    pub name: String,
    /// Listed in `extensionsRequired`.
    pub required: bool,
    pub treatment: Treatment,
    /// What that means for the picture.
    pub detail: String,
    /// How many objects carry it.
    pub uses: usize,
    /// The first of them.
    pub first: Option<String>,
}

/// (name, treatment, what it means, whether a file that requires it can be drawn).
const KNOWN: &[(&str, Treatment, &str, bool)] = {
    use Treatment::{Approximated, Ignored, Supported};
    &[
        ("KHR_lights_punctual", Supported, "", true),
        ("KHR_materials_unlit", Supported, "", true),
        ("KHR_materials_emissive_strength", Supported, "", true),
        ("KHR_materials_ior", Supported, "", true),
        ("KHR_materials_transmission", Supported, "", true),
        ("KHR_materials_diffuse_transmission", Supported, "", true),
        ("KHR_materials_volume", Supported, "", true),
        ("KHR_materials_dispersion", Supported, "", true),
        ("KHR_materials_specular", Supported, "", true),
        ("KHR_materials_clearcoat", Supported, "", true),
        ("KHR_materials_sheen", Supported, "", true),
        ("KHR_materials_anisotropy", Supported, "", true),
        ("KHR_materials_iridescence", Supported, "", true),
        ("KHR_materials_pbrSpecularGlossiness", Supported, "", true),
        ("KHR_texture_transform", Supported, "", true),
        ("KHR_mesh_quantization", Supported, "", true),
        ("SNELL_materials_bsdf", Supported, "", true),
        ("EXT_texture_webp", Supported, "", true),
        (
            "KHR_materials_variants",
            Approximated,
            "the default materials are drawn",
            true,
        ),
        (
            "EXT_meshopt_compression",
            Ignored,
            "the uncompressed fallback is drawn",
            false,
        ),
        (
            "KHR_meshopt_compression",
            Ignored,
            "the uncompressed fallback is drawn",
            false,
        ),
        (
            "KHR_draco_mesh_compression",
            Ignored,
            "the uncompressed fallback is drawn",
            false,
        ),
        (
            "KHR_texture_basisu",
            Ignored,
            "the PNG or JPEG fallback is drawn, if there is one",
            false,
        ),
        (
            "EXT_mesh_gpu_instancing",
            Ignored,
            "each mesh is drawn once",
            false,
        ),
        (
            "KHR_materials_volume_scatter",
            Ignored,
            "light is absorbed inside, and not scattered",
            false,
        ),
        (
            "KHR_materials_retroreflection",
            Ignored,
            "light is not sent back to where it came from",
            false,
        ),
    ]
};

/// Lists the extensions of a file; an error where it requires one that is not supported.
pub fn inventory(root: &Json<'_>) -> Result<Vec<ExtensionUse>, GltfError> {
    let mut found = BTreeMap::new();
    visit(root.value(), root.at.clone(), &mut found);
    let mut required = Vec::new();
    for name in root.elements("extensionsRequired")? {
        let text = name.as_string()?;
        if !KNOWN
            .iter()
            .any(|&(known, .., drawable)| known == text && drawable)
        {
            return Err(name.unsupported_extension(text));
        }
        required.push(text);
    }
    for name in root.elements("extensionsUsed")? {
        found.entry(name.as_string()?.to_owned()).or_default();
    }
    for &name in &required {
        found.entry(name.to_owned()).or_default();
    }
    Ok(found
        .into_iter()
        .map(|(name, (uses, first))| {
            let required = required.contains(&name.as_str());
            entry(name, required, uses, first)
        })
        .collect())
}

/// One that is met without being declared: an image in a format of an extension, say.
pub fn undeclared(extensions: &mut Vec<ExtensionUse>, name: &str, at: &str) {
    match extensions.iter_mut().find(|entry| entry.name == name) {
        Some(entry) => entry.uses += 1,
        None => extensions.push(entry(name.to_owned(), false, 1, Some(at.to_owned()))),
    }
}

fn entry(name: String, required: bool, uses: usize, first: Option<String>) -> ExtensionUse {
    let known = KNOWN.iter().find(|(known, ..)| *known == name);
    let (treatment, detail) = match known {
        Some(&(_, treatment, detail, _)) => (treatment, detail),
        None => (Treatment::Ignored, "it is not known"),
    };
    ExtensionUse {
        name,
        required,
        treatment,
        detail: detail.to_owned(),
        uses,
        first,
    }
}

/// Counts the keys of all `extensions` objects. The parser has bounded the depth; `extras` are the
/// application's own.
fn visit(value: &Value, at: String, found: &mut BTreeMap<String, (usize, Option<String>)>) {
    match value {
        Value::Object(object) => {
            for (key, value) in object {
                let place = if at.is_empty() {
                    key.clone()
                } else {
                    format!("{at}.{key}")
                };
                if let ("extensions", Value::Object(extensions)) = (key.as_str(), value) {
                    for name in extensions.keys() {
                        let (uses, first) = found.entry(name.clone()).or_default();
                        *uses += 1;
                        first.get_or_insert_with(|| place.clone());
                    }
                }
                if key != "extras" && (value.is_object() || value.is_array()) {
                    visit(value, place, found);
                }
            }
        }
        Value::Array(array) => {
            for (index, value) in array.iter().enumerate() {
                if value.is_object() || value.is_array() {
                    visit(value, format!("{at}[{index}]"), found);
                }
            }
        }
        _ => {}
    }
}
