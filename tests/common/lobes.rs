//! The lobes that statistical tests go over, and independent random numbers for them.
#![allow(dead_code, reason = "each test file uses a part of this")]
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

use glam::DVec3;
use snell::lab::query::{Kind, parse};
use snell::shared::Bsdf;

/// A lobe with what it promises.
pub struct Lobe {
    pub name: String,
    pub bsdf: Bsdf,
    /// f |cos| / pdf is never above this, with transmission freed of eta^2.
    pub weight_max: f64,
    /// What it reflects and transmits at most, of energy.
    pub albedo_max: f64,
}

impl Lobe {
    /// Index of the far side over the near side, of models that transmit; 1 of others.
    pub fn eta(&self) -> f64 {
        let transmissive = [
            snell::shared::BSDF_DIELECTRIC,
            snell::shared::BSDF_ROUGH_DIELECTRIC,
            snell::shared::BSDF_SPECULAR_TRANSMISSION,
        ];
        if transmissive.contains(&self.bsdf.model) {
            f64::from(self.bsdf.eta[0])
        } else {
            1.0
        }
    }
}

/// The reflection model of a material as JSON.
pub fn bsdf(material: &str) -> Bsdf {
    let line = format!(r#"{{"material":{material},"wo":[0,0,1],"u":[0,0,0]}}"#);
    let (_, query) = parse(line.as_bytes(), Some(Kind::Sample))
        .unwrap_or_else(|rejected| panic!("{material}: {}", rejected.error));
    query.input.bsdf
}

/// Every lobe that is no delta, white, at glTF roughness `roughness`.
pub fn lobes(roughness: f64) -> Vec<Lobe> {
    let alpha = roughness * roughness;
    // The exponent of the Beckmann distribution most like it.
    let exponent = 2.0 / (alpha * alpha) - 2.0;
    let white = "[1,1,1]";
    let facets = |distribution: &str| {
        format!(
            r#"{{"model":"torrance-sparrow","fresnel":{{"constant":{white}}},"distribution":{{{distribution}}}}}"#
        )
    };
    let glass = |eta: f64, distribution: &str| {
        format!(r#"{{"model":"dielectric","eta":{eta},"distribution":{{{distribution}}}}}"#)
    };
    let gltf = |metallic: f64| {
        format!(
            r#"{{"pbrMetallicRoughness":{{"metallicFactor":{metallic},"roughnessFactor":{roughness}}}}}"#
        )
    };
    let blinn = format!(r#""name":"blinn","exponent":{exponent}"#);
    let shirley = format!(
        r#""name":"ashikhmin-shirley","exponent":[{exponent},{}]"#,
        0.2 * exponent
    );
    let beckmann = format!(r#""name":"beckmann","alpha":{alpha}"#);
    let beckmann_2 = format!(r#""name":"beckmann","alpha":[{},{alpha}]"#, 0.5 * alpha);
    let ggx = format!(r#""name":"ggx","alpha":{alpha}"#);
    let ggx_2 = format!(r#""name":"ggx","alpha":[{alpha},{}]"#, 0.5 * alpha);
    let diffuse = |rest: &str| format!(r#"{{"model":{rest},"reflectance":{white}}}"#);
    // Visible normals weigh G2/G1 <= 1. Normals drawn by D cos weigh G (wo . wm) / (cos_o cos_m), which
    // V-cavities keep under 2. Oren and Nayar's forms grow like roughness / cos_o at grazing angles, here up
    // to 85 degrees, and are sampled by the cosine. glTF's two lobes are each chosen with a probability of 0.1 at least.
    [
        ("lambertian", diffuse(r#""lambertian""#), 1.0),
        (
            "oren-nayar",
            diffuse(&format!(
                r#""oren-nayar","form":"qualitative","sigma":{roughness}"#
            )),
            13.0,
        ),
        (
            "eon",
            diffuse(&format!(r#""oren-nayar","roughness":{roughness}"#)),
            13.0,
        ),
        ("blinn", facets(&blinn), 2.0),
        ("ashikhmin-shirley", facets(&shirley), 2.0),
        ("beckmann", facets(&beckmann), 1.0),
        ("beckmann anisotropic", facets(&beckmann_2), 1.0),
        ("ggx", facets(&ggx), 1.0),
        ("ggx anisotropic", facets(&ggx_2), 1.0),
        ("glass ggx", glass(1.5, &ggx), 1.0),
        ("glass ggx from inside", glass(1.0 / 1.5, &ggx), 1.0),
        ("glass beckmann", glass(1.5, &beckmann), 1.0),
        ("glass blinn", glass(1.5, &blinn), 2.0),
        ("gltf plastic", gltf(0.0), 10.0),
        ("gltf half metal", gltf(0.5), 10.0),
    ]
    .map(|(name, material, weight_max)| Lobe {
        name: format!("{name} roughness {roughness}"),
        bsdf: bsdf(&material),
        weight_max,
        // The lecture's Oren-Nayar formula itself returns a little too much at grazing angles.
        albedo_max: if name == "oren-nayar" { 1.01 } else { 1.0 },
    })
    .into()
}

/// The direction at an angle of `degrees` from the normal, in no special azimuth.
pub fn direction(degrees: f64) -> DVec3 {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let (sin_phi, cos_phi) = 0.4_f64.sin_cos();
    DVec3::new(sin * cos_phi, sin * sin_phi, cos)
}

/// Independent uniform points of the unit cube, multiples of 2^-24 (which float32 has exactly).
pub fn uniforms(seed: u64, count: usize) -> Vec<DVec3> {
    let mut state = seed.wrapping_mul(0xd134_2543_de82_ef95);
    let mut next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f64 / f64::from(1 << 24)
    };
    (0..count)
        .map(|_| DVec3::new(next(), next(), next()))
        .collect()
}
