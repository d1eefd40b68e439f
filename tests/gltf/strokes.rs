//! Points and lines are drawn as thin bodies.

use crate::asset::{Asset, U8, load_bytes, pixel_png};
use crate::{noted, only};
use glam::{Vec3, Vec4};
use serde_json::json;
use snell::gltf::{LoadOptions, Loaded};
use snell::scene::{Material, Model, Primitive};

/// A square of 3 by 4 metres.
const SQUARE: [[f32; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [3.0, 0.0, 0.0],
    [3.0, 4.0, 0.0],
    [0.0, 4.0, 0.0],
];
/// A 500th of its diagonal.
const WIDTH: f32 = 5.0 / 500.0;

fn square(mode: u32) -> Asset {
    let mut asset = Asset::of_primitive(|asset| {
        let positions = asset.floats("VEC3", SQUARE.as_flattened());
        asset.json["accessors"][positions]["min"] = json!([0, 0, 0]);
        asset.json["accessors"][positions]["max"] = json!([3, 4, 0]);
        json!({"attributes": {"POSITION": positions}, "mode": mode})
    });
    asset.push(
        "materials",
        json!({"pbrMetallicRoughness": {
        "baseColorFactor": [0.1, 0.2, 0.3, 1]}, "emissiveFactor": [0.5, 0, 0]}),
    );
    asset.primitive()["material"] = json!(0);
    asset
}

fn material(loaded: &Loaded) -> &Material {
    &loaded.scene.materials[only(loaded).material]
}

/// Positive where the surface is closed and its triangles face outwards.
fn volume(primitive: &Primitive) -> f64 {
    let volumes = primitive.triangles.iter().map(|triangle| {
        let [a, b, c] = triangle.map(|index| primitive.positions[index as usize].as_dvec3());
        a.dot(b.cross(c)) / 6.0
    });
    volumes.sum()
}

fn distance(p: Vec3, a: Vec3, b: Vec3) -> f32 {
    let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    p.distance(a.lerp(b, t))
}

/// Of a hexagonal rod with its two tips, which are pyramids as high as they are wide.
fn rod(length: f64) -> f64 {
    let radius = f64::from(0.5 * WIDTH);
    let section = 1.5 * 3f64.sqrt() * radius * radius;
    section * (length + 2.0 * radius / 3.0)
}

#[test]
fn lines_join_what_they_name() {
    // The triangles of glTF 2.0 section 3.7.2.1's lines, loop and strip, by lengths of their pieces.
    for (mode, indices, pieces) in [
        (1, None, vec![(0, 1), (2, 3)]),
        (2, None, vec![(0, 1), (1, 2), (2, 3), (3, 0)]),
        (3, None, vec![(0, 1), (1, 2), (2, 3)]),
        (1, Some([1u8, 3, 0, 2]), vec![(1, 3), (0, 2)]),
        (3, Some([1, 3, 0, 2]), vec![(1, 3), (3, 0), (0, 2)]),
        (2, Some([1, 3, 0, 2]), vec![(1, 3), (3, 0), (0, 2), (2, 1)]),
    ] {
        let mut asset = square(mode);
        if let Some(indices) = indices {
            let indices = asset.accessor(U8, "SCALAR", 4, &indices);
            asset.primitive()["indices"] = json!(indices);
        }
        let loaded = asset.load();
        let primitive = only(&loaded);
        assert!(noted(&loaded, "a 500th of the scene"), "{:?}", loaded.notes);
        let ends = pieces
            .iter()
            .map(|&(a, b)| [a, b].map(|i: usize| Vec3::from(SQUARE[i])));
        let ends: Vec<_> = ends.collect();
        for p in &primitive.positions {
            let near = ends.iter().map(|&[a, b]| distance(*p, a, b));
            let near = near.fold(f32::INFINITY, f32::min);
            assert!(near < 0.5 * WIDTH + 1e-5, "{p} is {near} from a line");
        }
        let expected: f64 = ends
            .iter()
            .map(|[a, b]| rod(f64::from(a.distance(*b))))
            .sum();
        let found = volume(primitive);
        assert!(
            (found / expected - 1.0).abs() < 1e-3,
            "mode {mode}: {found} {expected}"
        );
    }
}

#[test]
fn points_are_balls() {
    let loaded = square(0).load();
    let primitive = only(&loaded);
    assert_eq!(primitive.triangles.len(), 4 * 20);
    for (p, normal) in primitive.positions.iter().zip(&primitive.normals) {
        let center = SQUARE
            .map(Vec3::from)
            .into_iter()
            .find(|c| c.distance(*p) < WIDTH);
        let offset = *p - center.unwrap();
        assert!((offset.length() - 0.5 * WIDTH).abs() < 1e-5);
        assert!(offset.normalize().dot(*normal) > 0.999);
    }
    // An icosahedron whose corners lie on the ball.
    let radius = f64::from(0.5 * WIDTH);
    let expected = 4.0 * 2.536_15 * radius.powi(3);
    assert!(
        (volume(primitive) / expected - 1.0).abs() < 1e-2,
        "{}",
        volume(primitive)
    );
}

#[test]
fn widths_are_the_worlds() {
    let mut asset = square(0);
    asset.json["nodes"][0]["scale"] = json!([2, 2, 2]);
    asset.push("nodes", json!({"children": [0], "translation": [7, 8, 9]}));
    asset.json["scenes"] = json!([{"nodes": [1]}]);
    let loaded = asset.load();
    let place = loaded.scene.instances[0].world_from_object;
    let p = place.transform_point3(only(&loaded).positions[0]);
    let center = place.transform_point3(Vec3::ZERO);
    assert!(
        (p.distance(center) - 0.5 * 2.0 * WIDTH).abs() < 1e-5,
        "{}",
        p.distance(center)
    );
}

#[test]
fn strokes_without_normals_are_not_lit() {
    let mut asset = square(1);
    let colors = [1.0, 0.5, 0.25, 1.0].repeat(4);
    let colors = asset.floats("VEC4", &colors);
    asset.primitive()["attributes"]["COLOR_0"] = json!(colors);
    let loaded = asset.load();
    let Model::Unlit { base_color, .. } = &material(&loaded).model else {
        panic!("{:?}", material(&loaded).model);
    };
    // Base colour and emission are added.
    assert!(
        (*base_color - Vec4::new(0.6, 0.2, 0.3, 1.0)).length() < 1e-6,
        "{base_color}"
    );
    assert_eq!(material(&loaded).emissive, Vec3::ZERO);
    let colors = only(&loaded).colors.as_ref().unwrap();
    assert_eq!(colors.len(), only(&loaded).positions.len());
    assert!(
        colors
            .iter()
            .all(|color| *color == Vec4::new(1.0, 0.5, 0.25, 1.0))
    );
    // The material itself stays as it is for triangles.
    assert!(matches!(
        loaded.scene.materials[0].model,
        Model::MetallicRoughness(_)
    ));
}

#[test]
fn strokes_with_normals_are_lit_and_have_normal_maps_only_with_tangents() {
    let normals = [0.0, 0.6, 0.8].repeat(4);
    let mut asset = square(3);
    let texture = asset.texture(&pixel_png([128, 128, 255, 255]));
    asset.json["materials"][0]["normalTexture"] = json!({"index": texture});
    let texcoords = asset.floats("VEC2", &[0.5; 8]);
    let normals = asset.floats("VEC3", &normals);
    asset.primitive()["attributes"]["NORMAL"] = json!(normals);
    asset.primitive()["attributes"]["TEXCOORD_0"] = json!(texcoords);
    let loaded = asset.load();
    assert!(matches!(
        material(&loaded).model,
        Model::MetallicRoughness(_)
    ));
    assert!(material(&loaded).normal_texture.is_none());
    assert_eq!(material(&loaded).emissive, Vec3::new(0.5, 0.0, 0.0));
    let expected = Vec3::new(0.0, 0.6, 0.8);
    let normals = &only(&loaded).normals;
    assert!(
        normals
            .iter()
            .all(|normal| normal.distance(expected) < 1e-6)
    );

    let tangents = asset.floats("VEC4", &[1.0, 0.0, 0.0, -1.0].repeat(4));
    asset.primitive()["attributes"]["TANGENT"] = json!(tangents);
    let loaded = asset.load();
    assert!(material(&loaded).normal_texture.is_some());
    let tangents = only(&loaded).tangents.as_ref().unwrap();
    assert!(
        tangents
            .iter()
            .all(|t| *t == Vec4::new(1.0, 0.0, 0.0, -1.0))
    );
}

#[test]
fn strokes_follow_morph_targets() {
    let mut asset = square(0);
    let deltas = asset.floats("VEC3", &[0.0, 0.0, 2.0].repeat(4));
    asset.primitive()["targets"] = json!([{"POSITION": deltas}]);
    asset.json["nodes"][0]["weights"] = json!([0.5]);
    let loaded = asset.load();
    let lifted = |p: &Vec3| (p.z - 1.0).abs() <= WIDTH;
    assert!(only(&loaded).positions.iter().all(lifted));
}

#[test]
fn a_scene_of_unknown_size_and_points_in_one_place() {
    let asset = Asset::of_primitive(|asset| {
        let positions = asset.floats("VEC3", &[0.0; 6]);
        json!({"attributes": {"POSITION": positions}, "mode": 1})
    });
    let loaded = asset.load();
    let primitive = only(&loaded);
    assert!(
        primitive
            .positions
            .iter()
            .all(|p| p.is_finite() && p.length() > 0.0)
    );
    assert!(volume(primitive) > 0.0);
}

#[test]
fn a_million_points_are_paid_for_before_they_are_made() {
    let asset = Asset::of_primitive(|asset| {
        let positions = asset.push(
            "accessors",
            json!({"componentType": 5126, "type": "VEC3",
            "count": 1_000_000}),
        );
        json!({"attributes": {"POSITION": positions}, "mode": 0})
    });
    let options = LoadOptions {
        max_memory: 200 << 20,
        ..LoadOptions::default()
    };
    let error = load_bytes(&asset.glb(), &options).unwrap_err();
    assert_eq!(
        (error.exit_status(), error.at()),
        (6, "meshes[0].primitives[0]"),
        "{error}"
    );
}
