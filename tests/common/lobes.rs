//! The lobes that statistical tests go over, and independent random numbers for them.
#![allow(dead_code, reason = "each test file uses a part of this")]
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

use glam::DVec3;
use snell::lab::query::{Kind, parse};
use snell::shared::{BSDF_GLTF, Bsdf, GLTF_INSIDE, GLTF_THIN_WALLED, GLTF_TRANSMISSIVE, Gltf};

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
    /// Whether it is glTF's boundary of a medium that light is refracted into.
    pub fn is_refractive(&self) -> bool {
        let flags = self.bsdf.gltf.flags & (GLTF_TRANSMISSIVE | GLTF_THIN_WALLED);
        self.bsdf.model == BSDF_GLTF && flags == GLTF_TRANSMISSIVE
    }

    /// Index of the far side over the near side, of models that transmit; 1 of others.
    pub fn eta(&self) -> f64 {
        let transmissive = [
            snell::shared::BSDF_DIELECTRIC,
            snell::shared::BSDF_ROUGH_DIELECTRIC,
            snell::shared::BSDF_SPECULAR_TRANSMISSION,
        ];
        if transmissive.contains(&self.bsdf.model) || self.is_refractive() {
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
    // to 85 degrees, and are sampled by the cosine. glTF's lobes are each chosen with a probability of about 0.1, or three times their share.
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
        ("gltf plastic", gltf(0.0), 15.0),
        ("gltf half metal", gltf(0.5), 15.0),
    ]
    .map(|(name, material, weight_max)| Lobe {
        name: format!("{name} roughness {roughness}"),
        bsdf: bsdf(&material),
        weight_max,
        // The lecture's Oren-Nayar formula itself returns a little too much at grazing angles.
        // glTF's compensation stands on tables.
        albedo_max: match name {
            "oren-nayar" => 1.01,
            "gltf plastic" | "gltf half metal" => 1.003,
            _ => 1.0,
        },
    })
    .into()
}

/// A white glTF material with extensions that `change` sets.
pub fn gltf(roughness: f64, change: impl Fn(&mut Bsdf)) -> Bsdf {
    let mut bsdf = bsdf(&format!(
        r#"{{"pbrMetallicRoughness":{{"metallicFactor":0,"roughnessFactor":{roughness}}}}}"#
    ));
    change(&mut bsdf);
    bsdf
}

/// Light passes it: `eta` is the far side's index over the near side's.
pub fn transmissive(bsdf: &mut Bsdf, eta: f32, flags: u32) {
    bsdf.eta = [eta; 3];
    bsdf.gltf.F0 = [((eta - 1.0) / (eta + 1.0)).powi(2); 3];
    bsdf.gltf.transmission = 1.0;
    bsdf.gltf.flags = GLTF_TRANSMISSIVE | flags;
}

/// A bent normal for the coat.
pub fn bent() -> [f32; 3] {
    direction(12.0).as_vec3().to_array()
}

/// glTF's extensions that keep a lobe reciprocal, white.
pub fn gltf_lobes(roughness: f64) -> Vec<Lobe> {
    let inside = |b: &mut Bsdf| transmissive(b, 1.0 / 1.5, GLTF_INSIDE);
    let diffuse = |g: &mut Gltf| {
        g.diffuse_transmission = 0.6;
        g.diffuse_transmission_color = [1.0; 3];
    };
    let brushed = |b: &mut Bsdf| {
        b.alpha[0] += 0.25 * (1.0 - b.alpha[0]);
        b.gltf.rotation = [0.6, 0.8];
    };
    let all: Vec<(&str, Bsdf)> = vec![
        ("metal", gltf(roughness, |b| b.gltf.metallic = 1.0)),
        ("glass", gltf(roughness, |b| transmissive(b, 1.5, 0))),
        ("glass from inside", gltf(roughness, inside)),
        (
            "thin wall",
            gltf(roughness, |b| transmissive(b, 1.5, GLTF_THIN_WALLED)),
        ),
        (
            "strong and coloured specular on glass",
            gltf(roughness, |b| {
                transmissive(b, 1.5, 0);
                b.gltf.F0 = [0.3, 0.04, 0.02];
            }),
        ),
        (
            "diffuse transmission",
            gltf(roughness, |b| diffuse(&mut b.gltf)),
        ),
        (
            "all that passes a boundary",
            gltf(roughness, |b| {
                transmissive(b, 1.5, 0);
                b.gltf.transmission = 0.4;
                b.gltf.metallic = 0.2;
                diffuse(&mut b.gltf);
            }),
        ),
        (
            "brushed metal",
            gltf(roughness, |b| {
                b.gltf.metallic = 1.0;
                brushed(b);
            }),
        ),
        (
            "brushed glass",
            gltf(roughness, |b| {
                transmissive(b, 1.5, 0);
                brushed(b);
            }),
        ),
    ];
    promise(all, roughness, 1.0)
}

/// glTF's layers and films, white.
pub fn layered_lobes(roughness: f64) -> Vec<Lobe> {
    let coat = |b: &mut Bsdf| {
        b.gltf.coat = 0.8;
        b.gltf.coat_roughness = 0.5;
        b.gltf.coat_normal = bent();
    };
    let film = |b: &mut Bsdf| {
        b.gltf.iridescence = 1.0;
        b.gltf.film_ior = 1.3;
        b.gltf.film_thickness = 400.0;
    };
    let all: Vec<(&str, Bsdf)> = vec![
        (
            "coated metal",
            gltf(roughness, |b| {
                b.gltf.metallic = 1.0;
                coat(b);
            }),
        ),
        (
            "coated glass",
            gltf(roughness, |b| {
                transmissive(b, 1.5, 0);
                coat(b);
            }),
        ),
        (
            "sheen",
            gltf(roughness, |b| {
                b.gltf.sheen_color = [0.9, 0.5, 0.2];
                b.gltf.sheen_roughness = 0.5;
            }),
        ),
        (
            "coat over sheen",
            gltf(roughness, |b| {
                coat(b);
                b.gltf.sheen_color = [1.0; 3];
                b.gltf.sheen_roughness = 0.3;
            }),
        ),
        ("film on plastic", gltf(roughness, film)),
        (
            "film on metal",
            gltf(roughness, |b| {
                b.gltf.metallic = 1.0;
                film(b);
            }),
        ),
        (
            "film on a thin wall",
            gltf(roughness, |b| {
                transmissive(b, 1.5, GLTF_THIN_WALLED);
                film(b);
            }),
        ),
    ];
    promise(all, roughness, 1.0)
}

/// Weights are bounded by the least probability of a lobe, about 0.07, and by how much brighter than its
/// mean a lobe can be.
fn promise(all: Vec<(&str, Bsdf)>, roughness: f64, albedo_max: f64) -> Vec<Lobe> {
    all.into_iter()
        .map(|(name, bsdf)| Lobe {
            name: format!("{name} roughness {roughness}"),
            bsdf,
            weight_max: 25.0,
            albedo_max,
        })
        .collect()
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
