//! Packing: the same bytes each time, what is stored once, layouts, numbers of the frame, refusals.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod common;

use common::shapes::{self, Random};
use glam::{Affine3A, Quat, Vec2, Vec3, Vec3A, Vec4};
use snell::bvh::{self, Bounds, MAX_DEPTH, STACK_SIZE};
use snell::pack::vertex::{pack_normal, pack_tangent};
use snell::pack::{Background, PackError, Packed, Packer, pack};
use snell::scene::bsdf_model::{BsdfModel, OrenNayarForm};
use snell::scene::{
    AlphaMode, Camera, Environment, Filter, Image, Material, Model, Pixels, Projection,
    PunctualKind, PunctualLight, Scene, Texture, Wrap,
};
use snell::shared::*;

/// Every array of a packed scene as bytes.
fn bytes(packed: &Packed) -> Vec<u8> {
    let mut all = bytemuck::bytes_of(&packed.frame).to_vec();
    all.extend_from_slice(bytemuck::cast_slice(&packed.nodes));
    all.extend_from_slice(bytemuck::cast_slice(&packed.triangles));
    all.extend_from_slice(bytemuck::cast_slice(&packed.instances));
    all.extend_from_slice(bytemuck::cast_slice(&packed.vertices));
    all.extend_from_slice(bytemuck::cast_slice(&packed.materials));
    all.extend_from_slice(bytemuck::cast_slice(&packed.texels));
    all.extend_from_slice(bytemuck::cast_slice(&packed.lights));
    all.extend_from_slice(bytemuck::cast_slice(&packed.light_nodes));
    all.extend_from_slice(bytemuck::cast_slice(&packed.environment));
    all.extend_from_slice(bytemuck::cast_slice(&packed.environment_cells));
    all
}

fn image(pixels: Pixels, width: u32, height: u32) -> std::sync::Arc<Image> {
    std::sync::Arc::new(Image {
        name: String::new(),
        width,
        height,
        pixels,
    })
}

fn texture(image: usize, srgb: bool) -> Texture {
    Texture {
        image,
        srgb,
        wrap_s: Wrap::Clamp,
        wrap_t: Wrap::Mirror,
        filter: Filter::Linear,
        texcoord: 0,
        rows: [Vec3::X, Vec3::Y],
    }
}

fn metallic_roughness(material: &mut Material) -> &mut snell::scene::MetallicRoughness {
    match &mut material.model {
        Model::MetallicRoughness(m) => m,
        _ => panic!("not metallic-roughness"),
    }
}

/// Meshes large enough for the parallel parts of the build, with ties: grids and copies.
fn large() -> Scene {
    let mut random = Random(20);
    let meshes = vec![
        shapes::grid(80, |_, _| 0.0),
        shapes::soup(&mut random, 9000, 0.05),
        shapes::sphere(50, 1.0),
    ];
    let instances = (0..300)
        .map(|i| {
            let rotation = Quat::from_axis_angle(random.direction(), random.range(0.0, 6.0));
            let place = if i % 3 == 0 {
                Vec3::ZERO
            } else {
                random.cube()
            };
            shapes::instance(i % 3, Affine3A::from_rotation_translation(rotation, place))
        })
        .collect();
    let mut scene = shapes::scene(meshes, instances);
    scene.materials[0].emissive = Vec3::ONE;
    scene
}

#[test]
fn the_same_scene_gives_the_same_bytes_on_any_number_of_threads() {
    let scene = large();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        bytes(&pool.build().unwrap().install(|| shapes::packed(&scene)))
    };
    let one = on(1);
    for threads in [1, 2, 3, 8] {
        assert!(on(threads) == one, "{threads} threads");
    }
}

