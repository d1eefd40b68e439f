//! KHR_lights_punctual and EXT_lights_ies: light from points and from one direction. What arrives is an irradiance on
//! a surface that faces the light, in W/m^2, red green blue.

use crate::cpu::math::{INV_PI, sqr};
use crate::cpu::texture::texel_word;
use crate::pack::Packed;
use crate::shared::{LIGHT_PROFILE, LIGHT_SPOT, Light};
use glam::{DVec3, FloatExt as _, Vec3};

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

/// One entry of a profile's table.
pub fn profile_load(packed: &Packed, light: &Light, row: u32, column: u32) -> f64 {
    let index = light.profile + row * light.profile_columns + column;
    f64::from(f32::from_bits(texel_word(packed, index)))
}

/// A profile's table in direction d from the light, of any length, bilinear in the angles. The light
/// goes along the frame's -z and its azimuth turns from x towards y.
pub fn profile_intensity(packed: &Packed, light: &Light, d: DVec3) -> f64 {
    let axis = Vec3::from(light.direction).as_dvec3();
    let azimuth_zero = Vec3::from(light.edge2).as_dvec3();
    let x = d.dot(azimuth_zero);
    let y = d.dot(azimuth_zero.cross(axis));
    let theta = x.hypot(y).atan2(d.dot(axis));
    let v = theta * INV_PI * f64::from(light.profile_rows - 1);
    let row = (v as u32).min(light.profile_rows - 2);
    let turn = y.atan2(x) * (0.5 * INV_PI);
    let h = (if turn < 0.0 { turn + 1.0 } else { turn }) * f64::from(light.profile_columns);
    let column = h as u32 % light.profile_columns;
    let next = (column + 1) % light.profile_columns;
    let fraction = h - h.floor();
    let load = |row, column| profile_load(packed, light, row, column);
    let near = load(row, column).lerp(load(row, next), fraction);
    let far = load(row + 1, column).lerp(load(row + 1, next), fraction);
    near.lerp(far, v - f64::from(row))
}

/// Irradiance at `distance` metres from a light with a place, wi pointing to it.
pub fn irradiance_punctual(packed: &Packed, light: &Light, wi: DVec3, distance: f64) -> DVec3 {
    let mut attenuation = range_attenuation(distance, f64::from(light.range)) / sqr(distance);
    if light.kind == LIGHT_SPOT {
        attenuation *= spot_attenuation(
            -wi.dot(Vec3::from(light.direction).as_dvec3()),
            f64::from(light.cos_inner),
            f64::from(light.cos_outer),
        );
    }
    if light.kind == LIGHT_PROFILE {
        attenuation *= profile_intensity(packed, light, -wi);
    }
    attenuation * Vec3::from(light.radiance).as_dvec3()
}
