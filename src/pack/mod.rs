//! From a scene to the flat arrays that both renderers read: the fork in the data flow.

pub mod bake;
pub mod camera;
pub mod environment;
pub mod geometry;
pub mod light_tree;
pub mod lights;
pub mod material;
pub mod mesh;
pub mod model;
pub mod outline;
pub mod texture;
pub mod vertex;

use crate::bvh::{Bounds, Hierarchy, MAX_DEPTH};
use crate::scene::{self, Scene};
use crate::shared::{
    BACKGROUND_COLOR, BACKGROUND_ENVIRONMENT, BACKGROUND_TRANSPARENT, Frame, INSTANCE_KEYS_MASK,
    INSTANCE_KEYS_SHIFT, Instance, Light, LightNode, MATERIAL_ALPHA_BLEND, MATERIAL_ALPHA_MASK,
    MATERIAL_EMISSIVE, MATERIAL_THIN_WALLED, Material, NONE, Tables, Triangle,
};
use crate::tables::tables;
use bytemuck::Zeroable;
use environment::PackedEnvironment;
use geometry::Geometry;
use glam::{Vec3, Vec4};
use outline::Outline;
use std::time::{Duration, Instant};

/// Everything a renderer reads, as it goes to the GPU byte for byte.
#[derive(Clone)]
pub struct Packed {
    /// One per picture; a renderer sets tile and sample range in its own copy.
    pub frame: Frame,
    pub tables: Box<Tables>,
    /// CWBVH nodes, five words of 16 bytes each, of all hierarchies.
    pub nodes: Vec<[u32; 4]>,
    pub triangles: Vec<Triangle>,
    /// In the order of the top-level hierarchy's leaves; behind them the further keys of those that move.
    pub instances: Vec<Instance>,
    /// Words of attributes: see `LAYOUT_*`; the normal's comes first in each vertex.
    pub vertices: Vec<u32>,
    pub materials: Vec<Material>,
    pub texels: Vec<u32>,
    pub lights: Vec<Light>,
    /// Of the light tree, `2 * frame.light_tree_leaves`; one of zeros where there is no tree.
    pub light_nodes: Vec<LightNode>,
    /// Radiance of the environment map, `frame.environment_size`; at least one texel.
    pub environment: Vec<[f32; 4]>,
    /// `frame.environment_cells` rows of `x + 1` entries (cumulative probability in the row, density
    /// per unit square of (u, v)); the last entry of a row holds the rows' own cumulative probability.
    pub environment_cells: Vec<[f32; 2]>,
}

/// The arrays of `Packed` that kernels index, by name and in the order of their bindings
/// (shaders/bindings.wgsl, from 2 on).
pub const ARRAYS: [&str; 7] = [
    "nodes",
    "triangles",
    "instances",
    "vertices",
    "materials",
    "texels",
    "lights",
];

impl Packed {
    /// Whether something moves while the shutter is open.
    pub fn moves(&self) -> bool {
        let keys = |instance: &Instance| instance.flags >> INSTANCE_KEYS_SHIFT;
        self.frame.camera.moves != 0 || self.instances.iter().any(|instance| keys(instance) != 0)
    }

    /// The `ARRAYS` in their order, as bytes.
    pub fn arrays(&self) -> [(&'static str, &[u8]); ARRAYS.len()] {
        let bytes: [&[u8]; ARRAYS.len()] = [
            bytemuck::cast_slice(&self.nodes),
            bytemuck::cast_slice(&self.triangles),
            bytemuck::cast_slice(&self.instances),
            bytemuck::cast_slice(&self.vertices),
            bytemuck::cast_slice(&self.materials),
            bytemuck::cast_slice(&self.texels),
            bytemuck::cast_slice(&self.lights),
        ];
        std::array::from_fn(|number| (ARRAYS[number], bytes[number]))
    }
}

/// What is asked of a scene: a picture.
#[derive(Clone, Debug)]
pub struct View {
    pub camera: scene::Camera,
    /// Pixels, neither zero.
    pub film_size: [u32; 2],
    pub seed: u32,
    /// Surface interactions a path may have; 1 is direct light only.
    pub max_depth: u32,
    pub background: Background,
    /// Limits the largest channel of each sample's radiance, which biases the picture.
    pub clamp: Option<f32>,
}

/// What a camera ray that meets nothing brings home.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    Environment,
    /// Linear Rec. 709 radiance.
    Color([f32; 3]),
    Transparent,
}

