//! A glTF document under construction: one embedded buffer, and the arrays that refer to each other.

use super::mesh::Mesh;
use base64::Engine as _;
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;

/// Four bytes to a component of an attribute (glTF 2.0 section 3.6.2.2).
const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Indices into the document's accessors, so that several meshes can share one shape.
#[derive(Clone, Copy)]
pub struct Shape {
    position: usize,
    normal: Option<usize>,
    tangent: Option<usize>,
    indices: usize,
}

#[derive(Default)]
pub struct Document {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    materials: Vec<Value>,
    meshes: Vec<Value>,
    cameras: Vec<Value>,
    nodes: Vec<Value>,
    extensions: BTreeSet<String>,
}

impl Document {
    fn accessor(&mut self, bytes: &[u8], target: u32, mut accessor: Value) -> usize {
        self.views.push(json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(), "target": target
        }));
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        accessor["bufferView"] = json!(self.views.len() - 1);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn vectors<const N: usize>(&mut self, vectors: &[[f32; N]], bounds: bool) -> usize {
        let mut accessor = json!({
            "componentType": FLOAT, "count": vectors.len(), "type": format!("VEC{N}")
        });
        if bounds {
            let extreme = |pick: fn(f32, f32) -> f32| -> Vec<Value> {
                (0..N)
                    .filter_map(|i| vectors.iter().map(|v| v[i]).reduce(pick))
                    .map(number)
                    .collect()
            };
            accessor["min"] = extreme(f32::min).into();
            accessor["max"] = extreme(f32::max).into();
        }
        let bytes: Vec<u8> = vectors
            .iter()
            .flatten()
            .flat_map(|component| component.to_le_bytes())
            .collect();
        self.accessor(&bytes, ARRAY_BUFFER, accessor)
    }

    fn indices(&mut self, triangles: &[[u16; 3]]) -> usize {
        let bytes: Vec<u8> = triangles
            .iter()
            .flatten()
            .flat_map(|index| index.to_le_bytes())
            .collect();
        let accessor = json!({
            "componentType": UNSIGNED_SHORT, "count": 3 * triangles.len(), "type": "SCALAR"
        });
        self.accessor(&bytes, ELEMENT_ARRAY_BUFFER, accessor)
    }

    /// Stores a shape once. A mesh whose normals equal its positions (a unit sphere) shares them.
    pub fn shape(&mut self, mesh: &Mesh) -> Shape {
        let position = self.vectors(&mesh.positions, true);
        let normal = match &mesh.normals {
            Some(normals) if *normals == mesh.positions => Some(position),
            Some(normals) => Some(self.vectors(normals, false)),
            None => None,
        };
        Shape {
            position,
            normal,
            tangent: mesh.tangents.as_ref().map(|t| self.vectors(t, false)),
            indices: self.indices(&mesh.triangles),
        }
    }

    /// The vertices of `shape` with other triangles.
    pub fn other_triangles(&mut self, shape: Shape, triangles: &[[u16; 3]]) -> Shape {
        Shape {
            indices: self.indices(triangles),
            ..shape
        }
    }

    /// A material given as glTF; the extensions that it names are declared as used.
    pub fn material(&mut self, name: &str, mut material: Value) -> usize {
        if let Some(Value::Object(extensions)) = material.get("extensions") {
            self.extensions.extend(extensions.keys().cloned());
        }
        material["name"] = name.into();
        self.materials.push(material);
        self.materials.len() - 1
    }

    /// One of the lecture's models.
    pub fn bsdf(&mut self, name: &str, model: Value) -> usize {
        self.material(name, json!({"extensions": {"SNELL_materials_bsdf": model}}))
    }

    /// A light that reflects nothing. It shines from its front faces only.
    pub fn emitter(&mut self, name: &str, radiance: [f64; 3]) -> usize {
        let strength = radiance.into_iter().fold(1.0, f64::max);
        let mut extensions = json!({
            "SNELL_materials_bsdf": {"model": "lambertian", "reflectance": [0.0, 0.0, 0.0]}
        });
        if strength > 1.0 {
            extensions["KHR_materials_emissive_strength"] = json!({"emissiveStrength": strength});
        }
        let factor = radiance.map(|l| l / strength);
        self.material(
            name,
            json!({"emissiveFactor": factor, "extensions": extensions}),
        )
    }

    /// A mesh of one or more shapes, each with its material.
    pub fn mesh(&mut self, name: &str, primitives: &[(Shape, usize)]) -> usize {
        let primitives: Vec<Value> = primitives
            .iter()
            .map(|(shape, material)| {
                let mut attributes = json!({"POSITION": shape.position});
                for (semantic, accessor) in [("NORMAL", shape.normal), ("TANGENT", shape.tangent)] {
                    if let Some(accessor) = accessor {
                        attributes[semantic] = accessor.into();
                    }
                }
                json!({"attributes": attributes, "indices": shape.indices, "material": material})
            })
            .collect();
        self.meshes
            .push(json!({"name": name, "primitives": primitives}));
        self.meshes.len() - 1
    }

    /// Places a mesh: a uniform scale, then a translation.
    pub fn place(&mut self, name: &str, mesh: usize, scale: f64, translation: [f64; 3]) {
        let mut node = json!({"name": name, "mesh": mesh});
        if scale != 1.0 {
            node["scale"] = json!([scale, scale, scale]);
        }
        if translation != [0.0; 3] {
            node["translation"] = json!(translation);
        }
        self.nodes.push(node);
    }

    /// A shape with one material at the place where its vertices say.
    pub fn add(&mut self, name: &str, mesh: &Mesh, material: usize) {
        let shape = self.shape(mesh);
        let mesh = self.mesh(name, &[(shape, material)]);
        self.place(name, mesh, 1.0, [0.0; 3]);
    }

    /// A camera at `position`, pitched up by `pitch` radians from looking along -z.
    pub fn camera(&mut self, projection: Value, position: [f64; 3], pitch: f64) {
        let mut camera = projection;
        camera["name"] = "camera".into();
        self.cameras.push(camera);
        let (sin, cos) = (0.5 * pitch).sin_cos();
        self.nodes.push(json!({
            "name": "camera", "camera": self.cameras.len() - 1,
            "translation": position, "rotation": [sin, 0.0, 0.0, cos]
        }));
    }

    /// The file's text: one line for each element, so that a change of the scene reads as one.
    pub fn finish(self) -> String {
        let uri = format!(
            "data:application/octet-stream;base64,{}",
            base64::engine::general_purpose::STANDARD.encode(&self.bytes)
        );
        let scene: Vec<usize> = (0..self.nodes.len()).collect();
        let members = [
            ("scenes", vec![json!({"nodes": scene})]),
            ("nodes", self.nodes),
            ("cameras", self.cameras),
            ("meshes", self.meshes),
            ("materials", self.materials),
            ("accessors", self.accessors),
            ("bufferViews", self.views),
            (
                "buffers",
                vec![json!({"byteLength": self.bytes.len(), "uri": uri})],
            ),
        ];
        let asset = json!({"version": "2.0", "generator": "snell make_scenes"});
        let mut text = format!("{{\n\"asset\": {asset},\n");
        text += &format!(
            "\"extensionsUsed\": {},\n\"scene\": 0",
            json!(self.extensions)
        );
        for (name, elements) in members {
            let lines: Vec<String> = elements.iter().map(|e| sorted(e).to_string()).collect();
            text += &format!(",\n\"{name}\": [\n{}\n]", lines.join(",\n"));
        }
        text + "\n}\n"
    }
}

/// The shortest decimal that reads back as this f32, for accessor bounds.
fn number(x: f32) -> Value {
    x.to_string()
        .parse::<f64>()
        .map_or(Value::Null, Value::from)
}

/// The same value with its keys in alphabetical order, whatever map serde_json was built with.
fn sorted(value: &Value) -> Value {
    match value {
        Value::Object(map) => {
            let mut keys: Vec<&String> = map.keys().collect();
            keys.sort();
            let entries = keys.into_iter().map(|k| (k.clone(), sorted(&map[k])));
            Value::Object(entries.collect::<Map<_, _>>())
        }
        Value::Array(elements) => elements.iter().map(sorted).collect(),
        other => other.clone(),
    }
}
