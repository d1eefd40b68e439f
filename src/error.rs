//! Everything that can end a run, and the exit status that it ends with.

use std::path::PathBuf;

use crate::gltf::{ExtensionUse, GltfError};
use crate::gpu::device::DeviceError;
use crate::gpu::render::RenderError;
use crate::gpu::upload::UploadError;
use crate::lab::LabError;
use crate::output::OutputError;
use crate::pack::PackError;
use crate::plot::PlotError;

#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Arguments that parse and make no sense together.
    #[error("{0}")]
    Usage(String),
    #[error("cannot write to standard output: {0}")]
    Stdout(std::io::Error),
    #[error("cannot read '{path}': {source}")]
    Input {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("the intrinsics {path}: {message}")]
    Intrinsics { path: PathBuf, message: String },
    #[error(
        "'{scene}' uses what is ignored: {}; leave --strict away to render it all the same",
        list(ignored)
    )]
    Strict {
        scene: PathBuf,
        ignored: Vec<ExtensionUse>,
    },
    /// Of a sequence, whose frames before this one are there.
    #[error("frame {number}: {source} ({done} {} before it)", if *done == 1 { "frame was written" } else { "frames were written" })]
    Frame {
        number: u32,
        done: usize,
        source: Box<Error>,
    },
    #[error(
        "the picture needs {needed} bytes while it is made and --max-memory allows {allowed}; make it smaller, render it in parts with --crop, or raise --max-memory"
    )]
    FilmTooLarge { needed: u64, allowed: u64 },
    #[error(transparent)]
    Pack(#[from] PackError),
    #[error(transparent)]
    Gltf(#[from] GltfError),
    #[error(transparent)]
    Lab(#[from] LabError),
    #[error(transparent)]
    Plot(#[from] PlotError),
    #[error(transparent)]
    Device(#[from] DeviceError),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// Each with what it means and where it is.
fn list(extensions: &[ExtensionUse]) -> String {
    const PLACES: usize = 3;
    let one = |extension: &ExtensionUse| {
        let place = match extension.uses {
            0 => "required".to_owned(),
            _ => extension.places_text(PLACES),
        };
        format!("{} ({}; {place})", extension.name, extension.detail)
    };
    extensions.iter().map(one).collect::<Vec<_>>().join(", ")
}

impl Error {
    /// 2 wrong usage, 3 input invalid, 4 input needs an unsupported feature, 5 no adapter, 6 over a
    /// limit, 7 GPU failure, 8 output not written; 130 (interrupted) is the shell's own.
    pub fn exit_status(&self) -> u8 {
        match self {
            Error::Usage(_) => 2,
            Error::Stdout(_) => 8,
            Error::Input { .. } | Error::Intrinsics { .. } => 3,
            Error::Strict { .. } => 4,
            Error::FilmTooLarge { .. } => 6,
            Error::Frame { source, .. } => source.exit_status(),
            Error::Gltf(error) => error.exit_status(),
            Error::Pack(error) => match error {
                PackError::TooMany { .. } | PackError::TooManyKeys { .. } => 6,
                PackError::Folded { .. }
                | PackError::TooFar { .. }
                | PackError::TooDeep { .. }
                | PackError::Model { .. } => 3,
            },
            Error::Render(error) => match error {
                RenderError::Upload(
                    UploadError::TooLarge { .. }
                    | UploadError::EnvironmentTooLarge { .. }
                    | UploadError::OutOfMemory(_),
                )
                | RenderError::OutOfMemory(_) => 6,
                RenderError::Upload(UploadError::Device(_))
                | RenderError::Kernel(_)
                | RenderError::Lost(_)
                | RenderError::Failed(_) => 7,
            },
            Error::Lab(_) => 7,
            Error::Plot(error) => error.exit_status(),
            Error::Device(error) => match error {
                DeviceError::NoAdapter
                | DeviceError::NotFound { .. }
                | DeviceError::BelowDefaults { .. } => 5,
                DeviceError::Refused { .. } => 7,
            },
            Error::Output(error) => match error {
                OutputError::UnknownEnding(_) | OutputError::Twice(_) => 2,
                OutputError::Folder { .. }
                | OutputError::IsFolder(_)
                | OutputError::Write { .. }
                | OutputError::Stdout(_)
                | OutputError::Encode { .. } => 8,
            },
        }
    }
}
