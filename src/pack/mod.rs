//! From a scene to the flat arrays that both renderers read: the fork in the data flow.

pub mod camera;
pub mod environment;
pub mod lights;
pub mod material;
pub mod mesh;
pub mod model;
pub mod texture;

use crate::bvh::{self, Bounds};
use crate::scene::{self, Scene};
use crate::shared::{
    BACKGROUND_COLOR, BACKGROUND_ENVIRONMENT, BACKGROUND_TRANSPARENT, Frame, INSTANCE_FLIPPED,
    Instance, Light, MATERIAL_ALPHA_BLEND, MATERIAL_ALPHA_MASK, Material, NONE, Tables, Triangle,
};
use crate::tables::tables;
use bytemuck::Zeroable;
use glam::{DAffine3, DVec3, Vec3A};
use mesh::PackedMesh;
use rayon::prelude::*;

/// Everything a renderer reads, as it goes to the GPU byte for byte.
#[derive(Clone)]
pub struct Packed {
    /// One per picture; a renderer sets tile and sample range in its own copy.
    pub frame: Frame,
    pub tables: Box<Tables>,
    /// CWBVH nodes, five words of 16 bytes each, of all hierarchies.
    pub nodes: Vec<[u32; 4]>,
    pub triangles: Vec<Triangle>,
    /// In the order of the top-level hierarchy's leaves.
    pub instances: Vec<Instance>,
    /// Words of f32: see `LAYOUT_*`; three words of normal come first in each vertex.
    pub vertices: Vec<f32>,
    pub materials: Vec<Material>,
    pub texels: Vec<u32>,
    pub lights: Vec<Light>,
    /// Radiance of the environment map, `frame.environment_size`; at least one texel.
    pub environment: Vec<[f32; 4]>,
    /// `frame.environment_cells` rows of `x + 1` entries (cumulative probability in the row, density
    /// per unit square of (u, v)); the last entry of a row holds the rows' own cumulative probability.
    pub environment_cells: Vec<[f32; 2]>,
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
    #[error("material \"{material}\": {source}")]
    Model {
        material: String,
        source: model::ModelError,
    },
}

