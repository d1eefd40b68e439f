//! What is plotted: a material, as JSON of the form that `snell bsdf` takes. This is the one place that
//! asks the laboratory what a material is.

use super::{PlotError, direction};
use crate::cpu;
use crate::cpu::bsdf::gltf::F_gltf;
use crate::cpu::sobol::{owen_scramble, sobol_dimension0, sobol_dimension1};
use crate::lab::material::{bsdf_of, material_of};
use crate::lab::{Input, Lab, LabError, Output, Stage};
use crate::shared::{BSDF_GLTF, Bsdf, GLTF_THIN_WALLED, GLTF_TRANSMISSIVE};
use crate::tables::tables;
use glam::DVec3;
use serde_json::{Value, json};

/// A material that has a name of its own.
pub struct Preset {
    pub name: &'static str,
    /// In a few words.
    pub about: &'static str,
    json: &'static str,
}

/// All presets, from plain to peculiar.
pub const PRESETS: [Preset; 19] = [
    Preset {
        name: "lambertian",
        about: "ideally diffuse, reflectance 0.8",
        json: r#"{"model":"lambertian","reflectance":[0.8,0.8,0.8]}"#,
    },
    Preset {
        name: "oren-nayar",
        about: "rough and diffuse, roughness 0.8",
        json: r#"{"model":"oren-nayar","reflectance":[0.8,0.8,0.8],"roughness":0.8}"#,
    },
    Preset {
        name: "glass",
        about: "smooth, eta 1.5",
        json: r#"{"model":"dielectric","eta":1.5}"#,
    },
    Preset {
        name: "rough-glass",
        about: "GGX, alpha 0.16, eta 1.5",
        json: r#"{"model":"dielectric","eta":1.5,"distribution":{"name":"ggx","alpha":0.16}}"#,
    },
    Preset {
        name: "diamond",
        about: "smooth, eta 2.42",
        json: r#"{"model":"dielectric","eta":2.42}"#,
    },
    Preset {
        name: "gold",
        about: "smooth",
        json: r#"{"model":"conductor","conductor":{"metal":"Au"}}"#,
    },
    Preset {
        name: "rough-gold",
        about: "GGX, alpha 0.16",
        json: r#"{"model":"conductor","conductor":{"metal":"Au"},"distribution":{"name":"ggx","alpha":0.16}}"#,
    },
    Preset {
        name: "copper",
        about: "Beckmann, alpha 0.3",
        json: r#"{"model":"conductor","conductor":{"metal":"Cu"},"distribution":{"name":"beckmann","alpha":0.3}}"#,
    },
    Preset {
        name: "aluminium",
        about: "GGX, alpha 0.09",
        json: r#"{"model":"conductor","conductor":{"metal":"Al"},"distribution":{"name":"ggx","alpha":0.09}}"#,
    },
    Preset {
        name: "brushed-steel",
        about: "iron, GGX, alpha 0.4 along the tangent and 0.1 across",
        json: r#"{"model":"conductor","conductor":{"metal":"Fe"},"distribution":{"name":"ggx","alpha":[0.4,0.1]}}"#,
    },
    Preset {
        name: "blinn",
        about: "white facets after Blinn, exponent 50",
        json: r#"{"model":"torrance-sparrow","fresnel":{"constant":[1,1,1]},"distribution":{"name":"blinn","exponent":50}}"#,
    },
    Preset {
        name: "plastic",
        about: "glTF, not metallic, base colour 0.5, roughness 0.2",
        json: r#"{"pbrMetallicRoughness":{"baseColorFactor":[0.5,0.5,0.5,1],"metallicFactor":0,"roughnessFactor":0.2}}"#,
    },
    Preset {
        name: "rough-plastic",
        about: "glTF, not metallic, base colour 0.5, roughness 0.6",
        json: r#"{"pbrMetallicRoughness":{"baseColorFactor":[0.5,0.5,0.5,1],"metallicFactor":0,"roughnessFactor":0.6}}"#,
    },
    Preset {
        name: "white-metal",
        about: "glTF, metallic, base colour 1, roughness 0.5",
        json: r#"{"pbrMetallicRoughness":{"baseColorFactor":[1,1,1,1],"metallicFactor":1,"roughnessFactor":0.5}}"#,
    },
    Preset {
        name: "frosted-glass",
        about: "glTF, transmission into a volume, roughness 0.4",
        json: r#"{"pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0.4},"extensions":{"KHR_materials_transmission":{"transmissionFactor":1},"KHR_materials_volume":{"thicknessFactor":1}}}"#,
    },
    Preset {
        name: "lacquer",
        about: "glTF, rough red under a clear coat of roughness 0.1",
        json: r#"{"pbrMetallicRoughness":{"baseColorFactor":[0.5,0.05,0.05,1],"metallicFactor":0,"roughnessFactor":0.7},"extensions":{"KHR_materials_clearcoat":{"clearcoatFactor":1,"clearcoatRoughnessFactor":0.1}}}"#,
    },
    Preset {
        name: "velvet",
        about: "glTF, dark, sheen of roughness 0.4",
        json: r#"{"pbrMetallicRoughness":{"baseColorFactor":[0.05,0.02,0.05,1],"metallicFactor":0,"roughnessFactor":1},"extensions":{"KHR_materials_sheen":{"sheenColorFactor":[0.8,0.6,0.8],"sheenRoughnessFactor":0.4}}}"#,
    },
    Preset {
        name: "oil-film",
        about: "glTF, black, film of index 1.4 and 500 nm, roughness 0.3",
        json: r#"{"pbrMetallicRoughness":{"baseColorFactor":[0,0,0,1],"metallicFactor":0,"roughnessFactor":0.3},"extensions":{"KHR_materials_iridescence":{"iridescenceFactor":1,"iridescenceIor":1.4,"iridescenceThicknessMaximum":500}}}"#,
    },
    Preset {
        name: "leaf",
        about: "glTF, half of the diffuse light goes through",
        json: r#"{"pbrMetallicRoughness":{"baseColorFactor":[0.2,0.5,0.1,1],"metallicFactor":0,"roughnessFactor":0.5},"extensions":{"KHR_materials_diffuse_transmission":{"diffuseTransmissionFactor":0.5,"diffuseTransmissionColorFactor":[0.5,0.7,0.1]}}}"#,
    },
];

