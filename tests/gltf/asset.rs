//! Small glTF files, made in code.
#![allow(dead_code, reason = "each test binary uses the parts that it needs")]
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

use serde_json::{Value, json};
use snell::gltf::{GltfError, LoadOptions, Loaded, load};
use std::path::{Path, PathBuf};

pub const U8: u32 = 5121;
pub const U16: u32 = 5123;
pub const U32: u32 = 5125;
pub const F32: u32 = 5126;

/// glTF JSON and the binary buffer 0 that it refers to.
#[derive(Clone)]
pub struct Asset {
    pub json: Value,
    pub bin: Vec<u8>,
}

impl Asset {
    pub fn new() -> Self {
        Self {
            json: json!({"asset": {"version": "2.0"}}),
            bin: Vec::new(),
        }
    }

    /// Appends to a top-level array and gives the index.
    pub fn push(&mut self, section: &str, value: Value) -> usize {
        let root = self.json.as_object_mut().unwrap();
        let list = root.entry(section).or_insert_with(|| json!([]));
        let list = list.as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend(bytes);
        self.push(
            "bufferViews",
            json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}),
        )
    }

    pub fn accessor(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": component, "type": kind, "count": count}),
        )
    }

    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        self.accessor(
            F32,
            kind,
            values.len() / width,
            bytemuck::cast_slice(values),
        )
    }

    /// An asset that shows one mesh with one primitive by node 0 of scene 0.
    pub fn of_primitive(build: impl FnOnce(&mut Asset) -> Value) -> Self {
        let mut asset = Self::new();
        let primitive = build(&mut asset);
        asset.push("meshes", json!({"primitives": [primitive]}));
        asset.push("nodes", json!({"mesh": 0}));
        asset.push("scenes", json!({"nodes": [0]}));
        asset
    }

    /// One triangle in the plane z = 0, facing +z, without normals.
    pub fn triangle() -> Self {
        Self::of_primitive(|asset| {
            let positions = asset.floats("VEC3", &TRIANGLE);
            json!({"attributes": {"POSITION": positions}})
        })
    }

    /// The primitive of mesh 0.
    pub fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    /// A material on the only primitive, with texture coordinates that fit a triangle.
    pub fn with_material(mut self, material: Value) -> Self {
        let index = self.push("materials", material);
        let texcoords = self.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 0.0, 0.0]);
        self.primitive()["material"] = json!(index);
        self.primitive()["attributes"]["TEXCOORD_0"] = json!(texcoords);
        self
    }

    /// An image in a buffer view and a texture of it, texture index returned.
    pub fn texture(&mut self, encoded: &[u8]) -> usize {
        let view = self.view(encoded);
        let image = self.push(
            "images",
            json!({"bufferView": view, "mimeType": "image/png"}),
        );
        self.push("textures", json!({"source": image}))
    }

    fn with_buffer(&self, uri: Option<String>) -> Value {
        let mut json = self.json.clone();
        if json.get("buffers").is_none() && !self.bin.is_empty() {
            json["buffers"] = json!([{"byteLength": self.bin.len()}]);
            if let Some(uri) = uri {
                json["buffers"][0]["uri"] = json!(uri);
            }
        }
        json
    }

    pub fn glb(&self) -> Vec<u8> {
        glb(&self.with_buffer(None).to_string(), &self.bin)
    }

    pub fn save_glb(&self, path: &Path) {
        std::fs::write(path, self.glb()).unwrap();
    }

    pub fn save_separate(&self, path: &Path) {
        let bin = path.with_extension("bin");
        let uri = bin
            .file_name()
            .unwrap()
            .to_string_lossy()
            .replace(' ', "%20");
        std::fs::write(&bin, &self.bin).unwrap();
        std::fs::write(path, self.with_buffer(Some(uri)).to_string()).unwrap();
    }

    pub fn save_embedded(&self, path: &Path) {
        use base64::Engine as _;
        let text = base64::engine::general_purpose::STANDARD.encode(&self.bin);
        let uri = format!("data:application/octet-stream;base64,{text}");
        std::fs::write(path, self.with_buffer(Some(uri)).to_string()).unwrap();
    }

    pub fn try_load(&self) -> Result<Loaded, GltfError> {
        load_bytes(&self.glb(), &LoadOptions::default())
    }

    pub fn load(&self) -> Loaded {
        self.try_load()
            .unwrap_or_else(|error| panic!("{error}\n{:#}", self.json))
    }
}

