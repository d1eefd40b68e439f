//! Directional albedo of lobes, looked up in the tables that src/tables.rs makes.

use super::fresnel::{F_dielectric, schlick_weight};
use super::lobe::{ALPHA_SMOOTH, ETA_MATCHED, MIN_COS};
use crate::cpu::math::{log_accurate, log1p_accurate};
use crate::shared::{
    ALBEDO_COSINES, ALBEDO_DIELECTRIC_COSINES, ALBEDO_DIELECTRIC_ETAS,
    ALBEDO_DIELECTRIC_ROUGHNESSES, ALBEDO_ROUGHNESSES, ALBEDO_SHEEN_MAX, ALBEDO_SHEEN_SIZE,
    ETA_MAX, Tables,
};
use crate::tables::albedo_coordinate;
use glam::{DVec2, DVec4, FloatExt};

/// Width in |ln eta| of the layer about eta = 1 where Fresnel's term changes: see `eta_column`.
pub const ETA_LAYER: f64 = 0.1;
/// The averages' eta axis is that of a view at this cosine, the mean one under even light.
pub const ALBEDO_AVERAGE_COS: f64 = 2.0 / 3.0;

/// Where to interpolate on the eta axis: node `first` and the three after it, with their weights.
#[derive(Clone, Copy)]
pub struct EtaStencil {
    weights: DVec4,
    first: u32,
}

/// Where a cosine lies on the tables' columns, 0 to 1: see src/tables.rs.
pub fn albedo_column(cos_theta: f64, roughness: f64) -> f64 {
    albedo_coordinate(cos_theta, roughness)
}

pub fn albedo_entry(tables: &Tables, row: u32, column: u32) -> DVec2 {
    let index = (row * ALBEDO_COSINES + column) as usize;
    unorm16_pair(tables.albedo[index / 4][index % 4])
}

/// The two fractions of 1 in a word, the low half first.
pub fn unorm16_pair(word: u32) -> DVec2 {
    DVec2::new(f64::from(word & 0xffff), f64::from(word >> 16)) * (1.0 / 65535.0)
}

pub fn albedo_average_entry(tables: &Tables, row: u32) -> DVec2 {
    pair_of(&tables.albedo_average, row)
}

// cpu only: WGSL passes no slices.
pub(super) fn pair_of(table: &[[f32; 4]], index: u32) -> DVec2 {
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
    let last_column = f64::from(ALBEDO_COSINES - 1);
    let last_row = f64::from(ALBEDO_ROUGHNESSES - 1);
    let x = albedo_column(cos_theta.clamp(MIN_COS, 1.0), roughness).clamp(0.0, 1.0) * last_column;
    let y = roughness.clamp(0.0, 1.0) * last_row;
    let column = x.floor().min(last_column - 1.0) as u32;
    let row = y.floor().min(last_row - 1.0) as u32;
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
    let last = f64::from(ALBEDO_ROUGHNESSES - 1);
    let y = roughness.clamp(0.0, 1.0) * last;
    let row = y.floor().min(last - 1.0) as u32;
    let (below, above) = (
        albedo_average_entry(tables, row),
        albedo_average_entry(tables, row + 1),
    );
    below.lerp(above, y - f64::from(row))
}

/// Where an index ratio lies on the eta axis, 0 to 1, with eta = 1 in the middle. Reflection depends on
/// |eta - 1| against the square of the cosine at the facet, and that is of the order of the view's own
/// or of the lobe's width at least: hence the logarithm of that quotient.
pub fn eta_column(cos_theta: f64, roughness: f64, eta: f64) -> f64 {
    let alpha = roughness * roughness;
    let layer = ETA_LAYER * (cos_theta * cos_theta + alpha * alpha);
    let distance_max = log_accurate(ETA_MAX);
    let distance = log_accurate(eta).abs().min(distance_max);
    let half = 0.5 * log1p_accurate(distance / layer) / log1p_accurate(distance_max / layer);
    if eta < 1.0 { 0.5 - half } else { 0.5 + half }
}

/// Lagrange's cubic through four nodes on one side of eta = 1, where the albedo has a corner.
pub fn eta_stencil(coordinate: f64) -> EtaStencil {
    let middle = f64::from((ALBEDO_DIELECTRIC_ETAS - 1) / 2);
    let z = coordinate.clamp(0.0, 1.0) * (2.0 * middle);
    let side = if z >= middle { middle } else { 0.0 };
    let first = (z.floor() - 1.0).clamp(side, side + middle - 3.0);
    let x = z - first;
    let weights = DVec4::new(
        (x - 1.0) * (x - 2.0) * (3.0 - x) / 6.0,
        x * (x - 2.0) * (x - 3.0) / 2.0,
        x * (x - 1.0) * (3.0 - x) / 2.0,
        x * (x - 1.0) * (x - 2.0) / 6.0,
    );
    EtaStencil {
        weights,
        first: first as u32,
    }
}

pub fn albedo_dielectric_entry(tables: &Tables, row: u32, column: u32, node: u32) -> DVec2 {
    let index = (row * ALBEDO_DIELECTRIC_COSINES + column) * ALBEDO_DIELECTRIC_ETAS + node;
    unorm16_pair(tables.albedo_dielectric[index as usize / 4][index as usize % 4])
}

/// The row of the dielectric tables at one column, interpolated in eta.
pub fn albedo_dielectric_at(tables: &Tables, row: u32, column: u32, eta: EtaStencil) -> DVec2 {
    let entry = |node| albedo_dielectric_entry(tables, row, column, eta.first + node);
    eta.weights.x * entry(0)
        + eta.weights.y * entry(1)
        + eta.weights.z * entry(2)
        + eta.weights.w * entry(3)
}

