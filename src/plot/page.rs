//! The paper that figures are drawn on: letters, colours, axes, legends; and how it becomes a file.
//!
//! `plotters` places everything on whole units, so units are made small: six to a CSS pixel. An SVG says
//! so in its `viewBox`; a PNG is drawn at two thirds of that size again, three units to a pixel, and
//! averaged, which makes its lines smooth.

use super::PlotError;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::register_font;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::ops::Range;

/// Units of drawing in a CSS pixel.
const UNITS: i32 = 6;
/// Units to a side of a PNG's pixel: two pixels to a CSS pixel.
const PIXEL: usize = 3;

/// The embedded font's family, and what stands in for it where an SVG is viewed without it.
const FAMILY: &str = "Noto Sans, DejaVu Sans, Helvetica, Arial, sans-serif";
/// Sizes of letters, CSS pixels.
pub const SMALL: f64 = 12.0;
pub const NORMAL: f64 = 13.5;
pub const TITLE: f64 = 17.0;

// Okabe and Ito 2008, "Color Universal Design": told apart by colour-blind readers.
pub const VERMILION: RGBColor = RGBColor(0xd5, 0x5e, 0x00);
pub const GREEN: RGBColor = RGBColor(0x00, 0x9e, 0x73);
pub const BLUE: RGBColor = RGBColor(0x00, 0x72, 0xb2);
pub const ORANGE: RGBColor = RGBColor(0xe6, 0x9f, 0x00);
pub const PURPLE: RGBColor = RGBColor(0xcc, 0x79, 0xa7);
pub const INK: RGBColor = RGBColor(0x20, 0x20, 0x20);
pub const GREY: RGBColor = RGBColor(0x6a, 0x6a, 0x6a);
pub const FAINT: RGBColor = RGBColor(0xdd, 0xdd, 0xdd);

pub type Area<DB> = DrawingArea<DB, Shift>;
pub type Drawn<DB> = DrawResult<(), DB>;
pub type Chart<'a, DB> = ChartContext<'a, DB, Cartesian2d<Ticked, Ticked>>;

/// Something that can be drawn on a page.
pub trait Figure {
    /// Width and height, CSS pixels.
    fn size(&self) -> [i32; 2];
    /// Draws on a white page of that size.
    fn draw<DB: DrawingBackend>(&self, page: &Area<DB>) -> Drawn<DB>;
}

/// The figure as a text file.
pub fn svg(figure: &impl Figure) -> Result<String, PlotError> {
    let size = figure.size();
    let [width, height] = in_units(size);
    let mut text = String::new();
    draw(figure, SVGBackend::with_string(&mut text, (width, height)))?;
    // The backend knows one size only, that of its units.
    let units = format!(r#"width="{width}" height="{height}""#);
    let pixels = format!(r#"width="{}" height="{}""#, size[0], size[1]);
    Ok(text.replacen(&units, &pixels, 1))
}

/// The figure as pixels, two to a CSS pixel.
pub fn png(figure: &impl Figure) -> Result<Vec<u8>, PlotError> {
    let [width, height] = in_units(figure.size());
    let mut fine = vec![0; 3 * width as usize * height as usize];
    draw(
        figure,
        BitMapBackend::with_buffer(&mut fine, (width, height)),
    )?;
    let (columns, rows) = (width as usize / PIXEL, height as usize / PIXEL);
    let mut pixels = Vec::with_capacity(3 * columns * rows);
    for y in 0..rows {
        for x in 0..columns {
            for channel in 0..3 {
                let sum: usize = (0..PIXEL * PIXEL)
                    .map(|i| (x * PIXEL + i % PIXEL) + (y * PIXEL + i / PIXEL) * width as usize)
                    .map(|i| usize::from(fine[3 * i + channel]))
                    .sum();
                pixels.push((sum / (PIXEL * PIXEL)) as u8);
            }
        }
    }
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive)
        .write_image(
            &pixels,
            columns as u32,
            rows as u32,
            ExtendedColorType::Rgb8,
        )
        .map_err(|error| PlotError::Draw(error.to_string()))?;
    Ok(bytes)
}

fn in_units(size: [i32; 2]) -> [u32; 2] {
    size.map(|side| (side * UNITS) as u32)
}

fn draw<DB: DrawingBackend>(figure: &impl Figure, backend: DB) -> Result<(), PlotError> {
    register_font(FAMILY, FontStyle::Normal, ttf_noto_sans::REGULAR)
        .map_err(|_| PlotError::Draw("the embedded font cannot be read".into()))?;
    let page = backend.into_drawing_area();
    page.fill(&WHITE)
        .and_then(|()| figure.draw(&page))
        .and_then(|()| page.present())
        .map_err(|error| PlotError::Draw(error.to_string()))
}

/// CSS pixels in units.
pub fn px(pixels: f64) -> i32 {
    (pixels * f64::from(UNITS)).round() as i32
}

/// Letters of this size, CSS pixels.
pub fn letters(size: f64, color: RGBColor) -> TextStyle<'static> {
    /// What `plotters` takes for the height of a line, in ems.
    const LINE: f64 = 1.24;
    let font = FontDesc::new(
        FontFamily::Name(FAMILY),
        size * LINE * f64::from(UNITS),
        FontStyle::Normal,
    );
    TextStyle {
        color: color.to_backend_color(),
        ..TextStyle::from(font)
    }
}

