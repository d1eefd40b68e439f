//! The rough lobes in float64: normalisation, energy, reciprocity, and that pdfs are those of the samples.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]
#![allow(non_snake_case, reason = "the letters of the functions under test")]

mod subjects;

use glam::{DVec2, DVec3};
use snell::cpu::bsdf::Bsdf;
use snell::cpu::bsdf::bsdf::*;
use snell::cpu::bsdf::{distribution::*, lobe::ALPHA_SMOOTH, masking::*, visible_normal::*};
use snell::cpu::math::{PI, sqr};
use snell::shared::*;
use snell::tables::tables;
use subjects::*;

#[test]
fn distributions_project_to_one() {
    let mut cases = vec![];
    for e in [0.0, 1.0, 50.0, 1e3, 1e5] {
        cases.push(lobe(DISTRIBUTION_BLINN, [e, e], MASKING_NONE));
        cases.push(lobe(
            DISTRIBUTION_ASHIKHMIN_SHIRLEY,
            [e, 3.0 * e + 1.0],
            MASKING_NONE,
        ));
    }
    for alpha in [[0.001, 0.001], [0.1, 0.1], [1.0, 1.0], [0.05, 0.5]] {
        cases.push(lobe(DISTRIBUTION_BECKMANN, alpha, MASKING_NONE));
        cases.push(lobe(DISTRIBUTION_GGX, alpha, MASKING_NONE));
    }
    for bsdf in cases {
        // Over slopes r (cos phi, sin phi): d omega = cos^3 r dr dphi, r by its logarithm.
        let (radii, turns) = (4000, 400);
        let mut sum = 0.0;
        for i in 0..radii {
            let ln_r = -16.0 + 32.0 * (f64::from(i) + 0.5) / f64::from(radii);
            let r = ln_r.exp();
            for j in 0..turns {
                let phi = 2.0 * PI * (f64::from(j) + 0.5) / f64::from(turns);
                let wm = DVec3::new(r * phi.cos(), r * phi.sin(), 1.0).normalize();
                sum += facet_D(&bsdf, wm) * wm.z * wm.z.powi(3) * r * r;
            }
        }
        let integral = sum * 32.0 / f64::from(radii) * 2.0 * PI / f64::from(turns);
        assert!((integral - 1.0).abs() < 1e-4, "{integral} of {bsdf:?}");
    }
}

#[test]
fn equal_exponents_are_blinn() {
    for e in [0.0, 1.0, 30.0, 1e3, 1e5] {
        for (wm, _) in pairs() {
            let blinn = D_blinn(wm, e);
            let both = D_ashikhmin_shirley(wm, DVec2::splat(e));
            assert!((both - blinn).abs() <= 1e-6 * blinn, "{e}: {both} {blinn}");
        }
    }
}

#[test]
fn reflection_is_reciprocal() {
    let tables = tables();
    let mut all = lobes();
    for kind in [BSDF_LAMBERTIAN, BSDF_OREN_NAYAR, BSDF_OREN_NAYAR_EON] {
        all.push(Bsdf {
            model: kind,
            roughness: 0.7,
            ..all[0]
        });
    }
    all.push(plastic(0.5));
    for bsdf in all {
        for (wo, wi) in pairs() {
            let there = bsdf_eval(&tables, &bsdf, wo, wi).f;
            let back = bsdf_eval(&tables, &bsdf, wi, wo).f;
            assert!((there - back).abs().max_element() <= 1e-12 * there.max_element());
        }
    }
}

#[test]
fn transmission_is_reciprocal_over_eta_squared() {
    let tables = tables();
    for (wo, wi) in pairs() {
        let wi = DVec3::new(-wi.x, -wi.y, -wi.z);
        let eta = 1.5;
        // f(wo, wi) / eta_o^2 = f(wi, wo) / eta_i^2 for radiance: the outer index is 1.
        let there = bsdf_eval(&tables, &glass(eta, DISTRIBUTION_GGX, 0.4), wo, wi)
            .f
            .x;
        let back = bsdf_eval(&tables, &glass(1.0 / eta, DISTRIBUTION_GGX, 0.4), wi, wo)
            .f
            .x;
        assert!(
            (there * eta * eta - back).abs() <= 1e-10 * back,
            "{there} {back}"
        );
    }
}

