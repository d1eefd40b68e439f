//! Walls too thin to bend light: smooth ones let chosen light through, tinted.

use crate::common::shapes;
use crate::stage::{SEEN, Stage, films, lambertian, lamp, rectangle, slab, turned, wide};
use crate::{PANEL, REFLECTANCE, single};
use glam::{DVec3, Vec3};
use snell::cpu::ray::Ray;
use snell::cpu::visibility::visibility;
use snell::pack::Background;
use snell::scene::{Environment, Material, Mesh, Model, PunctualKind, PunctualLight};
use std::f64::consts::FRAC_1_PI;

const IOR: f64 = 1.5;
const TINT: [f64; 3] = [0.9, 0.5, 0.3];

pub fn pane() -> Material {
    let mut pane = shapes::material();
    if let Model::MetallicRoughness(m) = &mut pane.model {
        m.base_color = Vec3::from_array(single(TINT)).extend(1.0);
        m.roughness = 0.0;
        m.ior = IOR as f32;
        m.extensions.transmission = 1.0.into();
    }
    pane
}

/// What the pane passes (KHR_materials_transmission: base colour times what is not reflected, once).
fn passed(cos: f64, channel: usize) -> f64 {
    // Fresnel's equations in the angles (Born and Wolf 1999, section 1.5.2).
    let outside = cos.min(1.0).acos();
    let inside = (outside.sin() / IOR).asin();
    let reflected = match outside {
        ..1e-6 => ((IOR - 1.0) / (IOR + 1.0)).powi(2),
        _ => {
            let (difference, sum) = (outside - inside, outside + inside);
            0.5 * ((difference.sin() / sum.sin()).powi(2) + (difference.tan() / sum.tan()).powi(2))
        }
    };
    TINT[channel] * (1.0 - reflected)
}

#[test]
fn a_pane_tints_what_is_behind_it() {
    for tilt in [0.0f32, 1.3] {
        let mut stage = Stage::default();
        // Too narrow to be seen in the pane.
        stage.add(
            rectangle(Vec3::new(-1.0, -1.0, -5.0), Vec3::new(1.0, 1.0, -5.0)),
            lamp(single(PANEL)),
        );
        let mut tilted = wide(0.0);
        let turn = glam::Quat::from_rotation_y(tilt);
        for primitive in &mut tilted.primitives {
            primitive.positions.iter_mut().for_each(|p| *p = turn * *p);
            primitive.normals.iter_mut().for_each(|n| *n = turn * *n);
        }
        stage.add(tilted, pane());
        let expected = [0, 1, 2].map(|c| PANEL[c] * passed(f64::from(tilt).cos(), c));
        stage.check(&format!("a pane tilted by {tilt}"), 512, 5e-3, |_, _| {
            Some((0, expected))
        });
    }
}

/// A wall between all that the camera sees of the floor and what shines from x > 0.65.
fn add_panes(stage: &mut Stage, places: &[f32]) {
    for &x in places {
        let corner = |y: f32, z: f32| Vec3::new(x, y, z);
        let (a, b) = (corner(-40.0, -1.0), corner(40.0, -1.0));
        let (c, d) = (corner(40.0, 80.0), corner(-40.0, 80.0));
        stage.add(shapes::flat(&[[a, b, c], [a, c, d]]), pane());
    }
}

/// A floor, `panes` beside it, and no more bounces than light needs that passes `passes` of them.
fn floor_beside(panes: &[f32], passes: u32) -> Stage {
    let mut stage = Stage::default();
    // Single-sided, so that it does not close what lies below.
    stage.add(wide(0.0), lambertian(single(REFLECTANCE)));
    add_panes(&mut stage, panes);
    stage.max_depth = Some(1 + passes);
    stage
}

pub fn point_light(stage: &mut Stage, place: DVec3) {
    stage.scene.lights.push(PunctualLight {
        name: String::new(),
        kind: PunctualKind::Point,
        intensity: Vec3::ONE,
        position: place.as_vec3(),
        direction: Vec3::NEG_Z,
        range: None,
    });
}

