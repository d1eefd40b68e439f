// A layer of fibres that stand off the surface (KHR_materials_sheen): f = D(wm) G / (4 cos theta_o
// cos theta_i) without its colour. alpha is sheen roughness squared; below ALPHA_SMOOTH it is taken as
// ALPHA_SMOOTH, where only directions within some 2 degrees of the surface see the fibres at all.
//
// The formulas are the extension's normative ones, fit of Lambda included. The fit hides too little near
// the horizon where roughness is below 0.26: there the layer alone reflects more than it gets within 3
// degrees of grazing (1.02 at 0.25, 2.1 at 0.1), which whoever puts it over a base has to scale away.

import package::bsdf::lobe::{ALPHA_SMOOTH, is_reflected};
import package::bsdf::torrance_sparrow::{half_vector};
import package::math::{INV_PI, sqr, exp_accurate, log_accurate, log1p_accurate, pow_accurate};

fn D_charlie(wm: vec3<f32>, alpha: f32) -> f32 {
    // Estevez and Kulla 2017, "Production Friendly Microfacet Sheen BRDF", section 2:
    // (2 + 1 / alpha) sin^(1 / alpha) theta / (2 pi).
    if wm.z <= 0.0 {
        return 0.0;
    }
    let e = 1.0 / max(alpha, ALPHA_SMOOTH);
    let sin2 = wm.x * wm.x + wm.y * wm.y;
    if sin2 <= 0.0 {
        return 0.0;
    }
    // ln sin^2 by the smaller of the two squares, whose rounding a large exponent does not raise.
    let ln_sin2 = select(log_accurate(sin2), log1p_accurate(-wm.z * wm.z), wm.z * wm.z < 0.5);
    return (2.0 + e) * (0.5 * INV_PI) * exp_accurate(0.5 * e * ln_sin2);
}

// The fit to ln Lambda up to 60 degrees from grazing, as a function of the cosine.
fn ln_Lambda_charlie(x: f32, alpha: f32) -> f32 {
    // Estevez and Kulla 2017, table 1: the row of roughness 0 and that of 1, mixed by (1 - alpha)^2.
    let t = sqr(1.0 - alpha);
    let a = mix(21.5473, 25.3245, t);
    let b = mix(3.82987, 3.32435, t);
    let c = mix(0.19823, 0.16801, t);
    let d = mix(-1.97760, -1.27393, t);
    let e = mix(-4.32054, -4.85967, t);
    return a / (1.0 + b * pow_accurate(x, c)) + d * x + e;
}

// Smith's Lambda of the same facets, fitted.
fn Lambda_charlie(cos_theta: f32, alpha: f32) -> f32 {
    // Estevez and Kulla 2017, section 3: beyond 60 degrees from grazing by point symmetry there.
    let width = clamp(alpha, ALPHA_SMOOTH, 1.0);
    if cos_theta < 0.5 {
        return exp_accurate(ln_Lambda_charlie(max(cos_theta, 0.0), width));
    }
    return exp_accurate(2.0 * ln_Lambda_charlie(0.5, width) - ln_Lambda_charlie(max(1.0 - cos_theta, 0.0), width));
}

fn f_sheen(roughness: f32, wo: vec3<f32>, wi: vec3<f32>) -> f32 {
    // KHR_materials_sheen, "Sheen distribution" and "Sheen visibility".
    if !is_reflected(wo, wi) {
        return 0.0;
    }
    let alpha = sqr(roughness);
    let wm = half_vector(wo, wi).xyz;
    let Lambda_o = Lambda_charlie(wo.z, alpha);
    let Lambda_i = Lambda_charlie(wi.z, alpha);
    return D_charlie(wm, alpha) / ((1.0 + (Lambda_o + Lambda_i)) * (4.0 * wo.z * wi.z));
}
