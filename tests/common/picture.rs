//! Loading, packing and rendering a scene, as the image tests do it.
#![allow(dead_code, reason = "each test file uses a part of this")]
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

use snell::compare::map::write_maps;
use snell::compare::{relative_within, z_test};
use snell::film::Film;
use snell::gltf::{LoadOptions, default_camera, load};
use snell::gpu::device::Gpu;
use snell::pack::{Background, Packed, View, pack};
use snell::render::Settings;
use snell::scene::Scene;
use std::path::{Path, PathBuf};

/// A file of the project.
pub fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The corpus, where it is; without it a line says that its tests were not run.
pub fn corpus() -> Option<PathBuf> {
    let folder = project("../shared/corpus");
    if folder.is_dir() {
        return Some(folder);
    }
    println!("../shared/corpus is not there: the corpus tests were not run");
    None
}

pub fn load_scene(path: &Path) -> Scene {
    load(path, &LoadOptions::default())
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
        .scene
}

/// The scene's first camera or a framing one, `width` x `height` pixels.
pub fn view(scene: &Scene, [width, height]: [u32; 2]) -> View {
    View {
        camera: scene
            .cameras
            .first()
            .cloned()
            .unwrap_or_else(|| default_camera(scene, width as f32 / height as f32)),
        film_size: [width, height],
        seed: 0,
        max_depth: 8,
        background: Background::Environment,
        clamp: None,
    }
}

pub fn packed(scene: &Scene, size: [u32; 2]) -> Packed {
    pack(scene, &view(scene, size)).unwrap()
}

/// The whole picture of a packed scene.
pub fn whole(packed: &Packed, samples: u32) -> Settings {
    let [width, height] = packed.frame.film_size;
    Settings {
        crop: [0, 0, width, height],
        samples: 0..samples,
    }
}

pub fn on_gpu(gpu: &mut Gpu, packed: &Packed, settings: &Settings) -> Film {
    snell::gpu::render::render(gpu, packed, settings, &mut |_| {})
        .unwrap_or_else(|error| panic!("{error}"))
        .0
}

pub fn on_cpu(packed: &Packed, settings: &Settings) -> Film {
    snell::cpu::render::render(packed, settings, &|_| {}).0
}

/// At an equal sample stream the renderers take the same paths, but for those that part at an edge:
/// 99 % of pixels agree within 1e-3. What is darker than this part of the mean counts as this.
const FLOOR: f64 = 1e-3;

/// Compares two films of one sample stream; leaves pictures and an error map where they differ.
/// Returns a line for the log.
pub fn assert_parity(name: &str, gpu: &Film, cpu: &Film) -> String {
    let floor = FLOOR * cpu.average();
    let within = relative_within(gpu, cpu, 1e-3, floor);
    let verdict = z_test(gpu, cpu, 0.01);
    let line = format!(
        "{name}: {:.3} % of pixels within 1e-3, z-test {}, mean {:.5} and {:.5}, non-finite {} and {}",
        100.0 * within.fraction,
        if verdict.same { "passed" } else { "failed" },
        gpu.average(),
        cpu.average(),
        gpu.non_finite(),
        cpu.non_finite(),
    );
    if within.fraction < 0.99 || !verdict.same || gpu.non_finite() + cpu.non_finite() > 0 {
        write_maps(&project("tests/current"), name, gpu, cpu).unwrap();
        panic!("{line}; worst: {:?}; {verdict:?}", within.worst);
    }
    line
}
