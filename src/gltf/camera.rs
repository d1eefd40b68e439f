//! Cameras of the file (glTF 2.0 section 3.10).

use super::error::GltfError;
use super::json::Json;
use super::node::{Nodes, rigid, to_f32};
use crate::scene::{Camera, Projection};
use glam::DAffine3;
use std::f32::consts::PI;

/// The camera that a node holds, if it holds one; `closing` is where the node is when the shutter
/// closes, if it moves.
pub fn camera(
    nodes: &Nodes<'_>,
    node: usize,
    closing: Option<DAffine3>,
) -> Result<Option<Camera>, GltfError> {
    let json = &nodes.json[node];
    let Some((_, camera)) = json.reference("camera", "cameras")? else {
        return Ok(None);
    };
    nodes.world_f32(node)?;
    let name = match json.value().get("name") {
        Some(_) => json.name(),
        None => camera.name(),
    };
    Ok(Some(Camera {
        name,
        world_from_camera: to_f32(rigid(nodes.world(node))),
        closing: closing.map(|world| to_f32(rigid(world))),
        lens: None,
        projection: projection(&camera)?,
    }))
}

fn projection(camera: &Json<'_>) -> Result<Projection, GltfError> {
    let kind = camera.required("type")?;
    let kind_name = kind.as_string()?;
    let lens = |name: &str| {
        camera
            .object(name)?
            .ok_or_else(|| camera.invalid(format!("`{name}` is missing")))
    };
    match kind_name {
        "perspective" => {
            let lens = lens("perspective")?;
            let yfov = positive(&lens, "yfov")?;
            if yfov >= PI {
                return Err(lens.invalid(format!("yfov is {yfov}; it must be less than pi")));
            }
            let aspect = match lens.get("aspectRatio") {
                Some(_) => Some(positive(&lens, "aspectRatio")?),
                None => None,
            };
            Ok(Projection::Perspective {
                yfov,
                aspect,
                near: near(&lens)?,
            })
        }
        "orthographic" => {
            let lens = lens("orthographic")?;
            Ok(Projection::Orthographic {
                xmag: positive(&lens, "xmag")?,
                ymag: positive(&lens, "ymag")?,
                near: near(&lens)?,
            })
        }
        _ => Err(kind.invalid(format!(
            "`{kind_name}` is neither perspective nor orthographic"
        ))),
    }
}

fn positive(lens: &Json<'_>, key: &str) -> Result<f32, GltfError> {
    let value = lens.required(key)?.as_number()?;
    if value > 0.0 {
        Ok(value)
    } else {
        Err(lens.invalid(format!("{key} is {value}; it must be more than 0")))
    }
}

fn near(lens: &Json<'_>) -> Result<f32, GltfError> {
    let near = lens.number("znear")?.unwrap_or(0.0);
    if near >= 0.0 {
        Ok(near)
    } else {
        Err(lens.invalid(format!("znear is {near}; it must not be negative")))
    }
}
