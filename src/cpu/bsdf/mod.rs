//! The reflection models, file for file the twins of `shaders/bsdf`.

use crate::shared;
use glam::{DVec2, DVec3};

pub mod albedo;
pub mod boundary;
#[allow(
    clippy::module_inception,
    reason = "the twin of shaders/bsdf/bsdf.wgsl, which puts the models of this folder together"
)]
pub mod bsdf;
pub mod coat;
pub mod dielectric;
pub mod distribution;
pub mod fresnel;
pub mod gltf;
pub mod iridescence;
pub mod lambertian;
pub mod lobe;
pub mod masking;
pub mod multiple_scattering;
pub mod oren_nayar;
pub mod sheen;
pub mod specular;
pub mod thin_film;
pub mod torrance_sparrow;
pub mod transmission;
pub mod visible_normal;

/// A reflection model with its parameters: `shared::Bsdf` in float64.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bsdf {
    /// Diffuse albedo, or the factor of a specular lobe; glTF: base colour.
    pub reflectance: DVec3,
    pub model: u32,
    /// Conductor: index; constant: reflectance; Schlick: F0; dielectric: x is far over near, seen from wo.
    pub eta: DVec3,
    pub fresnel: u32,
    pub k: DVec3,
    pub distribution: u32,
    pub alpha: DVec2,
    /// Oren-Nayar: sigma in radians; EON: roughness; glTF's.
    pub roughness: f64,
    pub masking: u32,
    pub gltf: Gltf,
}

/// What glTF's extensions add: `shared::Gltf` in float64.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gltf {
    pub F0: DVec3,
    pub F90: f64,
    pub metallic: f64,
    pub transmission: f64,
    pub rotation: DVec2,
    pub diffuse_transmission_color: DVec3,
    pub diffuse_transmission: f64,
    pub sheen_color: DVec3,
    pub sheen_roughness: f64,
    pub coat_normal: DVec3,
    pub coat: f64,
    pub coat_roughness: f64,
    pub iridescence: f64,
    pub film_ior: f64,
    pub film_thickness: f64,
    pub flags: u32,
}

impl From<&shared::Bsdf> for Bsdf {
    fn from(bsdf: &shared::Bsdf) -> Self {
        let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let pair = |v: [f32; 2]| DVec2::from_array(v.map(f64::from));
        let gltf = &bsdf.gltf;
        Self {
            reflectance: vector(bsdf.reflectance),
            model: bsdf.model,
            eta: vector(bsdf.eta),
            fresnel: bsdf.fresnel,
            k: vector(bsdf.k),
            distribution: bsdf.distribution,
            alpha: pair(bsdf.alpha),
            roughness: f64::from(bsdf.roughness),
            masking: bsdf.masking,
            gltf: Gltf {
                F0: vector(gltf.F0),
                F90: f64::from(gltf.F90),
                metallic: f64::from(gltf.metallic),
                transmission: f64::from(gltf.transmission),
                rotation: pair(gltf.rotation),
                diffuse_transmission_color: vector(gltf.diffuse_transmission_color),
                diffuse_transmission: f64::from(gltf.diffuse_transmission),
                sheen_color: vector(gltf.sheen_color),
                sheen_roughness: f64::from(gltf.sheen_roughness),
                coat_normal: vector(gltf.coat_normal),
                coat: f64::from(gltf.coat),
                coat_roughness: f64::from(gltf.coat_roughness),
                iridescence: f64::from(gltf.iridescence),
                film_ior: f64::from(gltf.film_ior),
                film_thickness: f64::from(gltf.film_thickness),
                flags: gltf.flags,
            },
        }
    }
}

/// Rounded to what the kernels hold.
impl From<&Bsdf> for shared::Bsdf {
    fn from(bsdf: &Bsdf) -> Self {
        let vector = |v: DVec3| v.as_vec3().to_array();
        let pair = |v: DVec2| v.as_vec2().to_array();
        let gltf = &bsdf.gltf;
        Self {
            reflectance: vector(bsdf.reflectance),
            model: bsdf.model,
            eta: vector(bsdf.eta),
            fresnel: bsdf.fresnel,
            k: vector(bsdf.k),
            distribution: bsdf.distribution,
            alpha: pair(bsdf.alpha),
            roughness: bsdf.roughness as f32,
            masking: bsdf.masking,
            gltf: shared::Gltf {
                F0: vector(gltf.F0),
                F90: gltf.F90 as f32,
                metallic: gltf.metallic as f32,
                transmission: gltf.transmission as f32,
                rotation: pair(gltf.rotation),
                diffuse_transmission_color: vector(gltf.diffuse_transmission_color),
                diffuse_transmission: gltf.diffuse_transmission as f32,
                sheen_color: vector(gltf.sheen_color),
                sheen_roughness: gltf.sheen_roughness as f32,
                coat_normal: vector(gltf.coat_normal),
                coat: gltf.coat as f32,
                coat_roughness: gltf.coat_roughness as f32,
                iridescence: gltf.iridescence as f32,
                film_ior: gltf.film_ior as f32,
                film_thickness: gltf.film_thickness as f32,
                flags: gltf.flags,
                ..shared::Gltf::default()
            },
        }
    }
}
