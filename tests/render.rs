//! The wavefront as a whole: how the work is split changes no byte; faults end in sentences.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod common;
#[path = "common/picture.rs"]
mod picture;

use common::shapes;
use glam::{Affine3A, Vec3, Vec4};
use picture::*;
use snell::film::Film;
use snell::gpu::device::Gpu;
use snell::gpu::fetch::ROW_BITS;
use snell::gpu::render::{RenderError, compile_ahead, render, render_in_batches, sampled_pixels};
use snell::gpu::upload::{Scene, UploadError};
use snell::gpu::variant::Variants;
use snell::gpu::wavefront::{FilmCell, Wavefront, kernels};
use snell::pack::outline::Outline;
use snell::pack::{Background, Packed, pack};
use snell::render::Settings;
use snell::scene::{AlphaMode, Environment, Model, Projection};
use snell::shared::Frame;
use std::f64::consts::PI;
use std::ops::Range;

/// The gallery in small: every reflection model, area lights, instances. Wider than a tile.
fn gallery() -> Packed {
    packed(&load_scene(&project("scenes/gallery.gltf")), [272, 21])
}

#[test]
fn two_runs_give_the_same_film() {
    let mut gpu = common::gpu();
    let packed = gallery();
    let settings = whole(&packed, 3);
    assert!(on_gpu(&mut gpu, &packed, &settings) == on_gpu(&mut gpu, &packed, &settings));
}

#[test]
fn the_size_of_dispatches_changes_no_bit() {
    let mut gpu = common::gpu();
    let packed = gallery();
    let settings = whole(&packed, 5);
    let mut with = |paths| {
        render_in_batches(&mut gpu, &packed, &settings, paths, &mut |_| {})
            .unwrap()
            .0
    };
    let one_by_one = with(1..2);
    assert!(one_by_one == with(20_000..20_001));
    assert!(one_by_one == with(1 << 16..1 << 18));
}

/// Arrays in buffers, as for a GPU, or in textures, as for a software adapter. They fill more than a row.
#[test]
fn where_the_arrays_are_changes_no_bit() {
    let packed = gallery();
    let longest = packed
        .arrays()
        .map(|(_, bytes)| bytes.len())
        .into_iter()
        .max();
    assert!(longest > Some(16 << ROW_BITS));
    let settings = whole(&packed, 2);
    let [buffers, textures] = [false, true].map(|textures| {
        let mut gpu = common::gpu();
        gpu.arrays_in_textures = textures;
        on_gpu(&mut gpu, &packed, &settings)
    });
    assert!(buffers == textures);
}

/// Release builds leave wgpu's checks out.
#[test]
fn what_is_not_checked_is_the_same() {
    let packed = gallery();
    let settings = whole(&packed, 2);
    let [checked, unchecked] = [true, false].map(|checked| {
        let mut gpu = common::gpu();
        assert!(gpu.checked, "tests run with the checks");
        gpu.checked = checked;
        on_gpu(&mut gpu, &packed, &settings)
    });
    assert!(checked == unchecked);
}

fn cut(film: &Film, [x, y, width, height]: [u32; 4]) -> Film {
    let mut part = Film::new(width, height);
    for row in 0..height {
        for column in 0..width {
            *part.pixel_mut(column, row) = *film.pixel(x + column, y + row);
        }
    }
    part
}

#[test]
fn a_crop_is_that_part_of_the_whole() {
    let mut gpu = common::gpu();
    let packed = gallery();
    let all = whole(&packed, 2);
    let crop = [213, 5, 50, 12];
    let part = Settings {
        crop,
        samples: 0..2,
    };
    let film = on_gpu(&mut gpu, &packed, &all);
    assert!(on_gpu(&mut gpu, &packed, &part) == cut(&film, crop));
    let film = on_cpu(&packed, &all);
    assert!(on_cpu(&packed, &part) == cut(&film, crop));
}