const PLACE: DVec3 = DVec3::new(1.2, 0.3, 0.8);

/// The floor under the point light behind this many panes.
fn under_point(x: f64, y: f64, panes: i32) -> [f64; 3] {
    let d = PLACE - DVec3::new(SEEN * x, SEEN * y, 0.0);
    let r = d.length();
    [0, 1, 2].map(|c| REFLECTANCE[c] * FRAC_1_PI * d.z / r.powi(3) * passed(d.x / r, c).powi(panes))
}

#[test]
fn a_point_light_shines_through_panes() {
    for (panes, count) in [(&[0.65f32][..], 1), (&[0.65, 0.8], 2)] {
        let mut stage = floor_beside(panes, count as u32);
        point_light(&mut stage, PLACE);
        stage.check(&format!("{count} panes"), 64, 1e-3, |x, y| {
            Some((0, under_point(x, y, count)))
        });
    }
}

fn add_lamp(stage: &mut Stage, lower: DVec3, upper: DVec3) {
    let mesh: Mesh = turned(rectangle(lower.as_vec3(), upper.as_vec3()));
    stage.add(mesh, lamp([1.0; 3]));
}

/// Light that is chosen and light that is found through the pane add up to all of it: near the lamp the
/// one counts, and the other where the lamp fills the view.
#[test]
fn chosen_and_found_light_through_a_pane_add_up() {
    let (lower, upper) = (DVec3::new(0.7, -1.5, 0.6), DVec3::new(2.7, 1.5, 0.6));
    let mut stage = floor_beside(&[0.65], 1);
    add_lamp(&mut stage, lower, upper);
    const CELLS: u32 = 32;
    stage.check("a lamp behind a pane", 512, 4e-3, |x, y| {
        let p = DVec3::new(SEEN * x, SEEN * y, 0.0);
        let step = (upper - lower) / f64::from(CELLS);
        let mut radiance = [0.0; 3];
        for (i, j) in (0..CELLS).flat_map(|i| (0..CELLS).map(move |j| (i, j))) {
            let at = DVec3::new(f64::from(i) + 0.5, f64::from(j) + 0.5, 0.0);
            let d = lower + step * at - p;
            let r = d.length();
            for (c, radiance) in radiance.iter_mut().enumerate() {
                *radiance += (d.z / r).powi(2) / (r * r) * passed(d.x / r, c);
            }
        }
        let scale = FRAC_1_PI * step.x * step.y;
        Some((0, [0, 1, 2].map(|c| REFLECTANCE[c] * scale * radiance[c])))
    });
}

/// Where the bounces end, they end for chosen and for found light alike.
#[test]
fn no_light_passes_more_panes_than_there_are_bounces() {
    for (passes, arrives) in [(1, false), (2, true)] {
        let mut stage = floor_beside(&[0.65, 0.68], passes);
        point_light(&mut stage, PLACE);
        add_lamp(
            &mut stage,
            DVec3::new(0.7, -1.5, 0.6),
            DVec3::new(2.7, 1.5, 0.6),
        );
        for (renderer, film) in films(&stage.pack([8, 8]), 64) {
            assert_eq!(!film.is_black(), arrives, "{passes} passes on {renderer}");
        }
    }
}

