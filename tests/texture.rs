//! Textures: wrapping, filtering, decoding, transform and attribute look-up, on lavapipe and in the
//! reference.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod common;
#[path = "common/picture.rs"]
mod picture;

use bytemuck::Zeroable;
use common::packed::{empty_packed, identity_texture, no_texture};
use common::shapes::{self, Random};
use glam::{Affine3A, DVec2, DVec3, DVec4, Vec2, Vec3};
use snell::cpu::attributes::*;
use snell::cpu::texture::*;
use snell::gpu::device::Gpu;
use snell::gpu::link::Value;
use snell::gpu::upload::{Scene, UploadError};
use snell::pack::{Packed, pack};
use snell::scene::material::IDENTITY_ROWS;
use snell::scene::{self, Filter, Image, Model, Pixels, Wrap};
use snell::shared::*;
use std::sync::Arc;

const COUNT: usize = 100_000;
const LINEAR: u32 = FILTER_LINEAR << 8;

/// A texture of 8-bit texels that are all different.
fn numbered(width: u32, height: u32, filter: u32, wrap: u32) -> (Packed, Texture) {
    let mut packed = empty_packed();
    packed.texels = (0..width * height)
        .map(|i| u32::from_le_bytes([i as u8, (7 * i) as u8, (31 * i) as u8, 255 - i as u8]))
        .collect();
    let mut texture = identity_texture([width, height], FORMAT_RGBA8_UNORM | filter);
    texture.wrap = wrap | wrap << 2;
    (packed, texture)
}

/// Red of a numbered texture in texel numbers.
fn number_at(packed: &Packed, texture: &Texture, u: f64, v: f64) -> f64 {
    texture_sample(packed, texture, DVec2::new(u, v)).x * 255.0
}

