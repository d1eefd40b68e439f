//! Buffers and buffer views: byte ranges, all checked against what is really there.

use super::error::GltfError;
use super::json::Json;
use super::source::Source;

/// The bytes of every buffer; `None` for one that has neither a URI nor the GLB's binary chunk.
pub struct Buffers {
    bytes: Vec<Option<Vec<u8>>>,
}

/// A range of a buffer, and the distance from one element to the next where it is given.
pub struct View<'b> {
    pub bytes: &'b [u8],
    pub stride: Option<usize>,
}

impl Buffers {
    /// `bin` is a GLB's binary chunk.
    pub fn load(
        root: &Json<'_>,
        mut bin: Option<Vec<u8>>,
        source: &Source,
    ) -> Result<Self, GltfError> {
        let mut bytes = Vec::new();
        for (index, buffer) in root.objects("buffers")?.iter().enumerate() {
            let length = buffer.required("byteLength")?.as_uint()?;
            let mut data = match buffer.get("uri") {
                Some(uri) => Some(source.resolve(&uri)?),
                None if index == 0 => bin.take(),
                None => None,
            };
            if let Some(data) = &data
                && (data.len() as u64) < length
            {
                return Err(buffer.invalid(format!(
                    "byteLength is {length} and only {} bytes are there",
                    data.len()
                )));
            }
            if let Some(data) = &mut data {
                data.truncate(length as usize);
            }
            bytes.push(data);
        }
        Ok(Self { bytes })
    }

    /// All bytes that were read, for the record.
    pub fn total(&self) -> u64 {
        self.bytes
            .iter()
            .flatten()
            .map(|data| data.len() as u64)
            .sum()
    }

    /// The view that the property `key` of `user` refers to.
    pub fn view(&self, user: &Json<'_>, key: &str) -> Result<Option<View<'_>>, GltfError> {
        let Some((_, view)) = user.reference(key, "bufferViews")? else {
            return Ok(None);
        };
        let (index, buffer) = view.required("buffer")?.follow("buffers")?;
        let offset = view.uint("byteOffset")?.unwrap_or(0);
        let length = view.required("byteLength")?.as_uint()?;
        let Some(data) = self.bytes.get(index).and_then(Option::as_deref) else {
            for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
                if view.extension(name)?.is_some() {
                    return Err(view.unsupported_extension(name));
                }
            }
            return Err(buffer.invalid("it has no uri and the file has no binary chunk for it"));
        };
        let end = offset
            .checked_add(length)
            .filter(|&end| end <= data.len() as u64);
        let Some(end) = end else {
            return Err(view.invalid(format!(
                "{length} bytes from byte {offset} do not fit into {} of {} bytes",
                buffer.at,
                data.len()
            )));
        };
        let stride = match view.uint("byteStride")? {
            None | Some(0) => None,
            // glTF 2.0 section 5.11.4.
            Some(stride @ 1..=252) => Some(stride as usize),
            Some(stride) => {
                return Err(view.invalid(format!("byteStride is {stride}, more than 252")));
            }
        };
        Ok(Some(View {
            bytes: &data[offset as usize..end as usize],
            stride,
        }))
    }
}
