//! f over all directions of light, for one viewer: discs of the upper hemisphere and, where light passes
//! through, of the lower one. Logarithmic.

use super::page::{
    Area, Drawn, Figure, GREY, INK, NORMAL, Plane, SMALL, Side, Stroke, letters, locate, plane, px,
    titled, trace, write,
};
use super::subject::{Reference, Subject};
use super::{PlotError, direction, luminance};
use plotters::prelude::{
    BLACK, Circle, Color, DrawingBackend, PathElement, Polygon, RGBColor, Rectangle, ViridisRGB,
    WHITE,
};

/// Cells of a hemisphere: a degree of elevation by two of azimuth.
const ELEVATIONS: usize = 90;
const AZIMUTHS: usize = 180;
/// Powers of ten below the highest value that are told apart, and colours to each.
const DECADES: i32 = 4;
const SHADES: i32 = 16;
/// Radius of a disc in degrees, with room for what is written around it.
const REACH: f64 = 108.0;

/// The luminance of f, 1/sr, in the middle of each cell of a hemisphere: rows from the normal outward.
#[derive(Clone, Debug, PartialEq)]
pub struct Hemisphere {
    values: Vec<f64>,
}

#[derive(Clone, Debug)]
pub struct SphereFigure {
    name: String,
    theta_o: f64,
    phi_o: f64,
    above: Hemisphere,
    /// Empty of a material that transmits nothing.
    below: Option<Hemisphere>,
    delta: bool,
}

impl Hemisphere {
    /// For a viewer at wo; `up` is 1 above the surface and -1 below.
    fn new(
        subject: &Subject,
        reference: &Reference,
        wo: glam::DVec3,
        up: f64,
    ) -> Result<Self, PlotError> {
        let wi: Vec<_> = (0..ELEVATIONS * AZIMUTHS)
            .map(|cell| {
                let [theta, phi] = middle(cell / AZIMUTHS, cell % AZIMUTHS);
                let w = direction(theta, phi);
                glam::DVec3::new(w.x, w.y, up * w.z)
            })
            .collect();
        let f = reference.f(&subject.bsdf()?, wo, &wi)?;
        Ok(Self {
            values: f.into_iter().map(luminance).collect(),
        })
    }

    /// In the cell around these angles from the normal and from the tangent, degrees.
    pub fn at(&self, theta: f64, phi: f64) -> f64 {
        let row = (theta / 90.0 * ELEVATIONS as f64) as usize;
        let column = (phi.rem_euclid(360.0) / 360.0 * AZIMUTHS as f64) as usize;
        self.values[row.min(ELEVATIONS - 1) * AZIMUTHS + column.min(AZIMUTHS - 1)]
    }

    fn highest(&self) -> f64 {
        self.values.iter().copied().fold(0.0, f64::max)
    }
}

/// Degrees from the normal and from the tangent.
fn middle(row: usize, column: usize) -> [f64; 2] {
    [
        90.0 * (row as f64 + 0.5) / ELEVATIONS as f64,
        360.0 * (column as f64 + 0.5) / AZIMUTHS as f64,
    ]
}

impl SphereFigure {
    /// For a viewer at these angles from the normal and from the tangent, degrees.
    pub fn new(
        subject: &Subject,
        reference: &Reference,
        theta_o: f64,
        phi_o: f64,
    ) -> Result<Self, PlotError> {
        let parts = reference.parts(&subject.bsdf()?)?;
        if !parts.spread {
            return Err(PlotError::Smooth(subject.name.clone()));
        }
        let wo = direction(theta_o, phi_o);
        let below = match parts.transmits {
            true => Some(Hemisphere::new(subject, reference, wo, -1.0)?),
            false => None,
        };
        Ok(Self {
            name: subject.name.clone(),
            theta_o,
            phi_o,
            above: Hemisphere::new(subject, reference, wo, 1.0)?,
            below,
            delta: parts.delta,
        })
    }

    /// f towards light from above.
    pub fn above(&self) -> &Hemisphere {
        &self.above
    }
}

/// From the power of ten at or above the highest value downward.
struct Scale {
    top: i32,
}

