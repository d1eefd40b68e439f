//! What can be wrong with a glTF file, and what to do about it.

use std::path::PathBuf;

/// A file could not become a scene. Each message says what is wrong, in which file, at which place
/// of the glTF JSON (`at`, such as `accessors[4].bufferView`), and what to do.
#[derive(Debug, thiserror::Error)]
pub enum GltfError {
    /// A file is missing, is no regular file, or the system refuses to read it.
    #[error("{}: {what}; check the path and its permissions", place(file, at))]
    Unreadable {
        file: PathBuf,
        at: String,
        what: String,
    },
    /// The file breaks a rule of glTF 2.0 that its picture depends on.
    #[error("{}: {what}; repair the file or export it again", place(file, at))]
    Invalid {
        file: PathBuf,
        at: String,
        what: String,
    },
    /// A URI leads out of the file's own folder.
    #[error(
        "{}: {what}; keep the file inside the scene's folder, or allow its folder with --allow-path",
        place(file, at)
    )]
    Forbidden {
        file: PathBuf,
        at: String,
        what: String,
    },
    /// The file cannot be drawn without an extension that Snell does not know.
    #[error(
        "{}: {name} is required and not supported; export the file without it",
        place(file, at)
    )]
    UnsupportedExtension {
        file: PathBuf,
        at: String,
        name: String,
    },
    /// The file cannot be drawn without an extension that this build has left out.
    #[error(
        "{}: {name} is required and this build is without it; build Snell with the cargo feature \
         `{feature}`, or export the file without it",
        place(file, at)
    )]
    MissingFeature {
        file: PathBuf,
        at: String,
        name: String,
        feature: &'static str,
    },
    /// The scene would take more memory than allowed.
    #[error(
        "{}: {needed} bytes are needed and {left} are left of the {limit} allowed; \
         make the scene smaller or raise --max-memory",
        place(file, at)
    )]
    OverMemory {
        file: PathBuf,
        at: String,
        needed: u64,
        left: u64,
        limit: u64,
    },
}

impl GltfError {
    /// The exit status of the program: 3 invalid input, 4 unsupported feature, 6 over a limit.
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Unreadable { .. } | Self::Invalid { .. } | Self::Forbidden { .. } => 3,
            Self::UnsupportedExtension { .. } | Self::MissingFeature { .. } => 4,
            Self::OverMemory { .. } => 6,
        }
    }

    /// Where in the glTF JSON, such as `accessors[4].bufferView`; empty for the file as a whole.
    pub fn at(&self) -> &str {
        match self {
            Self::Unreadable { at, .. }
            | Self::Invalid { at, .. }
            | Self::Forbidden { at, .. }
            | Self::UnsupportedExtension { at, .. }
            | Self::MissingFeature { at, .. }
            | Self::OverMemory { at, .. } => at,
        }
    }
}

fn place(file: &std::path::Path, at: &str) -> String {
    if at.is_empty() {
        file.display().to_string()
    } else {
        format!("{}: {at}", file.display())
    }
}
