//! The points of a Draco mesh in the order that other attributes of the primitive count on.

use draco_oxide_core::mesh::Mesh;
use draco_oxide_core::mesh::ds::GenericCornerTable as _;
use draco_oxide_core::types::CornerIdx;
use draco_oxide_decoder::connectivity::EdgebreakerConnectivity;

const NONE: u32 = u32::MAX;

/// Triangles, and for each point the decoder's point with its values.
///
/// glTF's accessors count as Draco's own decoder does (Google's, `MeshEdgebreakerDecoderImpl`):
/// vertex by vertex, around each one clockwise, a new point where the values of an attribute change.
/// The decoder here counts along its traversal, and makes a point of its own at both sides of a
/// seam that ends at the vertex.
pub fn assign(
    mesh: &Mesh,
    connectivity: Option<&EdgebreakerConnectivity>,
) -> Result<(Vec<[u32; 3]>, Vec<u32>), String> {
    let found = mesh.attributes.first().map_or(0, |first| first.len());
    let count = u32::try_from(found).map_err(|_| "it holds too many points")?;
    if mesh.attributes.iter().any(|other| other.len() != found) {
        return Err("its attributes have different numbers of points".to_owned());
    }
    let mut corners = Vec::with_capacity(3 * mesh.faces.len());
    for &corner in mesh.faces.as_flattened() {
        match usize::from(corner) {
            index if index < found => corners.push(index as u32),
            index => return Err(format!("index {index} is out of range: {found} points")),
        }
    }
    let points = match connectivity {
        Some(connectivity) if connectivity.num_attribute_data > 0 => {
            around_vertices(mesh, connectivity, &mut corners)?
        }
        Some(connectivity) => (0..count.min(connectivity.num_vertices as u32)).collect(),
        None => (0..count).collect(),
    };
    let triangles = corners.chunks_exact(3);
    Ok((triangles.map(|t| [t[0], t[1], t[2]]).collect(), points))
}

/// Renumbers the points of all corners.
fn around_vertices(
    mesh: &Mesh,
    connectivity: &EdgebreakerConnectivity,
    corners: &mut [u32],
) -> Result<Vec<u32>, String> {
    let value = |corner: CornerIdx, attribute: usize| {
        let point = corners[usize::from(corner)] as usize;
        mesh.attributes[attribute].get_unique_val_idx(point.into())
    };
    let same = |a: CornerIdx, b: CornerIdx| {
        (0..mesh.attributes.len()).all(|attribute| value(a, attribute) == value(b, attribute))
    };
    let right = |corner| connectivity.corner_table.swing_right(corner);
    let mut numbers = vec![NONE; corners.len()];
    let mut points = Vec::new();
    for (vertex, &leftmost) in connectivity.vertex_corners.iter().enumerate() {
        if leftmost == CornerIdx::INVALID {
            continue;
        }
        let mut first = leftmost;
        let open = connectivity.is_vert_hole.get(vertex).copied();
        if open != Some(true) {
            // A closed fan is entered at a seam, of the first attribute that has one.
            let seam = (0..mesh.attributes.len()).find_map(|attribute| {
                let turn = std::iter::successors(right(leftmost), |&c| right(c));
                let mut turn = turn.take_while(|&c| c != leftmost);
                turn.find(|&c| value(c, attribute) != value(leftmost, attribute))
            });
            first = seam.unwrap_or(leftmost);
        }
        let mut previous = None;
        let mut corner = first;
        loop {
            let number = match previous {
                Some(previous) if same(previous, corner) => numbers[usize::from(previous)],
                _ => {
                    points.push(corners[usize::from(corner)]);
                    points.len() as u32 - 1
                }
            };
            numbers[usize::from(corner)] = number;
            previous = Some(corner);
            match right(corner) {
                Some(next) if next != first => corner = next,
                _ => break,
            }
        }
    }
    if numbers.contains(&NONE) {
        return Err("a corner belongs to no vertex".to_owned());
    }
    corners.copy_from_slice(&numbers);
    Ok(points)
}
