//! What the loader makes of each feature of glTF 2.0, on files made in code and on those of others.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod animation;
mod asset;
mod choices;
mod compressed;
mod corpus;
mod draco;
mod environment;
#[cfg(feature = "basisu")]
mod etc1s_file;
mod extensions;
mod geometry;
mod ies;
mod image_based;
mod images;
mod info;
#[path = "../common/json_schema.rs"]
mod json_schema;
#[cfg(feature = "basisu")]
mod ktx2;
#[cfg(feature = "basisu")]
mod ktx2_file;
mod materials;
mod nodes;
mod oracle;
mod oracle_animation;
mod pointers;
mod strokes;

use glam::Vec3;
use snell::gltf::Loaded;
use snell::scene::Primitive;

fn only(loaded: &Loaded) -> &Primitive {
    &loaded.scene.meshes[0].primitives[0]
}

#[track_caller]
fn assert_close(a: impl Into<Vec3>, b: impl Into<Vec3>) {
    let (a, b) = (a.into(), b.into());
    assert!((a - b).length() < 1e-5, "{a} is not {b}");
}

fn noted(loaded: &Loaded, text: &str) -> bool {
    loaded.notes.iter().any(|note| note.contains(text))
}
