//! `snell bench`: how fast this machine is, part by part.

mod spheres;

use std::fmt::Write;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use glam::Vec3A;
use rayon::prelude::*;
use serde::Serialize;

use super::renderer::{Opening, Renderer};
use super::value;
use crate::bvh::{self, Bounds};
use crate::error::Error;
use crate::gltf::{self, EnvironmentSource, LoadOptions};
use crate::gpu::wavefront::STAGES;
use crate::pack::outline::Outline;
use crate::pack::{self, Background, Packed, Packer, View};
use crate::progress::Progress;
use crate::render::Settings;
use crate::report::{Adapter, Rays, Times, milliseconds};
use crate::scene::Scene;
use crate::{cpu, gpu};

#[derive(Debug, clap::Args)]
pub struct BenchArgs {
    /// A .gltf or .glb file; without one, spheres that are made in memory.
    pub scene: Option<PathBuf>,
    /// Print JSON instead of text; see schema/bench.schema.json.
    #[arg(long)]
    pub json: bool,
    /// Measure the adapter whose name contains this; `snell doctor` lists them.
    #[arg(long, value_name = "SUBSTRING", conflicts_with = "cpu")]
    pub adapter: Option<String>,
    /// Measure the float64 reference.
    #[arg(long)]
    pub cpu: bool,
    /// Measure kernels that check every index and bound every loop.
    #[arg(long)]
    pub checked: bool,
    /// Width and height of the picture in pixels.
    #[arg(long, default_value = "256x256", value_name = "WxH", value_parser = value::size)]
    pub size: [u32; 2],
    /// Samples of each pixel.
    #[arg(long, default_value_t = 4, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: u32,
    /// Most bounces of a path.
    #[arg(long, default_value_t = 7, value_name = "N", value_parser = clap::value_parser!(u32).range(..=1024))]
    pub max_depth: u32,
    /// Measure everything but the first picture so many times over.
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub repetitions: u32,
    /// Light from all around, as `snell render --env` takes it.
    #[arg(long, value_name = "FILE|COLOR|sky[:key=value,...]", value_parser = value::environment, allow_hyphen_values = true)]
    pub env: Option<EnvironmentSource>,
    /// A folder that the scene may read files from, beside its own.
    #[arg(long, value_name = "FOLDER")]
    pub allow_path: Vec<PathBuf>,
    /// Most memory that the scene may take, such as 512M or 8G.
    #[arg(long, default_value = "4G", value_name = "BYTES", value_parser = value::bytes)]
    pub max_memory: u64,
}

/// What was measured, as JSON has it: see schema/bench.schema.json. Times are in milliseconds.
#[derive(Debug, Serialize)]
struct Bench {
    /// Snell's version.
    snell: &'static str,
    adapter: Adapter,
    /// Whether kernels check every index.
    checked: bool,
    /// That the CPU offers.
    threads: usize,
    /// The file's name, or `None` for the built-in scene.
    scene: Option<String>,
    triangles: usize,
    instances: usize,
    size: [u32; 2],
    spp: u32,
    max_depth: u32,
    repetitions: u32,
    /// Of one picture.
    paths: u64,
    rays: Rays,
    /// From nothing, kernels included: loading to the finished film.
    first_picture_ms: f64,
    /// Its stages.
    first_picture_times_ms: Times,
    /// Over and over; the kernels are there.
    load_ms: Option<Measured>,
    pack_ms: Measured,
    bvh_ms: Measured,
    upload_ms: Option<Measured>,
    render_ms: Measured,
    /// Each waited for by itself, so that their sum is more than `render_ms`.
    stages_ms: Option<Vec<Stage>>,
    /// Millions a second.
    bvh_mtriangles: f64,
    mpaths: f64,
    /// Of rays over the whole time of rendering.
    mrays: Kinds,
    /// Of rays over the time of the stage that traces them.
    traced_mrays: Option<Kinds>,
    warnings: Vec<String>,
}

/// A time over the repetitions, in milliseconds.
#[derive(Clone, Copy, Debug, Serialize)]
struct Measured {
    median: f64,
    least: f64,
    most: f64,
    /// Between the quartiles, as part of the median.
    scatter: f64,
}

#[derive(Debug, Serialize)]
struct Stage {
    name: &'static str,
    #[serde(flatten)]
    time: Measured,
}

