//! `snell render`: from a file to pictures.

use std::ops::Range;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;

use super::intrinsics::{self, Calibration};
use super::record::{self, Inputs, Made};
use super::renderer::{Opening, Renderer};
use super::sequence::{Frames, Sequence, Shot};
use super::studio::Studio;
use super::value::{self, Aov, Background};
use crate::error::Error;
use crate::film::Film;
use crate::gltf::{EnvironmentSource, Loaded};
use crate::output::tonemap::Tonemap;
use crate::output::{self, Channels, Format, Look, Place, Window};
use crate::pack::outline::Outline;
use crate::progress::Progress;
use crate::render::Settings;
use crate::report::{self, Facts, Times};

#[derive(Debug, Args)]
pub struct RenderArgs {
    /// A .gltf or .glb file.
    pub scene: PathBuf,
    /// Where to: .png .exr .hdr .jpg .webp by ending; '-' is a PNG on standard output.
    #[arg(short, long = "output", required = true, value_name = "OUT")]
    pub output: Vec<PathBuf>,

    /// Width and height in pixels; 800x600 unless --intrinsics says otherwise.
    #[arg(long = "size", value_name = "WxH", value_parser = value::size)]
    pub asked_size: Option<[u32; 2]>,
    /// The size that comes of it.
    #[arg(skip = [800, 600])]
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

    /// Show the scene at this second of its animation; 0 where only --animation or --shutter says that
    /// it plays. Before its first key and after its last an animation stands.
    #[arg(long, value_name = "SECONDS", value_parser = value::finite, allow_negative_numbers = true)]
    pub time: Option<f64>,
    /// Which animation plays, by name or number from 0, or all of them. The first, unless said.
    #[arg(long, value_name = "NAME|INDEX|all")]
    pub animation: Option<String>,
    /// How long the shutter is open from then on; what moves meanwhile is blurred.
    #[arg(long, value_name = "SECONDS", value_parser = value::not_negative, allow_negative_numbers = true)]
    pub shutter: Option<f64>,
    /// Render a sequence: frame N is the picture at N / FPS seconds, B is not included, FPS may be a
    /// fraction (30000/1001). Each output's name, and the report's, holds the number as {} or {:04}.
    /// The noise of each frame is its own, by --seed and its number.
    #[arg(long, value_name = "A..B@FPS", value_parser = value::frames, conflicts_with = "time")]
    pub frames: Option<Frames>,
    /// Turn the camera by so many degrees in all over the sequence, about +y through the scene's
    /// centre, counter-clockwise seen from above.
    #[arg(long, value_name = "DEGREES", value_parser = value::finite, allow_negative_numbers = true, requires = "frames")]
    pub turntable: Option<f64>,
    /// Show this variant of the materials (KHR_materials_variants); `snell info` lists them.
    #[arg(long, value_name = "NAME")]
    pub variant: Option<String>,

