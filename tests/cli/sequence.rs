//! Frames: their names, their noise, the camera's turn, and what is left when one fails.

use serde_json::{Value, json};

use crate::place::{Place, SMALL, animated, assert_status, channel, scene, stderr};

#[test]
fn each_frame_goes_to_a_place_of_its_own() {
    let place = Place::new();
    let output = place.succeed(&format!(
        "render scene.gltf -o f_{{:03}}.png -o {{}}.exr -o {{:4}}.jpg --report r{{}}.json \
         --frames 9..11@30000/1001 --seed 5 --cpu {SMALL}"
    ));
    assert_eq!(
        place.names(),
        [
            "   9.jpg",
            "  10.jpg",
            "10.exr",
            "9.exr",
            "f_009.png",
            "f_010.png",
            "r10.json",
            "r9.json",
            "scene.gltf"
        ]
    );
    let text = stderr(&output);
    let lines: Vec<&str> = text.lines().collect();
    let frames = lines.iter().filter(|l| l.contains("scene.gltf -> f_"));
    assert_eq!(frames.count(), 2, "{text}");
    assert!(!text.contains("% rendered"), "{text}");
    let last = lines.last().unwrap();
    assert!(
        last.contains("scene.gltf: 2 frames in ") && last.ends_with(" each"),
        "{last}"
    );
    let notes = lines
        .iter()
        .filter(|l| l.contains("there are no animations"));
    assert_eq!(notes.count(), 1, "{text}");

    let report: Value = serde_json::from_slice(&place.read("r10.json")).unwrap();
    assert_eq!(report["frame"], 10);
    assert_eq!(
        report["outputs"],
        json!(["f_010.png", "10.exr", "  10.jpg"])
    );
    // What a record says makes the frame again.
    let seed = &report["seed"];
    place.succeed(&format!(
        "render scene.gltf -o again.png --seed {seed} --cpu {SMALL}"
    ));
    assert_eq!(place.read("again.png"), place.read("f_010.png"));

    let quiet = place.succeed(&format!(
        "render scene.gltf -o {{}}.png --frames 0..2@1 --cpu -q {SMALL}"
    ));
    assert_eq!(stderr(&quiet), "");
}

#[test]
fn braces_are_part_of_a_name_where_there_are_no_frames() {
    let place = Place::new();
    place.succeed(&format!(
        "render scene.gltf -o a{{}}{{:02}}.png --cpu {SMALL}"
    ));
    assert_eq!(place.names(), ["a{}{:02}.png", "scene.gltf"]);
}

/// A frame is the same whichever others are made beside it, and its noise is no other's.
fn frames_stand_for_themselves(renderer: &str) {
    let place = Place::new();
    place.write("moving.gltf", animated().to_string().as_bytes());
    for (file, orbit) in [("scene", "--orbit 20,80,5"), ("moving", "--camera auto")] {
        let run = |rest: &str| {
            place.succeed(&format!(
                "render {file}.gltf {rest}@4 {orbit} --seed 2 {renderer} {SMALL}"
            ));
        };
        run(&format!(
            "-o {file}_{{}}.exr -o {file}_{{}}.png --frames 0..4"
        ));
        run(&format!("-o {file}_alone_{{}}.exr --frames 3..4"));
        let same =
            place.read(&format!("{file}_3.exr")) == place.read(&format!("{file}_alone_3.exr"));
        assert!(same, "{renderer}, {file}: a frame alone and among others");
        let frames =
            [0, 1, 2, 3].map(|frame| channel(&place.read(&format!("{file}_{frame}.exr")), "G"));
        for (a, one) in frames.iter().enumerate() {
            assert!(
                !frames[..a].contains(one),
                "{renderer}, {file}: frame {a} has another's noise"
            );
        }
        place.succeed(&format!(
            "render {file}.gltf -o single.png --time 0 --orbit 20,80,5 --seed 2 {renderer} {SMALL}"
        ));
        if file == "scene" {
            let same = place.read("single.png") == place.read("scene_0.png");
            assert!(same, "{renderer}: the first frame and a single picture");
        }
    }
}

#[test]
fn frames_stand_for_themselves_on_the_cpu() {
    frames_stand_for_themselves("--cpu");
}

#[test]
fn frames_stand_for_themselves_on_lavapipe() {
    frames_stand_for_themselves("--adapter llvmpipe");
}

#[test]
fn frames_before_one_that_fails_stay() {
    let place = Place::new();
    // As long as a name may be with one digit; with two the system refuses it.
    let name = "f".repeat(255 - "9.png".len());
    let line = format!("render scene.gltf -o {name}{{}}.png --frames 8..12@1 --cpu {SMALL}");
    let output = place.run(&line);
    assert_status(&output, 8, &line);
    let text = stderr(&output);
    let last = text.lines().last().unwrap();
    assert!(
        last.starts_with("snell: error: frame 10: cannot write"),
        "{last}"
    );
    assert!(
        last.ends_with("(2 frames were written before it)"),
        "{last}"
    );
    assert_eq!(
        place.names(),
        [
            format!("{name}8.png"),
            format!("{name}9.png"),
            "scene.gltf".into()
        ]
    );
}