#[test]
fn a_mesh_used_twice_is_stored_once() {
    let place = |x: f32| Affine3A::from_translation(Vec3::new(x, 0.0, 0.0));
    let packed_with = |count: usize| {
        let instances = (0..count).map(|i| shapes::instance(0, place(3.0 * i as f32)));
        shapes::packed(&shapes::two_levels(shapes::scene(
            vec![shapes::sphere(10, 1.0), shapes::sphere(40, 1.0)],
            instances.collect(),
        )))
    };
    let (once, many) = (packed_with(1), packed_with(7));
    assert_eq!(once.triangles, many.triangles);
    assert_eq!(once.vertices, many.vertices);
    // The mesh that no instance places is not stored.
    assert_eq!(once.triangles.len(), 2 * 20 * 9);
    assert_eq!(many.instances.len(), 7);
    let roots: Vec<_> = many
        .instances
        .iter()
        .map(|i| (i.root, i.first_triangle))
        .collect();
    assert!(roots.iter().all(|&root| root == roots[0]));
    // Only the top level grew, by less than the mesh's own hierarchy.
    assert!(many.nodes.len() - once.nodes.len() <= 5);
}

#[test]
fn every_triangle_is_in_one_leaf_and_inside_its_boxes() {
    let scene = large();
    let packed = shapes::packed(&scene);
    for instance in &packed.instances[..6] {
        let mut seen = Vec::new();
        let mut stack = vec![(instance.root, None)];
        while let Some((index, bounds)) = stack.pop() {
            visit(
                &packed,
                index,
                bounds,
                &mut stack,
                |leaf, bounds: Bounds| {
                    let triangle = &packed.triangles[(instance.first_triangle + leaf) as usize];
                    let p0 = Vec3::from_array(triangle.p0);
                    for p in [
                        p0,
                        p0 + Vec3::from_array(triangle.e1),
                        p0 + Vec3::from_array(triangle.e2),
                    ] {
                        let slack = Vec3A::splat(1e-6);
                        assert!(
                            p.to_vec3a().cmpge(bounds.min - slack).all(),
                            "{p} {bounds:?}"
                        );
                        assert!(
                            p.to_vec3a().cmple(bounds.max + slack).all(),
                            "{p} {bounds:?}"
                        );
                    }
                    seen.push(leaf);
                },
            );
        }
        seen.sort_unstable();
        let count = [2 * 80 * 80, 9000, 2 * 100 * 49]
            .into_iter()
            .find(|&count| count == seen.len());
        assert!(count.is_some(), "{} leaves", seen.len());
        assert!(seen.iter().enumerate().all(|(i, &leaf)| i == leaf as usize));
    }
}

/// Reads a node by the format's definition: its boxes lie in the parent's, `leaf` gets the others.
fn visit(
    packed: &Packed,
    index: u32,
    parent: Option<Bounds>,
    stack: &mut Vec<(u32, Option<Bounds>)>,
    mut leaf: impl FnMut(u32, Bounds),
) {
    let words = &packed.nodes[5 * index as usize..][..5];
    let node: [u8; 80] = bytemuck::cast_slice::<_, u8>(words).try_into().unwrap();
    let corner: [f32; 3] = bytemuck::pod_read_unaligned(&node[..12]);
    let step = [node[12], node[13], node[14]].map(|e| f32::from_bits(u32::from(e) << 23));
    let mut inner = 0;
    for child in 0..8 {
        let info = node[24 + child];
        let plane = |axis: usize, upper: usize| {
            corner[axis] + step[axis] * f32::from(node[32 + 16 * axis + 8 * upper + child])
        };
        let bounds = Bounds {
            min: [plane(0, 0), plane(1, 0), plane(2, 0)].into(),
            max: [plane(0, 1), plane(1, 1), plane(2, 1)].into(),
        };
        if let (Some(parent), true) = (parent, info != 0) {
            let slack = Vec3A::splat(0.02);
            assert!(bounds.min.cmpge(parent.min - slack).all());
            assert!(bounds.max.cmple(parent.max + slack).all());
        }
        if node[15] & (1 << child) != 0 {
            assert_eq!(info, 0b0010_0000 | (24 + child as u8));
            stack.push((words[1][0] + inner, Some(bounds)));
            inner += 1;
        } else {
            for primitive in 0..(info >> 5).count_ones() {
                leaf(words[1][1] + u32::from(info & 31) + primitive, bounds);
            }
        }
    }
}

