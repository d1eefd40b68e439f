//! Which moment of a file is shown, and which of its variants.

use serde_json::{Value, json};

use crate::place::{Place, SMALL, animated, channel, scene, stderr};

fn report(place: &Place, file: &str) -> Value {
    serde_json::from_slice(&place.read(file)).unwrap()
}

#[test]
fn an_animation_is_chosen_by_name_or_number() {
    let place = Place::new();
    let mut moving = animated();
    moving["animations"][1]["name"] = json!("0");
    // One that stands still: those that are placed look at what is there at the moment.
    moving["cameras"] =
        json!([{ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } }]);
    let nodes = moving["nodes"].as_array_mut().unwrap();
    nodes.push(json!({ "camera": 0, "translation": [0, 0, 20] }));
    moving["scenes"][0]["nodes"] = json!([0, 1]);
    place.write("moving.gltf", moving.to_string().as_bytes());
    let run = |name: &str, rest: &str| {
        place.succeed(&format!(
            "render moving.gltf -o {name}.png --report {name}.json --background transparent {rest} --cpu {SMALL}"
        ));
        (
            place.read(&format!("{name}.png")),
            report(&place, &format!("{name}.json"))["moment"].clone(),
        )
    };
    let (rest, moment) = run("rest", "");
    assert_eq!(moment, Value::Null);
    let (first, moment) = run("first", "--time 2");
    assert_eq!(
        moment,
        json!({"animation": "walk", "seconds": 2.0, "shutter": 0.0})
    );
    let (walk, _) = run("walk", "--time 2 --animation walk");
    let (middle, _) = run("middle", "--time 1 --animation walk");
    // A name wins over a number.
    let (jump, moment) = run("jump", "--time 2 --animation 0");
    assert_eq!(
        moment,
        json!({"animation": "0", "seconds": 2.0, "shutter": 0.0})
    );
    let (second, _) = run("second", "--time 2 --animation 1");
    let (start, moment) = run("start", "--shutter 0.5");
    assert_eq!(
        moment,
        json!({"animation": "walk", "seconds": 0.0, "shutter": 0.5})
    );
    assert!(rest == middle && first == walk && jump == second);
    assert!(rest != first && first != jump && rest != jump && start != rest);
    assert_eq!(run("all", "--time 2 --animation all").1["animation"], "all");

    place.fail(
        "render moving.gltf -o a.png --animation 2",
        2,
        "there is no animation '2'; the file has 0 'walk', 1 '0', or 'all'",
    );
}

#[test]
fn a_file_without_animations_says_so() {
    let place = Place::new();
    let output = place.succeed(&format!(
        "render scene.gltf -o a.png --report r.json --time 3 --cpu {SMALL}"
    ));
    let says = "there are no animations: at all times the file is drawn as it rests";
    assert!(stderr(&output).contains(says));
    let report = report(&place, "r.json");
    assert_eq!(report["moment"], Value::Null);
    assert!(report["notes"].as_array().unwrap().contains(&json!(says)));
}

#[test]
fn variants_are_chosen_by_name() {
    let place = Place::new();
    let mut scene = scene();
    scene["extensionsUsed"] = json!(["KHR_materials_variants"]);
    scene["extensions"] =
        json!({"KHR_materials_variants": {"variants": [{"name": "warm"}, {"name": "cold"}]}});
    let blue = json!({ "pbrMetallicRoughness": { "baseColorFactor": [0, 0, 1, 1], "metallicFactor": 0.0 } });
    scene["materials"].as_array_mut().unwrap().push(blue);
    scene["meshes"][0]["primitives"][0]["extensions"] =
        json!({"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [1]}]}});
    place.write("shoe.gltf", scene.to_string().as_bytes());
    let run = |rest: &str| {
        place.succeed(&format!(
            "render shoe.gltf -o a.exr --report r.json {rest} --background transparent --cpu {SMALL}"
        ));
        let sum = |name| channel(&place.read("a.exr"), name).iter().sum::<f32>();
        (
            sum("R") > sum("B"),
            report(&place, "r.json")["variant"].clone(),
        )
    };
    assert_eq!(run(""), (true, Value::Null));
    assert_eq!(run("--variant warm"), (true, json!("warm")));
    assert_eq!(run("--variant cold"), (false, json!("cold")));
    place.fail(
        "render shoe.gltf -o a.png --variant hot",
        2,
        "there is no variant 'hot'; the file has 'warm', 'cold'",
    );
}
