//! What the packed numbers are.

use crate::common::shapes::{self, Random};
use crate::extended;
use glam::{DVec3, Vec3, Vec4};
use snell::cpu::material::{bsdf_of, white_texels};
use snell::pack::material::pack_material;
use snell::pack::texture::Textures;
use snell::scene::extensions::Volume;
use snell::scene::{Material, Model, SpecularGlossiness};
use snell::shared::{self, *};

fn packed_material(material: &Material) -> shared::Material {
    pack_material(material, &Textures::default()).unwrap()
}

fn glass(thickness: Option<Volume>) -> Material {
    extended(|all| {
        all.transmission.factor = 1.0;
        all.volume.clone_from(&thickness);
        all.dispersion = 0.4;
    })
}

#[test]
fn a_thickness_makes_a_medium_and_none_a_thin_wall() {
    let volume = Volume {
        attenuation_color: Vec3::new(0.5, 1.0, 0.0),
        attenuation_distance: Some(2.0),
    };
    let thick = packed_material(&glass(Some(volume.clone())));
    assert_eq!(thick.flags & !MATERIAL_DOUBLE_SIDED, MATERIAL_TRANSMISSIVE);
    assert_eq!(thick.dispersion, 0.4);
    assert!((thick.absorption[0] - 0.5 * 2.0_f32.ln()).abs() < 1e-7);
    assert_eq!(thick.absorption[1], 0.0);
    // Nothing is left of a colour of 0 after a tenth of the distance, and the number is finite.
    assert!((-0.2 * thick.absorption[2]).exp() < 2e-4 && thick.absorption[2].is_finite());
    let thin = packed_material(&glass(None));
    assert_eq!(thin.flags & !MATERIAL_DOUBLE_SIDED, MATERIAL_THIN_WALLED);
    assert_eq!((thin.dispersion, thin.absorption), (0.0, [0.0; 3]));
    let leaf = packed_material(&extended(|all| {
        all.diffuse_transmission.share.factor = 0.5;
    }));
    assert_ne!(leaf.flags & MATERIAL_THIN_WALLED, 0);
    let opaque = packed_material(&extended(|all| all.volume = Some(volume.clone())));
    assert_eq!(opaque.flags & !MATERIAL_DOUBLE_SIDED, 0);
    let hostile = Volume {
        attenuation_color: Vec3::ZERO,
        attenuation_distance: Some(f32::from_bits(1)),
    };
    assert!(hostile.absorption().is_finite());
    let clear = Volume {
        attenuation_color: Vec3::splat(0.1),
        attenuation_distance: None,
    };
    assert_eq!(clear.absorption(), Vec3::ZERO);
}

#[test]
fn factors_become_what_the_extensions_say() {
    let outside = |material: &Material| {
        let packed = packed_material(material);
        bsdf_of(&packed, &white_texels(), f64::from(packed.ior))
    };
    let close = |a: DVec3, b: [f64; 3]| assert!((a - DVec3::from_array(b)).length() < 1e-6, "{a}");

    let plain = outside(&shapes::material());
    close(plain.gltf.F0, [0.04; 3]);
    assert_eq!((plain.gltf.F90, plain.gltf.flags), (1.0, 0));
    assert_eq!(plain.alpha.x, plain.alpha.y);

    let tinted = outside(&extended(|all| {
        all.specular.strength.factor = 0.5;
        all.specular.color.factor = Vec3::new(1.0, 0.5, 100.0);
    }));
    close(tinted.gltf.F0, [0.02, 0.01, 0.5]);
    assert_eq!(tinted.gltf.F90, 0.5);

    let brushed = outside(&extended(|all| {
        all.anisotropy.strength.factor = 0.5;
        all.anisotropy.rotation = std::f32::consts::FRAC_PI_2;
    }));
    // Roughness 0.5: alpha is 0.25, and a quarter of the way to 1 along the direction.
    assert!((brushed.alpha.x - 0.4375).abs() < 1e-7 && (brushed.alpha.y - 0.25).abs() < 1e-7);
    assert!((brushed.gltf.rotation - glam::DVec2::Y).length() < 1e-7);

    let film = outside(&extended(|all| all.iridescence.strength.factor = 0.5));
    assert_eq!(film.gltf.film_thickness, 400.0);
    let packed = packed_material(&extended(|_| {}));
    let mut texels = white_texels();
    texels.film_thickness = 0.25;
    assert_eq!(bsdf_of(&packed, &texels, 1.5).gltf.film_thickness, 175.0);

    for (material, flags) in [
        (glass(None), GLTF_TRANSMISSIVE | GLTF_THIN_WALLED),
        (
            glass(Some(Volume {
                attenuation_color: Vec3::ONE,
                attenuation_distance: None,
            })),
            GLTF_TRANSMISSIVE,
        ),
        (
            extended(|all| all.diffuse_transmission.share.factor = 1.0),
            GLTF_THIN_WALLED,
        ),
    ] {
        assert_eq!(outside(&material).gltf.flags, flags);
    }

    let mut gold = shapes::material();
    gold.model = Model::SpecularGlossiness(SpecularGlossiness {
        diffuse: Vec4::new(0.5, 0.25, 1.0, 0.3).into(),
        specular: Vec3::new(0.2, 0.6, 0.4).into(),
        glossiness: 0.75,
    });
    let gold = outside(&gold);
    close(gold.reflectance, [0.2, 0.1, 0.4]);
    close(gold.gltf.F0, [0.2, 0.6, 0.4]);
    assert_eq!((gold.gltf.F90, gold.gltf.metallic), (1.0, 0.0));
    assert!((gold.roughness - 0.25).abs() < 1e-7 && (gold.alpha.x - 0.0625).abs() < 1e-7);
}

/// Extensions whose values are 0 or 1 where that is neutral give the base's very numbers.
#[test]
fn neutral_extensions_are_the_base_bit_for_bit() {
    let mut random = Random(31);
    let neutral = packed_material(&extended(|all| {
        all.sheen.roughness.factor = 0.7;
        all.anisotropy.rotation = 0.0;
        all.clearcoat.roughness.factor = 0.4;
        all.iridescence.film_ior = 1.8;
    }));
    let plain = packed_material(&shapes::material());
    for _ in 0..100 {
        let eta = f64::from(random.range(1.0, 3.0));
        let texels = white_texels();
        let [a, b] = [&plain, &neutral].map(|material| {
            let mut bsdf = Bsdf::from(&bsdf_of(material, &texels, eta));
            // Of lobes of strength 0.
            bsdf.gltf.sheen_roughness = 0.0;
            bsdf.gltf.coat_roughness = 0.0;
            bsdf.gltf.film_ior = 0.0;
            bsdf
        });
        assert_eq!(a, b);
        assert_eq!(a.gltf.coat_normal, [0.0, 0.0, 1.0]);
    }
}
