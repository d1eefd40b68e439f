//! Runs repeat byte for byte, and the record of a run is whole.

use std::fs;

use serde_json::{Value, json};

use crate::json_schema::validate;
use crate::place::{Place, SMALL, channel, stderr};

/// Renders twice and once in part; checks that the bytes are the same and the report is whole. All
/// in one, since each run on lavapipe compiles the kernels anew.
fn repeats_itself(renderer: &str, kind: &str) {
    let place = Place::new();
    let run = |rest: &str| {
        place.succeed(&format!(
            "render scene.gltf {rest} --aov variance,samples --seed 3 {renderer} {SMALL}"
        ));
    };
    run("-o one.exr -o one.png --report one.json");
    run("-o two.exr -o two.png");
    run("-o crop.exr --crop 5,3,8,6");
    for ending in ["exr", "png"] {
        let same = place.read(&format!("one.{ending}")) == place.read(&format!("two.{ending}"));
        assert!(same, "{renderer} {ending}");
    }
    let (all, crop) = (place.read("one.exr"), place.read("crop.exr"));
    for name in ["R", "G", "B", "variance.G"] {
        let (all, crop) = (channel(&all, name), channel(&crop, name));
        assert_eq!(crop.len(), 48);
        for (i, value) in crop.iter().enumerate() {
            let (x, y) = (5 + i % 8, 3 + i / 8);
            assert_eq!(*value, all[y * 16 + x], "{renderer} {name} {x},{y}");
        }
    }
    check_report(&place.read("one.json"), kind);
}

#[test]
fn runs_repeat_and_crops_agree_on_the_cpu() {
    repeats_itself("--cpu", "cpu");
}

#[test]
fn runs_repeat_and_crops_agree_on_lavapipe() {
    repeats_itself("--adapter llvmpipe", "gpu");
}

/// Every promised field is there and nothing else.
fn check_report(bytes: &[u8], kind: &str) {
    let schema = fs::read("schema/report.schema.json").unwrap();
    let schema: Value = serde_json::from_slice(&schema).unwrap();
    let report: Value = serde_json::from_slice(bytes).unwrap();
    validate(&schema, &schema, &report).unwrap();
    assert_eq!(report["adapter"]["renderer"], kind);
    assert_eq!(report["seed"], 3);
    assert_eq!(report["samples"], json!([0, 4]));
    assert_eq!(report["crop"], json!([0, 0, 16, 12]));
    assert_eq!(report["camera"], "auto");
    assert_eq!(report["outputs"], json!(["one.exr", "one.png"]));
    assert_eq!(report["non_finite_samples"], 0);
    assert!(report["rays"]["closest"].as_u64().unwrap() >= 16 * 12 * 4);
    assert!(report["memory"]["packed"]["triangles"].as_u64().unwrap() > 0);
    assert_eq!(report["scene"]["file"], "scene.gltf");
    if kind == "gpu" {
        let name = report["adapter"]["name"].as_str().unwrap();
        assert!(name.contains("llvmpipe"), "{name}");
        assert!(report["limits"]["max_buffer_size"].as_u64().unwrap() > 0);
    }
}

