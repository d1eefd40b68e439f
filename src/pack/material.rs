//! Materials as the kernels take them, textures placed and models lowered.

use super::PackError;
use super::model::lower_bsdf;
use super::texture::Textures;
use crate::scene::{self, AlphaMode, Model};
use crate::shared::{
    BSDF_GLTF, BSDF_UNLIT, DISTRIBUTION_GGX, FRESNEL_SCHLICK, MASKING_SMITH, MATERIAL_ALPHA_BLEND,
    MATERIAL_ALPHA_MASK, MATERIAL_DOUBLE_SIDED, MATERIAL_EMISSIVE, Material,
};
use bytemuck::Zeroable;
use glam::DVec3;

/// Lowers a material. Textures whose images are not in `textures` sample as white, so that a
/// laboratory without images passes none.
pub fn pack_material(
    material: &scene::Material,
    textures: &Textures,
) -> Result<Material, PackError> {
    let none = textures.record(None);
    let mut packed = Material {
        alpha_cutoff: 0.0,
        normal_scale: material.normal_scale,
        ior: 1.0,
        base_color_texture: none,
        metallic_roughness_texture: none,
        normal_texture: textures.record(material.normal_texture.as_ref()),
        emissive_texture: textures.record(material.emissive_texture.as_ref()),
        emissive: material.emissive.to_array(),
        emission_weight: emission_weight(material, textures),
        ..Material::zeroed()
    };
    match &material.model {
        Model::MetallicRoughness(m) => {
            packed.model = BSDF_GLTF;
            packed.base_color = m.base_color.to_array();
            packed.metallic = m.metallic;
            packed.roughness = m.roughness;
            packed.ior = m.ior;
            packed.fresnel = FRESNEL_SCHLICK;
            packed.distribution = DISTRIBUTION_GGX;
            packed.masking = MASKING_SMITH;
            packed.base_color_texture = textures.record(m.base_color_texture.as_ref());
            packed.metallic_roughness_texture =
                textures.record(m.metallic_roughness_texture.as_ref());
        }
        Model::Unlit {
            base_color,
            base_color_texture,
        } => {
            packed.model = BSDF_UNLIT;
            packed.base_color = base_color.to_array();
            packed.base_color_texture = textures.record(base_color_texture.as_ref());
        }
        Model::Bsdf {
            bsdf,
            base_color,
            base_color_texture,
        } => {
            packed.base_color = [1.0; 4];
            lower_bsdf(bsdf, &mut packed).map_err(|source| PackError::Model {
                material: material.name.clone(),
                source,
            })?;
            // The model has a reflectance of its own; base colour's red, green and blue are what viewers
            // that do not know it show instead.
            packed.base_color[3] = base_color.w;
            packed.base_color_texture = textures.record(base_color_texture.as_ref());
        }
    }
    if material.double_sided {
        packed.flags |= MATERIAL_DOUBLE_SIDED;
    }
    match material.alpha_mode {
        AlphaMode::Opaque => {}
        AlphaMode::Mask { cutoff } => {
            packed.flags |= MATERIAL_ALPHA_MASK;
            packed.alpha_cutoff = cutoff;
        }
        AlphaMode::Blend => packed.flags |= MATERIAL_ALPHA_BLEND,
    }
    if packed.emission_weight > 0.0 {
        packed.flags |= MATERIAL_EMISSIVE;
    }
    Ok(packed)
}

/// Mean luminance of the emission, positive wherever any texel emits, so that nothing that a path
/// may find by chance is missing from the table of lights.
///
/// What an unlit material shows is no light: it is a picture, not a source.
fn emission_weight(material: &scene::Material, textures: &Textures) -> f32 {
    const LUMINANCE: DVec3 = DVec3::new(0.2126, 0.7152, 0.0722);
    let mean = textures.mean(material.emissive_texture.as_ref()).truncate();
    let weight = (mean * material.emissive.as_dvec3()).dot(LUMINANCE);
    if weight > 0.0 {
        (weight as f32).max(f32::MIN_POSITIVE)
    } else {
        0.0
    }
}
