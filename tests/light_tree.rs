//! Many lights: the tree that chooses among them, on lavapipe and in the reference.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod common;
#[path = "common/picture.rs"]
mod picture;

use common::shapes::{Random, flat, grid, instance, material, scene, sphere, two_levels};
use common::statistics::{assert_p, chi_square_p};
use glam::{Affine3A, DVec2, DVec3, Vec3};
use picture::{assert_parity, on_cpu, on_gpu, packed, whole};
use snell::compare::z_test;
use snell::cpu::light::light::{light_pdf_triangle, light_sample};
use snell::cpu::light::tree::{
    light_node, light_of_leaf, light_share, tree_importance, tree_pick, tree_probability,
};
use snell::cpu::light::triangle::{cos_emission, light_at, light_normal};
use snell::cpu::sample::sample_triangle;
use snell::film::Film;
use snell::pack::Packed;
use snell::pack::light_tree::TREE_LIGHTS_MIN;
use snell::pack::lights::alias_table;
use snell::scene::{Environment, Model, PunctualKind, PunctualLight, Scene};
use snell::shared::{
    INSTANCE_KEYS_SHIFT, LIGHT_CLUSTER, LIGHT_POINT, LIGHT_SPOT, LIGHT_TRIANGLE, Light, LightNode,
};

/// A floor and a sky; a soup of 40 shining triangles placed as it is and mirrored, another that shines from both
/// sides, and one that turns; 30 point lights and 30 spots.
fn many_lights() -> Scene {
    let mut random = Random(31);
    let mut soup = || {
        let triangles: Vec<[Vec3; 3]> = (0..40)
            .map(|_| {
                let p = random.cube();
                [0, 1, 2].map(|_| p + 0.2 * random.direction())
            })
            .collect();
        flat(&triangles)
    };
    let (mut one_sided, mut two_sided) = (soup(), soup());
    one_sided.primitives[0].material = 1;
    two_sided.primitives[0].material = 2;
    let up = |x: f32| Affine3A::from_translation(Vec3::new(x, 1.3, 0.0));
    let mut turning = instance(1, up(0.0));
    turning.motion = [up(0.3) * Affine3A::from_rotation_x(1.0)].into();
    let mut scene = scene(
        vec![grid(2, |_, _| 0.0), one_sided, two_sided],
        vec![
            instance(0, Affine3A::from_scale(Vec3::splat(3.0))),
            instance(1, up(-1.0)),
            instance(1, up(1.5) * Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0))),
            instance(2, up(-2.5)),
            turning,
        ],
    );
    for double_sided in [false, true] {
        let mut lamp = material();
        lamp.double_sided = double_sided;
        lamp.emissive = Vec3::new(4.0, 5.0, 6.0);
        scene.materials.push(lamp);
    }
    scene.lights = (0..60)
        .map(|number| PunctualLight {
            name: String::new(),
            kind: match number % 2 {
                0 => PunctualKind::Point,
                _ => PunctualKind::Spot {
                    inner_angle: 0.3,
                    outer_angle: 0.7,
                },
            },
            intensity: Vec3::splat(0.05 + random.unit().powi(6)),
            position: 2.0 * random.cube() + 2.2 * Vec3::Y,
            direction: random.direction(),
            range: None,
        })
        .collect();
    scene.environment = Some(Environment {
        width: 1,
        height: 1,
        radiance: vec![[0.2; 3]],
        strength: 1.0,
        rotation: 0.0,
    });
    scene
}

/// The same lights, chosen by the table of their weights alone.
fn by_table(packed: &Packed) -> Packed {
    let mut table = packed.clone();
    table.lights.retain(|light| light.kind != LIGHT_CLUSTER);
    let weights: Vec<f64> = (table.lights.iter())
        .map(|light| light.weight.into())
        .collect();
    for (light, (index, threshold)) in table.lights.iter_mut().zip(alias_table(&weights)) {
        light.alias_index = index;
        light.alias_threshold = threshold;
    }
    table.frame.light_count = table.lights.len() as u32;
    table.frame.light_tree_leaves = 0;
    table.frame.light_tree_triangles = 0;
    table.light_nodes.truncate(1);
    table
}

