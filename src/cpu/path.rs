//! The estimator: one path from the camera, in one function; `cpu::render` loops over pixels around it.
//! The GPU's kernels (`shaders/kernels`) are the sentences of `Li` taken apart.

use super::bsdf::bsdf::{bsdf_eval_and_sample, bsdf_is_delta, bsdf_transmits};
use super::bsdf::lobe::{DELTA_STRAIGHT, EvalAndSample};
use super::bvh::trace_closest;
use super::estimator::*;
use super::light::environment::Le_environment;
use super::light::light::{light_pdf_environment, light_pdf_triangle, light_sample};
use super::light::tree::light_share;
use super::material::{Le_surface, bsdf_at};
use super::math::{to_local, to_world};
use super::medium::{MEDIA_NONE, interface_at, media_far, media_ior, media_near, transmittance};
use super::ray::{Ray, offset_origin};
use super::rng::{Rng, next_1d, next_2d};
use super::spectrum::{sample_wavelength, wavelength_weight};
use super::surface::surface_at;
use super::visibility::visibility;
use crate::pack::Packed;
use crate::render::Counts;
use crate::shared::{
    BACKGROUND_COLOR, BACKGROUND_TRANSPARENT, BSDF_UNLIT, MATERIAL_TRANSMISSIVE, NONE,
};
use glam::DVec3;

