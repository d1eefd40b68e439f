// KHR_lights_punctual and EXT_lights_ies: light from points and from one direction. What arrives is an irradiance on
// a surface that faces the light, in W/m^2, red green blue.

import package::shared::{Light, LIGHT_SPOT, LIGHT_PROFILE};
import package::variant::{PROFILES};
import package::math::{INV_PI, sqr, atan2_accurate};
import package::texture::{texel_word};

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

// One entry of a profile's table.
fn profile_load(light: Light, row: u32, column: u32) -> f32 {
    return bitcast<f32>(texel_word(light.profile + row * light.profile_columns + column));
}

// A profile's table in direction d from the light, of any length, bilinear in the angles. The light goes
// along the frame's -z and its azimuth turns from x towards y.
fn profile_intensity(light: Light, d: vec3<f32>) -> f32 {
    let x = dot(d, light.edge2);
    let y = dot(d, cross(light.edge2, light.direction));
    let theta = atan2_accurate(sqrt(x * x + y * y), dot(d, light.direction));
    let v = theta * INV_PI * f32(light.profile_rows - 1u);
    let row = min(u32(v), light.profile_rows - 2u);
    let turn = atan2_accurate(y, x) * (0.5 * INV_PI);
    let h = select(turn, turn + 1.0, turn < 0.0) * f32(light.profile_columns);
    let column = u32(h) % light.profile_columns;
    let next = (column + 1u) % light.profile_columns;
    let fraction = h - floor(h);
    let near = mix(profile_load(light, row, column), profile_load(light, row, next), fraction);
    let far = mix(profile_load(light, row + 1u, column), profile_load(light, row + 1u, next), fraction);
    return mix(near, far, v - f32(row));
}

// Irradiance at `distance` metres from a light with a place, wi pointing to it.
fn irradiance_punctual(light: Light, wi: vec3<f32>, distance: f32) -> vec3<f32> {
    var attenuation = range_attenuation(distance, light.range) / sqr(distance);
    if light.kind == LIGHT_SPOT {
        attenuation *= spot_attenuation(-dot(wi, light.direction), light.cos_inner, light.cos_outer);
    }
    if PROFILES && light.kind == LIGHT_PROFILE {
        attenuation *= profile_intensity(light, -wi);
    }
    return attenuation * light.radiance;
}
