//! Morph targets and skins.

use super::accessor::{Accessors, Attribute};
use super::error::GltfError;
use super::json::Json;
use super::mesh::Vertices;
use super::notes::Notes;
use glam::{Affine3A, Mat3, Mat4, Vec2, Vec3, Vec4, Vec4Swizzles as _};

/// What moves a mesh's vertices.
#[derive(Default)]
pub struct Pose<'p> {
    /// Of the morph targets; the node's where it has some, else the mesh's.
    pub weights: Option<Vec<f32>>,
    /// World from bind pose, for each joint of the skin.
    pub joints: Option<&'p [Affine3A]>,
}

/// glTF 2.0 section 3.7.2.2: displacements, weighted and added.
pub fn morph(
    vertices: &mut Vertices,
    primitive: &Json<'_>,
    pose: &Pose<'_>,
    accessors: Accessors<'_>,
    notes: &mut Notes,
) -> Result<(), GltfError> {
    const VEC3: Attribute = Attribute::of(&["VEC3"]);
    const VEC2: Attribute = Attribute {
        normalized: true,
        ..Attribute::of(&["VEC2"])
    };
    const COLOR: Attribute = Attribute {
        normalized: true,
        ..Attribute::of(&["VEC3", "VEC4"])
    };
    let weights = pose.weights.as_deref().unwrap_or_default();
    let count = vertices.positions.len();
    for (target, &weight) in primitive.objects("targets")?.iter().zip(weights) {
        if weight == 0.0 {
            continue;
        }
        let mut read = Deltas {
            target,
            accessors,
            count,
            notes,
        };
        for (position, delta) in vertices
            .positions
            .iter_mut()
            .zip(read.deltas("POSITION", &VEC3)?)
        {
            *position += weight * Vec3::from(delta);
        }
        let normals = vertices.normals.iter_mut().flatten();
        for (normal, delta) in normals.zip(read.deltas("NORMAL", &VEC3)?) {
            *normal += weight * Vec3::from(delta);
        }
        let tangents = vertices.tangents.iter_mut().flatten();
        for (tangent, delta) in tangents.zip(read.deltas("TANGENT", &VEC3)?) {
            *tangent += (weight * Vec3::from(delta)).extend(0.0);
        }
        for (set, texcoords) in vertices.texcoords.iter_mut().enumerate() {
            let deltas = read.deltas(&format!("TEXCOORD_{set}"), &VEC2)?;
            for (texcoord, delta) in texcoords.iter_mut().zip(deltas) {
                *texcoord += weight * Vec2::from(delta);
            }
        }
        let colors = vertices.colors.iter_mut().flatten();
        for (color, delta) in colors.zip(read.deltas("COLOR_0", &COLOR)?) {
            *color += weight * Vec4::from(delta);
        }
    }
    // Only the sum is a colour.
    for color in vertices.colors.iter_mut().flatten() {
        *color = color.clamp(Vec4::ZERO, Vec4::ONE);
    }
    Ok(())
}

/// Reads what a morph target adds to the attributes of a primitive.
struct Deltas<'s, 'a, 'b> {
    target: &'s Json<'a>,
    accessors: Accessors<'b>,
    /// Vertices of the primitive.
    count: usize,
    notes: &'s mut Notes,
}

impl Deltas<'_, '_, '_> {
    /// None where the target leaves the attribute alone.
    fn deltas<const N: usize>(
        &mut self,
        key: &str,
        attribute: &Attribute,
    ) -> Result<Vec<[f32; N]>, GltfError> {
        let (target, count) = (self.target, self.count);
        let values = self.accessors.floats::<N>(target, key, attribute)?;
        let mut values = values.unwrap_or_default();
        if !values.is_empty() && values.len() != count {
            return Err(target.invalid(format!(
                "{key} has {} elements and the primitive has {count}",
                values.len()
            )));
        }
        let bad = |delta: &[f32; N]| !delta.iter().all(|value| value.is_finite());
        if let Some(vertex) = values.iter().position(bad) {
            if key == "POSITION" {
                return Err(target.invalid(format!("{key} of vertex {vertex} is not finite")));
            }
            let note = "displacements that are not finite are taken as zero";
            self.notes.add(note, &target.at);
            for delta in values.iter_mut().filter(|delta| bad(delta)) {
                *delta = [0.0; N];
            }
        }
        Ok(values)
    }
}

