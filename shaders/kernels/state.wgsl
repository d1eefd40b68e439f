// The state of the paths in flight, and the queues between the kernels.
//
// `paths` holds planes of vec4<u32>, PLANES of them, each with one entry a slot: wide loads for a
// software adapter, neighbouring ones for a GPU. A slot keeps its path from generate to accumulate;
// queues hold slots, so the order in which invocations append to them changes no result.

import package::bindings::{frame};
import package::ray::{Ray, Hit};
import package::shared::{NONE, CLASSES};
import package::rng::{Rng};
import package::estimator::{path_time};
import package::filter::{PLACE_BITS};
import package::medium::{MEDIA_NONE};
import package::variant::{MEDIA, SHADED_CLASS};

const PLANE_RAY_ORIGIN: u32 = 0u;     // origin, bounce
const PLANE_RAY_DIRECTION: u32 = 1u;  // direction, pdf of the last BSDF sample (negative: delta)
const PLANE_BETA: u32 = 2u;           // throughput, eta scale
const PLANE_RADIANCE: u32 = 3u;       // L so far, the sample's place in its pixel and alpha
const PLANE_HIT: u32 = 4u;            // t, u, v, instance
const PLANE_RNG: u32 = 5u;            // hit triangle, pixel seed, sample index, t_min
const PLANE_SHADOW_ORIGIN: u32 = 6u;  // origin, t_max
const PLANE_SHADOW_DIRECTION: u32 = 7u; // direction, bounce
const PLANE_SHADOW_LIGHT: u32 = 8u;   // what arrives if nothing is in the way, index of the medium
const PLANE_QUEUES: u32 = 9u;         // x, y: paths to go on with, in turn; z: shadow rays
const PLANE_MEDIA: u32 = 10u;         // media that the path is in, wavelength
const PLANE_CLASSES: u32 = 11u;       // and 12: paths to shade, a component for each class
const PLANES: u32 = 13u;

const COUNTER_PATHS: u32 = 0u;        // and 1: length of queue x and of queue y
const COUNTER_SHADOW: u32 = 2u;
const COUNTER_TURN: u32 = 3u;         // which of the two queues is read in this bounce
const COUNTER_CLOSEST_RAYS: u32 = 4u; // traced since the last clearing
const COUNTER_SHADOW_RAYS: u32 = 5u;
const COUNTER_CLAMPED: u32 = 6u;      // samples that frame.clamp has darkened
const COUNTER_CLASSES: u32 = 8u;      // and on: length of each class' queue
const COUNTERS: u32 = COUNTER_CLASSES + CLASSES;

const WORKGROUP: u32 = 64u;
// In the last word of PLANE_RADIANCE, above the place.
const COVERED: u32 = 0x40000000u;

const RAY_INFINITY: f32 = 3.4028234e38;

@group(1) @binding(0) var<storage, read_write> paths: array<vec4<u32>>;
@group(1) @binding(1) var<storage, read_write> counters: array<atomic<u32>>;

struct Path {
    ray: Ray,
    bounce: u32,
    pdf_bsdf: f32,
    delta: bool,
    beta: vec3<f32>,
    eta_scale: f32,
    media: vec3<u32>,
    wavelength: f32,  // nanometres; 0 while all wavelengths go one way
    rng: Rng,
}

fn plane(which: u32, slot: u32) -> u32 {
    return which * frame.capacity + slot;
}

fn load_ray(slot: u32) -> Ray {
    return ray_of(
        paths[plane(PLANE_RAY_ORIGIN, slot)], paths[plane(PLANE_RAY_DIRECTION, slot)], paths[plane(PLANE_RNG, slot)]);
}

// The ray of a path whose entries of these planes are given.
fn ray_of(origin: vec4<u32>, direction: vec4<u32>, rng: vec4<u32>) -> Ray {
    return Ray(
        bitcast<vec3<f32>>(origin.xyz), bitcast<f32>(rng.w), bitcast<vec3<f32>>(direction.xyz), RAY_INFINITY,
        path_time(Rng(rng.y, rng.z, 0u)));
}

fn load_path(slot: u32) -> Path {
    let origin = paths[plane(PLANE_RAY_ORIGIN, slot)];
    let direction = paths[plane(PLANE_RAY_DIRECTION, slot)];
    let beta = bitcast<vec4<f32>>(paths[plane(PLANE_BETA, slot)]);
    let rng = paths[plane(PLANE_RNG, slot)];
    let pdf = bitcast<f32>(direction.w);
    var media = vec4(MEDIA_NONE, 0u);
    if MEDIA {
        media = paths[plane(PLANE_MEDIA, slot)];
    }
    return Path(
        ray_of(origin, direction, rng),
        origin.w, abs(pdf), pdf < 0.0, beta.xyz, beta.w, media.xyz, bitcast<f32>(media.w), Rng(rng.y, rng.z, 0u),
    );
}

