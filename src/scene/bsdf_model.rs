//! The lecture's reflection models as data: what `SNELL_materials_bsdf` and `snell bsdf` accept.

use serde::{Deserialize, Serialize};

/// A reflection model with its parameters, tagged by `model`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "model", rename_all = "kebab-case", deny_unknown_fields)]
pub enum BsdfModel {
    Lambertian {
        reflectance: [f32; 3],
    },
    OrenNayar {
        reflectance: [f32; 3],
        #[serde(default)]
        form: OrenNayarForm,
        /// Standard deviation of the facets' slope angle, radians; the qualitative form's.
        sigma: Option<f32>,
        /// 0 to 1; the energy-preserving form's.
        roughness: Option<f32>,
    },
    SpecularReflection {
        fresnel: Fresnel,
    },
    SpecularTransmission {
        eta: f32,
    },
    Dielectric {
        eta: f32,
        distribution: Option<Distribution>,
    },
    Conductor {
        conductor: Conductor,
        distribution: Option<Distribution>,
    },
    TorranceSparrow {
        fresnel: Fresnel,
        distribution: Distribution,
        /// The distribution's natural one by default: V-cavity for Blinn and Ashikhmin-Shirley,
        /// Smith for Beckmann and GGX.
        masking: Option<Masking>,
        /// Factor on the lobe, white by default.
        reflectance: Option<[f32; 3]>,
    },
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OrenNayarForm {
    Qualitative,
    #[default]
    EnergyPreserving,
}

/// How much a facet reflects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fresnel {
    Constant([f32; 3]),
    Dielectric { eta: f32 },
    Conductor(Conductor),
}

/// A metal's complex index of refraction, by name or by value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Conductor {
    pub metal: Option<String>,
    pub eta: Option<[f32; 3]>,
    pub k: Option<[f32; 3]>,
    #[serde(default)]
    pub form: ConductorForm,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ConductorForm {
    #[default]
    Exact,
    Approximate,
}

/// The distribution of the facets' normals, tagged by `name`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "name", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Distribution {
    Blinn { exponent: f32 },
    AshikhminShirley { exponent: [f32; 2] },
    Beckmann { alpha: Alpha },
    Ggx { alpha: Alpha },
}

/// One number, or one along the tangent and one across it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Alpha {
    Isotropic(f32),
    Anisotropic([f32; 2]),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Masking {
    None,
    VCavity,
    Smith,
}