fn in_tree(packed: &Packed) -> impl Iterator<Item = (u32, &Light)> {
    let first = packed.frame.light_count;
    (first..).zip(&packed.lights[first as usize..])
}

fn places(random: &mut Random, count: usize) -> Vec<DVec3> {
    let mut places: Vec<DVec3> = (0..count)
        .map(|_| (3.0 * random.cube() + Vec3::Y).as_dvec3())
        .collect();
    places.push(DVec3::ZERO);
    places
}

#[test]
fn a_tree_is_there_from_enough_lights_on() {
    let mut scene = many_lights();
    let tree = packed(&scene, [8, 8]);
    assert_eq!(tree.frame.light_count, 2, "the sky, and one for all others");
    assert_eq!(tree.lights[1].kind, LIGHT_CLUSTER);
    assert_eq!(in_tree(&tree).count(), 220);
    assert_eq!(tree.frame.light_tree_leaves, 256);
    let weight: f32 = in_tree(&tree).map(|(_, light)| light.weight).sum();
    assert!((tree.lights[1].weight - weight).abs() < 1e-4 * weight);
    scene.instances.truncate(1);
    scene.lights.truncate(TREE_LIGHTS_MIN - 1);
    let table = packed(&scene, [8, 8]);
    assert_eq!(table.frame.light_tree_leaves, 0);
    assert_eq!(table.frame.light_count as usize, table.lights.len());
}

/// The probability with which the walk from the root comes to a leaf.
fn walked(packed: &Packed, p: DVec3, ns: DVec3, transmits: bool, leaf: u32) -> f64 {
    let mut node = leaf;
    let mut probability = 1.0;
    while node > 1 {
        let received = |node: u32| {
            tree_importance(&packed.light_nodes[node as usize], p, ns, transmits).received
        };
        let own = received(node);
        probability *= own / (own + received(node ^ 1));
        node /= 2;
    }
    probability
}

#[test]
fn every_light_has_a_probability_and_their_sum_is_one() {
    let packed = packed(&many_lights(), [8, 8]);
    let mut random = Random(32);
    for p in places(&mut random, 200) {
        let ns = random.direction().as_dvec3();
        for transmits in [false, true] {
            let each = in_tree(&packed)
                .map(|(_, light)| walked(&packed, p, ns, transmits, light.alias_index));
            let sum: f64 = each.inspect(|&one| assert!(one > 0.0)).sum();
            assert!((sum - 1.0).abs() < 1e-12, "at {p}: {sum}");
        }
    }
}

#[test]
fn picks_follow_their_probability() {
    let packed = packed(&many_lights(), [8, 8]);
    let mut random = Random(33);
    let first = packed.frame.light_count;
    let draws = 400_000;
    for (p, ns, transmits) in [
        (DVec3::ZERO, DVec3::Y, false),
        (DVec3::new(1.2, 1.0, 0.3), DVec3::NEG_X, false),
        (DVec3::new(1.2, 1.0, 0.3), DVec3::NEG_X, true),
        (DVec3::new(50.0, 0.0, 0.0), DVec3::new(0.0, 0.8, 0.6), false),
    ] {
        let mut observed = vec![0.0; in_tree(&packed).count()];
        for _ in 0..draws {
            let u = random.unit().into();
            let pick = tree_pick(&packed, p, ns, transmits, u, random.bits() as u32);
            let leaf = packed.lights[pick.index as usize].alias_index;
            let by_sent = tree_probability(&packed, p, leaf);
            let taken = walked(&packed, p, ns, transmits, leaf);
            assert!((pick.p - by_sent).abs() < 1e-12 * by_sent);
            assert!((pick.weight - by_sent / taken).abs() < 1e-9 * pick.weight);
            assert!(!transmits || (pick.weight - 1.0).abs() < 1e-12);
            observed[(pick.index - first) as usize] += 1.0;
        }
        let expected: Vec<f64> = in_tree(&packed)
            .map(|(_, light)| walked(&packed, p, ns, transmits, light.alias_index))
            .map(|probability| f64::from(draws) * probability)
            .collect();
        assert_p(&format!("at {p}"), chi_square_p(&observed, &expected), 4);
    }
}

