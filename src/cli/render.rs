//! `snell render`: from a file to pictures.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use clap::Args;

use super::value::{self, Aov, Background};
use super::{record, view};
use crate::error::Error;
use crate::film::Film;
use crate::gltf::{self, EnvironmentSource, LoadOptions, Loaded, Treatment};
use crate::gpu::device::{self, DeviceError, Gpu};
use crate::output::tonemap::Tonemap;
use crate::output::{self, Channels, Format, Look, Place, Target, Window};
use crate::pack::{self, Packed, View};
use crate::progress::Progress;
use crate::render::{Counts, Settings};
use crate::report::{self, Facts, Times};
use crate::{cpu, gpu};

#[derive(Debug, Args)]
pub struct RenderArgs {
    /// A .gltf or .glb file.
    pub scene: PathBuf,
    /// Where to: .png .exr .hdr .jpg .webp by ending; '-' is a PNG on standard output.
    #[arg(short, long = "output", required = true, value_name = "OUT")]
    pub output: Vec<PathBuf>,

    /// Width and height in pixels.
    #[arg(long, default_value = "800x600", value_name = "WxH", value_parser = value::size)]
    pub size: [u32; 2],
    /// Samples of each pixel.
    #[arg(long, default_value_t = 32, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: u32,
    /// Only these of a pixel's samples, by their running number; B is not included.
    #[arg(long, value_name = "A..B", value_parser = value::samples, conflicts_with = "spp")]
    pub samples: Option<Range<u32>>,
    /// Most bounces of a path; 0 shows emission only.
    #[arg(long, default_value_t = 12, value_name = "N", value_parser = clap::value_parser!(u32).range(..=1024))]
    pub max_depth: u32,
    /// Limit the largest channel of each sample's radiance. Takes fireflies away and the light they
    /// carry with them: the picture is darker than the scene.
    #[arg(long, value_name = "VALUE", value_parser = value::positive, allow_negative_numbers = true)]
    pub clamp: Option<f64>,
    /// Another seed takes other samples.
    #[arg(long, default_value_t = 0, value_name = "N")]
    pub seed: u32,
    /// Only this window of the picture, in pixels from its upper left corner.
    #[arg(long, value_name = "X,Y,W,H", value_parser = value::crop)]
    pub crop: Option<[u32; 4]>,

    /// A camera of the scene by name or number from 0, or 'auto' for one that frames everything.
    #[arg(long, value_name = "NAME|INDEX|auto")]
    pub camera: Option<String>,
    /// A camera around the scene's centre: degrees about +y from +z, degrees down from +y, metres.
    #[arg(long, value_name = "THETA,PHI,RADIUS", value_parser = value::orbit, conflicts_with = "camera", allow_hyphen_values = true)]
    pub orbit: Option<[f64; 3]>,

    /// Light from all around: a map (.hdr, .exr, or an ordinary picture), a colour ('#rrggbb' sRGB,
    /// 'r,g,b' linear radiance), or 'sky', a computed sun and sky. Its keys: elevation (degrees, 0 to
    /// 90, default 30), azimuth (degrees about +y from +z, counter-clockwise seen from above, default
    /// 45), turbidity (haze, 1 to 10, default 3), albedo (of the ground, 0 to 1, default 0.2), sun (0
    /// leaves the disc away, default 1).
    #[arg(long, value_name = "FILE|COLOR|sky[:key=value,...]", value_parser = value::environment, allow_hyphen_values = true)]
    pub env: Option<EnvironmentSource>,
    /// Turn the map or the sky by this about +y, counter-clockwise seen from above.
    #[arg(long, default_value_t = 0.0, value_name = "DEG", value_parser = value::finite, allow_negative_numbers = true)]
    pub env_rotation: f64,
    /// Multiply the radiance of --env.
    #[arg(long, default_value_t = 1.0, value_name = "S", value_parser = value::not_negative, allow_negative_numbers = true)]
    pub env_strength: f64,
    /// What is seen behind the scene: 'env', 'transparent', '#rrggbb' (sRGB) or 'r,g,b' (linear).
    #[arg(long, default_value = "env", value_name = "COLOR|env|transparent", value_parser = value::background, allow_hyphen_values = true)]
    pub background: Background,

    /// Stops to brighten by before the tone map; .exr and .hdr stay as they are.
    #[arg(long, default_value_t = 0.0, value_name = "EV", value_parser = value::finite, allow_negative_numbers = true)]
    pub exposure: f64,
    /// How radiance becomes colour in .png, .jpg and .webp.
    #[arg(long, value_enum, default_value_t = Tonemap::Neutral)]
    pub tonemap: Tonemap,
    /// Further channels of .exr: variance (of the mean), samples.
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = value::aov)]
    pub aov: Vec<Aov>,

    /// Render on the adapter whose name contains this; `snell doctor` lists them.
    #[arg(long, value_name = "SUBSTRING", conflicts_with = "cpu")]
    pub adapter: Option<String>,
    /// Render with the float64 reference.
    #[arg(long)]
    pub cpu: bool,

    /// Fail where the file uses extensions that would be ignored; naming one that nothing carries is no
    /// use. Approximated ones pass.
    #[arg(long)]
    pub strict: bool,
    /// Write a record of the render; see schema/report.schema.json.
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// A folder that the scene may read files from, beside its own.
    #[arg(long, value_name = "FOLDER")]
    pub allow_path: Vec<PathBuf>,
    /// Most memory that the scene and the film may take, such as 512M or 8G.
    #[arg(long, default_value = "4G", value_name = "BYTES", value_parser = value::bytes)]
    pub max_memory: u64,
    /// Say nothing but warnings and errors.
    #[arg(short, long)]
    pub quiet: bool,
}

