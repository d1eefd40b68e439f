//! The reflection functions broken on purpose: each change of the shaders must be caught by the
//! comparison with the float64 twin, or by what physics and statistics say of a lobe.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

#[path = "common/chi2.rs"]
mod chi2;
mod common;
#[path = "common/examine.rs"]
mod examine;
#[path = "common/lobes.rs"]
mod lobes;

use glam::DVec3;
use lobes::{Lobe, bsdf, uniforms};
use snell::gpu::link::link;
use snell::lab::{Input, Lab, Stage};

/// Answers that differ by more than this share of themselves are different.
const DIFFERENT: f64 = 0.01;
/// A break is caught where at least this share of answers is different.
const CAUGHT: f64 = 0.02;
/// Chance that a sound lobe looks so odd.
const ODD: f64 = 1e-9;

/// How a break shows.
enum Check {
    /// Answers of a stage differ from the twin's.
    Parity(Stage),
    /// At this angle (degrees) samples do not follow the pdf, weights are too large, or energy is made.
    Statistics(f64),
}
use Check::*;

/// In the linked text `from`, which stands there once, becomes `to`.
struct Mutation {
    name: &'static str,
    from: &'static str,
    to: &'static str,
    check: Check,
    material: &'static str,
}

const GREY: &str = r#"{"model":"lambertian","reflectance":[0.5,0.5,0.5]}"#;
const ROUGH: &str =
    r#"{"model":"oren-nayar","reflectance":[0.8,0.8,0.8],"form":"qualitative","sigma":0.5}"#;
const EON: &str = r#"{"model":"oren-nayar","reflectance":[0.8,0.8,0.8],"roughness":0.9}"#;
const MIRROR: &str = r#"{"model":"specular-reflection","fresnel":{"dielectric":{"eta":1.5}}}"#;
const TITANIUM: &str = r#"{"model":"conductor","conductor":{"metal":"Ti"}}"#;
const TITANIUM_APPROXIMATE: &str =
    r#"{"model":"conductor","conductor":{"metal":"Ti","form":"approximate"}}"#;
const REFRACTION: &str = r#"{"model":"specular-transmission","eta":1.5}"#;
const GLASS: &str = r#"{"model":"dielectric","eta":1.5}"#;
const FROSTED: &str =
    r#"{"model":"dielectric","eta":1.5,"distribution":{"name":"ggx","alpha":0.4}}"#;
const GGX: &str = r#"{"model":"torrance-sparrow","fresnel":{"constant":[1,1,1]},"distribution":{"name":"ggx","alpha":0.5}}"#;
const BRUSHED: &str = r#"{"model":"torrance-sparrow","fresnel":{"constant":[1,1,1]},"distribution":{"name":"ggx","alpha":[0.9,0.1]}}"#;
const BECKMANN: &str = r#"{"model":"torrance-sparrow","fresnel":{"constant":[1,1,1]},"distribution":{"name":"beckmann","alpha":0.5}}"#;
const BLINN: &str = r#"{"model":"torrance-sparrow","fresnel":{"constant":[1,1,1]},"distribution":{"name":"blinn","exponent":5}}"#;
const SHIRLEY: &str = r#"{"model":"torrance-sparrow","fresnel":{"constant":[1,1,1]},"distribution":{"name":"ashikhmin-shirley","exponent":[5,50]}}"#;
const PLASTIC: &str = r#"{"pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0.5}}"#;

