//! What moves while the shutter is open: where it is hit, how it blurs, what it lights, what it costs.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod common;
#[path = "common/picture.rs"]
mod picture;

use bytemuck::{Pod, Zeroable};
use common::rays::{RayQuery, ray, towards};
use common::shapes::{self, Random};
use glam::{Affine3A, DMat3, DVec3, Quat, Vec3};
use picture::*;
use snell::compare::z_test;
use snell::cpu;
use snell::cpu::filter::FILTER_OVERLAP;
use snell::film::{Film, FilmPixel, Weighted};
use snell::pack::{PackError, Packed, View, pack};
use snell::scene::{Instance, Model, Projection, Scene};
use snell::shared::NONE;

/// An instance that is at `keys` at equal steps from when the shutter opens to when it closes.
fn moving(mesh: usize, keys: &[Affine3A]) -> Instance {
    Instance {
        motion: keys[1..].into(),
        ..shapes::instance(mesh, keys[0])
    }
}

/// Where a moving instance is, by the definition and in float64.
fn at(instance: &Instance, time: f64) -> (DMat3, DVec3) {
    let keys: Vec<&Affine3A> = std::iter::once(&instance.world_from_object)
        .chain(&instance.motion)
        .collect();
    let place = time * (keys.len() - 1) as f64;
    let before = (place as usize).min(keys.len().saturating_sub(2));
    let after = (before + 1).min(keys.len() - 1);
    let part = place - before as f64;
    let [a, b] = [keys[before], keys[after]];
    (
        a.matrix3.as_dmat3() * (1.0 - part) + b.matrix3.as_dmat3() * part,
        a.translation.as_dvec3() * (1.0 - part) + b.translation.as_dvec3() * part,
    )
}

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct Met {
    t: f32,
    instance: u32,
    p: [f32; 3],
    front: u32,
    ng: [f32; 3],
    reserved: u32,
}

const MEET: &str = "
import package::shared::{NONE};
import package::ray::{Ray, Hit};
import package::bvh::{trace_closest};
import package::surface::{surface_at};
struct Met { t: f32, instance: u32, x: f32, y: f32, z: f32, front: u32, nx: f32, ny: f32, nz: f32, reserved: u32 }
@group(3) @binding(0) var<storage, read> rays: array<Ray>;
@group(3) @binding(1) var<storage, read_write> met: array<Met>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&rays) { return; }
    let hit = trace_closest(rays[id.x], 0u);
    met[id.x].instance = hit.instance;
    if hit.instance == NONE { return; }
    let s = surface_at(rays[id.x], hit);
    met[id.x] = Met(hit.t, hit.instance, s.p.x, s.p.y, s.p.z, s.front, s.ng.x, s.ng.y, s.ng.z, 0u);
}";

fn meet_gpu(packed: &Packed, rays: &[RayQuery]) -> Vec<Met> {
    let bytes = common::run_scene(
        MEET,
        packed,
        &[bytemuck::cast_slice(rays)],
        rays.len() * size_of::<Met>(),
        rays.len() as u32,
    );
    bytemuck::pod_collect_to_vec(&bytes)
}

fn meet_cpu(packed: &Packed, rays: &[RayQuery]) -> Vec<Met> {
    let meet = |query: &RayQuery| {
        let hit = cpu::bvh::trace_closest(packed, ray(query), 0);
        if hit.instance == NONE {
            return Met {
                instance: NONE,
                ..Met::zeroed()
            };
        }
        let s = cpu::surface::surface_at(packed, ray(query), hit);
        Met {
            t: hit.t as f32,
            instance: hit.instance,
            p: s.p.as_vec3().to_array(),
            front: u32::from(s.front),
            ng: s.ng.as_vec3().to_array(),
            reserved: 0,
        }
    };
    rays.iter().map(meet).collect()
}

fn timed(random: &mut Random, count: usize, to: f32) -> Vec<RayQuery> {
    (0..count)
        .map(|_| RayQuery {
            time: random.unit(),
            ..towards(3.0 * random.direction(), to * random.cube())
        })
        .collect()
}

