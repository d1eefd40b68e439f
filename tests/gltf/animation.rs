//! Animations: keys to moments, and moments to scenes.

use crate::asset::Asset;
use crate::{assert_close, noted, only};
use glam::{Quat, Vec3};
use serde_json::json;
use snell::gltf::{self, AnimationChoice, GltfError, LoadOptions, Loaded, Moment};
use std::sync::Arc;

pub fn open(asset: &Asset) -> gltf::Asset {
    open_within(asset, &LoadOptions::default())
}

pub fn open_within(asset: &Asset, options: &LoadOptions) -> gltf::Asset {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.glb");
    asset.save_glb(&path);
    gltf::Asset::open(&path, options).unwrap_or_else(|error| panic!("{error}\n{:#}", asset.json))
}

pub fn moment(seconds: f64) -> Moment {
    blurred(seconds, 0.0)
}

pub fn blurred(seconds: f64, shutter: f64) -> Moment {
    Moment::At {
        animation: AnimationChoice::All,
        seconds,
        shutter,
    }
}

pub fn at(file: &mut gltf::Asset, seconds: f64) -> Loaded {
    file.scene(&moment(seconds)).unwrap()
}

/// An animation of one channel that drives a node's property.
pub fn animate(
    asset: &mut Asset,
    (node, path): (usize, &str),
    interpolation: &str,
    times: &[f32],
    (kind, values): (&str, &[f32]),
) {
    let input = asset.floats("SCALAR", times);
    let output = asset.floats(kind, values);
    asset.push(
        "animations",
        json!({
            "channels": [{"sampler": 0, "target": {"node": node, "path": path}}],
            "samplers": [{"input": input, "output": output, "interpolation": interpolation}],
        }),
    );
}

fn translation(loaded: &Loaded) -> Vec3 {
    loaded.scene.instances[0]
        .world_from_object
        .translation
        .into()
}

#[test]
fn steps_and_lines_pass_through_their_keys() {
    let times = [1.0, 2.0, 4.0];
    let values = [1.0, 2.0, 3.0, 5.0, 2.0, -1.0, 7.0, 0.0, 0.0];
    let key = |i: usize| Vec3::from_slice(&values[3 * i..]);
    for interpolation in ["STEP", "LINEAR"] {
        let mut asset = Asset::triangle();
        asset.json["nodes"][0]["translation"] = json!([9, 9, 9]);
        let track = ("VEC3", values.as_slice());
        animate(&mut asset, (0, "translation"), interpolation, &times, track);
        let mut file = open(&asset);
        let info = &file.animations()[0];
        assert_eq!((info.start, info.end, info.channels), (1.0, 4.0, 1));
        assert_eq!(info.name, "animations[0]");
        // Before the first key and after the last, and at each.
        for (seconds, i) in [(-1.0, 0), (0.5, 0), (1.0, 0), (2.0, 1), (4.0, 2), (99.0, 2)] {
            assert_close(translation(&at(&mut file, seconds)), key(i));
        }
        let between = match interpolation {
            "STEP" => key(1),
            _ => key(1) * 0.25 + key(2) * 0.75,
        };
        assert_close(translation(&at(&mut file, 3.5)), between);
        let rest = file.scene(&Moment::Rest).unwrap();
        assert_close(translation(&rest), [9.0; 3]);
        assert!(noted(&rest, "no animation is played"));
        assert!(!noted(&at(&mut file, 3.5), "no animation is played"));
    }
}

/// A cubic spline through a cubic polynomial's values with its derivatives is that polynomial.
#[test]
fn splines_reproduce_cubic_polynomials() {
    let curve = |t: f32| {
        let f = |a: f32, b: f32, c: f32, d: f32| ((a * t + b) * t + c) * t + d;
        Vec3::new(
            f(1.0, -3.0, 0.5, 2.0),
            f(-0.5, 0.0, 1.0, 0.0),
            f(0.0, 2.0, 0.0, -1.0),
        )
    };
    let slope = |t: f32| {
        let f = |a: f32, b: f32, c: f32| (3.0 * a * t + 2.0 * b) * t + c;
        Vec3::new(f(1.0, -3.0, 0.5), f(-0.5, 0.0, 1.0), f(0.0, 2.0, 0.0))
    };
    let times = [0.0, 0.5, 2.0];
    let keys = times.iter().flat_map(|&t| [slope(t), curve(t), slope(t)]);
    let values: Vec<f32> = keys.flat_map(|v| v.to_array()).collect();
    let mut asset = Asset::triangle();
    animate(
        &mut asset,
        (0, "translation"),
        "CUBICSPLINE",
        &times,
        ("VEC3", &values),
    );
    let mut file = open(&asset);
    for t in [0.0, 0.1, 0.3, 0.5, 0.75, 1.0, 1.9, 2.0] {
        assert_close(translation(&at(&mut file, f64::from(t))), curve(t));
    }
    assert_close(translation(&at(&mut file, 3.0)), curve(2.0));
}