#[test]
fn the_reference_does_not_depend_on_threads() {
    let packed = gallery();
    let settings = whole(&packed, 2);
    let film = on_cpu(&packed, &settings);
    let one = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .unwrap();
    assert!(film == one.install(|| on_cpu(&packed, &settings)));
}

#[test]
fn samples_in_two_ranges_are_the_samples_of_one() {
    let gpu = common::gpu();
    let packed = gallery();
    let variants = Variants::general(&Outline::of(&packed));
    let cells = |samples: Range<u32>| cells(&gpu, &packed, &variants, samples);
    let (first, second, both) = (cells(0..3), cells(3..6), cells(0..6));
    for ((a, b), c) in first.iter().zip(&second).zip(&both) {
        // Each sum carries float32's rounding of its own additions, compensated.
        let adds_up = |a: f32, b: f32, c: f32| {
            let sum = f64::from(a) + f64::from(b);
            (sum - f64::from(c)).abs() <= 2e-7 * sum.abs().max(1e-3)
        };
        assert!((0..3).all(|i| adds_up(a.sum[i], b.sum[i], c.sum[i])));
        assert!(adds_up(a.weight, b.weight, c.weight));
    }
}

/// The film of a whole picture, as the kernels of these variants leave it.
fn cells(gpu: &Gpu, packed: &Packed, variants: &Variants, samples: Range<u32>) -> Vec<FilmCell> {
    let [width, height] = packed.frame.film_size;
    let frame = Frame {
        first_sample: samples.start,
        sample_count: samples.len() as u32,
        capacity: sampled_pixels([width, height]) * samples.len() as u32,
        ..packed.frame
    };
    let scene = Scene::upload(gpu, packed).unwrap();
    let pixels = width * height;
    let wavefront = Wavefront::new(gpu, scene, variants, frame.capacity, pixels).unwrap();
    wavefront.run(gpu, &frame, true).unwrap();
    wavefront.read_film(gpu, pixels).unwrap()
}

/// Mesa to 22.3 ends all loops of an invocation after 65 536 rounds in all and says nothing, and a pixel's
/// samples are added in a loop.
#[test]
fn a_pixel_keeps_more_samples_than_drivers_run_rounds() {
    let mut gpu = common::gpu();
    let mut scene = shapes::scene(Vec::new(), Vec::new());
    scene.environment = Some(Environment {
        width: 1,
        height: 1,
        radiance: vec![[0.5, 1.0, 2.0]],
        strength: 1.0,
        rotation: 0.0,
    });
    let packed = packed(&scene, [1, 1]);
    let most = 1 << 18;
    let (film, _) = render_in_batches(
        &mut gpu,
        &packed,
        &whole(&packed, most),
        most..most,
        &mut |_| {},
    )
    .unwrap();
    for (sum, radiance) in film.pixel(0, 0).sum.iter().zip([0.5, 1.0, 2.0]) {
        assert_eq!(*sum, radiance * f64::from(most));
    }
}

/// Two tiles, a dispatch for each sample number; the device is lost in the first, or in the second.
#[test]
fn a_lost_device_is_opened_again() {
    let packed = gallery();
    let settings = whole(&packed, 8);
    let [first, second] = [256 * 21, 16 * 21].map(|pixels| (1..=8).map(move |n| n * pixels));
    let all: Vec<u64> = first
        .clone()
        .chain(second.map(|done| 8 * 256 * 21 + done))
        .collect();
    let opened = common::gpu();
    let settings_of = |gpu: &Gpu| (gpu.checked, gpu.arrays_in_textures, gpu.skips_branches);
    let (checked, textures, skips) = settings_of(&opened);
    let chosen = (!checked, !textures, !skips);
    let render = |lost_at: Option<usize>| {
        let mut gpu = common::gpu();
        (gpu.checked, gpu.arrays_in_textures, gpu.skips_branches) = chosen;
        let device = gpu.device.clone();
        let mut seen = Vec::new();
        let (film, statistics) =
            render_in_batches(&mut gpu, &packed, &settings, 1..2, &mut |progress| {
                seen.push(progress.done);
                assert_eq!(progress.total, 272 * 21 * 8);
                if Some(seen.len()) == lost_at {
                    device.destroy();
                }
            })
            .unwrap();
        assert_eq!(settings_of(&gpu), chosen);
        (film, statistics.counts, seen)
    };
    let (film, counts, seen) = render(None);
    assert_eq!(seen, all);
    for (lost_at, start_of_tile) in [(6, 0), (12, 8)] {
        let (again, counts_again, seen) = render(Some(lost_at));
        // The tile is begun anew, with what was done before it, and counted once.
        assert_eq!(seen, [&all[..lost_at], &all[start_of_tile..]].concat());
        assert!(again == film, "lost at {lost_at}");
        assert_eq!(counts_again, counts, "lost at {lost_at}");
    }
}

