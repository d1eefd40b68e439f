//! From a film to files: which format, what it holds, and how it gets there without ever leaving
//! half a file.

pub mod display;
pub mod exr;
pub mod file;
pub mod tonemap;

use std::path::{Path, PathBuf};

use crate::film::Film;
use tonemap::Tonemap;

#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    #[error(
        "the ending of '{0}' says no picture format; use .png, .exr, .hdr, .jpg or .webp, or '-' for a PNG on standard output"
    )]
    UnknownEnding(PathBuf),
    #[error("'{0}' is named as an output more than once; give each output a name of its own")]
    Twice(PathBuf),
    #[error("cannot write '{path}': {source}; name a folder that exists and may be written to")]
    Folder {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("cannot write '{0}': it is a folder; name a file")]
    IsFolder(PathBuf),
    #[error("cannot write '{path}': {source}; nothing was left in its place")]
    Write {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("cannot write to standard output: {0}")]
    Stdout(std::io::Error),
    #[error("cannot encode the picture as {format}: {reason}; choose another format by the ending")]
    Encode {
        format: &'static str,
        reason: String,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Exr,
    Hdr,
    Png,
    Jpeg,
    Webp,
}

impl Format {
    pub fn name(self) -> &'static str {
        match self {
            Format::Exr => "OpenEXR",
            Format::Hdr => "Radiance HDR",
            Format::Png => "PNG",
            Format::Jpeg => "JPEG",
            Format::Webp => "WebP",
        }
    }

    fn of_ending(path: &Path) -> Result<Format, OutputError> {
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        match ending.to_ascii_lowercase().as_str() {
            "exr" => Ok(Format::Exr),
            "hdr" => Ok(Format::Hdr),
            "png" => Ok(Format::Png),
            "jpg" | "jpeg" => Ok(Format::Jpeg),
            "webp" => Ok(Format::Webp),
            _ => Err(OutputError::UnknownEnding(path.to_owned())),
        }
    }
}

/// Where an output goes.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Place {
    Stdout,
    File(PathBuf),
}

impl Place {
    /// `-` is standard output.
    pub fn of(path: &Path) -> Place {
        if path.as_os_str() == "-" {
            Place::Stdout
        } else {
            Place::File(path.to_owned())
        }
    }
}

/// One `-o`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Target {
    pub place: Place,
    pub format: Format,
}

impl Target {
    /// `-` is a PNG on standard output; anything else is a file whose ending says the format.
    pub fn parse(path: &Path) -> Result<Target, OutputError> {
        let place = Place::of(path);
        let format = match place {
            Place::Stdout => Format::Png,
            Place::File(_) => Format::of_ending(path)?,
        };
        Ok(Target { place, format })
    }
}

/// What a picture format gets beside the colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Channels {
    /// Coverage goes to the alpha channel (straight in PNG and WebP, associated in EXR).
    pub transparent: bool,
    /// `variance.R`, `.G`, `.B`: variance of the mean; EXR only.
    pub variance: bool,
    /// `samples`: how many samples a pixel's mean is of; EXR only.
    pub samples: bool,
}

/// How a picture is shown; only formats for displays (PNG, JPEG, WebP) look at it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// Stops, applied before the tone map.
    pub exposure_ev: f64,
    pub tonemap: Tonemap,
}

/// Which part of the whole picture the film is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    pub full_size: [u32; 2],
    pub origin: [u32; 2],
}

impl Window {
    /// The film is all there is.
    pub fn whole(film: &Film) -> Window {
        Window {
            full_size: [film.width, film.height],
            origin: [0, 0],
        }
    }
}

/// The bytes of a file. The same film gives the same bytes: nothing of the time or place goes in.
/// `facts` is a JSON text for formats that have room for it (EXR, attribute `snell`).
pub fn encode(
    film: &Film,
    format: Format,
    channels: Channels,
    look: Look,
    window: Window,
    facts: &str,
) -> Result<Vec<u8>, OutputError> {
    match format {
        Format::Exr => exr::encode(film, channels, window, facts),
        Format::Hdr => display::hdr(film),
        Format::Png => display::png(film, channels, look),
        Format::Jpeg => display::jpeg(film, look),
        Format::Webp => display::webp(film, channels, look),
    }
}