const WHITE_METAL: &str = r#"{"pbrMetallicRoughness":{"metallicFactor":1,"roughnessFactor":0.8}}"#;
const SHEEN: &str = r#"{"pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0.5},"extensions":{"KHR_materials_sheen":{"sheenColorFactor":[1,1,1],"sheenRoughnessFactor":0.5}}}"#;
const COATED: &str = r#"{"pbrMetallicRoughness":{"metallicFactor":1,"roughnessFactor":0.5},"extensions":{"KHR_materials_clearcoat":{"clearcoatFactor":1,"clearcoatRoughnessFactor":0.4}}}"#;
const ROUGH_GLASS: &str = r#"{"pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":1},"extensions":{"KHR_materials_transmission":{"transmissionFactor":1},"KHR_materials_volume":{"thicknessFactor":1}}}"#;
const FILM_ON_GREY: &str = r#"{"pbrMetallicRoughness":{"baseColorFactor":[0.4,0.4,0.4,1],"metallicFactor":1,"roughnessFactor":0.6},"extensions":{"KHR_materials_iridescence":{"iridescenceFactor":0.7,"iridescenceIor":1.6,"iridescenceThicknessMaximum":450}}}"#;
const TURNED: &str = r#"{"pbrMetallicRoughness":{"metallicFactor":1,"roughnessFactor":0.5},"extensions":{"KHR_materials_anisotropy":{"anisotropyStrength":0.8,"anisotropyRotation":0.6}}}"#;
const LEAF: &str = r#"{"pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0.5},"extensions":{"KHR_materials_diffuse_transmission":{"diffuseTransmissionFactor":0.3}}}"#;
const PANE: &str = r#"{"pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0.6},"extensions":{"KHR_materials_transmission":{"transmissionFactor":1}}}"#;

macro_rules! mutations {
    ($($name:ident: $from:literal => $to:literal, $check:expr, $material:expr;)*) => {
        $(
            #[test]
            fn $name() {
                assert_caught(&Mutation {
                    name: stringify!($name),
                    from: $from,
                    to: $to,
                    check: $check,
                    material: $material,
                });
            }
        )*
    };
}

