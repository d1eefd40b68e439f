// Directional albedo of facet lobes, looked up in the tables that src/tables.rs makes.

import package::shared::{ALBEDO_TABLE_SIZE};
import package::bindings::{tables};
import package::bsdf::lobe::{MIN_COS};
import package::bsdf::fresnel::{schlick_weight};

// Where a cosine lies on the tables' columns, 0 to 1: see src/tables.rs.
fn albedo_column(cos_theta: f32, roughness: f32) -> f32 {
    let alpha = roughness * roughness;
    return 0.5 * (sqrt(cos_theta) + sqrt(cos_theta / (cos_theta + alpha * (1.0 - cos_theta))));
}

fn albedo_entry(row: u32, column: u32) -> vec2<f32> {
    let index = row * ALBEDO_TABLE_SIZE + column;
    let pair = tables.albedo[index / 2u];
    return select(pair.xy, pair.zw, (index & 1u) == 1u);
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
    let last = f32(ALBEDO_TABLE_SIZE - 1u);
    let x = clamp(albedo_column(clamp(cos_theta, MIN_COS, 1.0), roughness), 0.0, 1.0) * last;
    let y = clamp(roughness, 0.0, 1.0) * last;
    let column = u32(min(floor(x), last - 1.0));
    let row = u32(min(floor(y), last - 1.0));
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
    let last = f32(ALBEDO_TABLE_SIZE - 1u);
    let y = clamp(roughness, 0.0, 1.0) * last;
    let row = u32(min(floor(y), last - 1.0));
    return mix(albedo_average_entry(row), albedo_average_entry(row + 1u), y - f32(row));
}