#[test]
fn rotations_go_the_short_way() {
    let turn = |degrees: f32| Quat::from_rotation_z(degrees.to_radians());
    let angle = |loaded: &Loaded| {
        let x = loaded.scene.instances[0]
            .world_from_object
            .transform_vector3(Vec3::X);
        assert!((x.length() - 1.0).abs() < 1e-6 && x.z.abs() < 1e-6);
        x.y.atan2(x.x).to_degrees()
    };
    // A key and its negative are the same rotation; one that is no unit quaternion is made one.
    let keys = [turn(0.0), -turn(120.0), turn(120.2) * 3.0];
    let values: Vec<f32> = keys.iter().flat_map(|q| q.to_array()).collect();
    let mut asset = Asset::triangle();
    let times = [0.0, 1.0, 2.0];
    animate(
        &mut asset,
        (0, "rotation"),
        "LINEAR",
        &times,
        ("VEC4", &values),
    );
    let mut file = open(&asset);
    for (t, expected) in [
        (0.0, 0.0),
        (0.25, 30.0),
        (0.75, 90.0),
        (1.0, 120.0),
        (1.5, 120.1),
    ] {
        let found = angle(&at(&mut file, t));
        assert!((found - expected).abs() < 1e-3, "{found} is not {expected}");
    }
    // A spline's rotations are made unit quaternions.
    let zero = [0.0; 4];
    let keys = [
        zero,
        turn(0.0).to_array(),
        zero,
        zero,
        turn(90.0).to_array(),
        zero,
    ];
    let mut asset = Asset::triangle();
    let track = ("VEC4", keys.as_flattened());
    animate(
        &mut asset,
        (0, "rotation"),
        "CUBICSPLINE",
        &[0.0, 1.0],
        track,
    );
    let mut file = open(&asset);
    for (t, expected) in [(0.0, 0.0), (0.5, 45.0), (1.0, 90.0)] {
        let found = angle(&at(&mut file, t));
        assert!((found - expected).abs() < 1e-3, "{found} is not {expected}");
    }
    // Normalized integers.
    const I16: u32 = 5122;
    let mut asset = Asset::triangle();
    animate(
        &mut asset,
        (0, "rotation"),
        "STEP",
        &[0.0],
        ("VEC4", &[0.0; 4]),
    );
    let bytes: Vec<u8> = [0i16, 0, 23170, 23170]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let output = asset.accessor(I16, "VEC4", 1, &bytes);
    asset.json["accessors"][output]["normalized"] = json!(true);
    asset.json["animations"][0]["samplers"][0]["output"] = json!(output);
    assert!((angle(&at(&mut open(&asset), 7.0)) - 90.0).abs() < 1e-3);
}

#[test]
fn weights_of_all_targets_move_together() {
    let mut asset = Asset::triangle();
    let up = asset.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let right = asset.floats("VEC3", &[1.0, 0.0, 0.0].repeat(3));
    asset.primitive()["targets"] = json!([{"POSITION": up}, {"POSITION": right}]);
    asset.json["meshes"][0]["weights"] = json!([5, 5]);
    let linear = [0.0, 2.0, 4.0, 0.0];
    animate(
        &mut asset,
        (0, "weights"),
        "LINEAR",
        &[0.0, 1.0],
        ("SCALAR", &linear),
    );
    let first = |loaded: &Loaded| only(loaded).positions[0];
    let mut file = open(&asset);
    assert_close(first(&at(&mut file, 0.25)), [1.5, 0.0, 1.0]);
    assert_close(first(&file.scene(&Moment::Rest).unwrap()), [5.0, 0.0, 5.0]);
    // Of a spline's key: tangents in, values, tangents out, each of both targets.
    let spline = [
        [0.0, 0.0],
        [1.0, 10.0],
        [1.0, 0.0],
        [1.0, 0.0],
        [2.0, 20.0],
        [0.0, 0.0],
    ];
    asset.json["animations"] = json!([]);
    let track = ("SCALAR", spline.as_flattened());
    animate(
        &mut asset,
        (0, "weights"),
        "CUBICSPLINE",
        &[0.0, 1.0],
        track,
    );
    let mut file = open(&asset);
    // The first weight is a line of slope 1, the second eases in and out.
    let t = 0.25f32;
    let ease = 10.0 + 10.0 * (3.0 * t * t - 2.0 * t * t * t);
    assert_close(first(&at(&mut file, 0.25)), [ease, 0.0, 1.25]);
}