/// Everything that is settled before the first ray.
pub struct Job<'a> {
    pub args: &'a RenderArgs,
    pub settings: Settings,
    pub loaded: Loaded,
    pub camera_name: String,
    pub packed: Packed,
    /// `None` is the CPU renderer.
    pub gpu: Option<Gpu>,
}

/// A film and how it came to be.
pub struct Rendered {
    pub film: Film,
    pub counts: Counts,
}

/// Renders and writes; the order is that of the checks: nothing that can be known to fail is started.
pub fn run(args: &RenderArgs) -> Result<(), Error> {
    let started = Instant::now();
    let targets = targets(args)?;
    let report_place = args.report.as_ref().map(|path| Place::of(path));
    let mut places: Vec<&Place> = targets.iter().map(|t| &t.place).collect();
    places.extend(&report_place);
    output::file::check(&places)?;
    let crop = crop(args)?;
    check_film_memory(args, crop)?;

    let mut times = Times::default();
    let mut job = prepare(args, crop, &mut times)?;
    let rendered = render(&mut job, &mut times)?;
    warn_of_bad_pictures(&rendered.film, &job.loaded);

    let start = Instant::now();
    let needs_facts = report_place.is_some() || targets.iter().any(|t| t.format == Format::Exr);
    let facts = needs_facts
        .then(|| record::facts(&job, &rendered))
        .transpose()?;
    let header = facts.as_ref().map_or_else(String::new, Facts::json);
    let window = Window {
        full_size: args.size,
        origin: [crop[0], crop[1]],
    };
    let mut files = Vec::new();
    for target in &targets {
        let bytes = output::encode(
            &rendered.film,
            target.format,
            channels(args),
            look(args),
            window,
            &header,
        )?;
        files.push((&target.place, bytes));
    }
    times.encode = report::milliseconds(start.elapsed());
    if let (Some(place), Some(facts)) = (&report_place, facts) {
        let report = record::report(&job, facts, times);
        files.push((place, report.json().into_bytes()));
    }
    let files: Vec<(&Place, &[u8])> = files.iter().map(|(p, b)| (*p, b.as_slice())).collect();
    output::file::write_all(&files)?;
    if !args.quiet {
        super::say(&record::summary(&job, &rendered, started.elapsed()));
    }
    Ok(())
}

fn targets(args: &RenderArgs) -> Result<Vec<Target>, Error> {
    let targets: Result<Vec<_>, _> = args.output.iter().map(|path| Target::parse(path)).collect();
    let targets = targets?;
    if !args.aov.is_empty() && targets.iter().all(|t| t.format != Format::Exr) {
        return Err(Error::Usage(
            "--aov needs an output that ends in .exr; no other format has room for further channels".into(),
        ));
    }
    Ok(targets)
}

/// The window to render: all, or what was asked for if it lies inside.
fn crop(args: &RenderArgs) -> Result<[u32; 4], Error> {
    let [width, height] = args.size;
    let Some([x, y, w, h]) = args.crop else {
        return Ok([0, 0, width, height]);
    };
    let inside =
        |from: u32, size: u32, all: u32| from.checked_add(size).is_some_and(|end| end <= all);
    if inside(x, w, width) && inside(y, h, height) {
        Ok([x, y, w, h])
    } else {
        Err(Error::Usage(format!(
            "the crop {x},{y},{w},{h} does not lie inside the picture of {width}x{height}"
        )))
    }
}

/// The film and one encoded copy must fit before anything else is begun.
fn check_film_memory(args: &RenderArgs, crop: [u32; 4]) -> Result<(), Error> {
    let pixel = size_of::<crate::film::FilmPixel>() as u64 + 4 * size_of::<f32>() as u64;
    let needed = u64::from(crop[2]) * u64::from(crop[3]) * pixel;
    if needed <= args.max_memory {
        Ok(())
    } else {
        Err(Error::FilmTooLarge {
            needed,
            allowed: args.max_memory,
        })
    }
}

