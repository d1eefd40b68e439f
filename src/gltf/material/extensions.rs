//! KHR_materials_*: the parameters that extensions add to metallic-roughness.

use super::super::error::GltfError;
use super::super::json::Json;
use super::factor::{at_least, color, known_keys, strength};
use super::{DEFAULT_IOR, Policy, normal_texture, texture};
use crate::scene::extensions::{
    Anisotropy, Clearcoat, DiffuseTransmission, Iridescence, Sheen, Specular, Volume,
};
use crate::scene::{Extensions, Textured};
use glam::Vec3;

/// What `extensions` and `ior` read.
pub const EXTENSIONS: [&str; 10] = [
    "KHR_materials_ior",
    "KHR_materials_transmission",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_volume",
    "KHR_materials_dispersion",
    "KHR_materials_specular",
    "KHR_materials_clearcoat",
    "KHR_materials_sheen",
    "KHR_materials_anisotropy",
    "KHR_materials_iridescence",
];

/// Beyond it a dielectric reflects all but a millionth, and squares of indices leave float32.
const MAX_IOR: f32 = 1e6;

/// Nanometres. Films show no interference from a few micrometres on; a millimetre keeps phases in float32.
const MAX_FILM_THICKNESS: f32 = 1e6;

pub fn extensions<'a>(
    json: &Json<'a>,
    ior: f32,
    policy: &mut dyn Policy<'a>,
) -> Result<Extensions, GltfError> {
    let mut all = Extensions {
        transmission: transmission(json, policy)?,
        diffuse_transmission: diffuse_transmission(json, policy)?,
        volume: volume(json, policy)?,
        dispersion: dispersion(json, policy)?,
        specular: specular(json, policy)?,
        clearcoat: clearcoat(json, policy)?,
        sheen: sheen(json, policy)?,
        anisotropy: anisotropy(json, policy)?,
        iridescence: iridescence(json, policy)?,
    };
    if ior == 0.0 && all.is_transmissive() {
        policy.doubt(
            json,
            "transmission of a material with an ior of 0",
            "is left out: it reflects everything",
        )?;
        all.transmission = Textured::default();
        all.diffuse_transmission = DiffuseTransmission::default();
    }
    Ok(all)
}

/// KHR_materials_ior: 1 or more, or 0 for a surface that reflects everything.
pub fn ior<'a>(json: &Json<'a>, policy: &mut dyn Policy<'a>) -> Result<f32, GltfError> {
    let Some(extension) = read(json, "KHR_materials_ior", &["ior"], policy)? else {
        return Ok(DEFAULT_IOR);
    };
    let ior = extension.number("ior")?.unwrap_or(DEFAULT_IOR);
    if ior != 0.0 && ior < 1.0 {
        return Err(extension.invalid(format!("ior is {ior}; it must be 0 or at least 1")));
    }
    if ior > MAX_IOR {
        policy.doubt(&extension, "an ior of more than a million", "is clamped")?;
    }
    Ok(ior.min(MAX_IOR))
}

fn transmission<'a>(
    json: &Json<'a>,
    policy: &mut dyn Policy<'a>,
) -> Result<Textured<f32>, GltfError> {
    let keys = ["transmissionFactor", "transmissionTexture"];
    let Some(extension) = read(json, "KHR_materials_transmission", &keys, policy)? else {
        return Ok(Textured::default());
    };
    textured_strength(&extension, keys, 0.0, policy)
}

fn diffuse_transmission<'a>(
    json: &Json<'a>,
    policy: &mut dyn Policy<'a>,
) -> Result<DiffuseTransmission, GltfError> {
    let share = ["diffuseTransmissionFactor", "diffuseTransmissionTexture"];
    let color = [
        "diffuseTransmissionColorFactor",
        "diffuseTransmissionColorTexture",
    ];
    let keys = [share, color].concat();
    let Some(extension) = read(json, "KHR_materials_diffuse_transmission", &keys, policy)? else {
        return Ok(DiffuseTransmission::default());
    };
    Ok(DiffuseTransmission {
        share: textured_strength(&extension, share, 0.0, policy)?,
        color: textured_color(&extension, color, 1.0, policy)?,
    })
}

