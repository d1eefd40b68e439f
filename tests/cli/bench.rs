//! `snell bench`, and what `snell render -v` says of its stages.

use std::fs;

use serde_json::Value;

use crate::json_schema::validate;
use crate::place::{Place, SMALL, stderr};

const QUICK: &str = "--size 24x16 --spp 2 --repetitions 2";

/// Measures, holds the answer against the schema, and checks that its numbers belong together.
fn measured(place: &Place, line: &str) -> Value {
    let output = place.succeed(&format!("bench {line} {QUICK} --json"));
    let schema: Value =
        serde_json::from_slice(&fs::read("schema/bench.schema.json").unwrap()).unwrap();
    let bench: Value = serde_json::from_slice(&output.stdout).unwrap();
    validate(&schema, &schema, &bench).unwrap();
    assert_eq!(bench["paths"], 24 * 16 * 2);
    assert!(bench["rays"]["closest"].as_u64().unwrap() >= 24 * 16 * 2);
    let number = |value: &Value| value.as_f64().unwrap();
    let rate = |count: &str, value: &Value| {
        let expected = bench["rays"][count].as_f64().unwrap() / number(value) * 1e-3;
        assert!(expected.is_finite());
        expected
    };
    let close = |a: f64, b: f64| assert!((a - b).abs() <= 1e-9 * b.abs(), "{a} {b}");
    let render = &bench["render_ms"]["median"];
    close(
        number(&bench["mpaths"]),
        number(&bench["paths"]) / number(render) * 1e-3,
    );
    for kind in ["closest", "shadow"] {
        close(number(&bench["mrays"][kind]), rate(kind, render));
    }
    close(
        number(&bench["bvh_mtriangles"]),
        number(&bench["triangles"]) / number(&bench["bvh_ms"]["median"]) * 1e-3,
    );
    let first = number(&bench["first_picture_ms"]);
    let stages = &bench["first_picture_times_ms"];
    let parts: f64 = ["load", "pack", "upload", "compile", "render"]
        .iter()
        .filter_map(|stage| stages[*stage].as_f64())
        .sum();
    assert!(parts > 0.0 && parts <= first, "{parts} of {first}");
    bench
}

#[test]
fn an_adapter_is_measured_stage_by_stage() {
    let place = Place::new();
    let bench = measured(&place, "scene.gltf --adapter llvmpipe");
    assert_eq!(bench["scene"], "scene.gltf");
    assert_eq!(bench["triangles"], 1);
    assert_eq!(bench["adapter"]["renderer"], "gpu");
    let stages: Vec<&str> = bench["stages_ms"]
        .as_array()
        .unwrap()
        .iter()
        .map(|stage| stage["name"].as_str().unwrap())
        .collect();
    assert_eq!(stages, snell::gpu::wavefront::STAGES);
    let traced = bench["traced_mrays"]["closest"].as_f64().unwrap();
    assert!(traced > 0.0);
}

#[test]
fn the_reference_is_measured_on_the_scene_in_memory() {
    let place = Place::new();
    let bench = measured(&place, "--cpu");
    assert!(bench["scene"].is_null());
    assert!(bench["load_ms"].is_null());
    assert!(bench["stages_ms"].is_null());
    assert!(bench["triangles"].as_u64().unwrap() > 100_000);
    assert_eq!(bench["adapter"]["renderer"], "cpu");
    assert_eq!(place.names(), ["scene.gltf"]);

    let output = place.succeed(&format!("bench scene.gltf --cpu {QUICK}"));
    let text = String::from_utf8(output.stdout).unwrap();
    for says in [
        "CPU reference",
        "first picture",
        "Mpaths/s",
        "Mtriangles/s",
        "scene.gltf",
    ] {
        assert!(text.contains(says), "no '{says}' in:\n{text}");
    }
}

#[test]
fn what_cannot_be_measured_has_its_status() {
    let place = Place::new();
    place.fail("bench none.gltf --cpu", 3, "none.gltf");
    place.fail("bench --adapter Voodoo", 5, "llvmpipe");
    place.fail("bench --cpu --env sky", 2, "--env lights a SCENE");
    place.fail("bench scene.gltf --cpu --max-memory 1", 6, "--max-memory");
    let output = place.run("bench --repetitions 0");
    assert_eq!(output.status.code(), Some(2));
}

/// One line for each stage, on standard error, by -v alone.
#[test]
fn stages_are_said_with_their_times() {
    let place = Place::new();
    let stages = |line: &str| -> Vec<String> {
        let said = stderr(&place.succeed(line));
        let times = said.lines().filter_map(|line| {
            let line = line.strip_prefix("snell: ")?.strip_suffix(" ms")?;
            let (name, time) = line.rsplit_once(' ')?;
            assert!(time.parse::<f64>().unwrap() >= 0.0, "{line}");
            Some(name.trim_end().to_owned())
        });
        times.collect()
    };
    let line = format!("render scene.gltf -o a.png {SMALL}");
    assert_eq!(
        stages(&format!("{line} --adapter llvmpipe -v")),
        [
            "load",
            "images (of load)",
            "pack",
            "geometry (of pack)",
            "open adapter, meanwhile",
            "upload",
            "compile",
            "render",
            "encode",
            "write"
        ]
    );
    assert!(stages(&format!("{line} --cpu")).is_empty());
    let of_cpu = stages(&format!("{line} --cpu -v"));
    assert!(!of_cpu.contains(&"compile".to_owned()) && of_cpu.contains(&"render".to_owned()));
}
