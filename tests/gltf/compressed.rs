//! Geometry that is compressed: the same as what went in, within what the encoder rounded.

use crate::asset::{Asset, corpus};
use crate::draco::{EDGEBREAKER, POINTS, SEQUENTIAL, TRAVERSED, TRIANGLES, sheet};
use crate::{noted, only};
use glam::{Vec2, Vec3};
use serde_json::json;
use snell::gltf::{LoadOptions, Loaded, load};
use snell::scene::Primitive;

/// Half a step of 12 bits over 6 units, and of 10 bits over the sheet's texture coordinates.
const POSITION_ERROR: f32 = 0.6 * 6.0 / 4095.0;
const TEXCOORD_ERROR: f32 = 0.6 / 1023.0;
/// Radians, of 10 bits on an octahedron.
const NORMAL_ERROR: f32 = 4.0 / 1023.0;

#[test]
fn draco_streams_hold_what_went_in() {
    for stream in [EDGEBREAKER, SEQUENTIAL] {
        let loaded = sheet(stream).load();
        let primitive = only(&loaded);
        assert_eq!(loaded.notes, [""; 0]);
        assert_eq!(primitive.positions.len(), POINTS);
        let colors = primitive.colors.as_ref().unwrap();
        for (i, &p) in primitive.positions.iter().enumerate() {
            let (x, y) = (p.x.round(), p.y.round());
            let expected = Vec3::new(x, y, x * y / 8.0);
            assert!((p - expected).abs().max_element() <= POSITION_ERROR, "{p}");
            let normal = Vec3::new(-y / 8.0, -x / 8.0, 1.0).normalize();
            assert!(primitive.normals[i].angle_between(normal) < NORMAL_ERROR);
            let color = [40.0 * x, 40.0 * y, 7.0 * (x + y), 255.0 - x].map(|c| c / 255.0);
            for (found, expected) in colors[i].to_array().into_iter().zip(color) {
                assert!((found - expected).abs() < 1e-6, "{} at {x}, {y}", colors[i]);
            }
        }
        let mut area = 0.0;
        assert_eq!(primitive.triangles.len(), TRIANGLES);
        for triangle in &primitive.triangles {
            let corners = triangle.map(|index| index as usize);
            let [a, b, c] = corners.map(|index| primitive.positions[index].truncate());
            area += 0.5 * (b - a).perp_dot(c - a);
            // The texture is cut along x = 3, where each half has points of its own.
            let half = ((a + b + c).x > 9.0) as u8;
            for index in corners {
                let p = primitive.positions[index].round();
                let expected = Vec2::new(p.x / 8.0 + 0.25 * f32::from(half), p.y / 8.0);
                let found = primitive.texcoords[0][index];
                assert!(
                    (found - expected).abs().max_element() <= TEXCOORD_ERROR,
                    "{found}"
                );
            }
        }
        assert!((area - 36.0).abs() < 0.1, "{area}");
    }
}

#[test]
fn points_are_counted_as_others_count_them() {
    let loaded = sheet(EDGEBREAKER).load();
    let found: Vec<_> = only(&loaded)
        .positions
        .iter()
        .map(|p| (p.x.round() as u8, p.y.round() as u8))
        .collect();
    assert_eq!(found, TRAVERSED);
    // The first triangles of what went in, which a sequence keeps.
    assert_eq!(
        only(&sheet(SEQUENTIAL).load()).triangles[..2],
        [[0, 1, 2], [0, 2, 3]]
    );
}

