//! Triangles and attributes out of a Draco stream.
//!
//! The decoder behind this reads the sizes of its tables from the stream and allocates them unseen,
//! and arithmetic on damaged values may panic in it. So [`frame`] walks over the stream before it is
//! decoded and refuses sizes that cannot be, and a panic is caught and told as damage.

use super::{frame, points};
use draco_oxide_core::attribute::{Attribute, ComponentDataType};
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Once;

/// What a stream holds. All attributes have one value for each point.
pub struct Decoded {
    pub triangles: Vec<[u32; 3]>,
    attributes: Vec<Attribute>,
    /// Of the decoder's points, for each of ours.
    points: Vec<u32>,
}

/// Bytes that decoding takes for each corner of a triangle: the opposite corner, the vertex, the
/// ranks in up to three traversals, seams, the point; and for each value of each attribute: symbols
/// with their prediction, the decoder's value, and its index.
const CORNER_BYTES: u64 = 40;
const VALUE_BYTES: u64 = 48;

/// Decodes a stream of so many triangles. `charge` is asked before memory is taken, and its error is
/// handed on; `damaged` makes one of a sentence.
pub fn decode<E>(
    bytes: &[u8],
    triangles: u64,
    charge: impl Fn(u64) -> Result<(), E>,
    damaged: impl Fn(String) -> E,
) -> Result<Decoded, E> {
    charge(triangles.saturating_mul(3 * CORNER_BYTES))?;
    let (walk, points) = contained(|| frame::open(bytes, triangles as usize)).map_err(&damaged)?;
    charge((points as u64).saturating_mul(VALUE_BYTES))?;
    let frame = contained(|| frame::survey(walk, points)).map_err(&damaged)?;
    let values = frame.attributes.saturating_mul(frame.values) as u64;
    charge(values.saturating_mul(VALUE_BYTES))?;
    contained(|| {
        let mesh = draco_oxide_decoder::decode_mesh(bytes).map_err(|error| error.to_string())?;
        let (triangles, points) = points::assign(&mesh, frame.connectivity.edgebreaker())?;
        Ok(Decoded {
            triangles,
            attributes: mesh.attributes,
            points,
        })
    })
    .map_err(&damaged)
}

impl Decoded {
    pub fn point_count(&self) -> usize {
        self.points.len()
    }

    /// The values of the attribute with a unique id, as many numbers a point as it has components.
    /// Every integer that Draco holds here is exact in 64-bit floating point.
    pub fn values(&self, id: u64) -> Result<(usize, Vec<f64>), String> {
        contained(|| {
            let attribute = self
                .attributes
                .iter()
                .find(|attribute| attribute.get_id().as_usize() as u64 == id)
                .ok_or_else(|| format!("it has no attribute with the id {id}"))?;
            let kind = attribute.get_component_type();
            let components = attribute.get_num_components();
            let data = attribute.get_data_as_bytes();
            let size = kind.size();
            let mut values = Vec::with_capacity(components * self.points.len());
            for &point in &self.points {
                let index = usize::from(attribute.get_unique_val_idx((point as usize).into()));
                let first = index * components * size;
                let element = &data[first..first + components * size];
                for part in element.chunks_exact(size) {
                    values.push(number(kind, part)?);
                }
            }
            Ok((components, values))
        })
    }
}

fn number(kind: ComponentDataType, bytes: &[u8]) -> Result<f64, String> {
    use ComponentDataType as C;
    // The decoder holds its values as the machine does.
    Ok(match (kind, bytes) {
        (C::I8, &[a]) => f64::from(a as i8),
        (C::U8, &[a]) => f64::from(a),
        (C::I16, &[a, b]) => f64::from(i16::from_ne_bytes([a, b])),
        (C::U16, &[a, b]) => f64::from(u16::from_ne_bytes([a, b])),
        (C::I32, &[a, b, c, d]) => f64::from(i32::from_ne_bytes([a, b, c, d])),
        (C::U32, &[a, b, c, d]) => f64::from(u32::from_ne_bytes([a, b, c, d])),
        (C::F32, &[a, b, c, d]) => f64::from(f32::from_ne_bytes([a, b, c, d])),
        _ => return Err(format!("attributes of type {kind:?} are not read")),
    })
}

/// Runs the decoder; a panic in it becomes an error and is not printed.
fn contained<T>(run: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    // The panic hook is the process'. It is set once, and asks this whether to be silent.
    thread_local!(static QUIET: Cell<bool> = const { Cell::new(false) });
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            if !QUIET.get() {
                before(panic);
            }
        }));
    });
    let outside = QUIET.replace(true);
    // Nothing that a panic leaves half done is seen again.
    let result = catch_unwind(AssertUnwindSafe(run));
    QUIET.set(outside);
    result.unwrap_or_else(|_| Err("its values contradict each other".to_owned()))
}
