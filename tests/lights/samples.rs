//! Samples of lights and their densities, on lavapipe and in the reference.

use crate::common;
use crate::common::shapes::Random;
use crate::{COUNT, all_lights};
use glam::{DVec2, DVec3, Vec2, Vec3};
use snell::cpu::light::environment::Le_environment;
use snell::cpu::light::light::*;
use snell::cpu::light::tree::light_share;
use snell::pack::Packed;
use snell::shared::*;

/// What light_sample says, as GPU and CPU answer it.
#[repr(C)]
#[derive(Clone, Copy, Debug, bytemuck::Pod, bytemuck::Zeroable)]
struct Answer {
    wi: [f32; 3],
    distance: f32,
    Le: [f32; 3],
    pdf: f32,
    delta: u32,
    pick: u32,
    pdf_environment: f32,
    reserved: u32,
}

fn light_samples_gpu(packed: &Packed, queries: &[[f32; 8]]) -> Vec<Answer> {
    let root = "
import package::light::light::{LightSample, light_sample, light_pick, light_pdf_environment};
struct Answer { s: LightSample, pick: u32, pdf_environment: f32 }
@group(3) @binding(0) var<storage, read> queries: array<array<vec4<f32>, 2>>;
@group(3) @binding(1) var<storage, read_write> answers: array<array<vec4<f32>, 3>>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&queries) { return; }
    let p = queries[id.x][0].xyz;
    let u_pick = queries[id.x][0].w;
    let u = queries[id.x][1].xy;
    let ns = vec3(queries[id.x][1].zw, 0.6);
    let s = light_sample(p, ns, ns.x > 0.0, u_pick, u, 0.0);
    answers[id.x] = array<vec4<f32>, 3>(vec4(s.wi, s.distance), vec4(s.Le, s.pdf),
        vec4(bitcast<f32>(s.delta), bitcast<f32>(light_pick(u_pick, u).index),
            light_pdf_environment(s.wi), 0.0));
}";
    let bytes = bytemuck::cast_slice(queries);
    let answers = common::run_scene(
        root,
        packed,
        &[bytes],
        queries.len() * 48,
        queries.len() as u32,
    );
    bytemuck::pod_collect_to_vec(&answers)
}

#[test]
fn light_samples_agree_with_float64() {
    let packed = all_lights();
    let mut uniform = Random(12);
    let queries: Vec<[f32; 8]> = (0..COUNT)
        .map(|_| {
            let [x, y, z] = (2.0 * uniform.direction()).to_array();
            // The normal's x, by whose sign the surface transmits, and y; its z is 0.6.
            let normal = uniform.direction().truncate().normalize_or(Vec2::X) * 0.8;
            let mut unit = || uniform.unit();
            [x, y, z, unit(), unit(), unit(), normal.x, normal.y]
        })
        .collect();
    let answers = light_samples_gpu(&packed, &queries);
    let brightest = 1.5 * 500.0;
    let mut seen = [0; 9];
    let (mut apart, mut met) = (0, 0);
    for (q, answer) in queries.iter().zip(&answers) {
        let p = Vec3::new(q[0], q[1], q[2]).as_dvec3();
        let u = DVec2::new(q[4].into(), q[5].into());
        let pick = light_pick(&packed, q[3].into(), u).index;
        assert_eq!(answer.pick, pick, "at {q:?}");
        seen[pick as usize] += 1;
        let ns = DVec3::new(q[6].into(), q[7].into(), f64::from(0.6f32));
        let s = light_sample(&packed, p, ns, q[6] > 0.0, q[3].into(), u, 0.0);
        assert_eq!(answer.delta, s.delta);
        let Le = Vec3::from(answer.Le).as_dvec3();
        let wi = Vec3::from(answer.wi).as_dvec3();
        // A density has a divisor that is mostly rounding where it is small: the cosine at a
        // triangle seen edge on, the sine of the angle to the map's pole.
        let kind = packed.lights[pick as usize].kind;
        let cosine = if kind == LIGHT_ENVIRONMENT && s.pdf > 0.0 {
            s.wi.x.hypot(s.wi.z)
        } else if kind == LIGHT_TRIANGLE && s.pdf > 0.0 {
            let weight = packed.materials[pick as usize - 4].emission_weight;
            let share = light_share(&packed, p, 0, 0);
            light_pdf_triangle(share, weight.into(), s.distance, 1.0) / s.pdf
        } else {
            1.0
        };
        if kind == LIGHT_ENVIRONMENT && s.pdf == 0.0 && answer.pdf == 0.0 {
            continue; // both directions lie below the surface
        }
        if cosine < 1e-4 || (answer.pdf == 0.0) != (s.pdf == 0.0) {
            apart += 1;
            continue;
        }
        met += usize::from(s.pdf > 0.0);
        let at = format!("at {q:?}, light {pick}: {answer:?}, float64 {s:?}");
        assert!((wi - s.wi).length() < 2e-6, "{at}");
        assert!(
            (f64::from(answer.distance) - s.distance).abs() < 1e-6 * s.distance,
            "{at}"
        );
        assert!(
            (f64::from(answer.pdf) - s.pdf).abs() <= (1e-5 + 2e-6 / cosine) * s.pdf,
            "{at}"
        );
        // The place on the map is rounded, by a share of a texel that grows with the map's width.
        let place = f64::from(f32::EPSILON) * 37.0;
        // Of two directions to the environment the one is weighed by the rounded cosines of both.
        let (mut weight, mut cosines) = (1.0, 0.0);
        if kind == LIGHT_ENVIRONMENT && s.pdf > 0.0 {
            weight = s.Le.length() / Le_environment(&packed, s.wi).length().max(1e-9);
            cosines = 4e-6 / s.wi.dot(ns).abs();
        }
        let error = (Le - s.Le).length();
        let bound = (1e-5 + cosines) * s.Le.length() + weight * place * brightest;
        assert!(error <= bound, "{at}");
    }
    assert!(apart < COUNT / 1000, "{apart} queries on an edge");
    assert!(met > COUNT / 2, "{met} samples");
    assert!(seen.iter().all(|&n| n > 100), "{seen:?}");
}

