//! How much a smooth boundary reflects, of unpolarised light.

use super::Bsdf;
use crate::cpu::exact::squares_minus_one;
use crate::cpu::math::{safe_sqrt, sqr};
use crate::shared::{
    FRESNEL_CONDUCTOR, FRESNEL_CONDUCTOR_APPROXIMATE, FRESNEL_DIELECTRIC, FRESNEL_SCHLICK,
};
use glam::DVec3;

/// eta cos theta_t, what Snell's law leaves of the cosine on the far side; 0 from the critical angle on.
pub fn snell_root(cos_theta: f64, eta: f64) -> f64 {
    // eta^2 - sin^2 theta = eta^2 - 1 + cos^2 theta.
    safe_sqrt(squares_minus_one(eta, cos_theta, 0.0))
}

/// Reflectance of a dielectric; eta is the far side's index over the near side's, seen from cos_theta.
pub fn F_dielectric(cos_theta: f64, eta: f64) -> f64 {
    // Lecture, "Fresnel Dielectrics". With c = cos theta and q = eta cos theta_t,
    //   r_perp = (c - q) / (c + q) and r_par = (eta^2 c - q) / (eta^2 c + q),
    // both expanded by their denominators: the differences of nearly equal numbers become exact factors.
    if eta == 1.0 {
        return 0.0;
    }
    let c = cos_theta.abs().min(1.0);
    let q = snell_root(c, eta);
    if q == 0.0 || c == 0.0 {
        return 1.0;
    }
    let contrast = (eta - 1.0) * (eta + 1.0);
    let r_perp = -contrast / sqr(c + q);
    let r_par = contrast * (c * c * (eta * eta + 1.0) - 1.0) / sqr(eta * eta * c + q);
    (0.5 * (r_perp * r_perp + r_par * r_par)).min(1.0)
}

/// 1 - F_dielectric, without the cancellation at grazing angles, where F is nearly 1.
pub fn T_dielectric(cos_theta: f64, eta: f64) -> f64 {
    if eta == 1.0 {
        return 1.0;
    }
    let c = cos_theta.abs().min(1.0);
    T_dielectric_cosines(c, snell_root(c, eta) / eta, eta)
}

/// The same from both cosines, for a caller who has them and need not go near the critical angle's root.
pub fn T_dielectric_cosines(cos_theta: f64, cos_theta_t: f64, eta: f64) -> f64 {
    // 1 - r^2 = 4 c q / (c + q)^2, and likewise for the other polarisation.
    let q = eta * cos_theta_t;
    if cos_theta <= 0.0 || q <= 0.0 {
        return 0.0;
    }
    let perp = 1.0 / sqr(cos_theta + q);
    let par = sqr(eta / (eta * eta * cos_theta + q));
    (2.0 * cos_theta * q * (perp + par)).min(1.0)
}

/// Reflectance of a conductor with complex index eta + i k over a medium of index 1, exact.
pub fn F_conductor(cos_theta: f64, eta: f64, k: f64) -> f64 {
    // Born and Wolf 1999, "Principles of Optics", 14.2: a + i b = sqrt((eta + i k)^2 - sin^2 theta), with
    // the root taken the way that does not cancel and the quotients as sums of squares.
    let c = cos_theta.abs().min(1.0);
    let s2 = (1.0 - c) * (1.0 + c);
    let re = squares_minus_one(eta, c, k); // eta^2 - k^2 - sin^2
    let im = eta * k;
    let norm = (re * re + 4.0 * im * im).sqrt();
    let high = (0.5 * (norm + re.abs())).sqrt();
    let mut low = 0.0;
    if high > 0.0 {
        low = im / high;
    }
    let a = if re >= 0.0 { high } else { low };
    let b = if re >= 0.0 { low } else { high };
    let perp_scale = sqr(a + c) + b * b;
    let par_scale = sqr(a * c + s2) + sqr(b * c);
    if perp_scale == 0.0 || par_scale == 0.0 {
        return 1.0;
    }
    let perp = (sqr(a - c) + b * b) / perp_scale;
    let par = perp * (sqr(a * c - s2) + sqr(b * c)) / par_scale;
    (0.5 * (perp + par)).min(1.0)
}

/// The lecture's form for conductors, an approximation for large eta^2 + k^2.
pub fn F_conductor_approximate(cos_theta: f64, eta: f64, k: f64) -> f64 {
    // Lecture, "Fresnel Conductors"; erratum: the two quotients are reflectances already and are not
    // squared again. (eta^2 + k^2) c^2 -+ 2 eta c + 1 = (eta c -+ 1)^2 + (k c)^2.
    let c = cos_theta.abs().min(1.0);
    let par_scale = sqr(eta * c + 1.0) + sqr(k * c);
    let perp_scale = sqr(eta + c) + k * k;
    if perp_scale == 0.0 {
        return 1.0;
    }
    let par = (sqr(eta * c - 1.0) + sqr(k * c)) / par_scale;
    let perp = (sqr(eta - c) + k * k) / perp_scale;
    0.5 * (par + perp)
}

/// (1 - cos theta)^5, the weight of white in Schlick's form.
pub fn schlick_weight(cos_theta: f64) -> f64 {
    let x = 1.0 - cos_theta.abs().min(1.0);
    sqr(sqr(x)) * x
}

pub fn F_schlick(cos_theta: f64, F0: DVec3) -> DVec3 {
    // Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering", eq. 15.
    F0 + (1.0 - F0) * schlick_weight(cos_theta)
}

/// The reflectance that a reflection model asks for; white for 1.
pub fn fresnel_F(bsdf: &Bsdf, cos_theta: f64) -> DVec3 {
    match bsdf.fresnel {
        FRESNEL_DIELECTRIC => DVec3::splat(F_dielectric(cos_theta, bsdf.eta.x)),
        FRESNEL_CONDUCTOR => DVec3::new(
            F_conductor(cos_theta, bsdf.eta.x, bsdf.k.x),
            F_conductor(cos_theta, bsdf.eta.y, bsdf.k.y),
            F_conductor(cos_theta, bsdf.eta.z, bsdf.k.z),
        ),
        FRESNEL_CONDUCTOR_APPROXIMATE => DVec3::new(
            F_conductor_approximate(cos_theta, bsdf.eta.x, bsdf.k.x),
            F_conductor_approximate(cos_theta, bsdf.eta.y, bsdf.k.y),
            F_conductor_approximate(cos_theta, bsdf.eta.z, bsdf.k.z),
        ),
        FRESNEL_SCHLICK => F_schlick(cos_theta, bsdf.eta),
        _ => bsdf.eta, // FRESNEL_CONSTANT
    }
}
