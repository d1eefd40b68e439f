//! From a glTF 2.0 file to a [`Scene`]: everything is checked here, so that nothing behind has to.
//!
//! A file is untrusted. It reads only regular files in its own folder, symbolic links followed
//! (`LoadOptions::allow_paths` widens that); every size that it claims is compared with what is
//! there, or paid for out of `LoadOptions::max_memory`, before anything is allocated; the hierarchy
//! is walked without recursion. Each error names its place in the JSON.

mod accessor;
mod buffer;
mod camera;
mod deform;
mod environment;
mod error;
mod extension;
mod framing;
mod image;
mod json;
mod light;
mod material;
mod mesh;
mod node;
mod normal;
mod notes;
mod source;
mod tangent;

pub use environment::{default_environment, load_environment};
pub use error::GltfError;
pub use extension::{ExtensionUse, Treatment};
pub use framing::{bounds, default_camera};
pub use material::material_of_query;

use crate::scene::{Instance, Material, Scene};
use accessor::{Accessors, Attribute};
use deform::Pose;
use glam::{Affine3A, DAffine3, DMat4, Vec3};
use json::Json;
use serde::Serialize;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Bytes that a scene may take where nothing else is said.
pub const DEFAULT_MAX_MEMORY: u64 = 4 << 30;

/// How to load a scene.
#[derive(Clone, Debug)]
pub struct LoadOptions {
    /// Folders that the file may read beside its own.
    pub allow_paths: Vec<PathBuf>,
    /// Ceiling in bytes on all that is read and made of it.
    pub max_memory: u64,
    /// An environment map in place of the default one.
    pub environment: Option<PathBuf>,
}

impl Default for LoadOptions {
    fn default() -> Self {
        Self {
            allow_paths: Vec::new(),
            max_memory: DEFAULT_MAX_MEMORY,
            environment: None,
        }
    }
}

/// A scene and what there is to say about it.
#[derive(Clone, Debug)]
pub struct Loaded {
    pub scene: Scene,
    pub extensions: Vec<ExtensionUse>,
    /// What the file holds and the picture does not show, one sentence each.
    pub notes: Vec<String>,
    pub counts: Counts,
    /// The scene brought no light, so that it is lit by [`default_environment`]. Punctual lights and
    /// emissive surfaces are light, but for emissive textures whose factor and strength are within 1.
    pub default_light: bool,
}

/// How much of what a file holds. `drawn_*` counts what the scene shows, instances included.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    pub scenes: usize,
    pub nodes: usize,
    pub meshes: usize,
    pub primitives: usize,
    pub materials: usize,
    pub textures: usize,
    pub images: usize,
    pub cameras: usize,
    pub lights: usize,
    pub skins: usize,
    pub animations: usize,
    pub drawn_instances: usize,
    pub drawn_triangles: u64,
    pub buffer_bytes: u64,
    /// What the scene was charged for: an upper bound on what it takes, in bytes.
    pub memory_bytes: u64,
}

/// Reads a .gltf or .glb file, told apart by their first bytes.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Loaded, GltfError> {
    let source = source::Source::new(path, options);
    let document = source::open(path, &source)?;
    let root = Json::root(&document);
    version(&root)?;
    let mut notes = notes::Notes::default();
    let mut extensions = extension::inventory(&root)?;
    let nodes = node::Nodes::read(&root, &mut notes)?;
    let buffers = buffer::Buffers::load(&root, &source)?;

    let mut scene = Scene::default();
    let mut materials = material::Materials {
        images: image::Images::new(&buffers, &source),
        extensions: &mut extensions,
        notes: &mut notes,
    };
    let used = used_materials(&root, &nodes)?;
    for (index, json) in root.objects("materials")?.iter().enumerate() {
        // One that nothing shown uses keeps its number and reads no images.
        scene.materials.push(match used.contains(&Some(index)) {
            true => materials.material(json)?,
            false => Material {
                name: json.name(),
                ..material::default_material()
            },
        });
    }
    let default_material = scene.materials.len();
    if used.contains(&None) {
        scene.materials.push(material::default_material());
    }
    let images = materials.images;

    let lights = light::lights(&root)?;
    for &node in &nodes.shown {
        scene.cameras.extend(camera::camera(&nodes, node)?);
        scene
            .lights
            .extend(light::light(&nodes, node, &lights, &mut notes)?);
    }
    let accessors = Accessors {
        buffers: &buffers,
        budget: &source.budget,
    };
    place_meshes(&mut scene, &nodes, accessors, default_material, &mut notes)?;
    scene.images = images.decode()?;
    if !root.elements("animations")?.is_empty() {
        notes.add("animations are not played: the rest pose is drawn", "");
    }

    let lit = !scene.lights.is_empty() || gives_light(&scene);
    let default_light = !lit && options.environment.is_none();
    scene.environment = match &options.environment {
        Some(path) => Some(environment::load_environment_within(path, &source.budget)?),
        None if default_light => Some(default_environment()),
        None => None,
    };
    let mut counts = count(&root, &scene)?;
    counts.buffer_bytes = buffers.total();
    counts.memory_bytes = source.budget.used();
    Ok(Loaded {
        scene,
        extensions,
        notes: notes.into_lines(),
        counts,
        default_light,
    })
}

