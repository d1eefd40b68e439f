//! All outputs or none: files are written whole under temporary names beside their places, and
//! renamed only when every one of them is there.

use std::collections::HashSet;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

use super::{OutputError, Place};

/// Finds out before a render what would only be found out after it: places named twice, folders that
/// are missing or cannot be written to. Each folder is tried once: a sequence has many places in one.
pub fn check(places: &[&Place]) -> Result<(), OutputError> {
    let mut named = HashSet::new();
    let mut tried = HashSet::new();
    for place in places {
        if !named.insert(place) {
            return Err(OutputError::Twice(match place {
                Place::Stdout => PathBuf::from("-"),
                Place::File(path) => path.clone(),
            }));
        }
        if let Place::File(path) = place {
            if path.is_dir() {
                return Err(OutputError::IsFolder(path.clone()));
            }
            let folder = folder(&resolved(path));
            if !tried.contains(&folder) {
                temporary(&folder).map_err(|source| OutputError::Folder {
                    path: path.clone(),
                    source,
                })?;
                tried.insert(folder);
            }
        }
    }
    Ok(())
}

/// Writes them all. On an error no new file is left behind and no old one was touched, save when
/// the system refuses a rename after it took the renames before it.
pub fn write_all(outputs: &[(&Place, &[u8])]) -> Result<(), OutputError> {
    let mut waiting = Vec::new();
    for (place, bytes) in outputs {
        if let Place::File(path) = place {
            let written = temporary(&folder(&resolved(path))).and_then(|mut file| {
                file.write_all(bytes)?;
                file.as_file().sync_all()?;
                Ok(file)
            });
            match written {
                Ok(file) => waiting.push((file, path)),
                Err(source) => return Err(write_error(path, source)),
            }
        }
    }
    for (place, bytes) in outputs {
        if **place == Place::Stdout {
            let mut stdout = io::stdout().lock();
            match stdout.write_all(bytes).and_then(|()| stdout.flush()) {
                // The reader has seen enough, as `| head -c` does.
                Err(e) if e.kind() == io::ErrorKind::BrokenPipe => {}
                result => result.map_err(OutputError::Stdout)?,
            }
        }
    }
    for (file, path) in waiting {
        file.persist(resolved(path))
            .map_err(|e| write_error(path, e.error))?;
    }
    Ok(())
}

fn write_error(path: &Path, source: io::Error) -> OutputError {
    OutputError::Write {
        path: path.to_owned(),
        source,
    }
}

/// A file in a folder that vanishes when dropped.
fn temporary(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = Builder::new();
    builder.prefix(".snell-").suffix(".part");
    // Temporary files are for their owner alone; pictures are as open as the umask lets them be.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

/// The one that a file is in.
fn folder(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Where a symbolic link points to, so that the link stays a link; else the path itself.
fn resolved(path: &Path) -> PathBuf {
    match path.symlink_metadata() {
        Ok(meta) if meta.is_symlink() => path.canonicalize().unwrap_or_else(|_| path.to_owned()),
        _ => path.to_owned(),
    }
}
