//! Links WGSL modules: `import package::a::b::{x, y};` brings in the file `shaders/a/b.wgsl`.
//!
//! WGSL's module scope does not depend on order, so linking is concatenating each imported file
//! once. Names are not mangled: they are unique over all files, and what a message names is what
//! stands in the file. The syntax is WESL's (the WGSL extension with imports), so the `wesl` crate
//! could take this module's place.

use super::shaders;
use std::collections::HashSet;
use std::fmt;
use thiserror::Error;

/// A program as one text, with the way back from its lines to the files' lines.
#[derive(Clone, Debug)]
pub struct Linked {
    pub name: String,
    pub text: String,
    /// For each line of `text`: module and line number in it, from 1.
    lines: Vec<(String, usize)>,
}

/// A constant's value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    Bool(bool),
    Uint(u32),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Bool(value) => write!(f, "{value}"),
            Value::Uint(value) => write!(f, "{value}u"),
        }
    }
}

#[derive(Debug, Error)]
pub enum LinkError {
    #[error(
        "shader {module}.wgsl:{line}: no module {import} to import from; is it in the table in src/gpu/shaders.rs?"
    )]
    NoModule {
        module: String,
        line: usize,
        import: String,
    },
    #[error("shader {module}.wgsl:{line}: module {import} defines no {name}")]
    NoName {
        module: String,
        line: usize,
        import: String,
        name: String,
    },
    #[error(
        "shader {module}.wgsl:{line}: this import is not of the form `import package::a::b::{{x, y}};`"
    )]
    Syntax { module: String, line: usize },
}

/// A shader that naga refuses, with the place in our files.
#[derive(Debug, Error)]
#[error("shader {name}: {message}")]
pub struct ShaderError {
    pub name: String,
    pub message: String,
}

/// Links the module `root` of the table.
pub fn link(root: &str) -> Result<Linked, LinkError> {
    let text = shaders::text(root).ok_or_else(|| LinkError::NoModule {
        module: root.to_owned(),
        line: 0,
        import: root.to_owned(),
    })?;
    link_text(root, text)
}

/// Links a root given as text; `name` is what messages call it.
pub fn link_text(name: &str, root: &str) -> Result<Linked, LinkError> {
    let mut linked = Linked {
        name: name.to_owned(),
        text: String::new(),
        lines: Vec::new(),
    };
    append(
        name,
        root,
        &mut HashSet::from([name.to_owned()]),
        &mut linked,
    )?;
    Ok(linked)
}

fn append(
    module: &str,
    text: &str,
    seen: &mut HashSet<String>,
    linked: &mut Linked,
) -> Result<(), LinkError> {
    let mut own = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let number = index + 1;
        if !line.starts_with("import ") {
            own.push((line, number));
            continue;
        }
        let (import, names) = parse_import(line).ok_or_else(|| LinkError::Syntax {
            module: module.to_owned(),
            line: number,
        })?;
        let text = shaders::text(&import).ok_or_else(|| LinkError::NoModule {
            module: module.to_owned(),
            line: number,
            import: import.clone(),
        })?;
        if let Some(name) = names.into_iter().find(|name| !defines(text, name)) {
            return Err(LinkError::NoName {
                module: module.to_owned(),
                line: number,
                import,
                name: name.to_owned(),
            });
        }
        if seen.insert(import.clone()) {
            append(&import, text, seen, linked)?;
        }
    }
    for (line, number) in own {
        linked.text.push_str(line);
        linked.text.push('\n');
        linked.lines.push((module.to_owned(), number));
    }
    Ok(())
}

/// `import package::a::b::{x, y};` as ("a/b", [x, y]).
fn parse_import(line: &str) -> Option<(String, Vec<&str>)> {
    let path = line
        .strip_prefix("import package::")?
        .trim_end()
        .strip_suffix("};")?;
    let (module, names) = path.split_once("::{")?;
    Some((
        module.replace("::", "/"),
        names.split(',').map(str::trim).collect(),
    ))
}

/// Whether a module defines a function, structure, constant or variable of that name.
fn defines(text: &str, name: &str) -> bool {
    text.lines().any(|line| {
        let Some(at) = line.find(name) else {
            return false;
        };
        let before = line[..at].trim_end();
        let after = line[at + name.len()..].chars().next();
        let whole = !after.is_some_and(|c| c.is_alphanumeric() || c == '_');
        whole
            && ["fn", "struct", "const", "alias", "var", ">"]
                .iter()
                .any(|keyword| before.ends_with(keyword))
    })
}

impl Linked {
    /// The same with other values for constants of one line, `const NAME: type = value;`; names that the
    /// text does not define are left out.
    pub fn with_constants(&self, constants: &[(&str, Value)]) -> Self {
        let mut text = String::with_capacity(self.text.len());
        for line in self.text.lines() {
            let value = line.strip_prefix("const ").and_then(|rest| {
                let (name, _) = rest.split_once(':')?;
                let (_, value) = constants.iter().find(|(given, _)| *given == name)?;
                let (before, _) = line.split_once('=')?;
                Some((before, value))
            });
            match value {
                Some((before, value)) => text.push_str(&format!("{before}= {value};")),
                None => text.push_str(line),
            }
            text.push('\n');
        }
        Self {
            text,
            ..self.clone()
        }
    }

    /// Parses; a fault is named by our own file and line.
    pub fn parse(&self) -> Result<naga::Module, ShaderError> {
        naga::front::wgsl::parse_str(&self.text).map_err(|error| {
            // The first label that has a place: naga's own choice may be one that has none.
            let line = error
                .labels()
                .find(|(span, _)| span.to_range().is_some_and(|range| range.start > 0))
                .map(|(span, _)| span.location(&self.text).line_number as usize);
            self.fault(line, error.emit_to_string(&self.text))
        })
    }

    /// Parses and validates with WebGPU's default capabilities, so that faults are found without an adapter.
    pub fn validate(&self) -> Result<(naga::Module, naga::valid::ModuleInfo), ShaderError> {
        let module = self.parse()?;
        let info = naga::valid::Validator::new(
            naga::valid::ValidationFlags::all(),
            naga::valid::Capabilities::default(),
        )
        .validate(&module)
        .map_err(|error| {
            let line = error.location(&self.text).map(|l| l.line_number as usize);
            self.fault(line, error.emit_to_string(&self.text))
        })?;
        Ok((module, info))
    }

    fn fault(&self, line: Option<usize>, message: String) -> ShaderError {
        ShaderError {
            name: self.name.clone(),
            message: format!("{}{message}", self.place(line)),
        }
    }

    /// "shaders/module.wgsl:line: " of a line of the linked text.
    fn place(&self, line: Option<usize>) -> String {
        line.and_then(|line| self.lines.get(line.saturating_sub(1)))
            .map_or_else(String::new, |(module, line)| {
                format!("shaders/{module}.wgsl:{line}: ")
            })
    }
}
