//! Runs one WGSL expression list over many queries on lavapipe and compares with the float64 twin.

#![allow(dead_code, reason = "each test file uses a part of this")]

use super::common;
use bytemuck::Zeroable;
use glam::{DVec2, DVec3};
use snell::cpu::bsdf::Bsdf;
use snell::pack::Packed;
use snell::shared::{self, Frame, LabQuery, LightNode};

/// How many queries each function answers.
pub const COUNT: usize = 100_000;
/// Values that a kernel returns for one query.
pub const OUTPUTS: usize = 8;
/// What the product promises.
pub const TOLERANCE: f64 = 1e-4;

/// A query as the twins see it: the very float32 numbers, in float64.
pub struct Query {
    pub bsdf: Bsdf,
    pub wo: DVec3,
    pub wi: DVec3,
    pub u: DVec3,
    pub cos_theta: f64,
}

impl From<&LabQuery> for Query {
    fn from(query: &LabQuery) -> Self {
        let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        Self {
            bsdf: Bsdf::from(&query.bsdf),
            wo: vector(query.wo),
            wi: vector(query.wi),
            u: vector(query.u),
            cos_theta: f64::from(query.cos_theta),
        }
    }
}

/// One value of an answer and how it is judged: |gpu - cpu| <= limit * max(|cpu|, floor).
pub struct Value {
    pub name: &'static str,
    pub floor: f64,
    pub limit: f64,
}

/// Relative error within `TOLERANCE` down to the smallest numbers float32 divides by.
pub const fn relative(name: &'static str) -> Value {
    within(name, 1e-30)
}

/// Relative error within `TOLERANCE`, below `floor` absolute.
pub const fn within(name: &'static str, floor: f64) -> Value {
    Value {
        name,
        floor,
        limit: TOLERANCE,
    }
}

/// A packed scene with nothing in it but the tables.
pub fn tables_only() -> Packed {
    let mut frame = Frame::zeroed();
    frame.environment_size = [1, 1];
    frame.environment_cells = [1, 1];
    Packed {
        frame,
        tables: snell::tables::tables(),
        nodes: Vec::new(),
        triangles: Vec::new(),
        instances: Vec::new(),
        vertices: Vec::new(),
        materials: Vec::new(),
        texels: Vec::new(),
        lights: Vec::new(),
        light_nodes: vec![LightNode::zeroed()],
        environment: vec![[0.0; 4]],
        environment_cells: vec![[0.0; 2]; 2],
    }
}

/// Evaluates `values` (WGSL expressions of the query `q`, up to `OUTPUTS`) after `statements`.
pub fn on_lavapipe(
    imports: &str,
    statements: &str,
    values: &[&str],
    queries: &[LabQuery],
) -> Vec<[f32; OUTPUTS]> {
    let mut list = values.join(", ");
    for _ in values.len()..OUTPUTS {
        list.push_str(", 0.0");
    }
    let root = format!(
        "{imports}
import package::shared::{{LabQuery}};
struct Answer {{ v: array<f32, {OUTPUTS}> }}
@group(3) @binding(0) var<storage, read> parity_queries: array<LabQuery>;
@group(3) @binding(1) var<storage, read_write> parity_answers: array<Answer>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {{
    if id.x >= arrayLength(&parity_queries) {{ return; }}
    let q = parity_queries[id.x];
    {statements}
    parity_answers[id.x] = Answer(array<f32, {OUTPUTS}>({list}));
}}"
    );
    let bytes = common::run_on(
        &common::gpu(),
        &root,
        Some(&tables_only()),
        &[bytemuck::cast_slice(queries)],
        queries.len() * OUTPUTS * 4,
        queries.len() as u32,
    );
    bytemuck::pod_collect_to_vec(&bytes)
}

