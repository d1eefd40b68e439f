//! Screenshots that another renderer made of the asset-generator models, and how a film is compared
//! with them: by what is covered, and by how colours are laid out. Their lighting is not known.

use snell::film::Film;
use snell::output::tonemap::srgb_encode;
use std::path::Path;

/// Pixels of the pictures compared; the screenshots have four times as many each way.
pub const SIZE: u32 = 100;
const SCALE: u32 = 4;
/// A pixel of a screenshot shows the model where a channel differs from the backdrop by more than
/// this of 255: the backdrop is the same in all of them.
const DIFFERENCE: u8 = 4;

/// Cells of a picture: how much is covered, and the colour in sRGB code values.
pub struct Cells {
    pub coverage: Vec<f64>,
    pub colors: Vec<[f64; 3]>,
}

impl Cells {
    /// A screenshot, of which everything that differs from the backdrop is the model.
    pub fn of_screenshot(path: &Path, backdrop: &Path) -> Cells {
        let [shot, backdrop] = [path, backdrop].map(|path| {
            let image = image::open(path).unwrap().to_rgb8();
            assert_eq!(image.dimensions(), (SIZE * SCALE, SIZE * SCALE));
            image
        });
        let mut cells = Cells {
            coverage: Vec::new(),
            colors: Vec::new(),
        };
        let area = f64::from(SCALE * SCALE);
        for y in 0..SIZE {
            for x in 0..SIZE {
                let mut covered = 0;
                let mut color = [0.0; 3];
                for (j, i) in (0..SCALE * SCALE).map(|k| (k / SCALE, k % SCALE)) {
                    let (x, y) = (x * SCALE + i, y * SCALE + j);
                    let (pixel, behind) = (shot[(x, y)], backdrop[(x, y)]);
                    let differs = |c: usize| pixel[c].abs_diff(behind[c]) > DIFFERENCE;
                    covered += u32::from((0..3).any(differs));
                    for (sum, code) in color.iter_mut().zip(pixel.0) {
                        *sum += f64::from(code) / 255.0 / area;
                    }
                }
                cells.coverage.push(f64::from(covered) / area);
                cells.colors.push(color);
            }
        }
        cells
    }

    /// A film with a transparent background.
    pub fn of_film(film: &Film) -> Cells {
        let coded = |radiance: f64| srgb_encode(radiance.clamp(0.0, 1.0));
        Cells {
            coverage: film.pixels.iter().map(|p| p.coverage()).collect(),
            colors: film.pixels.iter().map(|p| p.mean().map(coded)).collect(),
        }
    }

    pub fn covered(&self) -> f64 {
        self.coverage.iter().sum()
    }

    /// Intersection over union of what is covered, by area.
    pub fn overlap(&self, other: &Cells) -> f64 {
        let pairs = || self.coverage.iter().zip(&other.coverage);
        let common: f64 = pairs().map(|(a, b)| a.min(*b)).sum();
        let either: f64 = pairs().map(|(a, b)| a.max(*b)).sum();
        common / either
    }

    /// Pearson's correlation of the colours where both pictures are covered whole, with each
    /// channel's mean taken out: neither exposure nor the colour of the light counts.
    pub fn correlation(&self, other: &Cells) -> f64 {
        let inside: Vec<usize> = (0..self.colors.len())
            .filter(|&i| self.coverage[i] > 0.999 && other.coverage[i] > 0.999)
            .collect();
        let centred = |cells: &Cells| {
            let mut values = Vec::new();
            for channel in 0..3 {
                let of = |&i: &usize| cells.colors[i][channel];
                let mean = inside.iter().map(of).sum::<f64>() / inside.len() as f64;
                values.extend(inside.iter().map(|i| of(i) - mean));
            }
            values
        };
        let (a, b) = (centred(self), centred(other));
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        dot(&a, &b) / (dot(&a, &a) * dot(&b, &b)).sqrt()
    }
}