#[derive(Debug, thiserror::Error)]
pub enum PackError {
    #[error(
        "the scene needs {count} entries of {what}, and an index has 32 bits; use a smaller scene"
    )]
    TooMany { what: &'static str, count: usize },
    #[error(
        "{what} reaches {reach:e} m from the origin; beyond {limit:e} m single precision fails: scale the scene down",
        limit = mesh::MAX_COORDINATE
    )]
    TooFar { what: String, reach: f32 },
    #[error(
        "the hierarchy of {what} has {depth} levels, more than the traversal's stack holds ({limit}); split it up",
        limit = MAX_DEPTH
    )]
    TooDeep { what: String, depth: usize },
    #[error(
        "the mesh of nodes[{node}] has {keys} steps of motion, and an instance holds {limit}; use a shorter shutter",
        limit = INSTANCE_KEYS_MASK
    )]
    TooManyKeys { node: usize, keys: usize },
    #[error(
        "the lens shows no single direction at pixel {column},{row}: its distortion turns back inside the picture; check the coefficients, or render a smaller part of the lens' image"
    )]
    Folded { column: i64, row: i64 },
    #[error("material \"{material}\": {source}")]
    Model {
        material: String,
        source: model::ModelError,
    },
}

/// Packs one picture after the other and keeps of each what the next may need again: meshes and
/// images are told by their `Arc`. What it gives is what [`pack`] gives.
#[derive(Default)]
pub struct Packer {
    meshes: geometry::KnownMeshes,
    images: texture::KnownImages,
    /// What the last picture's meshes and hierarchies took.
    pub geometry_time: Duration,
}

impl Packer {
    pub fn pack(&mut self, scene: &Scene, view: &View) -> Result<Packed, PackError> {
        pack_with(scene, view, Some(self), None)
    }

    /// The same; `tell` hears what kernels there will be before meshes are packed.
    pub fn pack_and_tell(
        &mut self,
        scene: &Scene,
        view: &View,
        tell: Option<&mut dyn FnMut(Outline)>,
    ) -> Result<Packed, PackError> {
        pack_with(scene, view, Some(self), tell)
    }

    /// How many meshes and images the last picture brought; what stands still is one mesh.
    pub fn new_parts(&self) -> [usize; 2] {
        [self.meshes.new, self.images.new]
    }
}

/// Packs a scene for one picture. The same scene and view give the same bytes, whatever the number
/// of threads.
///
/// An instance whose transform has no inverse in single precision (a scale of zero) has no surface to
/// hit and is left out, as is one whose mesh has no triangles.
pub fn pack(scene: &Scene, view: &View) -> Result<Packed, PackError> {
    pack_with(scene, view, None, None)
}

