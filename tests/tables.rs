//! The tables of directional albedo: against finer and independent quadratures, and the lookups on
//! lavapipe against float64.

#![allow(non_snake_case, reason = "F0 is what it is called")]

mod common;
mod queries;
mod subjects;

use glam::{DVec2, DVec3};
use queries::{Inputs, compare, on_lavapipe, within};
use rayon::prelude::*;
use snell::cpu::bsdf::albedo::*;
use snell::cpu::bsdf::bsdf::bsdf_eval;
use snell::cpu::bsdf::fresnel::F_dielectric;
use snell::cpu::bsdf::lobe::ALPHA_SMOOTH;
use snell::cpu::bsdf::sheen::f_sheen;
use snell::cpu::bsdf::specular::{reflection_direction, refraction_direction};
use snell::cpu::bsdf::torrance_sparrow::facet_sample;
use snell::shared::{DISTRIBUTION_GGX, Tables};
use snell::tables::{albedo_ggx as quadrature_ggx, gauss_legendre, integrate, tables};
use subjects::{direction, glass};

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
                quadrature_ggx(cos, roughness, &rule),
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
        let [x, y] = quadrature_ggx(0.0, roughness, &rule);
        assert!(
            (x + y - 1.0).abs() < 5e-5,
            "roughness {roughness}: {x} + {y}"
        );
    }
    for cos in [0.0, 0.1, 0.5, 1.0_f64] {
        let [x, y] = quadrature_ggx(cos, 0.0, &rule);
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
    let smooth = ALPHA_SMOOTH.sqrt();
    let mut highest = [0.0_f64; 2];
    for j in 0..=80 {
        let roughness = smooth + (1.0 - smooth) * j as f64 / 80.0;
        let narrow = usize::from(roughness * roughness < 0.05);
        for i in 0..=160 {
            let cos = (i as f64 / 160.0).powi(2);
            let [x, y] = quadrature_ggx(cos, roughness, &fine);
            let E = albedo_ggx(&tables, cos, roughness, false);
            for F0 in [0.0, 0.04, 0.5, 1.0] {
                let (table, truth) = (F0 * E.x + E.y, F0 * x + y);
                // At the very edge the cap at 1 leaves a little to wish for; 16 bits round.
                let lowest = truth - if cos < 0.02 { 1e-3 } else { 2e-5 };
                highest[narrow] = highest[narrow].max(table - truth);
                assert!(
                    (lowest..truth + [0.0035, 0.005][narrow]).contains(&table),
                    "cos {cos} roughness {roughness} F0 {F0}: table {table}, truth {truth}"
                );
            }
        }
    }
    println!("at most {highest:?} above");
}

