//! The shader texts, embedded in the binary. A test compares this table with the folder.

/// Module name (path under `shaders/` without its ending) and text.
pub type Module = (&'static str, &'static str);

macro_rules! modules {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../shaders/", $name, ".wgsl")))),*]
    };
}

/// Every shader file: modules that others import, and the kernels that import them.
#[rustfmt::skip]
pub const MODULES: &[Module] = modules![
    "alpha",
    "attributes",
    "bindings",
    "bsdf/albedo",
    "bsdf/boundary",
    "bsdf/bsdf",
    "bsdf/coat",
    "bsdf/dielectric",
    "bsdf/distribution",
    "bsdf/fresnel",
    "bsdf/gltf",
    "bsdf/iridescence",
    "bsdf/lambertian",
    "bsdf/lobe",
    "bsdf/masking",
    "bsdf/multiple_scattering",
    "bsdf/oren_nayar",
    "bsdf/sheen",
    "bsdf/specular",
    "bsdf/thin_film",
    "bsdf/torrance_sparrow",
    "bsdf/transmission",
    "bsdf/visible_normal",
    "bvh",
    "camera",
    "erf",
    "estimator",
    "filter",
    "exact",
    "intersect",
    "kernels/accumulate",
    "kernels/advance",
    "kernels/bsdf_lab",
    "kernels/generate",
    "kernels/miss",
    "kernels/shade",
    "kernels/slots",
    "kernels/state",
    "kernels/trace_closest",
    "kernels/trace_shadow",
    "light/environment",
    "light/light",
    "light/punctual",
    "light/tree",
    "light/triangle",
    "material",
    "math",
    "medium",
    "ray",
    "rng",
    "sample",
    "shared",
    "sobol",
    "spectrum",
    "surface",
    "texture",
    "transform",
    "variant",
    "visibility",
];

/// The text of a module.
pub fn text(name: &str) -> Option<&'static str> {
    MODULES
        .iter()
        .find(|(module, _)| *module == name)
        .map(|(_, text)| *text)
}