/// Packs a scene for one picture. The same scene and view give the same bytes, whatever the number
/// of threads.
///
/// An instance whose transform has no inverse (a scale of zero) has no surface to hit and is left
/// out, as is one whose mesh has no triangles.
pub fn pack(scene: &Scene, view: &View) -> Result<Packed, PackError> {
    let textures = texture::Textures::gather(scene)?;
    let materials = scene
        .materials
        .iter()
        .map(|material| material::pack_material(material, &textures))
        .collect::<Result<Vec<_>, _>>()?;
    let mut meshes = pack_meshes(scene)?;
    let Geometry {
        nodes,
        triangles,
        vertices,
        instances,
        root,
        bounds,
    } = assemble(scene, &mut meshes)?;
    let alpha = MATERIAL_ALPHA_MASK | MATERIAL_ALPHA_BLEND;
    let has_alpha = triangles
        .iter()
        .any(|triangle| materials[triangle.material as usize].flags & alpha != 0);
    let (background_kind, background) = match view.background {
        Background::Environment => (BACKGROUND_ENVIRONMENT, [0.0; 3]),
        Background::Color(color) => (BACKGROUND_COLOR, color),
        Background::Transparent => (BACKGROUND_TRANSPARENT, [0.0; 3]),
    };
    let frame = Frame {
        camera: camera::pack_camera(&view.camera, view.film_size),
        background,
        background_kind,
        film_size: view.film_size,
        tile_size: view.film_size,
        environment_size: [1, 1],
        environment_cells: [1, 1],
        sample_count: 1,
        seed: view.seed,
        max_depth: view.max_depth,
        root,
        ray_offset_floor: ray_offset_floor(bounds),
        has_alpha: u32::from(has_alpha),
        ..Frame::zeroed()
    };
    Ok(Packed {
        frame,
        tables: tables(),
        nodes,
        triangles,
        instances,
        vertices,
        materials,
        texels: textures.texels,
        lights: Vec::new(),
        environment: vec![[0.0; 4]],
        environment_cells: vec![[1.0, 1.0]; 2],
    })
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

/// Packs the meshes that some instance places, by the scene's numbers; others stay `None`.
fn pack_meshes(scene: &Scene) -> Result<Vec<Option<PackedMesh>>, PackError> {
    let mut used = vec![false; scene.meshes.len()];
    for instance in &scene.instances {
        used[instance.mesh] = true;
    }
    scene
        .meshes
        .par_iter()
        .zip(used)
        .map(|(mesh, used)| {
            if used {
                mesh::pack_mesh(mesh, &scene.materials)
            } else {
                Ok(None)
            }
        })
        .collect()
}

struct Geometry {
    nodes: Vec<[u32; 4]>,
    triangles: Vec<Triangle>,
    vertices: Vec<f32>,
    instances: Vec<Instance>,
    root: u32,
    bounds: Bounds,
}

/// Puts the meshes one after the other, behind the top-level hierarchy over their instances.
fn assemble(scene: &Scene, meshes: &mut [Option<PackedMesh>]) -> Result<Geometry, PackError> {
    let mut placed = Vec::new();
    let mut boxes = Vec::new();
    for instance in &scene.instances {
        let Some(mesh) = &meshes[instance.mesh] else {
            continue;
        };
        let world_from_object = DAffine3 {
            matrix3: instance.world_from_object.matrix3.as_dmat3(),
            translation: instance.world_from_object.translation.as_dvec3(),
        };
        let object_from_world = world_from_object.inverse();
        if !object_from_world.is_finite() {
            continue;
        }
        let bounds = transform_bounds(world_from_object, mesh.bounds);
        check_extent(bounds, || format!("node \"{}\"", instance.name))?;
        placed.push((instance, world_from_object, object_from_world));
        boxes.push(bounds);
    }
    let bounds = boxes.iter().fold(Bounds::EMPTY, |all, &one| all.union(one));
    let Some(top) = bvh::build(&boxes) else {
        return Ok(Geometry {
            nodes: Vec::new(),
            triangles: Vec::new(),
            vertices: Vec::new(),
            instances: Vec::new(),
            root: NONE,
            bounds,
        });
    };
    let mut nodes = top.nodes;
    let mut triangles = Vec::new();
    let mut vertices = Vec::new();
    let mut starts = vec![(NONE, NONE); meshes.len()];
    for (mesh, start) in meshes.iter_mut().zip(&mut starts) {
        let Some(mut mesh) = mesh.take() else {
            continue;
        };
        let first_node = index("nodes", nodes.len())? / bvh::NODE_WORDS as u32;
        let first_triangle = index("triangles", triangles.len())?;
        let first_word = index("vertex attributes", vertices.len())?;
        index("vertex attributes", vertices.len() + mesh.vertices.len())?;
        bvh::rebase(&mut mesh.hierarchy.nodes, first_node);
        for triangle in &mut mesh.triangles {
            triangle.vertex0 += first_word;
            triangle.vertex1 += first_word;
            triangle.vertex2 += first_word;
        }
        nodes.append(&mut mesh.hierarchy.nodes);
        triangles.append(&mut mesh.triangles);
        vertices.append(&mut mesh.vertices);
        *start = (first_node, first_triangle);
    }
    index("nodes", nodes.len())?;
    index("triangles", triangles.len())?;
    let instances = top
        .order
        .iter()
        .map(|&leaf| {
            let (instance, world_from_object, object_from_world) = placed[leaf as usize];
            let (root, first_triangle) = starts[instance.mesh];
            let flipped = world_from_object.matrix3.determinant() < 0.0;
            Instance {
                world_from_object: rows(world_from_object),
                object_from_world: rows(object_from_world),
                root,
                first_triangle,
                flags: if flipped { INSTANCE_FLIPPED } else { 0 },
                object: instance.node as u32,
            }
        })
        .collect();
    Ok(Geometry {
        nodes,
        triangles,
        vertices,
        instances,
        root: 0,
        bounds,
    })
}

fn rows(transform: DAffine3) -> [[f32; 4]; 3] {
    let columns = transform.matrix3.to_cols_array_2d();
    [0, 1, 2].map(|row| {
        [
            columns[0][row] as f32,
            columns[1][row] as f32,
            columns[2][row] as f32,
            transform.translation[row] as f32,
        ]
    })
}

/// A box around the transformed box, rounded outwards.
///
/// Arvo 1990, "Transforming Axis-Aligned Bounding Boxes": per axis the sum of the smaller and of the
/// larger products.
fn transform_bounds(transform: DAffine3, bounds: Bounds) -> Bounds {
    let center = 0.5 * (bounds.min.as_dvec3() + bounds.max.as_dvec3());
    let half = 0.5 * (bounds.max.as_dvec3() - bounds.min.as_dvec3());
    let reach: DVec3 = transform.matrix3.x_axis.abs() * half.x
        + transform.matrix3.y_axis.abs() * half.y
        + transform.matrix3.z_axis.abs() * half.z;
    let center = transform.transform_point3(center);
    let round =
        |v: DVec3, to: fn(f32) -> f32| Vec3A::new(to(v.x as f32), to(v.y as f32), to(v.z as f32));
    Bounds {
        min: round(center - reach, f32::next_down),
        max: round(center + reach, f32::next_up),
    }
}

/// The least distance by which a ray starts off a surface, for points whose own error along the
/// normal is zero: 2^-28 of the scene's diagonal, which single precision takes for nothing.
fn ray_offset_floor(bounds: Bounds) -> f32 {
    if bounds == Bounds::EMPTY {
        return 0.0;
    }
    (bounds.max - bounds.min).length() * 2.0_f32.powi(-28)
}
