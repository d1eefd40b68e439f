//! EXT_lights_ies: what each edition, type and symmetry of LM-63 means, where the lamp points, and what
//! is refused.

use crate::asset::{Asset, load_bytes};
use crate::noted;
use glam::{DQuat, DVec3};
use serde_json::{Value, json};
use snell::cpu::light::punctual::irradiance_punctual;
use snell::gltf::{LoadOptions, Loaded};
use snell::pack::{Background, Packed, View, pack};

/// A file of LM-63: photometric type, vertical and horizontal angles, and candela as a function of them.
pub fn ies(
    kind: u32,
    vertical: &[f64],
    horizontal: &[f64],
    candela: impl Fn(f64, f64) -> f64,
) -> String {
    let row = |numbers: &[f64]| numbers.iter().map(|x| format!("{x} ")).collect::<String>();
    let mut text = format!(
        "IESNA:LM-63-2002\r\n[TEST] none\r\n[MANUFAC] nobody\r\nTILT=NONE\r\n\
         1 -1 1 {} {} {kind} 2 0 0 0\r\n1 1 100\r\n{}\r\n{}\r\n",
        vertical.len(),
        horizontal.len(),
        row(vertical),
        row(horizontal)
    );
    for &h in horizontal {
        let column: Vec<f64> = vertical.iter().map(|&v| candela(v, h)).collect();
        text += &(row(&column) + "\r\n");
    }
    text
}

pub fn lamp(text: &str, instance: Value, node: Value) -> Asset {
    let mut asset = Asset::triangle();
    let view = asset.view(text.as_bytes());
    asset.json["extensions"] = json!({"EXT_lights_ies": {"lights": [
        {"uri": "never-read.ies"},
        {"bufferView": view, "mimeType": "application/x-ies-lm-63"},
    ]}});
    asset.json["extensionsUsed"] = json!(["EXT_lights_ies"]);
    let mut extension = json!({"light": 1});
    for (key, value) in instance.as_object().unwrap() {
        extension[key] = value.clone();
    }
    let mut object = json!({"extensions": {"EXT_lights_ies": extension}});
    for (key, value) in node.as_object().unwrap() {
        object[key] = value.clone();
    }
    let index = asset.push("nodes", object);
    asset.json["scenes"][0]["nodes"] = json!([0, index]);
    asset
}

fn packed(loaded: &Loaded) -> Packed {
    let view = View {
        camera: snell::gltf::default_camera(&loaded.scene, 1.0),
        film_size: [1, 1],
        seed: 0,
        max_depth: 1,
        background: Background::Environment,
        clamp: None,
    };
    pack(&loaded.scene, &view).unwrap()
}

/// Intensity towards d.
fn intensity(packed: &Packed, d: DVec3) -> DVec3 {
    irradiance_punctual(packed, &packed.lights[0], -d.normalize(), 1.0)
}

/// From the node's -z by `v` degrees, turned about +z from +x by `h`.
fn towards(v: f64, h: f64) -> DVec3 {
    let (v, h) = (v.to_radians(), h.to_radians());
    DVec3::new(v.sin() * h.cos(), v.sin() * h.sin(), -v.cos())
}

fn by(step: f64, first: f64, last: f64) -> Vec<f64> {
    let count = ((last - first) / step).round() as usize;
    (0..=count).map(|i| first + step * i as f64).collect()
}

#[track_caller]
fn sends(packed: &Packed, d: DVec3, candela: f64) {
    let found = intensity(packed, d);
    assert!(
        (found - candela).abs().max_element() < 1e-3 * (candela.abs() + 1.0),
        "towards {d}: {found} is not {candela}"
    );
}

#[test]
fn symmetries_of_type_c_fill_the_turn() {
    // Linear in both angles, as the table is.
    let value = |v: f64, h: f64| 100.0 + v + 3.0 * h;
    let vertical = by(10.0, 0.0, 180.0);
    for (horizontal, folded) in [
        (by(1.0, 0.0, 0.0), [0.0, 0.0, 0.0, 0.0, 0.0]),
        (by(22.5, 0.0, 90.0), [30.0, 70.0, 10.0, 80.0, 15.0]),
        (by(15.0, 0.0, 180.0), [30.0, 110.0, 170.0, 100.0, 15.0]),
        (by(45.0, 0.0, 360.0), [30.0, 110.0, 190.0, 260.0, 345.0]),
        (by(30.0, 90.0, 270.0), [150.0, 110.0, 190.0, 260.0, 195.0]),
    ] {
        let text = ies(1, &vertical, &horizontal, value);
        let packed = packed(&lamp(&text, json!({}), json!({})).load());
        for (h, folded) in [30.0, 110.0, 190.0, 260.0, 345.0].into_iter().zip(folded) {
            for v in [10.0, 45.0, 90.0, 137.0] {
                sends(&packed, towards(v, h), value(v, folded));
            }
        }
    }
}

