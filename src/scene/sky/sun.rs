//! The sun's disc: how bright it is through the air, and its place in a map.

use super::{HEIGHT, WIDTH, direction};
use crate::spectrum;
use glam::{DMat3, DVec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Half of the sun's angular diameter of 0.533 degrees, radians.
pub const SUN_RADIUS: f64 = 0.5 * 0.533 * PI / 180.0;

/// Every 10 nm from 380 nm on: the sun's mean radiance above the air in 100 W / (m^2 nm sr), and the
/// absorption of ozone per centimetre. Preetham, Shirley and Smits 1999, "A Practical Analytic Model
/// for Daylight", table 2 (after Iqbal 1983). The bands of water and oxygen beyond 690 nm, which hold less
/// than 0.5 % of what an eye makes of the sun, are left out.
const SPECTRUM: [(f64, f64); 38] = [
    (165.5, 0.0),
    (162.3, 0.0),
    (211.2, 0.0),
    (258.8, 0.0),
    (258.2, 0.0),
    (242.3, 0.0),
    (267.6, 0.0),
    (296.6, 0.003),
    (305.4, 0.006),
    (300.6, 0.009),
    (306.6, 0.014),
    (288.3, 0.021),
    (287.1, 0.03),
    (278.2, 0.04),
    (271.0, 0.048),
    (272.3, 0.063),
    (263.6, 0.075),
    (255.0, 0.085),
    (250.6, 0.103),
    (253.1, 0.12),
    (253.5, 0.12),
    (251.3, 0.115),
    (246.3, 0.125),
    (241.7, 0.12),
    (236.8, 0.105),
    (232.1, 0.09),
    (228.2, 0.079),
    (223.4, 0.067),
    (219.7, 0.057),
    (215.3, 0.048),
    (211.0, 0.036),
    (207.3, 0.028),
    (202.4, 0.023),
    (198.7, 0.018),
    (194.3, 0.014),
    (190.7, 0.011),
    (186.3, 0.01),
    (182.6, 0.009),
];

/// Nanometres: where the table begins, and its step.
const FIRST: f64 = 380.0;
const STEP: f64 = 10.0;

/// From CIE XYZ to linear Rec. 709, white D65 (ITU-R BT.709), by columns: the space of the sky's data.
const RGB_FROM_XYZ: DMat3 = DMat3::from_cols_array(&[
    3.240_454_2,
    -0.969_266_0,
    0.055_643_4,
    -1.537_138_5,
    1.876_010_8,
    -0.204_025_9,
    -0.498_531_4,
    0.041_556_0,
    1.057_225_2,
]);

/// The disc's radiance, the same all over it: linear Rec. 709, W / (m^2 sr) weighted by the observer.
/// `elevation` in radians. What a deep red sun has outside of Rec. 709 is cut off.
pub fn sun_radiance(elevation: f64, turbidity: f64) -> DVec3 {
    // Preetham, Shirley and Smits 1999, appendix A.1: the sun's spectrum through molecules (Rayleigh),
    // aerosol (Angstrom) and ozone.
    const OZONE: f64 = 0.35; // cm
    const ANGSTROM_EXPONENT: f64 = 1.3;
    let zenith_angle = FRAC_PI_2 - elevation;
    // Kasten's relative optical mass, its angles in degrees.
    let mass =
        1.0 / (zenith_angle.cos() + 0.15 * (93.885 - zenith_angle.to_degrees()).powf(-1.253));
    let angstrom = 0.046_083_658_220_50 * turbidity - 0.045_860_259_285_22;
    let terms = SPECTRUM.iter().enumerate().map(|(i, &(radiance, ozone))| {
        let wavelength = FIRST + STEP * i as f64;
        let micrometres = wavelength / 1000.0;
        let rayleigh = 0.008735 * micrometres.powf(-4.08);
        let aerosol = angstrom * micrometres.powf(-ANGSTROM_EXPONENT);
        let transmitted = (-mass * (rayleigh + aerosol + ozone * OZONE)).exp();
        100.0 * radiance * transmitted * STEP * spectrum::xyz(wavelength)
    });
    (RGB_FROM_XYZ * terms.sum::<DVec3>()).max(DVec3::ZERO)
}

/// How much of the disc stands above the horizon: the segment of a circle.
fn visible_part(elevation: f64) -> f64 {
    let height = (elevation / SUN_RADIUS).clamp(-1.0, 1.0);
    1.0 - (height.acos() - height * (1.0 - height * height).sqrt()) / PI
}

/// Irradiance on a surface that faces the sun, per radiance of the disc.
pub fn irradiance_over_radiance(elevation: f64) -> f64 {
    PI * SUN_RADIUS.sin().powi(2) * visible_part(elevation)
}

/// Adds the disc to the rows of texels above the horizon. Texels get the part of them that it covers, scaled so
/// that the map, filtered bilinearly as it is looked up, sends the irradiance of the disc.
pub fn draw(texels: &mut [[f32; 3]], elevation: f64, radiance: DVec3) {
    let to_sun = direction(elevation, 0.0);
    let step = PI / HEIGHT as f64;
    let reach = (SUN_RADIUS + step).cos();
    let centre = (FRAC_PI_2 - elevation) / step;
    let margin = SUN_RADIUS / step + 1.0;
    let first = (centre - margin).max(0.0) as usize;
    let last = ((centre + margin) as usize).min(HEIGHT / 2 - 1);
    let mut covered = Vec::new();
    let mut total = 0.0;
    for y in first..=last {
        for x in 0..WIDTH {
            let (_, centre) = texel_point(x, y, 0.5, 0.5);
            if centre.dot(to_sun) < reach {
                continue;
            }
            let part = coverage(x, y, to_sun);
            if part > 0.0 {
                covered.push((x, y, part));
                total += part * solid_angle(y);
            }
        }
    }
    let scale = irradiance_over_radiance(elevation) / total;
    for (x, y, part) in covered {
        let texel = &mut texels[y * WIDTH + x];
        let sum = DVec3::from(texel.map(f64::from)) + radiance * (part * scale);
        *texel = sum.as_vec3().to_array();
    }
}

/// The polar angle and the direction of a point of a texel, (u, v) in [0, 1]^2 from its upper left.
fn texel_point(x: usize, y: usize, u: f64, v: f64) -> (f64, DVec3) {
    let theta = (y as f64 + v) * PI / HEIGHT as f64;
    let phi = ((x as f64 + u) / WIDTH as f64 - 0.5) * TAU;
    (theta, direction(FRAC_PI_2 - theta, phi))
}

/// The part of a texel that the disc covers, above the horizon.
fn coverage(x: usize, y: usize, to_sun: DVec3) -> f64 {
    const POINTS: usize = 16;
    let cos_radius = SUN_RADIUS.cos();
    let at = |i: usize| (i as f64 + 0.5) / POINTS as f64;
    let (mut inside, mut all) = (0.0, 0.0);
    for i in 0..POINTS * POINTS {
        let (theta, point) = texel_point(x, y, at(i % POINTS), at(i / POINTS));
        all += theta.sin();
        if point.dot(to_sun) >= cos_radius {
            inside += theta.sin();
        }
    }
    inside / all
}

/// Steradians that a texel stands for: the integral of the bilinear filter's weight. At the pole the
/// filter is constant over the first half row.
fn solid_angle(y: usize) -> f64 {
    let step = PI / HEIGHT as f64;
    let across = TAU / WIDTH as f64;
    // From a to a + step the weight falls linearly from 1 to 0; by parts.
    let falling = |a: f64| a.cos() - ((a + step).sin() - a.sin()) / step;
    let centre = (y as f64 + 0.5) * step;
    if y == 0 {
        return across * (1.0 - centre.cos() + falling(centre));
    }
    across * centre.sin() * 2.0 * (1.0 - step.cos()) / step
}
