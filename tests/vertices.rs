//! Vertex attributes in words: what packing loses, what it must not lose, and what it takes.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod common;

use common::packed::empty_packed;
use common::shapes::{self, Random};
use glam::{Affine3A, DVec3, DVec4, Vec2, Vec3, Vec4};
use snell::cpu::attributes::{unpack_normal, unpack_tangent};
use snell::pack::Packed;
use snell::pack::vertex::{pack_normal, pack_tangent};
use snell::scene::{Filter, Image, Mesh, Model, Pixels, Scene, Texture, Wrap};
use snell::shared::*;
use std::sync::Arc;

/// Between unit vectors, radians; the chord keeps small angles' digits.
fn angle(a: DVec3, b: DVec3) -> f64 {
    2.0 * (0.5 * a.distance(b)).asin()
}

/// The worst that the map of `steps` can do, radians: where it stretches most, at the middle of a face, its
/// points are a lattice of equilateral triangles of side sqrt(2) / steps on the plane |x| + |y| + |z| = 1,
/// 1 / sqrt(3) from the centre; the middle of one of these is sqrt(2 / 3) / steps from its corners.
fn theory(steps: u32) -> f64 {
    2.0_f64.sqrt() / f64::from(steps)
}

#[test]
fn directions_come_back_as_near_as_the_map_is_fine() {
    let mut random = Random(91);
    let mut worst = [0.0_f64; 2];
    // Over the sphere, and close to the corners of the map, to its folds and to the middles of its faces.
    let directions = (0..400_000).map(|i| match i % 4 {
        0 => random.direction(),
        1 => (Vec3::X + 1e-3 * random.cube()).normalize(),
        2 => (random.direction() * Vec3::new(1.0, 1.0, 1e-4)).normalize(),
        _ => (Vec3::new(1.0, -1.0, -1.0) + 1e-3 * random.cube()).normalize(),
    });
    for direction in directions {
        let normal = unpack_normal(pack_normal(direction));
        let tangent = unpack_tangent(pack_tangent(direction.extend(-1.0)));
        assert_eq!(tangent.w, -1.0);
        for (worst, found) in worst.iter_mut().zip([normal, tangent.truncate()]) {
            assert!((found.length() - 1.0).abs() < 1e-15);
            *worst = worst.max(angle(found, direction.as_dvec3().normalize()));
        }
    }
    for (worst, steps) in worst.into_iter().zip([NORMAL_STEPS, TANGENT_STEPS]) {
        let limit = theory(steps);
        assert!(
            (0.9..1.001).contains(&(worst / limit)),
            "{worst:e} {limit:e}"
        );
    }
}

#[test]
fn axes_are_exact_and_nothing_stays_nothing() {
    for axis in [Vec3::X, Vec3::Y, Vec3::Z]
        .into_iter()
        .flat_map(|a| [a, -a])
    {
        assert_eq!(unpack_normal(pack_normal(axis)), axis.as_dvec3());
        for w in [-1.0, 0.0, 1.0] {
            let tangent = axis.extend(w);
            assert_eq!(unpack_tangent(pack_tangent(tangent)), tangent.as_dvec4());
        }
    }
    assert_eq!(unpack_normal(pack_normal(Vec3::ZERO)), DVec3::ZERO);
    assert_eq!(unpack_tangent(pack_tangent(Vec4::ZERO)), DVec4::ZERO);
}

