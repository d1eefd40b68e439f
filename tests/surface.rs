//! Surfaces where rays met them: points, normals, frames, new rays, visibility, materials.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod common;

use bytemuck::{Pod, Zeroable};
use common::rays::{RayQuery, query, ray, towards};
use common::shapes::{self, Random};
use glam::{Affine3A, DVec3, Quat, Vec2, Vec3, Vec4};
use snell::cpu;
use snell::pack::Packed;
use snell::scene::bsdf_model::BsdfModel;
use snell::scene::{
    AlphaMode, Filter, Image, Mesh, Model, Pixels, Primitive, Scene, Texture, Wrap,
};
use snell::shared::{Bsdf, NONE};

/// One ray's surface, flattened, and two rays from its either side.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Answer {
    p: [f32; 3],
    p_error: f32,
    ng: [f32; 3],
    front: u32,
    t: [f32; 3],
    instance: u32,
    b: [f32; 3],
    triangle: u32,
    n: [f32; 3],
    material: u32,
    color: [f32; 4],
    above: [f32; 3],
    hit_t: f32,
    below: [f32; 3],
    hit_u: f32,
    emitted: [f32; 3],
    hit_v: f32,
    bsdf: Bsdf,
}

const SURFACES: &str = "
import package::shared::{NONE, Bsdf};
import package::bindings::{materials};
import package::ray::{Ray, Hit, offset_origin};
import package::bvh::{trace_closest};
import package::surface::{Surface, surface_at};
import package::material::{bsdf_at, Le_surface};
struct Answer {
    p: vec3<f32>, p_error: f32, ng: vec3<f32>, front: u32, t: vec3<f32>, instance: u32,
    b: vec3<f32>, triangle: u32, n: vec3<f32>, material: u32, color: vec4<f32>,
    above: vec3<f32>, hit_t: f32, below: vec3<f32>, hit_u: f32, emitted: vec3<f32>, hit_v: f32,
    bsdf: Bsdf,
}
@group(3) @binding(0) var<storage, read> rays: array<Ray>;
@group(3) @binding(1) var<storage, read_write> answers: array<Answer>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&rays) { return; }
    let ray = rays[id.x];
    let hit = trace_closest(ray, id.x);
    answers[id.x].instance = hit.instance;
    if hit.instance == NONE { return; }
    let s = surface_at(ray, hit);
    let ior = materials[s.material].ior;
    let eta = select(1.0 / ior, ior, s.front != 0u);
    answers[id.x] = Answer(
        s.p, s.p_error, s.ng, s.front, s.basis.t, hit.instance, s.basis.b, s.triangle, s.basis.n, s.material,
        s.color, offset_origin(s.p, s.ng, s.ng, s.p_error), hit.t, offset_origin(s.p, s.ng, -s.ng, s.p_error), hit.u,
        Le_surface(materials[s.material], s), hit.v, bsdf_at(materials[s.material], s, eta));
}";

fn surfaces_gpu(packed: &Packed, rays: &[RayQuery]) -> Vec<Answer> {
    let bytes = common::run_scene(
        SURFACES,
        packed,
        &[bytemuck::cast_slice(rays)],
        rays.len() * size_of::<Answer>(),
        rays.len() as u32,
    );
    bytemuck::pod_collect_to_vec(&bytes)
}

/// The reference's surfaces of the reference's hits.
fn surfaces_cpu(packed: &Packed, rays: &[RayQuery]) -> Vec<Answer> {
    let of = |(seed, query): (usize, &RayQuery)| {
        let hit = cpu::bvh::trace_closest(packed, ray(query), seed as u32);
        surface_cpu(packed, query, hit)
    };
    rays.iter().enumerate().map(of).collect()
}

fn surface_cpu(packed: &Packed, query: &RayQuery, hit: cpu::ray::Hit) -> Answer {
    let mut answer = Answer {
        instance: hit.instance,
        ..Answer::zeroed()
    };
    if hit.instance == NONE {
        return answer;
    }
    let s = cpu::surface::surface_at(packed, ray(query), hit);
    let material = &packed.materials[s.material as usize];
    let vector = |v: DVec3| v.as_vec3().to_array();
    let offset = |w| vector(cpu::ray::offset_origin(s.p, s.ng, w, s.p_error));
    let ior = f64::from(material.ior);
    let eta = if s.front { ior } else { ior.recip() };
    let bsdf = cpu::material::bsdf_at(packed, material, &s, eta);
    answer.p = vector(s.p);
    answer.p_error = s.p_error as f32;
    answer.ng = vector(s.ng);
    answer.front = u32::from(s.front);
    answer.t = vector(s.basis.t);
    answer.b = vector(s.basis.b);
    answer.n = vector(s.basis.n);
    answer.triangle = s.triangle;
    answer.material = s.material;
    answer.color = s.color.as_vec4().to_array();
    answer.above = offset(s.ng);
    answer.below = offset(-s.ng);
    answer.emitted = vector(cpu::material::Le_surface(packed, material, &s));
    [answer.hit_t, answer.hit_u, answer.hit_v] = [hit.t, hit.u, hit.v].map(|x| x as f32);
    answer.bsdf = Bsdf::from(&bsdf);
    answer
}

