//! Perfectly specular reflection and transmission: the law of reflection, Snell's law, and the delta
//! lobes that follow them. eta is the far side's index over the near side's, seen from wo.

use super::Bsdf;
use super::fresnel::{T_dielectric, fresnel_F, snell_root};
use super::lobe::{BsdfSample, MIN_COS, no_sample};
use crate::cpu::exact::squares_minus_one;
use crate::cpu::math::{PI, asin_accurate, sqr};
use glam::DVec3;

/// theta_o = theta_i and phi_o = phi_i +- pi about n.
pub fn reflection_direction(wo: DVec3, n: DVec3) -> DVec3 {
    2.0 * wo.dot(n) * n - wo
}

/// eta_o sin theta_o = eta_i sin theta_i, phi_o = phi_i +- pi about n, which lies on wo's side; the zero
/// vector where there is total internal reflection.
pub fn refraction_direction(wo: DVec3, n: DVec3, eta: f64) -> DVec3 {
    // wi = -wo / eta + (cos_o / eta - cos_i) n, with cos_o - eta cos_i = (1 - eta^2) / (cos_o + eta cos_i).
    if eta == 1.0 {
        return -wo;
    }
    let c = wo.dot(n);
    let q = snell_root(c, eta);
    if q == 0.0 {
        return DVec3::ZERO;
    }
    ((1.0 - eta) * (1.0 + eta) / (c + q) * n - wo) / eta
}

/// The angle from which on nothing is transmitted, radians; pi / 2 where the far side is denser.
pub fn critical_angle(eta: f64) -> f64 {
    if eta >= 1.0 {
        return 0.5 * PI;
    }
    asin_accurate(eta)
}

/// At the critical angle itself too: the refracted ray would lie in the surface.
pub fn is_totally_reflected(cos_theta: f64, eta: f64) -> bool {
    eta < 1.0 && squares_minus_one(eta, cos_theta, 0.0) <= 0.0
}

/// d theta_t / d theta, the derivative of the refracted angle; 0 where there is no refracted ray.
pub fn snell_jacobian(cos_theta: f64, eta: f64) -> f64 {
    // Lecture, "Specular Refraction": eta_i cos theta_i / (eta_o cos theta_o), here cos theta / (eta cos theta_t).
    let q = snell_root(cos_theta, eta);
    if q == 0.0 {
        return 0.0;
    }
    cos_theta / q
}

/// f = F delta(wi - R(wo)) / cos theta_i, so that Lo = F Li.
pub fn specular_reflection_sample(bsdf: &Bsdf, wo: DVec3) -> BsdfSample {
    // Lecture, "Specular Reflection".
    if wo.z < MIN_COS {
        return no_sample();
    }
    BsdfSample {
        wi: DVec3::new(-wo.x, -wo.y, wo.z),
        f: bsdf.reflectance * fresnel_F(bsdf, wo.z) / wo.z,
        pdf: 1.0,
        delta: 1,
    }
}

/// f = (1 - F) (eta_o^2 / eta_i^2) delta(wi - T(wo)) / cos theta_i, so that Lo = (1 - F) (eta_o^2 / eta_i^2) Li.
pub fn specular_transmission_sample(bsdf: &Bsdf, wo: DVec3) -> BsdfSample {
    // Lecture, "Specular Transmission".
    if wo.z < MIN_COS {
        return no_sample();
    }
    let eta = bsdf.eta.x;
    let wi = refraction_direction(wo, DVec3::Z, eta);
    if wi.z > -MIN_COS {
        return no_sample();
    }
    let f = T_dielectric(wo.z, eta) / (sqr(eta) * -wi.z);
    BsdfSample {
        wi,
        f: bsdf.reflectance * f,
        pdf: 1.0,
        delta: 1,
    }
}
