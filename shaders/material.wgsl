// What a material is at one point of a surface: its reflection model after texturing, its emission.

import package::shared::{Material, Bsdf, Texture, NONE, BSDF_GLTF, BSDF_UNLIT, MATERIAL_DOUBLE_SIDED, MATERIAL_TRANSMISSIVE, MATERIAL_THIN_WALLED, MATERIAL_SPECULAR_GLOSSINESS, GLTF_TRANSMISSIVE, GLTF_THIN_WALLED, GLTF_INSIDE};
import package::math::{sqr};
import package::surface::{Surface, texcoord};
import package::texture::{texture_sample};
import package::variant::{BASE_COLOR_TEXTURES, METALLIC_ROUGHNESS_TEXTURES, EMISSIVE_TEXTURES, TRANSMISSION_TEXTURES, DIFFUSE_TRANSMISSION_TEXTURES, SPECULAR_TEXTURES, ANISOTROPY_TEXTURES, COAT_TEXTURES, SHEEN_TEXTURES, IRIDESCENCE_TEXTURES, COMMON_MODEL, COMMON_FRESNEL, COMMON_DISTRIBUTION, COMMON_MASKING};

// What textures say of a material at one point: factors on its parameters.
struct Texels {
    base_color: vec3<f32>,     // of vertex colour, too
    metallic: f32,
    roughness: f32,
    transmission: f32,
    diffuse_transmission: f32,
    specular: f32,
    diffuse_transmission_color: vec3<f32>,
    glossiness: f32,
    specular_color: vec3<f32>,
    coat: f32,
    sheen_color: vec3<f32>,
    coat_roughness: f32,
    sheen_roughness: f32,
    iridescence: f32,
    film_thickness: f32,       // 0: the least, 1: the greatest
    anisotropy: f32,
    anisotropy_direction: vec2<f32>, // along tangent and bitangent, unit length
}

// Where there are no textures.
fn white_texels() -> Texels {
    var texels: Texels;
    texels.base_color = vec3<f32>(1.0);
    texels.metallic = 1.0;
    texels.roughness = 1.0;
    texels.transmission = 1.0;
    texels.diffuse_transmission = 1.0;
    texels.specular = 1.0;
    texels.diffuse_transmission_color = vec3<f32>(1.0);
    texels.glossiness = 1.0;
    texels.specular_color = vec3<f32>(1.0);
    texels.coat = 1.0;
    texels.sheen_color = vec3<f32>(1.0);
    texels.coat_roughness = 1.0;
    texels.sheen_roughness = 1.0;
    texels.iridescence = 1.0;
    texels.film_thickness = 1.0;
    texels.anisotropy = 1.0;
    texels.anisotropy_direction = vec2<f32>(1.0, 0.0);
    return texels;
}

// A texture of the material at the surface.
fn texture_at(texture: Texture, surface: Surface) -> vec4<f32> {
    return texture_sample(texture, texcoord(surface, texture.texcoord));
}

// Base colour: factor, texture and vertex colour (glTF 2.0 section 3.9.2).
fn base_color_at(material: Material, surface: Surface) -> vec4<f32> {
    return material.base_color * base_color_texel(material, surface);
}

// Without the factor.
fn base_color_texel(material: Material, surface: Surface) -> vec4<f32> {
    if BASE_COLOR_TEXTURES {
        return surface.color * texture_at(material.base_color_texture, surface);
    }
    return surface.color;
}