/// A surface with a thickness bounds a medium, and rays find the way through it themselves; without
/// one it is a thin wall, in which nothing is absorbed.
fn volume<'a>(json: &Json<'a>, policy: &mut dyn Policy<'a>) -> Result<Option<Volume>, GltfError> {
    let keys = [
        "thicknessFactor",
        "thicknessTexture",
        "attenuationDistance",
        "attenuationColor",
    ];
    let Some(extension) = read(json, "KHR_materials_volume", &keys, policy)? else {
        return Ok(None);
    };
    let thickness = at_least(&extension, "thicknessFactor", 0.0, 0.0)?;
    let attenuation_distance = extension.number("attenuationDistance")?;
    if let (Some(distance), Some(found)) =
        (attenuation_distance, extension.get("attenuationDistance"))
        && distance <= 0.0
    {
        return Err(found.invalid(format!("it is {distance}; it must be greater than 0")));
    }
    let attenuation_color = color(&extension, "attenuationColor", [1.0; 3], policy)?.into();
    if thickness == 0.0 {
        return Ok(None);
    }
    if let Some(texture) = extension.get("thicknessTexture") {
        policy.doubt(
            &texture,
            "thicknessTexture",
            "is ignored: rays find the true thickness themselves",
        )?;
    }
    Ok(Some(Volume {
        attenuation_color,
        attenuation_distance,
    }))
}

fn dispersion<'a>(json: &Json<'a>, policy: &mut dyn Policy<'a>) -> Result<f32, GltfError> {
    match read(json, "KHR_materials_dispersion", &["dispersion"], policy)? {
        Some(extension) => at_least(&extension, "dispersion", 0.0, 0.0),
        None => Ok(0.0),
    }
}

fn specular<'a>(json: &Json<'a>, policy: &mut dyn Policy<'a>) -> Result<Specular, GltfError> {
    let strength = ["specularFactor", "specularTexture"];
    let color = ["specularColorFactor", "specularColorTexture"];
    let keys = [strength, color].concat();
    let Some(extension) = read(json, "KHR_materials_specular", &keys, policy)? else {
        return Ok(Specular::default());
    };
    let factor: [f32; 3] = extension.vector(color[0])?.unwrap_or([1.0; 3]);
    if let Some(found) = extension.get(color[0])
        && factor.iter().any(|&channel| channel < 0.0)
    {
        return Err(found.invalid("a channel is negative"));
    }
    Ok(Specular {
        strength: textured_strength(&extension, strength, 1.0, policy)?,
        color: Textured {
            factor: factor.into(),
            texture: texture(&extension, color[1], true, policy)?,
        },
    })
}

fn clearcoat<'a>(json: &Json<'a>, policy: &mut dyn Policy<'a>) -> Result<Clearcoat, GltfError> {
    let coat = ["clearcoatFactor", "clearcoatTexture"];
    let roughness = ["clearcoatRoughnessFactor", "clearcoatRoughnessTexture"];
    let keys = [&coat[..], &roughness, &["clearcoatNormalTexture"]].concat();
    let Some(extension) = read(json, "KHR_materials_clearcoat", &keys, policy)? else {
        return Ok(Clearcoat::default());
    };
    let (normal_texture, normal_scale) =
        normal_texture(&extension, "clearcoatNormalTexture", policy)?;
    Ok(Clearcoat {
        coat: textured_strength(&extension, coat, 0.0, policy)?,
        roughness: textured_strength(&extension, roughness, 0.0, policy)?,
        normal_texture,
        normal_scale,
    })
}

