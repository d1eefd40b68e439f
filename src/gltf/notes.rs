//! What a file holds that a picture will not show, said once each.

use std::collections::BTreeMap;

/// Messages, each with the places that it is about.
#[derive(Default)]
pub struct Notes {
    places: BTreeMap<String, Vec<String>>,
}

impl Notes {
    pub fn add(&mut self, message: impl Into<String>, at: &str) {
        let places = self.places.entry(message.into()).or_default();
        if places.last().is_none_or(|last| last != at) {
            places.push(at.to_owned());
        }
    }

    /// One line for each message: `message (first place, second place and 3 more)`.
    pub fn into_lines(self) -> Vec<String> {
        const NAMED: usize = 3;
        self.places
            .into_iter()
            .map(|(message, mut places)| {
                places.retain(|place| !place.is_empty());
                let more = places.len().saturating_sub(NAMED);
                places.truncate(NAMED);
                match (places.is_empty(), more) {
                    (true, _) => message,
                    (_, 0) => format!("{message} ({})", places.join(", ")),
                    _ => format!("{message} ({} and {more} more)", places.join(", ")),
                }
            })
            .collect()
    }
}
