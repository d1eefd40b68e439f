//! What is said of a scene before its meshes are packed is what is found in it afterwards.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod common;
#[path = "common/picture.rs"]
mod picture;

use common::shapes::{self, Random};
use glam::{Affine3A, Vec3, Vec4};
use picture::{load_scene, project};
use snell::pack::light_tree::TREE_LIGHTS_MIN;
use snell::pack::outline::Outline;
use snell::pack::{Packer, View};
use snell::scene::{Environment, PunctualKind, PunctualLight, Scene};
use snell::shared::{LAYOUT_COLOR, LAYOUT_COLOR_UNORM, LIGHT_CLUSTER, LIGHT_TRIANGLE};
use std::sync::Arc;

/// What was told, which must be what was found.
fn told(name: &str, scene: &Scene, view: &View) -> Outline {
    let mut told = None;
    let packed = Packer::default()
        .pack_and_tell(scene, view, Some(&mut |outline| told = Some(outline)))
        .unwrap();
    let told = told.unwrap();
    assert_eq!(told, Outline::of(&packed), "{name}");
    told
}

#[test]
fn own_scenes_are_foreseen() {
    let scenes = std::fs::read_dir(project("scenes")).unwrap();
    let paths = scenes.map(|entry| entry.unwrap().path());
    let paths = paths.filter(|path| path.extension().is_some_and(|e| e == "gltf"));
    let mut count = 0;
    for path in paths {
        let scene = load_scene(&path);
        told(
            &path.to_string_lossy(),
            &scene,
            &picture::view(&scene, [16, 16]),
        );
        count += 1;
    }
    assert!(count > 10, "only {count} scenes");
}

/// One mesh here and there, lit as the closure says.
fn places(count: u32, light: impl FnOnce(&mut Scene)) -> Scene {
    let mesh = shapes::soup(&mut Random(5), 20, 0.3);
    let at = |number| Affine3A::from_translation(Vec3::X * number as f32);
    let instances = (0..count).map(|number| shapes::instance(0, at(number)));
    let mut scene = shapes::scene(vec![mesh], instances.collect());
    light(&mut scene);
    scene
}

fn lamp(kind: PunctualKind) -> PunctualLight {
    PunctualLight {
        name: String::new(),
        kind,
        intensity: Vec3::ONE,
        position: 3.0 * Vec3::Y,
        direction: Vec3::NEG_Y,
        range: None,
    }
}

#[test]
fn levels_are_foreseen() {
    let view = shapes::view();
    let cases = [
        ("nothing", places(0, |_| {}), true),
        ("one, where its mesh is", places(1, |_| {}), false),
        ("three that stand still", places(3, |_| {}), false),
        (
            "one that is moved",
            shapes::two_levels(places(2, |scene| {
                scene.instances.remove(0);
            })),
            true,
        ),
        (
            "three by themselves",
            shapes::two_levels(places(3, |_| {})),
            true,
        ),
        (
            "two, one of them as flat as nothing",
            shapes::two_levels(places(2, |scene| {
                scene.instances[1].world_from_object = Affine3A::from_scale(Vec3::ZERO);
            })),
            false,
        ),
    ];
    for (name, scene, two_levels) in cases {
        assert_eq!(told(name, &scene, &view).two_levels, two_levels, "{name}");
    }
}

#[test]
fn motion_is_foreseen() {
    let moving = places(2, |scene| {
        scene.instances[1].motion = [Affine3A::from_translation(Vec3::Y)].into();
    });
    assert!(told("an instance", &moving, &shapes::view()).moves);
    assert!(!told("none", &places(2, |_| {}), &shapes::view()).moves);
}

#[test]
fn lights_are_foreseen() {
    let view = shapes::view();
    let glowing = |triangles: usize| {
        places(1, |scene| {
            scene.materials[0].emissive = Vec3::ONE;
            let mesh = Arc::get_mut(&mut scene.meshes[0]).unwrap();
            mesh.primitives[0].triangles.truncate(triangles);
        })
    };
    let few = told(
        "few glowing triangles",
        &glowing(TREE_LIGHTS_MIN - 1),
        &view,
    );
    assert_eq!(few.light_kinds, 1 << LIGHT_TRIANGLE);
    assert!(few.many_lights && !few.light_tree);
    let more = told("one more", &glowing(TREE_LIGHTS_MIN), &view);
    assert_eq!(more.light_kinds, 1 << LIGHT_TRIANGLE | 1 << LIGHT_CLUSTER);
    let all = places(1, |scene| {
        scene.lights = vec![
            lamp(PunctualKind::Point),
            lamp(PunctualKind::Directional),
            lamp(PunctualKind::Spot {
                inner_angle: 0.1,
                outer_angle: 0.2,
            }),
        ];
        scene.environment = Some(Environment {
            width: 2,
            height: 1,
            radiance: vec![[1.0; 3]; 2],
            strength: 1.0,
            rotation: 0.0,
        });
    });
    let all = told("lamps and a map", &all, &view);
    assert_eq!(all.light_kinds.count_ones(), 4);
    assert!(all.environment && all.many_lights);
    let one = places(1, |scene| scene.lights = vec![lamp(PunctualKind::Point)]);
    assert!(!told("one lamp", &one, &view).many_lights);
}

#[test]
fn layouts_of_vertices_are_foreseen() {
    let colored = |value: f32| {
        places(2, |scene| {
            let mesh = Arc::get_mut(&mut scene.meshes[0]).unwrap();
            mesh.primitives[0].colors = Some(vec![Vec4::splat(value); 60]);
        })
    };
    let cases = [
        ("bytes", 0.2, LAYOUT_COLOR | LAYOUT_COLOR_UNORM),
        ("floats", 0.3, LAYOUT_COLOR),
    ];
    for (name, value, layout) in cases {
        let told = told(name, &colored(value), &shapes::view());
        assert_eq!(told.layouts, [layout].into(), "{name}");
    }
}

/// A material that no triangle has does not count.
#[test]
fn materials_are_foreseen() {
    let scene = places(1, |scene| {
        let mut unused = scene.materials[0].clone();
        unused.double_sided = !unused.double_sided;
        scene.materials.push(unused);
    });
    assert_eq!(
        told("an unused material", &scene, &shapes::view())
            .materials
            .len(),
        1
    );
}
