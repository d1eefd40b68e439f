//! glTF's material with its extensions, energy-exact. From the outside in: a clear coat, a sheen, and the
//! base, which is a dielectric and a metal mixed (glTF 2.0 appendix B). What a layer reflects towards wo is
//! missing below it, so that a furnace stays what the base makes of it; coat and sheen are not reciprocal
//! for that, as in their extensions. Rough facets get back what they miss (bsdf/multiple_scattering).
//!
//! Appendix B adds diffuse and specular by `fresnel_mix`, 1 - F(wo . wm) of the diffuse part: that is not
//! reciprocal in energy and exceeds 1 in a white furnace. Here the diffuse part gets what the dielectric's
//! surface lets pass on the way in and on the way out (Kelemen and Szirmay-Kalos 2001, "A Microfacet Based
//! Coupled Specular-Matte BRDF Model with Importance Sampling", eq. 14), transmitted or reflected.
//!
//! Light that passes the surface of a transmissive medium, refracted or diffuse, has its radiance
//! multiplied by 1 / eta^2. A medium behind diffuse transmission alone has no optical surface: no factor.

use super::Bsdf;
use super::albedo::{albedo_average_ggx, albedo_ggx, albedo_sheen};
use super::boundary::{
    Energy, F_boundary, T_boundary, T_entering_average, boundary_energy_at,
    boundary_energy_average, boundary_returned, boundary_weight, is_refractive, is_transmissive,
    transmits_smoothly,
};
use super::coat::{coat_albedo, coat_eval, coat_facets, coat_sample, is_coated};
use super::distribution::is_smooth;
use super::fresnel::{T_dielectric, schlick_weight};
use super::iridescence::{F_filmed, F0_filmed, T_filmed, is_filmed};
use super::lobe::{
    BsdfEval, BsdfSample, DELTA, EvalAndSample, MIN_COS, is_reflected, is_transmitted, mirrored,
    no_eval, no_sample, sample_of,
};
use super::multiple_scattering::{F_multiple, f_multiple};
use super::sheen::f_sheen;
use super::specular::reflection_direction;
use super::torrance_sparrow::{half_vector, mirror_sample, torrance_sparrow_shape};
use super::transmission::{transmission_sample, transmission_shape};
use crate::cpu::math::{INV_PI, luminance, sqr};
use crate::cpu::sample::{pdf_cosine_hemisphere, sample_cosine_hemisphere};
use crate::shared::{GLTF_INSIDE, Tables};
use glam::{DVec2, DVec3};

/// Where several lobes exist, each is chosen at least about so often, or so many times as often as its
/// albedo says: a lobe can be brighter than its mean over directions, and weights stay bounded.
pub const LOBE_PROBABILITY_MIN: f64 = 0.1;
pub const REFLECTION_OVERSAMPLING_MAX: f64 = 1e4;
/// What is not reflected may be rounding, of 1 - E.
pub const REST_OVERSAMPLING_MAX: f64 = 3.0;
/// What the diffuse part divides by at least; only a dielectric that reflects everything gets there.
pub const PASSED_AVERAGE_MIN: f64 = 1e-4;

/// One side of the dielectric's surface, seen by even light.
#[derive(Clone, Copy, Debug, Default)]
pub struct Side {
    pub average: Energy,
    /// Share of what is missing that is reflected at last.
    pub returned: DVec3,
    /// What passes the surface, on average.
    pub passed: DVec3,
}

/// What does not depend on wi.
#[derive(Clone, Copy, Debug, Default)]
pub struct GltfView {
    /// By which the tables are looked up.
    pub roughness: f64,
    /// Of the dielectric part; under a film, of facets without one that reflect as much to wo.
    pub F0: DVec3,
    pub metal_F0: DVec3,
    pub near: Side,
    pub far: Side,
    /// Of the dielectric's facets towards wo.
    pub energy: Energy,
    /// What passes the dielectric's surface on its way to wo.
    pub passed: DVec3,
    pub metal_energy: Energy,
    pub metal_average: Energy,
    pub metal_returned: DVec3,
    /// What the coat reflects.
    pub coat: f64,
    /// Factor on the sheen's f.
    pub sheen: DVec3,
    /// What is left of the light that comes from below a layer.
    pub below_coat: f64,
    pub below_sheen: f64,
    /// Probabilities of the ways to sample; they add up to 1, or are all 0.
    pub p_coat: f64,
    pub p_reflection: f64,
    pub p_transmission: f64,
    pub p_above: f64,
    pub p_below: f64,
}

