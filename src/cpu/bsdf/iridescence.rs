//! Iridescence: the same facets under a thin film (bsdf/thin_film).

use super::Bsdf;
use super::thin_film::F_thin_film;
use crate::shared::{GLTF_INSIDE, Tables};
use glam::DVec3;

/// Weights of F90 beyond this say nothing of F0.
pub const F90_WEIGHT_MAX: f64 = 0.999;

pub fn is_filmed(bsdf: &Bsdf) -> bool {
    bsdf.gltf.iridescence > 0.0 && bsdf.gltf.flags & GLTF_INSIDE == 0
}

/// Reflectance of a facet whose own is `F_base`.
pub fn F_filmed(tables: &Tables, bsdf: &Bsdf, cos_theta: f64, F_base: DVec3) -> DVec3 {
    if !is_filmed(bsdf) {
        return F_base;
    }
    // KHR_materials_iridescence, "Material": mixed by the factor.
    let g = bsdf.gltf;
    let film = F_thin_film(tables, cos_theta, g.film_ior, g.film_thickness, F_base);
    F_base.lerp(film, g.iridescence)
}

/// What a facet transmits that has `F_base` and `T_base` by itself.
pub fn T_filmed(
    tables: &Tables,
    bsdf: &Bsdf,
    cos_theta: f64,
    F_base: DVec3,
    T_base: DVec3,
) -> DVec3 {
    if !is_filmed(bsdf) {
        return T_base;
    }
    let g = bsdf.gltf;
    let film = F_thin_film(tables, cos_theta, g.film_ior, g.film_thickness, F_base);
    T_base.lerp(1.0 - film, g.iridescence)
}

/// The F0 of facets without a film that reflect towards `cos_theta` what filmed ones of F do; `weight` is
/// how far from F0 to F90 they are there.
pub fn F0_filmed(F: DVec3, F90: f64, weight: f64) -> DVec3 {
    // KHR_materials_iridescence, "Implementation notes": Schlick's form solved for F0.
    let w = weight.min(F90_WEIGHT_MAX);
    ((F - F90 * w) / (1.0 - w)).clamp(DVec3::ZERO, DVec3::ONE)
}
