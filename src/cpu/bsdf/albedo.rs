//! Directional albedo of facet lobes, looked up in the tables that src/tables.rs makes.

use super::fresnel::schlick_weight;
use super::lobe::MIN_COS;
use crate::shared::{ALBEDO_TABLE_SIZE, Tables};
use crate::tables::albedo_coordinate;
use glam::DVec2;

/// Where a cosine lies on the tables' columns, 0 to 1: see src/tables.rs.
pub fn albedo_column(cos_theta: f64, roughness: f64) -> f64 {
    albedo_coordinate(cos_theta, roughness)
}

pub fn albedo_entry(tables: &Tables, row: u32, column: u32) -> DVec2 {
    pair_of(&tables.albedo, row * ALBEDO_TABLE_SIZE + column)
}

pub fn albedo_average_entry(tables: &Tables, row: u32) -> DVec2 {
    pair_of(&tables.albedo_average, row)
}

// cpu only: WGSL passes no slices.
fn pair_of(table: &[[f32; 4]], index: u32) -> DVec2 {
    let pair = table[index as usize / 2].map(f64::from);
    let half = 2 * (index as usize % 2);
    DVec2::new(pair[half], pair[half + 1])
}

/// Directional albedo of the GGX lobe as factors of F0 and F90; of a mirror where the lobe is a delta.
pub fn albedo_ggx(tables: &Tables, cos_theta: f64, roughness: f64, smooth_lobe: bool) -> DVec2 {
    if smooth_lobe {
        let white = schlick_weight(cos_theta);
        return DVec2::new(1.0 - white, white);
    }
    let last = f64::from(ALBEDO_TABLE_SIZE - 1);
    let x = albedo_column(cos_theta.clamp(MIN_COS, 1.0), roughness).clamp(0.0, 1.0) * last;
    let y = roughness.clamp(0.0, 1.0) * last;
    let column = x.floor().min(last - 1.0) as u32;
    let row = y.floor().min(last - 1.0) as u32;
    let s = x - f64::from(column);
    let t = y - f64::from(row);
    let entry = |row, column| albedo_entry(tables, row, column);
    let below = entry(row, column).lerp(entry(row, column + 1), s);
    let above = entry(row + 1, column).lerp(entry(row + 1, column + 1), s);
    below.lerp(above, t)
}

/// The hemispherical average of the same.
pub fn albedo_average_ggx(tables: &Tables, roughness: f64, smooth_lobe: bool) -> DVec2 {
    if smooth_lobe {
        // 2 * integral of (1 - c)^5 c dc = 1 / 21.
        return DVec2::new(20.0 / 21.0, 1.0 / 21.0);
    }
    let last = f64::from(ALBEDO_TABLE_SIZE - 1);
    let y = roughness.clamp(0.0, 1.0) * last;
    let row = y.floor().min(last - 1.0) as u32;
    let (below, above) = (
        albedo_average_entry(tables, row),
        albedo_average_entry(tables, row + 1),
    );
    below.lerp(above, y - f64::from(row))
}