pub fn is_sheened(bsdf: &Bsdf) -> bool {
    bsdf.gltf.sheen_color.cmpgt(DVec3::ZERO).any() && bsdf.gltf.flags & GLTF_INSIDE == 0
}

pub fn is_anisotropic(bsdf: &Bsdf) -> bool {
    bsdf.alpha.x != bsdf.alpha.y
}

/// A direction in the frame of the anisotropy (`KHR_materials_anisotropy`: its direction is the frame's x).
pub fn anisotropy_from_local(bsdf: &Bsdf, w: DVec3) -> DVec3 {
    if !is_anisotropic(bsdf) {
        return w;
    }
    let r = bsdf.gltf.rotation;
    DVec3::new(r.x * w.x + r.y * w.y, r.x * w.y - r.y * w.x, w.z)
}

pub fn local_from_anisotropy(bsdf: &Bsdf, w: DVec3) -> DVec3 {
    if !is_anisotropic(bsdf) {
        return w;
    }
    let r = bsdf.gltf.rotation;
    DVec3::new(r.x * w.x - r.y * w.y, r.x * w.y + r.y * w.x, w.z)
}

/// The roughness whose isotropic lobe reflects about as much: of the geometric mean of both widths.
pub fn albedo_roughness(bsdf: &Bsdf) -> f64 {
    if !is_anisotropic(bsdf) {
        return bsdf.roughness;
    }
    (bsdf.alpha.x * bsdf.alpha.y).sqrt().sqrt()
}

/// What light there is below the facets of the dielectric part: transmitted, or diffuse.
pub fn transmission_share(bsdf: &Bsdf) -> f64 {
    if is_transmissive(bsdf) {
        return bsdf.gltf.transmission;
    }
    0.0
}

pub fn diffuse_transmission_share(bsdf: &Bsdf) -> f64 {
    bsdf.gltf.diffuse_transmission
}

/// Whether the dielectric part has more than what its facets reflect and transmit at once: a diffuse part
/// below, or light that is left for multiple scattering.
pub fn has_rest(bsdf: &Bsdf) -> bool {
    !is_smooth(bsdf) || transmission_share(bsdf) < 1.0
}

/// The index seen from the other side, on which transmitted light travels.
pub fn eta_below(bsdf: &Bsdf) -> f64 {
    if is_refractive(bsdf) {
        return 1.0 / bsdf.eta.x;
    }
    bsdf.eta.x
}

/// What passes the surface at last.
pub fn passed_energy(energy: Energy, returned: DVec3) -> DVec3 {
    energy.transmitted + (1.0 - returned) * energy.missing
}

pub fn metal_energy_of(F0: DVec3, E: DVec2, smooth_lobe: bool) -> Energy {
    let missing = if smooth_lobe {
        0.0
    } else {
        (1.0 - (E.x + E.y)).max(0.0)
    };
    Energy {
        reflected: F0 * E.x + E.y,
        transmitted: DVec3::ZERO,
        missing: DVec3::splat(missing),
    }
}

pub fn side_of(
    bsdf: &Bsdf,
    F0: DVec3,
    entering: DVec3,
    eta: f64,
    average: Energy,
    other: Energy,
) -> Side {
    let returned = boundary_returned(bsdf, F0, entering, eta, average, other);
    Side {
        average,
        returned,
        passed: passed_energy(average, returned),
    }
}

/// Probabilities of lobes in proportion to their albedos, none too small and those of absent lobes 0.
pub fn lobe_probability(albedo: f64, total: f64, oversampling_max: f64) -> f64 {
    albedo.max((LOBE_PROBABILITY_MIN * total).min(oversampling_max * albedo))
}

/// Reflectance of the metal's facets.
pub fn F_metal(bsdf: &Bsdf, cos_theta: f64) -> DVec3 {
    bsdf.reflectance + (1.0 - bsdf.reflectance) * schlick_weight(cos_theta)
}

