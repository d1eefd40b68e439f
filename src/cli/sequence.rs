//! Which pictures are made and where each goes: one, or the frames of a sequence.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::render::RenderArgs;
use crate::error::Error;
use crate::output::{self, Format, Place, Target};

/// `--frames`: numbers and the time of each.
#[derive(Clone, Debug, PartialEq)]
pub struct Frames {
    pub numbers: Range<u32>,
    /// Frames a second as a fraction, so that those of 30000/1001 fall on their times.
    pub rate: [f64; 2],
}

impl Frames {
    /// Of a frame, in seconds.
    pub fn seconds(&self, number: u32) -> f64 {
        f64::from(number) * self.rate[1] / self.rate[0]
    }
}

/// A picture to make.
pub struct Shot {
    /// Its number in the sequence; `None`: it is the only one.
    pub frame: Option<u32>,
    /// When it is, if anything plays.
    pub seconds: f64,
    pub seed: u32,
    /// How far the camera is turned, in degrees.
    pub turn: Option<f64>,
    pub targets: Vec<Target>,
    pub report: Option<Place>,
}

/// All pictures of a run.
pub struct Sequence<'a> {
    args: &'a RenderArgs,
    outputs: Vec<Name>,
    report: Option<Name>,
}

impl<'a> Sequence<'a> {
    /// Checks all that can be known of the outputs before anything is read.
    pub fn plan(args: &'a RenderArgs) -> Result<Self, Error> {
        let name = |path: &PathBuf| match args.frames {
            Some(_) => Name::template(path),
            None => Ok(Name::Literal(path.clone())),
        };
        let sequence = Self {
            args,
            outputs: args.output.iter().map(name).collect::<Result<_, _>>()?,
            report: args.report.as_ref().map(name).transpose()?,
        };
        let first = sequence.shot(sequence.numbers().start)?;
        let exr = |target: &Target| target.format == Format::Exr;
        if !args.aov.is_empty() && !first.targets.iter().any(exr) {
            return Err(Error::Usage(
                "--aov needs an output that ends in .exr; no other format has room for further channels".into(),
            ));
        }
        let mut places = Vec::new();
        for number in sequence.numbers() {
            let shot = sequence.shot(number)?;
            places.extend(shot.targets.into_iter().map(|target| target.place));
            places.extend(shot.report);
        }
        output::file::check(&places.iter().collect::<Vec<_>>())?;
        Ok(sequence)
    }

    pub fn is_single(&self) -> bool {
        self.args.frames.is_none()
    }

    /// The frames' numbers; a single picture is number 0.
    pub fn numbers(&self) -> Range<u32> {
        match &self.args.frames {
            Some(frames) => frames.numbers.clone(),
            None => 0..1,
        }
    }

    pub fn shot(&self, number: u32) -> Result<Shot, Error> {
        /// 2^32 over the golden ratio: the seeds of two sequences that are numbered alike do not
        /// meet, as those of `--seed 0` and `--seed 1` would in steps of 1.
        const STEP: u32 = 0x9e37_79b9;
        let args = self.args;
        let paths = self.outputs.iter().map(|name| name.of(number));
        let targets = paths.map(|path| Ok(Target::parse(&path)?));
        let report = self.report.as_ref();
        Ok(Shot {
            frame: args.frames.as_ref().map(|_| number),
            seconds: match &args.frames {
                Some(frames) => frames.seconds(number),
                None => args.time.unwrap_or(0.0),
            },
            // Noise that stayed where it is would look like dirt on the lens.
            seed: args.seed.wrapping_add(number.wrapping_mul(STEP)),
            turn: args.turntable.map(|degrees| {
                let Range { start, end } = self.numbers();
                degrees * f64::from(number - start) / f64::from(end - start)
            }),
            targets: targets.collect::<Result<_, Error>>()?,
            report: report.map(|name| Place::of(&name.of(number))),
        })
    }
}

/// The name of an output.
enum Name {
    Literal(PathBuf),
    /// With the number in its middle, as wide as that at least, filled up by 0 or by spaces.
    Template {
        before: String,
        width: usize,
        zeros: bool,
        after: String,
    },
}

impl Name {
    /// Finds the one `{}`, `{:N}` or `{:0N}`.
    fn template(path: &Path) -> Result<Self, Error> {
        let fault = |what: &str| {
            Error::Usage(format!(
                "'{}' {what}; with --frames each name holds the frame's number once, as {{}} or, with zeros \
                 up to four digits, {{:04}}",
                path.display()
            ))
        };
        if path.as_os_str() == "-" {
            return Err(fault("is one place for many pictures"));
        }
        let text = path
            .to_str()
            .ok_or_else(|| fault("is not valid as Unicode"))?;
        let mut found = None;
        for (open, _) in text.match_indices('{') {
            let Some(length) = text[open..].find('}') else {
                break;
            };
            let Some((width, zeros)) = width(&text[open + 1..open + length]) else {
                continue;
            };
            let template = Self::Template {
                before: text[..open].to_owned(),
                width,
                zeros,
                after: text[open + length + 1..].to_owned(),
            };
            if found.replace(template).is_some() {
                return Err(fault("holds more than one place for a number"));
            }
        }
        found.ok_or_else(|| fault("holds no place for a number"))
    }

    fn of(&self, number: u32) -> PathBuf {
        match self {
            Self::Literal(path) => path.clone(),
            Self::Template {
                before,
                width,
                zeros: true,
                after,
            } => format!("{before}{number:0width$}{after}").into(),
            Self::Template {
                before,
                width,
                zeros: false,
                after,
            } => format!("{before}{number:width$}{after}").into(),
        }
    }
}

/// What stands between the braces: nothing, `:N` or `:0N`.
fn width(inner: &str) -> Option<(usize, bool)> {
    /// As long as names of files may be.
    const WIDEST: usize = 255;
    if inner.is_empty() {
        return Some((0, false));
    }
    let digits = inner.strip_prefix(':')?;
    let width = digits.parse().ok()?;
    let digits_only = digits.bytes().all(|b| b.is_ascii_digit());
    (digits_only && width <= WIDEST).then_some((width, digits.starts_with('0')))
}
