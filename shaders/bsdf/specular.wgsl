// Perfectly specular reflection and transmission: the law of reflection, Snell's law, and the delta
// lobes that follow them. eta is the far side's index over the near side's, seen from wo.

import package::shared::{Bsdf};
import package::math::{PI, sqr, asin_accurate};
import package::exact::{squares_minus_one};
import package::bsdf::lobe::{MIN_COS, BsdfSample, no_sample, mirrored};
import package::bsdf::fresnel::{snell_root, T_dielectric, fresnel_F};

// theta_o = theta_i and phi_o = phi_i +- pi about n.
fn reflection_direction(wo: vec3<f32>, n: vec3<f32>) -> vec3<f32> {
    return 2.0 * dot(wo, n) * n - wo;
}

// eta_o sin theta_o = eta_i sin theta_i, phi_o = phi_i +- pi about n, which lies on wo's side; the zero
// vector where there is total internal reflection.
fn refraction_direction(wo: vec3<f32>, n: vec3<f32>, eta: f32) -> vec3<f32> {
    // wi = -wo / eta + (cos_o / eta - cos_i) n, with cos_o - eta cos_i = (1 - eta^2) / (cos_o + eta cos_i).
    if eta == 1.0 {
        return -wo;
    }
    let c = dot(wo, n);
    let q = snell_root(c, eta);
    if q == 0.0 {
        return vec3(0.0);
    }
    return ((1.0 - eta) * (1.0 + eta) / (c + q) * n - wo) / eta;
}

// The angle from which on nothing is transmitted, radians; pi / 2 where the far side is denser.
fn critical_angle(eta: f32) -> f32 {
    if eta >= 1.0 {
        return 0.5 * PI;
    }
    return asin_accurate(eta);
}

// At the critical angle itself too: the refracted ray would lie in the surface.
fn is_totally_reflected(cos_theta: f32, eta: f32) -> bool {
    return eta < 1.0 && squares_minus_one(eta, cos_theta, 0.0) <= 0.0;
}

// d theta_t / d theta, the derivative of the refracted angle; 0 where there is no refracted ray.
fn snell_jacobian(cos_theta: f32, eta: f32) -> f32 {
    // Lecture, "Specular Refraction": eta_i cos theta_i / (eta_o cos theta_o), here cos theta / (eta cos theta_t).
    let q = snell_root(cos_theta, eta);
    if q == 0.0 {
        return 0.0;
    }
    return cos_theta / q;
}

// f = F delta(wi - R(wo)) / cos theta_i, so that Lo = F Li.
fn specular_reflection_sample(bsdf: Bsdf, wo: vec3<f32>) -> BsdfSample {
    // Lecture, "Specular Reflection".
    if wo.z < MIN_COS {
        return no_sample();
    }
    return BsdfSample(
        vec3(-wo.x, -wo.y, wo.z),
        bsdf.reflectance * fresnel_F(bsdf, wo.z) / wo.z,
        1.0,
        1u,
    );
}

// f = (1 - F) (eta_o^2 / eta_i^2) delta(wi - T(wo)) / cos theta_i, so that Lo = (1 - F) (eta_o^2 / eta_i^2) Li.
fn specular_transmission_sample(bsdf: Bsdf, wo: vec3<f32>) -> BsdfSample {
    // Lecture, "Specular Transmission".
    if wo.z < MIN_COS {
        return no_sample();
    }
    let eta = bsdf.eta.x;
    let wi = refraction_direction(wo, vec3(0.0, 0.0, 1.0), eta);
    if wi.z > -MIN_COS {
        return no_sample();
    }
    let f = T_dielectric(wo.z, eta) / (sqr(eta) * -wi.z);
    return BsdfSample(wi, bsdf.reflectance * f, 1.0, 1u);
}
