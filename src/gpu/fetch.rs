//! Reads a shader's storage arrays from textures instead of buffers.
//!
//! llvmpipe loads from a storage buffer lane by lane, with a branch and a test of bounds for each word:
//! 22 to 34 ns for four words by eight lanes, where a read-only storage texture takes 5 (measured on Mesa
//! 22.3 and 25.0, see benches/RESULTS.md). The shaders keep their arrays; this pass gives each of them a
//! texture of words in its place, and each load a function that fetches the texels and puts the value
//! together. Texel number n is at (n mod 2^ROW_BITS, n / 2^ROW_BITS).

use naga::{
    AddressSpace, Arena, BinaryOperator, Block, Expression, Function, FunctionArgument,
    FunctionResult, GlobalVariable, Handle, ImageClass, ImageDimension, Literal, Module, Range,
    ScalarKind, Span, Statement, StorageAccess, StorageFormat, Type, TypeInner, VectorSize,
};
use std::collections::{BTreeMap, HashMap};
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
    let mut functions = Functions {
        arrays: &arrays,
        arena: Arena::new(),
        known: HashMap::new(),
    };
    // A function may call only those before it, so the new ones come first.
    let bodies: Vec<&Function> = module
        .functions
        .iter()
        .map(|(_, function)| function)
        .collect();
    let mut places = Vec::new();
    for function in bodies
        .into_iter()
        .chain(module.entry_points.iter().map(|point| &point.function))
    {
        for (_, expression) in function.expressions.iter() {
            if let Expression::Load { pointer } = *expression
                && let Some((place, _)) = functions.place(module, function, pointer)?
            {
                places.push(place);
            }
        }
    }
    for place in places {
        functions.add(module, place);
    }
    let old = std::mem::take(&mut module.functions);
    let mut renamed = HashMap::new();
    for (handle, function) in old.iter() {
        let function = functions.rewrite(module, function.clone(), &renamed)?;
        let new = functions.arena.append(function, old.get_span(handle));
        renamed.insert(handle, new);
    }
    for index in 0..module.entry_points.len() {
        let function = std::mem::take(&mut module.entry_points[index].function);
        module.entry_points[index].function = functions.rewrite(module, function, &renamed)?;
    }
    module.functions = functions.arena;
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

