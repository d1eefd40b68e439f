//! Images: the kernels on lavapipe against the float64 reference, at the same sample stream.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod common;
#[path = "common/picture.rs"]
mod picture;

use picture::*;

const SIZE: [u32; 2] = [96, 72];
const SAMPLES: u32 = 4;

/// Every scene of our own.
#[test]
fn own_scenes_agree_with_the_reference() {
    let mut gpu = common::gpu();
    let mut faults = Vec::new();
    for entry in std::fs::read_dir(project("scenes")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|ending| ending != "gltf") {
            continue;
        }
        let packed = packed(&load_scene(&path), SIZE);
        let settings = whole(&packed, SAMPLES);
        let name = path.file_stem().unwrap().to_str().unwrap();
        let (on_gpu, on_cpu) = (
            on_gpu(&mut gpu, &packed, &settings),
            on_cpu(&packed, &settings),
        );
        match std::panic::catch_unwind(|| assert_parity(name, &on_gpu, &on_cpu)) {
            Ok(line) => println!("{line}"),
            Err(_) => faults.push(name.to_owned()),
        }
    }
    assert!(faults.is_empty(), "differing: {faults:?}");
}
