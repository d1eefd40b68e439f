//! EXT_lights_image_based: where each face lies and which way round, how it is decoded and turned.

use crate::asset::{Asset, load_bytes};
use crate::noted;
use glam::{DQuat, DVec3};
use serde_json::{Value, json};
use snell::gltf::{EnvironmentSource, LoadOptions};
use snell::scene::Environment;
use std::f64::consts::{PI, TAU};

const SIZE: u32 = 16;

/// The direction of a place in an image: OpenGL 4.6 section 8.13, table 8.19 (sc, tc, ma), solved for the
/// direction, and mirrored left to right as the extension says.
fn direction(face: usize, s: f64, t: f64) -> DVec3 {
    let (sc, tc) = (-(2.0 * s - 1.0), 2.0 * t - 1.0);
    match face {
        0 => DVec3::new(1.0, -tc, -sc),
        1 => DVec3::new(-1.0, -tc, sc),
        2 => DVec3::new(sc, 1.0, tc),
        3 => DVec3::new(sc, -1.0, -tc),
        4 => DVec3::new(sc, -tc, 1.0),
        _ => DVec3::new(-sc, -tc, -1.0),
    }
    .normalize()
}

/// Smooth, and different in every direction.
fn light(d: DVec3) -> DVec3 {
    2.0 * (0.5 * d + 0.6)
}