/// Largest difference of two answers' numbers, each relative to the larger of its own and `scale`.
fn difference(a: &Answer, b: &Answer, scale: f32) -> f32 {
    let gap = |a: &[f32], b: &[f32], scale: f32| {
        let gaps = a
            .iter()
            .zip(b)
            .map(|(a, b)| (a - b).abs() / a.abs().max(b.abs()).max(scale));
        gaps.fold(0.0_f32, f32::max)
    };
    [
        gap(&a.p, &b.p, scale),
        gap(&[a.p_error], &[b.p_error], 0.0),
        gap(&a.ng, &b.ng, 1.0),
        gap(&a.t, &b.t, 1.0),
        gap(&a.b, &b.b, 1.0),
        gap(&a.n, &b.n, 1.0),
        gap(&a.color, &b.color, 1e-3),
        gap(&a.emitted, &b.emitted, 1e-2),
        gap(&a.bsdf.reflectance, &b.bsdf.reflectance, 1e-2),
        gap(&a.bsdf.eta, &b.bsdf.eta, 1e-2),
        gap(&a.bsdf.k, &b.bsdf.k, 1e-2),
        gap(&a.bsdf.alpha, &b.bsdf.alpha, 1e-2),
        gap(&[a.bsdf.roughness], &[b.bsdf.roughness], 1e-2),
    ]
    .into_iter()
    .fold(0.0, f32::max)
}

/// Images that a test's textures show: 0 is noise, 1 a normal map of bumps, both 16 x 16.
fn images() -> Vec<Image> {
    let mut random = Random(99);
    let noise = (0..16 * 16 * 4).map(|_| random.bits() as u8).collect();
    let bumps = (0..16 * 16)
        .flat_map(|_| {
            let tilt = |random: &mut Random| (128.0 + 60.0 * random.range(-1.0, 1.0)) as u8;
            [tilt(&mut random), tilt(&mut random), 230, 255]
        })
        .collect();
    [noise, bumps]
        .map(|pixels| Image {
            name: String::new(),
            width: 16,
            height: 16,
            pixels: Pixels::Rgba8(pixels),
        })
        .into()
}

fn texture(image: usize, srgb: bool) -> Option<Texture> {
    Some(Texture {
        image,
        srgb,
        wrap_s: Wrap::Repeat,
        wrap_t: Wrap::Mirror,
        filter: Filter::Linear,
        texcoord: 0,
        rows: [Vec3::new(1.5, 0.2, 0.1), Vec3::new(-0.1, 0.8, 0.0)],
    })
}

/// A sphere with every attribute, tangents along the circles of latitude.
fn dressed_sphere(n: u32, material: usize) -> Mesh {
    let mut mesh = shapes::sphere(n, 1.0);
    let primitive = &mut mesh.primitives[0];
    let tangent = |n: &Vec3| Vec3::new(-n.z, 0.0, n.x).try_normalize().unwrap_or(Vec3::X);
    let tangents = primitive.normals.iter().map(|n| tangent(n).extend(-1.0));
    let colors = primitive
        .normals
        .iter()
        .map(|n| (0.5 + 0.4 * *n).extend(0.9));
    let texcoords = primitive.normals.iter().map(|n| Vec2::new(n.x + n.z, n.y));
    primitive.tangents = Some(tangents.collect());
    primitive.colors = Some(colors.collect());
    primitive.texcoords = vec![texcoords.collect()];
    primitive.material = material;
    mesh
}

