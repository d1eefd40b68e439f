// KHR_lights_punctual: light from points and from one direction. What arrives is an irradiance on
// a surface that faces the light, in W/m^2, red green blue.

import package::shared::{Light, LIGHT_SPOT};
import package::math::{sqr};

// The extension's floor under the difference of the cone's cosines.
const SPOT_MIN_CONE: f32 = 0.001;

// 1 near the light, 0 from `range` metres on: KHR_lights_punctual, "Range Property".
fn range_attenuation(distance: f32, range: f32) -> f32 {
    if range <= 0.0 {
        return 1.0;
    }
    return clamp(1.0 - sqr(sqr(distance / range)), 0.0, 1.0);
}

// 1 inside the inner cone, 0 outside the outer one: KHR_lights_punctual, "Inner and Outer Cone
// Angles". cos_angle is between the light's axis and the direction from it.
fn spot_attenuation(cos_angle: f32, cos_inner: f32, cos_outer: f32) -> f32 {
    let width = max(cos_inner - cos_outer, SPOT_MIN_CONE);
    return sqr(clamp((cos_angle - cos_outer) / width, 0.0, 1.0));
}

// Irradiance at `distance` metres from a point or spot light, wi pointing to it.
fn irradiance_punctual(light: Light, wi: vec3<f32>, distance: f32) -> vec3<f32> {
    var attenuation = range_attenuation(distance, light.range) / sqr(distance);
    if light.kind == LIGHT_SPOT {
        attenuation *= spot_attenuation(-dot(wi, light.direction), light.cos_inner, light.cos_outer);
    }
    return attenuation * light.radiance;
}
