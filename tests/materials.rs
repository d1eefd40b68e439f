//! glTF's materials on their way to the reflection functions: packed numbers, textures at a point of a
//! surface, coats with their own normals, the kernels against the reference.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod common;

use bytemuck::{Pod, Zeroable};
use common::rays::{RayQuery, ray, towards};
use common::shapes::{self, Random};
use glam::{Affine3A, DVec3, Vec2, Vec3, Vec4};
use snell::cpu;
use snell::cpu::material::{bsdf_of, white_texels};
use snell::pack::Packed;
use snell::pack::material::pack_material;
use snell::pack::texture::Textures;
use snell::scene::extensions::Volume;
use snell::scene::material::IDENTITY_ROWS;
use snell::scene::{
    Extensions, Filter, Image, Material, Mesh, Model, Pixels, Scene, SpecularGlossiness, Texture,
    Textured, Wrap,
};
use snell::shared::{self, *};

fn extended(change: impl Fn(&mut Extensions)) -> Material {
    let mut material = shapes::material();
    if let Model::MetallicRoughness(model) = &mut material.model {
        change(&mut model.extensions);
    }
    material
}

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

/// The reflection model where a ray met a material, in front or behind.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Answer {
    t: f32,
    u: f32,
    v: f32,
    instance: u32,
    triangle: u32,
    front: u32,
    reserved: [u32; 2],
    /// In world space.
    coat_normal: [f32; 3],
    reserved1: u32,
    bsdf: Bsdf,
}

const MATERIALS: &str = "
import package::shared::{NONE, Bsdf};
import package::bindings::{materials};
import package::ray::{Ray, Hit};
import package::bvh::{trace_closest};
import package::math::{to_world};
import package::surface::{Surface, surface_at};
import package::material::{bsdf_at};
struct Answer {
    t: f32, u: f32, v: f32, instance: u32, triangle: u32, front: u32, reserved: vec2<u32>,
    coat_normal: vec3<f32>, reserved1: u32, bsdf: Bsdf,
}
@group(3) @binding(0) var<storage, read> rays: array<Ray>;
@group(3) @binding(1) var<storage, read_write> answers: array<Answer>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&rays) { return; }
    let ray = rays[id.x];
    let hit = trace_closest(ray, id.x);
    answers[id.x].instance = hit.instance;
    if hit.instance == NONE { return; }
    let s = surface_at(ray, hit);
    let material = materials[s.material];
    let bsdf = bsdf_at(material, s, material.ior);
    answers[id.x] = Answer(hit.t, hit.u, hit.v, hit.instance, hit.triangle, s.front, vec2(0u),
        to_world(s.basis, bsdf.gltf.coat_normal), 0u, bsdf);
}";

fn on_gpu(packed: &Packed, rays: &[RayQuery]) -> Vec<Answer> {
    let bytes = common::run_scene(
        MATERIALS,
        packed,
        &[bytemuck::cast_slice(rays)],
        rays.len() * size_of::<Answer>(),
        rays.len() as u32,
    );
    bytemuck::pod_collect_to_vec(&bytes)
}

/// The reference's surface and model at the kernels' own hit.
fn on_cpu(
    packed: &Packed,
    query: &RayQuery,
    gpu: &Answer,
) -> (cpu::surface::Surface, cpu::bsdf::Bsdf) {
    let hit = cpu::ray::Hit {
        t: f64::from(gpu.t),
        u: f64::from(gpu.u),
        v: f64::from(gpu.v),
        instance: gpu.instance,
        triangle: gpu.triangle,
    };
    let s = cpu::surface::surface_at(packed, ray(query), hit);
    let material = &packed.materials[s.material as usize];
    let bsdf = cpu::material::bsdf_at(packed, material, &s, f64::from(material.ior));
    (s, bsdf)
}

