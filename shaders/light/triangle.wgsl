// Emissive triangles: sampled uniformly by area, each with a share of the choice that is its
// area times its material's mean luminance. So the density per area is one number per material.

import package::shared::{Light, INSTANCE_FLIPPED, MATERIAL_DOUBLE_SIDED};
import package::math::{normalize_accurate};
import package::attributes::{attribute_texcoord};
import package::texture::{texture_sample};
import package::alpha::{coverage_at};
import package::variant::{EMISSIVE_TEXTURES};
import package::bindings::{triangles, instances, materials};

// Outward normal of the front face, unit length. glTF 2.0 section 3.6.2.1 (Triangles winding): a
// negative determinant of the instance's transform turns the winding around.
fn light_normal(light: Light) -> vec3<f32> {
    let ng = normalize_accurate(cross(light.direction, light.edge2));
    let flipped = (instances[light.instance].flags & INSTANCE_FLIPPED) != 0u;
    return select(ng, -ng, flipped);
}

// Radiance that a triangle light sends at `barycentrics`, times the surface's coverage there: a ray
// that meets the light by chance passes where it is masked or blended away (alpha.wgsl).
fn Le_triangle(light: Light, barycentrics: vec2<f32>) -> vec3<f32> {
    var Le = light.radiance * coverage_at(light.triangle, barycentrics);
    if EMISSIVE_TEXTURES {
        let triangle = triangles[light.triangle];
        let emissive_texture = materials[triangle.material].emissive_texture;
        let uv = attribute_texcoord(triangle, barycentrics, emissive_texture.texcoord);
        Le *= texture_sample(emissive_texture, uv).rgb;
    }
    return Le;
}

// Cosine at the light, `cos_geometric` between wi reversed and the front's normal; 0 where the
// triangle does not shine.
fn cos_emission(light: Light, cos_geometric: f32) -> f32 {
    let flags = materials[triangles[light.triangle].material].flags;
    return select(max(cos_geometric, 0.0), abs(cos_geometric), (flags & MATERIAL_DOUBLE_SIDED) != 0u);
}
