//! Points and lines as triangles: small balls and thin rods.
//!
//! glTF 2.0 leaves their size open and recommends one pixel (section 3.9.7, "Point and Line
//! Materials"). A path tracer has no pixels where its scene is made, so the width follows the
//! scene's size.

use super::error::GltfError;
use super::json::Json;
use super::material;
use super::mesh::{MAX_POSITION, Vertices};
use super::node::Nodes;
use super::notes::Notes;
use super::source::Budget;
use crate::scene::{Material, Model};
use glam::{DVec3, Vec3, Vec4};
use gltf::json::mesh::{LINE_LOOP, LINE_STRIP, LINES, POINTS};
use std::collections::HashMap;
use std::f32::consts::TAU;

/// Widths go into the diagonal of the scene's box: 1.1 pixels of a framed cube and 1.5 of a framed
/// square in a picture 600 pixels high.
const WIDTHS_IN_SCENE: f32 = 500.0;
/// Of a scene whose extent the file does not tell, metres.
const DEFAULT_EXTENT: f32 = 1.0;
/// A rod's sides.
const SIDES: usize = 6;

pub const NOTE: &str = "points and lines are drawn as bodies a 500th of the scene wide";

/// How a material shines from a stroke.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Shading {
    /// Without normals there is nothing to light.
    Unlit,
    /// Without tangents there are no normal maps.
    Smooth,
    /// As the material says.
    Full,
}

impl Shading {
    /// Section 3.9.7, by a primitive's attributes.
    fn of(attributes: &Json<'_>) -> Self {
        match (attributes.get("NORMAL"), attributes.get("TANGENT")) {
            (None, _) => Self::Unlit,
            (_, None) => Self::Smooth,
            _ => Self::Full,
        }
    }
}

pub fn is_stroke(mode: u32) -> bool {
    matches!(mode, POINTS | LINES | LINE_LOOP | LINE_STRIP)
}

/// What a scene's strokes need to know of it.
#[derive(Default)]
pub struct Strokes {
    /// Of each mesh that has some, by its path, in its own space.
    widths: HashMap<String, f32>,
    /// Materials made for strokes.
    materials: HashMap<(usize, Shading), usize>,
}

impl Strokes {
    /// Looks for strokes among the meshes that are shown. `extent` is that of the scene's first
    /// moment, so that widths stay while things move. Materials are added for those that shine
    /// otherwise from strokes.
    pub fn read(
        root: &Json<'_>,
        nodes: &Nodes<'_>,
        default_material: usize,
        materials: &mut Vec<Material>,
        extent: &mut Option<f32>,
        notes: &mut Notes,
    ) -> Result<Self, GltfError> {
        let mut shadings = Vec::new();
        let mut with_strokes = Vec::new();
        for mesh in root.objects("meshes")? {
            let mut any = false;
            for primitive in mesh.objects("primitives")? {
                let mode = primitive.uint("mode")?.unwrap_or(4);
                if u32::try_from(mode).is_ok_and(is_stroke) {
                    shadings.push(Shading::of(&primitive.object_or_empty("attributes")?));
                    any = true;
                }
            }
            with_strokes.push(any);
        }
        let mut strokes = Self::default();
        if shadings.is_empty() {
            return Ok(strokes);
        }
        let extent = match *extent {
            Some(extent) => extent,
            None => *extent.insert(scene_extent(nodes)?),
        };
        for &node in &nodes.shown {
            let json = &nodes.json[node];
            if let Some((index, mesh)) = json.reference("mesh", "meshes")?
                && with_strokes[index]
            {
                let scale = match json.get("skin") {
                    Some(_) => 1.0,
                    None => nodes.world(node).matrix3.determinant().abs().cbrt() as f32,
                };
                let width = extent / WIDTHS_IN_SCENE / scale;
                // The first node that shows a mesh decides, and another may scale it.
                strokes.widths.entry(mesh.at).or_insert(width);
            }
        }
        // A mesh that is known from an earlier moment has its materials by number: all are there in
        // each moment, whatever it shows.
        if materials.len() == default_material {
            materials.push(material::default_material());
        }
        for shading in [Shading::Unlit, Shading::Smooth] {
            if shadings.contains(&shading) {
                for index in 0..=default_material {
                    strokes.materials.insert((index, shading), materials.len());
                    let copy = shaded(&materials[index], shading, notes);
                    materials.push(copy);
                }
            }
        }
        Ok(strokes)
    }