/// What is asked of the driver's name and version stands where it is looked for.
#[test]
fn the_driver_says_which_mesa_it_is() {
    let gpu = common::gpu();
    assert_eq!(gpu.info.driver, "llvmpipe");
    let (_, version) = gpu.info.driver_info.split_once("Mesa ").unwrap();
    let major: u32 = version.split_once('.').unwrap().0.parse().unwrap();
    assert_eq!(gpu.skips_branches, major >= 25, "{}", gpu.info.driver_info);
}

#[test]
fn a_scene_over_the_limits_ends_in_a_sentence() {
    let mut gpu = common::gpu();
    let mut packed = gallery();
    gpu.limits.max_storage_buffer_binding_size = 4096;
    gpu.limits.max_buffer_size = 4096;
    for textures in [false, true] {
        gpu.arrays_in_textures = textures;
        let error = render(&mut gpu, &packed, &whole(&packed, 1), &mut |_| {}).unwrap_err();
        assert!(
            matches!(error, RenderError::Upload(UploadError::TooLarge { .. })),
            "{error}"
        );
        assert!(error.to_string().contains("4096"), "{error}");
    }
    let mut gpu = common::gpu();
    packed.frame.environment_size = [1 << 20, 1];
    packed.environment = vec![[0.0; 4]; 1 << 20];
    let error = render(&mut gpu, &packed, &whole(&packed, 1), &mut |_| {}).unwrap_err();
    assert!(
        matches!(
            error,
            RenderError::Upload(UploadError::EnvironmentTooLarge { .. })
        ),
        "{error}"
    );
}

#[test]
fn progress_goes_from_the_first_batch_to_all() {
    let mut gpu = common::gpu();
    let packed = gallery();
    let mut seen = Vec::new();
    let (_, statistics) = render(&mut gpu, &packed, &whole(&packed, 4), &mut |progress| {
        seen.push(progress.done);
        assert_eq!(progress.total, 272 * 21 * 4);
    })
    .unwrap();
    assert!(seen.is_sorted());
    assert_eq!(seen.last(), Some(&(272 * 21 * 4)));
    assert!(statistics.counts.closest_rays >= 272 * 21 * 4);
}

#[test]
fn no_submission_nears_a_watchdogs_two_seconds() {
    let mut gpu = common::gpu();
    let packed = packed(&load_scene(&project("scenes/gallery.gltf")), [256, 256]);
    let (_, statistics) = render(&mut gpu, &packed, &whole(&packed, 16), &mut |_| {}).unwrap();
    println!("longest submission {:?}", statistics.longest_submission);
    assert!(statistics.longest_submission.as_secs_f64() < 2.0);
}

/// Those that are compiled side by side, while a scene is packed, are all that a wavefront asks for.
#[test]
fn every_kernel_is_compiled_ahead() {
    let gpu = common::gpu();
    let packed = packed(&load_scene(&project("scenes/mirror.gltf")), [8, 8]);
    let scene = Scene::upload(&gpu, &packed).unwrap();
    let outline = Outline::of(&packed);
    let variants = Variants::of(&outline, &gpu.constants());
    let kernels = kernels(&variants);
    compile_ahead(&gpu, &outline).unwrap();
    assert_eq!(gpu.kernel_count(), kernels.len());
    Wavefront::new(&gpu, scene, &variants, 64, 64).unwrap();
    assert_eq!(gpu.kernel_count(), kernels.len());
}

