//! The text of an LM-63 file, of its editions from 1986 to 2019.

/// Which way the goniometer turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Photometry {
    A,
    B,
    C,
}

/// What of a file a picture needs.
pub struct Lm63 {
    pub photometry: Photometry,
    /// The file says how the output changes with the tilt of the lamp, which is not applied.
    pub tilted: bool,
    /// Degrees, rising.
    vertical: Vec<f64>,
    horizontal: Vec<f64>,
    /// For each horizontal angle one for each vertical angle, all factors applied.
    candela: Vec<f64>,
}

/// The numbers after the TILT line, one after the other.
struct Numbers<'t>(Vec<&'t str>, usize);

impl Numbers<'_> {
    fn next(&mut self, what: &str) -> Result<f64, String> {
        let text = self
            .0
            .get(self.1)
            .ok_or_else(|| format!("the IES file ends before {what}"))?;
        self.1 += 1;
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(format!("{what} of the IES file is '{}'", cut(text))),
        }
    }

    /// A number of numbers that must be there: nothing is allocated for those that cannot.
    fn count(&mut self, what: &str) -> Result<usize, String> {
        let number = self.next(what)?;
        let left = self.0.len() - self.1;
        if number >= 1.0 && number.fract() == 0.0 && number <= left as f64 {
            Ok(number as usize)
        } else {
            Err(format!(
                "{what} of the IES file is {number}, and {left} numbers follow"
            ))
        }
    }

    fn take(&mut self, count: usize, what: &str) -> Result<Vec<f64>, String> {
        if count > self.0.len() - self.1 {
            return Err(format!("the IES file ends before {what}"));
        }
        (0..count).map(|_| self.next(what)).collect()
    }
}

fn cut(text: &str) -> String {
    text.chars().take(20).collect()
}

fn rising(angles: &[f64], what: &str) -> Result<(), String> {
    match angles.windows(2).find(|pair| pair[0] >= pair[1]) {
        Some(pair) => Err(format!(
            "{what} of the IES file do not rise: {} after {}",
            pair[1], pair[0]
        )),
        None => Ok(()),
    }
}

