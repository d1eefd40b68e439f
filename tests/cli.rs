//! The program as its users meet it: exit statuses, messages, files written and not written.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use base64::Engine as _;
use exr::prelude::{ReadChannels, ReadLayers};
use serde_json::{Value, json};

/// A folder for one test with a scene in it, and the program run there.
struct Place(tempfile::TempDir);

impl Place {
    /// Holds `scene.gltf`: one triangle that faces +z, with no camera and no light of its own.
    fn new() -> Place {
        let place = Place(tempfile::tempdir().unwrap());
        place.write("scene.gltf", scene().to_string().as_bytes());
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, bytes: &[u8]) {
        fs::write(self.path(name), bytes).unwrap();
    }

    fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Runs `snell` with the arguments of a line, split at spaces.
    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_snell"));
        command
            .args(line.split_whitespace())
            .current_dir(self.0.path())
            .env_remove("RUST_LOG")
            .env("NODEVICE_SELECT", "1");
        command
    }

    fn run(&self, line: &str) -> Output {
        self.command(line).output().unwrap()
    }

    /// Where the Vulkan loader finds no driver.
    fn run_without_adapter(&self, line: &str) -> Output {
        self.command(line)
            .env("VK_DRIVER_FILES", "/nonexistent")
            .env("VK_ICD_FILENAMES", "/nonexistent")
            .output()
            .unwrap()
    }

    /// Runs and expects success.
    fn succeed(&self, line: &str) -> Output {
        let output = self.run(line);
        assert_status(&output, 0, line);
        output
    }

    /// Runs and expects this status, one line that starts with the program's name and holds `says`,
    /// and no new file.
    fn fail(&self, line: &str, status: i32, says: &str) {
        let before = self.names();
        let output = self.run(line);
        assert_status(&output, status, line);
        let text = stderr(&output);
        assert!(text.contains(says), "{line}: no '{says}' in:\n{text}");
        assert!(text.contains("error: "), "{line}:\n{text}");
        assert!(!text.contains("panicked"), "{line}:\n{text}");
        assert_eq!(before, self.names(), "{line} left a file");
    }

    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(self.0.path())
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

fn scene() -> Value {
    let corners: [[f32; 3]; 3] = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
    let bytes: Vec<u8> = corners
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
        "materials": [{ "pbrMetallicRoughness": { "baseColorFactor": [0.8, 0.4, 0.2, 1.0], "metallicFactor": 0.0 } }],
        "accessors": [{
            "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [-1.0, -1.0, 0.0], "max": [1.0, 1.0, 0.0]
        }],
        "bufferViews": [{ "buffer": 0, "byteLength": bytes.len() }],
        "buffers": [{
            "byteLength": bytes.len(),
            "uri": format!("data:application/octet-stream;base64,{data}")
        }]
    })
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn assert_status(output: &Output, status: i32, line: &str) {
    assert_eq!(
        output.status.code(),
        Some(status),
        "snell {line}\n{}",
        stderr(output)
    );
}

/// Small enough to render in no time.
const SMALL: &str = "--size 16x12 --spp 4";

/// The channels of an EXR file by name.
fn channel(bytes: &[u8], name: &str) -> Vec<f32> {
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(bytes))
        .unwrap();
    let channels = image.layer_data.channel_data.list;
    let found = channels.iter().find(|c| c.name.eq(name));
    found
        .unwrap_or_else(|| panic!("no channel {name}"))
        .sample_data
        .values_as_f32()
        .collect()
}

#[test]
fn wrong_usage_is_status_2_and_writes_nothing() {
    let place = Place::new();
    for (line, says) in [
        ("", "Usage"),
        ("paint scene.gltf", "paint"),
        ("render scene.gltf", "--output"),
        ("render -o a.png", "SCENE"),
        ("render scene.gltf -o a.png --size 0x5", "each side"),
        ("render scene.gltf -o a.png --size 100", "WxH"),
        ("render scene.gltf -o a.png --spp 0", "--spp"),
        (
            "render scene.gltf -o a.png --spp 4 --samples 0..4",
            "--samples",
        ),
        ("render scene.gltf -o a.png --samples 4..4", "A < B"),
        ("render scene.gltf -o a.png --exposure nan", "finite"),
        ("render scene.gltf -o a.png --env-strength -1", "negative"),
        ("render scene.gltf -o a.png --background #12345", "#rrggbb"),
        ("render scene.gltf -o a.png --background -1,0,0", "r,g,b"),
        ("render scene.gltf -o a.png --tonemap reinhard", "neutral"),
        (
            "render scene.gltf -o a.png --cpu --adapter llvmpipe",
            "--adapter",
        ),
        (
            "render scene.gltf -o a.exr --aov normal",
            "not available yet",
        ),
        ("render scene.gltf -o a.exr --aov colour", "variance"),
        ("render scene.gltf -o a.png --aov variance", ".exr"),
        ("render scene.gltf -o a.png --max-memory 12Q", "bytes"),
        ("render scene.gltf -o a.png --crop 10,10,10,0", "one pixel"),
        (
            "render scene.gltf -o a.png --size 16x12 --crop 10,0,7,1",
            "inside",
        ),
        ("render scene.gltf -o a.png --orbit 0,90", "THETA"),
        (
            "render scene.gltf -o a.png --camera 0",
            "the scene has none",
        ),
        ("render scene.gltf -o picture.bmp", "'picture.bmp'"),
        ("render scene.gltf -o picture", ".webp"),
        ("render scene.gltf -o a.png -o a.png", "more than once"),
        ("render scene.gltf -o - --report -", "more than once"),
    ] {
        let output = place.run(line);
        assert_status(&output, 2, line);
        assert!(
            stderr(&output).contains(says),
            "{line}:\n{}",
            stderr(&output)
        );
        assert_eq!(place.names(), ["scene.gltf"], "{line} left a file");
    }
}

