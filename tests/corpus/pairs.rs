//! Files that hold the same model in different clothes.

use crate::common::gpu;
use crate::picture::*;
use snell::compare::z_test;
use snell::film::Film;
use snell::gpu::device::Gpu;
use snell::pack::{View, pack};
use std::path::Path;

/// Pairs of one model, whose pictures must not differ in a bit.
const PAIRS: [(&str, &str); 9] = [
    // A binary container against data URIs.
    (
        "core/BoxTextured.glb",
        "core/BoxTextured-glTF-Embedded/BoxTextured.gltf",
    ),
    // Colours as floats against normalised shorts, and bytes of four channels.
    (
        "asset-generator/Mesh_PrimitiveVertexColor/Mesh_PrimitiveVertexColor_00.gltf",
        "asset-generator/Mesh_PrimitiveVertexColor/Mesh_PrimitiveVertexColor_02.gltf",
    ),
    (
        "asset-generator/Mesh_PrimitiveVertexColor/Mesh_PrimitiveVertexColor_00.gltf",
        "asset-generator/Mesh_PrimitiveVertexColor/Mesh_PrimitiveVertexColor_04.gltf",
    ),
    // Texture coordinates as floats against normalised shorts.
    (
        "asset-generator/Buffer_Interleaved/Buffer_Interleaved_00.gltf",
        "asset-generator/Buffer_Interleaved/Buffer_Interleaved_04.gltf",
    ),
    // No sampler against the modes that are the default.
    (
        "asset-generator/Texture_Sampler/Texture_Sampler_00.gltf",
        "asset-generator/Texture_Sampler/Texture_Sampler_06.gltf",
    ),
    // A skinned node's own transform, which is to be ignored.
    (
        "asset-generator/Animation_Skin/Animation_Skin_00.gltf",
        "asset-generator/Animation_Skin/Animation_Skin_02.gltf",
    ),
    // No indices against indices of one byte.
    (
        "asset-generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_06.gltf",
        "asset-generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_14.gltf",
    ),
    // What meshopt compressed against the fallback beside it.
    (
        "compressed/EXT_meshopt_compression/meshopt-fallback/meshopt-fallback.gltf",
        "compressed/EXT_meshopt_compression/meshopt-no-fallback/meshopt-no-fallback.gltf",
    ),
    (
        "compressed/KHR_meshopt_compression/meshopt-fallback/meshopt-fallback.gltf",
        "compressed/KHR_meshopt_compression/meshopt-no-fallback/meshopt-no-fallback.gltf",
    ),
];

/// Pairs of one model but for the rounding of one of them, whose pictures must not differ by more than
/// their noise.
const ROUNDED: [(&str, &str); 3] = [
    (
        "core/CesiumMilkTruck.glb",
        "core/CesiumMilkTruck-glTF-Draco/CesiumMilkTruck.gltf",
    ),
    // Floats against quantised positions and normals.
    (
        "core/cesium-native/cubeStrip.glb",
        "core/cesium-native/cubeQuantized.glb",
    ),
    (
        "core/cesium-native/cubeStrip.glb",
        "core/cesium-native/cubeFanIndexed.glb",
    ),
];

/// Two that are alike and not the same: a test of the test.
const DIFFERENT: (&str, &str) = ("core/BoxTextured.glb", "core/BoxTexturedNonPowerOfTwo.glb");

/// The films of two files from one camera, with samples of their own.
fn films(gpu: &mut Gpu, corpus: &Path, (left, right): (&str, &str)) -> [Film; 2] {
    const SAMPLES: u32 = 32;
    let [one, other] = [left, right].map(|name| load_scene(&corpus.join(name)));
    let view = view(&one, [64, 48]);
    [(&one, 0), (&other, 1)].map(|(scene, seed)| {
        let view = View {
            seed,
            ..view.clone()
        };
        let packed = pack(scene, &view).unwrap();
        on_gpu(gpu, &packed, &whole(&packed, SAMPLES))
    })
}

#[test]
fn files_of_one_model_with_other_roundings_agree_within_noise() {
    let Some(corpus) = corpus() else { return };
    let mut gpu = gpu();
    for pair in ROUNDED {
        let [one, other] = films(&mut gpu, &corpus, pair);
        let verdict = z_test(&one, &other, 0.01);
        println!("{pair:?}: {:?} by chance", verdict.p_mean);
        assert!(verdict.same, "{pair:?}: {verdict:?}");
    }
    let [one, other] = films(&mut gpu, &corpus, DIFFERENT);
    assert!(!z_test(&one, &other, 0.01).same, "{DIFFERENT:?}");
}

#[test]
fn files_of_one_model_give_the_same_film() {
    let Some(corpus) = corpus() else { return };
    let mut gpu = gpu();
    let mut faults = Vec::new();
    for (left, right) in PAIRS {
        let [one, other] = [left, right].map(|name| {
            let packed = packed(&load_scene(&corpus.join(name)), [48, 36]);
            on_gpu(&mut gpu, &packed, &whole(&packed, 2))
        });
        if one != other {
            let differing = one.pixels.iter().zip(&other.pixels);
            let count = differing.filter(|(a, b)| a != b).count();
            faults.push(format!("{left}, {right}: {count} pixels differ"));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