pub fn gltf_view(tables: &Tables, bsdf: &Bsdf, wo: DVec3) -> GltfView {
    let mut view = GltfView::default();
    let g = bsdf.gltf;
    let eta = bsdf.eta.x;
    let is_delta = is_smooth(bsdf);
    let roughness = albedo_roughness(bsdf);
    view.roughness = roughness;
    view.F0 = g.F0;
    view.metal_F0 = bsdf.reflectance;
    if is_filmed(bsdf) {
        let dielectric = F_filmed(tables, bsdf, wo.z, F_boundary(bsdf, wo.z));
        view.F0 = F0_filmed(dielectric, g.F90, boundary_weight(bsdf, wo.z));
        let metal = F_filmed(tables, bsdf, wo.z, F_metal(bsdf, wo.z));
        view.metal_F0 = F0_filmed(metal, 1.0, schlick_weight(wo.z));
    }

    // What has no part in the mixture is left at 0: it is only ever multiplied by its share.
    if g.metallic < 1.0 {
        view.energy = boundary_energy_at(tables, bsdf, view.F0, eta, roughness, wo.z);
        if has_rest(bsdf) {
            let entering = T_entering_average(tables, bsdf, view.F0, eta);
            let near = boundary_energy_average(tables, bsdf, view.F0, eta, roughness);
            let mut far = near;
            if is_refractive(bsdf) {
                far = boundary_energy_average(tables, bsdf, view.F0, 1.0 / eta, roughness);
            }
            view.near = side_of(bsdf, view.F0, entering, eta, near, far);
            view.far = view.near;
            if is_refractive(bsdf) {
                view.far = side_of(bsdf, view.F0, entering, 1.0 / eta, far, near);
            }
            view.passed = passed_energy(view.energy, view.near.returned);
        }
    }
    if g.metallic > 0.0 {
        view.metal_energy = metal_energy_of(
            view.metal_F0,
            albedo_ggx(tables, wo.z, roughness, is_delta),
            is_delta,
        );
        view.metal_average = metal_energy_of(
            view.metal_F0,
            albedo_average_ggx(tables, roughness, is_delta),
            is_delta,
        );
        view.metal_returned = F_multiple(
            view.metal_F0 + (1.0 - view.metal_F0) / 21.0,
            1.0 - view.metal_average.missing.x,
        );
    }

    view.below_coat = 1.0;
    if is_coated(bsdf) {
        view.coat = coat_albedo(tables, bsdf, wo);
        view.below_coat = 1.0 - view.coat;
    }
    view.below_sheen = 1.0;
    let mut sheen_albedo = DVec3::ZERO;
    if is_sheened(bsdf) {
        let E = albedo_sheen(tables, wo.z, g.sheen_roughness);
        let strongest = g.sheen_color.max_element() * E;
        // At grazing views the extension's lobe returns more than it gets.
        view.sheen = g.sheen_color / strongest.max(1.0);
        sheen_albedo = view.sheen * E;
        view.below_sheen = (1.0 - strongest).max(0.0);
    }

    let transmitted = transmission_share(bsdf);
    let below = diffuse_transmission_share(bsdf);
    let dielectric = 1.0 - g.metallic;
    let diffuse = dielectric * (1.0 - transmitted) * view.passed;
    let refracted = dielectric * transmitted * bsdf.reflectance;
    let base = view.below_coat * view.below_sheen;
    let reflection = base
        * luminance(dielectric * view.energy.reflected + g.metallic * view.metal_energy.reflected);
    let transmission = base * luminance(refracted * view.energy.transmitted);
    let cosine_above = view.below_coat * luminance(sheen_albedo)
        + base
            * luminance(
                (1.0 - below) * bsdf.reflectance * diffuse
                    + dielectric * view.near.returned * view.energy.missing
                    + g.metallic * view.metal_returned * view.metal_energy.missing,
            );
    let cosine_below = base
        * luminance(
            below * g.diffuse_transmission_color * diffuse
                + refracted * (1.0 - view.near.returned) * view.energy.missing,
        );
    let total = view.coat + reflection + transmission + cosine_above + cosine_below;
    view.p_coat = lobe_probability(view.coat, total, REFLECTION_OVERSAMPLING_MAX);
    view.p_reflection = lobe_probability(reflection, total, REFLECTION_OVERSAMPLING_MAX);
    view.p_transmission = lobe_probability(transmission, total, REST_OVERSAMPLING_MAX);
    view.p_above = lobe_probability(cosine_above, total, REST_OVERSAMPLING_MAX);
    view.p_below = lobe_probability(cosine_below, total, REST_OVERSAMPLING_MAX);
    let sum = view.p_coat + view.p_reflection + view.p_transmission + view.p_above + view.p_below;
    if sum > 0.0 {
        view.p_coat /= sum;
        view.p_reflection /= sum;
        view.p_transmission /= sum;
        view.p_above /= sum;
        view.p_below /= sum;
    }
    view
}

