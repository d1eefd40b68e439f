// Which hits count: alpha masks and alpha blending, decided while tracing.

import package::shared::{MATERIAL_ALPHA_MASK, MATERIAL_ALPHA_BLEND};
import package::bindings::{triangles, materials};
import package::attributes::{attribute_color, attribute_texcoord};
import package::texture::{texture_sample};
import package::rng::{hash_combine, unit_from_bits};
import package::variant::{TEST_ALPHA, BASE_COLOR_TEXTURES};

// Whether a masked or blended surface is there at this point, for the ray of this seed.
fn is_visible(triangle_index: u32, instance_index: u32, barycentrics: vec2<f32>, alpha_seed: u32) -> bool {
    return alpha_threshold(triangle_index, instance_index, alpha_seed) < coverage_at(triangle_index, barycentrics);
}

// The part of the surface that is there: 0 or 1 of a masked one, alpha of a blended one, else 1.
fn coverage_at(triangle_index: u32, barycentrics: vec2<f32>) -> f32 {
    let material_index = triangles[triangle_index].material;
    let flags = materials[material_index].flags;
    if !TEST_ALPHA || (flags & (MATERIAL_ALPHA_MASK | MATERIAL_ALPHA_BLEND)) == 0u {
        return 1.0;
    }
    let alpha = alpha_at(triangle_index, barycentrics);
    if (flags & MATERIAL_ALPHA_MASK) != 0u {
        return select(0.0, 1.0, alpha >= materials[material_index].alpha_cutoff);
    }
    return alpha;
}

// Base colour's alpha: factor, texture and vertex colour (glTF 2.0 sections 3.9.4 and 3.9.2).
fn alpha_at(triangle_index: u32, barycentrics: vec2<f32>) -> f32 {
    let triangle = triangles[triangle_index];
    var alpha = materials[triangle.material].base_color.a * attribute_color(triangle, barycentrics).a;
    if BASE_COLOR_TEXTURES {
        let texture = materials[triangle.material].base_color_texture;
        let uv = attribute_texcoord(triangle, barycentrics, texture.texcoord);
        alpha *= texture_sample(texture, uv).a;
    }
    return alpha;
}

// A number in [0, 1) that a blended surface's alpha has to exceed. One for each ray and triangle, so
// that the many rays of a pixel see it with probability alpha.
fn alpha_threshold(triangle_index: u32, instance_index: u32, alpha_seed: u32) -> f32 {
    let hash = hash_combine(hash_combine(alpha_seed, triangle_index), instance_index);
    return unit_from_bits(hash);
}
