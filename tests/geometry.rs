//! Tracing: the hierarchies against every triangle in turn, edges, degenerate input, culling, alpha.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod common;

use bytemuck::{Pod, Zeroable};
use common::rays::{RayQuery, query, ray, towards};
use common::shapes::{self, Random};
use glam::{Affine3A, DMat3, DVec3, Quat, Vec3, Vec3Swizzles};
use rayon::prelude::*;
use snell::cpu;
use snell::gpu::device::Gpu;
use snell::pack::Packed;
use snell::scene::{AlphaMode, Scene};
use snell::shared::NONE;

/// Mesa to 22.3 ends all loops of an invocation after 65 536 rounds in all and says nothing: as many boxes as a
/// ray may have to pass are not near that.
#[test]
fn a_ray_passes_the_boxes_of_many_triangles() {
    let corner = |x: f32, y: f32, z: f32| Vec3::new(x, y, -1e-3 * z);
    // The ray meets the half of each box that its triangle leaves free.
    let mut triangles: Vec<[Vec3; 3]> = (0..40_000)
        .map(|i| [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0]].map(|[x, y]| corner(x, y, i as f32)))
        .collect();
    triangles.push([[-4.0, -4.0], [8.0, -4.0], [-4.0, 8.0]].map(|[x, y]| corner(x, y, 50_000.0)));
    let scene = shapes::scene(
        vec![shapes::flat(&triangles)],
        vec![shapes::instance(0, Affine3A::IDENTITY)],
    );
    let packed = shapes::packed(&scene);
    let rays = [query(Vec3::new(0.5, 0.5, 1.0), Vec3::NEG_Z)];
    for traced in [trace_gpu(&packed, &rays), trace_cpu(&packed, &rays)] {
        assert_eq!(traced[0].any, 1);
        assert!((traced[0].t - 51.0).abs() < 1e-3, "{traced:?}");
    }
}

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct Traced {
    t: f32,
    u: f32,
    v: f32,
    instance: u32,
    triangle: u32,
    any: u32,
}

const TRACE: &str = "
import package::ray::{Ray, Hit};
import package::bvh::{trace_closest, trace_any};
struct Traced { t: f32, u: f32, v: f32, instance: u32, triangle: u32, any_hit: u32 }
@group(3) @binding(0) var<storage, read> rays: array<Ray>;
@group(3) @binding(1) var<storage, read_write> traced: array<Traced>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&rays) { return; }
    let hit = trace_closest(rays[id.x], id.x);
    let any_hit = select(0u, 1u, trace_any(rays[id.x], id.x));
    traced[id.x] = Traced(hit.t, hit.u, hit.v, hit.instance, hit.triangle, any_hit);
}";

/// The kernels' answers; ray number i has the alpha seed i.
fn trace_gpu(packed: &Packed, rays: &[RayQuery]) -> Vec<Traced> {
    trace_on(&common::gpu(), packed, rays)
}

/// The same on an adapter opened before.
fn trace_on(gpu: &Gpu, packed: &Packed, rays: &[RayQuery]) -> Vec<Traced> {
    let bytes = common::run_on(
        gpu,
        TRACE,
        Some(packed),
        &[bytemuck::cast_slice(rays)],
        size_of_val(rays) / size_of::<RayQuery>() * size_of::<Traced>(),
        rays.len() as u32,
    );
    bytemuck::pod_collect_to_vec(&bytes)
}

/// The reference's answers, in the kernels' form.
fn trace_cpu(packed: &Packed, rays: &[RayQuery]) -> Vec<Traced> {
    rays.par_iter()
        .enumerate()
        .map(|(seed, query)| {
            let hit = cpu::bvh::trace_closest(packed, ray(query), seed as u32);
            Traced {
                t: hit.t as f32,
                u: hit.u as f32,
                v: hit.v as f32,
                instance: hit.instance,
                triangle: hit.triangle,
                any: u32::from(cpu::bvh::trace_any(packed, ray(query), seed as u32)),
            }
        })
        .collect()
}

