//! Variants, visibility, copies by EXT_mesh_gpu_instancing, and metadata.

use crate::animation::{animate, at, blurred, open};
use crate::asset::{Asset, U8};
use crate::{assert_close, noted};
use glam::{Quat, Vec3};
use serde_json::json;
use snell::gltf::{self, Loaded, Treatment};

fn drawn_materials(loaded: &Loaded) -> Vec<&str> {
    let scene = &loaded.scene;
    let primitives = scene
        .instances
        .iter()
        .flat_map(|one| &scene.meshes[one.mesh].primitives);
    primitives
        .map(|primitive| scene.materials[primitive.material].name.as_str())
        .collect()
}

#[test]
fn variants_change_the_materials_that_mappings_name() {
    let mut asset = Asset::triangle();
    asset.json["materials"] = json!([
        {"name": "plain"},
        {"name": "red", "pbrMetallicRoughness": {"roughnessFactor": 0.25}},
        {"name": "blue"},
    ]);
    asset.json["extensions"] = json!({"KHR_materials_variants": {"variants":
        [{"name": "warm"}, {"name": "cold"}, {"name": "of no mapping"}]}});
    asset.primitive()["material"] = json!(0);
    asset.primitive()["extensions"] = json!({"KHR_materials_variants": {"mappings":
        [{"material": 1, "variants": [0]}, {"material": 2, "variants": [1]}]}});
    let mut file = open(&asset);
    assert_eq!(file.variants(), ["warm", "cold", "of no mapping"]);
    for (variant, expected) in [
        (None, "plain"),
        (Some(0), "red"),
        (Some(1), "blue"),
        (Some(2), "plain"),
        (None, "plain"),
    ] {
        file.choose_variant(variant);
        let loaded = file.scene(&gltf::Moment::Rest).unwrap();
        assert_eq!(drawn_materials(&loaded), [expected], "{variant:?}");
        assert_eq!(loaded.extensions[0].treatment, Treatment::Supported);
    }
    // A material that only a variant uses is read when it is chosen.
    file.choose_variant(Some(0));
    let loaded = file.scene(&gltf::Moment::Rest).unwrap();
    let snell::scene::Model::MetallicRoughness(model) = &loaded.scene.materials[1].model else {
        panic!("another model");
    };
    assert_eq!(model.roughness, 0.25);
    asset.primitive()["extensions"]["KHR_materials_variants"]["mappings"][0]["material"] = json!(9);
    let mut file = open(&asset);
    file.choose_variant(Some(0));
    let error = file.scene(&gltf::Moment::Rest).unwrap_err();
    let at = "meshes[0].primitives[0].extensions.KHR_materials_variants.mappings[0].material";
    assert_eq!(error.at(), at, "{error}");
}

#[test]
fn what_is_below_an_invisible_node_is_not_drawn() {
    let mut asset = Asset::triangle();
    asset.json["cameras"] =
        json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]);
    asset.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    let visible = |visible: bool| json!({"KHR_node_visibility": {"visible": visible}});
    asset.json["nodes"] = json!([
        {"children": [1], "extensions": visible(false)},
        {"mesh": 0, "camera": 0, "children": [2], "extensions": visible(true)},
        {"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"mesh": 0, "extensions": {"KHR_node_visibility": {}}},
    ]);
    asset.json["scenes"][0]["nodes"] = json!([0, 3]);
    let loaded = asset.load();
    let nodes: Vec<usize> = loaded.scene.instances.iter().map(|one| one.node).collect();
    assert_eq!(nodes, [3]);
    // Lights are hidden with it, cameras are not.
    assert_eq!(
        (loaded.scene.lights.len(), loaded.scene.cameras.len()),
        (0, 1)
    );
    asset.json["nodes"][0]["extensions"] = visible(true);
    let loaded = asset.load();
    assert_eq!(
        (loaded.scene.instances.len(), loaded.scene.lights.len()),
        (3, 1)
    );
}

fn copies() -> (Asset, [Vec3; 2], [Quat; 2], [Vec3; 2]) {
    let mut asset = Asset::triangle();
    let translations = [Vec3::new(1.0, 2.0, 3.0), Vec3::new(-4.0, 0.0, 1.0)];
    let turn = Quat::from_rotation_x(1.0);
    let rotations = [turn, Quat::from_rotation_y(-2.0)];
    let scales = [Vec3::splat(2.0), Vec3::new(1.0, -1.0, 0.5)];
    let flat = |vectors: &[Vec3]| {
        vectors
            .iter()
            .flat_map(|v| v.to_array())
            .collect::<Vec<f32>>()
    };
    let t = asset.floats("VEC3", &flat(&translations));
    let r: Vec<f32> = rotations.iter().flat_map(|q| q.to_array()).collect();
    let r = asset.floats("VEC4", &r);
    let s = asset.floats("VEC3", &flat(&scales));
    asset.json["nodes"][0] = json!({"mesh": 0, "translation": [10, 0, 0], "scale": [1, 3, 1],
        "extensions": {"EXT_mesh_gpu_instancing": {"attributes":
            {"TRANSLATION": t, "ROTATION": r, "SCALE": s}}}});
    asset.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    (asset, translations, rotations, scales)
}

