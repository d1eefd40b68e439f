//! Takes out of a shader what its constants decide: branches never taken, and the functions and
//! variables that only these reach.
//!
//! A driver would find the same, but only after it has read everything and put each function in the
//! place of each of its calls: with all of glTF's lobes that takes lavapipe ten seconds, for scenes
//! that have none of them.

use naga::{
    Block, Expression, Function, Handle, Literal, LocalVariable, Module, Statement, UnaryOperator,
};
use std::collections::HashMap;

/// Keeps `entry` alone of the module's entry points, and what it reaches.
pub fn prune(module: &mut Module, entry: &str) {
    module.entry_points.retain(|point| point.name == entry);
    let mut known = HashMap::new();
    // A function stands after those that it calls.
    let handles: Vec<Handle<Function>> = module.functions.iter().map(|(at, _)| at).collect();
    for handle in handles {
        let mut function = std::mem::take(&mut module.functions[handle]);
        if let Some(value) = prune_function(module, &known, &mut function) {
            known.insert(handle, value);
        }
        module.functions[handle] = function;
    }
    for index in 0..module.entry_points.len() {
        let mut function = std::mem::take(&mut module.entry_points[index].function);
        prune_function(module, &known, &mut function);
        module.entry_points[index].function = function;
    }
    naga::compact::compact(module, naga::compact::KeepUnused::No);
}

/// What is known of one function so far, statement by statement.
struct Folder<'a> {
    module: &'a Module,
    /// Functions without effects that always return the same.
    functions: &'a HashMap<Handle<Function>, bool>,
    /// What naga's own variables hold: it makes one for each `&&` and `||`, stores to it in both
    /// branches and loads it after them. None: not always the same.
    temporaries: HashMap<Handle<LocalVariable>, Option<bool>>,
}

/// Prunes the body; the answer is what the function always returns, if it does nothing else.
fn prune_function(
    module: &Module,
    functions: &HashMap<Handle<Function>, bool>,
    function: &mut Function,
) -> Option<bool> {
    let mut folder = Folder {
        module,
        functions,
        temporaries: HashMap::new(),
    };
    let body = std::mem::take(&mut function.body);
    function.body = folder.block(function, body);
    // A name would keep its value alive, and calls that are no longer made with it.
    function.named_expressions.clear();
    let mut returned = None;
    for statement in &function.body {
        match statement {
            Statement::Emit(_) => {}
            Statement::Store { pointer, .. } if is_local(function, *pointer) => {}
            Statement::Return { value: Some(value) } => {
                returned = folder.value(function, *value);
            }
            _ => return None,
        }
    }
    returned
}

fn is_local(function: &Function, pointer: Handle<Expression>) -> bool {
    matches!(function.expressions[pointer], Expression::LocalVariable(_))
}

impl Folder<'_> {
    /// The block without what is never done.
    fn block(&mut self, function: &mut Function, block: Block) -> Block {
        let mut kept = Block::new();
        self.append(function, block, &mut kept);
        kept
    }

    /// Whether control comes to the end of the block.
    fn append(&mut self, function: &mut Function, block: Block, kept: &mut Block) -> bool {
        for (statement, span) in block.span_into_iter() {
            match statement {
                Statement::If {
                    condition,
                    accept,
                    reject,
                } => {
                    let taken = match self.value(function, condition) {
                        Some(true) => accept,
                        Some(false) => reject,
                        None => {
                            let accept = self.block(function, accept);
                            let reject = self.block(function, reject);
                            let statement = Statement::If {
                                condition,
                                accept,
                                reject,
                            };
                            kept.push(statement, span);
                            continue;
                        }
                    };
                    if !self.append(function, taken, kept) {
                        return false;
                    }
                }
                Statement::Block(inner) => {
                    let inner = self.block(function, inner);
                    kept.push(Statement::Block(inner), span);
                }
                Statement::Switch { selector, cases } => {
                    let cases = cases
                        .into_iter()
                        .map(|mut case| {
                            case.body = self.block(function, case.body);
                            case
                        })
                        .collect();
                    kept.push(Statement::Switch { selector, cases }, span);
                }
                Statement::Loop {
                    body,
                    continuing,
                    break_if,
                } => {
                    let body = self.block(function, body);
                    let continuing = self.block(function, continuing);
                    let statement = Statement::Loop {
                        body,
                        continuing,
                        break_if,
                    };
                    kept.push(statement, span);
                }
                Statement::Call {
                    function: callee,
                    result: Some(result),
                    ..
                } if self.functions.contains_key(&callee) => {
                    let value = Literal::Bool(self.functions[&callee]);
                    function.expressions[result] = Expression::Literal(value);
                }
                Statement::Store { pointer, value } => {
                    self.store(function, pointer, value);
                    kept.push(Statement::Store { pointer, value }, span);
                }
                Statement::Return { .. }
                | Statement::Break
                | Statement::Continue
                | Statement::Kill => {
                    kept.push(statement, span);
                    return false;
                }
                _ => kept.push(statement, span),
            }
        }
        true
    }

    fn store(
        &mut self,
        function: &Function,
        pointer: Handle<Expression>,
        value: Handle<Expression>,
    ) {
        let Expression::LocalVariable(variable) = function.expressions[pointer] else {
            return;
        };
        if function.local_variables[variable].name.is_some() {
            return;
        }
        let value = self.value(function, value);
        self.temporaries
            .entry(variable)
            .and_modify(|before| *before = before.filter(|_| *before == value))
            .or_insert(value);
    }

    /// The value of a truth that the constants decide.
    fn value(&self, function: &Function, expression: Handle<Expression>) -> Option<bool> {
        match function.expressions[expression] {
            Expression::Literal(Literal::Bool(value)) => Some(value),
            Expression::Constant(constant) => {
                let init = self.module.constants[constant].init;
                match self.module.global_expressions[init] {
                    Expression::Literal(Literal::Bool(value)) => Some(value),
                    _ => None,
                }
            }
            Expression::Unary {
                op: UnaryOperator::LogicalNot,
                expr,
            } => self.value(function, expr).map(|value| !value),
            Expression::Load { pointer } => match function.expressions[pointer] {
                Expression::LocalVariable(variable) => {
                    self.temporaries.get(&variable).copied().flatten()
                }
                _ => None,
            },
            _ => None,
        }
    }
}
