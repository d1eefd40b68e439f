//! How the facets of a rough surface are oriented: D per solid angle of the facet normal wm, with
//! the integral of D cos theta_m equal to 1.

use super::Bsdf;
use super::lobe::{ALPHA_SMOOTH, MIN_COS};
use crate::cpu::math::{
    INV_PI, PI, exp_accurate, expm1_accurate, log1p_accurate, sincos_accurate, sqr,
};
use crate::shared::{
    DISTRIBUTION_ASHIKHMIN_SHIRLEY, DISTRIBUTION_BECKMANN, DISTRIBUTION_BLINN, DISTRIBUTION_GGX,
};
use glam::{DVec2, DVec3};

/// Beyond this Beckmann's exponential is below float32's range, and is 0 in both renderers.
pub const BECKMANN_FAR: f64 = 100.0;
/// See `facet_alpha`.
pub const ANISOTROPIC_MARGIN: f64 = 0.28;

pub fn is_ggx(bsdf: &Bsdf) -> bool {
    bsdf.distribution == DISTRIBUTION_GGX
}

/// The exponents of Blinn (twice the same) or Ashikhmin and Shirley.
pub fn facet_exponents(bsdf: &Bsdf) -> DVec2 {
    let blinn = bsdf.distribution == DISTRIBUTION_BLINN;
    let e = if blinn {
        DVec2::splat(bsdf.alpha.x)
    } else {
        bsdf.alpha
    };
    e.clamp(DVec2::ZERO, DVec2::splat(2.0 / sqr(ALPHA_SMOOTH) - 2.0))
}

/// The widths of GGX or Beckmann along the tangent and across it; of the exponential distributions
/// that of the Beckmann distribution with the same mean slope, which decides what they hide at grazing
/// angles (at equal peaks, as in Walter et al. 2007, 5.2, their white furnace exceeds 1 by up to 15 %).
pub fn facet_alpha(bsdf: &Bsdf) -> DVec2 {
    if is_ggx(bsdf) || bsdf.distribution == DISTRIBUTION_BECKMANN {
        return bsdf.alpha.max(DVec2::splat(ALPHA_SMOOTH));
    }
    // cos^e has slopes distributed as (1 + r^2)^(-(e + 4) / 2), whose mean is that of Beckmann's with
    // alpha = Gamma(n) / Gamma(n + 1/2), n = (e + 1) / 2; Watson 1959, "A note on gamma functions",
    // bounds the quotient from above within 1 %.
    let e = facet_exponents(bsdf);
    let n = 0.5 * (e + 1.0);
    let alpha = (n - 0.25 + 0.03125 / n).powf(-0.5);
    // Along the narrower axis the slopes of the wider one add up to 13 %; a fit to the integral, from above.
    alpha
        * (1.0 + ANISOTROPIC_MARGIN * (1.0 - alpha / alpha.max_element()) / (e.min_element() + 1.0))
}

/// Whether a lobe with these facets is a delta. One narrow axis does not make it one: `facet_alpha`
/// widens that axis to `ALPHA_SMOOTH`.
pub fn is_smooth(bsdf: &Bsdf) -> bool {
    if is_ggx(bsdf) || bsdf.distribution == DISTRIBUTION_BECKMANN {
        return bsdf.alpha.max_element() < ALPHA_SMOOTH;
    }
    let e = if bsdf.distribution == DISTRIBUTION_BLINN {
        bsdf.alpha.x
    } else {
        bsdf.alpha.min_element()
    };
    2.0 / (e + 2.0) < sqr(ALPHA_SMOOTH)
}

/// cos^e theta for a direction with the given squared tangent.
pub fn cos_power(tan2: f64, e: f64) -> f64 {
    // cos^2 = 1 / (1 + tan^2), exact for the small angles that a large exponent asks about.
    exp_accurate(-0.5 * e * log1p_accurate(tan2))
}

