//! How much a smooth boundary reflects, against the angle of incidence.
#![allow(non_snake_case, reason = "the symbols of the textbooks")]

use super::page::{
    Area, Axis, BLUE, Curve, Drawn, Figure, GREEN, INK, Side, Stroke, VERMILION, chart, legend,
    mark, number, px, titled, trace,
};
use super::subject::{Reference, Subject};
use super::{PlotError, direction};
use crate::cpu::bsdf::fresnel::{F_conductor, F_conductor_approximate, F_dielectric, snell_root};
use crate::scene::metals::Metal;
use crate::shared::{
    BSDF_DIELECTRIC, BSDF_GLTF, BSDF_ROUGH_DIELECTRIC, BSDF_SPECULAR_REFLECTION,
    BSDF_SPECULAR_TRANSMISSION, BSDF_TORRANCE_SPARROW, FRESNEL_CONDUCTOR,
    FRESNEL_CONDUCTOR_APPROXIMATE, FRESNEL_CONSTANT, FRESNEL_DIELECTRIC,
};
use plotters::prelude::{DrawingBackend, RGBColor};

/// Steps from 0 to 90 degrees; both ends are points.
const STEPS: u32 = 360;

const CHANNELS: [(&str, RGBColor); 3] = [("red", VERMILION), ("green", GREEN), ("blue", BLUE)];

/// Which boundary.
#[derive(Clone, Debug, PartialEq)]
pub enum FresnelFigure {
    /// Seen from both sides; `eta` is the far side's index over the near side's, seen from outside.
    Dielectric { eta: f64 },
    /// Complex index at red, green and blue, over a medium of index 1.
    Conductor {
        name: String,
        eta: [f64; 3],
        k: [f64; 3],
    },
    /// Curves that a material's own form gives, one for each channel.
    Own { name: String, curves: Vec<Curve> },
}

/// Where light polarised in the plane of incidence is not reflected, degrees; Brewster 1815.
pub fn brewster_angle(eta: f64) -> f64 {
    eta.atan().to_degrees()
}

/// From where on everything is reflected, degrees; only into the thinner medium.
pub fn critical_angle(eta: f64) -> Option<f64> {
    (eta < 1.0).then(|| eta.asin().to_degrees())
}

/// Reflectances across the plane of incidence (s) and in it (p).
pub fn polarised(cos_theta: f64, eta: f64) -> [f64; 2] {
    // Lecture, "Fresnel Dielectrics", with q = eta cos theta_t; past the critical angle q is imaginary and
    // both quotients have modulus 1, which is what they give for q = 0.
    let q = snell_root(cos_theta, eta);
    if q == 0.0 || cos_theta == 0.0 {
        return [1.0; 2];
    }
    let s = (cos_theta - q) / (cos_theta + q);
    let p = (eta * eta * cos_theta - q) / (eta * eta * cos_theta + q);
    [s * s, p * p]
}

/// Both polarisations and their mean, the mean as the renderers have it. Angles in degrees.
pub fn dielectric_curves(eta: f64) -> [Curve; 3] {
    let mut angles = angles();
    // The curves have a corner and a zero there.
    angles.extend(critical_angle(eta));
    angles.push(brewster_angle(eta));
    angles.sort_by(f64::total_cmp);
    let curve = |name: &str, stroke, F: &dyn Fn(f64) -> f64| Curve {
        name: name.into(),
        points: angles.iter().map(|&a| (a, F(cos_degrees(a)))).collect(),
        stroke,
    };
    [
        curve("s-polarised", Stroke::solid(BLUE), &|c| {
            polarised(c, eta)[0]
        }),
        curve("p-polarised", Stroke::solid(VERMILION), &|c| {
            polarised(c, eta)[1]
        }),
        curve("unpolarised", Stroke::solid(INK).wide(2.6), &|c| {
            F_dielectric(c, eta)
        }),
    ]
}

/// The exact reflectance of each channel, then the lecture's approximation of each. Angles in degrees.
pub fn conductor_curves(eta: [f64; 3], k: [f64; 3]) -> Vec<Curve> {
    type Reflectance = fn(f64, f64, f64) -> f64;
    let forms: [(&str, Reflectance, bool); 2] = [
        ("exact", F_conductor, false),
        ("approximate", F_conductor_approximate, true),
    ];
    let mut curves = Vec::new();
    for (form, F, dashed) in forms {
        for (i, (channel, color)) in CHANNELS.into_iter().enumerate() {
            let point = |angle: f64| (angle, F(cos_degrees(angle), eta[i], k[i]));
            curves.push(Curve {
                name: format!("{channel}, {form}"),
                points: angles().into_iter().map(point).collect(),
                stroke: Stroke {
                    dashed,
                    ..Stroke::solid(color)
                },
            });
        }
    }
    curves
}

fn angles() -> Vec<f64> {
    (0..=STEPS)
        .map(|i| 90.0 * f64::from(i) / f64::from(STEPS))
        .collect()
}

fn cos_degrees(angle: f64) -> f64 {
    direction(angle, 0.0).z.max(0.0)
}

impl FresnelFigure {
    /// A metal of the table.
    pub fn metal(metal: &Metal) -> Self {
        let [eta, k] = metal.index().map(|channels| channels.map(f64::from));
        Self::Conductor {
            name: format!("{} ({})", metal.symbol, metal.authors()),
            eta,
            k,
        }
    }