/// What a white surface reflects and transmits (transmission counted as power, so times eta^2).
fn albedo(tables: &Tables, bsdf: &Bsdf, wo: DVec3, count: u32) -> f64 {
    let sum: f64 = lattice(count)
        .map(|u| {
            let s = bsdf_sample(tables, bsdf, wo, u);
            if s.pdf <= 0.0 {
                return 0.0;
            }
            let power = if s.wi.z * wo.z < 0.0 {
                sqr(bsdf.eta.x)
            } else {
                1.0
            };
            s.f.max_element() * s.wi.z.abs() / s.pdf * power
        })
        .sum();
    sum / f64::from(count)
}

#[test]
fn white_furnace_never_exceeds_one() {
    let tables = tables();
    let mut all = lobes();
    for roughness in [0.0, 0.1, 0.3, 0.6, 1.0] {
        all.push(plastic(roughness));
        for eta in [1.5, 1.0 / 1.5] {
            all.push(glass(eta, DISTRIBUTION_GGX, roughness));
            all.push(glass(eta, DISTRIBUTION_BECKMANN, roughness));
        }
        all.push(Bsdf {
            model: BSDF_OREN_NAYAR_EON,
            roughness,
            ..all[0]
        });
    }
    for bsdf in all {
        for theta in [0.0f64, 30.0, 60.0, 85.0, 89.9] {
            let E = albedo(&tables, &bsdf, direction(theta.to_radians(), 0.4), 20_000);
            // The lattice itself integrates these to about 1e-3.
            assert!(E <= 1.0 + 2e-3, "{E} at {theta} of {bsdf:?}");
            assert!(E > 0.25, "{E} at {theta} of {bsdf:?}");
            if bsdf.model == BSDF_OREN_NAYAR_EON && theta < 89.0 {
                assert!(
                    (E - 1.0).abs() < 2e-3,
                    "EON keeps all energy: {E} at {theta}"
                );
            }
        }
    }
}

#[test]
fn pdfs_integrate_to_one_less_what_is_rejected() {
    let tables = tables();
    let mut all = vec![
        plastic(0.5),
        glass(1.5, DISTRIBUTION_GGX, 0.5),
        glass(1.0 / 1.5, DISTRIBUTION_BECKMANN, 0.5),
    ];
    all.extend(
        lobes()
            .into_iter()
            .filter(|b| facet_alpha(b).min_element() > 0.09),
    );
    for bsdf in all {
        for theta in [0.1f64, 1.0, 1.45] {
            let wo = direction(theta, 0.4);
            let count = 40_000;
            let kept = lattice(count)
                .filter(|u| bsdf_sample(&tables, &bsdf, wo, *u).pdf > 0.0)
                .count();
            let (rows, columns) = (800, 800);
            let mut mass = 0.0;
            for i in 0..rows {
                let z = -1.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(rows);
                for j in 0..columns {
                    let phi = 2.0 * PI * (f64::from(j) + 0.5) / f64::from(columns);
                    mass += bsdf_eval(&tables, &bsdf, wo, direction(z.acos(), phi)).pdf;
                }
            }
            mass *= 4.0 * PI / f64::from(rows * columns);
            let share = kept as f64 / f64::from(count);
            assert!(
                (mass - share).abs() < 5e-3,
                "{mass} {share} at {theta} of {bsdf:?}"
            );
        }
    }
}

