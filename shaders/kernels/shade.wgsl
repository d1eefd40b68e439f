// The middle of the path loop, for one bounce of one path whose ray met a surface of this kernel's class:
// add what it emits, choose a light and leave a shadow ray to it, choose where the path goes on, and
// queue it unless it ends here. Sentence by sentence the loop of src/cpu/path.rs.

import package::bindings::{frame, materials};
import package::shared::{NONE, BSDF_UNLIT, MATERIAL_TRANSMISSIVE};
import package::kernels::state::{Path, load_path, load_hit, store_path, queue_path, queue_shadow_ray, add_radiance, queued_of_class, counters, paths, RAY_INFINITY, WORKGROUP};
import package::math::{to_local, to_world};
import package::ray::{Ray, Hit, offset_origin};
import package::rng::{next_1d, next_2d};
import package::surface::{Surface, surface_at};
import package::material::{bsdf_at, Le_surface};
import package::light::light::{LightSample, light_sample, light_pdf_triangle};
import package::light::tree::{light_share};
import package::bsdf::bsdf::{bsdf_eval_and_sample, bsdf_is_delta, bsdf_transmits};
import package::bsdf::lobe::{DELTA_STRAIGHT};
import package::medium::{interface_at, media_ior, media_near, media_far, transmittance};
import package::spectrum::{sample_wavelength, wavelength_weight};
import package::variant::{MEDIA, BOUNDARIES, DISPERSION, EMISSION, THIN_WALLS};
import package::estimator::{power_heuristic, roulette_probability, bounce_dimension, sides_agree, DIMENSION_LIGHT, DIMENSION_BSDF, DIMENSION_ROULETTE, DIMENSION_WAVELENGTH, ROULETTE_START, SHADOW_SHORTENING};

@compute @workgroup_size(WORKGROUP)
fn shade_kernel(@builtin(global_invocation_id) id: vec3<u32>) {
    let slot = queued_of_class(id.x);
    if slot == NONE {
        return;
    }
    var path = load_path(slot);
    // A variable of its own: WebGPU has no pointers to a structure's members as arguments.
    var rng = path.rng;
    let hit = load_hit(slot);
    let surface = surface_at(path.ray, hit);
    let material = materials[surface.material];
    let front = surface.front != 0u;
    if MEDIA {
        path.media = media_near(path.media, surface.material, front);
        path.beta *= transmittance(path.media, hit.t - path.ray.t_min);
    }

    var Le = vec3(0.0);
    if EMISSION {
        Le = Le_surface(material, surface);
    }
    if EMISSION && any(Le > vec3(0.0)) {
        var weight = 1.0;
        if !path.delta {
            let cos_light = abs(dot(surface.ng, path.ray.direction));
            weight = power_heuristic(
                path.pdf_bsdf,
                light_pdf_triangle(
                    light_share(path.ray.origin, hit.instance, hit.triangle), material.emission_weight, hit.t, cos_light));
        }
        add_radiance(slot, path.beta * Le * weight);
    }
    if path.bounce >= frame.max_depth || material.model == BSDF_UNLIT {
        return;
    }

    var eta = material.ior;
    var far = path.media;
    if MEDIA {
        var boundary = interface_at(path.media, surface.material, front, path.wavelength);
        far = media_far(path.media, surface.material, front);
        if boundary.hidden != 0u {
            // As a delta: no light was chosen that lies beyond.
            path.media = far;
            path.delta = true;
            path.ray.origin = offset_origin(surface.p, surface.ng, path.ray.direction, surface.p_error);
            path.ray.t_min = 0.0;
            path.bounce += 1u;
            store_path(slot, path);
            queue_path(slot);
            return;
        }
        if DISPERSION && boundary.dispersive != 0u && path.wavelength == 0.0 {
            rng.dimension = bounce_dimension(path.bounce, DIMENSION_WAVELENGTH);
            path.wavelength = sample_wavelength(next_1d(&rng));
            path.beta *= wavelength_weight(path.wavelength);
            boundary = interface_at(path.media, surface.material, front, path.wavelength);
        }
        eta = boundary.eta;
    }

    let bsdf = bsdf_at(material, surface, eta);
    let wo = to_local(surface.basis, -path.ray.direction);
    var light: LightSample;
    var wi_light = vec3(0.0);
    if !bsdf_is_delta(bsdf) {
        rng.dimension = bounce_dimension(path.bounce, DIMENSION_LIGHT);
        let u_pick = next_1d(&rng);
        light = light_sample(surface.p, surface.basis.n, bsdf_transmits(bsdf), u_pick, next_2d(&rng), path.ray.time);
        let wi = to_local(surface.basis, light.wi);
        if light.pdf > 0.0 && sides_agree(wi, dot(light.wi, surface.ng)) {
            wi_light = wi;
        }
    }
    rng.dimension = bounce_dimension(path.bounce, DIMENSION_BSDF);
    let u_lobe = next_1d(&rng);
    let both = bsdf_eval_and_sample(bsdf, wo, wi_light, vec3(u_lobe, next_2d(&rng)));
    if !bsdf_is_delta(bsdf) && any(both.eval.f != vec3(0.0)) {
        let eval = both.eval;
        let weight = select(power_heuristic(light.pdf, eval.pdf), 1.0, light.delta != 0u);
        var L = path.beta * eval.f * abs(wi_light.z) * light.Le * (weight / light.pdf);
        var ior = 1.0;
        if MEDIA {
            let along = select(path.media, far, wi_light.z < 0.0);
            L *= transmittance(along, light.distance);
            ior = media_ior(along, path.wavelength);
        }
        if any(L != vec3(0.0)) {
            let origin = offset_origin(surface.p, surface.ng, light.wi, surface.p_error);
            let t_max = light.distance * (1.0 - SHADOW_SHORTENING);
            queue_shadow_ray(slot, path.bounce, Ray(origin, 0.0, light.wi, t_max, path.ray.time), L, ior);
        }
    }

    let sample = both.sample;
    let wi = to_world(surface.basis, sample.wi);
    if sample.pdf == 0.0 || !sides_agree(sample.wi, dot(wi, surface.ng)) {
        return;
    }
    path.beta *= sample.f * (abs(sample.wi.z) / sample.pdf);
    if BOUNDARIES && sample.wi.z < 0.0 && (material.flags & MATERIAL_TRANSMISSIVE) != 0u {
        path.media = far;
        path.eta_scale *= eta * eta;
    }
    if path.bounce >= ROULETTE_START {
        rng.dimension = bounce_dimension(path.bounce, DIMENSION_ROULETTE);
        let survival = roulette_probability(path.beta, path.eta_scale);
        if next_1d(&rng) >= survival {
            return;
        }
        path.beta /= survival;
    }
    if all(path.beta == vec3(0.0)) {
        return;
    }
    if THIN_WALLS && sample.delta == DELTA_STRAIGHT {
        // Still the same ray: light beyond is weighted as for its start.
        path.ray.t_min = hit.t;
    } else {
        path.pdf_bsdf = sample.pdf;
        path.delta = sample.delta != 0u;
        let origin = offset_origin(surface.p, surface.ng, wi, surface.p_error);
        path.ray = Ray(origin, 0.0, wi, RAY_INFINITY, path.ray.time);
    }
    path.bounce += 1u;
    store_path(slot, path);
    queue_path(slot);
}