/// The names and the JSON of a file's materials, in order; nothing else of the file is read.
pub fn material_objects(
    path: &Path,
    options: &LoadOptions,
) -> Result<Vec<(String, serde_json::Value)>, GltfError> {
    let source = source::Source::new(path, options);
    let document = source::open(path, &source)?;
    let root = Json::root(&document);
    version(&root)?;
    let materials = root.objects("materials")?;
    Ok(materials
        .iter()
        .map(|json| (json.name(), json.value().clone()))
        .collect())
}

/// glTF 2.0 section 3.2: minor versions are compatible, major ones are not.
fn version(root: &Json<'_>) -> Result<(), GltfError> {
    let asset = root.required("asset")?;
    let version = asset.required("version")?;
    let needed = asset.get("minVersion").unwrap_or_else(|| version.clone());
    if version.as_string()?.split('.').next() != Some("2") {
        return Err(version.invalid(format!("it is glTF {}, not 2", version.value())));
    }
    match needed.as_string()? {
        "2.0" | "2.1" => Ok(()),
        other if needed.at == version.at && other.starts_with("2.") => Ok(()),
        other => Err(needed.invalid(format!("it needs glTF {other}; Snell reads 2.0"))),
    }
}

/// The materials of all meshes that the scene shows; `None` is the default one.
fn used_materials(
    root: &Json<'_>,
    nodes: &node::Nodes<'_>,
) -> Result<std::collections::HashSet<Option<usize>>, GltfError> {
    let mut meshes = std::collections::HashSet::new();
    for &node in &nodes.shown {
        meshes.extend(
            nodes.json[node]
                .reference("mesh", "meshes")?
                .map(|(index, _)| index),
        );
    }
    let mut used = std::collections::HashSet::new();
    for (index, mesh) in root.objects("meshes")?.iter().enumerate() {
        if meshes.contains(&index) {
            for primitive in mesh.objects("primitives")? {
                let material = primitive.reference("material", "materials")?;
                used.insert(material.map(|(index, _)| index));
            }
        }
    }
    Ok(used)
}

/// Reads each mesh once for each pose that it is shown in, and places it.
fn place_meshes(
    scene: &mut Scene,
    nodes: &node::Nodes<'_>,
    accessors: Accessors<'_>,
    default_material: usize,
    notes: &mut notes::Notes,
) -> Result<(), GltfError> {
    let mut known = HashMap::new();
    for &node in &nodes.shown {
        let json = &nodes.json[node];
        let Some((index, mesh)) = json.reference("mesh", "meshes")? else {
            continue;
        };
        let weights = json.numbers("weights")?;
        let joints = skin_joints(nodes, node, accessors)?;
        // A skin moves the mesh to where the joints are: the node's own place does not count.
        let world_from_object = match joints {
            Some(_) => Affine3A::IDENTITY,
            None => nodes.world_f32(node)?,
        };
        let bits: Option<Vec<u32>> = weights
            .as_ref()
            .map(|weights| weights.iter().map(|weight| weight.to_bits()).collect());
        let key = (index, bits, joints.as_ref().map(|_| node));
        let mesh = match known.get(&key) {
            Some(&mesh) => mesh,
            None => {
                let mut meshes = mesh::Meshes {
                    accessors,
                    materials: &scene.materials,
                    default_material,
                    notes,
                };
                let pose = Pose {
                    weights,
                    joints: joints.as_deref(),
                };
                let mesh = meshes.mesh(&mesh, &pose)?;
                scene.meshes.push(mesh);
                known.insert(key, scene.meshes.len() - 1);
                scene.meshes.len() - 1
            }
        };
        if scene.meshes[mesh].primitives.is_empty() {
            continue;
        }
        check_extent(&scene.meshes[mesh], world_from_object, json)?;
        if !world_from_object.inverse().is_finite() {
            notes.add("a mesh scaled to nothing is not drawn", &json.at);
            continue;
        }
        scene.instances.push(Instance {
            name: json.name(),
            mesh,
            world_from_object,
            node,
        });
    }
    Ok(())
}

