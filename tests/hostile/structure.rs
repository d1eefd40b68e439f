//! Indices, sizes and types of the JSON.

use crate::asset::{Asset, U8, load_bytes};
use crate::{edited, expect, invalid};
use serde_json::{Value, json};
use snell::gltf::LoadOptions;

#[cfg(not(feature = "basisu"))]
#[test]
fn required_extensions_that_this_build_left_out() {
    let name = "KHR_texture_basisu";
    let asset = edited(|json| json["extensionsRequired"] = json!([name]));
    let result = asset.try_load().map(|_| ());
    expect(
        result,
        4,
        "extensionsRequired[0]",
        "the cargo feature `basisu`",
    );
}

#[test]
fn required_extensions_that_are_not_known() {
    for name in ["VENDOR_magic", "EXT_texture_avif"] {
        let asset = edited(|json| json["extensionsRequired"] = json!(["KHR_materials_ior", name]));
        let result = asset.try_load().map(|_| ());
        expect(result, 4, "extensionsRequired[1]", name);
    }
}

#[test]
fn references_out_of_range() {
    let cases: [(&str, &str); 8] = [
        ("/scene", "scene"),
        ("/scenes/0/nodes/0", "scenes[0].nodes[0]"),
        ("/nodes/0/mesh", "nodes[0].mesh"),
        ("/nodes/0/camera", "nodes[0].camera"),
        ("/nodes/0/skin", "nodes[0].skin"),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            "meshes[0].primitives[0].attributes.POSITION",
        ),
        ("/accessors/0/bufferView", "accessors[0].bufferView"),
        ("/bufferViews/0/buffer", "bufferViews[0].buffer"),
    ];
    for (pointer, at) in cases {
        // 2^32 must not turn into 0.
        for index in [json!(7), json!(u64::MAX), json!(1u64 << 32)] {
            let asset = edited(|json| {
                json["nodes"][0]["camera"] = json!(0);
                json["nodes"][0]["skin"] = json!(0);
                json["cameras"] = json!([{"type": "orthographic",
                    "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 1}}]);
                json["skins"] = json!([{"joints": [0]}]);
                json["scene"] = json!(0);
                *json.pointer_mut(pointer).unwrap() = index;
            });
            invalid(&asset, at, "out of range");
        }
        for index in [json!(-1), json!(0.5), json!("0"), json!(null), json!([])] {
            let asset = edited(|json| {
                json["nodes"][0]["camera"] = json!(0);
                json["nodes"][0]["skin"] = json!(0);
                json["cameras"] = json!([{"type": "orthographic",
                    "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 1}}]);
                json["skins"] = json!([{"joints": [0]}]);
                json["scene"] = json!(0);
                *json.pointer_mut(pointer).unwrap() = index;
            });
            invalid(&asset, at, "not a non-negative integer");
        }
    }
}

#[test]
fn vertex_indices_out_of_range() {
    let mut asset = Asset::triangle();
    let indices = asset.accessor(U8, "SCALAR", 3, &[0, 1, 3]);
    asset.primitive()["indices"] = json!(indices);
    invalid(
        &asset,
        "meshes[0].primitives[0]",
        "index 3 (number 2 of its indices) is out of range",
    );
}

#[test]
fn cycles_and_second_parents() {
    let cycle = |nodes: Value| edited(|json| json["nodes"] = nodes);
    invalid(
        &cycle(json!([{"children": [0], "mesh": 0}])),
        "nodes[0]",
        "cycle",
    );
    invalid(
        &cycle(json!([{"children": [1]}, {"children": [2]}, {"children": [0]}])),
        "nodes[0]",
        "cycle",
    );
    let twice = json!([{"children": [2]}, {"children": [2]}, {"mesh": 0}]);
    invalid(&cycle(twice), "nodes[1].children[0]", "child of both");
    invalid(
        &cycle(json!([{"children": [1, 1]}, {}])),
        "nodes[0].children[1]",
        "child of both",
    );
    // A chain far deeper than a stack is no trouble.
    let mut chain: Vec<Value> = (1..50_000)
        .map(|next| json!({"children": [next]}))
        .collect();
    chain.push(json!({"mesh": 0}));
    assert_eq!(cycle(json!(chain)).load().scene.instances.len(), 1);
    let mut deep = "[".repeat(100_000);
    deep.push_str(&"]".repeat(100_000));
    let error = load_bytes(
        format!("{{\"a\":{deep}}}").as_bytes(),
        &LoadOptions::default(),
    );
    assert_eq!(error.unwrap_err().exit_status(), 3);
}

#[test]
fn sizes_that_are_not_there() {
    let at = "accessors[0]";
    for count in [4u64, 1 << 40, u64::MAX] {
        invalid(
            &edited(|json| json["accessors"][0]["count"] = json!(count)),
            at,
            "do not fit",
        );
    }
    let offset = edited(|json| json["accessors"][0]["byteOffset"] = json!(u64::MAX));
    invalid(&offset, at, "do not fit");
    let at = "bufferViews[0]";
    for (key, value) in [
        ("byteLength", 37),
        ("byteOffset", 1),
        ("byteOffset", u64::MAX),
    ] {
        invalid(
            &edited(|json| json["bufferViews"][0][key] = json!(value)),
            at,
            "do not fit",
        );
    }
    invalid(
        &edited(|json| json["bufferViews"][0]["byteStride"] = json!(4)),
        "accessors[0]",
        "byteStride",
    );
    invalid(
        &edited(|json| json["bufferViews"][0]["byteStride"] = json!(400)),
        at,
        "252",
    );
    let buffer = edited(|json| json["buffers"] = json!([{"byteLength": 1u64 << 50}]));
    invalid(&buffer, "buffers[0]", "only 36 bytes");
    let second = edited(|json| {
        json["buffers"] = json!([{"byteLength": 36}, {"byteLength": 36}]);
        json["bufferViews"][0]["buffer"] = json!(1);
    });
    invalid(&second, "buffers[1]", "no uri");
}

#[test]
fn counts_without_data_are_paid_for_first() {
    for count in [1u64 << 34, u64::MAX / 12, u64::MAX] {
        let asset = edited(|json| {
            json["accessors"][0] = json!({"componentType": 5126, "type": "VEC3", "count": count});
        });
        expect(
            asset.try_load().map(|_| ()),
            6,
            "accessors[0]",
            "--max-memory",
        );
    }
}

#[test]
fn sparse_accessors_that_lie() {
    let sparse = |sparse: Value| {
        let mut asset = Asset::triangle();
        asset.view(&[7, 0, 0, 0]);
        asset.json["accessors"][0]["sparse"] = sparse;
        asset
    };
    let indices = json!({"bufferView": 1, "componentType": U8});
    let values = json!({"bufferView": 0});
    let of = |count: u64| json!({"count": count, "indices": indices, "values": values});
    invalid(
        &sparse(of(u64::MAX)),
        "accessors[0].sparse",
        "more than the 3",
    );
    invalid(
        &sparse(of(1)),
        "accessors[0].sparse.indices",
        "index 7 is out of range",
    );
    invalid(
        &sparse(json!({"count": 1, "values": values})),
        "accessors[0].sparse",
        "`indices`",
    );
    invalid(
        &sparse(json!({"count": 1, "indices": indices})),
        "accessors[0].sparse",
        "`values`",
    );
    let floats = json!({"bufferView": 1, "componentType": 5126});
    let floats = json!({"count": 1, "indices": floats, "values": values});
    invalid(&sparse(floats), "accessors[0].sparse.indices", "unsigned");
    let short = json!({"count": 3, "indices": indices, "values": {"bufferView": 1}});
    invalid(&sparse(short), "accessors[0].sparse.values", "do not fit");
}

#[test]
fn types_that_do_not_belong() {
    let accessor = |key: &str, value: Value| edited(|json| json["accessors"][0][key] = value);
    invalid(
        &accessor("componentType", json!(5124)),
        "accessors[0].componentType",
        "none of",
    );
    invalid(
        &accessor("type", json!("VEC9")),
        "accessors[0].type",
        "VEC3 belongs",
    );
    invalid(
        &accessor("type", json!(3)),
        "accessors[0].type",
        "not a string",
    );
    invalid(
        &accessor("normalized", json!(1)),
        "accessors[0].normalized",
        "true or false",
    );
    invalid(
        &edited(|json| json["nodes"] = json!({})),
        "nodes",
        "not an array",
    );
    invalid(
        &edited(|json| json["nodes"] = json!([3])),
        "nodes[0]",
        "not an object",
    );
    invalid(
        &edited(|json| json["meshes"] = json!([[]])),
        "meshes[0]",
        "not an object",
    );
    invalid(
        &edited(|json| json["nodes"][0]["scale"] = json!([1, 2])),
        "nodes[0].scale",
        "2 numbers where 3",
    );
    invalid(
        &edited(|json| json["nodes"][0]["matrix"] = json!([1e300])),
        "nodes[0].matrix[0]",
        "32-bit",
    );
    invalid(
        &edited(|json| json["meshes"][0]["primitives"][0]["mode"] = json!(7)),
        "meshes[0].primitives[0]",
        "mode",
    );
    // 3.0 is an integer in JSON.
    assert!(accessor("count", json!(3.0)).try_load().is_ok());
}