#[derive(Clone, Copy, Debug, Serialize)]
struct Kinds {
    closest: f64,
    shadow: f64,
}

/// Repetitions that scatter by more say that something else goes on.
const STEADY: f64 = 0.1;
/// What is shorter scatters by the clock and the scheduler alone, milliseconds.
const SHORT: f64 = 5.0;

impl Measured {
    /// At least one time.
    fn of(mut times: Vec<f64>) -> Self {
        times.sort_by(f64::total_cmp);
        let at = |part: f64| {
            let place = part * (times.len() - 1) as f64;
            let (low, high) = (times[place.floor() as usize], times[place.ceil() as usize]);
            low + (high - low) * place.fract()
        };
        let median = at(0.5);
        Self {
            median,
            least: at(0.0),
            most: at(1.0),
            scatter: if median > 0.0 {
                (at(0.75) - at(0.25)) / median
            } else {
                0.0
            },
        }
    }

    /// The time of what is done so many times over; what is made goes away outside of it.
    fn over<T>(
        repetitions: u32,
        mut what: impl FnMut() -> Result<T, Error>,
    ) -> Result<Self, Error> {
        let once = |_| {
            let start = Instant::now();
            let made = what()?;
            let time = start.elapsed();
            drop(made);
            Ok(milliseconds(time))
        };
        Ok(Self::of(
            (0..repetitions).map(once).collect::<Result<_, Error>>()?,
        ))
    }
}

/// Measures and prints.
pub fn run(args: &BenchArgs) -> Result<(), Error> {
    let bench = measure(args)?;
    if args.json {
        let json = serde_json::to_string_pretty(&bench).expect("a Bench has string keys only");
        super::print(&(json + "\n"))
    } else {
        super::print(&bench.text())
    }
}

/// The scene, and what its images took.
fn load(args: &BenchArgs) -> Result<(Scene, Duration), Error> {
    let Some(path) = &args.scene else {
        return Ok((spheres::scene(), Duration::ZERO));
    };
    let options = LoadOptions {
        allow_paths: args.allow_path.clone(),
        max_memory: args.max_memory,
        environment: args.env.clone(),
    };
    let loaded = gltf::load(path, &options)?;
    Ok((loaded.scene, loaded.image_time))
}

fn view(args: &BenchArgs, scene: &Scene) -> View {
    let [width, height] = args.size;
    View {
        camera: scene
            .cameras
            .first()
            .cloned()
            .unwrap_or_else(|| gltf::default_camera(scene, width as f32 / height as f32)),
        film_size: args.size,
        seed: 0,
        max_depth: args.max_depth,
        clamp: None,
        background: Background::Environment,
    }
}

