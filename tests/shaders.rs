//! The shader folder against the table in the binary, and every module and kernel through naga.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod common;

use snell::gpu::{link, shaders};
use std::path::Path;

fn files(folder: &Path, prefix: &str, found: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap();
        if path.is_dir() {
            files(&path, &format!("{prefix}{name}/"), found);
        } else if path.extension().is_some_and(|ending| ending == "wgsl") {
            found.push(format!("{prefix}{name}"));
        }
    }
}

#[test]
fn the_table_of_shaders_is_the_folder() {
    let mut folder = Vec::new();
    files(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders"),
        "",
        &mut folder,
    );
    folder.sort();
    let mut table: Vec<_> = shaders::MODULES
        .iter()
        .map(|(name, _)| name.to_string())
        .collect();
    table.sort();
    assert_eq!(table, folder);
}

#[test]
fn every_shader_links_and_validates_alone() {
    for (name, _) in shaders::MODULES {
        let linked = link::link(name).unwrap_or_else(|error| panic!("{error}"));
        linked.validate().unwrap_or_else(|error| panic!("{error}"));
    }
}

#[test]
fn a_fault_is_named_by_file_and_line() {
    let missing = link::link_text("root", "import package::nowhere::{x};").unwrap_err();
    assert!(missing.to_string().contains("root.wgsl:1"), "{missing}");
    let nameless = link::link_text("root", "\nimport package::shared::{Nothing};").unwrap_err();
    assert!(
        nameless.to_string().contains("root.wgsl:2") && nameless.to_string().contains("Nothing"),
        "{nameless}"
    );
    let linked = link::link_text(
        "root",
        "import package::shared::{Frame};\nfn f() -> u32 { return 1.5; }",
    )
    .unwrap();
    let refused = linked.validate().unwrap_err();
    assert!(
        refused.to_string().contains("shaders/root.wgsl:2"),
        "{refused}"
    );
}

#[test]
fn lavapipe_runs_a_kernel() {
    let root = "
@group(3) @binding(0) var<storage, read> input: array<u32>;
@group(3) @binding(1) var<storage, read_write> output: array<u32>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&input) { output[id.x] = input[id.x] * 3u; }
}";
    let input: Vec<u32> = (0..1000).collect();
    let bytes = common::run(root, &[bytemuck::cast_slice(&input)], 4000, 1000);
    let output: Vec<u32> = bytemuck::pod_collect_to_vec(&bytes);
    assert!(output.iter().zip(&input).all(|(o, i)| *o == 3 * i));
}
