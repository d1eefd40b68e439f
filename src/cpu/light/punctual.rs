//! KHR_lights_punctual: light from points and from one direction. What arrives is an irradiance on
//! a surface that faces the light, in W/m^2, red green blue.

use crate::cpu::math::sqr;
use crate::shared::{LIGHT_SPOT, Light};
use glam::{DVec3, Vec3};

/// The extension's floor under the difference of the cone's cosines.
pub const SPOT_MIN_CONE: f64 = 0.001;

/// 1 near the light, 0 from `range` metres on: KHR_lights_punctual, "Range Property".
pub fn range_attenuation(distance: f64, range: f64) -> f64 {
    if range <= 0.0 {
        return 1.0;
    }
    (1.0 - sqr(sqr(distance / range))).clamp(0.0, 1.0)
}

/// 1 inside the inner cone, 0 outside the outer one: KHR_lights_punctual, "Inner and Outer Cone
/// Angles". `cos_angle` is between the light's axis and the direction from it.
pub fn spot_attenuation(cos_angle: f64, cos_inner: f64, cos_outer: f64) -> f64 {
    let width = (cos_inner - cos_outer).max(SPOT_MIN_CONE);
    sqr(((cos_angle - cos_outer) / width).clamp(0.0, 1.0))
}

/// Irradiance at `distance` metres from a point or spot light, wi pointing to it.
pub fn irradiance_punctual(light: &Light, wi: DVec3, distance: f64) -> DVec3 {
    let mut attenuation = range_attenuation(distance, f64::from(light.range)) / sqr(distance);
    if light.kind == LIGHT_SPOT {
        attenuation *= spot_attenuation(
            -wi.dot(Vec3::from(light.direction).as_dvec3()),
            f64::from(light.cos_inner),
            f64::from(light.cos_outer),
        );
    }
    attenuation * Vec3::from(light.radiance).as_dvec3()
}
