//! The functions that are called instead: one of an index for each kind of value, which fetches the texels and puts
//! the value together.

use super::{Moved, Place, ROW_BITS, type_of};
use naga::{
    BinaryOperator, Block, Expression, Function, FunctionArgument, FunctionResult, Handle, Literal,
    Module, Range, ScalarKind, Span, Statement, Type, TypeInner, VectorSize,
};
use std::collections::HashMap;

/// Gathers neighbours into one Emit.
#[derive(Default)]
pub(super) struct Emitter {
    open: Option<[Handle<Expression>; 2]>,
}

impl Emitter {
    /// The next handle, directly behind the last one.
    pub(super) fn add(&mut self, handle: Handle<Expression>) {
        self.open = Some([self.open.map_or(handle, |[first, _]| first), handle]);
    }

    pub(super) fn flush(&mut self, block: &mut Block, span: Span) {
        if let Some([first, last]) = self.open.take() {
            block.push(Statement::Emit(Range::new_from_bounds(first, last)), span);
        }
    }
}

/// A function of an index: the value at `place` of the element with that index.
pub(super) fn fetch_function(module: &mut Module, array: &Moved, place: Place) -> Function {
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