/// Weighed by (1 - E) / (1 - average), what the lobe misses comes back as a whole, between rows too.
#[test]
fn averages_close_the_furnace() {
    let tables = tables();
    for j in 0..=50 {
        let roughness = 0.05 + 0.95 * j as f64 / 50.0;
        let average = albedo_average_ggx(&tables, roughness, false);
        let mut sum = DVec2::ZERO;
        for k in 0..2000 {
            let cos = (k as f64 + 0.5) / 2000.0;
            sum += cos / 1000.0 * albedo_ggx(&tables, cos, roughness, false);
        }
        for F0 in [0.0, 0.04, 0.5, 1.0] {
            let gap = F0 * (average.x - sum.x) + average.y - sum.y;
            assert!(gap.abs() < 3e-4, "roughness {roughness} F0 {F0}: {gap}");
        }
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

const ETAS: [f64; 12] = [
    1.01,
    1.1,
    1.33,
    1.5,
    1.8,
    2.4,
    1.0 / 1.01,
    1.0 / 1.1,
    1.0 / 1.33,
    1.0 / 1.5,
    1.0 / 1.8,
    1.0 / 2.4,
];

/// Energy that rough glass reflects, and reflects or transmits, by the reflection functions themselves:
/// at each of a lattice's facets the mirrored and the refracted direction, weighed by f cos / pdf.
fn furnace(tables: &Tables, cos_o: f64, roughness: f64, eta: f64) -> DVec2 {
    const FACETS: u32 = 6765;
    let bsdf = glass(eta, DISTRIBUTION_GGX, roughness * roughness);
    let wo = direction(cos_o.acos(), 0.4);
    let weight = |wi: DVec3, side: f64| {
        if wi.z * side <= 0.0 {
            return 0.0; // neither out of the surface nor through it
        }
        let e = bsdf_eval(tables, &bsdf, wo, wi);
        if e.pdf > 0.0 {
            e.f.x * wi.z.abs() / e.pdf
        } else {
            0.0
        }
    };
    let mut sum = DVec2::ZERO;
    for i in 0..FACETS {
        let u = (f64::from(i) + 0.5) / f64::from(FACETS);
        let v = (f64::from(i) * 4181.0 / f64::from(FACETS)).fract();
        let wm = facet_sample(&bsdf, wo, DVec2::new(u, v));
        let F = F_dielectric(wo.dot(wm), eta);
        let reflected = F * weight(reflection_direction(wo, wm), 1.0);
        let transmitted = (1.0 - F) * weight(refraction_direction(wo, wm, eta), -1.0) * eta * eta;
        sum += DVec2::new(reflected, reflected + transmitted);
    }
    sum / f64::from(FACETS)
}

/// What is scattered once and what the table says is missing make 1.
#[test]
fn glass_loses_what_the_table_says() {
    let tables = tables();
    let mut cases = vec![];
    for eta in ETAS {
        for alpha in [0.05_f64, 0.1, 0.15, 0.3, 0.55, 0.8, 1.0] {
            for cos in [0.02, 0.07, 0.15, 0.3, 0.5, 0.75, 0.95, 1.0] {
                cases.push((cos, alpha.sqrt(), eta));
            }
        }
    }
    let gaps: Vec<DVec2> = cases
        .par_iter()
        .map(|&(cos, roughness, eta)| {
            furnace(&tables, cos, roughness, eta) - albedo_dielectric(&tables, cos, roughness, eta)
        })
        .collect();
    let worst = |part: usize| {
        let at =
            (0..gaps.len()).max_by(|&a, &b| gaps[a][part].abs().total_cmp(&gaps[b][part].abs()));
        at.map(|at| (gaps[at][part].abs(), cases[at]))
    };
    let squares: DVec2 = gaps.iter().map(|&gap| gap * gap).sum();
    println!("reflected {:?}, total {:?}", worst(0), worst(1));
    println!(
        "root mean square {}",
        (squares / gaps.len() as f64).map(f64::sqrt)
    );
    let (gap, case) = worst(1).expect("cases");
    assert!(gap < 4e-3, "{gap} at (cos, roughness, eta) {case:?}");
    // The split is used to choose a side; a smooth lobe's critical angle is sharper than the columns.
    assert!((squares.x / gaps.len() as f64).sqrt() < 0.02);
}

/// Weighed by (1 - E) / (1 - average), what the table misses comes back as a whole, between nodes too.
#[test]
fn averages_close_the_dielectric_furnace() {
    let tables = tables();
    for i in 0..30 {
        let roughness = 0.2236 + (1.0 - 0.2236) * f64::from(i) / 29.0;
        for eta in ETAS {
            let average = albedo_average_dielectric(&tables, roughness, eta);
            let mut sum = DVec2::ZERO;
            for k in 0..2000 {
                let cos = (f64::from(k) + 0.5) / 2000.0;
                sum += cos / 1000.0 * albedo_dielectric(&tables, cos, roughness, eta);
            }
            let off = (1.0 - sum.y) / (1.0 - average.y) - 1.0;
            // Of the missing energy, which is a third at most.
            assert!(
                (off * (1.0 - sum.y)).abs() < 5e-4,
                "roughness {roughness} eta {eta}: {average} {sum}"
            );
            assert!(
                (average.x - sum.x).abs() < 4e-3,
                "{roughness} {eta}: {average} {sum}"
            );
        }
    }
}

#[test]
fn limits_of_the_dielectric_table() {
    let tables = tables();
    for i in 0..=50 {
        let cos = f64::from(i) / 50.0;
        for roughness in [0.0, 0.3, 1.0] {
            // Nothing there, nothing reflected.
            assert_eq!(albedo_dielectric(&tables, cos, roughness, 1.0), DVec2::Y);
            assert_eq!(albedo_average_dielectric(&tables, roughness, 1.0).y, 1.0);
        }
        for eta in ETAS {
            let smooth = albedo_dielectric(&tables, cos, 0.0, eta);
            assert_eq!(smooth, DVec2::new(F_dielectric(cos, eta), 1.0));
            // The first row goes over into it, but for what a narrow lobe blurs about grazing views and
            // about the critical angle, between columns.
            let critical = (1.0 - eta * eta).max(0.0).sqrt();
            if cos > 0.1 && (cos - critical).abs() > 0.2 {
                let narrow = albedo_dielectric(&tables, cos, ALPHA_SMOOTH.sqrt() + 1e-6, eta);
                assert!(
                    (narrow - smooth).abs().max_element() < 0.01,
                    "cos {cos} eta {eta}: {narrow} {smooth}"
                );
            }
            // Rougher boundaries lose more.
            let mut last = 1.0;
            for j in 0..=40 {
                let E = albedo_dielectric(&tables, cos, f64::from(j) / 40.0, eta);
                assert!(0.0 <= E.x && E.x <= E.y && E.y <= 1.0);
                if cos > 0.3 {
                    assert!(
                        E.y < last + 2e-3,
                        "cos {cos} eta {eta} row {j}: {} {last}",
                        E.y
                    );
                }
                last = E.y;
            }
        }
    }
}

/// The layer's albedo by even directions, nothing shared with the table's quadrature but f.
#[test]
fn sheen_table_agrees_with_a_plain_sum() {
    let tables = tables();
    let (rings, sectors) = (3000, 100);
    for roughness in [0.22, 0.37, 0.5, 0.81, 1.0] {
        for cos in [0.02, 0.05, 0.2, 0.5, 0.77, 1.0_f64] {
            let wo = direction(cos.acos(), 0.0);
            let mut sum = 0.0;
            for ring in 0..rings {
                let cos_i = (f64::from(ring) + 0.5) / f64::from(rings);
                for sector in 0..sectors {
                    let phi = std::f64::consts::PI * (f64::from(sector) + 0.5) / f64::from(sectors);
                    sum += cos_i * f_sheen(roughness, wo, direction(cos_i.acos(), phi));
                }
            }
            sum *= 2.0 * std::f64::consts::PI / f64::from(rings * sectors);
            let table = albedo_sheen(&tables, cos, roughness);
            assert!(
                (table - sum).abs() < 3e-3,
                "{cos} {roughness}: {table} {sum}"
            );
        }
    }
}

/// The binary holds what the code makes, but for what another machine's logarithms round otherwise.
#[test]
fn what_is_kept_is_what_is_integrated() {
    let (kept, made) = (tables(), integrate());
    for (name, kept, made) in [
        ("ggx", &kept.albedo[..], &made.albedo[..]),
        (
            "dielectric",
            &kept.albedo_dielectric,
            &made.albedo_dielectric,
        ),
        ("sheen", &kept.albedo_sheen, &made.albedo_sheen),
    ] {
        assert!(made.as_flattened().iter().any(|&pair| pair != 0), "{name}");
        let pairs = kept.as_flattened().iter().zip(made.as_flattened());
        for (index, (&kept, &made)) in pairs.enumerate() {
            for shift in [0, 16] {
                let [kept, made] = [kept, made].map(|pair| (pair >> shift) & 0xffff);
                assert!(
                    kept.abs_diff(made) <= 1,
                    "{name} {index}: {kept}, not {made}"
                );
            }
        }
    }
    // These are averages of the pairs above, so a unit of theirs, and integrals of their own.
    for (name, kept, made) in [
        (
            "ggx's average",
            &kept.albedo_average[..],
            &made.albedo_average[..],
        ),
        (
            "dielectric's average",
            &kept.albedo_average_dielectric,
            &made.albedo_average_dielectric,
        ),
        ("interference", &kept.interference, &made.interference),
    ] {
        assert!(made.as_flattened().iter().any(|&x| x != 0.0), "{name}");
        let values = kept.as_flattened().iter().zip(made.as_flattened());
        for (index, (kept, made)) in values.enumerate() {
            assert!(
                (kept - made).abs() <= 2e-5 * made.abs().max(1.0),
                "{name} {index}: {kept}, not {made}; cargo run --release --example make_tables"
            );
        }
    }
}

#[test]
fn lookups_on_lavapipe() {
    let tables = tables();
    let queries = Inputs::new(51).queries(|inputs, q| {
        q.bsdf.roughness = inputs.unit();
        q.bsdf.eta[0] = inputs.eta();
    });
    let gpu = on_lavapipe(
        "import package::bsdf::albedo::{albedo_ggx, albedo_average_ggx, albedo_dielectric, albedo_average_dielectric, albedo_sheen};",
        "let r = q.bsdf.roughness;
         let eta = q.bsdf.eta.x;
         let metal = albedo_ggx(q.cos_theta, r, r < 0.03);
         let metal_average = albedo_average_ggx(r, r < 0.03);
         let glass = albedo_dielectric(q.cos_theta, r, eta);
         let glass_average = albedo_average_dielectric(r, eta);",
        &[
            "metal.x",
            "metal.y",
            "metal_average.y",
            "glass.x",
            "glass.y",
            "glass_average.x",
            "glass_average.y",
            "albedo_sheen(q.cos_theta, r)",
        ],
        &queries,
    );
    compare(
        "albedo",
        &[
            within("ggx F0", 1e-2),
            within("ggx F90", 1e-2),
            within("ggx average F90", 1e-2),
            within("dielectric reflected", 1e-2),
            within("dielectric total", 1e-2),
            within("dielectric average reflected", 1e-2),
            within("dielectric average total", 1e-2),
            within("sheen", 1e-2),
        ],
        &queries,
        &gpu,
        |q| {
            let (r, eta) = (q.bsdf.roughness, q.bsdf.eta.x);
            let metal = albedo_ggx(&tables, q.cos_theta, r, r < f64::from(0.03f32));
            let metal_average = albedo_average_ggx(&tables, r, r < f64::from(0.03f32));
            let glass = albedo_dielectric(&tables, q.cos_theta, r, eta);
            let glass_average = albedo_average_dielectric(&tables, r, eta);
            vec![
                metal.x,
                metal.y,
                metal_average.y,
                glass.x,
                glass.y,
                glass_average.x,
                glass_average.y,
                albedo_sheen(&tables, q.cos_theta, r),
            ]
        },
        |_, _| true,
    );
}
