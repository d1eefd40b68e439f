//! `snell plot`: figures of reflection functions.

use std::path::{Path, PathBuf};

use clap::builder::PossibleValuesParser;
use clap::{Args, Subcommand, ValueEnum};
use serde_json::Value;

use super::value;
use crate::error::Error;
use crate::gltf::{self, LoadOptions};
use crate::output::{self, Place};
use crate::plot::PlotError;
use crate::plot::albedo::AlbedoFigure;
use crate::plot::fresnel::FresnelFigure;
use crate::plot::lobe::{LobeFigure, Radius};
use crate::plot::page::{self, Figure};
use crate::plot::sphere::SphereFigure;
use crate::plot::subject::{PRESETS, Reference, Subject};
use crate::scene::metals::{METALS, Metal, metal};

/// Draw reflection functions: Fresnel curves, lobes, albedos, slices on a sphere
///
/// Everything comes from the float64 reference. Angles are degrees from the normal.
#[derive(Args, Debug)]
pub struct PlotArgs {
    #[command(subcommand)]
    kind: Kind,
}

#[derive(Debug, Subcommand)]
enum Kind {
    /// How much a smooth boundary reflects, against the angle
    Fresnel {
        /// A dielectric's index, the far side's over the near side's
        #[arg(long, value_name = "ETA", value_parser = index, conflicts_with_all = ["metal", "subject"])]
        eta: Option<f64>,
        /// A measured metal by its symbol, the exact reflectance beside the approximate one
        #[arg(long, value_name = "SYMBOL", value_parser = known_metal, conflicts_with = "subject")]
        metal: Option<&'static Metal>,
        #[command(flatten)]
        subject: SubjectArgs,
        #[command(flatten)]
        output: OutputArgs,
    },
    /// Polar curves of f cos in the plane of incidence, for several viewers
    Lobe {
        #[command(flatten)]
        subject: SubjectArgs,
        /// The viewers' angles
        #[arg(long, value_name = "DEG,...", value_delimiter = ',', default_value = "0,30,60,75", value_parser = elevation)]
        theta: Vec<f64>,
        /// Draw powers of ten in equal steps
        #[arg(long)]
        log: bool,
        /// The plane's angle from the tangent
        #[arg(long, value_name = "DEG", default_value_t = 0.0, value_parser = value::finite, allow_negative_numbers = true)]
        phi: f64,
        #[command(flatten)]
        output: OutputArgs,
    },
    /// The share of the light that leaves the surface
    Albedo {
        #[command(flatten)]
        subject: SubjectArgs,
        /// What runs along the axis
        #[arg(long, value_enum, default_value = "angle")]
        against: Against,
        /// Against the angle: a curve for each of these
        #[arg(long, value_name = "R,...", value_delimiter = ',', default_value = "0.1,0.3,0.5,0.7,1", value_parser = share)]
        roughness: Vec<f64>,
        /// Against the roughness: a curve for each of these angles
        #[arg(long, value_name = "DEG,...", value_delimiter = ',', default_value = "0,45,60,75,85", value_parser = elevation)]
        theta: Vec<f64>,
        #[command(flatten)]
        output: OutputArgs,
    },
    /// f over all directions of light for one viewer, as discs
    Sphere {
        #[command(flatten)]
        subject: SubjectArgs,
        /// The viewer's angle
        #[arg(long, value_name = "DEG", default_value_t = 45.0, value_parser = elevation)]
        theta: f64,
        /// The viewer's angle from the tangent
        #[arg(long, value_name = "DEG", default_value_t = 180.0, value_parser = value::finite, allow_negative_numbers = true)]
        phi: f64,
        #[command(flatten)]
        output: OutputArgs,
    },
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Against {
    Angle,
    Roughness,
}

/// Which material; at most one of the three.
#[derive(Args, Debug)]
#[group(id = "subject", multiple = true)]
struct SubjectArgs {
    /// A material of Snell's own
    #[arg(value_parser = presets(), conflicts_with_all = ["material", "from"])]
    preset: Option<String>,
    /// A file with one material as `snell bsdf` takes it
    #[arg(long, value_name = "FILE.json", conflicts_with = "from")]
    material: Option<PathBuf>,
    /// A .gltf or .glb file; its material without textures
    #[arg(long, value_name = "SCENE", requires = "name")]
    from: Option<PathBuf>,
    /// Which of the file's materials, by name or number from 0
    #[arg(long, value_name = "NAME|INDEX", requires = "from")]
    name: Option<String>,
}

#[derive(Args, Debug)]
struct OutputArgs {
    /// Where to: .svg or .png by ending; '-' is an SVG on standard output
    #[arg(short, long = "output", required = true, value_name = "OUT")]
    output: Vec<PathBuf>,
}

fn presets() -> PossibleValuesParser {
    let values = PRESETS
        .iter()
        .map(|preset| clap::builder::PossibleValue::new(preset.name).help(preset.about));
    PossibleValuesParser::new(values)
}

fn index(text: &str) -> Result<f64, String> {
    match value::finite(text)? {
        eta if eta > 0.0 => Ok(eta),
        _ => Err("an index is more than 0".into()),
    }
}

fn elevation(text: &str) -> Result<f64, String> {
    match value::finite(text)? {
        theta if (0.0..90.0).contains(&theta) => Ok(theta),
        _ => Err("give degrees from 0 to less than 90".into()),
    }
}

fn share(text: &str) -> Result<f64, String> {
    match value::finite(text)? {
        share if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err("give numbers from 0 to 1".into()),
    }
}

fn known_metal(symbol: &str) -> Result<&'static Metal, String> {
    metal(symbol).ok_or_else(|| {
        let symbols: Vec<&str> = METALS.iter().map(|metal| metal.symbol).collect();
        format!("there are {}", symbols.join(", "))
    })
}

