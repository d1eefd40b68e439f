// glTF's material with its extensions, energy-exact. From the outside in: a clear coat, a sheen, and the
// base, which is a dielectric and a metal mixed (glTF 2.0 appendix B). What a layer reflects towards wo is
// missing below it, so that a furnace stays what the base makes of it; coat and sheen are not reciprocal
// for that, as in their extensions. Rough facets get back what they miss (bsdf/multiple_scattering).
//
// Appendix B adds diffuse and specular by fresnel_mix, 1 - F(wo . wm) of the diffuse part: that is not
// reciprocal in energy and exceeds 1 in a white furnace. Here the diffuse part gets what the dielectric's
// surface lets pass on the way in and on the way out (Kelemen and Szirmay-Kalos 2001, "A Microfacet Based
// Coupled Specular-Matte BRDF Model with Importance Sampling", eq. 14), transmitted or reflected.
//
// Light that passes the surface of a transmissive medium, refracted or diffuse, has its radiance
// multiplied by 1 / eta^2. A medium behind diffuse transmission alone has no optical surface: no factor.

import package::shared::{Bsdf, GLTF_INSIDE};
import package::variant::{SHEEN, TRANSMISSION, DIFFUSE_TRANSMISSION, ANISOTROPY, METALS, DIELECTRICS, DIFFUSE};
import package::math::{INV_PI, sqr, luminance};
import package::sample::{sample_cosine_hemisphere, pdf_cosine_hemisphere};
import package::bsdf::lobe::{BsdfEval, BsdfSample, EvalAndSample, no_eval, no_sample, sample_of, mirrored, is_reflected, is_transmitted, DELTA, MIN_COS};
import package::bsdf::fresnel::{schlick_weight, T_dielectric};
import package::bsdf::distribution::{is_smooth};
import package::bsdf::specular::{reflection_direction};
import package::bsdf::torrance_sparrow::{half_vector, mirror_sample, torrance_sparrow_shape};
import package::bsdf::albedo::{albedo_ggx, albedo_average_ggx, albedo_sheen};
import package::bsdf::multiple_scattering::{f_multiple, F_multiple};
import package::bsdf::boundary::{Energy, is_transmissive, is_refractive, transmits_smoothly, boundary_weight, F_boundary, T_boundary, T_entering_average, boundary_energy_at, boundary_energy_average, boundary_returned};
import package::bsdf::transmission::{transmission_shape, transmission_sample};
import package::bsdf::iridescence::{is_filmed, F_filmed, T_filmed, F0_filmed};
import package::bsdf::coat::{is_coated, coat_facets, coat_albedo, coat_eval, coat_sample};
import package::bsdf::sheen::{f_sheen};

// Where several lobes exist, each is chosen at least about so often, or so many times as often as its
// albedo says: a lobe can be brighter than its mean over directions, and weights stay bounded.
const LOBE_PROBABILITY_MIN: f32 = 0.1;
const REFLECTION_OVERSAMPLING_MAX: f32 = 1e4;
const REST_OVERSAMPLING_MAX: f32 = 3.0; // what is not reflected may be rounding, of 1 - E
// What the diffuse part divides by at least; only a dielectric that reflects everything gets there.
const PASSED_AVERAGE_MIN: f32 = 1e-4;

// One side of the dielectric's surface, seen by even light.
struct Side {
    average: Energy,
    returned: vec3<f32>, // share of what is missing that is reflected at last
    passed: vec3<f32>,   // what passes the surface, on average
}

// What does not depend on wi.
struct GltfView {
    roughness: f32,      // by which the tables are looked up
    F0: vec3<f32>,       // of the dielectric part; under a film, of facets without one that reflect as much to wo
    metal_F0: vec3<f32>,
    near: Side,
    far: Side,
    energy: Energy,      // of the dielectric's facets towards wo
    passed: vec3<f32>,   // what passes the dielectric's surface on its way to wo
    metal_energy: Energy,
    metal_average: Energy,
    metal_returned: vec3<f32>,
    coat: f32,           // what the coat reflects
    sheen: vec3<f32>,    // factor on the sheen's f
    below_coat: f32,     // what is left of the light that comes from below a layer
    below_sheen: f32,
    // Probabilities of the ways to sample; they add up to 1, or are all 0.
    p_coat: f32,
    p_reflection: f32,
    p_transmission: f32,
    p_above: f32,
    p_below: f32,
}

