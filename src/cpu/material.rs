//! What a material is at one point of a surface: its reflection model after texturing, its emission.

use super::bsdf::Bsdf;
use super::math::sqr;
use super::surface::{Surface, texcoord};
use super::texture::texture_sample;
use crate::pack::Packed;
use crate::shared::{
    BSDF_GLTF, BSDF_UNLIT, MATERIAL_DOUBLE_SIDED, MATERIAL_TRANSMISSIVE, Material, Texture,
};
use glam::{DVec2, DVec3, DVec4, Vec2, Vec3, Vec4};

/// A texture of the material at the surface.
pub fn texture_at(packed: &Packed, texture: &Texture, surface: &Surface) -> DVec4 {
    texture_sample(packed, texture, texcoord(packed, surface, texture.texcoord))
}

/// Base colour: factor, texture and vertex colour (glTF 2.0 section 3.9.2).
pub fn base_color_at(packed: &Packed, material: &Material, surface: &Surface) -> DVec4 {
    Vec4::from_array(material.base_color).as_dvec4()
        * texture_at(packed, &material.base_color_texture, surface)
        * surface.color
}

/// The reflection model in the surface's shading frame. `eta`: index of refraction beyond the surface over
/// the index on wo's side, for the dielectrics among the models.
pub fn bsdf_at(packed: &Packed, material: &Material, surface: &Surface, eta: f64) -> Bsdf {
    let base_color = base_color_at(packed, material, surface).truncate();
    let metallic_roughness = texture_at(packed, &material.metallic_roughness_texture, surface);
    let roughness = f64::from(material.roughness) * metallic_roughness.y;
    let metallic = f64::from(material.metallic) * metallic_roughness.z;
    bsdf_of(material, base_color, metallic, roughness, eta)
}

/// The same for given values of what textures vary.
pub fn bsdf_of(
    material: &Material,
    base_color: DVec3,
    metallic: f64,
    roughness: f64,
    eta: f64,
) -> Bsdf {
    let mut bsdf = Bsdf {
        reflectance: base_color,
        model: material.model,
        eta: Vec3::from_array(material.eta).as_dvec3(),
        fresnel: material.fresnel,
        k: Vec3::from_array(material.k).as_dvec3(),
        distribution: material.distribution,
        alpha: Vec2::from_array(material.alpha).as_dvec2(),
        roughness: f64::from(material.roughness),
        masking: material.masking,
        ..Bsdf::default()
    };
    if material.model == BSDF_GLTF {
        // glTF 2.0 appendix B.3: a dielectric and a metal, mixed.
        bsdf.eta = DVec3::splat(eta);
        bsdf.alpha = DVec2::splat(sqr(roughness));
        bsdf.roughness = roughness;
        bsdf.gltf.F0 = DVec3::splat(sqr((eta - 1.0) / (eta + 1.0)));
        bsdf.gltf.F90 = 1.0;
        bsdf.gltf.metallic = metallic;
        bsdf.gltf.rotation = DVec2::X;
        bsdf.gltf.coat_normal = DVec3::Z;
    } else if material.model == BSDF_UNLIT {
        bsdf.reflectance = DVec3::ZERO;
    } else if material.flags & MATERIAL_TRANSMISSIVE != 0 {
        bsdf.eta = DVec3::splat(eta);
    }
    bsdf
}

/// Radiance that the surface emits towards wo.
pub fn Le_surface(packed: &Packed, material: &Material, surface: &Surface) -> DVec3 {
    if material.model == BSDF_UNLIT {
        return base_color_at(packed, material, surface).truncate();
    }
    // One-sided like the surface itself; a transmissive one is seen from behind and stays dark there.
    if !surface.front && material.flags & MATERIAL_DOUBLE_SIDED == 0 {
        return DVec3::ZERO;
    }
    Vec3::from_array(material.emissive).as_dvec3()
        * texture_at(packed, &material.emissive_texture, surface).truncate()
}
