//! KHR_materials_*: every property, its default, its texture, its range.

use crate::asset::{Asset, corpus, models, pixel_png};
use crate::{noted, only};
use glam::{Vec3, Vec4};
use serde_json::{Value, json};
use snell::gltf::{LoadOptions, Treatment, load};
use snell::scene::{Extensions, Material, Model, Texture};

fn loaded(extensions: Value) -> snell::gltf::Loaded {
    Asset::triangle()
        .with_material(json!({"extensions": extensions}))
        .load()
}

fn of(material: &Material) -> &Extensions {
    material.extensions().unwrap()
}

/// Each extension, textured: texture i of the asset is the property's, with a set and an offset of its
/// own.
fn textured() -> (Material, usize) {
    let mut asset = Asset::triangle();
    let mut next = 0;
    let mut texture = || {
        let index = asset.texture(&pixel_png([next as u8, 0, 0, 255]));
        next += 1;
        json!({"index": index, "texCoord": 9, "extensions": {"KHR_texture_transform": {
            "offset": [index, 0], "texCoord": index % 3}}})
    };
    let mut coat_normal = texture();
    coat_normal["scale"] = json!(0.4);
    let extensions = json!({
        "KHR_materials_clearcoat": {
            "clearcoatFactor": 0.1, "clearcoatRoughnessFactor": 0.2,
            "clearcoatTexture": texture(), "clearcoatRoughnessTexture": texture(),
            "clearcoatNormalTexture": coat_normal},
        "KHR_materials_transmission": {
            "transmissionFactor": 0.3, "transmissionTexture": texture()},
        "KHR_materials_diffuse_transmission": {
            "diffuseTransmissionFactor": 0.4, "diffuseTransmissionTexture": texture(),
            "diffuseTransmissionColorFactor": [0.5, 0.6, 0.7],
            "diffuseTransmissionColorTexture": texture()},
        "KHR_materials_volume": {
            "thicknessFactor": 2, "attenuationDistance": 3, "attenuationColor": [0.8, 0.9, 1]},
        "KHR_materials_dispersion": {"dispersion": 0.35},
        "KHR_materials_specular": {
            "specularFactor": 0.45, "specularTexture": texture(),
            "specularColorFactor": [1.1, 0.2, 0.3], "specularColorTexture": texture()},
        "KHR_materials_sheen": {
            "sheenColorFactor": [0.15, 0.25, 0.35], "sheenColorTexture": texture(),
            "sheenRoughnessFactor": 0.55, "sheenRoughnessTexture": texture()},
        "KHR_materials_anisotropy": {
            "anisotropyStrength": 0.65, "anisotropyRotation": -7, "anisotropyTexture": texture()},
        "KHR_materials_iridescence": {
            "iridescenceFactor": 0.75, "iridescenceTexture": texture(), "iridescenceIor": 1.7,
            "iridescenceThicknessMinimum": 20, "iridescenceThicknessMaximum": 30,
            "iridescenceThicknessTexture": texture()},
    });
    let loaded = asset
        .with_material(json!({"extensions": extensions}))
        .load();
    assert_eq!(loaded.notes.len(), 1, "{:?}", loaded.notes);
    assert!(noted(&loaded, "missing texture coordinates"));
    (loaded.scene.materials[0].clone(), next)
}

