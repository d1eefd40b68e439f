//! Files that hold the same model in different clothes.

use crate::common::gpu;
use crate::picture::*;

/// Pairs of one model, whose pictures must not differ in a bit.
const PAIRS: [(&str, &str); 7] = [
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
];

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
