// What of a light comes straight to a surface.

import package::shared::{NONE, MATERIAL_THIN_WALLED};
import package::bindings::{frame, materials};
import package::variant::{THIN_WALLS};
import package::math::{to_local};
import package::ray::{Ray};
import package::bvh::{trace_any, trace_closest};
import package::surface::{surface_at};
import package::material::{bsdf_at};
import package::bsdf::bsdf::{straight_transmittance};

// The part of light that comes along a ray from its end: smooth thin walls tint it, everything else
// blocks it. That is just what a path finds that goes on straight through such walls, so that both can be
// weighted against each other. `ior`: index of the medium that the ray is in; `walls`: how many the path
// could still pass.
//
// Media that overlap hide boundaries, but for these rays they are surfaces too: a path passes them as a
// delta, and finds the light beyond by itself.
fn visibility(ray: Ray, ior: f32, walls: u32, alpha_seed: u32) -> vec3<f32> {
    if !THIN_WALLS || frame.has_thin_walls == 0u {
        return vec3(select(1.0, 0.0, trace_any(ray, alpha_seed)));
    }
    var passed = vec3(1.0);
    var ahead = ray;
    for (var wall = 0u; wall <= walls; wall++) {
        let hit = trace_closest(ahead, alpha_seed);
        if hit.instance == NONE {
            return passed;
        }
        let surface = surface_at(ahead, hit);
        let material = materials[surface.material];
        if (material.flags & MATERIAL_THIN_WALLED) == 0u {
            break;
        }
        let bsdf = bsdf_at(material, surface, material.ior / ior);
        passed *= straight_transmittance(bsdf, to_local(surface.basis, -ray.direction));
        if all(passed == vec3(0.0)) {
            break;
        }
        ahead.t_min = hit.t;
    }
    return vec3(0.0);
}