#[test]
fn texel_centres_give_texels() {
    // Sides that are no powers of two, one texel, and a line of texels.
    for (width, height) in [(5, 3), (1, 1), (7, 1), (1, 9)] {
        for filter in [FILTER_NEAREST << 8, LINEAR] {
            for wrap in [WRAP_REPEAT, WRAP_CLAMP, WRAP_MIRROR] {
                let (packed, texture) = numbered(width, height, filter, wrap);
                for y in 0..height {
                    for x in 0..width {
                        // Row 0 is on top, where v = 0 (glTF 2.0 section 3.8.3).
                        let u = (f64::from(x) + 0.5) / f64::from(width);
                        let v = (f64::from(y) + 0.5) / f64::from(height);
                        let expected = f64::from(y * width + x);
                        let got = number_at(&packed, &texture, u, v);
                        assert!(
                            (got - expected).abs() < 1e-9,
                            "{x} {y} of {width} x {height}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn wrapping_continues_the_image() {
    // One row of 4 texels, looked up one texel after another from -8 to 12.
    let row = |wrap: u32, filter: u32| -> Vec<f64> {
        let (packed, texture) = numbered(4, 1, filter, wrap);
        (-8..12)
            .map(|i| number_at(&packed, &texture, (f64::from(i) + 0.5) / 4.0, 0.5).round())
            .collect()
    };
    for filter in [FILTER_NEAREST << 8, LINEAR] {
        let cycle = |cycle: &[u32]| -> Vec<f64> {
            (0..20).map(|i| f64::from(cycle[i % cycle.len()])).collect()
        };
        assert_eq!(row(WRAP_REPEAT, filter), cycle(&[0, 1, 2, 3]));
        assert_eq!(row(WRAP_MIRROR, filter), cycle(&[0, 1, 2, 3, 3, 2, 1, 0]));
        let clamped: Vec<f64> = (-8..12).map(|i| f64::from(i.clamp(0, 3))).collect();
        assert_eq!(row(WRAP_CLAMP, filter), clamped);
    }
    // The two directions wrap each in its own way.
    let (packed, mut texture) = numbered(4, 4, FILTER_NEAREST << 8, WRAP_REPEAT);
    texture.wrap = WRAP_REPEAT | WRAP_CLAMP << 2;
    assert_eq!(
        number_at(&packed, &texture, 1.4, 1.4).round(),
        4.0 * 3.0 + 1.0
    );
    texture.wrap = WRAP_CLAMP | WRAP_REPEAT << 2;
    assert_eq!(number_at(&packed, &texture, 1.4, 1.4).round(), 4.0 + 3.0);
}

#[test]
fn the_filter_blends_neighbours_over_seams() {
    let seam = |wrap: u32, u: f64| {
        let (packed, texture) = numbered(5, 1, LINEAR, wrap);
        number_at(&packed, &texture, u, 0.5)
    };
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a}, not {b}");
    for wrap in [WRAP_REPEAT, WRAP_CLAMP, WRAP_MIRROR] {
        near(seam(wrap, 0.4), 1.5); // between texels 1 and 2
        near(seam(wrap, 0.45), 1.75);
    }
    near(seam(WRAP_REPEAT, 0.0), 2.0); // half of texel 4, half of texel 0
    near(seam(WRAP_REPEAT, 1.0), 2.0);
    near(seam(WRAP_REPEAT, 0.05), 0.25 * 4.0);
    near(seam(WRAP_REPEAT, -0.05), 0.75 * 4.0);
    near(seam(WRAP_CLAMP, 0.0), 0.0);
    near(seam(WRAP_CLAMP, 1.0), 4.0);
    near(seam(WRAP_MIRROR, 1.0), 4.0); // texel 4 beside its mirror
    near(seam(WRAP_MIRROR, 2.0), 0.0);
    near(seam(WRAP_MIRROR, 1.2), 3.5);
    // In both directions at once: the mean of four.
    let (packed, texture) = numbered(4, 4, LINEAR, WRAP_REPEAT);
    near(
        number_at(&packed, &texture, 0.5, 0.5),
        (5.0 + 6.0 + 9.0 + 10.0) / 4.0,
    );
    // The borders of nearest texels: a texel owns its left and upper edge.
    let (packed, texture) = numbered(4, 1, FILTER_NEAREST << 8, WRAP_REPEAT);
    near(number_at(&packed, &texture, 0.25, 0.5), 1.0);
    near(number_at(&packed, &texture, 0.25 - 1e-9, 0.5), 0.0);
}

#[test]
fn the_transform_comes_before_wrapping() {
    let (packed, mut texture) = numbered(4, 4, FILTER_NEAREST << 8, WRAP_REPEAT);
    // Swaps the axes, doubles, and moves by a quarter.
    texture.row_u = [0.0, 2.0, 0.25];
    texture.row_v = [1.0, 0.0, -0.5];
    for (u, v) in [(0.1, 0.2), (0.9, 0.7), (-0.3, 1.6)] {
        let moved = DVec2::new(2.0 * v + 0.25, u - 0.5).rem_euclid(DVec2::ONE);
        let expected = (4.0 * moved.y).floor() * 4.0 + (4.0 * moved.x).floor();
        assert_eq!(number_at(&packed, &texture, u, v).round(), expected);
    }
}

#[test]
fn no_texture_is_white() {
    let got = texture_sample(&empty_packed(), &no_texture(), DVec2::new(0.3, 7.0));
    assert_eq!(got, DVec4::ONE);
}

/// A query of the kernel: (u, v).
fn texture_samples_gpu(packed: &Packed, texture: &Texture, uvs: &[[f32; 2]]) -> Vec<[f32; 4]> {
    let root = "
import package::shared::{Texture};
import package::texture::{texture_sample};
@group(3) @binding(0) var<storage, read> textures: array<Texture>;
@group(3) @binding(1) var<storage, read> uvs: array<vec2<f32>>;
@group(3) @binding(2) var<storage, read_write> answers: array<vec4<f32>>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&uvs) { return; }
    answers[id.x] = texture_sample(textures[0], uvs[id.x]);
}";
    let inputs: [&[u8]; 2] = [bytemuck::bytes_of(texture), bytemuck::cast_slice(uvs)];
    let answers = common::run_scene(root, packed, &inputs, uvs.len() * 16, uvs.len() as u32);
    bytemuck::pod_collect_to_vec(&answers)
}

#[test]
fn srgb_is_exact_for_every_byte() {
    let mut packed = empty_packed();
    packed.texels = (0..=255)
        .map(|i: u8| u32::from_le_bytes([i, 255 - i, i, i]))
        .collect();
    let texture = identity_texture([256, 1], FORMAT_RGBA8_SRGB);
    let uvs: Vec<[f32; 2]> = (0..256).map(|i| [(i as f32 + 0.5) / 256.0, 0.5]).collect();
    // IEC 61966-2-1.
    let decode = |byte: u32| {
        let c = f64::from(byte) / 255.0;
        if c <= 0.04045 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        }
    };
    let (mut worst, mut above) = (0.0_f64, -1.0);
    for (i, answer) in (0..).zip(texture_samples_gpu(&packed, &texture, &uvs)) {
        let expected = DVec4::new(decode(i), decode(255 - i), decode(i), f64::from(i) / 255.0);
        let cpu = texture_sample(
            &packed,
            &texture,
            DVec2::new((f64::from(i) + 0.5) / 256.0, 0.5),
        );
        assert!(
            (cpu - expected).abs().max_element() < 1e-15,
            "byte {i}: {cpu}"
        );
        let gpu = DVec4::from_array(answer.map(f64::from));
        let error = ((gpu - expected) / expected.max(DVec4::splat(1e-9))).abs();
        worst = worst.max(error.max_element());
        assert!(answer[0] > above, "not monotone at byte {i}");
        above = answer[0];
    }
    println!("largest relative error: {worst:e}");
    assert!(worst < 1e-6, "relative error {worst:e}");
    assert_eq!(decode(255), 1.0);
}

#[test]
fn colours_are_decoded_before_they_are_blended() {
    let mut packed = empty_packed();
    packed.texels = vec![0x0000_0000, 0xffff_ffff];
    let texture = identity_texture([2, 1], FORMAT_RGBA8_SRGB | LINEAR);
    for answer in [
        texture_sample(&packed, &texture, DVec2::splat(0.5)),
        DVec4::from_array(texture_samples_gpu(&packed, &texture, &[[0.5, 0.5]])[0].map(f64::from)),
    ] {
        // Half of linear white, not the decoded middle grey 0.214.
        assert!((answer - 0.5).abs().max_element() < 1e-6, "{answer}");
    }
}

#[test]
fn sixteen_bits_keep_their_digits() {
    let mut packed = empty_packed();
    let values = [[0, 1, 65535, 32768], [12345, 54321, 255, 256]];
    packed.texels = values
        .iter()
        .flat_map(|&[r, g, b, a]: &[u32; 4]| [r | g << 16, b | a << 16])
        .collect();
    let texture = identity_texture([2, 1], FORMAT_RGBA16_UNORM);
    let uvs = [[0.25, 0.5], [0.75, 0.5]];
    let gpu = texture_samples_gpu(&packed, &texture, &uvs);
    for ((uv, gpu), value) in uvs.iter().zip(gpu).zip(values) {
        let expected = DVec4::from_array(value.map(f64::from)) / 65535.0;
        let cpu = texture_sample(&packed, &texture, DVec2::new(uv[0].into(), uv[1].into()));
        assert_eq!(cpu, expected);
        assert!(
            (DVec4::from_array(gpu.map(f64::from)) - expected)
                .abs()
                .max_element()
                < 1e-7
        );
    }
}

#[test]
fn samples_agree_with_float64() {
    let mut uniform = Random(21);
    for case in 0..12 {
        let format = [FORMAT_RGBA8_UNORM, FORMAT_RGBA8_SRGB, FORMAT_RGBA16_UNORM][case % 3];
        let filter = if case < 6 {
            LINEAR
        } else {
            FILTER_NEAREST << 8
        };
        let size = [
            1 + uniform.bits() as u32 % 40,
            1 + uniform.bits() as u32 % 40,
        ];
        let mut packed = empty_packed();
        // Not at the start of the array, so that a forgotten offset shows.
        packed.texels = (0..2 * size[0] * size[1] + 5)
            .map(|_| uniform.bits() as u32)
            .collect();
        let mut texture = identity_texture(size, format | filter);
        texture.texels = 5;
        texture.wrap = (case as u32 % 3) | (case as u32 / 3 % 3) << 2;
        texture.row_u = [
            uniform.range(-2.0, 2.0),
            uniform.range(-2.0, 2.0),
            uniform.unit(),
        ];
        texture.row_v = [
            uniform.range(-2.0, 2.0),
            uniform.range(-2.0, 2.0),
            uniform.unit(),
        ];
        let count = COUNT / 12;
        let uvs: Vec<[f32; 2]> = (0..count)
            .map(|_| [uniform.range(-3.0, 3.0), uniform.range(-3.0, 3.0)])
            .collect();
        let mut apart = 0;
        for (uv, answer) in uvs.iter().zip(texture_samples_gpu(&packed, &texture, &uvs)) {
            let uv = DVec2::new(uv[0].into(), uv[1].into());
            let expected = texture_sample(&packed, &texture, uv);
            let error = (DVec4::from_array(answer.map(f64::from)) - expected)
                .abs()
                .max_element();
            // A coordinate near 12 is rounded to 1e-6, which is 4e-5 of a texel in 40.
            apart += usize::from(error > 1e-4);
        }
        // A nearest texel's border is met by chance; a blend has no borders.
        let allowed = if filter == LINEAR { 0 } else { count / 500 };
        assert!(
            apart <= allowed,
            "case {case}: {apart} of {count} samples differ"
        );
    }
}

#[test]
fn wrapped_coordinates_stay_in_the_image() {
    // Whatever the coordinate, even one that float32 cannot wrap any more.
    for wrap in [WRAP_REPEAT, WRAP_CLAMP, WRAP_MIRROR] {
        let (packed, texture) = numbered(3, 2, LINEAR, wrap);
        let far = [
            -1e30,
            -1e9,
            -1.0,
            -1e-30,
            -1e-8,
            0.0,
            1.0,
            2.0,
            1e9,
            1e30,
            f32::MAX,
        ];
        let uvs: Vec<[f32; 2]> = far.iter().flat_map(|&u| far.map(|v| [u, v])).collect();
        for answer in texture_samples_gpu(&packed, &texture, &uvs) {
            // Every texel's alpha is at least 250.
            assert!((250.0 / 255.0..=1.0).contains(&answer[3]), "{answer:?}");
        }
        for [u, v] in uvs {
            let alpha = texture_sample(&packed, &texture, DVec2::new(u.into(), v.into())).w;
            assert!((250.0 / 255.0 - 1e-9..=1.0).contains(&alpha));
        }
    }
}

/// Asks for words of the texels by number.
const WORDS: &str = "
import package::texture::{texel_word};
@group(3) @binding(0) var<storage, read> indices: array<u32>;
@group(3) @binding(1) var<storage, read_write> answers: array<u32>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&indices) { return; }
    answers[id.x] = texel_word(indices[id.x]);
}";

