//! Every shader module has a twin in the reference: same functions, same order, same arguments.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

use snell::gpu::shaders;
use std::path::Path;

/// Modules without a twin: bindings are the reference's `&Packed`, `shared` has its own test, and
/// a variant is a matter of compiling.
const UNPAIRED: [&str; 3] = ["bindings", "shared", "variant"];

/// A function's name and the names of its arguments.
type Signature = (String, Vec<String>);

/// The functions of a file, without those that a comment above declares to be on one side only.
fn signatures(text: &str, one_sided: &str, dropped: &[&str]) -> Vec<Signature> {
    let lines: Vec<&str> = text.lines().collect();
    let mut found = Vec::new();
    for (index, line) in lines.iter().enumerate() {
        // Functions inside `mod tests` or of a trait are indented: only the file's own count.
        let line = line
            .strip_prefix("pub(super) ")
            .or(line.strip_prefix("pub(crate) "))
            .or(line.strip_prefix("pub "))
            .unwrap_or(line);
        let Some(rest) = line.strip_prefix("fn ") else {
            continue;
        };
        let declared = lines[..index]
            .iter()
            .rev()
            .take_while(|above| above.starts_with("//") || above.starts_with("#["))
            .any(|above| above.contains(one_sided));
        if declared {
            continue;
        }
        let name: String = rest
            .chars()
            .take_while(|c| c.is_alphanumeric() || *c == '_')
            .collect();
        let whole = lines[index..].join(" ");
        let open = whole.find('(').unwrap();
        let mut depth = 0;
        let close = whole[open..]
            .char_indices()
            .find_map(|(at, c)| {
                depth += match c {
                    '(' => 1,
                    ')' => -1,
                    _ => 0,
                };
                (depth == 0).then_some(open + at)
            })
            .unwrap();
        let arguments = whole[open + 1..close]
            .split(": ")
            .map(|part| {
                let name = part.rsplit([',', ' ', '(']).next().unwrap_or(part);
                name.trim_start_matches("mut ")
                    .trim()
                    .trim_start_matches('_')
                    .to_owned()
            })
            .collect::<Vec<_>>();
        // What follows the last ": " is the last argument's type.
        let arguments = arguments[..arguments.len() - 1]
            .iter()
            .filter(|name| !dropped.contains(&name.as_str()))
            .cloned()
            .collect();
        found.push((name, arguments));
    }
    found
}

#[test]
fn twins_have_the_same_functions_in_the_same_order() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/cpu");
    let mut faults = Vec::new();
    for (module, text) in shaders::MODULES {
        if module.starts_with("kernels/") || UNPAIRED.contains(module) {
            continue;
        }
        let twin = root.join(format!("{module}.rs"));
        let Ok(twin_text) = std::fs::read_to_string(&twin) else {
            faults.push(format!(
                "shaders/{module}.wgsl has no twin src/cpu/{module}.rs"
            ));
            continue;
        };
        let shader = signatures(text, "shader only:", &[]);
        let reference = signatures(&twin_text, "cpu only:", &["packed", "tables"]);
        if shader != reference {
            let differing = shader
                .iter()
                .zip(&reference)
                .find(|(s, r)| s != r)
                .map_or_else(
                    || format!("{} functions and {}", shader.len(), reference.len()),
                    |(s, r)| format!("{s:?} and {r:?}"),
                );
            faults.push(format!(
                "{module}: shader and reference part at {differing}"
            ));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
