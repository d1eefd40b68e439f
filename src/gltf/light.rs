//! KHR_lights_punctual.

use super::error::GltfError;
use super::json::Json;
use super::node::{Nodes, rigid};
use super::notes::Notes;
use crate::scene::{PunctualKind, PunctualLight};
use glam::{DVec3, Vec3};
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

pub const NAME: &str = "KHR_lights_punctual";

/// The lights that the file defines.
pub fn lights<'a>(root: &Json<'a>) -> Result<Vec<Json<'a>>, GltfError> {
    match root.extension(NAME)? {
        Some(extension) => extension.objects("lights"),
        None => Ok(Vec::new()),
    }
}

/// The light that a node holds, if it holds one. Scale does not touch it.
pub fn light(
    nodes: &Nodes<'_>,
    node: usize,
    lights: &[Json<'_>],
    notes: &mut Notes,
) -> Result<Option<PunctualLight>, GltfError> {
    let json = &nodes.json[node];
    let Some(extension) = json.extension(NAME)? else {
        return Ok(None);
    };
    let index = extension.required("light")?;
    let number = index.as_uint()?;
    let Some(light) = usize::try_from(number)
        .ok()
        .and_then(|number| lights.get(number))
    else {
        return Err(index.invalid(format!(
            "{number} is out of range: there are {} lights",
            lights.len()
        )));
    };
    let color = Vec3::from(light.vector("color")?.unwrap_or([1.0; 3]));
    let intensity = color * light.number("intensity")?.unwrap_or(1.0);
    if !intensity.is_finite() || intensity.min_element() < 0.0 {
        return Err(light.invalid("its intensity is negative or not finite"));
    }
    let range = light.number("range")?.filter(|&range| range > 0.0);
    if range.is_none() && light.get("range").is_some() {
        notes.add(
            "a light's range that is not positive is left out",
            &light.at,
        );
    }
    let position = nodes.world_f32(node)?.translation.into();
    let direction = rigid(nodes.world(node)).transform_vector3(DVec3::NEG_Z);
    Ok(Some(PunctualLight {
        name: light.name(),
        kind: kind(light, notes)?,
        intensity,
        position,
        direction: direction.as_vec3(),
        range,
    }))
}

fn kind(light: &Json<'_>, notes: &mut Notes) -> Result<PunctualKind, GltfError> {
    let kind = light.required("type")?;
    match kind.as_string()? {
        "point" => Ok(PunctualKind::Point),
        "directional" => Ok(PunctualKind::Directional),
        "spot" => {
            let spot = light.object("spot")?;
            let angle = |key: &str, default: f32| match &spot {
                Some(spot) => Ok(spot.number(key)?.unwrap_or(default)),
                None => Ok(default),
            };
            let inner = angle("innerConeAngle", 0.0)?;
            let outer = angle("outerConeAngle", FRAC_PI_4)?;
            let outer_angle = outer.clamp(0.0, FRAC_PI_2);
            let inner_angle = inner.clamp(0.0, outer_angle);
            if (inner_angle, outer_angle) != (inner, outer) {
                notes.add(
                    "spot angles outside of 0 <= inner <= outer <= pi/2 are clamped",
                    &light.at,
                );
            }
            Ok(PunctualKind::Spot {
                inner_angle,
                outer_angle,
            })
        }
        other => Err(kind.invalid(format!("`{other}` is none of point, spot, directional"))),
    }
}