/// World from bind pose for each joint of a node's skin (glTF 2.0 section 3.7.3).
fn skin_joints(
    nodes: &node::Nodes<'_>,
    node: usize,
    accessors: Accessors<'_>,
) -> Result<Option<Vec<Affine3A>>, GltfError> {
    const MAT4: Attribute = Attribute::of(&["MAT4"]);
    let Some((_, skin)) = nodes.json[node].reference("skin", "skins")? else {
        return Ok(None);
    };
    let joints = skin.elements("joints")?;
    let inverse = accessors.floats::<16>(&skin, "inverseBindMatrices", &MAT4)?;
    if let Some(inverse) = &inverse
        && inverse.len() < joints.len()
    {
        return Err(skin.invalid(format!(
            "inverseBindMatrices has {} elements for {} joints",
            inverse.len(),
            joints.len()
        )));
    }
    let mut matrices = Vec::with_capacity(joints.len());
    for (index, joint) in joints.iter().enumerate() {
        let (joint_node, _) = joint.follow("nodes")?;
        let bind = match &inverse {
            Some(inverse) => {
                let matrix = inverse[index].map(f64::from);
                DAffine3::from_mat4(DMat4::from_cols_array(&matrix))
            }
            None => DAffine3::IDENTITY,
        };
        let matrix = node::to_f32(nodes.world(joint_node) * bind);
        if !matrix.is_finite() {
            return Err(joint.invalid("the joint's place in the world is not finite"));
        }
        matrices.push(matrix);
    }
    Ok(Some(matrices))
}

/// The corners of an instance's box must stay where 32-bit numbers can work.
fn check_extent(
    mesh: &crate::scene::Mesh,
    world_from_object: Affine3A,
    node: &Json<'_>,
) -> Result<(), GltfError> {
    let points = mesh
        .primitives
        .iter()
        .flat_map(|primitive| &primitive.positions);
    let far = points.fold(Vec3::ZERO, |far, p| far.max(p.abs()));
    let matrix = world_from_object.matrix3;
    let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    let reach = columns
        .iter()
        .zip(far.to_array())
        .map(|(column, far)| column.abs() * far);
    let reach = reach.fold(world_from_object.translation.abs(), |sum, part| sum + part);
    if reach.max_element() <= mesh::MAX_POSITION {
        Ok(())
    } else {
        Err(node.invalid(format!(
            "its mesh reaches farther out than {:e} m",
            mesh::MAX_POSITION
        )))
    }
}

/// Whether a surface that is shown is there to give light. A texture that glows no brighter than a
/// lit white surface is a screen or a label on something: alone it would leave the rest of it dark.
fn gives_light(scene: &Scene) -> bool {
    let shown = scene
        .instances
        .iter()
        .flat_map(|instance| &scene.meshes[instance.mesh].primitives);
    let mut materials = shown.map(|primitive| &scene.materials[primitive.material]);
    materials.any(|material| {
        let least = match material.emissive_texture {
            Some(_) => 1.0,
            None => 0.0,
        };
        material.emissive.max_element() > least
    })
}

fn count(root: &Json<'_>, scene: &Scene) -> Result<Counts, GltfError> {
    let length = |key: &str| root.elements(key).map(|list| list.len());
    let mut primitives = 0;
    for mesh in root.objects("meshes")? {
        primitives += mesh.elements("primitives")?.len();
    }
    let triangles = scene.instances.iter().flat_map(|instance| {
        let primitives = &scene.meshes[instance.mesh].primitives;
        primitives
            .iter()
            .map(|primitive| primitive.triangles.len() as u64)
    });
    Ok(Counts {
        scenes: length("scenes")?,
        nodes: length("nodes")?,
        meshes: length("meshes")?,
        primitives,
        materials: length("materials")?,
        textures: length("textures")?,
        images: length("images")?,
        cameras: length("cameras")?,
        lights: light::lights(root)?.len(),
        skins: length("skins")?,
        animations: length("animations")?,
        drawn_instances: scene.instances.len(),
        drawn_triangles: triangles.sum(),
        ..Counts::default()
    })
}
