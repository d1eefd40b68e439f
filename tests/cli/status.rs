//! What ends a run, with which status, and that it leaves nothing behind.

use std::fs;

use serde_json::{Value, json};

use crate::place::{Place, SMALL, assert_status, scene, stderr};

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
        ("render scene.gltf -o a.png --env sky:hight=3", "keys"),
        ("render scene.gltf -o a.png --env sky:", "keys"),
        (
            "render scene.gltf -o a.png --env sky:elevation=-1",
            "0 to 90",
        ),
        (
            "render scene.gltf -o a.png --env sky:turbidity=nan",
            "1 to 10",
        ),
        (
            "render scene.gltf -o a.png --env sky:albedo=1,albedo=0",
            "twice",
        ),
        ("render scene.gltf -o a.png --env sky:sun=2", "0 or 1"),
        ("render scene.gltf -o a.png --env 1,-1,0", "from 0"),
        ("render scene.gltf -o a.png --env #12345", "#rrggbb"),
        ("render scene.gltf -o a.png --clamp 0", "greater than 0"),
        ("render scene.gltf -o a.png --clamp -1", "greater than 0"),
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
        ("render scene.gltf -o a.png --time later", "finite"),
        ("render scene.gltf -o a.png --shutter -1", "negative"),
        (
            "render scene.gltf -o a.png --animation walk",
            "the file has none",
        ),
        (
            "render scene.gltf -o a.png --variant red",
            "the file has none",
        ),
        (
            "render scene.gltf -o a{}.png --frames 0..4@25 --time 1",
            "--time",
        ),
        ("render scene.gltf -o a{}.png --frames 0..4", "A..B@FPS"),
        ("render scene.gltf -o a{}.png --frames 4..4@25", "A < B"),
        ("render scene.gltf -o a{}.png --frames 0..4@0", "FPS"),
        ("render scene.gltf -o a{}.png --frames 0..4@25/0", "FPS"),
        ("render scene.gltf -o a{}.png --frames 0..4@nan", "FPS"),
        (
            "render scene.gltf -o a{}.png --frames 0..4000000000@25",
            "at most",
        ),
        (
            "render scene.gltf -o a.png --frames 0..4@25",
            "no place for a number",
        ),
        (
            "render scene.gltf -o a{:x}{0}.png --frames 0..4@25",
            "no place for a number",
        ),
        (
            "render scene.gltf -o a{:04}_{}.png --frames 0..4@25",
            "more than one place",
        ),
        ("render scene.gltf -o - --frames 0..4@25", "many pictures"),
        (
            "render scene.gltf -o a{}.png --report r.json --frames 0..4@25",
            "'r.json' holds no place",
        ),
        (
            "render scene.gltf -o a{}.png -o a{:02}.png --frames 8..12@25",
            "'a10.png' is named as an output more than once",
        ),
        ("render scene.gltf -o a.png --turntable 360", "--frames"),
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
    place.fail(
        "render none.gltf -o missing/{}.png --frames 0..3@25",
        8,
        "missing/0.png",
    );
    fs::create_dir(place.path("folder.png")).unwrap();
    fs::create_dir(place.path("frame_2.png")).unwrap();
    place.fail(
        "render none.gltf -o frame_{}.png --frames 0..3@25",
        8,
        "frame_2.png': it is a folder",
    );
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
}

#[test]
fn strict_names_all_that_is_ignored_and_where() {
    let place = Place::new();
    let mut ignored = scene();
    ignored["extensionsUsed"] = json!(["KHR_materials_volume_scatter", "ACME_paint"]);
    ignored["materials"][0]["extensions"] =
        json!({ "KHR_materials_volume_scatter": { "multiscatterColor": [0.5, 0.5, 0.5] } });
    ignored["nodes"][0]["extensions"] = json!({ "ACME_teapot": {} });
    ignored["extensions"] = json!({ "ACME_teapot": {} });
    ignored["extras"] = json!({ "extensions": { "ACME_lid": {} } });
    place.write("ignored.gltf", ignored.to_string().as_bytes());
    let line = "render ignored.gltf -o a.png --report r.json --cpu --strict";
    place.fail(
        line,
        4,
        "'ignored.gltf' uses what is ignored: ACME_teapot (it is not known; extensions, \
         nodes[0].extensions), KHR_materials_volume_scatter (light is absorbed inside, and not \
         scattered; materials[0].extensions); leave --strict away",
    );
    let said = stderr(&place.run(line));
    assert!(
        !said.contains("ACME_paint") && !said.contains("ACME_lid"),
        "{said}"
    );
    let output = place.succeed(&format!(
        "render ignored.gltf -o a.png --report r.json --cpu {SMALL}"
    ));
    assert!(stderr(&output).contains("note: KHR_materials_volume_scatter"));

    // The record and the listing say the same of each.
    let report: Value = serde_json::from_slice(&place.read("r.json")).unwrap();
    let listing = place.succeed("info ignored.gltf --json").stdout;
    let listing: Value = serde_json::from_slice(&listing).unwrap();
    assert_eq!(report["extensions"], listing["extensions"]);
    assert_eq!(
        report["extensions"][1],
        json!({
            "name": "ACME_teapot", "declared": false, "required": false, "treatment": "ignored",
            "detail": "it is not known", "uses": 2, "places": ["extensions", "nodes[0].extensions"]
        })
    );

    // Named by the file and carried by nothing, the picture lacks nothing for it.
    let mut named = scene();
    named["extensionsUsed"] = json!(["ACME_paint"]);
    place.write("named.gltf", named.to_string().as_bytes());
    place.succeed(&format!(
        "render named.gltf -o a.png --cpu --strict {SMALL}"
    ));
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
    assert!(!text.contains("MESA") && !text.contains("LP_"), "{text}");
    for (name, value, is_told) in [
        ("LP_NATIVE_VECTOR_WIDTH", "512", true),
        ("MESA_SHADER_CACHE_DISABLE", "true", true),
        ("MESA_SHADER_CACHE_DISABLE", "false", false),
        ("MESA_GLSL_CACHE_DISABLE", "1", true),
        ("MESA_SHADER_CACHE_DIR", "scene.gltf/cache", true),
        ("MESA_SHADER_CACHE_DIR", "cache/of/mesa", false),
    ] {
        let output = place.command("doctor").env(name, value).output().unwrap();
        assert_status(&output, 0, name);
        let text = String::from_utf8(output.stdout).unwrap();
        assert_eq!(text.contains(&format!("{name} is")), is_told, "{text}");
        assert_eq!(text.contains("All is well"), !is_told, "{text}");
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
