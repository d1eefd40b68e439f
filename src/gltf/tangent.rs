//! Tangents where a file has none: MikkTSpace (Mikkelsen 2008, "Simulation of Wrinkled Surfaces
//! Revisited"), as glTF 2.0 section 3.7.2.1 asks.

use super::mesh::Vertices;
use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec2, Vec3, Vec4};
use std::collections::HashMap;

struct Corners<'v> {
    vertices: &'v Vertices,
    normals: &'v [Vec3],
    triangles: &'v [[u32; 3]],
    texcoords: Vec<Vec2>,
    tangents: Vec<[Vec4; 3]>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.triangles[face][corner] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.vertices.positions[self.vertex(face, corner)].into()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.normals[self.vertex(face, corner)].into()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.texcoords[self.vertex(face, corner)].into()
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        if let Some(space) = space {
            // Texture coordinates run down in glTF and up in MikkTSpace: the sign changes.
            let [x, y, z, sign] = space.tangent_encoded();
            self.tangents[face][corner] = Vec4::new(x, y, z, -sign);
        }
    }
}

/// Makes tangents that follow texture coordinate set `texcoord` after the affine map `rows`.
/// Vertices are split where the tangents of their triangles differ.
pub fn generate(
    vertices: &mut Vertices,
    triangles: &mut [[u32; 3]],
    texcoord: usize,
    rows: [Vec3; 2],
) {
    let texcoords = vertices.texcoords[texcoord].iter().map(|uv| {
        let uv = uv.extend(1.0);
        Vec2::new(rows[0].dot(uv), rows[1].dot(uv))
    });
    let mut corners = Corners {
        texcoords: texcoords.collect(),
        normals: vertices.normals.as_deref().unwrap_or_default(),
        vertices,
        triangles,
        tangents: vec![[Vec4::ZERO; 3]; triangles.len()],
    };
    match generate_tangents(&mut corners) {
        Ok(()) => {}
        // The library's error type has no values yet.
        Err(error) => log::warn!("no tangents: {error}"),
    }
    let tangents = corners.tangents;
    let mut order = Vec::new();
    let mut split = Vec::new();
    let mut known = HashMap::new();
    for (triangle, tangents) in triangles.iter_mut().zip(tangents) {
        for (index, tangent) in triangle.iter_mut().zip(tangents) {
            let key = (*index, tangent.to_array().map(f32::to_bits));
            *index = *known.entry(key).or_insert_with(|| {
                order.push(*index);
                split.push(tangent);
                (order.len() - 1) as u32
            });
        }
    }
    vertices.gather(&order);
    vertices.tangents = Some(split);
    repair(vertices);
}

/// Makes all tangents unit vectors with a sign of +1 or -1, any tangent where there is none. Says
/// whether one was missing.
pub fn repair(vertices: &mut Vertices) -> bool {
    let mut missing = false;
    let normals = vertices.normals.as_deref().unwrap_or_default();
    for (tangent, normal) in vertices.tangents.iter_mut().flatten().zip(normals) {
        let direction = tangent.truncate().try_normalize().unwrap_or_else(|| {
            missing = true;
            normal.any_orthonormal_vector()
        });
        *tangent = direction.extend(if tangent.w < 0.0 { -1.0 } else { 1.0 });
    }
    missing
}