#[test]
fn lambdas_agree_with_their_integrals() {
    // G1 = cos theta / integral of D max(0, w . wm): the facets' visible area projects to the surface's.
    for distribution in [DISTRIBUTION_BECKMANN, DISTRIBUTION_GGX] {
        let bsdf = lobe(distribution, [0.3, 0.6], MASKING_SMITH);
        for theta in [0.2, 1.0, 1.4] {
            let w = direction(theta, 0.8);
            let mut sum = 0.0;
            let (rows, columns) = (2000, 400);
            for i in 0..rows {
                let z = (f64::from(i) + 0.5) / f64::from(rows);
                for j in 0..columns {
                    let phi = 2.0 * PI * (f64::from(j) + 0.5) / f64::from(columns);
                    let wm = direction(z.acos(), phi);
                    sum += facet_D(&bsdf, wm) * w.dot(wm).max(0.0);
                }
            }
            sum *= 2.0 * PI / f64::from(rows * columns);
            assert!((G1_smith(&bsdf, w) - w.z / sum).abs() < 1e-4);
        }
    }
}

#[test]
fn smooth_lobes_are_deltas_and_others_are_not() {
    for (alpha, delta) in [
        ([0.0, 0.0], true),
        ([0.9e-3, 0.9e-3], true),
        ([1e-3, 1e-3], false),
        ([0.0, 0.5], false),
    ] {
        let bsdf = lobe(DISTRIBUTION_GGX, alpha, MASKING_SMITH);
        assert_eq!(bsdf_is_delta(&bsdf), delta);
        assert_eq!(
            bsdf_is_delta(&glass(1.5, DISTRIBUTION_GGX, alpha[1])),
            delta
        );
        assert!(facet_alpha(&bsdf).min_element() >= ALPHA_SMOOTH);
    }
    let smooth = plastic(0.0);
    assert!(!bsdf_is_delta(&smooth), "its diffuse part stays");
    let mirror = bsdf_sample(&tables(), &smooth, direction(0.5, 0.0), DVec3::ZERO);
    assert_eq!(mirror.delta, 1);
}

#[test]
fn beckmann_slopes_invert_their_distribution() {
    for theta in [0.0f64, 0.3, 1.0, 1.5, 1.5706] {
        let (sin, cos) = theta.sin_cos();
        let all = visible_slope_mass((cos / sin).min(SLOPE_FAR), cos, sin);
        for i in 1..100 {
            let u = f64::from(i) / 100.0;
            let x = visible_slope(cos, sin, u);
            assert!(
                (visible_slope_mass(x, cos, sin) / all - u).abs() < 1e-11,
                "{theta} {u}"
            );
        }
    }
}

#[test]
fn directions_in_the_surface_answer_nothing() {
    let tables = tables();
    let mut all = lobes();
    all.push(plastic(0.5));
    all.push(glass(1.5, DISTRIBUTION_GGX, 0.3));
    for bsdf in all {
        for (wo, wi) in [
            (DVec3::X, DVec3::Z),
            (DVec3::Z, DVec3::X),
            (DVec3::X, -DVec3::X),
            (DVec3::X, DVec3::X),
        ] {
            let e = bsdf_eval(&tables, &bsdf, wo, wi);
            assert_eq!((e.f, e.pdf), (DVec3::ZERO, 0.0));
        }
        assert_eq!(
            bsdf_sample(&tables, &bsdf, DVec3::X, DVec3::splat(0.3)).pdf,
            0.0
        );
    }
}

#[test]
fn torrance_sparrow_is_the_lectures_formula() {
    let tables = tables();
    let e = DVec2::new(40.0, 300.0);
    for (masking, G) in [(MASKING_NONE, None), (MASKING_V_CAVITY, Some(2.0))] {
        let bsdf = lobe(DISTRIBUTION_ASHIKHMIN_SHIRLEY, e.to_array(), masking);
        for (wo, wi) in pairs() {
            let h = (wo + wi).normalize();
            let phi = h.y.atan2(h.x);
            let D = ((e.x + 2.0) * (e.y + 2.0)).sqrt() / (2.0 * PI)
                * h.z.powf(e.x * sqr(phi.cos()) + e.y * sqr(phi.sin()));
            let G = G.map_or(1.0, |two| (two * h.z * wo.z.min(wi.z) / wo.dot(h)).min(1.0));
            let want = D * G / (4.0 * wo.z * wi.z);
            let got = bsdf_eval(&tables, &bsdf, wo, wi).f.x;
            assert!((got - want).abs() <= 1e-9 * want, "{got} {want}");
        }
    }
}