fn is_sheened(bsdf: Bsdf) -> bool {
    return SHEEN && any(bsdf.gltf.sheen_color > vec3(0.0)) && (bsdf.gltf.flags & GLTF_INSIDE) == 0u;
}

fn is_anisotropic(bsdf: Bsdf) -> bool {
    return ANISOTROPY && bsdf.alpha.x != bsdf.alpha.y;
}

// A direction in the frame of the anisotropy (KHR_materials_anisotropy: its direction is the frame's x).
fn anisotropy_from_local(bsdf: Bsdf, w: vec3<f32>) -> vec3<f32> {
    if !is_anisotropic(bsdf) {
        return w;
    }
    let r = bsdf.gltf.rotation;
    return vec3(r.x * w.x + r.y * w.y, r.x * w.y - r.y * w.x, w.z);
}

fn local_from_anisotropy(bsdf: Bsdf, w: vec3<f32>) -> vec3<f32> {
    if !is_anisotropic(bsdf) {
        return w;
    }
    let r = bsdf.gltf.rotation;
    return vec3(r.x * w.x - r.y * w.y, r.x * w.y + r.y * w.x, w.z);
}

// The roughness whose isotropic lobe reflects about as much: of the geometric mean of both widths.
fn albedo_roughness(bsdf: Bsdf) -> f32 {
    if !is_anisotropic(bsdf) {
        return bsdf.roughness;
    }
    return sqrt(sqrt(bsdf.alpha.x * bsdf.alpha.y));
}

// What light there is below the facets of the dielectric part: transmitted, or diffuse.
fn transmission_share(bsdf: Bsdf) -> f32 {
    return select(0.0, bsdf.gltf.transmission, is_transmissive(bsdf));
}

fn diffuse_transmission_share(bsdf: Bsdf) -> f32 {
    return select(0.0, bsdf.gltf.diffuse_transmission, DIFFUSE_TRANSMISSION);
}

// Whether the dielectric part has more than what its facets reflect and transmit at once: a diffuse part
// below, or light that is left for multiple scattering.
fn has_rest(bsdf: Bsdf) -> bool {
    return !is_smooth(bsdf) || (DIFFUSE && transmission_share(bsdf) < 1.0);
}

// The index seen from the other side, on which transmitted light travels.
fn eta_below(bsdf: Bsdf) -> f32 {
    return select(bsdf.eta.x, 1.0 / bsdf.eta.x, is_refractive(bsdf));
}

// What passes the surface at last.
fn passed_energy(energy: Energy, returned: vec3<f32>) -> vec3<f32> {
    return energy.transmitted + (1.0 - returned) * energy.missing;
}

fn metal_energy_of(F0: vec3<f32>, E: vec2<f32>, smooth_lobe: bool) -> Energy {
    let missing = select(max(1.0 - (E.x + E.y), 0.0), 0.0, smooth_lobe);
    return Energy(F0 * E.x + E.y, vec3(0.0), vec3(missing));
}

fn side_of(bsdf: Bsdf, F0: vec3<f32>, entering: vec3<f32>, eta: f32, average: Energy, other: Energy) -> Side {
    let returned = boundary_returned(bsdf, F0, entering, eta, average, other);
    return Side(average, returned, passed_energy(average, returned));
}

// Probabilities of lobes in proportion to their albedos, none too small and those of absent lobes 0.
fn lobe_probability(albedo: f32, total: f32, oversampling_max: f32) -> f32 {
    return max(albedo, min(LOBE_PROBABILITY_MIN * total, oversampling_max * albedo));
}

// Reflectance of the metal's facets.
fn F_metal(bsdf: Bsdf, cos_theta: f32) -> vec3<f32> {
    return bsdf.reflectance + (1.0 - bsdf.reflectance) * schlick_weight(cos_theta);
}

