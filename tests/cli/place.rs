//! A folder with a scene, the program run in it, and what comes out.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use base64::Engine as _;
use exr::prelude::{ReadChannels, ReadLayers};
use serde_json::{Value, json};

/// A folder for one test with a scene in it, and the program run there.
pub struct Place(tempfile::TempDir);

impl Place {
    /// Holds `scene.gltf`: one triangle that faces +z, with no camera and no light of its own.
    pub fn new() -> Place {
        let place = Place(tempfile::tempdir().unwrap());
        place.write("scene.gltf", scene().to_string().as_bytes());
        place
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, bytes: &[u8]) {
        fs::write(self.path(name), bytes).unwrap();
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Runs `snell` with the arguments of a line, split at spaces.
    pub fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_snell"));
        command
            .args(line.split_whitespace())
            .current_dir(self.0.path())
            .env_remove("RUST_LOG")
            .env("NODEVICE_SELECT", "1");
        command
    }

    pub fn run(&self, line: &str) -> Output {
        self.command(line).output().unwrap()
    }

    /// Where the Vulkan loader finds no driver.
    pub fn run_without_adapter(&self, line: &str) -> Output {
        self.command(line)
            .env("VK_DRIVER_FILES", "/nonexistent")
            .env("VK_ICD_FILENAMES", "/nonexistent")
            .output()
            .unwrap()
    }

    /// Runs and expects success.
    pub fn succeed(&self, line: &str) -> Output {
        let output = self.run(line);
        assert_status(&output, 0, line);
        output
    }

    /// Runs and expects this status, one line that starts with the program's name and holds `says`,
    /// and no new file.
    pub fn fail(&self, line: &str, status: i32, says: &str) {
        let before = self.names();
        let output = self.run(line);
        assert_status(&output, status, line);
        let text = stderr(&output);
        assert!(text.contains(says), "{line}: no '{says}' in:\n{text}");
        assert!(text.contains("error: "), "{line}:\n{text}");
        assert!(!text.contains("panicked"), "{line}:\n{text}");
        assert_eq!(before, self.names(), "{line} left a file");
    }

    pub fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(self.0.path())
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

pub fn scene() -> Value {
    let corners: [[f32; 3]; 3] = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
    let bytes: Vec<u8> = corners
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorFactor": [0.8, 0.4, 0.2, 1.0], "metallicFactor": 0.0 } }],
        "accessors": [{
            "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [-1.0, -1.0, 0.0], "max": [1.0, 1.0, 0.0]
        }],
        "bufferViews": [{ "buffer": 0, "byteLength": bytes.len() }],
        "buffers": [{
            "byteLength": bytes.len(),
            "uri": format!("data:application/octet-stream;base64,{data}")
        }]
    })
}

/// The same with a node's way in two seconds from 2 m on the left to 2 m on the right, and another
/// animation that lifts it.
pub fn animated() -> Value {
    let mut scene = scene();
    let values: [f32; 14] = [
        0.0, 2.0, -2.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0,
    ];
    let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    let add =
        |list: &mut Value, more: &[Value]| list.as_array_mut().unwrap().extend_from_slice(more);
    add(
        &mut scene["buffers"],
        &[json!({
            "byteLength": bytes.len(),
            "uri": format!("data:application/octet-stream;base64,{data}")
        })],
    );
    add(
        &mut scene["bufferViews"],
        &[json!({ "buffer": 1, "byteLength": bytes.len() })],
    );
    let accessor = |offset: usize, kind: &str| {
        json!({
            "bufferView": 1, "byteOffset": offset, "componentType": 5126, "count": 2, "type": kind,
            "min": [0.0], "max": [2.0]
        })
    };
    let vector = |offset| {
        let mut vector = accessor(offset, "VEC3");
        vector
            .as_object_mut()
            .unwrap()
            .retain(|key, _| key != "min" && key != "max");
        vector
    };
    add(
        &mut scene["accessors"],
        &[accessor(0, "SCALAR"), vector(8), vector(32)],
    );
    let animation = |name: &str, output: usize| {
        json!({
            "name": name,
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "translation" } }],
            "samplers": [{ "input": 1, "output": output }]
        })
    };
    scene["animations"] = json!([animation("walk", 2), animation("jump", 3)]);
    scene
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

pub fn assert_status(output: &Output, status: i32, line: &str) {
    assert_eq!(
        output.status.code(),
        Some(status),
        "snell {line}\n{}",
        stderr(output)
    );
}

/// Small enough to render in no time.
pub const SMALL: &str = "--size 16x12 --spp 4";

/// The channels of an EXR file by name.
pub fn channel(bytes: &[u8], name: &str) -> Vec<f32> {
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(bytes))
        .unwrap();
    let channels = image.layer_data.channel_data.list;
    let found = channels.iter().find(|c| c.name.eq(name));
    found
        .unwrap_or_else(|| panic!("no channel {name}"))
        .sample_data
        .values_as_f32()
        .collect()
}