fn sheen<'a>(json: &Json<'a>, policy: &mut dyn Policy<'a>) -> Result<Sheen, GltfError> {
    let color = ["sheenColorFactor", "sheenColorTexture"];
    let roughness = ["sheenRoughnessFactor", "sheenRoughnessTexture"];
    let keys = [color, roughness].concat();
    let Some(extension) = read(json, "KHR_materials_sheen", &keys, policy)? else {
        return Ok(Sheen::default());
    };
    Ok(Sheen {
        color: textured_color(&extension, color, 0.0, policy)?,
        roughness: textured_strength(&extension, roughness, 0.0, policy)?,
    })
}

fn anisotropy<'a>(json: &Json<'a>, policy: &mut dyn Policy<'a>) -> Result<Anisotropy, GltfError> {
    let keys = [
        "anisotropyStrength",
        "anisotropyTexture",
        "anisotropyRotation",
    ];
    let Some(extension) = read(json, "KHR_materials_anisotropy", &keys, policy)? else {
        return Ok(Anisotropy::default());
    };
    Ok(Anisotropy {
        strength: textured_strength(&extension, [keys[0], keys[1]], 0.0, policy)?,
        rotation: extension.number(keys[2])?.unwrap_or(0.0),
    })
}

fn iridescence<'a>(json: &Json<'a>, policy: &mut dyn Policy<'a>) -> Result<Iridescence, GltfError> {
    let strength = ["iridescenceFactor", "iridescenceTexture"];
    let thickness = [
        "iridescenceThicknessMinimum",
        "iridescenceThicknessMaximum",
        "iridescenceThicknessTexture",
    ];
    let keys = [&strength[..], &thickness, &["iridescenceIor"]].concat();
    let Some(extension) = read(json, "KHR_materials_iridescence", &keys, policy)? else {
        return Ok(Iridescence::default());
    };
    let default = Iridescence::default();
    let [minimum, maximum] = default.thickness.factor;
    let factor = [
        at_least(&extension, thickness[0], 0.0, minimum)?,
        at_least(&extension, thickness[1], 0.0, maximum)?,
    ];
    if factor
        .iter()
        .any(|&thickness| thickness > MAX_FILM_THICKNESS)
    {
        policy.doubt(&extension, "a film of more than a millimetre", "is thinned")?;
    }
    Ok(Iridescence {
        strength: textured_strength(&extension, strength, 0.0, policy)?,
        film_ior: at_least(&extension, "iridescenceIor", 1.0, default.film_ior)?.min(MAX_IOR),
        thickness: Textured {
            factor: factor.map(|thickness| thickness.min(MAX_FILM_THICKNESS)),
            texture: texture(&extension, thickness[2], false, policy)?,
        },
    })
}

/// An extension of the material, its properties' names checked.
fn read<'a>(
    json: &Json<'a>,
    name: &str,
    keys: &[&str],
    policy: &mut dyn Policy<'a>,
) -> Result<Option<Json<'a>>, GltfError> {
    let extension = json.extension(name)?;
    if let Some(extension) = &extension {
        known_keys(extension, keys, policy)?;
    }
    Ok(extension)
}

/// A factor from 0 to 1 and its texture, not sRGB, by their keys.
fn textured_strength<'a>(
    json: &Json<'a>,
    [factor, texture_key]: [&str; 2],
    default: f32,
    policy: &mut dyn Policy<'a>,
) -> Result<Textured<f32>, GltfError> {
    Ok(Textured {
        factor: strength(json, factor, default, policy)?,
        texture: texture(json, texture_key, false, policy)?,
    })
}

/// A colour of factors from 0 to 1 and its texture, sRGB, by their keys.
fn textured_color<'a>(
    json: &Json<'a>,
    [factor, texture_key]: [&str; 2],
    default: f32,
    policy: &mut dyn Policy<'a>,
) -> Result<Textured<Vec3>, GltfError> {
    Ok(Textured {
        factor: color(json, factor, [default; 3], policy)?.into(),
        texture: texture(json, texture_key, true, policy)?,
    })
}
