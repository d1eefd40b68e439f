//! What the kernels may take for granted of a scene: the values of `shaders/variant.wgsl`.

use super::link::Value;
use crate::pack::Packed;
use crate::shared::{BSDF_UNLIT, LIGHT_PROFILE, MATERIAL_TRANSMISSIVE, Material, NONE, Texture};

/// The constants' values for a scene, by name. Materials that no triangle has do not count.
pub fn constants(packed: &Packed) -> Vec<(&'static str, Value)> {
    let mut used = vec![false; packed.materials.len()];
    for triangle in &packed.triangles {
        used[triangle.material as usize] = true;
    }
    let materials: Vec<&Material> = packed
        .materials
        .iter()
        .zip(used)
        .filter_map(|(material, used)| used.then_some(material))
        .collect();
    let some =
        |test: fn(&Material) -> bool| Value::Bool(materials.iter().any(|material| test(material)));
    let models = materials
        .iter()
        .fold(0, |models, material| models | 1 << material.model);
    // An unlit surface ends its path before any reflection model is asked.
    let common = |value: fn(&Material) -> u32| {
        let mut values = materials
            .iter()
            .filter(|material| material.model != BSDF_UNLIT)
            .map(|material| value(material));
        let first = values.next().unwrap_or(NONE);
        Value::Uint(if values.all(|value| value == first) {
            first
        } else {
            NONE
        })
    };
    vec![
        ("LENS", Value::Bool(packed.frame.camera.lens_radius > 0.0)),
        ("CAMERAS", Value::Uint(1 << packed.frame.camera.kind)),
        (
            "PROFILES",
            Value::Bool(
                packed
                    .lights
                    .iter()
                    .any(|light| light.kind == LIGHT_PROFILE),
            ),
        ),
        ("MOTION", Value::Bool(packed.moves())),
        ("TEST_ALPHA", Value::Bool(packed.frame.has_alpha != 0)),
        ("MEDIA", some(|m| m.flags & MATERIAL_TRANSMISSIVE != 0)),
        ("DISPERSION", some(|m| m.dispersion > 0.0)),
        ("THIN_WALLS", Value::Bool(packed.frame.has_thin_walls != 0)),
        (
            "BASE_COLOR_TEXTURES",
            some(|m| any(&[&m.base_color_texture])),
        ),
        (
            "METALLIC_ROUGHNESS_TEXTURES",
            some(|m| any(&[&m.metallic_roughness_texture])),
        ),
        ("NORMAL_TEXTURES", some(|m| any(&[&m.normal_texture]))),
        ("EMISSIVE_TEXTURES", some(|m| any(&[&m.emissive_texture]))),
        (
            "TRANSMISSION_TEXTURES",
            some(|m| any(&[&m.transmission_texture])),
        ),
        (
            "DIFFUSE_TRANSMISSION_TEXTURES",
            some(|m| {
                any(&[
                    &m.diffuse_transmission_texture,
                    &m.diffuse_transmission_color_texture,
                ])
            }),
        ),
        (
            "SPECULAR_TEXTURES",
            some(|m| any(&[&m.specular_texture, &m.specular_color_texture])),
        ),
        (
            "ANISOTROPY_TEXTURES",
            some(|m| any(&[&m.anisotropy_texture])),
        ),
        (
            "COAT_TEXTURES",
            some(|m| any(&[&m.coat_texture, &m.coat_roughness_texture])),
        ),
        (
            "SHEEN_TEXTURES",
            some(|m| any(&[&m.sheen_color_texture, &m.sheen_roughness_texture])),
        ),
        (
            "IRIDESCENCE_TEXTURES",
            some(|m| any(&[&m.iridescence_texture, &m.film_thickness_texture])),
        ),
        (
            "COAT_NORMALS",
            some(|m| m.coat > 0.0 && any(&[&m.normal_texture, &m.coat_normal_texture])),
        ),
        ("COAT", some(|m| m.coat > 0.0)),
        ("SHEEN", some(|m| m.sheen_color != [0.0; 3])),
        ("TRANSMISSION", some(|m| m.transmission > 0.0)),
        (
            "DIFFUSE_TRANSMISSION",
            some(|m| m.diffuse_transmission > 0.0),
        ),
        ("IRIDESCENCE", some(|m| m.iridescence > 0.0)),
        ("ANISOTROPY", some(|m| m.anisotropy > 0.0)),
        ("MODELS", Value::Uint(models)),
        ("COMMON_MODEL", common(|m| m.model)),
        ("COMMON_FRESNEL", common(|m| m.fresnel)),
        ("COMMON_DISTRIBUTION", common(|m| m.distribution)),
        ("COMMON_MASKING", common(|m| m.masking)),
    ]
}

/// Whether one of the textures is there.
fn any(textures: &[&Texture]) -> bool {
    textures.iter().any(|texture| texture.texels != NONE)
}
