//! A file that is open: read once, and made into scenes for as many moments as are asked for.

use super::accessor::Accessors;
use super::animation::Animation;
use super::buffer::Buffers;
use super::error::GltfError;
use super::extension::ExtensionUse;
use super::image::Images;
use super::json::{Document, Json};
use super::notes::Notes;
use super::place::{KnownMeshes, Placer};
use super::pointer::{self, Undo};
use super::shutter::{self, Tracks};
use super::source::{self, Source};
use super::stroke::Strokes;
use super::{
    AnimationChoice, AnimationInfo, Counts, LoadOptions, Loaded, Metadata, Moment, animation,
    camera, environment, extension, ies, image_based, light, material, node, variant, xmp,
};
use crate::scene::{Environment, Material, PunctualLight, Scene};
use glam::DAffine3;
use serde::Serialize;
use std::collections::HashSet;
use std::ops::Range;
use std::path::Path;
use std::time::Instant;

/// A file with everything of it that does not change from one moment to the next: buffers, decoded
/// images, and the meshes of the moment before.
pub struct Asset {
    document: Document,
    source: Source,
    buffers: Buffers,
    images: Images,
    meshes: KnownMeshes,
    /// Of the scene at the first moment, where its strokes asked for it.
    extent: Option<f32>,
    /// The one that the options name.
    environment: Option<Environment>,
    /// The one that the file brings.
    image_based: image_based::Known,
    profiles: ies::Profiles,
    animations: Vec<Animation>,
    /// What takes the last moment back out of the document.
    undo: Vec<Undo>,
    variants: Vec<String>,
    /// Of `variants`.
    variant: Option<usize>,
    metadata: Vec<Metadata>,
    /// What of the memory ceiling is taken by all this but the meshes, in bytes.
    taken: u64,
}