/// Reflectance of the facets, dielectric and metal mixed.
pub fn F_gltf(tables: &Tables, bsdf: &Bsdf, cos_theta: f64) -> DVec3 {
    let dielectric = F_filmed(tables, bsdf, cos_theta, F_boundary(bsdf, cos_theta));
    let metal = F_filmed(tables, bsdf, cos_theta, F_metal(bsdf, cos_theta));
    dielectric.lerp(metal, bsdf.gltf.metallic)
}

/// Factor on what facets transmit, with `T_dielectric` of the facet.
pub fn T_gltf(tables: &Tables, bsdf: &Bsdf, cos_theta: f64, T: f64) -> DVec3 {
    let F = F_boundary(bsdf, cos_theta);
    let facet = T_filmed(tables, bsdf, cos_theta, F, T_boundary(bsdf, T));
    (1.0 - bsdf.gltf.metallic) * transmission_share(bsdf) * bsdf.reflectance * facet
}

/// All that is reflected above and is no delta, and the density of it. `energy` is the dielectric's of wi.
pub fn gltf_reflection(
    tables: &Tables,
    bsdf: &Bsdf,
    view: &GltfView,
    energy: Energy,
    wo: DVec3,
    wi: DVec3,
) -> BsdfEval {
    let g = bsdf.gltf;
    let is_delta = is_smooth(bsdf);
    let dielectric = 1.0 - g.metallic;
    let mut f = DVec3::ZERO;
    let mut pdf = view.p_above * pdf_cosine_hemisphere(wi.z);
    if dielectric > 0.0 {
        let passed = passed_energy(energy, view.near.returned);
        let diffuse = bsdf.reflectance
            * (dielectric
                * (1.0 - transmission_share(bsdf))
                * (1.0 - diffuse_transmission_share(bsdf)));
        let passed_average = view.near.passed.max(DVec3::splat(PASSED_AVERAGE_MIN));
        f += diffuse * INV_PI * (view.passed * passed / passed_average);
    }
    if !is_delta {
        let dielectric_lobe = f_multiple(
            view.energy.missing,
            energy.missing,
            view.near.average.missing,
        );
        f += dielectric * view.near.returned * dielectric_lobe;
        if g.metallic > 0.0 {
            let metal_energy = metal_energy_of(
                view.metal_F0,
                albedo_ggx(tables, wi.z, view.roughness, is_delta),
                is_delta,
            );
            let metal_lobe = f_multiple(
                view.metal_energy.missing,
                metal_energy.missing,
                view.metal_average.missing,
            );
            f += g.metallic * view.metal_returned * metal_lobe;
        }
        let base_wo = anisotropy_from_local(bsdf, wo);
        let base_wi = anisotropy_from_local(bsdf, wi);
        let wm = half_vector(base_wo, base_wi);
        let shape = torrance_sparrow_shape(bsdf, base_wo, base_wi, wm.truncate(), wm.w);
        f += F_gltf(tables, bsdf, wm.w) * shape.x;
        pdf += view.p_reflection * shape.y;
    }
    f *= view.below_sheen;
    if is_sheened(bsdf) {
        f += view.sheen * f_sheen(g.sheen_roughness, wo, wi);
    }
    f *= view.below_coat;
    if is_coated(bsdf) {
        let coat = coat_eval(bsdf, wo, wi);
        f += coat.f;
        pdf += view.p_coat * coat.pdf;
    }
    BsdfEval { f, pdf }
}