fn gltf_view(bsdf: Bsdf, wo: vec3<f32>) -> GltfView {
    var view: GltfView;
    let g = bsdf.gltf;
    let eta = bsdf.eta.x;
    let is_delta = is_smooth(bsdf);
    let roughness = albedo_roughness(bsdf);
    view.roughness = roughness;
    view.F0 = g.F0;
    view.metal_F0 = bsdf.reflectance;
    if is_filmed(bsdf) {
        view.F0 = F0_filmed(F_filmed(bsdf, wo.z, F_boundary(bsdf, wo.z)), g.F90, boundary_weight(bsdf, wo.z));
        view.metal_F0 = F0_filmed(F_filmed(bsdf, wo.z, F_metal(bsdf, wo.z)), 1.0, schlick_weight(wo.z));
    }

    // What has no part in the mixture is left at 0: it is only ever multiplied by its share.
    if DIELECTRICS {
        view.energy = boundary_energy_at(bsdf, view.F0, eta, roughness, wo.z);
        if has_rest(bsdf) {
            let entering = T_entering_average(bsdf, view.F0, eta);
            let near = boundary_energy_average(bsdf, view.F0, eta, roughness);
            var far = near;
            if is_refractive(bsdf) {
                far = boundary_energy_average(bsdf, view.F0, 1.0 / eta, roughness);
            }
            view.near = side_of(bsdf, view.F0, entering, eta, near, far);
            view.far = view.near;
            if is_refractive(bsdf) {
                view.far = side_of(bsdf, view.F0, entering, 1.0 / eta, far, near);
            }
            view.passed = passed_energy(view.energy, view.near.returned);
        }
    }
    if METALS {
        view.metal_energy = metal_energy_of(view.metal_F0, albedo_ggx(wo.z, roughness, is_delta), is_delta);
        view.metal_average = metal_energy_of(view.metal_F0, albedo_average_ggx(roughness, is_delta), is_delta);
        view.metal_returned = F_multiple(view.metal_F0 + (1.0 - view.metal_F0) / 21.0, 1.0 - view.metal_average.missing.x);
    }

    view.below_coat = 1.0;
    if is_coated(bsdf) {
        view.coat = coat_albedo(bsdf, wo);
        view.below_coat = 1.0 - view.coat;
    }
    view.below_sheen = 1.0;
    var sheen_albedo = vec3(0.0);
    if is_sheened(bsdf) {
        let E = albedo_sheen(wo.z, g.sheen_roughness);
        let strongest = max(max(g.sheen_color.r, g.sheen_color.g), g.sheen_color.b) * E;
        // At grazing views the extension's lobe returns more than it gets.
        view.sheen = g.sheen_color / max(strongest, 1.0);
        sheen_albedo = view.sheen * E;
        view.below_sheen = max(1.0 - strongest, 0.0);
    }

    let transmitted = transmission_share(bsdf);
    let below = diffuse_transmission_share(bsdf);
    let dielectric = 1.0 - g.metallic;
    let diffuse = dielectric * (1.0 - transmitted) * view.passed;
    let refracted = dielectric * transmitted * bsdf.reflectance;
    let base = view.below_coat * view.below_sheen;
    let reflection = base * luminance(dielectric * view.energy.reflected + g.metallic * view.metal_energy.reflected);
    let transmission = base * luminance(refracted * view.energy.transmitted);
    let cosine_above = view.below_coat * luminance(sheen_albedo) + base * luminance((1.0 - below) * bsdf.reflectance * diffuse
        + dielectric * view.near.returned * view.energy.missing
        + g.metallic * view.metal_returned * view.metal_energy.missing);
    let cosine_below = base * luminance(below * g.diffuse_transmission_color * diffuse
        + refracted * (1.0 - view.near.returned) * view.energy.missing);
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
    return view;
}

// Reflectance of the facets, dielectric and metal mixed.
fn F_gltf(bsdf: Bsdf, cos_theta: f32) -> vec3<f32> {
    if !METALS {
        return F_filmed(bsdf, cos_theta, F_boundary(bsdf, cos_theta));
    }
    let dielectric = F_filmed(bsdf, cos_theta, F_boundary(bsdf, cos_theta));
    return mix(dielectric, F_filmed(bsdf, cos_theta, F_metal(bsdf, cos_theta)), bsdf.gltf.metallic);
}

// Factor on what facets transmit, with T_dielectric of the facet.
fn T_gltf(bsdf: Bsdf, cos_theta: f32, T: f32) -> vec3<f32> {
    let facet = T_filmed(bsdf, cos_theta, F_boundary(bsdf, cos_theta), T_boundary(bsdf, T));
    return (1.0 - bsdf.gltf.metallic) * transmission_share(bsdf) * bsdf.reflectance * facet;
}