#[test]
fn outputs_that_cannot_be_written_are_known_before_loading() {
    let place = Place::new();
    // The scene is missing as well: had it been read, the status would be 3.
    place.fail("render none.gltf -o missing/a.png", 8, "missing/a.png");
    place.fail(
        "render none.gltf -o scene.gltf/a.png",
        8,
        "scene.gltf/a.png",
    );
    place.fail(
        "render none.gltf -o a.png --report missing/r.json",
        8,
        "missing/r.json",
    );
    fs::create_dir(place.path("folder.png")).unwrap();
    place.fail("render none.gltf -o folder.png", 8, "is a folder");
}

#[test]
fn bad_scenes_have_statuses_of_their_own() {
    let place = Place::new();
    place.fail("render none.gltf -o a.png", 3, "none.gltf");

    place.write("cut.glb", b"glTF\x02\0\0\0\xff\0\0\0");
    place.fail("render cut.glb -o a.png", 3, "cut.glb");

    let mut broken = scene();
    broken["accessors"][0]["bufferView"] = json!(7);
    place.write("index.gltf", broken.to_string().as_bytes());
    place.fail("render index.gltf -o a.png", 3, "accessors[0]");

    let mut required = scene();
    required["extensionsUsed"] = json!(["ACME_teapots"]);
    required["extensionsRequired"] = json!(["ACME_teapots"]);
    place.write("required.gltf", required.to_string().as_bytes());
    place.fail("render required.gltf -o a.png", 4, "ACME_teapots");

    let mut ignored = scene();
    ignored["extensionsUsed"] = json!(["KHR_materials_clearcoat"]);
    ignored["materials"][0]["extensions"] =
        json!({ "KHR_materials_clearcoat": { "clearcoatFactor": 1.0 } });
    place.write("ignored.gltf", ignored.to_string().as_bytes());
    place.fail(
        "render ignored.gltf -o a.png --strict",
        4,
        "KHR_materials_clearcoat",
    );
    let output = place.succeed(&format!("render ignored.gltf -o a.png --cpu {SMALL}"));
    assert!(stderr(&output).contains("note: KHR_materials_clearcoat"));
}

#[test]
fn memory_ceilings_are_kept() {
    let place = Place::new();
    place.fail(
        "render scene.gltf -o a.png --size 60000x60000",
        6,
        "--max-memory",
    );
    place.fail(
        "render scene.gltf -o a.png --size 2x2 --max-memory 1K",
        6,
        "--max-memory",
    );
}

#[test]
fn without_an_adapter_the_cpu_renders_and_says_what_to_install() {
    let place = Place::new();
    let line = format!("render scene.gltf -o a.png {SMALL}");
    let output = place.run_without_adapter(&line);
    assert_status(&output, 0, &line);
    let text = stderr(&output);
    let fallback: Vec<&str> = text.lines().filter(|l| l.contains("on the CPU:")).collect();
    assert_eq!(fallback.len(), 1, "{text}");
    assert!(fallback[0].contains("mesa-vulkan-drivers"), "{text}");
    assert!(text.contains("on CPU reference, float64"), "{text}");
    assert_eq!(place.names(), ["a.png", "scene.gltf"]);

    let output = place.run_without_adapter("render scene.gltf -o b.png --adapter llvmpipe");
    assert_status(&output, 5, "--adapter");
    assert!(stderr(&output).contains("llvmpipe"));
    assert!(!place.path("b.png").exists());
}

#[test]
fn an_adapter_that_is_not_there_is_named_with_those_that_are() {
    let place = Place::new();
    place.fail("render scene.gltf -o a.png --adapter Voodoo", 5, "llvmpipe");
}

