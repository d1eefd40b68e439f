//! Which hits count: alpha masks and alpha blending, decided while tracing.

use super::attributes::{attribute_color, attribute_texcoord};
use super::rng::{hash_combine, unit_from_bits};
use super::texture::texture_sample;
use crate::pack::Packed;
use crate::shared::{MATERIAL_ALPHA_BLEND, MATERIAL_ALPHA_MASK};
use glam::DVec2;

/// Whether a masked or blended surface is there at this point, for the ray of this seed.
pub fn is_visible(
    packed: &Packed,
    triangle_index: u32,
    instance_index: u32,
    barycentrics: DVec2,
    alpha_seed: u32,
) -> bool {
    alpha_threshold(triangle_index, instance_index, alpha_seed)
        < coverage_at(packed, triangle_index, barycentrics)
}

/// The part of the surface that is there: 0 or 1 of a masked one, alpha of a blended one, else 1.
pub fn coverage_at(packed: &Packed, triangle_index: u32, barycentrics: DVec2) -> f64 {
    let material_index = packed.triangles[triangle_index as usize].material;
    let material = &packed.materials[material_index as usize];
    if material.flags & (MATERIAL_ALPHA_MASK | MATERIAL_ALPHA_BLEND) == 0 {
        return 1.0;
    }
    let alpha = alpha_at(packed, triangle_index, barycentrics);
    if material.flags & MATERIAL_ALPHA_MASK != 0 {
        return f64::from(u8::from(alpha >= f64::from(material.alpha_cutoff)));
    }
    alpha
}

/// Base colour's alpha: factor, texture and vertex colour (glTF 2.0 sections 3.9.4 and 3.9.2).
pub fn alpha_at(packed: &Packed, triangle_index: u32, barycentrics: DVec2) -> f64 {
    let triangle = &packed.triangles[triangle_index as usize];
    let material = &packed.materials[triangle.material as usize];
    let texture = &material.base_color_texture;
    let uv = attribute_texcoord(packed, triangle, barycentrics, texture.texcoord);
    f64::from(material.base_color[3])
        * texture_sample(packed, texture, uv).w
        * attribute_color(packed, triangle, barycentrics).w
}

/// A number in [0, 1) that a blended surface's alpha has to exceed. One for each ray and triangle, so
/// that the many rays of a pixel see it with probability alpha.
pub fn alpha_threshold(triangle_index: u32, instance_index: u32, alpha_seed: u32) -> f64 {
    let hash = hash_combine(hash_combine(alpha_seed, triangle_index), instance_index);
    unit_from_bits(hash)
}