#[test]
fn draco_attributes_are_morphed_and_skinned_and_stand_beside_others() {
    for stream in [EDGEBREAKER, SEQUENTIAL] {
        let rest = sheet(stream).load();
        let mut asset = sheet(stream);
        let deltas: Vec<f32> = (0..POINTS).flat_map(|i| [0.0, 0.0, i as f32]).collect();
        let deltas = asset.floats("VEC3", &deltas);
        // What the stream has, too, but is not named to be read from it.
        let texcoords: Vec<f32> = (0..POINTS).flat_map(|i| [i as f32, 0.5]).collect();
        let texcoords = asset.floats("VEC2", &texcoords);
        let primitive = asset.primitive();
        primitive["targets"] = json!([{"POSITION": deltas}]);
        primitive["attributes"]["TEXCOORD_0"] = json!(texcoords);
        let extension = &mut primitive["extensions"]["KHR_draco_mesh_compression"];
        let ids = extension["attributes"].as_object_mut().unwrap();
        ids.remove("TEXCOORD_0");
        asset.json["nodes"] = json!([{"mesh": 0, "skin": 0, "weights": [2.0]},
            {"translation": [0, 0, 0]}, {"translation": [0, 600, 0]}]);
        asset.json["scenes"] = json!([{"nodes": [0, 1, 2]}]);
        asset.json["skins"] = json!([{"joints": [1, 2]}]);
        let loaded = asset.load();
        let primitive = only(&loaded);
        for (i, (p, rest)) in primitive
            .positions
            .iter()
            .zip(&only(&rest).positions)
            .enumerate()
        {
            // The second joint's weight falls from 1 at x = 0 to 0 at x = 6.
            let lift = 600.0 * (1.0 - rest.x.round() / 6.0);
            let expected = *rest + Vec3::new(0.0, lift, 2.0 * i as f32);
            assert!((*p - expected).length() < 1e-3, "{p} is not {expected}");
            assert_eq!(primitive.texcoords[0][i], Vec2::new(i as f32, 0.5));
        }
    }
}

#[test]
fn accessors_of_other_types_and_counts_than_their_stream() {
    let mut asset = sheet(SEQUENTIAL);
    asset.json["accessors"][0]["componentType"] = json!(crate::asset::U32);
    asset.json["accessors"][1]["count"] = json!(POINTS - 1);
    let loaded = asset.load();
    assert_eq!(only(&loaded).positions.len(), POINTS);
    assert_eq!(only(&loaded).triangles.len(), TRIANGLES);
    assert!(
        noted(&loaded, "as long as the stream"),
        "{:?}",
        loaded.notes
    );
}

/// Each vertex of one primitive has a vertex of the other within these distances, and its normal and
/// texture coordinates are as near.
fn covers(one: &Primitive, other: &Primitive, [position, normal, texcoord]: [f32; 3]) {
    let zeros = vec![Vec2::ZERO; one.positions.len().max(other.positions.len())];
    let texcoords = |p: &'_ Primitive| p.texcoords.first().cloned().unwrap_or(zeros.clone());
    let (ours, theirs) = (texcoords(one), texcoords(other));
    for (i, p) in one.positions.iter().enumerate() {
        let found = (0..other.positions.len()).any(|j| {
            (other.positions[j] - *p).abs().max_element() <= position
                && other.normals[j].angle_between(one.normals[i]) <= normal
                && (theirs[j] - ours[i]).abs().max_element() <= texcoord
        });
        assert!(
            found,
            "{p}, normal {}, texcoord {}",
            one.normals[i], ours[i]
        );
    }
}

fn area(primitive: &Primitive) -> f32 {
    let triangles = primitive.triangles.iter().map(|triangle| {
        let [a, b, c] = triangle.map(|index| primitive.positions[index as usize]);
        0.5 * (b - a).cross(c - a).length()
    });
    triangles.sum()
}

fn model(name: &str) -> Option<Loaded> {
    let Some(corpus) = corpus() else {
        println!("NOT RUN: there is no corpus of models beside this checkout");
        return None;
    };
    Some(load(&corpus.join(name), &LoadOptions::default()).unwrap())
}

