//! Many lights: the tree that chooses among them, on lavapipe and in the reference.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

mod common;
#[path = "common/picture.rs"]
mod picture;

use common::shapes::{Random, flat, grid, instance, material, scene};
use common::statistics::{assert_p, chi_square_p};
use glam::{Affine3A, DVec2, DVec3, Vec3};
use picture::{assert_parity, on_cpu, on_gpu, packed, whole};
use snell::compare::z_test;
use snell::cpu::light::light::{light_pdf_triangle, light_sample};
use snell::cpu::light::tree::{light_share, tree_pick, tree_probability};
use snell::film::Film;
use snell::pack::Packed;
use snell::pack::light_tree::TREE_LIGHTS_MIN;
use snell::scene::{Environment, PunctualKind, PunctualLight, Scene};
use snell::shared::{LIGHT_CLUSTER, LIGHT_TRIANGLE, Light};

/// A floor, two placings of a soup of 40 shining triangles, 60 point lights, and a grey sky.
fn many_lights() -> Scene {
    let mut random = Random(31);
    let soup: Vec<[Vec3; 3]> = (0..40)
        .map(|_| {
            let p = random.cube();
            [0, 1, 2].map(|_| p + 0.2 * random.direction())
        })
        .collect();
    let mut shining = flat(&soup);
    shining.primitives[0].material = 1;
    let up = |x: f32| Affine3A::from_translation(Vec3::new(x, 1.3, 0.0));
    let mut scene = scene(
        vec![grid(2, |_, _| 0.0), shining],
        vec![
            instance(0, Affine3A::from_scale(Vec3::splat(3.0))),
            instance(1, up(-1.0)),
            instance(1, up(1.5)),
        ],
    );
    let mut lamp = material();
    lamp.emissive = Vec3::new(4.0, 5.0, 6.0);
    scene.materials.push(lamp);
    scene.lights = (0..60)
        .map(|_| PunctualLight {
            name: String::new(),
            kind: PunctualKind::Point,
            intensity: Vec3::splat(0.05 + random.unit().powi(6)),
            position: 2.0 * random.cube() + 2.2 * Vec3::Y,
            direction: Vec3::NEG_Y,
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
    assert_eq!(in_tree(&tree).count(), 140);
    assert_eq!(tree.frame.light_tree_leaves, 256);
    let weight: f32 = in_tree(&tree).map(|(_, light)| light.weight).sum();
    assert!((tree.lights[1].weight - weight).abs() < 1e-4 * weight);
    scene.instances.truncate(1);
    scene.lights.truncate(TREE_LIGHTS_MIN - 1);
    let table = packed(&scene, [8, 8]);
    assert_eq!(table.frame.light_tree_leaves, 0);
    assert_eq!(table.frame.light_count as usize, table.lights.len());
}

#[test]
fn every_light_has_a_probability_and_their_sum_is_one() {
    let packed = packed(&many_lights(), [8, 8]);
    for p in places(&mut Random(32), 200) {
        let each =
            in_tree(&packed).map(|(_, light)| tree_probability(&packed, p, light.alias_index));
        let sum: f64 = each.inspect(|&one| assert!(one > 0.0)).sum();
        assert!((sum - 1.0).abs() < 1e-12, "at {p}: {sum}");
    }
}

#[test]
fn picks_follow_their_probability() {
    let packed = packed(&many_lights(), [8, 8]);
    let mut random = Random(33);
    let first = packed.frame.light_count;
    let draws = 400_000;
    for p in [
        DVec3::ZERO,
        DVec3::new(1.2, 1.0, 0.3),
        DVec3::new(50.0, 0.0, 0.0),
    ] {
        let mut observed = vec![0.0; in_tree(&packed).count()];
        for _ in 0..draws {
            let pick = tree_pick(&packed, p, random.unit().into(), random.bits() as u32);
            let leaf = packed.lights[pick.index as usize].alias_index;
            let probability = tree_probability(&packed, p, leaf);
            assert!((pick.p - probability).abs() < 1e-12 * probability);
            observed[(pick.index - first) as usize] += 1.0;
        }
        let expected: Vec<f64> = in_tree(&packed)
            .map(|(_, light)| f64::from(draws) * tree_probability(&packed, p, light.alias_index))
            .collect();
        assert_p(&format!("at {p}"), chi_square_p(&observed, &expected), 3);
    }
}

#[test]
fn a_samples_pdf_is_the_density_of_what_it_meets() {
    let packed = packed(&many_lights(), [8, 8]);
    let mut random = Random(34);
    let mut met = 0;
    for p in places(&mut Random(35), 20_000) {
        let u = DVec2::new(random.unit().into(), random.unit().into());
        let s = light_sample(&packed, p, DVec3::Y, true, random.unit().into(), u, 0.0);
        // Which of the triangles it is on, by its place.
        let target = p + s.distance * s.wi;
        let on = in_tree(&packed).find(|(_, light)| {
            let [p0, e1, e2] =
                [light.position, light.direction, light.edge2].map(|v| Vec3::from(v).as_dvec3());
            let (n, d) = (e1.cross(e2), target - p0);
            let (b1, b2) = (d.cross(e2).dot(n), e1.cross(d).dot(n));
            light.kind == LIGHT_TRIANGLE
                && d.dot(n).abs() < 1e-9 * n.length()
                && b1.min(b2) >= 0.0
                && b1 + b2 <= n.length_squared()
        });
        let (Some((_, light)), 0) = (on, s.delta) else {
            continue;
        };
        met += 1;
        let [e1, e2] = [light.direction, light.edge2].map(|v| Vec3::from(v).as_dvec3());
        let n = e1.cross(e2);
        let material = packed.triangles[light.triangle as usize].material;
        let expected = light_pdf_triangle(
            light_share(&packed, p, light.instance, light.triangle),
            packed.materials[material as usize].emission_weight.into(),
            s.distance,
            n.dot(s.wi).abs() / n.length(),
        );
        assert!(
            (s.pdf - expected).abs() < 1e-6 * expected,
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
    let few = packed(&lamp(2), [24, 24]);
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

#[test]
fn the_renderers_choose_alike() {
    let packed = packed(&many_lights(), [32, 32]);
    let samples = whole(&packed, 4);
    let mut gpu = common::gpu();
    let line = assert_parity(
        "many_lights",
        &on_gpu(&mut gpu, &packed, &samples),
        &on_cpu(&packed, &samples),
    );
    println!("{line}");
}
