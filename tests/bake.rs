//! What stands still as one mesh: the same surfaces and pictures as by two levels, what is left out, and
//! what a sequence packs again.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod common;
#[path = "common/picture.rs"]
mod picture;

use common::rays::{ray, towards};
use common::shapes::{self, Random};
use glam::{Affine3A, Mat3A, Quat, Vec3, Vec4};
use picture::{on_cpu, on_gpu, view, whole};
use snell::compare::z_test;
use snell::cpu::bvh::trace_closest;
use snell::cpu::surface::{Surface, surface_at};
use snell::pack::{Packed, Packer, pack};
use snell::scene::{Image, Instance, Mesh, Pixels, Scene, Texture};
use snell::shared::NONE;
use std::sync::Arc;

/// Flat triangles with tangents along their first edges, a colour for each, and texture coordinates.
fn dressed(random: &mut Random, count: usize) -> Mesh {
    let mut mesh = shapes::soup(random, count, 0.6);
    let primitive = &mut mesh.primitives[0];
    let corners = primitive.positions.chunks_exact(3);
    let tangents = corners.enumerate().flat_map(|(i, p)| {
        let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
        [(p[1] - p[0]).normalize().extend(sign); 3]
    });
    primitive.tangents = Some(tangents.collect());
    let count = primitive.positions.len();
    let colors = (0..count).map(|_| Vec4::splat(random.range(0.2, 1.0)));
    primitive.colors = Some(colors.collect());
    let places = (0..count).map(|_| glam::Vec2::new(random.unit(), random.unit()));
    primitive.texcoords = vec![places.collect()];
    mesh
}

/// Transforms of each kind: moved, turned, mirrored, scaled unequally, and sheared.
fn places(random: &mut Random) -> Vec<Affine3A> {
    let turn =
        |random: &mut Random| Quat::from_axis_angle(random.direction(), random.range(0.0, 6.0));
    let shear = Mat3A::from_cols_array(&[1.0, 0.4, 0.0, -0.3, 0.8, 0.2, 0.5, 0.0, 1.2]);
    let scales = [
        Vec3::ONE,
        Vec3::new(-1.0, 1.0, 1.0),
        Vec3::new(0.3, 1.2, 0.8),
        Vec3::new(-0.5, -1.5, -0.7),
    ];
    let mut all = vec![Affine3A {
        matrix3: shear,
        translation: random.cube().into(),
    }];
    all.extend(scales.map(|scale| {
        Affine3A::from_scale_rotation_translation(scale, turn(random), random.cube())
    }));
    all
}

/// Triangles of three materials, in all places: normal-mapped, one-sided, and glowing.
fn collection(random: &mut Random) -> Scene {
    let mut meshes: Vec<Mesh> = (0..3).map(|_| dressed(random, 12)).collect();
    for (number, mesh) in meshes.iter_mut().enumerate() {
        mesh.primitives[0].material = number;
    }
    let instances = places(random)
        .into_iter()
        .enumerate()
        .flat_map(|(i, place)| (0..3).map(move |mesh| (mesh, i, place)))
        .map(|(mesh, i, place)| {
            let aside = Affine3A::from_translation(Vec3::new(i as f32 - 2.0, 0.0, 0.0));
            shapes::instance(mesh, aside * place)
        });
    let mut scene = shapes::scene(meshes, instances.collect());
    // Blue is what points outwards: a normal that is against the eye is bent by as many times its error as
    // it is nearer to the opposite.
    let pixels = (0..64).map(|i| (random.unit() * 128.0) as u8 + if i % 4 == 2 { 127 } else { 64 });
    scene.images = vec![Arc::new(Image {
        name: String::new(),
        width: 4,
        height: 4,
        pixels: Pixels::Rgba8(pixels.collect()),
    })];
    let mut mapped = shapes::material();
    mapped.normal_texture = Some(Texture {
        image: 0,
        srgb: false,
        wrap_s: snell::scene::Wrap::Repeat,
        wrap_t: snell::scene::Wrap::Repeat,
        filter: snell::scene::Filter::Linear,
        texcoord: 0,
        rows: [Vec3::X, Vec3::Y],
    });
    let mut one_sided = shapes::material();
    one_sided.double_sided = false;
    let mut glowing = shapes::material();
    glowing.emissive = Vec3::new(2.0, 1.5, 1.0);
    glowing.double_sided = false;
    scene.materials = vec![mapped, one_sided, glowing];
    scene
}

fn both(scene: &Scene) -> [Packed; 2] {
    let apart = shapes::packed(&shapes::two_levels(scene.clone()));
    let baked = shapes::packed(scene);
    assert!(baked.frame.mesh_root != 0 && baked.instances.len() == 1);
    assert!(apart.frame.mesh_root == 0 && apart.instances.len() == scene.instances.len());
    [baked, apart]
}