    /// The boundary that a material has.
    pub fn of(subject: &Subject, reference: &Reference) -> Result<Self, PlotError> {
        let bsdf = subject.bsdf()?;
        let name = subject.name.clone();
        let dielectric = matches!(
            bsdf.model,
            BSDF_DIELECTRIC | BSDF_ROUGH_DIELECTRIC | BSDF_SPECULAR_TRANSMISSION
        );
        let facets = matches!(bsdf.model, BSDF_SPECULAR_REFLECTION | BSDF_TORRANCE_SPARROW);
        if dielectric || facets && bsdf.fresnel == FRESNEL_DIELECTRIC {
            return Ok(Self::Dielectric {
                eta: f64::from(bsdf.eta[0]),
            });
        }
        if facets
            && matches!(
                bsdf.fresnel,
                FRESNEL_CONDUCTOR | FRESNEL_CONDUCTOR_APPROXIMATE
            )
        {
            return Ok(Self::Conductor {
                name,
                eta: bsdf.eta.map(f64::from),
                k: bsdf.k.map(f64::from),
            });
        }
        if bsdf.model != BSDF_GLTF && bsdf.fresnel == FRESNEL_CONSTANT {
            return Err(PlotError::NoFresnel(name));
        }
        let angles = angles();
        let cosines: Vec<f64> = angles.iter().map(|&angle| cos_degrees(angle)).collect();
        let reflectances = reference.fresnel(&bsdf, &cosines)?;
        let mut curves = Vec::new();
        for (channel, (channel_name, color)) in CHANNELS.into_iter().enumerate() {
            let values = reflectances.iter().map(|F| F[channel]);
            curves.push(Curve {
                name: channel_name.into(),
                points: angles.iter().copied().zip(values).collect(),
                stroke: Stroke::solid(color),
            });
        }
        if curves[1..]
            .iter()
            .all(|curve| curve.points == curves[0].points)
        {
            curves.truncate(1);
            curves[0].name = "all channels".into();
            curves[0].stroke.color = INK;
        }
        Ok(Self::Own { name, curves })
    }
}

impl Figure for FresnelFigure {
    fn size(&self) -> [i32; 2] {
        match self {
            Self::Dielectric { .. } => [960, 460],
            Self::Conductor { .. } | Self::Own { .. } => [790, 480],
        }
    }

    fn draw<DB: DrawingBackend>(&self, page: &Area<DB>) -> Drawn<DB> {
        match self {
            Self::Dielectric { eta } => draw_dielectric(page, *eta),
            Self::Conductor { name, eta, k } => {
                let list = |values: &[f64; 3]| values.map(|v| format!("{v:.3}")).join(", ");
                let indices = format!("η = {}; k = {} (red, green, blue)", list(eta), list(k));
                let title = format!("Fresnel reflectance of a conductor: {name}");
                draw_channels(page, &title, &indices, &conductor_curves(*eta, *k))
            }
            Self::Own { name, curves } => {
                let title = format!("Fresnel reflectance of {name}");
                let at_normal: Vec<String> = curves
                    .iter()
                    .map(|curve| format!("{:.3}", curve.points[0].1))
                    .collect();
                let subtitle = format!("F = {} at normal incidence", at_normal.join(", "));
                draw_channels(page, &title, &subtitle, curves)
            }
        }
    }
}

fn draw_dielectric<DB: DrawingBackend>(page: &Area<DB>, eta: f64) -> Drawn<DB> {
    let title = format!("Fresnel reflectance of a dielectric, η = {}", number(eta));
    let rest = titled(
        page,
        &title,
        "reflectance of each polarisation and of unpolarised light, from both sides",
    )?;
    let panels = rest.split_evenly((1, 2));
    for (panel, (side, eta)) in panels.iter().zip([("outside", eta), ("inside", 1.0 / eta)]) {
        let label = format!(
            "angle of incidence θ from {side} (degrees), η = {}",
            number(eta)
        );
        let chart = chart(
            panel,
            Axis::degrees(&label),
            Axis::share("reflectance", 0.0, 1.0),
        )?;
        let curves = dielectric_curves(eta);
        for curve in &curves {
            trace(chart.plotting_area(), &curve.points, curve.stroke)?;
        }
        if eta != 1.0 {
            let angle = brewster_angle(eta);
            let name = format!("Brewster angle {angle:.1}°");
            // Left of the line, where the critical angle is close to its right.
            mark(&chart, angle, (0.0, 1.0), &name, Side::Left, 0.62)?;
        }
        if let Some(angle) = critical_angle(eta) {
            let name = format!("critical angle {angle:.1}°");
            mark(&chart, angle, (0.0, 1.0), &name, Side::Right, 0.62)?;
        }
        let entries: Vec<(&str, Stroke)> =
            curves.iter().map(|c| (c.name.as_str(), c.stroke)).collect();
        legend(panel, (px(86.0), px(38.0)), &entries)?;
    }
    Ok(())
}

fn draw_channels<DB: DrawingBackend>(
    page: &Area<DB>,
    title: &str,
    subtitle: &str,
    curves: &[Curve],
) -> Drawn<DB> {
    let rest = titled(page, title, subtitle)?;
    let width = rest.dim_in_pixel().0 as i32;
    let (left, right) = rest.split_horizontally(width - px(190.0));
    let values = || curves.iter().flat_map(|c| &c.points).map(|p| p.1);
    // High reflectances would all lie at the upper edge of an axis from 0.
    let lowest = (10.0 * values().fold(1.0, f64::min)).floor() / 10.0;
    let highest = values().fold(1.0, f64::max);
    let chart = chart(
        &left,
        Axis::degrees("angle of incidence θ (degrees)"),
        Axis::share("reflectance", lowest, highest),
    )?;
    for curve in curves {
        trace(chart.plotting_area(), &curve.points, curve.stroke)?;
    }
    let entries: Vec<(&str, Stroke)> = curves.iter().map(|c| (c.name.as_str(), c.stroke)).collect();
    legend(&right, (0, px(24.0)), &entries)
}
