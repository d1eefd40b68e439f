// Rough diffuse surfaces: facets that are Lambertian themselves.

import package::math::{PI, INV_PI, sqr, safe_sqrt, acos_accurate};

// 1/2 - 2/(3 pi) and 2/3 - 28/(15 pi), constants of the Fujii Oren-Nayar model's albedo.
const FON_DIRECTIONAL: f32 = 0.287793409210551;
const FON_AVERAGE: f32 = 0.0724882124569240;

// The qualitative form; sigma is the standard deviation of the facets' angle, radians.
fn f_oren_nayar(reflectance: vec3<f32>, sigma: f32, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    // Lecture, "Oren-Nayar"; Oren and Nayar 1994, "Generalization of Lambert's Reflectance Model", eq. 30.
    let sigma2 = sqr(sigma);
    let A = 1.0 - sigma2 / (2.0 * (sigma2 + 0.33));
    let B = 0.45 * sigma2 / (sigma2 + 0.09);
    // cos(phi_i - phi_o) sin alpha tan beta = cos(phi_i - phi_o) sin theta_i sin theta_o / cos beta.
    let projected = max(0.0, wo.x * wi.x + wo.y * wi.y);
    return reflectance * INV_PI * (A + B * projected / max(wo.z, wi.z));
}

// (1 - E(mu)) / (r A) for the single-scattering albedo E = A (1 + r G(mu) / pi), A = 1 / (1 + FON_DIRECTIONAL r).
fn eon_missing(mu: f32) -> f32 {
    // Portsmouth, Kutz and Hill 2025, "EON: A Practical Energy-Preserving Rough Diffuse BRDF", the exact
    // G rather than the fit: it never overshoots, so neither does the white furnace.
    let s = safe_sqrt((1.0 - mu) * (1.0 + mu));
    // (1 - s^3) / mu = mu (1 + s + s^2) / (1 + s).
    let G = s * (acos_accurate(min(mu, 1.0)) - s * mu)
        + (2.0 / 3.0) * (s * mu * (1.0 + s + s * s) / (1.0 + s) - s);
    return max(0.0, FON_DIRECTIONAL - G * INV_PI);
}

// The energy-preserving form: single scattering after Fujii, and what is scattered more than once.
fn f_oren_nayar_eon(reflectance: vec3<f32>, roughness: f32, wo: vec3<f32>, wi: vec3<f32>) -> vec3<f32> {
    // Portsmouth, Kutz and Hill 2025, "EON: A Practical Energy-Preserving Rough Diffuse BRDF".
    let s = wo.x * wi.x + wo.y * wi.y;
    let s_over_t = select(s, s / max(wo.z, wi.z), s > 0.0);
    let A = 1.0 / (1.0 + FON_DIRECTIONAL * roughness);
    let single = reflectance * INV_PI * (A * (1.0 + roughness * s_over_t));
    // 1 - E(mu) = roughness A eon_missing(mu), and 1 - <E> = roughness A (FON_DIRECTIONAL - FON_AVERAGE).
    let average = A * (1.0 + FON_AVERAGE * roughness);
    let missing = roughness * A * (eon_missing(wo.z) * eon_missing(wi.z)) / (FON_DIRECTIONAL - FON_AVERAGE);
    let tint = reflectance * reflectance * average / (1.0 - reflectance * (1.0 - average));
    return single + tint * INV_PI * missing;
}
