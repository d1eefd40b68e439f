//! Compressed geometry that is damaged, or claims what is not there.

use crate::asset::{Asset, U8, corpus, load_bytes};
use crate::draco::{EDGEBREAKER, POINTS, SEQUENTIAL, TRIANGLES, sheet};
use crate::mutants::next;
use crate::{expect, invalid};
use serde_json::{Value, json};
use snell::gltf::LoadOptions;

const DRACO: &str = "meshes[0].primitives[0].extensions.KHR_draco_mesh_compression";

fn small() -> LoadOptions {
    LoadOptions {
        max_memory: 64 << 20,
        ..LoadOptions::default()
    }
}

#[test]
fn draco_streams_cut_short() {
    for stream in [EDGEBREAKER, SEQUENTIAL] {
        for length in 1..stream.len() {
            invalid(
                &sheet(&stream[..length]),
                DRACO,
                "the Draco stream is damaged",
            );
        }
    }
}

/// Most damage is to values, which nothing can tell; what is told is told without a panic, in time
/// and within the memory that is allowed.
#[test]
fn draco_streams_with_wrong_bytes() {
    const ROUNDS: usize = 4_000;
    let mut state = 0x2545_F491_4F6C_DD1D;
    let (mut loaded, mut refused) = (0, 0);
    for round in 0..ROUNDS {
        let mut stream = [EDGEBREAKER, SEQUENTIAL][round % 2].to_vec();
        for _ in 0..=next(&mut state) % 3 {
            // The sizes are at the beginning.
            let within = [64, stream.len()][next(&mut state) % 2];
            let at = next(&mut state) % within;
            stream[at] = match next(&mut state) % 3 {
                0 => next(&mut state) as u8,
                1 => stream[at] ^ 1 << (next(&mut state) % 8),
                _ => [0, 255][next(&mut state) % 2],
            };
        }
        match load_bytes(&sheet(&stream).glb(), &small()) {
            Ok(_) => loaded += 1,
            Err(error) => {
                assert!(matches!(error.exit_status(), 3 | 6), "{error}");
                refused += 1;
            }
        }
    }
    println!("{loaded} streams decoded, {refused} were refused");
    assert!(
        loaded > ROUNDS / 20 && refused > ROUNDS / 20,
        "{loaded} {refused}"
    );
}

/// Streams of others, with symbols sorted by valence, seams and predictions of all kinds.
#[test]
fn draco_files_of_others_with_wrong_bytes() {
    const ROUNDS: usize = 400;
    let Some(corpus) = corpus() else {
        println!("NOT RUN: there is no corpus of models beside this checkout");
        return;
    };
    let folder = corpus.join("core/CesiumMilkTruck-glTF-Draco");
    let text = std::fs::read(folder.join("CesiumMilkTruck.gltf")).unwrap();
    let mut json: Value = serde_json::from_slice(&text).unwrap();
    let bin = std::fs::read(folder.join("0.bin")).unwrap();
    json["buffers"] = json!([{"byteLength": bin.len()}]);
    // Its picture is not beside the file that is made of it.
    for section in ["materials", "textures", "images", "samplers", "animations"] {
        json.as_object_mut().unwrap().remove(section);
    }
    for mesh in json["meshes"].as_array_mut().unwrap() {
        for primitive in mesh["primitives"].as_array_mut().unwrap() {
            primitive.as_object_mut().unwrap().remove("material");
        }
    }
    let whole = Asset { json, bin };
    whole.load();
    let mut state = 0x9E37_79B9_7F4A_7C15;
    let mut refused = 0;
    for _ in 0..ROUNDS {
        let mut asset = whole.clone();
        for _ in 0..=next(&mut state) % 3 {
            let at = next(&mut state) % asset.bin.len();
            asset.bin[at] ^= 1 << (next(&mut state) % 8);
        }
        let options = LoadOptions {
            max_memory: 256 << 20,
            ..LoadOptions::default()
        };
        if let Err(error) = load_bytes(&asset.glb(), &options) {
            assert!(matches!(error.exit_status(), 3 | 6), "{error}");
            refused += 1;
        }
    }
    assert!(refused > ROUNDS / 20 && refused < ROUNDS, "{refused}");
}

