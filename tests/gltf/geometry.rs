//! Attributes, indices, and what is made where a file has none.

use crate::asset::{Asset, F32, TRIANGLE, U8, U16, U32, pixel_png};
use crate::{assert_close, noted, only};
use glam::{Vec2, Vec3, Vec4};
use serde_json::{Value, json};
use snell::gltf::{LoadOptions, load};

#[test]
fn containers_agree() {
    let asset = Asset::triangle();
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    asset.save_glb(&path("a.glb"));
    asset.save_glb(&path("disguised.gltf"));
    asset.save_separate(&path("with spaces.gltf"));
    asset.save_embedded(&path("c.gltf"));
    asset.save_embedded(&path("disguised.glb"));
    for name in [
        "a.glb",
        "disguised.gltf",
        "with spaces.gltf",
        "c.gltf",
        "disguised.glb",
    ] {
        let loaded = load(&path(name), &LoadOptions::default()).unwrap();
        assert_eq!(
            only(&loaded).positions,
            [Vec3::ZERO, Vec3::X, Vec3::Y],
            "{name}"
        );
        assert_eq!(only(&loaded).triangles, [[0, 1, 2]]);
    }
}

#[test]
fn data_uris_may_be_plain_or_base64() {
    let mut asset = Asset::triangle();
    let text: String = asset
        .bin
        .iter()
        .map(|byte| format!("%{byte:02x}"))
        .collect();
    asset.json["buffers"] = json!([
        {"byteLength": asset.bin.len(), "uri": format!("data:application/gltf-buffer,{text}")}
    ]);
    assert_eq!(only(&asset.load()).positions[1], Vec3::X);
}

#[test]
fn indices_of_all_types() {
    let four = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0];
    for (component, bytes) in [
        (U8, vec![1u8, 3, 2]),
        (U16, bytemuck::cast_slice(&[1u16, 3, 2]).to_vec()),
        (U32, bytemuck::cast_slice(&[1u32, 3, 2]).to_vec()),
    ] {
        let asset = Asset::of_primitive(|asset| {
            let positions = asset.floats("VEC3", &four);
            let normals = asset.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
            let indices = asset.accessor(component, "SCALAR", 3, &bytes);
            json!({"attributes": {"POSITION": positions, "NORMAL": normals}, "indices": indices})
        });
        assert_eq!(only(&asset.load()).triangles, [[1, 3, 2]], "{component}");
    }
}

#[test]
fn quantized_positions_and_texture_coordinates() {
    let cases: [(u32, Vec<u8>, f32, f32); 4] = [
        (5120, vec![127, 129, 0], 127.0, 127.0),
        (U8, vec![255, 51, 0], 255.0, 255.0),
        (
            5122,
            bytemuck::cast_slice(&[32767i16, -32768, 0]).to_vec(),
            32767.0,
            32767.0,
        ),
        (
            U16,
            bytemuck::cast_slice(&[65535u16, 13107, 0]).to_vec(),
            65535.0,
            65535.0,
        ),
    ];
    for (component, corner, raw, scale) in cases {
        for normalized in [false, true] {
            let size = corner.len() / 3;
            let asset = Asset::of_primitive(|asset| {
                // Rows are padded to four bytes, as the specification asks of strides.
                let stride = (3 * size).next_multiple_of(4);
                let mut row = corner.clone();
                row.resize(stride, 0);
                let view = asset.view(&row.repeat(3));
                asset.json["bufferViews"][view]["byteStride"] = json!(stride);
                let accessor = |kind: &str| {
                    json!({"bufferView": view, "componentType": component, "type": kind,
                           "count": 3, "normalized": normalized})
                };
                let positions = asset.push("accessors", accessor("VEC3"));
                let texcoords = asset.push("accessors", accessor("VEC2"));
                json!({"attributes": {"POSITION": positions, "TEXCOORD_0": texcoords}})
            });
            let loaded = asset.load();
            let (p, uv) = (only(&loaded).positions[0], only(&loaded).texcoords[0][0]);
            let first = if normalized { raw / scale } else { raw };
            assert_eq!((p.x, p.z), (first, 0.0), "{component}");
            assert_eq!(uv, Vec2::new(p.x, p.y));
            let second = match (component, normalized) {
                (5120, false) => -127.0,
                (U8, false) => 51.0,
                (5122, false) => -32768.0,
                (U16, false) => 13107.0,
                // A signed minimum is -1 exactly.
                (5120 | 5122, true) => -1.0,
                _ => 0.2,
            };
            assert!((p.y - second).abs() < 1e-7, "{component} {p}");
        }
    }
}

