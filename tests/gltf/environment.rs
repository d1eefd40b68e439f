//! Environment maps, and what is made for a scene without light or camera.

use crate::asset::{Asset, pixel_png};
use glam::Vec3;
use serde_json::json;
use snell::gltf::{
    EnvironmentSource, GltfError, LoadOptions, bounds, default_camera, default_environment,
    load_environment,
};
use snell::scene::{Environment, Projection, Scene};
use std::path::Path;

/// The mean radiance over all directions.
fn mean(map: &Environment) -> f64 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for (index, texel) in map.radiance.iter().enumerate() {
        let row = (index / map.width as usize) as f64 + 0.5;
        let weight = (std::f64::consts::PI * row / f64::from(map.height)).sin();
        sum += weight * f64::from(texel[1]);
        weights += weight;
    }
    sum / weights
}

#[test]
fn the_default_environment_is_grey_brighter_above_and_of_mean_one() {
    let map = default_environment();
    assert_eq!(map.radiance.len(), (map.width * map.height) as usize);
    assert!((mean(&map) - 1.0).abs() < 1e-6);
    assert!(
        map.radiance
            .iter()
            .all(|t| t[0] == t[1] && t[1] == t[2] && t[0] > 0.0)
    );
    let row = |y: u32| {
        let row = &map.radiance[(y * map.width) as usize..((y + 1) * map.width) as usize];
        row.iter().map(|texel| texel[0]).sum::<f32>()
    };
    assert!(row(4) > row(16) && row(16) > row(30));
    // The key light stands in front: brighter where z > 0, the right half of u.
    let brightest =
        (0..map.radiance.len()).max_by(|&a, &b| map.radiance[a][0].total_cmp(&map.radiance[b][0]));
    let u = (brightest.unwrap() as u32 % map.width) as f32 / map.width as f32;
    assert!(u > 0.5, "{u}");
}

#[test]
fn a_scene_without_light_gets_the_default_one() {
    let loaded = Asset::triangle().load();
    assert!(loaded.default_light && loaded.scene.environment.is_some());
    let glowing = Asset::triangle()
        .with_material(json!({"emissiveFactor": [0, 1, 0]}))
        .load();
    assert!(!glowing.default_light && glowing.scene.environment.is_none());
}

#[test]
fn a_glowing_label_is_not_a_light_but_a_strong_one_is() {
    let png = pixel_png([255; 4]);
    let labelled = |strength: f32| {
        let mut asset = Asset::triangle();
        let texture = asset.texture(&png);
        let loaded = asset
            .with_material(json!({
                "emissiveFactor": [1, 1, 1],
                "emissiveTexture": {"index": texture},
                "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": strength}},
            }))
            .load();
        (loaded.default_light, loaded.scene.environment.is_some())
    };
    assert_eq!(labelled(1.0), (true, true));
    assert_eq!(labelled(2.0), (false, false));
}

fn write_exr(path: &Path, pixels: &[[f32; 3]], width: usize) {
    let color = |x: usize, y: usize| {
        let [r, g, b] = pixels[y * width + x];
        (r, g, b)
    };
    exr::prelude::write_rgb_file(path, width, pixels.len() / width, color).unwrap();
}

#[test]
fn maps_are_read_from_exr_hdr_and_png() {
    let folder = tempfile::tempdir().unwrap();
    // What Radiance's shared exponent holds exactly.
    let pixels = [
        [1.0, 0.5, 0.25],
        [2.0, 4.0, 8.0],
        [0.0, 0.0, 0.0],
        [1.0, 1.0, 1.0],
    ];
    let exr = folder.path().join("map.exr");
    write_exr(&exr, &pixels, 2);
    let hdr = folder.path().join("map.hdr");
    let colors: Vec<_> = pixels.iter().map(|&pixel| image::Rgb(pixel)).collect();
    let file = std::fs::File::create(&hdr).unwrap();
    image::codecs::hdr::HdrEncoder::new(file)
        .encode(&colors, 2, 2)
        .unwrap();
    for path in [exr, hdr] {
        let map = load_environment(&path).unwrap();
        assert_eq!((map.width, map.height), (2, 2));
        assert_eq!(map.radiance, pixels, "{}", path.display());
        assert_eq!((map.strength, map.rotation), (1.0, 0.0));
    }
    let png = folder.path().join("map.png");
    std::fs::write(&png, pixel_png([188, 255, 0, 255])).unwrap();
    let [r, g, b] = load_environment(&png).unwrap().radiance[0];
    assert!(
        (r - 0.5029).abs() < 1e-4 && g == 1.0 && b == 0.0,
        "{r} {g} {b}"
    );
}

