//! Vertex attributes to words: directions by the octahedral map, texture coordinates and colours in even steps
//! where these are fine enough.

use crate::cpu::attributes::octahedral_direction;
use crate::scene::{Mesh, Primitive, Scene, Texture};
use crate::shared::{
    LAYOUT_COLOR, LAYOUT_COLOR_UNORM, LAYOUT_TANGENT, LAYOUT_TEXCOORD_UNORM,
    LAYOUT_TEXCOORDS_SHIFT, NORMAL_STEPS, TANGENT_STEPS,
};
use glam::{DVec2, DVec3, IVec2, Vec2, Vec3, Vec4};
use rayon::prelude::*;

/// Steps of a texture coordinate from 0 to 1.
const TEXCOORD_STEPS: f64 = 65535.0;

/// Texels from coordinate 0 to 1 of the largest texture that such steps are fine enough for: half of one is
/// 1/32 of a texel.
const MAX_TEXELS: f32 = 4096.0;

/// What packed meshes take from the scene's materials, for each primitive.
pub fn layouts(mesh: &Mesh, scene: &Scene) -> Vec<u32> {
    let primitives = mesh.primitives.iter();
    primitives
        .map(|primitive| Layout::asked(primitive, scene).flags())
        .collect()
}

/// Which attributes the vertices of a primitive carry, those that are there and that its material reads,
/// and how.
pub struct Layout {
    tangent: bool,
    color: bool,
    color_unorm: bool,
    texcoords: usize,
    texcoord_unorm: bool,
}

impl Layout {
    /// That of a primitive's vertices.
    pub fn of(primitive: &Primitive, scene: &Scene) -> Self {
        Self::asked(primitive, scene).fitting(primitive)
    }

    /// What the material asks for, whatever the attributes' values are.
    fn asked(primitive: &Primitive, scene: &Scene) -> Self {
        let material = &scene.materials[primitive.material];
        let texcoords = material.texcoord_count().min(primitive.texcoords.len());
        let fine_enough = |texture: &Texture| {
            let image = &scene.images[texture.image];
            let sizes = [image.width, image.height];
            texture.rows.iter().zip(sizes).all(|(row, size)| {
                let texels = (row.x.abs() + row.y.abs()) * size as f32;
                texels <= MAX_TEXELS
            })
        };
        Self {
            tangent: material.tangent_source().is_some() && primitive.tangents.is_some(),
            color: primitive.colors.is_some(),
            color_unorm: false,
            texcoords,
            texcoord_unorm: texcoords > 0 && material.textures().all(fine_enough),
        }
    }

    /// What steps lose too much of stays in f32: coordinates outside of 0 to 1, colours that are not of a byte
    /// a channel.
    fn fitting(self, primitive: &Primitive) -> Self {
        let sets = &primitive.texcoords[..self.texcoords];
        let in_range = |uv: &Vec2| steps(*uv).is_some();
        let color_unorm = primitive
            .colors
            .as_ref()
            .is_some_and(|colors| colors.par_iter().all(|color| bytes(*color).is_some()));
        Self {
            texcoord_unorm: self.texcoord_unorm
                && sets.iter().all(|set| set.par_iter().all(in_range)),
            color_unorm,
            ..self
        }
    }

    pub fn words(&self) -> usize {
        let color = if self.color_unorm { 1 } else { 4 };
        let texcoord = if self.texcoord_unorm { 1 } else { 2 };
        1 + usize::from(self.tangent) + color * usize::from(self.color) + texcoord * self.texcoords
    }

    pub fn flags(&self) -> u32 {
        let flag = |on: bool, flag: u32| if on { flag } else { 0 };
        (self.texcoords as u32) << LAYOUT_TEXCOORDS_SHIFT
            | flag(self.tangent, LAYOUT_TANGENT)
            | flag(self.color, LAYOUT_COLOR)
            | flag(self.color_unorm, LAYOUT_COLOR_UNORM)
            | flag(self.texcoord_unorm, LAYOUT_TEXCOORD_UNORM)
    }

