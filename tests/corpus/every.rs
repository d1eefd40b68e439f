//! Every file renders.

use crate::common::gpu;
use crate::picture::*;
use snell::pack::{Background, View, pack};
use std::path::{Path, PathBuf};

/// Small, for there are more than a hundred and fifty; each shows its scene in hundreds of pixels.
const SIZE: [u32; 2] = [48, 36];

/// Files of which nothing is drawn, for an alpha cutoff above 1.
const EMPTY: [&str; 1] = ["asset-generator/Material_AlphaMask/Material_AlphaMask_03.gltf"];

/// Lit only by a filament in a bulb whose KHR_materials_transmission is not drawn.
const DARK: &str = "materials/AnisotropyBarnLamp/AnisotropyBarnLamp.gltf";

/// The .gltf and .glb files under a folder, sorted.
fn models(folder: &Path) -> Vec<PathBuf> {
    let mut folders = vec![folder.to_owned()];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "gltf" || e == "glb") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

#[test]
fn every_file_renders() {
    let Some(corpus) = corpus() else { return };
    let mut gpu = gpu();
    let mut faults = Vec::new();
    let mut rendered = 0;
    for path in models(&corpus) {
        let name = path.strip_prefix(&corpus).unwrap().to_str().unwrap();
        let scene = load_scene(&path);
        let view = View {
            background: Background::Transparent,
            ..view(&scene, SIZE)
        };
        let packed = pack(&scene, &view).unwrap_or_else(|error| panic!("{name}: {error}"));
        let film = on_gpu(&mut gpu, &packed, &whole(&packed, 1));
        let covered = film.pixels.iter().filter(|p| p.alpha > 0.0).count();
        if film.non_finite() > 0 {
            faults.push(format!("{name}: {} samples not finite", film.non_finite()));
        }
        if (covered == 0) != EMPTY.contains(&name) {
            faults.push(format!("{name}: {covered} pixels covered"));
        }
        if film.is_black() != (covered == 0 || name == DARK) {
            faults.push(format!("{name}: black is {}", film.is_black()));
        }
        rendered += 1;
    }
    println!("{rendered} files rendered");
    assert!(rendered > 150, "only {rendered} files");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
