//! Meshes and their instances to two levels of hierarchies and the arrays that these address; what stands
//! still is one of the meshes (`bake`).

use super::bake::{self, KnownBake};
use super::mesh::{self, PackedMesh};
use super::vertex;
use super::{PackError, check_depth, check_extent, index};
use crate::bvh::{self, Bounds};
use crate::scene::{self, Mesh, Scene};
use crate::shared::{
    INSTANCE_FLIPPED, INSTANCE_KEYS_MASK, INSTANCE_KEYS_SHIFT, Instance, NONE, Triangle,
};
use glam::{Affine3A, DAffine3, DVec3, Vec3A};
use rayon::prelude::*;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, Weak};

/// What rays meet, as in `Packed`.
#[derive(Clone, Debug)]
pub struct Geometry {
    pub nodes: Vec<[u32; 4]>,
    pub triangles: Vec<Triangle>,
    pub vertices: Vec<u32>,
    pub instances: Vec<Instance>,
    /// The triangles of each placed instance; `instances` has the further keys of those that move as well.
    pub ranges: Vec<Range<u32>>,
    /// `NONE`: there is nothing to hit.
    pub root: u32,
    /// Of the one mesh that there is, if it stands in the world as it is; else 0, which is the top level's.
    pub mesh_root: u32,
    /// Of all instances, in world space.
    pub bounds: Bounds,
}

impl Geometry {
    const NOTHING: Self = Self {
        nodes: Vec::new(),
        triangles: Vec::new(),
        vertices: Vec::new(),
        instances: Vec::new(),
        ranges: Vec::new(),
        root: NONE,
        mesh_root: 0,
        bounds: Bounds::EMPTY,
    };
}

/// A mesh by its address, and the layouts of its primitives' vertices as far as they follow from materials.
type MeshKey = (usize, Vec<u32>);

/// Meshes that were packed before. An address is not given to another mesh while a `Weak` is left.
#[derive(Default)]
pub struct KnownMeshes {
    packed: HashMap<MeshKey, (Weak<Mesh>, Option<Arc<PackedMesh>>)>,
    pub baked: Option<KnownBake>,
    /// How many of them the last scene brought.
    pub new: usize,
}

/// Packs the meshes in parallel, then puts them one after the other behind the top-level hierarchy
/// over their instances; the instances of the numbers `baked` become one mesh, if they can (`bake::choose`). What is `known` is not packed again, and becomes what this scene needs.
pub fn pack_geometry(
    scene: &Scene,
    baked: &[usize],
    mut known: Option<&mut KnownMeshes>,
) -> Result<Geometry, PackError> {
    if let Some(known) = &mut known {
        known.new = 0;
    }
    let mut apart = vec![true; scene.instances.len()];
    let chosen = baked;
    let baked = bake::pack_baked(scene, chosen, known.as_deref_mut());
    if baked.is_some() {
        chosen.iter().for_each(|&number| apart[number] = false);
    }
    let instances: Vec<&scene::Instance> = scene
        .instances
        .iter()
        .zip(apart)
        .filter_map(|(instance, apart)| apart.then_some(instance))
        .collect();
    let mut meshes = pack_meshes(scene, &instances, known)?;
    let still = scene::Instance {
        mesh: meshes.len(),
        node: 0,
        world_from_object: Affine3A::IDENTITY,
        motion: Box::default(),
        animated: false,
    };
    let mut placed = Vec::new();
    let mut boxes = Vec::new();
    if let Some(baked) = baked {
        boxes.push(baked.bounds);
        placed.push(&still);
        meshes.push(Some(baked));
    }
    for instance in instances {
        let Some(mesh) = &meshes[instance.mesh] else {
            continue;
        };
        if instance.motion.len() > INSTANCE_KEYS_MASK as usize {
            return Err(PackError::TooManyKeys {
                node: instance.node,
                keys: instance.motion.len(),
            });
        }
        if !is_placed(instance) {
            continue;
        }
        // Between keys a point goes straight from one to the next, so it stays in the box of both.
        let bounds = keys(instance)
            .map(|key| transform_bounds(key, mesh.bounds))
            .fold(Bounds::EMPTY, Bounds::union);
        check_extent(bounds, || format!("the mesh of nodes[{}]", instance.node))?;
        placed.push(instance);
        boxes.push(bounds);
    }
    let top = check_depth(bvh::build(&boxes), || "the nodes".to_owned())?;
    let Some(top) = top else {
        return Ok(Geometry::NOTHING);
    };
    let mut geometry = Geometry {
        nodes: top.nodes,
        root: 0,
        bounds: boxes.iter().fold(Bounds::EMPTY, |all, &one| all.union(one)),
        ..Geometry::NOTHING
    };
    let starts = meshes
        .iter_mut()
        .map(|mesh| match mesh.take() {
            Some(mesh) => geometry.append(&mesh).map(Some),
            None => Ok(None),
        })
        .collect::<Result<Vec<_>, _>>()?;
    let count = index("instances", placed.len())? as usize;
    let mut further = Vec::new();
    geometry.instances.reserve_exact(count);
    geometry.ranges.reserve_exact(count);
    for &leaf in &top.order {
        let instance = placed[leaf as usize];
        let (root, range) = starts[instance.mesh]
            .clone()
            .expect("a placed instance's mesh was packed");
        let entry = |world_from_object: DAffine3, flags: u32, motion: u32| {
            let flipped = world_from_object.matrix3.determinant() < 0.0;
            Instance {
                world_from_object: rows(world_from_object),
                root,
                first_triangle: range.start,
                flags: flags | if flipped { INSTANCE_FLIPPED } else { 0 },
                motion,
            }
        };
        let first = index("instances", count + further.len() + instance.motion.len())?
            - instance.motion.len() as u32;
        let mut keys = keys(instance);
        let flags = (instance.motion.len() as u32) << INSTANCE_KEYS_SHIFT;
        geometry
            .instances
            .extend(keys.next().map(|key| entry(key, flags, first)));
        further.extend(keys.map(|key| entry(key, 0, 0)));
        geometry.ranges.push(range);
    }
    geometry.instances.append(&mut further);
    if let ([one], [instance]) = (&*placed, &*geometry.instances)
        && bake::is_identity(one)
    {
        geometry.mesh_root = instance.root;
    }
    Ok(geometry)
}