fn png(size: [u32; 2], pixel: impl Fn(f64, f64) -> [u8; 4]) -> Vec<u8> {
    let image = image::RgbaImage::from_fn(size[0], size[1], |x, y| {
        let at = |i: u32, n: u32| (f64::from(i) + 0.5) / f64::from(n);
        image::Rgba(pixel(at(x, size[0]), at(y, size[1])))
    });
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

/// Divided by 2.5 and 2.5 times so dark.
fn rgbd(color: DVec3) -> [u8; 4] {
    let divisor = 0.4;
    let [r, g, b] = (color * divisor)
        .to_array()
        .map(|x| (x.powf(1.0 / 2.2) * 255.0).round() as u8);
    [r, g, b, (divisor * 255.0) as u8]
}

pub fn lit_by(images: &[Vec<u8>], rest: Value) -> Asset {
    let mut asset = Asset::triangle();
    let indices: Vec<usize> = images
        .iter()
        .map(|png| {
            let view = asset.view(png);
            asset.push(
                "images",
                json!({"bufferView": view, "mimeType": "image/png"}),
            )
        })
        .collect();
    let mut light = json!({
        "specularImages": [indices],
        "specularImageSize": SIZE,
        // Mean radiance 1.2.
        "irradianceCoefficients": vec![vec![1.2 * PI / 0.282_095; 3]; 9],
    });
    for (key, value) in rest.as_object().unwrap() {
        light[key] = value.clone();
    }
    asset.json["extensions"] = json!({"EXT_lights_image_based": {"lights": [light]}});
    asset.json["scenes"][0]["extensions"] = json!({"EXT_lights_image_based": {"light": 0}});
    asset.json["extensionsUsed"] = json!(["EXT_lights_image_based"]);
    asset
}

pub fn faces() -> Vec<Vec<u8>> {
    (0..6)
        .map(|face| png([SIZE; 2], |s, t| rgbd(light(direction(face, s, t)))))
        .collect()
}

/// The texel nearest to a direction.
fn look(map: &Environment, d: DVec3) -> DVec3 {
    let u = d.z.atan2(d.x) / TAU + 0.5;
    let v = d.y.acos() / PI;
    let x = ((u * f64::from(map.width)) as u32).min(map.width - 1);
    let y = ((v * f64::from(map.height)) as u32).min(map.height - 1);
    DVec3::from(map.radiance[(y * map.width + x) as usize].map(f64::from))
}

/// Directions all around, none on a symmetry of the cube.
fn directions() -> impl Iterator<Item = DVec3> {
    (0..500).map(|i| {
        let y = 1.0 - (f64::from(i) + 0.5) / 250.0;
        let phi = f64::from(i) * 2.399_963;
        let r = (1.0 - y * y).sqrt();
        DVec3::new(r * phi.cos(), y, r * phi.sin())
    })
}

#[test]
fn each_face_lies_where_it_belongs_and_edges_have_no_seam() {
    let loaded = lit_by(&faces(), json!({})).load();
    assert!(!loaded.default_light && !noted(&loaded, "coefficients"));
    let map = loaded.scene.environment.unwrap();
    assert_eq!((map.width, map.height), (4 * SIZE, 2 * SIZE));
    for d in directions() {
        let (found, expected) = (look(&map, d), light(d));
        assert!(
            (found - expected).abs().max_element() < 0.08,
            "{d}: {found} {expected}"
        );
    }
}

#[test]
fn it_is_turned_counter_clockwise_and_made_brighter() {
    let rotation = DQuat::from_axis_angle(DVec3::new(0.3, 1.0, -0.2).normalize(), 1.1);
    let asset = lit_by(
        &faces(),
        json!({"rotation": rotation.to_array(), "intensity": 3.0}),
    );
    let map = asset.load().scene.environment.unwrap();
    assert_eq!(map.strength, 3.0);
    for d in directions() {
        let (found, expected) = (look(&map, rotation * d), light(d));
        assert!(
            (found - expected).abs().max_element() < 0.08,
            "{d}: {found} {expected}"
        );
    }
}

#[test]
fn pictures_without_alpha_are_srgb_and_those_with_it_rgbd() {
    let opaque = image::RgbImage::from_pixel(2, 2, image::Rgb([188, 255, 0]));
    let mut bytes = std::io::Cursor::new(Vec::new());
    opaque
        .write_to(&mut bytes, image::ImageFormat::Png)
        .unwrap();
    let srgb = lit_by(&vec![bytes.into_inner(); 6], json!({})).load();
    let [r, g, b] = srgb.scene.environment.as_ref().unwrap().radiance[7];
    assert!(
        (r - 0.5029).abs() < 1e-4 && g == 1.0 && b == 0.0,
        "{r} {g} {b}"
    );
    let bright = png([2, 2], |_, _| [255, 188, 0, 51]);
    let rgbd = lit_by(&vec![bright; 6], json!({})).load();
    let [r, g, b] = rgbd.scene.environment.as_ref().unwrap().radiance[7];
    let expected = (188f32 / 255.0).powf(2.2) * 5.0;
    assert!((r - 5.0).abs() < 1e-5 && (g - expected).abs() < 1e-5 && b == 0.0);
    // Their mean is 2.51, and the coefficients say 1.2.
    assert!(noted(&rgbd, "coefficients"));
}

#[test]
fn an_environment_that_is_asked_for_takes_its_place() {
    let options = LoadOptions {
        environment: Some(EnvironmentSource::Constant([0.25; 3])),
        ..LoadOptions::default()
    };
    let loaded = load_bytes(&lit_by(&faces(), json!({})).glb(), &options).unwrap();
    assert!(noted(&loaded, "takes the place"));
    assert_eq!(loaded.scene.environment.unwrap().radiance, [[0.25; 3]]);
}

#[test]
fn bad_image_based_lights_end_in_a_sentence_with_their_place() {
    const LIGHT: &str = "extensions.EXT_lights_image_based.lights[0]";
    let small = png([4, 4], |_, _| [9; 4]);
    let mut five = faces();
    five.pop();
    let mut uneven = faces();
    uneven[3] = small;
    let mut oblong = faces();
    oblong[0] = png([16, 8], |_, _| [9; 4]);
    let mut zero = faces();
    zero[2] = png([SIZE; 2], |_, _| [9, 9, 9, 0]);
    let mut no_image = faces();
    no_image[4] = b"nothing".to_vec();
    let level = format!("{LIGHT}.specularImages[0]");
    for (asset, at, says) in [
        (lit_by(&five, json!({})), level.clone(), "5 images"),
        (lit_by(&uneven, json!({})), format!("{level}[3]"), "4 x 4"),
        (lit_by(&oblong, json!({})), format!("{level}[0]"), "16 x 8"),
        (lit_by(&zero, json!({})), "images[2]".into(), "alpha of 0"),
        (lit_by(&no_image, json!({})), "images[4]".into(), "neither"),
        (
            lit_by(&faces(), json!({"specularImages": []})),
            format!("{LIGHT}.specularImages"),
            "no images",
        ),
        (
            lit_by(&faces(), json!({"specularImages": [[0, 1, 2, 3, 4, 99]]})),
            format!("{level}[5]"),
            "out of range",
        ),
        (
            lit_by(&faces(), json!({"intensity": -1})),
            LIGHT.into(),
            "negative",
        ),
        (
            lit_by(&faces(), json!({"rotation": [0, 0, 0, 0]})),
            LIGHT.into(),
            "length",
        ),
        (
            lit_by(&faces(), json!({"irradianceCoefficients": [["x"]]})),
            format!("{LIGHT}.irradianceCoefficients[0][0]"),
            "not a number",
        ),
    ] {
        let error = asset.try_load().unwrap_err();
        assert_eq!(error.at(), at, "{error}");
        assert!(error.to_string().contains(says), "{error}");
        assert_eq!(error.exit_status(), 3);
    }
    let mut asset = lit_by(&faces(), json!({}));
    asset.json["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = json!(1);
    let error = asset.try_load().unwrap_err();
    assert_eq!(
        error.at(),
        "scenes[0].extensions.EXT_lights_image_based.light"
    );
}