#[test]
fn doctor_lists_adapters_or_says_what_is_wrong() {
    let place = Place::new();
    let output = place.succeed("doctor");
    let text = String::from_utf8(output.stdout).unwrap();
    for says in [
        "llvmpipe",
        "vulkan",
        "a storage binding",
        "usable    yes",
        "CPU renderer",
    ] {
        assert!(text.contains(says), "no '{says}' in:\n{text}");
    }
    let output = place.run_without_adapter("doctor");
    assert_status(&output, 5, "doctor");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        text.contains("VK_DRIVER_FILES names '/nonexistent'"),
        "{text}"
    );
    assert!(stderr(&output).contains("apt-get install mesa-vulkan-drivers libvulkan1"));
}

#[test]
fn two_runs_give_the_same_bytes_on_each_renderer() {
    let place = Place::new();
    for renderer in ["--cpu", "--adapter llvmpipe"] {
        for name in ["one", "two"] {
            place.succeed(&format!(
                "render scene.gltf -o {name}.exr -o {name}.png --aov variance,samples {renderer} {SMALL}"
            ));
        }
        for ending in ["exr", "png"] {
            let same = place.read(&format!("one.{ending}")) == place.read(&format!("two.{ending}"));
            assert!(same, "{renderer} {ending}");
        }
    }
}

#[test]
fn a_crop_holds_the_bytes_of_the_whole() {
    let place = Place::new();
    for renderer in ["--cpu", "--adapter llvmpipe"] {
        place.succeed(&format!("render scene.gltf -o all.exr {renderer} {SMALL}"));
        place.succeed(&format!(
            "render scene.gltf -o crop.exr --crop 5,3,8,6 {renderer} {SMALL}"
        ));
        let (all, crop) = (place.read("all.exr"), place.read("crop.exr"));
        for name in ["R", "G", "B"] {
            let (all, crop) = (channel(&all, name), channel(&crop, name));
            assert_eq!(crop.len(), 48);
            for (i, value) in crop.iter().enumerate() {
                let (x, y) = (5 + i % 8, 3 + i / 8);
                assert_eq!(*value, all[y * 16 + x], "{renderer} {name} {x},{y}");
            }
        }
    }
}