#[test]
fn animations_are_chosen_one_or_all() {
    let mut asset = Asset::triangle();
    animate(
        &mut asset,
        (0, "translation"),
        "STEP",
        &[0.0],
        ("VEC3", &[1.0, 2.0, 3.0]),
    );
    animate(
        &mut asset,
        (0, "scale"),
        "STEP",
        &[0.0],
        ("VEC3", &[2.0, 2.0, 2.0]),
    );
    let mut file = open(&asset);
    let mut show = |animation| {
        let moment = Moment::At {
            animation,
            seconds: 0.0,
            shutter: 0.0,
        };
        let matrix = file.scene(&moment)?.scene.instances[0].world_from_object;
        Ok::<_, GltfError>((matrix.translation.x, matrix.matrix3.x_axis.x))
    };
    assert_eq!(show(AnimationChoice::Index(0)).unwrap(), (1.0, 1.0));
    assert_eq!(show(AnimationChoice::Index(1)).unwrap(), (0.0, 2.0));
    assert_eq!(show(AnimationChoice::All).unwrap(), (1.0, 2.0));
    let error = show(AnimationChoice::Index(2)).unwrap_err().to_string();
    assert!(error.contains("there are 2 animations"), "{error}");
}

/// A node that turns, a mesh that morphs, and a mesh that stands.
fn three() -> Asset {
    let mut asset = Asset::triangle();
    let up = asset.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    asset.primitive()["targets"] = json!([{"POSITION": up}]);
    let still = asset.json["meshes"][0]["primitives"][0]["attributes"].clone();
    asset.push("meshes", json!({"primitives": [{"attributes": still}]}));
    asset.json["nodes"] =
        json!([{"mesh": 1}, {"mesh": 0}, {"mesh": 1, "children": [3]}, {"mesh": 1}]);
    asset.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    animate(
        &mut asset,
        (1, "weights"),
        "LINEAR",
        &[0.0, 1.0],
        ("SCALAR", &[0.0, 1.0]),
    );
    let turn: Vec<f32> = [0.0, 90f32]
        .iter()
        .flat_map(|angle| Quat::from_rotation_y(angle.to_radians()).to_array())
        .collect();
    animate(
        &mut asset,
        (2, "rotation"),
        "LINEAR",
        &[0.0, 1.0],
        ("VEC4", &turn),
    );
    asset
}

#[test]
fn a_moment_does_not_know_the_one_before() {
    let mut asset = three();
    asset.json["nodes"][0]["extensions"] = json!({"KHR_node_visibility": {"visible": false}});
    let pointer = json!({"path": "pointer", "extensions": {"KHR_animation_pointer":
        {"pointer": "/nodes/0/extensions/KHR_node_visibility/visible"}}});
    let input = asset.floats("SCALAR", &[0.0, 0.5]);
    let output = asset.accessor(crate::asset::U8, "SCALAR", 2, &[0, 1]);
    asset.push(
        "animations",
        json!({
        "channels": [{"sampler": 0, "target": pointer}],
        "samplers": [{"input": input, "output": output, "interpolation": "STEP"}]}),
    );
    let text = |loaded: &Loaded| {
        let Loaded {
            scene,
            notes,
            extensions,
            counts,
            ..
        } = loaded;
        format!("{scene:?} {notes:?} {extensions:?} {counts:?}")
    };
    let moments = [
        Moment::Rest,
        moment(0.25),
        moment(0.75),
        blurred(0.25, 0.5),
        moment(0.25),
        Moment::Rest,
    ];
    let mut file = open(&asset);
    for moment in moments {
        let after_others = text(&file.scene(&moment).unwrap());
        let fresh = text(&open(&asset).scene(&moment).unwrap());
        assert!(after_others == fresh, "{moment:?}");
        let again = text(&file.scene(&moment).unwrap());
        assert!(after_others == again, "{moment:?} again");
    }
}

