//! Energy that a rough dielectric boundary reflects and transmits: single scattering on GGX facets with
//! the exact Fresnel term, `shaders/bsdf/dielectric.wgsl` integrated.
//!
//! Axes: cosine (`albedo_coordinate`, as the metals' table), roughness, and the index ratio by
//! `eta_column`, whose middle node is eta = 1. Entry `(row * COSINES + column) * ETAS + node` is a
//! pair of 16-bit fractions of 1: reflected (low half), reflected and transmitted. Lookups are bilinear
//! in cosine and roughness and cubic in eta; `tests/tables.rs` bounds what that costs.

use super::{
    CELL_NODES, cosine_of, gauss_legendre, grid, hemispherical_average, masking_ratio, unorm16x2,
    write_pair,
};
use crate::cpu::bsdf::albedo::{ALBEDO_AVERAGE_COS, ETA_LAYER, look_up_dielectric};
use crate::cpu::bsdf::lobe::ALPHA_SMOOTH;
use crate::shared::{
    ALBEDO_DIELECTRIC_COSINES, ALBEDO_DIELECTRIC_ETAS, ALBEDO_DIELECTRIC_ROUGHNESSES, ETA_MAX,
    Tables,
};
use rayon::prelude::*;
use std::f64::consts::PI;

const COSINES: usize = ALBEDO_DIELECTRIC_COSINES as usize;
const ROUGHNESSES: usize = ALBEDO_DIELECTRIC_ROUGHNESSES as usize;
const ETAS: usize = ALBEDO_DIELECTRIC_ETAS as usize;

/// Facets that an entry is summed over, a Fibonacci number, and the one before: together a lattice of
/// the square that has no two points near each other (Niederreiter 1992, "Random Number Generation and
/// Quasi-Monte Carlo Methods", 5). Total reflection and the horizon cut corners into the integrand that
/// spoil rules of Gauss; the lattice errs by 1e-3 at most, 3e-4 root mean square.
const FACETS: usize = 1597;
const FACETS_GENERATOR: usize = 987;

/// Inverse of `eta_column`.
fn eta_of(cos: f64, roughness: f64, coordinate: f64) -> f64 {
    let layer = ETA_LAYER * (cos * cos + roughness.powi(4));
    let side = 2.0 * coordinate - 1.0;
    let distance = layer * (side.abs() * (ETA_MAX.ln() / layer).ln_1p()).exp_m1();
    (distance * side.signum()).exp()
}

pub fn fill(tables: &mut Tables) {
    let rows: Vec<Vec<[f64; 2]>> = (0..ROUGHNESSES)
        .into_par_iter()
        .map(|j| {
            // A smoother boundary is a delta, and asks no table.
            let roughness = grid(j, ROUGHNESSES).max(ALPHA_SMOOTH.sqrt());
            let columns = (0..COSINES).map(|i| {
                let cos = cosine_of(grid(i, COSINES), roughness);
                let etas: [f64; ETAS] =
                    std::array::from_fn(|k| eta_of(cos, roughness, grid(k, ETAS)));
                dielectric_pairs(cos, roughness, &etas, FACETS, FACETS_GENERATOR)
            });
            columns.flatten().collect()
        })
        .collect();
    for (index, pair) in rows.iter().flatten().enumerate() {
        tables.albedo_dielectric[index / 4][index % 4] = unorm16x2(*pair);
    }
    // The averages are those of the lookups, interpolation included: what a model puts back of 1 - E then
    // adds up to 1 - E.
    let rule = gauss_legendre(CELL_NODES);
    let made = &*tables;
    let averages: Vec<[f64; 2]> = (0..ROUGHNESSES * ETAS)
        .into_par_iter()
        .map(|index| {
            let roughness = grid(index / ETAS, ROUGHNESSES).max(ALPHA_SMOOTH.sqrt());
            let eta = eta_of(ALBEDO_AVERAGE_COS, roughness, grid(index % ETAS, ETAS));
            hemispherical_average(roughness, COSINES, &rule, |cos| {
                look_up_dielectric(made, cos, roughness, eta)
            })
        })
        .collect();
    for (index, pair) in averages.iter().enumerate() {
        write_pair(&mut tables.albedo_average_dielectric, index, *pair);
    }
}

/// Energy (reflected, reflected and transmitted) for each index ratio, seen at `cos_o`, summed over
/// `count` visible normals of a lattice with the given generator.
pub fn dielectric_pairs<const N: usize>(
    cos_o: f64,
    roughness: f64,
    etas: &[f64; N],
    count: usize,
    generator: usize,
) -> [[f64; 2]; N] {
    let alpha = roughness * roughness;
    let sin_o = ((1.0 - cos_o) * (1.0 + cos_o)).max(0.0).sqrt();
    // root(c) = c (1 + 2 Lambda(c)), Heitz 2014 eq. 72.
    let root = |c: f64| (c * c + alpha * alpha * (1.0 - c * c)).sqrt();
    let length = root(cos_o);
    // The view where the roughness is one: there the mirrored directions of visible normals are uniform
    // over the cap z > -z_o (Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps").
    let (x_o, z_o) = (alpha * sin_o / length, cos_o / length);
    let mut sums = [[0.0; 2]; N];
    for point in 0..count {
        let u = (point as f64 + 0.5) / count as f64;
        let v = ((point * generator % count) as f64 + 0.5) / count as f64;
        // Both halves of the turn are alike.
        let cos_phi = (PI * v).cos();
        let height = (1.0 - u) * (1.0 + z_o); // of the mirrored direction over the cap's edge
        let sin_i = (u * (1.0 + z_o) * ((1.0 - z_o) + height)).sqrt();
        let dot = 1.0 + x_o * sin_i * cos_phi + z_o * (height - z_o);
        let norm = (alpha * alpha * (2.0 * dot - height * height) + height * height).sqrt();
        let cos_m = height / norm; // between facet and surface
        let c = (length * dot / norm).min(1.0); // between facet and view
        let cos_r = 2.0 * c * cos_m - cos_o;
        // What is left of the light after it has left: G2 / G1(o), one side and through the surface.
        let kept_r = if cos_r > 0.0 {
            masking_ratio(cos_o, cos_r, alpha)
        } else {
            0.0
        };
        for (sum, &eta) in sums.iter_mut().zip(etas) {
            let (reflectance, q) = fresnel(c, eta);
            let mut energy = reflectance * kept_r;
            sum[0] += energy;
            // Snell's law, as refraction_direction has it.
            let cos_t = (cos_o - (1.0 - eta) * (1.0 + eta) / (c + q) * cos_m) / eta;
            if q > 0.0 && cos_t > 0.0 {
                energy += (1.0 - reflectance) * 2.0 * cos_t / (cos_t + root(cos_t));
            }
            sum[1] += energy;
        }
    }
    sums.map(|sum| sum.map(|s| s / count as f64))
}

/// Reflectance and eta cos theta_t; the plain formula, as some ten millions of them are asked for.
fn fresnel(c: f64, eta: f64) -> (f64, f64) {
    let q_squared = eta * eta - 1.0 + c * c;
    if q_squared <= 0.0 {
        return (1.0, 0.0);
    }
    let q = q_squared.sqrt();
    let perp = (c - q) / (c + q);
    let par = (eta * eta * c - q) / (eta * eta * c + q);
    (0.5 * (perp * perp + par * par), q)
}