fn texture(image: usize, srgb: bool) -> Option<Texture> {
    Some(Texture {
        image,
        srgb,
        wrap_s: Wrap::Repeat,
        wrap_t: Wrap::Mirror,
        filter: Filter::Linear,
        texcoord: 0,
        rows: [Vec3::new(1.5, 0.2, 0.1), Vec3::new(-0.1, 0.8, 0.0)],
    })
}

/// Image i is a smooth pattern of its own in each channel, so that no texture can stand for another.
fn patterns(count: usize) -> Vec<Image> {
    let texel = |image: usize, x: usize, y: usize, channel: usize| {
        let phase = (image * 4 + channel) as f32;
        let wave = (0.39 * x as f32 + phase).sin() * (0.39 * y as f32 + 2.0 * phase).cos();
        (150.0 + 100.0 * wave) as u8
    };
    (0..count)
        .map(|image| Image {
            name: String::new(),
            width: 16,
            height: 16,
            pixels: Pixels::Rgba8(
                (0..16 * 16 * 4)
                    .map(|i| texel(image, (i / 4) % 16, i / 64, i % 4))
                    .collect(),
            ),
        })
        .collect()
}

/// Everything that the extensions have, textured.
fn everything(image: &mut impl FnMut() -> usize) -> Material {
    let mut material = shapes::material();
    material.double_sided = true;
    let mut map = |srgb| texture(image(), srgb);
    let Model::MetallicRoughness(model) = &mut material.model else {
        panic!("not metallic-roughness");
    };
    let all = &mut model.extensions;
    all.transmission = Textured {
        factor: 0.9,
        texture: map(false),
    };
    all.diffuse_transmission.share = Textured {
        factor: 0.8,
        texture: map(false),
    };
    all.diffuse_transmission.color = Textured {
        factor: Vec3::new(0.9, 0.8, 0.7),
        texture: map(true),
    };
    all.volume = Some(Volume {
        attenuation_color: Vec3::ONE,
        attenuation_distance: None,
    });
    all.specular.strength = Textured {
        factor: 0.7,
        texture: map(false),
    };
    all.specular.color = Textured {
        factor: Vec3::new(3.0, 0.8, 0.7),
        texture: map(true),
    };
    all.clearcoat.coat = Textured {
        factor: 0.6,
        texture: map(false),
    };
    all.clearcoat.roughness = Textured {
        factor: 0.5,
        texture: map(false),
    };
    all.clearcoat.normal_texture = map(false);
    all.clearcoat.normal_scale = 0.3;
    all.sheen.color = Textured {
        factor: Vec3::new(0.4, 0.5, 0.6),
        texture: map(true),
    };
    all.sheen.roughness = Textured {
        factor: 0.9,
        texture: map(false),
    };
    all.anisotropy.strength = Textured {
        factor: 0.8,
        texture: map(false),
    };
    all.anisotropy.rotation = 0.6;
    all.iridescence.strength = Textured {
        factor: 0.7,
        texture: map(false),
    };
    all.iridescence.thickness.texture = map(false);
    material
}

fn dressed_sphere(material: usize) -> Mesh {
    let mut mesh = shapes::sphere(12, 1.0);
    let primitive = &mut mesh.primitives[0];
    let tangent = |n: &Vec3| Vec3::new(-n.z, 0.0, n.x).try_normalize().unwrap_or(Vec3::X);
    let tangents = primitive.normals.iter().map(|n| tangent(n).extend(-1.0));
    let texcoords = primitive.normals.iter().map(|n| Vec2::new(n.x + n.z, n.y));
    primitive.tangents = Some(tangents.collect());
    primitive.texcoords = vec![texcoords.collect()];
    primitive.material = material;
    mesh
}