#[test]
fn hierarchies_fit_the_stack_whatever_is_in_them() {
    let shader = snell::gpu::shaders::text("bvh").unwrap();
    assert!(shader.contains(&format!("const STACK_SIZE: u32 = {STACK_SIZE}u;")));
    let point = |p: Vec3| Bounds::of_points([p.into()]);
    let same = vec![point(Vec3::ONE); 100_000];
    // Each box a little larger than the last: clustering makes a chain of them.
    let nested: Vec<_> = (0..400)
        .map(|i| {
            let half = Vec3::splat(1.2_f32.powi(i % 180));
            Bounds::of_points([half.into(), (-half).into()])
        })
        .collect();
    let line: Vec<_> = (0..120).map(|i| point(Vec3::X * 1.3_f32.powi(i))).collect();
    let row = (0..100_000).map(|i| point(Vec3::X * i as f32)).collect();
    let cubes = |i: i32| {
        let p = Vec3::X * i as f32;
        Bounds::of_points([(p - 0.3).into(), (p + 0.3).into()])
    };
    let cubes = (0..20_000).map(cubes).collect();
    for (name, boxes) in [
        ("nested", nested),
        ("line", line),
        ("row", row),
        ("cubes", cubes),
        ("same", same),
        ("none", vec![point(Vec3::ZERO); 5000]),
    ] {
        let hierarchy = bvh::build(&boxes).unwrap();
        println!("{name}: {} boxes, depth {}", boxes.len(), hierarchy.depth);
        assert!(hierarchy.depth <= MAX_DEPTH, "{name}: {}", hierarchy.depth);
        let mut order = hierarchy.order.clone();
        order.sort_unstable();
        assert!(
            order.iter().enumerate().all(|(i, &o)| i == o as usize),
            "{name}"
        );
    }
    assert_eq!(bvh::build(&[]), None);
}

#[test]
fn vertices_carry_what_their_material_reads() {
    let mut mesh = shapes::flat(&[
        [Vec3::ZERO, Vec3::X, Vec3::Y],
        [Vec3::ZERO, Vec3::Y, Vec3::Z],
    ]);
    let primitive = &mut mesh.primitives[0];
    primitive.tangents = Some(vec![Vec4::new(1.0, 2.0, 3.0, -1.0); 6]);
    primitive.colors = Some(vec![Vec4::new(4.0, 5.0, 6.0, 7.0); 6]);
    primitive.texcoords = (0..3)
        .map(|set| vec![Vec2::splat(10.0 + set as f32); 6])
        .collect();
    let mut scene = shapes::scene(vec![mesh], vec![shapes::instance(0, Affine3A::IDENTITY)]);
    scene.images = vec![image(Pixels::Rgba8(vec![255; 4]), 1, 1)];
    let plain = shapes::packed(&scene);
    let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    let normal = pack_normal(Vec3::Z);
    assert_eq!(plain.triangles[0].vertex_layout, LAYOUT_COLOR);
    assert_eq!(plain.vertices.len(), 6 * 5);
    assert_eq!(plain.vertices[0], normal);
    assert_eq!(plain.vertices[1..5], bits(&[4.0, 5.0, 6.0, 7.0]));
    let mut second_set = texture(0, false);
    second_set.texcoord = 1;
    scene.materials[0].normal_texture = Some(second_set);
    let dressed = shapes::packed(&scene);
    let layout = LAYOUT_TANGENT | LAYOUT_COLOR | 2 << LAYOUT_TEXCOORDS_SHIFT;
    let words = 1 + 1 + 4 + 4;
    for triangle in &dressed.triangles {
        assert_eq!(triangle.vertex_layout, layout);
        let first = triangle.vertex1 as usize;
        assert_eq!(first % words, 0);
        let tangent = pack_tangent(Vec4::new(1.0, 2.0, 3.0, -1.0));
        assert_eq!(dressed.vertices[first + 1], tangent);
        let expected = bits(&[4.0, 5.0, 6.0, 7.0, 10.0, 10.0, 11.0, 11.0]);
        assert_eq!(dressed.vertices[first + 2..][..8], expected);
    }
}

