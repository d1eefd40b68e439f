//! `snell plot`: what reflection functions look like, as figures for a paper or a lecture.
//!
//! [`subject`] is what is plotted. Each kind of figure has a module that makes its data out of the
//! float64 reference, through the laboratory, and then draws them: [`fresnel`], [`lobe`], [`albedo`],
//! [`sphere`]. [`page`] is the paper: sizes, letters, colours, SVG and PNG.

pub mod albedo;
pub mod fresnel;
pub mod lobe;
pub mod page;
pub mod sphere;
pub mod subject;

use crate::lab::LabError;
use crate::lab::material::MaterialError;
use glam::DVec3;
use std::path::PathBuf;

#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    #[error("'{path}' is not JSON: {reason}; write one material as `snell bsdf` takes it")]
    Json { path: PathBuf, reason: String },
    #[error("the material '{name}' cannot be plotted: {source}")]
    Material { name: String, source: MaterialError },
    #[error(
        "'{0}' spreads no light, so that there is no lobe to show; plot its fresnel or its albedo, or make it rough"
    )]
    Smooth(String),
    #[error(
        "'{0}' has no Fresnel reflectance that depends on the angle; plot its lobe or its albedo"
    )]
    NoFresnel(String),
    #[error("'{0}' has no roughness to vary; plot its albedo against the angle")]
    NoRoughness(String),
    #[error(transparent)]
    Lab(#[from] LabError),
    #[error("cannot draw the plot: {0}")]
    Draw(String),
}

impl PlotError {
    /// 2 wrong usage, 3 input invalid, 4 input needs an unsupported feature, 7 device, 8 no output.
    pub fn exit_status(&self) -> u8 {
        match self {
            Self::Smooth(_) | Self::NoFresnel(_) | Self::NoRoughness(_) => 2,
            Self::Material {
                source: MaterialError::Extension(_),
                ..
            } => 4,
            Self::Json { .. } | Self::Material { .. } => 3,
            Self::Lab(_) => 7,
            Self::Draw(_) => 8,
        }
    }
}

/// The direction at `theta` from the normal and `phi` from the tangent, degrees, in the local frame.
pub fn direction(theta: f64, phi: f64) -> DVec3 {
    let (sin_theta, cos_theta) = theta.to_radians().sin_cos();
    let (sin_phi, cos_phi) = phi.to_radians().sin_cos();
    DVec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta)
}

/// Rec. 709's luminance of a linear colour: figures that need all colours for other things show it.
pub fn luminance(color: DVec3) -> f64 {
    color.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}
