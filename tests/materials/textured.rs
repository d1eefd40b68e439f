//! Materials with every texture, in the kernels and in the reference.

use crate::common::rays::{ray, towards};
use crate::common::shapes::{self, Random};
use crate::{extended, on_cpu, on_gpu, texture};
use glam::{Affine3A, Vec2, Vec3, Vec4};
use snell::cpu;
use snell::scene::extensions::Volume;
use snell::scene::{Image, Material, Mesh, Model, Pixels, Scene, SpecularGlossiness, Textured};
use snell::shared::*;

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