/// A material to be plotted.
#[derive(Clone, Debug)]
pub struct Subject {
    pub name: String,
    material: Value,
}

/// What a material does along single directions and what it spreads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parts {
    pub delta: bool,
    pub spread: bool,
    pub transmits: bool,
}

impl Subject {
    pub fn new(name: impl Into<String>, material: Value) -> Self {
        Self {
            name: name.into(),
            material,
        }
    }

    /// The preset of this name.
    pub fn preset(name: &str) -> Option<Self> {
        let preset = PRESETS.iter().find(|preset| preset.name == name)?;
        let material = serde_json::from_str(preset.json).ok()?;
        Some(Self::new(name, material))
    }

    /// As the reflection functions take it, seen from outside.
    pub fn bsdf(&self) -> Result<Bsdf, PlotError> {
        match material_of(&self.material) {
            Ok(material) => Ok(bsdf_of(&material)),
            Err(source) => Err(PlotError::Material {
                name: self.name.clone(),
                source,
            }),
        }
    }

    /// The same material with another roughness, alpha being its square; `None` where it has none. Smooth
    /// boundaries get facets after GGX.
    pub fn with_roughness(&self, roughness: f64) -> Option<Self> {
        let mut material = self.material.clone();
        let model = material
            .pointer_mut("/extensions/SNELL_materials_bsdf")
            .map(Value::take);
        match model {
            Some(mut model) => {
                roughen(&mut model, roughness)?;
                material["extensions"]["SNELL_materials_bsdf"] = model;
            }
            None => roughen(&mut material, roughness)?,
        }
        Some(Self::new(self.name.clone(), material))
    }
}

fn roughen(material: &mut Value, roughness: f64) -> Option<()> {
    // Models ask for more than 0; a lobe this narrow is a mirror to them.
    const SMOOTH: f64 = 1e-6;
    let alpha = (roughness * roughness).max(SMOOTH);
    let Some(model) = material.get("model") else {
        let pbr = material
            .as_object_mut()?
            .entry("pbrMetallicRoughness")
            .or_insert_with(|| json!({}));
        pbr.as_object_mut()?
            .insert("roughnessFactor".into(), json!(roughness));
        return Some(());
    };
    match model.as_str()? {
        "oren-nayar" => {
            // The other form speaks of slopes.
            if material
                .get("form")
                .is_some_and(|form| form == "qualitative")
            {
                return None;
            }
            material["roughness"] = json!(roughness);
        }
        "dielectric" | "conductor" | "torrance-sparrow" => {
            let name = match material
                .pointer("/distribution/name")
                .and_then(Value::as_str)
            {
                None => "ggx",
                Some(name @ ("ggx" | "beckmann")) => name,
                // Exponents are no roughness.
                Some(_) => return None,
            };
            material["distribution"] = json!({"name": name, "alpha": alpha});
        }
        _ => return None,
    }
    Some(())
}

