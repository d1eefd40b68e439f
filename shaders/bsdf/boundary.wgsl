// The surface of glTF's dielectric part: what its facets reflect, and where the energy goes in sum.
//
// Opaque, the facets reflect by Schlick's form and absorb nothing: what they do not reflect meets the
// diffuse part below. With KHR_materials_transmission the exact Fresnel term stands in for Schlick's
// weight, F = F0 + (F90 - F0) (F_dielectric - p) / (1 - p) with p = F_dielectric at normal incidence: of
// a neutral KHR_materials_specular (F0 = p, F90 = 1) that is F_dielectric itself. Where refraction has no
// angle everything is reflected, whatever F90 says: light has nowhere else to go.

import package::shared::{Bsdf, GLTF_TRANSMISSIVE, GLTF_THIN_WALLED};
import package::variant::{TRANSMISSION, OPAQUE, THIN};
import package::math::{sqr};
import package::bsdf::lobe::{ETA_MATCHED, MIN_COS};
import package::bsdf::fresnel::{F_dielectric, schlick_weight};
import package::bsdf::specular::{is_totally_reflected};
import package::bsdf::distribution::{is_smooth};
import package::bsdf::albedo::{albedo_ggx, albedo_average_ggx, albedo_dielectric, albedo_average_dielectric, albedo_average_smooth_dielectric};
import package::bsdf::multiple_scattering::{F_multiple, T_multiple};

// Of white light from one direction, or of even light: what facets reflect, what they let pass, and
// what is left for multiple scattering. The three add up to 1.
struct Energy {
    reflected: vec3<f32>,
    transmitted: vec3<f32>,
    missing: vec3<f32>,
}

// Whether the dielectric part has the exact Fresnel term. An index of 0 is glTF's word for "reflects
// everything" and has no refraction: such a surface stays opaque.
fn is_transmissive(bsdf: Bsdf) -> bool {
    return !OPAQUE || (TRANSMISSION && (bsdf.gltf.flags & GLTF_TRANSMISSIVE) != 0u && bsdf.eta.x > 0.0);
}

// Whether light that is transmitted enters a medium, refracted.
fn is_refractive(bsdf: Bsdf) -> bool {
    return is_transmissive(bsdf) && (!THIN || (bsdf.gltf.flags & GLTF_THIN_WALLED) == 0u);
}

// Whether light is transmitted as by a smooth boundary.
fn transmits_smoothly(bsdf: Bsdf) -> bool {
    return is_smooth(bsdf) || (is_refractive(bsdf) && abs(bsdf.eta.x - 1.0) < ETA_MATCHED);
}

// F_dielectric at normal incidence.
fn F_normal(eta: f32) -> f32 {
    return sqr((eta - 1.0) / (eta + 1.0));
}

// How far from F0 to F90 a facet's reflectance is.
fn boundary_weight(bsdf: Bsdf, cos_theta: f32) -> f32 {
    if is_transmissive(bsdf) {
        let p = F_normal(bsdf.eta.x);
        return (F_dielectric(cos_theta, bsdf.eta.x) - p) / (1.0 - p);
    }
    return schlick_weight(cos_theta);
}

// Reflectance of a facet.
fn F_boundary(bsdf: Bsdf, cos_theta: f32) -> vec3<f32> {
    if is_transmissive(bsdf) && is_totally_reflected(cos_theta, bsdf.eta.x) {
        return vec3(1.0);
    }
    return bsdf.gltf.F0 + (bsdf.gltf.F90 - bsdf.gltf.F0) * boundary_weight(bsdf, cos_theta);
}

// 1 - F_boundary of a transmissive facet by its T_dielectric, without the cancellation where F is nearly 1.
fn T_boundary(bsdf: Bsdf, T: f32) -> vec3<f32> {
    if T <= 0.0 {
        return vec3(0.0);
    }
    return 1.0 - bsdf.gltf.F90 + (bsdf.gltf.F90 - bsdf.gltf.F0) * (T / (1.0 - F_normal(bsdf.eta.x)));
}