/// Whether there is a surface to hit: what moves is there at some time if it is there at one of its keys.
pub fn is_placed(instance: &scene::Instance) -> bool {
    keys(instance).any(is_invertible)
}

/// Where an instance is when the shutter opens and at its further keys.
fn keys(instance: &scene::Instance) -> impl Iterator<Item = DAffine3> + '_ {
    let all = std::iter::once(&instance.world_from_object).chain(&instance.motion);
    all.map(to_f64)
}

pub fn to_f64(transform: &Affine3A) -> DAffine3 {
    DAffine3 {
        matrix3: transform.matrix3.as_dmat3(),
        translation: transform.translation.as_dvec3(),
    }
}

impl Geometry {
    /// Where a placed instance is later than when the shutter opens.
    pub fn further_keys(&self, instance: &Instance) -> &[Instance] {
        let first = instance.motion as usize;
        let keys = (instance.flags >> INSTANCE_KEYS_SHIFT) & INSTANCE_KEYS_MASK;
        &self.instances[first..first + keys as usize]
    }

    /// Copies a mesh to the end of the arrays; gives its root and its triangles.
    fn append(&mut self, mesh: &PackedMesh) -> Result<(u32, Range<u32>), PackError> {
        let root = index("nodes", self.nodes.len() + mesh.hierarchy.nodes.len())?;
        let root = (root - mesh.hierarchy.nodes.len() as u32) / bvh::NODE_WORDS as u32;
        let first_word = index("vertex attributes", self.vertices.len())?;
        index(
            "vertex attributes",
            self.vertices.len() + mesh.vertices.len(),
        )?;
        let end = index("triangles", self.triangles.len() + mesh.triangles.len())?;
        let range = end - mesh.triangles.len() as u32..end;
        let first_node = self.nodes.len();
        self.nodes.extend(&mesh.hierarchy.nodes);
        bvh::rebase(&mut self.nodes[first_node..], root);
        let triangles = mesh.triangles.iter().map(|triangle| Triangle {
            vertex0: triangle.vertex0 + first_word,
            vertex1: triangle.vertex1 + first_word,
            vertex2: triangle.vertex2 + first_word,
            ..*triangle
        });
        self.triangles.extend(triangles);
        self.vertices.extend(&mesh.vertices);
        Ok((root, range))
    }
}

/// Packs the meshes that `instances` place, by the scene's numbers; others stay `None`.
fn pack_meshes(
    scene: &Scene,
    instances: &[&scene::Instance],
    known: Option<&mut KnownMeshes>,
) -> Result<Vec<Option<Arc<PackedMesh>>>, PackError> {
    let mut used = vec![false; scene.meshes.len()];
    for instance in instances {
        used[instance.mesh] = true;
    }
    let key = |mesh: &Arc<Mesh>| (Arc::as_ptr(mesh).addr(), vertex::layouts(mesh, scene));
    let nothing = HashMap::new();
    let before = known.as_ref().map_or(&nothing, |known| &known.packed);
    let found: Vec<Option<&Option<Arc<PackedMesh>>>> = scene
        .meshes
        .iter()
        .map(|mesh| before.get(&key(mesh)).map(|(_, packed)| packed))
        .collect();
    let new = found
        .iter()
        .zip(&used)
        .filter(|(found, used)| **used && found.is_none())
        .count();
    let meshes = scene
        .meshes
        .par_iter()
        .zip(&used)
        .zip(found)
        .map(|((mesh, used), found)| match (used, found) {
            (false, _) => Ok(None),
            (true, Some(packed)) => Ok(packed.clone()),
            (true, None) => Ok(mesh::pack_mesh(mesh, scene)?.map(Arc::new)),
        })
        .collect::<Result<Vec<_>, _>>()?;
    if let Some(known) = known {
        known.new += new;
        let rows = scene.meshes.iter().zip(&meshes).zip(used);
        known.packed = rows
            .filter(|(_, used)| *used)
            .map(|((mesh, packed), _)| (key(mesh), (Arc::downgrade(mesh), packed.clone())))
            .collect();
    }
    Ok(meshes)
}

/// Whether a ray's way into the object's space, made in single precision, means anything: the columns
/// are in float32's range, and their determinant is more than what rounding leaves of zero.
pub fn is_invertible(transform: DAffine3) -> bool {
    let [x, y, z] = transform.matrix3.to_cols_array_2d().map(DVec3::from);
    let lengths = x.length() * y.length() * z.length();
    let in_range =
        |column: DVec3| (SCALE_RANGE.0..=SCALE_RANGE.1).contains(&column.abs().max_element());
    transform.is_finite()
        && [x, y, z].into_iter().all(in_range)
        && x.dot(y.cross(z)).abs() > DETERMINANT_ROUNDING * lengths
}

/// Scales whose reciprocals are normal float32 with room to spare.
const SCALE_RANGE: (f64, f64) = (1e-30, 1e30);

/// Of a determinant in float32, as part of the product of the columns' lengths: 2^-22, four units.
const DETERMINANT_ROUNDING: f64 = 2.384_185_791_015_625e-7;

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
pub fn transform_bounds(transform: DAffine3, bounds: Bounds) -> Bounds {
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
