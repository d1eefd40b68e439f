// Directional albedo of lobes, looked up in the tables that src/tables.rs makes.

import package::shared::{ALBEDO_COSINES, ALBEDO_ROUGHNESSES, ALBEDO_DIELECTRIC_COSINES, ALBEDO_DIELECTRIC_ROUGHNESSES, ALBEDO_DIELECTRIC_ETAS, ETA_MAX, ALBEDO_SHEEN_SIZE, ALBEDO_SHEEN_MAX};
import package::bindings::{tables};
import package::math::{log_accurate, log1p_accurate};
import package::bsdf::lobe::{MIN_COS, ALPHA_SMOOTH, ETA_MATCHED};
import package::bsdf::fresnel::{F_dielectric, schlick_weight};

// Width in |ln eta| of the layer about eta = 1 where Fresnel's term changes: see eta_column.
const ETA_LAYER: f32 = 0.1;
const LOG_ETA_MAX: f32 = log(ETA_MAX);
// The averages' eta axis is that of a view at this cosine, the mean one under even light.
const ALBEDO_AVERAGE_COS: f32 = 2.0 / 3.0;

// Where to interpolate on the eta axis: node `first` and the three after it, with their weights.
struct EtaStencil {
    weights: vec4<f32>,
    first: u32,
}

// Where a cosine lies on the tables' columns, 0 to 1: see src/tables.rs.
fn albedo_column(cos_theta: f32, roughness: f32) -> f32 {
    let alpha = roughness * roughness;
    return 0.5 * (sqrt(cos_theta) + sqrt(cos_theta / (cos_theta + alpha * (1.0 - cos_theta))));
}

fn albedo_entry(row: u32, column: u32) -> vec2<f32> {
    let index = row * ALBEDO_COSINES + column;
    return unorm16_pair(tables.albedo[index / 4u][index % 4u]);
}

// The two fractions of 1 in a word, the low half first.
fn unorm16_pair(word: u32) -> vec2<f32> {
    return vec2(f32(word & 0xffffu), f32(word >> 16u)) / 65535.0;
}

fn albedo_average_entry(row: u32) -> vec2<f32> {
    let pair = tables.albedo_average[row / 2u];
    return select(pair.xy, pair.zw, (row & 1u) == 1u);
}

// Directional albedo of the GGX lobe as factors of F0 and F90; of a mirror where the lobe is a delta.
fn albedo_ggx(cos_theta: f32, roughness: f32, smooth_lobe: bool) -> vec2<f32> {
    if smooth_lobe {
        let white = schlick_weight(cos_theta);
        return vec2(1.0 - white, white);
    }
    let last_column = f32(ALBEDO_COSINES - 1u);
    let last_row = f32(ALBEDO_ROUGHNESSES - 1u);
    let x = clamp(albedo_column(clamp(cos_theta, MIN_COS, 1.0), roughness), 0.0, 1.0) * last_column;
    let y = clamp(roughness, 0.0, 1.0) * last_row;
    let column = u32(min(floor(x), last_column - 1.0));
    let row = u32(min(floor(y), last_row - 1.0));
    let s = x - f32(column);
    let t = y - f32(row);
    let below = mix(albedo_entry(row, column), albedo_entry(row, column + 1u), s);
    let above = mix(albedo_entry(row + 1u, column), albedo_entry(row + 1u, column + 1u), s);
    return mix(below, above, t);
}

// The hemispherical average of the same.
fn albedo_average_ggx(roughness: f32, smooth_lobe: bool) -> vec2<f32> {
    if smooth_lobe {
        // 2 * integral of (1 - c)^5 c dc = 1 / 21.
        return vec2(20.0 / 21.0, 1.0 / 21.0);
    }
    let last = f32(ALBEDO_ROUGHNESSES - 1u);
    let y = clamp(roughness, 0.0, 1.0) * last;
    let row = u32(min(floor(y), last - 1.0));
    return mix(albedo_average_entry(row), albedo_average_entry(row + 1u), y - f32(row));
}