/// All that comes from below and is no delta, and the density of it. `energy` is the dielectric's of wi.
pub fn gltf_transmission(
    tables: &Tables,
    bsdf: &Bsdf,
    view: &GltfView,
    energy: Energy,
    wo: DVec3,
    wi: DVec3,
) -> BsdfEval {
    let g = bsdf.gltf;
    let dielectric = 1.0 - g.metallic;
    let radiance = if is_refractive(bsdf) {
        sqr(eta_below(bsdf))
    } else {
        1.0
    };
    let passed = passed_energy(energy, view.far.returned);
    // Both averages are the same but for eta^2, within the tables' precision: their mean is reciprocal.
    let passed_average = (view.near.passed * view.far.passed * radiance).map(f64::sqrt);
    let diffuse = g.diffuse_transmission_color
        * (dielectric * (1.0 - transmission_share(bsdf)) * diffuse_transmission_share(bsdf));
    let mut f = diffuse
        * (INV_PI * radiance)
        * (view.passed * passed / passed_average.max(DVec3::splat(PASSED_AVERAGE_MIN)));
    let mut pdf = view.p_below * pdf_cosine_hemisphere(-wi.z);
    if is_transmissive(bsdf) && !transmits_smoothly(bsdf) {
        f += bsdf.reflectance
            * (dielectric * transmission_share(bsdf) * radiance)
            * (1.0 - view.near.returned)
            * f_multiple(
                view.energy.missing,
                energy.missing,
                view.far.average.missing,
            );
        let shape = transmission_shape(
            bsdf,
            anisotropy_from_local(bsdf, wo),
            anisotropy_from_local(bsdf, wi),
        );
        f += T_gltf(tables, bsdf, shape.z, shape.w) * shape.x;
        pdf += view.p_transmission * shape.y;
    }
    BsdfEval {
        f: f * (view.below_coat * view.below_sheen),
        pdf,
    }
}

pub fn gltf_eval_view(
    tables: &Tables,
    bsdf: &Bsdf,
    view: &GltfView,
    wo: DVec3,
    wi: DVec3,
) -> BsdfEval {
    if !is_reflected(wo, wi) && !is_transmitted(wo, wi) {
        return no_eval();
    }
    let mut energy = Energy::default();
    if bsdf.gltf.metallic < 1.0 {
        let eta = if wi.z < 0.0 {
            eta_below(bsdf)
        } else {
            bsdf.eta.x
        };
        energy = boundary_energy_at(tables, bsdf, view.F0, eta, view.roughness, wi.z.abs());
    }
    if is_reflected(wo, wi) {
        return gltf_reflection(tables, bsdf, view, energy, wo, wi);
    }
    gltf_transmission(tables, bsdf, view, energy, wo, wi)
}

/// The parts that are no delta; the pdf is that of `gltf_sample`, lobe's choice included.
pub fn gltf_eval(tables: &Tables, bsdf: &Bsdf, wo: DVec3, wi: DVec3) -> BsdfEval {
    if wo.z < MIN_COS {
        return no_eval();
    }
    gltf_eval_view(tables, bsdf, &gltf_view(tables, bsdf, wo), wo, wi)
}

/// A way to sample by u.x, a direction in it by u.yz.
pub fn gltf_sample(tables: &Tables, bsdf: &Bsdf, wo: DVec3, u: DVec3) -> BsdfSample {
    if wo.z < MIN_COS {
        return no_sample();
    }
    let view = gltf_view(tables, bsdf, wo);
    let drawn = gltf_draw(tables, bsdf, &view, wo, u);
    if drawn.delta != 0 || drawn.pdf == 0.0 {
        return drawn;
    }
    sample_of(drawn.wi, gltf_eval_view(tables, bsdf, &view, wo, drawn.wi))
}