    /// A camera of the scene by name or number from 0, or 'auto' for one that frames everything;
    /// in a sequence, everything at all times of what plays. 'panorama' looks all around, from the
    /// scene's centre or from where a camera of the scene is.
    #[arg(long, value_name = "NAME|INDEX|auto|panorama[:NAME|:INDEX]")]
    pub camera: Option<String>,
    /// A camera around the scene's centre, or around X,Y,Z: degrees about +y from +z, degrees down from
    /// +y, metres.
    #[arg(long, value_name = "THETA,PHI,RADIUS[,X,Y,Z]", value_parser = value::orbit, conflicts_with = "camera", allow_hyphen_values = true)]
    pub orbit: Option<value::Orbit>,
    /// Diameter of a thin lens in metres; 0 is a pinhole, which has everything in focus.
    #[arg(long, default_value_t = 0.0, value_name = "METRES", value_parser = value::not_negative, allow_negative_numbers = true)]
    pub aperture: f64,
    /// Distance to the plane in focus along the camera's axis; without it, to what the middle of the
    /// picture shows.
    #[arg(long, value_name = "METRES", value_parser = value::positive, allow_negative_numbers = true, requires = "aperture")]
    pub focus: Option<f64>,
    /// A calibrated camera, as OpenCV has it; see schema/intrinsics.schema.json.
    #[arg(long, value_name = "FILE.json")]
    pub intrinsics: Option<PathBuf>,
    /// What is in that file.
    #[arg(skip)]
    pub calibration: Option<Calibration>,

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
    /// Check every index in the kernels and bound every loop, to track down a fault; slower
    #[arg(long)]
    pub checked: bool,

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

impl RenderArgs {
    /// With the calibration read, and the size that it or the arguments give.
    pub fn sized(mut self: Box<Self>) -> Result<Box<Self>, Error> {
        self.calibration = self
            .intrinsics
            .as_deref()
            .map(intrinsics::read)
            .transpose()?;
        if let Some(calibration) = &self.calibration {
            self.size = intrinsics::size(&calibration.intrinsics, self.asked_size)?;
        } else if let Some(size) = self.asked_size {
            self.size = size;
        }
        Ok(self)
    }
}

/// Renders and writes; the order is that of the checks: nothing that can be known to fail is started.
pub fn run(args: &RenderArgs) -> Result<(), Error> {
    let started = Instant::now();
    let sequence = Sequence::plan(args)?;
    let crop = crop(args)?;
    check_film_memory(args, crop)?;
    let mut times = Times::default();
    std::thread::scope(|scope| {
        let opening = Opening::start(scope, args.cpu, args.adapter.as_deref(), args.checked);
        let mut work = Work {
            args,
            settings: Settings {
                crop,
                samples: args.samples.clone().unwrap_or(0..args.spp),
            },
            studio: Studio::open(args, &mut times)?,
            renderer: None,
            opening,
            inputs: None,
            progress: Progress::new(args.quiet, sequence.numbers().len() as u64),
        };
        for (done, number) in sequence.numbers().enumerate() {
            let made = work.picture(sequence.shot(number)?, std::mem::take(&mut times));
            match made {
                Err(source) if !sequence.is_single() => {
                    return Err(Error::Frame {
                        number,
                        done,
                        source: Box::new(source),
                    });
                }
                made => made?,
            }
        }
        Ok::<(), Error>(())
    })?;
    if !sequence.is_single() && !args.quiet {
        super::say(&record::sequence_summary(
            args,
            sequence.numbers().len(),
            started.elapsed(),
        ));
    }
    Ok(())
}

/// What the pictures of a run have in common.
struct Work<'a> {
    args: &'a RenderArgs,
    settings: Settings,
    studio: Studio<'a>,
    /// From when there is something to render; until then it is being opened.
    renderer: Option<Renderer>,
    opening: Option<Opening<'a>>,
    /// Read again when the first record is made.
    inputs: Option<Inputs>,
    progress: Progress,
}

impl Work<'_> {
    fn picture(&mut self, shot: Shot, mut times: Times) -> Result<(), Error> {
        let started = Instant::now();
        let args = self.args;
        let mut tell = (self.opening.as_ref()).map(|opening| |outline| opening.foresee(outline));
        let tell = tell.as_mut().map(|tell| tell as &mut dyn FnMut(Outline));
        let job = self.studio.prepare(shot, &mut times, tell)?;
        let renderer = match &mut self.renderer {
            Some(renderer) => renderer,
            closed => {
                let (opened, meanwhile) =
                    Renderer::wait(self.opening.take(), args.adapter.as_deref())?;
                times.open_adapter = report::milliseconds(meanwhile.open);
                times.compile = meanwhile.compile.map(report::milliseconds);
                closed.insert(opened)
            }
        };
        let rendered =
            renderer.render(&job.packed, &self.settings, &mut self.progress, &mut times)?;
        self.progress.finish_picture();
        warn_of_bad_pictures(&rendered.film, &job.loaded);

        let start = Instant::now();
        let made = Made {
            args,
            settings: &self.settings,
            moment: self.studio.playing.record(job.shot.seconds),
            gpu: renderer.gpu(),
            job: &job,
            rendered: &rendered,
        };
        let targets = &job.shot.targets;
        let needs_facts =
            job.shot.report.is_some() || targets.iter().any(|t| t.format == Format::Exr);
        let facts = match (needs_facts, &mut self.inputs) {
            (false, _) => None,
            (true, Some(inputs)) => Some(made.facts(inputs)),
            (true, unread) => Some(made.facts(unread.insert(Inputs::read(args)?))),
        };
        let header = facts.as_ref().map_or_else(String::new, Facts::json);
        let [x, y, ..] = self.settings.crop;
        let window = Window {
            full_size: args.size,
            origin: [x, y],
        };
        let mut files = Vec::new();
        for target in targets {
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
        if let (Some(place), Some(facts)) = (&job.shot.report, facts) {
            let report = made.report(facts, times);
            files.push((place, report.json().into_bytes()));
        }
        let files: Vec<(&Place, &[u8])> = files.iter().map(|(p, b)| (*p, b.as_slice())).collect();
        let start = Instant::now();
        output::file::write_all(&files)?;
        if log::log_enabled!(log::Level::Info) {
            for line in times.lines(Some(report::milliseconds(start.elapsed()))) {
                super::say(&line);
            }
        }
        if !args.quiet {
            super::say(&made.summary(started.elapsed()));
        }
        Ok(())
    }
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