/// Makes storage textures of the float32 textures for which `components(name)` says of how many components
/// their texels are, 2 or 4: a sampled texture's texel takes two to three times as long.
pub fn load_as_storage(module: &mut Module, components: impl Fn(&str) -> Option<u32>) {
    let mut changed = Vec::new();
    for (handle, variable) in module.global_variables.iter() {
        let TypeInner::Image {
            class: ImageClass::Sampled { .. },
            ..
        } = module.types[variable.ty].inner
        else {
            continue;
        };
        let format = match variable.name.as_deref().and_then(&components) {
            Some(2) => StorageFormat::Rg32Float,
            Some(4) => StorageFormat::Rgba32Float,
            _ => continue,
        };
        changed.push((handle, format));
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

/// The functions that fetch, and those that are rewritten behind them.
struct Functions<'a> {
    arrays: &'a BTreeMap<Handle<GlobalVariable>, Moved>,
    arena: Arena<Function>,
    known: HashMap<Place, Handle<Function>>,
}

impl Functions<'_> {
    /// What a pointer into one of the arrays points to, and the index of the element.
    fn place(
        &self,
        module: &Module,
        function: &Function,
        pointer: Handle<Expression>,
    ) -> Result<Option<(Place, Handle<Expression>)>, FetchError> {
        let fail = |why| FetchError {
            array: self.array_of(module, function, pointer).unwrap_or_default(),
            why,
        };
        if self.array_of(module, function, pointer).is_none() {
            return Ok(None);
        }
        let mut members = Vec::new();
        let mut at = pointer;
        let (array, index) = loop {
            match function.expressions[at] {
                Expression::AccessIndex { base, index } => {
                    members.push(index);
                    at = base;
                }
                Expression::Access { base, index } => match function.expressions[base] {
                    Expression::GlobalVariable(array) => break (array, index),
                    _ => return Err(fail("what is in an element is indexed by a variable")),
                },
                _ => return Err(fail("it is indexed by a constant")),
            }
        };
        let mut offset = 0;
        let mut ty = self.arrays[&array].element;
        for &member in members.iter().rev() {
            match &module.types[ty].inner {
                TypeInner::Struct { members, .. } => {
                    offset += members[member as usize].offset;
                    ty = members[member as usize].ty;
                }
                TypeInner::Array { base, stride, .. } => {
                    offset += stride * member;
                    ty = *base;
                }
                TypeInner::Vector { scalar, .. } => {
                    offset += u32::from(scalar.width) * member;
                    let inner = TypeInner::Scalar(*scalar);
                    let component = module.types.get(&Type { name: None, inner });
                    ty = component.ok_or_else(|| fail("a vector is not of words"))?;
                }
                _ => {
                    return Err(fail(
                        "an element holds what is neither a structure, an array nor a vector",
                    ));
                }
            }
        }
        Ok(Some((Place { array, offset, ty }, index)))
    }

    /// The name of the moved array that a pointer points into.
    fn array_of(
        &self,
        module: &Module,
        function: &Function,
        mut at: Handle<Expression>,
    ) -> Option<String> {
        loop {
            match function.expressions[at] {
                Expression::AccessIndex { base, .. } | Expression::Access { base, .. } => at = base,
                Expression::GlobalVariable(array) if self.arrays.contains_key(&array) => {
                    return Some(
                        module.global_variables[array]
                            .name
                            .clone()
                            .unwrap_or_default(),
                    );
                }
                _ => return None,
            }
        }
    }

    /// Makes the function for a place, if it is not there yet.
    fn add(&mut self, module: &mut Module, place: Place) {
        if self.known.contains_key(&place) {
            return;
        }
        let function = fetch_function(module, &self.arrays[&place.array], place);
        let handle = self.arena.append(function, Span::UNDEFINED);
        self.known.insert(place, handle);
    }

    /// The function with its loads from the arrays replaced by calls, and its own calls renamed.
    fn rewrite(
        &self,
        module: &Module,
        mut function: Function,
        renamed: &HashMap<Handle<Function>, Handle<Function>>,
    ) -> Result<Function, FetchError> {
        let mut fetches = HashMap::new();
        let mut pointers = Vec::new();
        let handles: Vec<_> = function
            .expressions
            .iter()
            .map(|(handle, _)| handle)
            .collect();
        for &handle in &handles {
            match function.expressions[handle] {
                Expression::Load { pointer } => {
                    if let Some((place, index)) = self.place(module, &function, pointer)? {
                        fetches.insert(handle, (self.known[&place], index));
                    }
                }
                Expression::Access { .. } | Expression::AccessIndex { .. }
                    if self.array_of(module, &function, handle).is_some() =>
                {
                    pointers.push(handle);
                }
                _ => {}
            }
        }
        for (&handle, &(callee, _)) in &fetches {
            function.expressions[handle] = Expression::CallResult(callee);
        }
        for &handle in &handles {
            if let Expression::CallResult(callee) = &mut function.expressions[handle]
                && let Some(&new) = renamed.get(callee)
                && !fetches.contains_key(&handle)
            {
                *callee = new;
            }
        }
        // They point nowhere now, and nothing uses them.
        for &handle in &pointers {
            function.expressions[handle] = Expression::Literal(Literal::U32(0));
        }
        function
            .named_expressions
            .retain(|handle, _| !pointers.contains(handle));
        let calls = Calls {
            fetches,
            renamed,
            dropped: pointers,
        };
        let body = std::mem::take(&mut function.body);
        function.body = calls.block(body);
        Ok(function)
    }
}

/// What is done to a function's statements.
struct Calls<'a> {
    fetches: HashMap<Handle<Expression>, (Handle<Function>, Handle<Expression>)>,
    renamed: &'a HashMap<Handle<Function>, Handle<Function>>,
    dropped: Vec<Handle<Expression>>,
}