impl Lm63 {
    /// ANSI/IES LM-63-19 sections 5 and 6; the older editions differ in the first line and in what the
    /// number after the ballast factor means.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut rest = text.trim_start_matches('\u{feff}');
        let first = rest.lines().next().unwrap_or("").trim();
        let newer = first.contains("LM-63-2002") || first.contains("LM-63-2019");
        let tilt = loop {
            let (line, after) = rest.split_once('\n').unwrap_or((rest, ""));
            if let Some(tilt) = line.trim().strip_prefix("TILT=") {
                rest = after;
                break tilt.trim();
            }
            if after.is_empty() {
                return Err("the IES file has no line 'TILT='".into());
            }
            rest = after;
        };
        let separators = |c: char| c.is_ascii_whitespace() || c == ',';
        let numbers = rest.split(separators).filter(|text| !text.is_empty());
        let mut numbers = Numbers(numbers.collect(), 0);
        if tilt == "INCLUDE" {
            numbers.next("the lamp's position")?;
            let count = numbers.count("the number of tilts")?;
            numbers.take(2 * count, "the last tilt")?;
        }
        numbers.take(2, "the lumens of a lamp")?;
        let multiplier = numbers.next("the multiplier")?;
        let vertical = numbers.count("the number of vertical angles")?;
        let horizontal = numbers.count("the number of horizontal angles")?;
        let photometry = match numbers.next("the photometric type")? {
            1.0 => Photometry::C,
            2.0 => Photometry::B,
            3.0 => Photometry::A,
            other => {
                return Err(format!(
                    "the IES file's photometric type is {other}, not 1 to 3"
                ));
            }
        };
        numbers.take(4, "the luminaire's height")?;
        let ballast = numbers.next("the ballast factor")?;
        // Of the editions of 2002 and 2019 it tells of no factor.
        let lamp = numbers.next("the ballast-lamp factor")?;
        let factor = multiplier * ballast * if newer { 1.0 } else { lamp };
        numbers.next("the input watts")?;
        let count = vertical.saturating_mul(horizontal);
        let lamp = Self {
            photometry,
            tilted: tilt != "NONE",
            vertical: numbers.take(vertical, "the last vertical angle")?,
            horizontal: numbers.take(horizontal, "the last horizontal angle")?,
            candela: numbers.take(count, "the last candela value")?,
        };
        lamp.finish(factor)
    }

    fn finish(mut self, factor: f64) -> Result<Self, String> {
        rising(&self.vertical, "vertical angles")?;
        rising(&self.horizontal, "horizontal angles")?;
        for value in &mut self.candela {
            *value *= factor;
            if !(0.0..=f64::from(f32::MAX)).contains(value) {
                return Err(format!(
                    "an intensity of the IES file is {value} cd once its factors are applied"
                ));
            }
        }
        let [first, last] = ends(&self.horizontal);
        let [low, high] = ends(&self.vertical);
        let complete = match self.photometry {
            Photometry::C => {
                let around = [0.0, 90.0, 180.0, 360.0].contains(&last) && first == 0.0;
                (around || (first, last) == (90.0, 270.0)) && low >= 0.0 && high <= 180.0
            }
            _ => [&self.horizontal, &self.vertical].iter().all(|angles| {
                let [first, last] = ends(angles);
                (first == 0.0 || first == -last) && last <= 90.0
            }),
        };
        if complete {
            Ok(self)
        } else {
            Err(format!(
                "the IES file's angles of type {:?} are {first} to {last} and {low} to {high} degrees: \
                 they leave open what lies beyond",
                self.photometry
            ))
        }
    }

    /// Alike all around its axis.
    pub fn is_round(&self) -> bool {
        self.photometry == Photometry::C && self.horizontal.len() == 1
    }

    /// In a direction: `polar` radians from the node's -z, `azimuth` about its +z from +x towards +y.
    pub fn candela(&self, polar: f64, azimuth: f64) -> f64 {
        if self.photometry == Photometry::C {
            return self.at(polar.to_degrees(), self.folded(azimuth.to_degrees()));
        }
        // The pole of type A stands upright, so that the horizontal angle is a longitude; that of type
        // B lies across, and the vertical angle is one.
        let (up, right) = (polar.sin() * azimuth.cos(), -polar.sin() * azimuth.sin());
        let forward = polar.cos();
        let (vertical, horizontal) = match self.photometry {
            Photometry::A => (up.clamp(-1.0, 1.0).asin(), right.atan2(forward)),
            _ => (up.atan2(forward), right.clamp(-1.0, 1.0).asin()),
        };
        let fold = |angle: f64, angles: &[f64]| match angles[0] < 0.0 {
            true => angle.to_degrees(),
            false => angle.to_degrees().abs(),
        };
        let vertical = fold(vertical, &self.vertical);
        let horizontal = fold(horizontal, &self.horizontal);
        if horizontal < self.horizontal[0] || horizontal > ends(&self.horizontal)[1] {
            return 0.0;
        }
        self.at(vertical, horizontal)
    }

    /// A horizontal angle of type C, by the symmetry that the file's range stands for.
    fn folded(&self, degrees: f64) -> f64 {
        let degrees = degrees.rem_euclid(360.0);
        match ends(&self.horizontal) {
            [_, 90.0] => 90.0 - (degrees.rem_euclid(180.0) - 90.0).abs(),
            [_, 180.0] => 180.0 - (degrees - 180.0).abs(),
            [_, 270.0] => match degrees {
                ..90.0 => 180.0 - degrees,
                90.0..=270.0 => degrees,
                _ => 540.0 - degrees,
            },
            _ => degrees,
        }
    }

    /// Linear between the angles of the file; nothing beyond the vertical ones.
    fn at(&self, vertical: f64, horizontal: f64) -> f64 {
        // Half degrees come back from radians with their rounding.
        const ROUNDING: f64 = 1e-9;
        let [low, high] = ends(&self.vertical);
        if vertical < low - ROUNDING || vertical > high + ROUNDING {
            return 0.0;
        }
        let (v, v_share) = between(&self.vertical, vertical);
        let (h, h_share) = between(&self.horizontal, horizontal);
        let count = self.vertical.len();
        let column = |h: usize| {
            let column = &self.candela[h * count..(h + 1) * count];
            let next = column[(v + 1).min(count - 1)];
            column[v] + v_share * (next - column[v])
        };
        let next = column((h + 1).min(self.horizontal.len() - 1));
        column(h) + h_share * (next - column(h))
    }
}

fn ends(angles: &[f64]) -> [f64; 2] {
    [angles[0], angles[angles.len() - 1]]
}

/// The last angle that is not above, and the share of the way to the next.
fn between(angles: &[f64], angle: f64) -> (usize, f64) {
    let above = angles.partition_point(|&a| a <= angle);
    let index = above.saturating_sub(1);
    match angles.get(above) {
        Some(next) if above > 0 => {
            let share = (angle - angles[index]) / (next - angles[index]);
            (index, share)
        }
        _ => (index, 0.0),
    }
}
