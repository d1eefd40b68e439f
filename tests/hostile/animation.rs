//! Animations that make no sense.

use crate::asset::Asset;
use crate::invalid;
use serde_json::{Value, json};

/// A channel of two keys on a node's translation.
fn animated(times: &[f32], values: &[f32]) -> Asset {
    let mut asset = Asset::triangle();
    let input = asset.floats("SCALAR", times);
    let output = asset.floats("VEC3", values);
    asset.json["animations"] = json!([{
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
        "samplers": [{"input": input, "output": output}],
    }]);
    asset
}

fn edited(edit: impl FnOnce(&mut Value)) -> Asset {
    let mut asset = animated(&[0.0, 1.0], &[0.0; 6]);
    edit(&mut asset.json);
    asset
}

#[test]
fn keys_that_make_no_sense() {
    let input = "animations[0].samplers[0].input";
    let output = "animations[0].samplers[0].output";
    for (times, words) in [
        ([f32::NAN, 1.0], "the time of key 0 is NaN"),
        ([0.0, f32::INFINITY], "the time of key 1 is inf"),
        ([-1.0, 1.0], "key 0 is -1"),
        ([1.0, 0.5], "do not ascend"),
    ] {
        invalid(&animated(&times, &[0.0; 6]), input, words);
    }
    invalid(&animated(&[], &[]), input, "no keys");
    invalid(
        &animated(&[0.0, 1.0], &[0.0; 9]),
        output,
        "9 numbers; 2 keys of 3 take 6",
    );
    let spline =
        edited(|json| json["animations"][0]["samplers"][0]["interpolation"] = json!("CUBICSPLINE"));
    invalid(&spline, output, "2 keys of 9 take 18");
    let nan = [0.0, 0.0, 0.0, 0.0, f32::NAN, 0.0];
    invalid(&animated(&[0.0, 1.0], &nan), output, "key 1 holds NaN");
    let mut still = animated(&[0.0], &[0.0; 3]);
    let zero = still.floats("VEC4", &[0.0; 4]);
    still.json["animations"][0]["samplers"][0]["output"] = json!(zero);
    still.json["animations"][0]["channels"][0]["target"]["path"] = json!("rotation");
    invalid(&still, output, "length zero");
}

#[test]
fn channels_that_make_no_sense() {
    let channel = "animations[0].channels[0]";
    let sampler = "animations[0].samplers[0]";
    let target = |edit: Value| edited(|json| json["animations"][0]["channels"][0]["target"] = edit);
    invalid(
        &target(json!({"node": 0, "path": "colour"})),
        &format!("{channel}.target.path"),
        "`colour` is none of",
    );
    invalid(
        &target(json!({"node": 4, "path": "scale"})),
        &format!("{channel}.target.node"),
        "out of range",
    );
    invalid(
        &target(json!({"node": 0})),
        &format!("{channel}.target"),
        "`path` is missing",
    );
    invalid(
        &target(json!([])),
        &format!("{channel}.target"),
        "is not an object",
    );
    invalid(
        &edited(|json| json["animations"][0]["channels"][0]["sampler"] = json!(1)),
        &format!("{channel}.sampler"),
        "there are 1 samplers",
    );
    invalid(
        &edited(|json| json["animations"][0]["samplers"][0]["interpolation"] = json!("BEZIER")),
        &format!("{sampler}.interpolation"),
        "`BEZIER` is none of",
    );
    invalid(
        &edited(|json| json["animations"][0]["samplers"][0]["input"] = json!(99)),
        &format!("{sampler}.input"),
        "out of range",
    );
    invalid(
        &edited(|json| json["animations"][0]["samplers"][0]["output"] = json!(1)),
        "accessors[1].type",
        "it is SCALAR where VEC3 belongs",
    );
    invalid(
        &edited(|json| {
            json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])
        }),
        &format!("{channel}.target"),
        "nodes[0] has a matrix",
    );
    // A morphed mesh with two targets and keys for one.
    let mut weights = animated(&[0.0, 1.0], &[0.0; 6]);
    weights.primitive()["targets"] = json!([{}, {}]);
    let output = weights.floats("SCALAR", &[0.0, 1.0]);
    weights.json["animations"][0]["samplers"][0]["output"] = json!(output);
    weights.json["animations"][0]["channels"][0]["target"]["path"] = json!("weights");
    invalid(
        &weights,
        &format!("{sampler}.output"),
        "2 numbers; 2 keys of 2 take 4",
    );
}

#[test]
fn displacements_that_make_no_sense() {
    let target = "meshes[0].primitives[0].targets[0]";
    let morphed = |values: &[f32]| {
        let mut asset = Asset::triangle();
        let deltas = asset.floats("VEC3", values);
        asset.primitive()["targets"] = json!([{"POSITION": deltas}]);
        asset.json["meshes"][0]["weights"] = json!([1]);
        asset
    };
    let mut bad = [0.0; 9];
    bad[4] = f32::NAN;
    invalid(&morphed(&bad), target, "POSITION of vertex 1 is not finite");
    invalid(
        &morphed(&[0.0; 6]),
        target,
        "POSITION has 2 elements and the primitive has 3",
    );
}

#[test]
fn joints_without_weights() {
    let mut asset = Asset::triangle();
    let joints = asset.accessor(crate::asset::U8, "VEC4", 3, &[0; 12]);
    asset.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    asset.json["nodes"][0]["skin"] = json!(0);
    asset.json["skins"] = json!([{"joints": [0]}]);
    invalid(
        &asset,
        "meshes[0].primitives[0].attributes",
        "belong together",
    );
}
