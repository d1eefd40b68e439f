//! What a material is at one point of a surface: its reflection model after texturing, its emission.

use super::bsdf::Bsdf;
use super::math::sqr;
use super::surface::{Surface, texcoord};
use super::texture::texture_sample;
use crate::pack::Packed;
use crate::shared::{
    BSDF_GLTF, BSDF_UNLIT, GLTF_INSIDE, GLTF_THIN_WALLED, GLTF_TRANSMISSIVE, MATERIAL_DOUBLE_SIDED,
    MATERIAL_SPECULAR_GLOSSINESS, MATERIAL_THIN_WALLED, MATERIAL_TRANSMISSIVE, Material, NONE,
    Texture,
};
use glam::{DVec2, DVec3, DVec4, Vec2, Vec3, Vec4};

/// What textures say of a material at one point: factors on its parameters.
#[derive(Clone, Copy, Debug)]
pub struct Texels {
    /// Of vertex colour, too.
    pub base_color: DVec3,
    pub metallic: f64,
    pub roughness: f64,
    pub transmission: f64,
    pub diffuse_transmission: f64,
    pub specular: f64,
    pub diffuse_transmission_color: DVec3,
    pub glossiness: f64,
    pub specular_color: DVec3,
    pub coat: f64,
    pub sheen_color: DVec3,
    pub coat_roughness: f64,
    pub sheen_roughness: f64,
    pub iridescence: f64,
    /// 0: the least, 1: the greatest.
    pub film_thickness: f64,
    pub anisotropy: f64,
    /// Along tangent and bitangent, unit length.
    pub anisotropy_direction: DVec2,
}

/// Where there are no textures.
pub fn white_texels() -> Texels {
    Texels {
        base_color: DVec3::ONE,
        metallic: 1.0,
        roughness: 1.0,
        transmission: 1.0,
        diffuse_transmission: 1.0,
        specular: 1.0,
        diffuse_transmission_color: DVec3::ONE,
        glossiness: 1.0,
        specular_color: DVec3::ONE,
        coat: 1.0,
        sheen_color: DVec3::ONE,
        coat_roughness: 1.0,
        sheen_roughness: 1.0,
        iridescence: 1.0,
        film_thickness: 1.0,
        anisotropy: 1.0,
        anisotropy_direction: DVec2::X,
    }
}

/// A texture of the material at the surface.
pub fn texture_at(packed: &Packed, texture: &Texture, surface: &Surface) -> DVec4 {
    // Most have none, and its coordinates need not be read.
    if texture.texels == NONE {
        return DVec4::ONE;
    }
    texture_sample(packed, texture, texcoord(packed, surface, texture.texcoord))
}

/// Base colour: factor, texture and vertex colour (glTF 2.0 section 3.9.2).
pub fn base_color_at(packed: &Packed, material: &Material, surface: &Surface) -> DVec4 {
    Vec4::from_array(material.base_color).as_dvec4() * base_color_texel(packed, material, surface)
}

/// Without the factor.
pub fn base_color_texel(packed: &Packed, material: &Material, surface: &Surface) -> DVec4 {
    surface.color * texture_at(packed, &material.base_color_texture, surface)
}

/// The channels are those that glTF and each extension give to a parameter.
pub fn texels_at(packed: &Packed, material: &Material, surface: &Surface) -> Texels {
    let at = |texture: &Texture| texture_at(packed, texture, surface);
    let metallic_roughness = at(&material.metallic_roughness_texture);
    let specular_color = at(&material.specular_color_texture);
    let mut texels = Texels {
        base_color: base_color_texel(packed, material, surface).truncate(),
        metallic: metallic_roughness.z,
        roughness: metallic_roughness.y,
        transmission: at(&material.transmission_texture).x,
        diffuse_transmission: at(&material.diffuse_transmission_texture).w,
        specular: at(&material.specular_texture).w,
        diffuse_transmission_color: at(&material.diffuse_transmission_color_texture).truncate(),
        glossiness: specular_color.w,
        specular_color: specular_color.truncate(),
        coat: at(&material.coat_texture).x,
        sheen_color: at(&material.sheen_color_texture).truncate(),
        coat_roughness: at(&material.coat_roughness_texture).y,
        sheen_roughness: at(&material.sheen_roughness_texture).w,
        iridescence: at(&material.iridescence_texture).x,
        film_thickness: at(&material.film_thickness_texture).y,
        ..white_texels()
    };
    if material.anisotropy_texture.texels != NONE {
        let texel = at(&material.anisotropy_texture);
        texels.anisotropy_direction = direction_from_texel(DVec2::new(texel.x, texel.y));
        texels.anisotropy = texel.z;
    }
    texels
}

