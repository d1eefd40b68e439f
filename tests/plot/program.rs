//! The program.

use crate::parse_svg;
use crate::place::{Place, scene, stderr};
use serde_json::{Value, json};

#[test]
fn the_program_draws_the_same_bytes_again() {
    let place = Place::new();
    for (line, word) in [
        ("fresnel --eta 1.5", "Brewster angle 56.3°"),
        ("fresnel --metal Au", "Au (Johnson and Christy 1972)"),
        ("lobe rough-gold --theta 20", "viewer at 20°"),
        ("albedo rough-plastic --roughness 0.5", "roughness 0.5"),
        (
            "sphere rough-gold --theta 30 --phi -90",
            "θ = 30°, φ = -90°",
        ),
    ] {
        place.succeed(&format!("plot {line} -o a.svg -o a.png"));
        place.succeed(&format!("plot {line} -o b.png -o b.SVG"));
        assert!(place.read("a.svg") == place.read("b.SVG"), "{line}: a.svg");
        assert!(place.read("a.png") == place.read("b.png"), "{line}: a.png");
        assert!(place.read("a.png").starts_with(b"\x89PNG"), "{line}");
        let text = String::from_utf8(place.read("a.svg")).unwrap();
        let found = parse_svg(&text).iter().any(|w| w.contains(word));
        assert!(found, "{line}: no {word}");
    }
    place.succeed("plot fresnel --eta 1.5 -o a.svg");
    let output = place.succeed("plot fresnel --eta 1.5 -o -");
    assert!(place.read("a.svg") == output.stdout);
}

#[test]
fn materials_come_from_files_too() {
    let place = Place::new();
    let rough = json!({"name": "rough-plastic", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0, "roughnessFactor": 0.6}});
    let preset = place.succeed("plot lobe rough-plastic -o -").stdout;
    place.write("material.json", rough.to_string().as_bytes());
    let output = place.succeed("plot lobe --material material.json -o -");
    assert_eq!(
        (output.stdout.as_slice(), stderr(&output).as_str()),
        (preset.as_slice(), "")
    );

    let mut textured = rough.clone();
    textured["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
    textured["normalTexture"] = json!({"index": 0});
    let mut file = scene();
    file["materials"] = json!([{ "name": "other" }, rough, textured]);
    file["materials"][2]["name"] = json!("textured");
    place.write("materials.gltf", file.to_string().as_bytes());
    for choice in ["rough-plastic", "1"] {
        let output = place.succeed(&format!(
            "plot lobe --from materials.gltf --name {choice} -o -"
        ));
        assert_eq!(
            (output.stdout.as_slice(), stderr(&output).as_str()),
            (preset.as_slice(), "")
        );
    }
    let output = place.succeed("plot lobe --from materials.gltf --name textured -o -");
    let preset = String::from_utf8(preset).unwrap();
    let same = String::from_utf8(output.stdout.clone())
        .unwrap()
        .replace("textured", "rough-plastic");
    assert_eq!(same, preset);
    let note = stderr(&output);
    for texture in ["factors alone", "baseColorTexture", "normalTexture"] {
        assert!(note.contains(texture), "{note}");
    }
    // A nameless material is called by its place.
    let output = place.succeed("plot albedo --from scene.gltf --name 0 --roughness 1 -o -");
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains("Directional albedo of materials[0]"),
        "{text}"
    );
}

#[test]
fn what_goes_wrong_has_its_status() {
    let place = Place::new();
    let write = |name: &str, value: Value| place.write(name, value.to_string().as_bytes());
    write(
        "range.json",
        json!({"pbrMetallicRoughness": {"roughnessFactor": 2}}),
    );
    write(
        "fuzz.json",
        json!({"extensions": {"KHR_materials_fuzz": {}}}),
    );
    place.write("text.json", b"{");
    write("empty.gltf", json!({"asset": {"version": "2.0"}}));
    write("old.gltf", json!({"asset": {"version": "1.0"}}));
    for (line, status, says) in [
        ("fresnel --eta 1.5", 2, "--output"),
        ("fresnel -o a.svg", 2, "--material"),
        ("fresnel --eta 0 -o a.svg", 2, "more than 0"),
        ("fresnel --eta 1.5 gold -o a.svg", 2, "--eta"),
        ("fresnel --eta 1.5 --metal Au -o a.svg", 2, "--metal"),
        ("fresnel --metal Xx -o a.svg", 2, "there are Ag, Al"),
        ("fresnel lambertian -o a.svg", 2, "no Fresnel"),
        ("lobe marble -o a.svg", 2, "rough-gold"),
        ("lobe glass -o a.svg", 2, "spreads no light"),
        ("sphere gold -o a.svg", 2, "spreads no light"),
        ("lobe rough-gold --theta 90 -o a.svg", 2, "less than 90"),
        ("albedo gold --roughness 2 -o a.svg", 2, "0 to 1"),
        (
            "albedo lambertian --against roughness -o a.svg",
            2,
            "no roughness",
        ),
        ("lobe gold --material range.json -o a.svg", 2, "--material"),
        ("lobe --from scene.gltf -o a.svg", 2, "--name"),
        ("lobe --name 0 -o a.svg", 2, "--from"),
        (
            "lobe --from scene.gltf --name x -o a.svg",
            2,
            "0 'materials[0]'",
        ),
        ("lobe --from empty.gltf --name 0 -o a.svg", 2, "has none"),
        ("lobe rough-gold -o a.pdf", 2, ".svg or .png"),
        ("lobe rough-gold -o a.svg -o a.svg", 2, "more than once"),
        ("lobe --material none.json -o a.svg", 3, "none.json"),
        ("lobe --material text.json -o a.svg", 3, "not JSON"),
        ("lobe --material range.json -o a.svg", 3, "roughness"),
        ("lobe --from none.gltf --name 0 -o a.svg", 3, "none.gltf"),
        ("lobe --from old.gltf --name 0 -o a.svg", 3, "not 2"),
        (
            "lobe --material fuzz.json -o a.svg",
            4,
            "KHR_materials_fuzz",
        ),
        ("lobe rough-gold -o none/a.svg", 8, "none/a.svg"),
        ("lobe rough-gold -o a.svg -o none/a.png", 8, "none/a.png"),
    ] {
        place.fail(&format!("plot {line}"), status, says);
    }
}