/// A scene's triangles in world space.
fn triangles(scene: &Scene) -> Vec<[DVec3; 3]> {
    let mut all = Vec::new();
    for instance in &scene.instances {
        for primitive in &scene.meshes[instance.mesh].primitives {
            for corners in &primitive.triangles {
                all.push(corners.map(|corner| {
                    let p = primitive.positions[corner as usize].as_dvec3();
                    instance.world_from_object.matrix3.as_dmat3() * p
                        + instance.world_from_object.translation.as_dvec3()
                }));
            }
        }
    }
    all
}

/// The nearest hit of a ray with triangles that are grown by `slack` in each barycentric coordinate,
/// by Cramer's rule and without any hierarchy.
fn nearest(triangles: &[[DVec3; 3]], query: &RayQuery, slack: f64) -> f64 {
    let ray = ray(query);
    let mut t_nearest = f64::INFINITY;
    for [p0, p1, p2] in triangles {
        let system = DMat3::from_cols(p1 - p0, p2 - p0, -ray.direction);
        let solved = system.inverse() * (ray.origin - p0);
        let (u, v, t) = (solved.x, solved.y, solved.z);
        if u >= -slack && v >= -slack && u + v <= 1.0 + slack && t > 0.0 && t < t_nearest {
            t_nearest = t;
        }
    }
    t_nearest
}

/// How answers compare with every triangle in turn.
#[derive(Debug, Default)]
struct Verdict {
    rays: usize,
    hits: usize,
    /// Right for triangles that are larger or smaller by 1e-4 of themselves: the ray meets an edge.
    edges: usize,
    wrong: usize,
}

fn judge(scene: &Scene, rays: &[RayQuery], traced: &[Traced]) -> Verdict {
    let triangles = triangles(scene);
    let outcomes: Vec<(bool, bool, bool)> = rays
        .par_iter()
        .zip(traced)
        .map(|(query, traced)| {
            let found = if traced.instance == NONE {
                f64::INFINITY
            } else {
                f64::from(traced.t)
            };
            assert_eq!(traced.any != 0, found.is_finite(), "any-hit: {query:?}");
            let agrees = |slack: f64| {
                let t = nearest(&triangles, query, slack);
                t == found || (t - found).abs() <= 2e-5 * (1.0 + t)
            };
            let right = agrees(0.0);
            (
                found.is_finite(),
                right,
                right || agrees(1e-4) || agrees(-1e-4),
            )
        })
        .collect();
    let count = |test: &dyn Fn(&(bool, bool, bool)) -> bool| {
        outcomes.iter().filter(|outcome| test(outcome)).count()
    };
    Verdict {
        rays: rays.len(),
        hits: count(&|o| o.0),
        edges: count(&|o| !o.1 && o.2),
        wrong: count(&|o| !o.2),
    }
}

/// Both renderers against every triangle and so against each other, with what stands still as one mesh and
/// with all meshes by themselves.
fn check(scene: &Scene, rays: &[RayQuery], least_hits: usize) {
    let baked = shapes::packed(scene);
    let apart = shapes::packed(&shapes::two_levels(scene.clone()));
    for (name, traced) in [
        ("kernels", trace_gpu(&baked, rays)),
        ("reference", trace_cpu(&baked, rays)),
        ("kernels, two levels", trace_gpu(&apart, rays)),
        ("reference, two levels", trace_cpu(&apart, rays)),
    ] {
        let verdict = judge(scene, rays, &traced);
        println!("{name}: {verdict:?}");
        assert_eq!(verdict.wrong, 0, "{name}: {verdict:?}");
        assert!(verdict.edges * 5000 <= verdict.rays, "{name}: {verdict:?}");
        assert!(verdict.hits >= least_hits, "{name}: {verdict:?}");
    }
}

/// Rays from a sphere of radius `from` towards points in the cube of half side `to`.
fn rays_around(random: &mut Random, count: usize, from: f32, to: f32) -> Vec<RayQuery> {
    (0..count)
        .map(|_| towards(from * random.direction(), to * random.cube()))
        .collect()
}

#[test]
fn random_triangles_are_hit_as_without_a_hierarchy() {
    let mut random = Random(1);
    for (count, size) in [
        (1, 1.0),
        (2, 1.0),
        (3, 1.0),
        (9, 0.8),
        (400, 0.3),
        (1500, 0.1),
    ] {
        let mesh = shapes::soup(&mut random, count, size);
        let scene = shapes::scene(vec![mesh], vec![shapes::instance(0, Affine3A::IDENTITY)]);
        let rays = rays_around(&mut random, 20_000, 3.0, 1.0);
        check(&scene, &rays, 200);
    }
}

