//! Buffers and buffer views: byte ranges, all checked against what is really there.

use super::error::GltfError;
use super::json::Json;
use super::meshopt;
use super::source::Source;
use rayon::prelude::*;

/// The bytes of every buffer; `None` for one that has neither a URI nor the GLB's binary chunk, or
/// that nothing is read from.
pub struct Buffers {
    bytes: Vec<Option<Vec<u8>>>,
    /// Of every buffer view, where it is compressed.
    decoded: Vec<Option<Vec<u8>>>,
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
                // All that it holds is decoded instead, and it need not be there.
                Some(_) if cfg!(feature = "meshopt") && meshopt::is_fallback(buffer)? => None,
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
        let mut buffers = Self {
            bytes,
            decoded: Vec::new(),
        };
        let views = root.objects("bufferViews")?;
        let decoded: Vec<_> = views
            .par_iter()
            .map(|view| buffers.decode(view, source))
            .collect();
        // The first error in the order of the file, whichever thread was faster.
        buffers.decoded = decoded.into_iter().collect::<Result<_, _>>()?;
        Ok(buffers)
    }

    #[cfg(feature = "meshopt")]
    fn decode(&self, view: &Json<'_>, source: &Source) -> Result<Option<Vec<u8>>, GltfError> {
        let Some((_, extension)) = meshopt::extension(view)? else {
            return Ok(None);
        };
        let take = |bytes| source.budget.take(bytes, extension.file(), &extension.at);
        let compressed = self.range(&extension)?;
        meshopt::decode(view, &extension, compressed, take).map(Some)
    }

    /// Without the decoder, a view holds its fallback.
    #[cfg(not(feature = "meshopt"))]
    fn decode(&self, view: &Json<'_>, _: &Source) -> Result<Option<Vec<u8>>, GltfError> {
        let Some((name, _)) = meshopt::extension(view)? else {
            return Ok(None);
        };
        let (index, _) = view.required("buffer")?.follow("buffers")?;
        match self.bytes.get(index) {
            Some(Some(_)) => Ok(None),
            _ => Err(view.missing_feature(name, meshopt::FEATURE)),
        }
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
        let Some((number, view)) = user.reference(key, "bufferViews")? else {
            return Ok(None);
        };
        let bytes = match self.decoded.get(number) {
            Some(Some(decoded)) => decoded,
            _ => self.range(&view)?,
        };
        let stride = match view.uint("byteStride")? {
            None | Some(0) => None,
            // glTF 2.0 section 5.11.4.
            Some(stride @ 1..=252) => Some(stride as usize),
            Some(stride) => {
                return Err(view.invalid(format!("byteStride is {stride}, more than 252")));
            }
        };
        Ok(Some(View { bytes, stride }))
    }

    /// The bytes that `buffer`, `byteOffset` and `byteLength` of an object name.
    fn range(&self, object: &Json<'_>) -> Result<&[u8], GltfError> {
        let (index, buffer) = object.required("buffer")?.follow("buffers")?;
        let offset = object.uint("byteOffset")?.unwrap_or(0);
        let length = object.required("byteLength")?.as_uint()?;
        let Some(data) = self.bytes.get(index).and_then(Option::as_deref) else {
            return Err(buffer.invalid("it has no uri and the file has no binary chunk for it"));
        };
        let end = offset
            .checked_add(length)
            .filter(|&end| end <= data.len() as u64);
        match end {
            Some(end) => Ok(&data[offset as usize..end as usize]),
            None => Err(object.invalid(format!(
                "{length} bytes from byte {offset} do not fit into {} of {} bytes",
                buffer.at,
                data.len()
            ))),
        }
    }
}
