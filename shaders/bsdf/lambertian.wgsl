// The ideally diffuse surface.

import package::math::{INV_PI};

fn f_lambertian(reflectance: vec3<f32>) -> vec3<f32> {
    // Lecture, "Lambertian Reflection": rho / pi.
    return reflectance * INV_PI;
}