#[test]
fn what_does_not_deform_is_the_same_mesh() {
    let mut file = open(&three());
    let a = at(&mut file, 0.25).scene;
    let b = at(&mut file, 0.5).scene;
    assert_eq!((a.meshes.len(), a.instances.len()), (2, 4));
    let same = |i: usize| {
        let mesh = |scene: &snell::scene::Scene| Arc::clone(&scene.meshes[scene.instances[i].mesh]);
        Arc::ptr_eq(&mesh(&a), &mesh(&b))
    };
    assert_eq!([0, 1, 2, 3].map(same), [true, false, true, true]);
    // The last one's parent turns.
    let animated = |scene: &snell::scene::Scene| [0, 1, 2, 3].map(|i| scene.instances[i].animated);
    assert_eq!(animated(&a), [false, true, true, true]);
    assert_eq!(animated(&b), animated(&a));
    let rest = file.scene(&Moment::Rest).unwrap().scene;
    assert_eq!(animated(&rest), [false; 4]);
    assert_ne!(
        a.instances[3].world_from_object,
        b.instances[3].world_from_object
    );
    assert_eq!(
        a.instances[0].world_from_object,
        b.instances[0].world_from_object
    );
}

#[test]
fn a_long_sequence_takes_no_more_memory_than_its_pictures() {
    let asset = three();
    let mut file = open(&asset);
    let most = (0..8)
        .map(|i| at(&mut file, f64::from(i) / 8.0).counts.memory_bytes)
        .max()
        .unwrap();
    let options = LoadOptions {
        max_memory: most,
        ..LoadOptions::default()
    };
    let mut file = open_within(&asset, &options);
    for i in 0..1000 {
        file.scene(&blurred(f64::from(i) / 1000.0, 0.0))
            .unwrap_or_else(|error| panic!("picture {i}: {error}"));
    }
}

#[test]
fn the_shutter_gives_what_moves_further_keys() {
    let mut asset = three();
    animate(
        &mut asset,
        (0, "translation"),
        "LINEAR",
        &[0.0, 2.0],
        ("VEC3", &[0.0, 0.0, 0.0, 4.0, 0.0, 0.0]),
    );
    let mut file = open(&asset);
    let loaded = file.scene(&blurred(0.0, 1.0)).unwrap();
    let instances = &loaded.scene.instances;
    // A straight line needs one further key, a quarter turn several; what stands still has none.
    assert_eq!(instances[0].motion.len(), 1);
    assert_close(instances[0].motion[0].translation, [2.0, 0.0, 0.0]);
    // What is framed holds all of the way.
    let (_, high) = gltf::bounds(&loaded.scene).unwrap();
    assert_eq!(high.x, 3.0);
    assert_eq!(instances[1].motion.len(), 0);
    assert!(noted(&loaded, "opens (nodes[1])"), "{:?}", loaded.notes);
    for instance in &instances[2..4] {
        let keys: Vec<_> = std::iter::once(&instance.world_from_object)
            .chain(&instance.motion)
            .collect();
        let steps = keys.len() - 1;
        assert_eq!(steps, 16, "16 steps of 6 degrees are nearer than 8 of 11");
        for (i, key) in keys.iter().enumerate() {
            let turn = Quat::from_rotation_y(90f32.to_radians() * i as f32 / steps as f32);
            assert_close(key.transform_vector3(Vec3::X), turn * Vec3::X);
        }
    }
    // A tenth of the turn, 9 degrees: two steps are within 5.
    let loaded = file.scene(&blurred(0.0, 0.1)).unwrap();
    assert_eq!(loaded.scene.instances[2].motion.len(), 2);
    // After the last key everything stands.
    let loaded = file.scene(&blurred(5.0, 1.0)).unwrap();
    assert!(
        loaded
            .scene
            .instances
            .iter()
            .all(|one| one.motion.is_empty())
    );
    assert!(!noted(&loaded, "blurred"));
}