/// Clamped samples are as bright as the limit at most, and said to be clamped.
fn clamps(renderer: &str) {
    let place = Place::new();
    let run = |rest: &str| {
        let line = format!("render scene.gltf {rest} --env-strength 40 {renderer} {SMALL}");
        stderr(&place.succeed(&line))
    };
    let brightest = |file: &str| {
        let bytes = place.read(file);
        let channels = ["R", "G", "B"].map(|name| channel(&bytes, name));
        channels.concat().into_iter().fold(0.0, f32::max)
    };
    let report = |file: &str| -> Value { serde_json::from_slice(&place.read(file)).unwrap() };

    let said = run("-o free.exr --report free.json");
    assert!(!said.contains("clamped"), "{said}");
    assert!(brightest("free.exr") > 3.0);
    assert!(report("free.json")["clamp"].is_null());
    assert!(report("free.json")["clamped_samples"].is_null());

    let said = run("-o clamped.exr --clamp 1.5 --report clamped.json");
    let report = report("clamped.json");
    let samples = report["clamped_samples"].as_u64().unwrap();
    assert!(
        said.contains(&format!("{samples} samples clamped to 1.5")),
        "{said}"
    );
    assert!((brightest("clamped.exr") - 1.5).abs() < 1e-5);
    assert_eq!(report["clamp"], 1.5);
    assert!(samples > 0 && samples <= 16 * 12 * 4, "{samples}");
    let header = place.read("clamped.exr");
    let header = String::from_utf8_lossy(&header[..4096.min(header.len())]);
    assert!(header.contains(r#""clamp":1.5"#));

    let said = run("-o generous.exr --clamp 1000000");
    assert!(said.contains("0 samples clamped"), "{said}");
    let same = channel(&place.read("free.exr"), "G") == channel(&place.read("generous.exr"), "G");
    assert!(same, "a limit above all samples changes nothing");
}

#[test]
fn samples_are_clamped_on_request_on_the_cpu() {
    clamps("--cpu");
}

#[test]
fn samples_are_clamped_on_request_on_lavapipe() {
    clamps("--adapter llvmpipe");
}

#[test]
fn exr_holds_the_channels_asked_for_and_the_facts() {
    let place = Place::new();
    place.succeed(&format!(
        "render scene.gltf -o a.exr --aov variance,samples --cpu --seed 9 {SMALL}"
    ));
    let bytes = place.read("a.exr");
    assert!(channel(&bytes, "A").iter().all(|&a| a == 1.0));
    assert!(channel(&bytes, "samples").iter().all(|&n| n == 4.0));
    assert!(channel(&bytes, "variance.G").iter().any(|&v| v > 0.0));
    assert!(channel(&bytes, "R").iter().any(|&v| v > 0.0));
    let text = String::from_utf8_lossy(&bytes[..4096.min(bytes.len())]).into_owned();
    for says in [
        r#""seed":9"#,
        r#""packed_hash":"fnv1a64:"#,
        r#""renderer":"cpu""#,
    ] {
        assert!(text.contains(says), "no {says}");
    }
    assert!(!text.contains("times_ms"), "times change from run to run");
}

/// A computed environment stands in the record as a text that makes the same picture.
#[test]
fn computed_environments_are_recorded_by_their_text() {
    let place = Place::new();
    for (given, kept) in [
        ("0.5,1,2", "0.5,1,2"),
        ("#ffffff", "1,1,1"),
        (
            "sky",
            "sky:elevation=30,azimuth=45,turbidity=3,albedo=0.2,sun=1",
        ),
        (
            "sky:sun=0,elevation=5.5,azimuth=-120",
            "sky:elevation=5.5,azimuth=-120,turbidity=3,albedo=0.2,sun=0",
        ),
    ] {
        let run = |environment: &str, name: &str| {
            place.succeed(&format!(
                "render scene.gltf -o {name}.exr --report {name}.json --cpu --env {environment} {SMALL}"
            ));
        };
        run(given, "one");
        run(kept, "two");
        let report: Value = serde_json::from_slice(&place.read("one.json")).unwrap();
        let schema: Value =
            serde_json::from_slice(&fs::read("schema/report.schema.json").unwrap()).unwrap();
        validate(&schema, &schema, &report).unwrap();
        assert_eq!(report["environment"], kept);
        assert!(place.read("one.exr") == place.read("two.exr"), "{given}");
        if given == "0.5,1,2" {
            let bytes = place.read("one.exr");
            // The corner shows what is behind the triangle.
            assert_eq!(
                ["R", "G", "B"].map(|c| channel(&bytes, c)[0]),
                [0.5, 1.0, 2.0]
            );
        }
    }
}
