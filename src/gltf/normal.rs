//! Normals where a file has none, or none of any length.

use super::mesh::Vertices;
use glam::{DVec3, Vec3};

/// glTF 2.0 section 3.7.2.1: a primitive without normals has flat ones, so no two triangles share
/// a vertex.
pub fn flatten(vertices: &mut Vertices, triangles: &mut [[u32; 3]]) {
    let corners: Vec<u32> = triangles.iter().flatten().copied().collect();
    vertices.gather(&corners);
    let faces = vertices.positions.chunks_exact(3);
    let normals = faces.flat_map(|p| {
        let normal = area_vector([p[0], p[1], p[2]]).normalize_or(DVec3::Z);
        [normal.as_vec3(); 3]
    });
    vertices.normals = Some(normals.collect());
    for (face, triangle) in (0u32..).zip(triangles) {
        *triangle = [3 * face, 3 * face + 1, 3 * face + 2];
    }
}

/// Makes all normals unit vectors; one of no length becomes the mean of the faces around it. Says
/// whether there was one.
pub fn repair(vertices: &mut Vertices, triangles: &[[u32; 3]]) -> bool {
    let Some(normals) = &mut vertices.normals else {
        return false;
    };
    for normal in normals.iter_mut() {
        *normal = normal.as_dvec3().normalize_or_zero().as_vec3();
    }
    if !normals.contains(&Vec3::ZERO) {
        return false;
    }
    let mut sums = vec![DVec3::ZERO; normals.len()];
    for triangle in triangles {
        let face = area_vector(triangle.map(|index| vertices.positions[index as usize]));
        for index in triangle {
            sums[*index as usize] += face;
        }
    }
    for (normal, sum) in normals.iter_mut().zip(sums) {
        if *normal == Vec3::ZERO {
            *normal = sum.normalize_or(DVec3::Z).as_vec3();
        }
    }
    true
}

/// Twice the area, along the normal.
fn area_vector(p: [Vec3; 3]) -> DVec3 {
    let [a, b, c] = p.map(|p| p.as_dvec3());
    (b - a).cross(c - a)
}