#[test]
fn structured_meshes_are_hit_as_without_a_hierarchy() {
    let mut random = Random(2);
    let meshes = vec![
        shapes::grid(20, |_, _| 0.0),
        shapes::grid(16, |x, z| 0.2 * (5.0 * x).sin() * (4.0 * z).cos()),
        shapes::sphere(12, 0.7),
    ];
    for mesh in meshes {
        let scene = shapes::scene(vec![mesh], vec![shapes::instance(0, Affine3A::IDENTITY)]);
        let rays = rays_around(&mut random, 10_000, 2.0, 0.8);
        check(&scene, &rays, 2000);
    }
}

#[test]
fn instances_are_hit_where_their_transforms_put_them() {
    let mut random = Random(3);
    let meshes = vec![shapes::sphere(6, 0.3), shapes::soup(&mut random, 60, 0.3)];
    let instances = (0..24)
        .map(|i| {
            let scale = match i % 4 {
                0 => Vec3::ONE,
                1 => Vec3::new(-1.0, 1.0, 1.0),
                2 => Vec3::new(0.2, 1.5, 0.7),
                _ => Vec3::new(-0.5, -2.0, -0.1),
            };
            let rotation = Quat::from_axis_angle(random.direction(), random.range(0.0, 6.0));
            let transform =
                Affine3A::from_scale_rotation_translation(scale, rotation, random.cube());
            shapes::instance(i % 2, transform)
        })
        .collect();
    let scene = shapes::scene(meshes, instances);
    let rays = rays_around(&mut random, 20_000, 3.0, 1.0);
    check(&scene, &rays, 4000);
}

/// A ray enters an instance while others of the same node wait, with instances entered and alpha looked up within
/// the traversal's loop and outside of it: what waits is never taken for triangles of the instance. Each mesh is
/// smaller than what may wait, so that such triangles would be others' in a wrong place; the masked meshes are not
/// there at all.
#[test]
fn what_waits_outside_of_an_instance_is_not_met_in_it() {
    let mut random = Random(8);
    let mut meshes: Vec<_> = (0..12)
        .map(|i| shapes::soup(&mut random, 1 + i % 2, 0.8))
        .collect();
    for masked in meshes.iter_mut().step_by(3) {
        masked.primitives[0].material = 1;
    }
    let instances = (0..36)
        .map(|i| {
            let rotation = Quat::from_axis_angle(random.direction(), random.range(0.0, 6.0));
            let place = Affine3A::from_rotation_translation(rotation, 0.5 * random.cube());
            shapes::instance(i % 12, place)
        })
        .collect();
    let mut scene = shapes::two_levels(shapes::scene(meshes, instances));
    let mut nothing = shapes::material();
    nothing.alpha_mode = AlphaMode::Mask { cutoff: 2.0 };
    scene.materials.push(nothing);
    let packed = shapes::packed(&scene);
    let mut there = scene.clone();
    there.instances.retain(|instance| instance.mesh % 3 != 0);
    let rays = rays_around(&mut random, 20_000, 3.0, 1.0);
    let mut gpu = common::gpu();
    let mut kernels = |skips_branches| {
        gpu.skips_branches = skips_branches;
        trace_on(&gpu, &packed, &rays)
    };
    for (name, traced) in [
        ("outside of the loop", kernels(false)),
        ("within the loop", kernels(true)),
        ("reference", trace_cpu(&packed, &rays)),
    ] {
        let verdict = judge(&there, &rays, &traced);
        println!("{name}: {verdict:?}");
        assert_eq!(verdict.wrong, 0, "{name}: {verdict:?}");
        assert!(verdict.edges * 5000 <= verdict.rays, "{name}: {verdict:?}");
        assert!(verdict.hits > 4000, "{name}: {verdict:?}");
    }
}

