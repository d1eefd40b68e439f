//! `--intrinsics`: a calibrated camera from a file; see schema/intrinsics.schema.json.

use std::path::Path;

use glam::{Affine3A, DMat3, DVec3};
use serde::Deserialize;

use crate::error::Error;
use crate::scene::{Distortion, Intrinsics};

/// What the file says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    pub intrinsics: Intrinsics,
    /// Ours: x right, y up, looking along -z. `None`: the file says nothing of a place.
    pub world_from_camera: Option<Affine3A>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    width: u32,
    height: u32,
    fx: f64,
    fy: f64,
    cx: f64,
    cy: f64,
    distortion: Option<Model>,
    camera_from_world: Option<[[f64; 4]; 4]>,
    world_from_camera: Option<[[f64; 4]; 4]>,
}

#[derive(Deserialize)]
#[serde(tag = "model", rename_all = "kebab-case", deny_unknown_fields)]
enum Model {
    BrownConrady(Box<BrownConrady>),
    Fisheye(Fisheye),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
#[derive(Default)]
struct BrownConrady {
    k1: f64,
    k2: f64,
    k3: f64,
    k4: f64,
    k5: f64,
    k6: f64,
    p1: f64,
    p2: f64,
    s1: f64,
    s2: f64,
    s3: f64,
    s4: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
#[derive(Default)]
struct Fisheye {
    k1: f64,
    k2: f64,
    k3: f64,
    k4: f64,
}

/// Files of this kind are a few hundred bytes.
const LARGEST_FILE: u64 = 1 << 20;
/// As `--size` takes it.
const LARGEST_SIDE: u32 = 65536;
/// How far a rotation's rows may be from orthonormal: what six printed digits leave.
const ORTHONORMAL: f64 = 1e-4;

/// Reads and checks the file.
pub fn read(path: &Path) -> Result<Calibration, Error> {
    let invalid = |message: String| Error::Intrinsics {
        path: path.to_owned(),
        message,
    };
    let size =
        std::fs::metadata(path).map_err(|error| invalid(format!("it cannot be read: {error}")))?;
    if size.len() > LARGEST_FILE {
        return Err(invalid(format!(
            "it has {} bytes and intrinsics need no more than {LARGEST_FILE}",
            size.len()
        )));
    }
    let text = std::fs::read_to_string(path)
        .map_err(|error| invalid(format!("it cannot be read: {error}")))?;
    parse(&text).map_err(invalid)
}

fn parse(text: &str) -> Result<Calibration, String> {
    let file: File = serde_json::from_str(text)
        .map_err(|error| format!("{error}; see schema/intrinsics.schema.json"))?;
    for (name, side) in [("width", file.width), ("height", file.height)] {
        if !(1..=LARGEST_SIDE).contains(&side) {
            return Err(format!(
                "{name} is {side}; it must be from 1 to {LARGEST_SIDE}"
            ));
        }
    }
    for (name, focal) in [("fx", file.fx), ("fy", file.fy)] {
        if !(focal > 0.0 && is_float(focal)) {
            return Err(format!("{name} is {focal}; it must be more than 0"));
        }
    }
    if !(is_float(file.cx) && is_float(file.cy)) {
        return Err("cx or cy is beyond single precision".into());
    }
    let distortion = match file.distortion {
        None => Distortion::BrownConrady {
            radial: [0.0; 6],
            tangential: [0.0; 2],
            prism: [0.0; 4],
        },
        Some(Model::BrownConrady(lens)) => Distortion::BrownConrady {
            radial: floats([lens.k1, lens.k2, lens.k3, lens.k4, lens.k5, lens.k6])?,
            tangential: floats([lens.p1, lens.p2])?,
            prism: floats([lens.s1, lens.s2, lens.s3, lens.s4])?,
        },
        Some(Model::Fisheye(lens)) => {
            Distortion::Fisheye(floats([lens.k1, lens.k2, lens.k3, lens.k4])?)
        }
    };
    let place = match (file.camera_from_world, file.world_from_camera) {
        (None, None) => None,
        (Some(rows), None) => {
            let (turn, offset) = rigid("camera_from_world", rows)?;
            Some((turn.transpose(), -(turn.transpose() * offset)))
        }
        (None, Some(rows)) => Some(rigid("world_from_camera", rows)?),
        (Some(_), Some(_)) => {
            return Err("give camera_from_world or world_from_camera, not both".into());
        }
    };
    Ok(Calibration {
        intrinsics: Intrinsics {
            size: [file.width, file.height],
            focal: [file.fx as f32, file.fy as f32],
            center: [file.cx as f32, file.cy as f32],
            distortion,
        },
        // OpenCV's y goes down and its z forward.
        world_from_camera: place.map(|(turn, origin)| {
            let columns = [turn.x_axis, -turn.y_axis, -turn.z_axis].map(|axis| axis.as_vec3());
            Affine3A::from_mat3_translation(
                glam::Mat3::from_cols(columns[0], columns[1], columns[2]),
                origin.as_vec3(),
            )
        }),
    })
}

fn is_float(x: f64) -> bool {
    (x as f32).is_finite()
}

fn floats<const N: usize>(numbers: [f64; N]) -> Result<[f32; N], String> {
    match numbers.iter().find(|x| !is_float(**x)) {
        Some(number) => Err(format!(
            "the coefficient {number} is beyond single precision"
        )),
        None => Ok(numbers.map(|x| x as f32)),
    }
}

/// The turn and the offset of a matrix that must be a rigid motion.
fn rigid(name: &str, rows: [[f64; 4]; 4]) -> Result<(DMat3, DVec3), String> {
    let turn = DMat3::from_cols_array_2d(&[0, 1, 2].map(|c| [0, 1, 2].map(|r| rows[r][c])));
    let offset = DVec3::from_array([0, 1, 2].map(|r| rows[r][3]));
    let off = (turn.transpose() * turn - DMat3::IDENTITY).to_cols_array();
    // Not `> ORTHONORMAL`: that lets NaN pass.
    let orthonormal = off.iter().all(|x| x.abs() <= ORTHONORMAL) && turn.determinant() > 0.0;
    if !orthonormal || rows[3] != [0.0, 0.0, 0.0, 1.0] || !offset.as_vec3().is_finite() {
        return Err(format!(
            "{name} must be a rotation and a translation: 4 rows, orthonormal and right-handed, the last 0, 0, 0, 1"
        ));
    }
    Ok((turn, offset))
}

/// The size to render at: the file's, or another of the same shape.
pub fn size(intrinsics: &Intrinsics, asked: Option<[u32; 2]>) -> Result<[u32; 2], Error> {
    let [width, height] = intrinsics.size;
    let Some(asked) = asked else {
        return Ok([width, height]);
    };
    // A picture scaled to whole pixels is off its shape by less than one of them.
    let scale = f64::from(asked[0]) / f64::from(width);
    if (scale * f64::from(height) - f64::from(asked[1])).abs() < 1.0 {
        return Ok(asked);
    }
    Err(Error::Usage(format!(
        "--size {}x{} has another shape than the {width}x{height} of the intrinsics; leave --size away or keep their ratio",
        asked[0], asked[1]
    )))
}
