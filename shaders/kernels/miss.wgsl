// The ray left the scene: the background for a camera ray, the environment as a light for others.

import package::bindings::{frame};
import package::shared::{NONE, BACKGROUND_COLOR, BACKGROUND_TRANSPARENT};
import package::kernels::state::{load_path, add_radiance, uncover, queued_of_class, counters, paths, WORKGROUP};
import package::light::light::{light_pdf_environment};
import package::light::environment::{Le_environment};
import package::estimator::{power_heuristic};

@compute @workgroup_size(WORKGROUP)
fn miss_kernel(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = queued_of_class(id.x);
    if slot == NONE {
        return;
    }
    let path = load_path(slot);
    let Le = Le_environment(path.ray.direction);
    if path.bounce == 0u {
        if frame.background_kind == BACKGROUND_TRANSPARENT {
            uncover(slot);
        } else {
            add_radiance(slot, select(Le, frame.background, frame.background_kind == BACKGROUND_COLOR));
        }
        return;
    }
    var weight = 1.0;
    if !path.delta {
        weight = power_heuristic(path.pdf_bsdf, light_pdf_environment(path.ray.direction));
    }
    add_radiance(slot, path.beta * Le * weight);
}
