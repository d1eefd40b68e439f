//! `snell plot`: the data behind each figure against closed forms, the figures themselves, and the program.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]
#![allow(non_snake_case, reason = "the symbols of the textbooks")]

#[allow(dead_code, reason = "shared with the other tests of the program")]
#[path = "cli/place.rs"]
mod place;

use place::{Place, scene, stderr};
use serde_json::{Value, json};
use snell::cpu::bsdf::fresnel::{F_conductor, F_dielectric};
use snell::plot::albedo::{AlbedoFigure, albedo};
use snell::plot::fresnel::{
    FresnelFigure, brewster_angle, conductor_curves, critical_angle, dielectric_curves,
};
use snell::plot::lobe::{LobeFigure, Radius, lobe};
use snell::plot::page::{Curve, Figure, png, svg};
use snell::plot::sphere::SphereFigure;
use snell::plot::subject::{PRESETS, Reference, Subject};
use snell::scene::metals::metal;
use std::f64::consts::PI;

fn preset(name: &str) -> Subject {
    Subject::preset(name).unwrap_or_else(|| panic!("no preset {name}"))
}

fn close(value: f64, expected: f64, tolerance: f64, what: &str) {
    assert!(
        (value - expected).abs() <= tolerance,
        "{what}: {value}, not {expected}"
    );
}

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

/// Every tag closes, every attribute is quoted, nothing is left over; the text between tags.
fn parse_svg(text: &str) -> Vec<String> {
    let mut open = Vec::new();
    let mut words = Vec::new();
    let mut rest = text;
    while let Some(start) = rest.find('<') {
        let word = rest[..start].trim();
        if !word.is_empty() {
            assert!(!open.is_empty(), "text outside of all elements: {word}");
            words.push(word.to_owned());
        }
        let end = start + rest[start..].find('>').expect("a tag ends");
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        assert_eq!(tag.matches('"').count() % 2, 0, "<{tag}>");
        let name = tag
            .trim_start_matches('/')
            .split([' ', '/'])
            .next()
            .unwrap();
        assert!(name.chars().all(char::is_alphanumeric), "<{tag}>");
        if tag.starts_with('/') {
            assert_eq!(open.pop().as_deref(), Some(name));
        } else if !tag.ends_with('/') {
            open.push(name.to_owned());
        }
    }
    assert!(open.is_empty() && rest.trim().is_empty(), "{open:?}");
    words
}

/// All that is written in the figure.
fn words(figure: &impl Figure) -> Vec<String> {
    parse_svg(&svg(figure).unwrap())
}

fn check_pixels(figure: &impl Figure, name: &str) {
    let bytes = png(figure).unwrap();
    let picture = image::load_from_memory(&bytes).unwrap().into_rgb8();
    let size = figure.size().map(|side| 2 * side as u32);
    assert_eq!([picture.width(), picture.height()], size, "{name}");
    let count = |test: fn(u8) -> bool| {
        let all = |p: &&image::Rgb<u8>| p.0.iter().all(|&c| test(c));
        picture.pixels().filter(all).count()
    };
    let (white, dark) = (count(|c| c == 255), count(|c| c < 0x60));
    let all = (size[0] * size[1]) as usize;
    assert!(
        white > all / 4 && dark > 2000,
        "{name}: {white} white and {dark} dark of {all}"
    );
}

#[test]
fn every_preset_is_drawn() {
    let reference = Reference::default();
    for name in PRESETS.iter().map(|preset| preset.name) {
        let subject = preset(name);
        let smooth = ["glass", "diamond", "gold"].contains(&name);
        let lobes = LobeFigure::new(&subject, &reference, &[0.0, 60.0], 30.0, Radius::Linear);
        let sphere = SphereFigure::new(&subject, &reference, 45.0, 180.0);
        assert_eq!(lobes.is_err(), smooth, "{name}");
        assert_eq!(sphere.is_err(), smooth, "{name}");
        if !smooth {
            let words = words(&lobes.unwrap());
            let lobe = |word: &&String| word.starts_with("viewer at ");
            assert_eq!(words.iter().filter(lobe).count(), 2, "{name}: {words:?}");
            assert!(
                words
                    .iter()
                    .any(|word| word.contains("30° from the tangent"))
            );
        }
        if !["lambertian", "oren-nayar", "blinn"].contains(&name) {
            let fresnel = FresnelFigure::of(&subject, &reference).unwrap();
            assert!(words(&fresnel)[0].starts_with("Fresnel reflectance"));
        }
    }
}