fn texel_words_gpu(gpu: &Gpu, packed: &Packed, indices: &[u32]) -> Vec<u32> {
    let inputs: [&[u8]; 1] = [bytemuck::cast_slice(indices)];
    let count = indices.len();
    let answers = common::run_on(gpu, WORDS, Some(packed), &inputs, 4 * count, count as u32);
    bytemuck::pod_collect_to_vec(&answers)
}

/// Pages of 64 x 64 words, of one layer or of four.
#[test]
fn texels_that_no_binding_holds_are_paged() {
    let mut gpu = common::gpu();
    gpu.arrays_in_textures = false;
    let buffers = gpu.limits.max_storage_buffer_binding_size;
    gpu.limits.max_texture_dimension_2d = 64;
    for layers in [1, 4] {
        gpu.limits.max_texture_array_layers = layers;
        let page = 64 * 64 * layers as usize;
        // From a part of the first row to all four pages.
        for count in [
            2000,
            page - 1,
            page,
            page + 63,
            2 * page + 64,
            3 * page + 1,
            4 * page,
        ] {
            let mut packed = empty_packed();
            packed.texels = (0..count as u32)
                .map(|i| i.wrapping_mul(0x9E37_79B9))
                .collect();
            let indices: Vec<u32> = (0..count as u32).collect();
            gpu.limits.max_storage_buffer_binding_size = 7999;
            assert_eq!(
                texel_words_gpu(&gpu, &packed, &indices),
                packed.texels,
                "{count}"
            );
            let scene = Scene::upload(&gpu, &packed).unwrap();
            let pages = count.div_ceil(page) as u32;
            assert_eq!(scene.constants()[0], ("TEXEL_PAGES", Value::Uint(pages)));
            // What fits stays in its buffer.
            gpu.limits.max_storage_buffer_binding_size = buffers;
            assert!(Scene::upload(&gpu, &packed).unwrap().constants().is_empty());
            assert_eq!(
                texel_words_gpu(&gpu, &packed, &indices),
                packed.texels,
                "{count}"
            );
        }
        let mut packed = empty_packed();
        packed.texels = vec![0; 4 * page + 1];
        gpu.limits.max_storage_buffer_binding_size = 7999;
        match Scene::upload(&gpu, &packed).map(|_| ()) {
            Err(UploadError::TooLarge {
                what: "texels",
                limit,
                ..
            }) => {
                assert_eq!(limit, 16 * page as u64);
            }
            other => panic!("{other:?}"),
        }
    }
}