/// What there is to say of a skin.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Skin {
    pub name: String,
    pub joints: usize,
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
        let accessors = Accessors {
            buffers: &buffers,
            budget: &source.budget,
            overrides: None,
        };
        let animations = animation::animations(&root, accessors)?;
        let variants = variant::variants(&root)?;
        let metadata = xmp::metadata(&root)?;
        Ok(Self {
            taken: source.budget.used(),
            document,
            source,
            buffers,
            images: Images::default(),
            meshes: KnownMeshes::default(),
            extent: None,
            environment,
            image_based: image_based::Known::default(),
            profiles: ies::Profiles::default(),
            animations,
            undo: Vec::new(),
            variants,
            variant: None,
            metadata,
        })
    }

    /// The file's animations, in its order.
    pub fn animations(&self) -> Vec<AnimationInfo> {
        let animations = self.animations.iter();
        animations.map(|animation| animation.info.clone()).collect()
    }

    /// The names of the file's material variants (KHR_materials_variants), in its order.
    pub fn variants(&self) -> Vec<String> {
        self.variants.clone()
    }

    /// The file's skins, in its order.
    pub fn skins(&self) -> Result<Vec<Skin>, GltfError> {
        let skins = Json::root(&self.document).objects("skins")?;
        let skin = |json: &Json<'_>| {
            Ok(Skin {
                name: json.name(),
                joints: json.elements("joints")?.len(),
            })
        };
        skins.iter().map(skin).collect()
    }

    /// What the images of the scene last made are encoded as, in the order of `Scene::images`.
    pub fn image_formats(&self) -> Vec<&'static str> {
        self.images.formats()
    }

    /// Which of the variants further scenes show, by its place in `variants`; `None` shows the default
    /// materials, as do primitives that no mapping ties to the variant.
    pub fn choose_variant(&mut self, variant: Option<usize>) {
        self.variant = variant;
    }

    /// The scene at a moment. What has not changed since the last one is the same `Arc`.
    pub fn scene(&mut self, moment: &Moment) -> Result<Loaded, GltfError> {
        pointer::undo(&mut self.document.root, &mut self.undo);
        self.source.budget.rewind(self.taken);
        let mut notes = Notes::default();
        let root = Json::root(&self.document);
        let mut extensions = extension::inventory(&root)?;
        let files = (&self.buffers, &self.source);
        self.profiles.read(&root, files, &mut notes)?;
        self.taken = self.source.budget.used();
        let mut tracks = Tracks::default();
        let mut lights = None;
        let mut driven = Vec::new();
        match moment {
            Moment::Rest => {
                if !self.animations.is_empty() {
                    notes.add("the rest pose is drawn: no animation is played", "");
                }
            }
            &Moment::At {
                animation,
                seconds,
                shutter,
            } => {
                let chosen = self.chosen(animation)?;
                if shutter > 0.0 {
                    tracks = self.tracks(chosen.clone(), seconds, shutter)?;
                    self.pose(chosen.clone(), seconds + 0.5 * shutter);
                    lights = Some(self.lights_of_a_shutter(&tracks, &mut notes)?);
                }
                for animation in &self.animations[chosen.clone()] {
                    animation.say_what_is_left_out(&mut notes);
                    driven.extend(animation.driven_nodes());
                }
                self.pose(chosen, seconds);
            }
        }
        let root = Json::root(&self.document);
        let nodes = node::Nodes::read(&root, &mut notes)?;
        let of_this_moment = self.source.budget.used() - self.taken;

        let files = (&self.buffers, &self.source);
        let own = match &self.environment {
            None => self.image_based.environment(&root, files, &mut notes)?,
            Some(_) => None,
        };

        let mut scene = Scene::default();
        let mut materials = material::Materials {
            images: &mut self.images,
            buffers: &self.buffers,
            source: &self.source,
            extensions: &mut extensions,
            notes: &mut notes,
        };
        let used = used_materials(&root, &nodes, self.variant)?;
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
        let strokes = Strokes::read(
            &root,
            &nodes,
            default_material,
            &mut scene.materials,
            &mut self.extent,
            &mut notes,
        )?;
        let start = Instant::now();
        scene.images = self.images.decode(&root, &self.buffers, &self.source)?;
        let image_time = start.elapsed();
        self.taken = self.source.budget.used() - of_this_moment;

        for &node in &nodes.shown {
            scene
                .cameras
                .extend(camera::camera(&nodes, node, tracks.closing(node))?);
        }
        scene.profiles = self.profiles.all();
        scene.lights = match lights {
            Some(lights) => lights,
            None => punctual_lights(&root, &nodes, &self.profiles, &mut notes)?,
        };
        let accessors = Accessors {
            buffers: &self.buffers,
            budget: &self.source.budget,
            overrides: None,
        };
        let known = std::mem::take(&mut self.meshes);
        let animated = nodes.below(driven).into_iter().collect();
        let mut placer = Placer {
            nodes: &nodes,
            accessors,
            default_material,
            variant: self.variant,
            strokes: &strokes,
            tracks: &tracks,
            animated: &animated,
            notes: &mut notes,
        };
        self.meshes = placer.place(&mut scene, known)?;

        let lit = own.is_some() || !scene.lights.is_empty() || gives_light(&scene);
        let default_light = !lit && self.environment.is_none();
        let brings_its_own = |e: &ExtensionUse| e.name == image_based::NAME && e.uses > 0;
        if self.environment.is_some() && extensions.iter().any(brings_its_own) {
            notes.add(
                "the environment that was asked for takes the place of the file's own",
                "",
            );
        }
        scene.environment = self.environment.clone().or(own);
        if default_light {
            scene.environment = Some(environment::default_environment());
        }
        let mut counts = count(&root, &scene)?;
        counts.buffer_bytes = self.buffers.total();
        counts.memory_bytes = self.source.budget.used();
        Ok(Loaded {
            scene,
            extensions,
            notes: notes.into_lines(),
            counts,
            metadata: self.metadata.clone(),
            default_light,
            image_time,
        })
    }

    /// The animations that are meant, as a range of the file's.
    fn chosen(&self, animation: AnimationChoice) -> Result<Range<usize>, GltfError> {
        let count = self.animations.len();
        match animation {
            AnimationChoice::All => Ok(0..count),
            AnimationChoice::Index(index) if index < count => Ok(index..index + 1),
            AnimationChoice::Index(index) => Err(Json::root(&self.document).invalid(format!(
                "animation {index} is out of range: there are {count} animations"
            ))),
        }
    }

    /// Puts a time of some animations into the document, in place of the one before.
    fn pose(&mut self, chosen: Range<usize>, seconds: f64) {
        let root = &mut self.document.root;
        pointer::undo(root, &mut self.undo);
        animation::pose(root, &self.animations[chosen], seconds, &mut self.undo);
    }

    /// What moves while the shutter is open.
    fn tracks(
        &mut self,
        chosen: Range<usize>,
        seconds: f64,
        shutter: f64,
    ) -> Result<Tracks, GltfError> {
        let mut tracks = Tracks::default();
        for step in 0..=shutter::STEPS {
            let t = step as f64 / shutter::STEPS as f64;
            self.pose(chosen.clone(), seconds + t * shutter);
            let root = Json::root(&self.document);
            // What there is to note is noted when the scene is read.
            let nodes = node::Nodes::read(&root, &mut Notes::default())?;
            if step == 0 {
                let animations = self.animations[chosen.clone()].iter();
                let driven = animations.clone().flat_map(Animation::moved_nodes);
                let moving = nodes.below(driven);
                let bytes = moving.len() * (shutter::STEPS + 1) * size_of::<DAffine3>();
                self.source.budget.take(bytes as u64, root.file(), "")?;
                tracks.worlds = moving.into_iter().map(|node| (node, Vec::new())).collect();
                let morphed =
                    animations.flat_map(|one| one.morphed_nodes(seconds, seconds + shutter));
                tracks.morphed = morphed.collect();
            }
            for (&node, track) in &mut tracks.worlds {
                track.push(nodes.world(node));
            }
        }
        Ok(tracks)
    }

    /// The lights as the document has them now, in the middle of the shutter.
    fn lights_of_a_shutter(
        &self,
        tracks: &Tracks,
        notes: &mut Notes,
    ) -> Result<Vec<PunctualLight>, GltfError> {
        let root = Json::root(&self.document);
        let nodes = node::Nodes::read(&root, &mut Notes::default())?;
        for &node in &nodes.shown {
            let json = &nodes.json[node];
            let lamp = json.extension(light::NAME)?.or(json.extension(ies::NAME)?);
            if tracks.moves(node) && lamp.is_some() {
                notes.add(
                    "a light that moves is not blurred: it is where it is in the middle of the shutter",
                    &nodes.json[node].at,
                );
            }
        }
        punctual_lights(&root, &nodes, &self.profiles, notes)
    }
}

