//! Lights, and the choice among them.

pub mod environment;
#[expect(
    clippy::module_inception,
    reason = "the shader's file is light/light.wgsl, and twins have one name"
)]
pub mod light;
pub mod punctual;
pub mod tree;
pub mod triangle;