/// Section 3.7.3.3: each vertex moves with the weighted mean of its joints.
pub fn skin(
    vertices: &mut Vertices,
    attributes: &Json<'_>,
    pose: &Pose<'_>,
    accessors: Accessors<'_>,
    notes: &mut Notes,
) -> Result<(), GltfError> {
    const VEC4: Attribute = Attribute {
        types: &["VEC4"],
        fill: 0.0,
        normalized: true,
    };
    // A vertex has more than eight joints in no file in use.
    const MAX_SETS: usize = 4;
    let Some(joints) = pose.joints else {
        return Ok(());
    };
    let count = vertices.positions.len();
    let mut matrices = vec![Mat4::ZERO; count];
    let mut totals = vec![0.0f32; count];
    for set in 0..MAX_SETS {
        let (joint_key, weight_key) = (format!("JOINTS_{set}"), format!("WEIGHTS_{set}"));
        let indices = accessors.integers::<4>(attributes, &joint_key, &["VEC4"])?;
        let weights = accessors.floats::<4>(attributes, &weight_key, &VEC4)?;
        let (indices, weights) = match (indices, weights) {
            (Some(indices), Some(weights)) => (indices, weights),
            (None, None) => break,
            _ => {
                return Err(attributes.invalid(format!(
                    "{joint_key} and {weight_key} belong together and one is missing"
                )));
            }
        };
        if indices.len() != count || weights.len() != count {
            return Err(attributes.invalid(format!(
                "{joint_key} has {} and {weight_key} {} elements, POSITION has {count}",
                indices.len(),
                weights.len()
            )));
        }
        let rows = indices
            .iter()
            .zip(&weights)
            .zip(&mut matrices)
            .zip(&mut totals);
        for (((indices, weights), matrix), total) in rows {
            for (&joint, &weight) in indices.iter().zip(weights) {
                if !weight.is_finite() || weight <= 0.0 {
                    continue;
                }
                let Some(joint_matrix) = joints.get(joint as usize) else {
                    return Err(attributes.invalid(format!(
                        "{joint_key} names joint {joint} and the skin has {}",
                        joints.len()
                    )));
                };
                *matrix += Mat4::from(*joint_matrix) * weight;
                *total += weight;
            }
        }
    }
    if totals.contains(&0.0) {
        notes.add(
            "vertices that no joint moves follow the first joint",
            &attributes.at,
        );
    }
    let first = joints
        .first()
        .map_or(Mat4::IDENTITY, |joint| Mat4::from(*joint));
    for (index, (matrix, total)) in matrices.iter().zip(totals).enumerate() {
        let matrix = if total > 0.0 {
            *matrix * total.recip()
        } else {
            first
        };
        vertices.positions[index] = matrix.transform_point3(vertices.positions[index]);
        let linear = Mat3::from_mat4(matrix);
        if let Some(normals) = &mut vertices.normals {
            normals[index] = cofactor(linear) * normals[index];
        }
        if let Some(tangents) = &mut vertices.tangents {
            let tangent = linear * tangents[index].xyz();
            tangents[index] = tangent.extend(tangents[index].w);
        }
    }
    Ok(())
}

/// What moves normals: the inverse transpose times the determinant, which exists for any matrix.
fn cofactor(m: Mat3) -> Mat3 {
    let sign = m.determinant().signum();
    Mat3::from_cols(
        sign * m.y_axis.cross(m.z_axis),
        sign * m.z_axis.cross(m.x_axis),
        sign * m.x_axis.cross(m.y_axis),
    )
}