/// Shapes that fly, turn, grow, and turn inside out, with one, two and five further keys.
fn swarm(random: &mut Random) -> Scene {
    let meshes = vec![shapes::sphere(6, 0.25), shapes::soup(random, 20, 0.3)];
    let instances = (0..20)
        .map(|i| {
            let key = |random: &mut Random, j: usize| {
                let mirror = if i % 5 == 0 && j % 2 == 1 { -1.0 } else { 1.0 };
                let turn = Quat::from_axis_angle(random.direction(), random.range(0.0, 1.5));
                let scale = Vec3::new(mirror, random.range(0.5, 1.5), random.range(0.3, 1.0));
                Affine3A::from_scale_rotation_translation(scale, turn, random.cube())
            };
            let keys: Vec<Affine3A> = (0..[1, 2, 3, 6][i % 4]).map(|j| key(random, j)).collect();
            moving(i % 2, &keys)
        })
        .collect();
    shapes::scene(meshes, instances)
}

#[test]
fn moving_instances_are_hit_where_they_are_at_the_rays_time() {
    let mut random = Random(31);
    let scene = swarm(&mut random);
    let packed = shapes::packed(&scene);
    let rays = timed(&mut random, 20_000, 1.0);
    // Every triangle in turn, by Cramer's rule; with triangles a little larger and smaller, too.
    let nearest = |query: &RayQuery, slack: f64| {
        let ray = ray(query);
        let mut nearest = f64::INFINITY;
        for instance in &scene.instances {
            let (matrix, translation) = at(instance, ray.time);
            for primitive in &scene.meshes[instance.mesh].primitives {
                for corners in &primitive.triangles {
                    let [p0, p1, p2] = corners.map(|corner| {
                        matrix * primitive.positions[corner as usize].as_dvec3() + translation
                    });
                    let system = DMat3::from_cols(p1 - p0, p2 - p0, -ray.direction);
                    let s = system.inverse() * (ray.origin - p0);
                    let inside = s.x >= -slack && s.y >= -slack && s.x + s.y <= 1.0 + slack;
                    if inside && s.z > 0.0 && s.z < nearest {
                        nearest = s.z;
                    }
                }
            }
        }
        nearest
    };
    let expected: Vec<[f64; 3]> = rays
        .iter()
        .map(|query| [0.0, 1e-4, -1e-4].map(|slack| nearest(query, slack)))
        .collect();
    for (name, met) in [
        ("kernels", meet_gpu(&packed, &rays)),
        ("reference", meet_cpu(&packed, &rays)),
    ] {
        let (mut hits, mut edges) = (0, 0);
        for ((met, expected), query) in met.iter().zip(&expected).zip(&rays) {
            let found = match met.instance {
                NONE => f64::INFINITY,
                _ => f64::from(met.t),
            };
            let agrees = |t: &f64| *t == found || (t - found).abs() <= 3e-5 * (1.0 + t);
            hits += usize::from(found.is_finite());
            edges += usize::from(!agrees(&expected[0]));
            assert!(
                expected.iter().any(agrees),
                "{name}: {met:?} {expected:?} {query:?}"
            );
            if met.instance != NONE {
                // The surface is that of the same moment.
                let q = ray(query);
                let there = q.origin + found * q.direction;
                let p = Vec3::from_array(met.p).as_dvec3();
                assert!(p.distance(there) < 1e-4, "{name}: {met:?}");
                let ng = Vec3::from_array(met.ng).as_dvec3();
                assert!(ng.dot(q.direction) < 1e-5, "{name}: {met:?}");
            }
        }
        println!("{name}: {hits} hits, {edges} at edges");
        assert!(hits > 4000 && edges * 1000 < rays.len());
    }
}

/// The front of a closed shape is its outside, whatever its matrix does in between.
#[test]
fn what_turns_inside_out_keeps_its_outside() {
    let mirrored = Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    let instance = moving(0, &[Affine3A::IDENTITY, mirrored]);
    let packed = shapes::packed(&shapes::scene(
        vec![shapes::sphere(12, 1.0)],
        vec![instance],
    ));
    let mut random = Random(32);
    let rays = timed(&mut random, 4000, 0.05);
    for met in [meet_gpu(&packed, &rays), meet_cpu(&packed, &rays)] {
        let hits = met.iter().filter(|met| met.instance != NONE);
        assert!(hits.clone().count() > 2000);
        assert_eq!(hits.filter(|met| met.front == 0).count(), 0);
    }
}

