//! Bodies that bend each wavelength by an angle of its own.

use crate::expect::{Seen, check};
use crate::stage::{SEEN, Stage, bsdf, films, lamp, prism, rectangle, slab};
use crate::{ABSORPTION, Layer, PANEL, over_panel, passed, single};
use glam::{DVec3, Vec3};
use snell::scene::Mesh;
use snell::scene::bsdf_model::BsdfModel;
use snell::spectrum::color_matching;
use std::cell::RefCell;
use std::collections::BTreeMap;

const IOR: f64 = 1.5;
const ABBE: f64 = 12.0;

fn add_dispersive(stage: &mut Stage, mut mesh: Mesh, absorption: [f64; 3]) {
    let glass = bsdf(BsdfModel::Dielectric {
        eta: IOR as f32,
        distribution: None,
    });
    stage.add_changed(&mut mesh, glass, move |material| {
        // KHR_materials_dispersion.
        material.dispersion = (20.0 / ABBE) as f32;
        material.absorption = single(absorption);
    });
}

/// By Cauchy's A + B / lambda^2, from the index at 587.56 nm and Abbe's number, nanometres.
fn index(wavelength: f64, abbe: f64) -> f64 {
    let b = (IOR - 1.0) / abbe / (486.13f64.powi(-2) - 656.27f64.powi(-2));
    IOR + b * (wavelength.powi(-2) - 587.56f64.powi(-2))
}

/// What an observer makes of a spectrum, linear Rec. 709; of a constant one: that constant.
fn observed(spectrum: impl Fn(f64) -> [f64; 3]) -> [f64; 3] {
    const STEP: f64 = 0.5;
    let steps = (0..800).map(|i| 380.0 + STEP * (f64::from(i) + 0.5));
    steps
        .map(|wavelength| {
            STEP * color_matching(wavelength) * DVec3::from_array(spectrum(wavelength))
        })
        .sum::<DVec3>()
        .to_array()
}

/// Head-on all wavelengths go one way: white stays white but for the little by which indices change
/// what is reflected.
#[test]
fn a_dispersive_slab_stays_white_head_on() {
    let mut stage = over_panel();
    add_dispersive(&mut stage, slab(-0.7, 0.8), ABSORPTION);
    let layer = |ior| Layer {
        ior,
        absorption: ABSORPTION,
        thickness: 1.5,
    };
    let expected = observed(|wavelength| {
        let layer = layer(index(wavelength, ABBE));
        [0, 1, 2].map(|c| PANEL[c] * passed(&[layer], c))
    });
    for c in 0..3 {
        let plain = PANEL[c] * passed(&[layer(IOR)], c);
        assert!((expected[c] / plain - 1.0).abs() < 0.02, "{expected:?}");
    }
    stage.check("a dispersive slab", 4096, 3e-3, |_, _| Some((0, expected)));
}

/// The prism's front is z = 0; its back rises from x = -2 by this angle.
const APEX: f64 = 0.35;
const EDGE: f64 = -2.0;
const WALL: f64 = 6.0;
const STRIPE: [f64; 2] = [1.02, 1.17];

/// Unpolarised reflectance by Fresnel's equations in the angles (Born and Wolf 1999, section 1.5.2).
fn reflectance(inside: f64, outside: f64) -> f64 {
    let (difference, sum) = (inside - outside, inside + outside);
    let s = difference.sin() / sum.sin();
    let p = difference.tan() / sum.tan();
    0.5 * (s * s + p * p)
}

/// The stripe at x on the prism, one wavelength.
fn stripe_seen(x: f64, n: f64) -> f64 {
    let outside = (n * APEX.sin()).asin();
    let way = WALL - (x - EDGE) * APEX.tan();
    let at = x + way * (outside - APEX).tan();
    let front = ((n - 1.0) / (n + 1.0)).powi(2);
    let passed = (1.0 - front) * (1.0 - reflectance(APEX, outside));
    f64::from(u8::from((STRIPE[0]..STRIPE[1]).contains(&at))) * passed
}

/// Each colour of a white stripe is seen where Snell's law has it.
#[test]
fn a_prism_bends_each_colour_by_its_own_index() {
    const PARTS: f64 = 6.0;
    let mut stage = Stage::default();
    let wall = |x: f64, y: f64| Vec3::new(x as f32, y as f32, -WALL as f32);
    stage.add(
        rectangle(wall(STRIPE[0], -9.0), wall(STRIPE[1], 9.0)),
        lamp([1.0; 3]),
    );
    add_dispersive(&mut stage, prism(EDGE as f32, 2.0, APEX as f32), [0.0; 3]);
    let seen = |x: f64, abbe: f64| {
        observed(|wavelength| [stripe_seen(SEEN * x, index(wavelength, abbe)); 3])
    };
    let packed = stage.pack([96, 96]);
    for (renderer, film) in films(&packed, 128) {
        let compare = |abbe: f64| {
            // Columns of filter taps repeat from row to row.
            let columns = RefCell::new(BTreeMap::new());
            check(&format!("a prism on {renderer}"), &film, &|x, _| -> Seen {
                let part = (0.5 * (x + 1.0) * PARTS) as u32;
                let mut columns = columns.borrow_mut();
                let radiance = columns.entry(x.to_bits()).or_insert_with(|| seen(x, abbe));
                Some((part, *radiance))
            });
        };
        compare(ABBE);
        for other in [0.9 * ABBE, 1.1 * ABBE] {
            let seen_apart = std::panic::catch_unwind(|| compare(other)).is_err();
            assert!(seen_apart, "Abbe numbers {ABBE} and {other} look the same");
        }
    }
    // Red is bent least, so it is seen at the larger x; each end lacks the other's colour.
    let (red, blue) = (seen(0.36, ABBE), seen(-0.14, ABBE));
    assert!(red[0] > 0.1 && red[2] < 0.02, "{red:?}");
    assert!(blue[2] > 0.1 && blue[0] < 0.3 * blue[2], "{blue:?}");
}