/// A floor under a pane and an even sky: the sky is seen in the pane, and lights the floor through it.
#[test]
fn the_sky_shines_through_a_pane() {
    let mut stage = Stage::default();
    // So wide that next to nothing gets past their edges.
    let wide = |z| rectangle(Vec3::new(-300.0, -300.0, z), Vec3::new(300.0, 300.0, z));
    stage.add(wide(0.0), lambertian(single(REFLECTANCE)));
    stage.add(wide(0.3), pane());
    stage.scene.environment = Some(Environment {
        width: 4,
        height: 2,
        radiance: vec![[1.0; 3]; 8],
        strength: 1.0,
        rotation: 0.0,
    });
    // The pane, the floor, and the pane again.
    stage.max_depth = Some(3);
    const STEPS: u32 = 2000;
    let expected = [0, 1, 2].map(|c| {
        // In cos^2 theta the cosine-weighted hemisphere is even.
        let steps = (0..STEPS).map(|i| ((f64::from(i) + 0.5) / f64::from(STEPS)).sqrt());
        let floor =
            REFLECTANCE[c] * steps.map(|cos| passed(cos, c)).sum::<f64>() / f64::from(STEPS);
        (1.0 - passed(1.0, c) / TINT[c]) + passed(1.0, c) * floor
    });
    stage.check("a floor under a pane", 1024, 5e-3, |_, _| {
        Some((0, expected))
    });
}

/// Chosen light passes smooth walls alone: what comes through rough ones and into media is bent, and comes
/// by the path.
#[test]
fn only_smooth_walls_let_chosen_light_through() {
    let ray = Ray {
        origin: DVec3::new(0.1, 0.2, 3.0),
        t_min: 0.0,
        direction: DVec3::new(0.6, 0.0, -0.8),
        t_max: 5.0,
        time: 0.0,
    };
    let through = |scene: &dyn Fn(&mut Stage)| {
        let mut stage = Stage::default();
        scene(&mut stage);
        visibility(&stage.pack([1, 1]), ray, 1.0, 2, 7)
    };
    let tinted = DVec3::from_array([0, 1, 2].map(|c| passed(0.8, c)));
    let near = |a: DVec3, b: DVec3| assert!(a.abs_diff_eq(b, 1e-6), "{a} is not {b}");
    let add = |stage: &mut Stage, z: f32| _ = stage.add(wide(z), pane());
    near(through(&|stage| add(stage, 1.0)), tinted);
    near(
        through(&|stage| [1.0, 0.0].map(|z| add(stage, z)).into_iter().collect()),
        tinted * tinted,
    );
    // Beyond the ray's end, and more than it may pass.
    near(through(&|stage| add(stage, -2.0)), DVec3::ONE);
    let three = |stage: &mut Stage| [1.0, 0.0, 0.5].map(|z| add(stage, z)).into_iter().collect();
    near(through(&three), DVec3::ZERO);
    let behind_floor = |stage: &mut Stage| {
        add(stage, 1.0);
        stage.add(wide(0.5), lambertian([1.0; 3]));
    };
    near(through(&behind_floor), DVec3::ZERO);
    let rough = |stage: &mut Stage| {
        let mut rough = pane();
        if let Model::MetallicRoughness(m) = &mut rough.model {
            m.roughness = 0.3;
        }
        stage.add(wide(1.0), rough);
    };
    near(through(&rough), DVec3::ZERO);
    let medium = |stage: &mut Stage| _ = stage.add_medium(slab(0.0, 1.0), 1.0, [0.0; 3]);
    near(through(&medium), DVec3::ZERO);
    // In a liquid of the pane's own index nothing is reflected.
    let mut stage = Stage::default();
    add(&mut stage, 1.0);
    let in_liquid = visibility(&stage.pack([1, 1]), ray, IOR, 2, 7);
    near(in_liquid, DVec3::from_array(TINT));
}

/// What lies behind glass is no background: a picture with a transparent one is opaque there, and shows
/// the environment.
#[test]
fn a_pane_is_opaque_to_the_background() {
    let mut stage = Stage::default();
    let half = rectangle(Vec3::new(-9.0, -9.0, 0.0), Vec3::new(0.0, 9.0, 0.0));
    stage.add(half, pane());
    let mut view = stage.view([16, 16]);
    view.background = Background::Transparent;
    for (renderer, film) in films(&stage.pack_view(&view), 16) {
        let alpha = |x: u32| film.pixel(x, 8).coverage();
        assert_eq!((alpha(2), alpha(13)), (1.0, 0.0), "{renderer}");
    }
}
