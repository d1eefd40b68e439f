//! The kernels against the reference at one sample stream, and whether that sees them broken.

use crate::common;
use crate::picture::{assert_parity, on_cpu, on_gpu, whole};
use crate::stage::{Stage, bsdf, lambertian, lamp, rectangle, turned, wide};
use glam::{Affine3A, DVec3, Vec3};
use snell::compare::relative_within;
use snell::gpu::kernel::Kernel;
use snell::gpu::link::link;
use snell::gpu::variant::{Constants, Variants};
use snell::pack::Packed;
use snell::pack::outline::Outline;
use snell::scene::bsdf_model::{Alpha, BsdfModel, Distribution};
use snell::scene::{Environment, Material, Mesh, Model};
use snell::shared::CLASS_MISS;
use std::sync::Arc;

const SIZE: [u32; 2] = [64, 64];
const SAMPLES: u32 = 4;
/// Share of pixels that must differ for a break to count as seen.
const SEEN_BROKEN: f64 = 0.05;

fn glass(ior: f32, alpha: Option<f32>) -> Material {
    bsdf(BsdfModel::Dielectric {
        eta: ior,
        distribution: alpha.map(|alpha| Distribution::Ggx {
            alpha: Alpha::Isotropic(alpha),
        }),
    })
}

fn sky() -> Environment {
    Environment {
        width: 4,
        height: 2,
        radiance: vec![[0.3, 0.4, 0.6]; 8],
        strength: 1.0,
        rotation: 0.0,
    }
}

fn ball(at: Vec3, radius: f32) -> Mesh {
    let mut mesh = common::shapes::sphere(24, radius);
    for primitive in &mut mesh.primitives {
        primitive.positions.iter_mut().for_each(|p| *p += at);
    }
    mesh
}

/// Balls of glass, smooth, rough and dispersive, half in an absorbing liquid and half in each other, over a
/// floor, under a lamp and a sky.
fn aquarium() -> Packed {
    let mut stage = Stage::default();
    stage.add(wide(-1.0), lambertian([0.8, 0.6, 0.4]));
    stage.add_medium(crate::stage::slab(-1.2, -0.1), 1.33, [0.5, 0.2, 0.1]);
    let mut add = |at: Vec3, ior, alpha, absorption: [f32; 3], dispersion| {
        stage.add_changed(&mut ball(at, 0.22), glass(ior, alpha), move |material| {
            material.absorption = absorption;
            material.dispersion = dispersion;
        });
    };
    add(Vec3::new(-0.2, 0.22, 0.0), 1.5, None, [0.1, 1.0, 2.0], 0.0);
    add(Vec3::new(0.05, 0.25, 0.1), 1.6, None, [3.0, 1.0, 0.2], 0.0);
    add(Vec3::new(-0.2, -0.24, -0.1), 1.5, Some(0.2), [0.0; 3], 0.0);
    add(Vec3::new(0.25, -0.2, 0.0), 1.7, None, [0.0; 3], 1.5);
    stage.add(
        turned(rectangle(
            Vec3::new(0.8, -0.6, 1.0),
            Vec3::new(1.8, 0.6, 1.0),
        )),
        lamp([4.0; 3]),
    );
    // Under the liquid, where light is chosen that is weakened on its way.
    stage.add(
        turned(rectangle(
            Vec3::new(0.1, 0.2, -0.5),
            Vec3::new(0.4, 0.45, -0.5),
        )),
        lamp([8.0; 3]),
    );
    stage.scene.environment = Some(sky());
    let mut view = stage.view(SIZE);
    view.max_depth = 12;
    view.camera.world_from_camera =
        Affine3A::from_rotation_x(0.3) * Affine3A::from_translation(Vec3::Z * 4.0);
    stage.pack_view(&view)
}

#[test]
fn media_agree_with_the_reference() {
    let packed = aquarium();
    let settings = whole(&packed, SAMPLES);
    let ours = on_gpu(&mut common::gpu(), &packed, &settings);
    println!(
        "{}",
        assert_parity("aquarium", &ours, &on_cpu(&packed, &settings))
    );
}

/// A smooth, a rough and a hazy pane, one behind the other over a floor, under a lamp, a point light and a sky.
fn greenhouse() -> Packed {
    let mut stage = Stage::default();
    stage.add(wide(-1.0), lambertian([0.8, 0.6, 0.4]));
    let mut add = |z: f32, turn: f32, roughness: f32, transmission: f32| {
        let mut mesh = rectangle(Vec3::new(-0.6, -0.6, z), Vec3::new(0.35, 0.35, z));
        let turn = Affine3A::from_rotation_x(turn);
        for primitive in &mut mesh.primitives {
            let positions = primitive.positions.iter_mut();
            positions.for_each(|p| *p = turn.transform_point3(*p));
            let normals = primitive.normals.iter_mut();
            normals.for_each(|n| *n = turn.transform_vector3(*n));
        }
        let mut pane = crate::panes::pane();
        if let Model::MetallicRoughness(m) = &mut pane.model {
            m.roughness = roughness;
            m.extensions.transmission = transmission.into();
        }
        stage.add(mesh, pane);
    };
    add(0.0, 0.5, 0.0, 1.0);
    add(-0.2, -0.6, 0.4, 1.0);
    add(-0.4, 0.1, 0.0, 0.6);
    add(0.4, 0.8, 0.0, 1.0);
    stage.add(
        turned(rectangle(
            Vec3::new(0.5, -0.6, 1.0),
            Vec3::new(1.5, 0.6, 1.0),
        )),
        lamp([4.0; 3]),
    );
    crate::panes::point_light(&mut stage, DVec3::new(-0.5, 0.3, 1.5));
    stage.scene.environment = Some(sky());
    let mut view = stage.view(SIZE);
    // Fewer than the panes in a row.
    view.max_depth = 3;
    stage.pack_view(&view)
}

