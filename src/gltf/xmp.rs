//! KHR_xmp_json_ld: what a file says about itself, kept as it is.

use super::error::GltfError;
use super::json::Json;
use serde::Serialize;
use serde_json::Value;

const NAME: &str = "KHR_xmp_json_ld";

/// A packet of XMP metadata.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Metadata {
    /// Where in the glTF JSON it stands.
    pub at: String,
    /// The objects that it is about, by their places; the file as a whole is `asset`.
    pub about: Vec<String>,
    /// JSON-LD.
    pub packet: Value,
}

/// All packets of a file, with the objects that refer to them.
pub fn metadata(root: &Json<'_>) -> Result<Vec<Metadata>, GltfError> {
    let Some(extension) = root.extension(NAME)? else {
        return Ok(Vec::new());
    };
    let mut packets: Vec<Metadata> = extension
        .objects("packets")?
        .into_iter()
        .map(|packet| Metadata {
            packet: packet.value().clone(),
            at: packet.at,
            about: Vec::new(),
        })
        .collect();
    // The parser has bounded the depth. The order is that of the file's sections by name.
    let mut objects = vec![root.clone()];
    while let Some(json) = objects.pop() {
        if json.at != extension.at && !json.at.is_empty() {
            refer(&json, &mut packets)?;
        }
        let inner = json.children().into_iter().rev();
        objects.extend(inner.filter(|inner| {
            let name = inner.at.rsplit('.').next();
            !matches!(name, Some("extras" | NAME))
        }));
    }
    Ok(packets)
}

/// Enters an object with the packet that it names.
fn refer(json: &Json<'_>, packets: &mut [Metadata]) -> Result<(), GltfError> {
    let Some(extensions) = json
        .get("extensions")
        .filter(|json| json.value().is_object())
    else {
        return Ok(());
    };
    let Some(reference) = extensions.object(NAME)? else {
        return Ok(());
    };
    let packet = reference.required("packet")?;
    let number = packet.as_uint()?;
    let count = packets.len();
    let found = usize::try_from(number)
        .ok()
        .and_then(|number| packets.get_mut(number));
    match found {
        Some(found) => found.about.push(json.at.clone()),
        None => {
            return Err(packet.invalid(format!(
                "{number} is out of range: there are {count} packets"
            )));
        }
    }
    Ok(())
}
