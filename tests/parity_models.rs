//! `bsdf_eval` and `bsdf_sample` of every reflection model, WGSL on lavapipe against float64, over
//! 100 000 queries each. A sample is judged twice: its direction against the twin's, and its f and pdf
//! against the twin's evaluation of the very direction that it returned.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod common;
mod queries;

use glam::DVec3;
use queries::{COUNT, Inputs, Query, Value, compare, on_lavapipe, within};
use snell::cpu::bsdf::bsdf::{bsdf_eval, bsdf_is_delta, bsdf_sample};
use snell::shared::*;
use snell::tables::tables;

/// Fills in glTF's extensions at random, each in about half of all queries.
fn gltf(inputs: &mut Inputs, b: &mut Bsdf) {
    b.fresnel = FRESNEL_SCHLICK;
    let flags = [
        0,
        0,
        GLTF_TRANSMISSIVE,
        GLTF_TRANSMISSIVE,
        GLTF_TRANSMISSIVE | GLTF_THIN_WALLED,
    ];
    let eta = match inputs.pick(2) {
        0 => 1.5,
        _ => inputs.range(1.01, 2.9),
    };
    let g = &mut b.gltf;
    g.flags = flags[inputs.pick(5) as usize];
    b.eta = [eta; 3];
    if g.flags == GLTF_TRANSMISSIVE && inputs.pick(2) == 0 {
        g.flags |= GLTF_INSIDE;
        b.eta = [1.0 / eta; 3];
    }
    let plain = ((eta - 1.0) / (eta + 1.0)).powi(2);
    (g.F0, g.F90) = ([plain; 3], 1.0);
    if inputs.pick(4) == 0 {
        // KHR_materials_specular scales both. Facets of F0 = 0 reflect the difference of the exact
        // Fresnel term and its value at normal incidence: rounding, near there.
        g.F90 = inputs.range(0.1, 1.0);
        g.F0 = inputs.color().map(|channel| channel.max(0.1) * g.F90);
    }
    let strength = |inputs: &mut Inputs| match inputs.pick(4) {
        0 | 1 => 0.0,
        2 => 1.0,
        _ => inputs.unit(),
    };
    g.metallic = strength(inputs);
    g.transmission = strength(inputs);
    let phi = inputs.range(0.0, std::f32::consts::TAU);
    g.rotation = [phi.cos(), phi.sin()];
    g.diffuse_transmission_color = inputs.color();
    g.diffuse_transmission = strength(inputs);
    if inputs.pick(3) == 0 {
        g.sheen_color = inputs.color();
    }
    g.sheen_roughness = inputs.unit();
    let normal = glam::Vec3::new(inputs.range(-0.5, 0.5), inputs.range(-0.5, 0.5), 1.0);
    g.coat_normal = normal.normalize().to_array();
    if inputs.pick(2) == 0 {
        g.coat_normal = [0.0, 0.0, 1.0];
    }
    g.coat = strength(inputs);
    g.coat_roughness = [0.0, 0.05, 0.3, 1.0][inputs.pick(4) as usize];
    if inputs.pick(3) == 0 {
        g.iridescence = strength(inputs);
    }
    g.film_ior = inputs.range(1.0, 2.0);
    g.film_thickness = inputs.range(0.0, 1000.0);
}

/// Fills in a model at random.
fn model(inputs: &mut Inputs, model: u32, b: &mut Bsdf) {
    b.model = model;
    let rough = |inputs: &mut Inputs| match inputs.pick(16) {
        0 => 0.0,
        1 => 1.0,
        _ => inputs.log_range(1e-3, 1.0),
    };
    b.roughness = inputs.unit();
    b.distribution = DISTRIBUTION_GGX;
    b.masking = MASKING_SMITH;
    match model {
        BSDF_TORRANCE_SPARROW | BSDF_SPECULAR_REFLECTION => {
            b.fresnel = inputs.pick(5);
            b.distribution = inputs.pick(4);
            b.masking = inputs.pick(3);
            b.eta = if b.fresnel == FRESNEL_DIELECTRIC {
                [inputs.eta(), 0.0, 0.0]
            } else if b.fresnel == FRESNEL_CONSTANT || b.fresnel == FRESNEL_SCHLICK {
                inputs.color()
            } else {
                [1; 3].map(|_| inputs.log_range(0.05, 8.0))
            };
            b.k = [1; 3].map(|_| inputs.range(0.1, 10.0));
        }
        BSDF_ROUGH_DIELECTRIC | BSDF_DIELECTRIC | BSDF_SPECULAR_TRANSMISSION => {
            b.distribution = inputs.pick(4);
            b.masking = 1 + inputs.pick(2);
            b.eta = [inputs.eta(), 0.0, 0.0];
        }
        BSDF_GLTF => {
            gltf(inputs, b);
            b.roughness = rough(inputs).sqrt();
            // Black reflects next to nothing, and by which lobe is a matter of rounding.
            b.reflectance = b.reflectance.map(|channel| channel.max(0.02));
            b.gltf.diffuse_transmission_color = b
                .gltf
                .diffuse_transmission_color
                .map(|channel| channel.max(0.02));
            // Where a film cancels a channel, what is left is rounding, which narrow lobes make bright.
            if b.gltf.iridescence > 0.0 {
                b.roughness = b.roughness.max(0.4);
            }
            b.alpha = [b.roughness * b.roughness; 2];
            if inputs.pick(4) == 0 {
                b.alpha[0] += (1.0 - b.alpha[0]) * inputs.unit();
            }
            return;
        }
        _ => {}
    }
    let exponential = b.distribution <= DISTRIBUTION_ASHIKHMIN_SHIRLEY;
    b.alpha = [1; 2].map(|_| {
        if exponential {
            inputs.log_range(0.01, 1e5)
        } else {
            rough(inputs)
        }
    });
    if inputs.pick(2) == 0 {
        b.alpha[1] = b.alpha[0];
    }
}

