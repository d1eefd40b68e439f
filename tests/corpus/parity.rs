//! A dozen files and more, rendered by both renderers.

use crate::common::gpu;
use crate::picture::*;

/// One for each kind of content: textures, samplers, alpha, vertex colours, tangents, transforms,
/// strips, sparse data, negative scales, lights, emission, unlit, metals.
const COMPARED: [&str; 16] = [
    "core/BoxTextured.glb",
    "core/BoxVertexColors.glb",
    "core/OrientationTest.glb",
    "core/TextureSettingsTest.glb",
    "core/AlphaBlendModeTest.glb",
    "core/VertexColorTest.glb",
    "core/MultiUVTest.glb",
    "core/CesiumMilkTruck.glb",
    "core/TextureTransformTest-glTF/TextureTransformTest.gltf",
    "core/MeshPrimitiveModes/MeshPrimitiveModes.gltf",
    "core/SimpleSparseAccessor-glTF/SimpleSparseAccessor.gltf",
    "core/FlightHelmet/FlightHelmet.gltf",
    "materials/NormalTangentTest.glb",
    "materials/sphere_lights/sphere_lights.gltf",
    "materials/UnlitTest/UnlitTest.gltf",
    "scenes/CornellBox.glb",
];

#[test]
fn a_dozen_assets_agree_with_the_reference() {
    let Some(corpus) = corpus() else { return };
    let mut gpu = gpu();
    let mut faults = Vec::new();
    for name in COMPARED {
        let packed = packed(&load_scene(&corpus.join(name)), [80, 60]);
        let settings = whole(&packed, 2);
        let (on_gpu, on_cpu) = (
            on_gpu(&mut gpu, &packed, &settings),
            on_cpu(&packed, &settings),
        );
        let file = name.replace('/', "-");
        match std::panic::catch_unwind(|| assert_parity(&file, &on_gpu, &on_cpu)) {
            Ok(line) => println!("{line}"),
            Err(_) => faults.push(name),
        }
    }
    assert!(faults.is_empty(), "differing: {faults:?}");
}
