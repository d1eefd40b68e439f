//! Directional albedo of the layer of fibres of KHR_materials_sheen, white.
//!
//! Axes: the fourth root of the cosine (the fit of Lambda falls steeply towards grazing views), and
//! roughness. Entries are 16-bit fractions of `ALBEDO_SHEEN_MAX`, two to a word; lookups are bilinear.
//!
//! Near the horizon the extension's lobe reflects more than it gets (see `cpu::bsdf::sheen`), and so
//! says the table: whoever layers it divides the lobe by max(E, 1) and keeps max(1 - E, 0) of the base.

use super::{gauss_legendre, grid, unorm16x2};
use crate::cpu::bsdf::lobe::ALPHA_SMOOTH;
use crate::cpu::bsdf::sheen::f_sheen;
use crate::shared::{ALBEDO_SHEEN_MAX, ALBEDO_SHEEN_SIZE, Tables};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Side of the table.
const N: usize = ALBEDO_SHEEN_SIZE as usize;

/// Nodes in elevation, and midpoints in azimuth over half a turn.
const ELEVATIONS: usize = 24;
const AZIMUTHS: usize = 16;

/// The first column is made for this cosine: at 0 the fit of Lambda lets the lobe grow without bound.
const COS_FIRST: f64 = 1e-4;

pub fn fill(tables: &mut Tables) {
    let rule = gauss_legendre(ELEVATIONS);
    let entries: Vec<f64> = (0..N * N)
        .into_par_iter()
        .map(|index| {
            let roughness = grid(index / N, N).max(ALPHA_SMOOTH.sqrt());
            let cos = grid(index % N, N).powi(4).max(COS_FIRST);
            albedo_sheen(cos, roughness, AZIMUTHS, &rule)
        })
        .collect();
    for (index, pair) in entries.chunks(2).enumerate() {
        let word = unorm16x2([pair[0] / ALBEDO_SHEEN_MAX, pair[1] / ALBEDO_SHEEN_MAX]);
        tables.albedo_sheen[index / 4][index % 4] = word;
    }
}

/// The share of light that the white layer reflects, seen at `cos_o` > 0.
pub fn albedo_sheen(cos_o: f64, roughness: f64, azimuths: usize, rule: &[(f64, f64)]) -> f64 {
    let wo = DVec3::new(((1.0 - cos_o) * (1.0 + cos_o)).sqrt(), 0.0, cos_o);
    let mut sum = 0.0;
    for &(node, weight) in rule {
        // Nodes crowd at grazing light, where all of a smooth layer's lies.
        let cos_i = node.powi(3);
        let sin_i = ((1.0 - cos_i) * (1.0 + cos_i)).sqrt();
        for a in 0..azimuths {
            let (sin_phi, cos_phi) = (PI * (a as f64 + 0.5) / azimuths as f64).sin_cos();
            let wi = DVec3::new(sin_i * cos_phi, sin_i * sin_phi, cos_i);
            sum += 3.0 * node * node * weight * cos_i * f_sheen(roughness, wo, wi);
        }
    }
    sum * TAU / azimuths as f64
}