/// Loads, packs and opens the adapter.
fn prepare<'a>(args: &'a RenderArgs, crop: [u32; 4], times: &mut Times) -> Result<Job<'a>, Error> {
    let start = Instant::now();
    let loaded = load(args)?;
    times.load = report::milliseconds(start.elapsed());
    say_notes(args, &loaded);

    let start = Instant::now();
    let (camera, camera_name) =
        view::choose(&loaded.scene, args.camera.as_deref(), args.orbit, args.size)?;
    let packed = pack::pack(
        &loaded.scene,
        &View {
            camera,
            film_size: args.size,
            seed: args.seed,
            max_depth: args.max_depth,
            background: match args.background {
                Background::Environment => pack::Background::Environment,
                Background::Color(color) => pack::Background::Color(color),
                Background::Transparent => pack::Background::Transparent,
            },
            clamp: args.clamp.map(|limit| limit as f32),
        },
    )?;
    times.pack = report::milliseconds(start.elapsed());

    let start = Instant::now();
    let gpu = open(args)?;
    times.open_adapter = report::milliseconds(start.elapsed());
    Ok(Job {
        args,
        settings: Settings {
            crop,
            samples: args.samples.clone().unwrap_or(0..args.spp),
        },
        loaded,
        camera_name,
        packed,
        gpu,
    })
}

fn load(args: &RenderArgs) -> Result<Loaded, Error> {
    let mut loaded = gltf::load(
        &args.scene,
        &LoadOptions {
            allow_paths: args.allow_path.clone(),
            max_memory: args.max_memory,
            environment: args.env.clone(),
        },
    )?;
    let extensions = loaded.extensions.iter();
    let ignored: Vec<_> = extensions.filter(|e| e.is_missed()).cloned().collect();
    if args.strict && !ignored.is_empty() {
        return Err(Error::Strict {
            scene: args.scene.clone(),
            ignored,
        });
    }
    if let Some(environment) = &mut loaded.scene.environment {
        environment.strength *= args.env_strength as f32;
        environment.rotation += args.env_rotation.to_radians() as f32;
    }
    Ok(loaded)
}

/// What the picture will not show.
fn say_notes(args: &RenderArgs, loaded: &Loaded) {
    if args.quiet {
        return;
    }
    for extension in &loaded.extensions {
        if extension.treatment != Treatment::Supported {
            super::say(&format!("note: {}: {}", extension.name, extension.detail));
        }
    }
    for note in &loaded.notes {
        super::say(&format!("note: {note}"));
    }
}

/// The adapter, or `None` for the CPU renderer: asked for, or taken where there is no adapter at all.
fn open(args: &RenderArgs) -> Result<Option<Gpu>, Error> {
    if args.cpu {
        return Ok(None);
    }
    match device::open(args.adapter.as_deref()) {
        Ok(gpu) => Ok(Some(gpu)),
        Err(error @ (DeviceError::NoAdapter | DeviceError::BelowDefaults { .. }))
            if args.adapter.is_none() =>
        {
            super::say(&format!("rendering on the CPU: {error}"));
            Ok(None)
        }
        Err(error) => Err(error.into()),
    }
}

fn render(job: &mut Job, times: &mut Times) -> Result<Rendered, Error> {
    let mut progress = Progress::new(job.args.quiet);
    let rendered = match &mut job.gpu {
        Some(gpu) => {
            let (film, statistics) =
                gpu::render::render(gpu, &job.packed, &job.settings, &mut |p| {
                    progress.update(p.done, p.total);
                })?;
            times.upload = Some(report::milliseconds(statistics.upload));
            times.compile = Some(report::milliseconds(statistics.compile));
            times.render = report::milliseconds(statistics.render);
            Rendered {
                film,
                counts: statistics.counts,
            }
        }
        None => {
            let start = Instant::now();
            let shared = Mutex::new(&mut progress);
            let (film, counts) = cpu::path::render(&job.packed, &job.settings, &|p| {
                let mut progress = shared.lock().unwrap_or_else(PoisonError::into_inner);
                progress.update(p.done, p.total);
            });
            times.render = report::milliseconds(start.elapsed());
            Rendered { film, counts }
        }
    };
    progress.finish();
    Ok(rendered)
}

/// A picture that cannot be meant is still written, and said to be so.
fn warn_of_bad_pictures(film: &Film, loaded: &Loaded) {
    let bad = film.non_finite();
    if bad > 0 {
        super::say(&format!(
            "warning: {bad} of {} samples were infinite or not a number and were left out; \
             the picture is wrong there, please report it with the scene",
            bad + film.samples()
        ));
    }
    if film.is_black() {
        let cause = if loaded.scene.instances.is_empty() {
            "the scene shows no triangles"
        } else if loaded.scene.environment.is_none() {
            "none of the scene's lights reaches what the camera sees; --env adds light from all around"
        } else {
            "no light reaches what the camera sees; check --env-strength and the camera's place (--camera auto)"
        };
        super::say(&format!("warning: the picture is black: {cause}"));
    }
}

fn channels(args: &RenderArgs) -> Channels {
    Channels {
        transparent: args.background == Background::Transparent,
        variance: args.aov.contains(&Aov::Variance),
        samples: args.aov.contains(&Aov::Samples),
    }
}

fn look(args: &RenderArgs) -> Look {
    Look {
        exposure_ev: args.exposure,
        tonemap: args.tonemap,
    }
}
