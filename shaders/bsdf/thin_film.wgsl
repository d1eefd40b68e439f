// Interference in a film thinner than light's coherence, on a base whose reflectance is known
// (KHR_materials_iridescence; Belcour and Barla 2017, "A Practical Extension to Microfacet Theory for
// the Modeling of Varying Iridescence").
//
// With amplitudes r12 of the film's upper side and r23 of its lower, and phase p = 2 pi D / lambda of
// the path difference D, Airy's sum of all reflections leaves through
//   1 - R = (1 - r12^2) (1 - r23^2) / |1 + r12 r23 e^(i p)|^2
//         = A (1 + 2 sum_m (-r12 r23)^m cos(m p)),   A = (1 - r12^2) (1 - r23^2) / (1 - (r12 r23)^2),
// and the observer's view of cos(m p) is a table made of the colour-matching functions themselves.
//
// What is free in the extension, and how it is taken here: amplitudes are real and polarisations
// averaged, as there; r12 is exact Fresnel; r23 is such that a film of no thickness, where amplitudes
// add up to (r12 + r23) / (1 + r12 r23), leaves the base's own reflectance, whichever that is. With
// indices (a base of F0, seen at normal incidence) that is the extension's own r23. So a film of no
// thickness or of index 1 is no film, without a blend.

import package::shared::{INTERFERENCE_CARRIER, INTERFERENCE_STEP, INTERFERENCE_TABLE_SIZE};
import package::bindings::{tables};
import package::bsdf::fresnel::{F_dielectric, T_dielectric, snell_root};
import package::math::{PI, sincos_accurate};

// Reflections inside the film that are told apart. Those left out are less than 4e-4 of the light up to
// 85 degrees, 0.01 at any angle.
const FILM_ORDERS: u32 = 24u;
// Below this an order and all that follow are nothing.
const FILM_ORDER_MIN: f32 = 1e-7;

// Three complex numbers, one a channel.
struct Interference {
    re: vec3<f32>,
    im: vec3<f32>,
}

// shader only: the reference reads pairs of any table.
fn interference_pair(index: u32) -> vec2<f32> {
    let pair = tables.interference[index / 2u];
    return select(pair.xy, pair.zw, (index & 1u) == 1u);
}

fn interference_entry(entry: u32) -> Interference {
    let red = interference_pair(3u * entry);
    let green = interference_pair(3u * entry + 1u);
    let blue = interference_pair(3u * entry + 2u);
    return Interference(vec3(red.x, green.x, blue.x), vec3(red.y, green.y, blue.y));
}

// What the observer sees of cos(2 pi D / lambda), for D in steps of the table: 1 at 0, and 0 from the
// table's end on. carrier is (sin, cos) of 2 pi D / INTERFERENCE_CARRIER.
fn interference(steps: f32, carrier: vec2<f32>) -> vec3<f32> {
    let last = f32(INTERFERENCE_TABLE_SIZE - 1u);
    if steps >= last {
        return vec3(0.0);
    }
    let entry = u32(floor(steps));
    let t = steps - f32(entry);
    let below = interference_entry(entry);
    let above = interference_entry(entry + 1u);
    return mix(below.re, above.re, t) * carrier.y - mix(below.im, above.im, t) * carrier.x;
}

// Reflectance of a base under a film: F_base is the base's own towards cos_theta (from the film's
// outside), film_thickness is in nanometres, film_ior relative to the outside.
//
// Where interference makes a colour that Rec. 709 lacks, a channel would pass 0 or 1, by up to 0.09: it
// is cut there, so that no channel ever reflects more light than it gets.
fn F_thin_film(cos_theta: f32, film_ior: f32, film_thickness: f32, F_base: vec3<f32>) -> vec3<f32> {
    if film_thickness <= 0.0 {
        return F_base;
    }
    let c = min(abs(cos_theta), 1.0);
    // -r12 and -r13, and from them A and -r12 r23 with the quotients multiplied out.
    let a = sqrt(F_dielectric(c, film_ior)) * select(1.0, -1.0, film_ior < 1.0);
    let b = sqrt(clamp(F_base, vec3(0.0), vec3(1.0)));
    let T12 = T_dielectric(c, film_ior);
    let T13 = max(1.0 - F_base, vec3(0.0));
    let gap = vec3(a) - b;
    let A = T12 * T13 / max(T13 + gap * gap, vec3(1e-30));
    let ratio = a * gap / max(1.0 - a * b, vec3(1e-30));
    let path_difference = 2.0 * film_thickness * snell_root(c, film_ior);
    let steps = path_difference / INTERFERENCE_STEP;
    let turn = sincos_accurate(2.0 * PI * path_difference / INTERFERENCE_CARRIER);
    var carrier = turn;
    var power = ratio;
    var sum = vec3(1.0);
    for (var order = 1u; order <= FILM_ORDERS; order++) {
        let reach = f32(order) * steps;
        let size = max(abs(power.x), max(abs(power.y), abs(power.z)));
        if reach >= f32(INTERFERENCE_TABLE_SIZE - 1u) || size < FILM_ORDER_MIN {
            break;
        }
        sum += 2.0 * power * interference(reach, carrier);
        power *= ratio;
        carrier = vec2(carrier.x * turn.y + carrier.y * turn.x, carrier.y * turn.y - carrier.x * turn.x);
    }
    return clamp(1.0 - A * sum, vec3(0.0), vec3(1.0));
}