fn queries(seed: u64, kind: u32) -> Vec<LabQuery> {
    let tables = tables();
    Inputs::new(seed).queries(|inputs, q| {
        model(inputs, kind, &mut q.bsdf);
        if inputs.pick(4) == 0 {
            q.wo[2] = -q.wo[2];
        }
        if inputs.pick(4) == 0 {
            q.wi[2] = -q.wi[2];
        }
        // Half of the light directions are where the lobe sends them.
        if inputs.pick(2) == 0 {
            let query = Query::from(&*q);
            let sample = bsdf_sample(&tables, &query.bsdf, query.wo, query.u);
            q.wi = sample.wi.as_vec3().into();
        }
    })
}

/// f is compared down to this: what is smaller adds nothing to a picture.
const FLOOR: f64 = 1e-10;

/// glTF's material has factors 1 - E, differences that float32 knows to 1e-7, over averages of the same.
const FLOOR_GLTF: f64 = 2e-2;

/// Cosines below which 1 - E and 1 - F of a layer are nothing that float32 knows.
const GRAZING: f64 = 1e-3;

/// Whether a surface with layers that light passes is seen or lit edge on.
fn passes_edge_on(q: &Query) -> bool {
    let g = q.bsdf.gltf;
    if q.bsdf.model != BSDF_GLTF || (g.coat == 0.0 && g.iridescence == 0.0 && g.flags == 0) {
        return false;
    }
    let edge_on =
        |w: DVec3| w.z.abs() < GRAZING || mirrored_up(w).dot(g.coat_normal) < 10.0 * GRAZING;
    edge_on(q.wo) || q.wi.z.abs() < GRAZING
}

fn mirrored_up(w: DVec3) -> DVec3 {
    w.with_z(w.z.abs())
}

fn values(kind: u32) -> [Value; 4] {
    let floor = if kind == BSDF_GLTF { FLOOR_GLTF } else { FLOOR };
    ["f.x", "f.y", "f.z", "pdf"].map(|name| within(name, floor))
}

/// Whether float32 directions resolve the lobe here: an answer that changes by more than `share` when wi
/// moves by its last bit (6e-8) is one that no float32 arithmetic can give to a few times that share.
fn is_resolved(tables: &Tables, q: &Query, share: f64) -> bool {
    let e = bsdf_eval(tables, &q.bsdf, q.wo, q.wi);
    let last_bit = f64::from(f32::EPSILON) / 2.0;
    DVec3::AXES.iter().all(|axis| {
        let step = last_bit * axis;
        // glTF's frames of its own round wo too.
        let step_o = if q.bsdf.model == BSDF_GLTF {
            step
        } else {
            DVec3::ZERO
        };
        [(DVec3::ZERO, step), (step_o, DVec3::ZERO)]
            .into_iter()
            .all(|(o, i)| {
                let moved = bsdf_eval(tables, &q.bsdf, q.wo + o, q.wi + i);
                let change = (moved.f.max_element() - e.f.max_element()).abs()
                    / e.f.max_element().max(FLOOR);
                change.max((moved.pdf - e.pdf).abs() / e.pdf.max(FLOOR)) < share
            })
    })
}