/// How much of each frame is covered, and the mean column of it.
fn coverage(place: &Place, file: &str) -> (f32, f32) {
    let alpha = channel(&place.read(file), "A");
    let sum: f32 = alpha.iter().sum();
    let columns = alpha.iter().enumerate().map(|(i, a)| (i % 16) as f32 * a);
    (sum, columns.sum::<f32>() / sum)
}

#[test]
fn a_turntable_goes_round_counter_clockwise() {
    let place = Place::new();
    let mut sideways = scene();
    // Faces +x, and is seen from there alone.
    sideways["nodes"][0]["rotation"] = json!([0.0, 0.5_f64.sqrt(), 0.0, 0.5_f64.sqrt()]);
    place.write("sideways.gltf", sideways.to_string().as_bytes());
    let run = |more: &str| {
        place.succeed(&format!(
            "render sideways.gltf --frames 0..4@1 --background transparent {more} --cpu {SMALL}"
        ))
    };
    let output = run("-o t{}.exr --report r{}.json --orbit 0,90,4 --turntable 360");
    assert!(!stderr(&output).contains("no animations"));
    let covered = [0, 1, 2, 3].map(|frame| coverage(&place, &format!("t{frame}.exr")).0);
    assert!(covered[1] > 20.0 && covered[3] == 0.0, "{covered:?}");
    assert!(covered[0] < 5.0 && covered[2] < 5.0, "{covered:?}");
    let report: Value = serde_json::from_slice(&place.read("r1.json")).unwrap();
    assert_eq!(report["camera"], "orbit 0,90,4 turned by 90");

    run("-o b{}.exr --orbit 0,90,4 --turntable -360");
    assert_eq!(coverage(&place, "b1.exr").0, 0.0);
    assert!(coverage(&place, "b3.exr").0 > 20.0);

    // A camera that frames everything does so from all sides.
    let mut wide = scene();
    wide["nodes"] = json!([{ "children": [1, 2] }, { "mesh": 0, "translation": [9.0, 0.0, 0.0] },
        { "mesh": 0, "translation": [-9.0, 0.0, 0.0] }]);
    wide["materials"][0]["doubleSided"] = json!(true);
    place.write("wide.gltf", wide.to_string().as_bytes());
    place.succeed(
        "render wide.gltf --frames 0..8@1 --background transparent -o w{}.exr --turntable 360 --cpu --size 80x60 --spp 1",
    );
    for frame in 0..8 {
        let alpha = channel(&place.read(&format!("w{frame}.exr")), "A");
        for (i, &a) in alpha.iter().enumerate() {
            let (x, y) = (i % 80, i / 80);
            let rim = x == 0 || x == 79 || y == 0 || y == 59;
            assert!(!rim || a == 0.0, "frame {frame}: {x},{y} is covered");
        }
        assert!(alpha.iter().any(|&a| a > 0.0), "frame {frame}");
    }
}

#[test]
fn a_turntable_goes_round_what_the_camera_looks_at() {
    let place = Place::new();
    let mut apart = scene();
    apart["nodes"] = json!([{ "children": [1, 2] }, { "mesh": 0, "translation": [9.0, 0.0, 0.0] },
        { "mesh": 0, "translation": [0.0, 9.0, 0.0] }]);
    apart["materials"][0]["doubleSided"] = json!(true);
    place.write("apart.gltf", apart.to_string().as_bytes());
    place.succeed(&format!(
        "render apart.gltf --frames 0..2@1 --background transparent -o a{{}}.exr --orbit 0,90,4,9,0,0 \
         --turntable 360 --cpu {SMALL}"
    ));
    let [front, back] = [0, 1].map(|frame| coverage(&place, &format!("a{frame}.exr")).0);
    assert!(front > 20.0 && back > 20.0, "{front} and {back}");

    // A camera of the file turns about what it shows, here from above: the other triangle is where the axis
    // is nearest to the scene's centre.
    let tilt = 0.25 * std::f64::consts::PI;
    apart["cameras"] =
        json!([{ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.01 } }]);
    apart["nodes"][0]["children"] = json!([1, 2, 3]);
    apart["nodes"].as_array_mut().unwrap().push(json!({
        "camera": 0, "translation": [9.0, 3.0, 3.0],
        "rotation": [-(0.5 * tilt).sin(), 0.0, 0.0, (0.5 * tilt).cos()],
    }));
    place.write("apart.gltf", apart.to_string().as_bytes());
    place.succeed(&format!(
        "render apart.gltf --frames 0..4@1 --background transparent -o c{{}}.exr --turntable 360 \
         --cpu {SMALL}"
    ));
    for frame in [0, 2] {
        let (covered, _) = coverage(&place, &format!("c{frame}.exr"));
        assert!(covered > 10.0, "frame {frame}: {covered}");
    }
}

#[test]
fn the_framing_does_not_follow_what_moves() {
    let place = Place::new();
    place.write("moving.gltf", animated().to_string().as_bytes());
    place.succeed(&format!(
        "render moving.gltf -o m{{}}.exr --frames 0..3@1 --background transparent --cpu {SMALL}"
    ));
    let columns = [0, 1, 2].map(|frame| coverage(&place, &format!("m{frame}.exr")).1);
    // From left to right, as far as the picture goes.
    assert!(columns[0] < 5.0 && columns[2] > 10.0, "{columns:?}");
    assert!(
        (columns[0] + columns[2] - 2.0 * columns[1]).abs() < 1.0,
        "{columns:?}"
    );
}
