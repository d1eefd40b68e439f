//! glTF's materials on their way to the reflection functions: packed numbers, textures at a point of a
//! surface, coats with their own normals, the kernels against the reference.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

#[path = "../common/mod.rs"]
mod common;
mod frames;
mod numbers;
mod textured;

use bytemuck::{Pod, Zeroable};
use common::rays::{RayQuery, ray};
use common::shapes;
use glam::Vec3;
use snell::cpu;
use snell::pack::Packed;
use snell::scene::{Extensions, Filter, Material, Model, Texture, Wrap};
use snell::shared::*;

fn extended(change: impl Fn(&mut Extensions)) -> Material {
    let mut material = shapes::material();
    if let Model::MetallicRoughness(model) = &mut material.model {
        change(&mut model.extensions);
    }
    material
}

/// The reflection model where a ray met a material, in front or behind.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Answer {
    t: f32,
    u: f32,
    v: f32,
    instance: u32,
    triangle: u32,
    front: u32,
    reserved: [u32; 2],
    /// In world space.
    coat_normal: [f32; 3],
    reserved1: u32,
    bsdf: Bsdf,
}

const MATERIALS: &str = "
import package::shared::{NONE, Bsdf};
import package::bindings::{materials};
import package::ray::{Ray, Hit};
import package::bvh::{trace_closest};
import package::math::{to_world};
import package::surface::{Surface, surface_at};
import package::material::{bsdf_at};
struct Answer {
    t: f32, u: f32, v: f32, instance: u32, triangle: u32, front: u32, reserved: vec2<u32>,
    coat_normal: vec3<f32>, reserved1: u32, bsdf: Bsdf,
}
@group(3) @binding(0) var<storage, read> rays: array<Ray>;
@group(3) @binding(1) var<storage, read_write> answers: array<Answer>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&rays) { return; }
    let ray = rays[id.x];
    let hit = trace_closest(ray, id.x);
    answers[id.x].instance = hit.instance;
    if hit.instance == NONE { return; }
    let s = surface_at(ray, hit);
    let material = materials[s.material];
    let bsdf = bsdf_at(material, s, material.ior);
    answers[id.x] = Answer(hit.t, hit.u, hit.v, hit.instance, hit.triangle, s.front, vec2(0u),
        to_world(s.basis, bsdf.gltf.coat_normal), 0u, bsdf);
}";

fn on_gpu(packed: &Packed, rays: &[RayQuery]) -> Vec<Answer> {
    let bytes = common::run_scene(
        MATERIALS,
        packed,
        &[bytemuck::cast_slice(rays)],
        rays.len() * size_of::<Answer>(),
        rays.len() as u32,
    );
    bytemuck::pod_collect_to_vec(&bytes)
}

/// The reference's surface and model at the kernels' own hit.
fn on_cpu(
    packed: &Packed,
    query: &RayQuery,
    gpu: &Answer,
) -> (cpu::surface::Surface, cpu::bsdf::Bsdf) {
    let hit = cpu::ray::Hit {
        t: f64::from(gpu.t),
        u: f64::from(gpu.u),
        v: f64::from(gpu.v),
        instance: gpu.instance,
        triangle: gpu.triangle,
    };
    let s = cpu::surface::surface_at(packed, ray(query), hit);
    let material = &packed.materials[s.material as usize];
    let bsdf = cpu::material::bsdf_at(packed, material, &s, f64::from(material.ior));
    (s, bsdf)
}

fn texture(image: usize, srgb: bool) -> Option<Texture> {
    Some(Texture {
        image,
        srgb,
        wrap_s: Wrap::Repeat,
        wrap_t: Wrap::Mirror,
        filter: Filter::Linear,
        texcoord: 0,
        rows: [Vec3::new(1.5, 0.2, 0.1), Vec3::new(-0.1, 0.8, 0.0)],
    })
}