fn pack_with(
    scene: &Scene,
    view: &View,
    packer: Option<&mut Packer>,
    tell: Option<&mut dyn FnMut(Outline)>,
) -> Result<Packed, PackError> {
    let (meshes, images, geometry_time) = match packer {
        Some(packer) => (
            Some(&mut packer.meshes),
            Some(&mut packer.images),
            Some(&mut packer.geometry_time),
        ),
        None => (None, None, None),
    };
    let mut textures = texture::Textures::gather(scene, images)?;
    let materials = scene
        .materials
        .iter()
        .map(|material| material::pack_material(material, &textures))
        .collect::<Result<Vec<_>, _>>()?;
    let profiles = lights::place_profiles(&scene.profiles, &mut textures.texels)?;
    let punctual: Vec<Light> = (scene.lights.iter())
        .map(|light| lights::punctual_light(light, &profiles))
        .collect();
    let camera = camera::pack_camera(&view.camera, view.film_size)?;
    let start = Instant::now();
    let baked = bake::choose(scene);
    if let Some(tell) = tell {
        tell(Outline::foresee(
            scene, &materials, camera, &punctual, &baked,
        ));
    }
    let mut geometry = geometry::pack_geometry(scene, &baked, meshes)?;
    if let Some(time) = geometry_time {
        *time = start.elapsed();
    }
    let flags: Vec<u32> = materials.iter().map(material::triangle_flags).collect();
    for triangle in &mut geometry.triangles {
        triangle.flags = flags[triangle.material as usize];
    }
    let environment = scene
        .environment
        .as_ref()
        .map(environment::build_environment);
    let mut lights = gather_lights(scene, &geometry, &materials, punctual, environment.as_ref());
    let radius = 0.5 * diagonal(geometry.bounds);
    let weights = lights::build_lights(&mut lights, radius);
    let light_tree = light_tree::build_light_tree(&mut lights, &geometry, &materials, radius)?;
    let any_triangle = |flags: u32| {
        geometry
            .triangles
            .iter()
            .any(|triangle| materials[triangle.material as usize].flags & flags != 0)
    };
    let has_alpha = any_triangle(MATERIAL_ALPHA_MASK | MATERIAL_ALPHA_BLEND);
    let has_thin_walls = any_triangle(MATERIAL_THIN_WALLED);
    let (background_kind, background) = match view.background {
        Background::Environment => (BACKGROUND_ENVIRONMENT, [0.0; 3]),
        Background::Color(color) => (BACKGROUND_COLOR, color),
        Background::Transparent => (BACKGROUND_TRANSPARENT, [0.0; 3]),
    };
    let mut frame = Frame {
        camera,
        background,
        background_kind,
        environment_cos: 1.0,
        environment_weight: weights.environment,
        film_size: view.film_size,
        tile_size: view.film_size,
        environment_size: [1, 1],
        environment_cells: [1, 1],
        sample_count: 1,
        seed: view.seed,
        max_depth: view.max_depth,
        light_count: light_tree.light_count,
        light_weight_total: weights.total,
        root: geometry.root,
        mesh_root: geometry.mesh_root,
        ray_offset_floor: RAY_OFFSET_FLOOR * diagonal(geometry.bounds),
        has_alpha: u32::from(has_alpha),
        has_thin_walls: u32::from(has_thin_walls),
        light_tree_triangles: light_tree.triangles,
        light_tree_leaves: light_tree.leaves,
        clamp: view.clamp.unwrap_or(0.0),
        ..Frame::zeroed()
    };
    let mut texels_of_environment = vec![[0.0; 4]];
    let mut cells_of_environment = vec![[1.0, 1.0]; 2];
    if let (Some(packed), Some(environment)) = (environment, &scene.environment) {
        frame.environment_strength = environment.strength;
        frame.environment_cos = environment.rotation.cos();
        frame.environment_sin = environment.rotation.sin();
        frame.environment_size = packed.size;
        frame.environment_cells = packed.cells_size;
        texels_of_environment = packed.texels;
        cells_of_environment = packed.cells;
    }
    Ok(Packed {
        frame,
        tables: tables(),
        nodes: geometry.nodes,
        triangles: geometry.triangles,
        instances: geometry.instances,
        vertices: geometry.vertices,
        materials,
        texels: textures.texels,
        lights,
        light_nodes: light_tree.nodes,
        environment: texels_of_environment,
        environment_cells: cells_of_environment,
    })
}