#[test]
fn colors_of_all_types() {
    let floats = [0.5f32, 0.25, 1.0, 0.5, 0.25, 1.0, 0.5, 0.25, 1.0];
    let bytes = [255u8, 0, 51, 102].repeat(3);
    let shorts: Vec<u16> = [65535u16, 0, 13107, 26214].repeat(3);
    for (component, kind, data, expected) in [
        (
            F32,
            "VEC3",
            bytemuck::cast_slice(&floats).to_vec(),
            Vec4::new(0.5, 0.25, 1.0, 1.0),
        ),
        (U8, "VEC4", bytes, Vec4::new(1.0, 0.0, 0.2, 0.4)),
        (
            U16,
            "VEC4",
            bytemuck::cast_slice(&shorts).to_vec(),
            Vec4::new(1.0, 0.0, 0.2, 0.4),
        ),
    ] {
        let mut asset = Asset::triangle();
        let colors = asset.accessor(component, kind, 3, &data);
        asset.primitive()["attributes"]["COLOR_0"] = json!(colors);
        let loaded = asset.load();
        let color = only(&loaded).colors.as_ref().unwrap()[2];
        assert!((color - expected).abs().max_element() < 1e-6, "{color}");
    }
}

#[test]
fn interleaved_attributes() {
    let asset = Asset::of_primitive(|asset| {
        let mut bytes: Vec<f32> = vec![9.0];
        for corner in TRIANGLE.chunks(3) {
            bytes.extend(corner);
            bytes.extend([0.0, 0.0, 2.0]);
        }
        let view = asset.view(bytemuck::cast_slice(&bytes));
        asset.json["bufferViews"][view]["byteStride"] = json!(24);
        let accessor = |offset: usize| {
            json!({"bufferView": view, "byteOffset": offset, "componentType": F32,
                   "type": "VEC3", "count": 3})
        };
        let positions = asset.push("accessors", accessor(4));
        let normals = asset.push("accessors", accessor(16));
        json!({"attributes": {"POSITION": positions, "NORMAL": normals}})
    });
    let loaded = asset.load();
    assert_eq!(only(&loaded).positions, [Vec3::ZERO, Vec3::X, Vec3::Y]);
    // Normals come out of unit length.
    assert_eq!(only(&loaded).normals, [Vec3::Z; 3]);
}

#[test]
fn sparse_accessors_over_values_and_over_nothing() {
    for (component, index) in [
        (U8, vec![2u8]),
        (U16, 2u16.to_le_bytes().to_vec()),
        (U32, 2u32.to_le_bytes().to_vec()),
    ] {
        for based in [true, false] {
            let mut asset = Asset::triangle();
            let indices = asset.view(&index);
            let values = asset.view(bytemuck::cast_slice(&[0.0f32, 5.0, 0.0]));
            let accessor = &mut asset.json["accessors"][0];
            accessor["sparse"] = json!({
                "count": 1,
                "indices": {"bufferView": indices, "componentType": component},
                "values": {"bufferView": values},
            });
            if !based {
                accessor.as_object_mut().unwrap().remove("bufferView");
            }
            let expected = if based { Vec3::X } else { Vec3::ZERO };
            let positions = only(&asset.load()).positions.clone();
            assert_eq!(positions, [Vec3::ZERO, expected, Vec3::new(0.0, 5.0, 0.0)]);
        }
    }
}

#[test]
fn strips_and_fans_keep_their_winding() {
    let corners: Vec<f32> = (0..5)
        .flat_map(|i| [i as f32, (i % 2) as f32, 0.0])
        .collect();
    let load = |mode: u32, indices: Option<&[u8]>| {
        Asset::of_primitive(|asset| {
            let positions = asset.floats("VEC3", &corners);
            let normals = asset.floats("VEC3", &[0.0, 0.0, 1.0].repeat(5));
            let mut primitive =
                json!({"attributes": {"POSITION": positions, "NORMAL": normals}, "mode": mode});
            if let Some(indices) = indices {
                let accessor = asset.accessor(U8, "SCALAR", indices.len(), indices);
                primitive["indices"] = json!(accessor);
            }
            primitive
        })
        .load()
    };
    assert_eq!(
        only(&load(5, None)).triangles,
        [[0, 1, 2], [1, 3, 2], [2, 3, 4]]
    );
    assert_eq!(
        only(&load(6, None)).triangles,
        [[1, 2, 0], [2, 3, 0], [3, 4, 0]]
    );
    // Stitched by repeated indices.
    let stitched = load(5, Some(&[0, 1, 2, 2, 3, 4]));
    assert_eq!(only(&stitched).triangles, [[0, 1, 2], [2, 4, 3]]);
    let list = load(4, None);
    assert_eq!(only(&list).triangles, [[0, 1, 2]]);
    assert!(noted(&list, "no whole triangle"));
}

