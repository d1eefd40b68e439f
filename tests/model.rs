//! Lowering of the lecture's models: every spelling of DESIGN's grammar, and a sentence per fault.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

use bytemuck::Zeroable;
use snell::pack::model::{ModelError, lower_bsdf};
use snell::scene::bsdf_model::BsdfModel;
use snell::scene::metals::metal;
use snell::shared::*;

fn lower(json: &str) -> Result<Material, ModelError> {
    let model: BsdfModel = serde_json::from_str(json).unwrap();
    let mut material = Material::zeroed();
    lower_bsdf(&model, &mut material).map(|()| material)
}

#[test]
fn diffuse_models() {
    let m = lower(r#"{"model":"lambertian","reflectance":[0.1,0.2,0.3]}"#).unwrap();
    assert_eq!(m.model, BSDF_LAMBERTIAN);
    assert_eq!(m.base_color[..3], [0.1, 0.2, 0.3]);
    let m =
        lower(r#"{"model":"oren-nayar","reflectance":[1,1,1],"form":"qualitative","sigma":0.35}"#);
    assert_eq!(
        m.map(|m| (m.model, m.roughness)),
        Ok((BSDF_OREN_NAYAR, 0.35))
    );
    for form in ["", r#","form":"energy-preserving""#] {
        let json =
            format!(r#"{{"model":"oren-nayar","reflectance":[1,1,1]{form},"roughness":0.5}}"#);
        let m = lower(&json);
        assert_eq!(
            m.map(|m| (m.model, m.roughness)),
            Ok((BSDF_OREN_NAYAR_EON, 0.5))
        );
    }
}

#[test]
fn specular_models() {
    let m = lower(r#"{"model":"specular-reflection","fresnel":{"constant":[1,0.5,0]}}"#).unwrap();
    assert_eq!(
        (m.model, m.fresnel),
        (BSDF_SPECULAR_REFLECTION, FRESNEL_CONSTANT)
    );
    assert_eq!((m.eta, m.flags), ([1.0, 0.5, 0.0], 0));
    let m = lower(r#"{"model":"specular-transmission","eta":1.33}"#).unwrap();
    assert_eq!(
        (m.model, m.fresnel),
        (BSDF_SPECULAR_TRANSMISSION, FRESNEL_DIELECTRIC)
    );
    assert_eq!(
        (m.ior, m.eta, m.flags),
        (1.33, [1.33; 3], MATERIAL_TRANSMISSIVE)
    );
    let m = lower(r#"{"model":"dielectric","eta":1.5}"#).unwrap();
    assert_eq!((m.model, m.flags), (BSDF_DIELECTRIC, MATERIAL_TRANSMISSIVE));
    let m = lower(r#"{"model":"conductor","conductor":{"metal":"Au"}}"#).unwrap();
    assert_eq!(
        (m.model, m.fresnel),
        (BSDF_SPECULAR_REFLECTION, FRESNEL_CONDUCTOR)
    );
    assert_eq!([m.eta, m.k], metal("Au").unwrap().index());
}

#[test]
fn facet_models_take_their_natural_masking() {
    let cases = [
        (
            r#"{"name":"blinn","exponent":50}"#,
            DISTRIBUTION_BLINN,
            [50.0; 2],
            MASKING_V_CAVITY,
        ),
        (
            r#"{"name":"ashikhmin-shirley","exponent":[10,100]}"#,
            DISTRIBUTION_ASHIKHMIN_SHIRLEY,
            [10.0, 100.0],
            MASKING_V_CAVITY,
        ),
        (
            r#"{"name":"beckmann","alpha":0.3}"#,
            DISTRIBUTION_BECKMANN,
            [0.3; 2],
            MASKING_SMITH,
        ),
        (
            r#"{"name":"ggx","alpha":[0.1,0.4]}"#,
            DISTRIBUTION_GGX,
            [0.1, 0.4],
            MASKING_SMITH,
        ),
    ];
    for (distribution, name, alpha, masking) in cases {
        for (head, model) in [
            (r#""model":"dielectric","eta":1.5"#, BSDF_ROUGH_DIELECTRIC),
            (
                r#""model":"conductor","conductor":{"metal":"Cu"}"#,
                BSDF_TORRANCE_SPARROW,
            ),
            (
                r#""model":"torrance-sparrow","fresnel":{"dielectric":{"eta":1.5}}"#,
                BSDF_TORRANCE_SPARROW,
            ),
        ] {
            let m = lower(&format!(r#"{{{head},"distribution":{distribution}}}"#)).unwrap();
            assert_eq!(m.model, model);
            assert_eq!((m.distribution, m.alpha, m.masking), (name, alpha, masking));
            assert_eq!(m.base_color[..3], [1.0; 3]);
        }
    }
    for (masking, value) in [
        ("none", MASKING_NONE),
        ("v-cavity", MASKING_V_CAVITY),
        ("smith", MASKING_SMITH),
    ] {
        let m = lower(&format!(
            r#"{{"model":"torrance-sparrow",
                 "fresnel":{{"conductor":{{"eta":[1,2,3],"k":[4,5,6],"form":"approximate"}}}},
                 "distribution":{{"name":"ggx","alpha":0.5}},"masking":"{masking}",
                 "reflectance":[0.5,0.5,0.5]}}"#
        ))
        .unwrap();
        assert_eq!(
            (m.masking, m.fresnel),
            (value, FRESNEL_CONDUCTOR_APPROXIMATE)
        );
        assert_eq!((m.eta, m.k), ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]));
        assert_eq!(m.base_color[..3], [0.5; 3]);
    }
}

#[test]
fn faults_are_told_in_a_sentence() {
    let ts = r#"{"model":"torrance-sparrow","fresnel":{"constant":[1,1,1]},"distribution":"#;
    let cases = [
        (
            r#"{"model":"lambertian","reflectance":[0.1,1.2,0.3]}"#.to_string(),
            "`reflectance` is 1.2, but must be from 0 to 1",
        ),
        (
            r#"{"model":"oren-nayar","reflectance":[1,1,1],"form":"qualitative","sigma":-1}"#
                .into(),
            "`sigma` is -1, but must be 0 or more (radians)",
        ),
        (
            r#"{"model":"oren-nayar","reflectance":[1,1,1],"form":"qualitative"}"#.into(),
            "form `qualitative` of oren-nayar takes `sigma`, which is missing",
        ),
        (
            r#"{"model":"oren-nayar","reflectance":[1,1,1],"sigma":0.1}"#.into(),
            "form `energy-preserving` of oren-nayar takes `roughness`, not `sigma`",
        ),
        (
            r#"{"model":"dielectric","eta":0}"#.into(),
            "`eta` is 0, but must be greater than 0",
        ),
        (
            r#"{"model":"specular-reflection","fresnel":{"constant":[2,0,0]}}"#.into(),
            "`constant` is 2, but must be from 0 to 1",
        ),
        (
            r#"{"model":"conductor","conductor":{"eta":[1,1,1],"k":[0,-0.5,0]}}"#.into(),
            "`k` is -0.5, but must be 0 or more",
        ),
        (
            r#"{"model":"conductor","conductor":{"eta":[1,1,1]}}"#.into(),
            "a conductor is given by `metal`, or by both `eta` and `k`",
        ),
        (
            format!(r#"{ts}{{"name":"ggx","alpha":0}}}}"#),
            "`alpha` is 0, but must be greater than 0",
        ),
        (
            format!(r#"{ts}{{"name":"beckmann","alpha":1e300}}}}"#),
            "`alpha` is inf, but must be greater than 0",
        ),
        (
            format!(r#"{ts}{{"name":"blinn","exponent":-0.5}}}}"#),
            "`exponent` is -0.5, but must be 0 or more",
        ),
    ];
    for (json, message) in cases {
        assert_eq!(lower(&json).unwrap_err().to_string(), message, "{json}");
    }
    let message = lower(r#"{"model":"conductor","conductor":{"metal":"Xx"}}"#).unwrap_err();
    assert!(
        message
            .to_string()
            .starts_with("no metal `Xx` is known; give `eta` and `k`, or one of Ag, Al, ")
    );
}