// Where the energy goes, from the albedo of facets that reflect by Schlick's form (`white`, factors of
// F0 and F90) and by the exact Fresnel term (`plain`, reflected and in all), from one direction or on
// average. `eta` may be that of the other side.
fn boundary_energy(bsdf: Bsdf, F0: vec3<f32>, eta: f32, white: vec2<f32>, plain: vec2<f32>) -> Energy {
    let F90 = bsdf.gltf.F90;
    let all = white.x + white.y;
    let missing_white = select(max(1.0 - all, 0.0), 0.0, is_smooth(bsdf));
    if !is_transmissive(bsdf) {
        let reflected = F0 * white.x + F90 * white.y;
        let transmitted = (1.0 - F0) * white.x + (1.0 - F90) * white.y;
        return Energy(reflected, transmitted, vec3(missing_white));
    }
    let p = F_normal(eta);
    let weight = (plain.x - p * all) / (1.0 - p);
    let reflected = F0 * all + (F90 - F0) * weight;
    if !is_refractive(bsdf) {
        return Energy(reflected, max(all - reflected, vec3(0.0)), vec3(missing_white));
    }
    let lossless = is_smooth(bsdf) || abs(eta - 1.0) < ETA_MATCHED;
    let share = (plain.y - plain.x) / (1.0 - p);
    // What facets without reflectance (F90 = 0) would pass, estimated: from outside by the mean F of facets,
    // from inside by that of those that do not reflect totally, which is about p.
    let F = select(plain.x / max(all, MIN_COS), p, eta < 1.0);
    var whole = min((plain.y - plain.x) / max(1.0 - F, MIN_COS), 1.0);
    if lossless {
        whole = select(0.0, 1.0, share > 0.0);
    }
    let transmitted = (F90 - F0) * share + (1.0 - F90) * whole;
    // Total reflection does not ask for F90.
    let total = (1.0 - F90) * select(0.0, max(weight, 0.0), eta < 1.0);
    let rest = max(1.0 - (reflected + total) - transmitted, vec3(0.0));
    return Energy(reflected + total, transmitted, select(rest, vec3(0.0), lossless));
}

fn boundary_energy_at(bsdf: Bsdf, F0: vec3<f32>, eta: f32, roughness: f32, cos_theta: f32) -> Energy {
    var plain = vec2(0.0);
    if is_transmissive(bsdf) {
        if is_smooth(bsdf) {
            plain = vec2(F_dielectric(cos_theta, eta), 1.0);
        } else {
            plain = albedo_dielectric(cos_theta, roughness, eta);
        }
    }
    return boundary_energy(bsdf, F0, eta, albedo_ggx(cos_theta, roughness, is_smooth(bsdf)), plain);
}

fn boundary_energy_average(bsdf: Bsdf, F0: vec3<f32>, eta: f32, roughness: f32) -> Energy {
    var plain = vec2(0.0);
    if is_transmissive(bsdf) {
        plain = albedo_average_dielectric(roughness, eta);
    }
    return boundary_energy(bsdf, F0, eta, albedo_average_ggx(roughness, is_smooth(bsdf)), plain);
}

// What smooth facets let pass of even light that enters the denser side; 0 of an opaque surface.
fn T_entering_average(bsdf: Bsdf, F0: vec3<f32>, eta: f32) -> vec3<f32> {
    if !is_transmissive(bsdf) {
        return vec3(0.0);
    }
    let F90 = bsdf.gltf.F90;
    let dense = max(eta, 1.0 / eta);
    let share = (1.0 - albedo_average_smooth_dielectric(dense)) / (1.0 - F_normal(dense));
    return 1.0 - F90 + (F90 - F0) * share;
}

// The share of what is missing that comes back out by reflection at last; of an opaque surface the rest
// is with the diffuse part below, of a transmissive one it is on the other side. `entering` is that of
// T_entering_average; the denser side sees 1 / eta^2 of it (all of it that is not totally reflected), so that
// what passes is reciprocal by construction.
fn boundary_returned(bsdf: Bsdf, F0: vec3<f32>, entering: vec3<f32>, eta: f32, near: Energy, far: Energy) -> vec3<f32> {
    if is_transmissive(bsdf) {
        let T_average = entering * select(1.0, eta * eta, eta < 1.0 && is_refractive(bsdf));
        return 1.0 - T_multiple(T_average, near.missing, far.missing);
    }
    let F_average = F0 + (bsdf.gltf.F90 - F0) / 21.0;
    return F_multiple(F_average, 1.0 - near.missing.x);
}