#[test]
fn a_samples_pdf_is_what_the_density_functions_say() {
    let packed = all_lights();
    let mut uniform = Random(13);
    let mut met = [0; 3];
    for _ in 0..50_000 {
        let p = uniform.direction().as_dvec3() * 0.4;
        let (u_pick, x, y) = (uniform.unit(), uniform.unit(), uniform.unit());
        let u = DVec2::new(x.into(), y.into());
        let ns = uniform.direction().as_dvec3();
        let light = &packed.lights[light_pick(&packed, u_pick.into(), u).index as usize];
        let s = light_sample(&packed, p, ns, false, u_pick.into(), u, 0.0);
        let share = f64::from(light.weight) / f64::from(packed.frame.light_weight_total);
        let expected = match light.kind {
            // Both directions may lie below the surface.
            LIGHT_ENVIRONMENT if s.pdf == 0.0 => continue,
            LIGHT_ENVIRONMENT => {
                met[0] += 1;
                light_pdf_environment(&packed, s.wi)
            }
            LIGHT_TRIANGLE => {
                // Meets the plane again, as a ray would, and turns the area's density about.
                let [p0, e1, e2] = [light.position, light.direction, light.edge2]
                    .map(|v| Vec3::from(v).as_dvec3());
                let ng = e1.cross(e2);
                let distance = (p0 - p).dot(ng) / s.wi.dot(ng);
                let cosine = s.wi.dot(ng).abs() / ng.length();
                let front = s.wi.dot(ng) < 0.0;
                let flipped = packed.instances[light.instance as usize].flags != 0;
                let material = &packed.materials[light.triangle as usize];
                if material.flags & MATERIAL_DOUBLE_SIDED == 0 && front == flipped {
                    met[2] += 1;
                    assert_eq!(s.pdf, 0.0, "the back of a one-sided light");
                    assert_eq!(s.Le, DVec3::ZERO);
                    continue;
                }
                met[1] += 1;
                assert!((s.distance - distance).abs() < 1e-9);
                let by_area = share / (0.5 * ng.length()) * distance * distance / cosine;
                assert!(
                    (s.pdf - by_area).abs() < 1e-6 * by_area,
                    "{} {by_area}",
                    s.pdf
                );
                let share = light_share(&packed, p, light.instance, light.triangle);
                light_pdf_triangle(share, material.emission_weight.into(), distance, cosine)
            }
            _ => share,
        };
        let close = (s.pdf - expected).abs() < 1e-6 * expected;
        // A direction on the border of two cells may be read as the other's.
        assert!(
            close || light.kind == LIGHT_ENVIRONMENT && u.x < 1e-4,
            "{} {expected}",
            s.pdf
        );
    }
    assert!(met.iter().all(|&n| n > 500), "{met:?}");
}