#[test]
fn surfaces_are_those_of_two_levels() {
    let mut random = Random(71);
    let scene = collection(&mut random);
    let [baked, apart] = both(&scene);
    let (mut hits, mut misses, mut edges, mut mapped, mut backs) = (0, 0, 0, 0, 0);
    for seed in 0..20_000 {
        let from = 4.0 * random.direction();
        let ray = ray(&towards(from, 2.0 * random.cube()));
        let [a, b] = [&baked, &apart].map(|packed| trace_closest(packed, ray, seed));
        if (a.instance == NONE) != (b.instance == NONE) || (a.t - b.t).abs() > 1e-4 {
            edges += 1;
            continue;
        }
        if a.instance == NONE {
            misses += 1;
            continue;
        }
        let [a, b]: [Surface; 2] =
            [(&baked, a), (&apart, b)].map(|(p, hit)| surface_at(p, ray, hit));
        let near = |a: glam::DVec3, b: glam::DVec3| a.distance(b) < 1e-3;
        assert!(a.p.distance(b.p) < 1e-4, "{a:?} {b:?}");
        assert!(near(a.ng, b.ng), "{a:?} {b:?}");
        assert!(near(a.basis.n, b.basis.n), "{a:?} {b:?}");
        assert!(near(a.basis.t, b.basis.t), "{a:?} {b:?}");
        assert_eq!(
            (a.front, a.material, a.bitangent_sign),
            (b.front, b.material, b.bitangent_sign)
        );
        assert!((a.color - b.color).length() < 1e-3, "{a:?} {b:?}");
        hits += 1;
        mapped += usize::from(a.material == 0);
        backs += usize::from(!a.front);
    }
    println!("{hits} hits, {misses} misses, {edges} edges, {mapped} mapped, {backs} backs");
    assert!(hits > 4000 && misses > 4000 && mapped > 1000 && backs > 500);
    assert!(edges * 1000 < hits, "{edges} of {hits}");
}

/// Lights stand in another order, so other ones are chosen: the same picture but for its noise.
#[test]
fn pictures_are_those_of_two_levels() {
    const SIZE: [u32; 2] = [48, 36];
    let scene = collection(&mut Random(72));
    let mut looking = view(&scene, SIZE);
    looking.max_depth = 4;
    let [baked, apart] =
        [scene.clone(), shapes::two_levels(scene)].map(|scene| pack(&scene, &looking).unwrap());
    let mut gpu = common::gpu();
    let reference = on_cpu(&apart, &whole(&apart, 64));
    for (name, film) in [
        ("kernels", on_gpu(&mut gpu, &baked, &whole(&baked, 64))),
        ("reference", on_cpu(&baked, &whole(&baked, 64))),
    ] {
        let verdict = z_test(&film, &reference, 0.01);
        println!("{name}: {verdict:?}");
        assert!(verdict.same, "{name}: {verdict:?}");
    }
    let average = reference.average();
    assert!(average > 0.01, "{average}");
}

/// Root of the one mesh, instances in all, and triangles stored.
fn shape_of(scene: &Scene) -> (bool, usize, usize) {
    let packed = shapes::packed(scene);
    let one = packed.frame.mesh_root != 0;
    (one, packed.instances.len(), packed.triangles.len())
}

#[test]
fn copies_and_what_would_lose_its_shape_stay_apart() {
    let at = |mesh: usize, x: f32| shapes::instance(mesh, Affine3A::from_translation(Vec3::X * x));
    let many = |count: usize| (0..count).map(|i| at(0, 3.0 * i as f32));
    let sphere = shapes::sphere(50, 1.0);
    let triangles = sphere.primitives[0].triangles.len();
    let with = |instances: Vec<Instance>| {
        shape_of(&shapes::scene(
            vec![sphere.clone(), shapes::grid(1, |_, _| 0.0)],
            instances,
        ))
    };
    // Few copies become one mesh; of many the one beside them stands alone, so it is left as well.
    assert_eq!(with(many(4).collect()), (true, 1, 4 * triangles));
    assert_eq!(with(many(40).collect()), (false, 40, triangles));
    let beside = many(40).chain([at(1, -3.0)]);
    assert_eq!(with(beside.collect()), (false, 41, triangles + 2));
    // Where it is put already, a mesh is not copied.
    assert_eq!(with(vec![at(0, 0.0)]), (true, 1, triangles));
    // A mesh of its own beside what moves.
    let mut moving = at(1, 3.0);
    moving.animated = true;
    let beside = |x: f32| vec![at(0, 1.0), at(1, x), moving.clone()];
    assert_eq!(with(beside(-3.0)), (false, 2, triangles + 2 + 2));
    // 10^6 m away a sphere would lose its shape; so would one of a nanometre.
    assert_eq!(with(vec![at(0, 1.0), at(1, 1e6)]).1, 2);
    let tiny = shapes::instance(1, Affine3A::from_scale(Vec3::splat(1e-9)));
    assert_eq!(with(vec![at(0, 1.0), tiny]).1, 2);
}

#[test]
fn a_turntable_keeps_the_baked_mesh_and_an_animation_what_stands_still() {
    let mut random = Random(73);
    let mut scene = collection(&mut random);
    let mut packer = Packer::default();
    let mut next = |scene: &Scene, turn: f32| {
        let mut view = shapes::view();
        view.camera.world_from_camera = Affine3A::from_rotation_y(turn);
        let packed = packer.pack(scene, &view).unwrap();
        let fresh = pack(scene, &view).unwrap();
        for (a, b) in packed.arrays().iter().zip(fresh.arrays()) {
            assert!(*a == b, "{} at {turn}", a.0);
        }
        (packer.new_parts()[0], packed.instances.len())
    };
    assert_eq!(next(&scene, 0.0), (1, 1));
    assert_eq!(next(&scene, 0.5), (0, 1));
    // Two instances of one mesh that is still baked elsewhere.
    for number in [4, 7] {
        scene.instances[number].animated = true;
    }
    assert_eq!(next(&scene, 1.0), (2, 3));
    for frame in 0..3 {
        for number in [4, 7] {
            let instance = &mut scene.instances[number];
            instance.world_from_object.translation.y += 0.1;
        }
        assert_eq!(next(&scene, 1.0), (0, 3), "frame {frame}");
    }
    // What was said to stand still and does not is baked again.
    scene.instances[0].world_from_object.translation.y += 0.1;
    assert_eq!(next(&scene, 1.0), (1, 3));
}