fn measure(args: &BenchArgs) -> Result<Bench, Error> {
    if args.scene.is_none() && args.env.is_some() {
        return Err(Error::Usage(
            "--env lights a SCENE; the built-in one has its own light".into(),
        ));
    }
    let settings = Settings {
        crop: [0, 0, args.size[0], args.size[1]],
        samples: 0..args.spp,
    };
    let mut quiet = Progress::new(true, 1);

    // The first picture, as `snell render` has it, before anything is warm.
    let mut times = Times::default();
    let started = Instant::now();
    let (scene, view, packed, mut renderer) = std::thread::scope(|scope| {
        let opening = Opening::start(scope, args.cpu, args.adapter.as_deref(), args.checked);
        let (scene, image_time) = load(args)?;
        times.load = milliseconds(started.elapsed());
        times.images = milliseconds(image_time);
        let start = Instant::now();
        let view = view(args, &scene);
        let mut packer = Packer::default();
        let mut tell = (opening.as_ref()).map(|opening| |outline| opening.foresee(outline));
        let tell = tell.as_mut().map(|tell| tell as &mut dyn FnMut(Outline));
        let packed = packer.pack_and_tell(&scene, &view, tell)?;
        times.pack = milliseconds(start.elapsed());
        times.geometry = milliseconds(packer.geometry_time);
        let (renderer, meanwhile) = Renderer::wait(opening, args.adapter.as_deref())?;
        times.open_adapter = milliseconds(meanwhile.open);
        times.compile = meanwhile.compile.map(milliseconds);
        Ok::<_, Error>((scene, view, packed, renderer))
    })?;
    let rendered = renderer.render(&packed, &settings, &mut quiet, &mut times)?;
    let first_picture_ms = milliseconds(started.elapsed());

    let rays = Rays {
        closest: rendered.counts.closest_rays,
        shadow: rendered.counts.shadow_rays,
    };
    let n = args.repetitions;
    let load_ms = match args.scene {
        Some(_) => Some(Measured::over(n, || load(args))?),
        None => None,
    };
    let pack_ms = Measured::over(n, || Ok(pack::pack(&scene, &view)?))?;
    let boxes: Vec<Vec<Bounds>> = scene.meshes.iter().map(|mesh| boxes(mesh)).collect();
    let bvh_ms = Measured::over(n, || {
        Ok(boxes
            .par_iter()
            .map(|mesh| bvh::build(mesh))
            .collect::<Vec<_>>())
    })?;
    let Pictures {
        render_ms,
        upload_ms,
        stages_ms,
    } = Pictures::measure(&mut renderer, &packed, &settings, n)?;

    let paths = u64::from(args.size[0]) * u64::from(args.size[1]) * u64::from(args.spp);
    let triangles = boxes.iter().map(Vec::len).sum();
    let stage = |name| {
        let stages = stages_ms.as_ref()?;
        stages
            .iter()
            .find(|stage: &&Stage| stage.name == name)
            .map(|stage| stage.time.median)
    };
    let traced_mrays = stage("trace closest").zip(stage("trace shadow"));
    let mut bench = Bench {
        snell: env!("CARGO_PKG_VERSION"),
        adapter: renderer
            .gpu()
            .map_or_else(Adapter::cpu, |gpu| Adapter::gpu(&gpu.info)),
        checked: renderer.gpu().is_some_and(|gpu| gpu.checked),
        threads: std::thread::available_parallelism().map_or(1, usize::from),
        scene: args.scene.as_ref().map(|path| {
            path.file_name()
                .map_or_else(String::new, |name| name.to_string_lossy().into_owned())
        }),
        triangles,
        instances: scene.instances.len(),
        size: args.size,
        spp: args.spp,
        max_depth: args.max_depth,
        repetitions: n,
        paths,
        rays,
        first_picture_ms,
        first_picture_times_ms: times,
        bvh_mtriangles: millions(triangles as u64, bvh_ms.median),
        mpaths: millions(paths, render_ms.median),
        mrays: Kinds {
            closest: millions(rays.closest, render_ms.median),
            shadow: millions(rays.shadow, render_ms.median),
        },
        traced_mrays: traced_mrays.map(|(closest, shadow)| Kinds {
            closest: millions(rays.closest, closest),
            shadow: millions(rays.shadow, shadow),
        }),
        load_ms,
        pack_ms,
        bvh_ms,
        upload_ms,
        render_ms,
        stages_ms,
        warnings: Vec::new(),
    };
    bench.warnings = bench.unsteady();
    Ok(bench)
}

/// Of a mesh's triangles.
fn boxes(mesh: &crate::scene::Mesh) -> Vec<Bounds> {
    let primitives = mesh.primitives.iter();
    primitives
        .flat_map(|primitive| {
            let corner = |&corner: &u32| Vec3A::from(primitive.positions[corner as usize]);
            let triangles = primitive.triangles.iter();
            triangles.map(move |triangle| Bounds::of_points(triangle.iter().map(corner)))
        })
        .collect()
}

/// What rendering took, when the kernels are there.
struct Pictures {
    render_ms: Measured,
    upload_ms: Option<Measured>,
    stages_ms: Option<Vec<Stage>>,
}

impl Pictures {
    fn measure(
        renderer: &mut Renderer,
        packed: &Packed,
        settings: &Settings,
        repetitions: u32,
    ) -> Result<Self, Error> {
        let gpu = match renderer {
            Renderer::Cpu => {
                return Ok(Self {
                    render_ms: Measured::over(repetitions, || {
                        Ok(cpu::render::render(packed, settings, &|_| {}))
                    })?,
                    upload_ms: None,
                    stages_ms: None,
                });
            }
            Renderer::Gpu(gpu) => gpu,
        };
        let (mut render, mut upload) = (Vec::new(), Vec::new());
        for _ in 0..repetitions {
            let (_, statistics) = gpu::render::render(gpu, packed, settings, &mut |_| {})?;
            render.push(milliseconds(statistics.render));
            upload.push(milliseconds(statistics.upload));
        }
        let stages = gpu::render::time_stages(gpu, packed, settings, repetitions as usize)?;
        let stage = |number: usize| {
            let times = stages
                .iter()
                .map(|times: &[Duration; STAGES.len()]| times[number]);
            Measured::of(times.map(milliseconds).collect())
        };
        Ok(Self {
            render_ms: Measured::of(render),
            upload_ms: Some(Measured::of(upload)),
            stages_ms: Some(
                STAGES
                    .iter()
                    .enumerate()
                    .map(|(number, name)| Stage {
                        name,
                        time: stage(number),
                    })
                    .collect(),
            ),
        })
    }
}

