//! KHR_animation_pointer: which properties can be driven, and how they are written into the JSON
//! (glTF 2.0 Asset Object Model; RFC 6901).

use super::error::GltfError;
use super::json::Json;
use serde_json::{Map, Value};

/// What type a driven property has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One number, or an array of so many.
    Floats(usize),
    /// A unit quaternion.
    Rotation,
    /// All weights of a node's mesh.
    Weights(usize),
    /// One of so many.
    Weight {
        index: usize,
        count: usize,
    },
    Bool,
}

impl Kind {
    /// Numbers in one value.
    pub fn width(self) -> usize {
        match self {
            Self::Floats(count) | Self::Weights(count) => count,
            Self::Rotation => 4,
            Self::Weight { .. } | Self::Bool => 1,
        }
    }

    /// The type that the accessor of its values must have.
    pub fn accessor_type(self) -> &'static str {
        match self {
            Self::Floats(2) => "VEC2",
            Self::Floats(3) => "VEC3",
            Self::Floats(4) | Self::Rotation => "VEC4",
            _ => "SCALAR",
        }
    }
}

const SCALAR: Kind = Kind::Floats(1);
const RGB: Kind = Kind::Floats(3);

/// The properties that pictures depend on; `*` is an index. Texture transforms and weights are beside
/// the table.
const PROPERTIES: &[(&str, Kind)] = &[
    ("nodes/*/translation", Kind::Floats(3)),
    ("nodes/*/rotation", Kind::Rotation),
    ("nodes/*/scale", Kind::Floats(3)),
    ("nodes/*/extensions/KHR_node_visibility/visible", Kind::Bool),
    ("cameras/*/orthographic/xmag", SCALAR),
    ("cameras/*/orthographic/ymag", SCALAR),
    ("cameras/*/orthographic/znear", SCALAR),
    ("cameras/*/perspective/aspectRatio", SCALAR),
    ("cameras/*/perspective/yfov", SCALAR),
    ("cameras/*/perspective/znear", SCALAR),
    (
        "extensions/EXT_lights_image_based/lights/*/rotation",
        Kind::Rotation,
    ),
    (
        "extensions/EXT_lights_image_based/lights/*/intensity",
        SCALAR,
    ),
    ("nodes/*/extensions/EXT_lights_ies/multiplier", SCALAR),
    ("nodes/*/extensions/EXT_lights_ies/color", RGB),
    ("extensions/KHR_lights_punctual/lights/*/color", RGB),
    ("extensions/KHR_lights_punctual/lights/*/intensity", SCALAR),
    ("extensions/KHR_lights_punctual/lights/*/range", SCALAR),
    (
        "extensions/KHR_lights_punctual/lights/*/spot/innerConeAngle",
        SCALAR,
    ),
    (
        "extensions/KHR_lights_punctual/lights/*/spot/outerConeAngle",
        SCALAR,
    ),
    ("materials/*/alphaCutoff", SCALAR),
    ("materials/*/emissiveFactor", RGB),
    ("materials/*/normalTexture/scale", SCALAR),
    (
        "materials/*/pbrMetallicRoughness/baseColorFactor",
        Kind::Floats(4),
    ),
    ("materials/*/pbrMetallicRoughness/metallicFactor", SCALAR),
    ("materials/*/pbrMetallicRoughness/roughnessFactor", SCALAR),
    (
        "materials/*/extensions/KHR_materials_anisotropy/anisotropyStrength",
        SCALAR,
    ),
    (
        "materials/*/extensions/KHR_materials_anisotropy/anisotropyRotation",
        SCALAR,
    ),
    (
        "materials/*/extensions/KHR_materials_clearcoat/clearcoatFactor",
        SCALAR,
    ),
    (
        "materials/*/extensions/KHR_materials_clearcoat/clearcoatRoughnessFactor",
        SCALAR,
    ),
    (
        "materials/*/extensions/KHR_materials_clearcoat/clearcoatNormalTexture/scale",
        SCALAR,
    ),
    (
        "materials/*/extensions/KHR_materials_diffuse_transmission/diffuseTransmissionFactor",
        SCALAR,
    ),
    (
        "materials/*/extensions/KHR_materials_diffuse_transmission/diffuseTransmissionColorFactor",
        RGB,
    ),
    (
        "materials/*/extensions/KHR_materials_dispersion/dispersion",
        SCALAR,
    ),
    (
        "materials/*/extensions/KHR_materials_emissive_strength/emissiveStrength",
        SCALAR,
    ),
    ("materials/*/extensions/KHR_materials_ior/ior", SCALAR),
    (
        "materials/*/extensions/KHR_materials_iridescence/iridescenceFactor",
        SCALAR,
    ),
    (
        "materials/*/extensions/KHR_materials_iridescence/iridescenceIor",
        SCALAR,
    ),
    (
        "materials/*/extensions/KHR_materials_iridescence/iridescenceThicknessMinimum",
        SCALAR,
    ),
    (
        "materials/*/extensions/KHR_materials_iridescence/iridescenceThicknessMaximum",
        SCALAR,
    ),
    (
        "materials/*/extensions/KHR_materials_sheen/sheenColorFactor",
        RGB,
    ),
    (
        "materials/*/extensions/KHR_materials_sheen/sheenRoughnessFactor",
        SCALAR,
    ),
    (
        "materials/*/extensions/KHR_materials_specular/specularFactor",
        SCALAR,
    ),
    (
        "materials/*/extensions/KHR_materials_specular/specularColorFactor",
        RGB,
    ),
    (
        "materials/*/extensions/KHR_materials_transmission/transmissionFactor",
        SCALAR,
    ),
    (
        "materials/*/extensions/KHR_materials_volume/thicknessFactor",
        SCALAR,
    ),
    (
        "materials/*/extensions/KHR_materials_volume/attenuationDistance",
        SCALAR,
    ),
    (
        "materials/*/extensions/KHR_materials_volume/attenuationColor",
        RGB,
    ),
    (
        "materials/*/extensions/KHR_materials_pbrSpecularGlossiness/diffuseFactor",
        Kind::Floats(4),
    ),
    (
        "materials/*/extensions/KHR_materials_pbrSpecularGlossiness/specularFactor",
        RGB,
    ),
    (
        "materials/*/extensions/KHR_materials_pbrSpecularGlossiness/glossinessFactor",
        SCALAR,
    ),
];

