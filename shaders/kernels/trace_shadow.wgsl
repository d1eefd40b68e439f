// "What stands between the surface and the light?": one invocation a queued shadow ray; the light that
// arrives is added to its path.

import package::kernels::state::{add_radiance, counters, paths, plane, COUNTER_SHADOW, PLANE_RAY_ORIGIN, PLANE_QUEUES, PLANE_RNG, PLANE_SHADOW_ORIGIN, PLANE_SHADOW_DIRECTION, PLANE_SHADOW_LIGHT, WORKGROUP};
import package::ray::{Ray};
import package::bindings::{frame};
import package::visibility::{visibility};
import package::estimator::{path_time, ray_alpha_seed};
import package::rng::{Rng};

@compute @workgroup_size(WORKGROUP)
fn trace_shadow_kernel(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= atomicLoad(&counters[COUNTER_SHADOW]) {
        return;
    }
    let slot = paths[plane(PLANE_QUEUES, id.x)].z;
    let origin = bitcast<vec4<f32>>(paths[plane(PLANE_SHADOW_ORIGIN, slot)]);
    let direction = bitcast<vec3<f32>>(paths[plane(PLANE_SHADOW_DIRECTION, slot)].xyz);
    let rng = paths[plane(PLANE_RNG, slot)];
    // The bounce at which the shadow ray was made; the path itself is one further by now.
    let bounce = paths[plane(PLANE_SHADOW_DIRECTION, slot)].w;
    let path_rng = Rng(rng.y, rng.z, 0u);
    let seed = ray_alpha_seed(path_rng, 2u * bounce + 1u);
    let light = bitcast<vec4<f32>>(paths[plane(PLANE_SHADOW_LIGHT, slot)]);
    let ray = Ray(origin.xyz, 0.0, direction, origin.w, path_time(path_rng));
    let passed = visibility(ray, light.w, frame.max_depth - 1u - bounce, seed);
    if any(passed > vec3(0.0)) {
        add_radiance(slot, light.xyz * passed);
    }
}