#[test]
fn images_are_stored_once_for_each_way_of_decoding() {
    let mut scene = shapes::scene(vec![], vec![]);
    scene.images = vec![
        image(Pixels::Rgba8(vec![1, 2, 3, 4, 5, 6, 7, 8]), 2, 1),
        image(Pixels::Rgba16(vec![0, 65535, 32896, 1]), 1, 1),
        image(Pixels::Rgba8(vec![9; 4]), 1, 1),
    ];
    let mut other = shapes::material();
    metallic_roughness(&mut other).base_color_texture = Some(texture(0, true));
    metallic_roughness(&mut other).metallic_roughness_texture = Some(texture(0, false));
    other.emissive_texture = Some(texture(1, true));
    other.normal_texture = Some(texture(1, false));
    scene.materials = vec![other.clone(), other];
    let packed = shapes::packed(&scene);
    let [a, b] = [0, 1].map(|i| packed.materials[i]);
    assert_eq!(a, b);
    // 2 texels twice, 2 words twice; the third image is not used.
    assert_eq!(packed.texels.len(), 8);
    let color = a.base_color_texture;
    assert_eq!(color.format, FORMAT_RGBA8_SRGB | FILTER_LINEAR << 8);
    assert_eq!(color.wrap, WRAP_CLAMP | WRAP_MIRROR << 2);
    assert_eq!(
        (color.size, packed.texels[color.texels as usize]),
        ([2, 1], 0x0403_0201)
    );
    assert_eq!(
        a.metallic_roughness_texture.format & 0xff,
        FORMAT_RGBA8_UNORM
    );
    let linear = a.normal_texture;
    assert_eq!(linear.format & 0xff, FORMAT_RGBA16_UNORM);
    assert_eq!(
        packed.texels[linear.texels as usize..][..2],
        [0xffff_0000, 0x0001_8080]
    );
    // sRGB of 16 bits is decoded while packing: 32896 / 65535 is 0.50196, which is 0.21586 linear.
    let decoded = packed.texels[a.emissive_texture.texels as usize + 1];
    assert!((f64::from(decoded & 0xffff) / 65535.0 - 0.21586).abs() < 2e-5);
    assert_eq!(decoded >> 16, 1);
    assert_eq!(packed.materials[0].base_color_texture.texcoord, 0);
}

#[test]
fn emission_weighs_its_mean_and_never_loses_a_texel() {
    let mut scene = shapes::scene(vec![], vec![]);
    let mut dark = vec![0_u8; 64 * 64 * 4];
    dark[4 * 77] = 1;
    scene.images = vec![
        image(Pixels::Rgba8(dark), 64, 64),
        image(Pixels::Rgba8(vec![0, 0, 0, 255]), 1, 1),
        image(Pixels::Rgba8(vec![255, 255, 255, 255, 0, 0, 0, 255]), 2, 1),
    ];
    let weight = |emissive: Vec3, image: Option<usize>| {
        let mut scene = scene.clone();
        scene.materials[0].emissive = emissive;
        scene.materials[0].emissive_texture = image.map(|image| texture(image, true));
        let material = shapes::packed(&scene).materials[0];
        assert_eq!(
            material.flags & MATERIAL_EMISSIVE != 0,
            material.emission_weight > 0.0
        );
        material.emission_weight
    };
    assert_eq!(weight(Vec3::ZERO, None), 0.0);
    assert!((weight(Vec3::new(1.0, 2.0, 3.0), None) - 1.8596).abs() < 1e-6);
    assert!((weight(Vec3::splat(4.0), Some(2)) - 2.0).abs() < 1e-6);
    assert_eq!(weight(Vec3::ONE, Some(1)), 0.0);
    assert!(weight(Vec3::new(1.2e-38, 0.0, 0.0), Some(0)) > 0.0);
}

