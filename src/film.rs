//! What a renderer leaves behind: sums of samples per pixel, from which every output, the
//! error estimate and the image tests are made.

/// What the samples of one pixel come to, in 48 bytes: a picture of 8192 x 8192 has 67 million of them.
/// Radiance is linear Rec. 709; where nothing was hit in front of a transparent background a sample is
/// black with alpha 0, so colours are premultiplied.
///
/// The sums are those of `samples` independent samples of equal weight that would tell as much: a pixel's mean is
/// made of all that the filter reaches, and surer than its own samples alone would make it (`Weighted`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilmPixel {
    /// Sum of radiance.
    pub sum: [f64; 3],
    /// Sum of the squared deviations of radiance from its mean: unlike a sum of squares, it loses
    /// nothing to cancellation, so that float32 is enough.
    pub spread: [f32; 3],
    /// Sum of coverage, each sample's in [0, 1]; exact to 2^24 samples of all or nothing.
    pub alpha: f32,
    /// Samples in the sums.
    pub samples: u32,
    /// Samples that came out infinite or not a number: left out of the sums, counted here, reported.
    pub non_finite: u32,
}

impl FilmPixel {
    /// Adds one sample; one that is not finite is counted and otherwise left out.
    pub fn add(&mut self, radiance: [f64; 3], alpha: f64) {
        // Welford 1962, "Note on a Method for Calculating Corrected Sums of Squares and Products".
        if !(radiance.iter().all(|x| x.is_finite()) && alpha.is_finite()) {
            self.non_finite += 1;
            return;
        }
        let before = f64::from(self.samples.max(1));
        self.samples += 1;
        let now = f64::from(self.samples);
        for (c, x) in radiance.into_iter().enumerate() {
            let from_old_mean = x - self.sum[c] / before;
            self.sum[c] += x;
            if self.samples > 1 {
                self.spread[c] += (from_old_mean * (x - self.sum[c] / now)) as f32;
            }
        }
        self.alpha += alpha as f32;
    }

    /// Estimated radiance; NaN without a finite sample.
    pub fn mean(&self) -> [f64; 3] {
        self.sum.map(|s| s / f64::from(self.samples))
    }

    /// Mean of the squared radiance; NaN without a finite sample.
    pub fn mean_square(&self) -> [f64; 3] {
        let mean = self.mean();
        std::array::from_fn(|c| {
            mean[c] * mean[c] + f64::from(self.spread[c]) / f64::from(self.samples)
        })
    }

    /// Estimated coverage in [0, 1]; NaN without a finite sample.
    pub fn coverage(&self) -> f64 {
        f64::from(self.alpha) / f64::from(self.samples)
    }

    /// Unbiased estimate of the variance of one sample; NaN below two samples.
    pub fn sample_variance(&self) -> [f64; 3] {
        if self.samples < 2 {
            return [f64::NAN; 3];
        }
        self.spread
            .map(|s| f64::from(s) / (f64::from(self.samples) - 1.0))
    }

    /// Estimated variance of `mean`, as if the samples were independent: the sampler's points are
    /// stratified, which makes the true variance smaller on smooth integrands.
    pub fn variance(&self) -> [f64; 3] {
        self.sample_variance().map(|v| v / f64::from(self.samples))
    }
}

/// Sums of samples with weights, as the pixel filter gives them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Weighted {
    pub weight: f64,
    pub weight_squares: f64,
    /// Weighted radiance.
    pub sum: [f64; 3],
    /// Weighted square of radiance.
    pub squares: [f64; 3],
    /// Weighted alpha.
    pub alpha: f64,
    /// Samples that are left out, as in `FilmPixel`.
    pub non_finite: u32,
}

impl Weighted {
    /// Adds one finite sample, whose weight is above 0.
    pub fn add(&mut self, weight: f64, radiance: [f64; 3], alpha: f64) {
        self.weight += weight;
        self.weight_squares += weight * weight;
        for (c, x) in radiance.into_iter().enumerate() {
            self.sum[c] += weight * x;
            self.squares[c] += weight * x * x;
        }
        self.alpha += weight * alpha;
    }