fn edited_sheet(edit: impl FnOnce(&mut Value)) -> Asset {
    let mut asset = sheet(EDGEBREAKER);
    edit(&mut asset.json);
    asset
}

#[test]
fn draco_streams_that_do_not_fit_their_accessors() {
    let extension = "/meshes/0/primitives/0/extensions/KHR_draco_mesh_compression";
    let unknown = edited_sheet(|json| {
        *json
            .pointer_mut(&format!("{extension}/attributes/NORMAL"))
            .unwrap() = json!(99);
    });
    invalid(
        &unknown,
        &format!("{DRACO}.attributes.NORMAL"),
        "no attribute with the id 99",
    );
    let unnamed = edited_sheet(|json| {
        json.pointer_mut(&format!("{extension}/attributes"))
            .unwrap()["TANGENT"] = json!(15);
    });
    invalid(
        &unnamed,
        "meshes[0].primitives[0].attributes",
        "`TANGENT` is missing",
    );
    let nowhere = edited_sheet(|json| {
        let object = json
            .pointer_mut(extension)
            .unwrap()
            .as_object_mut()
            .unwrap();
        object.remove("bufferView");
    });
    invalid(&nowhere, DRACO, "`bufferView` is missing");
    let fewer = edited_sheet(|json| json["accessors"][0]["count"] = json!(3 * TRIANGLES - 3));
    invalid(
        &fewer,
        DRACO,
        "72 triangles and the accessor of its indices 71",
    );
    let wider = edited_sheet(|json| json["accessors"][2]["type"] = json!("VEC2"));
    invalid(&wider, "accessors[2].type", "elements of 3 components");
    let narrower = edited_sheet(|json| json["accessors"][3]["componentType"] = json!(U8));
    invalid(
        &narrower,
        "accessors[3]",
        "its component type cannot hold 0.",
    );
    let strip = edited_sheet(|json| json["meshes"][0]["primitives"][0]["mode"] = json!(5));
    invalid(&strip, "meshes[0].primitives[0]", "not a list of triangles");
    // Beside an attribute of the stream, one of another length.
    let mut asset = sheet(EDGEBREAKER);
    let normals = asset.floats("VEC3", &[0.0, 0.0, 1.0].repeat(POINTS + 1));
    asset.primitive()["attributes"]["NORMAL"] = json!(normals);
    let ids = &mut asset.primitive()["extensions"]["KHR_draco_mesh_compression"]["attributes"];
    ids.as_object_mut().unwrap().remove("NORMAL");
    invalid(
        &asset,
        "meshes[0].primitives[0].attributes",
        "NORMAL has 57 elements and POSITION has 56",
    );
}

/// A stream that says it holds 2^31 triangles, and accessors that agree, take no memory.
#[test]
fn draco_streams_that_claim_the_moon() {
    const HEADER: usize = 11;
    let moon = [0x80, 0x80, 0x80, 0x80, 0x08];
    let claim = |stream: &[u8], place: std::ops::Range<usize>| {
        let mut stream = stream.to_vec();
        stream.splice(place, moon);
        let mut asset = sheet(&stream);
        asset.json["accessors"][0]["count"] = json!(3u64 << 31);
        asset
    };
    // After the kind of the traversal and the number of vertices; at once.
    for asset in [
        claim(EDGEBREAKER, HEADER + 2..HEADER + 3),
        claim(SEQUENTIAL, HEADER..HEADER + 1),
    ] {
        let result = load_bytes(&asset.glb(), &LoadOptions::default());
        expect(result.map(|_| ()), 6, DRACO, "bytes are needed");
    }
    // 2^31 points.
    let mut stream = SEQUENTIAL.to_vec();
    stream.splice(HEADER + 1..HEADER + 2, moon);
    let result = load_bytes(&sheet(&stream).glb(), &LoadOptions::default());
    expect(result.map(|_| ()), 6, DRACO, "bytes are needed");
}

#[cfg(feature = "meshopt")]
mod meshopt_views {
    use super::*;
    use crate::asset::{F32, TRIANGLE};

    const AT: &str = "bufferViews[1].extensions.EXT_meshopt_compression";

