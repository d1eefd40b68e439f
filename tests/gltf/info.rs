//! `snell info`: what it prints and how it ends.

use crate::asset::{Asset, pixel_png};
use crate::json_schema::validate;
use serde_json::{Value, json};
use std::path::Path;
use std::process::{Command, Output};

fn info(path: &Path, more: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_snell"));
    command.arg("info").arg(path).args(more).output().unwrap()
}

#[test]
fn text_and_json() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.glb");
    let mut asset = Asset::triangle().with_material(json!({
        "name": "paint", "extensions": {"KHR_materials_retroreflection": {}}
    }));
    asset.json["extensionsUsed"] = json!(["VENDOR_named"]);
    asset.push("animations", json!({"channels": [], "samplers": []}));
    asset.save_glb(&path);
    let output = info(&path, &[]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success() && output.stderr.is_empty());
    for words in [
        "1 triangles in 1 instances",
        "KHR_materials_retroreflection, ignored, not declared: light is not sent back to where it came from (materials[0].extensions)",
        "VENDOR_named, ignored, declared and not used: it is not known\n",
        "no animation is played",
    ] {
        assert!(text.contains(words), "{text}");
    }
    let output = info(&path, &["--json"]);
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    check_schema(&json);
    assert_eq!(json["counts"]["drawn_triangles"], 1);
    assert_eq!(json["bounds"], json!([[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]]));
    assert_eq!(json["materials"], json!(["paint"]));
    assert_eq!(json["extensions"][0]["treatment"], "ignored");
    assert_eq!(
        (&json["default_camera"], &json["default_light"]),
        (&json!(true), &json!(true))
    );
}

fn check_schema(info: &Value) {
    let schema = std::fs::read("schema/info.schema.json").unwrap();
    let schema: Value = serde_json::from_slice(&schema).unwrap();
    validate(&schema, &schema, info).unwrap();
}

/// Everything that a listing has a row for.
#[test]
fn contents_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.glb");
    let mut asset = Asset::triangle();
    let texture = asset.texture(&pixel_png([10, 20, 30, 40]));
    let mut asset = asset.with_material(json!({
        "name": "paint", "pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}
    }));
    asset.json["cameras"] = json!([{
        "name": "front", "type": "orthographic",
        "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 1}
    }]);
    asset.json["nodes"] = json!([
        {"mesh": 0}, {"camera": 0},
        {"extensions": {"KHR_lights_punctual": {"light": 0}}}
    ]);
    asset.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    asset.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    asset.json["extensions"] = json!({
        "KHR_lights_punctual": {"lights": [{"name": "bulb", "type": "point"}]}
    });
    asset.json["skins"] = json!([{"name": "bones", "joints": [0, 1]}]);
    asset.save_glb(&path);
    let text = String::from_utf8(info(&path, &[]).stdout).unwrap();
    for line in [
        "  camera      front, orthographic\n",
        "  light       bulb, point\n",
        "  skin        bones, 2 joints\n",
        ", PNG, 1 x 1, 8 bits\n",
        "  extension   KHR_lights_punctual, supported (extensions, nodes[2].extensions)\n",
    ] {
        assert!(text.contains(line), "{text}");
    }
    let json: Value = serde_json::from_slice(&info(&path, &["--json"]).stdout).unwrap();
    check_schema(&json);
    assert_eq!(json["skins"], json!([{"name": "bones", "joints": 2}]));
    assert_eq!(json["images"][0]["format"], "PNG");
}

#[test]
fn exit_statuses() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.glb");
    let end = |asset: &Asset, more: &[&str]| {
        asset.save_glb(&path);
        let output = info(&path, more);
        assert!(output.stdout.is_empty());
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(text.lines().count(), 1, "{text}");
        (output.status.code().unwrap(), text)
    };
    let mut asset = Asset::triangle();
    assert_eq!(end(&asset, &["--max-memory", "0"]).0, 6);
    asset.json["accessors"][0]["bufferView"] = json!(4);
    let (status, text) = end(&asset, &[]);
    assert_eq!(status, 3);
    assert!(
        text.contains("scene.glb: accessors[0].bufferView: 4 is out of range"),
        "{text}"
    );
    asset.json["extensionsRequired"] = json!(["VENDOR_magic"]);
    let (status, text) = end(&asset, &[]);
    assert_eq!(status, 4);
    assert!(
        text.contains("VENDOR_magic is required and not supported"),
        "{text}"
    );
}
