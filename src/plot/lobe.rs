//! Polar curves of f cos theta_i in a plane through the normal.

use super::page::{
    Area, BLUE, Drawn, FAINT, Figure, GREEN, GREY, INK, NORMAL, ORANGE, PURPLE, Plane, SMALL, Side,
    Stroke, VERMILION, legend, letters, locate, plane, px, titled, trace, write,
};
use super::subject::{Reference, Subject};
use super::{PlotError, direction, luminance};
use plotters::prelude::{DrawingBackend, RGBColor};

/// Powers of ten that a logarithmic radius spans.
const DECADES: i32 = 4;
/// Points to a degree of the plane.
const FINENESS: i32 = 4;
const COLORS: [RGBColor; 6] = [BLUE, VERMILION, GREEN, PURPLE, ORANGE, INK];

/// What light from each direction of the plane adds to what is seen from one.
#[derive(Clone, Debug, PartialEq)]
pub struct Lobe {
    /// The viewer's angle from the normal, degrees, on the left of the figure.
    pub theta_o: f64,
    /// The light's angle from the normal, degrees, positive on the right and beyond 90 below; with the
    /// luminance of f |cos theta_i|, 1/sr.
    pub points: Vec<(f64, f64)>,
}

#[derive(Clone, Debug)]
pub struct LobeFigure {
    name: String,
    phi: f64,
    lobes: Vec<Lobe>,
    transmits: bool,
    delta: bool,
    radius: Radius,
}

/// What the distance from the middle means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Radius {
    Linear,
    Logarithmic,
}

/// The lobe for a viewer at `theta_o`, in the plane at `phi` from the tangent, degrees.
pub fn lobe(
    subject: &Subject,
    reference: &Reference,
    theta_o: f64,
    phi: f64,
) -> Result<Lobe, PlotError> {
    let wo = direction(-theta_o, phi);
    let angles: Vec<f64> = (-180 * FINENESS..=180 * FINENESS)
        .map(|i| f64::from(i) / f64::from(FINENESS))
        .collect();
    let wi: Vec<_> = angles.iter().map(|&angle| direction(angle, phi)).collect();
    let f = reference.f(&subject.bsdf()?, wo, &wi)?;
    let values = f.iter().zip(&wi).map(|(f, wi)| luminance(*f) * wi.z.abs());
    Ok(Lobe {
        theta_o,
        points: angles.into_iter().zip(values).collect(),
    })
}

impl LobeFigure {
    /// One lobe for each of the viewer's angles, degrees.
    pub fn new(
        subject: &Subject,
        reference: &Reference,
        angles: &[f64],
        phi: f64,
        radius: Radius,
    ) -> Result<Self, PlotError> {
        let parts = reference.parts(&subject.bsdf()?)?;
        if !parts.spread {
            return Err(PlotError::Smooth(subject.name.clone()));
        }
        let lobes: Result<Vec<Lobe>, PlotError> = angles
            .iter()
            .map(|&theta_o| lobe(subject, reference, theta_o, phi))
            .collect();
        Ok(Self {
            name: subject.name.clone(),
            phi,
            lobes: lobes?,
            transmits: parts.transmits,
            delta: parts.delta,
            radius,
        })
    }
}

/// The rings around the middle: where values lie, the outermost at 1.
struct Rings {
    radius: Radius,
    /// Value and radius, outward.
    rings: Vec<(f64, f64)>,
}

impl Rings {
    fn new(radius: Radius, highest: f64) -> Self {
        let rings = match radius {
            Radius::Linear => {
                let step = round_up(highest / 4.0);
                let count = (highest / step - 1e-9).ceil();
                (1..=count as i32)
                    .map(|i| (step * f64::from(i), f64::from(i) / count))
                    .collect()
            }
            Radius::Logarithmic => {
                let top = highest.log10().ceil() as i32;
                (1..=DECADES)
                    .map(|i| {
                        (
                            10f64.powi(top - DECADES + i),
                            f64::from(i) / f64::from(DECADES),
                        )
                    })
                    .collect()
            }
        };
        Self { radius, rings }
    }

    fn at(&self, value: f64) -> f64 {
        let top = self.rings.last().map_or(1.0, |ring| ring.0);
        match self.radius {
            Radius::Linear => value / top,
            Radius::Logarithmic => (1.0 + (value / top).log10() / f64::from(DECADES)).max(0.0),
        }
    }
}