/// The float64 reference, asked about one material.
pub struct Reference {
    lab: Lab,
}

impl Default for Reference {
    fn default() -> Self {
        Self { lab: Lab::cpu() }
    }
}

impl Reference {
    /// The Fresnel reflectance of the material's facets at each cosine.
    pub fn fresnel(&self, bsdf: &Bsdf, cosines: &[f64]) -> Result<Vec<DVec3>, LabError> {
        if bsdf.model == BSDF_GLTF {
            // The laboratory's stage knows the boundaries of the lecture's models only.
            let bsdf = cpu::bsdf::Bsdf::from(bsdf);
            let tables = tables();
            return Ok(cosines
                .iter()
                .map(|&cos| F_gltf(&tables, &bsdf, cos))
                .collect());
        }
        let inputs: Vec<Input> = cosines
            .iter()
            .map(|&cos_theta| Input {
                cos_theta,
                ..input(bsdf, DVec3::Z)
            })
            .collect();
        let outputs = self.lab.run(Stage::Fresnel, &inputs)?;
        Ok(outputs.into_iter().map(|output| output.f).collect())
    }

    /// f without the cosine for each wi, single directions left out.
    pub fn f(&self, bsdf: &Bsdf, wo: DVec3, wi: &[DVec3]) -> Result<Vec<DVec3>, LabError> {
        let inputs: Vec<Input> = wi
            .iter()
            .map(|&wi| Input {
                wi,
                ..input(bsdf, wo)
            })
            .collect();
        let outputs = self.lab.run(Stage::Eval, &inputs)?;
        Ok(outputs.into_iter().map(|output| output.f).collect())
    }

    /// This many samples for wo, spread evenly; always the same ones.
    pub fn samples(&self, bsdf: &Bsdf, wo: DVec3, count: usize) -> Result<Vec<Output>, LabError> {
        // Burley 2020, "Practical hash-based Owen scrambling", section 4: a third dimension is the first one
        // again in another order.
        const SEEDS: [u32; 4] = [1, 2, 3, 4];
        let unit = |x: u32, seed| f64::from(owen_scramble(x, seed)) / 2f64.powi(32);
        let inputs: Vec<Input> = (0..count as u32)
            .map(|i| Input {
                u: DVec3::new(
                    unit(sobol_dimension0(owen_scramble(i, SEEDS[0])), SEEDS[1]),
                    unit(sobol_dimension0(i), SEEDS[2]),
                    unit(sobol_dimension1(i), SEEDS[3]),
                ),
                ..input(bsdf, wo)
            })
            .collect();
        self.lab.run(Stage::Sample, &inputs)
    }

    /// What there is to see of the material, found by sampling it.
    pub fn parts(&self, bsdf: &Bsdf) -> Result<Parts, LabError> {
        let found = self.samples(bsdf, direction(45.0, 0.0), 1024)?;
        let any = |test: fn(&Output) -> bool| found.iter().filter(|s| s.pdf > 0.0).any(test);
        Ok(Parts {
            delta: any(|sample| sample.delta),
            spread: any(|sample| !sample.delta),
            transmits: any(|sample| sample.wi.z < 0.0),
        })
    }
}

/// By how much radiance is denser where light goes that the material transmits; f has its inverse.
pub fn radiance_density(bsdf: &Bsdf) -> f64 {
    let enters_a_medium = match bsdf.model {
        BSDF_GLTF => bsdf.gltf.flags & (GLTF_TRANSMISSIVE | GLTF_THIN_WALLED) == GLTF_TRANSMISSIVE,
        _ => true,
    };
    match enters_a_medium {
        true => f64::from(bsdf.eta[0]).powi(2),
        false => 1.0,
    }
}

fn input(bsdf: &Bsdf, wo: DVec3) -> Input {
    Input {
        bsdf: *bsdf,
        wo,
        wi: DVec3::Z,
        u: DVec3::ZERO,
        cos_theta: 1.0,
    }
}
