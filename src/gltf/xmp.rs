//! KHR_xmp_json_ld: what a file says about itself, kept as it is.

use serde::Serialize;

/// A packet of XMP metadata.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Metadata {
    /// Where in the glTF JSON it stands.
    pub at: String,
    /// The objects that it is about, by their places; the file itself is `asset`.
    pub about: Vec<String>,
    /// JSON-LD.
    pub packet: serde_json::Value,
}