    /// A triangle whose positions are compressed.
    fn triangle(encoded: &[u8], edit: impl FnOnce(&mut Value)) -> Asset {
        let mut asset = Asset::triangle();
        let view = asset.view(encoded);
        let offset = asset.json["bufferViews"][view]["byteOffset"].clone();
        let mut extension = json!({"buffer": 0, "byteOffset": offset, "byteLength": encoded.len(),
            "byteStride": 12, "count": 3, "mode": "ATTRIBUTES"});
        edit(&mut extension);
        let number = |key: &str| extension[key].as_u64().unwrap_or(1);
        let length = number("byteStride").saturating_mul(number("count"));
        asset.json["bufferViews"][view] = json!({"buffer": 1, "byteLength": length,
            "extensions": {"EXT_meshopt_compression": extension}});
        let positions = asset.push(
            "accessors",
            json!({"bufferView": view, "componentType": F32,
            "type": "VEC3", "count": 3}),
        );
        asset.primitive()["attributes"]["POSITION"] = json!(positions);
        asset.bin.resize(asset.bin.len().next_multiple_of(4), 0);
        asset.json["buffers"] = json!([{"byteLength": asset.bin.len()}, {"byteLength": length}]);
        asset
    }

    fn encoded() -> Vec<u8> {
        let rows: Vec<[f32; 3]> = TRIANGLE.chunks(3).map(|p| [p[0], p[1], p[2]]).collect();
        ::meshopt::encode_vertex_buffer_level(&rows, 2, Some(0)).unwrap()
    }

    #[test]
    fn views_cut_short_or_damaged() {
        let whole = encoded();
        triangle(&whole, |_| ()).load();
        for length in 0..whole.len() {
            invalid(&triangle(&whole[..length], |_| ()), AT, "damaged");
        }
        for at in 0..whole.len() {
            for bit in 0..8 {
                let mut bytes = whole.clone();
                bytes[at] ^= 1 << bit;
                let _ = triangle(&bytes, |_| ()).try_load();
            }
        }
    }

    #[test]
    fn layouts_that_cannot_be() {
        let with = |key: &str, value: Value| triangle(&encoded(), |json| json[key] = value);
        let wide = format!("{AT}.byteStride");
        invalid(&with("byteStride", json!(260)), &wide, "260 is no stride");
        invalid(&with("byteStride", json!(6)), &wide, "6 is no stride");
        invalid(&with("byteStride", json!(0)), &wide, "0 is no stride");
        invalid(
            &with("mode", json!("MAGIC")),
            &format!("{AT}.mode"),
            "none of ATTRIBUTES",
        );
        invalid(&with("filter", json!("SEPIA")), AT, "no filter SEPIA");
        invalid(
            &with("filter", json!("QUATERNION")),
            &wide,
            "filter Quaternion",
        );
        invalid(&with("filter", json!("COLOR")), &wide, "filter Color");
        invalid(
            &with("buffer", json!(7)),
            &format!("{AT}.buffer"),
            "out of range",
        );
        invalid(&with("buffer", json!(1)), "buffers[1]", "no uri");
        invalid(&with("byteLength", json!(1 << 20)), AT, "do not fit");
        invalid(&with("count", json!(u64::MAX)), AT, "are not the");
        let indices = |count: u64, filter: &str| {
            triangle(&encoded(), |json| {
                json["mode"] = json!("TRIANGLES");
                json["byteStride"] = json!(4);
                json["count"] = json!(count);
                json["filter"] = json!(filter);
            })
        };
        invalid(&indices(4, "NONE"), AT, "4 indices are no whole triangles");
        invalid(&indices(3, "OCTAHEDRAL"), AT, "have no filter");
        let mut shorter = triangle(&encoded(), |_| ());
        shorter.json["bufferViews"][1]["byteLength"] = json!(35);
        invalid(&shorter, AT, "3 elements of 12 bytes are not the 35 bytes");
    }

    #[test]
    fn counts_beyond_the_memory_that_is_allowed() {
        let asset = triangle(&encoded(), |json| json["count"] = json!(1u64 << 40));
        expect(asset.try_load().map(|_| ()), 6, AT, "bytes are needed");
    }
}
