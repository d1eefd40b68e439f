//! Meshes and where the nodes put them.

use super::accessor::{Accessors, Attribute};
use super::deform::Pose;
use super::error::GltfError;
use super::instancing;
use super::json::Json;
use super::mesh::{self, Meshes};
use super::node::{self, Nodes};
use super::notes::Notes;
use super::shutter::Tracks;
use super::stroke::Strokes;
use super::variant;
use crate::scene::{Instance, Mesh, Scene};
use glam::{Affine3A, DAffine3, DMat4, Vec3};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// What a mesh's vertices follow from: its number, the weights of its morph targets and its joints'
/// matrices, as bits, and what its primitives' materials ask of them.
type MeshKey = (usize, Option<Vec<u32>>, Option<Vec<u32>>, Vec<MaterialKey>);

/// A material's number, how many texture coordinates it reads, and what its tangents follow.
type MaterialKey = (usize, usize, Option<(usize, [u32; 6])>);

/// The meshes of a moment, to be used again in the next where nothing has moved them.
#[derive(Default)]
pub struct KnownMeshes(HashMap<MeshKey, KnownMesh>);

#[derive(Clone)]
struct KnownMesh {
    mesh: Arc<Mesh>,
    /// Its number in the scene.
    number: usize,
    /// How far its vertices are from its origin along the axes, at most.
    reach: Vec3,
    /// What it took of the memory ceiling, in bytes.
    bytes: u64,
}

/// Puts meshes into a scene.
pub struct Placer<'s, 'a, 'b> {
    pub nodes: &'s Nodes<'a>,
    pub accessors: Accessors<'b>,
    /// Where a primitive without a material finds one.
    pub default_material: usize,
    pub variant: Option<usize>,
    pub strokes: &'s Strokes,
    pub tracks: &'s Tracks,
    /// The nodes that are elsewhere at another moment of what plays.
    pub animated: &'s HashSet<usize>,
    pub notes: &'s mut Notes,
}

