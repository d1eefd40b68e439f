//! What arguments look like: parsers whose messages clap shows beside the argument.

use std::ops::Range;

use super::sequence::Frames;
use crate::gltf::EnvironmentSource;
use crate::scene::sky::Sky;

/// `WxH` in pixels.
pub fn size(text: &str) -> Result<[u32; 2], String> {
    let (width, height) = text
        .split_once(['x', 'X'])
        .ok_or("give width and height as WxH, such as 1024x768")?;
    let side = |text: &str| match text.parse() {
        Ok(side @ 1..=LARGEST_SIDE) => Ok(side),
        _ => Err(format!(
            "each side is a whole number from 1 to {LARGEST_SIDE}"
        )),
    };
    Ok([side(width)?, side(height)?])
}

/// Coordinates up to here are exact as float32 with their fraction of a pixel.
const LARGEST_SIDE: u32 = 65536;

/// `X,Y,W,H` in pixels.
pub fn crop(text: &str) -> Result<[u32; 4], String> {
    let crop = numbers::<u32, 4>(text, "give the window as X,Y,W,H in pixels")?;
    if crop[2] == 0 || crop[3] == 0 {
        return Err("the window is at least one pixel wide and high".into());
    }
    Ok(crop)
}

/// `A..B`, the end not included.
pub fn samples(text: &str) -> Result<Range<u32>, String> {
    const FORM: &str = "give the samples as A..B with A < B; B is not included";
    let (start, end) = text.split_once("..").ok_or(FORM)?;
    match (start.parse(), end.parse()) {
        (Ok(start), Ok(end)) if start < end => Ok(start..end),
        _ => Err(FORM.into()),
    }
}

/// `A..B@FPS`, the end not included; FPS is a number or a fraction `N/D`.
pub fn frames(text: &str) -> Result<Frames, String> {
    const FORM: &str = "give the frames as A..B@FPS with A < B; B is not included";
    /// So many names are made and checked before the first picture.
    const MOST: u32 = 1_000_000;
    let (numbers, rate) = text.split_once('@').ok_or(FORM)?;
    let numbers = samples(numbers).map_err(|_| FORM)?;
    if numbers.end - numbers.start > MOST {
        return Err(format!("a sequence has {MOST} frames at most"));
    }
    let (over, under) = rate.split_once('/').unwrap_or((rate, "1"));
    let part = |text| positive(text).map_err(|_| "FPS is greater than 0, such as 25 or 30000/1001");
    Ok(Frames {
        numbers,
        rate: [part(over)?, part(under)?],
    })
}

/// A camera on a sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// Degrees about +y from +z.
    pub theta: f64,
    /// Degrees down from +y.
    pub phi: f64,
    /// Metres.
    pub radius: f64,
    /// What it looks at; `None`: the scene's centre.
    pub target: Option<[f64; 3]>,
}

/// `THETA,PHI,RADIUS` or `THETA,PHI,RADIUS,X,Y,Z`: degrees, degrees, metres.
pub fn orbit(text: &str) -> Result<Orbit, String> {
    const FORM: &str =
        "give THETA,PHI,RADIUS or THETA,PHI,RADIUS,X,Y,Z in degrees, degrees, metres";
    let ([theta, phi, radius], target) = match numbers::<f64, 6>(text, FORM) {
        Ok([theta, phi, radius, x, y, z]) => ([theta, phi, radius], Some([x, y, z])),
        Err(_) => (numbers::<f64, 3>(text, FORM)?, None),
    };
    let all = [theta, phi, radius]
        .into_iter()
        .chain(target.into_iter().flatten());
    if all.clone().all(f64::is_finite) && radius > 0.0 {
        Ok(Orbit {
            theta,
            phi,
            radius,
            target,
        })
    } else {
        Err("angles and the target are finite and the radius is more than 0 metres".into())
    }
}

/// A finite number.
pub fn finite(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err("give a finite number".into()),
    }
}

/// A finite number that is not negative.
pub fn not_negative(text: &str) -> Result<f64, String> {
    finite(text).and_then(|x| {
        if x >= 0.0 {
            Ok(x)
        } else {
            Err("give a number that is not negative".into())
        }
    })
}

/// Within float32's range too.
pub fn positive(text: &str) -> Result<f64, String> {
    finite(text).and_then(|x| {
        if (f64::from(f32::MIN_POSITIVE)..=f64::from(f32::MAX)).contains(&x) {
            Ok(x)
        } else {
            Err("give a number greater than 0".into())
        }
    })
}

/// Bytes, with K, M, G or T for powers of 1024 (also as KB, KiB and so on).
pub fn bytes(text: &str) -> Result<u64, String> {
    const FORM: &str = "give bytes as a whole number, with K, M, G or T for powers of 1024";
    let digits = text.trim_end_matches(|c: char| !c.is_ascii_digit());
    let unit = text[digits.len()..].to_ascii_lowercase();
    let shift = match unit.trim_end_matches('b').trim_end_matches('i') {
        "" => 0,
        "k" => 10,
        "m" => 20,
        "g" => 30,
        "t" => 40,
        _ => return Err(FORM.into()),
    };
    let number: u64 = digits.parse().map_err(|_| FORM)?;
    number
        .checked_mul(1 << shift)
        .ok_or_else(|| "that is more than can be counted".into())
}