#[test]
fn every_figure_has_letters_and_pixels() {
    let reference = Reference::default();
    let glass = preset("rough-glass");
    let has = |words: &[String], expected: &[&str]| {
        for word in expected {
            assert!(words.contains(&(*word).to_owned()), "{word}: {words:?}");
        }
    };
    let logarithmic = LobeFigure::new(&glass, &reference, &[45.0], 0.0, Radius::Logarithmic);
    let logarithmic = logarithmic.unwrap();
    has(&words(&logarithmic), &["0.1", "1", "10", "100", "180°"]);
    check_pixels(&logarithmic, "lobe");
    let sphere = SphereFigure::new(&glass, &reference, 45.0, 180.0).unwrap();
    has(&words(&sphere), &["f (1/sr)", "light from below", "100"]);
    check_pixels(&sphere, "sphere");
    let albedo = AlbedoFigure::over_angle(&glass, &reference, &[0.3, 0.9]).unwrap();
    let axis = "angle of incidence θ (degrees)";
    has(&words(&albedo), &["roughness 0.9", "reflected only", axis]);
    check_pixels(&albedo, "albedo");
    let fresnel = FresnelFigure::metal(metal("Cu").unwrap());
    has(
        &words(&fresnel),
        &["blue, exact", "blue, approximate", axis],
    );
    check_pixels(&fresnel, "fresnel");
}

#[test]
fn glass_shows_its_angles() {
    let figure = FresnelFigure::Dielectric { eta: 1.5 };
    let shown = words(&figure);
    for word in [
        "Fresnel reflectance of a dielectric, η = 1.5",
        "Brewster angle 56.3°",
        "Brewster angle 33.7°",
        "critical angle 41.8°",
        "s-polarised",
        "p-polarised",
        "unpolarised",
    ] {
        assert!(shown.contains(&word.to_owned()), "{word}: {shown:?}");
    }
    assert_eq!(
        shown.iter().filter(|w| w.starts_with("critical")).count(),
        1
    );
    // Without a boundary there are no angles.
    let shown = words(&FresnelFigure::Dielectric { eta: 1.0 });
    assert!(
        !shown
            .iter()
            .any(|w| w.contains("Brewster") || w.contains("critical"))
    );
}

#[test]
fn the_program_draws_the_same_bytes_again() {
    let place = Place::new();
    for (line, word) in [
        ("fresnel --eta 1.5", "Brewster angle 56.3°"),
        ("fresnel --metal Au", "Au (Johnson and Christy 1972)"),
        ("lobe rough-gold --theta 20", "viewer at 20°"),
        ("albedo rough-plastic --roughness 0.5", "roughness 0.5"),
        (
            "sphere rough-gold --theta 30 --phi -90",
            "θ = 30°, φ = -90°",
        ),
    ] {
        place.succeed(&format!("plot {line} -o a.svg -o a.png"));
        place.succeed(&format!("plot {line} -o b.png -o b.SVG"));
        assert!(place.read("a.svg") == place.read("b.SVG"), "{line}: a.svg");
        assert!(place.read("a.png") == place.read("b.png"), "{line}: a.png");
        assert!(place.read("a.png").starts_with(b"\x89PNG"), "{line}");
        let text = String::from_utf8(place.read("a.svg")).unwrap();
        let found = parse_svg(&text).iter().any(|w| w.contains(word));
        assert!(found, "{line}: no {word}");
    }
    place.succeed("plot fresnel --eta 1.5 -o a.svg");
    let output = place.succeed("plot fresnel --eta 1.5 -o -");
    assert!(place.read("a.svg") == output.stdout);
}

