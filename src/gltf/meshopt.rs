//! EXT_meshopt_compression and KHR_meshopt_compression: buffer views that are compressed. They
//! differ in what an encoder may write; both are read here in all that KHR's has, the first version
//! of its vertices and its filter of colours included.

use super::error::GltfError;
use super::json::Json;

/// The newer first: a view must not carry both.
pub const NAMES: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];
/// The cargo feature that decodes it.
pub const FEATURE: &str = "meshopt";

/// The extension's object in a buffer view or a buffer.
pub fn extension<'a>(json: &Json<'a>) -> Result<Option<(&'static str, Json<'a>)>, GltfError> {
    for name in NAMES {
        if let Some(extension) = json.extension(name)? {
            return Ok(Some((name, extension)));
        }
    }
    Ok(None)
}

/// Whether a buffer is there only for programs without the extension.
pub fn is_fallback(buffer: &Json<'_>) -> Result<bool, GltfError> {
    match extension(buffer)? {
        Some((_, extension)) => Ok(extension.boolean("fallback")?.unwrap_or(false)),
        None => Ok(false),
    }
}

#[cfg(feature = "meshopt")]
pub use decode::decode;

#[cfg(feature = "meshopt")]
mod decode {
    use super::GltfError;
    use super::Json;
    use meshopt::{decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat};

    /// What the extension's object says, checked as its section "JSON schema updates" asks.
    struct Layout {
        mode: Mode,
        filter: Filter,
        stride: usize,
        count: usize,
    }

    #[derive(Clone, Copy, Debug, PartialEq)]
    enum Mode {
        Attributes,
        Triangles,
        Indices,
    }

    #[derive(Clone, Copy, Debug, PartialEq)]
    enum Filter {
        None,
        Octahedral,
        Quaternion,
        Exponential,
        Color,
    }

    /// The bytes of a buffer view out of its compressed ones. `charge` is asked before they are
    /// allocated.
    pub fn decode(
        view: &Json<'_>,
        extension: &Json<'_>,
        compressed: &[u8],
        charge: impl Fn(u64) -> Result<(), GltfError>,
    ) -> Result<Vec<u8>, GltfError> {
        let layout = layout(view, extension)?;
        // Rows as they are decoded, and their bytes.
        const COPIES: u64 = 2;
        charge(COPIES * (layout.stride * layout.count) as u64)?;
        let damaged = |_| extension.invalid("the compressed data is damaged");
        let mut words = match (layout.mode, layout.stride) {
            (Mode::Attributes, stride) => attributes(compressed, stride / 4, layout.count),
            (Mode::Triangles, 2) => {
                meshopt::decode_index_buffer(compressed, layout.count).map(shorts)
            }
            (Mode::Triangles, _) => meshopt::decode_index_buffer(compressed, layout.count),
            (Mode::Indices, 2) => {
                meshopt::decode_index_sequence(compressed, layout.count).map(shorts)
            }
            (Mode::Indices, _) => meshopt::decode_index_sequence(compressed, layout.count),
        }
        .map_err(damaged)?;
        match (layout.filter, layout.stride) {
            (Filter::None, _) => {}
            (Filter::Octahedral, 4) => {
                decode_filter_oct(bytemuck::cast_slice_mut::<u32, [i8; 4]>(&mut words));
            }
            (Filter::Octahedral, _) => {
                decode_filter_oct(bytemuck::cast_slice_mut::<u32, [i16; 4]>(&mut words));
            }
            (Filter::Quaternion, _) => decode_filter_quat(bytemuck::cast_slice_mut(&mut words)),
            // Each component has its own exponent.
            (Filter::Exponential, _) => {
                decode_filter_exp(bytemuck::cast_slice_mut::<u32, [u32; 1]>(&mut words));
            }
            (Filter::Color, 4) => {
                decode_filter_color(bytemuck::cast_slice_mut::<u32, [u8; 4]>(&mut words));
            }
            (Filter::Color, _) => {
                decode_filter_color(bytemuck::cast_slice_mut::<u32, [u16; 4]>(&mut words));
            }
        }
        let mut bytes = bytemuck::cast_slice(&words).to_vec();
        // An odd number of short indices fills half of the last word.
        bytes.truncate(layout.stride * layout.count);
        Ok(bytes)
    }

