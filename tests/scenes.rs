//! The committed scenes are what `cargo run --example make_scenes` writes, byte for byte.

#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

#[path = "../examples/make_scenes/main.rs"]
#[allow(dead_code, reason = "main is the example's")]
mod make_scenes;

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes");
const MAX_BYTES: usize = 160 * 1024;

#[test]
fn committed_scenes_are_reproducible() {
    for (name, text) in make_scenes::all() {
        let committed = std::fs::read_to_string(format!("{FOLDER}/{name}")).unwrap();
        assert!(
            committed == text,
            "scenes/{name} is not what make_scenes writes; run `cargo run --example make_scenes`"
        );
    }
}

#[test]
fn every_scene_is_made_here_and_small() {
    let made: Vec<&str> = make_scenes::all().iter().map(|(name, _)| *name).collect();
    for entry in std::fs::read_dir(FOLDER).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        if name.ends_with(".gltf") {
            assert!(made.contains(&name.as_str()), "scenes/{name} has no maker");
            let bytes = usize::try_from(entry.metadata().unwrap().len()).unwrap();
            assert!(bytes < MAX_BYTES, "scenes/{name} has {bytes} bytes");
        }
    }
}