fn check_eval(title: &str, kind: u32) {
    let tables = tables();
    let queries = queries(100 + u64::from(kind), kind);
    let gpu = on_lavapipe(
        "import package::bsdf::bsdf::{bsdf_eval, bsdf_is_delta};",
        "let e = bsdf_eval(q.bsdf, q.wo, q.wi);",
        &[
            "e.f.x",
            "e.f.y",
            "e.f.z",
            "e.pdf",
            "f32(bsdf_is_delta(q.bsdf))",
        ],
        &queries,
    );
    let mut expected = Vec::from(values(kind));
    expected.push(within("bsdf_is_delta", 1.0));
    compare(
        &format!("eval {title}"),
        &expected,
        &queries,
        &gpu,
        |q| {
            let e = bsdf_eval(&tables, &q.bsdf, q.wo, q.wi);
            let delta = f64::from(u8::from(bsdf_is_delta(&q.bsdf)));
            vec![e.f.x, e.f.y, e.f.z, e.pdf, delta]
        },
        // Only transmission needs it: facets seen edge on, where wo . wm is a difference.
        |q, _| {
            let transmits = kind == BSDF_ROUGH_DIELECTRIC || kind == BSDF_GLTF;
            // glTF's coat and anisotropy have frames of their own, where directions are rounded once more.
            let share = if kind == BSDF_GLTF { 3e-5 } else { 1e-4 };
            !passes_edge_on(q) && (!transmits || is_resolved(&tables, q, share))
        },
    );
}

fn check_sample(title: &str, kind: u32) {
    let tables = tables();
    let queries = queries(200 + u64::from(kind), kind);
    let gpu = on_lavapipe(
        "import package::bsdf::bsdf::{bsdf_sample};",
        "let s = bsdf_sample(q.bsdf, q.wo, q.u);",
        &[
            "s.f.x",
            "s.f.y",
            "s.f.z",
            "s.pdf",
            "s.wi.x",
            "s.wi.y",
            "s.wi.z",
            "f32(s.delta)",
        ],
        &queries,
    );
    // Directions, and how often the two sides chose differently (a lobe or the horizon missed by a bit).
    let (mut far, mut worst, mut parted) = (0, 0.0f64, 0);
    let (mut alike, mut answers) = (Vec::new(), Vec::new());
    for (mut query, answer) in queries.iter().copied().zip(&gpu) {
        assert!(
            answer.iter().all(|v| v.is_finite()),
            "{title}: {answer:?} of {query:?}"
        );
        let q = Query::from(&query);
        let twin = bsdf_sample(&tables, &q.bsdf, q.wo, q.u);
        let wi = DVec3::new(answer[4].into(), answer[5].into(), answer[6].into());
        query.wi = [answer[4], answer[5], answer[6]];
        let same = (twin.pdf > 0.0) == (answer[3] > 0.0)
            && f64::from(answer[7]) == f64::from(twin.delta)
            && wi.z * twin.wi.z >= 0.0;
        if passes_edge_on(&Query { wi: twin.wi, ..q }) {
            continue;
        }
        if !same {
            parted += 1;
            continue;
        }
        let error = (wi - twin.wi).length();
        far += usize::from(error > 1e-4);
        worst = worst.max(error);
        alike.push(query);
        answers.push(*answer);
    }
    println!(
        "sample {title:20} direction: max error {worst:9.2e}, {far} above 1e-4, {parted} chose differently"
    );
    // Facets seen edge on (u near 1) have directions that are differences of nearly equal vectors.
    assert!(far < COUNT / 300, "{title}: {far} directions differ");
    // glTF has five ways to choose from, others two.
    let borders = if kind == BSDF_GLTF { 4 } else { 1 };
    assert!(
        parted < borders * COUNT / 3000,
        "{title}: {parted} samples differ"
    );
    // f and pdf of the direction that was returned; a delta's are those of the twin's own sample.
    compare(
        &format!("sample {title}"),
        &values(kind),
        &alike,
        &answers,
        |q| {
            let twin = bsdf_sample(&tables, &q.bsdf, q.wo, q.u);
            if twin.delta != 0 || twin.pdf == 0.0 {
                return vec![twin.f.x, twin.f.y, twin.f.z, twin.pdf];
            }
            let e = bsdf_eval(&tables, &q.bsdf, q.wo, q.wi);
            vec![e.f.x, e.f.y, e.f.z, e.pdf]
        },
        // A sample is evaluated before its direction is rounded: there the last bit matters.
        |q, _| !passes_edge_on(q) && is_resolved(&tables, q, 2e-5),
    );
}

macro_rules! models {
    ($($name:ident $kind:ident,)*) => {$(
        mod $name {
            #[test]
            fn evaluates_alike() {
                super::check_eval(stringify!($name), snell::shared::$kind);
            }
            #[test]
            fn samples_alike() {
                super::check_sample(stringify!($name), snell::shared::$kind);
            }
        }
    )*};
}

models! {
    lambertian BSDF_LAMBERTIAN,
    oren_nayar BSDF_OREN_NAYAR,
    eon BSDF_OREN_NAYAR_EON,
    specular_reflection BSDF_SPECULAR_REFLECTION,
    specular_transmission BSDF_SPECULAR_TRANSMISSION,
    dielectric BSDF_DIELECTRIC,
    rough_dielectric BSDF_ROUGH_DIELECTRIC,
    torrance_sparrow BSDF_TORRANCE_SPARROW,
    gltf BSDF_GLTF,
}
