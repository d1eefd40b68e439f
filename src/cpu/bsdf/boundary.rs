//! The surface of glTF's dielectric part: what its facets reflect, and where the energy goes in sum.
//!
//! Opaque, the facets reflect by Schlick's form and absorb nothing: what they do not reflect meets the
//! diffuse part below. With `KHR_materials_transmission` the exact Fresnel term stands in for Schlick's
//! weight, F = F0 + (F90 - F0) (`F_dielectric` - p) / (1 - p) with p = `F_dielectric` at normal incidence: of
//! a neutral `KHR_materials_specular` (F0 = p, F90 = 1) that is `F_dielectric` itself. Where refraction has no
//! angle everything is reflected, whatever F90 says: light has nowhere else to go.

use super::Bsdf;
use super::albedo::{
    albedo_average_dielectric, albedo_average_ggx, albedo_average_smooth_dielectric,
    albedo_dielectric, albedo_ggx,
};
use super::distribution::is_smooth;
use super::fresnel::{F_dielectric, schlick_weight};
use super::lobe::{ETA_MATCHED, MIN_COS};
use super::multiple_scattering::{F_multiple, T_multiple};
use super::specular::is_totally_reflected;
use crate::cpu::math::sqr;
use crate::shared::{GLTF_THIN_WALLED, GLTF_TRANSMISSIVE, Tables};
use glam::{DVec2, DVec3};

/// Of white light from one direction, or of even light: what facets reflect, what they let pass, and
/// what is left for multiple scattering. The three add up to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    pub reflected: DVec3,
    pub transmitted: DVec3,
    pub missing: DVec3,
}

/// Whether the dielectric part has the exact Fresnel term. An index of 0 is glTF's word for "reflects
/// everything" and has no refraction: such a surface stays opaque.
pub fn is_transmissive(bsdf: &Bsdf) -> bool {
    bsdf.gltf.flags & GLTF_TRANSMISSIVE != 0 && bsdf.eta.x > 0.0
}

/// Whether light that is transmitted enters a medium, refracted.
pub fn is_refractive(bsdf: &Bsdf) -> bool {
    is_transmissive(bsdf) && bsdf.gltf.flags & GLTF_THIN_WALLED == 0
}

/// Whether light is transmitted as by a smooth boundary.
pub fn transmits_smoothly(bsdf: &Bsdf) -> bool {
    is_smooth(bsdf) || (is_refractive(bsdf) && (bsdf.eta.x - 1.0).abs() < ETA_MATCHED)
}

/// `F_dielectric` at normal incidence.
pub fn F_normal(eta: f64) -> f64 {
    sqr((eta - 1.0) / (eta + 1.0))
}

/// How far from F0 to F90 a facet's reflectance is.
pub fn boundary_weight(bsdf: &Bsdf, cos_theta: f64) -> f64 {
    if is_transmissive(bsdf) {
        let p = F_normal(bsdf.eta.x);
        return (F_dielectric(cos_theta, bsdf.eta.x) - p) / (1.0 - p);
    }
    schlick_weight(cos_theta)
}

/// Reflectance of a facet.
pub fn F_boundary(bsdf: &Bsdf, cos_theta: f64) -> DVec3 {
    if is_transmissive(bsdf) && is_totally_reflected(cos_theta, bsdf.eta.x) {
        return DVec3::ONE;
    }
    bsdf.gltf.F0 + (bsdf.gltf.F90 - bsdf.gltf.F0) * boundary_weight(bsdf, cos_theta)
}

/// 1 - `F_boundary` of a transmissive facet by its `T_dielectric`, without the cancellation where F is
/// nearly 1.
pub fn T_boundary(bsdf: &Bsdf, T: f64) -> DVec3 {
    if T <= 0.0 {
        return DVec3::ZERO;
    }
    1.0 - bsdf.gltf.F90 + (bsdf.gltf.F90 - bsdf.gltf.F0) * (T / (1.0 - F_normal(bsdf.eta.x)))
}

