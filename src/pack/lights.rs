//! The table of lights and its alias table (see `shaders/light/light.wgsl`).
//!
//! A light is chosen in proportion to its weight: its power divided by pi, in watts of luminance
//! (683 lm not applied), so that a triangle, which sends pi L A, weighs its mean luminance times
//! its area, and the density of its points per area is a constant of its material.

use super::PackError;
use crate::scene::{Profile, PunctualKind, PunctualLight};
use crate::shared::{
    LIGHT_DIRECTIONAL, LIGHT_ENVIRONMENT, LIGHT_POINT, LIGHT_PROFILE, LIGHT_SPOT, LIGHT_TRIANGLE,
    Light,
};
use bytemuck::Zeroable;
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// Power says too little where lights are near and far: the sky's is counted over the whole
/// scene's disk, whatever stands in its way, and a lamp's however far it is. So neither group, of
/// lights with a place and of lights without, is chosen less often than this, if both are there.
const GROUP_SHARE_MIN: f64 = 0.25;

/// What the choice of a light needs to know beside the table, as `Frame` holds it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightWeights {
    /// Sum of all weights; 0: there is no light.
    pub total: f32,
    /// The environment's; 0: there is none, or it is black.
    pub environment: f32,
}

/// Where the table of a profile stands.
#[derive(Clone, Copy, Debug)]
pub struct PlacedProfile {
    first_word: u32,
    rows: u32,
    columns: u32,
    /// Over all directions, candela.
    mean: f32,
}

/// Appends the tables of all profiles to the texels.
pub fn place_profiles(
    profiles: &[Arc<Profile>],
    texels: &mut Vec<u32>,
) -> Result<Vec<PlacedProfile>, PackError> {
    let place = |profile: &Arc<Profile>| {
        let first_word = super::index("texels", texels.len())?;
        texels.extend(profile.candela.iter().map(|value| value.to_bits()));
        super::index("texels", texels.len())?;
        Ok(PlacedProfile {
            first_word,
            rows: profile.rows,
            columns: profile.columns,
            mean: profile.mean() as f32,
        })
    };
    profiles.iter().map(place).collect()
}

/// The entry of a punctual light; `build_lights` weighs it. `profiles` are those of its scene.
pub fn punctual_light(light: &PunctualLight, profiles: &[PlacedProfile]) -> Light {
    let mut packed = Light {
        position: light.position.to_array(),
        direction: light.direction.to_array(),
        radiance: light.intensity.to_array(),
        range: light.range.unwrap_or(0.0),
        ..Light::zeroed()
    };
    packed.kind = match light.kind {
        PunctualKind::Point => LIGHT_POINT,
        PunctualKind::Directional => LIGHT_DIRECTIONAL,
        PunctualKind::Spot {
            inner_angle,
            outer_angle,
        } => {
            packed.cos_inner = inner_angle.cos();
            packed.cos_outer = outer_angle.cos();
            LIGHT_SPOT
        }
        PunctualKind::Profile {
            profile,
            azimuth_zero,
        } => {
            let placed = profiles[profile];
            packed.edge2 = azimuth_zero.to_array();
            packed.profile = placed.first_word;
            packed.profile_rows = placed.rows;
            packed.profile_columns = placed.columns;
            packed.cos_inner = placed.mean;
            LIGHT_PROFILE
        }
    };
    packed
}

/// The entry of an emissive triangle: corners in the world, `radiance` the factor on its texture,
/// `emission_weight` its material's, `triangle` and `instance` its places in those tables.
pub fn triangle_light(
    corners: [Vec3; 3],
    radiance: [f32; 3],
    emission_weight: f32,
    triangle: u32,
    instance: u32,
) -> Light {
    let edge1 = corners[1] - corners[0];
    let edge2 = corners[2] - corners[0];
    // From the edges as the shader has them.
    let area = 0.5 * edge1.as_dvec3().cross(edge2.as_dvec3()).length();
    Light {
        position: corners[0].to_array(),
        kind: LIGHT_TRIANGLE,
        direction: edge1.to_array(),
        edge2: edge2.to_array(),
        radiance,
        weight: (f64::from(emission_weight) * area) as f32,
        triangle,
        instance,
        ..Light::zeroed()
    }
}

/// The entry of the environment, whose luminance averages `mean_luminance` over all directions,
/// its strength included; `build_lights` weighs it.
pub fn environment_light(mean_luminance: f32) -> Light {
    Light {
        kind: LIGHT_ENVIRONMENT,
        radiance: [mean_luminance; 3],
        ..Light::zeroed()
    }
}