#[test]
fn a_hierarchy_of_thousands_of_instances_is_traversed_whole() {
    let mut random = Random(4);
    let meshes = vec![shapes::flat(&[[Vec3::ZERO, Vec3::X, Vec3::Y]])];
    let instances = (0..1500)
        .map(|_| {
            let rotation = Quat::from_axis_angle(random.direction(), random.range(0.0, 6.0));
            let scale = Vec3::splat(random.range(0.02, 0.2));
            shapes::instance(
                0,
                Affine3A::from_scale_rotation_translation(scale, rotation, random.cube()),
            )
        })
        .collect();
    let scene = shapes::scene(meshes, instances);
    let rays = rays_around(&mut random, 10_000, 3.0, 1.0);
    check(&scene, &rays, 1000);
}

#[test]
fn rays_along_the_axes_are_traced() {
    let mut random = Random(5);
    let meshes = vec![
        shapes::grid(16, |_, _| 0.0),
        shapes::soup(&mut random, 200, 0.4),
    ];
    let instances = vec![
        shapes::instance(0, Affine3A::IDENTITY),
        shapes::instance(1, Affine3A::IDENTITY),
    ];
    let scene = shapes::scene(meshes, instances);
    let mut rays = Vec::new();
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        for sign in [1.0, -1.0] {
            for zero in [0.0_f32, -0.0] {
                for _ in 0..1000 {
                    let p = random.cube();
                    let side = Vec3::ONE - axis;
                    let direction = sign * axis + zero * side;
                    rays.push(query(p * side - 3.0 * sign * axis, direction));
                    // Two components of three.
                    let slanted = (sign * axis + axis.zxy() * random.range(-1.0, 1.0)).normalize();
                    rays.push(query(p - 3.0 * slanted, slanted));
                }
            }
        }
    }
    check(&scene, &rays, 5000);
    // Straight down on the grid's own lines and corners.
    let flat = shapes::scene(
        vec![shapes::grid(16, |_, _| 0.0)],
        vec![shapes::instance(0, Affine3A::IDENTITY)],
    );
    let mut rays = Vec::new();
    for i in 0..=16 {
        for j in 0..=64 {
            let (x, z) = (i as f32 / 8.0 - 1.0, j as f32 / 32.0 - 1.0);
            for (x, z) in [(x, z), (z, x)] {
                rays.push(query(Vec3::new(x, 1.0, z), Vec3::NEG_Y));
                rays.push(query(Vec3::new(x, -7.0, z), Vec3::Y));
            }
        }
    }
    let packed = shapes::packed(&flat);
    for traced in [trace_gpu(&packed, &rays), trace_cpu(&packed, &rays)] {
        let missed = traced.iter().filter(|hit| hit.instance == NONE).count();
        assert_eq!(missed, 0, "rays on edges, borders included");
    }
}

/// Rays through shared corners and shared edges, none of which may slip through.
#[test]
fn shared_edges_and_corners_do_not_leak() {
    let mut random = Random(6);
    let fine = shapes::sphere(100, 1.0);
    let corners: Vec<[Vec3; 3]> = fine.primitives[0]
        .triangles
        .iter()
        .map(|t| t.map(|corner| fine.primitives[0].positions[corner as usize]))
        .collect();
    let tilt = Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 0.7);
    for (transform, distance) in [
        (Affine3A::IDENTITY, 0.0),
        (Affine3A::IDENTITY, 100.0),
        (
            Affine3A::from_rotation_translation(tilt, Vec3::new(3.0, -20.0, 11.0)),
            30.0,
        ),
        (
            Affine3A::from_scale_rotation_translation(Vec3::new(4.0, 0.5, 2.0), tilt, Vec3::ONE),
            1000.0,
        ),
    ] {
        let scene = shapes::scene(vec![fine.clone()], vec![shapes::instance(0, transform)]);
        let packed = shapes::packed(&scene);
        let apart = shapes::packed(&shapes::two_levels(scene));
        let center = transform.transform_point3(Vec3::ZERO);
        let rays: Vec<RayQuery> = (0..50_000)
            .map(|i| {
                let [p0, p1, _] = corners[random.below(corners.len())];
                let along = if i % 2 == 0 { 0.0 } else { random.unit() };
                let object_target = p0.lerp(p1, along);
                let target = transform.transform_point3(object_target);
                // From within, or from afar onto the side that is seen well inside the silhouette.
                let origin = if distance == 0.0 {
                    0.3 * random.cube()
                } else {
                    let out = transform.transform_vector3(object_target).normalize();
                    target + distance * (out + 0.2 * random.cube()).normalize()
                };
                towards(origin, target)
            })
            .collect();
        let _ = center;
        for (name, traced) in [
            ("kernels", trace_gpu(&packed, &rays)),
            ("reference", trace_cpu(&packed, &rays)),
            ("kernels, two levels", trace_gpu(&apart, &rays)),
            ("reference, two levels", trace_cpu(&apart, &rays)),
        ] {
            let missed = traced.iter().filter(|hit| hit.instance == NONE).count();
            println!(
                "{name}, distance {distance}: {missed} of {} missed",
                rays.len()
            );
            assert_eq!(missed, 0, "{name}, distance {distance}");
        }
    }
}