impl Calls<'_> {
    fn block(&self, block: Block) -> Block {
        let mut kept = Block::new();
        for (statement, span) in block.span_into_iter() {
            match statement {
                Statement::Emit(range) => self.emit(range, span, &mut kept),
                Statement::Call {
                    function: callee,
                    arguments,
                    result,
                } => kept.push(
                    Statement::Call {
                        function: self.renamed[&callee],
                        arguments,
                        result,
                    },
                    span,
                ),
                Statement::Block(inner) => {
                    kept.push(Statement::Block(self.block(inner)), span);
                }
                Statement::If {
                    condition,
                    accept,
                    reject,
                } => kept.push(
                    Statement::If {
                        condition,
                        accept: self.block(accept),
                        reject: self.block(reject),
                    },
                    span,
                ),
                Statement::Switch { selector, cases } => {
                    let cases = cases
                        .into_iter()
                        .map(|mut case| {
                            case.body = self.block(case.body);
                            case
                        })
                        .collect();
                    kept.push(Statement::Switch { selector, cases }, span);
                }
                Statement::Loop {
                    body,
                    continuing,
                    break_if,
                } => kept.push(
                    Statement::Loop {
                        body: self.block(body),
                        continuing: self.block(continuing),
                        break_if,
                    },
                    span,
                ),
                other => kept.push(other, span),
            }
        }
        kept
    }

    /// The emitted expressions in their order, a call in the place of each that is fetched.
    fn emit(&self, range: Range<Expression>, span: Span, kept: &mut Block) {
        let mut emitter = Emitter::default();
        for handle in range {
            if let Some(&(callee, index)) = self.fetches.get(&handle) {
                emitter.flush(kept, span);
                let call = Statement::Call {
                    function: callee,
                    arguments: vec![index],
                    result: Some(handle),
                };
                kept.push(call, span);
            } else if self.dropped.contains(&handle) {
                emitter.flush(kept, span);
            } else {
                emitter.add(handle);
            }
        }
        emitter.flush(kept, span);
    }
}

/// Gathers neighbours into one Emit.
#[derive(Default)]
struct Emitter {
    open: Option<[Handle<Expression>; 2]>,
}

impl Emitter {
    /// The next handle, directly behind the last one.
    fn add(&mut self, handle: Handle<Expression>) {
        self.open = Some([self.open.map_or(handle, |[first, _]| first), handle]);
    }

    fn flush(&mut self, block: &mut Block, span: Span) {
        if let Some([first, last]) = self.open.take() {
            block.push(Statement::Emit(Range::new_from_bounds(first, last)), span);
        }
    }
}

fn type_of(module: &mut Module, inner: TypeInner) -> Handle<Type> {
    module
        .types
        .insert(Type { name: None, inner }, Span::UNDEFINED)
}

/// A function of an index: the value at `place` of the element with that index.
fn fetch_function(module: &mut Module, array: &Moved, place: Place) -> Function {
    let uint = type_of(module, TypeInner::Scalar(naga::Scalar::U32));
    let pair = TypeInner::Vector {
        size: VectorSize::Bi,
        scalar: naga::Scalar::U32,
    };
    let pair = type_of(module, pair);
    let mut fetch = Fetch {
        module,
        array,
        pair,
        function: Function {
            name: Some("fetch".to_owned()),
            arguments: vec![FunctionArgument {
                name: None,
                ty: uint,
                binding: None,
            }],
            result: Some(FunctionResult {
                ty: place.ty,
                binding: None,
            }),
            ..Function::default()
        },
        emitter: Emitter::default(),
        texels: HashMap::new(),
        image: None,
        first: None,
    };
    let index = fetch.constant(Expression::FunctionArgument(0));
    fetch.image = Some(fetch.constant(Expression::GlobalVariable(place.array)));
    let texels = fetch.literal(array.stride / array.texel_bytes);
    fetch.first = Some(fetch.value_of(Expression::Binary {
        op: BinaryOperator::Multiply,
        left: index,
        right: texels,
    }));
    let value = fetch.value(place.ty, place.offset);
    let mut function = fetch.function;
    fetch.emitter.flush(&mut function.body, Span::UNDEFINED);
    let statement = Statement::Return { value: Some(value) };
    function.body.push(statement, Span::UNDEFINED);
    function
}

