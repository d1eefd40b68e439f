//! Directional albedo: the share of the light from one direction that leaves the surface.

use super::page::{
    Area, Axis, Curve, Drawn, Figure, GREY, Stroke, chart, legend, px, titled, trace,
};
use super::subject::{Reference, Subject, radiance_density};
use super::{PlotError, direction, luminance};
use plotters::prelude::{DrawingBackend, ViridisRGB};

/// Of each point; evenly spread, they leave errors thinner than a line.
const SAMPLES: usize = 16_384;
/// Points of a curve: every 1.25 degrees, but nothing is seen from within the surface.
const ANGLE_STEPS: u32 = 72;
const LAST_ANGLE: f64 = 89.0;
/// Points of a curve over the roughness.
const ROUGHNESS_STEPS: u32 = 40;

/// Luminance of what goes which way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Albedo {
    pub reflected: f64,
    pub transmitted: f64,
}

#[derive(Clone, Debug)]
pub struct AlbedoFigure {
    name: String,
    axis: &'static str,
    /// Named, with the albedo over the axis.
    lines: Vec<(String, Vec<(f64, Albedo)>)>,
}

/// For light that comes at `theta` from the normal, degrees.
pub fn albedo(subject: &Subject, reference: &Reference, theta: f64) -> Result<Albedo, PlotError> {
    let bsdf = subject.bsdf()?;
    let mut albedo = Albedo::default();
    for sample in reference.samples(&bsdf, direction(theta, 0.0), SAMPLES)? {
        if sample.pdf > 0.0 {
            let share = luminance(sample.f) * sample.wi.z.abs() / sample.pdf / SAMPLES as f64;
            if sample.wi.z > 0.0 {
                albedo.reflected += share;
            } else {
                // f transports radiance: with its density taken out it is the share of the light.
                albedo.transmitted += share * radiance_density(&bsdf);
            }
        }
    }
    Ok(albedo)
}

const ANGLE: &str = "angle of incidence θ (degrees)";
const ROUGHNESS: &str = "roughness (α = roughness²)";

impl AlbedoFigure {
    /// Over the angle, with a curve for each roughness; one curve for a material without roughness.
    pub fn over_angle(
        subject: &Subject,
        reference: &Reference,
        roughnesses: &[f64],
    ) -> Result<Self, PlotError> {
        let rough: Option<Vec<_>> = roughnesses
            .iter()
            .map(|&r| Some((format!("roughness {r}"), subject.with_roughness(r)?)))
            .collect();
        let rough = rough.unwrap_or_else(|| vec![(String::new(), subject.clone())]);
        let mut lines = Vec::new();
        for (name, subject) in rough {
            let mut points = Vec::new();
            for i in 0..=ANGLE_STEPS {
                let theta = (90.0 * f64::from(i) / f64::from(ANGLE_STEPS)).min(LAST_ANGLE);
                points.push((theta, albedo(&subject, reference, theta)?));
            }
            lines.push((name, points));
        }
        Ok(Self {
            name: subject.name.clone(),
            axis: ANGLE,
            lines,
        })
    }

    /// Over the roughness, with a curve for each angle, degrees.
    pub fn over_roughness(
        subject: &Subject,
        reference: &Reference,
        angles: &[f64],
    ) -> Result<Self, PlotError> {
        let mut lines: Vec<(String, Vec<(f64, Albedo)>)> = angles
            .iter()
            .map(|theta| (format!("θ = {theta}°"), Vec::new()))
            .collect();
        for i in 0..=ROUGHNESS_STEPS {
            let roughness = f64::from(i) / f64::from(ROUGHNESS_STEPS);
            let rough = subject
                .with_roughness(roughness)
                .ok_or_else(|| PlotError::NoRoughness(subject.name.clone()))?;
            for (&theta, (_, points)) in angles.iter().zip(&mut lines) {
                points.push((roughness, albedo(&rough, reference, theta)?));
            }
        }
        Ok(Self {
            name: subject.name.clone(),
            axis: ROUGHNESS,
            lines,
        })
    }

    /// Both directions together, and reflection by itself where anything is transmitted.
    pub fn curves(&self) -> Vec<Curve> {
        let transmits = self
            .lines
            .iter()
            .flat_map(|(_, points)| points)
            .any(|(_, albedo)| albedo.transmitted > 0.0);
        let last = (self.lines.len() - 1).max(1) as f64;
        let mut curves = Vec::new();
        for (i, (name, points)) in self.lines.iter().enumerate() {
            // The yellow end of the colours is too light for a line.
            let stroke = Stroke::solid(ViridisRGB::get_color(0.88 * i as f64 / last));
            let all = |albedo: Albedo| albedo.reflected + albedo.transmitted;
            curves.push(Curve {
                name: name.clone(),
                points: points.iter().map(|&(x, albedo)| (x, all(albedo))).collect(),
                stroke,
            });
            if transmits {
                curves.push(Curve {
                    name: format!("{name}, reflected"),
                    points: points.iter().map(|&(x, a)| (x, a.reflected)).collect(),
                    stroke: stroke.wide(1.6).dashed(),
                });
            }
        }
        curves
    }
}

impl Figure for AlbedoFigure {
    fn size(&self) -> [i32; 2] {
        [790, 480]
    }

    fn draw<DB: DrawingBackend>(&self, page: &Area<DB>) -> Drawn<DB> {
        let title = format!("Directional albedo of {}", self.name);
        let rest = titled(
            page,
            &title,
            "luminance of the share of the light that leaves the surface",
        )?;
        let (left, right) = rest.split_horizontally(rest.dim_in_pixel().0 as i32 - px(190.0));
        let curves = self.curves();
        let highest = curves
            .iter()
            .flat_map(|curve| &curve.points)
            .fold(1.0, |high: f64, point| high.max(point.1 - 0.01));
        let axis = match self.axis {
            ANGLE => Axis::degrees(ANGLE),
            other => Axis::share(other, 0.0, 1.0),
        };
        let chart = chart(&left, axis, Axis::share("albedo", 0.0, highest))?;
        for curve in &curves {
            trace(chart.plotting_area(), &curve.points, curve.stroke)?;
        }
        let mut entries: Vec<(&str, Stroke)> = curves
            .iter()
            .filter(|curve| !curve.stroke.dashed && !curve.name.is_empty())
            .map(|curve| (curve.name.as_str(), curve.stroke))
            .collect();
        if curves.iter().any(|curve| curve.stroke.dashed) {
            entries.push(("reflected or transmitted", Stroke::solid(GREY)));
            entries.push(("reflected only", Stroke::solid(GREY).wide(1.6).dashed()));
        }
        legend(&right, (0, px(24.0)), &entries)
    }
}