#[test]
fn keys_along_a_line_change_nothing() {
    let mut random = Random(33);
    let turn = Quat::from_axis_angle(random.direction(), 1.0);
    let keys = [
        Affine3A::from_rotation_translation(turn, Vec3::new(-0.7, 0.1, 0.0)),
        Affine3A::from_scale_rotation_translation(
            Vec3::new(1.0, 2.0, 0.5),
            Quat::IDENTITY,
            Vec3::new(0.8, -0.2, 0.4),
        ),
    ];
    let between = |part: f32| Affine3A {
        matrix3: keys[0].matrix3 * (1.0 - part) + keys[1].matrix3 * part,
        translation: keys[0].translation.lerp(keys[1].translation, part),
    };
    let packed = |count: usize| {
        let keys: Vec<Affine3A> = (0..=count)
            .map(|key| between(key as f32 / count as f32))
            .collect();
        let instance = moving(0, &keys);
        shapes::packed(&shapes::scene(vec![shapes::sphere(8, 0.4)], vec![instance]))
    };
    let rays = timed(&mut random, 4000, 0.6);
    for meet in [meet_gpu, meet_cpu] {
        let [one, seven] = [1, 7].map(|count| meet(&packed(count), &rays));
        let hits = one.iter().filter(|met| met.instance != NONE).count();
        let apart = |(a, b): &(&Met, &Met)| {
            a.instance != b.instance || a.instance != NONE && (a.t - b.t).abs() > 1e-4
        };
        let apart = one.iter().zip(&seven).filter(apart).count();
        println!("{hits} hits, {apart} apart");
        assert!(
            hits > 500 && apart * 500 < hits,
            "{hits} hits, {apart} apart"
        );
    }
}

#[test]
fn more_keys_than_an_instance_holds_end_in_a_sentence() {
    let keys = vec![Affine3A::IDENTITY; 257];
    let scene = |count: usize| {
        let instance = moving(0, &keys[..=count]);
        shapes::scene(vec![shapes::sphere(4, 1.0)], vec![instance])
    };
    assert!(pack(&scene(255), &shapes::view()).is_ok());
    let error = pack(&scene(256), &shapes::view()).map(|_| ()).unwrap_err();
    assert!(matches!(error, PackError::TooManyKeys { .. }), "{error}");
    assert!(error.to_string().contains("nodes[0]"), "{error}");
}

/// A parallel camera that looks down -z at [-2, 2] x [-1, 1].
fn overhead(size: [u32; 2]) -> View {
    let mut view = shapes::view();
    view.camera.world_from_camera = Affine3A::from_translation(Vec3::new(0.0, 0.0, 5.0));
    view.camera.projection = Projection::Orthographic {
        xmag: 2.0,
        ymag: 1.0,
        near: 0.0,
    };
    view.film_size = size;
    view
}