/// What a pipeline takes for granted of a scene is true, so leaving it out changes nothing beyond the
/// rounding of another compilation.
#[test]
fn a_variant_shows_what_the_general_kernels_show() {
    let gpu = common::gpu();
    for path in [
        "scenes/gallery.gltf",
        "scenes/white_furnace.gltf",
        "scenes/glasses.gltf",
        "scenes/coatings.gltf",
    ] {
        let packed = packed(&load_scene(&project(path)), [64, 48]);
        let (general, variant) = (
            cells(
                &gpu,
                &packed,
                &Variants::general(&Outline::of(&packed)),
                0..2,
            ),
            cells(
                &gpu,
                &packed,
                &Variants::of(&Outline::of(&packed), &[]),
                0..2,
            ),
        );
        let differing = general
            .iter()
            .zip(&variant)
            .filter(|(g, v)| (0..3).any(|c| (g.sum[c] - v.sum[c]).abs() > 1e-3 * g.sum[c].abs()))
            .count();
        println!("{path}: {differing} of {} pixels differ", general.len());
        assert!(differing * 200 < general.len(), "{path}: {differing}");
    }
}

/// A lamp that is blended to a quarter lights a floor with a quarter, by chosen and by found light
/// alike.
#[test]
fn a_blended_lamp_is_as_bright_as_it_is_there() {
    let quad = |y: f32, size: f32| {
        let corner = |x: f32, z: f32| Vec3::new(x * size, y, z * size);
        let (a, b) = (corner(-1.0, -1.0), corner(-1.0, 1.0));
        let (c, d) = (corner(1.0, 1.0), corner(1.0, -1.0));
        shapes::flat(&[[a, b, c], [a, c, d]])
    };
    let with_alpha = |alpha: f32| {
        let floor = quad(0.0, 10.0);
        let mut lamp = quad(1.0, 0.7);
        lamp.primitives[0].material = 1;
        let mut scene = shapes::scene(
            vec![floor, lamp],
            vec![
                shapes::instance(0, Affine3A::IDENTITY),
                shapes::instance(1, Affine3A::IDENTITY),
            ],
        );
        let mut shining = shapes::material();
        shining.emissive = Vec3::ONE;
        shining.alpha_mode = AlphaMode::Blend;
        if let Model::MetallicRoughness(m) = &mut shining.model {
            m.base_color = Vec4::new(0.0, 0.0, 0.0, alpha);
        }
        scene.materials.push(shining);
        let mut view = shapes::view();
        view.max_depth = 1;
        // From the side, under the lamp: the floor alone is seen.
        view.camera.world_from_camera =
            Affine3A::from_rotation_x(-0.2) * Affine3A::from_translation(Vec3::Z * 2.5);
        view.camera.projection = Projection::Perspective {
            yfov: 0.2,
            aspect: None,
            near: 0.01,
        };
        view.film_size = [16, 16];
        pack(&scene, &view).unwrap()
    };
    let mut gpu = common::gpu();
    for on_cpu_too in [false, true] {
        let mut average = |alpha| {
            let packed = with_alpha(alpha);
            let settings = whole(&packed, 256);
            match on_cpu_too {
                false => on_gpu(&mut gpu, &packed, &settings).average(),
                true => on_cpu(&packed, &settings).average(),
            }
        };
        let (quarter, full) = (average(0.25), average(1.0));
        assert!(full > 0.05, "{full}");
        let ratio = quarter / full;
        assert!((ratio - 0.25).abs() < 0.005, "{ratio}");
    }
}