// Where an index ratio lies on the eta axis, 0 to 1, with eta = 1 in the middle. Reflection depends on
// |eta - 1| against the square of the cosine at the facet, and that is of the order of the view's own
// or of the lobe's width at least: hence the logarithm of that quotient.
fn eta_column(cos_theta: f32, roughness: f32, eta: f32) -> f32 {
    let alpha = roughness * roughness;
    let layer = ETA_LAYER * (cos_theta * cos_theta + alpha * alpha);
    let distance = min(abs(log_accurate(eta)), LOG_ETA_MAX);
    let half = 0.5 * log1p_accurate(distance / layer) / log1p_accurate(LOG_ETA_MAX / layer);
    return select(0.5 + half, 0.5 - half, eta < 1.0);
}

// Lagrange's cubic through four nodes on one side of eta = 1, where the albedo has a corner.
fn eta_stencil(coordinate: f32) -> EtaStencil {
    let middle = f32((ALBEDO_DIELECTRIC_ETAS - 1u) / 2u);
    let z = clamp(coordinate, 0.0, 1.0) * (2.0 * middle);
    let side = select(0.0, middle, z >= middle);
    let first = clamp(floor(z) - 1.0, side, side + middle - 3.0);
    let x = z - first;
    let weights = vec4(
        (x - 1.0) * (x - 2.0) * (3.0 - x) / 6.0,
        x * (x - 2.0) * (x - 3.0) / 2.0,
        x * (x - 1.0) * (3.0 - x) / 2.0,
        x * (x - 1.0) * (x - 2.0) / 6.0,
    );
    return EtaStencil(weights, u32(first));
}

fn albedo_dielectric_entry(row: u32, column: u32, node: u32) -> vec2<f32> {
    let index = (row * ALBEDO_DIELECTRIC_COSINES + column) * ALBEDO_DIELECTRIC_ETAS + node;
    return unorm16_pair(tables.albedo_dielectric[index / 4u][index % 4u]);
}

// The row of the dielectric tables at one column, interpolated in eta.
fn albedo_dielectric_at(row: u32, column: u32, eta: EtaStencil) -> vec2<f32> {
    return eta.weights.x * albedo_dielectric_entry(row, column, eta.first)
        + eta.weights.y * albedo_dielectric_entry(row, column, eta.first + 1u)
        + eta.weights.z * albedo_dielectric_entry(row, column, eta.first + 2u)
        + eta.weights.w * albedo_dielectric_entry(row, column, eta.first + 3u);
}

fn look_up_dielectric(cos_theta: f32, roughness: f32, eta: f32) -> vec2<f32> {
    let c = clamp(cos_theta, MIN_COS, 1.0);
    let last_column = f32(ALBEDO_DIELECTRIC_COSINES - 1u);
    let last_row = f32(ALBEDO_DIELECTRIC_ROUGHNESSES - 1u);
    let x = clamp(albedo_column(c, roughness), 0.0, 1.0) * last_column;
    let y = clamp(roughness, 0.0, 1.0) * last_row;
    let column = u32(min(floor(x), last_column - 1.0));
    let row = u32(min(floor(y), last_row - 1.0));
    let s = x - f32(column);
    let t = y - f32(row);
    let stencil = eta_stencil(eta_column(c, roughness, eta));
    let below = mix(albedo_dielectric_at(row, column, stencil), albedo_dielectric_at(row, column + 1u, stencil), s);
    let above = mix(albedo_dielectric_at(row + 1u, column, stencil), albedo_dielectric_at(row + 1u, column + 1u, stencil), s);
    let E = mix(below, above, t);
    // The cubic may pass by some 1e-4 what the boundary can do.
    let total = clamp(E.y, 0.0, 1.0);
    return vec2(clamp(E.x, 0.0, total), total);
}

