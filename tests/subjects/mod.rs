//! Reflection models and directions that tests of the reference share.
#![allow(dead_code, reason = "each test file uses a part of this")]

use bytemuck::Zeroable;
use glam::{DVec2, DVec3};
use snell::cpu::bsdf::{Bsdf, Gltf};
use snell::shared::{self, *};

pub fn direction(theta: f64, phi: f64) -> DVec3 {
    DVec3::new(
        theta.sin() * phi.cos(),
        theta.sin() * phi.sin(),
        theta.cos(),
    )
}

/// A white Torrance-Sparrow lobe.
pub fn lobe(distribution: u32, alpha: [f64; 2], masking: u32) -> Bsdf {
    Bsdf {
        reflectance: DVec3::ONE,
        model: BSDF_TORRANCE_SPARROW,
        eta: DVec3::ONE,
        fresnel: FRESNEL_CONSTANT,
        distribution,
        alpha: DVec2::from_array(alpha),
        masking,
        ..Bsdf::from(&shared::Bsdf::zeroed())
    }
}

pub fn glass(eta: f64, distribution: u32, alpha: f64) -> Bsdf {
    Bsdf {
        model: BSDF_ROUGH_DIELECTRIC,
        eta: DVec3::new(eta, 0.0, 0.0),
        ..lobe(distribution, [alpha; 2], MASKING_SMITH)
    }
}

/// Points of a rank-1 lattice, for integrals by the lobes' own samplers.
pub fn lattice(count: u32) -> impl Iterator<Item = DVec3> {
    // Powers of the plastic number's relatives (Roberts 2018, "The Unreasonable Effectiveness of
    // Quasirandom Sequences").
    let g = 1.220_744_084_605_759_5f64;
    (0..count).map(move |i| {
        let n = f64::from(i) + 0.5;
        DVec3::new(
            (n / g).fract(),
            (n / g.powi(2)).fract(),
            (n / g.powi(3)).fract(),
        )
    })
}

/// Pairs of directions over the hemisphere, grazing ones too.
pub fn pairs() -> Vec<(DVec3, DVec3)> {
    let thetas = [0.0, 0.4, 1.0, 1.5, 1.5706];
    let mut pairs = Vec::new();
    for a in thetas {
        for b in thetas {
            for phi in [0.1, 1.3, 3.0] {
                pairs.push((direction(a, 0.2), direction(b, 0.2 + phi)));
            }
        }
    }
    pairs
}

/// Every kind of rough lobe, with the natural masking and Smith's.
pub fn lobes() -> Vec<Bsdf> {
    let mut all = vec![];
    for masking in [MASKING_V_CAVITY, MASKING_SMITH] {
        for e in [2.0, 100.0, 1e4] {
            all.push(lobe(DISTRIBUTION_BLINN, [e, e], masking));
            all.push(lobe(DISTRIBUTION_ASHIKHMIN_SHIRLEY, [e, 0.1 * e], masking));
        }
    }
    for alpha in [[0.0025, 0.0025], [0.1, 0.1], [1.0, 1.0], [0.1, 0.6]] {
        all.push(lobe(DISTRIBUTION_BECKMANN, alpha, MASKING_SMITH));
        all.push(lobe(DISTRIBUTION_GGX, alpha, MASKING_SMITH));
    }
    all
}

/// glTF's white dielectric.
pub fn plastic(roughness: f64) -> Bsdf {
    Bsdf {
        model: BSDF_GLTF,
        eta: DVec3::splat(1.5),
        fresnel: FRESNEL_SCHLICK,
        roughness,
        gltf: Gltf {
            F0: DVec3::splat(0.04),
            F90: 1.0,
            rotation: DVec2::X,
            coat_normal: DVec3::Z,
            ..Gltf::default()
        },
        ..lobe(DISTRIBUTION_GGX, [roughness * roughness; 2], MASKING_SMITH)
    }
}