/// Where the energy goes, from the albedo of facets that reflect by Schlick's form (`white`, factors of
/// F0 and F90) and by the exact Fresnel term (`plain`, reflected and in all), from one direction or on
/// average. `eta` may be that of the other side.
pub fn boundary_energy(bsdf: &Bsdf, F0: DVec3, eta: f64, white: DVec2, plain: DVec2) -> Energy {
    let F90 = bsdf.gltf.F90;
    let all = white.x + white.y;
    let missing_white = if is_smooth(bsdf) {
        0.0
    } else {
        (1.0 - all).max(0.0)
    };
    if !is_transmissive(bsdf) {
        return Energy {
            reflected: F0 * white.x + F90 * white.y,
            transmitted: (1.0 - F0) * white.x + (1.0 - F90) * white.y,
            missing: DVec3::splat(missing_white),
        };
    }
    let p = F_normal(eta);
    let weight = (plain.x - p * all) / (1.0 - p);
    let reflected = F0 * all + (F90 - F0) * weight;
    if !is_refractive(bsdf) {
        return Energy {
            reflected,
            transmitted: (all - reflected).max(DVec3::ZERO),
            missing: DVec3::splat(missing_white),
        };
    }
    let lossless = is_smooth(bsdf) || (eta - 1.0).abs() < ETA_MATCHED;
    let share = (plain.y - plain.x) / (1.0 - p);
    // What facets without reflectance (F90 = 0) would pass, estimated: from outside by the mean F of facets,
    // from inside by that of those that do not reflect totally, which is about p.
    let F = if eta < 1.0 {
        p
    } else {
        plain.x / all.max(MIN_COS)
    };
    let mut whole = ((plain.y - plain.x) / (1.0 - F).max(MIN_COS)).min(1.0);
    if lossless {
        whole = f64::from(u8::from(share > 0.0));
    }
    let transmitted = (F90 - F0) * share + (1.0 - F90) * whole;
    // Total reflection does not ask for F90.
    let total = (1.0 - F90) * if eta < 1.0 { weight.max(0.0) } else { 0.0 };
    let rest = (1.0 - (reflected + total) - transmitted).max(DVec3::ZERO);
    Energy {
        reflected: reflected + total,
        transmitted,
        missing: if lossless { DVec3::ZERO } else { rest },
    }
}

pub fn boundary_energy_at(
    tables: &Tables,
    bsdf: &Bsdf,
    F0: DVec3,
    eta: f64,
    roughness: f64,
    cos_theta: f64,
) -> Energy {
    let mut plain = DVec2::ZERO;
    if is_transmissive(bsdf) {
        plain = if is_smooth(bsdf) {
            DVec2::new(F_dielectric(cos_theta, eta), 1.0)
        } else {
            albedo_dielectric(tables, cos_theta, roughness, eta)
        };
    }
    let white = albedo_ggx(tables, cos_theta, roughness, is_smooth(bsdf));
    boundary_energy(bsdf, F0, eta, white, plain)
}

pub fn boundary_energy_average(
    tables: &Tables,
    bsdf: &Bsdf,
    F0: DVec3,
    eta: f64,
    roughness: f64,
) -> Energy {
    let mut plain = DVec2::ZERO;
    if is_transmissive(bsdf) {
        plain = albedo_average_dielectric(tables, roughness, eta);
    }
    let white = albedo_average_ggx(tables, roughness, is_smooth(bsdf));
    boundary_energy(bsdf, F0, eta, white, plain)
}

/// What smooth facets let pass of even light that enters the denser side; 0 of an opaque surface.
pub fn T_entering_average(tables: &Tables, bsdf: &Bsdf, F0: DVec3, eta: f64) -> DVec3 {
    if !is_transmissive(bsdf) {
        return DVec3::ZERO;
    }
    let F90 = bsdf.gltf.F90;
    let dense = eta.max(1.0 / eta);
    let share = (1.0 - albedo_average_smooth_dielectric(tables, dense)) / (1.0 - F_normal(dense));
    1.0 - F90 + (F90 - F0) * share
}

/// The share of what is missing that comes back out by reflection at last; of an opaque surface the rest
/// is with the diffuse part below, of a transmissive one it is on the other side. `entering` is that of
/// `T_entering_average`; the denser side sees 1 / eta^2 of it (all of it that is not totally reflected), so
/// that what passes is reciprocal by construction.
pub fn boundary_returned(
    bsdf: &Bsdf,
    F0: DVec3,
    entering: DVec3,
    eta: f64,
    near: Energy,
    far: Energy,
) -> DVec3 {
    if is_transmissive(bsdf) {
        let mut T_average = entering;
        if eta < 1.0 && is_refractive(bsdf) {
            T_average *= eta * eta;
        }
        return 1.0 - T_multiple(T_average, near.missing, far.missing);
    }
    let F_average = F0 + (bsdf.gltf.F90 - F0) / 21.0;
    F_multiple(F_average, 1.0 - near.missing.x)
}