#[test]
fn missing_normals_are_flat() {
    // A roof: two triangles that share an edge.
    let asset = Asset::of_primitive(|asset| {
        let positions =
            [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0].map(|x: f32| x);
        let positions = asset.floats("VEC3", &positions);
        let tangents = asset.floats("VEC4", &[1.0, 0.0, 0.0, 1.0].repeat(4));
        let indices = asset.accessor(U8, "SCALAR", 6, &[0, 1, 2, 0, 2, 3]);
        json!({"attributes": {"POSITION": positions, "TANGENT": tangents}, "indices": indices})
    });
    let loaded = asset.load();
    let primitive = only(&loaded);
    assert_eq!(primitive.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(primitive.normals[..3], [Vec3::Z; 3]);
    assert_eq!(primitive.normals[3..], [Vec3::NEG_X; 3]);
    assert!(primitive.tangents.is_none());
}

#[test]
fn normals_of_no_length_come_from_the_faces() {
    let mut asset = Asset::triangle();
    let normals = asset.floats("VEC3", &[0.0, 0.0, 0.0, 0.0, f32::NAN, 1.0, 0.6, 0.0, 0.8]);
    asset.primitive()["attributes"]["NORMAL"] = json!(normals);
    let loaded = asset.load();
    let expected = [Vec3::Z, Vec3::Z, Vec3::new(0.6, 0.0, 0.8)];
    for (normal, expected) in only(&loaded).normals.iter().zip(expected) {
        assert_close(*normal, expected);
    }
    assert!(noted(&loaded, "length zero") && noted(&loaded, "not finite"));
}

/// A square facing +z with its picture upright, or mirrored.
fn square(mirrored: bool, extra: Value) -> Asset {
    let mut asset = Asset::of_primitive(|asset| {
        let positions = asset.floats("VEC3", &[0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.]);
        let normals = asset.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
        let uv: Vec<f32> = [0., 1., 1., 1., 1., 0., 0., 0.]
            .chunks(2)
            .flat_map(|uv| [if mirrored { 1.0 - uv[0] } else { uv[0] }, uv[1]])
            .collect();
        let texcoords = asset.floats("VEC2", &uv);
        let indices = asset.accessor(U8, "SCALAR", 6, &[0, 1, 2, 0, 2, 3]);
        json!({"attributes": {"POSITION": positions, "NORMAL": normals, "TEXCOORD_0": texcoords},
               "indices": indices, "material": 0})
    });
    let texture = asset.texture(&pixel_png([128, 128, 255, 255]));
    let mut info = json!({"index": texture});
    info.as_object_mut()
        .unwrap()
        .extend(extra.as_object().unwrap().clone());
    asset.push("materials", json!({"normalTexture": info}));
    asset
}

#[test]
fn tangents_follow_the_picture() {
    // cross(normal, tangent) * w must point up the picture, to smaller v.
    for (mirrored, tangent) in [
        (false, Vec4::new(1.0, 0.0, 0.0, 1.0)),
        (true, Vec4::new(-1.0, 0.0, 0.0, -1.0)),
    ] {
        let loaded = square(mirrored, json!({})).load();
        let primitive = only(&loaded);
        assert_eq!(primitive.positions.len(), 4, "welded again");
        for found in primitive.tangents.as_ref().unwrap() {
            assert!((*found - tangent).abs().max_element() < 1e-6, "{found}");
        }
    }
    // A quarter turn of the coordinates turns the tangent with them.
    let turned =
        json!({"extensions": {"KHR_texture_transform": {"rotation": 0.5 * std::f32::consts::PI}}});
    let loaded = square(false, turned).load();
    let tangent = only(&loaded).tangents.as_ref().unwrap()[0];
    assert_close(tangent.truncate(), Vec3::NEG_Y);
    assert_eq!(tangent.w, 1.0);
}

#[test]
fn tangents_only_where_the_material_needs_them() {
    let mut asset = square(false, json!({}));
    let tangents = asset.floats("VEC4", &[0.0, 2.0, 0.0, -1.0].repeat(4));
    asset.primitive()["attributes"]["TANGENT"] = json!(tangents);
    let given = asset.load();
    assert_eq!(
        only(&given).tangents.as_ref().unwrap()[3],
        Vec4::new(0.0, 1.0, 0.0, -1.0)
    );
    asset.json["materials"][0] = json!({});
    assert!(only(&asset.load()).tangents.is_none());
    let anisotropic = |alpha: Value| {
        json!({"extensions": {"SNELL_materials_bsdf": {
            "model": "conductor", "conductor": {"metal": "Au"},
            "distribution": {"name": "ggx", "alpha": alpha}}}})
    };
    asset.json["materials"][0] = anisotropic(json!([0.1, 0.4]));
    assert!(only(&asset.load()).tangents.is_some());
    asset.json["materials"][0] = anisotropic(json!([0.1, 0.1]));
    assert!(only(&asset.load()).tangents.is_none());
}