pub fn look_up_dielectric(tables: &Tables, cos_theta: f64, roughness: f64, eta: f64) -> DVec2 {
    let c = cos_theta.clamp(MIN_COS, 1.0);
    let last_column = f64::from(ALBEDO_DIELECTRIC_COSINES - 1);
    let last_row = f64::from(ALBEDO_DIELECTRIC_ROUGHNESSES - 1);
    let x = albedo_column(c, roughness).clamp(0.0, 1.0) * last_column;
    let y = roughness.clamp(0.0, 1.0) * last_row;
    let column = x.floor().min(last_column - 1.0) as u32;
    let row = y.floor().min(last_row - 1.0) as u32;
    let s = x - f64::from(column);
    let t = y - f64::from(row);
    let stencil = eta_stencil(eta_column(c, roughness, eta));
    let at = |row, column| albedo_dielectric_at(tables, row, column, stencil);
    let below = at(row, column).lerp(at(row, column + 1), s);
    let above = at(row + 1, column).lerp(at(row + 1, column + 1), s);
    let E = below.lerp(above, t);
    // The cubic may pass by some 1e-4 what the boundary can do.
    let total = E.y.clamp(0.0, 1.0);
    DVec2::new(E.x.clamp(0.0, total), total)
}

/// Energy that a boundary with GGX facets and the exact Fresnel term reflects (x), and that it reflects
/// or transmits (y), seen from the side that eta is far over near of; single scattering, no factor
/// 1 / eta^2. Smooth and index-matched boundaries (`is_smooth_dielectric`) lose nothing. Index ratios
/// beyond `ETA_MAX` are taken as `ETA_MAX`.
pub fn albedo_dielectric(tables: &Tables, cos_theta: f64, roughness: f64, eta: f64) -> DVec2 {
    if roughness * roughness < ALPHA_SMOOTH || (eta - 1.0).abs() < ETA_MATCHED {
        return DVec2::new(F_dielectric(cos_theta, eta), 1.0);
    }
    look_up_dielectric(tables, cos_theta, roughness, eta)
}

pub fn albedo_average_dielectric_entry(tables: &Tables, row: u32, node: u32) -> DVec2 {
    pair_of(
        &tables.albedo_average_dielectric,
        row * ALBEDO_DIELECTRIC_ETAS + node,
    )
}

pub fn albedo_average_dielectric_at(tables: &Tables, row: u32, eta: EtaStencil) -> DVec2 {
    let entry = |node| albedo_average_dielectric_entry(tables, row, eta.first + node);
    eta.weights.x * entry(0)
        + eta.weights.y * entry(1)
        + eta.weights.z * entry(2)
        + eta.weights.w * entry(3)
}

/// The hemispherical average of the same.
pub fn albedo_average_dielectric(tables: &Tables, roughness: f64, eta: f64) -> DVec2 {
    let last = f64::from(ALBEDO_DIELECTRIC_ROUGHNESSES - 1);
    let y = roughness.clamp(0.0, 1.0) * last;
    let row = y.floor().min(last - 1.0) as u32;
    let stencil = eta_stencil(eta_column(ALBEDO_AVERAGE_COS, roughness, eta));
    let at = |row| albedo_average_dielectric_at(tables, row, stencil);
    let E = at(row).lerp(at(row + 1), y - f64::from(row));
    let smooth_or_matched = roughness * roughness < ALPHA_SMOOTH || (eta - 1.0).abs() < ETA_MATCHED;
    let total = if smooth_or_matched {
        1.0
    } else {
        E.y.clamp(0.0, 1.0)
    };
    DVec2::new(E.x.clamp(0.0, total), total)
}

/// What a smooth boundary reflects of even light.
pub fn albedo_average_smooth_dielectric(tables: &Tables, eta: f64) -> f64 {
    let stencil = eta_stencil(eta_column(ALBEDO_AVERAGE_COS, 0.0, eta));
    let E = albedo_average_dielectric_at(tables, 0, stencil);
    E.x.clamp(0.0, 1.0)
}

pub fn albedo_sheen_entry(tables: &Tables, row: u32, column: u32) -> f64 {
    let index = (row * ALBEDO_SHEEN_SIZE + column) as usize;
    let pair = unorm16_pair(tables.albedo_sheen[index / 8][index / 2 % 4]);
    let entry = if index % 2 == 1 { pair.y } else { pair.x };
    entry * ALBEDO_SHEEN_MAX
}

/// What the white layer of KHR_materials_sheen reflects. At grazing views the extension's lobe returns
/// more than it gets and so this is above 1: divide the lobe by max(E, 1), keep max(1 - E, 0) of the base.
pub fn albedo_sheen(tables: &Tables, cos_theta: f64, roughness: f64) -> f64 {
    let last = f64::from(ALBEDO_SHEEN_SIZE - 1);
    let x = cos_theta.clamp(0.0, 1.0).sqrt().sqrt() * last;
    let y = roughness.clamp(0.0, 1.0) * last;
    let column = x.floor().min(last - 1.0) as u32;
    let row = y.floor().min(last - 1.0) as u32;
    let s = x - f64::from(column);
    let entry = |row, column| albedo_sheen_entry(tables, row, column);
    let below = entry(row, column).lerp(entry(row, column + 1), s);
    let above = entry(row + 1, column).lerp(entry(row + 1, column + 1), s);
    below.lerp(above, y - f64::from(row))
}
