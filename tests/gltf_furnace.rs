//! glTF's material in a white furnace, in float64.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]
#![allow(non_snake_case, reason = "the letters of the functions under test")]

mod subjects;

use glam::DVec3;
use rayon::prelude::*;
use snell::cpu::bsdf::Bsdf;
use snell::cpu::bsdf::bsdf::*;
use snell::shared::*;
use snell::tables::tables;
use std::fmt::Write;
use subjects::*;

/// What a surface returns to wo of even light of radiance 1 (and eta^2 on the far side of a boundary).
fn furnace(tables: &Tables, bsdf: &Bsdf, wo: DVec3, count: u32) -> DVec3 {
    let refractive = bsdf.gltf.flags & (GLTF_TRANSMISSIVE | GLTF_THIN_WALLED) == GLTF_TRANSMISSIVE;
    let points: Vec<DVec3> = lattice(count).collect();
    let sum: DVec3 = points
        .par_iter()
        .map(|&u| {
            let s = bsdf_sample(tables, bsdf, wo, u);
            if s.pdf <= 0.0 {
                return DVec3::ZERO;
            }
            let power = if refractive && s.wi.z < 0.0 {
                bsdf.eta.x.powi(2)
            } else {
                1.0
            };
            s.f * (s.wi.z.abs() / s.pdf * power)
        })
        .sum();
    sum / f64::from(count)
}

fn white(roughness: f64, change: impl Fn(&mut Bsdf)) -> Bsdf {
    let mut bsdf = plastic(roughness);
    change(&mut bsdf);
    bsdf
}

fn glassy(b: &mut Bsdf, eta: f64, flags: u32) {
    b.eta = DVec3::splat(eta);
    b.gltf.F0 = DVec3::splat(((eta - 1.0) / (eta + 1.0)).powi(2));
    b.gltf.transmission = 1.0;
    b.gltf.flags = GLTF_TRANSMISSIVE | flags;
}