#[test]
fn every_property_is_read() {
    let (material, _) = textured();
    let all = of(&material);
    assert_eq!(all.transmission.factor, 0.3);
    assert_eq!(all.diffuse_transmission.share.factor, 0.4);
    let color = all.diffuse_transmission.color.factor;
    assert_eq!(color, Vec3::new(0.5, 0.6, 0.7));
    let volume = all.volume.as_ref().unwrap();
    assert_eq!(volume.attenuation_distance, Some(3.0));
    assert_eq!(volume.attenuation_color, Vec3::new(0.8, 0.9, 1.0));
    assert_eq!(all.dispersion, 0.35);
    assert_eq!(all.specular.strength.factor, 0.45);
    assert_eq!(all.specular.color.factor, Vec3::new(1.1, 0.2, 0.3));
    assert_eq!(all.clearcoat.coat.factor, 0.1);
    assert_eq!(all.clearcoat.roughness.factor, 0.2);
    assert_eq!(all.clearcoat.normal_scale, 0.4);
    assert_eq!(all.sheen.color.factor, Vec3::new(0.15, 0.25, 0.35));
    assert_eq!(all.sheen.roughness.factor, 0.55);
    assert_eq!(all.anisotropy.strength.factor, 0.65);
    assert_eq!(all.anisotropy.rotation, -7.0);
    assert_eq!(all.iridescence.strength.factor, 0.75);
    assert_eq!(all.iridescence.film_ior, 1.7);
    assert_eq!(all.iridescence.thickness.factor, [20.0, 30.0]);
}

#[test]
fn every_texture_keeps_its_image_its_transform_and_its_coordinates() {
    let (material, count) = textured();
    let all = of(&material);
    let colors = [
        &all.diffuse_transmission.color.texture,
        &all.specular.color.texture,
        &all.sheen.color.texture,
    ];
    let mut seen = Vec::new();
    for texture in all.textures() {
        let texture = texture.as_ref().unwrap();
        // Images are numbered as they are read, transforms and sets as the file has them.
        let index = texture.rows[0].z as usize;
        assert_eq!(texture.texcoord, index % 3);
        let is_color = colors
            .iter()
            .any(|color| color.as_ref().unwrap().rows == texture.rows);
        assert_eq!(texture.srgb, is_color, "texture {index}");
        seen.push(index);
    }
    seen.sort_unstable();
    assert_eq!(seen, (0..count).collect::<Vec<_>>());
    assert_eq!((count, material.textures().count()), (13, 13));
    assert_eq!(material.texcoord_count(), 3);
    // The coat's normals come before the anisotropy when tangents are made.
    let normal = all.clearcoat.normal_texture.as_ref().unwrap();
    let source = Some((normal.texcoord, normal.rows));
    assert_eq!(material.tangent_source(), source);
}

#[test]
fn what_is_left_out_is_neutral() {
    let plain = Asset::triangle().with_material(json!({})).load();
    let empty = loaded(json!({
        "KHR_materials_transmission": {}, "KHR_materials_diffuse_transmission": {},
        "KHR_materials_volume": {}, "KHR_materials_dispersion": {}, "KHR_materials_specular": {},
        "KHR_materials_clearcoat": {}, "KHR_materials_sheen": {}, "KHR_materials_anisotropy": {},
        "KHR_materials_iridescence": {}, "KHR_materials_ior": {},
    }));
    let [plain, empty] = [&plain, &empty].map(|loaded| {
        assert!(loaded.notes.is_empty(), "{:?}", loaded.notes);
        &loaded.scene.materials[0]
    });
    assert_eq!(format!("{plain:?}"), format!("{empty:?}"));
    let all = of(plain);
    assert_eq!(all.specular.strength.factor, 1.0);
    assert_eq!(all.specular.color.factor, Vec3::ONE);
    assert_eq!(all.diffuse_transmission.color.factor, Vec3::ONE);
    assert_eq!(all.iridescence.film_ior, 1.3);
    assert_eq!(all.iridescence.thickness.factor, [100.0, 400.0]);
    assert_eq!(all.clearcoat.normal_scale, 1.0);
    let zeros = [
        all.transmission.factor,
        all.diffuse_transmission.share.factor,
        all.dispersion,
        all.clearcoat.coat.factor,
        all.clearcoat.roughness.factor,
        all.sheen.color.factor.max_element(),
        all.sheen.roughness.factor,
        all.anisotropy.strength.factor,
        all.anisotropy.rotation,
        all.iridescence.strength.factor,
    ];
    assert_eq!(zeros, [0.0; 10]);
    assert!(all.volume.is_none() && plain.tangent_source().is_none());
}