mutations! {
    diffuse_pdf_without_its_cosine:
        "return max(cos_theta, 0.0) * INV_PI;" => "return INV_PI;", Statistics(30.0), GREY;
    lambert_without_pi:
        "return reflectance * INV_PI;" => "return reflectance;", Statistics(30.0), GREY;
    sigma_in_degrees:
        "let sigma2 = sqr(sigma);" => "let sigma2 = sqr(degrees(sigma));", Parity(Stage::Eval), ROUGH;
    oren_nayar_by_the_greater_angle:
        "projected / max(wo.z, wi.z)" => "projected / min(wo.z, wi.z)", Statistics(60.0), ROUGH;
    eon_without_multiple_scattering:
        "return single + tint * INV_PI * missing;" => "return single;", Parity(Stage::Eval), EON;
    eta_swapped_in_fresnel:
        "vec3(F_dielectric(cos_theta, bsdf.eta.x))" => "vec3(F_dielectric(cos_theta, 1.0 / bsdf.eta.x))",
        Parity(Stage::Fresnel), MIRROR;
    one_polarisation_only:
        "0.5 * (r_perp * r_perp + r_par * r_par)" => "r_perp * r_perp", Parity(Stage::Fresnel), MIRROR;
    conductor_terms_squared_again:
        "0.5 * (perp + par), 1.0" => "0.5 * (perp * perp + par * par), 1.0", Parity(Stage::Fresnel), TITANIUM;
    approximate_conductor_terms_squared_again:
        "0.5 * (par + perp);" => "0.5 * (par * par + perp * perp);", Parity(Stage::Fresnel), TITANIUM_APPROXIMATE;
    mirror_without_its_cosine:
        "bsdf.reflectance * fresnel_F(bsdf, wo.z) / wo.z," => "bsdf.reflectance * fresnel_F(bsdf, wo.z),",
        Parity(Stage::Sample), MIRROR;
    eta_swapped_in_snell:
        "(c + q) * n - wo) / eta;" => "(c + q) * n - wo) * eta;", Parity(Stage::Sample), REFRACTION;
    eta_squared_forgotten_in_transmission:
        "T_dielectric(wo.z, eta) / (sqr(eta) * -wi.z)" => "T_dielectric(wo.z, eta) / -wi.z",
        Parity(Stage::Sample), REFRACTION;
    eta_squared_forgotten_in_glass:
        "(T / (sqr(eta) * -wi.z))" => "(T / -wi.z)", Parity(Stage::Sample), GLASS;
    importance_for_radiance_in_frosted_glass:
        "(wo.z * -wi.z * sqr(norm));" => "(wo.z * -wi.z * sqr(norm)) * sqr(eta);", Statistics(30.0), FROSTED;
    eta_squared_forgotten_in_the_jacobian:
        "return sqr(eta) * abs(cos_i) / sqr(norm);" => "return abs(cos_i) / sqr(norm);", Statistics(30.0), FROSTED;
    quarter_forgotten_in_f:
        "G / (4.0 * wo.z * wi.z)" => "G / (wo.z * wi.z)", Statistics(0.0), GGX;
    quarter_forgotten_in_the_jacobian:
        "return 1.0 / (4.0 * cos_m);" => "return 1.0 / cos_m;", Statistics(0.0), BECKMANN;
    jacobian_forgotten_in_the_pdf:
        "cos_m) * half_vector_jacobian(cos_m);" => "cos_m);", Statistics(30.0), BECKMANN;
    a_cosine_for_the_other:
        "G / (4.0 * wo.z * wi.z)" => "G / (4.0 * wo.z * wo.z)", Statistics(85.0), GGX;
    smith_forgotten:
        "return 1.0 / (1.0 + Lambda_o + Lambda_i);" => "return 1.0;", Statistics(85.0), GGX;
    v_cavities_for_smith:
        "return G2_smith(bsdf, wo, wi);" => "return G2_v_cavity(wo, wi, wm, cos_o, cos_i);",
        Parity(Stage::Eval), GGX;
    beckmann_masked_twice_as_much:
        "return 0.5 * exp_accurate(-a * a)" => "return exp_accurate(-a * a)", Statistics(85.0), BECKMANN;
    beckmann_normalised_in_slopes:
        "alpha.x * alpha.y * cos2 * cos2)" => "alpha.x * alpha.y * cos2)", Statistics(30.0), BECKMANN;
    ggx_not_squared:
        "alpha.x * alpha.y * sqr(stretched))" => "alpha.x * alpha.y * stretched)", Statistics(30.0), GGX;
    visible_normals_without_their_cosine:
        "facet_D(bsdf, wm) * cos_o / wo.z" => "facet_D(bsdf, wm) / wo.z", Statistics(60.0), BECKMANN;
    normals_not_stretched_back:
        "vec3(alpha * sum.xy, sum.z)" => "vec3(sum.xy, sum.z)", Statistics(30.0), GGX;
    bound_forgotten_in_the_samples:
        "let above = rest * view.z;" => "let above = 0.0;", Statistics(30.0), GGX;
    bound_forgotten_in_the_pdf:
        "+ k * wo.z));" => "+ wo.z));", Statistics(30.0), GGX;
    bound_too_tight:
        "let a2 = sqr(min(min(alpha.x, alpha.y), 1.0));" => "let a2 = min(min(alpha.x, alpha.y), 1.0);",
        Statistics(60.0), GGX;
    bound_by_the_wider_axis:
        "min(min(alpha.x, alpha.y), 1.0)" => "min(max(alpha.x, alpha.y), 1.0)", Statistics(60.0), BRUSHED;
    blinn_normalised_for_radiance:
        "return (e + 2.0) * (0.5 * INV_PI)" => "return (e + 1.0) * (0.5 * INV_PI)", Statistics(30.0), BLINN;
    blinn_sampled_without_its_cosine:
        "/ (exponent + 2.0)" => "/ (exponent + 1.0)", Statistics(30.0), BLINN;
    exponents_crossed:
        "(e.x * wm.x * wm.x + e.y * wm.y * wm.y)" => "(e.y * wm.x * wm.x + e.x * wm.y * wm.y)",
        Statistics(30.0), SHIRLEY;
    schlick_to_the_fourth:
        "return sqr(sqr(x)) * x;" => "return sqr(sqr(x));", Parity(Stage::Fresnel), PLASTIC;
    lobe_choice_forgotten_in_the_pdf:
        "pdf += view.p_reflection * shape.y;" => "pdf += shape.y;", Statistics(30.0), PLASTIC;
    diffuse_share_one_way_only:
        "INV_PI * (view.passed * passed / max(view.near.passed" => "INV_PI * (view.passed / max(view.near.passed",
        Parity(Stage::Eval), PLASTIC;
    multiple_scattering_dropped:
        "return missing_o * missing_i * INV_PI" => "return 0.0 * missing_o * missing_i * INV_PI", Parity(Stage::Eval), WHITE_METAL;
    sheen_over_an_undimmed_base:
        "view.below_sheen = max(1.0 - strongest, 0.0);" => "view.below_sheen = 1.0;", Statistics(30.0), SHEEN;
    coat_over_an_undimmed_base:
        "view.below_coat = 1.0 - view.coat;" => "view.below_coat = 1.0;", Statistics(60.0), COATED;
    eta_squared_forgotten_in_rescattered_light:
        "transmission_share(bsdf) * radiance) * (1.0 - view.near.returned)" => "transmission_share(bsdf)) * (1.0 - view.near.returned)",
        Parity(Stage::Eval), ROUGH_GLASS;
    sides_of_rescattered_light_swapped:
        "energy.missing, view.far.average.missing);" => "energy.missing, view.near.average.missing);",
        Parity(Stage::Eval), ROUGH_GLASS;
    sheen_fibres_too_upright:
        "exp_accurate(0.5 * e * ln_sin2)" => "exp_accurate(e * ln_sin2)", Parity(Stage::Eval), SHEEN;
    sheen_without_shadows:
        "(1.0 + (Lambda_o + Lambda_i))" => "1.0", Parity(Stage::Eval), SHEEN;
    coat_not_in_the_pdf:
        "pdf += view.p_coat * coat.pdf;" => "pdf += coat.pdf;", Statistics(30.0), COATED;
    film_interferes_half:
        "sum += 2.0 * power * interference" => "sum += power * interference", Parity(Stage::Eval), FILM_ON_GREY;
    film_not_mixed:
        "film_thickness, F_base), bsdf.gltf.iridescence);\n}\n\n// What a facet transmits" => "film_thickness, F_base), 1.0);\n}\n\n// What a facet transmits",
        Parity(Stage::Eval), FILM_ON_GREY;
    anisotropy_turned_the_other_way:
        "return vec3(r.x * w.x + r.y * w.y, r.x * w.y - r.y * w.x, w.z);" => "return vec3(r.x * w.x - r.y * w.y, r.x * w.y + r.y * w.x, w.z);",
        Parity(Stage::Eval), TURNED;
    turned_samples_not_turned_back:
        "drawn = BsdfSample(local_from_anisotropy(bsdf, wi), vec3(0.0)" => "drawn = BsdfSample(wi, vec3(0.0)", Statistics(30.0), TURNED;
    all_of_the_diffuse_light_transmitted:
        "* (1.0 - transmission_share(bsdf)) * diffuse_transmission_share(bsdf));" => "* (1.0 - transmission_share(bsdf)));",
        Parity(Stage::Eval), LEAF;
    thin_walls_reflect_through_themselves:
        "return BsdfSample(mirrored(above), vec3(0.0), 1.0, 0u);" => "return BsdfSample(above, vec3(0.0), 1.0, 0u);",
        Statistics(30.0), PANE;
    light_not_mirrored_with_the_viewer:
        "select(wi, mirrored(wi), below));" => "wi);", Parity(Stage::Eval), GREY;
}

