//! Writes the glTF scenes of `scenes/`: `cargo run --example make_scenes [FOLDER]`.
//!
//! Everything is made from formulas, so the committed files are reproducible byte for byte, and the
//! tests take the scenes' measures from here to compute what the pictures must show.

pub mod closed_forms;
pub mod document;
pub mod fresnel;
pub mod gallery;
pub mod mesh;
pub mod panels;
pub mod prism;
pub mod specimens;
pub mod water;

use std::path::PathBuf;

/// Every scene: its file name and its text.
pub fn all() -> Vec<(&'static str, String)> {
    vec![
        ("gallery.gltf", gallery::scene()),
        ("coatings.gltf", specimens::coatings()),
        ("glasses.gltf", specimens::glasses()),
        ("prism.gltf", prism::scene()),
        ("total_internal_reflection.gltf", water::scene()),
        ("fresnel.gltf", fresnel::scene()),
        ("furnace.gltf", closed_forms::furnace()),
        ("white_furnace.gltf", closed_forms::white_furnace()),
        ("area_light.gltf", closed_forms::area_light()),
        ("mirror.gltf", panels::mirror()),
        ("slab.gltf", panels::slab()),
    ]
}

fn main() -> std::io::Result<()> {
    let folder = std::env::args_os()
        .nth(1)
        .map_or_else(|| PathBuf::from("scenes"), PathBuf::from);
    for (name, text) in all() {
        std::fs::write(folder.join(name), text)?;
    }
    Ok(())
}