impl Placer<'_, '_, '_> {
    /// Reads each mesh once for each pose that it is shown in, and places it; gives the meshes to know
    /// at the next moment.
    pub fn place(
        &mut self,
        scene: &mut Scene,
        mut before: KnownMeshes,
    ) -> Result<KnownMeshes, GltfError> {
        let nodes = self.nodes;
        let mut known: HashMap<MeshKey, KnownMesh> = HashMap::new();
        for &node in nodes.shown.iter().filter(|&&node| nodes.visible[node]) {
            let json = &nodes.json[node];
            let Some((index, mesh)) = json.reference("mesh", "meshes")? else {
                continue;
            };
            let weights = json.numbers("weights")?;
            let joints = self.skin_joints(node)?;
            if self.tracks.morphed.contains(&node) {
                self.notes.add(DEFORMS, &json.at);
            }
            let key: MeshKey = (
                index,
                weights.as_ref().map(|weights| bits(weights)),
                joints.as_ref().map(|joints| {
                    let matrices = joints.iter();
                    matrices.flat_map(|m| bits(&m.to_cols_array())).collect()
                }),
                self.material_keys(&mesh, scene)?,
            );
            let found = match known.get(&key) {
                Some(known) => known.clone(),
                None => {
                    let pose = Pose {
                        weights,
                        joints: joints.as_deref(),
                    };
                    let found = self.mesh(scene, &mesh, &pose, before.0.remove(&key))?;
                    known.insert(key, found.clone());
                    found
                }
            };
            if !found.mesh.primitives.is_empty() {
                self.instances(scene, node, &found, joints.is_some())?;
            }
        }
        Ok(KnownMeshes(known))
    }

    /// A mesh in a pose as the scene's next one: the one that was known, or read anew.
    fn mesh(
        &mut self,
        scene: &mut Scene,
        json: &Json<'_>,
        pose: &Pose<'_>,
        before: Option<KnownMesh>,
    ) -> Result<KnownMesh, GltfError> {
        let number = scene.meshes.len();
        let budget = self.accessors.budget;
        let found = match before {
            Some(found) => {
                budget.take(found.bytes, json.file(), &json.at)?;
                KnownMesh { number, ..found }
            }
            None => {
                let used = budget.used();
                let mut meshes = Meshes {
                    accessors: self.accessors,
                    materials: &scene.materials,
                    default_material: self.default_material,
                    variant: self.variant,
                    strokes: self.strokes,
                    notes: self.notes,
                };
                let mesh = meshes.mesh(json, pose)?;
                KnownMesh {
                    number,
                    reach: reach(&mesh),
                    mesh: Arc::new(mesh),
                    bytes: budget.used() - used,
                }
            }
        };
        scene.meshes.push(Arc::clone(&found.mesh));
        Ok(found)
    }

    /// Places a mesh by a node, once or as often as EXT_mesh_gpu_instancing says.
    fn instances(
        &mut self,
        scene: &mut Scene,
        node: usize,
        mesh: &KnownMesh,
        skinned: bool,
    ) -> Result<(), GltfError> {
        let json = &self.nodes.json[node];
        let copies = instancing::copies(json, self.accessors, self.notes)?;
        // A skin moves the mesh to where the joints are: the node's own place does not count.
        let world_from_node = match skinned {
            true => DAffine3::IDENTITY,
            false => self.nodes.world(node),
        };
        if skinned && copies.is_some() {
            self.notes.add(
                "the copies of a skinned mesh are placed relative to its joints' world",
                &json.at,
            );
        }
        let count = copies.as_ref().map_or(1, |copies| copies.count);
        let budget = self.accessors.budget;
        budget.take(
            (count * size_of::<Instance>()) as u64,
            json.file(),
            &json.at,
        )?;
        scene.instances.reserve(count);
        let animated = self.is_animated(node)?;
        for copy in 0..count {
            let node_from_object = match &copies {
                Some(copies) => copies.node_from_object(copy),
                None => DAffine3::IDENTITY,
            };
            let world_from_object = node::to_f32(world_from_node * node_from_object);
            let motion = match skinned {
                true => Box::default(),
                false => self.tracks.motion(node, node_from_object, mesh.reach),
            };
            let mut keys = std::iter::once(&world_from_object).chain(&motion);
            if !keys.clone().all(|key| key.is_finite()) {
                return Err(json.invalid("its place in the world is not finite"));
            }
            keys.clone()
                .try_for_each(|key| check_extent(mesh.reach, key, json))?;
            if !keys.any(|key| key.inverse().is_finite()) {
                self.notes
                    .add("a mesh scaled to nothing is not drawn", &json.at);
                continue;
            }
            scene.instances.push(Instance {
                mesh: mesh.number,
                node,
                world_from_object,
                motion,
                animated,
            });
        }
        Ok(())
    }

    /// Whether the node, or a joint of its skin, is elsewhere at another moment.
    fn is_animated(&self, node: usize) -> Result<bool, GltfError> {
        if self.animated.contains(&node) {
            return Ok(true);
        }
        let Some((_, skin)) = self.nodes.json[node].reference("skin", "skins")? else {
            return Ok(false);
        };
        for joint in skin.elements("joints")? {
            if self.animated.contains(&joint.follow("nodes")?.0) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// What the materials of a mesh's primitives ask of its vertices.
    fn material_keys(&self, mesh: &Json<'_>, scene: &Scene) -> Result<Vec<MaterialKey>, GltfError> {
        let mut keys = Vec::new();
        for primitive in mesh.objects("primitives")? {
            let material = variant::material(&primitive, self.variant)?;
            let number = material.map_or(self.default_material, |(number, _)| number);
            let material = &scene.materials[number];
            let tangents = material.tangent_source().map(|(texcoord, [u, v])| {
                let numbers = [u.x, u.y, u.z, v.x, v.y, v.z];
                (texcoord, numbers.map(f32::to_bits))
            });
            keys.push((number, material.texcoord_count(), tangents));
        }
        Ok(keys)
    }

    /// World from bind pose for each joint of a node's skin (glTF 2.0 section 3.7.3).
    fn skin_joints(&mut self, node: usize) -> Result<Option<Vec<Affine3A>>, GltfError> {
        const MAT4: Attribute = Attribute::of(&["MAT4"]);
        let Some((_, skin)) = self.nodes.json[node].reference("skin", "skins")? else {
            return Ok(None);
        };
        let joints = skin.elements("joints")?;
        let inverse = self
            .accessors
            .floats::<16>(&skin, "inverseBindMatrices", &MAT4)?;
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
            let matrix = node::to_f32(self.nodes.world(joint_node) * bind);
            if !matrix.is_finite() {
                return Err(joint.invalid("the joint's place in the world is not finite"));
            }
            if self.tracks.moves(joint_node) {
                self.notes.add(DEFORMS, &self.nodes.json[node].at);
            }
            matrices.push(matrix);
        }
        Ok(Some(matrices))
    }
}

const DEFORMS: &str = "what deforms is not blurred: it is drawn as it is when the shutter opens";

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// How far a mesh's vertices are from its origin along the axes, at most.
fn reach(mesh: &Mesh) -> Vec3 {
    let primitives = mesh.primitives.iter();
    let points = primitives.flat_map(|primitive| &primitive.positions);
    points.fold(Vec3::ZERO, |far, p| far.max(p.abs()))
}

/// The corners of an instance's box must stay where 32-bit numbers can work.
fn check_extent(far: Vec3, world_from_object: &Affine3A, node: &Json<'_>) -> Result<(), GltfError> {
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