    /// As sums of `samples` independent samples with the same mean and the same error of it. As many samples of equal
    /// weight as tell what these do are weight² / weight_squares (Kish 1965, "Survey Sampling", section 11.7).
    pub fn pixel(&self, samples: u32) -> FilmPixel {
        if samples == 0 {
            // Whatever the neighbours brought: the pixel counts as empty, as `FilmPixel` says.
            return FilmPixel {
                non_finite: self.non_finite,
                ..FilmPixel::default()
            };
        }
        let n = f64::from(samples);
        let count = self.weight * self.weight / self.weight_squares;
        let spread = |c: usize| {
            let mean = self.sum[c] / self.weight;
            // Rounding can leave a tiny negative number where all samples are equal.
            let variance = (self.squares[c] / self.weight - mean * mean).max(0.0);
            // So that `FilmPixel::variance` is the mean's, variance / (count - 1).
            (variance * n * (n - 1.0) / (count - 1.0)) as f32
        };
        FilmPixel {
            sum: self.sum.map(|sum| n * sum / self.weight),
            spread: match samples < 2 {
                true => [0.0; 3],
                false => [spread(0), spread(1), spread(2)],
            },
            alpha: (n * self.alpha / self.weight) as f32,
            samples,
            non_finite: self.non_finite,
        }
    }
}

/// Pixels by rows, row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    pub width: u32,
    pub height: u32,
    pub pixels: Vec<FilmPixel>,
}

/// How far a picture is from converged, from its own samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmError {
    /// Standard error over radiance, averaged over channels and pixels; see `Film::error`.
    pub relative: f64,
    /// 95 % confidence interval of `relative`.
    pub confidence: [f64; 2],
}

impl Film {
    pub fn new(width: u32, height: u32) -> Film {
        Film {
            width,
            height,
            pixels: vec![FilmPixel::default(); width as usize * height as usize],
        }
    }

    /// The pixel in column `x` and row `y`.
    ///
    /// # Panics
    /// Outside of the film.
    pub fn pixel(&self, x: u32, y: u32) -> &FilmPixel {
        &self.pixels[y as usize * self.width as usize + x as usize]
    }

    /// As `pixel`, to write to.
    pub fn pixel_mut(&mut self, x: u32, y: u32) -> &mut FilmPixel {
        &mut self.pixels[y as usize * self.width as usize + x as usize]
    }

    /// Samples that were infinite or not a number, of the whole picture.
    pub fn non_finite(&self) -> u64 {
        self.pixels.iter().map(|p| u64::from(p.non_finite)).sum()
    }

    /// Samples in the sums, of the whole picture.
    pub fn samples(&self) -> u64 {
        self.pixels.iter().map(|p| u64::from(p.samples)).sum()
    }

    /// True where no finite sample brought any radiance.
    pub fn is_black(&self) -> bool {
        self.pixels.iter().all(|p| p.sum == [0.0; 3])
    }

    /// Radiance averaged over pixels and channels, pixels without a finite sample left out.
    pub fn average(&self) -> f64 {
        let (sum, count) = self
            .pixels
            .iter()
            .filter(|p| p.samples > 0)
            .fold((0.0, 0u64), |(sum, count), p| {
                (sum + p.mean().iter().sum::<f64>() / 3.0, count + 1)
            });
        if count == 0 { 0.0 } else { sum / count as f64 }
    }

    /// The relative standard error of a pixel, averaged over the picture. Each pixel's error is taken
    /// relative to its own radiance plus 1 % of the picture's average, lest dark pixels rule. The
    /// interval is that of the average over pixels; pixels differ in more than chance, so it is wider
    /// than need be. `None` where no pixel has two samples.
    pub fn error(&self) -> Option<FilmError> {
        /// The share of the picture's average radiance below which a pixel counts as dark.
        const DARK: f64 = 0.01;
        /// Two-sided 95 % quantile of the normal distribution.
        const Z_95: f64 = 1.959_963_984_540_054;
        let floor = DARK * self.average();
        // Made twice rather than kept: half a gigabyte of a large picture.
        let errors = || {
            let several = self.pixels.iter().filter(|p| p.samples >= 2);
            several.map(|p| {
                let error: f64 = p.variance().iter().map(|v| v.sqrt()).sum();
                // Colours of single wavelengths may lie outside of Rec. 709, and be negative.
                let level = p.mean().iter().map(|mean| mean.abs()).sum::<f64>() + 3.0 * floor;
                if error == 0.0 { 0.0 } else { error / level }
            })
        };
        let n = errors().count() as f64;
        if n == 0.0 {
            return None;
        }
        let relative = errors().sum::<f64>() / n;
        let spread = errors().map(|e| (e - relative).powi(2)).sum::<f64>() / n;
        let half = Z_95 * (spread / n).sqrt();
        Some(FilmError {
            relative,
            confidence: [(relative - half).max(0.0), relative + half],
        })
    }
}
