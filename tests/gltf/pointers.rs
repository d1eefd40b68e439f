//! KHR_animation_pointer: properties of every kind, driven.

use crate::animation::{at, open};
use crate::asset::{Asset, U8, pixel_png};
use crate::{assert_close, noted, only};
use glam::Vec3;
use serde_json::{Value, json};
use snell::gltf::{GltfError, Loaded, Moment};
use snell::scene::{Model, Projection, PunctualKind};

/// A scene with a camera, a light, and a textured material; a file of one animation for each pointer.
fn stage() -> Asset {
    let mut asset = Asset::triangle();
    let texture = asset.texture(&pixel_png([255; 4]));
    let mut asset = asset.with_material(json!({
        "alphaMode": "MASK",
        "pbrMetallicRoughness": {"baseColorTexture": {"index": texture,
            "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}}},
        "extensions": {"KHR_materials_clearcoat": {}}
    }));
    let up = asset.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    asset.primitive()["targets"] = json!([{"POSITION": up}, {"POSITION": up}]);
    asset.json["meshes"][0]["weights"] = json!([1, 2]);
    asset.json["cameras"] =
        json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]);
    asset.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "spot"}]}});
    asset.json["nodes"] = json!([
        {"mesh": 0, "camera": 0},
        {"extensions": {"KHR_lights_punctual": {"light": 0}, "KHR_node_visibility": {}}},
    ]);
    asset.json["scenes"][0]["nodes"] = json!([0, 1]);
    asset
}

/// Two keys at 0 and 1 s on a pointer, with equal values where there is only one.
fn drive(asset: &mut Asset, pointer: &str, kind: &str, values: &[f32], interpolation: &str) {
    let input = asset.floats("SCALAR", &[0.0, 1.0]);
    let output = asset.floats(kind, values);
    asset.push("animations", driven(pointer, input, output, interpolation));
}

pub fn driven(pointer: &str, input: usize, output: usize, interpolation: &str) -> Value {
    json!({
        "channels": [{"sampler": 0, "target": {"path": "pointer",
            "extensions": {"KHR_animation_pointer": {"pointer": pointer}}}}],
        "samplers": [{"input": input, "output": output, "interpolation": interpolation}],
    })
}

fn halfway(pointer: &str, kind: &str, values: &[f32]) -> Loaded {
    let mut asset = stage();
    drive(&mut asset, pointer, kind, values, "LINEAR");
    at(&mut open(&asset), 0.5)
}

#[test]
fn nodes_cameras_and_lights() {
    let loaded = halfway(
        "/nodes/0/translation",
        "VEC3",
        &[0.0, 0.0, 0.0, 2.0, 4.0, 6.0],
    );
    assert_close(
        loaded.scene.instances[0].world_from_object.translation,
        [1.0, 2.0, 3.0],
    );
    let loaded = halfway(
        "/nodes/0/rotation",
        "VEC4",
        &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0],
    );
    let matrix = loaded.scene.instances[0].world_from_object;
    assert_close(matrix.transform_vector3(Vec3::X), Vec3::Y);
    let loaded = halfway("/nodes/0/weights", "SCALAR", &[0.0, 0.0, 4.0, 2.0]);
    assert_close(only(&loaded).positions[0], [0.0, 0.0, 3.0]);
    // One weight: the other stays the mesh's.
    let loaded = halfway("/nodes/0/weights/0", "SCALAR", &[0.0, 8.0]);
    assert_close(only(&loaded).positions[0], [0.0, 0.0, 6.0]);

    let loaded = halfway("/cameras/0/perspective/yfov", "SCALAR", &[1.0, 2.0]);
    let Projection::Perspective { yfov, .. } = loaded.scene.cameras[0].projection else {
        panic!("another camera");
    };
    assert_eq!(yfov, 1.5);
    let lights = "/extensions/KHR_lights_punctual/lights/0";
    let loaded = halfway(
        &format!("{lights}/color"),
        "VEC3",
        &[0.0, 0.0, 0.0, 1.0, 0.5, 0.0],
    );
    assert_close(loaded.scene.lights[0].intensity, [0.5, 0.25, 0.0]);
    // The light has no `spot` yet.
    let loaded = halfway(
        &format!("{lights}/spot/outerConeAngle"),
        "SCALAR",
        &[0.2, 0.4],
    );
    let PunctualKind::Spot { outer_angle, .. } = loaded.scene.lights[0].kind else {
        panic!("another light");
    };
    assert!((outer_angle - 0.3).abs() < 1e-6);
}