/// The property that a pointer leads to; or why nothing is driven by it.
pub fn resolve(
    root: &Json<'_>,
    pointer: &Json<'_>,
) -> Result<Result<(Vec<String>, Kind), String>, GltfError> {
    let text = pointer.as_string()?;
    let path = parse(text)
        .ok_or_else(|| pointer.invalid(format!("`{text}` is no JSON pointer (RFC 6901)")))?;
    let names: Vec<&str> = path.iter().map(String::as_str).collect();
    let mut value = root.value();
    for (depth, name) in names.iter().enumerate() {
        let next = match value {
            Value::Object(object) => object.get(*name),
            Value::Array(array) => {
                let found = index(name).and_then(|index| array.get(index));
                let missing = || {
                    let count = array.len();
                    pointer.invalid(format!(
                        "`{text}` is out of range at `{name}`: there are {count} elements"
                    ))
                };
                Some(found.ok_or_else(missing)?)
            }
            _ => return Err(pointer.invalid(format!("`{text}` leads through what is no object"))),
        };
        match next {
            Some(next) => value = next,
            None if names[depth..].iter().any(|name| index(name).is_some())
                && !names[depth..].starts_with(&["weights"]) =>
            {
                return Err(pointer.invalid(format!("`{text}` leads nowhere at `{name}`")));
            }
            None if name.ends_with("Texture") => {
                return Ok(Err(
                    "an animation of a texture that is not there is left out".to_owned(),
                ));
            }
            None => break,
        }
    }
    if let ["nodes", node, rest @ ..] = names.as_slice() {
        let nodes = root.objects("nodes")?;
        let node = index(node).and_then(|index| nodes.get(index));
        let node = node.ok_or_else(|| pointer.invalid(format!("`{text}` names no node")))?;
        match rest {
            ["weights"] | ["weights", _] => {
                return weights(node, rest.get(1), path.clone(), pointer);
            }
            ["translation" | "rotation" | "scale"] => refuse_matrix(node, pointer)?,
            _ => {}
        }
    }
    Ok(kind(&names)
        .map(|kind| (path.clone(), kind))
        .ok_or_else(|| format!("`{text}` is animated and no part of the picture")))
}

fn weights(
    node: &Json<'_>,
    element: Option<&&str>,
    mut path: Vec<String>,
    pointer: &Json<'_>,
) -> Result<Result<(Vec<String>, Kind), String>, GltfError> {
    path.truncate(3);
    let count = target_count(node)?;
    let kind = match element {
        None if count == 0 => {
            return Ok(Err(
                "weights of a mesh without targets are left out".to_owned()
            ));
        }
        None => Kind::Weights(count),
        Some(element) => match index(element).filter(|&index| index < count) {
            Some(index) => Kind::Weight { index, count },
            None => {
                return Err(pointer.invalid(format!(
                    "weight {element} is out of range: there are {count} targets"
                )));
            }
        },
    };
    Ok(Ok((path, kind)))
}

/// RFC 6901, section 3.
fn parse(text: &str) -> Option<Vec<String>> {
    let names = text.strip_prefix('/')?.split('/');
    names
        .map(|name| {
            let escapes = name.split('~').skip(1);
            let valid = escapes.clone().all(|rest| rest.starts_with(['0', '1']));
            (valid && !name.is_empty()).then(|| name.replace("~1", "/").replace("~0", "~"))
        })
        .collect()
}

