//! The shapes of lobes.

use crate::{close, preset};
use serde_json::json;
use snell::plot::lobe::lobe;
use snell::plot::sphere::SphereFigure;
use snell::plot::subject::{Reference, Subject};
use std::f64::consts::PI;

#[test]
fn lobes_have_their_shapes() {
    let reference = Reference::default();
    for theta_o in [0.0, 50.0] {
        let diffuse = lobe(&preset("lambertian"), &reference, theta_o, 0.0).unwrap();
        for &(angle, value) in &diffuse.points {
            let cos = angle.to_radians().cos().max(0.0);
            close(value, 0.8 / PI * cos, 1e-7, &format!("at {angle} degrees"));
        }
    }
    // The viewer is on the left, so that a metal's lobe points to the right, and farther out than a mirror's.
    let metal = lobe(&preset("rough-gold"), &reference, 40.0, 0.0).unwrap();
    let peak = metal
        .points
        .iter()
        .max_by(|p, q| p.1.total_cmp(&q.1))
        .unwrap();
    assert!((38.0..50.0).contains(&peak.0), "{peak:?}");
    // Glass bends the other lobe towards the normal: sin 40 = 1.5 sin 25.37.
    let glass = lobe(&preset("rough-glass"), &reference, 40.0, 0.0).unwrap();
    let below = glass.points.iter().filter(|p| p.0.abs() > 90.0);
    let peak = below.max_by(|p, q| p.1.total_cmp(&q.1)).unwrap();
    close(peak.0, 180.0 - 25.37, 2.0, "refracted");
    // Facets along the tangent are rougher: the lobe across it is narrower and higher.
    let steel = |phi| {
        let lobe = lobe(&preset("brushed-steel"), &reference, 0.0, phi).unwrap();
        let share = |angle: f64| {
            let near = |p: &&(f64, f64)| (p.0 - angle).abs() < 1e-9;
            lobe.points.iter().find(near).unwrap().1
        };
        share(20.0) / share(0.0)
    };
    assert!(
        steel(0.0) > 5.0 * steel(90.0),
        "{} {}",
        steel(0.0),
        steel(90.0)
    );
}

#[test]
fn roughness_is_set_where_a_material_has_one() {
    let rough = |name| preset(name).with_roughness(0.4);
    let bytes = |subject: Subject| bytemuck::bytes_of(&subject.bsdf().unwrap()).to_vec();
    // alpha = 0.4^2 = 0.16, the presets' own; a smooth boundary gets facets.
    for (smooth, preset_) in [("glass", "rough-glass"), ("gold", "rough-gold")] {
        assert_eq!(bytes(rough(smooth).unwrap()), bytes(preset(preset_)));
        assert_eq!(bytes(rough(preset_).unwrap()), bytes(preset(preset_)));
    }
    assert_eq!(
        bytes(preset("plastic").with_roughness(0.6).unwrap()),
        bytes(preset("rough-plastic"))
    );
    assert_eq!(
        bytes(preset("oren-nayar").with_roughness(0.8).unwrap()),
        bytes(preset("oren-nayar"))
    );
    assert_ne!(
        bytes(rough("oren-nayar").unwrap()),
        bytes(preset("oren-nayar"))
    );
    let copper = |alpha: f32| json!({"model": "conductor", "conductor": {"metal": "Cu"}, "distribution": {"name": "beckmann", "alpha": alpha}});
    assert_eq!(
        bytes(rough("copper").unwrap()),
        bytes(Subject::new("copper", copper(0.16)))
    );
    let inside = |alpha: f32| {
        Subject::new(
            "",
            json!({"extensions": {"SNELL_materials_bsdf": copper(alpha)}}),
        )
    };
    assert_eq!(
        bytes(inside(0.3).with_roughness(0.4).unwrap()),
        bytes(inside(0.16))
    );
    for none in ["lambertian", "blinn"] {
        assert!(rough(none).is_none(), "{none}");
    }
}

#[test]
fn slices_peak_where_mirrors_reflect() {
    let reference = Reference::default();
    let diffuse = SphereFigure::new(&preset("lambertian"), &reference, 45.0, 180.0).unwrap();
    let metal = SphereFigure::new(&preset("aluminium"), &reference, 45.0, 180.0).unwrap();
    for theta in [0.5, 30.0, 60.0, 89.5] {
        for phi in [0.0, 90.0, 200.0, 359.0] {
            close(diffuse.above().at(theta, phi), 0.8 / PI, 1e-7, "diffuse");
        }
    }
    // A narrow lobe is highest within a few degrees of the mirrored direction.
    let cells = (0..90).flat_map(|row| (0..180).map(move |column| (row, column)));
    let middles = cells.map(|(row, column)| (f64::from(row) + 0.5, 2.0 * f64::from(column) + 1.0));
    let height = |cell: &(f64, f64)| metal.above().at(cell.0, cell.1);
    let peak = middles
        .max_by(|p, q| height(p).total_cmp(&height(q)))
        .unwrap();
    let off_plane = peak.1.min(360.0 - peak.1);
    assert!(
        (44.0..47.0).contains(&peak.0) && off_plane < 2.0,
        "{peak:?}"
    );
    let turned = SphereFigure::new(&preset("aluminium"), &reference, 45.0, 90.0).unwrap();
    close(
        turned.above().at(45.0, 270.0),
        metal.above().at(45.0, 0.0),
        1e-9,
        "turned by a right angle",
    );
}