    fn layout(view: &Json<'_>, extension: &Json<'_>) -> Result<Layout, GltfError> {
        let count = extension.required("count")?.as_uint()?;
        let stride_json = extension.required("byteStride")?;
        let stride = stride_json.as_uint()?;
        let length = view.required("byteLength")?.as_uint()?;
        if count.checked_mul(stride) != Some(length) {
            return Err(extension.invalid(format!(
                "{count} elements of {stride} bytes are not the {length} bytes of its bufferView"
            )));
        }
        let mode_json = extension.required("mode")?;
        let mode = match mode_json.as_string()? {
            "ATTRIBUTES" => Mode::Attributes,
            "TRIANGLES" => Mode::Triangles,
            "INDICES" => Mode::Indices,
            _ => return Err(mode_json.invalid("it is none of ATTRIBUTES, TRIANGLES and INDICES")),
        };
        let filter = match extension.string("filter")?.unwrap_or("NONE") {
            "NONE" => Filter::None,
            "OCTAHEDRAL" => Filter::Octahedral,
            "QUATERNION" => Filter::Quaternion,
            "EXPONENTIAL" => Filter::Exponential,
            "COLOR" => Filter::Color,
            other => return Err(extension.invalid(format!("there is no filter {other}"))),
        };
        let possible = match (mode, filter) {
            (Mode::Attributes, Filter::None | Filter::Exponential) => {
                stride.is_multiple_of(4) && (4..=256).contains(&stride)
            }
            (Mode::Attributes, Filter::Octahedral | Filter::Color) => matches!(stride, 4 | 8),
            (Mode::Attributes, Filter::Quaternion) => stride == 8,
            (_, Filter::None) => matches!(stride, 2 | 4),
            _ => return Err(extension.invalid(format!("{mode:?} have no filter"))),
        };
        if !possible {
            return Err(stride_json.invalid(format!(
                "{stride} is no stride of mode {mode:?} with filter {filter:?}"
            )));
        }
        if mode == Mode::Triangles && !count.is_multiple_of(3) {
            return Err(extension.invalid(format!("{count} indices are no whole triangles")));
        }
        Ok(Layout {
            mode,
            filter,
            stride: stride as usize,
            count: count as usize,
        })
    }

    fn shorts(indices: Vec<u16>) -> Vec<u32> {
        let pairs = indices.chunks(2).map(|pair| {
            let mut bytes = [0; 4];
            for (place, index) in bytes.chunks_exact_mut(2).zip(pair) {
                place.copy_from_slice(&index.to_ne_bytes());
            }
            u32::from_ne_bytes(bytes)
        });
        pairs.collect()
    }

    /// A vertex of N words, for the library asks for a type of the stride's size.
    #[derive(Clone)]
    struct Row<const N: usize>([u32; N]);

    impl<const N: usize> Default for Row<N> {
        fn default() -> Self {
            Self([0; N])
        }
    }

    fn rows<const N: usize>(compressed: &[u8], count: usize) -> meshopt::Result<Vec<u32>> {
        let rows = meshopt::decode_vertex_buffer::<Row<N>>(compressed, count)?;
        Ok(rows.iter().flat_map(|row| row.0).collect())
    }

    /// `stride` is in words, 1 to 64.
    fn attributes(compressed: &[u8], stride: usize, count: usize) -> meshopt::Result<Vec<u32>> {
        macro_rules! by_stride {
            ($($n:literal)*) => {
                match stride {
                    $($n => rows::<$n>(compressed, count),)*
                    _ => unreachable!("strides are checked before"),
                }
            };
        }
        by_stride! {
            1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32
            33 34 35 36 37 38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61
            62 63 64
        }
    }
}