#[test]
fn panes_agree_with_the_reference() {
    let packed = greenhouse();
    let settings = whole(&packed, SAMPLES);
    let ours = on_gpu(&mut common::gpu(), &packed, &settings);
    println!(
        "{}",
        assert_parity("greenhouse", &ours, &on_cpu(&packed, &settings))
    );
}

#[test]
fn breaks_of_panes_are_seen() {
    let broken = |name, kernel, from, to| Break {
        name,
        kernel,
        from,
        to,
    };
    assert_seen(
        &greenhouse(),
        &[
            broken(
                "panes are forgotten",
                SHADE,
                "path.ray.t_min = hit.t;",
                "path.ray.t_min = 0.0;",
            ),
            broken(
                "panes are where rays begin anew",
                SHADE,
                "if THIN_WALLS && sample.delta == DELTA_STRAIGHT {",
                "if false {",
            ),
            broken(
                "panes block chosen light",
                SHADOW,
                "(material.flags & MATERIAL_THIN_WALLED) == 0u",
                "true",
            ),
            broken(
                "panes do not tint chosen light",
                SHADOW,
                "passed *= straight_transmittance(",
                "passed *= 1.0 + 0.0 * straight_transmittance(",
            ),
            broken(
                "chosen light passes too many panes",
                SHADOW,
                "frame.max_depth - 1u - bounce",
                "frame.max_depth",
            ),
        ],
    );
}

/// A kernel's text in which `from`, which stands there once, is `to`.
struct Break {
    name: &'static str,
    kernel: [&'static str; 2],
    from: &'static str,
    to: &'static str,
}

const SHADE: [&str; 2] = ["shade", "shade_kernel"];
const SHADOW: [&str; 2] = ["trace_shadow", "trace_shadow_kernel"];

/// Each break must change the picture.
fn assert_seen(packed: &Packed, breaks: &[Break]) {
    let settings = whole(packed, SAMPLES);
    let reference = on_cpu(packed, &settings);
    let mut gpu = common::gpu();
    let variants = Variants::of(&Outline::of(packed), &gpu.constants());
    let mut unseen = Vec::new();
    for Break {
        name,
        kernel: [module, entry],
        from,
        to,
    } in breaks
    {
        let mut linked = link(&format!("kernels/{module}")).unwrap();
        assert_eq!(linked.text.matches(from).count(), 1, "{name}: `{from}`");
        linked.text = linked.text.replace(from, to);
        let all: Vec<&Constants> = match *module {
            "shade" => {
                let hit = variants
                    .classes
                    .iter()
                    .filter(|(class, _)| *class != CLASS_MISS);
                hit.map(|(_, constants)| constants).collect()
            }
            _ => vec![&variants.scene],
        };
        let sound: Vec<_> = all
            .iter()
            .map(|constants| Kernel::of_renderer(&gpu, module, entry, constants).unwrap())
            .collect();
        for constants in &all {
            let broken = Kernel::with_constants(&gpu, &linked, entry, constants).unwrap();
            Arc::new(broken).keep(&gpu, module, entry, constants);
        }
        let broken = on_gpu(&mut gpu, packed, &settings);
        for (sound, constants) in sound.iter().zip(&all) {
            sound.keep(&gpu, module, entry, constants);
        }
        let floor = 1e-3 * reference.average();
        let within = relative_within(&broken, &reference, 1e-3, floor).fraction;
        println!("{name}: {:.1} % of pixels differ", 100.0 * (1.0 - within));
        if within > 1.0 - SEEN_BROKEN {
            unseen.push(*name);
        }
    }
    assert!(unseen.is_empty(), "unseen: {unseen:?}");
}

#[test]
fn breaks_of_media_are_seen() {
    let shade = |name, from, to| Break {
        name,
        kernel: SHADE,
        from,
        to,
    };
    assert_seen(
        &aquarium(),
        &[
            shade(
                "light grows on its way",
                "materials[media.x].absorption * distance",
                "materials[media.x].absorption * -distance",
            ),
            shade(
                "the lighter medium has the place",
                "return ior_a > ior_b ||",
                "return ior_a < ior_b ||",
            ),
            shade(
                "hidden boundaries are shown",
                "if far.x == media.x {",
                "if far.x != media.x {",
            ),
            shade(
                "a body is never left",
                "return media_without(media, material_index);",
                "return media;",
            ),
            shade(
                "media are not stored",
                "vec4(path.media, bitcast<u32>(path.wavelength))",
                "vec4(MEDIA_NONE, bitcast<u32>(path.wavelength))",
            ),
            shade(
                "a wavelength at each boundary",
                "boundary.dispersive != 0u && path.wavelength == 0.0",
                "boundary.dispersive != 0u",
            ),
            shade(
                "indices without their wavelength",
                "return ior_at(materials[media.x].ior, materials[media.x].dispersion, wavelength);",
                "return materials[media.x].ior;",
            ),
            shade(
                "no colour below zero goes on",
                "if all(path.beta == vec3(0.0)) {",
                "if any(path.beta < vec3(0.0)) {",
            ),
            shade(
                "chosen light is not weakened",
                "L *= transmittance(",
                "L *= 1.0 + 0.0 * transmittance(",
            ),
        ],
    );
}