#[test]
fn numbers_out_of_range_are_refused_where_they_stand() {
    for (name, property, value) in [
        ("ior", "", json!({"ior": 0.99})),
        ("ior", "", json!({"ior": -1})),
        ("volume", ".thicknessFactor", json!({"thicknessFactor": -1})),
        (
            "volume",
            ".attenuationDistance",
            json!({"attenuationDistance": 0}),
        ),
        (
            "volume",
            ".attenuationDistance",
            json!({"attenuationDistance": 1e60}),
        ),
        ("dispersion", ".dispersion", json!({"dispersion": -0.1})),
        (
            "specular",
            ".specularColorFactor",
            json!({"specularColorFactor": [1, -1, 1]}),
        ),
        (
            "iridescence",
            ".iridescenceIor",
            json!({"iridescenceIor": 0.5}),
        ),
        (
            "iridescence",
            ".iridescenceThicknessMinimum",
            json!({"iridescenceThicknessMinimum": -1}),
        ),
        (
            "anisotropy",
            ".anisotropyRotation",
            json!({"anisotropyRotation": 1e300}),
        ),
        (
            "sheen",
            ".sheenColorFactor",
            json!({"sheenColorFactor": [1, 1]}),
        ),
        (
            "clearcoat",
            ".clearcoatFactor",
            json!({"clearcoatFactor": "1"}),
        ),
        (
            "transmission",
            ".transmissionTexture.index",
            json!({"transmissionTexture": {"index": 5}}),
        ),
        (
            "pbrSpecularGlossiness",
            ".diffuseFactor",
            json!({"diffuseFactor": [1, 1, 1]}),
        ),
    ] {
        let name = format!("KHR_materials_{name}");
        let asset = Asset::triangle().with_material(json!({"extensions": {&name: value}}));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("scene.glb");
        asset.save_glb(&path);
        let error = load(&path, &LoadOptions::default()).unwrap_err();
        let place = format!("materials[0].extensions.{name}{property}");
        assert_eq!((error.at(), error.exit_status()), (&*place, 3), "{error}");
    }
}

#[test]
fn what_is_moved_into_its_range_or_left_out_is_noted() {
    let clamped = loaded(json!({
        "KHR_materials_clearcoat": {"clearcoatFactor": 2},
        "KHR_materials_sheen": {"sheenColorFactor": [0.5, -1, 3]},
        "KHR_materials_ior": {"ior": 1e9},
        "KHR_materials_iridescence": {"iridescenceThicknessMaximum": 1e38},
    }));
    assert!(noted(&clamped, "a film of more than a millimetre"));
    assert!(noted(&clamped, "a factor outside of 0 to 1 is clamped"));
    assert!(noted(&clamped, "more than a million is clamped"));
    let material = &clamped.scene.materials[0];
    assert_eq!(of(material).clearcoat.coat.factor, 1.0);
    let thickness = of(material).iridescence.thickness.factor;
    assert_eq!(thickness, [100.0, 1e6]);
    assert_eq!(of(material).sheen.color.factor, Vec3::new(0.5, 0.0, 1.0));

    let unknown = loaded(json!({"KHR_materials_iridescence": {"iridescenceIOR": 1.5}}));
    assert!(noted(&unknown, "`iridescenceIOR` is ignored"));

    let transmission = json!({"transmissionFactor": 1});
    let mirror = loaded(json!({
        "KHR_materials_ior": {"ior": 0}, "KHR_materials_transmission": transmission}));
    assert!(noted(&mirror, "it reflects everything"));
    assert!(!of(&mirror.scene.materials[0]).is_transmissive());

    let mut asset = Asset::triangle();
    let texture = asset.texture(&pixel_png([0, 9, 0, 255]));
    let volume = |thickness: f32| {
        let extensions = json!({
            "KHR_materials_transmission": {"transmissionFactor": 1},
            "KHR_materials_volume": {
                "thicknessFactor": thickness, "thicknessTexture": {"index": texture}}});
        let asset = asset.clone();
        asset
            .with_material(json!({"extensions": extensions}))
            .load()
    };
    let thick = volume(0.1);
    assert!(noted(&thick, "thicknessTexture is ignored"));
    assert!(of(&thick.scene.materials[0]).volume.is_some());
    assert!(thick.scene.images.is_empty());
    let thin = volume(0.0);
    assert!(thin.notes.is_empty() && of(&thin.scene.materials[0]).volume.is_none());
}

