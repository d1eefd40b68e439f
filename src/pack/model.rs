//! The lecture's models as the kernels' numbers: `SNELL_materials_bsdf` to `shared::Material`.

use crate::scene::bsdf_model::{
    Alpha, BsdfModel, Conductor, ConductorForm, Distribution, Fresnel, Masking, OrenNayarForm,
};
use crate::scene::metals;
use crate::shared::*;

/// What is wrong with a model's parameters.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    #[error("`{name}` is {value}, but must be {range}")]
    Range {
        name: &'static str,
        value: f32,
        range: &'static str,
    },
    #[error("form `{form}` of oren-nayar takes `{takes}`, which is missing")]
    Missing {
        form: &'static str,
        takes: &'static str,
    },
    #[error("form `{form}` of oren-nayar takes `{takes}`, not `{found}`")]
    Foreign {
        form: &'static str,
        takes: &'static str,
        found: &'static str,
    },
    #[error("no metal `{0}` is known; give `eta` and `k`, or one of {known}", known = known_metals())]
    Metal(String),
    #[error("a conductor is given by `metal`, or by both `eta` and `k`")]
    Conductor,
}

fn known_metals() -> String {
    metals::METALS.map(|metal| metal.symbol).join(", ")
}

/// Checks a model and writes it over a material: everything but base colour's alpha, emission,
/// textures and flags, of which it only ever sets `MATERIAL_TRANSMISSIVE`.
pub fn lower_bsdf(model: &BsdfModel, into: &mut Material) -> Result<(), ModelError> {
    let mut reflectance = [1.0; 3];
    match model {
        BsdfModel::Lambertian {
            reflectance: albedo,
        } => {
            into.model = BSDF_LAMBERTIAN;
            reflectance = *albedo;
        }
        BsdfModel::OrenNayar {
            reflectance: albedo,
            form,
            sigma,
            roughness,
        } => {
            (into.model, into.roughness) = lower_oren_nayar(*form, *sigma, *roughness)?;
            reflectance = *albedo;
        }
        BsdfModel::SpecularReflection { fresnel } => {
            into.model = BSDF_SPECULAR_REFLECTION;
            lower_fresnel(fresnel, into)?;
        }
        BsdfModel::SpecularTransmission { eta } => {
            into.model = BSDF_SPECULAR_TRANSMISSION;
            lower_fresnel(&Fresnel::Dielectric { eta: *eta }, into)?;
            into.flags |= MATERIAL_TRANSMISSIVE;
        }
        BsdfModel::Dielectric { eta, distribution } => {
            into.model = BSDF_DIELECTRIC;
            lower_fresnel(&Fresnel::Dielectric { eta: *eta }, into)?;
            if let Some(distribution) = distribution {
                into.model = BSDF_ROUGH_DIELECTRIC;
                lower_distribution(distribution, None, into)?;
            }
            into.flags |= MATERIAL_TRANSMISSIVE;
        }
        BsdfModel::Conductor {
            conductor,
            distribution,
        } => {
            into.model = BSDF_SPECULAR_REFLECTION;
            lower_fresnel(&Fresnel::Conductor(conductor.clone()), into)?;
            if let Some(distribution) = distribution {
                into.model = BSDF_TORRANCE_SPARROW;
                lower_distribution(distribution, None, into)?;
            }
        }
        BsdfModel::TorranceSparrow {
            fresnel,
            distribution,
            masking,
            reflectance: factor,
        } => {
            into.model = BSDF_TORRANCE_SPARROW;
            lower_fresnel(fresnel, into)?;
            lower_distribution(distribution, *masking, into)?;
            reflectance = factor.unwrap_or(reflectance);
        }
    }
    check_all("reflectance", &reflectance, 0.0..=1.0, "from 0 to 1")?;
    into.base_color[..3].copy_from_slice(&reflectance);
    Ok(())
}

fn lower_oren_nayar(
    form: OrenNayarForm,
    sigma: Option<f32>,
    roughness: Option<f32>,
) -> Result<(u32, f32), ModelError> {
    let (model, form, takes, given, found, other) = match form {
        OrenNayarForm::Qualitative => {
            let names = ("qualitative", "sigma");
            (
                BSDF_OREN_NAYAR,
                names.0,
                names.1,
                sigma,
                "roughness",
                roughness,
            )
        }
        OrenNayarForm::EnergyPreserving => {
            let names = ("energy-preserving", "roughness");
            (
                BSDF_OREN_NAYAR_EON,
                names.0,
                names.1,
                roughness,
                "sigma",
                sigma,
            )
        }
    };
    if other.is_some() {
        return Err(ModelError::Foreign { form, takes, found });
    }
    let value = given.ok_or(ModelError::Missing { form, takes })?;
    if model == BSDF_OREN_NAYAR {
        check(takes, value, 0.0..=f32::MAX, "0 or more (radians)")?;
    } else {
        check(takes, value, 0.0..=1.0, "from 0 to 1")?;
    }
    Ok((model, value))
}

