//! A file that is open: read once, and made into scenes for as many moments as are asked for.

use super::accessor::Accessors;
use super::buffer::Buffers;
use super::error::GltfError;
use super::image::Images;
use super::json::{Document, Json};
use super::place::{self, KnownMeshes};
use super::source::{self, Source};
use super::{
    AnimationInfo, Counts, LoadOptions, Loaded, Moment, camera, environment, extension, light,
    material, node, notes,
};
use crate::scene::{Environment, Material, Scene};
use std::collections::HashSet;
use std::path::Path;

/// A file with everything of it that does not change from one moment to the next: buffers, decoded
/// images, and the meshes of the moment before.
pub struct Asset {
    document: Document,
    source: Source,
    buffers: Buffers,
    images: Images,
    meshes: KnownMeshes,
    /// The one that the options name.
    environment: Option<Environment>,
    /// Of KHR_materials_variants, by its number.
    variant: Option<usize>,
    /// What of the memory ceiling is taken by all this but the meshes, in bytes.
    taken: u64,
}

impl Asset {
    /// Reads the file, its buffers, and the environment map that the options name.
    pub fn open(path: &Path, options: &LoadOptions) -> Result<Self, GltfError> {
        let source = Source::new(path, options);
        let (document, bin) = source::open(path, &source)?;
        let root = Json::root(&document);
        super::version(&root)?;
        // What it requires and is not there is said before anything else of it is read.
        extension::inventory(&root)?;
        let buffers = Buffers::load(&root, bin, &source)?;
        let environment = match &options.environment {
            Some(environment) => Some(environment.load(path, &source.budget)?),
            None => None,
        };
        Ok(Self {
            taken: source.budget.used(),
            document,
            source,
            buffers,
            images: Images::default(),
            meshes: KnownMeshes::default(),
            environment,
            variant: None,
        })
    }

    /// The file's animations, in its order.
    pub fn animations(&self) -> Vec<AnimationInfo> {
        Vec::new()
    }

    /// The names of the file's material variants (KHR_materials_variants), in its order.
    pub fn variants(&self) -> Vec<String> {
        Vec::new()
    }

    /// Which of the variants further scenes show; `None` shows the default materials.
    pub fn choose_variant(&mut self, variant: Option<usize>) {
        self.variant = variant;
    }

    /// The scene at a moment. What has not changed since the last one is the same `Arc`.
    pub fn scene(&mut self, _moment: &Moment) -> Result<Loaded, GltfError> {
        self.source.budget.rewind(self.taken);
        let root = Json::root(&self.document);
        let mut notes = notes::Notes::default();
        let mut extensions = extension::inventory(&root)?;
        let nodes = node::Nodes::read(&root, &mut notes)?;

        let mut scene = Scene::default();
        let mut materials = material::Materials {
            images: &mut self.images,
            buffers: &self.buffers,
            source: &self.source,
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
        scene.images = self.images.decode(&root, &self.buffers, &self.source)?;
        self.taken = self.source.budget.used();

        let lights = light::lights(&root)?;
        for &node in &nodes.shown {
            scene.cameras.extend(camera::camera(&nodes, node)?);
            scene
                .lights
                .extend(light::light(&nodes, node, &lights, &mut notes)?);
        }
        let accessors = Accessors {
            buffers: &self.buffers,
            budget: &self.source.budget,
            overrides: None,
        };
        let known = std::mem::take(&mut self.meshes);
        self.meshes = place::place_meshes(
            &mut scene,
            &nodes,
            accessors,
            default_material,
            known,
            &mut notes,
        )?;
        if !root.elements("animations")?.is_empty() {
            notes.add("animations are not played: the rest pose is drawn", "");
        }

        let lit = !scene.lights.is_empty() || gives_light(&scene);
        let default_light = !lit && self.environment.is_none();
        scene.environment = match &self.environment {
            Some(environment) => Some(environment.clone()),
            None if default_light => Some(environment::default_environment()),
            None => None,
        };
        let mut counts = count(&root, &scene)?;
        counts.buffer_bytes = self.buffers.total();
        counts.memory_bytes = self.source.budget.used();
        Ok(Loaded {
            scene,
            extensions,
            notes: notes.into_lines(),
            counts,
            metadata: Vec::new(),
            default_light,
        })
    }
}

/// The materials of all meshes that the scene shows; `None` is the default one.
fn used_materials(
    root: &Json<'_>,
    nodes: &node::Nodes<'_>,
) -> Result<HashSet<Option<usize>>, GltfError> {
    let mut meshes = HashSet::new();
    for &node in &nodes.shown {
        meshes.extend(
            nodes.json[node]
                .reference("mesh", "meshes")?
                .map(|(index, _)| index),
        );
    }
    let mut used = HashSet::new();
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