/// A white square of side 1 flies by its own width: the time for which a point is covered rises and
/// falls in straight lines.
#[test]
fn a_flying_square_blurs_as_its_closed_form() {
    const SIZE: [u32; 2] = [128, 64];
    const SAMPLES: u32 = 256;
    let half = 0.5_f32;
    let corner = |x: f32, y: f32| Vec3::new(x, y, 0.0);
    let square = shapes::flat(&[
        [corner(-half, -2.0), corner(half, -2.0), corner(half, 2.0)],
        [corner(-half, -2.0), corner(half, 2.0), corner(-half, 2.0)],
    ]);
    let place = |x: f32| Affine3A::from_translation(Vec3::new(x, 0.0, 0.0));
    let mut scene = shapes::scene(vec![square], vec![moving(0, &[place(-0.5), place(0.5)])]);
    scene.materials[0].model = Model::Unlit {
        base_color: glam::Vec4::ONE,
        base_color_texture: None,
    };
    let packed = pack(&scene, &overhead(SIZE)).unwrap();
    let settings = whole(&packed, SAMPLES);
    let mut gpu = common::gpu();
    let pixel = 4.0 / f64::from(SIZE[0]);
    for (name, film) in [
        ("kernels", on_gpu(&mut gpu, &packed, &settings)),
        ("reference", on_cpu(&packed, &settings)),
    ] {
        let (mut compared, mut ramps) = (0, 0);
        for column in 0..SIZE[0] {
            let x = (f64::from(column) + 0.5) * pixel - 2.0;
            // At -1, 0 and 1 the lines meet, and the pixel's filter sees more than one.
            if [-1.0, 0.0, 1.0]
                .iter()
                .any(|kink: &f64| (x - kink).abs() < 1.5 * pixel)
            {
                continue;
            }
            let covered = (1.0 - x.abs()).max(0.0);
            let mean: f64 = (0..SIZE[1])
                .map(|row| film.pixel(column, row).mean()[0])
                .sum::<f64>()
                / f64::from(SIZE[1]);
            // As if the samples were independent, four standard deviations: stratified, they do better.
            let count = f64::from(SAMPLES * SIZE[1]);
            let bound = 4.0 * (covered * (1.0 - covered) / count).sqrt() + 1e-6;
            assert!(
                (mean - covered).abs() < bound,
                "{name}: column {column}, {mean} is not {covered} within {bound}"
            );
            compared += 1;
            ramps += usize::from(covered > 0.0);
        }
        assert!(
            compared > 100 && ramps > 50,
            "{compared} columns, {ramps} on ramps"
        );
    }
}

/// A lamp over a floor that flies, tilts and grows to four times its area.
fn lamp_over_floor() -> Scene {
    let lamp = shapes::flat(&[[
        Vec3::new(-0.3, 0.0, -0.3),
        Vec3::new(0.3, 0.0, -0.3),
        Vec3::new(0.0, 0.0, 0.4),
    ]]);
    let mut lamp = lamp;
    lamp.primitives[0].material = 1;
    let floor = shapes::grid(1, |_, _| 0.0);
    let keys = [
        Affine3A::from_translation(Vec3::new(-0.6, 0.3, 0.0)),
        Affine3A::from_scale_rotation_translation(
            Vec3::splat(2.0),
            Quat::from_rotation_z(0.6),
            Vec3::new(0.5, 0.8, 0.1),
        ),
    ];
    let mut scene = shapes::scene(
        vec![floor, lamp],
        vec![
            shapes::instance(0, Affine3A::from_scale(Vec3::splat(1.5))),
            moving(1, &keys),
        ],
    );
    let mut glowing = shapes::material();
    glowing.emissive = Vec3::new(3.0, 2.0, 1.0);
    scene.materials.push(glowing);
    scene
}

fn from_above() -> View {
    let mut view = shapes::view();
    view.film_size = [48, 36];
    view.max_depth = 2;
    let back = Vec3::new(0.0, 1.0, 1.0).normalize();
    view.camera.world_from_camera = Affine3A::from_mat3_translation(
        glam::Mat3::from_cols(Vec3::X, back.cross(Vec3::X), back),
        3.1 * back,
    );
    view
}

