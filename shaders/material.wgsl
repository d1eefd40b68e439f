// What a material is at one point of a surface: its reflection model after texturing, its emission.

import package::shared::{Material, Bsdf, Texture, NONE, BSDF_GLTF, BSDF_UNLIT, MATERIAL_DOUBLE_SIDED, MATERIAL_TRANSMISSIVE};
import package::math::{sqr};
import package::surface::{Surface, texcoord};
import package::texture::{texture_sample};
import package::variant::{BASE_COLOR_TEXTURES, METALLIC_ROUGHNESS_TEXTURES, EMISSIVE_TEXTURES, COMMON_MODEL, COMMON_FRESNEL, COMMON_DISTRIBUTION, COMMON_MASKING};

// A texture of the material at the surface.
fn texture_at(texture: Texture, surface: Surface) -> vec4<f32> {
    return texture_sample(texture, texcoord(surface, texture.texcoord));
}

// Base colour: factor, texture and vertex colour (glTF 2.0 section 3.9.2).
fn base_color_at(material: Material, surface: Surface) -> vec4<f32> {
    var base_color = material.base_color * surface.color;
    if BASE_COLOR_TEXTURES {
        base_color *= texture_at(material.base_color_texture, surface);
    }
    return base_color;
}

// The reflection model in the surface's shading frame. `eta`: index of refraction beyond the surface over
// the index on wo's side, for the dielectrics among the models.
fn bsdf_at(material: Material, surface: Surface, eta: f32) -> Bsdf {
    let base_color = base_color_at(material, surface).rgb;
    var roughness = material.roughness;
    var metallic = material.metallic;
    if METALLIC_ROUGHNESS_TEXTURES {
        let metallic_roughness = texture_at(material.metallic_roughness_texture, surface);
        roughness *= metallic_roughness.g;
        metallic *= metallic_roughness.b;
    }
    var bsdf = bsdf_of(material, base_color, metallic, roughness, eta);
    // Nothing new to the reflection functions, but constants to the compiler.
    bsdf.model = select(COMMON_MODEL, bsdf.model, COMMON_MODEL == NONE);
    bsdf.fresnel = select(COMMON_FRESNEL, bsdf.fresnel, COMMON_FRESNEL == NONE);
    bsdf.distribution = select(COMMON_DISTRIBUTION, bsdf.distribution, COMMON_DISTRIBUTION == NONE);
    bsdf.masking = select(COMMON_MASKING, bsdf.masking, COMMON_MASKING == NONE);
    return bsdf;
}

// The same for given values of what textures vary.
fn bsdf_of(material: Material, base_color: vec3<f32>, metallic: f32, roughness: f32, eta: f32) -> Bsdf {
    var bsdf: Bsdf;
    bsdf.reflectance = base_color;
    bsdf.model = material.model;
    bsdf.eta = material.eta;
    bsdf.fresnel = material.fresnel;
    bsdf.k = material.k;
    bsdf.distribution = material.distribution;
    bsdf.alpha = material.alpha;
    bsdf.roughness = material.roughness;
    bsdf.masking = material.masking;
    if material.model == BSDF_GLTF {
        // glTF 2.0 appendix B.3: a dielectric and a metal, mixed.
        bsdf.eta = vec3<f32>(eta);
        bsdf.alpha = vec2<f32>(sqr(roughness));
        bsdf.roughness = roughness;
        bsdf.gltf.F0 = vec3<f32>(sqr((eta - 1.0) / (eta + 1.0)));
        bsdf.gltf.F90 = 1.0;
        bsdf.gltf.metallic = metallic;
        bsdf.gltf.rotation = vec2<f32>(1.0, 0.0);
        bsdf.gltf.coat_normal = vec3<f32>(0.0, 0.0, 1.0);
    } else if material.model == BSDF_UNLIT {
        bsdf.reflectance = vec3<f32>(0.0);
    } else if (material.flags & MATERIAL_TRANSMISSIVE) != 0u {
        bsdf.eta = vec3<f32>(eta);
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