fn dressed_scene() -> Scene {
    let mut count = 0;
    let mut image = || {
        count += 1;
        count - 1
    };
    let full = everything(&mut image);
    let mut glossy = shapes::material();
    glossy.model = Model::SpecularGlossiness(SpecularGlossiness {
        diffuse: Textured {
            factor: Vec4::new(0.9, 0.8, 0.7, 1.0),
            texture: texture(image(), true),
        },
        specular: Textured {
            factor: Vec3::new(0.5, 0.4, 0.9),
            texture: texture(image(), true),
        },
        glossiness: 0.9,
    });
    // A coat of its own normal over a bumpy base.
    let mut lacquer = extended(|all| all.clearcoat.coat.factor = 1.0);
    lacquer.normal_texture = texture(image(), false);
    lacquer.normal_scale = 0.5;
    let meshes = (0..3).map(dressed_sphere).collect();
    let instances = (0..6)
        .map(|i| {
            let mirror = if i < 3 { 1.0 } else { -1.0 };
            let place = Vec3::new(3.0 * (i % 3) as f32 - 3.0, 0.0, 3.0 * (i / 3) as f32);
            let scale = Vec3::new(mirror, 0.8, 1.1);
            let rotation = glam::Quat::from_rotation_z(0.3 * i as f32);
            shapes::instance(
                i % 3,
                Affine3A::from_scale_rotation_translation(scale, rotation, place),
            )
        })
        .collect();
    let mut scene = shapes::scene(meshes, instances);
    scene.materials = vec![full, glossy, lacquer];
    scene.images = patterns(count).into_iter().map(Into::into).collect();
    scene
}

/// Largest difference of two models' numbers, relative to the larger of the number and 0.1.
fn difference(a: &Bsdf, b: &Bsdf) -> f32 {
    let words = |bsdf: &Bsdf| -> Vec<f32> {
        let g = &bsdf.gltf;
        [
            &bsdf.reflectance[..],
            &bsdf.eta,
            &bsdf.alpha,
            &[bsdf.roughness, g.F90, g.metallic, g.transmission],
            &g.F0,
            &g.rotation,
            &g.diffuse_transmission_color,
            &[g.diffuse_transmission, g.sheen_roughness, g.coat],
            &g.sheen_color,
            &g.coat_normal,
            &[
                g.coat_roughness,
                g.iridescence,
                g.film_ior,
                g.film_thickness,
            ],
        ]
        .concat()
    };
    words(a)
        .iter()
        .zip(words(b))
        .map(|(&a, b)| (a - b).abs() / a.abs().max(b.abs()).max(0.1))
        .fold(0.0, f32::max)
}

#[test]
fn kernels_and_reference_read_the_same_materials() {
    let mut random = Random(41);
    let rays: Vec<_> = (0..12_000)
        .map(|i| {
            let centre = Vec3::new(3.0 * (i % 3) as f32 - 3.0, 0.0, 3.0 * (i % 2) as f32);
            // Half of them from within.
            let reach = if i % 4 < 2 { 0.1 } else { 4.0 };
            towards(
                centre + reach * random.direction(),
                centre + 0.7 * random.direction(),
            )
        })
        .collect();
    // Baked into one mesh, in world space; and by themselves.
    let scene = dressed_scene();
    for (name, scene) in [
        ("one level", scene.clone()),
        ("two levels", shapes::two_levels(scene)),
    ] {
        let packed = shapes::packed(&scene);
        assert_eq!(packed.frame.mesh_root != 0, name == "one level");
        let (mut hits, mut inside, mut far, mut worst) = (0, 0, 0, 0.0_f32);
        for (gpu, query) in on_gpu(&packed, &rays).iter().zip(&rays) {
            if gpu.instance == NONE {
                continue;
            }
            let (surface, bsdf) = on_cpu(&packed, query, gpu);
            let material = &packed.materials[surface.material as usize];
            assert_eq!(gpu.front != 0, surface.front);
            assert_eq!(gpu.bsdf.gltf.flags, bsdf.gltf.flags);
            let in_glass = !surface.front && material.flags & MATERIAL_TRANSMISSIVE != 0;
            assert_eq!(bsdf.gltf.flags & GLTF_INSIDE != 0, in_glass);
            let coat_normal = bsdf.gltf.coat_normal;
            assert!((coat_normal.length() - 1.0).abs() < 1e-9);
            let in_world = cpu::math::to_world(surface.basis, coat_normal);
            assert!(in_world.dot(-ray(query).direction) > 0.0);
            // Compared there: how the frame is turned about its normal rounds coarsely where that is nearly the tangent.
            let (mut a, mut b) = (gpu.bsdf, Bsdf::from(&bsdf));
            a.gltf.coat_normal = gpu.coat_normal;
            b.gltf.coat_normal = in_world.as_vec3().to_array();
            let gap = difference(&a, &b);
            worst = worst.max(gap);
            far += usize::from(gap > 1e-4);
            hits += 1;
            inside += usize::from(in_glass);
        }
        println!("{name}: {hits} hits, {inside} inside, {far} off, worst {worst:e}");
        assert!(hits > 8000 && inside > 500);
        assert!(
            far <= hits / 2000 && worst < 1e-3,
            "{far} of {hits}, worst {worst:e}"
        );
    }
}