    /// The material that stands for one on strokes with these attributes.
    pub fn material(&self, material: usize, attributes: &Json<'_>) -> usize {
        let key = (material, Shading::of(attributes));
        self.materials.get(&key).copied().unwrap_or(material)
    }

    /// In the mesh's own space; `positions` are those of a stroke in it.
    pub fn width(&self, mesh: &Json<'_>, positions: &[Vec3]) -> f32 {
        let known = self.widths.get(&mesh.at).copied();
        match known.filter(|width| width.is_normal() && *width < MAX_POSITION) {
            Some(width) => width,
            None => {
                let far = positions.iter().fold(0.0f32, |far, p| far.max(p.length()));
                if far > 0.0 {
                    far / WIDTHS_IN_SCENE
                } else {
                    DEFAULT_EXTENT
                }
            }
        }
    }
}

/// The diagonal of the box around the boxes that the accessors of all shown positions name. What they
/// name is not checked: only the width of strokes follows from it.
fn scene_extent(nodes: &Nodes<'_>) -> Result<f32, GltfError> {
    let mut bounds: Option<(DVec3, DVec3)> = None;
    for &node in &nodes.shown {
        let Some((_, mesh)) = nodes.json[node].reference("mesh", "meshes")? else {
            continue;
        };
        for primitive in mesh.objects("primitives")? {
            let attributes = primitive.object_or_empty("attributes")?;
            let Some((_, accessor)) = attributes.reference("POSITION", "accessors")? else {
                continue;
            };
            let (Ok(Some(low)), Ok(Some(high))) =
                (accessor.vector::<3>("min"), accessor.vector::<3>("max"))
            else {
                continue;
            };
            let ends = [low, high].map(|end| Vec3::from(end).as_dvec3());
            for corner in 0..8 {
                let pick = |axis: usize| ends[corner >> axis & 1][axis];
                let p = DVec3::new(pick(0), pick(1), pick(2));
                let p = nodes.world(node).transform_point3(p);
                bounds = Some(match bounds {
                    Some((low, high)) => (low.min(p), high.max(p)),
                    None => (p, p),
                });
            }
        }
    }
    let extent = bounds.map_or(0.0, |(low, high)| (high - low).length() as f32);
    Ok(if extent.is_normal() {
        extent
    } else {
        DEFAULT_EXTENT
    })
}

/// A material as it shines from a stroke.
fn shaded(material: &Material, shading: Shading, notes: &mut Notes) -> Material {
    let material = Material {
        normal_texture: None,
        ..material.clone()
    };
    if shading != Shading::Unlit {
        return material;
    }
    let (mut base_color, base_color_texture) = match &material.model {
        Model::MetallicRoughness(model) => (model.base_color, &model.base_color_texture),
        Model::SpecularGlossiness(model) => (model.diffuse.factor, &model.diffuse.texture),
        Model::Bsdf {
            base_color,
            base_color_texture,
            ..
        } => (*base_color, base_color_texture),
        Model::Unlit { .. } => return material,
    };
    // The sum of base colour and emission; no surface has two textures for one colour.
    if base_color_texture.is_none() && material.emissive_texture.is_none() {
        base_color += material.emissive.extend(0.0);
    } else if material.emissive != Vec3::ZERO {
        notes.add(
            "points and lines show a base colour without their emission",
            "",
        );
    }
    Material {
        model: Model::Unlit {
            base_color,
            base_color_texture: base_color_texture.clone(),
        },
        emissive: Vec3::ZERO,
        emissive_texture: None,
        ..material
    }
}

