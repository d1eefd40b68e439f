//! The reference: the renderer in float64, file for file the twin of `shaders/`.
//!
//! A twin has the functions of its shader in the same order and under the same names; where the
//! shader reads a binding, the twin takes the packed scene as its first argument.
#![allow(
    non_snake_case,
    reason = "functions are named by the field's letters: D, G1, F, Le"
)]

pub mod alpha;
pub mod attributes;
pub mod bsdf;
pub mod bvh;
pub mod camera;
pub mod erf;
pub mod estimator;
pub mod exact;
pub mod filter;
pub mod intersect;
pub mod light;
pub mod material;
pub mod math;
pub mod medium;
pub mod path;
pub mod ray;
pub mod render;
pub mod rng;
pub mod sample;
pub mod sobol;
pub mod spectrum;
pub mod surface;
pub mod texture;
pub mod transform;
pub mod visibility;
