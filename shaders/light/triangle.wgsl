// Emissive triangles: sampled uniformly by area, each with a share of the choice that is its
// area times its material's mean luminance. So the density per area is one number per material.

import package::shared::{Light, INSTANCE_FLIPPED, INSTANCE_KEYS_SHIFT, MATERIAL_DOUBLE_SIDED};
import package::math::{normalize_accurate};
import package::attributes::{attribute_texcoord};
import package::texture::{texture_sample};
import package::alpha::{coverage_at};
import package::variant::{EMISSIVE_TEXTURES, MOTION};
import package::transform::{instance_at, transform_point, transform_vector};
import package::bindings::{triangles, instances, materials};

// The light at `time`, where its instance is by then. It is chosen by its area in the table, and points
// on it uniformly by the area that it has: where motion changes that, the density by area is off by the
// areas' ratio. The ratio goes to what the light sends instead, which leaves the estimate what it was, and
// light_pdf_triangle one number per material: all that weights need of a density is to be the same
// for both techniques.
fn light_at(light: Light, time: f32) -> Light {
    if !MOTION || (instances[light.instance].flags >> INSTANCE_KEYS_SHIFT) == 0u {
        return light;
    }
    let rows = instance_at(light.instance, time).world_from_object;
    let triangle = triangles[light.triangle];
    var moved = light;
    moved.position = transform_point(rows, triangle.p0);
    moved.direction = transform_vector(rows, triangle.e1);
    moved.edge2 = transform_vector(rows, triangle.e2);
    // At unit scale, so that the product of tiny edges does not underflow.
    let size1 = max(abs(light.direction.x), max(abs(light.direction.y), abs(light.direction.z)));
    let size2 = max(abs(light.edge2.x), max(abs(light.edge2.y), abs(light.edge2.z)));
    let area = cross(moved.direction / size1, moved.edge2 / size2);
    let area_in_table = cross(light.direction / size1, light.edge2 / size2);
    moved.radiance *= sqrt(dot(area, area) / dot(area_in_table, area_in_table));
    return moved;
}

// Outward normal of the front face, unit length. glTF 2.0 section 3.6.2.1 (Triangles winding): a
// negative determinant of the instance's transform turns the winding around.
fn light_normal(light: Light, time: f32) -> vec3<f32> {
    let ng = normalize_accurate(cross(light.direction, light.edge2));
    let flipped = (instance_at(light.instance, time).flags & INSTANCE_FLIPPED) != 0u;
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
