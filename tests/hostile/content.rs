//! Numbers, materials, images and skins that make no sense.

use crate::asset::{Asset, U8, load_bytes, pixel_png, png};
use crate::{edited, expect, invalid};
use serde_json::{Value, json};
use snell::gltf::LoadOptions;

#[test]
fn positions_that_are_no_place() {
    for bad in [f32::NAN, f32::INFINITY, 1e30] {
        let mut asset = Asset::triangle();
        asset.bin[16..20].copy_from_slice(&bad.to_le_bytes());
        invalid(&asset, "accessors[0]", "the position of vertex 1");
    }
    let far = edited(|json| json["nodes"][0]["scale"] = json!([1e30, 1e30, 1e30]));
    invalid(&far, "nodes[0]", "farther out");
    let beyond = edited(|json| {
        json["nodes"] = json!([{"children": [1], "scale": [1e30, 1e30, 1e30]},
                               {"mesh": 0, "scale": [1e30, 1e30, 1e30]}]);
    });
    invalid(&beyond, "nodes[1]", "not finite");
}

#[test]
fn attributes_of_other_lengths() {
    let mut asset = Asset::triangle();
    let normals = asset.floats("VEC3", &[0.0, 0.0, 1.0]);
    asset.primitive()["attributes"]["NORMAL"] = json!(normals);
    invalid(&asset, "meshes[0].primitives[0].attributes", "NORMAL has 1");
}

#[test]
fn materials_that_make_no_sense() {
    let material = |material: Value| Asset::triangle().with_material(material);
    let bsdf = |value: Value| material(json!({"extensions": {"SNELL_materials_bsdf": value}}));
    let at = "materials[0].extensions.SNELL_materials_bsdf";
    invalid(&bsdf(json!({"model": "magic"})), at, "magic");
    invalid(&bsdf(json!({"model": "lambertian"})), at, "reflectance");
    invalid(&bsdf(json!({})), at, "model");
    invalid(
        &material(json!({"alphaMode": "GLOW"})),
        "materials[0]",
        "GLOW",
    );
    invalid(
        &material(json!({"emissiveFactor": [-1, 0, 0]})),
        "materials[0]",
        "negative",
    );
    let ior = json!({"extensions": {"KHR_materials_ior": {"ior": 0.5}}});
    invalid(
        &material(ior),
        "materials[0].extensions.KHR_materials_ior",
        "0.5",
    );
    let texture = json!({"normalTexture": {"index": 0}});
    invalid(
        &material(texture),
        "materials[0].normalTexture.index",
        "there are 0 textures",
    );
    let texture = json!({"normalTexture": {}});
    invalid(
        &material(texture),
        "materials[0].normalTexture",
        "`index` is missing",
    );
}

#[test]
fn cameras_and_lights_that_make_no_sense() {
    let camera = |camera: Value| {
        edited(|json| {
            json["cameras"] = json!([camera]);
            json["nodes"][0]["camera"] = json!(0);
        })
    };
    let at = "cameras[0].perspective";
    for (lens, words) in [
        (json!({"yfov": 0, "znear": 1}), "yfov is 0"),
        (json!({"yfov": 3.2, "znear": 1}), "less than pi"),
        (json!({"yfov": 1, "znear": -1}), "znear"),
        (
            json!({"yfov": 1, "znear": 1, "aspectRatio": 0}),
            "aspectRatio",
        ),
        (json!({"znear": 1}), "`yfov` is missing"),
    ] {
        invalid(
            &camera(json!({"type": "perspective", "perspective": lens})),
            at,
            words,
        );
    }
    invalid(
        &camera(json!({"type": "fisheye"})),
        "cameras[0].type",
        "fisheye",
    );
    invalid(
        &camera(json!({"type": "perspective"})),
        "cameras[0]",
        "`perspective` is missing",
    );
    let light = |light: Value| {
        edited(|json| {
            json["extensions"] = json!({"KHR_lights_punctual": {"lights": [light]}});
            json["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
        })
    };
    let at = "extensions.KHR_lights_punctual.lights[0]";
    invalid(
        &light(json!({"type": "point", "intensity": -1})),
        at,
        "negative",
    );
    invalid(&light(json!({"type": "sun"})), &format!("{at}.type"), "sun");
    let mut none = light(json!({"type": "point"}));
    none.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = json!(1);
    invalid(
        &none,
        "nodes[0].extensions.KHR_lights_punctual.light",
        "out of range",
    );
}

#[test]
fn images_that_are_none() {
    let image = |bytes: &[u8]| {
        let mut asset = Asset::triangle();
        let texture = asset.texture(bytes);
        asset.with_material(json!({"emissiveTexture": {"index": texture}}))
    };
    invalid(&image(b""), "images[0]", "neither PNG");
    invalid(&image(b"GIF89a"), "images[0]", "neither PNG");
    let good = pixel_png([1, 2, 3, 4]);
    for length in 8..good.len() - 12 {
        invalid(&image(&good[..length]), "images[0]", "damaged");
    }
    for (width, height) in [(0, 1), (1, 0)] {
        let bytes = png(width, height, 8, 6, &[], &[]);
        assert_eq!(image(&bytes).try_load().unwrap_err().exit_status(), 3);
    }
    // 60 000 x 60 000 pixels are 14.4 GB: over the ceiling before anything is decoded.
    let huge = png(60_000, 60_000, 8, 6, &[], &[]);
    expect(
        image(&huge).try_load().map(|_| ()),
        6,
        "images[0]",
        "14400000000 bytes",
    );
    let small = LoadOptions {
        max_memory: 100_000,
        ..LoadOptions::default()
    };
    // A gray image grows fourfold: what it becomes is paid for, not what it was.
    let gray = image(&png(200, 200, 8, 0, &[], &[])).glb();
    expect(
        load_bytes(&gray, &small).map(|_| ()),
        6,
        "images[0]",
        "160000 bytes",
    );
    let mut nowhere = image(&good);
    nowhere.json["images"] = json!([{}]);
    invalid(&nowhere, "images[0]", "neither `uri` nor");
}

#[test]
fn skins_that_do_not_fit() {
    let mut asset = Asset::triangle();
    let joints = asset.accessor(U8, "VEC4", 3, &[9; 12]);
    let weights = asset.floats("VEC4", &[1.0; 12]);
    let matrices = asset.floats("MAT4", &[0.0; 16]);
    asset.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    asset.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    asset.json["nodes"][0]["skin"] = json!(0);
    asset.json["skins"] = json!([{"joints": [0]}]);
    invalid(&asset, "meshes[0].primitives[0].attributes", "joint 9");
    asset.json["skins"] = json!([{"joints": [0, 0], "inverseBindMatrices": matrices}]);
    invalid(&asset, "skins[0]", "1 elements for 2 joints");
    asset.json["skins"] = json!([{"joints": [5]}]);
    invalid(&asset, "skins[0].joints[0]", "out of range");
}