/// One light's place among the leaves is empty, and one light is dark: what is left of a number near 1 must not
/// be rounded past them.
#[test]
fn nothing_without_light_is_chosen() {
    let mut scene = many_lights();
    scene.instances.truncate(1);
    scene.lights.truncate(7);
    scene.lights[3].intensity = Vec3::ZERO;
    let packed = packed(&scene, [8, 8]);
    assert_eq!(packed.frame.light_tree_leaves, 8);
    let mut random = Random(38);
    for p in places(&mut random, 20_000) {
        let ns = random.direction().as_dvec3();
        for u in [0.0, 1.0 - f64::EPSILON / 2.0, 1.0 - f64::from(f32::EPSILON)] {
            let pick = tree_pick(&packed, p, ns, false, u, 0);
            assert!(pick.p > 0.0 && pick.weight > 0.0, "at {p}: {pick:?}");
            assert!(packed.lights[pick.index as usize].weight > 0.0, "{pick:?}");
        }
    }
}

#[test]
fn nodes_are_around_their_lights_and_face_as_they_do() {
    // Baked, what is mirrored is mirrored in its mesh.
    for scene in [many_lights(), two_levels(many_lights())] {
        let packed = packed(&scene, [8, 8]);
        let mut random = Random(36);
        let mut seen = [0; 3];
        for (index, light) in in_tree(&packed) {
            assert_eq!(light_of_leaf(&packed, light.alias_index), index);
            let leaf = light_node(&packed, light.alias_index);
            let instance = &packed.instances[light.instance as usize];
            let facing = match light.kind {
                LIGHT_POINT => DVec3::ZERO,
                LIGHT_SPOT => Vec3::from(light.direction).as_dvec3(),
                _ if instance.flags >> INSTANCE_KEYS_SHIFT != 0 => DVec3::ZERO,
                _ => {
                    let at = light_at(&packed, light, 0.0);
                    let (front, back) = (
                        cos_emission(&packed, &at, 1.0),
                        cos_emission(&packed, &at, -1.0),
                    );
                    (front - back) * light_normal(&packed, &at, 0.0)
                }
            };
            seen[(light.kind == LIGHT_TRIANGLE) as usize + (facing == DVec3::ZERO) as usize] += 1;
            let error = Vec3::from(leaf.facing).as_dvec3().distance(facing);
            assert!(error < 1e-5, "{light:?}: {leaf:?}, not {facing}");
            for _ in 0..8 {
                let place = match light.kind {
                    LIGHT_TRIANGLE => {
                        let at = light_at(&packed, light, random.unit().into());
                        let u = DVec2::new(random.unit().into(), random.unit().into());
                        let b = sample_triangle(u);
                        at.position + b.x * at.direction + b.y * at.edge2
                    }
                    _ => Vec3::from(light.position).as_dvec3(),
                };
                let mut node = light.alias_index;
                while node > 0 {
                    let around = light_node(&packed, node);
                    let away = place.distance(Vec3::from(around.centre).as_dvec3());
                    let radius = f64::from(around.radius2).sqrt();
                    assert!(away <= radius * (1.0 + 1e-5), "{light:?} and {around:?}");
                    node /= 2;
                }
            }
        }
        assert!(seen.iter().all(|&count| count >= 30), "{seen:?}");
        for node in 1..packed.frame.light_tree_leaves {
            let [left, right] = [2 * node, 2 * node + 1].map(|child| light_node(&packed, child));
            let node = light_node(&packed, node);
            assert!((node.weight - left.weight - right.weight).abs() <= 1e-5 * node.weight);
            let turned = |node: &LightNode| node.weight * Vec3::from(node.facing);
            let apart = turned(node).distance(turned(left) + turned(right));
            assert!(apart <= 1e-5 * node.weight, "{node:?}");
        }
    }
}

