//! Materials, textures and images.

use crate::asset::{Asset, pixel_png, png};
use crate::{noted, only};
use glam::{Vec2, Vec3, Vec4};
use serde_json::{Value, json};
use snell::gltf::Treatment;
use snell::scene::{AlphaMode, Filter, Material, Model, Pixels, Scene, Texture, Wrap};

fn material(json: Value) -> Material {
    Asset::triangle().with_material(json).load().scene.materials[0].clone()
}

#[test]
fn materials() {
    let plain = material(json!({}));
    let Model::MetallicRoughness(model) = &plain.model else {
        panic!("{plain:?}");
    };
    assert_eq!(
        (model.base_color, model.metallic, model.roughness),
        (Vec4::ONE, 1.0, 1.0)
    );
    assert_eq!(model.ior, 1.5);
    assert_eq!(
        (plain.alpha_mode, plain.double_sided),
        (AlphaMode::Opaque, false)
    );

    let full = material(json!({
        "name": "full", "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.25,
        "emissiveFactor": [1, 0.5, 0],
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.6},
        "extensions": {
            "KHR_materials_ior": {"ior": 1.3},
            "KHR_materials_emissive_strength": {"emissiveStrength": 8}},
    }));
    let Model::MetallicRoughness(model) = &full.model else {
        panic!("{full:?}");
    };
    assert_eq!(model.base_color, Vec4::new(0.1, 0.2, 0.3, 0.4));
    assert_eq!(
        (model.metallic, model.roughness, model.ior),
        (0.5, 0.6, 1.3)
    );
    assert_eq!(full.alpha_mode, AlphaMode::Mask { cutoff: 0.25 });
    assert_eq!(full.emissive, Vec3::new(8.0, 4.0, 0.0));
    assert!(full.double_sided && full.name == "full");

    let blend = material(json!({"alphaMode": "BLEND", "extensions": {"KHR_materials_unlit": {}}}));
    assert_eq!(blend.alpha_mode, AlphaMode::Blend);
    assert!(matches!(blend.model, Model::Unlit { .. }));

    let lecture = json!({"model": "oren-nayar", "reflectance": [0.5, 0.5, 0.5],
                         "form": "qualitative", "sigma": 0.3});
    let bsdf = material(json!({"extensions": {"SNELL_materials_bsdf": lecture}}));
    let Model::Bsdf { bsdf, .. } = &bsdf.model else {
        panic!("{bsdf:?}");
    };
    assert_eq!(
        serde_json::to_value(bsdf).unwrap()["sigma"]
            .as_f64()
            .unwrap() as f32,
        0.3
    );
}

#[test]
fn a_primitive_without_material_gets_the_default_one_behind_the_others() {
    let mut asset = Asset::triangle();
    asset.push("materials", json!({"name": "unused"}));
    let loaded = asset.load();
    assert_eq!(only(&loaded).material, 1);
    assert_eq!(loaded.scene.materials.len(), 2);
}