/// The integral of the 4-term Blackman-Harris window on [-1, 1] from its start, of 1 in all.
fn window_cdf(t: f64) -> f64 {
    let t = t.clamp(-1.0, 1.0);
    let sines = (1..)
        .zip([0.48829, 0.14128, 0.01168])
        .map(|(k, a)| a * (f64::from(k) * PI * t).sin() / (f64::from(k) * PI));
    0.5 + (0.5 * t + sines.sum::<f64>() / (2.0 * 0.35875))
}

/// Edges are as soft as the filter is wide, and lie where they lie; beyond the picture's border is what is there.
#[test]
fn edges_are_the_filters_integral() {
    let [left, right, top] = [-8.0_f32, 0.3, -0.2];
    let corner = |x: f32, y: f32| Vec3::new(x, y, 0.0);
    let (a, b) = (corner(left, -20.0), corner(right, -20.0));
    let (c, d) = (corner(right, top), corner(left, top));
    let quad = shapes::flat(&[[a, b, c], [a, c, d]]);
    let mut scene = shapes::scene(vec![quad], vec![shapes::instance(0, Affine3A::IDENTITY)]);
    scene.materials[0].emissive = Vec3::ONE;
    let mut view = shapes::view();
    view.background = Background::Color([0.0; 3]);
    view.max_depth = 0;
    view.film_size = [16, 16];
    view.camera.world_from_camera = Affine3A::from_translation(Vec3::Z * 2.0);
    view.camera.projection = Projection::Orthographic {
        xmag: 8.0,
        ymag: 8.0,
        near: 0.01,
    };
    let packed = pack(&scene, &view).unwrap();
    let settings = whole(&packed, 1024);
    let films = [
        on_gpu(&mut common::gpu(), &packed, &settings),
        on_cpu(&packed, &settings),
    ];
    for film in films {
        let mut partly = 0;
        for row in 0..16 {
            for column in 0..16 {
                let (x, y) = (f64::from(column) - 7.5, 7.5 - f64::from(row));
                let below = |edge: f32, center: f64| window_cdf((f64::from(edge) - center) / 1.5);
                let expected = (below(right, x) - below(left, x)) * below(top, y);
                let pixel = film.pixel(column, row);
                let (mean, error) = (pixel.mean()[0], pixel.variance()[0].sqrt());
                assert!(
                    (mean - expected).abs() < 3.0 * error + 1e-5,
                    "{column}, {row}: {mean} +- {error} instead of {expected}"
                );
                partly += u32::from(mean > 0.01 && mean < 0.99);
            }
        }
        assert!(partly > 20, "{partly}");
    }
}

/// Alpha is looked up and instances are entered within the traversal's loop or outside of it, as suits the driver;
/// what is seen is the same, with all things in one level and in two.
#[test]
fn what_is_put_off_in_the_traversal_shows_the_same() {
    let mut soup = shapes::soup(&mut shapes::Random(5), 70, 1.0);
    soup.primitives[0].material = 1;
    let turned = |angle| shapes::instance(0, Affine3A::from_rotation_x(angle));
    let mut scene = shapes::scene(vec![soup], [0.0, 1.0, 2.0].map(turned).to_vec());
    let mut veil = shapes::material();
    veil.emissive = Vec3::new(0.5, 0.2, 0.1);
    veil.alpha_mode = AlphaMode::Blend;
    if let Model::MetallicRoughness(m) = &mut veil.model {
        m.base_color = Vec4::new(0.8, 0.5, 0.3, 0.2);
    }
    scene.materials.push(veil);
    let mut view = shapes::view();
    view.film_size = [24, 24];
    let mut gpu = common::gpu();
    for scene in [scene.clone(), shapes::two_levels(scene)] {
        let packed = pack(&scene, &view).unwrap();
        let settings = whole(&packed, 8);
        let mut picture = |skips_branches| {
            gpu.skips_branches = skips_branches;
            on_gpu(&mut gpu, &packed, &settings)
        };
        let (later, at_once) = (picture(false), picture(true));
        assert!(!at_once.is_black());
        assert!(later == at_once);
    }
}
