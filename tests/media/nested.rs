//! Bodies in each other.

use crate::stage::{Stage, slab, turned};
use crate::{Layer, over_panel, panel_behind, single};
use glam::UVec3;
use snell::cpu::medium::{MEDIA_NONE, interface_at, media_far, media_near, media_with};
use snell::shared::NONE;

const GLASS: Layer = Layer {
    ior: 1.5,
    absorption: [0.5, 0.1, 0.3],
    thickness: 1.0,
};
const LIQUID: Layer = Layer {
    ior: 1.2,
    absorption: [0.1, 0.8, 0.6],
    thickness: 1.4,
};

fn add(stage: &mut Stage, layer: Layer, from: f32, to: f32) {
    stage.add_medium(slab(from, to), layer.ior as f32, single(layer.absorption));
}

fn check(stage: &Stage, what: &str, layers: &[Layer]) {
    let expected = panel_behind(layers);
    stage.check(what, 512, 4e-3, |_, _| Some((0, expected)));
}

/// Glass of 1 m on top of 1.4 m of liquid, which reaches a little or far into the glass.
#[test]
fn liquid_ends_where_the_glass_begins() {
    for reach in [0.1, 0.9] {
        let mut stage = over_panel();
        add(&mut stage, LIQUID, -1.4, reach);
        add(&mut stage, GLASS, 0.0, 1.0);
        check(&stage, &format!("{reach} m in the glass"), &[GLASS, LIQUID]);
    }
}

/// The same from the other side: into the liquid first, and out of the glass through its end.
#[test]
fn glass_begins_in_the_liquid() {
    let mut stage = over_panel();
    add(&mut stage, GLASS, -1.0, 0.0);
    add(&mut stage, LIQUID, -0.2, 1.4);
    check(&stage, "from above", &[LIQUID, GLASS]);
}

/// A sheet of glass inside of the liquid, and a pool that is all inside of the glass.
#[test]
fn a_body_in_another_is_seen_where_it_is_denser() {
    let mut stage = over_panel();
    add(&mut stage, LIQUID, -1.0, 1.8);
    add(&mut stage, GLASS, -0.5, 0.5);
    let part = |thickness| Layer {
        thickness,
        ..LIQUID
    };
    check(&stage, "glass in liquid", &[part(1.3), GLASS, part(0.5)]);

    let mut stage = over_panel();
    add(&mut stage, LIQUID, -0.2, 0.2);
    add(&mut stage, GLASS, -0.5, 0.5);
    check(&stage, "liquid in glass", &[GLASS]);
}

/// Of two bodies with one index the one with the later material has the place.
#[test]
fn equals_follow_the_order_of_their_materials() {
    let clear = Layer {
        absorption: [0.0, 0.2, 0.9],
        ..GLASS
    };
    let half = Layer {
        thickness: 0.5,
        ..GLASS
    };
    let mut stage = over_panel();
    add(&mut stage, half, -0.5, 0.5);
    add(&mut stage, clear, 0.0, 1.0);
    check(&stage, "the later one above", &[clear, half]);
    let mut stage = over_panel();
    add(&mut stage, clear, 0.0, 1.0);
    add(&mut stage, half, -0.5, 0.5);
    let clear = Layer {
        thickness: 0.5,
        ..clear
    };
    let half = Layer {
        thickness: 1.0,
        ..half
    };
    check(&stage, "the later one below", &[clear, half]);
}

/// A bubble is a hole in its body: the same material, its front inwards.
#[test]
fn a_bubble_of_air_is_seen_in_its_glass() {
    let mut stage = over_panel();
    add(&mut stage, GLASS, -1.0, 1.0);
    let index = stage.add(turned(slab(-0.3, 0.2)), stage.scene.materials[1].clone());
    // Of the glass's own material, so that it leaves the glass.
    std::sync::Arc::make_mut(&mut stage.scene.meshes[index]).primitives[0].material = 1;
    let part = |thickness| Layer { thickness, ..GLASS };
    let air = Layer {
        ior: 1.0,
        absorption: [0.0; 3],
        thickness: 0.5,
    };
    check(&stage, "a bubble", &[part(0.8), air, part(0.7)]);
}

/// Two bodies of one material that overlap are one body.
#[test]
fn bodies_of_one_material_join() {
    let mut stage = over_panel();
    add(&mut stage, GLASS, -0.4, 0.3);
    let index = stage.add(slab(0.1, 0.6), stage.scene.materials[1].clone());
    std::sync::Arc::make_mut(&mut stage.scene.meshes[index]).primitives[0].material = 1;
    check(&stage, "joined", &[GLASS]);
}

#[test]
fn a_fourth_body_is_not_entered_and_others_are_kept_in_order() {
    let mut stage = over_panel();
    for ior in [1.1, 1.4, 1.2, 1.3] {
        stage.add_medium(slab(-0.5, 0.5), ior, [0.0; 3]);
    }
    let packed = stage.pack([1, 1]);
    let two = media_with(&packed, media_with(&packed, MEDIA_NONE, 1), 2);
    assert_eq!(two, UVec3::new(2, 1, NONE));
    let three = media_with(&packed, two, 3);
    assert_eq!(three, UVec3::new(2, 3, 1));
    assert_eq!(media_far(&packed, three, 4, true), three);
    assert!(interface_at(&packed, three, 4, true, 0.0).hidden);
    assert_eq!(media_far(&packed, three, 3, false), two);
    // Where the path was not seen to enter, it is taken to be inside by the back that it meets.
    assert_eq!(
        media_near(&packed, MEDIA_NONE, 1, false),
        UVec3::new(1, NONE, NONE)
    );
    assert_eq!(media_near(&packed, MEDIA_NONE, 1, true), MEDIA_NONE);
    assert_eq!(media_near(&packed, MEDIA_NONE, 0, false), MEDIA_NONE);
    // The panel, index 1, in the densest: as far as it has a dielectric surface.
    let panel = interface_at(&packed, three, 0, true, 0.0);
    assert!(!panel.hidden && (panel.eta - 1.0 / 1.4f32 as f64).abs() < 1e-7);
}
