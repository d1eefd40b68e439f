// How the facets of a rough surface are oriented: D per solid angle of the facet normal wm, with
// the integral of D cos theta_m equal to 1.

import package::shared::{Bsdf, DISTRIBUTION_BLINN, DISTRIBUTION_ASHIKHMIN_SHIRLEY, DISTRIBUTION_BECKMANN, DISTRIBUTION_GGX};
import package::variant::{SMOOTH, ROUGH, ONLY_GGX};
import package::math::{PI, INV_PI, sqr, exp_accurate, expm1_accurate, log1p_accurate, sincos_accurate};
import package::bsdf::lobe::{MIN_COS, ALPHA_SMOOTH};

// Beyond this Beckmann's exponential is below float32's range.
const BECKMANN_FAR: f32 = 100.0;
// See facet_alpha.
const ANISOTROPIC_MARGIN: f32 = 0.28;

fn is_ggx(bsdf: Bsdf) -> bool {
    return ONLY_GGX || bsdf.distribution == DISTRIBUTION_GGX;
}

// The exponents of Blinn (twice the same) or Ashikhmin and Shirley.
fn facet_exponents(bsdf: Bsdf) -> vec2<f32> {
    let e = select(bsdf.alpha, bsdf.alpha.xx, bsdf.distribution == DISTRIBUTION_BLINN);
    return clamp(e, vec2(0.0), vec2(2.0 / sqr(ALPHA_SMOOTH) - 2.0));
}

// The widths of GGX or Beckmann along the tangent and across it; of the exponential distributions
// that of the Beckmann distribution with the same mean slope, which decides what they hide at grazing
// angles (at equal peaks, as in Walter et al. 2007, 5.2, their white furnace exceeds 1 by up to 15 %).
fn facet_alpha(bsdf: Bsdf) -> vec2<f32> {
    if is_ggx(bsdf) || bsdf.distribution == DISTRIBUTION_BECKMANN {
        return max(bsdf.alpha, vec2(ALPHA_SMOOTH));
    }
    // cos^e has slopes distributed as (1 + r^2)^(-(e + 4) / 2), whose mean is that of Beckmann's with
    // alpha = Gamma(n) / Gamma(n + 1/2), n = (e + 1) / 2; Watson 1959, "A note on gamma functions",
    // bounds the quotient from above within 1 %.
    let e = facet_exponents(bsdf);
    let n = 0.5 * (e + 1.0);
    let alpha = 1.0 / sqrt(n - 0.25 + 0.03125 / n);
    // Along the narrower axis the slopes of the wider one add up to 13 %; a fit to the integral, from above.
    return alpha * (1.0 + ANISOTROPIC_MARGIN * (1.0 - alpha / max(alpha.x, alpha.y)) / (min(e.x, e.y) + 1.0));
}

// Whether a lobe with these facets is a delta. One narrow axis does not make it one: facet_alpha
// widens that axis to ALPHA_SMOOTH.
fn is_smooth(bsdf: Bsdf) -> bool {
    if !SMOOTH {
        return false;
    }
    if !ROUGH {
        return true;
    }
    if is_ggx(bsdf) || bsdf.distribution == DISTRIBUTION_BECKMANN {
        return max(bsdf.alpha.x, bsdf.alpha.y) < ALPHA_SMOOTH;
    }
    let e = select(min(bsdf.alpha.x, bsdf.alpha.y), bsdf.alpha.x, bsdf.distribution == DISTRIBUTION_BLINN);
    return 2.0 / (e + 2.0) < sqr(ALPHA_SMOOTH);
}

// cos^e theta for a direction with the given squared tangent.
fn cos_power(tan2: f32, e: f32) -> f32 {
    // cos^2 = 1 / (1 + tan^2), exact for the small angles that a large exponent asks about.
    return exp_accurate(-0.5 * e * log1p_accurate(tan2));
}

fn tan2_theta(w: vec3<f32>) -> f32 {
    return (w.x * w.x + w.y * w.y) / sqr(max(w.z, MIN_COS));
}

