//! Whatever happens to a file, the loader does not panic.

use crate::asset::{Asset, U8, glb, load_bytes, pixel_png};
use serde_json::{Value, json};
use snell::gltf::{LoadOptions, load};

/// A scene with something of everything, for the mutations.
fn rich() -> Asset {
    let mut asset = Asset::triangle();
    let texture = asset.texture(&pixel_png([10, 20, 30, 255]));
    let normals = asset.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let indices = asset.accessor(U8, "SCALAR", 3, &[0, 1, 2]);
    let joints = asset.accessor(U8, "VEC4", 3, &[0; 12]);
    let weights = asset.floats("VEC4", &[1.0, 0.0, 0.0, 0.0].repeat(3));
    let sparse_indices = asset.view(&[1, 0, 0, 0]);
    let sparse_values = asset.view(bytemuck::cast_slice(&[2.0f32, 0.0, 0.0]));
    asset.json["accessors"][0]["sparse"] = json!({"count": 1,
        "indices": {"bufferView": sparse_indices, "componentType": U8},
        "values": {"bufferView": sparse_values}});
    asset.primitive()["indices"] = json!(indices);
    asset.primitive()["targets"] = json!([{"POSITION": 0}]);
    let attributes = &mut asset.primitive()["attributes"];
    attributes["NORMAL"] = json!(normals);
    attributes["JOINTS_0"] = json!(joints);
    attributes["WEIGHTS_0"] = json!(weights);
    asset.json["nodes"] = json!([
        {"mesh": 0, "skin": 0, "weights": [0.5]}, {"children": [2], "camera": 0},
        {"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}]);
    asset.json["scenes"] = json!([{"nodes": [0, 1]}]);
    asset.json["skins"] = json!([{"joints": [1]}]);
    asset.json["cameras"] =
        json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]);
    asset.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "spot"}]}});
    asset.with_material(json!({
        "normalTexture": {"index": texture, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}},
        "pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}}))
}

/// A step of the generator of Marsaglia (2003), "Xorshift RNGs".
pub fn next(state: &mut u64) -> usize {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (*state >> 16) as usize
}

#[test]
fn mutated_files_never_panic() {
    const ROUNDS: usize = 3_000;
    let whole = rich().glb();
    assert!(load_bytes(&whole, &LoadOptions::default()).is_ok());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mutant.glb");
    // Memory that a mutant claims is refused and not taken.
    let options = LoadOptions {
        max_memory: 64 << 20,
        ..LoadOptions::default()
    };
    let mut state = 0x9E37_79B9_7F4A_7C15;
    let (mut loaded, mut refused) = (0, 0);
    for round in 0..ROUNDS {
        let mut bytes = whole.clone();
        for _ in 0..=next(&mut state) % 3 {
            let at = 20 + next(&mut state) % (bytes.len() - 20);
            bytes[at] = match next(&mut state) % 4 {
                0 => next(&mut state) as u8,
                1 => bytes[at] ^ 1 << (next(&mut state) % 8),
                // Digits and brackets keep the JSON alive more often.
                2 => b"0123456789"[next(&mut state) % 10],
                _ => b"[]{},:\"-e"[next(&mut state) % 9],
            };
        }
        if round % 10 == 0 {
            bytes.truncate(next(&mut state) % bytes.len());
        }
        std::fs::write(&path, &bytes).unwrap();
        match load(&path, &options) {
            Ok(_) => loaded += 1,
            Err(_) => refused += 1,
        }
    }
    println!("{loaded} mutants loaded, {refused} were refused");
    assert!(
        loaded > ROUNDS / 20 && refused > ROUNDS / 20,
        "{loaded} {refused}"
    );
}

#[test]
fn every_json_value_replaced_never_panics() {
    let asset = rich();
    let mut pointers = Vec::new();
    let mut stack = vec![(String::new(), &asset.json)];
    while let Some((pointer, value)) = stack.pop() {
        match value {
            Value::Object(object) => {
                let children = object
                    .iter()
                    .map(|(key, value)| (format!("{pointer}/{key}"), value));
                stack.extend(children);
            }
            Value::Array(array) => {
                let children = array.iter().enumerate();
                stack.extend(children.map(|(i, value)| (format!("{pointer}/{i}"), value)));
            }
            _ => {}
        }
        pointers.push(pointer);
    }
    let options = LoadOptions {
        max_memory: 64 << 20,
        ..LoadOptions::default()
    };
    let values = [
        json!(null),
        json!(-1),
        json!(0),
        json!(1e300),
        json!(u64::MAX),
        json!("text"),
        json!([]),
        json!({}),
        json!([0]),
        json!(true),
    ];
    for pointer in pointers {
        for value in &values {
            let mut json = asset.json.clone();
            *json.pointer_mut(&pointer).unwrap() = value.clone();
            let _ = load_bytes(&glb(&json.to_string(), &asset.bin), &options);
        }
    }
}