/// Each extension's texture changes the numbers that it is of, and no other texture does.
#[test]
fn each_texture_reaches_its_own_parameter() {
    let scene = dressed_scene();
    let rays: Vec<_> = [0.3, 0.5, 0.7]
        .map(|y| towards(Vec3::new(-3.0, y, -4.0), Vec3::new(-3.1, 0.0, 0.0)))
        .into();
    let packed = shapes::packed(&scene);
    let hits = on_gpu(&packed, &rays);
    let all = scene.materials[0].extensions().unwrap().textures();
    let models = |scene: &Scene| -> Vec<Bsdf> {
        let packed = shapes::packed(scene);
        rays.iter()
            .zip(&hits)
            .map(|(query, hit)| Bsdf::from(&on_cpu(&packed, query, hit).1))
            .collect()
    };
    let base = models(&scene);
    type Reset = fn(&mut Gltf, &Gltf);
    // In the order of `Extensions::textures`: copies what the texture is of, and nothing else.
    let own: [Reset; 13] = [
        |a, b| a.transmission = b.transmission,
        |a, b| a.diffuse_transmission = b.diffuse_transmission,
        |a, b| a.diffuse_transmission_color = b.diffuse_transmission_color,
        |a, b| (a.F0, a.F90) = (b.F0, b.F90),
        |a, b| a.F0 = b.F0,
        |a, b| a.rotation = b.rotation,
        |a, b| a.coat = b.coat,
        |a, b| a.coat_roughness = b.coat_roughness,
        |a, b| a.coat_normal = b.coat_normal,
        |a, b| a.sheen_color = b.sheen_color,
        |a, b| a.sheen_roughness = b.sheen_roughness,
        |a, b| a.iridescence = b.iridescence,
        |a, b| a.film_thickness = b.film_thickness,
    ];
    for (texture, own) in all.into_iter().zip(own) {
        let image = texture.as_ref().unwrap().image;
        let mut changed = scene.clone();
        if let Pixels::Rgba8(bytes) =
            &mut std::sync::Arc::make_mut(&mut changed.images[image]).pixels
        {
            bytes.reverse();
        }
        for (mut model, base) in models(&changed).into_iter().zip(&base) {
            assert_ne!(model, *base, "image {image}");
            own(&mut model.gltf, &base.gltf);
            // The anisotropy's blue channel widens the lobe.
            model.alpha = base.alpha;
            assert_eq!(model, *base, "image {image}");
        }
    }
}