/// Which way a text lies from its place.
#[derive(Clone, Copy)]
pub enum Side {
    Left,
    Right,
    Middle,
}

/// Writes at `at`, units, on half the height of the letters.
pub fn write<DB: DrawingBackend>(
    area: &Area<DB>,
    text: &str,
    at: (i32, i32),
    side: Side,
    style: &TextStyle<'_>,
) -> Drawn<DB> {
    let horizontal = match side {
        Side::Left => HPos::Right,
        Side::Right => HPos::Left,
        Side::Middle => HPos::Center,
    };
    // The backends agree on no anchor but nearly on this one; from there down to the baseline of letters
    // whose middle is at `at`.
    let at = (at.0, at.1 + (0.53 * style.font.get_size()).round() as i32);
    area.draw(&Text::new(
        text,
        at,
        style.pos(Pos::new(horizontal, VPos::Bottom)),
    ))
}

/// With up to four decimals, none of them a trailing zero.
pub fn number(x: f64) -> String {
    let text = format!("{x:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Takes the page's head for a title and a line below it; leaves the rest.
pub fn titled<DB: DrawingBackend>(
    page: &Area<DB>,
    title: &str,
    subtitle: &str,
) -> DrawResult<Area<DB>, DB> {
    let (head, rest) = page.split_vertically(px(54.0));
    let middle = head.dim_in_pixel().0 as i32 / 2;
    let at = |y| (middle, px(y));
    write(&head, title, at(20.0), Side::Middle, &letters(TITLE, INK))?;
    write(
        &head,
        subtitle,
        at(43.0),
        Side::Middle,
        &letters(NORMAL, GREY),
    )?;
    Ok(rest)
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    pub color: RGBColor,
    /// CSS pixels.
    pub width: f64,
    pub dashed: bool,
}

impl Stroke {
    pub fn solid(color: RGBColor) -> Self {
        Self {
            color,
            width: 2.0,
            dashed: false,
        }
    }

    pub fn dashed(self) -> Self {
        Self {
            dashed: true,
            ..self
        }
    }

    pub fn wide(self, width: f64) -> Self {
        Self { width, ..self }
    }

    fn style(self) -> ShapeStyle {
        self.color.stroke_width(px(self.width) as u32)
    }
}

pub type Plane<DB> = DrawingArea<DB, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// An area with coordinates up and to the right, and as long units in x as in y: `x` is what is seen of
/// them at least, and the area's height shows `y`.
pub fn plane<DB: DrawingBackend>(area: &Area<DB>, x: Range<f64>, y: Range<f64>) -> Plane<DB> {
    let (across, down) = area.get_pixel_range();
    let unit = (f64::from(across.end - across.start) / (x.end - x.start))
        .min(f64::from(down.end - down.start) / (y.end - y.start));
    let widened = |range: Range<f64>, units: i32| {
        let extra = (f64::from(units) / unit - (range.end - range.start)) / 2.0;
        range.start - extra..range.end + extra
    };
    area.apply_coord_spec(Cartesian2d::<RangedCoordf64, RangedCoordf64>::new(
        widened(x, across.end - across.start),
        widened(y, down.end - down.start),
        (across, down.end..down.start),
    ))
}

/// Where a point of a plane or a chart is in its area, units.
pub fn locate<DB: DrawingBackend, CT: CoordTranslate<From = (f64, f64)>>(
    area: &DrawingArea<DB, CT>,
    point: (f64, f64),
) -> (i32, i32) {
    let (x, y) = area.map_coordinate(&point);
    let origin = area.get_base_pixel();
    (x - origin.0, y - origin.1)
}

/// A named line through data.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    pub name: String,
    pub points: Vec<(f64, f64)>,
    pub stroke: Stroke,
}

/// Draws through points of any coordinates.
pub fn trace<DB: DrawingBackend, CT: CoordTranslate<From = (f64, f64)>>(
    area: &DrawingArea<DB, CT>,
    points: &[(f64, f64)],
    stroke: Stroke,
) -> Drawn<DB> {
    let mut path: Vec<_> = points.iter().map(|&p| locate(area, p)).collect();
    path.dedup();
    line(&area.strip_coord_spec(), path, stroke)
}

/// Draws through points, units.
fn line<DB: DrawingBackend>(area: &Area<DB>, path: Vec<(i32, i32)>, stroke: Stroke) -> Drawn<DB> {
    if path.len() < 2 {
        return Ok(());
    }
    if stroke.dashed {
        let series = DashedLineSeries::new(path, px(6.0), px(4.0), stroke.style());
        return series.into_iter().try_for_each(|dashes| area.draw(&dashes));
    }
    area.draw(&PathElement::new(path, stroke.style()))
}

/// One of a chart's axes.
pub struct Axis<'a> {
    pub label: &'a str,
    pub range: Range<f64>,
    pub ticks: Vec<f64>,
    pub decimals: usize,
}