/// More than the 128 MiB that WebGPU grants a binding by default, and lavapipe any.
#[test]
fn texels_beyond_128_mib_are_read() {
    let mut gpu = common::gpu();
    let count = 160 << 18;
    let bytes = 4 * u64::from(count);
    assert!(bytes > gpu.limits.max_storage_buffer_binding_size);
    let mut packed = empty_packed();
    packed.texels = (0..count)
        .map(|i: u32| i.wrapping_mul(0x9E37_79B9))
        .collect();
    let indices: Vec<u32> = (0..COUNT as u32)
        .map(|i| i * 419)
        .chain([count - 1])
        .collect();
    assert!(indices.iter().all(|&index| index < count));
    let expected: Vec<u32> = indices.iter().map(|&i| packed.texels[i as usize]).collect();
    for textures in [false, true] {
        gpu.arrays_in_textures = textures;
        assert_eq!(texel_words_gpu(&gpu, &packed, &indices), expected);
    }
}

/// A textured quad gives the same film whether its texels are paged or not.
#[test]
fn a_paged_picture_is_the_same() {
    let image = |seed| {
        let mut uniform = Random(seed);
        let pixels = (0..4 * 1024 * 1280).map(|_| uniform.bits() as u8).collect();
        Arc::new(Image {
            name: String::new(),
            width: 1024,
            height: 1280,
            pixels: Pixels::Rgba8(pixels),
        })
    };
    let corners = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y].map(|at| (2.0 * at - 1.0).extend(-1.0));
    let mut quad = shapes::flat(&[
        [corners[0], corners[1], corners[2]],
        [corners[0], corners[2], corners[3]],
    ]);
    let uv = |at: &Vec3| (at.truncate() + 1.0) / 2.0;
    let primitive = &mut quad.primitives[0];
    primitive.texcoords = vec![primitive.positions.iter().map(uv).collect()];
    let mut scene = shapes::scene(vec![quad], vec![shapes::instance(0, Affine3A::IDENTITY)]);
    scene.images = vec![image(1), image(2)];
    let texture = |image, srgb| scene::Texture {
        image,
        srgb,
        wrap_s: Wrap::Repeat,
        wrap_t: Wrap::Mirror,
        filter: Filter::Linear,
        texcoord: 0,
        rows: IDENTITY_ROWS,
    };
    scene.materials[0].emissive = Vec3::ONE;
    scene.materials[0].emissive_texture = Some(texture(0, true));
    if let Model::MetallicRoughness(m) = &mut scene.materials[0].model {
        m.base_color_texture = Some(texture(1, true));
    }
    let mut view = shapes::view();
    view.film_size = [32, 32];
    let packed = pack(&scene, &view).unwrap();
    let settings = picture::whole(&packed, 2);
    let mut gpu = common::gpu();
    gpu.arrays_in_textures = false;
    let plain = picture::on_gpu(&mut gpu, &packed, &settings);
    // Less than the texels, and more than all else, the renderer's own buffers included.
    gpu.limits.max_storage_buffer_binding_size = 8 << 20;
    assert!(!Scene::upload(&gpu, &packed).unwrap().constants().is_empty());
    let paged = picture::on_gpu(&mut gpu, &packed, &settings);
    assert!(!plain.is_black());
    for (a, b) in plain.pixels.iter().zip(&paged.pixels) {
        assert_eq!(format!("{a:?}"), format!("{b:?}"));
    }
}

