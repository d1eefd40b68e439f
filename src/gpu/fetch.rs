//! Reads a shader's storage arrays from textures instead of buffers.
//!
//! llvmpipe loads from a storage buffer lane by lane, with a branch and a test of bounds for each word:
//! 22 to 34 ns for four words by eight lanes, where a read-only storage texture takes 5 (measured on Mesa
//! 22.3 and 25.0, see benches/RESULTS.md). The shaders keep their arrays; this pass gives each of them a
//! texture of words in its place, and each load a function that fetches the texels and puts the value
//! together. Texel number n is at (n mod 2^ROW_BITS, n / 2^ROW_BITS).

mod function;
mod rewrite;

use naga::{
    AddressSpace, Expression, GlobalVariable, Handle, ImageClass, ImageDimension, Module, Span,
    StorageAccess, StorageFormat, Type, TypeInner,
};
use rewrite::replace_loads;
use std::collections::BTreeMap;
use thiserror::Error;

/// Texels in a row of such a texture, as a logarithm: the width that every adapter has (WebGPU's 8192).
pub const ROW_BITS: u32 = 13;

/// A load that the pass has no function for.
#[derive(Debug, Error)]
#[error("cannot read array {array} from a texture: {why}")]
pub struct FetchError {
    pub array: String,
    pub why: &'static str,
}

/// A value in an element of an array: what a load loads.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Place {
    array: Handle<GlobalVariable>,
    /// Bytes from the element's start.
    offset: u32,
    ty: Handle<Type>,
}

/// Bytes of one texel of a texture for an array of this stride, and its format.
pub fn texel(stride: u32) -> Option<(u32, StorageFormat)> {
    match stride {
        4 => Some((4, StorageFormat::R32Uint)),
        8 => Some((8, StorageFormat::Rg32Uint)),
        stride if stride.is_multiple_of(16) => Some((16, StorageFormat::Rgba32Uint)),
        _ => None,
    }
}

/// Moves the read-only arrays for which `moves(name)` holds to textures at the same bindings.
pub fn fetch_from_textures(
    module: &mut Module,
    moves: impl Fn(&str) -> bool,
) -> Result<(), FetchError> {
    // In order, here and below: drivers know a shader again by its bits.
    let arrays: BTreeMap<Handle<GlobalVariable>, Moved> = module
        .global_variables
        .iter()
        .filter(|(_, variable)| {
            is_read_only(variable) && variable.name.as_deref().is_some_and(&moves)
        })
        .map(|(handle, variable)| Ok((handle, Moved::of(module, variable)?)))
        .collect::<Result<_, _>>()?;
    if arrays.is_empty() {
        return Ok(());
    }
    for scalar in [naga::Scalar::U32, naga::Scalar::F32] {
        type_of(module, TypeInner::Scalar(scalar));
    }
    replace_loads(module, &arrays)?;
    for (handle, moved) in &arrays {
        let image = TypeInner::Image {
            dim: ImageDimension::D2,
            arrayed: false,
            class: ImageClass::Storage {
                format: moved.format,
                access: StorageAccess::LOAD,
            },
        };
        let ty = type_of(module, image);
        let variable = module.global_variables.get_mut(*handle);
        variable.space = AddressSpace::Handle;
        variable.ty = ty;
    }
    naga::compact::compact(module, naga::compact::KeepUnused::No);
    Ok(())
}

/// Makes storage textures of those for which `format(name)` tells one: a sampled texture's texel takes two
/// to three times as long.
pub fn load_as_storage(module: &mut Module, format: impl Fn(&str) -> Option<StorageFormat>) {
    let mut changed = Vec::new();
    for (handle, variable) in module.global_variables.iter() {
        let TypeInner::Image {
            class: ImageClass::Sampled { .. },
            ..
        } = module.types[variable.ty].inner
        else {
            continue;
        };
        if let Some(format) = variable.name.as_deref().and_then(&format) {
            changed.push((handle, format));
        }
    }
    for &(handle, format) in &changed {
        let image = TypeInner::Image {
            dim: ImageDimension::D2,
            arrayed: false,
            class: ImageClass::Storage {
                format,
                access: StorageAccess::LOAD,
            },
        };
        let ty = type_of(module, image);
        module.global_variables.get_mut(handle).ty = ty;
    }
    let functions = module.functions.iter_mut().map(|(_, function)| function);
    let points = module
        .entry_points
        .iter_mut()
        .map(|point| &mut point.function);
    for function in functions.chain(points) {
        let loads: Vec<_> = function
            .expressions
            .iter()
            .filter_map(|(handle, expression)| match *expression {
                Expression::ImageLoad { image, .. } => Some((handle, image)),
                _ => None,
            })
            .collect();
        for (handle, image) in loads {
            let Expression::GlobalVariable(variable) = function.expressions[image] else {
                continue;
            };
            if let Expression::ImageLoad { level, .. } = &mut function.expressions[handle]
                && changed.iter().any(|&(one, _)| one == variable)
            {
                // They have one level.
                *level = None;
            }
        }
    }
}

fn is_read_only(variable: &GlobalVariable) -> bool {
    variable.space
        == AddressSpace::Storage {
            access: StorageAccess::LOAD,
        }
}

/// An array that is moved.
struct Moved {
    element: Handle<Type>,
    stride: u32,
    texel_bytes: u32,
    format: StorageFormat,
}

impl Moved {
    fn of(module: &Module, variable: &GlobalVariable) -> Result<Self, FetchError> {
        let fail = |why| FetchError {
            array: variable.name.clone().unwrap_or_default(),
            why,
        };
        let TypeInner::Array { base, stride, .. } = module.types[variable.ty].inner else {
            return Err(fail("it is no array"));
        };
        let (texel_bytes, format) = texel(stride).ok_or(fail("no texel is of its stride"))?;
        Ok(Self {
            element: base,
            stride,
            texel_bytes,
            format,
        })
    }
}

fn type_of(module: &mut Module, inner: TypeInner) -> Handle<Type> {
    module
        .types
        .insert(Type { name: None, inner }, Span::UNDEFINED)
}