/// Random directions on both sides; viewers on both sides too, so that mirroring is seen.
fn queries(lobe: &Lobe, count: usize) -> Vec<Input> {
    let around = |u: DVec3| (2.0 * u - 1.0).normalize();
    uniforms(1, count)
        .into_iter()
        .zip(uniforms(2, count))
        .zip(uniforms(3, count))
        .map(|((a, b), u)| Input {
            bsdf: lobe.bsdf,
            wo: around(a),
            wi: around(b),
            u,
            cos_theta: a.z,
        })
        .collect()
}

/// Share of answers that differ from the twin's, among those where either is not 0.
fn different(lab: &Lab, stage: Stage, lobe: &Lobe) -> f64 {
    let inputs = queries(lobe, 4096);
    let (ours, twins) = (
        lab.run(stage, &inputs).unwrap(),
        Lab::cpu().run(stage, &inputs).unwrap(),
    );
    let apart = |a: f64, b: f64| (a - b).abs() > DIFFERENT * a.abs().max(b.abs());
    let (mut answered, mut differing) = (0, 0);
    for (a, b) in ours.iter().zip(&twins) {
        answered += usize::from(a.f.x != 0.0 || b.f.x != 0.0);
        let directions = stage == Stage::Sample && a.wi.distance(b.wi) > DIFFERENT;
        differing += usize::from(apart(a.f.x, b.f.x) || apart(a.pdf, b.pdf) || directions);
    }
    assert!(answered > 500, "{}: only {answered} answers", lobe.name);
    differing as f64 / answered as f64
}

