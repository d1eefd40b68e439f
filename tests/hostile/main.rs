//! Files that are broken or mean harm: one clear error with its place in the file, of the right
//! kind, and never a panic.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod animation;
#[path = "../gltf/asset.rs"]
mod asset;
mod compressed;
mod content;
#[path = "../gltf/draco/mod.rs"]
mod draco;
#[cfg(feature = "basisu")]
#[path = "../gltf/etc1s_file.rs"]
mod etc1s_file;
mod files;
#[cfg(feature = "basisu")]
mod ktx2;
#[cfg(feature = "basisu")]
#[path = "../gltf/ktx2_file.rs"]
mod ktx2_file;
mod mutants;
mod structure;

use asset::Asset;
use serde_json::Value;
use snell::gltf::GltfError;

/// Loads and expects exit status 3 at a place, with some words in the message.
#[track_caller]
fn invalid(asset: &Asset, at: &str, words: &str) {
    expect(asset.try_load().map(|_| ()), 3, at, words);
}

#[track_caller]
fn expect(result: Result<(), GltfError>, status: u8, at: &str, words: &str) {
    let error = result.unwrap_err();
    assert_eq!((error.exit_status(), error.at()), (status, at), "{error}");
    let text = error.to_string();
    assert!(text.contains(words) && text.contains(at), "{text}");
    assert!(text.contains("; "), "no advice: {text}");
}

fn edited(edit: impl FnOnce(&mut Value)) -> Asset {
    let mut asset = Asset::triangle();
    edit(&mut asset.json);
    asset
}
