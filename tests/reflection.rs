//! The reflection models in float64 against what physics and the lecture say of them: printed values,
//! limits, inverses, finite differences, complex arithmetic, reciprocity and energy.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]
#![allow(non_snake_case, reason = "the letters of the functions under test")]

use bytemuck::Zeroable;
use glam::{DVec2, DVec3};
use snell::cpu::bsdf::Bsdf;
use snell::cpu::bsdf::bsdf::*;
use snell::cpu::bsdf::{
    dielectric::*, distribution::*, fresnel::*, lambertian::*, lobe::ALPHA_SMOOTH, masking::*,
    oren_nayar::*, specular::*, torrance_sparrow::*, visible_normal::*,
};
use snell::cpu::math::{PI, sqr};
use snell::shared::{self, *};
use snell::tables::tables;

fn direction(theta: f64, phi: f64) -> DVec3 {
    DVec3::new(
        theta.sin() * phi.cos(),
        theta.sin() * phi.sin(),
        theta.cos(),
    )
}

/// A white Torrance-Sparrow lobe.
fn lobe(distribution: u32, alpha: [f64; 2], masking: u32) -> Bsdf {
    Bsdf {
        reflectance: DVec3::ONE,
        model: BSDF_TORRANCE_SPARROW,
        eta: DVec3::ONE,
        fresnel: FRESNEL_CONSTANT,
        distribution,
        alpha: DVec2::from_array(alpha),
        masking,
        ..Bsdf::from(&shared::Bsdf::zeroed())
    }
}

fn glass(eta: f64, distribution: u32, alpha: f64) -> Bsdf {
    Bsdf {
        model: BSDF_ROUGH_DIELECTRIC,
        eta: DVec3::new(eta, 0.0, 0.0),
        ..lobe(distribution, [alpha; 2], MASKING_SMITH)
    }
}

/// Points of a rank-1 lattice, for integrals by the lobes' own samplers.
fn lattice(count: u32) -> impl Iterator<Item = DVec3> {
    // Powers of the plastic number's relatives (Roberts 2018, "The Unreasonable Effectiveness of
    // Quasirandom Sequences").
    let g = 1.220_744_084_605_759_5f64;
    (0..count).map(move |i| {
        let n = f64::from(i) + 0.5;
        DVec3::new(
            (n / g).fract(),
            (n / g.powi(2)).fract(),
            (n / g.powi(3)).fract(),
        )
    })
}

#[test]
fn reflection_keeps_theta_and_turns_phi() {
    for (theta, phi) in [(0.0, 0.0), (0.3, 1.0), (1.2, 4.0), (1.57, 2.0)] {
        let mirrored = reflection_direction(direction(theta, phi), DVec3::Z);
        assert!((mirrored - direction(theta, phi + PI)).length() < 1e-15);
    }
}

#[test]
fn snell_holds_both_ways() {
    for eta in [1.5, 1.0 / 1.5, 2.4, 1.0003, 1.0] {
        for i in 0..100 {
            let theta = f64::from(i) / 100.0 * PI / 2.0;
            let wo = direction(theta, 0.7);
            let wi = refraction_direction(wo, DVec3::Z, eta);
            if wi == DVec3::ZERO {
                assert!(theta >= critical_angle(eta) - 1e-12 && is_totally_reflected(wo.z, eta));
                continue;
            }
            assert!((wi.length() - 1.0).abs() < 1e-14 && wi.z < 0.0);
            // eta_o sin theta_o = eta_i sin theta_i and phi turned by pi.
            assert!((wo.truncate() + eta * wi.truncate()).length() < 1e-14);
            // n on the side that the light now comes from.
            let back = refraction_direction(wi, -DVec3::Z, 1.0 / eta);
            assert!((back - wo).length() < 1e-6, "{eta} {theta}: {back} {wo}");
        }
    }
}