fn base_texture(scene: &Scene) -> &Texture {
    match &scene.materials[0].model {
        Model::MetallicRoughness(model) => model.base_color_texture.as_ref().unwrap(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn textures_samplers_and_transforms() {
    let mut asset = Asset::triangle();
    let texture = asset.texture(&pixel_png([255, 0, 0, 255]));
    asset.push(
        "samplers",
        json!({"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}),
    );
    asset.json["textures"][texture]["sampler"] = json!(0);
    let plain = asset.texture(&pixel_png([0, 255, 0, 255]));
    let transform = json!({"offset": [0.5, 0.25], "rotation": 0.5 * std::f32::consts::PI,
                           "scale": [2, 3], "texCoord": 1});
    let asset = asset.with_material(json!({
        "pbrMetallicRoughness": {
            "baseColorTexture": {"index": texture, "texCoord": 0,
                "extensions": {"KHR_texture_transform": transform}},
            "metallicRoughnessTexture": {"index": plain}},
        "normalTexture": {"index": plain, "scale": 0.5},
        "emissiveTexture": {"index": plain},
        "occlusionTexture": {"index": plain},
    }));
    let loaded = asset.load();
    let scene = &loaded.scene;
    assert_eq!(scene.images.len(), 2);
    let texture = base_texture(scene);
    assert!(texture.srgb);
    assert_eq!(
        (texture.wrap_s, texture.wrap_t),
        (Wrap::Clamp, Wrap::Mirror)
    );
    assert_eq!((texture.filter, texture.texcoord), (Filter::Nearest, 1));
    // Scaled by (2, 3), turned counter-clockwise with v pointing down, moved: (1, 0) goes to
    // (2, 0), then (0, -2); (0, 1) to (0, 3), then (3, 0).
    let apply = |uv: Vec2| {
        let uv = uv.extend(1.0);
        Vec2::new(texture.rows[0].dot(uv), texture.rows[1].dot(uv))
    };
    for (from, to) in [
        (Vec2::ZERO, Vec2::new(0.5, 0.25)),
        (Vec2::X, Vec2::new(0.5, -1.75)),
        (Vec2::Y, Vec2::new(3.5, 0.25)),
    ] {
        assert!((apply(from) - to).length() < 1e-6, "{from} {}", apply(from));
    }
    let material = &scene.materials[0];
    let normal = material.normal_texture.as_ref().unwrap();
    assert_eq!(
        (normal.srgb, normal.filter, normal.wrap_s),
        (false, Filter::Linear, Wrap::Repeat)
    );
    assert_eq!(normal.rows, [Vec3::X, Vec3::Y]);
    assert_eq!(material.normal_scale, 0.5);
    assert!(material.emissive_texture.as_ref().unwrap().srgb);
    assert!(noted(&loaded, "occlusionTexture is ignored"));
    // Set 1 is read and not there.
    assert_eq!(only(&loaded).texcoords[1], [Vec2::ZERO; 3]);
    assert!(noted(&loaded, "texture coordinates"));
}

#[test]
fn images_of_all_kinds() {
    let mut jpeg = Vec::new();
    let gray = image::RgbImage::from_pixel(8, 8, image::Rgb([128, 128, 128]));
    gray.write_to(
        &mut std::io::Cursor::new(&mut jpeg),
        image::ImageFormat::Jpeg,
    )
    .unwrap();
    let mut webp = Vec::new();
    let red = image::RgbaImage::from_pixel(1, 1, image::Rgba([255, 0, 0, 255]));
    red.write_to(
        &mut std::io::Cursor::new(&mut webp),
        image::ImageFormat::WebP,
    )
    .unwrap();
    let cases = [
        (
            "RGBA",
            pixel_png([1, 2, 3, 4]),
            Pixels::Rgba8(vec![1, 2, 3, 4]),
        ),
        (
            "RGB",
            png(1, 1, 8, 2, &[], &[0, 7, 8, 9]),
            Pixels::Rgba8(vec![7, 8, 9, 255]),
        ),
        (
            "gray",
            png(1, 1, 8, 0, &[], &[0, 77]),
            Pixels::Rgba8(vec![77, 77, 77, 255]),
        ),
        ("one bit", png(2, 1, 1, 0, &[], &[0, 0x40]), {
            Pixels::Rgba8(vec![0, 0, 0, 255, 255, 255, 255, 255])
        }),
        ("palette", png(1, 1, 8, 3, &[9, 8, 7, 6, 5, 4], &[0, 1]), {
            Pixels::Rgba8(vec![6, 5, 4, 255])
        }),
        ("16 bits", png(1, 1, 16, 2, &[], &[0, 1, 2, 3, 4, 5, 6]), {
            Pixels::Rgba16(vec![0x0102, 0x0304, 0x0506, 0xffff])
        }),
        // All of them are called image/png; only the bytes count.
        ("JPEG", jpeg, Pixels::Rgba8([128, 128, 128, 255].repeat(64))),
        ("WebP", webp, Pixels::Rgba8(vec![255, 0, 0, 255])),
    ];
    for (name, bytes, expected) in cases {
        let mut asset = Asset::triangle();
        let texture = asset.texture(&bytes);
        let texture = json!({"baseColorTexture": {"index": texture}});
        let asset = asset.with_material(json!({"pbrMetallicRoughness": texture}));
        let scene = asset.load().scene;
        match (&scene.images[0].pixels, &expected) {
            (Pixels::Rgba8(a), Pixels::Rgba8(b)) => assert_eq!(a, b, "{name}"),
            (Pixels::Rgba16(a), Pixels::Rgba16(b)) => assert_eq!(a, b, "{name}"),
            (found, _) => panic!("{name}: {found:?}"),
        }
    }
}

#[test]
fn only_images_in_use_are_read() {
    let mut asset = Asset::triangle();
    asset.push("images", json!({"uri": "not-there.png"}));
    asset.push("textures", json!({"source": 0}));
    asset.push("materials", json!({"emissiveTexture": {"index": 0}}));
    assert!(asset.load().scene.images.is_empty());
}

#[test]
fn webp_and_formats_that_are_not_read() {
    let mut asset = Asset::triangle();
    let png = asset.texture(&pixel_png([1, 2, 3, 255]));
    let dds = asset.texture(b"DDS and so on");
    asset.json["textures"][png] = json!({"extensions": {"EXT_texture_webp": {"source": 0}}});
    let asset = asset.with_material(json!({
        "pbrMetallicRoughness": {"baseColorTexture": {"index": png}},
        "emissiveTexture": {"index": dds},
    }));
    let loaded = asset.load();
    assert_eq!(base_texture(&loaded.scene).image, 0);
    assert!(loaded.scene.materials[0].emissive_texture.is_none());
    let dds = loaded
        .extensions
        .iter()
        .find(|e| e.name == "MSFT_texture_dds")
        .unwrap();
    assert_eq!(dds.treatment, Treatment::Ignored);
    assert!(noted(&loaded, "DDS"));
}