#[test]
fn lights_are_all_that_shines() {
    let mut glow = shapes::material();
    glow.emissive = Vec3::splat(2.0);
    let mut mesh = shapes::flat(&[
        [Vec3::ZERO, Vec3::X, Vec3::Y],
        // No area.
        [Vec3::ZERO, Vec3::X, Vec3::X],
    ]);
    mesh.primitives[0].material = 1;
    let dim = shapes::sphere(4, 1.0);
    let transform = Affine3A::from_scale(Vec3::new(-2.0, 3.0, 1.0));
    let mut scene = shapes::scene(
        vec![dim, mesh],
        vec![
            shapes::instance(0, Affine3A::IDENTITY),
            shapes::instance(1, Affine3A::IDENTITY),
            shapes::instance(1, transform),
        ],
    );
    scene.materials.push(glow);
    scene.lights.push(PunctualLight {
        name: String::new(),
        kind: PunctualKind::Point,
        intensity: Vec3::ONE,
        position: Vec3::Y,
        direction: Vec3::NEG_Z,
        range: None,
    });
    scene.environment = Some(Environment {
        width: 4,
        height: 2,
        radiance: vec![[1.0; 3]; 8],
        strength: 0.5,
        rotation: 0.25,
    });
    let baked = shapes::packed(&scene);
    let packed = shapes::packed(&shapes::two_levels(scene));
    let in_order = |packed: &Packed| {
        let mut weights: Vec<f32> = packed.lights.iter().map(|light| light.weight).collect();
        weights.sort_by(f32::total_cmp);
        weights
    };
    for (a, b) in in_order(&baked).iter().zip(in_order(&packed)) {
        assert!((a - b).abs() <= 1e-5 * b, "{a} and {b}");
    }
    assert_eq!(baked.frame.light_count, 2, "the sky, and one for the tree");
    let kinds: Vec<_> = packed.lights.iter().map(|light| light.kind).collect();
    assert_eq!(
        kinds,
        [
            LIGHT_ENVIRONMENT,
            LIGHT_CLUSTER,
            LIGHT_TRIANGLE,
            LIGHT_TRIANGLE,
            LIGHT_POINT,
        ]
    );
    for light in &packed.lights[2..4] {
        let instance = &packed.instances[light.instance as usize];
        let area = if instance.flags & INSTANCE_FLIPPED != 0 {
            3.0
        } else {
            0.5
        };
        assert!((light.weight - 2.0 * area).abs() < 1e-5, "{light:?}");
        let triangle = &packed.triangles[light.triangle as usize];
        assert_eq!(triangle.material, 1);
    }
    let frame = &packed.frame;
    assert_eq!((frame.light_count, frame.light_tree_triangles), (2, 2));
    assert_eq!(
        (frame.environment_strength, frame.environment_size),
        (0.5, [4, 2])
    );
    assert!((frame.environment_sin - 0.25_f32.sin()).abs() < 1e-7);
    // The tree's entry weighs what its lights do.
    let total: f32 = packed.lights[..2].iter().map(|light| light.weight).sum();
    assert!((frame.light_weight_total - total).abs() < 1e-3 * total);
    assert_eq!(frame.environment_weight, packed.lights[0].weight);
}