#[test]
fn bad_maps_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("map.exr");
    for bad in [-1.0, f32::NAN, f32::INFINITY] {
        write_exr(&path, &[[1.0; 3], [1.0, bad, 1.0]], 1);
        let error = load_environment(&path).unwrap_err();
        assert!(matches!(error, GltfError::Invalid { .. }), "{error}");
        assert!(error.to_string().contains("pixel (0, 1)"), "{error}");
    }
    std::fs::write(&path, b"\x76\x2f\x31\x01 and no more").unwrap();
    assert_eq!(load_environment(&path).unwrap_err().exit_status(), 3);
    std::fs::write(&path, b"neither").unwrap();
    assert_eq!(load_environment(&path).unwrap_err().exit_status(), 3);
    let missing = load_environment(&folder.path().join("missing.hdr")).unwrap_err();
    assert!(matches!(missing, GltfError::Unreadable { .. }));
    // As an option of a scene it is found missing, too.
    let options = LoadOptions {
        environment: Some(EnvironmentSource::File(folder.path().join("missing.hdr"))),
        ..LoadOptions::default()
    };
    let error = crate::asset::load_bytes(&Asset::triangle().glb(), &options).unwrap_err();
    assert!(error.to_string().contains("missing.hdr"));
}

/// Where all corners of the scene's box come to lie in the picture, as factors of half its size.
fn framed(scene: &Scene, aspect: f32) -> (f32, f32) {
    let camera = default_camera(scene, aspect);
    let Projection::Perspective { yfov, near, .. } = camera.projection else {
        panic!("{camera:?}");
    };
    let camera_from_world = camera.world_from_camera.inverse();
    let (low, high) = bounds(scene).unwrap();
    let tan = (0.5 * yfov).tan();
    let mut worst = (0.0f32, 0.0f32);
    for corner in 0..8 {
        let pick = |bit: i32, low, high| if corner >> bit & 1 == 1 { high } else { low };
        let p = Vec3::new(
            pick(0, low.x, high.x),
            pick(1, low.y, high.y),
            pick(2, low.z, high.z),
        );
        let p = camera_from_world.transform_point3(p);
        assert!(-p.z > near, "{p} lies before the near plane");
        worst.0 = worst.0.max(p.x.abs() / (-p.z * tan * aspect));
        worst.1 = worst.1.max(p.y.abs() / (-p.z * tan));
    }
    worst
}

#[test]
fn the_default_camera_frames_the_scene() {
    for scale in [
        [1.0, 1.0, 1.0],
        [1e-3, 1e-3, 1e-3],
        [1e4, 1.0, 1.0],
        [0.1, 5.0, 0.1],
        [1.0, 1.0, 50.0],
    ] {
        let asset = Asset::of_primitive(|asset| {
            let positions: Vec<f32> = [[-1.0, -1.0, -1.0], [1.0, -1.0, 1.0], [1.0, 1.0, -1.0]]
                .into_iter()
                .flat_map(|p: [f32; 3]| [0, 1, 2].map(|axis| p[axis] * scale[axis] + 3.0))
                .collect();
            let positions = asset.floats("VEC3", &positions);
            json!({"attributes": {"POSITION": positions}})
        });
        let scene = asset.load().scene;
        for aspect in [0.5, 1.0, 2.0] {
            let (x, y) = framed(&scene, aspect);
            let fullest = x.max(y);
            assert!(
                fullest < 1.0 && fullest > 0.8,
                "{scale:?} {aspect}: {x} {y}"
            );
        }
    }
    // A board is seen from the side that it faces, a floor from above.
    for (corner, toward) in [
        ([0.0, 1.0, 0.0], Vec3::Z),
        ([0.0, -1.0, 0.0], Vec3::NEG_Z),
        ([0.0, 0.0, -1.0], Vec3::Y),
    ] {
        let mut asset = Asset::triangle();
        let tip: Vec<u8> = corner.iter().flat_map(|x: &f32| x.to_le_bytes()).collect();
        asset.bin[24..36].copy_from_slice(&tip);
        let camera = default_camera(&asset.load().scene, 1.0);
        let back = camera.world_from_camera.transform_vector3(Vec3::Z);
        assert!(back.dot(toward) > 0.5, "{corner:?}: {back}");
        let up = camera.world_from_camera.transform_vector3(Vec3::Y);
        assert!(up.y > 0.5);
    }
    // Nothing, or nothing but a point, is no reason to fail.
    let empty = default_camera(&Scene::default(), 1.0);
    assert!(empty.world_from_camera.is_finite());
}