fn store_path(slot: u32, path: Path) {
    let pdf = select(path.pdf_bsdf, -path.pdf_bsdf, path.delta);
    paths[plane(PLANE_RAY_ORIGIN, slot)] = vec4(bitcast<vec3<u32>>(path.ray.origin), path.bounce);
    paths[plane(PLANE_RAY_DIRECTION, slot)] =
        vec4(bitcast<vec3<u32>>(path.ray.direction), bitcast<u32>(pdf));
    paths[plane(PLANE_BETA, slot)] = bitcast<vec4<u32>>(vec4(path.beta, path.eta_scale));
    paths[plane(PLANE_RNG, slot)] =
        vec4(0u, path.rng.pixel_seed, path.rng.index, bitcast<u32>(path.ray.t_min));
    if MEDIA {
        paths[plane(PLANE_MEDIA, slot)] = vec4(path.media, bitcast<u32>(path.wavelength));
    }
}

fn load_hit(slot: u32) -> Hit {
    let hit = paths[plane(PLANE_HIT, slot)];
    let t_u_v = bitcast<vec3<f32>>(hit.xyz);
    return Hit(t_u_v.x, t_u_v.y, t_u_v.z, hit.w, paths[plane(PLANE_RNG, slot)].x);
}

fn store_hit(slot: u32, hit: Hit) {
    paths[plane(PLANE_HIT, slot)] = vec4(bitcast<vec3<u32>>(vec3(hit.t, hit.u, hit.v)), hit.instance);
    paths[plane(PLANE_RNG, slot)].x = hit.triangle;
}

// A sample that has brought nothing yet, at a place in its pixel, and covered: something is there.
fn start_radiance(slot: u32, place: vec2<u32>) {
    paths[plane(PLANE_RADIANCE, slot)] = vec4(0u, 0u, 0u, COVERED | place.x | (place.y << PLACE_BITS));
}

// The place in its pixel of a sample of PLANE_RADIANCE.
fn sample_place(radiance: vec4<u32>) -> vec2<u32> {
    return vec2(radiance.w, radiance.w >> PLACE_BITS) & vec2((1u << PLACE_BITS) - 1u);
}

fn is_covered(radiance: vec4<u32>) -> bool {
    return (radiance.w & COVERED) != 0u;
}

// Nothing is there: alpha is 0.
fn uncover(slot: u32) {
    paths[plane(PLANE_RADIANCE, slot)].w &= ~COVERED;
}

// Adds to the path's radiance. One invocation at a time has a path, so no atomics are needed and the
// order of a path's additions is the order of its bounces.
fn add_radiance(slot: u32, L: vec3<f32>) {
    let at = plane(PLANE_RADIANCE, slot);
    let before = paths[at];
    paths[at] = vec4(bitcast<vec3<u32>>(bitcast<vec3<f32>>(before.xyz) + L), before.w);
}

// The slot at a place of the queue that this bounce reads; NONE past its end.
fn queued_path(place: u32) -> u32 {
    let turn = atomicLoad(&counters[COUNTER_TURN]);
    if place >= atomicLoad(&counters[COUNTER_PATHS + turn]) {
        return NONE;
    }
    return paths[plane(PLANE_QUEUES, place)][turn];
}

// Puts a path whose ray has been traced in the queue of those that are shaded alike.
fn queue_class(slot: u32, shading_class: u32) {
    let place = atomicAdd(&counters[COUNTER_CLASSES + shading_class], 1u);
    paths[plane(PLANE_CLASSES + shading_class / 4u, place)][shading_class % 4u] = slot;
}

// The slot at a place of the queue of this kernel's class; NONE past its end.
fn queued_of_class(place: u32) -> u32 {
    if place >= atomicLoad(&counters[COUNTER_CLASSES + SHADED_CLASS]) {
        return NONE;
    }
    return paths[plane(PLANE_CLASSES + SHADED_CLASS / 4u, place)][SHADED_CLASS % 4u];
}

// Puts a path in the queue that the next bounce reads.
fn queue_path(slot: u32) {
    let turn = 1u - atomicLoad(&counters[COUNTER_TURN]);
    let place = atomicAdd(&counters[COUNTER_PATHS + turn], 1u);
    if turn == 0u {
        paths[plane(PLANE_QUEUES, place)].x = slot;
    } else {
        paths[plane(PLANE_QUEUES, place)].y = slot;
    }
}

fn queue_shadow_ray(slot: u32, bounce: u32, ray: Ray, light: vec3<f32>, ior: f32) {
    paths[plane(PLANE_SHADOW_ORIGIN, slot)] = vec4(bitcast<vec3<u32>>(ray.origin), bitcast<u32>(ray.t_max));
    paths[plane(PLANE_SHADOW_DIRECTION, slot)] = vec4(bitcast<vec3<u32>>(ray.direction), bounce);
    paths[plane(PLANE_SHADOW_LIGHT, slot)] = vec4(bitcast<vec3<u32>>(light), bitcast<u32>(ior));
    let place = atomicAdd(&counters[COUNTER_SHADOW], 1u);
    paths[plane(PLANE_QUEUES, place)].z = slot;
}