/// The lights of all nodes that the scene shows.
fn punctual_lights(
    root: &Json<'_>,
    nodes: &node::Nodes<'_>,
    profiles: &ies::Profiles,
    notes: &mut Notes,
) -> Result<Vec<PunctualLight>, GltfError> {
    let lights = light::lights(root)?;
    let mut placed = Vec::new();
    for &node in nodes.shown.iter().filter(|&&node| nodes.visible[node]) {
        placed.extend(light::light(nodes, node, &lights, notes)?);
        placed.extend(profiles.light(nodes, node, notes)?);
    }
    Ok(placed)
}

/// The materials of all meshes that the scene shows; `None` is the default one.
fn used_materials(
    root: &Json<'_>,
    nodes: &node::Nodes<'_>,
    variant: Option<usize>,
) -> Result<HashSet<Option<usize>>, GltfError> {
    let mut meshes = HashSet::new();
    for &node in nodes.shown.iter().filter(|&&node| nodes.visible[node]) {
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
                let material = variant::material(&primitive, variant)?;
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
        lights: light::lights(root)?.len() + ies::lights(root)?.len(),
        skins: length("skins")?,
        animations: length("animations")?,
        drawn_instances: scene.instances.len(),
        drawn_triangles: triangles.sum(),
        ..Counts::default()
    })
}