/// Draws what was asked for.
pub fn run(args: &PlotArgs) -> Result<(), Error> {
    match &args.kind {
        Kind::Fresnel {
            eta,
            metal,
            subject,
            output,
        } => {
            let targets = targets(output)?;
            let figure = match (eta, metal) {
                (Some(eta), _) => FresnelFigure::Dielectric { eta: *eta },
                (None, Some(metal)) => FresnelFigure::metal(metal),
                (None, None) => FresnelFigure::of(&chosen(subject)?, &Reference::default())?,
            };
            write(&figure, &targets)
        }
        Kind::Lobe {
            subject,
            theta,
            log,
            phi,
            output,
        } => {
            let targets = targets(output)?;
            let radius = match log {
                true => Radius::Logarithmic,
                false => Radius::Linear,
            };
            let (subject, reference) = (chosen(subject)?, Reference::default());
            let figure = LobeFigure::new(&subject, &reference, theta, *phi, radius)?;
            write(&figure, &targets)
        }
        Kind::Albedo {
            subject,
            against,
            roughness,
            theta,
            output,
        } => {
            let targets = targets(output)?;
            let (subject, reference) = (chosen(subject)?, Reference::default());
            let figure = match against {
                Against::Angle => AlbedoFigure::over_angle(&subject, &reference, roughness)?,
                Against::Roughness => AlbedoFigure::over_roughness(&subject, &reference, theta)?,
            };
            write(&figure, &targets)
        }
        Kind::Sphere {
            subject,
            theta,
            phi,
            output,
        } => {
            let targets = targets(output)?;
            let figure = SphereFigure::new(&chosen(subject)?, &Reference::default(), *theta, *phi)?;
            write(&figure, &targets)
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Format {
    Svg,
    Png,
}

/// What is known to fail is found out before anything is computed.
fn targets(args: &OutputArgs) -> Result<Vec<(Place, Format)>, Error> {
    let targets: Result<Vec<_>, Error> = args.output.iter().map(|path| target(path)).collect();
    let targets = targets?;
    let places: Vec<&Place> = targets.iter().map(|(place, _)| place).collect();
    output::file::check(&places)?;
    Ok(targets)
}

fn target(path: &Path) -> Result<(Place, Format), Error> {
    let place = Place::of(path);
    let ending = path.extension().and_then(|ending| ending.to_str());
    let format = match (&place, ending.map(str::to_ascii_lowercase).as_deref()) {
        (Place::Stdout, _) | (_, Some("svg")) => Format::Svg,
        (_, Some("png")) => Format::Png,
        _ => {
            return Err(Error::Usage(format!(
                "the ending of '{}' says no format of plots; use .svg or .png, or '-' for an SVG on standard output",
                path.display()
            )));
        }
    };
    Ok((place, format))
}

fn write(figure: &impl Figure, targets: &[(Place, Format)]) -> Result<(), Error> {
    let mut outputs = Vec::new();
    for (place, format) in targets {
        let bytes = match format {
            Format::Svg => page::svg(figure)?.into_bytes(),
            Format::Png => page::png(figure)?,
        };
        outputs.push((place, bytes));
    }
    let outputs: Vec<(&Place, &[u8])> = outputs
        .iter()
        .map(|(place, bytes)| (*place, bytes.as_slice()))
        .collect();
    Ok(output::file::write_all(&outputs)?)
}

/// The material asked for.
fn chosen(args: &SubjectArgs) -> Result<Subject, Error> {
    if let Some(path) = &args.material {
        return from_json(path);
    }
    if let (Some(path), Some(name)) = (&args.from, &args.name) {
        return from_scene(path, name);
    }
    args.preset.as_deref().and_then(Subject::preset).ok_or_else(|| {
        Error::Usage("say what to plot: a preset (see --help), --material FILE.json, or --from SCENE --name MATERIAL".into())
    })
}

fn from_json(path: &Path) -> Result<Subject, Error> {
    let bytes = std::fs::read(path).map_err(|source| Error::Input {
        path: path.to_owned(),
        source,
    })?;
    let material: Value = serde_json::from_slice(&bytes).map_err(|error| PlotError::Json {
        path: path.to_owned(),
        reason: error.to_string(),
    })?;
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let name = material.get("name").and_then(Value::as_str);
    Ok(Subject::new(name.unwrap_or(&stem).to_owned(), material))
}

/// A material of a scene; as a figure is of one point, without its textures.
fn from_scene(path: &Path, choice: &str) -> Result<Subject, Error> {
    let mut materials = gltf::material_objects(path, &LoadOptions::default())?;
    // A name wins over a number, as for cameras.
    let index = materials
        .iter()
        .position(|(name, _)| name == choice)
        .or_else(|| choice.parse().ok().filter(|&i| i < materials.len()))
        .ok_or_else(|| {
            let names: Vec<String> = materials
                .iter()
                .enumerate()
                .map(|(i, (name, _))| format!("{i} '{name}'"))
                .collect();
            Error::Usage(match names.is_empty() {
                true => format!("there is no material '{choice}': the scene has none"),
                false => format!(
                    "there is no material '{choice}'; the scene has {}",
                    names.join(", ")
                ),
            })
        })?;
    let (name, mut material) = materials.swap_remove(index);
    let mut textures = Vec::new();
    remove_textures(&mut material, &mut textures);
    if !textures.is_empty() {
        let textures = textures.join(", ");
        super::say(&format!(
            "'{name}' is plotted by its factors alone; it also has {textures}"
        ));
    }
    Ok(Subject::new(name, material))
}

/// Takes out every property that is a texture; glTF names them all `...Texture`.
fn remove_textures(value: &mut Value, removed: &mut Vec<String>) {
    if let Value::Object(object) = value {
        object.retain(|name, _| {
            let texture = name.ends_with("Texture");
            if texture {
                removed.push(name.clone());
            }
            !texture
        });
        for (name, value) in object {
            if name != "extras" {
                remove_textures(value, removed);
            }
        }
    }
}