/// Millions a second of so many in this time; 0 for no time.
fn millions(count: u64, milliseconds: f64) -> f64 {
    if milliseconds > 0.0 {
        count as f64 / milliseconds * 1e-3
    } else {
        0.0
    }
}

impl Bench {
    /// What was measured over and over, by name.
    fn measured(&self) -> impl Iterator<Item = (&'static str, Measured)> {
        let stages = self.stages_ms.iter().flatten();
        [
            ("load", self.load_ms),
            ("pack", Some(self.pack_ms)),
            ("BVH", Some(self.bvh_ms)),
            ("upload", self.upload_ms),
            ("render", Some(self.render_ms)),
        ]
        .into_iter()
        .filter_map(|(name, time)| Some((name, time?)))
        .chain(stages.map(|stage| (stage.name, stage.time)))
    }

    /// A sentence where times cannot be trusted.
    fn unsteady(&self) -> Vec<String> {
        let scattered = self
            .measured()
            .filter(|(_, time)| time.median >= SHORT && time.scatter > STEADY);
        scattered
            .map(|(name, time)| {
                format!(
                    "{name} scatters by {:.0} % between its repetitions; something else keeps this machine busy",
                    100.0 * time.scatter
                )
            })
            .collect()
    }

    fn text(&self) -> String {
        let mut out = String::new();
        let adapter = &self.adapter;
        let driver = [adapter.driver.as_str(), adapter.driver_info.as_str()].join(" ");
        let scene = self.scene.as_deref().unwrap_or("built-in spheres");
        let [width, height] = self.size;
        // Writing to a String cannot fail.
        let _ = writeln!(
            out,
            "Snell {} on {} ({}), {} threads\n{scene}: {} triangles, {} instances; {width}x{height}, {} samples a pixel, depth {}; medians of {}\n",
            self.snell,
            adapter.name,
            if adapter.driver.is_empty() {
                "no driver"
            } else {
                driver.trim()
            },
            self.threads,
            self.triangles,
            self.instances,
            self.spp,
            self.max_depth,
            self.repetitions,
        );
        for line in self.first_picture_times_ms.lines(None) {
            let _ = writeln!(out, "{line}");
        }
        let _ = writeln!(
            out,
            "{:<24}{:>10.1} ms\n",
            "first picture", self.first_picture_ms
        );
        for (name, time) in self.measured() {
            let _ = writeln!(
                out,
                "{name:<24}{:>10.2} ms   {:.2} to {:.2}",
                time.median, time.least, time.most
            );
        }
        out.push('\n');
        let mut rate = |name: &str, value: f64, unit: &str| {
            let _ = writeln!(out, "{name:<24}{value:>10.3} M{unit}/s");
        };
        rate("paths", self.mpaths, "paths");
        rate("closest rays", self.mrays.closest, "rays");
        rate("shadow rays", self.mrays.shadow, "rays");
        if let Some(traced) = self.traced_mrays {
            rate("closest rays, traced", traced.closest, "rays");
            rate("shadow rays, traced", traced.shadow, "rays");
        }
        rate("BVH", self.bvh_mtriangles, "triangles");
        for warning in &self.warnings {
            let _ = writeln!(out, "\nwarning: {warning}");
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_quartiles() {
        let even = Measured::of(vec![4.0, 1.0, 3.0, 2.0]);
        assert_eq!((even.least, even.median, even.most), (1.0, 2.5, 4.0));
        assert!((even.scatter - 1.5 / 2.5).abs() < 1e-12);
        let one = Measured::of(vec![7.0]);
        assert_eq!((one.median, one.scatter), (7.0, 0.0));
    }

    #[test]
    fn rates_are_millions_a_second() {
        assert_eq!(millions(3_000_000, 1500.0), 2.0);
        assert_eq!(millions(1, 0.0), 0.0);
    }
}