#[test]
fn attributes_stand_where_the_layout_says() {
    let mut uniform = Random(22);
    for layout_bits in 0..16 {
        let [tangent, color, color_unorm, uv_unorm] = [
            LAYOUT_TANGENT,
            LAYOUT_COLOR,
            LAYOUT_COLOR_UNORM,
            LAYOUT_TEXCOORD_UNORM,
        ]
        .map(|flag| layout_bits & flag != 0);
        if color_unorm && !color {
            continue;
        }
        for sets in 0..3 {
            let color_at = 1 + u32::from(tangent);
            let color_words = u32::from(color) * if color_unorm { 1 } else { 4 };
            let uv_words = if uv_unorm { 1 } else { 2 };
            let words = color_at + color_words + uv_words * sets;
            let mut packed = empty_packed();
            // Numbers in float32; where words are read as bits, any.
            let mut word = |offset: u32| {
                let in_color = (color_at..color_at + color_words).contains(&offset);
                match (offset < color_at, in_color) {
                    (false, true) if !color_unorm => uniform.unit().to_bits(),
                    (false, false) if !uv_unorm => uniform.unit().to_bits(),
                    _ => uniform.bits() as u32,
                }
            };
            packed.vertices = (0..7)
                .chain((0..3 * words).map(|i| i % words))
                .map(&mut word)
                .collect();
            let triangle = Triangle {
                vertex0: 7,
                vertex1: 7 + words,
                vertex2: 7 + 2 * words,
                vertex_layout: layout_bits | sets << LAYOUT_TEXCOORDS_SHIFT,
                ..Triangle::zeroed()
            };
            let at = DVec2::new(0.25, 0.625);
            let word =
                |corner: u32, offset: u32| packed.vertices[(7 + corner * words + offset) as usize];
            let near = |a: DVec4, corner: &dyn Fn(u32) -> DVec4| {
                let blend = 0.125 * corner(0) + 0.25 * corner(1) + 0.625 * corner(2);
                assert!(
                    (a - blend).abs().max_element() < 1e-12,
                    "{layout_bits} {sets}: {a} {blend}"
                );
            };
            let floats = |first: u32, count: u32| {
                move |corner: u32| {
                    let mut value = DVec4::ZERO;
                    (0..count).for_each(|i| {
                        value[i as usize] = f32::from_bits(word(corner, first + i)).into()
                    });
                    value
                }
            };
            near(
                attribute_normal(&packed, &triangle, at).extend(0.0),
                &|corner| unpack_normal(word(corner, 0)).extend(0.0),
            );
            let found = attribute_tangent(&packed, &triangle, at);
            if tangent {
                near(found.with_w(0.0), &|corner| {
                    unpack_tangent(word(corner, 1)).with_w(0.0)
                });
                assert_eq!(found.w, unpack_tangent(word(0, 1)).w);
            } else {
                assert_eq!(found, DVec4::ZERO);
            }
            let found = attribute_color(&packed, &triangle, at);
            match (color, color_unorm) {
                (false, _) => assert_eq!(found, DVec4::ONE),
                (true, true) => near(found, &|corner| {
                    DVec4::from_array(word(corner, color_at).to_le_bytes().map(f64::from)) / 255.0
                }),
                (true, false) => near(found, &floats(color_at, 4)),
            }
            for set in 0..sets {
                let uv = attribute_texcoord(&packed, &triangle, at, set);
                let first = words - uv_words * (sets - set);
                let steps = |corner: u32| {
                    let word = word(corner, first);
                    DVec4::new(f64::from(word & 0xffff), f64::from(word >> 16), 0.0, 0.0) / 65535.0
                };
                let uv = DVec4::new(uv.x, uv.y, 0.0, 0.0);
                if uv_unorm {
                    near(uv, &steps)
                } else {
                    near(uv, &floats(first, 2))
                }
            }
            assert_eq!(
                attribute_texcoord(&packed, &triangle, at, sets),
                DVec2::ZERO
            );
            attributes_agree_with_float64(&packed, &triangle, at, sets);
        }
    }
}

