// Facet normals drawn as often as a viewer sees them, with density G1(wo) D(wm) (wo . wm) / cos theta_o.

import package::math::{PI, sqr, exp_accurate, sincos_accurate, normalize_accurate};
import package::erf::{SQRT_PI, erfc_accurate, normal_quantile};

// Beckmann slopes beyond this are rarer than float32's smallest u.
const SLOPE_FAR: f32 = 6.0;
// The search for a slope ends when a step is smaller than this, or after so many steps.
const SLOPE_TOLERANCE: f32 = 1e-7;
const SLOPE_STEPS: i32 = 32;

// The view in the space where the surface has roughness 1.
fn stretched_view(wo: vec3<f32>, alpha: vec2<f32>) -> vec3<f32> {
    return normalize_accurate(vec3(alpha * wo.xy, wo.z));
}

// The visible normal of a point u on the cap z > (rest - 1) view.z of mirrored directions in that space.
fn sample_cap(view: vec3<f32>, rest: f32, alpha: vec2<f32>, u: vec2<f32>) -> vec3<f32> {
    // Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps", listing 3: over the cap
    // z > -view.z visible normals make them uniform.
    let turn = sincos_accurate(2.0 * PI * u.x);
    // z = (1 - u) (1 + b) - b with b = (1 - rest) view.z; 1 - z, 1 + z and z + view.z without cancellation.
    let above = rest * view.z; // of the cap's edge over the mirrored view
    let width = (1.0 + view.z) - above;
    let sin = sqrt(u.y * width * ((1.0 - view.z) + above + (1.0 - u.y) * width));
    let sum = vec3(sin * turn.y + view.x, sin * turn.x + view.y, (1.0 - u.y) * width + above);
    return normalize_accurate(vec3(alpha * sum.xy, sum.z));
}

fn sample_visible_ggx(wo: vec3<f32>, alpha: vec2<f32>, u: vec2<f32>) -> vec3<f32> {
    return sample_cap(stretched_view(wo, alpha), 0.0, alpha, u);
}

// 1 - k, where the mirrored directions above the surface lie in the cap z > -k view.z.
fn bounded_cap_rest(wo: vec3<f32>, alpha: vec2<f32>) -> f32 {
    // Eto and Tokuyoshi 2023, "Bounded VNDF Sampling for Smith-GGX Reflections", with the narrower axis:
    // k = (1 - a^2) s^2 / (s^2 + a^2 cos^2), s = 1 + sin.
    let a2 = sqr(min(min(alpha.x, alpha.y), 1.0));
    let s2 = sqr(1.0 + sqrt(wo.x * wo.x + wo.y * wo.y));
    return a2 * (s2 + sqr(wo.z)) / (s2 + a2 * sqr(wo.z));
}

// Visible normals for reflection alone: few of those that mirror wo into the surface.
fn sample_bounded_visible_ggx(wo: vec3<f32>, alpha: vec2<f32>, u: vec2<f32>) -> vec3<f32> {
    return sample_cap(stretched_view(wo, alpha), bounded_cap_rest(wo, alpha), alpha, u);
}

// Density of the mirrored direction, per its own solid angle; D is that of its facet.
fn pdf_bounded_visible_ggx(wo: vec3<f32>, alpha: vec2<f32>, D: f32) -> f32 {
    // Eto and Tokuyoshi 2023: the cap's area is 1 + k view.z where it was 1 + view.z, so that
    // G1 D / (4 cos_o) = D / (2 (t + cos_o)) becomes D / (2 (t + k cos_o)), t the stretched view's length.
    let stretched = vec3(alpha * wo.xy, wo.z);
    let k = 1.0 - bounded_cap_rest(wo, alpha);
    return D / (2.0 * (sqrt(dot(stretched, stretched)) + k * wo.z));
}

// Probability that a visible Beckmann slope along the view is below x, times a constant.
fn visible_slope_mass(x: f32, view_cos: f32, view_sin: f32) -> f32 {
    // The integral of (cos - s sin) e^(-s^2) / sqrt(pi) over s up to x.
    return view_cos * 0.5 * erfc_accurate(-x) + view_sin * exp_accurate(-x * x) / (2.0 * SQRT_PI);
}

// The slope below which the share u of all visible Beckmann slopes lies, roughness 1.
fn visible_slope(view_cos: f32, view_sin: f32, u: f32) -> f32 {
    // Heitz and d'Eon 2014, "Importance Sampling Microfacet-Based BSDFs using the Distribution of Visible
    // Normals", in the plane of the view; inverted by Newton's method kept inside a bracket.
    var low = -SLOPE_FAR;
    var high = SLOPE_FAR;
    if view_cos < SLOPE_FAR * view_sin {
        high = view_cos / view_sin;
    }
    let goal = max(u, 1.4901161e-8) * visible_slope_mass(high, view_cos, view_sin);
    var x = min(0.0, 0.5 * (low + high));
    for (var i = 0; i < SLOPE_STEPS; i++) {
        let excess = visible_slope_mass(x, view_cos, view_sin) - goal;
        if excess > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let density = (view_cos - x * view_sin) * exp_accurate(-x * x) / SQRT_PI;
        var next = 0.5 * (low + high);
        if abs(excess) < density * (high - low) {
            next = clamp(x - excess / density, low, high);
        }
        let moved = abs(next - x);
        x = next;
        if moved <= SLOPE_TOLERANCE {
            break;
        }
    }
    return x;
}

fn sample_visible_beckmann(wo: vec3<f32>, alpha: vec2<f32>, u: vec2<f32>) -> vec3<f32> {
    let view = stretched_view(wo, alpha);
    let view_sin = sqrt(sqr(view.x) + sqr(view.y));
    var along = vec2(1.0, 0.0);
    if view_sin > 0.0 {
        along = view.xy / view_sin;
    }
    let slope = vec2(visible_slope(view.z, view_sin, u.x), normal_quantile(u.y));
    let turned = vec2(along.x * slope.x - along.y * slope.y, along.y * slope.x + along.x * slope.y);
    return normalize_accurate(vec3(-alpha * turned, 1.0));
}
