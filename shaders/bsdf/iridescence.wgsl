// Iridescence: the same facets under a thin film (bsdf/thin_film).

import package::shared::{Bsdf, GLTF_INSIDE};
import package::variant::{IRIDESCENCE};
import package::bsdf::thin_film::{F_thin_film};

// Weights of F90 beyond this say nothing of F0.
const F90_WEIGHT_MAX: f32 = 0.999;

fn is_filmed(bsdf: Bsdf) -> bool {
    return IRIDESCENCE && bsdf.gltf.iridescence > 0.0 && (bsdf.gltf.flags & GLTF_INSIDE) == 0u;
}

// Reflectance of a facet whose own is F_base.
fn F_filmed(bsdf: Bsdf, cos_theta: f32, F_base: vec3<f32>) -> vec3<f32> {
    if !is_filmed(bsdf) {
        return F_base;
    }
    // KHR_materials_iridescence, "Material": mixed by the factor.
    return mix(F_base, F_thin_film(cos_theta, bsdf.gltf.film_ior, bsdf.gltf.film_thickness, F_base), bsdf.gltf.iridescence);
}

// What a facet transmits that has F_base and T_base by itself.
fn T_filmed(bsdf: Bsdf, cos_theta: f32, F_base: vec3<f32>, T_base: vec3<f32>) -> vec3<f32> {
    if !is_filmed(bsdf) {
        return T_base;
    }
    return mix(T_base, 1.0 - F_thin_film(cos_theta, bsdf.gltf.film_ior, bsdf.gltf.film_thickness, F_base), bsdf.gltf.iridescence);
}

// The F0 of facets without a film that reflect towards cos_theta what filmed ones of F do; `weight` is
// how far from F0 to F90 they are there.
fn F0_filmed(F: vec3<f32>, F90: f32, weight: f32) -> vec3<f32> {
    // KHR_materials_iridescence, "Implementation notes": Schlick's form solved for F0.
    let w = min(weight, F90_WEIGHT_MAX);
    return clamp((F - F90 * w) / (1.0 - w), vec3(0.0), vec3(1.0));
}