/// Whether the check sees something wrong, and what.
fn caught(lab: &Lab, check: &Check, lobe: &Lobe) -> Option<String> {
    match check {
        Parity(stage) => {
            let share = different(lab, *stage, lobe);
            (share > CAUGHT).then(|| format!("{share:.2} of the answers differ"))
        }
        Statistics(degrees) => {
            let (p, faults) = examine::examine(lab, lobe, *degrees, 77);
            (p < ODD || !faults.is_empty()).then(|| format!("p = {p:.0e} {faults}"))
        }
    }
}

fn assert_caught(mutation: &Mutation) {
    let mut linked = link("kernels/bsdf_lab").unwrap();
    let count = linked.text.matches(mutation.from).count();
    assert_eq!(
        count, 1,
        "`{}` stands {count} times in the shaders",
        mutation.from
    );
    linked.text = linked.text.replace(mutation.from, mutation.to);
    let lobe = Lobe {
        name: mutation.name.to_owned(),
        bsdf: bsdf(mutation.material),
        weight_max: 13.0,
        albedo_max: 1.005,
    };
    // The check is quiet where nothing is broken: the twin stands for that.
    assert_eq!(
        caught(&Lab::cpu(), &mutation.check, &lobe),
        None,
        "a sound lobe is accused"
    );
    let broken = Lab::gpu_linked(common::gpu(), linked);
    let finding = caught(&broken, &mutation.check, &lobe);
    println!(
        "{}: {}",
        mutation.name,
        finding.as_deref().unwrap_or("not seen")
    );
    assert!(finding.is_some(), "{} goes unseen", mutation.name);
}

/// A query's coat has no normal of its own (that is a texture's), so this one is bent by hand.
#[test]
fn coat_lit_by_the_surfaces_cosine() {
    let mut linked = link("kernels/bsdf_lab").unwrap();
    let (from, to) = ("shape.x * (coat_wi.z / wi.z);", "shape.x;");
    assert_eq!(linked.text.matches(from).count(), 1);
    let mut bent = bsdf(COATED);
    bent.gltf.coat_normal = lobes::bent();
    let lobe = Lobe {
        name: "bent coat".to_owned(),
        bsdf: bent,
        weight_max: 25.0,
        albedo_max: 1.005,
    };
    let sound = Lab::gpu_linked(common::gpu(), link("kernels/bsdf_lab").unwrap());
    assert!(different(&sound, Stage::Eval, &lobe) < CAUGHT);
    linked.text = linked.text.replace(from, to);
    let broken = Lab::gpu_linked(common::gpu(), linked);
    assert!(different(&broken, Stage::Eval, &lobe) > CAUGHT);
}
