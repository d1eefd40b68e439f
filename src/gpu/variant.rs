//! What the kernels may take for granted of a scene: the values of `shaders/variant.wgsl`.

use super::link::Value;
use crate::cpu::bsdf::lobe::ALPHA_SMOOTH;
use crate::pack::material::triangle_flags;
use crate::pack::outline::Outline;
use crate::shared::{
    BSDF_GLTF, BSDF_UNLIT, CLASS_MISS, CLASSES, LAYOUT_COLOR, LAYOUT_TANGENT,
    LAYOUT_TEXCOORD_UNORM, LAYOUT_TEXCOORDS_SHIFT, LIGHT_PROFILE, MATERIAL_ALPHA_BLEND,
    MATERIAL_ALPHA_MASK, MATERIAL_SPECULAR_GLOSSINESS, MATERIAL_THIN_WALLED, MATERIAL_TRANSMISSIVE,
    Material, NONE, TRIANGLE_CLASS, Texture,
};

const _: () = assert!(CLASSES <= TRIANGLE_CLASS + 1, "a class that has no room");

/// Names and values of constants.
pub type Constants = Vec<(&'static str, Value)>;

/// What the kernels of one scene may take for granted.
#[derive(Clone, Debug, Default)]
pub struct Variants {
    pub scene: Constants,
    /// By class of surfaces, of those that the scene has and of misses.
    pub classes: Vec<(u32, Constants)>,
}

impl Variants {
    /// Those of a scene; `more` goes with all kernels.
    pub fn of(outline: &Outline, more: &[(&'static str, Value)]) -> Self {
        let all = |mut constants: Constants| {
            constants.extend(more);
            constants
        };
        let hit = classes(outline).map(|class| (class, all(class_constants(outline, class))));
        let miss = [("SHADED_CLASS", Value::Uint(CLASS_MISS))].into_iter();
        let miss = miss.chain(constants(outline)).collect();
        Self {
            scene: all(constants(outline)),
            classes: hit.chain([(CLASS_MISS, all(miss))]).collect(),
        }
    }

    /// Kernels that take nothing for granted, for all classes of a scene.
    pub fn general(outline: &Outline) -> Self {
        let class = |class| (class, vec![("SHADED_CLASS", Value::Uint(class))]);
        Self {
            scene: Vec::new(),
            classes: classes(outline).chain([CLASS_MISS]).map(class).collect(),
        }
    }
}

fn class_of(material: &Material) -> u32 {
    triangle_flags(material) & TRIANGLE_CLASS
}

/// The classes of the scene's surfaces.
fn classes(outline: &Outline) -> impl Iterator<Item = u32> {
    let mut there = [false; CLASSES as usize];
    for material in &outline.materials {
        there[class_of(material) as usize] = true;
    }
    (0..CLASSES).filter(move |&class| there[class as usize])
}

/// The constants of kernels that meet all materials.
pub fn constants(outline: &Outline) -> Constants {
    let materials: Vec<&Material> = outline.materials.iter().collect();
    let mut constants = scene_constants(outline);
    constants.extend(material_constants(&materials));
    constants
}

/// The constants of the kernel that shades the surfaces of one class.
fn class_constants(outline: &Outline, class: u32) -> Constants {
    let all = outline.materials.iter();
    let own: Vec<&Material> = all.clone().filter(|m| class_of(m) == class).collect();
    let mut constants = vec![("SHADED_CLASS", Value::Uint(class))];
    constants.extend(scene_constants(outline));
    constants.extend(material_constants(&own));
    // A boundary to a medium with an index of 0, which reflects everything, is a mirror.
    if all
        .clone()
        .any(|m| m.flags & MATERIAL_TRANSMISSIVE != 0 && m.ior <= 0.0)
    {
        constants.retain(|(name, _)| !["OPAQUE", "DIFFUSE"].contains(name));
    }
    constants
}

/// What the way of light through the scene depends on, whatever surface is shaded.
fn scene_constants(outline: &Outline) -> Constants {
    let some = |test: fn(&Material) -> bool| Value::Bool(outline.materials.iter().any(test));
    let vertices =
        |test: fn(u32) -> bool| Value::Bool(outline.layouts.iter().any(|&layout| test(layout)));
    vec![
        ("LENS", Value::Bool(outline.camera.lens_radius > 0.0)),
        ("CAMERAS", Value::Uint(1 << outline.camera.kind)),
        (
            "PROFILES",
            Value::Bool(outline.light_kinds & 1 << LIGHT_PROFILE != 0),
        ),
        ("LIGHTS", Value::Uint(outline.light_kinds)),
        ("MANY_LIGHTS", Value::Bool(outline.many_lights)),
        ("ENVIRONMENT", Value::Bool(outline.environment)),
        ("INSTANCES", Value::Bool(outline.two_levels)),
        ("LIGHT_TREE", Value::Bool(outline.light_tree)),
        ("MOTION", Value::Bool(outline.moves)),
        (
            "TEST_ALPHA",
            some(|m| m.flags & (MATERIAL_ALPHA_MASK | MATERIAL_ALPHA_BLEND) != 0),
        ),
        ("MEDIA", some(|m| m.flags & MATERIAL_TRANSMISSIVE != 0)),
        ("DISPERSION", some(|m| m.dispersion > 0.0)),
        ("THIN_WALLS", some(|m| m.flags & MATERIAL_THIN_WALLED != 0)),
        (
            "VERTEX_TANGENTS",
            vertices(|layout| layout & LAYOUT_TANGENT != 0),
        ),
        (
            "VERTEX_COLORS",
            vertices(|layout| layout & LAYOUT_COLOR != 0),
        ),
        (
            "UNORM_TEXCOORDS",
            vertices(|layout| layout & LAYOUT_TEXCOORD_UNORM != 0),
        ),
        (
            "FLOAT_TEXCOORDS",
            vertices(|layout| {
                layout >> LAYOUT_TEXCOORDS_SHIFT != 0 && layout & LAYOUT_TEXCOORD_UNORM == 0
            }),
        ),
        (
            "BASE_COLOR_TEXTURES",
            some(|m| any(&[&m.base_color_texture])),
        ),
        // Lamps and masks are looked up wherever they are seen from.
        ("EMISSIVE_TEXTURES", some(|m| any(&[&m.emissive_texture]))),
    ]
}

/// What the surfaces alone depend on.
fn material_constants(materials: &[&Material]) -> Constants {
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
        ("BOUNDARIES", some(|m| m.flags & MATERIAL_TRANSMISSIVE != 0)),
        (
            "METALLIC_ROUGHNESS_TEXTURES",
            some(|m| any(&[&m.metallic_roughness_texture])),
        ),
        ("NORMAL_TEXTURES", some(|m| any(&[&m.normal_texture]))),
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
        (
            "EMISSION",
            some(|m| m.model == BSDF_UNLIT || m.emissive != [0.0; 3]),
        ),
        ("METALS", some(|m| m.metallic > 0.0)),
        (
            "DIELECTRICS",
            some(|m| m.metallic < 1.0 || any(&[&m.metallic_roughness_texture])),
        ),
        (
            "DIFFUSE",
            some(|m| !transmits(m) || m.transmission < 1.0 || any(&[&m.transmission_texture])),
        ),
        ("OPAQUE", some(|m| !transmits(m))),
        ("THIN", some(|m| m.flags & MATERIAL_THIN_WALLED != 0)),
        ("SMOOTH", some(|m| !is_rough(m))),
        ("ROUGH", some(|m| !is_smooth(m))),
        ("MODELS", Value::Uint(models)),
        ("COMMON_MODEL", common(|m| m.model)),
        ("COMMON_FRESNEL", common(|m| m.fresnel)),
        ("COMMON_DISTRIBUTION", common(|m| m.distribution)),
        ("COMMON_MASKING", common(|m| m.masking)),
    ]
}

/// Whether the surface is a dielectric boundary wherever it is seen.
fn transmits(material: &Material) -> bool {
    material.model == BSDF_GLTF && material.transmission > 0.0 && material.ior > 0.0
}

/// Whether all facets are smooth, for certain: not where rounding may say otherwise, nor where a coat lies over
/// them, whose facets are others.
fn is_smooth(material: &Material) -> bool {
    has_plain_facets(material) && material.roughness.powi(2) < 0.99 * ALPHA_SMOOTH as f32
}

fn is_rough(material: &Material) -> bool {
    has_plain_facets(material)
        && !any(&[&material.metallic_roughness_texture])
        && material.roughness.powi(2) > 1.01 * ALPHA_SMOOTH as f32
}

/// Whether there is one kind of facets, and their roughness is what the material says or less.
fn has_plain_facets(material: &Material) -> bool {
    material.model == BSDF_GLTF
        && material.flags & MATERIAL_SPECULAR_GLOSSINESS == 0
        && material.coat == 0.0
        && material.anisotropy == 0.0
}

/// Whether one of the textures is there.
fn any(textures: &[&Texture]) -> bool {
    textures.iter().any(|texture| texture.texels != NONE)
}
