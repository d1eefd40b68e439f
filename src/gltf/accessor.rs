//! Accessors: typed arrays in buffer views (glTF 2.0 section 3.6.2), every component type,
//! normalized integers, strides and sparse overlays included.

use super::buffer::{Buffers, View};
use super::error::GltfError;
use super::json::Json;
use super::source::Budget;
use gltf::json::accessor::{BYTE, FLOAT, SHORT, UNSIGNED_BYTE, UNSIGNED_INT, UNSIGNED_SHORT};
use std::collections::HashMap;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(json: &Json<'_>) -> Result<Self, GltfError> {
        let kind = json.required("componentType")?;
        match u32::try_from(kind.as_uint()?) {
            Ok(BYTE) => Ok(Self::I8),
            Ok(UNSIGNED_BYTE) => Ok(Self::U8),
            Ok(SHORT) => Ok(Self::I16),
            Ok(UNSIGNED_SHORT) => Ok(Self::U16),
            Ok(UNSIGNED_INT) => Ok(Self::U32),
            Ok(FLOAT) => Ok(Self::F32),
            _ => Err(kind.invalid("it is none of 5120, 5121, 5122, 5123, 5125, 5126")),
        }
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }
}

/// Reads accessors out of buffers, within a budget.
#[derive(Clone, Copy)]
pub struct Accessors<'b> {
    pub buffers: &'b Buffers,
    pub budget: &'b Budget,
    /// Of one primitive, where it is compressed.
    pub overrides: Option<&'b Overrides>,
}

/// The elements of accessors, by number, that did not come out of a buffer view: little-endian and
/// without gaps.
pub type Overrides = HashMap<usize, Vec<u8>>;

/// Which accessors an attribute may have, and how they become floats.
pub struct Attribute {
    pub types: &'static [&'static str],
    /// For the components that a shorter vector lacks.
    pub fill: f32,
    /// Integers are normalized whether the accessor says so or not: no other reading makes sense.
    pub normalized: bool,
}

impl Attribute {
    pub const fn of(types: &'static [&'static str]) -> Self {
        Self {
            types,
            fill: 0.0,
            normalized: false,
        }
    }
}

/// The elements of an accessor as little-endian bytes without gaps.
struct Packed {
    component: Component,
    normalized: bool,
    components: usize,
    bytes: Vec<u8>,
}

impl Accessors<'_> {
    /// The accessor that property `key` of `user` refers to, as vectors of N floats.
    pub fn floats<const N: usize>(
        &self,
        user: &Json<'_>,
        key: &str,
        attribute: &Attribute,
    ) -> Result<Option<Vec<[f32; N]>>, GltfError> {
        let Some((number, accessor)) = user.reference(key, "accessors")? else {
            return Ok(None);
        };
        let packed = self.packed(number, &accessor, attribute.types)?;
        let normalized = packed.normalized || attribute.normalized;
        let element = packed.components * packed.component.size();
        let count = packed.bytes.len() / element;
        self.take(count as u64 * 4 * N as u64, &accessor)?;
        let vectors = packed.bytes.chunks_exact(element).map(|bytes| {
            let mut vector = [attribute.fill; N];
            let parts = bytes.chunks_exact(packed.component.size());
            for (value, part) in vector.iter_mut().zip(parts) {
                *value = float(packed.component, normalized, part);
            }
            vector
        });
        Ok(Some(vectors.collect()))
    }

    /// Likewise as unsigned integers: indices and joints.
    pub fn integers<const N: usize>(
        &self,
        user: &Json<'_>,
        key: &str,
        types: &[&str],
    ) -> Result<Option<Vec<[u32; N]>>, GltfError> {
        let Some((number, accessor)) = user.reference(key, "accessors")? else {
            return Ok(None);
        };
        let packed = self.packed(number, &accessor, types)?;
        let size = packed.component.size();
        if matches!(
            packed.component,
            Component::I8 | Component::I16 | Component::F32
        ) {
            return Err(accessor.invalid("its component type must be an unsigned integer"));
        }
        let element = packed.components * size;
        self.take((packed.bytes.len() / element * 4 * N) as u64, &accessor)?;
        let vectors = packed.bytes.chunks_exact(element).map(|bytes| {
            let mut vector = [0; N];
            for (value, part) in vector.iter_mut().zip(bytes.chunks_exact(size)) {
                *value = unsigned(part);
            }
            vector
        });
        Ok(Some(vectors.collect()))
    }

    fn take(&self, bytes: u64, json: &Json<'_>) -> Result<(), GltfError> {
        self.budget.take(bytes, json.file(), &json.at)
    }

    fn packed(
        &self,
        number: usize,
        accessor: &Json<'_>,
        types: &[&str],
    ) -> Result<Packed, GltfError> {
        let component = Component::of(accessor)?;
        let kind = accessor.required("type")?;
        let name = kind.as_string()?;
        if !types.contains(&name) {
            return Err(kind.invalid(format!("it is {name} where {} belongs", types.join(" or "))));
        }
        let components = components(name);
        let element = components * component.size();
        let replaced = self.overrides.and_then(|overrides| overrides.get(&number));
        let count = match replaced {
            Some(bytes) => (bytes.len() / element) as u64,
            None => accessor.required("count")?.as_uint()?,
        };
        let size = count.saturating_mul(element as u64);
        let view = match replaced {
            Some(_) => None,
            None => self.buffers.view(accessor, "bufferView")?,
        };
        // What a view can hold is known before anything is allocated.
        let offset = accessor.uint("byteOffset")?.unwrap_or(0);
        let range = view
            .map(|view| range(accessor, view, offset, count, element))
            .transpose()?;
        self.take(size, accessor)?;
        let mut bytes = match range {
            Some((data, stride)) if stride == element => data.to_vec(),
            Some((data, stride)) => {
                let elements = data.chunks(stride).take(count as usize);
                elements
                    .flat_map(|chunk| &chunk[..element])
                    .copied()
                    .collect()
            }
            None => replaced.map_or_else(|| vec![0; size as usize], Vec::clone),
        };
        if let Some(sparse) = accessor.object("sparse")? {
            self.overlay(&sparse, &mut bytes, count, element)?;
        }
        Ok(Packed {
            component,
            normalized: accessor.boolean("normalized")?.unwrap_or(false),
            components,
            bytes,
        })
    }

    /// Section 3.6.2.3: some elements are replaced.
    fn overlay(
        &self,
        sparse: &Json<'_>,
        bytes: &mut [u8],
        count: u64,
        element: usize,
    ) -> Result<(), GltfError> {
        let replaced = sparse.required("count")?.as_uint()?;
        if replaced > count {
            return Err(sparse.invalid(format!("count is {replaced}, more than the {count} there")));
        }
        let part = |name: &str, size: usize| -> Result<_, GltfError> {
            let json = sparse.required(name)?;
            let view = self.buffers.view(&json, "bufferView")?;
            let view = view.ok_or_else(|| json.invalid("`bufferView` is missing"))?;
            let offset = json.uint("byteOffset")?.unwrap_or(0);
            let tight = View {
                bytes: view.bytes,
                stride: None,
            };
            let (data, _) = range(&json, tight, offset, replaced, size)?;
            Ok((json, data))
        };
        let kind = Component::of(&sparse.required("indices")?)?;
        let (indices, index_bytes) = part("indices", kind.size())?;
        if !matches!(kind, Component::U8 | Component::U16 | Component::U32) {
            return Err(indices.invalid("its component type must be an unsigned integer"));
        }
        let (_, values) = part("values", element)?;
        for (index, value) in index_bytes
            .chunks_exact(kind.size())
            .zip(values.chunks_exact(element))
        {
            let index = unsigned(index) as usize;
            let Some(target) = bytes.chunks_exact_mut(element).nth(index) else {
                return Err(indices.invalid(format!("index {index} is out of range: {count}")));
            };
            target.copy_from_slice(value);
        }
        Ok(())
    }
}

