//! What of a light comes straight to a surface.

use super::bsdf::bsdf::straight_transmittance;
use super::bvh::{trace_any, trace_closest};
use super::material::bsdf_at;
use super::math::to_local;
use super::ray::Ray;
use super::surface::surface_at;
use crate::pack::Packed;
use crate::shared::{MATERIAL_THIN_WALLED, NONE};
use glam::DVec3;

/// The part of light that comes along a ray from its end: smooth thin walls tint it, everything else
/// blocks it. That is just what a path finds that goes on straight through such walls, so that both can
/// be weighted against each other. `ior`: index of the medium that the ray is in; `walls`: how many the
/// path could still pass.
///
/// Media that overlap hide boundaries, but for these rays they are surfaces too: a path passes them as a
/// delta, and finds the light beyond by itself.
pub fn visibility(packed: &Packed, ray: Ray, ior: f64, walls: u32, alpha_seed: u32) -> DVec3 {
    if packed.frame.has_thin_walls == 0 {
        return match trace_any(packed, ray, alpha_seed) {
            true => DVec3::ZERO,
            false => DVec3::ONE,
        };
    }
    let mut passed = DVec3::ONE;
    let mut ahead = ray;
    for _ in 0..=walls {
        let hit = trace_closest(packed, ahead, alpha_seed);
        if hit.instance == NONE {
            return passed;
        }
        let surface = surface_at(packed, ahead, hit);
        let material = &packed.materials[surface.material as usize];
        if material.flags & MATERIAL_THIN_WALLED == 0 {
            break;
        }
        let bsdf = bsdf_at(packed, material, &surface, f64::from(material.ior) / ior);
        let wo = to_local(surface.basis, -ray.direction);
        passed *= straight_transmittance(&packed.tables, &bsdf, wo);
        if passed == DVec3::ZERO {
            break;
        }
        ahead.t_min = hit.t;
    }
    DVec3::ZERO
}
