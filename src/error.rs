//! Everything that can end a run, and the exit status that it ends with.

use crate::gltf::GltfError;
use crate::gpu::device::DeviceError;
use crate::output::OutputError;

#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Arguments that parse and make no sense together.
    #[error("{0}")]
    Usage(String),
    #[error("cannot write to standard output: {0}")]
    Stdout(std::io::Error),
    #[error(transparent)]
    Gltf(#[from] GltfError),
    #[error(transparent)]
    Device(#[from] DeviceError),
    #[error(transparent)]
    Output(#[from] OutputError),
}

impl Error {
    /// 2 wrong usage, 3 input invalid, 4 input needs an unsupported feature, 5 no adapter, 6 over a
    /// limit, 7 GPU failure, 8 output not written; 130 (interrupted) is the shell's own.
    pub fn exit_status(&self) -> u8 {
        match self {
            Error::Usage(_) => 2,
            Error::Stdout(_) => 8,
            Error::Gltf(error) => error.exit_status(),
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