pub fn tan2_theta(w: DVec3) -> f64 {
    (w.x * w.x + w.y * w.y) / sqr(w.z.max(MIN_COS))
}

pub fn D_blinn(wm: DVec3, e: f64) -> f64 {
    // Lecture, "Microfacet Distribution": (e + 2) / (2 pi) cos^e theta.
    if wm.z <= 0.0 {
        return 0.0;
    }
    (e + 2.0) * (0.5 * INV_PI) * cos_power(tan2_theta(wm), e)
}

pub fn D_ashikhmin_shirley(wm: DVec3, e: DVec2) -> f64 {
    // Lecture, "Microfacet Distribution"; Ashikhmin and Shirley 2000, "An Anisotropic Phong BRDF Model".
    if wm.z <= 0.0 {
        return 0.0;
    }
    let scale = ((e.x + 2.0) * (e.y + 2.0)).sqrt() * (0.5 * INV_PI);
    let sin2 = wm.x * wm.x + wm.y * wm.y;
    if sin2 <= 0.0 {
        return scale;
    }
    let exponent = (e.x * wm.x * wm.x + e.y * wm.y * wm.y) / sin2;
    scale * cos_power(tan2_theta(wm), exponent)
}

pub fn D_beckmann(wm: DVec3, alpha: DVec2) -> f64 {
    // Walter et al. 2007, eq. 25, with an ellipse of slopes (Heitz 2014, eq. 85).
    if wm.z <= 0.0 {
        return 0.0;
    }
    let cos2 = sqr(wm.z.max(MIN_COS));
    let slope2 = (sqr(wm.x / alpha.x) + sqr(wm.y / alpha.y)) / cos2;
    if slope2 > BECKMANN_FAR {
        return 0.0;
    }
    exp_accurate(-slope2) / (PI * alpha.x * alpha.y * cos2 * cos2)
}

pub fn D_ggx(wm: DVec3, alpha: DVec2) -> f64 {
    // Walter et al. 2007, eq. 33, with an ellipse of slopes (Heitz 2014, eq. 85).
    if wm.z <= 0.0 {
        return 0.0;
    }
    let stretched = sqr(wm.x / alpha.x) + sqr(wm.y / alpha.y) + sqr(wm.z);
    1.0 / (PI * alpha.x * alpha.y * sqr(stretched))
}

pub fn facet_D(bsdf: &Bsdf, wm: DVec3) -> f64 {
    match bsdf.distribution {
        DISTRIBUTION_BLINN => D_blinn(wm, facet_exponents(bsdf).x),
        DISTRIBUTION_ASHIKHMIN_SHIRLEY => D_ashikhmin_shirley(wm, facet_exponents(bsdf)),
        DISTRIBUTION_BECKMANN => D_beckmann(wm, facet_alpha(bsdf)),
        _ => D_ggx(wm, facet_alpha(bsdf)), // DISTRIBUTION_GGX
    }
}

/// A facet normal with density D cos theta of the exponential distributions.
pub fn sample_exponential(e: DVec2, u: DVec2) -> DVec3 {
    // The density of phi is proportional to 1 / ((ex + 2) cos^2 phi + (ey + 2) sin^2 phi), so
    // tan phi = sqrt((ex + 2) / (ey + 2)) tan(2 pi u), in all quadrants at once; and cos^(e(phi) + 2) = 1 - u.
    let turn = sincos_accurate(2.0 * PI * u.x);
    let ray = DVec2::new(turn.y * (e.y + 2.0).sqrt(), turn.x * (e.x + 2.0).sqrt());
    let direction = ray / ray.dot(ray).sqrt();
    let exponent = e.x * sqr(direction.x) + e.y * sqr(direction.y);
    let tan2 = expm1_accurate(-2.0 * log1p_accurate(-u.y) / (exponent + 2.0));
    let cos = 1.0 / (1.0 + tan2).sqrt();
    (direction * (tan2.sqrt() * cos)).extend(cos)
}