/// What camera rays see that leave the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Background {
    Environment,
    Transparent,
    /// Linear Rec. 709.
    Color([f32; 3]),
}

/// `env`, `transparent`, `#rrggbb` (sRGB) or `r,g,b` (linear).
pub fn background(text: &str) -> Result<Background, String> {
    const FORM: &str = "give 'env', 'transparent', '#rrggbb' (sRGB) or 'r,g,b' (linear, from 0)";
    match text {
        "env" => return Ok(Background::Environment),
        "transparent" => return Ok(Background::Transparent),
        _ => {}
    }
    match color(text) {
        Some(Ok(color)) => Ok(Background::Color(color)),
        _ => Err(FORM.into()),
    }
}

/// `#rrggbb` (sRGB) or `r,g,b` (linear): `None` for a text of neither form, an error for numbers that
/// are no colour.
fn color(text: &str) -> Option<Result<[f32; 3], ()>> {
    if let Some(hex) = text.strip_prefix('#') {
        if hex.len() != 6 || !hex.bytes().all(|digit| digit.is_ascii_hexdigit()) {
            return Some(Err(()));
        }
        let code = u32::from_str_radix(hex, 16).ok()?;
        let channel = |shift: u32| f64::from(code >> shift & 0xff) / 255.0;
        let decode = |x: f64| crate::output::tonemap::srgb_decode(x) as f32;
        return Some(Ok([16, 8, 0].map(channel).map(decode)));
    }
    let color = numbers::<f32, 3>(text, "").ok()?;
    let valid = color.iter().all(|x| x.is_finite() && *x >= 0.0);
    Some(if valid { Ok(color) } else { Err(()) })
}

/// A file, a colour as `background` takes it, or `sky` with its keys.
pub fn environment(text: &str) -> Result<EnvironmentSource, String> {
    if let Some(rest) = text.strip_prefix("sky") {
        match rest.strip_prefix(':') {
            Some(keys) => return sky(keys).map(EnvironmentSource::Sky),
            None if rest.is_empty() => return Ok(EnvironmentSource::Sky(Sky::default())),
            None => {}
        }
    }
    match color(text) {
        Some(Ok(color)) => Ok(EnvironmentSource::Constant(color)),
        Some(Err(())) => Err(
            "a colour is '#rrggbb' (sRGB) or 'r,g,b' (linear, finite, from 0); write a file of \
             such a name as ./NAME"
                .into(),
        ),
        None => Ok(EnvironmentSource::File(text.into())),
    }
}

/// `key=value,...`; what is not given is `Sky::default`'s.
fn sky(keys: &str) -> Result<Sky, String> {
    const FORM: &str = "give the sky as 'sky' or 'sky:key=value,...' with the keys elevation, azimuth, \
                        turbidity, albedo, sun";
    let mut sky = Sky::default();
    let mut given = Vec::new();
    for pair in keys.split(',') {
        let (key, value) = pair.split_once('=').ok_or(FORM)?;
        let key = key.trim();
        if given.contains(&key) {
            return Err(format!("'{key}' is given twice"));
        }
        given.push(key);
        let within = |low: f64, high: f64| match value.trim().parse::<f64>() {
            Ok(x) if (low..=high).contains(&x) => Ok(x),
            _ => Err(format!("the sky's {key} is a number from {low} to {high}")),
        };
        match key {
            "elevation" => sky.elevation = within(0.0, 90.0)?,
            "azimuth" => sky.azimuth = within(-360.0, 360.0)?,
            "turbidity" => sky.turbidity = within(1.0, 10.0)?,
            "albedo" => sky.albedo = within(0.0, 1.0)?,
            "sun" => {
                sky.sun = match value.trim() {
                    "0" => false,
                    "1" => true,
                    _ => return Err("the sky's sun is 0 or 1".into()),
                }
            }
            _ => return Err(FORM.into()),
        }
    }
    Ok(sky)
}

/// An arbitrary output variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aov {
    Variance,
    Samples,
}

pub fn aov(text: &str) -> Result<Aov, String> {
    match text {
        "variance" => Ok(Aov::Variance),
        "samples" => Ok(Aov::Samples),
        "albedo" | "normal" | "depth" | "position" | "uv" | "object-id" | "material-id" => {
            Err("not available yet; there are 'variance' and 'samples'".into())
        }
        _ => Err("there are 'variance' and 'samples'".into()),
    }
}

fn numbers<T: std::str::FromStr, const N: usize>(text: &str, form: &str) -> Result<[T; N], String> {
    let numbers: Result<Vec<T>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    numbers
        .ok()
        .and_then(|n| n.try_into().ok())
        .ok_or_else(|| form.to_owned())
}