#[test]
fn a_sample_range_is_that_part_of_the_samples() {
    let place = Place::new();
    for (name, samples) in [("all", "0..8"), ("first", "0..3"), ("rest", "3..8")] {
        place.succeed(&format!(
            "render scene.gltf -o {name}.exr --aov samples --cpu --size 8x6 --samples {samples}"
        ));
    }
    let [all, first, rest] = ["all", "first", "rest"].map(|n| place.read(&format!("{n}.exr")));
    assert!(channel(&rest, "samples").iter().all(|&n| n == 5.0));
    let values = |bytes| channel(bytes, "G").into_iter();
    for ((all, first), rest) in values(&all).zip(values(&first)).zip(values(&rest)) {
        let merged = (3.0 * first + 5.0 * rest) / 8.0;
        assert!((all - merged).abs() <= 1e-5 * all.abs(), "{all} {merged}");
    }
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

#[test]
fn a_transparent_background_has_no_alpha() {
    let place = Place::new();
    place.succeed(&format!(
        "render scene.gltf -o a.png --background transparent --cpu {SMALL}"
    ));
    let image = image::open(place.path("a.png")).unwrap().to_rgba8();
    assert_eq!(image.get_pixel(0, 0).0, [0; 4]);
    assert_eq!(image.get_pixel(8, 7).0[3], 255);
    place.succeed(&format!(
        "render scene.gltf -o b.png --background #ff0000 --tonemap linear --cpu {SMALL}"
    ));
    let image = image::open(place.path("b.png")).unwrap().to_rgb8();
    assert_eq!(image.get_pixel(0, 0).0, [255, 0, 0]);
}

#[test]
fn a_dash_is_a_png_on_standard_output() {
    let place = Place::new();
    let output = place.succeed(&format!("render scene.gltf -o - --cpu {SMALL}"));
    let image = image::load_from_memory(&output.stdout).unwrap();
    assert_eq!((image.width(), image.height()), (16, 12));
    assert_eq!(place.names(), ["scene.gltf"]);
}

#[test]
fn progress_is_plain_lines_and_quiet_is_silent() {
    let place = Place::new();
    let output = place.succeed(&format!("render scene.gltf -o a.png --cpu {SMALL}"));
    let text = stderr(&output);
    let lines: Vec<&str> = text.lines().collect();
    let progress = lines.iter().filter(|l| l.contains("% rendered")).count();
    assert!((1..=3).contains(&progress), "{text}");
    assert!(!text.contains('\r') && !text.contains('\x1b'), "{text:?}");
    let last = lines.last().unwrap();
    for says in [
        "scene.gltf",
        "a.png",
        "16x12",
        "4 samples a pixel",
        "float64",
        " in ",
        "error ",
    ] {
        assert!(last.contains(says), "no '{says}' in: {last}");
    }
    assert!(output.stdout.is_empty());

    let output = place.succeed(&format!("render scene.gltf -o a.png --cpu --quiet {SMALL}"));
    assert_eq!(stderr(&output), "");
}

#[test]
fn a_black_picture_is_said_to_be_black() {
    let place = Place::new();
    let output = place.succeed(&format!(
        "render scene.gltf -o a.png --env-strength 0 --cpu --quiet {SMALL}"
    ));
    assert!(stderr(&output).contains("warning: the picture is black"));
}

/// The part of JSON Schema (2020-12) that schema/report.schema.json uses.
fn validate(schema: &Value, root: &Value, value: &Value, at: &str) {
    if let Some(target) = schema["$ref"].as_str() {
        let found = root.pointer(target.trim_start_matches('#')).unwrap();
        return validate(found, root, value, at);
    }
    if let Some(choices) = schema["anyOf"].as_array() {
        let null = choices.iter().any(|c| c["type"] == "null");
        if null && value.is_null() {
            return;
        }
        return validate(&choices[0], root, value, at);
    }
    if let Some(allowed) = schema["enum"].as_array() {
        assert!(allowed.contains(value), "{at}: {value}");
        return;
    }
    let fits = match schema["type"].as_str().unwrap() {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "integer" => value.is_u64() || value.is_i64(),
        "number" => value.is_number(),
        "boolean" => value.is_boolean(),
        other => panic!("{at}: the schema has type {other}"),
    };
    assert!(fits, "{at}: {value} is no {}", schema["type"]);
    if let Some(least) = schema["minimum"].as_f64() {
        assert!(value.as_f64().unwrap() >= least, "{at}: {value}");
    }
    if schema["pattern"] == "^fnv1a64:[0-9a-f]{16}$" {
        let digits = value.as_str().unwrap().strip_prefix("fnv1a64:").unwrap();
        assert!(digits.len() == 16 && digits.chars().all(|c| c.is_ascii_hexdigit()));
    }
    for key in schema["required"].as_array().into_iter().flatten() {
        assert!(value.get(key.as_str().unwrap()).is_some(), "{at}: no {key}");
    }
    for (key, item) in value.as_object().into_iter().flatten() {
        let at = format!("{at}.{key}");
        match (
            schema["properties"].get(key),
            &schema["additionalProperties"],
        ) {
            (Some(schema), _) => validate(schema, root, item, &at),
            (None, Value::Bool(false)) => panic!("{at} is not in the schema"),
            (None, Value::Null) => {}
            (None, schema) => validate(schema, root, item, &at),
        }
    }
    let items = value.as_array().map_or(&[][..], Vec::as_slice);
    if let Some(least) = schema["minItems"].as_u64() {
        assert!(items.len() as u64 >= least, "{at}");
    }
    if let Some(most) = schema["maxItems"].as_u64() {
        assert!(items.len() as u64 <= most, "{at}");
    }
    for (i, item) in items.iter().enumerate() {
        validate(&schema["items"], root, item, &format!("{at}[{i}]"));
    }
}

#[test]
fn the_report_has_every_promised_field() {
    let schema = fs::read("schema/report.schema.json").unwrap();
    let schema: Value = serde_json::from_slice(&schema).unwrap();
    let place = Place::new();
    for (renderer, kind) in [("--cpu", "cpu"), ("--adapter llvmpipe", "gpu")] {
        place.succeed(&format!(
            "render scene.gltf -o a.png --report r.json --seed 3 {renderer} {SMALL}"
        ));
        let report: Value = serde_json::from_slice(&place.read("r.json")).unwrap();
        validate(&schema, &schema, &report, "report");
        assert_eq!(report["adapter"]["renderer"], kind);
        assert_eq!(report["seed"], 3);
        assert_eq!(report["samples"], json!([0, 4]));
        assert_eq!(report["crop"], json!([0, 0, 16, 12]));
        assert_eq!(report["camera"], "auto");
        assert_eq!(report["outputs"], json!(["a.png"]));
        assert_eq!(report["non_finite_samples"], 0);
        assert!(report["rays"]["closest"].as_u64().unwrap() >= 16 * 12 * 4);
        assert!(report["memory"]["packed"]["triangles"].as_u64().unwrap() > 0);
        assert_eq!(report["scene"]["file"], "scene.gltf");
        if kind == "gpu" {
            assert!(
                report["adapter"]["name"]
                    .as_str()
                    .unwrap()
                    .contains("llvmpipe")
            );
            assert!(report["limits"]["max_buffer_size"].as_u64().unwrap() > 0);
        }
    }
}
