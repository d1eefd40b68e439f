//! `snell bsdf` as its users meet it: every example of the documentation, on lavapipe and with --cpu.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

#[path = "common/json_schema.rs"]
mod json_schema;

use assert_cmd::Command;
use json_schema::validate;
use serde_json::{Value, json};

const BACKENDS: [&[&str]; 2] = [&["--cpu"], &["--adapter", "llvmpipe"]];

fn snell(kind: &str, options: &[&str], input: &str) -> Vec<Value> {
    let output = Command::cargo_bin("snell")
        .unwrap()
        .args(["bsdf", kind])
        .args(options)
        .write_stdin(input)
        .assert()
        .success()
        .get_output()
        .stdout
        .clone();
    let text = String::from_utf8(output).unwrap();
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

fn lines(queries: &[Value]) -> String {
    queries.iter().map(|query| format!("{query}\n")).collect()
}

fn close(value: &Value, expected: f64) {
    let value = value.as_f64().unwrap();
    assert!(
        (value - expected).abs() <= 1e-5 * expected.abs().max(1e-3),
        "{value} {expected}"
    );
}

/// One query for each spelling of the grammar; `kind` is always there, so all go to `mixed`.
fn grammar() -> Vec<Value> {
    let fresnels = [
        json!({"constant": [0.5, 0.5, 0.5]}),
        json!({"dielectric": {"eta": 1.5}}),
        json!({"conductor": {"metal": "Au"}}),
        json!({"conductor": {"metal": "Cu", "form": "approximate"}}),
        json!({"conductor": {"eta": [0.2, 0.9, 1.1], "k": [3.9, 2.4, 2.2], "form": "exact"}}),
    ];
    let distributions = [
        json!({"name": "blinn", "exponent": 20}),
        json!({"name": "ashikhmin-shirley", "exponent": [20, 100]}),
        json!({"name": "beckmann", "alpha": 0.3}),
        json!({"name": "ggx", "alpha": [0.2, 0.5]}),
    ];
    let mut materials = vec![
        json!({"model": "lambertian", "reflectance": [0.5, 0.6, 0.7]}),
        json!({"model": "oren-nayar", "reflectance": [0.5, 0.6, 0.7], "form": "qualitative", "sigma": 0.3}),
        json!({"model": "oren-nayar", "reflectance": [0.5, 0.6, 0.7], "form": "energy-preserving", "roughness": 0.3}),
        json!({"model": "oren-nayar", "reflectance": [0.5, 0.6, 0.7], "roughness": 0.3}),
        json!({"model": "specular-transmission", "eta": 1.33}),
        json!({"model": "dielectric", "eta": 1.5}),
        json!({}),
        json!({"name": "plastic", "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1], "metallicFactor": 0, "roughnessFactor": 0.5}}),
        json!({"pbrMetallicRoughness": {}, "extensions": {"KHR_materials_ior": {"ior": 1.8}}, "emissiveFactor": [1, 1, 1]}),
        json!({"extensions": {"KHR_materials_unlit": {}}}),
        json!({"extensions": {"SNELL_materials_bsdf": {"model": "lambertian", "reflectance": [1, 1, 1]}}}),
    ];
    for (name, extension) in [
        ("transmission", json!({"transmissionFactor": 0.7})),
        (
            "diffuse_transmission",
            json!({"diffuseTransmissionFactor": 0.4, "diffuseTransmissionColorFactor": [1, 0.5, 0.2]}),
        ),
        ("dispersion", json!({"dispersion": 0.3})),
        (
            "specular",
            json!({"specularFactor": 0.6, "specularColorFactor": [2, 0.5, 1]}),
        ),
        (
            "clearcoat",
            json!({"clearcoatFactor": 0.8, "clearcoatRoughnessFactor": 0.2}),
        ),
        (
            "sheen",
            json!({"sheenColorFactor": [0.5, 0.4, 0.9], "sheenRoughnessFactor": 0.4}),
        ),
        (
            "anisotropy",
            json!({"anisotropyStrength": 0.6, "anisotropyRotation": 0.7}),
        ),
        (
            "iridescence",
            json!({"iridescenceFactor": 1, "iridescenceIor": 1.4, "iridescenceThicknessMinimum": 50, "iridescenceThicknessMaximum": 300}),
        ),
        (
            "pbrSpecularGlossiness",
            json!({"diffuseFactor": [0.2, 0.3, 0.4, 1], "specularFactor": [0.5, 0.4, 0.1], "glossinessFactor": 0.4}),
        ),
    ] {
        let name = format!("KHR_materials_{name}");
        let base = json!({"metallicFactor": 0.3, "roughnessFactor": 0.5});
        materials.push(json!({"pbrMetallicRoughness": base, "extensions": {name: extension}}));
    }
    materials.push(json!({
        "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.4},
        "extensions": {
            "KHR_materials_transmission": {"transmissionFactor": 1},
            "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [0.5, 0.5, 1]},
        },
    }));
    for fresnel in &fresnels {
        materials.push(json!({"model": "specular-reflection", "fresnel": fresnel}));
    }
    for distribution in &distributions {
        materials.push(json!({"model": "dielectric", "eta": 1.5, "distribution": distribution}));
        materials.push(json!({"model": "conductor", "conductor": {"metal": "Ag"}, "distribution": distribution}));
        for masking in ["none", "v-cavity", "smith"] {
            materials.push(json!({
                "model": "torrance-sparrow", "fresnel": {"dielectric": {"eta": 1.5}},
                "distribution": distribution, "masking": masking, "reflectance": [1, 0.5, 0.5],
            }));
        }
    }
    let mut queries = Vec::new();
    for fresnel in fresnels {
        queries.push(json!({"kind": "fresnel", "fresnel": fresnel, "cos_theta": 0.7}));
    }
    for material in materials {
        let wo = [0.6, 0.0, 0.8];
        queries.push(
            json!({"kind": "eval", "material": material, "wo": wo, "wi": [-0.36, 0.48, 0.8]}),
        );
        queries
            .push(json!({"kind": "sample", "material": material, "wo": wo, "u": [0.3, 0.6, 0.2]}));
        queries.push(json!({"kind": "albedo", "material": material, "wo": wo, "samples": 256}));
    }
    for (i, query) in queries.iter_mut().enumerate() {
        query["id"] = json!(i);
    }
    queries
}

#[test]
fn every_spelling_is_answered_alike_on_lavapipe_and_in_float64() {
    let queries = grammar();
    let schema: Value = serde_json::from_str(snell::cli::bsdf::SCHEMA).unwrap();
    for query in &queries {
        validate(&schema, &schema["$defs"]["query"], query).unwrap();
    }
    let [cpu, gpu] = BACKENDS.map(|options| snell("mixed", options, &lines(&queries)));
    assert_eq!((cpu.len(), gpu.len()), (queries.len(), queries.len()));
    for ((query, a), b) in queries.iter().zip(&cpu).zip(&gpu) {
        for answer in [a, b] {
            assert_eq!(answer["id"], query["id"]);
            assert!(answer.get("error").is_none(), "{query}: {answer}");
            validate(&schema, &schema["$defs"]["answer"], answer).unwrap();
        }
        alike(a, b, &query.to_string());
    }
}

/// Numbers within 1e-3, everything else the same.
fn alike(a: &Value, b: &Value, query: &str) {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            assert!(
                (a - b).abs() <= 1e-3 * a.abs().max(1e-2),
                "{query}: {a} {b}"
            );
        }
        (Value::Array(a), Value::Array(b)) => {
            a.iter().zip(b).for_each(|(a, b)| alike(a, b, query));
        }
        (Value::Object(a), Value::Object(b)) => {
            assert!(a.keys().eq(b.keys()), "{query}");
            a.values()
                .zip(b.values())
                .for_each(|(a, b)| alike(a, b, query));
        }
        _ => assert_eq!(a, b, "{query}"),
    }
}

#[test]
fn answers_are_right_where_the_closed_form_is_known() {
    for options in BACKENDS {
        let fresnel = json!({"id": 0, "fresnel": {"dielectric": {"eta": 1.5}}, "cos_theta": 1});
        close(
            &snell("fresnel", options, &lines(&[fresnel]))[0]["F"][0],
            0.04,
        );

        let grey = json!({"model": "lambertian", "reflectance": [0.5, 0.5, 0.5]});
        let eval = json!({"id": "e", "material": grey, "wo": [0, 0, 1], "wi": [0.6, 0, 0.8]});
        let answer = &snell("eval", options, &lines(&[eval]))[0];
        close(&answer["f"][0], 0.5 / std::f64::consts::PI);
        close(&answer["pdf"], 0.8 / std::f64::consts::PI);

        let glass = json!({"model": "dielectric", "eta": 1.5});
        let sample = json!({"id": null, "material": glass, "wo": [0, 0, 1], "u": [0.5, 0.5, 0.5]});
        let answer = &snell("sample", options, &lines(&[sample]))[0];
        assert_eq!(
            (&answer["delta"], &answer["id"]),
            (&json!(true), &Value::Null)
        );
        close(&answer["wi"][2], -1.0);
        close(&answer["pdf"], 0.96);
        close(&answer["f"][0], 0.96 / 2.25);

        let albedo = json!({"id": [1], "material": grey, "wo": [0.6, 0, 0.8], "samples": 4096});
        let answer = &snell("albedo", options, &lines(&[albedo]))[0];
        assert_eq!(answer["id"], json!([1]));
        close(&answer["albedo"][0], 0.5);
        assert!(answer["stderr"][0].as_f64().unwrap() < 1e-6);
    }
}

#[test]
fn faults_are_answered_in_their_place_and_the_run_goes_on() {
    let grey = r#"{"model":"lambertian","reflectance":[0.5,0.5,0.5]}"#;
    let good = format!(r#"{{"id":"good","material":{grey},"wo":[0,0,1.0005],"wi":[0,0,1]}}"#);
    let cases = [
        ("{".to_owned(), Value::Null, "not JSON"),
        ("[1]".to_owned(), Value::Null, "a JSON object"),
        (r#"{"id":1}"#.to_owned(), json!(1), "`material` is missing"),
        (format!(r#"{{"id":2,"material":{grey},"wi":[0,0,1]}}"#), json!(2), "`wo` is missing"),
        (format!(r#"{{"id":3,"material":{grey},"wo":[0,0,1.01],"wi":[0,0,1]}}"#), json!(3), "1.01, not 1"),
        (format!(r#"{{"id":4,"material":{grey},"wo":[0,0,0],"wi":[0,0,1]}}"#), json!(4), "length 0"),
        (format!(r#"{{"id":5,"material":{grey},"wo":[0,1],"wi":[0,0,1]}}"#), json!(5), "`wo`"),
        (format!(r#"{{"id":6,"material":{grey},"wo":[0,null,1],"wi":[0,0,1]}}"#), json!(6), "`wo`"),
        (r#"{"id":7,"material":{"model":"phong"},"wo":[0,0,1],"wi":[0,0,1]}"#.to_owned(), json!(7), "phong"),
        (format!(r#"{{"id":8,"kind":"sample","material":{grey},"wo":[0,0,1],"u":[0,0,0]}}"#), json!(8), "mixed"),
        (
            r#"{"id":9,"material":{"normalTexture":{"index":0}},"wo":[0,0,1],"wi":[0,0,1]}"#.to_owned(),
            json!(9),
            "normalTexture",
        ),
        (
            r#"{"id":10,"material":{"extensions":{"KHR_materials_fuzz":{}}},"wo":[0,0,1],"wi":[0,0,1]}"#.to_owned(),
            json!(10),
            "KHR_materials_fuzz",
        ),
        (format!("{}1{}", "[".repeat(500), "]".repeat(500)), Value::Null, "not JSON"),
        (format!(r#"{{"id":"{}"}}"#, "x".repeat(2 << 20)), Value::Null, "1 MiB"),
    ];
    for options in BACKENDS {
        let mut input = String::new();
        for (line, _, _) in &cases {
            input += &format!("{line}\n\n{good}\n");
        }
        let answers = snell("eval", options, input.trim_end());
        assert_eq!(answers.len(), 2 * cases.len());
        for ((_, id, message), pair) in cases.iter().zip(answers.chunks(2)) {
            assert_eq!(pair[0]["id"], *id);
            let error = pair[0]["error"].as_str().unwrap();
            assert!(
                error.contains(message),
                "{error:?} does not say {message:?}"
            );
            assert_eq!(pair[1]["id"], "good");
            close(&pair[1]["pdf"], 1.0 / std::f64::consts::PI);
        }
    }
}

#[test]
fn a_program_may_ask_and_wait_for_the_answer() {
    use std::io::{BufRead, BufReader, Write};
    use std::process::{Command, Stdio};
    let mut child = Command::new(assert_cmd::cargo::cargo_bin!("snell"))
        .args(["bsdf", "fresnel", "--cpu"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap());
    for id in 0..3 {
        writeln!(
            input,
            r#"{{"id":{id},"fresnel":{{"constant":[1,1,1]}},"cos_theta":0.5}}"#
        )
        .unwrap();
        let mut answer = String::new();
        output.read_line(&mut answer).unwrap();
        assert_eq!(answer, format!("{{\"id\":{id},\"F\":[1.0,1.0,1.0]}}\n"));
    }
    drop(input);
    assert!(child.wait().unwrap().success());
}

#[test]
fn many_queries_are_answered_in_order() {
    let queries: String = (0..20_000)
        .map(|id| {
            format!(r#"{{"id":{id},"fresnel":{{"dielectric":{{"eta":1.5}}}},"cos_theta":0.3}}"#)
                + "\n"
        })
        .collect();
    for options in BACKENDS {
        let answers = snell("fresnel", options, &queries);
        assert_eq!(answers.len(), 20_000);
        assert!(
            answers
                .iter()
                .enumerate()
                .all(|(i, answer)| answer["id"] == i)
        );
    }
}

#[test]
fn exit_status_tells_what_went_wrong() {
    let run = |args: &[&str]| {
        let mut command = Command::cargo_bin("snell").unwrap();
        command.arg("bsdf").args(args).assert()
    };
    run(&["--schema"])
        .success()
        .stdout(snell::cli::bsdf::SCHEMA);
    run(&[]).code(2);
    run(&["colour"]).code(2);
    run(&["eval", "--cpu", "--adapter", "x"]).code(2);
    run(&["eval", "--cpu", "no/such/file"]).code(3);
    run(&["eval", "--adapter", "no such adapter"]).code(5);
}

#[test]
fn the_schema_refuses_what_the_program_refuses() {
    let schema: Value = serde_json::from_str(snell::cli::bsdf::SCHEMA).unwrap();
    let query = |material: Value| json!({"material": material, "wo": [0, 0, 1], "wi": [0, 0, 1]});
    for bad in [
        json!({"model": "lambertian", "reflectance": [2, 0, 0]}),
        json!({"model": "lambertian"}),
        json!({"model": "oren-nayar", "reflectance": [1, 1, 1], "sigma": 0.5}),
        json!({"model": "dielectric", "eta": 0}),
        json!({"model": "conductor", "conductor": {"metal": "Unobtainium"}}),
        json!({"model": "conductor", "conductor": {"eta": [1, 1, 1]}}),
        json!({"normalTexture": {"index": 0}}),
        json!({"extensions": {"KHR_materials_fuzz": {}}}),
        json!({"extensions": {"KHR_materials_ior": {"ior": 0.5}}}),
        json!({"extensions": {"KHR_materials_sheen": {"sheenColorFactor": [1.5, 0, 0]}}}),
        json!({"extensions": {"KHR_materials_clearcoat": {"clearcoatTexture": {"index": 0}}}}),
        json!({"extensions": {"KHR_materials_volume": {"attenuationDistance": 0}}}),
        json!({"extensions": {"KHR_materials_iridescence": {"iridescenceIOR": 1.2}}}),
        json!({"extensions": {"KHR_materials_dispersion": {"dispersion": -1}}}),
        json!({"pbrMetallicRoughness": {"metalicFactor": 1}}),
        json!({"pbrMetallicRoughness": {"metallicFactor": 2}}),
    ] {
        let query = query(bad);
        assert!(
            validate(&schema, &schema["$defs"]["query"], &query).is_err(),
            "{query}"
        );
        let answer = &snell("eval", &["--cpu"], &lines(std::slice::from_ref(&query)))[0];
        assert!(answer.get("error").is_some(), "{query}");
    }
}
