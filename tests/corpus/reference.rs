//! The asset-generator models from the cameras of their manifests, against the screenshots that
//! Khronos made of them with Babylon.js.

use crate::common::gpu;
use crate::picture::*;
use crate::reference_image::{Cells, SIZE};
use glam::{Affine3A, Mat3, Vec3};
use serde_json::Value;
use snell::pack::{Background, View, pack};
use snell::scene::{Camera, Projection};
use std::collections::BTreeSet;
use std::path::Path;

/// Vertical field of view of the screenshots, Babylon.js' default: with it the models' edges fall
/// where they should. Radians.
const YFOV: f32 = 0.8;
const SAMPLES: u32 = 16;
/// Found: 0.981 for a ring and discs cut out by an alpha mask, 0.984 for small squares, 0.99 for the
/// rest, for our pixel filter blurs edges by 1.5 pixels. Half a pixel along all edges of the unit
/// square that most models are, 91 pixels wide, would make 0.978, a field of view 1 % off 0.98.
const LEAST_OVERLAP: f64 = 0.975;
/// Found: 0.93 and more; shading and clipped highlights, which differ, leave no more.
const LEAST_CORRELATION: f64 = 0.9;

/// What a screenshot is good for.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Use {
    Shape,
    ShapeAndColors,
    /// Nothing is drawn.
    Empty,
    Nothing(&'static str),
}

/// The screenshot that shows nothing but the backdrop.
const BACKDROP: &str = "Material_AlphaMask_03";

fn use_of(name: &str) -> Use {
    let (group, number) = name.rsplit_once('_').unwrap();
    match (group, number) {
        ("Animation_Skin", _) => {
            Use::Nothing("its camera is turned, and there is no picture of the backdrop alone")
        }
        ("Mesh_PrimitiveMode", "00" | "02" | "08" | "10") => {
            Use::Nothing("it shows points or lines, whose width is free")
        }
        ("Material_AlphaMask", "03") => Use::Empty,
        // Grey, white, or a mirror of lights that are not known.
        ("Material" | "Mesh_PrimitiveMode", _)
        | ("Material_MetallicRoughness", "00" | "03" | "04" | "05" | "06" | "09" | "10" | "11")
        | ("Mesh_PrimitivesUV", "00") => Use::Shape,
        // Specular-glossiness at its defaults is a mirror of surroundings that are not known.
        ("Material_Mixed", _) => Use::Shape,
        _ => Use::ShapeAndColors,
    }
}

/// A camera there that looks at the origin, +y up.
fn camera(position: Vec3) -> Camera {
    let back = position.normalize();
    let right = Vec3::Y.cross(back).normalize();
    let matrix = Mat3::from_cols(right, back.cross(right), back);
    Camera {
        name: String::new(),
        world_from_camera: Affine3A::from_mat3_translation(matrix, position),
        closing: None,
        lens: None,
        projection: Projection::Perspective {
            yfov: YFOV,
            aspect: None,
            near: 0.0,
        },
    }
}

/// The file names and camera positions of a group's manifest.
fn manifest(folder: &Path) -> Vec<(String, Vec3)> {
    let text = std::fs::read_to_string(folder.join("Manifest.json")).unwrap();
    let manifest: Value = serde_json::from_str(&text).unwrap();
    let models = manifest["models"].as_array().unwrap().iter();
    models
        .map(|model| {
            let place = |axis: usize| {
                let place = model["camera"]["translation"][axis].as_f64();
                place.unwrap() as f32
            };
            let name = model["fileName"].as_str().unwrap();
            (name.to_owned(), Vec3::new(place(0), place(1), place(2)))
        })
        .collect()
}

#[test]
fn models_look_as_in_their_reference_pictures() {
    let Some(corpus) = corpus() else { return };
    let root = corpus.join("asset-generator");
    let backdrop = root.join(format!("Material_AlphaMask/reference/{BACKDROP}.png"));
    let mut gpu = gpu();
    let mut faults = Vec::new();
    let mut compared = BTreeSet::new();
    for group in std::fs::read_dir(&root).unwrap() {
        let folder = group.unwrap().path();
        for (file, position) in manifest(&folder) {
            let name = file.trim_end_matches(".gltf");
            let screenshot = folder.join(format!("reference/{name}.png"));
            if !screenshot.exists() {
                continue;
            }
            let used = use_of(name);
            if let Use::Nothing(reason) = used {
                println!("{name}: not compared: {reason}");
                continue;
            }
            let scene = load_scene(&folder.join(&file));
            let view = View {
                camera: camera(position),
                background: Background::Transparent,
                ..view(&scene, [SIZE, SIZE])
            };
            let packed = pack(&scene, &view).unwrap();
            let film = on_gpu(&mut gpu, &packed, &whole(&packed, SAMPLES));
            let ours = Cells::of_film(&film);
            let theirs = Cells::of_screenshot(&screenshot, &backdrop);
            compared.insert(name.to_owned());
            if used == Use::Empty {
                if ours.covered() + theirs.covered() > 0.0 {
                    faults.push(format!("{name} shows something"));
                }
                continue;
            }
            let overlap = ours.overlap(&theirs);
            let correlation = ours.correlation(&theirs);
            let line = format!("{name}: overlap {overlap:.4}, correlation {correlation:.4}");
            println!("{line}");
            // Not a number, as where nothing overlaps, is no likeness.
            let alike = overlap >= LEAST_OVERLAP
                && (used == Use::Shape || correlation >= LEAST_CORRELATION);
            if !alike {
                faults.push(line);
                save(name, &ours);
            }
        }
    }
    assert_eq!(compared.len(), 58, "{compared:?}");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Leaves a picture to look at.
fn save(name: &str, cells: &Cells) {
    let folder = project("tests/current");
    std::fs::create_dir_all(&folder).unwrap();
    let picture = image::RgbaImage::from_fn(SIZE, SIZE, |x, y| {
        let i = (y * SIZE + x) as usize;
        let [r, g, b] = cells.colors[i];
        image::Rgba([r, g, b, cells.coverage[i]].map(|v| (255.0 * v).round() as u8))
    });
    picture.save(folder.join(format!("{name}.png"))).unwrap();
}