/// Radiance along a camera ray, and its alpha: one sample of the path integral (Kajiya 1986, "The
/// rendering equation"), with next-event estimation weighted against BSDF sampling (Veach 1997).
pub fn Li(packed: &Packed, camera_ray: Ray, rng: &mut Rng, counts: &mut Counts) -> (DVec3, f64) {
    let frame = &packed.frame;
    let mut ray = camera_ray;
    let mut L = DVec3::ZERO;
    let mut beta = DVec3::ONE;
    let mut eta_scale = 1.0;
    // Nanometres; 0 while all wavelengths go one way.
    let (mut media, mut wavelength) = (MEDIA_NONE, 0.0);
    // The camera's ray counts as a delta sample: no light could have been chosen for it.
    let (mut pdf_bsdf, mut delta) = (1.0, true);
    for bounce in 0.. {
        counts.closest_rays += 1;
        let hit = trace_closest(packed, ray, ray_alpha_seed(*rng, 2 * bounce));
        if hit.instance == NONE {
            if bounce == 0 {
                return background(packed, &ray);
            }
            let weight = match delta {
                true => 1.0,
                false => power_heuristic(pdf_bsdf, light_pdf_environment(packed, ray.direction)),
            };
            L += beta * Le_environment(packed, ray.direction) * weight;
            break;
        }
        let surface = surface_at(packed, ray, hit);
        let material = &packed.materials[surface.material as usize];
        media = media_near(packed, media, surface.material, surface.front);
        beta *= transmittance(packed, media, hit.t - ray.t_min);

        let Le = Le_surface(packed, material, &surface);
        if Le.max_element() > 0.0 {
            let cos_light = surface.ng.dot(ray.direction).abs();
            let weight = match delta {
                true => 1.0,
                false => power_heuristic(
                    pdf_bsdf,
                    light_pdf_triangle(
                        light_share(packed, ray.origin, hit.instance, hit.triangle),
                        f64::from(material.emission_weight),
                        hit.t,
                        cos_light,
                    ),
                ),
            };
            L += beta * Le * weight;
        }
        if bounce >= frame.max_depth || material.model == BSDF_UNLIT {
            break;
        }

        let mut interface =
            interface_at(packed, media, surface.material, surface.front, wavelength);
        let far = media_far(packed, media, surface.material, surface.front);
        if interface.hidden {
            // As a delta: no light was chosen that lies beyond.
            (media, delta) = (far, true);
            ray = Ray {
                origin: offset_origin(surface.p, surface.ng, ray.direction, surface.p_error),
                t_min: 0.0,
                ..ray
            };
            continue;
        }
        if interface.dispersive && wavelength == 0.0 {
            rng.dimension = bounce_dimension(bounce, DIMENSION_WAVELENGTH);
            wavelength = sample_wavelength(next_1d(rng));
            beta *= wavelength_weight(wavelength);
            interface = interface_at(packed, media, surface.material, surface.front, wavelength);
        }

        let bsdf = bsdf_at(packed, material, &surface, interface.eta);
        let wo = to_local(surface.basis, -ray.direction);
        let mut light = None;
        if frame.light_weight_total > 0.0 && !bsdf_is_delta(&bsdf) {
            rng.dimension = bounce_dimension(bounce, DIMENSION_LIGHT);
            let u_pick = next_1d(rng);
            let sample = light_sample(
                packed,
                surface.p,
                surface.basis.n,
                bsdf_transmits(&bsdf),
                u_pick,
                next_2d(rng),
                ray.time,
            );
            let wi = to_local(surface.basis, sample.wi);
            if sample.pdf > 0.0 && sides_agree(wi, sample.wi.dot(surface.ng)) {
                light = Some((sample, wi));
            }
        }
        rng.dimension = bounce_dimension(bounce, DIMENSION_BSDF);
        let u_lobe = next_1d(rng);
        let u = next_2d(rng);
        let u = DVec3::new(u_lobe, u.x, u.y);
        let wi = light.map(|(_, wi)| wi);
        let EvalAndSample { eval, sample } = bsdf_eval_and_sample(&packed.tables, &bsdf, wo, wi, u);
        if let Some((light, wi)) = light {
            let weight = match light.delta != 0 {
                true => 1.0,
                false => power_heuristic(light.pdf, eval.pdf),
            };
            let along = if wi.z < 0.0 { far } else { media };
            let Ld = beta
                * transmittance(packed, along, light.distance)
                * eval.f
                * wi.z.abs()
                * light.Le
                * (weight / light.pdf);
            let shadow = Ray {
                origin: offset_origin(surface.p, surface.ng, light.wi, surface.p_error),
                t_min: 0.0,
                direction: light.wi,
                t_max: light.distance * (1.0 - SHADOW_SHORTENING),
                time: ray.time,
            };
            if Ld != DVec3::ZERO {
                counts.shadow_rays += 1;
                L += Ld
                    * visibility(
                        packed,
                        shadow,
                        media_ior(packed, along, wavelength),
                        frame.max_depth - 1 - bounce,
                        ray_alpha_seed(*rng, 2 * bounce + 1),
                    );
            }
        }

        let wi = to_world(surface.basis, sample.wi);
        if sample.pdf == 0.0 || !sides_agree(sample.wi, wi.dot(surface.ng)) {
            break;
        }
        beta *= sample.f * (sample.wi.z.abs() / sample.pdf);
        if sample.wi.z < 0.0 && material.flags & MATERIAL_TRANSMISSIVE != 0 {
            media = far;
            eta_scale *= interface.eta * interface.eta;
        }
        if bounce >= ROULETTE_START {
            rng.dimension = bounce_dimension(bounce, DIMENSION_ROULETTE);
            let survival = roulette_probability(beta, eta_scale);
            if next_1d(rng) >= survival {
                break;
            }
            beta /= survival;
        }
        if beta == DVec3::ZERO {
            break;
        }
        if sample.delta == DELTA_STRAIGHT {
            // Still the same ray: light beyond is weighted as for its start.
            ray.t_min = hit.t;
            continue;
        }
        (pdf_bsdf, delta) = (sample.pdf, sample.delta != 0);
        ray = Ray {
            origin: offset_origin(surface.p, surface.ng, wi, surface.p_error),
            t_min: 0.0,
            direction: wi,
            t_max: f64::INFINITY,
            time: ray.time,
        };
    }
    (L, 1.0)
}

/// What a camera ray that meets nothing brings home, and its alpha.
fn background(packed: &Packed, ray: &Ray) -> (DVec3, f64) {
    match packed.frame.background_kind {
        BACKGROUND_TRANSPARENT => (DVec3::ZERO, 0.0),
        BACKGROUND_COLOR => (
            DVec3::from_array(packed.frame.background.map(f64::from)),
            1.0,
        ),
        _ => (Le_environment(packed, ray.direction), 1.0),
    }
}