impl Axis<'_> {
    /// Degrees from 0 to 90.
    pub fn degrees(label: &str) -> Axis<'_> {
        Axis {
            label,
            range: 0.0..90.0,
            ticks: (0..=6).map(|i| 15.0 * f64::from(i)).collect(),
            decimals: 0,
        }
    }

    /// From `low` or the tenth or two below it, to 1 or the tenth above `high`.
    pub fn share(label: &str, low: f64, high: f64) -> Axis<'_> {
        let last = ((10.0 * high - 1e-6).ceil() as i32).max(10);
        let lowest = (10.0 * low).round() as i32;
        let step = if last - lowest > 5 { 2 } else { 1 };
        let first = lowest - lowest % step;
        Axis {
            label,
            range: f64::from(first) / 10.0..f64::from(last) / 10.0,
            ticks: (first..=last)
                .filter(|tick| tick % step == 0)
                .map(|tick| f64::from(tick) / 10.0)
                .collect(),
            decimals: 1,
        }
    }
}

/// Numbers with ticks at chosen places.
pub struct Ticked {
    numbers: RangedCoordf64,
    ticks: Vec<f64>,
}

impl Ranged for Ticked {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.numbers.map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        match hint.weight().allow_light_points() {
            true => Vec::new(),
            false => self.ticks.clone(),
        }
    }

    fn range(&self) -> Range<f64> {
        self.numbers.range()
    }
}

/// Axes with a faint grid; the area's right margin is kept for tick labels that stick out.
pub fn chart<'a, DB: DrawingBackend + 'a>(
    area: &Area<DB>,
    x: Axis<'_>,
    y: Axis<'_>,
) -> DrawResult<Chart<'a, DB>, DB> {
    let mut chart = ChartBuilder::on(area)
        .margin_top(px(10.0))
        .margin_right(px(18.0))
        .margin_left(px(8.0))
        .margin_bottom(px(6.0))
        .x_label_area_size(px(42.0))
        .y_label_area_size(px(52.0))
        .build_cartesian_2d(ticked(&x), ticked(&y))?;
    chart
        .configure_mesh()
        .bold_line_style(FAINT.stroke_width(px(0.8) as u32))
        .axis_style(INK.stroke_width(px(1.0) as u32))
        .set_all_tick_mark_size(px(4.0))
        .label_style(letters(SMALL, INK))
        // Plotters centres labels on their line with room for letters that go below it.
        .y_label_offset(px(1.8))
        .axis_desc_style(letters(NORMAL, INK))
        .x_desc(x.label)
        .y_desc(y.label)
        .x_label_formatter(&|value| format!("{value:.0$}", x.decimals))
        .y_label_formatter(&|value| format!("{value:.0$}", y.decimals))
        .draw()?;
    Ok(chart)
}

fn ticked(axis: &Axis<'_>) -> Ticked {
    Ticked {
        numbers: axis.range.clone().into(),
        ticks: axis.ticks.clone(),
    }
}

/// Samples of lines, one below the other, from `at`, units.
pub fn legend<DB: DrawingBackend>(
    area: &Area<DB>,
    at: (i32, i32),
    entries: &[(&str, Stroke)],
) -> Drawn<DB> {
    for (i, (name, stroke)) in entries.iter().enumerate() {
        let y = at.1 + px(21.0) * i as i32;
        let (from, to) = (at.0, at.0 + px(34.0));
        line(area, vec![(from, y), (to, y)], *stroke)?;
        write(
            area,
            name,
            (to + px(8.0), y),
            Side::Right,
            &letters(SMALL, INK),
        )?;
    }
    Ok(())
}

/// A dashed vertical line through a chart, named beside its upper end.
pub fn mark<DB: DrawingBackend>(
    chart: &Chart<'_, DB>,
    x: f64,
    (low, high): (f64, f64),
    name: &str,
    side: Side,
    name_at: f64,
) -> Drawn<DB> {
    let area = chart.plotting_area();
    let stroke = Stroke::solid(GREY).wide(1.2).dashed();
    trace(area, &[(x, low), (x, high)], stroke)?;
    let at = locate(area, (x, name_at));
    let gap = match side {
        Side::Left => -px(6.0),
        Side::Right => px(6.0),
        Side::Middle => 0,
    };
    write(
        &area.strip_coord_spec(),
        name,
        (at.0 + gap, at.1),
        side,
        &letters(SMALL, GREY),
    )
}