/// Weighs all lights but triangles, which come weighed, and fills in the alias table.
/// `scene_radius`: metres, of a sphere around everything that is lit.
pub fn build_lights(lights: &mut [Light], scene_radius: f32) -> LightWeights {
    for light in lights.iter_mut() {
        if light.kind != LIGHT_TRIANGLE {
            light.weight = power_over_pi(light, f64::from(scene_radius)) as f32;
        }
    }
    balance_groups(lights);
    let weights: Vec<f64> = lights.iter().map(|light| f64::from(light.weight)).collect();
    for (light, (index, threshold)) in lights.iter_mut().zip(alias_table(&weights)) {
        light.alias_index = index;
        light.alias_threshold = threshold;
    }
    let environment = lights
        .iter()
        .filter(|light| light.kind == LIGHT_ENVIRONMENT);
    LightWeights {
        total: weights.iter().sum::<f64>() as f32,
        environment: environment.map(|light| light.weight).sum(),
    }
}

/// Whether it has no place.
pub fn is_infinite(light: &Light) -> bool {
    light.kind == LIGHT_DIRECTIONAL || light.kind == LIGHT_ENVIRONMENT
}

/// Power as pbrt counts it (Pharr, Jakob and Humphreys 2023, "Physically based rendering", chapter
/// 12), over pi: 4 pi I of a point, I its mean where it has a profile, 2 pi (1 - mean cosine) I of a spot, pi r^2 E and 4 pi^2 r^2 L
/// of lights that shine through the scene's disk.
fn power_over_pi(light: &Light, radius: f64) -> f64 {
    let luminance = Vec3::from(light.radiance)
        .as_dvec3()
        .dot(DVec3::new(0.2126, 0.7152, 0.0722))
        .max(0.0);
    let factor = match light.kind {
        LIGHT_POINT => 4.0,
        LIGHT_PROFILE => 4.0 * f64::from(light.cos_inner),
        LIGHT_SPOT => {
            let mean_cosine = 0.5 * (f64::from(light.cos_inner) + f64::from(light.cos_outer));
            2.0 * (1.0 - mean_cosine)
        }
        LIGHT_DIRECTIONAL => radius * radius,
        _ => 4.0 * std::f64::consts::PI * radius * radius,
    };
    luminance * factor
}

/// Scales lights without a place so that both groups keep `GROUP_SHARE_MIN`; triangles' weights
/// are tied to their materials and stay.
fn balance_groups(lights: &mut [Light]) {
    let sum = |infinite: bool| -> f64 {
        let group = lights.iter().filter(|light| is_infinite(light) == infinite);
        group.map(|light| f64::from(light.weight)).sum()
    };
    let (finite, infinite) = (sum(false), sum(true));
    if finite <= 0.0 || infinite <= 0.0 {
        return;
    }
    let most = finite * (1.0 - GROUP_SHARE_MIN) / GROUP_SHARE_MIN;
    let least = finite * GROUP_SHARE_MIN / (1.0 - GROUP_SHARE_MIN);
    let scale = infinite.clamp(least, most) / infinite;
    for light in lights.iter_mut().filter(|light| is_infinite(light)) {
        light.weight = (f64::from(light.weight) * scale) as f32;
    }
}

/// For each entry the one to take in its stead, and the share of the entry that it keeps itself.
///
/// Vose 1991, "A linear algorithm for generating random numbers with a given distribution".
pub fn alias_table(weights: &[f64]) -> Vec<(u32, f32)> {
    let total: f64 = weights.iter().sum();
    let mut table: Vec<(u32, f32)> = (0..weights.len() as u32).map(|i| (i, 1.0)).collect();
    if total <= 0.0 {
        return table;
    }
    // In units of the mean, so that an entry is full at 1.
    let mut shares: Vec<f64> = weights
        .iter()
        .map(|weight| weight * weights.len() as f64 / total)
        .collect();
    let (mut small, mut large): (Vec<usize>, Vec<usize>) =
        (0..weights.len()).partition(|&i| shares[i] < 1.0);
    while let (Some(poor), Some(&rich)) = (small.pop(), large.last()) {
        table[poor] = (rich as u32, shares[poor] as f32);
        shares[rich] -= 1.0 - shares[poor];
        if shares[rich] < 1.0 {
            small.extend(large.pop());
        }
    }
    // What is left in either list is full but for rounding.
    table
}