#[test]
fn materials_and_texture_transforms() {
    let base = "/materials/0/pbrMetallicRoughness";
    let model = |loaded: &Loaded| match &loaded.scene.materials[0].model {
        Model::MetallicRoughness(model) => model.clone(),
        _ => panic!("another model"),
    };
    let color = [0.0, 0.0, 0.0, 0.0, 1.0, 0.5, 0.25, 1.0];
    let loaded = halfway(&format!("{base}/baseColorFactor"), "VEC4", &color);
    assert_eq!(
        model(&loaded).base_color.to_array(),
        [0.5, 0.25, 0.125, 0.5]
    );
    let loaded = halfway(&format!("{base}/roughnessFactor"), "SCALAR", &[0.0, 0.5]);
    assert_eq!(model(&loaded).roughness, 0.25);
    let loaded = halfway(
        "/materials/0/emissiveFactor",
        "VEC3",
        &[0.0, 0.0, 0.0, 1.0, 1.0, 0.0],
    );
    assert_close(loaded.scene.materials[0].emissive, [0.5, 0.5, 0.0]);
    let coat = "/materials/0/extensions/KHR_materials_clearcoat/clearcoatFactor";
    let loaded = halfway(coat, "SCALAR", &[0.0, 1.0]);
    assert_eq!(model(&loaded).extensions.clearcoat.coat.factor, 0.5);
    let ior = "/materials/0/extensions/KHR_materials_ior/ior";
    assert_eq!(model(&halfway(ior, "SCALAR", &[1.0, 2.0])).ior, 1.5);
    let transform = format!("{base}/baseColorTexture/extensions/KHR_texture_transform");
    let loaded = halfway(
        &format!("{transform}/offset"),
        "VEC2",
        &[0.0, 0.0, 1.0, 0.5],
    );
    let rows = model(&loaded).base_color_texture.unwrap().rows;
    assert_close(rows[0], [2.0, 0.0, 0.5]);
    assert_close(rows[1], [0.0, 2.0, 0.25]);
}

#[test]
fn truth_is_animated_by_steps() {
    let visible = "/nodes/1/extensions/KHR_node_visibility/visible";
    let mut asset = stage();
    let input = asset.floats("SCALAR", &[0.0, 1.0]);
    let output = asset.accessor(U8, "SCALAR", 2, &[0, 1]);
    asset.push("animations", driven(visible, input, output, "STEP"));
    let mut file = open(&asset);
    let mut lights = |seconds| at(&mut file, seconds).scene.lights.len();
    assert_eq!([lights(0.9), lights(1.0)], [0, 1]);
    assert_eq!(file.scene(&Moment::Rest).unwrap().scene.lights.len(), 1);
}

#[test]
fn what_no_picture_depends_on_is_noted() {
    let mut asset = stage();
    drive(
        &mut asset,
        "/materials/0/occlusionTexture/strength",
        "SCALAR",
        &[0.0, 1.0],
        "LINEAR",
    );
    drive(
        &mut asset,
        "/nodes/0/extras/height",
        "SCALAR",
        &[0.0, 1.0],
        "LINEAR",
    );
    drive(
        &mut asset,
        "/materials/0/normalTexture/extensions/KHR_texture_transform/rotation",
        "SCALAR",
        &[0.0, 1.0],
        "LINEAR",
    );
    let loaded = at(&mut open(&asset), 0.5);
    assert!(noted(
        &loaded,
        "/nodes/0/extras/height` is animated and no part of the picture"
    ));
    assert!(
        noted(&loaded, "a texture that is not there"),
        "{:?}",
        loaded.notes
    );
    assert_eq!(loaded.notes.len(), 2, "{:?}", loaded.notes);
}