#[test]
fn cameras_move_and_lights_are_in_the_middle_of_the_shutter() {
    let mut asset = Asset::triangle();
    asset.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    asset.json["cameras"] = json!([{"type": "orthographic",
        "orthographic": {"xmag": 1, "ymag": 1, "znear": 0}}]);
    asset.push(
        "nodes",
        json!({"camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}),
    );
    asset.json["scenes"][0]["nodes"] = json!([0, 1]);
    animate(
        &mut asset,
        (1, "translation"),
        "LINEAR",
        &[0.0, 1.0],
        ("VEC3", &[0.0, 0.0, 0.0, 4.0, 0.0, 0.0]),
    );
    let mut file = open(&asset);
    let loaded = file.scene(&blurred(0.5, 0.25)).unwrap();
    assert_close(loaded.scene.lights[0].position, [2.5, 0.0, 0.0]);
    assert!(noted(&loaded, "a light that moves is not blurred"));
    assert_close(
        loaded.scene.cameras[0].world_from_camera.translation,
        [2.0, 0.0, 0.0],
    );
    let closing = loaded.scene.cameras[0].closing.unwrap();
    assert_close(closing.translation, [3.0, 0.0, 0.0]);
    let loaded = at(&mut file, 0.5);
    assert!(loaded.scene.cameras[0].closing.is_none());
    assert_close(loaded.scene.lights[0].position, [2.0, 0.0, 0.0]);
    assert!(!noted(&loaded, "blurred"));
}

/// A morphed triangle's attributes are their sums; colours are kept within 0 and 1.
#[test]
fn all_attributes_morph() {
    let mut asset = Asset::triangle();
    let normals = asset.floats("VEC3", &[0.0, 0.0, 1.0].repeat(3));
    let tangents = asset.floats("VEC4", &[1.0, 0.0, 0.0, -1.0].repeat(3));
    let colors = asset.floats("VEC3", &[0.5, 0.5, 0.5].repeat(3));
    let texcoords = asset.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 0.0, 0.0]);
    let texture = asset.texture(&crate::asset::pixel_png([128, 128, 255, 255]));
    asset.push("materials", json!({"normalTexture": {"index": texture}}));
    asset.primitive()["material"] = json!(0);
    for (name, accessor) in [
        ("NORMAL", normals),
        ("TANGENT", tangents),
        ("COLOR_0", colors),
        ("TEXCOORD_0", texcoords),
    ] {
        asset.primitive()["attributes"][name] = json!(accessor);
    }
    let normals = asset.floats("VEC3", &[0.0, 2.0, 0.0].repeat(3));
    let tangents = asset.floats("VEC3", &[0.0, 0.0, 2.0].repeat(3));
    let colors = asset.floats("VEC4", &[-2.0, 0.0, 2.0, 0.5].repeat(3));
    let texcoords = asset.floats("VEC2", &[4.0, -4.0].repeat(3));
    asset.primitive()["targets"] = json!([{"NORMAL": normals, "TANGENT": tangents,
        "COLOR_0": colors, "TEXCOORD_0": texcoords}]);
    asset.json["nodes"][0]["weights"] = json!([0.5]);
    let loaded = asset.load();
    let primitive = only(&loaded);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    assert_close(primitive.normals[0], [0.0, half, half]);
    let tangent = primitive.tangents.as_ref().unwrap()[0];
    assert_close(tangent.truncate(), [half, 0.0, half]);
    assert_eq!(tangent.w, -1.0);
    let color = primitive.colors.as_ref().unwrap()[0];
    assert_eq!(color.to_array(), [0.0, 0.5, 1.0, 1.0]);
    assert_eq!(primitive.texcoords[0][0].to_array(), [2.0, -1.0]);
}

/// Of a sequence only what deforms is packed again.
#[test]
fn only_what_deforms_is_packed_again() {
    use snell::pack::{Background, Packer, View, pack};
    let mut file = open(&three());
    let mut packer = Packer::default();
    for (i, new) in [2, 1, 1].into_iter().enumerate() {
        let scene = at(&mut file, 0.25 + 0.1 * i as f64).scene;
        let view = View {
            camera: gltf::default_camera(&scene, 1.0),
            film_size: [4, 4],
            seed: 0,
            max_depth: 1,
            background: Background::Environment,
            clamp: None,
        };
        let packed = packer.pack(&scene, &view).unwrap();
        assert_eq!(packer.new_parts(), [new, 0], "picture {i}");
        let fresh = pack(&scene, &view).unwrap();
        for (a, b) in packed.arrays().iter().zip(fresh.arrays()) {
            assert!(*a == b, "{} of picture {i}", b.0);
        }
    }
}