fn check_depth(
    hierarchy: Option<Hierarchy>,
    what: impl Fn() -> String,
) -> Result<Option<Hierarchy>, PackError> {
    match hierarchy {
        Some(Hierarchy { depth, .. }) if depth > MAX_DEPTH => Err(PackError::TooDeep {
            what: what(),
            depth,
        }),
        other => Ok(other),
    }
}

/// Everything that a path may aim at: the `punctual` lights, the triangles of emissive materials wherever
/// they are placed, and the environment. Triangles without area send nothing and are left out.
fn gather_lights(
    scene: &Scene,
    geometry: &Geometry,
    materials: &[Material],
    punctual: Vec<Light>,
    environment: Option<&PackedEnvironment>,
) -> Vec<Light> {
    let mut all = punctual;
    // Of the meshes, not of their instances, of which there may be millions.
    let shines = |&index: &u32| {
        let material = geometry.triangles[index as usize].material;
        materials[material as usize].flags & MATERIAL_EMISSIVE != 0
    };
    let shining: Vec<u32> = (0..geometry.triangles.len() as u32)
        .filter(shines)
        .collect();
    for (number, (instance, range)) in geometry.instances.iter().zip(&geometry.ranges).enumerate() {
        let first = shining.partition_point(|&index| index < range.start);
        for &index in shining[first..]
            .iter()
            .take_while(|&index| *index < range.end)
        {
            let triangle = &geometry.triangles[index as usize];
            let material = &materials[triangle.material as usize];
            let p0 = Vec3::from_array(triangle.p0);
            let corners = [
                p0,
                p0 + Vec3::from_array(triangle.e1),
                p0 + Vec3::from_array(triangle.e2),
            ];
            let at_key = |instance: &Instance| {
                let rows = instance.world_from_object.map(Vec4::from_array);
                let place = |p: Vec3| {
                    let p = p.extend(1.0).as_dvec4();
                    Vec3::from_array(rows.map(|row| row.as_dvec4().dot(p) as f32))
                };
                lights::triangle_light(
                    corners.map(place),
                    material.emissive,
                    material.emission_weight,
                    index,
                    number as u32,
                )
            };
            // A moving one is in the table as it is where it is largest: as long as it has an area
            // at some key, it can be chosen.
            let light = geometry.further_keys(instance).iter().map(at_key).fold(
                at_key(instance),
                |most, light| {
                    if light.weight > most.weight {
                        light
                    } else {
                        most
                    }
                },
            );
            all.extend((light.weight > 0.0).then_some(light));
        }
    }
    if let (Some(packed), Some(environment)) = (environment, &scene.environment) {
        let mean_luminance = packed.mean_luminance * environment.strength;
        if mean_luminance > 0.0 {
            all.push(lights::environment_light(mean_luminance));
        }
    }
    all
}

/// `count` as an index of 32 bits that is not `NONE`.
fn index(what: &'static str, count: usize) -> Result<u32, PackError> {
    match u32::try_from(count) {
        Ok(index) if index != NONE => Ok(index),
        _ => Err(PackError::TooMany { what, count }),
    }
}

fn check_extent(bounds: Bounds, what: impl Fn() -> String) -> Result<(), PackError> {
    if bounds == Bounds::EMPTY {
        return Ok(());
    }
    let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
    // Not `reach > MAX`: that lets NaN pass.
    if reach <= mesh::MAX_COORDINATE {
        Ok(())
    } else {
        Err(PackError::TooFar {
            what: what(),
            reach,
        })
    }
}

/// The least distance by which a ray starts off a surface, for points whose own error along the
/// normal is zero, as part of the scene's diagonal: 2^-28, which single precision takes for nothing.
const RAY_OFFSET_FLOOR: f32 = 3.725_290_3e-9;

/// Metres; 0 for nothing.
fn diagonal(bounds: Bounds) -> f32 {
    if bounds == Bounds::EMPTY {
        return 0.0;
    }
    (bounds.max - bounds.min).length()
}