impl Scale {
    /// Of 0 to `DECADES` * `SHADES` - 1.
    fn shade(&self, value: f64) -> i32 {
        let below = f64::from(self.top) - value.max(f64::MIN_POSITIVE).log10();
        let shade = ((f64::from(DECADES) - below) * f64::from(SHADES)).floor();
        (shade as i32).clamp(0, DECADES * SHADES - 1)
    }

    fn color(shade: i32) -> RGBColor {
        ViridisRGB::get_color(f64::from(shade) / f64::from(DECADES * SHADES - 1))
    }
}

impl Figure for SphereFigure {
    fn size(&self) -> [i32; 2] {
        [if self.below.is_some() { 980 } else { 580 }, 520]
    }

    fn draw<DB: DrawingBackend>(&self, page: &Area<DB>) -> Drawn<DB> {
        let title = format!(
            "BSDF of {}, viewer at θ = {}°, φ = {}°",
            self.name, self.theta_o, self.phi_o
        );
        let mut subtitle = "luminance of f; light from θ outward and φ around".to_owned();
        if self.delta {
            subtitle += "; single directions are left out";
        }
        let rest = titled(page, &title, &subtitle)?;
        let (discs, bar) = rest.split_horizontally(rest.dim_in_pixel().0 as i32 - px(110.0));
        let highest = self.below.iter().map(Hemisphere::highest);
        let highest = highest.fold(self.above.highest(), f64::max);
        let scale = Scale {
            top: highest.max(f64::MIN_POSITIVE).log10().ceil() as i32,
        };
        let mut hemispheres = vec![(&self.above, "light from above")];
        if let Some(below) = &self.below {
            hemispheres.push((below, "light from below"));
        }
        let areas = discs.split_evenly((1, hemispheres.len()));
        for ((hemisphere, name), area) in hemispheres.into_iter().zip(&areas) {
            let disc = disc(area);
            draw_cells(&disc, hemisphere, &scale)?;
            draw_grid(&disc)?;
            let (x, y) = (
                area.dim_in_pixel().0 as i32 / 2,
                area.dim_in_pixel().1 as i32,
            );
            write(
                area,
                name,
                (x, y - px(16.0)),
                Side::Middle,
                &letters(NORMAL, INK),
            )?;
        }
        self.draw_viewer(&disc(&areas[0]))?;
        draw_bar(&bar, &scale)
    }
}

/// Coordinates in degrees from the normal, x along the tangent.
fn disc<DB: DrawingBackend>(area: &Area<DB>) -> Plane<DB> {
    let (area, _) = area.split_vertically(area.dim_in_pixel().1 as i32 - px(30.0));
    plane(&area, -REACH..REACH, -REACH..REACH)
}

fn place(theta: f64, phi: f64) -> (f64, f64) {
    let (sin, cos) = phi.to_radians().sin_cos();
    (theta * cos, theta * sin)
}

/// From the rim inward, each ring of slices over the whole of the one before, so that no seams show.
fn draw_cells<DB: DrawingBackend>(
    disc: &Plane<DB>,
    values: &Hemisphere,
    scale: &Scale,
) -> Drawn<DB> {
    let step = 360.0 / AZIMUTHS as f64;
    for row in (0..ELEVATIONS).rev() {
        let rim = 90.0 * (row + 1) as f64 / ELEVATIONS as f64;
        let shades: Vec<i32> = values.values[row * AZIMUTHS..(row + 1) * AZIMUTHS]
            .iter()
            .map(|&value| scale.shade(value))
            .collect();
        let mut column = 0;
        while column < AZIMUTHS {
            let shade = shades[column];
            let run = shades[column..].iter().take_while(|s| **s == shade).count();
            // Half a cell more, below the next slice.
            let end = step * ((column + run) as f64 + 0.5);
            let mut slice: Vec<_> = (column..=column + run)
                .map(|edge| place(rim, step * edge as f64))
                .collect();
            if run < AZIMUTHS {
                slice.push(place(rim, end.min(360.0)));
                slice.push((0.0, 0.0));
            }
            disc.draw(&Polygon::new(slice, Scale::color(shade).filled()))?;
            column += run;
        }
    }
    Ok(())
}