fn components(kind: &str) -> usize {
    match kind {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        // Columns of 4-byte components need no padding; no other matrix is read.
        _ => 16,
    }
}

/// Numbers as the elements of an accessor, whose own count does not matter. All must be values that
/// its component type has.
pub fn store(accessor: &Json<'_>, width: usize, values: &[f64]) -> Result<Vec<u8>, GltfError> {
    let component = Component::of(accessor)?;
    let kind = accessor.required("type")?;
    if components(kind.as_string()?) != width {
        return Err(kind.invalid(format!(
            "it is {} and decoded were elements of {width} components",
            kind.as_string()?
        )));
    }
    let mut bytes = Vec::with_capacity(values.len() * component.size());
    for &value in values {
        let exact = match component {
            Component::F32 => {
                bytes.extend((value as f32).to_le_bytes());
                continue;
            }
            Component::I8 => f64::from(i8::MIN)..=f64::from(i8::MAX),
            Component::U8 => 0.0..=f64::from(u8::MAX),
            Component::I16 => f64::from(i16::MIN)..=f64::from(i16::MAX),
            Component::U16 => 0.0..=f64::from(u16::MAX),
            Component::U32 => 0.0..=f64::from(u32::MAX),
        };
        if !exact.contains(&value) || value.fract() != 0.0 {
            return Err(accessor.invalid(format!(
                "its component type cannot hold {value}, which was decoded"
            )));
        }
        bytes.extend(&(value as i64).to_le_bytes()[..component.size()]);
    }
    Ok(bytes)
}

/// The bytes from the first element to the last, and the stride.
fn range<'v>(
    json: &Json<'_>,
    view: View<'v>,
    offset: u64,
    count: u64,
    element: usize,
) -> Result<(&'v [u8], usize), GltfError> {
    let stride = view.stride.unwrap_or(element);
    if stride < element {
        return Err(json.invalid(format!(
            "its elements are {element} bytes and its bufferView's byteStride is {stride}"
        )));
    }
    if count == 0 {
        return Ok((&[], stride));
    }
    let end = (count - 1)
        .checked_mul(stride as u64)
        .and_then(|bytes| bytes.checked_add(element as u64)?.checked_add(offset))
        .filter(|&end| end <= view.bytes.len() as u64);
    match end {
        Some(end) => Ok((&view.bytes[offset as usize..end as usize], stride)),
        None => Err(json.invalid(format!(
            "{count} elements of {element} bytes from byte {offset} do not fit into its \
             bufferView's {} bytes",
            view.bytes.len()
        ))),
    }
}

fn unsigned(bytes: &[u8]) -> u32 {
    bytes
        .iter()
        .rev()
        .fold(0, |value, &byte| value << 8 | u32::from(byte))
}

/// Section 3.6.2.2: a normalized integer is c / max, and -1 at least.
fn float(component: Component, normalized: bool, bytes: &[u8]) -> f32 {
    let raw = unsigned(bytes);
    let (value, maximum) = match component {
        Component::F32 => return f32::from_bits(raw),
        Component::I8 => (f32::from(raw as u8 as i8), f32::from(i8::MAX)),
        Component::U8 => (raw as f32, f32::from(u8::MAX)),
        Component::I16 => (f32::from(raw as u16 as i16), f32::from(i16::MAX)),
        Component::U16 => (raw as f32, f32::from(u16::MAX)),
        Component::U32 => (raw as f32, u32::MAX as f32),
    };
    if normalized {
        (value / maximum).max(-1.0)
    } else {
        value
    }
}
