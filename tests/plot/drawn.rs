//! The figures as they are drawn.

use crate::{parse_svg, preset};
use snell::plot::albedo::AlbedoFigure;
use snell::plot::fresnel::FresnelFigure;
use snell::plot::lobe::{LobeFigure, Radius};
use snell::plot::page::{Figure, png, svg};
use snell::plot::sphere::SphereFigure;
use snell::plot::subject::{PRESETS, Reference};
use snell::scene::metals::metal;

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
