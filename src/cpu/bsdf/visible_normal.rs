//! Facet normals drawn as often as a viewer sees them, with density G1(wo) D(wm) (wo . wm) / cos theta_o.

use crate::cpu::erf::{SQRT_PI, erfc_accurate, normal_quantile};
use crate::cpu::math::{PI, exp_accurate, normalize_accurate, sincos_accurate, sqr};
use glam::{DVec2, DVec3};

/// Beckmann slopes beyond this are rarer than float32's smallest u.
pub const SLOPE_FAR: f64 = 6.0;
/// The search for a slope ends when a step is smaller than this, or after so many steps.
pub const SLOPE_TOLERANCE: f64 = 1e-13;
pub const SLOPE_STEPS: i32 = 64;

/// The view in the space where the surface has roughness 1.
pub fn stretched_view(wo: DVec3, alpha: DVec2) -> DVec3 {
    normalize_accurate((alpha * wo.truncate()).extend(wo.z))
}

/// The visible normal of a point u on the cap z > (rest - 1) view.z of mirrored directions in that space.
pub fn sample_cap(view: DVec3, rest: f64, alpha: DVec2, u: DVec2) -> DVec3 {
    // Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps", listing 3: over the cap
    // z > -view.z visible normals make them uniform.
    let turn = sincos_accurate(2.0 * PI * u.x);
    // z = (1 - u) (1 + b) - b with b = (1 - rest) view.z; 1 - z, 1 + z and z + view.z without cancellation.
    let above = rest * view.z; // of the cap's edge over the mirrored view
    let width = (1.0 + view.z) - above;
    let sin = (u.y * width * ((1.0 - view.z) + above + (1.0 - u.y) * width)).sqrt();
    let sum = DVec3::new(
        sin * turn.y + view.x,
        sin * turn.x + view.y,
        (1.0 - u.y) * width + above,
    );
    normalize_accurate((alpha * sum.truncate()).extend(sum.z))
}

pub fn sample_visible_ggx(wo: DVec3, alpha: DVec2, u: DVec2) -> DVec3 {
    sample_cap(stretched_view(wo, alpha), 0.0, alpha, u)
}

/// 1 - k, where the mirrored directions above the surface lie in the cap z > -k view.z.
pub fn bounded_cap_rest(wo: DVec3, alpha: DVec2) -> f64 {
    // Eto and Tokuyoshi 2023, "Bounded VNDF Sampling for Smith-GGX Reflections", with the narrower axis:
    // k = (1 - a^2) s^2 / (s^2 + a^2 cos^2), s = 1 + sin.
    let a2 = sqr(alpha.min_element().min(1.0));
    let s2 = sqr(1.0 + (wo.x * wo.x + wo.y * wo.y).sqrt());
    a2 * (s2 + sqr(wo.z)) / (s2 + a2 * sqr(wo.z))
}

/// Visible normals for reflection alone: few of those that mirror wo into the surface.
pub fn sample_bounded_visible_ggx(wo: DVec3, alpha: DVec2, u: DVec2) -> DVec3 {
    sample_cap(
        stretched_view(wo, alpha),
        bounded_cap_rest(wo, alpha),
        alpha,
        u,
    )
}

/// Density of the mirrored direction, per its own solid angle; D is that of its facet.
pub fn pdf_bounded_visible_ggx(wo: DVec3, alpha: DVec2, D: f64) -> f64 {
    // Eto and Tokuyoshi 2023: the cap's area is 1 + k view.z where it was 1 + view.z, so that
    // G1 D / (4 cos_o) = D / (2 (t + cos_o)) becomes D / (2 (t + k cos_o)), t the stretched view's length.
    let stretched = (alpha * wo.truncate()).extend(wo.z);
    let k = 1.0 - bounded_cap_rest(wo, alpha);
    D / (2.0 * (stretched.dot(stretched).sqrt() + k * wo.z))
}

/// Probability that a visible Beckmann slope along the view is below x, times a constant.
pub fn visible_slope_mass(x: f64, view_cos: f64, view_sin: f64) -> f64 {
    // The integral of (cos - s sin) e^(-s^2) / sqrt(pi) over s up to x.
    view_cos * 0.5 * erfc_accurate(-x) + view_sin * exp_accurate(-x * x) / (2.0 * SQRT_PI)
}

/// The slope below which the share u of all visible Beckmann slopes lies, roughness 1.
pub fn visible_slope(view_cos: f64, view_sin: f64, u: f64) -> f64 {
    // Heitz and d'Eon 2014, "Importance Sampling Microfacet-Based BSDFs using the Distribution of Visible
    // Normals", in the plane of the view; inverted by Newton's method kept inside a bracket.
    let mut low = -SLOPE_FAR;
    let mut high = SLOPE_FAR;
    if view_cos < SLOPE_FAR * view_sin {
        high = view_cos / view_sin;
    }
    let goal = u.max(1.490_116_119_384_765_6e-8) * visible_slope_mass(high, view_cos, view_sin);
    let mut x = (0.5 * (low + high)).min(0.0);
    for _ in 0..SLOPE_STEPS {
        let excess = visible_slope_mass(x, view_cos, view_sin) - goal;
        if excess > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let density = (view_cos - x * view_sin) * exp_accurate(-x * x) / SQRT_PI;
        let mut next = 0.5 * (low + high);
        if excess.abs() < density * (high - low) {
            next = (x - excess / density).clamp(low, high);
        }
        let moved = (next - x).abs();
        x = next;
        if moved <= SLOPE_TOLERANCE {
            break;
        }
    }
    x
}

pub fn sample_visible_beckmann(wo: DVec3, alpha: DVec2, u: DVec2) -> DVec3 {
    let view = stretched_view(wo, alpha);
    let view_sin = (sqr(view.x) + sqr(view.y)).sqrt();
    let mut along = DVec2::new(1.0, 0.0);
    if view_sin > 0.0 {
        along = view.truncate() / view_sin;
    }
    let slope = DVec2::new(visible_slope(view.z, view_sin, u.x), normal_quantile(u.y));
    let turned = DVec2::new(
        along.x * slope.x - along.y * slope.y,
        along.y * slope.x + along.x * slope.y,
    );
    normalize_accurate((-alpha * turned).extend(1.0))
}