pub const TRIANGLE: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

pub fn glb(json: &str, bin: &[u8]) -> Vec<u8> {
    let mut text = json.as_bytes().to_vec();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut bin = bin.to_vec();
    bin.resize(bin.len().next_multiple_of(4), 0);
    let mut out = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
    for (kind, data) in [(b"JSON", text), (b"BIN\0", bin)] {
        if kind == b"JSON" || !data.is_empty() {
            out.extend((data.len() as u32).to_le_bytes());
            out.extend(kind);
            out.extend(data);
        }
    }
    let length = (out.len() as u32).to_le_bytes();
    out[8..12].copy_from_slice(&length);
    out
}

pub fn load_bytes(bytes: &[u8], options: &LoadOptions) -> Result<Loaded, GltfError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.glb");
    std::fs::write(&path, bytes).unwrap();
    load(&path, options)
}

/// The models of others, where they are at hand.
pub fn corpus() -> Option<PathBuf> {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/corpus"));
    path.is_dir().then_some(path)
}

/// All .gltf and .glb files below a folder, sorted.
pub fn models(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let ending = path.extension().and_then(|ending| ending.to_str());
            match ending {
                _ if path.is_dir() => folders.push(path),
                Some("gltf" | "glb") => found.push(path),
                _ => {}
            }
        }
    }
    found.sort();
    found
}

/// A PNG file of any colour type and depth, its rows as they go into the stream without filters.
pub fn png(width: u32, height: u32, depth: u8, color: u8, palette: &[u8], rows: &[u8]) -> Vec<u8> {
    png_of([width, height], [depth, color, 0], palette, &[], rows)
}

/// The same with its depth, colour type and interlacing, and a tRNS chunk where it is not empty.
pub fn png_of(
    [width, height]: [u32; 2],
    [depth, color, interlacing]: [u8; 3],
    palette: &[u8],
    transparency: &[u8],
    rows: &[u8],
) -> Vec<u8> {
    let mut header = Vec::new();
    header.extend(width.to_be_bytes());
    header.extend(height.to_be_bytes());
    header.extend([depth, color, 0, 0, interlacing]);
    // RFC 1950 and 1951: one stored block.
    let mut stream = vec![0x78, 0x01, 0x01];
    stream.extend((rows.len() as u16).to_le_bytes());
    stream.extend((!(rows.len() as u16)).to_le_bytes());
    stream.extend(rows);
    let (mut a, mut b) = (1u32, 0u32);
    for &byte in rows {
        a = (a + u32::from(byte)) % 65521;
        b = (b + a) % 65521;
    }
    stream.extend((b << 16 | a).to_be_bytes());
    let mut out = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |kind: &[u8; 4], data: &[u8]| {
        out.extend((data.len() as u32).to_be_bytes());
        out.extend(kind);
        out.extend(data);
        let mut crc = u32::MAX;
        for &byte in kind.iter().chain(data) {
            crc ^= u32::from(byte);
            for _ in 0..8 {
                crc = if crc & 1 == 1 {
                    crc >> 1 ^ 0xEDB8_8320
                } else {
                    crc >> 1
                };
            }
        }
        out.extend((!crc).to_be_bytes());
    };
    chunk(b"IHDR", &header);
    if !palette.is_empty() {
        chunk(b"PLTE", palette);
    }
    if !transparency.is_empty() {
        chunk(b"tRNS", transparency);
    }
    chunk(b"IDAT", &stream);
    chunk(b"IEND", &[]);
    out
}

/// One RGBA pixel.
pub fn pixel_png(rgba: [u8; 4]) -> Vec<u8> {
    png(1, 1, 8, 6, &[], &[0, rgba[0], rgba[1], rgba[2], rgba[3]])
}
