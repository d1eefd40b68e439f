//! Sun and sky, computed: an environment map of a clear to hazy day.

mod sun;

pub use sun::{SUN_RADIUS, sun_radiance};

use super::Environment;
use glam::DVec3;
use hw_skymodel::rgb::{SkyParams, SkyState};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Where the sun stands, and through what air and above what ground it shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sky {
    /// Degrees above the horizon, 0 to 90.
    pub elevation: f64,
    /// Degrees about +y from +z, counter-clockwise seen from above, as `--env-rotation` turns.
    pub azimuth: f64,
    /// Haze: the extinction of all air over that of its molecules, 1 to 10.
    pub turbidity: f64,
    /// Of the ground, 0 to 1.
    pub albedo: f64,
    /// Whether the sun's disc is there; without it the sky alone gives light.
    pub sun: bool,
}

impl Default for Sky {
    /// An ordinary clear day, the sun in front and to the right.
    fn default() -> Self {
        Self {
            elevation: 30.0,
            azimuth: 45.0,
            turbidity: 3.0,
            albedo: 0.2,
            sun: true,
        }
    }
}

/// A texel is 0.18 degrees wide, a third of the sun.
const WIDTH: usize = 2048;
const HEIGHT: usize = 1024;

/// Radiance of a map per radiance of the models, W / (m^2 sr) weighted by CIE 1931's observer. A white
/// diffuse floor under the default sky has a luminance of 1. A radiance of 1 is
/// 15.4 kcd/m^2.
pub const SCALE: f64 = 0.044_468;

/// Hosek and Wilkie 2012, "An Analytic Model for Full Spectral Sky-Dome Radiance", of one channel.
struct Channel {
    /// A to I of their equation 8, I and H swapped as in their data.
    distribution: [f64; 9],
    mean: f64,
}

impl Channel {
    /// What of equation 8 depends on the polar angle alone: the factor, and the zenith's term.
    fn row(&self, cos_theta: f64) -> [f64; 2] {
        let [a, b, .., i, _] = self.distribution;
        [
            self.mean * (1.0 + a * (b / (cos_theta + 0.01)).exp()),
            i * cos_theta.sqrt(),
        ]
    }

    /// Radiance at an angle from the sun.
    fn radiance(&self, [factor, zenith]: [f64; 2], gamma: f64, cos_gamma: f64) -> f64 {
        let [_, _, c, d, e, f, g, _, h] = self.distribution;
        let x = 1.0 + h * h - 2.0 * h * cos_gamma;
        let aureole = (1.0 + cos_gamma * cos_gamma) / (x * x.sqrt());
        let sum = c + d * (e * gamma).exp() + f * cos_gamma * cos_gamma + g * aureole + zenith;
        // The fit goes a little below nothing in the darkest places.
        (factor * sum).max(0.0)
    }
}

/// The channels of linear Rec. 709, by the model's own data.
fn channels(sky: &Sky) -> [Channel; 3] {
    let state = SkyState::new(&SkyParams {
        elevation: sky.elevation.to_radians().clamp(0.0, FRAC_PI_2) as f32,
        turbidity: sky.turbidity as f32,
        albedo: [sky.albedo as f32; 3],
    })
    .expect("a sky's parameters are checked where they are read");
    let (distributions, means) = state.raw();
    [0, 1, 2].map(|channel| Channel {
        distribution: std::array::from_fn(|i| f64::from(distributions[9 * channel + i])),
        mean: f64::from(means[channel]),
    })
}

/// Fills one row of texels above the horizon, whose halves mirror each other, and returns its mean in
/// the models' units.
fn draw_row(channels: &[Channel; 3], elevation: f64, y: usize, texels: &mut [[f32; 3]]) -> DVec3 {
    let theta = (y as f64 + 0.5) * PI / HEIGHT as f64;
    let (sin_theta, cos_theta) = theta.sin_cos();
    let (sin_elevation, cos_elevation) = elevation.sin_cos();
    let rows = channels.each_ref().map(|channel| channel.row(cos_theta));
    let (before, after) = texels.split_at_mut(WIDTH / 2);
    let mut sum = DVec3::ZERO;
    for (x, (left, right)) in before.iter_mut().rev().zip(after).enumerate() {
        let phi = (x as f64 + 0.5) * TAU / WIDTH as f64;
        let cos_gamma = sin_theta * cos_elevation * phi.cos() + cos_theta * sin_elevation;
        let cos_gamma = cos_gamma.clamp(-1.0, 1.0);
        let gamma = cos_gamma.acos();
        let radiance = |c: usize| channels[c].radiance(rows[c], gamma, cos_gamma);
        let radiance = DVec3::new(radiance(0), radiance(1), radiance(2));
        sum += radiance;
        *left = (radiance * SCALE).as_vec3().to_array();
        *right = *left;
    }
    sum / (WIDTH / 2) as f64
}

/// The unit vector at an elevation, `phi` about +y from +x towards +z, radians.
fn direction(elevation: f64, phi: f64) -> DVec3 {
    let (sin, cos) = elevation.sin_cos();
    DVec3::new(cos * phi.cos(), sin, cos * phi.sin())
}

impl Sky {
    /// Width and height of the map.
    pub const SIZE: (u32, u32) = (WIDTH as u32, HEIGHT as u32);

    /// The map. The sun stands over +x in it, in the middle; the map's rotation
    /// brings it to its azimuth.
    pub fn environment(&self) -> Environment {
        let elevation = self.elevation.to_radians();
        let channels = channels(self);
        let mut radiance = vec![[0.0; 3]; WIDTH * HEIGHT];
        let (above, below) = radiance.split_at_mut(WIDTH * HEIGHT / 2);
        let rows = above.par_chunks_exact_mut(WIDTH).enumerate();
        let means: Vec<DVec3> = rows
            .map(|(y, texels)| draw_row(&channels, elevation, y, texels))
            .collect();
        let mut irradiance = horizontal_irradiance(&means);
        if self.sun {
            let sun = sun_radiance(elevation, self.turbidity);
            irradiance += sun * sun::irradiance_over_radiance(elevation) * elevation.sin();
            sun::draw(above, elevation, sun * SCALE);
        }
        below.fill(
            (irradiance * (self.albedo / PI) * SCALE)
                .as_vec3()
                .to_array(),
        );
        Environment {
            width: Self::SIZE.0,
            height: Self::SIZE.1,
            radiance,
            strength: 1.0,
            rotation: (self.azimuth - 90.0).to_radians() as f32,
        }
    }
}

/// What a sky sends on level ground, from the means of its rows.
fn horizontal_irradiance(means: &[DVec3]) -> DVec3 {
    let step = PI / HEIGHT as f64;
    let rows = means.iter().enumerate().map(|(y, mean)| {
        let (top, bottom) = (y as f64 * step, (y + 1) as f64 * step);
        // Integral of cos(theta) sin(theta) over the row, all around.
        let weight = PI * (bottom.sin().powi(2) - top.sin().powi(2));
        mean * weight
    });
    rows.sum()
}