#[test]
fn total_reflection_starts_at_the_critical_angle() {
    // eta^2 = 1 - cos^2 exactly in binary: eta = 0.8, cos = 0.6 is not, so take squares of 3-4-5 eighths.
    let eta: f64 = 1.0 / 1.5;
    let critical = critical_angle(eta);
    assert!((critical - 41.810_314_895_778_6f64.to_radians()).abs() < 1e-13);
    for (offset, total) in [(1e-9, true), (-1e-9, false)] {
        let c = (critical + offset).cos();
        assert_eq!(is_totally_reflected(c, eta), total);
        assert_eq!(F_dielectric(c, eta) == 1.0, total);
        assert_eq!(T_dielectric(c, eta) == 0.0, total);
        assert_eq!(
            refraction_direction(direction(critical + offset, 0.0), DVec3::Z, eta) == DVec3::ZERO,
            total
        );
    }
    // Just inside, F falls off like the root: nearly 1 still.
    assert!(F_dielectric((critical - 1e-9).cos(), eta) > 0.999);
    // Exactly at it (sin = eta = 0, the one angle that floats hit): nothing is transmitted.
    assert!(is_totally_reflected(1.0, 0.0) && F_dielectric(1.0, 0.0) == 1.0);
    assert_eq!(critical_angle(1.5), PI / 2.0);
}

#[test]
fn snell_jacobian_is_the_derivative() {
    let refracted = |theta: f64, eta: f64| (theta.sin() / eta).asin();
    for eta in [1.5, 1.0 / 1.5, 2.4] {
        for theta in [0.0, 0.2, 0.5, 0.7] {
            let h = 1e-5;
            let slope = (refracted(theta + h, eta) - refracted(theta - h, eta)) / (2.0 * h);
            assert!((snell_jacobian(theta.cos(), eta) / slope - 1.0).abs() < 1e-5);
        }
    }
}

#[test]
fn fresnel_of_dielectrics() {
    assert!((F_dielectric(1.0, 1.5) - 0.04).abs() < 1e-15);
    assert!((F_dielectric(1.0, 1.0 / 1.5) - 0.04).abs() < 1e-15);
    assert_eq!(F_dielectric(0.0, 1.5), 1.0);
    assert_eq!(F_dielectric(0.3, 1.0), 0.0);
    // Brewster: the parallel part vanishes, what is left is half of r_perp^2 = ((1 - eta^2) / (1 + eta^2))^2.
    let eta: f64 = 1.5;
    let brewster = eta.atan().cos();
    let half = 0.5 * sqr((1.0 - eta * eta) / (1.0 + eta * eta));
    assert!((F_dielectric(brewster, eta) - half).abs() < 1e-15);
    for i in 1..=1000 {
        let c = f64::from(i) / 1000.0;
        for eta in [1.5, 1.0 / 1.5, 1.05, 3.0] {
            // The lecture's quotients as printed.
            let ct = (1.0 - (1.0 - c * c) / (eta * eta)).max(0.0).sqrt();
            let par = (eta * c - ct) / (eta * c + ct);
            let perp = (c - eta * ct) / (c + eta * ct);
            assert!((F_dielectric(c, eta) - 0.5 * (par * par + perp * perp)).abs() < 1e-13);
            assert!((T_dielectric(c, eta) + F_dielectric(c, eta) - 1.0).abs() < 1e-14);
            // The same from the other side, away from the critical angle's root.
            if ct > 0.02 {
                assert!((F_dielectric(c, eta) - F_dielectric(ct, 1.0 / eta)).abs() < 1e-9);
            }
        }
    }
}

/// A complex number, for the textbook's form of Fresnel's equations.
#[derive(Clone, Copy)]
struct Complex(f64, f64);