fn draw_grid<DB: DrawingBackend>(disc: &Plane<DB>) -> Drawn<DB> {
    let area = disc.strip_coord_spec();
    for theta in [30.0, 60.0, 90.0] {
        let ring: Vec<_> = (0..=180)
            .map(|i| place(theta, 2.0 * f64::from(i)))
            .collect();
        let (color, width) = if theta < 90.0 {
            (WHITE, 0.6)
        } else {
            (INK, 1.2)
        };
        trace(disc, &ring, Stroke::solid(color).wide(width))?;
        if theta < 90.0 {
            let (x, y) = locate(disc, place(theta, 270.0));
            let name = format!("{theta}°");
            let style = letters(SMALL, WHITE);
            write(
                &area,
                &name,
                (x + px(3.0), y + px(8.0)),
                Side::Right,
                &style,
            )?;
        }
    }
    for phi in (0..360).step_by(45) {
        let phi = f64::from(phi);
        let edge = [place(90.0, phi), place(92.5, phi)];
        trace(disc, &edge, Stroke::solid(INK).wide(1.0))?;
        let style = letters(SMALL, INK);
        let name = format!("{phi}°");
        write(
            &area,
            &name,
            locate(disc, place(98.5, phi)),
            Side::Middle,
            &style,
        )?;
    }
    Ok(())
}

impl SphereFigure {
    /// A ring where the viewer is, a cross where a mirror would send light from.
    fn draw_viewer<DB: DrawingBackend>(&self, disc: &Plane<DB>) -> Drawn<DB> {
        let viewer = place(self.theta_o, self.phi_o);
        for (radius, color) in [(5.0, BLACK), (4.0, WHITE)] {
            disc.draw(&Circle::new(viewer, px(radius), color.filled()))?;
        }
        disc.draw(&Circle::new(viewer, px(2.0), BLACK.filled()))?;
        let (x, y) = place(self.theta_o, self.phi_o + 180.0);
        for (width, color) in [(3.2, BLACK), (1.6, WHITE)] {
            for (dx, dy) in [(2.0, 2.0), (2.0, -2.0)] {
                let arm = [(x - dx, y - dy), (x + dx, y + dy)];
                trace(disc, &arm, Stroke::solid(color).wide(width))?;
            }
        }
        Ok(())
    }
}

fn draw_bar<DB: DrawingBackend>(area: &Area<DB>, scale: &Scale) -> Drawn<DB> {
    let (left, right) = (px(14.0), px(32.0));
    let (top, bottom) = (px(34.0), px(394.0));
    let y = |shade: i32| bottom - (bottom - top) * shade / (DECADES * SHADES);
    write(
        area,
        "f (1/sr)",
        (left, px(16.0)),
        Side::Right,
        &letters(NORMAL, INK),
    )?;
    for shade in 0..DECADES * SHADES {
        // Up to the top, below the next.
        let strip = [(left, top), (right, y(shade))];
        area.draw(&Rectangle::new(strip, Scale::color(shade).filled()))?;
    }
    area.draw(&Rectangle::new(
        [(left, top), (right, bottom)],
        INK.stroke_width(px(0.8) as u32),
    ))?;
    for decade in 0..=DECADES {
        let y = y(decade * SHADES);
        let tick = [(right, y), (right + px(4.0), y)];
        area.draw(&PathElement::new(tick, INK.stroke_width(px(0.8) as u32)))?;
        let power = scale.top - DECADES + decade;
        let mut name = power_of_ten(power);
        if decade == 0 {
            name = format!("≤ {name}");
        }
        write(
            area,
            &name,
            (right + px(8.0), y),
            Side::Right,
            &letters(SMALL, INK),
        )?;
    }
    let note = letters(SMALL, GREY);
    let line = |i: f64| bottom + px(24.0 + 17.0 * i);
    write(area, "o  viewer", (left, line(0.0)), Side::Right, &note)?;
    write(area, "×  mirrored", (left, line(1.0)), Side::Right, &note)
}

/// 0.01, 0.1, 1, 10, 100 in full, beyond with an exponent.
fn power_of_ten(power: i32) -> String {
    if (-3..=3).contains(&power) {
        let decimals = (-power).max(0) as usize;
        return format!("{:.decimals$}", 10f64.powi(power));
    }
    format!("1e{power}")
}
