//! Emissive triangles: sampled uniformly by area, each with a share of the choice that is its
//! area times its material's mean luminance. So the density per area is one number per material.

use crate::cpu::alpha::coverage_at;
use crate::cpu::attributes::attribute_texcoord;
use crate::cpu::math::normalize_accurate;
use crate::cpu::texture::texture_sample;
use crate::cpu::transform::{instance_at, transform_point, transform_vector};
use crate::pack::Packed;
use crate::shared::{INSTANCE_FLIPPED, INSTANCE_KEYS_SHIFT, Light, MATERIAL_DOUBLE_SIDED};
use glam::{DVec2, DVec3, Vec3};

/// A triangle light at a moment: `Light` in float64.
#[derive(Clone, Copy, Debug)]
pub struct PlacedLight {
    pub position: DVec3,
    /// Edge 1.
    pub direction: DVec3,
    pub edge2: DVec3,
    pub radiance: DVec3,
    pub triangle: u32,
    pub instance: u32,
}

/// The light at `time`, where its instance is by then. It is chosen by its area in the table, and
/// points on it uniformly by the area that it has: where motion changes that, the density by area is
/// off by the areas' ratio. The ratio goes to what the light sends instead, which leaves the estimate
/// what it was, and `light_pdf_triangle` one number per material: all that weights need of a density
/// is to be the same for both techniques.
pub fn light_at(packed: &Packed, light: &Light, time: f64) -> PlacedLight {
    let vector = |v: [f32; 3]| Vec3::from(v).as_dvec3();
    let mut placed = PlacedLight {
        position: vector(light.position),
        direction: vector(light.direction),
        edge2: vector(light.edge2),
        radiance: vector(light.radiance),
        triangle: light.triangle,
        instance: light.instance,
    };
    if packed.instances[light.instance as usize].flags >> INSTANCE_KEYS_SHIFT == 0 {
        return placed;
    }
    let rows = instance_at(packed, light.instance, time).world_from_object;
    let triangle = &packed.triangles[light.triangle as usize];
    let area_in_table = placed.direction.cross(placed.edge2).length();
    placed.position = transform_point(rows, vector(triangle.p0));
    placed.direction = transform_vector(rows, vector(triangle.e1));
    placed.edge2 = transform_vector(rows, vector(triangle.e2));
    placed.radiance *= placed.direction.cross(placed.edge2).length() / area_in_table;
    placed
}

/// Outward normal of the front face, unit length. glTF 2.0 section 3.6.2.1 (Triangles winding): a
/// negative determinant of the instance's transform turns the winding around.
pub fn light_normal(packed: &Packed, light: &PlacedLight, time: f64) -> DVec3 {
    let ng = normalize_accurate(light.direction.cross(light.edge2));
    let flipped = instance_at(packed, light.instance, time).flags & INSTANCE_FLIPPED != 0;
    if flipped { -ng } else { ng }
}

/// Radiance that a triangle light sends at `barycentrics`, times the surface's coverage there: a ray
/// that meets the light by chance passes where it is masked or blended away.
pub fn Le_triangle(packed: &Packed, light: &PlacedLight, barycentrics: DVec2) -> DVec3 {
    let triangle = &packed.triangles[light.triangle as usize];
    let emissive_texture = &packed.materials[triangle.material as usize].emissive_texture;
    let uv = attribute_texcoord(packed, triangle, barycentrics, emissive_texture.texcoord);
    light.radiance
        * texture_sample(packed, emissive_texture, uv).truncate()
        * coverage_at(packed, light.triangle, barycentrics)
}

/// Cosine at the light, `cos_geometric` between wi reversed and the front's normal; 0 where the
/// triangle does not shine.
pub fn cos_emission(packed: &Packed, light: &PlacedLight, cos_geometric: f64) -> f64 {
    let triangle = &packed.triangles[light.triangle as usize];
    let flags = packed.materials[triangle.material as usize].flags;
    if flags & MATERIAL_DOUBLE_SIDED != 0 {
        cos_geometric.abs()
    } else {
        cos_geometric.max(0.0)
    }
}