#[test]
fn beyond_the_measured_angles_there_is_no_light() {
    let below = ies(1, &by(5.0, 0.0, 90.0), &[0.0], |_, _| 7.0);
    let packed_below = packed(&lamp(&below, json!({}), json!({})).load());
    sends(&packed_below, towards(89.9, 40.0), 7.0);
    sends(&packed_below, towards(90.6, 40.0), 0.0);
    let above = ies(1, &by(5.0, 90.0, 180.0), &[0.0], |_, _| 7.0);
    let packed_above = packed(&lamp(&above, json!({}), json!({})).load());
    sends(&packed_above, towards(89.4, 40.0), 0.0);
    sends(&packed_above, towards(90.1, 40.0), 7.0);
}

#[test]
fn a_lamp_follows_its_node_its_multiplier_and_its_colour() {
    let value = |v: f64, h: f64| 50.0 + v + h;
    let text = ies(1, &by(10.0, 0.0, 180.0), &by(45.0, 0.0, 360.0), value);
    let rotation = DQuat::from_axis_angle(DVec3::new(0.2, -0.5, 0.8).normalize(), 0.9);
    let loaded = lamp(
        &text,
        json!({"multiplier": 2.0, "color": [1.0, 0.5, 0.25]}),
        json!({"rotation": rotation.to_array(), "scale": [3, 3, 3], "translation": [1, 2, 3]}),
    )
    .load();
    assert!(!loaded.default_light && loaded.counts.lights == 2);
    let packed = packed(&loaded);
    assert_eq!(packed.lights[0].position, [1.0, 2.0, 3.0]);
    for (v, h) in [(30.0, 20.0), (70.0, 250.0), (140.0, 100.0)] {
        let found = intensity(&packed, rotation * towards(v, h));
        let expected = 2.0 * value(v, h) * DVec3::new(1.0, 0.5, 0.25);
        assert!(
            (found - expected).length() < 1e-3 * expected.length(),
            "{found} {expected}"
        );
    }
}

#[test]
fn types_a_and_b_differ_in_their_poles() {
    let angles = by(10.0, -90.0, 90.0);
    let value = |v: f64, h: f64| 500.0 + v + 2.0 * h;
    for kind in [2, 3] {
        let text = ies(kind, &angles, &angles, value);
        let loaded = lamp(&text, json!({}), json!({})).load();
        assert!(noted(&loaded, "types A and B"));
        let packed = packed(&loaded);
        for (v, h) in [
            (0.0, 0.0),
            (30.0, 0.0),
            (0.0, 40.0),
            (-20.0, 60.0),
            (50.0, -35.0),
        ] {
            let (sin_v, cos_v) = f64::to_radians(v).sin_cos();
            let (sin_h, cos_h) = f64::to_radians(h).sin_cos();
            // Up, right and forward.
            let [up, right, forward] = match kind {
                2 => [cos_h * sin_v, sin_h, cos_h * cos_v],
                _ => [sin_v, cos_v * sin_h, cos_v * cos_h],
            };
            let found = intensity(&packed, DVec3::new(up, -right, -forward)).x;
            // The table is not linear in these angles.
            assert!((found - value(v, h)).abs() < 0.1, "{kind} {v} {h}: {found}");
        }
        sends(&packed, DVec3::Z, 0.0);
    }
    // From 0 on stands for both sides.
    let half = by(10.0, 0.0, 90.0);
    let packed = packed(&lamp(&ies(2, &half, &half, value), json!({}), json!({})).load());
    let found = intensity(&packed, DVec3::new(-0.3, 0.4, -1.0)).x;
    let mirrored = intensity(&packed, DVec3::new(0.3, -0.4, -1.0)).x;
    assert!(
        (found - mirrored).abs() < 1e-6 && found > 520.0,
        "{found} {mirrored}"
    );
}

