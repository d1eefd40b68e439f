//! Rays as tests send them to kernels and to the reference alike.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use snell::cpu::ray::Ray;

/// Twin of `Ray` in shaders/ray.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct RayQuery {
    pub origin: [f32; 3],
    pub t_min: f32,
    pub direction: [f32; 3],
    pub t_max: f32,
    pub time: f32,
    pub reserved: [f32; 3],
}

/// From `origin` without end; `direction` is of unit length.
pub fn query(origin: Vec3, direction: Vec3) -> RayQuery {
    RayQuery {
        origin: origin.to_array(),
        t_min: 0.0,
        direction: direction.to_array(),
        t_max: 1e30,
        time: 0.0,
        reserved: [0.0; 3],
    }
}

pub fn towards(origin: Vec3, target: Vec3) -> RayQuery {
    query(origin, (target - origin).normalize())
}

/// The same ray for the reference.
pub fn ray(query: &RayQuery) -> Ray {
    Ray {
        origin: Vec3::from_array(query.origin).as_dvec3(),
        t_min: f64::from(query.t_min),
        direction: Vec3::from_array(query.direction).as_dvec3(),
        t_max: f64::from(query.t_max),
        time: f64::from(query.time),
    }
}