/// Spheres of every kind of material under rotations and uneven and mirroring scales.
fn gallery() -> Scene {
    let mut textured = shapes::material();
    textured.normal_texture = texture(1, false);
    textured.normal_scale = 0.8;
    textured.emissive = Vec3::new(2.0, 1.0, 0.5);
    textured.emissive_texture = texture(0, true);
    if let Model::MetallicRoughness(m) = &mut textured.model {
        m.base_color_texture = texture(0, true);
        m.metallic_roughness_texture = texture(0, false);
        m.metallic = 0.9;
    }
    let mut unlit = shapes::material();
    unlit.model = Model::Unlit {
        base_color: Vec4::new(0.2, 0.4, 0.6, 1.0),
        base_color_texture: texture(0, true),
    };
    let mut glass = shapes::material();
    glass.double_sided = false;
    glass.model = Model::Bsdf {
        bsdf: BsdfModel::Dielectric {
            eta: 1.5,
            distribution: None,
        },
        base_color: Vec4::ONE,
        base_color_texture: None,
    };
    let mut random = Random(11);
    let meshes = (0..3).map(|m| dressed_sphere(12, m)).collect();
    let instances = (0..12)
        .map(|i| {
            let mirror = if i % 2 == 0 { 1.0 } else { -1.0 };
            let scale = Vec3::new(mirror * 0.3, random.range(0.1, 0.4), random.range(0.1, 0.4));
            let rotation = Quat::from_axis_angle(random.direction(), random.range(0.0, 6.0));
            let place = random.cube();
            shapes::instance(
                i % 3,
                Affine3A::from_scale_rotation_translation(scale, rotation, place),
            )
        })
        .collect();
    let mut scene = shapes::scene(meshes, instances);
    scene.materials = vec![textured, unlit, glass];
    scene.images = images().into_iter().map(Into::into).collect();
    scene
}

fn rays_around(random: &mut Random, count: usize, from: f32, to: f32) -> Vec<RayQuery> {
    (0..count)
        .map(|_| towards(from * random.direction(), to * random.cube()))
        .collect()
}

#[test]
fn kernels_and_reference_see_the_same_surfaces() {
    let packed = shapes::packed(&gallery());
    let mut random = Random(12);
    let mut rays = rays_around(&mut random, 20_000, 3.0, 1.0);
    // From within the spheres, too.
    rays.extend((0..10_000).map(|_| towards(random.cube(), random.cube())));
    let (mut hits, mut backs, mut far, mut worst) = (0, 0, 0, 0.0_f32);
    for (gpu, query) in surfaces_gpu(&packed, &rays).iter().zip(&rays) {
        if gpu.instance == NONE {
            continue;
        }
        // Of the kernels' own hit: a texture turns a shift of 1e-6 along it into anything.
        let hit = cpu::ray::Hit {
            t: f64::from(gpu.hit_t),
            u: f64::from(gpu.hit_u),
            v: f64::from(gpu.hit_v),
            instance: gpu.instance,
            triangle: gpu.triangle,
        };
        let cpu = surface_cpu(&packed, query, hit);
        hits += 1;
        backs += usize::from(gpu.front == 0);
        assert_eq!(
            (gpu.material, gpu.bsdf.model),
            (cpu.material, cpu.bsdf.model)
        );
        assert_eq!(gpu.front, cpu.front);
        let gap = difference(gpu, &cpu, 1.0);
        worst = worst.max(gap);
        far += usize::from(gap > 1e-4);
    }
    println!("{hits} hits, {backs} from behind, {far} off, worst {worst:e}");
    assert!(hits > 10_000 && backs > 500);
    // Normal maps and texture coordinates leave float32 a little more than that, rarely.
    assert!(
        far <= hits / 5000 && worst < 3e-4,
        "{far} of {hits}, worst {worst:e}"
    );
}

#[test]
fn frames_are_orthonormal_and_on_the_viewers_side() {
    let packed = shapes::packed(&gallery());
    let mut random = Random(13);
    let mut rays = rays_around(&mut random, 5000, 3.0, 1.0);
    rays.extend((0..5000).map(|_| towards(random.cube(), random.cube())));
    let outside = surfaces_gpu(&packed, &rays);
    for (answer, query) in outside.iter().zip(&rays) {
        if answer.instance == NONE {
            continue;
        }
        let [t, b, n, ng] = [answer.t, answer.b, answer.n, answer.ng].map(Vec3::from_array);
        let wo = -Vec3::from_array(query.direction);
        for (product, expected) in [
            (t.dot(t), 1.0),
            (b.dot(b), 1.0),
            (n.dot(n), 1.0),
            (ng.dot(ng), 1.0),
            (t.dot(b), 0.0),
            (t.dot(n), 0.0),
            (b.dot(n), 0.0),
            (t.cross(b).dot(n), 1.0),
        ] {
            assert!((product - expected).abs() < 2e-6, "{answer:?}");
        }
        assert!(ng.dot(wo) >= -1e-6 && n.dot(wo) > 0.0, "{answer:?}");
    }
}