#[test]
fn the_truck_is_the_same_with_and_without_draco() {
    // Its streams say 14 bits for positions, 10 for normals and 12 for texture coordinates.
    let Some(plain) = model("core/CesiumMilkTruck.glb") else {
        return;
    };
    let Some(draco) = model("core/CesiumMilkTruck-glTF-Draco/CesiumMilkTruck.gltf") else {
        return;
    };
    assert_eq!(plain.counts.drawn_triangles, draco.counts.drawn_triangles);
    assert_eq!(plain.scene.instances.len(), draco.scene.instances.len());
    for (a, b) in plain.scene.meshes.iter().zip(&draco.scene.meshes) {
        assert_eq!(a.primitives.len(), b.primitives.len());
        for (a, b) in a.primitives.iter().zip(&b.primitives) {
            assert_eq!(a.triangles.len(), b.triangles.len());
            let (one, other) = (area(a), area(b));
            assert!((one - other).abs() < 1e-3 * one, "{one} {other}");
            let fold =
                |start, pick: fn(Vec3, Vec3) -> Vec3| a.positions.iter().copied().fold(start, pick);
            let extent = (fold(Vec3::MIN, Vec3::max) - fold(Vec3::MAX, Vec3::min)).max_element();
            let tolerances = [0.6 * extent / 16383.0, NORMAL_ERROR, 0.6 / 4095.0];
            covers(a, b, tolerances);
            covers(b, a, tolerances);
        }
    }
}

#[cfg(feature = "meshopt")]
#[test]
fn a_fallback_and_what_it_stands_in_for_are_the_same() {
    for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        let path = |kind: &str| format!("compressed/{name}/meshopt-{kind}/meshopt-{kind}.gltf");
        let Some(fallback) = model(&path("fallback")) else {
            return;
        };
        let compressed = model(&path("no-fallback")).unwrap();
        let [fallback, compressed] =
            [fallback, compressed].map(|l| format!("{:?}", l.scene.meshes));
        assert!(fallback == compressed, "{name}");
    }
}

#[cfg(feature = "meshopt")]
mod meshopt_views {
    use super::*;
    use crate::assert_close;
    use crate::asset::{F32, TRIANGLE, U8, U16, U32};
    use ::meshopt::{
        EncodeExpMode, encode_filter_color, encode_filter_exp, encode_filter_oct,
        encode_filter_quat, encode_index_buffer, encode_index_sequence, encode_vertex_buffer_level,
    };
    use glam::Vec4;

    const I8: u32 = 5120;
    const I16: u32 = 5122;