#[test]
fn materials_keep_what_their_models_say() {
    let mut scene = shapes::scene(vec![], vec![]);
    let lecture = |bsdf: BsdfModel| Material {
        model: Model::Bsdf {
            bsdf,
            base_color: Vec4::new(0.5, 1.0, 0.25, 0.75),
            base_color_texture: None,
        },
        double_sided: false,
        ..shapes::material()
    };
    scene.materials = vec![
        shapes::material(),
        lecture(BsdfModel::Lambertian {
            reflectance: [0.8, 0.5, 0.4],
        }),
        lecture(BsdfModel::Dielectric {
            eta: 1.5,
            distribution: None,
        }),
        Material {
            alpha_mode: AlphaMode::Mask { cutoff: 0.25 },
            ..shapes::material()
        },
    ];
    let m = shapes::packed(&scene).materials;
    assert_eq!((m[0].model, m[0].flags), (BSDF_GLTF, MATERIAL_DOUBLE_SIDED));
    assert_eq!(
        (m[0].ior, m[0].roughness, m[0].fresnel),
        (1.5, 0.5, FRESNEL_SCHLICK)
    );
    assert_eq!((m[1].model, m[1].flags), (BSDF_LAMBERTIAN, 0));
    assert_eq!(m[1].base_color, [0.8, 0.5, 0.4, 0.75]);
    assert_eq!(
        (m[2].model, m[2].flags),
        (BSDF_DIELECTRIC, MATERIAL_TRANSMISSIVE)
    );
    assert_eq!(
        (m[3].flags & MATERIAL_ALPHA_MASK, m[3].alpha_cutoff),
        (MATERIAL_ALPHA_MASK, 0.25)
    );
    scene.materials = vec![lecture(BsdfModel::OrenNayar {
        reflectance: [0.5; 3],
        form: OrenNayarForm::Qualitative,
        sigma: None,
        roughness: None,
    })];
    let error = pack(&scene, &shapes::view()).err().unwrap();
    assert!(
        error.to_string().starts_with("material \"grey\": "),
        "{error}"
    );
}

#[test]
fn the_camera_keeps_its_vertical_angle() {
    let mut view = shapes::view();
    view.film_size = [200, 100];
    view.background = Background::Color([1.0, 2.0, 3.0]);
    let tilt = Quat::from_rotation_y(0.3);
    view.camera = Camera {
        name: String::new(),
        world_from_camera: Affine3A::from_scale_rotation_translation(
            Vec3::new(-2.0, 3.0, 4.0),
            tilt,
            Vec3::ONE,
        ),
        closing: None,
        lens: None,
        projection: Projection::Perspective {
            yfov: 1.0,
            aspect: Some(1.0),
            near: 0.1,
        },
    };
    let frame = pack(&Scene::default(), &view).unwrap().frame;
    let camera = frame.camera;
    assert_eq!(camera.kind, CAMERA_PERSPECTIVE);
    assert!((camera.half_height - 0.5_f32.tan()).abs() < 1e-6);
    assert_eq!(camera.half_width, 2.0 * camera.half_height);
    let near = |v: [f32; 3], expected: Vec3| Vec3::from_array(v).distance(expected) < 1e-6;
    assert!(near(camera.forward, tilt * Vec3::NEG_Z));
    assert!(
        near(camera.right, tilt * Vec3::X),
        "scale and mirroring are left out"
    );
    assert!(near(camera.up, Vec3::Y) && near(camera.origin, Vec3::ONE));
    assert_eq!(
        (frame.background_kind, frame.background),
        (BACKGROUND_COLOR, [1.0, 2.0, 3.0])
    );
    view.camera.projection = Projection::Orthographic {
        xmag: 7.0,
        ymag: 3.0,
        near: 0.0,
    };
    let camera = pack(&Scene::default(), &view).unwrap().frame.camera;
    assert_eq!((camera.half_width, camera.half_height), (6.0, 3.0));
}