#[test]
fn words_are_read_alike_on_both_sides() {
    let mut random = Random(92);
    let axes = [Vec3::X, Vec3::Y, Vec3::Z]
        .into_iter()
        .flat_map(|a| [a, -a]);
    let directions = axes
        .chain([Vec3::ZERO])
        .chain((0..8192 - 7).map(|_| random.direction()));
    let directions: Vec<Vec3> = directions.collect();
    let words: Vec<u32> = directions
        .iter()
        .flat_map(|&v| [pack_normal(v), pack_tangent(v.extend(v.x.signum()))])
        .collect();
    let root = "
import package::attributes::{unpack_normal, unpack_tangent};
@group(3) @binding(0) var<storage, read> words: array<u32>;
@group(3) @binding(1) var<storage, read_write> answers: array<vec4<f32>>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if 2u * id.x >= arrayLength(&words) { return; }
    answers[2u * id.x] = vec4(unpack_normal(words[2u * id.x]), 0.0);
    answers[2u * id.x + 1u] = unpack_tangent(words[2u * id.x + 1u]);
}";
    let inputs: [&[u8]; 1] = [bytemuck::cast_slice(&words)];
    let count = directions.len();
    let answers = common::run_scene(root, &empty_packed(), &inputs, 32 * count, count as u32);
    let answers: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&answers);
    for (i, (answer, word)) in answers.iter().zip(&words).enumerate() {
        let answer = DVec4::from_array(answer.map(f64::from));
        let expected = match i % 2 {
            0 => unpack_normal(*word).extend(0.0),
            _ => unpack_tangent(*word),
        };
        // Of the first, which lie along axes or are nothing, no digit is lost.
        let limit = if i / 2 < 7 { 0.0 } else { 1.5e-7 };
        let error = (answer - expected).abs().max_element();
        assert!(error <= limit, "{word:#x}: {answer} {expected}");
    }
}

/// A scene of one mesh whose material has a texture of this width.
fn textured(mesh: Mesh, width: u32, rows: [Vec3; 2]) -> Scene {
    let mut scene = shapes::scene(vec![mesh], vec![shapes::instance(0, Affine3A::IDENTITY)]);
    scene.images = vec![Arc::new(Image {
        name: String::new(),
        width,
        height: 1,
        pixels: Pixels::Rgba8(vec![200; 4 * width as usize]),
    })];
    let Model::MetallicRoughness(model) = &mut scene.materials[0].model else {
        panic!("not metallic-roughness")
    };
    model.base_color_texture = Some(Texture {
        image: 0,
        srgb: true,
        wrap_s: Wrap::Repeat,
        wrap_t: Wrap::Repeat,
        filter: Filter::Linear,
        texcoord: 0,
        rows,
    });
    scene
}

/// A sphere with texture coordinates in the square from `from` to `to`.
fn mapped(n: u32, from: f32, to: f32) -> Mesh {
    let mut mesh = shapes::sphere(n, 1.0);
    let primitive = &mut mesh.primitives[0];
    let uv = |n: &Vec3| from + (to - from) * (0.5 + 0.5 * Vec2::new(n.x, n.y));
    primitive.texcoords = vec![primitive.normals.iter().map(uv).collect()];
    mesh
}

const PLAIN: [Vec3; 2] = [Vec3::X, Vec3::Y];

#[test]
fn texture_coordinates_take_a_word_where_steps_are_fine_enough() {
    let words = |mesh: &Mesh, width: u32, rows| {
        let packed = shapes::packed(&textured(mesh.clone(), width, rows));
        let vertices = mesh.primitives[0].positions.len();
        assert_eq!(packed.vertices.len() % vertices, 0);
        packed.vertices.len() / vertices - 1
    };
    let inside = mapped(6, 0.0, 1.0);
    assert_eq!(words(&inside, 4096, PLAIN), 1);
    assert_eq!(words(&inside, 4097, PLAIN), 2);
    // KHR_texture_transform: what is scaled up loses as much more.
    let scaled = |scale: f32| [scale * Vec3::X, Vec3::Y];
    assert_eq!(words(&inside, 1024, scaled(4.0)), 1);
    assert_eq!(words(&inside, 1024, scaled(-5.0)), 2);
    // A file's rounding is no reason; being elsewhere is.
    assert_eq!(words(&mapped(6, -1e-7, 1.0 + 2e-7), 64, PLAIN), 1);
    assert_eq!(words(&mapped(6, 0.0, 1.00002), 64, PLAIN), 2);
    assert_eq!(words(&mapped(6, -0.00002, 1.0), 64, PLAIN), 2);
    assert_eq!(words(&mapped(6, 0.0, f32::NAN), 64, PLAIN), 2);
}