// The channels are those that glTF and each extension give to a parameter.
fn texels_at(material: Material, surface: Surface) -> Texels {
    var texels = white_texels();
    texels.base_color = base_color_texel(material, surface).rgb;
    if METALLIC_ROUGHNESS_TEXTURES {
        let metallic_roughness = texture_at(material.metallic_roughness_texture, surface);
        texels.roughness = metallic_roughness.g;
        texels.metallic = metallic_roughness.b;
    }
    if TRANSMISSION_TEXTURES {
        texels.transmission = texture_at(material.transmission_texture, surface).r;
    }
    if DIFFUSE_TRANSMISSION_TEXTURES {
        texels.diffuse_transmission = texture_at(material.diffuse_transmission_texture, surface).a;
        texels.diffuse_transmission_color = texture_at(material.diffuse_transmission_color_texture, surface).rgb;
    }
    if SPECULAR_TEXTURES {
        let specular_color = texture_at(material.specular_color_texture, surface);
        texels.specular = texture_at(material.specular_texture, surface).a;
        texels.specular_color = specular_color.rgb;
        texels.glossiness = specular_color.a;
    }
    if ANISOTROPY_TEXTURES && material.anisotropy_texture.texels != NONE {
        let texel = texture_at(material.anisotropy_texture, surface);
        texels.anisotropy_direction = direction_from_texel(texel.rg);
        texels.anisotropy = texel.b;
    }
    if COAT_TEXTURES {
        texels.coat = texture_at(material.coat_texture, surface).r;
        texels.coat_roughness = texture_at(material.coat_roughness_texture, surface).g;
    }
    if SHEEN_TEXTURES {
        texels.sheen_color = texture_at(material.sheen_color_texture, surface).rgb;
        texels.sheen_roughness = texture_at(material.sheen_roughness_texture, surface).a;
    }
    if IRIDESCENCE_TEXTURES {
        texels.iridescence = texture_at(material.iridescence_texture, surface).r;
        texels.film_thickness = texture_at(material.film_thickness_texture, surface).g;
    }
    return texels;
}

// KHR_materials_anisotropy: 0 to 1 stands for -1 to 1. What has no direction gets the tangent's.
fn direction_from_texel(texel: vec2<f32>) -> vec2<f32> {
    let direction = 2.0 * texel - 1.0;
    let norm = sqrt(dot(direction, direction));
    if norm == 0.0 {
        return vec2<f32>(1.0, 0.0);
    }
    return direction / norm;
}

// The reflection model in the surface's shading frame. `eta`: index of refraction beyond the surface over
// the index on wo's side, for the dielectrics among the models.
fn bsdf_at(material: Material, surface: Surface, eta: f32) -> Bsdf {
    var bsdf = bsdf_of(material, texels_at(material, surface), eta);
    bsdf.gltf.rotation.y *= surface.bitangent_sign;
    bsdf.gltf.coat_normal = surface.coat_normal;
    if surface.front == 0u && (material.flags & MATERIAL_TRANSMISSIVE) != 0u {
        bsdf.gltf.flags |= GLTF_INSIDE;
    }
    // Nothing new to the reflection functions, but constants to the compiler.
    bsdf.model = select(COMMON_MODEL, bsdf.model, COMMON_MODEL == NONE);
    bsdf.fresnel = select(COMMON_FRESNEL, bsdf.fresnel, COMMON_FRESNEL == NONE);
    bsdf.distribution = select(COMMON_DISTRIBUTION, bsdf.distribution, COMMON_DISTRIBUTION == NONE);
    bsdf.masking = select(COMMON_MASKING, bsdf.masking, COMMON_MASKING == NONE);
    return bsdf;
}

// The same for given values of what textures vary, seen from the front, whose bitangent is the frame's.
fn bsdf_of(material: Material, texels: Texels, eta: f32) -> Bsdf {
    var bsdf: Bsdf;
    bsdf.reflectance = material.base_color.rgb * texels.base_color;
    bsdf.model = material.model;
    bsdf.eta = material.eta;
    bsdf.fresnel = material.fresnel;
    bsdf.k = material.k;
    bsdf.distribution = material.distribution;
    bsdf.alpha = material.alpha;
    bsdf.roughness = material.roughness;
    bsdf.masking = material.masking;
    if material.model == BSDF_GLTF {
        return gltf_of(bsdf, material, texels, eta);
    }
    if material.model == BSDF_UNLIT {
        bsdf.reflectance = vec3<f32>(0.0);
    } else if (material.flags & MATERIAL_TRANSMISSIVE) != 0u {
        bsdf.eta = vec3<f32>(eta);
    }
    return bsdf;
}