/// The next 1, 2 or 5 times a power of ten that is not below `x`.
fn round_up(x: f64) -> f64 {
    let power = 10f64.powf(x.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .find(|step| step * power >= x * (1.0 - 1e-9));
    power * step.unwrap_or(10.0)
}

/// With three digits.
fn digits(x: f64) -> String {
    let decimals = (2.0 - x.max(1e-3).log10().floor()).max(0.0) as usize;
    format!("{x:.decimals$}")
}

fn polar(angle: f64, radius: f64) -> (f64, f64) {
    let w = direction(angle, 0.0);
    (radius * w.x, radius * w.z)
}

impl Figure for LobeFigure {
    fn size(&self) -> [i32; 2] {
        [860, if self.transmits { 760 } else { 450 }]
    }

    fn draw<DB: DrawingBackend>(&self, page: &Area<DB>) -> Drawn<DB> {
        let lobes = if self.transmits {
            "Reflection and transmission"
        } else {
            "Reflection"
        };
        let title = format!("{lobes} lobes of {}", self.name);
        let mut subtitle = "luminance of f cos θ (1/sr) in the plane of incidence".to_owned();
        if self.phi != 0.0 {
            subtitle += &format!(", {}° from the tangent", self.phi);
        }
        if self.radius == Radius::Logarithmic {
            subtitle += ", logarithmic";
        }
        if self.delta {
            subtitle += "; single directions are left out";
        }
        let rest = titled(page, &title, &subtitle)?;
        let (left, right) = rest.split_horizontally(rest.dim_in_pixel().0 as i32 - px(190.0));
        let peak = |lobe: &Lobe| lobe.points.iter().map(|p| p.1).fold(0.0, f64::max);
        let highest = self
            .lobes
            .iter()
            .map(peak)
            .fold(f64::MIN_POSITIVE, f64::max);
        let rings = Rings::new(self.radius, highest);
        // With room for what is written around.
        let low = if self.transmits { -1.1 } else { -0.1 };
        let plane = plane(&left, -1.12..1.12, low..1.1);
        grid(&plane, &rings, self.transmits)?;
        for (lobe, color) in self.lobes.iter().zip(COLORS.iter().cycle()) {
            let viewer = [(0.0, 0.0), polar(-lobe.theta_o, 1.0)];
            trace(&plane, &viewer, Stroke::solid(*color).wide(1.2).dashed())?;
            let points: Vec<_> = lobe
                .points
                .iter()
                .map(|&(angle, value)| polar(angle, rings.at(value)))
                .collect();
            trace(&plane, &points, Stroke::solid(*color))?;
        }
        let names: Vec<String> = self
            .lobes
            .iter()
            .map(|lobe| format!("viewer at {}°, peak {}", lobe.theta_o, digits(peak(lobe))))
            .collect();
        let mut entries: Vec<(&str, Stroke)> = names
            .iter()
            .zip(COLORS.iter().cycle())
            .map(|(name, color)| (name.as_str(), Stroke::solid(*color)))
            .collect();
        entries.push((
            "where the viewer is",
            Stroke::solid(GREY).wide(1.2).dashed(),
        ));
        legend(&right, (0, px(30.0)), &entries)
    }
}

/// Rings with their values and rays with their angles.
fn grid<DB: DrawingBackend>(plane: &Plane<DB>, rings: &Rings, whole: bool) -> Drawn<DB> {
    let faint = Stroke::solid(FAINT).wide(0.8);
    let end: i32 = if whole { 180 } else { 90 };
    let area = plane.strip_coord_spec();
    for (_, radius) in &rings.rings {
        let circle: Vec<_> = (-end..=end).map(|a| polar(f64::from(a), *radius)).collect();
        trace(plane, &circle, faint)?;
    }
    for angle in (-end..=end).step_by(30) {
        let rim = polar(f64::from(angle), 1.0);
        trace(plane, &[(0.0, 0.0), rim], faint)?;
        if angle > -180 {
            let (x, y) = locate(plane, rim);
            let out = |along: f64, distance: f64| (along * f64::from(px(distance))) as i32;
            let place = (x + out(rim.0, 19.0), y - out(rim.1, 14.0));
            let name = format!("{}°", angle.abs());
            write(&area, &name, place, Side::Middle, &letters(NORMAL, INK))?;
        }
    }
    trace(
        plane,
        &[(-1.0, 0.0), (1.0, 0.0)],
        Stroke::solid(INK).wide(1.2),
    )?;
    for (value, radius) in &rings.rings {
        let (x, y) = locate(plane, (*radius, 0.0));
        let below = (x - px(4.0), y + px(9.0));
        write(
            &area,
            &scale_value(*value),
            below,
            Side::Left,
            &letters(SMALL, GREY),
        )?;
    }
    Ok(())
}

/// A ring's value, a round number.
fn scale_value(value: f64) -> String {
    if !(1e-3..1e4).contains(&value) {
        return format!("{value:.0e}");
    }
    let decimals = (-value.log10().floor() + 1.0).max(0.0) as usize;
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}