/// Under a ball of lamps with nothing in the way: were the walk's probabilities in proportion to what each lamp
/// brings, an estimate would have no variance.
#[test]
fn the_walk_goes_where_the_light_comes_from() {
    let mut ball = sphere(24, 0.5);
    ball.primitives[0].material = 1;
    let mut scene = scene(
        vec![grid(2, |_, _| 0.0), ball],
        vec![
            instance(0, Affine3A::from_scale(Vec3::splat(3.0))),
            instance(1, Affine3A::from_translation(1.5 * Vec3::Y)),
        ],
    );
    let mut lamp = material();
    lamp.double_sided = false;
    lamp.emissive = Vec3::ONE;
    scene.materials.push(lamp);
    let packed = packed(&scene, [8, 8]);
    let mut random = Random(37);
    let mut worst = 0.0_f64;
    for _ in 0..50 {
        let p = 2.0 * Vec3::new(random.unit() - 0.5, 0.0, random.unit() - 0.5).as_dvec3();
        // The variance of an estimate of the irradiance by the middle of one triangle.
        let (mut mean, mut square) = (0.0, 0.0);
        for (_, light) in in_tree(&packed) {
            let at = light_at(&packed, light, 0.0);
            let to_light = at.position + (at.direction + at.edge2) / 3.0 - p;
            let wi = to_light.normalize();
            let cosine = cos_emission(&packed, &at, -wi.dot(light_normal(&packed, &at, 0.0)));
            let received =
                f64::from(light.weight) * cosine * wi.y.max(0.0) / to_light.length_squared();
            mean += received;
            square += received * received / walked(&packed, p, DVec3::Y, false, light.alias_index);
        }
        let variance = square / (mean * mean) - 1.0;
        worst = worst.max(variance);
    }
    println!("variance of one sample's irradiance over its square, at worst: {worst}");
    assert!((0.0..0.25).contains(&worst), "{worst}");
}

#[test]
fn a_samples_pdf_is_the_density_of_what_it_meets() {
    let packed = packed(&many_lights(), [8, 8]);
    let mut random = Random(34);
    let mut met = 0;
    for p in places(&mut Random(35), 20_000) {
        let u = DVec2::new(random.unit().into(), random.unit().into());
        let (ns, transmits) = (random.direction().as_dvec3(), random.below(2) == 0);
        let s = light_sample(&packed, p, ns, transmits, random.unit().into(), u, 0.0);
        // Which of the triangles it is on, by its place.
        let target = p + s.distance * s.wi;
        let triangles = in_tree(&packed).filter(|(_, light)| light.kind == LIGHT_TRIANGLE);
        let mut triangles = triangles.map(|(_, light)| light_at(&packed, light, 0.0));
        let on = triangles.find(|light| {
            let (e1, e2) = (light.direction, light.edge2);
            let (n, d) = (e1.cross(e2), target - light.position);
            let (b1, b2) = (d.cross(e2).dot(n), e1.cross(d).dot(n));
            d.dot(n).abs() < 1e-9 * n.length() && b1.min(b2) >= 0.0 && b1 + b2 <= n.length_squared()
        });
        let (Some(light), 0) = (on, s.delta) else {
            continue;
        };
        met += 1;
        let cosine = -s.wi.dot(light_normal(&packed, &light, 0.0));
        let material = packed.triangles[light.triangle as usize].material;
        let expected = light_pdf_triangle(
            light_share(&packed, p, light.instance, light.triangle),
            packed.materials[material as usize].emission_weight.into(),
            s.distance,
            cos_emission(&packed, &light, cosine),
        );
        assert!(
            (s.pdf - expected).abs() <= 1e-6 * expected,
            "{} {expected}",
            s.pdf
        );
    }
    assert!(met > 2000, "{met}");
    assert_eq!(
        light_share(&packed, DVec3::ZERO, 0, 0),
        0.0,
        "the floor is no light"
    );
}