impl Complex {
    fn mul(self, o: Self) -> Self {
        Self(self.0 * o.0 - self.1 * o.1, self.0 * o.1 + self.1 * o.0)
    }
    fn sqrt(self) -> Self {
        let (r, angle) = (self.0.hypot(self.1).sqrt(), 0.5 * self.1.atan2(self.0));
        Self(r * angle.cos(), r * angle.sin())
    }
    fn ratio_squared(self, o: Self) -> f64 {
        (sqr(self.0) + sqr(self.1)) / (sqr(o.0) + sqr(o.1))
    }
}

#[test]
fn fresnel_of_conductors() {
    for (eta, k) in [
        (0.2, 3.9),
        (1.5, 7.6),
        (2.9, 3.1),
        (0.05, 4.2),
        (1.4, 0.1),
        (2.0, 0.0),
    ] {
        for i in 1..=100 {
            let c = f64::from(i) / 100.0;
            let index = Complex(eta, k);
            let n2 = index.mul(index);
            let root = Complex(n2.0 - (1.0 - c * c), n2.1).sqrt();
            let perp = Complex(c - root.0, -root.1).ratio_squared(Complex(c + root.0, root.1));
            let n2c = Complex(n2.0 * c, n2.1 * c);
            let par = Complex(n2c.0 - root.0, n2c.1 - root.1)
                .ratio_squared(Complex(n2c.0 + root.0, n2c.1 + root.1));
            let F = F_conductor(c, eta, k);
            assert!((F - 0.5 * (perp + par)).abs() < 1e-13, "{eta} {k} {c}");
            // The lecture's form takes the refracted ray as perpendicular: root = index.
            let perp = Complex(c - eta, -k).ratio_squared(Complex(c + eta, k));
            let inc = Complex(eta * c, k * c);
            let par = Complex(inc.0 - 1.0, inc.1).ratio_squared(Complex(inc.0 + 1.0, inc.1));
            let approximate = F_conductor_approximate(c, eta, k);
            assert!((approximate - 0.5 * (perp + par)).abs() < 1e-13);
            if eta * eta + k * k > 10.0 {
                assert!(
                    (F - approximate).abs() < 0.02,
                    "{eta} {k} {c}: {F} {approximate}"
                );
            }
        }
        // Both are exact at normal incidence, and a reflectance, not its square (erratum).
        let normal = (sqr(eta - 1.0) + k * k) / (sqr(eta + 1.0) + k * k);
        assert!((F_conductor(1.0, eta, k) - normal).abs() < 1e-14);
        assert!((F_conductor_approximate(1.0, eta, k) - normal).abs() < 1e-14);
        assert!((F_conductor(0.0, eta, k) - 1.0).abs() < 1e-14);
    }
    for eta in [1.5, 2.4] {
        assert!((F_conductor(0.4, eta, 0.0) - F_dielectric(0.4, eta)).abs() < 1e-14);
    }
}

#[test]
fn radiance_through_a_slab_is_kept() {
    // In and out again: the two eta^2 factors cancel, and inside radiance is eta^2 times (1 - F) of it.
    let bsdf = |eta| Bsdf {
        model: BSDF_SPECULAR_TRANSMISSION,
        ..glass(eta, DISTRIBUTION_GGX, 0.0)
    };
    let tables = tables();
    let weight = |s: snell::cpu::bsdf::lobe::BsdfSample| s.f.x * s.wi.z.abs() / s.pdf;
    for theta in [0.0, 0.5, 1.2] {
        let wo = direction(theta, 0.3);
        let entered = bsdf_sample(&tables, &bsdf(1.5), wo, DVec3::ZERO);
        let left = bsdf_sample(&tables, &bsdf(1.0 / 1.5), -entered.wi, DVec3::ZERO);
        assert!((left.wi - -wo).length() < 1e-14);
        let T = 1.0 - F_dielectric(wo.z, 1.5);
        assert!((weight(entered) - T / 2.25).abs() < 1e-14);
        assert!((weight(left) - T * 2.25).abs() < 1e-13);
        assert!((weight(entered) * weight(left) - T * T).abs() < 1e-14);
    }
}