#[test]
fn materials_come_from_files_too() {
    let place = Place::new();
    let rough = json!({"name": "rough-plastic", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0, "roughnessFactor": 0.6}});
    let preset = place.succeed("plot lobe rough-plastic -o -").stdout;
    place.write("material.json", rough.to_string().as_bytes());
    let output = place.succeed("plot lobe --material material.json -o -");
    assert_eq!(
        (output.stdout.as_slice(), stderr(&output).as_str()),
        (preset.as_slice(), "")
    );

    let mut textured = rough.clone();
    textured["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": 0});
    textured["normalTexture"] = json!({"index": 0});
    let mut file = scene();
    file["materials"] = json!([{ "name": "other" }, rough, textured]);
    file["materials"][2]["name"] = json!("textured");
    place.write("materials.gltf", file.to_string().as_bytes());
    for choice in ["rough-plastic", "1"] {
        let output = place.succeed(&format!(
            "plot lobe --from materials.gltf --name {choice} -o -"
        ));
        assert_eq!(
            (output.stdout.as_slice(), stderr(&output).as_str()),
            (preset.as_slice(), "")
        );
    }
    let output = place.succeed("plot lobe --from materials.gltf --name textured -o -");
    let preset = String::from_utf8(preset).unwrap();
    let same = String::from_utf8(output.stdout.clone())
        .unwrap()
        .replace("textured", "rough-plastic");
    assert_eq!(same, preset);
    let note = stderr(&output);
    for texture in ["factors alone", "baseColorTexture", "normalTexture"] {
        assert!(note.contains(texture), "{note}");
    }
    // A nameless material is called by its place.
    let output = place.succeed("plot albedo --from scene.gltf --name 0 --roughness 1 -o -");
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains("Directional albedo of materials[0]"),
        "{text}"
    );
}

#[test]
fn what_goes_wrong_has_its_status() {
    let place = Place::new();
    let write = |name: &str, value: Value| place.write(name, value.to_string().as_bytes());
    write(
        "range.json",
        json!({"pbrMetallicRoughness": {"roughnessFactor": 2}}),
    );
    write(
        "fuzz.json",
        json!({"extensions": {"KHR_materials_fuzz": {}}}),
    );
    place.write("text.json", b"{");
    write("empty.gltf", json!({"asset": {"version": "2.0"}}));
    write("old.gltf", json!({"asset": {"version": "1.0"}}));
    for (line, status, says) in [
        ("fresnel --eta 1.5", 2, "--output"),
        ("fresnel -o a.svg", 2, "--material"),
        ("fresnel --eta 0 -o a.svg", 2, "more than 0"),
        ("fresnel --eta 1.5 gold -o a.svg", 2, "--eta"),
        ("fresnel --eta 1.5 --metal Au -o a.svg", 2, "--metal"),
        ("fresnel --metal Xx -o a.svg", 2, "there are Ag, Al"),
        ("fresnel lambertian -o a.svg", 2, "no Fresnel"),
        ("lobe marble -o a.svg", 2, "rough-gold"),
        ("lobe glass -o a.svg", 2, "spreads no light"),
        ("sphere gold -o a.svg", 2, "spreads no light"),
        ("lobe rough-gold --theta 90 -o a.svg", 2, "less than 90"),
        ("albedo gold --roughness 2 -o a.svg", 2, "0 to 1"),
        (
            "albedo lambertian --against roughness -o a.svg",
            2,
            "no roughness",
        ),
        ("lobe gold --material range.json -o a.svg", 2, "--material"),
        ("lobe --from scene.gltf -o a.svg", 2, "--name"),
        ("lobe --name 0 -o a.svg", 2, "--from"),
        (
            "lobe --from scene.gltf --name x -o a.svg",
            2,
            "0 'materials[0]'",
        ),
        ("lobe --from empty.gltf --name 0 -o a.svg", 2, "has none"),
        ("lobe rough-gold -o a.pdf", 2, ".svg or .png"),
        ("lobe rough-gold -o a.svg -o a.svg", 2, "more than once"),
        ("lobe --material none.json -o a.svg", 3, "none.json"),
        ("lobe --material text.json -o a.svg", 3, "not JSON"),
        ("lobe --material range.json -o a.svg", 3, "roughness"),
        ("lobe --from none.gltf --name 0 -o a.svg", 3, "none.gltf"),
        ("lobe --from old.gltf --name 0 -o a.svg", 3, "not 2"),
        (
            "lobe --material fuzz.json -o a.svg",
            4,
            "KHR_materials_fuzz",
        ),
        ("lobe rough-gold -o none/a.svg", 8, "none/a.svg"),
        ("lobe rough-gold -o a.svg -o none/a.png", 8, "none/a.png"),
    ] {
        place.fail(&format!("plot {line}"), status, says);
    }
}