/// A square of one texture coordinate, seen aslant: what the channels of a flat image do.
fn flat(
    material: Material,
    texel: [u8; 4],
    front: bool,
) -> (cpu::surface::Surface, cpu::bsdf::Bsdf) {
    let mut mesh = shapes::grid(1, |_, _| 0.0);
    let primitive = &mut mesh.primitives[0];
    let count = primitive.positions.len();
    // Normal +y, tangent +x: glTF's bitangent is cross(n, t) * w = -z for +1.
    primitive.tangents = Some(vec![Vec4::new(1.0, 0.0, 0.0, 1.0); count]);
    primitive.texcoords = vec![vec![Vec2::ZERO; count]];
    let mut scene = shapes::scene(vec![mesh], vec![shapes::instance(0, Affine3A::IDENTITY)]);
    scene.materials = vec![material];
    scene.images = vec![std::sync::Arc::new(Image {
        name: String::new(),
        width: 1,
        height: 1,
        pixels: Pixels::Rgba8(texel.into()),
    })];
    let packed = shapes::packed(&scene);
    let side = if front { 1.0 } else { -1.0 };
    let query = towards(Vec3::new(0.2, side, 0.3), Vec3::new(0.1, 0.0, 0.2));
    let hit = cpu::bvh::trace_closest(&packed, ray(&query), 0);
    let surface = cpu::surface::surface_at(&packed, ray(&query), hit);
    let material = &packed.materials[0];
    let bsdf = cpu::material::bsdf_at(&packed, material, &surface, 1.5);
    (surface, bsdf)
}

fn flat_texture() -> Option<Texture> {
    Some(Texture {
        rows: IDENTITY_ROWS,
        ..texture(0, false).unwrap()
    })
}

#[test]
fn anisotropy_points_along_the_texture_turned_by_the_rotation_on_both_sides() {
    let brushed = || {
        extended(|all| {
            all.anisotropy.strength.factor = 1.0;
            all.anisotropy.strength.texture = flat_texture();
            all.anisotropy.rotation = std::f32::consts::FRAC_PI_6;
        })
    };
    for front in [true, false] {
        // (1, 1) in tangent space: 45 degrees, and 30 more.
        let (surface, bsdf) = flat(brushed(), [255, 255, 128, 255], front);
        let r = bsdf.gltf.rotation;
        let world = cpu::math::to_world(surface.basis, DVec3::new(r.x, r.y, 0.0));
        let angle = 75.0_f64.to_radians();
        let expected = DVec3::new(angle.cos(), 0.0, -angle.sin());
        assert!((world - expected).length() < 1e-6, "{world}");
        let strength = 128.0 / 255.0;
        let alpha = 0.25 + 0.75 * strength * strength;
        assert!((bsdf.alpha.x - alpha).abs() < 1e-6, "{}", bsdf.alpha);
    }
}

#[test]
fn a_coat_is_smooth_over_bumps_and_follows_its_own() {
    let world = |(surface, bsdf): (cpu::surface::Surface, cpu::bsdf::Bsdf)| {
        cpu::math::to_world(surface.basis, bsdf.gltf.coat_normal)
    };
    // A normal 26.6 degrees towards the tangent.
    let tilted = [191, 128, 255, 255];
    for front in [true, false] {
        let up = if front { DVec3::Y } else { DVec3::NEG_Y };
        let mut bumpy = extended(|all| all.clearcoat.coat.factor = 1.0);
        bumpy.normal_texture = flat_texture();
        let (surface, bsdf) = flat(bumpy, tilted, front);
        assert!(surface.basis.n.dot(up) < 0.95);
        assert!((world((surface, bsdf)) - up).length() < 1e-6);
        let own = extended(|all| {
            all.clearcoat.coat.factor = 1.0;
            all.clearcoat.normal_texture = flat_texture();
        });
        let (surface, bsdf) = flat(own, tilted, front);
        assert!((surface.basis.n - up).length() < 1e-9);
        let cosine = world((surface, bsdf)).dot(up);
        assert!(
            (cosine - 26.5_f64.to_radians().cos()).abs() < 5e-3,
            "{cosine}"
        );
    }
}