#[test]
fn specular_glossiness_stands_for_metallic_roughness() {
    let mut asset = Asset::triangle();
    let diffuse = asset.texture(&pixel_png([1, 0, 0, 255]));
    let specular = asset.texture(&pixel_png([2, 0, 0, 255]));
    let loaded = asset
        .with_material(json!({
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 77}},
            "extensions": {
                "KHR_materials_pbrSpecularGlossiness": {
                    "diffuseFactor": [0.1, 0.2, 0.3, 0.4], "diffuseTexture": {"index": diffuse},
                    "specularFactor": [0.5, 0.6, 0.7], "glossinessFactor": 0.8,
                    "specularGlossinessTexture": {"index": specular}},
                "KHR_materials_sheen": {"sheenColorFactor": [1, 1, 1]}}}))
        .load();
    assert!(noted(&loaded, "KHR_materials_sheen beside"));
    let Model::SpecularGlossiness(model) = &loaded.scene.materials[0].model else {
        panic!("{:?}", loaded.scene.materials[0]);
    };
    assert_eq!(model.diffuse.factor, Vec4::new(0.1, 0.2, 0.3, 0.4));
    assert_eq!(model.specular.factor, Vec3::new(0.5, 0.6, 0.7));
    assert_eq!(model.glossiness, 0.8);
    let srgb = |texture: &Option<Texture>| texture.as_ref().unwrap().srgb;
    assert!(srgb(&model.diffuse.texture) && srgb(&model.specular.texture));
}

#[test]
fn tangents_are_made_for_coats_and_anisotropy() {
    let strength = json!({"anisotropyStrength": 0.5});
    let brushed = loaded(json!({"KHR_materials_anisotropy": strength}));
    let tangents = only(&brushed).tangents.as_ref().unwrap();
    // u grows along +x, v against +y: the bitangent is +y.
    assert!((tangents[0] - Vec4::new(1.0, 0.0, 0.0, 1.0)).length() < 1e-6);
    let round = loaded(json!({"KHR_materials_anisotropy": {"anisotropyRotation": 1}}));
    assert!(only(&round).tangents.is_none());
    let mut asset = Asset::triangle();
    let map = asset.texture(&pixel_png([128, 128, 255, 255]));
    let coat = json!({"clearcoatFactor": 1, "clearcoatNormalTexture": {"index": map}});
    let coated = asset
        .with_material(json!({"extensions": {"KHR_materials_clearcoat": coat}}))
        .load();
    assert!(only(&coated).tangents.is_some());
}

#[test]
fn nothing_of_the_corpus_materials_is_ignored() {
    let Some(corpus) = corpus() else {
        println!("NOT RUN: there is no corpus of models beside this checkout");
        return;
    };
    let mut count = 0;
    for path in models(&corpus.join("materials")) {
        let Ok(loaded) = load(&path, &LoadOptions::default()) else {
            continue;
        };
        for extension in &loaded.extensions {
            let ours = extension.name.starts_with("KHR_materials_");
            let ignored = extension.treatment == Treatment::Ignored;
            assert!(!(ours && ignored), "{}: {extension:?}", path.display());
            count += usize::from(ours);
        }
    }
    assert!(count > 15, "{count} uses");
}

#[test]
fn emission_under_a_coat_is_remarked_on() {
    let with = |coat: f32, emission: f32| {
        Asset::triangle()
            .with_material(json!({
                "emissiveFactor": [emission, 0, 0],
                "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": coat}}}))
            .load()
    };
    let remark = "does not dim what the surface under it emits";
    assert!(noted(&with(1.0, 0.5), remark));
    assert!(with(0.0, 0.5).notes.is_empty());
    assert!(with(1.0, 0.0).notes.is_empty());
}