// Energy that a boundary with GGX facets and the exact Fresnel term reflects (x), and that it reflects
// or transmits (y), seen from the side that eta is far over near of; single scattering, no factor
// 1 / eta^2. Smooth and index-matched boundaries (is_smooth_dielectric) lose nothing. Index ratios
// beyond ETA_MAX are taken as ETA_MAX.
fn albedo_dielectric(cos_theta: f32, roughness: f32, eta: f32) -> vec2<f32> {
    if roughness * roughness < ALPHA_SMOOTH || abs(eta - 1.0) < ETA_MATCHED {
        return vec2(F_dielectric(cos_theta, eta), 1.0);
    }
    return look_up_dielectric(cos_theta, roughness, eta);
}

fn albedo_average_dielectric_entry(row: u32, node: u32) -> vec2<f32> {
    let index = row * ALBEDO_DIELECTRIC_ETAS + node;
    let pair = tables.albedo_average_dielectric[index / 2u];
    return select(pair.xy, pair.zw, (index & 1u) == 1u);
}

fn albedo_average_dielectric_at(row: u32, eta: EtaStencil) -> vec2<f32> {
    return eta.weights.x * albedo_average_dielectric_entry(row, eta.first)
        + eta.weights.y * albedo_average_dielectric_entry(row, eta.first + 1u)
        + eta.weights.z * albedo_average_dielectric_entry(row, eta.first + 2u)
        + eta.weights.w * albedo_average_dielectric_entry(row, eta.first + 3u);
}

// The hemispherical average of the same.
fn albedo_average_dielectric(roughness: f32, eta: f32) -> vec2<f32> {
    let last = f32(ALBEDO_DIELECTRIC_ROUGHNESSES - 1u);
    let y = clamp(roughness, 0.0, 1.0) * last;
    let row = u32(min(floor(y), last - 1.0));
    let stencil = eta_stencil(eta_column(ALBEDO_AVERAGE_COS, roughness, eta));
    let E = mix(albedo_average_dielectric_at(row, stencil), albedo_average_dielectric_at(row + 1u, stencil), y - f32(row));
    let smooth_or_matched = roughness * roughness < ALPHA_SMOOTH || abs(eta - 1.0) < ETA_MATCHED;
    let total = select(clamp(E.y, 0.0, 1.0), 1.0, smooth_or_matched);
    return vec2(clamp(E.x, 0.0, total), total);
}

// What a smooth boundary reflects of even light.
fn albedo_average_smooth_dielectric(eta: f32) -> f32 {
    let E = albedo_average_dielectric_at(0u, eta_stencil(eta_column(ALBEDO_AVERAGE_COS, 0.0, eta)));
    return clamp(E.x, 0.0, 1.0);
}

fn albedo_sheen_entry(row: u32, column: u32) -> f32 {
    let index = row * ALBEDO_SHEEN_SIZE + column;
    let pair = unorm16_pair(tables.albedo_sheen[index / 8u][index / 2u % 4u]);
    return select(pair.x, pair.y, (index & 1u) == 1u) * ALBEDO_SHEEN_MAX;
}

// What the white layer of KHR_materials_sheen reflects. At grazing views the extension's lobe returns
// more than it gets and so this is above 1: divide the lobe by max(E, 1), keep max(1 - E, 0) of the base.
fn albedo_sheen(cos_theta: f32, roughness: f32) -> f32 {
    let last = f32(ALBEDO_SHEEN_SIZE - 1u);
    let x = sqrt(sqrt(clamp(cos_theta, 0.0, 1.0))) * last;
    let y = clamp(roughness, 0.0, 1.0) * last;
    let column = u32(min(floor(x), last - 1.0));
    let row = u32(min(floor(y), last - 1.0));
    let s = x - f32(column);
    let below = mix(albedo_sheen_entry(row, column), albedo_sheen_entry(row, column + 1u), s);
    let above = mix(albedo_sheen_entry(row + 1u, column), albedo_sheen_entry(row + 1u, column + 1u), s);
    return mix(below, above, y - f32(row));
}
