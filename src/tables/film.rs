//! What the observer sees of interference, against the path difference D of the two rays.
//!
//! Entries, at multiples of `INTERFERENCE_STEP`, are the integrals of color_matching(lambda)
//! e^(2 pi i D (1 / lambda - 1 / carrier)) over the visible spectrum: without the carrier's own fast turn
//! they are smooth, and linear interpolation errs by less than 6e-4. Red, green and blue follow one
//! another, each as a pair (real, imaginary).

use super::write_pair;
use crate::shared::{INTERFERENCE_CARRIER, INTERFERENCE_STEP, INTERFERENCE_TABLE_SIZE, Tables};
use crate::spectrum;
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Wavelengths that integrate over the spectrum: a nanometre apart, where the closest fringes of the
/// table's end are 18.
const WAVELENGTHS: usize = 400;

/// Takes some milliseconds. The last entry stays 0, so that what lies beyond the table, 0 too, follows
/// without a jump; the response is below 0.02 there.
pub fn fill(tables: &mut Tables) {
    let responses: Vec<_> = spectrum::wavelengths(WAVELENGTHS)
        .map(|(wavelength, weight)| (wavelength, weight * spectrum::color_matching(wavelength)))
        .collect();
    let entries: Vec<_> = (0..INTERFERENCE_TABLE_SIZE - 1)
        .into_par_iter()
        .map(|entry| {
            let path_difference = f64::from(entry) * INTERFERENCE_STEP;
            let (mut re, mut im) = (DVec3::ZERO, DVec3::ZERO);
            for &(wavelength, response) in &responses {
                let waves = 1.0 / wavelength - 1.0 / INTERFERENCE_CARRIER;
                let (sin, cos) = (TAU * path_difference * waves).sin_cos();
                re += response * cos;
                im += response * sin;
            }
            (re, im)
        })
        .collect();
    for (entry, (re, im)) in entries.iter().enumerate() {
        for channel in 0..3 {
            let pair = [re[channel], im[channel]];
            write_pair(&mut tables.interference, 3 * entry + channel, pair);
        }
    }
}
