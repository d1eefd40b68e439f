//! What nodes place: meshes, cameras, lights; poses at rest; the list of extensions.

use crate::asset::{Asset, U8};
use crate::{assert_close, noted, only};
use glam::Vec3;
use serde_json::json;
use snell::gltf::Treatment;
use snell::scene::{Projection, PunctualKind};

#[test]
fn hierarchies_place_instances() {
    let mut asset = Asset::triangle();
    asset.json["nodes"] = json!([
        {"children": [1, 2], "translation": [1, 2, 3],
         "rotation": [0, 0, std::f32::consts::FRAC_1_SQRT_2, std::f32::consts::FRAC_1_SQRT_2],
         "scale": [2, 2, 2]},
        {"mesh": 0, "translation": [1, 0, 0], "name": "leaf"},
        {"mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 0, 0, 1]},
        {"mesh": 0, "name": "of no scene"},
        {"mesh": 0, "scale": [0, 0, 0]},
    ]);
    asset.json["scenes"] = json!([{"nodes": [3]}, {"nodes": [0, 4]}]);
    asset.json["scene"] = json!(1);
    let loaded = asset.load();
    let instances = &loaded.scene.instances;
    assert_eq!(instances.len(), 2);
    assert!(noted(&loaded, "scaled to nothing"));
    // One mesh for both: instances share it.
    assert_eq!((loaded.scene.meshes.len(), instances[1].mesh), (1, 0));
    assert_eq!(instances[0].node, 1);
    let at = |i: usize, p: Vec3| instances[i].world_from_object.transform_point3(p);
    assert_close(at(0, Vec3::ZERO), [1.0, 4.0, 3.0]);
    assert_close(at(0, Vec3::X), [1.0, 6.0, 3.0]);
    assert_close(at(1, Vec3::X), [1.0, 10.0, 3.0]);
    assert!(instances[1].world_from_object.matrix3.determinant() < 0.0);
    // Without `scene` the first is drawn; without scenes every root.
    asset.json.as_object_mut().unwrap().remove("scene");
    assert_eq!(asset.load().scene.instances[0].node, 3);
    asset.json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(asset.load().scene.instances.len(), 3);
    // A scene may be empty.
    asset.json["scenes"] = json!([{}]);
    assert!(asset.load().scene.instances.is_empty());
}

#[test]
fn cameras_of_both_kinds() {
    let mut asset = Asset::triangle();
    asset.json["cameras"] = json!([
        {"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1, "aspectRatio": 1.5}},
        {"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 3, "znear": 0, "zfar": 9}},
        {"type": "perspective", "perspective": {"yfov": 1, "znear": 1}},
    ]);
    asset.json["nodes"] = json!([
        {"mesh": 0},
        {"camera": 0, "translation": [0, 0, 5], "scale": [3, 3, -3], "name": "front"},
        {"camera": 1},
    ]);
    asset.json["scenes"] = json!([{"nodes": [0, 1, 2]}]);
    let cameras = asset.load().scene.cameras;
    assert_eq!(cameras.len(), 2, "camera 2 is placed by no node");
    assert_eq!(cameras[0].name, "front");
    let (yfov, aspect, near) = (0.5, Some(1.5), 0.1);
    assert_eq!(
        cameras[0].projection,
        Projection::Perspective { yfov, aspect, near }
    );
    let (xmag, ymag, near) = (2.0, 3.0, 0.0);
    assert_eq!(
        cameras[1].projection,
        Projection::Orthographic { xmag, ymag, near }
    );
    // Scale is no part of a camera; a flipped z turns it around.
    let matrix = cameras[0].world_from_camera;
    assert_close(matrix.transform_vector3(Vec3::NEG_Z), Vec3::Z);
    assert_close(matrix.transform_vector3(Vec3::Y), Vec3::Y);
    assert!((matrix.matrix3.determinant() - 1.0).abs() < 1e-6);
}

#[test]
fn punctual_lights() {
    let mut asset = Asset::triangle();
    asset.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [
        {"type": "spot", "color": [1, 0.5, 0], "intensity": 20, "range": 7, "name": "lamp",
         "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.2}},
        {"type": "point"},
        {"type": "directional", "intensity": 3},
    ]}});
    asset.json["nodes"] = json!([
        {"mesh": 0, "children": [1, 2, 3]},
        {"translation": [1, 2, 3], "scale": [5, 5, 5],
         "rotation": [0, std::f32::consts::FRAC_1_SQRT_2, 0, std::f32::consts::FRAC_1_SQRT_2],
         "extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"extensions": {"KHR_lights_punctual": {"light": 1}}},
        {"extensions": {"KHR_lights_punctual": {"light": 2}}},
    ]);
    let loaded = asset.load();
    let lights = &loaded.scene.lights;
    assert_eq!(lights[0].name, "lamp");
    let (inner_angle, outer_angle) = (0.1, 0.2);
    assert_eq!(
        lights[0].kind,
        PunctualKind::Spot {
            inner_angle,
            outer_angle
        }
    );
    assert_close(lights[0].intensity, [20.0, 10.0, 0.0]);
    assert_eq!(lights[0].range, Some(7.0));
    assert_close(lights[0].position, [1.0, 2.0, 3.0]);
    assert_close(lights[0].direction, Vec3::NEG_X);
    assert_eq!(
        (lights[1].kind, lights[1].range),
        (PunctualKind::Point, None)
    );
    assert_close(lights[2].direction, Vec3::NEG_Z);
    assert_close(lights[2].intensity, [3.0; 3]);
    assert!(loaded.scene.environment.is_none() && !loaded.default_light);
}

#[test]
fn extensions_are_listed() {
    let mut asset = Asset::triangle();
    asset.json["extensionsUsed"] = json!(["KHR_materials_clearcoat", "VENDOR_thing"]);
    asset.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    asset.json["nodes"][0]["extensions"] = json!({"VENDOR_other": {}});
    asset.json["meshes"][0]["extensions"] =
        json!({"VENDOR_other": {"extensions": {"VENDOR_in": {}}}});
    for _ in 0..20 {
        asset.push("samplers", json!({"extensions": {"VENDOR_thing": {}}}));
    }
    let loaded = asset.load();
    let entries: Vec<_> = loaded
        .extensions
        .iter()
        .map(|e| (e.name.as_str(), e.declared, e.required, e.treatment, e.uses))
        .collect();
    let (supported, ignored) = (Treatment::Supported, Treatment::Ignored);
    assert_eq!(
        entries,
        [
            ("KHR_materials_clearcoat", true, false, supported, 0),
            ("KHR_mesh_quantization", false, true, supported, 0),
            ("VENDOR_in", false, false, ignored, 1),
            ("VENDOR_other", false, false, ignored, 2),
            ("VENDOR_thing", true, false, ignored, 20),
        ]
    );
    let other = &loaded.extensions[3];
    assert_eq!(
        other.places,
        ["meshes[0].extensions", "nodes[0].extensions"]
    );
    assert_eq!(
        loaded.extensions[2].places,
        ["meshes[0].extensions.VENDOR_other.extensions"]
    );
    let thing = &loaded.extensions[4];
    assert_eq!(thing.places.len(), 16);
    assert_eq!(thing.places[15], "samplers[15].extensions");
    let text = thing.places_text(2);
    assert_eq!(
        text,
        "samplers[0].extensions, samplers[1].extensions and 18 more"
    );
    let missed: Vec<bool> = loaded.extensions.iter().map(|e| e.is_missed()).collect();
    assert_eq!(missed, [false, false, true, true, true]);
}

#[test]
fn morph_targets_rest_at_their_weights() {
    let mut asset = Asset::triangle();
    let deltas = asset.floats("VEC3", &[0.0, 0.0, 4.0].repeat(3));
    let sideways = asset.floats("VEC3", &[1.0, 0.0, 0.0].repeat(3));
    asset.primitive()["targets"] = json!([{"POSITION": deltas}, {"POSITION": sideways}]);
    asset.json["meshes"][0]["weights"] = json!([0.5, 0]);
    asset.json["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "weights": [0, 1]}, {"mesh": 0}]);
    asset.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let scene = asset.load().scene;
    assert_eq!(scene.meshes.len(), 2, "one for each pose");
    let first = |i: usize| scene.meshes[scene.instances[i].mesh].primitives[0].positions[0];
    assert_close(first(0), [0.0, 0.0, 2.0]);
    assert_close(first(1), [1.0, 0.0, 0.0]);
    assert_close(first(2), [0.0, 0.0, 2.0]);
}

#[test]
fn skins_rest_where_their_joints_are() {
    let mut asset = Asset::triangle();
    let normals = asset.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let joints = asset.accessor(U8, "VEC4", 3, &[0, 1, 0, 0].repeat(3));
    // The second vertex follows both joints, its weights not of sum 1; the third follows none.
    let weights = [1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let weights = asset.floats("VEC4", &weights);
    let mut inverse = glam::Mat4::IDENTITY.to_cols_array().to_vec();
    inverse.extend(glam::Mat4::from_translation(Vec3::NEG_X).to_cols_array());
    let inverse = asset.floats("MAT4", &inverse);
    let attributes = &mut asset.primitive()["attributes"];
    attributes["JOINTS_0"] = json!(joints);
    attributes["WEIGHTS_0"] = json!(weights);
    attributes["NORMAL"] = json!(normals);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    asset.json["nodes"] = json!([
        // Its own place does not count.
        {"mesh": 0, "skin": 0, "translation": [100, 0, 0]},
        {"translation": [0, 0, 2], "children": [2]},
        {"translation": [1, 0, 0], "rotation": [half, 0, 0, half]},
    ]);
    asset.json["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": inverse}]);
    let loaded = asset.load();
    let primitive = only(&loaded);
    assert_close(
        loaded.scene.instances[0].world_from_object.translation,
        Vec3::ZERO,
    );
    assert_close(primitive.positions[0], [0.0, 0.0, 2.0]);
    assert_close(primitive.positions[1], [1.0, 0.0, 2.0]);
    assert_close(primitive.positions[2], [0.0, 1.0, 2.0]);
    // Half of it is turned by a quarter about x, z to -y.
    assert_close(primitive.normals[1], Vec3::new(0.0, -half, half));
    assert!(noted(&loaded, "no joint moves"));
}