/// A material by its roughness, and how far from 1 its furnace may be, above and below.
type Family = (&'static str, fn(f64) -> Bsdf, [f64; 2]);

/// Samples of an integral whose error has to be small against 0.005, and of one that is a bound.
const MANY: u32 = 400_000;
const SOME: u32 = 20_000;

fn assert_furnace(families: &[Family], azimuths: &[f64], count: u32) {
    let tables = tables();
    let mut faults = String::new();
    for (name, of, [above, below]) in families {
        let (mut highest, mut lowest) = (0.0_f64, 0.0_f64);
        for roughness in ROUGHNESSES {
            for degrees in [0.0_f64, 30.0, 50.0, 70.0, 80.0, 85.0, 89.0] {
                for &phi in azimuths {
                    let wo = direction(degrees.to_radians(), phi);
                    let gap = furnace(&tables, &of(roughness), wo, count) - 1.0;
                    highest = highest.max(gap.max_element());
                    lowest = lowest.min(gap.min_element());
                }
            }
        }
        println!("{name:24} {highest:+.4} {lowest:+.4}");
        if highest > *above || lowest < -below {
            writeln!(faults, "{name}: {highest:+.4} {lowest:+.4}").unwrap();
        }
    }
    assert!(faults.is_empty(), "{faults}");
}

/// alpha from 0.05 to 1.
const ROUGHNESSES: [f64; 6] = [0.2237, 0.3, 0.4, 0.6, 0.8, 1.0];
/// What the tables leave, and what is left of the lattice's noise.
const EXACT: [f64; 2] = [0.005; 2];

fn half_through(b: &mut Bsdf) {
    b.gltf.transmission = 0.5;
    b.gltf.metallic = 0.3;
    b.gltf.diffuse_transmission = 0.6;
    b.gltf.diffuse_transmission_color = DVec3::ONE;
}

#[test]
fn white_surfaces_return_all_light() {
    let families: [Family; 10] = [
        ("metal", |r| white(r, |b| b.gltf.metallic = 1.0), EXACT),
        ("plastic", plastic, EXACT),
        ("half metal", |r| white(r, |b| b.gltf.metallic = 0.5), EXACT),
        ("glass", |r| white(r, |b| glassy(b, 1.5, 0)), EXACT),
        (
            "glass from inside",
            |r| white(r, |b| glassy(b, 1.0 / 1.5, GLTF_INSIDE)),
            EXACT,
        ),
        ("diamond", |r| white(r, |b| glassy(b, 2.4, 0)), EXACT),
        (
            "diamond from inside",
            |r| white(r, |b| glassy(b, 1.0 / 2.4, GLTF_INSIDE)),
            EXACT,
        ),
        (
            "thin wall",
            |r| white(r, |b| glassy(b, 1.5, GLTF_THIN_WALLED)),
            EXACT,
        ),
        (
            "coloured specular on glass",
            |r| {
                white(r, |b| {
                    glassy(b, 1.5, 0);
                    b.gltf.F0 = DVec3::new(0.2, 0.04, 0.01);
                })
            },
            EXACT,
        ),
        (
            "all that passes",
            |r| {
                white(r, |b| {
                    glassy(b, 1.5, 0);
                    half_through(b);
                })
            },
            EXACT,
        ),
    ];
    assert_furnace(&families, &[0.4], MANY);
}

/// Where specular's F90 is not 1, what facets would transmit is an estimate.
#[test]
fn weak_specular_keeps_most_light() {
    let families: [Family; 2] = [
        (
            "weak specular",
            |r| {
                white(r, |b| {
                    glassy(b, 1.5, 0);
                    b.gltf.F0 *= 0.5;
                    b.gltf.F90 = 0.5;
                })
            },
            [0.04; 2],
        ),
        (
            "weak specular, inside",
            |r| {
                white(r, |b| {
                    glassy(b, 1.0 / 1.5, GLTF_INSIDE);
                    b.gltf.F0 *= 0.5;
                    b.gltf.F90 = 0.5;
                })
            },
            [0.03; 2],
        ),
    ];
    assert_furnace(&families, &[0.4], SOME);
}

#[test]
fn layers_keep_what_is_below_them() {
    let families: [Family; 5] = [
        (
            "coat on metal",
            |r| {
                white(0.3, |b| {
                    b.gltf.metallic = 1.0;
                    b.gltf.coat = 1.0;
                    b.gltf.coat_roughness = r;
                })
            },
            EXACT,
        ),
        (
            "smooth coat on plastic",
            |r| white(r, |b| b.gltf.coat = 1.0),
            EXACT,
        ),
        (
            "coat on glass",
            |r| {
                white(r, |b| {
                    glassy(b, 1.5, 0);
                    b.gltf.coat = 0.7;
                    b.gltf.coat_roughness = 0.3;
                })
            },
            EXACT,
        ),
        (
            "white sheen",
            |r| {
                white(0.6, |b| {
                    b.gltf.sheen_color = DVec3::ONE;
                    b.gltf.sheen_roughness = r;
                })
            },
            [0.005, 0.005],
        ),
        // The bent lobe's part below the surface is lost.
        (
            "bent coat",
            |r| {
                white(0.5, |b| {
                    b.gltf.coat = 1.0;
                    b.gltf.coat_roughness = r;
                    b.gltf.coat_normal = direction(0.2, 2.0);
                })
            },
            [0.002, 0.01],
        ),
    ];
    assert_furnace(&families, &[0.4], MANY);
}

/// Under a film and for anisotropic facets the tables hold by an equivalent.
#[test]
fn films_and_brushes_make_little_light() {
    let families: [Family; 5] = [
        (
            "film on plastic",
            |r| {
                white(r, |b| {
                    film(b);
                })
            },
            [0.02, 0.13],
        ),
        (
            "film on metal",
            |r| {
                white(r, |b| {
                    b.gltf.metallic = 1.0;
                    film(b);
                })
            },
            [0.02, 0.02],
        ),
        (
            "film on glass",
            |r| {
                white(r, |b| {
                    glassy(b, 1.5, 0);
                    film(b);
                })
            },
            [0.05, 0.05],
        ),
        (
            "brushed, strength 0.3",
            |r| white(r, |b| brushed(b, 0.3)),
            [0.03, 0.06],
        ),
        (
            "brushed, strength 0.5",
            |r| white(r, |b| brushed(b, 0.5)),
            [0.04, 0.1],
        ),
    ];
    assert_furnace(&families, &[0.4, 1.3], SOME);
}

fn film(b: &mut Bsdf) {
    b.gltf.iridescence = 1.0;
    b.gltf.film_ior = 1.3;
    b.gltf.film_thickness = 400.0;
}

fn brushed(b: &mut Bsdf, strength: f64) {
    b.gltf.metallic = 1.0;
    b.alpha.x += (1.0 - b.alpha.x) * strength * strength;
}
