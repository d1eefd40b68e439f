//! Meshes and where the nodes put them.

use super::accessor::{Accessors, Attribute};
use super::deform::Pose;
use super::error::GltfError;
use super::json::Json;
use super::mesh::{self, Meshes};
use super::node::{self, Nodes};
use super::notes::Notes;
use crate::scene::{Instance, Mesh, Scene};
use glam::{Affine3A, DAffine3, DMat4, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

/// What a mesh's vertices follow from: its number, the weights of its morph targets and its joints'
/// matrices, as bits.
type MeshKey = (usize, Option<Vec<u32>>, Option<Vec<u32>>);

/// The meshes of a moment, to be used again in the next where nothing has moved them.
#[derive(Default)]
pub struct KnownMeshes(HashMap<MeshKey, KnownMesh>);

#[derive(Clone)]
struct KnownMesh {
    mesh: Arc<Mesh>,
    /// Its number in the scene.
    number: usize,
    /// What it took of the memory ceiling, in bytes.
    bytes: u64,
}

/// Reads each mesh once for each pose that it is shown in, and places it; gives the meshes to know at
/// the next moment.
pub fn place_meshes(
    scene: &mut Scene,
    nodes: &Nodes<'_>,
    accessors: Accessors<'_>,
    default_material: usize,
    mut before: KnownMeshes,
    notes: &mut Notes,
) -> Result<KnownMeshes, GltfError> {
    let mut known: HashMap<MeshKey, KnownMesh> = HashMap::new();
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
        let key: MeshKey = (
            index,
            weights.as_ref().map(|weights| bits(weights)),
            joints.as_ref().map(|joints| {
                joints
                    .iter()
                    .flat_map(|m| bits(&m.to_cols_array()))
                    .collect()
            }),
        );
        let number = match known.get(&key) {
            Some(known) => known.number,
            None => {
                let number = scene.meshes.len();
                let budget = accessors.budget;
                let found = match before.0.remove(&key) {
                    Some(found) => {
                        budget.take(found.bytes, mesh.file(), &mesh.at)?;
                        KnownMesh { number, ..found }
                    }
                    None => {
                        let used = budget.used();
                        let mut meshes = Meshes {
                            accessors,
                            materials: &scene.materials,
                            default_material,
                            notes,
                        };
                        let pose = Pose {
                            weights,
                            joints: joints.as_deref(),
                        };
                        KnownMesh {
                            mesh: Arc::new(meshes.mesh(&mesh, &pose)?),
                            number,
                            bytes: budget.used() - used,
                        }
                    }
                };
                scene.meshes.push(Arc::clone(&found.mesh));
                known.insert(key, found);
                number
            }
        };
        if scene.meshes[number].primitives.is_empty() {
            continue;
        }
        check_extent(&scene.meshes[number], world_from_object, json)?;
        if !world_from_object.inverse().is_finite() {
            notes.add("a mesh scaled to nothing is not drawn", &json.at);
            continue;
        }
        scene.instances.push(Instance {
            mesh: number,
            node,
            world_from_object,
            motion: Box::default(),
        });
    }
    Ok(KnownMeshes(known))
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// World from bind pose for each joint of a node's skin (glTF 2.0 section 3.7.3).
fn skin_joints(
    nodes: &Nodes<'_>,
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
    mesh: &Mesh,
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
