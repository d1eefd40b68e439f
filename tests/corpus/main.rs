//! The corpus of glTF files that others made, on lavapipe.

#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

#[path = "../common/mod.rs"]
mod common;
mod every;
mod moving;
mod pairs;
mod parity;
#[path = "../common/picture.rs"]
mod picture;
mod reference;
mod reference_image;
