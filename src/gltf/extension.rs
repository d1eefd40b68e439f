//! Which extensions a file uses and what each of them gets.

use super::error::GltfError;
use super::json::Json;
use super::meshopt;
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

/// An extension that a file names or uses, and what it gets: the same record in `snell info --json` and
/// in a render's report.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ExtensionUse {
    pub name: String,
    /// Listed in `extensionsUsed`, as each that is used should be.
    pub declared: bool,
    /// Listed in `extensionsRequired`.
    pub required: bool,
    pub treatment: Treatment,
    /// What that means for the picture.
    pub detail: String,
    /// How many objects carry it; 0 where it is only named.
    pub uses: usize,
    /// The paths of the first [`PLACES`] of those `extensions` objects, sections in alphabetical order.
    pub places: Vec<String>,
}

/// So many places of an extension are kept; every node of a large scene may be one.
pub const PLACES: usize = 16;

impl ExtensionUse {
    /// The picture lacks something for it: naming an extension that nothing carries changes nothing.
    pub fn is_missed(&self) -> bool {
        self.treatment == Treatment::Ignored && (self.required || self.uses > 0)
    }

    /// Places and how many more there are: `nodes[0], nodes[1] and 3 more`, `shown` at most.
    pub fn places_text(&self, shown: usize) -> String {
        let shown = shown.min(self.places.len());
        let places = self.places[..shown].join(", ");
        match self.uses - shown {
            0 => places,
            more => format!("{places} and {more} more"),
        }
    }
}

/// The objects that carry an extension.
#[derive(Default)]
struct Uses {
    count: usize,
    places: Vec<String>,
}

impl Uses {
    fn add(&mut self, at: &str) {
        self.count += 1;
        if self.places.len() < PLACES {
            self.places.push(at.to_owned());
        }
    }
}

/// (name, treatment, what it means, whether a file that requires it can be drawn).
const KNOWN: &[(&str, Treatment, &str, bool)] = {
    use Treatment::{Approximated, Ignored, Supported};
    &[
        ("KHR_lights_punctual", Supported, "", true),
        (
            "EXT_lights_image_based",
            Approximated,
            "the sharpest of its images is the light; its irradiance coefficients are not used",
            true,
        ),
        ("EXT_lights_ies", Supported, "", true),
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
        ("KHR_draco_mesh_compression", Supported, "", true),
        ("SNELL_materials_bsdf", Supported, "", true),
        ("EXT_texture_webp", Supported, "", true),
        ("EXT_meshopt_compression", MESHOPT.0, MESHOPT.1, MESHOPT.2),
        ("KHR_meshopt_compression", MESHOPT.0, MESHOPT.1, MESHOPT.2),
        ("KHR_animation_pointer", Supported, "", true),
        ("KHR_materials_variants", Supported, "", true),
        ("KHR_node_visibility", Supported, "", true),
        ("KHR_xmp_json_ld", Supported, "", true),
        ("EXT_mesh_gpu_instancing", Supported, "", true),
        #[cfg(feature = "basisu")]
        ("KHR_texture_basisu", Supported, "", true),
        #[cfg(not(feature = "basisu"))]
        (
            "KHR_texture_basisu",
            Ignored,
            "this build lacks the cargo feature `basisu`: the PNG or JPEG fallback is drawn, if there \
             is one",
            false,
        ),
        (
            "EXT_texture_avif",
            Ignored,
            "the fallback is drawn, if there is one",
            false,
        ),
        (
            "MSFT_texture_dds",
            Ignored,
            "the fallback is drawn, if there is one",
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

/// By whether this build decodes it.
const MESHOPT: (Treatment, &str, bool) = match cfg!(feature = "meshopt") {
    true => (Treatment::Supported, "", true),
    false => (
        Treatment::Ignored,
        "this build lacks the cargo feature `meshopt`: the uncompressed fallback is drawn",
        false,
    ),
};

/// The cargo feature that brings an extension.
const FEATURES: &[(&str, &str)] = &[
    ("KHR_texture_basisu", "basisu"),
    ("EXT_meshopt_compression", meshopt::FEATURE),
    ("KHR_meshopt_compression", meshopt::FEATURE),
];

/// Lists the extensions of a file; an error where it requires one that is not supported.
pub fn inventory(root: &Json<'_>) -> Result<Vec<ExtensionUse>, GltfError> {
    let mut found = BTreeMap::new();
    visit(root.value(), &root.at, &mut found);
    let mut required = Vec::new();
    for name in root.elements("extensionsRequired")? {
        let text = name.as_string()?;
        if !KNOWN
            .iter()
            .any(|&(known, .., drawable)| known == text && drawable)
        {
            let feature = FEATURES.iter().find(|(known, _)| *known == text);
            return Err(match feature {
                Some(&(_, feature)) => name.missing_feature(text, feature),
                None => name.unsupported_extension(text),
            });
        }
        required.push(text);
    }
    let mut declared = Vec::new();
    for name in root.elements("extensionsUsed")? {
        declared.push(name.as_string()?);
    }
    for &name in declared.iter().chain(&required) {
        found.entry(name.to_owned()).or_default();
    }
    Ok(found
        .into_iter()
        .map(|(name, uses)| ExtensionUse {
            declared: declared.contains(&name.as_str()),
            required: required.contains(&name.as_str()),
            ..entry(name, uses)
        })
        .collect())
}

/// One that is met without standing among an object's `extensions`: an image in its format, say.
pub fn undeclared(extensions: &mut Vec<ExtensionUse>, name: &str, at: &str) {
    let place = match extensions.iter().position(|entry| entry.name == name) {
        Some(place) => place,
        None => {
            extensions.push(entry(name.to_owned(), Uses::default()));
            extensions.len() - 1
        }
    };
    let entry = &mut extensions[place];
    entry.uses += 1;
    if entry.places.len() < PLACES {
        entry.places.push(at.to_owned());
    }
}

fn entry(name: String, uses: Uses) -> ExtensionUse {
    let known = KNOWN.iter().find(|(known, ..)| *known == name);
    let (treatment, detail) = match known {
        Some(&(_, treatment, detail, _)) => (treatment, detail),
        None => (Treatment::Ignored, "it is not known"),
    };
    ExtensionUse {
        name,
        declared: false,
        required: false,
        treatment,
        detail: detail.to_owned(),
        uses: uses.count,
        places: uses.places,
    }
}

/// Takes down the keys of all `extensions` objects. The parser has bounded the depth; `extras` are
/// the application's own.
fn visit(value: &Value, at: &str, found: &mut BTreeMap<String, Uses>) {
    match value {
        Value::Object(object) => {
            for (key, value) in object {
                let at = match at {
                    "" => key.clone(),
                    _ => format!("{at}.{key}"),
                };
                if let ("extensions", Value::Object(extensions)) = (key.as_str(), value) {
                    for name in extensions.keys() {
                        found.entry(name.clone()).or_default().add(&at);
                    }
                }
                if key != "extras" && (value.is_object() || value.is_array()) {
                    visit(value, &at, found);
                }
            }
        }
        Value::Array(array) => {
            for (index, value) in array.iter().enumerate() {
                if value.is_object() || value.is_array() {
                    visit(value, &format!("{at}[{index}]"), found);
                }
            }
        }
        _ => {}
    }
}