/// A fetching function under way.
struct Fetch<'a> {
    module: &'a Module,
    array: &'a Moved,
    pair: Handle<Type>,
    function: Function,
    emitter: Emitter,
    /// By their number in the element.
    texels: HashMap<u32, Handle<Expression>>,
    image: Option<Handle<Expression>>,
    /// Number of the element's first texel.
    first: Option<Handle<Expression>>,
}

impl Fetch<'_> {
    /// An expression that is never emitted: a literal, an argument or a variable.
    fn constant(&mut self, expression: Expression) -> Handle<Expression> {
        self.emitter.flush(&mut self.function.body, Span::UNDEFINED);
        self.function
            .expressions
            .append(expression, Span::UNDEFINED)
    }

    fn literal(&mut self, value: u32) -> Handle<Expression> {
        self.constant(Expression::Literal(Literal::U32(value)))
    }

    fn value_of(&mut self, expression: Expression) -> Handle<Expression> {
        let handle = self
            .function
            .expressions
            .append(expression, Span::UNDEFINED);
        self.emitter.add(handle);
        handle
    }

    fn binary(
        &mut self,
        op: BinaryOperator,
        left: Handle<Expression>,
        right: u32,
    ) -> Handle<Expression> {
        let right = self.literal(right);
        self.value_of(Expression::Binary { op, left, right })
    }

    /// Four words of texel `number` of the element.
    fn texel(&mut self, number: u32) -> Handle<Expression> {
        if let Some(&texel) = self.texels.get(&number) {
            return texel;
        }
        let (Some(image), Some(first)) = (self.image, self.first) else {
            unreachable!("both are set before the first texel is fetched");
        };
        let index = self.binary(BinaryOperator::Add, first, number);
        let column = self.binary(BinaryOperator::And, index, (1 << ROW_BITS) - 1);
        let row = self.binary(BinaryOperator::ShiftRight, index, ROW_BITS);
        let ty = self.pair;
        let coordinate = self.value_of(Expression::Compose {
            ty,
            components: vec![column, row],
        });
        let texel = self.value_of(Expression::ImageLoad {
            image,
            coordinate,
            array_index: None,
            sample: None,
            level: None,
        });
        self.texels.insert(number, texel);
        texel
    }

    fn word(&mut self, offset: u32, kind: ScalarKind) -> Handle<Expression> {
        let base = self.texel(offset / self.array.texel_bytes);
        let index = offset % self.array.texel_bytes / 4;
        let word = self.value_of(Expression::AccessIndex { base, index });
        if kind == ScalarKind::Uint {
            return word;
        }
        self.value_of(Expression::As {
            expr: word,
            kind,
            convert: None,
        })
    }

    /// A value of type `ty`, `offset` bytes from the element's start.
    fn value(&mut self, ty: Handle<Type>, offset: u32) -> Handle<Expression> {
        let parts: Vec<(Handle<Type>, u32)> = match &self.module.types[ty].inner {
            TypeInner::Scalar(scalar) => {
                let kind = scalar.kind;
                return self.word(offset, kind);
            }
            TypeInner::Vector { size, scalar } => {
                let (size, kind) = (*size as u32, scalar.kind);
                let components = (0..size)
                    .map(|part| self.word(offset + 4 * part, kind))
                    .collect();
                return self.value_of(Expression::Compose { ty, components });
            }
            TypeInner::Array {
                base,
                size: naga::ArraySize::Constant(count),
                stride,
            } => (0..count.get())
                .map(|part| (*base, offset + stride * part))
                .collect(),
            TypeInner::Struct { members, .. } => members
                .iter()
                .map(|member| (member.ty, offset + member.offset))
                .collect(),
            _ => unreachable!("storage holds scalars, vectors, arrays and structures"),
        };
        let components = parts
            .into_iter()
            .map(|(ty, offset)| self.value(ty, offset))
            .collect();
        self.value_of(Expression::Compose { ty, components })
    }
}
