//! Fresnel's curves and albedos against closed forms.

use crate::{close, preset};
use snell::cpu::bsdf::fresnel::{F_conductor, F_dielectric};
use snell::plot::albedo::{AlbedoFigure, albedo};
use snell::plot::fresnel::{
    FresnelFigure, brewster_angle, conductor_curves, critical_angle, dielectric_curves,
};
use snell::plot::page::Curve;
use snell::plot::subject::{Reference, Subject};
use snell::scene::metals::metal;

/// The value at the point nearest to `x`.
fn at(curve: &Curve, x: f64) -> f64 {
    let nearest = |p: &&(f64, f64), q: &&(f64, f64)| (p.0 - x).abs().total_cmp(&(q.0 - x).abs());
    let point = curve.points.iter().min_by(nearest).unwrap();
    close(point.0, x, 1e-9, "a point there");
    point.1
}

#[test]
fn angles_of_glass_and_air() {
    close(brewster_angle(1.5), 56.309_932_474, 1e-9, "Brewster");
    close(brewster_angle(1.0 / 1.5), 33.690_067_526, 1e-9, "Brewster");
    close(
        critical_angle(1.0 / 1.5).unwrap(),
        41.810_314_896,
        1e-9,
        "critical",
    );
    assert_eq!(critical_angle(1.5), None);
    assert_eq!(critical_angle(1.0), None);
}

#[test]
fn dielectric_curves_are_fresnel_s_sines_and_tangents() {
    for eta in [1.5, 1.0 / 1.5, 2.42] {
        let [s, p, mean] = dielectric_curves(eta);
        assert_eq!(s.points.len(), mean.points.len());
        for (i, &(angle, unpolarised)) in mean.points.iter().enumerate() {
            close(
                unpolarised,
                0.5 * (s.points[i].1 + p.points[i].1),
                1e-12,
                &format!("mean at {angle} degrees, eta {eta}"),
            );
            let sin_t = angle.to_radians().sin() / eta;
            if angle == 0.0 || sin_t > 1.0 - 1e-9 {
                continue;
            }
            // Fresnel's own form, which the program does not use.
            let (i_, t) = (angle.to_radians(), sin_t.asin());
            let R_s = ((i_ - t).sin() / (i_ + t).sin()).powi(2);
            let R_p = ((i_ - t).tan() / (i_ + t).tan()).powi(2);
            close(
                s.points[i].1,
                R_s,
                1e-9,
                &format!("s at {angle}, eta {eta}"),
            );
            close(
                p.points[i].1,
                R_p,
                1e-9,
                &format!("p at {angle}, eta {eta}"),
            );
        }
        let at_normal = ((eta - 1.0) / (eta + 1.0)).powi(2);
        for curve in [&s, &p, &mean] {
            close(at(curve, 0.0), at_normal, 1e-12, "normal incidence");
            close(at(curve, 90.0), 1.0, 1e-12, "grazing incidence");
        }
        close(
            at(&p, brewster_angle(eta)),
            0.0,
            1e-12,
            "p at Brewster's angle",
        );
        if let Some(critical) = critical_angle(eta) {
            for &(angle, F) in &mean.points {
                assert_eq!(angle >= critical, F == 1.0, "{angle} degrees: {F}");
            }
        }
    }
}

#[test]
fn conductor_curves_are_exact_and_approximate() {
    let [eta, k] = metal("Ti").unwrap().index().map(|v| v.map(f64::from));
    let curves = conductor_curves(eta, k);
    assert_eq!(curves.len(), 6);
    for channel in 0..3 {
        let (eta, k) = (eta[channel], k[channel]);
        let at_normal = ((eta - 1.0).powi(2) + k * k) / ((eta + 1.0).powi(2) + k * k);
        let (exact, approximate) = (&curves[channel], &curves[3 + channel]);
        assert!(!exact.stroke.dashed && approximate.stroke.dashed);
        assert_eq!(exact.stroke.color, approximate.stroke.color);
        for curve in [exact, approximate] {
            close(at(curve, 0.0), at_normal, 1e-12, &curve.name);
            close(at(curve, 90.0), 1.0, 1e-12, &curve.name);
        }
        let c = 60f64.to_radians().cos();
        close(at(exact, 60.0), F_conductor(c, eta, k), 1e-12, "exact");
        // |r|^2 of the approximation, each polarisation by itself.
        let s = ((eta - c).powi(2) + k * k) / ((eta + c).powi(2) + k * k);
        let p = ((eta * c - 1.0).powi(2) + (k * c).powi(2))
            / ((eta * c + 1.0).powi(2) + (k * c).powi(2));
        close(at(approximate, 60.0), 0.5 * (s + p), 1e-12, "approximate");
        assert!((at(approximate, 60.0) - at(exact, 60.0)).abs() > 1e-4);
    }
}

