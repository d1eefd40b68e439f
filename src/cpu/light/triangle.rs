//! Emissive triangles: sampled uniformly by area, each with a share of the choice that is its
//! area times its material's mean luminance. So the density per area is one number per material.

use crate::cpu::alpha::coverage_at;
use crate::cpu::attributes::attribute_texcoord;
use crate::cpu::math::normalize_accurate;
use crate::cpu::texture::texture_sample;
use crate::pack::Packed;
use crate::shared::{INSTANCE_FLIPPED, Light, MATERIAL_DOUBLE_SIDED};
use glam::{DVec2, DVec3, Vec3};

/// Outward normal of the front face, unit length. glTF 2.0 section 3.6.2.1 (Triangles winding): a
/// negative determinant of the instance's transform turns the winding around.
pub fn light_normal(packed: &Packed, light: &Light) -> DVec3 {
    let edge1 = Vec3::from(light.direction).as_dvec3();
    let ng = normalize_accurate(edge1.cross(Vec3::from(light.edge2).as_dvec3()));
    let flipped = packed.instances[light.instance as usize].flags & INSTANCE_FLIPPED != 0;
    if flipped { -ng } else { ng }
}

/// Radiance that a triangle light sends at `barycentrics`, times the surface's coverage there: a ray
/// that meets the light by chance passes where it is masked or blended away.
pub fn Le_triangle(packed: &Packed, light: &Light, barycentrics: DVec2) -> DVec3 {
    let triangle = &packed.triangles[light.triangle as usize];
    let emissive_texture = &packed.materials[triangle.material as usize].emissive_texture;
    let uv = attribute_texcoord(packed, triangle, barycentrics, emissive_texture.texcoord);
    Vec3::from(light.radiance).as_dvec3()
        * texture_sample(packed, emissive_texture, uv).truncate()
        * coverage_at(packed, light.triangle, barycentrics)
}

/// Cosine at the light, `cos_geometric` between wi reversed and the front's normal; 0 where the
/// triangle does not shine.
pub fn cos_emission(packed: &Packed, light: &Light, cos_geometric: f64) -> f64 {
    let triangle = &packed.triangles[light.triangle as usize];
    let flags = packed.materials[triangle.material as usize].flags;
    if flags & MATERIAL_DOUBLE_SIDED != 0 {
        cos_geometric.abs()
    } else {
        cos_geometric.max(0.0)
    }
}