fn D_blinn(wm: vec3<f32>, e: f32) -> f32 {
    // Lecture, "Microfacet Distribution": (e + 2) / (2 pi) cos^e theta.
    if wm.z <= 0.0 {
        return 0.0;
    }
    return (e + 2.0) * (0.5 * INV_PI) * cos_power(tan2_theta(wm), e);
}

fn D_ashikhmin_shirley(wm: vec3<f32>, e: vec2<f32>) -> f32 {
    // Lecture, "Microfacet Distribution"; Ashikhmin and Shirley 2000, "An Anisotropic Phong BRDF Model".
    if wm.z <= 0.0 {
        return 0.0;
    }
    let scale = sqrt((e.x + 2.0) * (e.y + 2.0)) * (0.5 * INV_PI);
    let sin2 = wm.x * wm.x + wm.y * wm.y;
    if sin2 <= 0.0 {
        return scale;
    }
    let exponent = (e.x * wm.x * wm.x + e.y * wm.y * wm.y) / sin2;
    return scale * cos_power(tan2_theta(wm), exponent);
}

fn D_beckmann(wm: vec3<f32>, alpha: vec2<f32>) -> f32 {
    // Walter et al. 2007, eq. 25, with an ellipse of slopes (Heitz 2014, eq. 85).
    if wm.z <= 0.0 {
        return 0.0;
    }
    let cos2 = sqr(max(wm.z, MIN_COS));
    let slope2 = (sqr(wm.x / alpha.x) + sqr(wm.y / alpha.y)) / cos2;
    if slope2 > BECKMANN_FAR {
        return 0.0;
    }
    return exp_accurate(-slope2) / (PI * alpha.x * alpha.y * cos2 * cos2);
}

fn D_ggx(wm: vec3<f32>, alpha: vec2<f32>) -> f32 {
    // Walter et al. 2007, eq. 33, with an ellipse of slopes (Heitz 2014, eq. 85).
    if wm.z <= 0.0 {
        return 0.0;
    }
    let stretched = sqr(wm.x / alpha.x) + sqr(wm.y / alpha.y) + sqr(wm.z);
    return 1.0 / (PI * alpha.x * alpha.y * sqr(stretched));
}

fn facet_D(bsdf: Bsdf, wm: vec3<f32>) -> f32 {
    if is_ggx(bsdf) {
        return D_ggx(wm, facet_alpha(bsdf));
    }
    switch bsdf.distribution {
        case DISTRIBUTION_BLINN: {
            return D_blinn(wm, facet_exponents(bsdf).x);
        }
        case DISTRIBUTION_ASHIKHMIN_SHIRLEY: {
            return D_ashikhmin_shirley(wm, facet_exponents(bsdf));
        }
        default: { // DISTRIBUTION_BECKMANN
            return D_beckmann(wm, facet_alpha(bsdf));
        }
    }
}

// A facet normal with density D cos theta of the exponential distributions.
fn sample_exponential(e: vec2<f32>, u: vec2<f32>) -> vec3<f32> {
    // The density of phi is proportional to 1 / ((ex + 2) cos^2 phi + (ey + 2) sin^2 phi), so
    // tan phi = sqrt((ex + 2) / (ey + 2)) tan(2 pi u), in all quadrants at once; and cos^(e(phi) + 2) = 1 - u.
    let turn = sincos_accurate(2.0 * PI * u.x);
    let ray = vec2(turn.y * sqrt(e.y + 2.0), turn.x * sqrt(e.x + 2.0));
    let direction = ray / sqrt(dot(ray, ray));
    let exponent = e.x * sqr(direction.x) + e.y * sqr(direction.y);
    let tan2 = expm1_accurate(-2.0 * log1p_accurate(-u.y) / (exponent + 2.0));
    let cos = 1.0 / sqrt(1.0 + tan2);
    return vec3(direction * (sqrt(tan2) * cos), cos);
}