/// A sphere's outside is its front under every transform, and its normals follow the transform.
#[test]
fn normals_follow_transforms_that_mirror_and_stretch() {
    let mut random = Random(14);
    for i in 0..20 {
        let mirror = if i % 2 == 0 { 1.0 } else { -1.0 };
        let scale = Vec3::new(mirror * 2.0, random.range(0.2, 3.0), random.range(0.2, 3.0));
        let rotation = Quat::from_axis_angle(random.direction(), random.range(0.0, 6.0));
        let transform =
            Affine3A::from_scale_rotation_translation(scale, rotation, 5.0 * random.cube());
        let scene = shapes::scene(
            vec![shapes::sphere(60, 1.0)],
            vec![shapes::instance(0, transform)],
        );
        let packed = shapes::packed(&scene);
        let rays: Vec<_> = (0..200)
            .map(|_| {
                // Off the silhouette, where a ray may touch a facet that faces away.
                let target = transform.transform_point3(0.9 * random.direction());
                let origin = transform.transform_point3(3.0 * random.direction());
                towards(origin, target)
            })
            .collect();
        for answers in [surfaces_gpu(&packed, &rays), surfaces_cpu(&packed, &rays)] {
            for answer in answers.iter().filter(|answer| answer.instance != NONE) {
                // The gradient of the ellipsoid's implicit equation.
                let p = Vec3::from_array(answer.p);
                let object = transform.inverse().transform_point3(p);
                let outward = (transform.matrix3.inverse().transpose() * object).normalize();
                assert_eq!(answer.front, 1, "seen from outside");
                assert!(
                    Vec3::from_array(answer.n).dot(outward) > 0.999,
                    "{answer:?}"
                );
                assert!(
                    Vec3::from_array(answer.ng).dot(outward) > 0.98,
                    "{answer:?}"
                );
            }
        }
    }
}

/// Rays that start on a surface neither meet it again nor pass through a wall close behind it.
#[test]
fn new_rays_leave_the_surface_at_every_scale() {
    let mut random = Random(15);
    let wall = |h: f32| shapes::grid(1, move |_, _| h);
    let gap = 1e-4;
    for exponent in -3..=5 {
        let size = 10.0_f32.powi(exponent);
        for tilted in [false, true] {
            let rotation = if tilted {
                Quat::from_axis_angle(random.direction(), 1.0)
            } else {
                Quat::IDENTITY
            };
            let transform = Affine3A::from_scale_rotation_translation(
                Vec3::splat(size),
                rotation,
                size * 2.0 * random.cube(),
            );
            let mut meshes = vec![wall(0.0), wall(-gap), shapes::sphere(30, 0.8)];
            for mesh in &mut meshes[1..] {
                mesh.primitives[0].material = 1;
            }
            let mut scene = shapes::scene(
                meshes,
                vec![
                    shapes::instance(0, transform),
                    shapes::instance(1, transform),
                    shapes::instance(2, transform),
                ],
            );
            scene.materials.push(shapes::material());
            let rays: Vec<_> = (0..1000)
                .map(|_| {
                    let above = random.cube() * Vec3::new(3.0, 0.0, 3.0) + 2.0 * Vec3::Y;
                    let target = random.cube() * Vec3::new(0.9, 0.0, 0.9);
                    let [above, target] = [above, target].map(|p| transform.transform_point3(p));
                    towards(above, target)
                })
                .collect();
            for (levels, packed) in [
                ("one level", shapes::packed(&scene)),
                ("two levels", shapes::packed(&shapes::two_levels(scene))),
            ] {
                let first = surfaces_gpu(&packed, &rays);
                let mut next = Vec::new();
                for answer in first.iter().filter(|answer| answer.instance != NONE) {
                    let ng = Vec3::from_array(answer.ng);
                    let w = (ng + random.direction() * 0.999).normalize();
                    next.push((*answer, Vec3::from_array(answer.above), w));
                    next.push((*answer, Vec3::from_array(answer.below), -w));
                }
                let rays: Vec<_> = next
                    .iter()
                    .map(|&(_, p, w)| towards(p, p + w * size))
                    .collect();
                let second = surfaces_gpu(&packed, &rays);
                let (mut again, mut through, mut below_wall) = (0, 0, 0);
                for ((from, _, w), to) in next.iter().zip(&second) {
                    again +=
                        usize::from((to.instance, to.triangle) == (from.instance, from.triangle));
                    // Downwards from the upper wall there is always the lower one (its borders apart).
                    let wall_above = from.material == 0;
                    let downwards = w.dot(Vec3::from_array(from.ng)) < -0.5;
                    if wall_above && downwards && well_inside(transform, from.p) {
                        below_wall += 1;
                        let distance = (Vec3::from_array(to.p) - Vec3::from_array(from.p)).length();
                        through += usize::from(to.instance == NONE || distance > 5.0 * gap * size);
                    }
                }
                println!(
                    "size {size}, {levels}: {} rays, {again} again, {through} of {below_wall} through",
                    rays.len()
                );
                assert_eq!(again, 0, "size {size}, tilted {tilted}, {levels}");
                assert_eq!(through, 0, "size {size}, tilted {tilted}, {levels}");
                assert!(below_wall > 100);
            }
        }
    }
}