// glTF 2.0 appendix B.3, a dielectric and a metal, mixed, and the KHR_materials extensions.
fn gltf_of(base: Bsdf, material: Material, texels: Texels, eta: f32) -> Bsdf {
    var bsdf = base;
    bsdf.eta = vec3<f32>(eta);
    bsdf.roughness = material.roughness * texels.roughness;
    bsdf.gltf.metallic = material.metallic * texels.metallic;
    // KHR_materials_specular, section "Implementation"; its colour may exceed 1, F0 not.
    let specular = material.specular * texels.specular;
    let specular_color = material.specular_color * texels.specular_color;
    bsdf.gltf.F0 = min(sqr((eta - 1.0) / (eta + 1.0)) * specular_color, vec3<f32>(1.0)) * specular;
    bsdf.gltf.F90 = specular;
    if (material.flags & MATERIAL_SPECULAR_GLOSSINESS) != 0u {
        bsdf.reflectance *= 1.0 - max(specular_color.r, max(specular_color.g, specular_color.b));
        bsdf.roughness = 1.0 - material.roughness * texels.glossiness;
        bsdf.gltf.F0 = specular_color;
        bsdf.gltf.F90 = 1.0;
    }
    // KHR_materials_anisotropy, "Anisotropy"; the rotation comes after the texture's direction.
    let alpha = sqr(bsdf.roughness);
    let share = sqr(material.anisotropy * texels.anisotropy);
    bsdf.alpha = vec2<f32>(alpha * (1.0 - share) + share, alpha);
    let turn = material.anisotropy_rotation;
    let direction = texels.anisotropy_direction;
    bsdf.gltf.rotation = vec2<f32>(
        turn.x * direction.x - turn.y * direction.y,
        turn.y * direction.x + turn.x * direction.y);

    bsdf.gltf.transmission = material.transmission * texels.transmission;
    bsdf.gltf.diffuse_transmission = material.diffuse_transmission * texels.diffuse_transmission;
    bsdf.gltf.diffuse_transmission_color = material.diffuse_transmission_color * texels.diffuse_transmission_color;
    bsdf.gltf.sheen_color = material.sheen_color * texels.sheen_color;
    bsdf.gltf.sheen_roughness = material.sheen_roughness * texels.sheen_roughness;
    bsdf.gltf.coat_normal = vec3<f32>(0.0, 0.0, 1.0);
    bsdf.gltf.coat = material.coat * texels.coat;
    bsdf.gltf.coat_roughness = material.coat_roughness * texels.coat_roughness;
    bsdf.gltf.iridescence = material.iridescence * texels.iridescence;
    bsdf.gltf.film_ior = material.film_ior;
    let thickness = material.film_thickness;
    bsdf.gltf.film_thickness = thickness.x * (1.0 - texels.film_thickness) + thickness.y * texels.film_thickness;
    // By the factor: the surface is one dielectric, however its texture covers it.
    if material.transmission > 0.0 {
        bsdf.gltf.flags |= GLTF_TRANSMISSIVE;
    }
    if (material.flags & MATERIAL_THIN_WALLED) != 0u {
        bsdf.gltf.flags |= GLTF_THIN_WALLED;
    }
    return bsdf;
}

// Radiance that the surface emits towards wo.
fn Le_surface(material: Material, surface: Surface) -> vec3<f32> {
    if material.model == BSDF_UNLIT {
        return base_color_at(material, surface).rgb;
    }
    // One-sided like the surface itself; a transmissive one is seen from behind and stays dark there.
    if surface.front == 0u && (material.flags & MATERIAL_DOUBLE_SIDED) == 0u {
        return vec3<f32>(0.0);
    }
    var Le = material.emissive;
    if EMISSIVE_TEXTURES {
        Le *= texture_at(material.emissive_texture, surface).rgb;
    }
    return Le;
}