#[test]
fn every_edition_is_read_with_its_factors() {
    // Multiplier 2, ballast factor 0.5, and a third number of 0.25 that was a factor until 1995.
    let numbers = "1, 1000, 2, 2, 1, 1, 1, 0, 0, 0, 0.5, 0.25, 60\n0, 180\n0\n40, 40\n";
    for (head, expected) in [
        (format!("A lamp\nTILT=NONE\n{numbers}"), 10.0),
        (format!("IESNA91\n[TEST] 1\nTILT=NONE\n{numbers}"), 10.0),
        (format!("IESNA:LM-63-1995\nTILT=NONE\n{numbers}"), 10.0),
        (format!("IESNA:LM-63-2002\nTILT=NONE\n{numbers}"), 40.0),
        (format!("IES:LM-63-2019\nTILT=NONE\n{numbers}"), 40.0),
        (
            format!("IES:LM-63-2019\nTILT=INCLUDE\n1\n3\n0 90 180\n1 0.9 0.8\n{numbers}"),
            40.0,
        ),
        (format!("IES:LM-63-2019\nTILT=other.tlt\n{numbers}"), 40.0),
    ] {
        let loaded = lamp(&head, json!({}), json!({})).load();
        sends(&packed(&loaded), towards(33.0, 44.0), expected);
        assert_eq!(noted(&loaded, "tilt"), !head.contains("NONE"), "{head}");
    }
}

#[test]
fn hostile_profiles_end_in_a_sentence_with_their_place() {
    let good = "IES:LM-63-2019\nTILT=NONE\n1 1 1 2 1 1 1 0 0 0 1 1 60 0 180 0 40 40";
    lamp(good, json!({}), json!({})).load();
    for (from, to, says) in [
        ("TILT=NONE", "TILT", "TILT="),
        (" 40 40", " 40", "ends before the last candela"),
        ("1 1 1 2 1 1", "1 1 1 4000000000 1 1", "numbers follow"),
        ("1 1 1 2 1 1", "1 1 1 2 9e18 1", "numbers follow"),
        ("1 1 1 2 1 1", "1 1 1 3 3 1", "ends before"),
        ("1 1 1 2 1 1", "1 1 1 2.5 1 1", "numbers follow"),
        ("1 1 1 2 1 1", "1 1 1 0 1 1", "numbers follow"),
        ("1 1 1 2 1 1", "1 1 1 2 1 7", "photometric type"),
        ("1 1 1 2 1 1", "1 1 -1 2 1 1", "cd once"),
        ("1 1 1 2 1 1", "1 1 1e300 2 1 1", "cd once"),
        ("0 180 0", "0 nan 0", "'nan'"),
        ("0 180 0", "180 0 0", "do not rise"),
        ("0 180 0", "0 181 0", "leave open"),
        ("0 180 0", "0 180 30", "leave open"),
        ("40 40", "40 -3", "cd once"),
        ("NONE", "INCLUDE\n1 99999999", "numbers follow"),
    ] {
        let text = good.replacen(from, to, 1);
        assert_ne!(text, good);
        let error = lamp(&text, json!({}), json!({})).try_load().unwrap_err();
        assert_eq!(error.at(), "extensions.EXT_lights_ies.lights[1]", "{error}");
        assert!(error.to_string().contains(says), "no '{says}' in {error}");
        assert_eq!(error.exit_status(), 3);
    }
    for bytes in ["", "\0\0\0\0", "TILT=NONE", "TILT=NONE\n"] {
        assert!(lamp(bytes, json!({}), json!({})).try_load().is_err());
    }
    let node = "nodes[1].extensions.EXT_lights_ies";
    for (instance, at) in [
        (json!({"light": 2}), format!("{node}.light")),
        (json!({"light": -1}), format!("{node}.light")),
        (json!({"multiplier": -1}), node.to_owned()),
        (json!({"color": [1, 1]}), format!("{node}.color")),
    ] {
        let error = lamp(good, instance, json!({})).try_load().unwrap_err();
        assert_eq!(error.at(), at, "{error}");
    }
    // A table costs a megabyte.
    let options = LoadOptions {
        max_memory: 1 << 19,
        ..LoadOptions::default()
    };
    let error = load_bytes(&lamp(good, json!({}), json!({})).glb(), &options).unwrap_err();
    assert_eq!(error.exit_status(), 6, "{error}");
}