#[test]
fn oren_nayar_without_roughness_is_lambert_bit_for_bit() {
    let rho = DVec3::new(0.2, 0.55, 1.0);
    for (wo, wi) in pairs() {
        assert_eq!(f_oren_nayar(rho, 0.0, wo, wi), f_lambertian(rho));
        assert_eq!(f_oren_nayar_eon(rho, 0.0, wo, wi), f_lambertian(rho));
        assert!(f_oren_nayar(rho, 1.0, wo, wi).is_finite());
    }
}

/// Pairs of directions over the hemisphere, grazing ones too.
fn pairs() -> Vec<(DVec3, DVec3)> {
    let thetas = [0.0, 0.4, 1.0, 1.5, 1.5706];
    let mut pairs = Vec::new();
    for a in thetas {
        for b in thetas {
            for phi in [0.1, 1.3, 3.0] {
                pairs.push((direction(a, 0.2), direction(b, 0.2 + phi)));
            }
        }
    }
    pairs
}

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

/// Every kind of rough lobe, with the natural masking and Smith's.
fn lobes() -> Vec<Bsdf> {
    let mut all = vec![];
    for masking in [MASKING_V_CAVITY, MASKING_SMITH] {
        for e in [2.0, 100.0, 1e4] {
            all.push(lobe(DISTRIBUTION_BLINN, [e, e], masking));
            all.push(lobe(DISTRIBUTION_ASHIKHMIN_SHIRLEY, [e, 0.1 * e], masking));
        }
    }
    for alpha in [[0.0025, 0.0025], [0.1, 0.1], [1.0, 1.0], [0.1, 0.6]] {
        all.push(lobe(DISTRIBUTION_BECKMANN, alpha, MASKING_SMITH));
        all.push(lobe(DISTRIBUTION_GGX, alpha, MASKING_SMITH));
    }
    all
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

/// glTF's white dielectric.
fn plastic(roughness: f64) -> Bsdf {
    Bsdf {
        model: BSDF_METALLIC_ROUGHNESS,
        eta: DVec3::splat(0.04),
        k: DVec3::new(0.04, 0.0, 0.0),
        fresnel: FRESNEL_SCHLICK,
        roughness,
        ..lobe(DISTRIBUTION_GGX, [roughness * roughness; 2], MASKING_SMITH)
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
fn half_vector_jacobian_is_a_ratio_of_areas() {
    // The area that a small triangle of facet normals makes of directions, mirrored and refracted.
    let wo = direction(0.6, 0.3);
    let eta = 1.5;
    let area = |f: &dyn Fn(DVec3) -> DVec3, wm: DVec3| {
        let (t, b) = (
            wm.any_orthonormal_vector(),
            wm.cross(wm.any_orthonormal_vector()),
        );
        let h = 1e-5;
        let corner = |v: DVec3| f((wm + h * v).normalize());
        let (a, c, d) = (corner(DVec3::ZERO), corner(t), corner(b));
        (c - a).cross(d - a).length() / (h * h)
    };
    for wm in [direction(0.2, 1.0), direction(0.5, 3.0)] {
        let mirror = |m: DVec3| reflection_direction(wo, m);
        let jacobian = half_vector_jacobian(wo.dot(wm));
        assert!((area(&mirror, wm) * jacobian - 1.0).abs() < 1e-3);
        assert!((half_vector(wo, mirror(wm)).truncate() - wm).length() < 1e-12);
        let refract = |m: DVec3| refraction_direction(wo, m, eta);
        let wi = refract(wm);
        let half = half_vector_transmission(wo, wi, eta);
        assert!((half.truncate() - wm).length() < 1e-12);
        let jacobian = half_vector_transmission_jacobian(wi.dot(wm), half.w, eta);
        assert!((area(&refract, wm) * jacobian - 1.0).abs() < 1e-3);
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