/// With and without aiming at the lamp's area as it is in the table: directly lit surfaces, glossy ones
/// that find the lamp by themselves, and the lamp itself.
#[test]
fn a_moving_lamp_lights_as_the_mean_of_its_still_pictures() {
    const STILLS: u32 = 64;
    const EACH: u32 = 16;
    let mut scene = lamp_over_floor();
    if let Model::MetallicRoughness(model) = &mut scene.materials[0].model {
        model.roughness = 0.3;
        model.metallic = 0.5;
    }
    let view = from_above();
    let moving = pack(&scene, &view).unwrap();
    let mut gpu = common::gpu();
    let blurred = on_gpu(&mut gpu, &moving, &whole(&moving, STILLS * EACH));
    let lamp = scene.instances[1].clone();
    let still = |still: u32| {
        let (matrix, translation) = at(&lamp, (f64::from(still) + 0.5) / f64::from(STILLS));
        scene.instances[1].motion = Box::default();
        scene.instances[1].world_from_object = Affine3A {
            matrix3: matrix.as_mat3().into(),
            translation: translation.as_vec3().into(),
        };
        let packed = pack(&scene, &view).unwrap();
        let mut settings = whole(&packed, 0);
        settings.samples = still * EACH..(still + 1) * EACH;
        on_gpu(&mut gpu, &packed, &settings)
    };
    let stills: Vec<Film> = (0..STILLS).map(still).collect();
    let mut mean = Film::new(view.film_size[0], view.film_size[1]);
    let samples = STILLS * EACH;
    for (index, pixel) in mean.pixels.iter_mut().enumerate() {
        let of_stills = || stills.iter().map(|film| film.pixels[index]);
        let mean_of = |value: &dyn Fn(FilmPixel) -> f64| {
            of_stills().map(value).sum::<f64>() / f64::from(STILLS)
        };
        let mean = [0, 1, 2].map(|c: usize| mean_of(&|one| one.mean()[c]));
        // All samples' deviation is that of a still's from its mean, and that of the stills' means.
        let count = f64::from(EACH) * FILTER_OVERLAP;
        let square =
            |c: usize| mean_of(&|one| (count - 1.0) * one.variance()[c] + one.mean()[c].powi(2));
        let weight = f64::from(samples);
        *pixel = Weighted {
            weight,
            weight_squares: weight / FILTER_OVERLAP,
            sum: mean.map(|mean| weight * mean),
            squares: [0, 1, 2].map(|c| weight * square(c)),
            alpha: weight * mean_of(&|one| one.coverage()),
            non_finite: 0,
        }
        .pixel(samples);
    }
    let verdict = z_test(&blurred, &mean, 0.01);
    let [a, b] = [&blurred, &mean].map(Film::average);
    println!("{a} and {b}: {verdict:?}");
    assert!(verdict.same, "{a} and {b}: {verdict:?}");
    assert!((a / b - 1.0).abs() < 0.01, "{a} and {b}");
}

#[test]
fn pictures_of_motion_agree_with_the_reference() {
    let mut gpu = common::gpu();
    let packed_lamp = pack(&lamp_over_floor(), &from_above()).unwrap();
    let mut swarm = swarm(&mut Random(34));
    swarm.materials[0].emissive = Vec3::new(0.3, 0.6, 0.9);
    let packed_swarm = packed(&swarm, [64, 48]);
    for (name, packed) in [("lamp", packed_lamp), ("swarm", packed_swarm)] {
        let settings = whole(&packed, 8);
        let films = (
            on_gpu(&mut gpu, &packed, &settings),
            on_cpu(&packed, &settings),
        );
        println!("{}", assert_parity(name, &films.0, &films.1));
    }
}

/// Half the instances fly: what is still is still where it was, and the arrays grow by the keys alone.
#[test]
fn instances_take_memory_in_proportion() {
    const COUNT: usize = 100_000;
    let side = (COUNT as f32).cbrt().ceil();
    let place = |i: usize| {
        let i = i as f32;
        let at = Vec3::new(
            i % side,
            (i / side).floor() % side,
            (i / (side * side)).floor(),
        );
        Affine3A::from_translation(at)
    };
    let mut scene = shapes::scene(
        vec![shapes::sphere(4, 0.3)],
        (0..COUNT).map(|i| shapes::instance(0, place(i))).collect(),
    );
    let still = shapes::packed(&scene);
    assert_eq!(size_of::<snell::shared::Instance>(), 64);
    assert_eq!(still.instances.len(), COUNT);
    // A node of 80 bytes has up to eight children, a leaf up to three instances.
    let nodes = size_of_val(still.nodes.as_slice());
    assert!(nodes < 80 * COUNT / 2, "{nodes} bytes of nodes");
    for instance in scene.instances.iter_mut().step_by(2) {
        instance.motion = [instance.world_from_object].into();
    }
    let moving = shapes::packed(&scene);
    assert_eq!(moving.instances.len(), COUNT + COUNT / 2);
    assert!(moving.moves() && !still.moves());
    assert_eq!(moving.nodes, still.nodes);
}
