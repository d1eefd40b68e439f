//! The tables of directional albedo: against a finer quadrature, and never below the truth.

#![allow(non_snake_case, reason = "F0 is what it is called")]

use snell::shared::{ALBEDO_TABLE_SIZE, Tables};
use snell::tables::{albedo_coordinate, albedo_ggx, gauss_legendre, tables};

const N: usize = ALBEDO_TABLE_SIZE as usize;

fn pair(table: &[[f32; 4]], index: usize) -> [f64; 2] {
    let half = 2 * (index % 2);
    [table[index / 2][half], table[index / 2][half + 1]].map(f64::from)
}

/// The lookup that the documentation of `tables` describes.
fn look_up(tables: &Tables, cos: f64, roughness: f64) -> [f64; 2] {
    let x = albedo_coordinate(cos, roughness) * (N - 1) as f64;
    let y = roughness * (N - 1) as f64;
    let (i, j) = ((x as usize).min(N - 2), (y as usize).min(N - 2));
    let (s, t) = (x - i as f64, y - j as f64);
    let at = |i: usize, j: usize| pair(&tables.albedo, j * N + i);
    std::array::from_fn(|k| {
        (at(i, j)[k] * (1.0 - s) + at(i + 1, j)[k] * s) * (1.0 - t)
            + (at(i, j + 1)[k] * (1.0 - s) + at(i + 1, j + 1)[k] * s) * t
    })
}

/// The lobe's albedo by a plain sum over directions: no visible normals, no closed-form masking
/// ratio, nothing shared with the code under test.
fn brute_force(cos_o: f64, roughness: f64) -> [f64; 2] {
    let (rings, sectors) = (1200, 600);
    let a2 = roughness.powi(4);
    let sin_o = (1.0 - cos_o * cos_o).sqrt();
    let lambda = |c: f64| 0.5 * ((1.0 + a2 * (1.0 / (c * c) - 1.0)).sqrt() - 1.0);
    let mut sum = [0.0; 2];
    for ring in 0..rings {
        let cos_i = (ring as f64 + 0.5) / rings as f64;
        let sin_i = (1.0 - cos_i * cos_i).sqrt();
        for sector in 0..sectors {
            let phi = std::f64::consts::PI * (sector as f64 + 0.5) / sectors as f64;
            let h = [sin_o + sin_i * phi.cos(), sin_i * phi.sin(), cos_o + cos_i];
            let norm = h.iter().map(|x| x * x).sum::<f64>().sqrt();
            let cos_h = h[2] / norm;
            let d = a2 / (std::f64::consts::PI * (cos_h * cos_h * (a2 - 1.0) + 1.0).powi(2));
            let g = 1.0 / (1.0 + lambda(cos_o) + lambda(cos_i));
            let schlick = (1.0 - (sin_o * h[0] + cos_o * h[2]) / norm).powi(5);
            let value = d * g / (4.0 * cos_o);
            sum[0] += value * (1.0 - schlick);
            sum[1] += value * schlick;
        }
    }
    sum.map(|s| s * 2.0 * std::f64::consts::PI / (rings * sectors) as f64)
}

#[test]
fn quadrature_agrees_with_a_plain_sum() {
    let rule = gauss_legendre(24);
    for roughness in [0.4, 0.7, 1.0] {
        for cos in [0.05, 0.3, 0.7, 1.0] {
            let (quick, plain) = (
                albedo_ggx(cos, roughness, &rule),
                brute_force(cos, roughness),
            );
            for k in 0..2 {
                let gap = (quick[k] - plain[k]).abs();
                assert!(
                    gap < 3e-4,
                    "cos {cos} roughness {roughness}: {quick:?} {plain:?}"
                );
            }
        }
    }
}

#[test]
fn limits_are_those_of_a_mirror() {
    let rule = gauss_legendre(24);
    // Grazing view: every ray is reflected, and at roughness 0 by Schlick's F90 alone.
    for roughness in [0.0, 0.1, 0.5, 1.0] {
        let [x, y] = albedo_ggx(0.0, roughness, &rule);
        assert!(
            (x + y - 1.0).abs() < 5e-5,
            "roughness {roughness}: {x} + {y}"
        );
    }
    for cos in [0.0, 0.1, 0.5, 1.0_f64] {
        let [x, y] = albedo_ggx(cos, 0.0, &rule);
        let schlick = (1.0 - cos).powi(5);
        assert!(
            (x - (1.0 - schlick)).abs() < 1e-9 && (y - schlick).abs() < 1e-9,
            "cos {cos}"
        );
    }
}

/// Interpolated values must not be below the truth (compensation divides by them), nor far above.
#[test]
fn interpolation_stays_just_above_the_truth() {
    let tables = tables();
    let fine = gauss_legendre(64);
    let smooth = 1e-3_f64.sqrt(); // below it models are perfect mirrors
    for j in 0..=80 {
        let roughness = smooth + (1.0 - smooth) * j as f64 / 80.0;
        for i in 0..=160 {
            let cos = (i as f64 / 160.0).powi(2);
            let [x, y] = albedo_ggx(cos, roughness, &fine);
            let [tx, ty] = look_up(&tables, cos, roughness);
            for F0 in [0.0, 0.04, 0.5, 1.0] {
                let (table, truth) = (F0 * tx + ty, F0 * x + y);
                // At the very edge the cap at 1 leaves a little to wish for.
                let lowest = truth - if cos < 0.02 { 1e-3 } else { 1e-6 };
                assert!(
                    (lowest..truth + 0.012).contains(&table),
                    "cos {cos} roughness {roughness} F0 {F0}: table {table}, truth {truth}"
                );
            }
        }
    }
}

#[test]
fn averages_are_those_of_the_albedo() {
    let tables = tables();
    let rule = gauss_legendre(24);
    for j in 1..N {
        let roughness = j as f64 / (N - 1) as f64;
        let mut sum = [0.0; 2];
        for k in 0..400 {
            let cos = (k as f64 + 0.5) / 400.0;
            let [x, y] = albedo_ggx(cos, roughness, &rule);
            sum[0] += 2.0 * cos * x / 400.0;
            sum[1] += 2.0 * cos * y / 400.0;
        }
        let [x, y] = pair(&tables.albedo_average, j);
        assert!(
            (x - sum[0]).abs() < 2e-4,
            "roughness {roughness}: {x} is not {}",
            sum[0]
        );
        assert!(
            (y - sum[1]).abs() < 2e-4,
            "roughness {roughness}: {y} is not {}",
            sum[1]
        );
    }
}

#[test]
fn gauss_legendre_integrates_polynomials() {
    for count in [1, 2, 5, 24] {
        let rule = gauss_legendre(count);
        for power in 0..2 * count {
            let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(power as i32)).sum();
            assert!(
                (sum - 1.0 / (power as f64 + 1.0)).abs() < 1e-13,
                "{count} nodes, x^{power}"
            );
        }
    }
}
