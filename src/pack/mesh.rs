//! A mesh to triangles in the order of its hierarchy's leaves, and to words of vertex attributes.

use super::PackError;
use super::vertex::Layout;
use crate::bvh::{self, Bounds, Hierarchy};
use crate::scene::{Mesh, Scene};
use crate::shared::Triangle;
use glam::{Vec3, Vec3A};

/// Coordinates whose boxes' areas are still finite numbers, with room for the sums of the build.
pub const MAX_COORDINATE: f32 = 1e15;

/// One mesh by itself: node indices, leaf positions and vertex words count from its own first.
#[derive(Clone, Debug)]
pub struct PackedMesh {
    pub hierarchy: Hierarchy,
    pub triangles: Vec<Triangle>,
    pub vertices: Vec<u32>,
    pub bounds: Bounds,
}

/// `mesh` need not be one of the scene's, whose materials it has. `None` for a mesh without triangles.
pub fn pack_mesh(mesh: &Mesh, scene: &Scene) -> Result<Option<PackedMesh>, PackError> {
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    let mut boxes = Vec::new();
    for (number, primitive) in mesh.primitives.iter().enumerate() {
        let layout = Layout::of(primitive, scene);
        let first_word = super::index("vertex attributes", vertices.len())?;
        layout.write(primitive, &mut vertices);
        super::index("vertex attributes", vertices.len())?;
        for &corners in &primitive.triangles {
            let corners = widest_first(corners, &primitive.positions);
            let [p0, p1, p2] = corners.map(|corner| primitive.positions[corner as usize]);
            let vertex = corners.map(|corner| first_word + corner * layout.words() as u32);
            triangles.push(Triangle {
                p0: p0.to_array(),
                vertex0: vertex[0],
                e1: (p1 - p0).to_array(),
                vertex1: vertex[1],
                e2: (p2 - p0).to_array(),
                flags: 0, // known with the packed material
                vertex2: vertex[2],
                material: primitive.material as u32,
                vertex_layout: layout.flags(),
                primitive: number as u32,
            });
            boxes.push(Bounds::of_points([p0, p1, p2].map(Vec3A::from)));
        }
    }
    let bounds = boxes.iter().fold(Bounds::EMPTY, |all, &one| all.union(one));
    let name = || format!("mesh \"{}\"", mesh.name);
    super::check_extent(bounds, name)?;
    let hierarchy = super::check_depth(bvh::build(&boxes), name)?;
    Ok(hierarchy.map(|hierarchy| PackedMesh {
        triangles: hierarchy
            .order
            .iter()
            .map(|&index| triangles[index as usize])
            .collect(),
        hierarchy,
        vertices,
        bounds,
    }))
}

/// The corners in the same sense of rotation from the one at the widest angle: products of the two edges
/// there are rounded least against their area, which for slivers is a thousand times less.
fn widest_first([a, b, c]: [u32; 3], positions: &[Vec3]) -> [u32; 3] {
    let [p0, p1, p2] = [a, b, c].map(|corner| positions[corner as usize]);
    let opposite = [p1.distance(p2), p2.distance(p0), p0.distance(p1)];
    if opposite[0] >= opposite[1] && opposite[0] >= opposite[2] {
        [a, b, c]
    } else if opposite[1] >= opposite[2] {
        [b, c, a]
    } else {
        [c, a, b]
    }
}
