//! `snell bench`, and what `snell render -v` says of its stages.

use std::fs;
use std::io::Cursor;
use std::time::Instant;

use serde_json::{Value, json};

use crate::json_schema::validate;
use crate::place::{Place, SMALL, scene, stderr};

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
    let parts: f64 = ["load", "pack", "upload", "render"]
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

/// A line for each stage and its key in the record's `times_ms`, in order; the record ends before its files are
/// written.
const STAGES: [(&str, &str); 10] = [
    ("load", "load"),
    ("images (of load)", "images"),
    ("pack", "pack"),
    ("geometry (of pack)", "geometry"),
    ("open adapter, meanwhile", "open_adapter"),
    ("upload", "upload"),
    ("compile, partly meanwhile", "compile"),
    ("render", "render"),
    ("encode", "encode"),
    ("write", ""),
];

/// The lines of `-v`: names, and milliseconds as they are written.
fn stages(place: &Place, line: &str) -> Vec<(String, String)> {
    let said = stderr(&place.succeed(line));
    let times = said.lines().filter_map(|line| {
        let line = line.strip_prefix("snell: ")?.strip_suffix(" ms")?;
        let (name, time) = line.rsplit_once(' ')?;
        Some((name.trim_end().to_owned(), time.to_owned()))
    });
    times.collect()
}

/// The scene with a picture on it, whose decoding takes its time.
fn textured(place: &Place) {
    let mut png = Cursor::new(Vec::new());
    image::RgbImage::from_fn(256, 256, |x, y| {
        image::Rgb([x as u8, y as u8, (x * y) as u8])
    })
    .write_to(&mut png, image::ImageFormat::Png)
    .unwrap();
    place.write("picture.png", png.get_ref());
    let mut scene = scene();
    scene["images"] = json!([{ "uri": "picture.png" }]);
    scene["textures"] = json!([{ "source": 0 }]);
    scene["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": 0 });
    place.write("textured.gltf", scene.to_string().as_bytes());
}

/// One line for each stage, on standard error, by -v alone; each has a time, and that of the record.
#[test]
fn stages_are_said_with_their_times() {
    let place = Place::new();
    textured(&place);
    // Many pixels, so that no stage is too short to be seen in tenths of milliseconds.
    let line = "render textured.gltf -o a.exr --report r.json --size 256x256 --spp 1";
    for (renderer, lacks) in [
        ("--adapter llvmpipe", &[][..]),
        ("--cpu", &["upload", "compile, partly meanwhile"]),
    ] {
        let start = Instant::now();
        let said = stages(&place, &format!("{line} {renderer} -v"));
        let wall = start.elapsed().as_secs_f64() * 1e3;
        let report: Value = serde_json::from_slice(&place.read("r.json")).unwrap();
        let expected = STAGES.iter().filter(|(name, _)| !lacks.contains(name));
        let names: Vec<&str> = expected.clone().map(|(name, _)| *name).collect();
        let said_names: Vec<&str> = said.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(said_names, names);
        for ((_, key), (name, time)) in expected.zip(&said) {
            if let Some(exact) = report["times_ms"][key].as_f64() {
                assert_eq!(*time, format!("{exact:.1}"), "{name}");
                // Without a device there is none to open, but the file's stages are there.
                let opens_none = renderer == "--cpu" && *key == "open_adapter";
                assert!(opens_none || exact > 0.0, "{name}: {said:?}");
            } else {
                assert!(
                    key.is_empty() && time.parse::<f64>().unwrap() > 0.0,
                    "{name}"
                );
            }
        }
        let time = |name: &str| -> f64 {
            let found = said.iter().find(|(said, _)| said == name);
            found.map_or(0.0, |(_, time)| time.parse().unwrap())
        };
        assert!(time("images (of load)") <= time("load"));
        assert!(time("geometry (of pack)") <= time("pack"));
        // Kernels may be compiled beside other work.
        let one_by_one = ["load", "pack", "upload", "render", "encode", "write"];
        let sum: f64 = one_by_one.map(time).iter().sum();
        // What is rounded up is at most half a tenth a stage.
        assert!(sum <= wall + 0.3, "{sum} of {wall}: {said:?}");
    }
    let quiet = format!("render scene.gltf -o b.png {SMALL} --cpu");
    assert!(stages(&place, &quiet).is_empty());
}