/// Compares answers value by value, prints the largest error of each, and fails beyond its limit.
/// `conditioned` says which queries float32 can answer at all; those that it cannot are counted.
pub fn compare(
    title: &str,
    values: &[Value],
    queries: &[LabQuery],
    gpu: &[[f32; OUTPUTS]],
    cpu: impl Fn(&Query) -> Vec<f64>,
    conditioned: impl Fn(&Query, usize) -> bool,
) {
    let mut worst = vec![(0.0, 0); values.len()];
    let mut left_out = vec![0; values.len()];
    for (index, (query, answer)) in queries.iter().zip(gpu).enumerate() {
        let query = Query::from(query);
        let truth = cpu(&query);
        assert_eq!(truth.len(), values.len(), "{title}");
        for (v, value) in values.iter().enumerate() {
            let (got, want) = (f64::from(answer[v]), truth[v]);
            assert!(
                got.is_finite() && want.is_finite(),
                "{title}: {} is {got} on the GPU, {want} on the CPU, of {:?}",
                value.name,
                queries[index]
            );
            if !conditioned(&query, v) {
                left_out[v] += 1;
                continue;
            }
            let error = (got - want).abs() / want.abs().max(value.floor);
            if error > worst[v].0 {
                worst[v] = (error, index);
            }
        }
    }
    let mut failures = Vec::new();
    for (v, value) in values.iter().enumerate() {
        let (error, index) = worst[v];
        println!(
            "{title:24} {:28} max error {error:9.2e}   left out {}",
            value.name, left_out[v]
        );
        if error > value.limit {
            let query = &queries[index];
            failures.push(format!(
                "{title}: {} is {:e}, should be {:e} (error {error:.2e}) of {query:?}",
                value.name,
                gpu[index][v],
                cpu(&Query::from(query))[v],
            ));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// A small generator of inputs with a fixed seed (Steele et al. 2014, "Fast Splittable Pseudorandom
/// Number Generators", SplitMix64).
pub struct Inputs(u64);

impl Inputs {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A multiple of 2^-24 in [0, 1), as the samplers give.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / 16_777_216.0
    }

    pub fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// Uniform in the logarithm.
    pub fn log_range(&mut self, low: f32, high: f32) -> f32 {
        let (low, high) = (f64::from(low).ln(), f64::from(high).ln());
        (low + (high - low) * f64::from(self.unit())).exp() as f32
    }

    pub fn pick(&mut self, count: u32) -> u32 {
        (self.bits() >> 32) as u32 % count
    }

    /// A cosine in [0, 1]: plain, grazing, near 1, or an end.
    pub fn cosine(&mut self) -> f32 {
        match self.pick(8) {
            0 => self.log_range(1e-9, 1.0),
            1 => 1.0 - self.log_range(1e-7, 1.0),
            2 => [0.0, 1.0][self.pick(2) as usize],
            _ => self.unit(),
        }
    }

    /// A unit direction above the surface; grazing, perpendicular and in-plane ones included.
    pub fn direction(&mut self) -> [f32; 3] {
        let z = f64::from(self.cosine());
        let phi = match self.pick(8) {
            0 => f64::from(self.pick(4)) * std::f64::consts::FRAC_PI_2,
            _ => f64::from(self.unit()) * std::f64::consts::TAU,
        };
        let r = ((1.0 - z) * (1.0 + z)).sqrt();
        [(r * phi.cos()) as f32, (r * phi.sin()) as f32, z as f32]
    }

    pub fn units(&mut self) -> [f32; 3] {
        match self.pick(64) {
            0 => [0.0; 3],
            1 => [1.0 - f32::EPSILON / 2.0; 3],
            _ => [self.unit(), self.unit(), self.unit()],
        }
    }

    pub fn color(&mut self) -> [f32; 3] {
        match self.pick(8) {
            0 => [1.0; 3],
            1 => [0.0; 3],
            _ => [self.unit(), self.unit(), self.unit()],
        }
    }

    /// Far index over near index of dielectrics.
    pub fn eta(&mut self) -> f32 {
        match self.pick(8) {
            0 => 1.5,
            1 => 1.0 / 1.5,
            2 => 1.0 + self.range(-0.01, 0.01),
            _ => self.log_range(0.3, 3.0),
        }
    }

    /// A query with everything in it but a model.
    pub fn query(&mut self) -> LabQuery {
        LabQuery {
            bsdf: shared::Bsdf {
                reflectance: self.color(),
                ..shared::Bsdf::zeroed()
            },
            wo: self.direction(),
            cos_theta: self.cosine(),
            wi: self.direction(),
            u: self.units(),
            ..LabQuery::zeroed()
        }
    }

    pub fn queries(&mut self, fill: impl Fn(&mut Self, &mut LabQuery)) -> Vec<LabQuery> {
        (0..COUNT)
            .map(|_| {
                let mut query = self.query();
                fill(self, &mut query);
                query
            })
            .collect()
    }
}

/// The first two coordinates.
pub fn xy(v: DVec3) -> DVec2 {
    v.truncate()
}

pub fn yz(v: DVec3) -> DVec2 {
    DVec2::new(v.y, v.z)
}
