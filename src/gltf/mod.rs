//! From a glTF 2.0 file to a [`Scene`]: everything is checked here, so that nothing behind has to.
//!
//! A file is untrusted. It reads only regular files in its own folder, symbolic links followed
//! (`LoadOptions::allow_paths` widens that); every size that it claims is compared with what is
//! there, or paid for out of `LoadOptions::max_memory`, before anything is allocated; the hierarchy
//! is walked without recursion. Each error names its place in the JSON.

mod accessor;
mod animation;
mod asset;
mod buffer;
mod camera;
mod deform;
mod draco;
mod environment;
mod error;
#[cfg(feature = "basisu")]
mod etc1s;
mod extension;
mod framing;
mod ies;
mod image;
mod image_based;
mod instancing;
mod json;
#[cfg(feature = "basisu")]
mod ktx2;
mod light;
mod material;
mod mesh;
mod meshopt;
mod node;
mod normal;
mod notes;
mod place;
mod pointer;
mod shutter;
mod source;
mod stroke;
mod tangent;
#[cfg(feature = "basisu")]
mod uastc;
mod variant;
mod xmp;

pub use animation::{AnimationChoice, AnimationInfo, Moment};
pub use asset::{Asset, Skin};
pub use environment::{EnvironmentSource, default_environment, load_environment};
pub use error::GltfError;
pub use extension::{ExtensionUse, Treatment};
pub use framing::{bounds, default_camera, framing_camera};
pub use material::material_of_query;
pub use xmp::Metadata;

use crate::scene::Scene;
use json::Json;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Bytes that a scene may take where nothing else is said.
pub const DEFAULT_MAX_MEMORY: u64 = 4 << 30;

/// How to load a scene.
#[derive(Clone, Debug)]
pub struct LoadOptions {
    /// Folders that the file may read beside its own.
    pub allow_paths: Vec<PathBuf>,
    /// Ceiling in bytes on all that is read and made of it.
    pub max_memory: u64,
    /// Light from all around in place of the scene's own or the default one.
    pub environment: Option<EnvironmentSource>,
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
    /// KHR_xmp_json_ld.
    pub metadata: Vec<Metadata>,
    /// The scene brought no light, so that it is lit by [`default_environment`]. Punctual lights and
    /// emissive surfaces are light, but for emissive textures whose factor and strength are within 1.
    pub default_light: bool,
    /// Reading and decoding the images.
    pub image_time: Duration,
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

/// Reads a .gltf or .glb file, told apart by their first bytes, in the pose that it rests in.
pub fn load(path: &Path, options: &LoadOptions) -> Result<Loaded, GltfError> {
    Asset::open(path, options)?.scene(&Moment::Rest)
}

/// The names and the JSON of a file's materials, in order; nothing else of the file is read.
pub fn material_objects(
    path: &Path,
    options: &LoadOptions,
) -> Result<Vec<(String, serde_json::Value)>, GltfError> {
    let source = source::Source::new(path, options);
    let (document, _) = source::open(path, &source)?;
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
