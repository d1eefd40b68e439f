//! The program as its users meet it: exit statuses, messages, files written and not written.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod bench;
#[path = "../common/json_schema.rs"]
mod json_schema;
mod moment;
mod pictures;
mod place;
mod record;
mod sequence;
mod status;