#[test]
fn coordinates_that_single_precision_cannot_hold_are_refused() {
    let far = shapes::flat(&[[Vec3::ZERO, Vec3::X * 1e20, Vec3::Y]]);
    let near = shapes::flat(&[[Vec3::ZERO, Vec3::X, Vec3::Y]]);
    for (mesh, transform, what) in [
        (far, Affine3A::IDENTITY, "mesh \"mesh\""),
        (
            near,
            Affine3A::from_scale(Vec3::splat(1e20)),
            "the mesh of nodes[0]",
        ),
    ] {
        let scene = shapes::scene(vec![mesh], vec![shapes::instance(0, transform)]);
        match pack(&scene, &shapes::view()) {
            Err(error @ PackError::TooFar { .. }) => assert!(error.to_string().contains(what)),
            other => panic!("{:?}", other.err()),
        }
    }
}

#[test]
fn a_packer_packs_what_changed_and_gives_the_same_bytes() {
    let triangle = |z: f32| shapes::flat(&[[Vec3::ZERO, Vec3::X, Vec3::new(0.0, 1.0, z)]]);
    let place =
        |mesh: usize, x: f32| shapes::instance(mesh, Affine3A::from_translation(Vec3::X * x));
    let mut scene = shapes::scene(
        vec![triangle(0.0), triangle(1.0)],
        vec![place(0, 0.0), place(1, 1.0)],
    );
    for mesh in &mut scene.meshes {
        for primitive in &mut std::sync::Arc::get_mut(mesh).unwrap().primitives {
            primitive.texcoords = vec![vec![Vec2::X; primitive.positions.len()]];
        }
    }
    let (mut packer, mut baking) = (Packer::default(), Packer::default());
    let mut next = |scene: &Scene, new: [usize; 2], what: &str| {
        let next = |packer: &mut Packer, scene: &Scene| {
            let packed = packer.pack(scene, &shapes::view()).unwrap();
            let fresh = pack(scene, &shapes::view()).unwrap();
            assert!(bytes(&packed) == bytes(&fresh), "{what}");
            assert!(packed.tables == fresh.tables, "{what}: tables");
            packer.new_parts()
        };
        assert_eq!(
            next(&mut packer, &shapes::two_levels(scene.clone())),
            new,
            "{what}"
        );
        // What is baked is one mesh, which follows all that it is made of.
        let moved = what == "moved instances";
        let of_one = usize::from(moved || new[0] > 0);
        assert_eq!(next(&mut baking, scene), [of_one, new[1]], "{what}");
    };
    next(&scene, [2, 0], "the first picture");
    next(&scene, [0, 0], "the same again");
    scene.instances[1] = place(1, 3.0);
    scene.instances.push(place(0, -2.0));
    next(&scene, [0, 0], "moved instances");
    scene.meshes[1] = triangle(2.0).into();
    next(&scene, [1, 0], "another mesh");
    scene.images = vec![image(Pixels::Rgba8(vec![10, 20, 30, 40]), 1, 1)];
    metallic_roughness(&mut scene.materials[0]).base_color_texture = Some(texture(0, true));
    next(
        &scene,
        [1, 1],
        "a texture adds the coordinates that mesh 0 has",
    );
    metallic_roughness(&mut scene.materials[0]).roughness = 0.1;
    next(&scene, [0, 0], "another roughness");
    let sheen = &mut metallic_roughness(&mut scene.materials[0]).extensions.sheen;
    sheen.color.factor = Vec3::ONE;
    next(&scene, [0, 0], "sheen, which has a table of its own");
    // The address of an image that is gone may be given to the next one.
    for value in 0..8 {
        scene.images.clear();
        scene.images = vec![image(Pixels::Rgba8(vec![value; 4]), 1, 1)];
        next(&scene, [0, 1], "another image");
    }
    scene.images = vec![image(Pixels::Rgba8(vec![1; 4 * 8192]), 8192, 1)];
    let what = "an image of so many texels that coordinates need all their bits";
    next(&scene, [1, 1], what);
    scene.images = vec![image(Pixels::Rgba8(vec![1; 4 * 4096]), 4096, 1)];
    next(&scene, [1, 1], "a smaller one");
}