    /// Appends the vertices of a primitive that this layout is fitting for.
    pub fn write(&self, primitive: &Primitive, vertices: &mut Vec<u32>) {
        let first = vertices.len();
        vertices.resize(first + primitive.positions.len() * self.words(), 0);
        vertices[first..]
            .par_chunks_mut(self.words())
            .enumerate()
            .for_each(|(vertex, words)| self.write_vertex(primitive, vertex, words));
    }

    fn write_vertex(&self, primitive: &Primitive, vertex: usize, words: &mut [u32]) {
        let mut words = words.iter_mut();
        let mut put = |word: u32| *words.next().expect("words() counts these") = word;
        put(pack_normal(primitive.normals[vertex]));
        if let Some(tangents) = primitive.tangents.as_ref().filter(|_| self.tangent) {
            put(pack_tangent(tangents[vertex]));
        }
        if let Some(colors) = &primitive.colors {
            match bytes(colors[vertex]).filter(|_| self.color_unorm) {
                Some(bytes) => put(u32::from_le_bytes(bytes)),
                None => colors[vertex]
                    .to_array()
                    .map(f32::to_bits)
                    .into_iter()
                    .for_each(&mut put),
            }
        }
        for set in &primitive.texcoords[..self.texcoords] {
            match steps(set[vertex]).filter(|_| self.texcoord_unorm) {
                Some([u, v]) => put(u32::from(u) | u32::from(v) << 16),
                None => set[vertex]
                    .to_array()
                    .map(f32::to_bits)
                    .into_iter()
                    .for_each(&mut put),
            }
        }
    }
}

/// As `unpack_normal` reads it.
pub fn pack_normal(normal: Vec3) -> u32 {
    let [x, y] = octahedral_point(normal.as_dvec3(), NORMAL_STEPS as i32).to_array();
    (x & 0xffff | y << 16) as u32
}

/// As `unpack_tangent` reads it; of w only the sign counts.
pub fn pack_tangent(tangent: Vec4) -> u32 {
    let [x, y] = octahedral_point(tangent.truncate().as_dvec3(), TANGENT_STEPS as i32).to_array();
    let handedness = i32::from(tangent.w > 0.0) - i32::from(tangent.w < 0.0);
    (x & 0x7fff | (y & 0x7fff) << 15 | handedness << 30) as u32
}

/// The point of the octahedral map with the direction nearest to `v`'s, of the four around it. (Cigolle et al.
/// 2014, "A Survey of Efficient Representations for Independent Unit Vectors", the "precise" encoding.)
fn octahedral_point(v: DVec3, steps: i32) -> IVec2 {
    let v = v.normalize_or_zero();
    if v == DVec3::ZERO {
        return IVec2::splat(-steps - 1);
    }
    let mut at = v.truncate() / v.abs().element_sum();
    if v.z < 0.0 {
        let sign = DVec2::select(at.cmpge(DVec2::ZERO), DVec2::ONE, DVec2::NEG_ONE);
        at = (1.0 - DVec2::new(at.y, at.x).abs()) * sign;
    }
    let at = at * f64::from(steps);
    let (low, high) = (at.floor().as_ivec2(), at.ceil().as_ivec2());
    let corners = [
        low,
        IVec2::new(high.x, low.y),
        IVec2::new(low.x, high.y),
        high,
    ];
    let [first, others @ ..] = corners;
    let cosine = |at: IVec2| octahedral_direction(at.x, at.y, steps).dot(v);
    let best = |best: IVec2, at: IVec2| if cosine(at) > cosine(best) { at } else { best };
    others.into_iter().fold(first, best)
}

/// The nearest steps, unless one is outside of 0 to 1.
fn steps(uv: Vec2) -> Option<[u16; 2]> {
    let at = (uv.as_dvec2() * TEXCOORD_STEPS).round();
    let in_range = at.cmpge(DVec2::ZERO).all() && at.cmple(DVec2::splat(TEXCOORD_STEPS)).all();
    in_range.then(|| at.to_array().map(|step| step as u16))
}

/// The bytes whose 255th parts, in float32, are just these channels.
fn bytes(color: Vec4) -> Option<[u8; 4]> {
    let bytes = color.to_array().map(|value| (value * 255.0).round() as u8);
    let value = bytes.map(|byte| f32::from(byte) / 255.0);
    (value == color.to_array()).then_some(bytes)
}
