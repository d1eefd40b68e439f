//! `snell plot`: the data behind each figure against closed forms, the figures themselves, and the program.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]
#![allow(non_snake_case, reason = "the symbols of the textbooks")]

mod curves;
mod drawn;
mod lobes;
#[allow(dead_code, reason = "shared with the other tests of the program")]
#[path = "../cli/place.rs"]
mod place;
mod program;

use snell::plot::subject::Subject;

fn preset(name: &str) -> Subject {
    Subject::preset(name).unwrap_or_else(|| panic!("no preset {name}"))
}

fn close(value: f64, expected: f64, tolerance: f64, what: &str) {
    assert!(
        (value - expected).abs() <= tolerance,
        "{what}: {value}, not {expected}"
    );
}

/// Every tag closes, every attribute is quoted, nothing is left over; the text between tags.
fn parse_svg(text: &str) -> Vec<String> {
    let mut open = Vec::new();
    let mut words = Vec::new();
    let mut rest = text;
    while let Some(start) = rest.find('<') {
        let word = rest[..start].trim();
        if !word.is_empty() {
            assert!(!open.is_empty(), "text outside of all elements: {word}");
            words.push(word.to_owned());
        }
        let end = start + rest[start..].find('>').expect("a tag ends");
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        assert_eq!(tag.matches('"').count() % 2, 0, "<{tag}>");
        let name = tag
            .trim_start_matches('/')
            .split([' ', '/'])
            .next()
            .unwrap();
        assert!(name.chars().all(char::is_alphanumeric), "<{tag}>");
        if tag.starts_with('/') {
            assert_eq!(open.pop().as_deref(), Some(name));
        } else if !tag.ends_with('/') {
            open.push(name.to_owned());
        }
    }
    assert!(open.is_empty() && rest.trim().is_empty(), "{open:?}");
    words
}