#[test]
fn a_material_knows_its_fresnel() {
    let reference = Reference::default();
    let of = |subject: &Subject| FresnelFigure::of(subject, &reference);
    assert_eq!(
        of(&preset("rough-glass")).unwrap(),
        FresnelFigure::Dielectric { eta: 1.5 }
    );
    let gold = metal("Au").unwrap().index().map(|v| v.map(f64::from));
    match of(&preset("gold")).unwrap() {
        FresnelFigure::Conductor { eta, k, .. } => {
            assert_eq!((eta, k), (gold[0], gold[1]));
        }
        other => panic!("{other:?}"),
    }
    match of(&preset("plastic")).unwrap() {
        FresnelFigure::Own { curves, .. } => {
            assert_eq!(curves.len(), 1, "grey");
            close(at(&curves[0], 0.0), 0.04, 1e-6, "index 1.5");
            let weight = (1.0 - 60f64.to_radians().cos()).powi(5);
            close(at(&curves[0], 60.0), 0.04 + 0.96 * weight, 1e-6, "Schlick");
        }
        other => panic!("{other:?}"),
    }
    assert_eq!(of(&preset("lambertian")).unwrap_err().exit_status(), 2);
}

#[test]
fn albedos_are_what_is_left() {
    let reference = Reference::default();
    for theta in [0.0, 60.0, 85.0] {
        let cos = f64::to_radians(theta).cos();
        let diffuse = albedo(&preset("lambertian"), &reference, theta).unwrap();
        close(diffuse.reflected, 0.8, 1e-6, "diffuse");
        close(diffuse.transmitted, 0.0, 0.0, "diffuse");
        let glass = albedo(&preset("glass"), &reference, theta).unwrap();
        close(
            glass.reflected,
            F_dielectric(cos, 1.5),
            2e-4,
            "glass reflects",
        );
        close(
            glass.reflected + glass.transmitted,
            1.0,
            1e-9,
            "glass keeps all",
        );
        let diamond = albedo(&preset("diamond"), &reference, theta).unwrap();
        close(
            diamond.reflected + diamond.transmitted,
            1.0,
            1e-6,
            "diamond too",
        );
        let gold = albedo(&preset("gold"), &reference, theta).unwrap();
        let [eta, k] = metal("Au").unwrap().index().map(|v| v.map(f64::from));
        let F: f64 = [0.2126, 0.7152, 0.0722]
            .iter()
            .enumerate()
            .map(|(i, weight)| weight * F_conductor(cos, eta[i], k[i]))
            .sum();
        close(gold.reflected, F, 1e-9, "gold");
    }
}

#[test]
fn albedo_curves_run_over_angle_and_over_roughness() {
    let reference = Reference::default();
    let metal = preset("rough-gold");
    let over_angle = AlbedoFigure::over_angle(&metal, &reference, &[0.2, 0.8]).unwrap();
    let over_roughness = AlbedoFigure::over_roughness(&metal, &reference, &[0.0, 75.0]).unwrap();
    let (angles, roughnesses) = (over_angle.curves(), over_roughness.curves());
    assert_eq!((angles.len(), roughnesses.len()), (2, 2));
    assert_eq!(angles[1].name, "roughness 0.8");
    assert_eq!(roughnesses[1].name, "θ = 75°");
    // Both ways come to the same.
    assert_eq!(at(&angles[1], 75.0), at(&roughnesses[1], 0.8));
    let glass = AlbedoFigure::over_angle(&preset("glass"), &reference, &[0.5]).unwrap();
    let [all, reflected] = &glass.curves()[..] else {
        panic!("two curves of what transmits")
    };
    assert!(!all.stroke.dashed && reflected.stroke.dashed);
    assert!(at(all, 30.0) > 0.9 && at(reflected, 30.0) < 0.1);
    let plain = AlbedoFigure::over_angle(&preset("lambertian"), &reference, &[0.2, 0.8]).unwrap();
    assert_eq!(plain.curves().len(), 1);
}
