//! The node hierarchy: where everything stands in the world.

use super::error::GltfError;
use super::json::Json;
use super::notes::Notes;
use glam::{Affine3A, DAffine3, DMat4, DQuat, DVec3};

/// All nodes of a file with their place in the world.
pub struct Nodes<'a> {
    pub json: Vec<Json<'a>>,
    world: Vec<DAffine3>,
    parent: Vec<Option<usize>>,
    /// All, parents before children.
    order: Vec<usize>,
    /// KHR_node_visibility, ancestors' included: it hides meshes and lights, not cameras.
    pub visible: Vec<bool>,
    /// Those of the scene, parents before children.
    pub shown: Vec<usize>,
}

impl<'a> Nodes<'a> {
    pub fn read(root: &Json<'a>, notes: &mut Notes) -> Result<Self, GltfError> {
        let json = root.objects("nodes")?;
        let mut children = Vec::with_capacity(json.len());
        let mut parent = vec![None; json.len()];
        for (index, node) in json.iter().enumerate() {
            let mut list = Vec::new();
            for child in node.elements("children")? {
                let (target, _) = child.follow("nodes")?;
                if let Some(first) = parent[target].replace(index) {
                    return Err(child.invalid(format!(
                        "node {target} is a child of both nodes[{first}] and nodes[{index}]"
                    )));
                }
                list.push(target);
            }
            children.push(list);
        }
        // Every node has at most one parent now, so what no root leads to is on or behind a cycle.
        let roots: Vec<usize> = (0..json.len())
            .filter(|&node| parent[node].is_none())
            .collect();
        let order = descend(&roots, &children);
        if order.len() < json.len() {
            let mut reached = vec![false; json.len()];
            order.iter().for_each(|&node| reached[node] = true);
            let lost = reached
                .iter()
                .position(|&reached| !reached)
                .unwrap_or_default();
            return Err(json[lost].invalid("it is its own ancestor: the hierarchy has a cycle"));
        }
        let mut world = vec![DAffine3::IDENTITY; json.len()];
        for &node in &order {
            let local = local(&json[node], notes)?;
            world[node] = parent[node].map_or(local, |parent: usize| world[parent] * local);
        }
        let mut visible = vec![true; json.len()];
        for &node in &order {
            let own = match json[node].extension("KHR_node_visibility")? {
                Some(extension) => extension.boolean("visible")?.unwrap_or(true),
                None => true,
            };
            visible[node] = own && parent[node].is_none_or(|parent| visible[parent]);
        }
        let shown = match scene(root)? {
            Some(scene) => {
                let mut tops = Vec::new();
                for top in scene.elements("nodes")? {
                    tops.push(top.follow("nodes")?.0);
                }
                descend(&tops, &children)
            }
            None => order.clone(),
        };
        Ok(Self {
            json,
            world,
            parent,
            order,
            visible,
            shown,
        })
    }

    /// Some nodes and all below them.
    pub fn below(&self, tops: impl IntoIterator<Item = usize>) -> Vec<usize> {
        let mut found = vec![false; self.json.len()];
        for top in tops {
            found[top] = true;
        }
        for &node in &self.order {
            found[node] |= self.parent[node].is_some_and(|parent| found[parent]);
        }
        (0..found.len()).filter(|&node| found[node]).collect()
    }

    pub fn world(&self, node: usize) -> DAffine3 {
        self.world[node]
    }

    /// The node's matrix for the renderer, which must be finite.
    pub fn world_f32(&self, node: usize) -> Result<Affine3A, GltfError> {
        let matrix = to_f32(self.world[node]);
        if matrix.is_finite() {
            Ok(matrix)
        } else {
            Err(self.json[node].invalid("its place in the world is not finite"))
        }
    }
}

pub fn to_f32(matrix: DAffine3) -> Affine3A {
    Affine3A::from_cols_array(&matrix.to_cols_array().map(|value| value as f32))
}

/// The scene to draw: the default one, else the first, else none (then all nodes are drawn).
pub fn scene<'a>(root: &Json<'a>) -> Result<Option<Json<'a>>, GltfError> {
    if let Some((_, scene)) = root.reference("scene", "scenes")? {
        return Ok(Some(scene));
    }
    Ok(root.objects("scenes")?.into_iter().next())
}

/// Depth first, without recursion; each node once.
fn descend(tops: &[usize], children: &[Vec<usize>]) -> Vec<usize> {
    let mut order = Vec::new();
    let mut seen = vec![false; children.len()];
    let mut stack: Vec<usize> = tops.iter().rev().copied().collect();
    while let Some(node) = stack.pop() {
        if !std::mem::replace(&mut seen[node], true) {
            order.push(node);
            stack.extend(children[node].iter().rev());
        }
    }
    order
}

/// glTF 2.0 section 3.5.3: a matrix, or translation * rotation * scale.
fn local(node: &Json<'_>, notes: &mut Notes) -> Result<DAffine3, GltfError> {
    if let Some(matrix) = node.vector::<16>("matrix")? {
        let matrix = DMat4::from_cols_array(&matrix.map(f64::from));
        let affine = DAffine3::from_mat4(matrix);
        if matrix.row(3).to_array() != [0.0, 0.0, 0.0, 1.0] {
            notes.add(
                "a node's matrix is taken as affine, without its last row",
                &node.at,
            );
        }
        return Ok(affine);
    }
    let vector = |key, default: f64| -> Result<DVec3, GltfError> {
        let values = node.vector::<3>(key)?;
        Ok(values.map_or(DVec3::splat(default), |values| {
            DVec3::from(values.map(f64::from))
        }))
    };
    let rotation = match node.vector::<4>("rotation")? {
        None => DQuat::IDENTITY,
        Some(values) => {
            let rotation = DQuat::from_array(values.map(f64::from));
            if rotation.length() > 0.0 {
                rotation.normalize()
            } else {
                notes.add("a rotation of length zero is taken as none", &node.at);
                DQuat::IDENTITY
            }
        }
    };
    Ok(DAffine3::from_scale_rotation_translation(
        vector("scale", 1.0)?,
        rotation,
        vector("translation", 0.0)?,
    ))
}

/// The rotation of a node without its scale, for cameras and lights, which have none: -z of the
/// node stays, then as much of y as is perpendicular to it.
pub fn rigid(world: DAffine3) -> DAffine3 {
    let back = world.transform_vector3(DVec3::Z).normalize_or(DVec3::Z);
    let up = world.transform_vector3(DVec3::Y);
    let up = (up - back * up.dot(back)).normalize_or(back.any_orthonormal_vector());
    DAffine3 {
        matrix3: glam::DMat3::from_cols(up.cross(back), up, back),
        translation: world.translation,
    }
}