#[test]
fn degenerate_triangles_are_never_hit_and_never_in_the_way() {
    let mut random = Random(7);
    let mut list: Vec<[Vec3; 3]> = Vec::new();
    for _ in 0..300 {
        let p = random.cube();
        let d = random.direction();
        list.push([p, p, p]);
        list.push([p, p + d, p]);
        list.push([p, p + 0.5 * d, p + d]);
    }
    let only = shapes::scene(
        vec![shapes::flat(&list)],
        vec![shapes::instance(0, Affine3A::IDENTITY)],
    );
    let rays = rays_around(&mut random, 10_000, 3.0, 1.0);
    let packed = shapes::packed(&only);
    for traced in [trace_gpu(&packed, &rays), trace_cpu(&packed, &rays)] {
        let hit = traced.iter().filter(|hit| hit.instance != NONE).count();
        assert!(
            hit <= 2,
            "{hit} of {} rays hit what has no area",
            rays.len()
        );
    }
    // A thousand triangles in one place, and a scene that is spread over many scales.
    let one = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let mut spread = vec![one; 1000];
    spread.extend((0..100).map(|i| one.map(|p| p * 1.4_f32.powi(i - 50))));
    let scene = shapes::scene(
        vec![shapes::flat(&spread)],
        vec![shapes::instance(0, Affine3A::IDENTITY); 200],
    );
    let packed = shapes::packed(&scene);
    let down = [query(Vec3::new(0.2, 0.2, 1.0), Vec3::NEG_Z)];
    assert_eq!(trace_gpu(&packed, &down)[0].t, 1.0);
    assert_eq!(trace_cpu(&packed, &down)[0].t, 1.0);
}

#[test]
fn an_empty_scene_is_missed() {
    let rays = [query(Vec3::ZERO, Vec3::X)];
    let flat = Affine3A::from_scale(Vec3::new(1.0, 0.0, 1.0));
    for scene in [
        Scene::default(),
        shapes::scene(
            vec![shapes::flat(&[])],
            vec![shapes::instance(0, Affine3A::IDENTITY)],
        ),
        shapes::scene(
            vec![shapes::sphere(4, 1.0)],
            vec![shapes::instance(0, flat)],
        ),
    ] {
        let packed = shapes::packed(&scene);
        assert_eq!(packed.frame.root, NONE);
        for traced in [trace_gpu(&packed, &rays), trace_cpu(&packed, &rays)] {
            assert_eq!((traced[0].instance, traced[0].any), (NONE, 0));
        }
    }
}

#[test]
fn a_ray_ends_where_it_is_told_to() {
    let scene = shapes::scene(
        vec![shapes::sphere(20, 1.0)],
        vec![shapes::instance(0, Affine3A::IDENTITY)],
    );
    let packed = shapes::packed(&scene);
    let from = |t_min: f32, t_max: f32| RayQuery {
        t_min,
        t_max,
        ..towards(Vec3::new(0.03, 0.1, 5.0), Vec3::ZERO)
    };
    let rays = [
        from(0.0, 3.9),
        from(0.0, 4.2),
        from(4.2, 5.5),
        from(4.2, 7.0),
        from(6.2, 1e30),
    ];
    for traced in [trace_gpu(&packed, &rays), trace_cpu(&packed, &rays)] {
        let any: Vec<u32> = traced.iter().map(|hit| hit.any).collect();
        assert_eq!(any, [0, 1, 0, 1, 0]);
        assert!(traced[3].t > 5.5 && traced[1].t < 4.2);
    }
}
