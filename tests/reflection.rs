//! The laws of reflection in float64 against what physics and the lecture say of them: printed values,
//! limits, inverses, finite differences and complex arithmetic.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]
#![allow(non_snake_case, reason = "the letters of the functions under test")]

mod subjects;

use glam::DVec3;
use snell::cpu::bsdf::Bsdf;
use snell::cpu::bsdf::bsdf::*;
use snell::cpu::bsdf::{
    dielectric::*, fresnel::*, lambertian::*, oren_nayar::*, specular::*, torrance_sparrow::*,
};
use snell::cpu::math::{PI, sqr};
use snell::shared::*;
use snell::tables::tables;
use subjects::*;

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
fn oren_nayar_is_the_lectures_formula() {
    let rho = DVec3::splat(0.7);
    for sigma in [0.1f64, 0.3, 1.0] {
        let sigma2 = sigma * sigma;
        let A = 1.0 - sigma2 / (2.0 * (sigma2 + 0.33));
        let B = 0.45 * sigma2 / (sigma2 + 0.09);
        for theta_o in [0.0f64, 0.5, 1.3] {
            for theta_i in [0.1f64, 0.9, 1.5] {
                for phi in [0.0f64, 1.0, 2.5] {
                    let (alpha, beta) = (theta_o.max(theta_i), theta_o.min(theta_i));
                    let want = 0.7 / PI * (A + B * phi.cos().max(0.0) * alpha.sin() * beta.tan());
                    let got = f_oren_nayar(
                        rho,
                        sigma,
                        direction(theta_o, 0.4),
                        direction(theta_i, 0.4 + phi),
                    );
                    assert!((got.x - want).abs() < 1e-14);
                }
            }
        }
    }
}