/// KHR_materials_anisotropy: 0 to 1 stands for -1 to 1. What has no direction gets the tangent's.
pub fn direction_from_texel(texel: DVec2) -> DVec2 {
    let direction = 2.0 * texel - 1.0;
    let norm = direction.length();
    if norm == 0.0 {
        return DVec2::X;
    }
    direction / norm
}

/// The reflection model in the surface's shading frame. `eta`: index of refraction beyond the surface over
/// the index on wo's side, for the dielectrics among the models.
pub fn bsdf_at(packed: &Packed, material: &Material, surface: &Surface, eta: f64) -> Bsdf {
    let mut bsdf = bsdf_of(material, &texels_at(packed, material, surface), eta);
    bsdf.gltf.rotation.y *= surface.bitangent_sign;
    bsdf.gltf.coat_normal = surface.coat_normal;
    if !surface.front && material.flags & MATERIAL_TRANSMISSIVE != 0 {
        bsdf.gltf.flags |= GLTF_INSIDE;
    }
    bsdf
}

/// The same for given values of what textures vary, seen from the front, whose bitangent is the frame's.
pub fn bsdf_of(material: &Material, texels: &Texels, eta: f64) -> Bsdf {
    let mut bsdf = Bsdf {
        reflectance: Vec4::from_array(material.base_color).truncate().as_dvec3()
            * texels.base_color,
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
        return gltf_of(bsdf, material, texels, eta);
    }
    if material.model == BSDF_UNLIT {
        bsdf.reflectance = DVec3::ZERO;
    } else if material.flags & MATERIAL_TRANSMISSIVE != 0 {
        bsdf.eta = DVec3::splat(eta);
    }
    bsdf
}

/// glTF 2.0 appendix B.3, a dielectric and a metal, mixed, and the KHR_materials extensions.
pub fn gltf_of(base: Bsdf, material: &Material, texels: &Texels, eta: f64) -> Bsdf {
    let vector = |v: [f32; 3]| Vec3::from_array(v).as_dvec3();
    let mut bsdf = base;
    bsdf.eta = DVec3::splat(eta);
    bsdf.roughness = f64::from(material.roughness) * texels.roughness;
    bsdf.gltf.metallic = f64::from(material.metallic) * texels.metallic;
    // KHR_materials_specular, section "Implementation"; its colour may exceed 1, F0 not.
    let specular = f64::from(material.specular) * texels.specular;
    let specular_color = vector(material.specular_color) * texels.specular_color;
    bsdf.gltf.F0 = (sqr((eta - 1.0) / (eta + 1.0)) * specular_color).min(DVec3::ONE) * specular;
    bsdf.gltf.F90 = specular;
    if material.flags & MATERIAL_SPECULAR_GLOSSINESS != 0 {
        bsdf.reflectance *= 1.0 - specular_color.max_element();
        bsdf.roughness = 1.0 - f64::from(material.roughness) * texels.glossiness;
        bsdf.gltf.F0 = specular_color;
        bsdf.gltf.F90 = 1.0;
    }
    // KHR_materials_anisotropy, "Anisotropy"; the rotation comes after the texture's direction.
    let alpha = sqr(bsdf.roughness);
    let share = sqr(f64::from(material.anisotropy) * texels.anisotropy);
    bsdf.alpha = DVec2::new(alpha * (1.0 - share) + share, alpha);
    let turn = Vec2::from_array(material.anisotropy_rotation).as_dvec2();
    bsdf.gltf.rotation = turn.rotate(texels.anisotropy_direction);

    bsdf.gltf.transmission = f64::from(material.transmission) * texels.transmission;
    bsdf.gltf.diffuse_transmission =
        f64::from(material.diffuse_transmission) * texels.diffuse_transmission;
    bsdf.gltf.diffuse_transmission_color =
        vector(material.diffuse_transmission_color) * texels.diffuse_transmission_color;
    bsdf.gltf.sheen_color = vector(material.sheen_color) * texels.sheen_color;
    bsdf.gltf.sheen_roughness = f64::from(material.sheen_roughness) * texels.sheen_roughness;
    bsdf.gltf.coat_normal = DVec3::Z;
    bsdf.gltf.coat = f64::from(material.coat) * texels.coat;
    bsdf.gltf.coat_roughness = f64::from(material.coat_roughness) * texels.coat_roughness;
    bsdf.gltf.iridescence = f64::from(material.iridescence) * texels.iridescence;
    bsdf.gltf.film_ior = f64::from(material.film_ior);
    let [least, greatest] = material.film_thickness.map(f64::from);
    bsdf.gltf.film_thickness =
        least * (1.0 - texels.film_thickness) + greatest * texels.film_thickness;
    // By the factor: the surface is one dielectric, however its texture covers it.
    if material.transmission > 0.0 {
        bsdf.gltf.flags |= GLTF_TRANSMISSIVE;
    }
    if material.flags & MATERIAL_THIN_WALLED != 0 {
        bsdf.gltf.flags |= GLTF_THIN_WALLED;
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
