//! What the kernels may take for granted of a scene: the values of `shaders/variant.wgsl`.

use crate::pack::Packed;
use crate::shared::{BSDF_UNLIT, MATERIAL_TRANSMISSIVE, Material, NONE, Texture};

/// The overrides' values for a scene, by name. Materials that no triangle has do not count.
pub fn constants(packed: &Packed) -> Vec<(&'static str, f64)> {
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
    let any = |texture: fn(&Material) -> &Texture| {
        flag(
            materials
                .iter()
                .any(|material| texture(material).texels != NONE),
        )
    };
    let any_flag = |bit: u32| flag(materials.iter().any(|material| material.flags & bit != 0));
    // An unlit surface ends its path before any reflection model is asked.
    let common = |value: fn(&Material) -> u32| {
        let mut values = materials
            .iter()
            .filter(|material| material.model != BSDF_UNLIT)
            .map(|material| value(material));
        let first = values.next().unwrap_or(NONE);
        f64::from(if values.all(|value| value == first) {
            first
        } else {
            NONE
        })
    };
    vec![
        ("TEST_ALPHA", flag(packed.frame.has_alpha != 0)),
        ("MEDIA", any_flag(MATERIAL_TRANSMISSIVE)),
        ("BASE_COLOR_TEXTURES", any(|m| &m.base_color_texture)),
        (
            "METALLIC_ROUGHNESS_TEXTURES",
            any(|m| &m.metallic_roughness_texture),
        ),
        ("NORMAL_TEXTURES", any(|m| &m.normal_texture)),
        ("EMISSIVE_TEXTURES", any(|m| &m.emissive_texture)),
        ("COMMON_MODEL", common(|m| m.model)),
        ("COMMON_FRESNEL", common(|m| m.fresnel)),
        ("COMMON_DISTRIBUTION", common(|m| m.distribution)),
        ("COMMON_MASKING", common(|m| m.masking)),
    ]
}

fn flag(value: bool) -> f64 {
    f64::from(u8::from(value))
}