/// Section 4: no leading zeros.
fn index(name: &str) -> Option<usize> {
    let digits = name.bytes().all(|byte| byte.is_ascii_digit());
    let plain = name == "0" || !name.starts_with('0');
    (digits && plain).then(|| name.parse().ok()).flatten()
}

fn kind(names: &[&str]) -> Option<Kind> {
    if let [
        "materials",
        _,
        ..,
        texture,
        "extensions",
        "KHR_texture_transform",
        property,
    ] = names
        && texture.ends_with("Texture")
        && *texture != "occlusionTexture"
    {
        return match *property {
            "offset" | "scale" => Some(Kind::Floats(2)),
            "rotation" => Some(SCALAR),
            _ => None,
        };
    }
    let found = PROPERTIES.iter().find(|(pattern, _)| {
        let pattern = pattern.split('/');
        pattern.clone().count() == names.len()
            && pattern
                .zip(names)
                .all(|(pattern, name)| pattern == *name || pattern == "*")
    });
    found.map(|&(_, kind)| kind)
}

/// How many morph targets the mesh of a node has.
pub fn target_count(node: &Json<'_>) -> Result<usize, GltfError> {
    let Some((_, mesh)) = node.reference("mesh", "meshes")? else {
        return Ok(0);
    };
    match mesh.objects("primitives")?.first() {
        Some(primitive) => Ok(primitive.elements("targets")?.len()),
        None => Ok(0),
    }
}

/// glTF 2.0 section 3.5.3: a node that is animated has no matrix.
pub fn refuse_matrix(node: &Json<'_>, target: &Json<'_>) -> Result<(), GltfError> {
    match node.get("matrix") {
        None => Ok(()),
        Some(_) => Err(target.invalid(format!(
            "{} has a matrix, and a node that is animated must have translation, rotation and scale",
            node.at
        ))),
    }
}

/// What makes a value what it was.
pub struct Undo {
    path: Vec<String>,
    before: Option<Value>,
}

/// Writes a value, and the objects that lead to it where they are missing. Nothing is written where
/// the path leads through something else, which `resolve` has ruled out.
pub fn write(root: &mut Value, path: &[String], kind: Kind, numbers: &[f64]) -> Option<Undo> {
    let array = |numbers: &[f64]| Value::Array(numbers.iter().map(|&n| n.into()).collect());
    let value = match kind {
        Kind::Bool => Value::Bool(numbers[0] != 0.0),
        Kind::Floats(1) => numbers[0].into(),
        Kind::Floats(_) | Kind::Rotation | Kind::Weights(_) => array(numbers),
        Kind::Weight { index, count } => {
            let mut weights = weights_at_rest(root, path, count);
            weights[index] = numbers[0];
            array(&weights)
        }
    };
    put(root, path, value)
}

/// The weights of a node, else those of its mesh, else zeros.
fn weights_at_rest(root: &Value, path: &[String], count: usize) -> Vec<f64> {
    let node = &root["nodes"][index(&path[1]).unwrap_or(usize::MAX)];
    let mesh = node["mesh"]
        .as_u64()
        .map(|mesh| &root["meshes"][mesh as usize]);
    let given = node["weights"]
        .as_array()
        .or_else(|| mesh?["weights"].as_array());
    let mut weights = vec![0.0; count];
    for (weight, value) in weights.iter_mut().zip(given.into_iter().flatten()) {
        *weight = value.as_f64().unwrap_or_default();
    }
    weights
}

fn put(root: &mut Value, path: &[String], value: Value) -> Option<Undo> {
    let mut parent = root;
    for (depth, name) in path.iter().enumerate() {
        let last = depth + 1 == path.len();
        if let Value::Object(object) = parent
            && (last || !object.contains_key(name))
        {
            let value = path[depth + 1..].iter().rev().fold(value, |value, name| {
                Map::from_iter([(name.clone(), value)]).into()
            });
            return Some(Undo {
                path: path[..=depth].to_vec(),
                before: object.insert(name.clone(), value),
            });
        }
        parent = child(parent, name)?;
    }
    None
}

fn child<'v>(parent: &'v mut Value, name: &str) -> Option<&'v mut Value> {
    match parent {
        Value::Object(object) => object.get_mut(name),
        Value::Array(array) => array.get_mut(index(name)?),
        _ => None,
    }
}

/// Takes writes back, the last one first.
pub fn undo(root: &mut Value, writes: &mut Vec<Undo>) {
    while let Some(Undo { path, before }) = writes.pop() {
        let Some((name, parents)) = path.split_last() else {
            continue;
        };
        let parent = parents
            .iter()
            .try_fold(&mut *root, |value, name| child(value, name));
        if let Some(Value::Object(object)) = parent {
            match before {
                Some(before) => object.insert(name.clone(), before),
                None => object.remove(name),
            };
        }
    }
}
