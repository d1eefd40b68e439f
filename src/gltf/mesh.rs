//! Meshes: attributes and indices to triangles, in the pose that the file rests in.

use super::accessor::{Accessors, Attribute};
use super::deform::{self, Pose};
use super::draco;
use super::error::GltfError;
use super::json::Json;
use super::material::MAX_TEXCOORDS;
use super::normal;
use super::notes::Notes;
use super::stroke::{self, Strokes};
use super::tangent;
use super::variant;
use crate::scene::{Material, Mesh, Primitive};
use glam::{Vec2, Vec3, Vec4};
use gltf::json::mesh::{TRIANGLE_FAN, TRIANGLE_STRIP, TRIANGLES};

/// Farther out, squares of distances are no longer 32-bit floats. Metres.
pub const MAX_POSITION: f32 = 1e18;

/// A primitive's vertices while it is read; all attributes are as long as `positions`.
#[derive(Clone, Default)]
pub struct Vertices {
    pub positions: Vec<Vec3>,
    pub normals: Option<Vec<Vec3>>,
    pub tangents: Option<Vec<Vec4>>,
    pub colors: Option<Vec<Vec4>>,
    pub texcoords: Vec<Vec<Vec2>>,
}

impl Vertices {
    /// Vertex i becomes what vertex `order[i]` was.
    pub fn gather(&mut self, order: &[u32]) {
        fn pick<T: Copy>(values: &mut Vec<T>, order: &[u32]) {
            *values = order.iter().map(|&index| values[index as usize]).collect();
        }
        pick(&mut self.positions, order);
        self.normals
            .iter_mut()
            .for_each(|values| pick(values, order));
        self.tangents
            .iter_mut()
            .for_each(|values| pick(values, order));
        self.colors
            .iter_mut()
            .for_each(|values| pick(values, order));
        self.texcoords
            .iter_mut()
            .for_each(|values| pick(values, order));
    }

    /// Bytes that one vertex takes.
    pub fn stride(&self) -> u64 {
        let floats = 3
            + 3 * u64::from(self.normals.is_some())
            + 4 * u64::from(self.tangents.is_some())
            + 4 * u64::from(self.colors.is_some())
            + 2 * self.texcoords.len() as u64;
        floats * 4
    }
}

/// Reads meshes.
pub struct Meshes<'s, 'b> {
    pub accessors: Accessors<'b>,
    pub materials: &'s [Material],
    /// Where a primitive without a material finds one.
    pub default_material: usize,
    /// Of KHR_materials_variants.
    pub variant: Option<usize>,
    pub strokes: &'s Strokes,
    pub notes: &'s mut Notes,
}

impl Meshes<'_, '_> {
    pub fn mesh(&mut self, json: &Json<'_>, pose: &Pose<'_>) -> Result<Mesh, GltfError> {
        let weights = match &pose.weights {
            Some(weights) => Some(weights.clone()),
            None => json.numbers("weights")?,
        };
        let pose = Pose {
            weights,
            joints: pose.joints,
        };
        let mut primitives = Vec::new();
        for primitive in json.objects("primitives")? {
            primitives.extend(self.primitive(json, &primitive, &pose)?);
        }
        Ok(Mesh {
            name: json.name(),
            primitives,
        })
    }

    fn primitive(
        &mut self,
        mesh: &Json<'_>,
        json: &Json<'_>,
        pose: &Pose<'_>,
    ) -> Result<Option<Primitive>, GltfError> {
        let mode = json.uint("mode")?.unwrap_or(u64::from(TRIANGLES));
        let mode = u32::try_from(mode).unwrap_or(u32::MAX);
        if mode > TRIANGLE_FAN {
            return Err(json.invalid(format!("mode is {mode}; it must be 0 to 6")));
        }
        let attributes = json
            .object("attributes")?
            .ok_or_else(|| json.invalid("`attributes` is missing"))?;
        if attributes.get("POSITION").is_none() {
            self.notes
                .add("a primitive without POSITION is not drawn", &json.at);
            return Ok(None);
        }
        let overrides = draco::read(json, &attributes, self.accessors, self.notes)?;
        let accessors = Accessors {
            overrides: Some(&overrides),
            ..self.accessors
        };
        let mut vertices = self.vertices(&attributes, accessors)?;
        let corners = self.corners(json, vertices.positions.len(), accessors)?;
        let material = match variant::material(json, self.variant)? {
            Some((index, _)) => index,
            None => self.default_material,
        };
        deform::morph(&mut vertices, json, pose, accessors, self.notes)?;
        deform::skin(&mut vertices, &attributes, pose, accessors, self.notes)?;
        check_positions(&vertices, &attributes)?;
        let (triangles, material) = if stroke::is_stroke(mode) {
            self.notes.add(stroke::NOTE, &json.at);
            let width = self.strokes.width(mesh, &vertices.positions);
            let budget = self.accessors.budget;
            let triangles = stroke::build(&mut vertices, &corners, mode, width, budget, json)?;
            (triangles, self.strokes.material(material, &attributes))
        } else {
            (self.triangles(json, mode, &corners)?, material)
        };
        if triangles.is_empty() {
            return Ok(None);
        }
        Ok(Some(self.finish(vertices, triangles, material, json)?))
    }