/// Checks a Fresnel term and writes it over a material.
pub fn lower_fresnel(fresnel: &Fresnel, into: &mut Material) -> Result<(), ModelError> {
    into.k = [0.0; 3];
    match fresnel {
        Fresnel::Constant(reflectance) => {
            check_all("constant", reflectance, 0.0..=1.0, "from 0 to 1")?;
            into.fresnel = FRESNEL_CONSTANT;
            into.eta = *reflectance;
        }
        Fresnel::Dielectric { eta } => {
            check_eta(&[*eta])?;
            into.fresnel = FRESNEL_DIELECTRIC;
            into.ior = *eta;
            into.eta = [*eta; 3];
        }
        Fresnel::Conductor(conductor) => {
            into.fresnel = match conductor.form {
                ConductorForm::Exact => FRESNEL_CONDUCTOR,
                ConductorForm::Approximate => FRESNEL_CONDUCTOR_APPROXIMATE,
            };
            (into.eta, into.k) = lower_conductor(conductor)?;
        }
    }
    Ok(())
}

/// Index and extinction of a conductor, from its name or as given.
fn lower_conductor(conductor: &Conductor) -> Result<([f32; 3], [f32; 3]), ModelError> {
    match (&conductor.metal, conductor.eta, conductor.k) {
        (Some(symbol), None, None) => {
            let metal = metals::metal(symbol).ok_or_else(|| ModelError::Metal(symbol.clone()))?;
            let [eta, k] = metal.index();
            Ok((eta, k))
        }
        (None, Some(eta), Some(k)) => {
            check_eta(&eta)?;
            check_all("k", &k, 0.0..=f32::MAX, "0 or more")?;
            Ok((eta, k))
        }
        _ => Err(ModelError::Conductor),
    }
}

fn lower_distribution(
    distribution: &Distribution,
    masking: Option<Masking>,
    into: &mut Material,
) -> Result<(), ModelError> {
    let natural;
    (into.distribution, into.alpha, natural) = match *distribution {
        Distribution::Blinn { exponent } => (DISTRIBUTION_BLINN, [exponent; 2], MASKING_V_CAVITY),
        Distribution::AshikhminShirley { exponent } => {
            (DISTRIBUTION_ASHIKHMIN_SHIRLEY, exponent, MASKING_V_CAVITY)
        }
        Distribution::Beckmann { alpha } => (DISTRIBUTION_BECKMANN, pair(alpha), MASKING_SMITH),
        Distribution::Ggx { alpha } => (DISTRIBUTION_GGX, pair(alpha), MASKING_SMITH),
    };
    match *distribution {
        Distribution::Blinn { .. } | Distribution::AshikhminShirley { .. } => {
            check_all("exponent", &into.alpha, 0.0..=f32::MAX, "0 or more")?;
        }
        Distribution::Beckmann { .. } | Distribution::Ggx { .. } => {
            let range = f32::MIN_POSITIVE..=f32::MAX;
            check_all("alpha", &into.alpha, range, "greater than 0")?;
        }
    }
    into.masking = match masking {
        None => natural,
        Some(Masking::None) => MASKING_NONE,
        Some(Masking::VCavity) => MASKING_V_CAVITY,
        Some(Masking::Smith) => MASKING_SMITH,
    };
    Ok(())
}

fn pair(alpha: Alpha) -> [f32; 2] {
    match alpha {
        Alpha::Isotropic(alpha) => [alpha; 2],
        Alpha::Anisotropic(alpha) => alpha,
    }
}

fn check_eta(eta: &[f32]) -> Result<(), ModelError> {
    check_all("eta", eta, f32::MIN_POSITIVE..=f32::MAX, "greater than 0")
}

fn check_all(
    name: &'static str,
    values: &[f32],
    range: std::ops::RangeInclusive<f32>,
    said: &'static str,
) -> Result<(), ModelError> {
    values
        .iter()
        .try_for_each(|&value| check(name, value, range.clone(), said))
}

/// The range's ends are finite, so that infinities and NaN are outside it.
fn check(
    name: &'static str,
    value: f32,
    range: std::ops::RangeInclusive<f32>,
    said: &'static str,
) -> Result<(), ModelError> {
    if range.contains(&value) {
        Ok(())
    } else {
        Err(ModelError::Range {
            name,
            value,
            range: said,
        })
    }
}