fn attributes_agree_with_float64(packed: &Packed, triangle: &Triangle, at: DVec2, sets: u32) {
    let root = "
import package::shared::{Triangle};
import package::attributes::{attribute_normal, attribute_tangent, attribute_color, attribute_texcoord};
@group(3) @binding(0) var<storage, read> query: array<Triangle>;
@group(3) @binding(1) var<storage, read> barycentrics: array<vec2<f32>>;
@group(3) @binding(2) var<storage, read_write> answers: array<vec4<f32>>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x > 0u { return; }
    let at = barycentrics[0];
    answers[0] = vec4(attribute_normal(query[0], at), 0.0);
    answers[1] = attribute_tangent(query[0], at);
    answers[2] = attribute_color(query[0], at);
    answers[3] = vec4(attribute_texcoord(query[0], at, 0u), attribute_texcoord(query[0], at, 1u));
}";
    let barycentrics = at.as_vec2();
    let inputs: [&[u8]; 2] = [
        bytemuck::bytes_of(triangle),
        bytemuck::bytes_of(&barycentrics),
    ];
    let answers = common::run_scene(root, packed, &inputs, 64, 1);
    let answers: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&answers);
    let uv = |set| attribute_texcoord(packed, triangle, at, set);
    let expected = [
        attribute_normal(packed, triangle, at).extend(0.0),
        attribute_tangent(packed, triangle, at),
        attribute_color(packed, triangle, at),
        DVec4::new(uv(0).x, uv(0).y, uv(1).x, uv(1).y),
    ];
    for (answer, expected) in answers.iter().zip(expected) {
        let error = DVec4::from_array(answer.map(f64::from)) - expected;
        assert!(
            error.abs().max_element() < 1e-6,
            "{sets} sets: {answer:?} {expected}"
        );
    }
}

#[test]
fn the_fifth_root_is_one() {
    for i in 0..=100 {
        let x = DVec3::splat(0.09 + 0.91 * f64::from(i) / 100.0);
        assert!((fifth_root(x).powf(5.0) - x).abs().max_element() < 1e-15);
    }
}