    /// Normals, tangents and texture coordinates that are missing are made.
    fn finish(
        &mut self,
        mut vertices: Vertices,
        mut triangles: Vec<[u32; 3]>,
        material: usize,
        json: &Json<'_>,
    ) -> Result<Primitive, GltfError> {
        let corners = 3 * triangles.len() as u64;
        if vertices.normals.is_none() {
            // glTF 2.0 section 3.7.2.1: flat normals, and tangents in the file are ignored.
            vertices.tangents = None;
            let bytes = corners * (vertices.stride() + 12);
            self.accessors.budget.take(bytes, json.file(), &json.at)?;
            normal::flatten(&mut vertices, &mut triangles);
        } else if normal::repair(&mut vertices, &triangles) {
            self.notes.add(
                "normals of length zero are replaced by the faces'",
                &json.at,
            );
        }
        let used = &self.materials[material];
        let present = vertices.texcoords.len();
        if present < used.texcoord_count() {
            self.notes
                .add("missing texture coordinates are taken as zero", &json.at);
        }
        let count = present.max(used.texcoord_count());
        let zeros = vec![Vec2::ZERO; vertices.positions.len()];
        vertices.texcoords.resize(count, zeros);
        match used.tangent_source() {
            None => vertices.tangents = None,
            Some((texcoord, rows)) => {
                if vertices.tangents.is_none() && texcoord < present {
                    let bytes = corners * (vertices.stride() + 16);
                    self.accessors.budget.take(bytes, json.file(), &json.at)?;
                    tangent::generate(&mut vertices, &mut triangles, texcoord, rows);
                } else if tangent::repair(&mut vertices) {
                    self.notes
                        .add("tangents of length zero are replaced", &json.at);
                }
            }
        }
        Ok(Primitive {
            positions: vertices.positions,
            normals: vertices.normals.unwrap_or_default(),
            tangents: vertices.tangents,
            colors: vertices.colors,
            texcoords: vertices.texcoords,
            triangles,
            material,
        })
    }

    fn vertices(
        &mut self,
        attributes: &Json<'_>,
        accessors: Accessors<'_>,
    ) -> Result<Vertices, GltfError> {
        const VEC2: Attribute = Attribute::of(&["VEC2"]);
        const VEC3: Attribute = Attribute::of(&["VEC3"]);
        const VEC4: Attribute = Attribute::of(&["VEC4"]);
        const COLOR: Attribute = Attribute {
            types: &["VEC3", "VEC4"],
            fill: 1.0,
            normalized: true,
        };
        let positions = accessors.floats::<3>(attributes, "POSITION", &VEC3)?;
        let normals = accessors.floats::<3>(attributes, "NORMAL", &VEC3)?;
        let tangents = accessors.floats::<4>(attributes, "TANGENT", &VEC4)?;
        let colors = accessors.floats::<4>(attributes, "COLOR_0", &COLOR)?;
        let mut vertices = Vertices {
            positions: vectors(positions.unwrap_or_default()),
            normals: normals.map(vectors),
            tangents: tangents.map(vectors),
            colors: colors.map(vectors),
            texcoords: Vec::new(),
        };
        let count = vertices.positions.len();
        if count > u32::MAX as usize {
            return Err(attributes.invalid(format!("{count} vertices are more than 2^32 - 1")));
        }
        for set in 0..MAX_TEXCOORDS {
            let key = format!("TEXCOORD_{set}");
            if let Some(values) = accessors.floats::<2>(attributes, &key, &VEC2)? {
                vertices.texcoords.resize(set, vec![Vec2::ZERO; count]);
                vertices.texcoords.push(vectors(values));
            }
        }
        let lengths = [
            ("NORMAL", vertices.normals.as_ref().map(Vec::len)),
            ("TANGENT", vertices.tangents.as_ref().map(Vec::len)),
            ("COLOR_0", vertices.colors.as_ref().map(Vec::len)),
        ];
        let sets = vertices
            .texcoords
            .iter()
            .map(|set| ("TEXCOORD_n", Some(set.len())));
        for (name, length) in lengths.into_iter().chain(sets) {
            if let Some(length) = length
                && length != count
            {
                return Err(attributes.invalid(format!(
                    "{name} has {length} elements and POSITION has {count}"
                )));
            }
        }
        if sanitize(&mut vertices) {
            self.notes.add(
                "vertex attributes that are not finite are taken as zero",
                &attributes.at,
            );
        }
        Ok(vertices)
    }