#[test]
fn texture_coordinates_are_within_half_a_step_or_exact() {
    use snell::cpu::attributes::attribute_texcoord;
    for (to, limit) in [(1.0, 0.5 / 65535.0), (3.0, 0.0)] {
        let mesh = mapped(40, 0.0, to);
        let primitive = mesh.primitives[0].clone();
        let packed = shapes::packed(&textured(mesh, 64, PLAIN));
        let words = packed.vertices.len() / primitive.positions.len();
        let mut worst = 0.0_f64;
        for triangle in &packed.triangles {
            let expected = primitive.texcoords[0][triangle.vertex0 as usize / words].as_dvec2();
            let uv = attribute_texcoord(&packed, triangle, Default::default(), 0);
            worst = worst.max((uv - expected).abs().max_element());
        }
        assert!(
            worst <= limit && worst >= 0.9 * limit,
            "{worst:e} {limit:e}"
        );
    }
}

#[test]
fn colours_of_bytes_take_a_word_and_others_keep_their_digits() {
    use snell::cpu::attributes::attribute_color;
    let mut random = Random(93);
    for (steps, words) in [(255.0, 2), (65535.0, 5)] {
        let mut mesh = shapes::soup(&mut random, 100, 0.1);
        let mut channel = || (random.unit() * steps).round() / steps;
        let colors = (0..300).map(|_| Vec4::from_array([(); 4].map(|()| channel())));
        let colors: Vec<Vec4> = colors.collect();
        mesh.primitives[0].colors = Some(colors.clone());
        let scene = shapes::scene(vec![mesh], vec![shapes::instance(0, Affine3A::IDENTITY)]);
        let packed = shapes::packed(&scene);
        assert_eq!(packed.vertices.len(), 300 * words);
        for triangle in &packed.triangles {
            let color = attribute_color(&packed, triangle, Default::default());
            assert_eq!(color.as_vec4(), colors[triangle.vertex0 as usize / words]);
        }
    }
}

/// Bytes of nodes, triangles and vertices for each triangle.
fn bytes_per_triangle(packed: &Packed) -> f64 {
    let arrays = packed.arrays();
    let of = |name| {
        arrays
            .iter()
            .find(|(array, _)| *array == name)
            .unwrap()
            .1
            .len()
    };
    let bytes = of("nodes") + of("triangles") + of("vertices");
    bytes as f64 / packed.triangles.len() as f64
}

#[test]
fn a_triangle_takes_less_than_120_bytes() {
    let mut random = Random(94);
    let mut apart = shapes::soup(&mut random, 20_000, 0.02);
    let vertices = apart.primitives[0].positions.len();
    let uv = |_| Vec2::new(random.unit(), random.unit());
    apart.primitives[0].texcoords = vec![(0..vertices).map(uv).collect()];
    let with = |mesh: &Mesh, tangents: bool, colors: bool, scale: f32| {
        let mut mesh = mesh.clone();
        let primitive = &mut mesh.primitives[0];
        let count = primitive.positions.len();
        primitive.tangents = tangents.then(|| vec![Vec4::new(1.0, 0.0, 0.0, -1.0); count]);
        primitive.colors = colors.then(|| vec![Vec4::splat(0.2); count]);
        let mut scene = textured(mesh, 64, [scale * Vec3::X, Vec3::Y]);
        if tangents {
            let texture = base_color_texture(&scene);
            scene.materials[0].normal_texture = Some(texture);
        }
        bytes_per_triangle(&shapes::packed(&scene))
    };
    let shared = mapped(100, 0.0, 1.0);
    let cases = [
        (with(&shared, false, false, 1.0), 72.0..78.0),
        (with(&shared, true, true, 1000.0), 78.0..90.0),
        (with(&apart, false, false, 1.0), 94.0..98.0),
        (with(&apart, false, false, 1000.0), 106.0..110.0),
        (with(&apart, true, false, 1.0), 106.0..110.0),
        (with(&apart, false, true, 1.0), 106.0..110.0),
    ];
    for (bytes, range) in cases {
        assert!(bytes < 120.0 && range.contains(&bytes), "{bytes} {range:?}");
    }
}

/// The base colour's texture of a scene that `textured` made.
fn base_color_texture(scene: &Scene) -> Texture {
    scene.materials[0].textures().next().unwrap().clone()
}