/// Transforms by what is hard about inverting them in single precision.
fn awkward_transforms(random: &mut Random) -> Vec<(&'static str, Affine3A)> {
    let turn = |random: &mut Random| {
        Affine3A::from_quat(Quat::from_axis_angle(
            random.direction(),
            random.range(0.5, 2.5),
        ))
    };
    let scale = |x, y, z| Affine3A::from_scale(Vec3::new(x, y, z));
    let mut all = Vec::new();
    for _ in 0..4 {
        let [first, second] = [turn(random), turn(random)];
        all.extend([
            ("rotated, 1 : 1 : 1000", first * scale(1.0, 1.0, 1000.0)),
            ("1 : 1 : 1000 of rotated", scale(1.0, 1.0, 1000.0) * first),
            ("sheared 1 : 5", first * scale(1.0, 2.0, 5.0) * second),
            ("sheared 1 : 30", first * scale(1.0, -5.0, 30.0) * second),
            ("sheared 1 : 1000", first * scale(1.0, 1000.0, 1.0) * second),
            ("tiny", first * scale(1e-12, 2e-12, 1e-12)),
            ("huge", first * scale(1e12, 1e12, 3e12)),
            ("three scales", first * scale(0.1, 1.0, 30.0)),
        ]);
    }
    for (_, transform) in &mut all {
        let size = transform.matrix3.x_axis.length();
        transform.translation = (3.0 * size * random.direction()).into();
    }
    all
}

/// Points near the triangles' plane, taken into the object's space by the kernels, against what the
/// offset of new rays allows for.
#[test]
fn the_way_into_an_object_is_as_exact_as_the_offset_says() {
    const ROUNDING: f64 = cpu::surface::SURFACE_ROUNDING;
    const INTO: &str = "
import package::transform::{normal_matrix, transform_translation, vector_in_object};
@group(3) @binding(0) var<storage, read> rows: array<vec4<f32>>;
@group(3) @binding(1) var<storage, read> points: array<vec4<f32>>;
@group(3) @binding(2) var<storage, read_write> local: array<vec4<f32>>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&points) { return; }
    let matrix = array(rows[3u * id.x], rows[3u * id.x + 1u], rows[3u * id.x + 2u]);
    let offset = points[id.x].xyz - transform_translation(matrix);
    local[id.x] = vec4(vector_in_object(matrix, normal_matrix(matrix), offset), 0.0);
}";
    let mut random = Random(21);
    let transforms = awkward_transforms(&mut random);
    let (mut rows, mut points, mut of) = (Vec::new(), Vec::new(), Vec::new());
    for (number, (_, transform)) in transforms.iter().enumerate() {
        let matrix = transform.matrix3.transpose();
        let t = transform.translation;
        for _ in 0..2000 {
            for (row, t) in [matrix.x_axis, matrix.y_axis, matrix.z_axis]
                .iter()
                .zip(t.to_array())
            {
                rows.push(row.extend(t).to_array());
            }
            let local = random.cube();
            points.push(transform.transform_point3(local).extend(1.0).to_array());
            of.push(number);
        }
    }
    let bytes = common::run(
        INTO,
        &[bytemuck::cast_slice(&rows), bytemuck::cast_slice(&points)],
        points.len() * 16,
        points.len() as u32,
    );
    let locals: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&bytes);
    let mut worst = vec![0.0_f64; transforms.len()];
    for (i, (local, point)) in locals.iter().zip(&points).enumerate() {
        let rows = [rows[3 * i], rows[3 * i + 1], rows[3 * i + 2]];
        let local = Vec4::from_array(*local).truncate().as_dvec3();
        let rows = rows.map(|row| Vec4::from_array(row).as_dvec4());
        let there = cpu::transform::transform_point(rows, local);
        let shift = there - Vec4::from_array(*point).truncate().as_dvec3();
        for _ in 0..8 {
            let ng = random.direction().as_dvec3();
            let reach = DVec3::ONE;
            let size = DVec3::from_array(rows.map(|row| row.truncate().abs().dot(reach)));
            let allowed = ROUNDING
                * (ng.abs().dot(size) + cpu::transform::inverse_error(rows, reach, ng, ROUNDING));
            worst[of[i]] = worst[of[i]].max(shift.dot(ng).abs() / allowed);
        }
    }
    for ((name, _), worst) in transforms.iter().zip(&worst) {
        println!("{name}: {worst:.3} of what is allowed");
        assert!(*worst < 1.0, "{name}: {worst}");
    }
    // Not by being allowed anything: some transform needs a good part of it.
    assert!(worst.iter().any(|&worst| worst > 0.05));
}

