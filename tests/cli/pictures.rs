//! What a run that goes well writes and says.

use crate::place::{Place, SMALL, channel, stderr};

#[test]
fn a_sample_range_is_that_part_of_the_samples() {
    let place = Place::new();
    for (name, samples) in [
        ("all", "--samples 0..8"),
        ("first", "--samples 0..3"),
        ("rest", "--samples 3..8"),
        ("three", "--spp 3"),
        ("five", "--spp 5"),
    ] {
        place.succeed(&format!(
            "render scene.gltf -o {name}.exr --aov samples,variance --cpu --size 8x6 {samples}"
        ));
    }
    let [all, first, rest, three, five] =
        ["all", "first", "rest", "three", "five"].map(|n| place.read(&format!("{n}.exr")));
    assert!(channel(&rest, "samples").iter().all(|&n| n == 5.0));
    let values = |bytes| channel(bytes, "G");
    assert!(values(&first) == values(&three) && values(&rest) != values(&five));
    // Parts average to the whole but for what the filter's weights of each part happen to sum to.
    let errors = channel(&all, "variance.G").into_iter().map(f32::sqrt);
    let parts = values(&first).into_iter().zip(values(&rest));
    for ((all, (first, rest)), error) in values(&all).into_iter().zip(parts).zip(errors) {
        let merged = (3.0 * first + 5.0 * rest) / 8.0;
        assert!(
            (all - merged).abs() <= 0.5 * error + 1e-5 * all.abs(),
            "{all} +- {error}, {merged}"
        );
    }
}

#[test]
fn a_transparent_background_has_no_alpha() {
    let place = Place::new();
    place.succeed(&format!(
        "render scene.gltf -o a.png --background transparent --cpu {SMALL}"
    ));
    let image = image::open(place.path("a.png")).unwrap().to_rgba8();
    assert_eq!(image.get_pixel(0, 0).0, [0; 4]);
    assert_eq!(image.get_pixel(8, 7).0[3], 255);
    place.succeed(&format!(
        "render scene.gltf -o b.png --background #ff0000 --tonemap linear --cpu {SMALL}"
    ));
    let image = image::open(place.path("b.png")).unwrap().to_rgb8();
    assert_eq!(image.get_pixel(0, 0).0, [255, 0, 0]);
}

#[test]
fn a_dash_is_a_png_on_standard_output() {
    let place = Place::new();
    let output = place.succeed(&format!("render scene.gltf -o - --cpu {SMALL}"));
    let image = image::load_from_memory(&output.stdout).unwrap();
    assert_eq!((image.width(), image.height()), (16, 12));
    assert_eq!(place.names(), ["scene.gltf"]);
}

#[test]
fn progress_is_plain_lines_and_quiet_is_silent() {
    let place = Place::new();
    let output = place.succeed(&format!("render scene.gltf -o a.png --cpu {SMALL}"));
    let text = stderr(&output);
    let lines: Vec<&str> = text.lines().collect();
    let progress = lines.iter().filter(|l| l.contains("% rendered")).count();
    assert!((1..=3).contains(&progress), "{text}");
    assert!(!text.contains('\r') && !text.contains('\x1b'), "{text:?}");
    let last = lines.last().unwrap();
    for says in [
        "scene.gltf",
        "a.png",
        "16x12",
        "4 samples a pixel",
        "float64",
        " in ",
        "error ",
    ] {
        assert!(last.contains(says), "no '{says}' in: {last}");
    }
    assert!(output.stdout.is_empty());

    let output = place.succeed(&format!("render scene.gltf -o a.png --cpu --quiet {SMALL}"));
    assert_eq!(stderr(&output), "");
}

#[test]
fn a_black_picture_is_said_to_be_black() {
    let place = Place::new();
    let output = place.succeed(&format!(
        "render scene.gltf -o a.png --env-strength 0 --cpu --quiet {SMALL}"
    ));
    assert!(stderr(&output).contains("warning: the picture is black"));
}
