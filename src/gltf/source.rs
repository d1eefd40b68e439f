//! The bytes that a scene is made of: the file itself, its neighbours, data: URIs; all under a
//! memory ceiling and none from outside the allowed folders.

use super::LoadOptions;
use super::error::GltfError;
use super::json::{Document, Json};
use base64::Engine as _;
use std::io::Read as _;
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// What has been taken of the memory that a scene may use, in bytes.
pub struct Budget {
    limit: u64,
    used: AtomicU64,
}

impl Budget {
    pub fn new(limit: u64) -> Self {
        Self {
            limit,
            used: AtomicU64::new(0),
        }
    }

    pub fn used(&self) -> u64 {
        self.used.load(Ordering::Relaxed)
    }

    /// Gives back what was taken beyond `used`.
    pub fn rewind(&self, used: u64) {
        self.used.fetch_min(used, Ordering::Relaxed);
    }

    pub fn left(&self) -> u64 {
        self.limit.saturating_sub(self.used())
    }

    /// Asked before memory is allocated for `bytes` bytes.
    pub fn take(&self, bytes: u64, file: &Path, at: &str) -> Result<(), GltfError> {
        self.used
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |used| {
                used.checked_add(bytes).filter(|&used| used <= self.limit)
            })
            .map(|_| ())
            .map_err(|used| GltfError::OverMemory {
                file: file.to_owned(),
                at: at.to_owned(),
                needed: bytes,
                left: self.limit.saturating_sub(used),
                limit: self.limit,
            })
    }
}

/// Folders that may be read, and the budget.
pub struct Source {
    folder: PathBuf,
    allowed: Vec<PathBuf>,
    pub budget: Budget,
}

impl Source {
    pub fn new(scene: &Path, options: &LoadOptions) -> Self {
        let folder = match scene.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
            _ => PathBuf::from("."),
        };
        // A folder that cannot be resolved allows nothing: the file itself will say why.
        let allowed = std::iter::once(&folder)
            .chain(&options.allow_paths)
            .filter_map(|path| path.canonicalize().ok())
            .collect();
        Self {
            folder,
            allowed,
            budget: Budget::new(options.max_memory),
        }
    }

    fn read(&self, path: &Path, uri: &Json<'_>) -> Result<Vec<u8>, GltfError> {
        read_file(path, uri.file(), &uri.at, &self.budget)
    }

    /// The bytes behind the string property `uri` of a buffer or an image.
    pub fn resolve(&self, uri: &Json<'_>) -> Result<Vec<u8>, GltfError> {
        let text = uri.as_string()?;
        match text.get(..5) {
            Some(scheme) if scheme.eq_ignore_ascii_case("data:") => self.data_uri(uri, &text[5..]),
            _ => self.read(&self.locate(uri, text)?, uri),
        }
    }

    /// RFC 2397: `[media type][;base64],data`.
    fn data_uri(&self, uri: &Json<'_>, rest: &str) -> Result<Vec<u8>, GltfError> {
        let (header, data) = rest
            .split_once(',')
            .ok_or_else(|| uri.invalid("the data: URI has no comma before its data"))?;
        self.budget.take(data.len() as u64, uri.file(), &uri.at)?;
        let decoded = percent_encoding::percent_decode_str(data);
        if !header.to_ascii_lowercase().ends_with(";base64") {
            return Ok(decoded.collect());
        }
        let text: Vec<u8> = decoded.filter(|byte| !byte.is_ascii_whitespace()).collect();
        let engine = base64::engine::GeneralPurpose::new(
            &base64::alphabet::STANDARD,
            base64::engine::GeneralPurposeConfig::new()
                .with_decode_padding_mode(base64::engine::DecodePaddingMode::Indifferent)
                .with_decode_allow_trailing_bits(true),
        );
        engine
            .decode(&text)
            .map_err(|error| uri.invalid(format!("the data: URI is not valid base64: {error}")))
    }

    /// The file that a relative URI means, which must lie in an allowed folder after all symbolic
    /// links have been followed.
    fn locate(&self, uri: &Json<'_>, text: &str) -> Result<PathBuf, GltfError> {
        let forbidden = |what: String| GltfError::Forbidden {
            file: uri.file().to_owned(),
            at: uri.at.clone(),
            what,
        };
        if let Some(scheme) = scheme(text) {
            return Err(uri.invalid(format!(
                "`{scheme}:` URLs are not read, only files beside the scene and data: URIs"
            )));
        }
        let decoded = percent_encoding::percent_decode_str(text)
            .decode_utf8()
            .map_err(|_| uri.invalid("the URI is not UTF-8 once percent-decoded"))?;
        if decoded.contains('\0') {
            return Err(uri.invalid("the URI holds a zero byte"));
        }
        // Some exporters write Windows' separators.
        let relative = PathBuf::from(decoded.replace('\\', "/"));
        let path = self.folder.join(&relative);
        let resolved = path.canonicalize();
        let escapes = relative
            .components()
            .any(|part| !matches!(part, Component::Normal(_) | Component::CurDir));
        let inside = match &resolved {
            Ok(resolved) => self
                .allowed
                .iter()
                .any(|folder| resolved.starts_with(folder)),
            // What does not exist is told apart from what is forbidden only inside the folder.
            Err(_) => !escapes,
        };
        // An escape is allowed only by a folder that was allowed by name.
        let by_name = match &resolved {
            Ok(resolved) => self
                .allowed
                .iter()
                .skip(1)
                .any(|folder| resolved.starts_with(folder)),
            Err(_) => false,
        };
        if !inside || (escapes && !by_name) {
            return Err(forbidden(format!(
                "`{decoded}` lies outside the folders that may be read"
            )));
        }
        resolved.map_err(|error| GltfError::Unreadable {
            file: uri.file().to_owned(),
            at: uri.at.clone(),
            what: format!("{} cannot be read: {error}", path.display()),
        })
    }
}