/// From a closed surface outwards nothing of it is met again, inwards the other side is.
#[test]
fn new_rays_leave_surfaces_under_awkward_transforms() {
    let mut random = Random(22);
    for (name, transform) in awkward_transforms(&mut random) {
        let scene = shapes::scene(
            vec![shapes::sphere(24, 1.0)],
            vec![shapes::instance(0, transform)],
        );
        let rays: Vec<_> = (0..3000)
            .map(|_| {
                let out = random.direction();
                let from = transform.transform_point3(out * 3.0);
                towards(from, transform.transform_point3(0.9 * random.direction()))
            })
            .collect();
        for (levels, packed) in [
            ("one level", shapes::packed(&scene)),
            ("two levels", shapes::packed(&shapes::two_levels(scene))),
        ] {
            let first = surfaces_gpu(&packed, &rays);
            let (mut next, mut from) = (Vec::new(), Vec::new());
            for answer in first.iter().filter(|answer| answer.instance != NONE) {
                let ng = Vec3::from_array(answer.ng);
                let w = (ng + random.direction() * 0.999).normalize();
                let [above, below] = [answer.above, answer.below].map(Vec3::from_array);
                next.extend([query(above, w), query(below, -w)]);
                from.extend([(answer.triangle, true), (answer.triangle, false)]);
            }
            let second = surfaces_gpu(&packed, &next);
            let (mut again, mut lost) = (0, 0);
            for ((triangle, outwards), to) in from.iter().zip(&second) {
                again +=
                    usize::from(to.instance != NONE && (*outwards || to.triangle == *triangle));
                lost += usize::from(to.instance == NONE && !outwards);
            }
            println!(
                "{name}, {levels}: {} rays, {again} again, {lost} lost",
                next.len()
            );
            assert!(next.len() > 2000, "{name}: {} rays", next.len());
            assert_eq!(again, 0, "{name}, {levels}");
            // A ray that starts within an offset of an edge may start outside. What is 1000 times as long as
            // it is wide, along none of the object's axes, has a determinant of 1e-6 of its terms: there the
            // offset is larger than the shape is wide.
            let hopeless = name == "sheared 1 : 1000";
            assert!(
                hopeless || lost * 1000 <= next.len(),
                "{name}, {levels}: {lost} lost"
            );
        }
    }
}

fn well_inside(transform: Affine3A, p: [f32; 3]) -> bool {
    let object = transform.inverse().transform_point3(Vec3::from_array(p));
    object.x.abs() < 0.99 && object.z.abs() < 0.99
}

/// One square facing +z, its corners at (+-1, +-1, 0), texture coordinates from (0, 0) at its top left.
fn square() -> Mesh {
    let positions = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    shapes::mesh(Primitive {
        positions: positions.map(|(x, y)| Vec3::new(x, y, 0.0)).into(),
        normals: vec![Vec3::Z; 4],
        tangents: Some(vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4]),
        texcoords: vec![
            positions
                .map(|(x, y)| Vec2::new(0.5 + 0.5 * x, 0.5 - 0.5 * y))
                .into(),
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Primitive::default()
    })
}

fn one(mesh: Mesh, change: impl Fn(&mut snell::scene::Material)) -> Scene {
    let mut scene = shapes::scene(vec![mesh], vec![shapes::instance(0, Affine3A::IDENTITY)]);
    change(&mut scene.materials[0]);
    scene
}

