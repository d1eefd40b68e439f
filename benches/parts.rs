//! `cargo bench`: the parts of a picture, each against its own last time. `snell bench` measures whole ones.

use std::f32::consts::TAU;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::Duration;

use criterion::{Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use glam::Vec3A;
use snell::bvh::{self, Bounds};
use snell::gltf::{self, LoadOptions};
use snell::gpu::wavefront::STAGES;
use snell::pack::{self, Background, Packed, View};
use snell::render::Settings;
use snell::scene::Scene;
use snell::{cpu, gpu};

const SIDE: u32 = 64;
const SETTINGS: Settings = Settings {
    crop: [0, 0, SIDE, SIDE],
    samples: 0..4,
};
const PATHS: u64 = (SIDE * SIDE * 4) as u64;

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn load(path: &Path) -> Scene {
    let loaded = gltf::load(path, &LoadOptions::default());
    loaded.unwrap_or_else(|error| panic!("{error}")).scene
}

fn view(scene: &Scene) -> View {
    View {
        camera: scene
            .cameras
            .first()
            .cloned()
            .unwrap_or_else(|| gltf::default_camera(scene, 1.0)),
        film_size: [SIDE, SIDE],
        seed: 0,
        max_depth: 7,
        clamp: None,
        background: Background::Environment,
    }
}

fn packed(name: &str) -> Packed {
    let scene = load(&file(name));
    pack::pack(&scene, &view(&scene)).unwrap_or_else(|error| panic!("{error}"))
}

/// Boxes of small triangles on a rolling sheet of `side` x `side` squares.
fn sheet(side: u16) -> Vec<Bounds> {
    let point = |x: u16, z: u16| {
        let [x, z] = [x, z].map(|i| f32::from(i) / f32::from(side));
        Vec3A::new(x, 0.1 * (3.0 * TAU * x).sin() * (2.0 * TAU * z).cos(), z)
    };
    let square = |x, z| {
        let [a, b, c, d] = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[i, j]| point(x + i, z + j));
        [Bounds::of_points([a, b, c]), Bounds::of_points([a, c, d])]
    };
    (0..side)
        .flat_map(|x| (0..side).flat_map(move |z| square(x, z)))
        .collect()
}

fn hierarchy(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("bvh");
    group.sampling_mode(SamplingMode::Flat);
    for side in [32, 256] {
        let boxes = sheet(side);
        group.throughput(Throughput::Elements(boxes.len() as u64));
        group.bench_function(format!("{} triangles", boxes.len()), |b| {
            b.iter(|| bvh::build(black_box(&boxes)));
        });
    }
    group.finish();
}

/// A textured file of the corpus where there is one, and one of our own.
fn scenes(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("scene");
    group.sampling_mode(SamplingMode::Flat);
    for name in [
        "../shared/corpus/core/FlightHelmet/FlightHelmet.gltf",
        "scenes/gallery.gltf",
    ] {
        let path = file(name);
        if !path.exists() {
            continue;
        }
        let stem = path
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        group.bench_function(format!("load {stem}"), |b| b.iter(|| load(&path)));
        let scene = load(&path);
        let view = view(&scene);
        group.bench_function(format!("pack {stem}"), |b| {
            b.iter(|| pack::pack(black_box(&scene), &view));
        });
    }
    group.finish();
}

/// Each stage of the wavefront, on the adapter that `snell render` takes.
fn stages(criterion: &mut Criterion) {
    let gpu = match gpu::device::open(None) {
        Ok(gpu) => gpu,
        Err(error) => {
            eprintln!("no stages: {error}");
            return;
        }
    };
    for name in ["gallery", "glasses"] {
        let packed = packed(&format!("scenes/{name}.gltf"));
        let mut group = criterion.benchmark_group(format!("{name} on {}", gpu.info.name));
        group.sampling_mode(SamplingMode::Flat);
        group.throughput(Throughput::Elements(PATHS));
        for (number, stage) in STAGES.iter().enumerate() {
            group.bench_function(*stage, |b| {
                b.iter_custom(|times| {
                    let measured =
                        gpu::render::time_stages(&gpu, &packed, &SETTINGS, times as usize);
                    let measured = measured.unwrap_or_else(|error| panic!("{error}"));
                    measured
                        .iter()
                        .map(|stages| stages[number])
                        .sum::<Duration>()
                });
            });
        }
        group.finish();
    }
}

fn reference(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("reference");
    group.sampling_mode(SamplingMode::Flat);
    group.throughput(Throughput::Elements(PATHS));
    for name in ["gallery", "glasses"] {
        let packed = packed(&format!("scenes/{name}.gltf"));
        group.bench_function(format!("Li {name}"), |b| {
            b.iter(|| cpu::render::render(black_box(&packed), &SETTINGS, &|_| {}));
        });
    }
    group.finish();
}

criterion_group! {
    name = parts;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_secs(1))
        .measurement_time(Duration::from_secs(3));
    targets = hierarchy, scenes, stages, reference
}
criterion_main!(parts);