/// A lamp over a floor, of 2 n^2 triangles; seen from the side.
fn lamp(n: u32) -> Scene {
    let mut shining = grid(n, |_, _| 0.7);
    shining.primitives[0].material = 1;
    let mut scene = scene(
        vec![grid(2, |_, _| 0.0), shining],
        vec![
            instance(0, Affine3A::from_scale(Vec3::new(2.0, 1.0, 2.0))),
            instance(1, Affine3A::IDENTITY),
        ],
    );
    let mut lamp = material();
    lamp.emissive = Vec3::ONE;
    scene.materials.push(lamp);
    scene
}

#[test]
fn a_tree_changes_no_picture() {
    // Few triangles, chosen by the table, and many of the same shape, chosen by the tree.
    let few = packed(&lamp(1), [24, 24]);
    let many = packed(&lamp(12), [24, 24]);
    assert_eq!(few.frame.light_tree_leaves, 0);
    assert_eq!(many.frame.light_tree_leaves, 512);
    let samples = whole(&few, 512);
    let (few, many) = (on_cpu(&few, &samples), on_cpu(&many, &samples));
    // The variances are not the same: the tree is there for that.
    let verdict = z_test(&few, &many, 0.01);
    assert_eq!(verdict.rejected, 0, "{verdict:?}");
    let same_mean = |p: &f64| *p > verdict.alpha_average;
    assert!(verdict.p_mean.iter().all(same_mean), "{verdict:?}");
    let noise = |film: &Film| {
        film.pixels
            .iter()
            .map(|pixel| pixel.variance()[1])
            .sum::<f64>()
    };
    println!(
        "variance by the tree over that by the table: {}",
        noise(&many) / noise(&few)
    );
    let ratio = many.average() / few.average();
    assert!((ratio - 1.0).abs() < 2e-3, "{ratio}");
}

/// Lights that face all ways, that move, and that surfaces turn away from; and points and spots alone.
#[test]
fn a_tree_changes_no_light() {
    let mut all = many_lights();
    let Model::MetallicRoughness(floor) = &mut all.materials[0].model else {
        unreachable!("it is grey");
    };
    (floor.roughness, floor.metallic) = (0.3, 0.5);
    let mut points = many_lights();
    points.instances.truncate(1);
    points.environment = None;
    for (name, scene, samples) in [("all", all, 2048), ("points", points, 512)] {
        let tree = packed(&scene, [24, 24]);
        let table = by_table(&tree);
        let (tree, table) = (
            on_cpu(&tree, &whole(&tree, samples)),
            on_cpu(&table, &whole(&table, 4 * samples)),
        );
        let verdict = z_test(&tree, &table, 0.01);
        assert_eq!(verdict.rejected, 0, "{name}: {verdict:?}");
        let same_mean = |p: &f64| *p > verdict.alpha_average;
        assert!(verdict.p_mean.iter().all(same_mean), "{name}: {verdict:?}");
    }
}

#[test]
fn the_renderers_choose_alike() {
    let mut gpu = common::gpu();
    // The second fills more than a row of the nodes' texture.
    for (name, scene) in [("many_lights", many_lights()), ("lamp", lamp(30))] {
        let packed = packed(&scene, [32, 32]);
        let samples = whole(&packed, 4);
        let line = assert_parity(
            name,
            &on_gpu(&mut gpu, &packed, &samples),
            &on_cpu(&packed, &samples),
        );
        println!("{line}");
    }
}
