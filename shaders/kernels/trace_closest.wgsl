// "What does the ray meet first?": one invocation a path in the queue; rays in, hits out.

import package::kernels::state::{load_ray, store_hit, queued_path, queue_class, counters, paths, plane, PLANE_RNG, PLANE_RAY_ORIGIN, WORKGROUP};
import package::shared::{NONE, CLASS_MISS, TRIANGLE_CLASS};
import package::bindings::{triangles};
import package::bvh::{trace_closest};
import package::estimator::{ray_alpha_seed};
import package::rng::{Rng};

@compute @workgroup_size(WORKGROUP)
fn trace_closest_kernel(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = queued_path(id.x);
    if slot == NONE {
        return;
    }
    let rng = paths[plane(PLANE_RNG, slot)];
    let bounce = paths[plane(PLANE_RAY_ORIGIN, slot)].w;
    let seed = ray_alpha_seed(Rng(rng.y, rng.z, 0u), 2u * bounce);
    let hit = trace_closest(load_ray(slot), seed);
    store_hit(slot, hit);
    var shading_class = CLASS_MISS;
    if hit.instance != NONE {
        shading_class = triangles[hit.triangle].flags & TRIANGLE_CLASS;
    }
    queue_class(slot, shading_class);
}
