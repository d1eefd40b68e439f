// "For every sample of every pixel, a ray through the film": fills the slots of a tile's samples.

import package::bindings::{frame};
import package::kernels::state::{Path, store_path, start_radiance, paths, plane, PLANE_QUEUES, WORKGROUP};
import package::kernels::slots::{slot_pixel};
import package::estimator::{DIMENSION_LENS, DIMENSION_PIXEL, path_time};
import package::rng::{rng_init, next_2d};
import package::sample::{sample_disk_concentric};
import package::filter::{filter_offset, filter_place, FILTER_REACH};
import package::camera::{camera_at, camera_ray};
import package::medium::{MEDIA_NONE};
import package::variant::{LENS};

@compute @workgroup_size(WORKGROUP)
fn generate(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = id.x;
    if slot >= frame.capacity {
        return;
    }
    let place = slot_pixel(slot);
    // Beyond the picture's upper and left edges numbers wrap, as in the reference.
    let pixel = frame.tile_origin + place.xy - FILTER_REACH;
    var rng = rng_init(pixel, frame.first_sample + place.z, frame.seed);
    rng.dimension = DIMENSION_PIXEL;
    let in_pixel = filter_place(next_2d(&rng));
    let position = vec2<f32>(vec2<i32>(pixel)) + 0.5 + filter_offset(in_pixel);
    // The path's time needs no place in its state: path_time gives it again.
    let camera = camera_at(frame.camera, path_time(rng));
    var lens = vec2(0.0);
    if LENS && camera.lens_radius > 0.0 {
        rng.dimension = DIMENSION_LENS;
        lens = sample_disk_concentric(next_2d(&rng));
    }
    let ray = camera_ray(camera, frame.film_size, position, lens);
    store_path(slot, Path(ray, 0u, 1.0, true, vec3(1.0), 1.0, MEDIA_NONE, 0.0, rng));
    start_radiance(slot, in_pixel);
    paths[plane(PLANE_QUEUES, slot)].x = slot;
}
