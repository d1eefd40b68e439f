//! Rough diffuse surfaces: facets that are Lambertian themselves.

use crate::cpu::math::{INV_PI, PI, acos_accurate, safe_sqrt, sqr};
use glam::DVec3;

/// Constants of the Fujii Oren-Nayar model's albedo.
pub const FON_DIRECTIONAL: f64 = 0.5 - 2.0 / (3.0 * PI);
pub const FON_AVERAGE: f64 = 2.0 / 3.0 - 28.0 / (15.0 * PI);

/// The qualitative form; sigma is the standard deviation of the facets' angle, radians.
pub fn f_oren_nayar(reflectance: DVec3, sigma: f64, wo: DVec3, wi: DVec3) -> DVec3 {
    // Lecture, "Oren-Nayar"; Oren and Nayar 1994, "Generalization of Lambert's Reflectance Model", eq. 30.
    let sigma2 = sqr(sigma);
    let A = 1.0 - sigma2 / (2.0 * (sigma2 + 0.33));
    let B = 0.45 * sigma2 / (sigma2 + 0.09);
    // cos(phi_i - phi_o) sin alpha tan beta = cos(phi_i - phi_o) sin theta_i sin theta_o / cos beta.
    let projected = (wo.x * wi.x + wo.y * wi.y).max(0.0);
    reflectance * INV_PI * (A + B * projected / wo.z.max(wi.z))
}

/// (1 - E(mu)) / (r A) for the single-scattering albedo E = A (1 + r G(mu) / pi), A = 1 / (1 + FON_DIRECTIONAL r).
pub fn eon_missing(mu: f64) -> f64 {
    // Portsmouth, Kutz and Hill 2025, "EON: A Practical Energy-Preserving Rough Diffuse BRDF", the exact
    // G rather than the fit: it never overshoots, so neither does the white furnace.
    let s = safe_sqrt((1.0 - mu) * (1.0 + mu));
    // (1 - s^3) / mu = mu (1 + s + s^2) / (1 + s).
    let G = s * (acos_accurate(mu.min(1.0)) - s * mu)
        + (2.0 / 3.0) * (s * mu * (1.0 + s + s * s) / (1.0 + s) - s);
    (FON_DIRECTIONAL - G * INV_PI).max(0.0)
}

/// The energy-preserving form: single scattering after Fujii, and what is scattered more than once.
pub fn f_oren_nayar_eon(reflectance: DVec3, roughness: f64, wo: DVec3, wi: DVec3) -> DVec3 {
    // Portsmouth, Kutz and Hill 2025, "EON: A Practical Energy-Preserving Rough Diffuse BRDF".
    let s = wo.x * wi.x + wo.y * wi.y;
    let s_over_t = if s > 0.0 { s / wo.z.max(wi.z) } else { s };
    let A = 1.0 / (1.0 + FON_DIRECTIONAL * roughness);
    let single = reflectance * INV_PI * (A * (1.0 + roughness * s_over_t));
    // 1 - E(mu) = roughness A eon_missing(mu), and 1 - <E> = roughness A (FON_DIRECTIONAL - FON_AVERAGE).
    let average = A * (1.0 + FON_AVERAGE * roughness);
    let missing =
        roughness * A * (eon_missing(wo.z) * eon_missing(wi.z)) / (FON_DIRECTIONAL - FON_AVERAGE);
    let tint = reflectance * reflectance * average / (1.0 - reflectance * (1.0 - average));
    single + tint * INV_PI * missing
}
