//! Materials as the kernels take them, textures placed and models lowered.

use super::PackError;
use super::model::lower_bsdf;
use super::texture::Textures;
use crate::cpu::bsdf::lobe::ALPHA_SMOOTH;
use crate::scene::{self, AlphaMode, Extensions, Model, Texture};
use crate::shared::{
    BSDF_GLTF, BSDF_LAMBERTIAN, BSDF_OREN_NAYAR, BSDF_OREN_NAYAR_EON, BSDF_UNLIT, CLASS_CLEAR,
    CLASS_DIFFUSE, CLASS_GLASS, CLASS_OPAQUE, CLASS_OTHER, DISTRIBUTION_GGX, FRESNEL_SCHLICK,
    MASKING_SMITH, MATERIAL_ALPHA_BLEND, MATERIAL_ALPHA_MASK, MATERIAL_DOUBLE_SIDED,
    MATERIAL_EMISSIVE, MATERIAL_SPECULAR_GLOSSINESS, MATERIAL_THIN_WALLED, MATERIAL_TRANSMISSIVE,
    Material, NONE, TRIANGLE_ALPHA, TRIANGLE_CULLED,
};
use bytemuck::Zeroable;
use glam::DVec3;

/// Lowers a material. Textures whose images are not in `textures` sample as white, so that a
/// laboratory without images passes none.
pub fn pack_material(
    material: &scene::Material,
    textures: &Textures,
) -> Result<Material, PackError> {
    let mut packed = Material {
        alpha_cutoff: 0.0,
        normal_scale: material.normal_scale,
        ior: 1.0,
        normal_texture: textures.record(material.normal_texture.as_ref()),
        emissive_texture: textures.record(material.emissive_texture.as_ref()),
        emissive: material.emissive.to_array(),
        emission_weight: emission_weight(material, textures),
        ..untextured()
    };
    match &material.model {
        Model::MetallicRoughness(m) => {
            lower_gltf(&m.extensions, textures, &mut packed);
            packed.base_color = m.base_color.to_array();
            packed.metallic = m.metallic;
            packed.roughness = m.roughness;
            packed.ior = m.ior;
            packed.base_color_texture = textures.record(m.base_color_texture.as_ref());
            packed.metallic_roughness_texture =
                textures.record(m.metallic_roughness_texture.as_ref());
        }
        Model::SpecularGlossiness(m) => {
            lower_gltf(&Extensions::default(), textures, &mut packed);
            packed.flags |= MATERIAL_SPECULAR_GLOSSINESS;
            packed.base_color = m.diffuse.factor.to_array();
            packed.specular_color = m.specular.factor.to_array();
            packed.roughness = m.glossiness;
            packed.ior = SPECULAR_GLOSSINESS_IOR;
            packed.base_color_texture = textures.record(m.diffuse.texture.as_ref());
            packed.specular_color_texture = textures.record(m.specular.texture.as_ref());
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
    if is_lambertian(&packed) {
        packed.model = BSDF_LAMBERTIAN;
    }
    if packed.emission_weight > 0.0 {
        packed.flags |= MATERIAL_EMISSIVE;
    }
    Ok(packed)
}

/// Whether glTF's material is its diffuse part alone: no metal, and a dielectric that reflects nothing. Its
/// function is Lambert's then, at a small part of the work.
fn is_lambertian(material: &Material) -> bool {
    shading_class(material) == CLASS_OPAQUE
        && material.flags & MATERIAL_SPECULAR_GLOSSINESS == 0
        && material.metallic == 0.0
        && material.specular == 0.0
}

/// `Triangle.flags` of all that have this material.
pub fn triangle_flags(material: &Material) -> u32 {
    // glTF 2.0 section 3.9.6: back faces are culled unless double-sided. What light goes through has
    // to be met from inside as well.
    let culled = material.flags & (MATERIAL_DOUBLE_SIDED | MATERIAL_TRANSMISSIVE) == 0;
    let alpha = material.flags & (MATERIAL_ALPHA_MASK | MATERIAL_ALPHA_BLEND) != 0;
    shading_class(material)
        | if culled { TRIANGLE_CULLED } else { 0 }
        | if alpha { TRIANGLE_ALPHA } else { 0 }
}

/// One of `CLASS_*`.
pub fn shading_class(material: &Material) -> u32 {
    match material.model {
        BSDF_LAMBERTIAN | BSDF_OREN_NAYAR | BSDF_OREN_NAYAR_EON | BSDF_UNLIT => CLASS_DIFFUSE,
        BSDF_GLTF if has_further_lobes(material) => CLASS_OTHER,
        BSDF_GLTF if is_clear(material) => CLASS_CLEAR,
        BSDF_GLTF if material.transmission > 0.0 => match material.metallic {
            0.0 => CLASS_GLASS,
            _ => CLASS_OTHER,
        },
        BSDF_GLTF => CLASS_OPAQUE,
        _ => CLASS_OTHER,
    }
}

/// Whether glTF's material is a smooth boundary and nothing else, wherever it is seen: no metal, nothing diffuse
/// and no facets whose roughness is near the limit.
fn is_clear(material: &Material) -> bool {
    material.transmission == 1.0
        && material.transmission_texture.texels == NONE
        && material.metallic == 0.0
        && material.ior > 0.0
        && material.roughness.powi(2) < 0.99 * ALPHA_SMOOTH as f32
}

/// Whether glTF's material has more than a base that reflects, is diffuse or transmits.
fn has_further_lobes(material: &Material) -> bool {
    let factors = [
        material.diffuse_transmission,
        material.coat,
        material.iridescence,
        material.anisotropy,
    ];
    factors != [0.0; 4] || material.sheen_color != [0.0; 3]
}

/// The index of glTF's dielectrics. Specular-glossiness has none of its own: its F0 is all that its
/// reflection asks for.
const SPECULAR_GLOSSINESS_IOR: f32 = 1.5;

/// Zeros, without textures.
fn untextured() -> Material {
    let none = Textures::default().record(None);
    Material {
        base_color_texture: none,
        metallic_roughness_texture: none,
        normal_texture: none,
        emissive_texture: none,
        transmission_texture: none,
        diffuse_transmission_texture: none,
        diffuse_transmission_color_texture: none,
        specular_texture: none,
        specular_color_texture: none,
        anisotropy_texture: none,
        coat_texture: none,
        coat_roughness_texture: none,
        coat_normal_texture: none,
        sheen_color_texture: none,
        sheen_roughness_texture: none,
        iridescence_texture: none,
        film_thickness_texture: none,
        ..Material::zeroed()
    }
}

/// The model of glTF with its extensions, neutral ones too.
fn lower_gltf(extensions: &Extensions, textures: &Textures, into: &mut Material) {
    into.model = BSDF_GLTF;
    into.fresnel = FRESNEL_SCHLICK;
    into.distribution = DISTRIBUTION_GGX;
    into.masking = MASKING_SMITH;
    let place = |texture: &Option<Texture>| textures.record(texture.as_ref());
    let Extensions {
        transmission,
        diffuse_transmission,
        volume,
        dispersion,
        specular,
        clearcoat,
        sheen,
        anisotropy,
        iridescence,
    } = extensions;
    into.transmission = transmission.factor;
    into.transmission_texture = place(&transmission.texture);
    into.diffuse_transmission = diffuse_transmission.share.factor;
    into.diffuse_transmission_texture = place(&diffuse_transmission.share.texture);
    into.diffuse_transmission_color = diffuse_transmission.color.factor.to_array();
    into.diffuse_transmission_color_texture = place(&diffuse_transmission.color.texture);
    match volume {
        _ if !extensions.is_transmissive() => {}
        Some(volume) => {
            into.flags |= MATERIAL_TRANSMISSIVE;
            into.absorption = volume.absorption().to_array();
            into.dispersion = *dispersion;
        }
        // Nothing is between the two sides of a wall: its colours neither part nor fade.
        None => into.flags |= MATERIAL_THIN_WALLED,
    }
    into.specular = specular.strength.factor;
    into.specular_texture = place(&specular.strength.texture);
    into.specular_color = specular.color.factor.to_array();
    into.specular_color_texture = place(&specular.color.texture);
    into.coat = clearcoat.coat.factor;
    into.coat_texture = place(&clearcoat.coat.texture);
    into.coat_roughness = clearcoat.roughness.factor;
    into.coat_roughness_texture = place(&clearcoat.roughness.texture);
    into.coat_normal_texture = place(&clearcoat.normal_texture);
    into.coat_normal_scale = clearcoat.normal_scale;
    into.sheen_color = sheen.color.factor.to_array();
    into.sheen_color_texture = place(&sheen.color.texture);
    into.sheen_roughness = sheen.roughness.factor;
    into.sheen_roughness_texture = place(&sheen.roughness.texture);
    into.anisotropy = anisotropy.strength.factor;
    into.anisotropy_texture = place(&anisotropy.strength.texture);
    let (sin, cos) = f64::from(anisotropy.rotation).sin_cos();
    into.anisotropy_rotation = [cos as f32, sin as f32];
    into.iridescence = iridescence.strength.factor;
    into.iridescence_texture = place(&iridescence.strength.texture);
    into.film_ior = iridescence.film_ior;
    into.film_thickness = iridescence.thickness.factor;
    into.film_thickness_texture = place(&iridescence.thickness.texture);
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