/// Balls and rods of a width around the vertices that `corners` names; each vertex of them has the
/// attributes of the one that it stands around.
pub fn build(
    vertices: &mut Vertices,
    corners: &[u32],
    mode: u32,
    width: f32,
    budget: &Budget,
    json: &Json<'_>,
) -> Result<Vec<[u32; 3]>, GltfError> {
    let count = corners.len();
    let pieces = match mode {
        POINTS => count,
        LINES => count / 2,
        LINE_STRIP => count.saturating_sub(1),
        _ if count > 1 => count,
        _ => 0,
    };
    let (points, faces) = match mode {
        POINTS => (BALL.len(), BALL_FACES.len()),
        _ => (ROD_VERTICES, 4 * SIDES),
    };
    const TRIANGLE_BYTES: u64 = 12;
    // With normals, and the order in which attributes are gathered.
    let point_bytes = vertices.stride() + 16;
    let bytes = points as u64 * point_bytes + faces as u64 * TRIANGLE_BYTES;
    budget.take((pieces as u64).saturating_mul(bytes), json.file(), &json.at)?;
    if (pieces as u64).saturating_mul(points as u64) > u64::from(u32::MAX) {
        return Err(json.invalid("its points or lines are too many to be drawn"));
    }

    let radius = 0.5 * width;
    let mut shape = Shape::with_capacity(pieces * points, pieces * faces);
    for piece in 0..pieces {
        match mode {
            POINTS => shape.ball(corners[piece], radius),
            _ => {
                let first = if mode == LINES { 2 * piece } else { piece };
                let ends = [corners[first], corners[(first + 1) % count]];
                let [from, to] = ends.map(|end| vertices.positions[end as usize]);
                shape.rod(
                    ends,
                    (to - from).as_dvec3().normalize_or(DVec3::Y).as_vec3(),
                    radius,
                );
            }
        }
    }
    vertices.gather(&shape.sources);
    for (position, offset) in vertices.positions.iter_mut().zip(&shape.offsets) {
        *position += *offset;
    }
    if vertices.normals.is_none() {
        vertices.tangents = None;
        let outward = shape
            .offsets
            .iter()
            .map(|offset| offset.normalize_or(Vec3::Z));
        vertices.normals = Some(outward.collect());
    } else if vertices.tangents.is_none() {
        // Around the normal, all directions are alike where nothing in the file tells them apart.
        let normals = vertices.normals.iter().flatten();
        let tangents = normals.map(|normal| {
            let normal = normal.try_normalize().unwrap_or(Vec3::Z);
            normal.any_orthonormal_vector().extend(1.0)
        });
        vertices.tangents = Some(tangents.collect::<Vec<Vec4>>());
    }
    Ok(shape.triangles)
}

/// Triangles around vertices of the file.
struct Shape {
    /// Around which vertex each of ours is, and where from there.
    sources: Vec<u32>,
    offsets: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

/// Of an icosahedron, not scaled: (0, 1, golden ratio) and its rotations.
const GOLDEN: f32 = 1.618_034;
const BALL: [[f32; 3]; 12] = [
    [-1.0, GOLDEN, 0.0],
    [1.0, GOLDEN, 0.0],
    [-1.0, -GOLDEN, 0.0],
    [1.0, -GOLDEN, 0.0],
    [0.0, -1.0, GOLDEN],
    [0.0, 1.0, GOLDEN],
    [0.0, -1.0, -GOLDEN],
    [0.0, 1.0, -GOLDEN],
    [GOLDEN, 0.0, -1.0],
    [GOLDEN, 0.0, 1.0],
    [-GOLDEN, 0.0, -1.0],
    [-GOLDEN, 0.0, 1.0],
];
#[rustfmt::skip]
const BALL_FACES: [[u32; 3]; 20] = [
    [0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11],
    [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8],
    [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9],
    [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1],
];
/// A ring and a tip at each end.
const ROD_VERTICES: usize = 2 * (SIDES + 1);

impl Shape {
    fn with_capacity(vertices: usize, triangles: usize) -> Self {
        Self {
            sources: Vec::with_capacity(vertices),
            offsets: Vec::with_capacity(vertices),
            triangles: Vec::with_capacity(triangles),
        }
    }

    fn push(&mut self, source: u32, offset: Vec3) {
        self.sources.push(source);
        self.offsets.push(offset);
    }

    fn ball(&mut self, source: u32, radius: f32) {
        let base = self.sources.len() as u32;
        for corner in BALL {
            self.push(source, radius * Vec3::from(corner).normalize());
        }
        self.triangles
            .extend(BALL_FACES.map(|face| face.map(|index| base + index)));
    }

    /// Its ends are cones, as long as they are wide, so that rods that meet leave no gap.
    fn rod(&mut self, ends: [u32; 2], along: Vec3, radius: f32) {
        let base = self.sources.len() as u32;
        let side = along.any_orthonormal_vector();
        let other = along.cross(side);
        for (end, outward) in ends.into_iter().zip([-along, along]) {
            for k in 0..SIDES {
                let (sin, cos) = (TAU * k as f32 / SIDES as f32).sin_cos();
                self.push(end, radius * (cos * side + sin * other));
            }
            self.push(end, radius * outward);
        }
        let sides = SIDES as u32;
        let far = base + sides + 1;
        for k in 0..sides {
            let next = (k + 1) % sides;
            self.triangles.extend([
                [base + k, base + next, far + next],
                [base + k, far + next, far + k],
                [base + sides, base + next, base + k],
                [far + sides, far + k, far + next],
            ]);
        }
    }
}