fn flat_image(texel: [u8; 4]) -> Image {
    Image {
        name: String::new(),
        width: 1,
        height: 1,
        pixels: Pixels::Rgba8(texel.into()),
    }
}

#[test]
fn a_normal_map_tilts_along_tangent_and_bitangent() {
    // Red is the tangent, +x here; green is the bitangent cross(n, t) w = +y.
    for (texel, scale, expected) in [
        ([255, 128, 255, 255], 1.0, Vec3::new(1.0, 0.004, 1.0)),
        ([128, 255, 255, 255], 1.0, Vec3::new(0.004, 1.0, 1.0)),
        ([128, 255, 255, 255], 0.5, Vec3::new(0.002, 0.5, 1.0)),
        ([0, 128, 255, 255], 0.25, Vec3::new(-0.25, 0.001, 1.0)),
    ] {
        for (mirror, side) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0)] {
            let mut scene = one(square(), |material| {
                material.normal_texture = texture(0, false);
                material.normal_scale = scale;
            });
            scene.images = vec![flat_image(texel).into()];
            // Mirrored in y: the map's green axis is mirrored with the mesh.
            scene.instances[0].world_from_object =
                Affine3A::from_scale(Vec3::new(1.0, mirror, 1.0));
            let packed = shapes::packed(&scene);
            // Looking against the expected normal, so that it is not bent.
            let expected = side * (expected * Vec3::new(1.0, mirror, 1.0)).normalize();
            let from = expected + Vec3::new(0.0, 0.0, 0.4 * side);
            let rays = [towards(3.0 * from, Vec3::ZERO)];
            for answers in [surfaces_gpu(&packed, &rays), surfaces_cpu(&packed, &rays)] {
                assert_eq!(answers[0].front, u32::from(side > 0.0));
                let n = Vec3::from_array(answers[0].n);
                assert!(n.distance(expected) < 2e-3, "{n} is not {expected}");
            }
        }
    }
}

#[test]
fn a_normal_is_bent_until_what_it_mirrors_is_over_the_surface() {
    let mut scene = one(square(), |material| {
        material.normal_texture = texture(0, false)
    });
    // Tilted to +x by 67 degrees.
    scene.images = vec![flat_image([247, 128, 171, 255]).into()];
    let packed = shapes::packed(&scene);
    // At 60 degrees from -x, where the normal faces away, and from straight above, where it mirrors
    // the inside: the half vector of what is seen and the horizon at +x is left.
    for wo in [Vec3::new(-0.866, 0.0, 0.5), Vec3::Z] {
        let expected = (wo + Vec3::X).normalize();
        let rays = [towards(wo, Vec3::ZERO)];
        for answers in [surfaces_gpu(&packed, &rays), surfaces_cpu(&packed, &rays)] {
            let n = Vec3::from_array(answers[0].n);
            assert!(n.distance(expected) < 5e-3, "{n} is not {expected}");
            let mirrored = 2.0 * n.dot(wo) * n - wo;
            assert!((5e-4..2e-3).contains(&mirrored.z), "{mirrored}");
        }
    }
    // From +x at 45 degrees it mirrors what is over the surface, and stays as the texel says.
    let rays = [towards(Vec3::new(0.7, 0.0, 0.7), Vec3::ZERO)];
    for answers in [surfaces_gpu(&packed, &rays), surfaces_cpu(&packed, &rays)] {
        let n = Vec3::from_array(answers[0].n);
        assert!(n.distance(Vec3::new(0.924, 0.0, 0.383)) < 1e-2, "{n}");
    }
}

#[test]
fn back_faces_are_culled_unless_something_shows_them() {
    let glass = |material: &mut snell::scene::Material| {
        material.model = Model::Bsdf {
            bsdf: BsdfModel::Dielectric {
                eta: 1.5,
                distribution: None,
            },
            base_color: Vec4::ONE,
            base_color_texture: None,
        };
    };
    let rays = [1.0, -1.0].map(|side| towards(Vec3::new(0.1, 0.2, side), Vec3::new(0.1, 0.2, 0.0)));
    for (double_sided, transmissive, mirrored, seen) in [
        (false, false, false, [true, false]),
        (true, false, false, [true, true]),
        (false, true, false, [true, true]),
        // The mirror image of a front is a front.
        (false, false, true, [true, false]),
    ] {
        let mut scene = one(square(), |material| {
            if transmissive {
                glass(material);
            }
            material.double_sided = double_sided;
        });
        if mirrored {
            scene.instances[0].world_from_object = Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
        }
        let packed = shapes::packed(&scene);
        for answers in [surfaces_gpu(&packed, &rays), surfaces_cpu(&packed, &rays)] {
            let hit = [0, 1].map(|i| answers[i].instance != NONE);
            assert_eq!(
                hit, seen,
                "double-sided {double_sided}, glass {transmissive}"
            );
            if transmissive {
                assert_eq!(answers[0].bsdf.eta[0], 1.5);
                assert!((answers[1].bsdf.eta[0] - 1.0 / 1.5).abs() < 1e-6);
            }
        }
    }
}

