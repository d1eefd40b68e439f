//! The ideally diffuse surface.

use crate::cpu::math::INV_PI;
use glam::DVec3;

pub fn f_lambertian(reflectance: DVec3) -> DVec3 {
    // Lecture, "Lambertian Reflection": rho / pi.
    reflectance * INV_PI
}
