//! What light does that leaves rough facets only after meeting more than one of them. A model's single
//! scattering misses it: m(w) = 1 - E(w) of the light from w, M on average over the hemisphere.

use crate::cpu::math::INV_PI;
use glam::DVec3;

/// Averages of m are taken as this at least: m and M are differences of numbers near 1 that float32 knows
/// to 1e-7, and facets that miss less (alpha below 0.05) do so at grazing angles only.
pub const MISSING_MIN: f64 = 3e-3;

/// The lobe that returns m(wo) in a white furnace.
pub fn f_multiple(missing_o: DVec3, missing_i: DVec3, missing_average: DVec3) -> DVec3 {
    // Kelemen and Szirmay-Kalos 2001, "A Microfacet Based Coupled Specular-Matte BRDF Model with
    // Importance Sampling", eq. 14; Kulla and Conty 2017, "Revisiting Physically Based Shading at Imageworks".
    missing_o * missing_i * INV_PI / missing_average.max(DVec3::splat(MISSING_MIN))
}

/// The colour of that lobe where facets absorb what they do not reflect: `F_average` is their reflectance
/// averaged over the hemisphere, `E_average` = 1 - M.
pub fn F_multiple(F_average: DVec3, E_average: f64) -> DVec3 {
    // Kulla and Conty 2017: every bounce but the last takes F_average and meets another facet with
    // probability M; the sum of the series without its first term, over M.
    F_average * F_average * E_average / (1.0 - F_average * (1.0 - E_average))
}

/// The share of that lobe that goes through a boundary, when `T_average` of even light goes through its
/// facets. Reciprocal: seen from both sides, share times M is in the ratio of `T_average`, eta^2 : 1.
pub fn T_multiple(T_average: DVec3, missing_near: DVec3, missing_far: DVec3) -> DVec3 {
    // The side that misses less would otherwise have to pass more than it has.
    T_average * missing_near.min(missing_far) / missing_near.max(DVec3::splat(MISSING_MIN))
}