/// The same direction, of a delta with f. What is no delta has f and its density, which is not 0 yet, from
/// `gltf_eval_view`.
pub fn gltf_draw(tables: &Tables, bsdf: &Bsdf, view: &GltfView, wo: DVec3, u: DVec3) -> BsdfSample {
    let u_direction = DVec2::new(u.y, u.z);
    let base = view.below_coat * view.below_sheen;
    let coat_end = view.p_coat;
    let reflection_end = coat_end + view.p_reflection;
    let transmission_end = reflection_end + view.p_transmission;
    let above_end = transmission_end + view.p_above;
    let mut drawn;
    if is_coated(bsdf) && u.x < coat_end {
        drawn = coat_sample(bsdf, wo, u_direction);
        drawn.pdf *= view.p_coat;
    } else if u.x < reflection_end {
        let base_wo = anisotropy_from_local(bsdf, wo);
        drawn = if is_smooth(bsdf) {
            BsdfSample {
                wi: DVec3::new(-wo.x, -wo.y, wo.z),
                f: F_gltf(tables, bsdf, wo.z) * (base / wo.z),
                pdf: view.p_reflection,
                delta: DELTA,
            }
        } else {
            let wi = reflection_direction(base_wo, mirror_sample(bsdf, base_wo, u_direction));
            BsdfSample {
                wi: local_from_anisotropy(bsdf, wi),
                f: DVec3::ZERO,
                pdf: view.p_reflection,
                delta: 0,
            }
        };
    } else if is_transmissive(bsdf) && u.x < transmission_end {
        drawn = transmission_sample(bsdf, anisotropy_from_local(bsdf, wo), u_direction);
        drawn.wi = local_from_anisotropy(bsdf, drawn.wi);
        drawn.f *= T_gltf(tables, bsdf, wo.z, T_dielectric(wo.z, bsdf.eta.x)) * base;
        drawn.pdf *= view.p_transmission;
    } else {
        let wi = sample_cosine_hemisphere(u_direction);
        drawn = BsdfSample {
            wi: if u.x < above_end { wi } else { mirrored(wi) },
            f: DVec3::ZERO,
            pdf: view.p_above + view.p_below,
            delta: 0,
        };
    }
    // A facet may send the reflected ray below the horizon, where it is nobody's sample.
    if drawn.delta == 0 && u.x < reflection_end && drawn.wi.z < MIN_COS {
        return no_sample();
    }
    drawn
}

/// `gltf_eval` for wi, where there is one, and `gltf_sample` by u. What does not depend on wi is made once for
/// both.
pub fn gltf_eval_and_sample(
    tables: &Tables,
    bsdf: &Bsdf,
    wo: DVec3,
    wi: Option<DVec3>,
    u: DVec3,
) -> EvalAndSample {
    let mut both = EvalAndSample {
        eval: no_eval(),
        sample: no_sample(),
    };
    if wo.z < MIN_COS {
        return both;
    }
    let view = gltf_view(tables, bsdf, wo);
    both.sample = gltf_draw(tables, bsdf, &view, wo, u);
    if gltf_is_delta(bsdf) {
        return both;
    }
    if let Some(wi) = wi {
        both.eval = gltf_eval_view(tables, bsdf, &view, wo, wi);
    }
    if both.sample.delta == 0 && both.sample.pdf > 0.0 {
        let wi = both.sample.wi;
        both.sample = sample_of(wi, gltf_eval_view(tables, bsdf, &view, wo, wi));
    }
    both
}

/// Whether there is nothing but deltas, whatever wo is.
pub fn gltf_is_delta(bsdf: &Bsdf) -> bool {
    let g = bsdf.gltf;
    let is_diffuse = g.metallic < 1.0 && transmission_share(bsdf) < 1.0;
    let coat_is_rough = is_coated(bsdf) && !is_smooth(&coat_facets(bsdf));
    is_smooth(bsdf) && !is_diffuse && !coat_is_rough && !is_sheened(bsdf)
}

/// Whether light from the other side may come through.
pub fn gltf_transmits(bsdf: &Bsdf) -> bool {
    transmission_share(bsdf) > 0.0 || diffuse_transmission_share(bsdf) > 0.0
}

/// What a smooth thin wall passes straight on, the expectation of its samples that are `DELTA_STRAIGHT`.
pub fn gltf_straight_transmittance(tables: &Tables, bsdf: &Bsdf, wo: DVec3) -> DVec3 {
    if !is_transmissive(bsdf) || is_refractive(bsdf) || !is_smooth(bsdf) || wo.z < MIN_COS {
        return DVec3::ZERO;
    }
    let view = gltf_view(tables, bsdf, wo);
    T_gltf(tables, bsdf, wo.z, T_dielectric(wo.z, bsdf.eta.x))
        * (view.below_coat * view.below_sheen)
}