    /// The vertices in the order of the indices, or in their own.
    fn corners(
        &self,
        json: &Json<'_>,
        vertex_count: usize,
        accessors: Accessors<'_>,
    ) -> Result<Vec<u32>, GltfError> {
        let indices = accessors.integers::<1>(json, "indices", &["SCALAR"])?;
        let count = indices.as_ref().map_or(vertex_count, Vec::len);
        accessors
            .budget
            .take(4 * count as u64, json.file(), &json.at)?;
        let Some(indices) = indices else {
            return Ok((0..vertex_count as u32).collect());
        };
        let outside = |[index]: &[u32; 1]| *index as usize >= vertex_count;
        if let Some((place, [index])) = indices.iter().enumerate().find(|(_, i)| outside(i)) {
            return Err(json.invalid(format!(
                "index {index} (number {place} of its indices) is out of range: \
                 there are {vertex_count} vertices"
            )));
        }
        Ok(indices.into_iter().flatten().collect())
    }

    /// glTF 2.0 section 3.7.2.1: lists, strips and fans.
    fn triangles(
        &mut self,
        json: &Json<'_>,
        mode: u32,
        corners: &[u32],
    ) -> Result<Vec<[u32; 3]>, GltfError> {
        let count = corners.len();
        let budget = self.accessors.budget;
        budget.take(12 * count as u64, json.file(), &json.at)?;
        let triangle_count = match mode {
            TRIANGLES => count / 3,
            _ => count.saturating_sub(2),
        };
        let used = if mode == TRIANGLES {
            3 * triangle_count
        } else {
            triangle_count + 2
        };
        if triangle_count == 0 || used != count {
            self.notes
                .add("indices that make no whole triangle are left out", &json.at);
        }
        Ok((0..triangle_count)
            .map(|i| match mode {
                TRIANGLES => [3 * i, 3 * i + 1, 3 * i + 2],
                TRIANGLE_STRIP => [i, i + 1 + i % 2, i + 2 - i % 2],
                _ => [i + 1, i + 2, 0],
            })
            .map(|triangle| triangle.map(|i| corners[i]))
            // Strips are stitched with triangles of no area.
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect())
    }
}

fn vectors<V: From<[f32; N]>, const N: usize>(values: Vec<[f32; N]>) -> Vec<V> {
    values.into_iter().map(V::from).collect()
}

/// Whether something but the positions was not finite. Colours are made non-negative, too.
fn sanitize(vertices: &mut Vertices) -> bool {
    let mut found = false;
    let mut zero = |bad: bool| {
        found |= bad;
        bad
    };
    for normal in vertices.normals.iter_mut().flatten() {
        if zero(!normal.is_finite()) {
            *normal = Vec3::ZERO;
        }
    }
    for tangent in vertices.tangents.iter_mut().flatten() {
        if zero(!tangent.is_finite()) {
            *tangent = Vec4::ZERO;
        }
    }
    for color in vertices.colors.iter_mut().flatten() {
        if zero(!color.is_finite()) {
            *color = Vec4::ZERO;
        }
        *color = color.clamp(Vec4::ZERO, Vec4::ONE);
    }
    for texcoord in vertices.texcoords.iter_mut().flatten() {
        if zero(!texcoord.is_finite()) {
            *texcoord = Vec2::ZERO;
        }
    }
    found
}

fn check_positions(vertices: &Vertices, attributes: &Json<'_>) -> Result<(), GltfError> {
    let bad = |p: &Vec3| !p.is_finite() || p.abs().max_element() > MAX_POSITION;
    match vertices.positions.iter().enumerate().find(|(_, p)| bad(p)) {
        None => Ok(()),
        Some((index, position)) => {
            let (_, accessor) = attributes.required("POSITION")?.follow("accessors")?;
            Err(accessor.invalid(format!(
                "the position of vertex {index} is {position}, not finite or farther out than \
                 {MAX_POSITION:e} m"
            )))
        }
    }
}
