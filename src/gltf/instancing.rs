//! EXT_mesh_gpu_instancing: many copies of a node's mesh.

use super::accessor::{Accessors, Attribute};
use super::error::GltfError;
use super::json::Json;
use super::notes::Notes;
use glam::{DAffine3, DQuat, DVec3};

const NAME: &str = "EXT_mesh_gpu_instancing";

/// Where the copies of a node's mesh are in the node's own space.
pub struct Copies {
    translations: Option<Vec<[f32; 3]>>,
    rotations: Option<Vec<[f32; 4]>>,
    scales: Option<Vec<[f32; 3]>>,
    pub count: usize,
}

/// The copies that a node asks for; `None` where the mesh is drawn as it is.
pub fn copies(
    node: &Json<'_>,
    accessors: Accessors<'_>,
    notes: &mut Notes,
) -> Result<Option<Copies>, GltfError> {
    const VEC3: Attribute = Attribute::of(&["VEC3"]);
    const ROTATION: Attribute = Attribute {
        types: &["VEC4"],
        fill: 0.0,
        normalized: true,
    };
    let Some(extension) = node.extension(NAME)? else {
        return Ok(None);
    };
    let Some(attributes) = extension.object("attributes")? else {
        return Ok(None);
    };
    let translations = accessors.floats::<3>(&attributes, "TRANSLATION", &VEC3)?;
    let rotations = accessors.floats::<4>(&attributes, "ROTATION", &ROTATION)?;
    let scales = accessors.floats::<3>(&attributes, "SCALE", &VEC3)?;
    let counts = [
        ("TRANSLATION", translations.as_ref().map(Vec::len)),
        ("ROTATION", rotations.as_ref().map(Vec::len)),
        ("SCALE", scales.as_ref().map(Vec::len)),
    ];
    let mut counts = counts
        .into_iter()
        .filter_map(|(name, count)| Some((name, count?)));
    let custom = attributes.children().into_iter().find(|attribute| {
        let name = attribute.at.rsplit('.').next().unwrap_or_default();
        !["TRANSLATION", "ROTATION", "SCALE"].contains(&name)
    });
    if custom.is_some() {
        notes.add("custom attributes of instances are ignored", &attributes.at);
    }
    let count = match counts.next() {
        Some((first, count)) => {
            if let Some((name, other)) = counts.find(|&(_, other)| other != count) {
                return Err(attributes.invalid(format!(
                    "{first} has {count} elements and {name} has {other}"
                )));
            }
            count
        }
        // Copies that differ in what is not drawn coincide: one of them is seen.
        None => return Ok(None),
    };
    Ok(Some(Copies {
        translations,
        rotations,
        scales,
        count,
    }))
}

impl Copies {
    /// Translation * rotation * scale of one of them.
    pub fn node_from_object(&self, copy: usize) -> DAffine3 {
        let vector = |values: &Option<Vec<[f32; 3]>>, default| match values {
            Some(values) => DVec3::from(values[copy].map(f64::from)),
            None => default,
        };
        let rotation = match &self.rotations {
            // A quaternion without a length turns nothing, as at nodes.
            Some(values) => {
                let rotation = DQuat::from_array(values[copy].map(f64::from));
                match rotation.length() > 0.0 {
                    true => rotation.normalize(),
                    false => DQuat::IDENTITY,
                }
            }
            None => DQuat::IDENTITY,
        };
        DAffine3::from_scale_rotation_translation(
            vector(&self.scales, DVec3::ONE),
            rotation,
            vector(&self.translations, DVec3::ZERO),
        )
    }
}
