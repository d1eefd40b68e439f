//! Puts calls in the place of loads: which value a load loads, and a function's text with calls instead.

use super::function::{Emitter, fetch_function};
use super::{FetchError, Moved, Place};
use naga::{
    Arena, Block, Expression, Function, GlobalVariable, Handle, Literal, Module, Range, Span,
    Statement, Type, TypeInner,
};
use std::collections::{BTreeMap, HashMap};

/// Calls functions for all loads from the arrays, in all functions and entry points.
pub(super) fn replace_loads(
    module: &mut Module,
    arrays: &BTreeMap<Handle<GlobalVariable>, Moved>,
) -> Result<(), FetchError> {
    let mut functions = Functions {
        arrays,
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
    Ok(())
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
