//! The shader folder against the table in the binary, and every module and kernel through naga.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod common;

use snell::gpu::fetch::fetch_from_textures;
use snell::gpu::link::Value;
use snell::gpu::prune::prune;
use snell::gpu::{link, shaders};
use snell::pack::ARRAYS;
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

/// A program whose branches hang on a constant, and the same with the constant's value as an input.
const BRANCHES: &str = "
const ON: bool = true;
@group(3) @binding(0) var<storage, read> input: array<u32>;
@group(3) @binding(1) var<storage, read_write> output: array<u32>;
fn is_on_and_odd(on: bool, x: u32) -> bool { return on && (x & 1u) == 1u; }
fn is_odd(x: u32) -> bool { return ON && (x & 1u) == 1u; }
fn is_off() -> bool { return !ON; }
fn heavy(x: u32) -> u32 { return x * 3u + input[x % 7u]; }
fn given(on: bool, x: u32) -> u32 {
    var y = x;
    if is_on_and_odd(on, x) || (!on && x % 5u == 0u) { y = heavy(x); }
    for (var i = 0u; i < 4u; i++) {
        if !on && i == 2u { break; }
        if on { y += i; continue; }
        y += 100u;
    }
    switch x % 3u {
        case 0u: { if on { return y; } y ^= 7u; }
        default: { y += 1u; }
    }
    if !on { return y + 1u; }
    return y;
}
fn decided(x: u32) -> u32 {
    var y = x;
    if is_odd(x) || (is_off() && x % 5u == 0u) { y = heavy(x); }
    for (var i = 0u; i < 4u; i++) {
        if !ON && i == 2u { break; }
        if ON { y += i; continue; }
        y += 100u;
    }
    switch x % 3u {
        case 0u: { if ON { return y; } y ^= 7u; }
        default: { y += 1u; }
    }
    if is_off() { return y + 1u; }
    return y;
}
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let x = id.x;
    if x >= 200u { return; }
    output[2u * x] = given(input[7] == 1u, x);
    output[2u * x + 1u] = decided(x);
}
@compute @workgroup_size(1)
fn other() { output[0] = heavy(3u); }";

#[test]
fn what_a_constant_decides_is_what_a_value_decides() {
    for on in [false, true] {
        let root = BRANCHES.replace("= true;", &format!("= {on};"));
        let input = [9, 8, 7, 6, 5, 4, 3, u32::from(on)];
        let bytes = common::run(&root, &[bytemuck::cast_slice(&input)], 1600, 200);
        let output: Vec<u32> = bytemuck::pod_collect_to_vec(&bytes);
        for pair in output.chunks(2) {
            assert_eq!(pair[0], pair[1], "{on}");
        }
    }
}

#[test]
fn what_no_constant_leaves_is_gone() {
    const ONE: &str = "
const ON: bool = true;
@group(0) @binding(0) var<storage, read_write> a: array<u32>;
@group(0) @binding(1) var<storage, read_write> b: array<u32>;
fn is_large(x: u32) -> bool { return ON && x > 3u; }
fn heavy(x: u32) -> u32 { return b[x]; }
@compute @workgroup_size(1) fn other() { b[0] = 1u; }
@compute @workgroup_size(1) fn main() {
    var x = a[0];
    if is_large(x) || (!(ON || x == 9u) && ON) { x = heavy(x); }
    a[1] = x;
}";
    let linked = link::link_text("one", ONE).unwrap();
    let pruned = |on| {
        let given = linked.with_constants(&[("ON", Value::Bool(on)), ("OTHER", Value::Uint(3))]);
        let (mut module, _) = given.validate().unwrap();
        prune(&mut module, "main");
        naga::valid::Validator::new(
            naga::valid::ValidationFlags::all(),
            naga::valid::Capabilities::default(),
        )
        .validate(&module)
        .unwrap();
        assert_eq!(module.entry_points.len(), 1);
        (module.functions.len(), module.global_variables.len())
    };
    assert_eq!(pruned(true), (2, 2));
    assert_eq!(pruned(false), (0, 1));
}

/// Drivers keep what they compiled under the bits of a shader: another order of its types, and every process
/// compiles anew.
#[test]
fn a_kernel_that_fetches_comes_out_the_same_each_time() {
    let (module, _) = link::link("kernels/shade").unwrap().validate().unwrap();
    let prepared = || {
        let mut module = module.clone();
        prune(&mut module, "shade_kernel");
        fetch_from_textures(&mut module, |name| ARRAYS.contains(&name)).unwrap();
        format!("{module:?}")
    };
    let first = prepared();
    for _ in 0..8 {
        assert!(prepared() == first, "two orders of one shader");
    }
}
