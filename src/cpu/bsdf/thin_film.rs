//! Interference in a film thinner than light's coherence, on a base whose reflectance is known
//! (KHR_materials_iridescence; Belcour and Barla 2017, "A Practical Extension to Microfacet Theory for
//! the Modeling of Varying Iridescence").
//!
//! With amplitudes r12 of the film's upper side and r23 of its lower, and phase p = 2 pi D / lambda of
//! the path difference D, Airy's sum of all reflections leaves through
//!   1 - R = (1 - r12^2) (1 - r23^2) / |1 + r12 r23 e^(i p)|^2
//!         = A (1 + 2 sum_m (-r12 r23)^m cos(m p)),   A = (1 - r12^2) (1 - r23^2) / (1 - (r12 r23)^2),
//! and the observer's view of cos(m p) is a table made of the colour-matching functions themselves.
//!
//! What is free in the extension, and how it is taken here: amplitudes are real and polarisations
//! averaged, as there; r12 is exact Fresnel; r23 is such that a film of no thickness, where amplitudes
//! add up to (r12 + r23) / (1 + r12 r23), leaves the base's own reflectance, whichever that is. With
//! indices (a base of F0, seen at normal incidence) that is the extension's own r23. So a film of no
//! thickness or of index 1 is no film, without a blend.

use super::albedo::pair_of;
use super::fresnel::{F_dielectric, T_dielectric, snell_root};
use crate::cpu::math::{PI, sincos_accurate};
use crate::shared::{INTERFERENCE_CARRIER, INTERFERENCE_STEP, INTERFERENCE_TABLE_SIZE, Tables};
use glam::{DVec2, DVec3};

/// Reflections inside the film that are told apart. Those left out are less than 4e-4 of the light up to
/// 85 degrees, 0.01 at any angle.
pub const FILM_ORDERS: u32 = 24;
/// Below this an order and all that follow are nothing.
pub const FILM_ORDER_MIN: f64 = 1e-7;

/// Three complex numbers, one a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interference {
    pub re: DVec3,
    pub im: DVec3,
}

pub fn interference_entry(tables: &Tables, entry: u32) -> Interference {
    let red = pair_of(&tables.interference, 3 * entry);
    let green = pair_of(&tables.interference, 3 * entry + 1);
    let blue = pair_of(&tables.interference, 3 * entry + 2);
    Interference {
        re: DVec3::new(red.x, green.x, blue.x),
        im: DVec3::new(red.y, green.y, blue.y),
    }
}

/// What the observer sees of cos(2 pi D / lambda), for D in steps of the table: 1 at 0, and 0 from the
/// table's end on. `carrier` is (sin, cos) of 2 pi D / `INTERFERENCE_CARRIER`.
pub fn interference(tables: &Tables, steps: f64, carrier: DVec2) -> DVec3 {
    let last = f64::from(INTERFERENCE_TABLE_SIZE - 1);
    if steps >= last {
        return DVec3::ZERO;
    }
    let entry = steps.floor() as u32;
    let t = steps - f64::from(entry);
    let below = interference_entry(tables, entry);
    let above = interference_entry(tables, entry + 1);
    below.re.lerp(above.re, t) * carrier.y - below.im.lerp(above.im, t) * carrier.x
}

/// Reflectance of a base under a film: `F_base` is the base's own towards `cos_theta` (from the film's
/// outside), `film_thickness` is in nanometres, `film_ior` relative to the outside.
///
/// Where interference makes a colour that Rec. 709 lacks, a channel would pass 0 or 1, by up to 0.09: it
/// is cut there, so that no channel ever reflects more light than it gets.
pub fn F_thin_film(
    tables: &Tables,
    cos_theta: f64,
    film_ior: f64,
    film_thickness: f64,
    F_base: DVec3,
) -> DVec3 {
    if film_thickness <= 0.0 {
        return F_base;
    }
    let c = cos_theta.abs().min(1.0);
    // -r12 and -r13, and from them A and -r12 r23 with the quotients multiplied out.
    let a = F_dielectric(c, film_ior).sqrt() * if film_ior < 1.0 { -1.0 } else { 1.0 };
    let b = F_base.clamp(DVec3::ZERO, DVec3::ONE).map(f64::sqrt);
    let T12 = T_dielectric(c, film_ior);
    let T13 = (DVec3::ONE - F_base).max(DVec3::ZERO);
    let gap = DVec3::splat(a) - b;
    let A = T12 * T13 / (T13 + gap * gap).max(DVec3::splat(1e-30));
    let ratio = a * gap / (1.0 - a * b).max(DVec3::splat(1e-30));
    let path_difference = 2.0 * film_thickness * snell_root(c, film_ior);
    let steps = path_difference / INTERFERENCE_STEP;
    let turn = sincos_accurate(2.0 * PI * path_difference / INTERFERENCE_CARRIER);
    let mut carrier = turn;
    let mut power = ratio;
    let mut sum = DVec3::ONE;
    for order in 1..=FILM_ORDERS {
        let reach = f64::from(order) * steps;
        if reach >= f64::from(INTERFERENCE_TABLE_SIZE - 1)
            || power.abs().max_element() < FILM_ORDER_MIN
        {
            break;
        }
        sum += 2.0 * power * interference(tables, reach, carrier);
        power *= ratio;
        carrier = DVec2::new(
            carrier.x * turn.y + carrier.y * turn.x,
            carrier.y * turn.y - carrier.x * turn.x,
        );
    }
    (1.0 - A * sum).clamp(DVec3::ZERO, DVec3::ONE)
}