    /// What a compressed view says of itself.
    struct View<'e> {
        extension: &'e str,
        mode: &'e str,
        filter: Option<&'e str>,
        stride: usize,
        count: usize,
    }

    /// An accessor of a whole compressed view; the uncompressed one would be in a buffer 1 that is not
    /// there.
    fn accessor(
        asset: &mut Asset,
        encoded: &[u8],
        view: &View<'_>,
        component: u32,
        kind: &str,
    ) -> usize {
        let number = asset.view(encoded);
        let object = &mut asset.json["bufferViews"][number];
        let offset = object["byteOffset"].clone();
        let mut extension = json!({"buffer": 0, "byteOffset": offset, "byteLength": encoded.len(),
            "byteStride": view.stride, "count": view.count, "mode": view.mode});
        if let Some(filter) = view.filter {
            extension["filter"] = json!(filter);
        }
        *object = json!({"buffer": 1, "byteLength": view.stride * view.count,
            "extensions": {view.extension: extension}});
        if view.mode == "ATTRIBUTES" {
            object["byteStride"] = json!(view.stride);
        }
        let normalized = component != F32 && view.mode == "ATTRIBUTES";
        asset.push(
            "accessors",
            json!({"bufferView": number, "componentType": component,
            "type": kind, "count": view.count, "normalized": normalized}),
        )
    }

    fn load_with_buffers(mut asset: Asset) -> Loaded {
        asset.bin.resize(asset.bin.len().next_multiple_of(4), 0);
        asset.json["buffers"] = json!([{"byteLength": asset.bin.len()}, {"byteLength": 1 << 20}]);
        asset.load()
    }

    /// Positions and one more attribute of three vertices.
    fn with_attribute(
        name: &str,
        component: u32,
        kind: &str,
        encoded: &[u8],
        view: &View<'_>,
    ) -> Loaded {
        let mut asset = Asset::triangle();
        let number = accessor(&mut asset, encoded, view, component, kind);
        asset.primitive()["attributes"][name] = json!(number);
        load_with_buffers(asset)
    }

    fn vertices<T>(rows: &[T], version: i32) -> Vec<u8> {
        encode_vertex_buffer_level(rows, 2, Some(version)).unwrap()
    }

    #[test]
    fn vertices_and_indices_in_both_extensions() {
        let positions: Vec<[f32; 3]> = (0..300u32)
            .map(|i| [i as f32, (i * i % 17) as f32, 0.25 * (i % 5) as f32])
            .collect();
        let order: Vec<u32> = (0..297).flat_map(|i| [i, i + 1, i + 3]).collect();
        let order = &order[..6 * 100];
        for (extension, version) in [
            ("EXT_meshopt_compression", 0),
            ("KHR_meshopt_compression", 0),
            ("KHR_meshopt_compression", 1),
        ] {
            for (mode, stride, component) in [
                ("TRIANGLES", 2, U16),
                ("TRIANGLES", 4, U32),
                ("INDICES", 2, U16),
                ("INDICES", 4, U32),
            ] {
                let mut asset = Asset::of_primitive(|asset| {
                    let view = View {
                        extension,
                        mode: "ATTRIBUTES",
                        filter: None,
                        stride: 12,
                        count: positions.len(),
                    };
                    let encoded = vertices(&positions, version);
                    let positions = accessor(asset, &encoded, &view, F32, "VEC3");
                    let encoded = match mode {
                        "TRIANGLES" => encode_index_buffer(order, 300),
                        _ => encode_index_sequence(order, 300),
                    };
                    let view = View {
                        extension,
                        mode,
                        filter: None,
                        stride,
                        count: order.len(),
                    };
                    let indices = accessor(asset, &encoded.unwrap(), &view, component, "SCALAR");
                    json!({"attributes": {"POSITION": positions}, "indices": indices})
                });
                // Vertices that are shared stay as they are.
                let normals = asset.floats("VEC3", &[0.0, 0.0, 1.0].repeat(positions.len()));
                asset.primitive()["attributes"]["NORMAL"] = json!(normals);
                let loaded = load_with_buffers(asset);
                let primitive = only(&loaded);
                let found: Vec<[f32; 3]> =
                    primitive.positions.iter().map(|p| p.to_array()).collect();
                assert_eq!(found, positions, "{extension} {version}");
                assert_eq!(primitive.triangles.len(), 200);
                for (found, expected) in primitive.triangles.iter().zip(order.chunks(3)) {
                    // The codec may begin a triangle at another corner.
                    let turns =
                        [0, 1, 2].map(|k| [found[k], found[(k + 1) % 3], found[(k + 2) % 3]]);
                    assert!(turns.iter().any(|turn| turn == expected), "{mode} {stride}");
                }
            }
        }
    }

    #[test]
    fn strips_of_an_odd_number_of_short_indices() {
        let asset = Asset::of_primitive(|asset| {
            let positions = [
                0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 2.0, 0.0,
            ];
            let positions = asset.floats("VEC3", &positions);
            let normals = asset.floats("VEC3", &[0.0, 0.0, 1.0].repeat(5));
            let encoded = encode_index_sequence(&[0, 1, 2, 3, 4], 5).unwrap();
            let view = View {
                extension: "EXT_meshopt_compression",
                mode: "INDICES",
                filter: None,
                stride: 2,
                count: 5,
            };
            let indices = accessor(asset, &encoded, &view, U16, "SCALAR");
            json!({"attributes": {"POSITION": positions, "NORMAL": normals}, "indices": indices,
                   "mode": 5})
        });
        let loaded = load_with_buffers(asset);
        assert_eq!(only(&loaded).triangles, [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
    }

    #[test]
    fn octahedral_normals() {
        let normals = [
            [0.6, 0.0, 0.8, 0.0],
            [-0.36, 0.48, -0.8, 0.0],
            [0.0, -1.0, 0.0, 0.0],
        ];
        let view = |stride| View {
            extension: "EXT_meshopt_compression",
            mode: "ATTRIBUTES",
            filter: Some("OCTAHEDRAL"),
            stride,
            count: 3,
        };
        let short = vertices(&encode_filter_oct::<i8>(&normals, 8), 0);
        let long = vertices(&encode_filter_oct::<i16>(&normals, 14), 0);
        for (encoded, stride, component, error) in [(short, 4, I8, 2e-2), (long, 8, I16, 3e-4)] {
            let loaded = with_attribute("NORMAL", component, "VEC3", &encoded, &view(stride));
            for (found, [x, y, z, _]) in only(&loaded).normals.iter().zip(normals) {
                assert!((*found - Vec3::new(x, y, z)).length() < error, "{found}");
            }
        }
    }

    #[test]
    fn exponential_positions() {
        let positions = [[1.0, -23.4, 1e-4], [-0.1, 11.0, 3e4], [7.5, 0.0, -2.0]];
        let encoded = vertices(
            &encode_filter_exp(&positions, 24, EncodeExpMode::Separate),
            0,
        );
        let view = View {
            extension: "EXT_meshopt_compression",
            mode: "ATTRIBUTES",
            filter: Some("EXPONENTIAL"),
            stride: 12,
            count: 3,
        };
        let loaded = with_attribute("POSITION", F32, "VEC3", &encoded, &view);
        for (found, expected) in only(&loaded).positions.iter().zip(positions) {
            for (found, expected) in found.to_array().into_iter().zip(expected) {
                assert!(
                    (found - expected).abs() <= 1e-6 * expected.abs(),
                    "{found} {expected}"
                );
            }
        }
    }

    /// Drawn as colours, which are four numbers that stay as they are.
    #[test]
    fn quaternions() {
        let rotations = [[0.5; 4], [0.1, 0.7, 0.5, 0.5], [0.0, 0.0, 0.6, 0.8]];
        let encoded = vertices(&encode_filter_quat(&rotations, 16), 0);
        let view = View {
            extension: "EXT_meshopt_compression",
            mode: "ATTRIBUTES",
            filter: Some("QUATERNION"),
            stride: 8,
            count: 3,
        };
        let loaded = with_attribute("COLOR_0", I16, "VEC4", &encoded, &view);
        for (found, expected) in only(&loaded).colors.as_ref().unwrap().iter().zip(rotations) {
            assert!((*found - Vec4::from(expected)).length() < 1e-3, "{found}");
        }
    }

    #[test]
    fn colors() {
        let colors = [
            [1.0, 0.0, 0.0, 1.0],
            [0.2, 0.6, 0.9, 0.5],
            [0.4, 0.4, 0.4, 0.75],
        ];
        let view = |stride| View {
            extension: "KHR_meshopt_compression",
            mode: "ATTRIBUTES",
            filter: Some("COLOR"),
            stride,
            count: 3,
        };
        let short = vertices(&encode_filter_color::<u8>(&colors, 8), 1);
        let long = vertices(&encode_filter_color::<u16>(&colors, 14), 1);
        for (encoded, stride, component, error) in [(short, 4, U8, 2e-2), (long, 8, U16, 3e-4)] {
            let loaded = with_attribute("COLOR_0", component, "VEC4", &encoded, &view(stride));
            for (found, expected) in only(&loaded).colors.as_ref().unwrap().iter().zip(colors) {
                assert!(
                    (*found - Vec4::from(expected)).abs().max_element() < error,
                    "{found}"
                );
            }
        }
    }

    #[test]
    fn a_fallback_need_not_be_there() {
        let rows: Vec<[f32; 3]> = TRIANGLE.chunks(3).map(|p| [p[0], p[1], p[2]]).collect();
        let view = View {
            extension: "EXT_meshopt_compression",
            mode: "ATTRIBUTES",
            filter: None,
            stride: 12,
            count: 3,
        };
        let mut asset = Asset::triangle();
        let number = accessor(&mut asset, &vertices(&rows, 0), &view, F32, "VEC3");
        asset.primitive()["attributes"]["POSITION"] = json!(number);
        asset.bin.resize(asset.bin.len().next_multiple_of(4), 0);
        asset.json["buffers"] = json!([{"byteLength": asset.bin.len()}, {"byteLength": 36,
            "uri": "missing.bin", "extensions": {"EXT_meshopt_compression": {"fallback": true}}}]);
        let loaded = asset.load();
        assert_close(only(&loaded).positions[1], Vec3::X);
        let buffer = asset.json["buffers"][1].as_object_mut().unwrap();
        buffer.remove("extensions");
        assert_eq!(asset.try_load().unwrap_err().at(), "buffers[1].uri");
    }
}