#[test]
fn masks_cut_at_their_cutoff_and_blending_covers_by_alpha() {
    let rays: Vec<_> = (0..4096)
        .map(|_| towards(Vec3::new(0.1, 0.2, 1.0), Vec3::new(0.1, 0.2, 0.0)))
        .collect();
    let share = |mode: AlphaMode, factor: f32, texel: u8, vertex: f32| -> [f64; 2] {
        let mut mesh = square();
        mesh.primitives[0].colors = Some(vec![Vec4::new(1.0, 1.0, 1.0, vertex); 4]);
        let mut scene = one(mesh, |material| {
            material.alpha_mode = mode;
            if let Model::MetallicRoughness(m) = &mut material.model {
                m.base_color.w = factor;
                m.base_color_texture = texture(0, true);
            }
        });
        scene.images = vec![flat_image([255, 255, 255, texel]).into()];
        let packed = shapes::packed(&scene);
        assert_eq!(packed.frame.has_alpha, u32::from(mode != AlphaMode::Opaque));
        [surfaces_gpu(&packed, &rays), surfaces_cpu(&packed, &rays)].map(|answers| {
            let hits = answers.iter().filter(|answer| answer.instance != NONE);
            hits.count() as f64 / rays.len() as f64
        })
    };
    let mask = |cutoff| AlphaMode::Mask { cutoff };
    assert_eq!(share(AlphaMode::Opaque, 0.1, 20, 0.1), [1.0; 2]);
    assert_eq!(share(mask(0.5), 0.6, 255, 1.0), [1.0; 2]);
    assert_eq!(share(mask(0.5), 0.6, 255, 0.8), [0.0; 2]);
    assert_eq!(share(mask(0.5), 1.0, 120, 1.0), [0.0; 2]);
    assert_eq!(share(mask(0.5), 1.0, 130, 1.0), [1.0; 2]);
    for (factor, texel, vertex) in [
        (0.3, 255, 1.0),
        (1.0, 51, 1.0),
        (0.8, 204, 0.5),
        (0.0, 255, 1.0),
    ] {
        let alpha = f64::from(factor) * f64::from(texel) / 255.0 * f64::from(vertex);
        let [gpu, cpu] = share(AlphaMode::Blend, factor, texel, vertex);
        // Four standard deviations of 4096 coin tosses.
        let bound = 4.0 * (alpha * (1.0 - alpha) / 4096.0).sqrt();
        assert!((gpu - alpha).abs() <= bound, "{gpu} is not {alpha}");
        assert!(
            (cpu - gpu).abs() <= 2.0 / 4096.0,
            "the same seeds decide alike"
        );
    }
}

#[test]
fn light_leaves_a_front_and_both_sides_of_what_has_two() {
    let rays = [1.0, -1.0].map(|side| towards(Vec3::new(0.1, 0.2, side), Vec3::new(0.1, 0.2, 0.0)));
    for double_sided in [true, false] {
        let mut scene = one(square(), |material| {
            material.double_sided = double_sided;
            material.emissive = Vec3::new(3.0, 2.0, 1.0);
            material.emissive_texture = texture(0, true);
            // Seen from behind whatever its sides are.
            material.model = Model::Bsdf {
                bsdf: BsdfModel::Dielectric {
                    eta: 1.5,
                    distribution: None,
                },
                base_color: Vec4::ONE,
                base_color_texture: None,
            };
        });
        scene.images = vec![flat_image([255, 0, 255, 255]).into()];
        let packed = shapes::packed(&scene);
        for answers in [surfaces_gpu(&packed, &rays), surfaces_cpu(&packed, &rays)] {
            assert_eq!(answers[0].emitted, [3.0, 0.0, 1.0]);
            let behind = if double_sided {
                [3.0, 0.0, 1.0]
            } else {
                [0.0; 3]
            };
            assert_eq!(answers[1].emitted, behind);
        }
    }
}