/// A normal map's transform turns the tangents that are made for it.
#[test]
fn tangents_follow_an_animated_texture() {
    let mut asset = Asset::triangle();
    let texture = asset.texture(&pixel_png([128, 128, 255, 255]));
    let mut asset = asset.with_material(json!({"normalTexture": {"index": texture,
        "extensions": {"KHR_texture_transform": {}}}}));
    let normals = asset.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    asset.primitive()["attributes"]["NORMAL"] = json!(normals);
    let pointer = "/materials/0/normalTexture/extensions/KHR_texture_transform/rotation";
    let turn = std::f32::consts::PI;
    drive(&mut asset, pointer, "SCALAR", &[0.0, turn], "LINEAR");
    let mut file = open(&asset);
    let mut tangent = |seconds| {
        let loaded = at(&mut file, seconds);
        only(&loaded).tangents.as_ref().unwrap()[0].truncate()
    };
    let (before, after) = (tangent(0.0), tangent(1.0));
    assert_close(before, -after);
}

#[test]
fn pointers_that_lead_nowhere() {
    let error = |pointer: &str, kind: &str, values: &[f32], interpolation: &str| -> GltfError {
        let mut asset = stage();
        drive(&mut asset, pointer, kind, values, interpolation);
        asset.try_load().map(|_| ()).unwrap_err()
    };
    let target = "animations[0].channels[0].target.extensions.KHR_animation_pointer.pointer";
    for (pointer, words) in [
        ("nodes/0/translation", "no JSON pointer"),
        ("", "no JSON pointer"),
        ("/nodes/0~2/translation", "no JSON pointer"),
        ("/nodes/7/translation", "there are 2 elements"),
        ("/nodes/01/translation", "out of range"),
        ("/nodes/0/weights/2", "there are 2 targets"),
        ("/meshes/0/primitives/3/material", "out of range"),
        (
            "/scenes/0/nodes/0/translation",
            "leads through what is no object",
        ),
        ("/extensions/KHR_lights/lights/0/color", "leads nowhere"),
    ] {
        let error = error(pointer, "VEC3", &[0.0; 6], "LINEAR");
        assert_eq!(
            (error.exit_status(), error.at()),
            (3, target),
            "{pointer}: {error}"
        );
        assert!(error.to_string().contains(words), "{error}");
    }
    let visible = "/nodes/1/extensions/KHR_node_visibility/visible";
    let wrong = error(visible, "SCALAR", &[0.0, 1.0], "LINEAR");
    assert_eq!(wrong.at(), "animations[0].samplers[0]", "{wrong}");
    let wrong = error("/nodes/0/translation", "SCALAR", &[0.0, 1.0], "LINEAR").to_string();
    assert!(wrong.contains("it is SCALAR where VEC3 belongs"), "{wrong}");
}

#[test]
fn lamps_and_light_from_images() {
    let text = crate::ies::ies(1, &[0.0, 90.0], &[0.0], |_, _| 1.0);
    let mut asset = crate::ies::lamp(&text, json!({"multiplier": 7}), json!({}));
    let multiplier = "/nodes/1/extensions/EXT_lights_ies/multiplier";
    drive(&mut asset, multiplier, "SCALAR", &[2.0, 4.0], "LINEAR");
    let loaded = at(&mut open(&asset), 0.5);
    assert_close(loaded.scene.lights[0].intensity, [3.0; 3]);

    let mut asset = crate::image_based::lit_by(&crate::image_based::faces(), json!({}));
    let light = "/extensions/EXT_lights_image_based/lights/0";
    let intensity = format!("{light}/intensity");
    drive(&mut asset, &intensity, "SCALAR", &[2.0, 4.0], "LINEAR");
    let half_turn = [0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0];
    drive(
        &mut asset,
        &format!("{light}/rotation"),
        "VEC4",
        &half_turn,
        "LINEAR",
    );
    let mut file = open(&asset);
    let mut environment = |seconds| at(&mut file, seconds).scene.environment.unwrap();
    let (before, after) = (environment(0.0), environment(1.0));
    assert_eq!((before.strength, after.strength), (2.0, 4.0));
    // Half a turn about +y is half a row of the map.
    let (width, row) = (before.width as usize, before.height as usize / 2);
    let texel = |x: usize| row * width + x;
    for x in [0, 3, width / 3] {
        let a = Vec3::from(before.radiance[texel(x)]);
        let b = Vec3::from(after.radiance[texel((x + width / 2) % width)]);
        assert!((a - b).length() < 0.02, "{a} is not {b}");
        let unturned = Vec3::from(after.radiance[texel(x)]);
        assert!(
            (a - unturned).length() > 0.02,
            "{a} is {unturned}, unturned"
        );
    }
}
