//! The reflection models, file for file the twins of `shaders/bsdf`.

use crate::shared;
use glam::{DVec2, DVec3};

pub mod albedo;
#[allow(
    clippy::module_inception,
    reason = "the twin of shaders/bsdf/bsdf.wgsl, which puts the models of this folder together"
)]
pub mod bsdf;
pub mod dielectric;
pub mod distribution;
pub mod fresnel;
pub mod lambertian;
pub mod lobe;
pub mod masking;
pub mod metallic_roughness;
pub mod oren_nayar;
pub mod specular;
pub mod torrance_sparrow;
pub mod visible_normal;

/// A reflection model with its parameters: `shared::Bsdf` in float64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bsdf {
    /// Diffuse albedo, or the factor of a specular lobe.
    pub reflectance: DVec3,
    pub model: u32,
    /// Conductor: index; constant: reflectance; Schlick: F0; dielectric: x is far over near, seen from wo.
    pub eta: DVec3,
    pub fresnel: u32,
    pub k: DVec3,
    pub distribution: u32,
    pub alpha: DVec2,
    /// Oren-Nayar: sigma in radians; EON: roughness; metallic-roughness: glTF's.
    pub roughness: f64,
    pub masking: u32,
}

impl From<&shared::Bsdf> for Bsdf {
    fn from(bsdf: &shared::Bsdf) -> Self {
        let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        Self {
            reflectance: vector(bsdf.reflectance),
            model: bsdf.model,
            eta: vector(bsdf.eta),
            fresnel: bsdf.fresnel,
            k: vector(bsdf.k),
            distribution: bsdf.distribution,
            alpha: DVec2::from_array(bsdf.alpha.map(f64::from)),
            roughness: f64::from(bsdf.roughness),
            masking: bsdf.masking,
        }
    }
}