// All that is reflected above and is no delta, and the density of it. `energy` is the dielectric's of wi.
fn gltf_reflection(bsdf: Bsdf, view: GltfView, energy: Energy, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    let g = bsdf.gltf;
    let is_delta = is_smooth(bsdf);
    let dielectric = 1.0 - g.metallic;
    var f = vec3(0.0);
    var pdf = view.p_above * pdf_cosine_hemisphere(wi.z);
    if DIELECTRICS && DIFFUSE {
        let passed = passed_energy(energy, view.near.returned);
        let diffuse = bsdf.reflectance * (dielectric * (1.0 - transmission_share(bsdf)) * (1.0 - diffuse_transmission_share(bsdf)));
        f += diffuse * INV_PI * (view.passed * passed / max(view.near.passed, vec3(PASSED_AVERAGE_MIN)));
    }
    if !is_delta {
        if DIELECTRICS {
            f += dielectric * view.near.returned * f_multiple(view.energy.missing, energy.missing, view.near.average.missing);
        }
        if METALS {
            let metal_energy = metal_energy_of(view.metal_F0, albedo_ggx(wi.z, view.roughness, is_delta), is_delta);
            f += g.metallic * view.metal_returned
                * f_multiple(view.metal_energy.missing, metal_energy.missing, view.metal_average.missing);
        }
        let base_wo = anisotropy_from_local(bsdf, wo);
        let base_wi = anisotropy_from_local(bsdf, wi);
        let wm = half_vector(base_wo, base_wi);
        let shape = torrance_sparrow_shape(bsdf, base_wo, base_wi, wm.xyz, wm.w);
        f += F_gltf(bsdf, wm.w) * shape.x;
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
    return BsdfEval(f, pdf);
}

// All that comes from below and is no delta, and the density of it. `energy` is the dielectric's of wi.
fn gltf_transmission(bsdf: Bsdf, view: GltfView, energy: Energy, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    let g = bsdf.gltf;
    let dielectric = 1.0 - g.metallic;
    let radiance = select(1.0, sqr(eta_below(bsdf)), is_refractive(bsdf));
    var f = vec3(0.0);
    var pdf = view.p_below * pdf_cosine_hemisphere(-wi.z);
    if DIFFUSE_TRANSMISSION {
        let passed = passed_energy(energy, view.far.returned);
        // Both averages are the same but for eta^2, within the tables' precision: their mean is reciprocal.
        let passed_average = sqrt(view.near.passed * view.far.passed * radiance);
        let diffuse = g.diffuse_transmission_color * (dielectric * (1.0 - transmission_share(bsdf)) * diffuse_transmission_share(bsdf));
        f += diffuse * (INV_PI * radiance) * (view.passed * passed / max(passed_average, vec3(PASSED_AVERAGE_MIN)));
    }
    if is_transmissive(bsdf) && !transmits_smoothly(bsdf) {
        f += bsdf.reflectance * (dielectric * transmission_share(bsdf) * radiance) * (1.0 - view.near.returned)
            * f_multiple(view.energy.missing, energy.missing, view.far.average.missing);
        let shape = transmission_shape(bsdf, anisotropy_from_local(bsdf, wo), anisotropy_from_local(bsdf, wi));
        f += T_gltf(bsdf, shape.z, shape.w) * shape.x;
        pdf += view.p_transmission * shape.y;
    }
    return BsdfEval(f * (view.below_coat * view.below_sheen), pdf);
}

fn gltf_eval_view(bsdf: Bsdf, view: GltfView, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    var energy: Energy;
    if DIELECTRICS {
        // Looked up once for both sides.
        let eta = select(bsdf.eta.x, eta_below(bsdf), wi.z < 0.0);
        energy = boundary_energy_at(bsdf, view.F0, eta, view.roughness, abs(wi.z));
    }
    if is_reflected(wo, wi) {
        return gltf_reflection(bsdf, view, energy, wo, wi);
    }
    if (TRANSMISSION || DIFFUSE_TRANSMISSION) && is_transmitted(wo, wi) {
        return gltf_transmission(bsdf, view, energy, wo, wi);
    }
    return no_eval();
}

// The parts that are no delta; the pdf is that of gltf_sample, lobe's choice included.
fn gltf_eval(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>) -> BsdfEval {
    if wo.z < MIN_COS {
        return no_eval();
    }
    return gltf_eval_view(bsdf, gltf_view(bsdf, wo), wo, wi);
}

// A way to sample by u.x, a direction in it by u.yz.
fn gltf_sample(bsdf: Bsdf, wo: vec3<f32>, u: vec3<f32>) -> BsdfSample {
    if wo.z < MIN_COS {
        return no_sample();
    }
    let view = gltf_view(bsdf, wo);
    let drawn = gltf_draw(bsdf, view, wo, u);
    if drawn.delta != 0u || drawn.pdf == 0.0 {
        return drawn;
    }
    return sample_of(drawn.wi, gltf_eval_view(bsdf, view, wo, drawn.wi));
}

// The same direction, of a delta with f. What is no delta has f and its density, which is not 0 yet, from
// gltf_eval_view.
fn gltf_draw(bsdf: Bsdf, view: GltfView, wo: vec3<f32>, u: vec3<f32>) -> BsdfSample {
    let base = view.below_coat * view.below_sheen;
    var drawn = no_sample();
    let coat_end = view.p_coat;
    let reflection_end = coat_end + view.p_reflection;
    let transmission_end = reflection_end + view.p_transmission;
    let above_end = transmission_end + view.p_above;
    if is_coated(bsdf) && u.x < coat_end {
        drawn = coat_sample(bsdf, wo, u.yz);
        drawn.pdf *= view.p_coat;
    } else if u.x < reflection_end {
        let base_wo = anisotropy_from_local(bsdf, wo);
        if is_smooth(bsdf) {
            drawn = BsdfSample(vec3(-wo.x, -wo.y, wo.z), F_gltf(bsdf, wo.z) * (base / wo.z), view.p_reflection, DELTA);
        } else {
            let wi = reflection_direction(base_wo, mirror_sample(bsdf, base_wo, u.yz));
            drawn = BsdfSample(local_from_anisotropy(bsdf, wi), vec3(0.0), view.p_reflection, 0u);
        }
    } else if is_transmissive(bsdf) && u.x < transmission_end {
        drawn = transmission_sample(bsdf, anisotropy_from_local(bsdf, wo), u.yz);
        drawn.wi = local_from_anisotropy(bsdf, drawn.wi);
        drawn.f *= T_gltf(bsdf, wo.z, T_dielectric(wo.z, bsdf.eta.x)) * base;
        drawn.pdf *= view.p_transmission;
    } else {
        let wi = sample_cosine_hemisphere(u.yz);
        drawn = BsdfSample(select(mirrored(wi), wi, u.x < above_end), vec3(0.0), view.p_above + view.p_below, 0u);
    }
    // A facet may send the reflected ray below the horizon, where it is nobody's sample.
    if drawn.delta == 0u && u.x < reflection_end && drawn.wi.z < MIN_COS {
        return no_sample();
    }
    return drawn;
}

// gltf_eval for wi, which may be 0, and gltf_sample by u. What does not depend on wi is made once for both.
fn gltf_eval_and_sample(bsdf: Bsdf, wo: vec3<f32>, wi: vec3<f32>, u: vec3<f32>) -> EvalAndSample {
    var both = EvalAndSample(no_eval(), no_sample());
    if wo.z < MIN_COS {
        return both;
    }
    let view = gltf_view(bsdf, wo);
    both.sample = gltf_draw(bsdf, view, wo, u);
    if gltf_is_delta(bsdf) {
        return both;
    }
    // In a loop, since a driver puts a copy of all lobes in the place of each call.
    for (var i = 0; i < 2; i++) {
        let eval = gltf_eval_view(bsdf, view, wo, select(both.sample.wi, wi, i == 0));
        if i == 0 {
            both.eval = eval;
        } else if both.sample.delta == 0u && both.sample.pdf > 0.0 {
            both.sample = sample_of(both.sample.wi, eval);
        }
    }
    return both;
}

// Whether there is nothing but deltas, whatever wo is.
fn gltf_is_delta(bsdf: Bsdf) -> bool {
    let g = bsdf.gltf;
    let is_diffuse = DIFFUSE && g.metallic < 1.0 && transmission_share(bsdf) < 1.0;
    let coat_is_rough = is_coated(bsdf) && !is_smooth(coat_facets(bsdf));
    return is_smooth(bsdf) && !is_diffuse && !coat_is_rough && !is_sheened(bsdf);
}

// Whether light from the other side may come through.
fn gltf_transmits(bsdf: Bsdf) -> bool {
    return transmission_share(bsdf) > 0.0 || diffuse_transmission_share(bsdf) > 0.0;
}

// What a smooth thin wall passes straight on, the expectation of its samples that are DELTA_STRAIGHT.
fn gltf_straight_transmittance(bsdf: Bsdf, wo: vec3<f32>) -> vec3<f32> {
    if !is_transmissive(bsdf) || is_refractive(bsdf) || !is_smooth(bsdf) || wo.z < MIN_COS {
        return vec3(0.0);
    }
    let view = gltf_view(bsdf, wo);
    return T_gltf(bsdf, wo.z, T_dielectric(wo.z, bsdf.eta.x)) * (view.below_coat * view.below_sheen);
}
