// The reflection laboratory: one query, one answer (src/lab). No path, no scene but the tables.

import package::shared::{LabQuery, LabAnswer};
import package::bsdf::fresnel::{fresnel_F};
import package::bsdf::bsdf::{bsdf_eval, bsdf_sample};

@group(1) @binding(0) var<storage, read> queries: array<LabQuery>;
@group(1) @binding(1) var<storage, read_write> answers: array<LabAnswer>;

@compute @workgroup_size(64)
fn fresnel(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&queries) {
        return;
    }
    let F = fresnel_F(queries[id.x].bsdf, queries[id.x].cos_theta);
    answers[id.x] = LabAnswer(F, 0.0, vec3(0.0), 0u);
}

@compute @workgroup_size(64)
fn eval(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&queries) {
        return;
    }
    let query = queries[id.x];
    let value = bsdf_eval(query.bsdf, query.wo, query.wi);
    answers[id.x] = LabAnswer(value.f, value.pdf, query.wi, 0u);
}

@compute @workgroup_size(64)
fn sample(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&queries) {
        return;
    }
    let query = queries[id.x];
    let drawn = bsdf_sample(query.bsdf, query.wo, query.u);
    answers[id.x] = LabAnswer(drawn.f, drawn.pdf, drawn.wi, drawn.delta);
}