/// Reads a whole regular file; `scene` and `at` say who asks for it.
pub fn read_file(
    path: &Path,
    scene: &Path,
    at: &str,
    budget: &Budget,
) -> Result<Vec<u8>, GltfError> {
    let unreadable = |error: std::io::Error| GltfError::Unreadable {
        file: scene.to_owned(),
        at: at.to_owned(),
        what: if path == scene {
            format!("the file cannot be read: {error}")
        } else {
            format!("{} cannot be read: {error}", path.display())
        },
    };
    // Asked before opening: opening a pipe would wait for its writer.
    let metadata = std::fs::metadata(path).map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(unreadable(std::io::Error::other(
            "it is not a regular file",
        )));
    }
    budget.take(metadata.len(), scene, at)?;
    let mut bytes = Vec::new();
    std::fs::File::open(path)
        .map_err(unreadable)?
        // The file may grow after its size was taken.
        .take(metadata.len())
        .read_to_end(&mut bytes)
        .map_err(unreadable)?;
    Ok(bytes)
}

/// RFC 3986, section 3.1. A single letter is left to the path check (a Windows drive).
fn scheme(text: &str) -> Option<&str> {
    let (scheme, _) = text.split_once(':')?;
    let mut bytes = scheme.bytes();
    let valid = bytes.next()?.is_ascii_alphabetic()
        && bytes.all(|byte| byte.is_ascii_alphanumeric() || b"+-.".contains(&byte));
    valid.then_some(scheme)
}

/// Reads and parses a scene file: GLB, with its binary chunk, where it begins with GLB's magic, JSON
/// otherwise.
pub fn open(path: &Path, source: &Source) -> Result<(Document, Option<Vec<u8>>), GltfError> {
    let bytes = read_file(path, path, "", &source.budget)?;
    let invalid = |what: String| GltfError::Invalid {
        file: path.to_owned(),
        at: String::new(),
        what,
    };
    let (json, bin) = if bytes.starts_with(b"glTF") {
        split_glb(&bytes).map_err(invalid)?
    } else {
        (bytes.as_slice(), None)
    };
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    // Each value and each key of the tree is led by one of these, and takes this much at worst.
    const NODE: u64 = 64;
    let nodes = json.iter().filter(|byte| b",:[{".contains(byte)).count() as u64;
    source
        .budget
        .take(json.len() as u64 + nodes * NODE, path, "")?;
    let root: serde_json::Value = serde_json::from_slice(json)
        .map_err(|error| invalid(format!("this is neither glTF's JSON nor a GLB: {error}")))?;
    if !root.is_object() {
        return Err(invalid("the JSON is not an object".to_owned()));
    }
    let document = Document {
        path: path.to_owned(),
        root,
    };
    Ok((document, bin.map(<[u8]>::to_vec)))
}

/// glTF 2.0 section 4.4: a header of three words, then chunks of length, type and data.
fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    const HEADER: usize = 12;
    const JSON: u32 = u32::from_le_bytes(*b"JSON");
    const BIN: u32 = u32::from_le_bytes(*b"BIN\0");
    let word = |at: usize| -> Option<u32> {
        let bytes = bytes.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes(bytes.try_into().ok()?))
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(format!(
            "the GLB is cut off in its header, at {} bytes",
            bytes.len()
        ));
    };
    if version != 2 {
        return Err(format!("the GLB's container version is {version}, not 2"));
    }
    if (length as usize) < HEADER || length as usize > bytes.len() {
        return Err(format!(
            "the GLB says that it is {length} bytes long and is {}: it is cut off or damaged",
            bytes.len()
        ));
    }
    let end = length as usize;
    let mut chunks = Vec::new();
    let mut at = HEADER;
    while at < end && chunks.len() < 2 {
        let (Some(size), Some(kind)) = (word(at), word(at + 4)) else {
            return Err(format!(
                "the GLB is cut off in a chunk's header at byte {at}"
            ));
        };
        let first = at + 8;
        let data = first
            .checked_add(size as usize)
            .filter(|&last| last <= end)
            .map(|last| &bytes[first..last])
            .ok_or_else(|| {
                format!("the GLB's chunk at byte {at} says {size} bytes, more than there are")
            })?;
        chunks.push((kind, data));
        at = first + size as usize;
    }
    match chunks.as_slice() {
        [(JSON, json)] => Ok((json, None)),
        [(JSON, json), (BIN, bin)] => Ok((json, Some(bin))),
        // Unknown chunks are to be ignored.
        [(JSON, json), _] => Ok((json, None)),
        _ => Err("the GLB's first chunk is not JSON".to_owned()),
    }
}