#[test]
fn copies_stand_in_the_nodes_own_space() {
    let (mut asset, translations, rotations, scales) = copies();
    let loaded = asset.load();
    assert_eq!(
        (loaded.scene.meshes.len(), loaded.scene.instances.len()),
        (1, 2)
    );
    for (i, instance) in loaded.scene.instances.iter().enumerate() {
        for p in [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z] {
            let local = translations[i] + rotations[i] * (scales[i] * p);
            let world = Vec3::new(10.0, 0.0, 0.0) + Vec3::new(1.0, 3.0, 1.0) * local;
            assert_close(instance.world_from_object.transform_point3(p), world);
        }
        assert_eq!((instance.node, instance.mesh), (0, 0));
    }
    // What is not there is as at nodes.
    let attributes =
        &mut asset.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
    attributes.as_object_mut().unwrap().remove("ROTATION");
    attributes["_ID"] = json!(0);
    let loaded = asset.load();
    let x = loaded.scene.instances[0]
        .world_from_object
        .transform_vector3(Vec3::X);
    assert_close(x, [2.0, 0.0, 0.0]);
    assert!(noted(&loaded, "custom attributes of instances"));
}

#[test]
fn copies_move_with_their_node() {
    let (mut asset, translations, ..) = copies();
    animate(
        &mut asset,
        (0, "translation"),
        "LINEAR",
        &[0.0, 1.0],
        ("VEC3", &[0.0, 0.0, 0.0, 5.0, 0.0, 0.0]),
    );
    let mut file = open(&asset);
    let x = |p: Vec3, offset: f32| Vec3::new(p.x + offset, 3.0 * p.y, p.z);
    let loaded = at(&mut file, 1.0);
    let place = |i: usize| loaded.scene.instances[i].world_from_object.translation;
    assert_close(place(1), x(translations[1], 5.0));
    let loaded = file.scene(&blurred(0.0, 1.0)).unwrap();
    for (i, instance) in loaded.scene.instances.iter().enumerate() {
        assert_eq!(instance.motion.len(), 1);
        assert_close(
            instance.world_from_object.translation,
            x(translations[i], 0.0),
        );
        assert_close(instance.motion[0].translation, x(translations[i], 5.0));
    }
}

#[test]
fn copies_of_bytes_and_of_other_counts() {
    const I8: u32 = 5120;
    let (mut asset, ..) = copies();
    let rotations = asset.accessor(I8, "VEC4", 2, &[0, 0, 127, 0, 0, 0, 0, 127]);
    asset.json["accessors"][rotations]["normalized"] = json!(true);
    let attributes = json!({"ROTATION": rotations});
    asset.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = attributes;
    let loaded = asset.load();
    let x = |i: usize| {
        loaded.scene.instances[i]
            .world_from_object
            .transform_vector3(Vec3::X)
    };
    assert_close(x(0), Vec3::NEG_X);
    assert_close(x(1), Vec3::X);
    let three = asset.floats("VEC3", &[0.0; 9]);
    let attributes =
        &mut asset.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
    attributes["TRANSLATION"] = json!(three);
    let error = asset.try_load().map(|_| ()).unwrap_err();
    let at = "nodes[0].extensions.EXT_mesh_gpu_instancing.attributes";
    assert_eq!(error.at(), at, "{error}");
    assert!(
        error
            .to_string()
            .contains("TRANSLATION has 3 elements and ROTATION has 2")
    );
}

/// The count is paid for out of the ceiling on memory before anything is placed.
#[test]
fn copies_without_end() {
    let mut asset = Asset::triangle();
    let scales = asset.push(
        "accessors",
        json!({"componentType": 5126, "type": "VEC3", "count": 1u64 << 40}),
    );
    asset.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"SCALE": scales}}});
    assert_eq!(asset.try_load().map(|_| ()).unwrap_err().exit_status(), 6);
}

#[test]
fn a_skinned_mesh_is_copied_where_its_joints_put_it() {
    let (mut asset, translations, ..) = copies();
    let joints = asset.accessor(U8, "VEC4", 3, &[0; 12]);
    let weights = asset.floats("VEC4", &[1.0, 0.0, 0.0, 0.0].repeat(3));
    asset.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    asset.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    asset.json["nodes"][0]["skin"] = json!(0);
    asset.push("nodes", json!({"translation": [0, 0, 7]}));
    asset.json["skins"] = json!([{"joints": [1]}]);
    let loaded = asset.load();
    let first = |i: usize| {
        let instance = &loaded.scene.instances[i];
        let p = loaded.scene.meshes[instance.mesh].primitives[0].positions[0];
        assert_close(p, [0.0, 0.0, 7.0]);
        instance.world_from_object.transform_point3(Vec3::ZERO)
    };
    assert_close(first(1), translations[1]);
    assert!(noted(&loaded, "copies of a skinned mesh"));
}

#[test]
fn metadata_is_kept_with_what_it_is_about() {
    let mut asset = Asset::triangle();
    let packet = json!({"@context": {"dc": "http://purl.org/dc/elements/1.1/"}, "dc:format": "model/gltf-binary",
        "extensions": {"KHR_xmp_json_ld": {"packet": 77}}});
    asset.json["extensions"] = json!({"KHR_xmp_json_ld": {"packets": [{"@context": {}}, packet]}});
    let refer = |packet: usize| json!({"KHR_xmp_json_ld": {"packet": packet}});
    asset.json["asset"]["extensions"] = refer(1);
    asset.json["meshes"][0]["extensions"] = refer(1);
    let loaded = asset.load();
    let found: Vec<_> = loaded
        .metadata
        .iter()
        .map(|one| (one.at.as_str(), &one.about))
        .collect();
    let at = "extensions.KHR_xmp_json_ld.packets";
    assert_eq!(found[0], (format!("{at}[0]").as_str(), &vec![]));
    let about = vec!["asset".to_owned(), "meshes[0]".to_owned()];
    assert_eq!(found[1], (format!("{at}[1]").as_str(), &about));
    assert_eq!(loaded.metadata[1].packet, packet);
    asset.json["meshes"][0]["extensions"] = refer(2);
    let error = asset.try_load().map(|_| ()).unwrap_err();
    assert_eq!(
        error.at(),
        "meshes[0].extensions.KHR_xmp_json_ld.packet",
        "{error}"
    );
}
