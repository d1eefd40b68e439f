//! Films to files and back: what is written is what was rendered, tone maps do what they promise, and
//! no failure leaves half a file.
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

use std::fs;
use std::io::Cursor;
use std::path::Path;

use exr::prelude::{ReadChannels, ReadLayers};
use snell::film::{Film, FilmPixel, Weighted};
use snell::output::exr::FACTS_ATTRIBUTE;
use snell::output::file::{check, write_all};
use snell::output::tonemap::{Tonemap, srgb_encode};
use snell::output::{Channels, Format, Look, OutputError, Place, Target, Window, encode};

/// A film with many magnitudes, unequal sample counts, coverage and a sample that is not finite.
fn film() -> Film {
    let mut film = Film::new(7, 5);
    for (i, pixel) in film.pixels.iter_mut().enumerate() {
        for s in 0..2 + i % 3 {
            let x = (i as f64 * 0.7 - 9.0).exp2() * (1.0 + s as f64 / 3.0);
            pixel.add([x, x / 3.0, 0.25], f64::from(u8::from(s > 0)));
        }
    }
    film.pixel_mut(3, 2).add([f64::NAN, 1.0, 1.0], 1.0);
    film
}

fn look(tonemap: Tonemap) -> Look {
    Look {
        exposure_ev: 0.0,
        tonemap,
    }
}

/// One pixel of one colour.
fn flat(rgb: [f64; 3], alpha: f64) -> Film {
    let mut film = Film::new(1, 1);
    film.pixels[0].add(rgb, alpha);
    film
}

fn encode_simply(film: &Film, format: Format, channels: Channels, look: Look) -> Vec<u8> {
    encode(film, format, channels, look, Window::whole(film), "").unwrap()
}

#[test]
fn film_counts_what_is_not_finite_and_leaves_it_out() {
    let mut pixel = FilmPixel::default();
    pixel.add([1.0, 2.0, 3.0], 1.0);
    pixel.add([f64::INFINITY, 0.0, 0.0], 1.0);
    pixel.add([0.0, f64::NAN, 0.0], 1.0);
    pixel.add([3.0, 2.0, 1.0], 0.0);
    assert_eq!((pixel.samples, pixel.non_finite), (2, 2));
    assert_eq!(pixel.mean(), [2.0; 3]);
    assert_eq!(pixel.coverage(), 0.5);
    assert_eq!(pixel.sample_variance(), [2.0, 0.0, 2.0]);
    assert_eq!(pixel.variance(), [1.0, 0.0, 1.0]);
    assert_eq!(pixel.mean_square(), [5.0, 4.0, 5.0]);
    assert_eq!(film().non_finite(), 1);
}

#[test]
fn weighted_samples_tell_as_much_as_fewer_equal_ones() {
    let values = [[1.0, 2.0, 4.0], [3.0, 2.0, 1.0], [5.0, 2.0, 1.5]];
    let (mut equal, mut plain) = (Weighted::default(), FilmPixel::default());
    for x in values {
        equal.add(0.25, x, 0.5);
        plain.add(x, 0.5);
    }
    let equal = equal.pixel(3);
    for c in 0..3 {
        assert!((equal.mean()[c] - plain.mean()[c]).abs() < 1e-14);
        assert!((equal.variance()[c] - plain.variance()[c]).abs() < 1e-6);
    }
    assert_eq!((equal.coverage(), equal.samples), (0.5, 3));

    // By hand: of weights 1 and 1/2 the mean of 1 and 3 is 5/3, the mean squared deviation 8/9, and both weigh
    // like 9/5 samples: the error squared is 8/9 over 4/5.
    let mut halved = Weighted::default();
    halved.add(1.0, [1.0; 3], 1.0);
    halved.add(0.5, [3.0; 3], 0.0);
    let halved = halved.pixel(2);
    for c in 0..3 {
        assert!((halved.mean()[c] - 5.0 / 3.0).abs() < 1e-14);
        assert!((halved.variance()[c] - 10.0 / 9.0).abs() < 1e-6);
    }
    assert!((halved.coverage() - 2.0 / 3.0).abs() < 1e-6);

    // A picture of samples that all came out infinite is black, and said to be.
    let bad = Weighted {
        non_finite: 4,
        ..Weighted::default()
    };
    let mut film = Film::new(1, 1);
    film.pixels[0] = bad.pixel(0);
    assert!(film.is_black() && film.non_finite() == 4);
}

#[test]
fn film_error_is_that_of_known_noise() {
    // Samples 0 and 2 in turn: mean 1, variance of a sample n/(n-1), so the error is 1/sqrt(n-1),
    // over a level of 1.01.
    let mut film = Film::new(4, 4);
    for pixel in &mut film.pixels {
        for s in 0..100 {
            pixel.add([f64::from(s % 2) * 2.0; 3], 1.0);
        }
    }
    let error = film.error().unwrap();
    let expected = (1.0f64 / 99.0).sqrt() / 1.01;
    assert!((error.relative - expected).abs() < 1e-12, "{error:?}");
    assert!(error.confidence[0] <= error.relative && error.relative <= error.confidence[1]);
    assert!(Film::new(2, 2).error().is_none());
    assert!(!film.is_black() && Film::new(1, 1).is_black());
}

#[test]
fn exr_holds_the_float32_values_exactly() {
    let film = film();
    let channels = Channels {
        transparent: true,
        variance: true,
        samples: true,
    };
    let window = Window {
        full_size: [40, 30],
        origin: [11, 13],
    };
    let facts = r#"{"seed":1}"#;
    let bytes = encode(&film, Format::Exr, channels, Look::default(), window, facts).unwrap();
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(&bytes))
        .unwrap();
    let layer = &image.layer_data[0];
    let channel = |name: &str| -> Vec<f32> {
        let found = layer.channel_data.list.iter().find(|c| c.name.eq(name));
        found.unwrap().sample_data.values_as_f32().collect()
    };
    let same = |name: &str, value: &dyn Fn(&FilmPixel) -> f64| {
        let expected: Vec<f32> = film.pixels.iter().map(|p| value(p) as f32).collect();
        assert_eq!(channel(name), expected, "{name}");
    };
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        same(name, &|p| p.mean()[c]);
        same(&format!("variance.{name}"), &|p| p.variance()[c]);
    }
    same("A", &|p| p.coverage());
    same("samples", &|p| f64::from(p.samples));
    assert_eq!(layer.channel_data.list.len(), 8);
    assert_eq!(layer.attributes.layer_position, exr::math::Vec2(11, 13));
    assert_eq!(
        image.attributes.display_window.size,
        exr::math::Vec2(40, 30)
    );
    let stored = &layer.attributes.other[&exr::meta::attribute::Text::from(FACTS_ATTRIBUTE)];
    assert_eq!(
        *stored,
        exr::meta::attribute::AttributeValue::Text(facts.into())
    );
}

#[test]
fn exr_alpha_is_one_before_an_opaque_background() {
    let bytes = encode_simply(&film(), Format::Exr, Channels::default(), Look::default());
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(&bytes))
        .unwrap();
    let alpha = &image.layer_data.channel_data.list[0];
    assert!(alpha.name.eq("A"));
    assert!(alpha.sample_data.values_as_f32().all(|a| a == 1.0));
}

#[test]
fn every_format_gives_the_same_bytes_each_time() {
    let film = film();
    for format in [
        Format::Exr,
        Format::Hdr,
        Format::Png,
        Format::Jpeg,
        Format::Webp,
    ] {
        let channels = Channels {
            transparent: true,
            variance: true,
            samples: true,
        };
        let first = encode_simply(&film, format, channels, Look::default());
        let second = encode_simply(&film, format, channels, Look::default());
        assert!(first == second, "{format:?}");
    }
}

#[test]
fn png_and_webp_hold_srgb_code_values() {
    // IEC 61966-2-1: linear 0.214 is code value 127.5 / 255 and so on; ends are exact.
    for (linear, code) in [
        (0.0, 0),
        (1.0, 255),
        (2.0, 255),
        (0.0031308, 10),
        (0.18, 118),
        (0.5, 188),
        (0.2158605, 128),
    ] {
        for format in [Format::Png, Format::Webp] {
            let film = flat([linear; 3], 1.0);
            let bytes = encode_simply(&film, format, Channels::default(), look(Tonemap::Linear));
            let image = image::load_from_memory(&bytes).unwrap();
            assert_eq!(image.color(), image::ColorType::Rgb8);
            assert_eq!(image.to_rgb8().get_pixel(0, 0).0, [code; 3], "{linear}");
        }
    }
}

#[test]
fn exposure_is_in_stops() {
    let film = flat([0.125; 3], 1.0);
    let bright = Look {
        exposure_ev: 2.0,
        tonemap: Tonemap::Linear,
    };
    let bytes = encode_simply(&film, Format::Png, Channels::default(), bright);
    let image = image::load_from_memory(&bytes).unwrap().to_rgb8();
    assert_eq!(image.get_pixel(0, 0).0, [188; 3]);
}

#[test]
fn a_pixel_knows_a_small_spread_about_a_large_mean() {
    // Sums of squares in float32 would lose all of it, and in float64 half of the digits.
    let mut pixel = FilmPixel::default();
    let values: Vec<f64> = (0..1000).map(|i| 1e6 + f64::from(i % 7)).collect();
    for &x in &values {
        pixel.add([x; 3], 1.0);
    }
    let mean = values.iter().sum::<f64>() / 1000.0;
    let expected = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 999.0;
    for variance in pixel.sample_variance() {
        assert!(
            (variance / expected - 1.0).abs() < 1e-5,
            "{variance} {expected}"
        );
    }
}

#[test]
fn transparent_png_has_straight_alpha() {
    // Half covered by radiance 0.5, so the premultiplied mean is 0.25.
    let mut film = Film::new(2, 1);
    film.pixels[0].add([0.5; 3], 1.0);
    film.pixels[0].add([0.0; 3], 0.0);
    film.pixels[1].add([0.0; 3], 0.0);
    let channels = Channels {
        transparent: true,
        ..Channels::default()
    };
    let bytes = encode_simply(&film, Format::Png, channels, look(Tonemap::Linear));
    let image = image::load_from_memory(&bytes).unwrap();
    assert_eq!(image.color(), image::ColorType::Rgba8);
    let image = image.to_rgba8();
    assert_eq!(image.get_pixel(0, 0).0, [188, 188, 188, 128]);
    assert_eq!(image.get_pixel(1, 0).0, [0; 4]);
}

#[test]
fn jpeg_is_near_and_has_no_alpha() {
    let mut film = Film::new(16, 16);
    for pixel in &mut film.pixels {
        pixel.add([0.5, 0.18, 0.05], 1.0);
    }
    let bytes = encode_simply(
        &film,
        Format::Jpeg,
        Channels::default(),
        look(Tonemap::Linear),
    );
    let image = image::load_from_memory(&bytes).unwrap();
    assert_eq!(image.color(), image::ColorType::Rgb8);
    let [r, g, b] = image.to_rgb8().get_pixel(8, 8).0;
    for (got, linear) in [(r, 0.5), (g, 0.18), (b, 0.05)] {
        let expected = srgb_encode(linear) * 255.0;
        assert!((f64::from(got) - expected).abs() < 4.0, "{got} {expected}");
    }
}

#[test]
fn hdr_is_within_its_mantissa() {
    let film = film();
    let bytes = encode_simply(&film, Format::Hdr, Channels::default(), Look::default());
    let image = image::load_from_memory(&bytes).unwrap().to_rgb32f();
    for (i, pixel) in film.pixels.iter().enumerate() {
        let [r, g, b] = pixel.mean();
        // The mantissa of the largest channel is 128 to 255, so a step is at most 1/128 of it.
        let step = r.max(g).max(b) / 128.0;
        let got = image.get_pixel(i as u32 % 7, i as u32 / 7).0;
        for (got, expected) in got.into_iter().zip([r, g, b]) {
            assert!(
                (f64::from(got) - expected).abs() <= step,
                "{i}: {got} {expected}"
            );
        }
    }
}

#[test]
fn tone_maps_stay_in_range_and_order() {
    for map in [
        Tonemap::Linear,
        Tonemap::Neutral,
        Tonemap::Aces,
        Tonemap::Agx,
    ] {
        let mut last = 0.0;
        for step in 0..4000 {
            let x = (f64::from(step) / 100.0 - 20.0).exp2();
            let grey = map.apply([x; 3]);
            assert!(grey[0] >= last - 1e-12, "{map:?} falls at {x}");
            last = grey[0];
            for rgb in [[x; 3], [x, 0.0, 0.0], [0.1, x, 0.0], [x, x, 2.0 * x]] {
                let shown = map.apply(rgb);
                assert!(
                    shown.iter().all(|v| (0.0..=1.0).contains(v)),
                    "{map:?} {rgb:?} {shown:?}"
                );
            }
        }
        assert!(last > 0.95, "{map:?} never becomes white");
        assert!(map.apply([0.0; 3])[0] < 1e-3, "{map:?} has grey for black");
        assert_eq!(map.apply([f64::NAN, -1.0, 0.0]), map.apply([0.0; 3]));
        let white = map.apply([f64::INFINITY; 3]);
        assert!(white.iter().all(|&v| v > 0.95 && v <= 1.0), "{map:?}");
    }
}

#[test]
fn neutral_keeps_colours_below_the_shoulder() {
    // Specification: below the compression only the Fresnel offset is taken off, at most 0.04, so a
    // base colour lit to 1 plus its 4 % of reflection shows as the base colour.
    for base in [[0.3, 0.5, 0.7], [0.04, 0.4, 0.2], [0.7, 0.1, 0.6]] {
        let lit = base.map(|c: f64| c + 0.04);
        for (got, expected) in Tonemap::Neutral.apply(lit).into_iter().zip(base) {
            assert!((got - expected).abs() < 1e-9, "{lit:?}");
        }
    }
    // Continuous where the compression starts.
    let below = Tonemap::Neutral.apply([0.8 - 1e-9; 3])[0];
    let above = Tonemap::Neutral.apply([0.8 + 1e-9; 3])[0];
    assert!((below - 0.76).abs() < 1e-8 && (above - 0.76).abs() < 1e-8);
    // By hand: peak 4 - 0.04 = 3.96, so 1 - 0.24^2 / (3.96 + 0.24 - 0.76).
    let bright = Tonemap::Neutral.apply([4.0; 3])[0];
    assert!((bright - (1.0 - 0.0576 / 3.44)).abs() < 1e-12, "{bright}");
}

#[test]
fn aces_and_agx_have_their_known_values() {
    // The rational fit alone for grey, since both matrices' rows sum to 1 within 1e-4:
    // (0.18 * 0.2045786 - 0.000090537) / (0.18 * (0.17707122 + 0.432951) + 0.238081).
    let grey = Tonemap::Aces.apply([0.18; 3])[0];
    assert!((grey - 0.105_623).abs() < 1e-4, "{grey}");
    // Sobotka's curve has its pivot at middle grey, 10 of 16.5 stops up, with the code value 0.5; the
    // fit misses that by 0.003.
    let grey = Tonemap::Agx.apply([0.18; 3]);
    for x in grey {
        assert!((x.powf(1.0 / 2.2) - 0.5).abs() < 0.004, "{grey:?}");
    }
    // A pure strong colour goes to white in AgX and stays saturated in the linear map.
    let red = Tonemap::Agx.apply([100.0, 0.0, 0.0]);
    assert!(red[1] > 0.1 && red[2] > 0.1, "{red:?}");
    assert_eq!(Tonemap::Linear.apply([100.0, 0.0, 0.0]), [1.0, 0.0, 0.0]);
}

fn place(path: &Path) -> Place {
    Place::File(path.to_owned())
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn all_outputs_are_written_or_none() {
    let folder = tempfile::tempdir().unwrap();
    let good = place(&folder.path().join("good.png"));
    let bad = place(&folder.path().join("missing/bad.png"));
    fs::write(folder.path().join("good.png"), b"old").unwrap();
    let error = write_all(&[(&good, b"new"), (&bad, b"new")]).unwrap_err();
    assert!(error.to_string().contains("bad.png"), "{error}");
    assert_eq!(fs::read(folder.path().join("good.png")).unwrap(), b"old");
    assert_eq!(names(folder.path()), ["good.png"]);

    let second = place(&folder.path().join("second.png"));
    write_all(&[(&good, b"new"), (&second, b"other")]).unwrap();
    assert_eq!(fs::read(folder.path().join("good.png")).unwrap(), b"new");
    assert_eq!(names(folder.path()), ["good.png", "second.png"]);
}

#[cfg(unix)]
#[test]
fn outputs_are_as_open_as_other_files_and_links_stay_links() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let ordinary = folder.path().join("ordinary");
    fs::write(&ordinary, b"").unwrap();
    let picture = folder.path().join("a.png");
    let link = folder.path().join("link.png");
    write_all(&[(&place(&picture), b"1")]).unwrap();
    let mode = |p: &Path| fs::metadata(p).unwrap().permissions().mode();
    assert_eq!(mode(&picture), mode(&ordinary));
    std::os::unix::fs::symlink(&picture, &link).unwrap();
    write_all(&[(&place(&link), b"2")]).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(fs::read(&picture).unwrap(), b"2");
}

#[test]
fn targets_are_checked_before_rendering() {
    let folder = tempfile::tempdir().unwrap();
    let target = |name: &str| Target::parse(&folder.path().join(name));
    assert!(matches!(
        target("a.bmp"),
        Err(OutputError::UnknownEnding(_))
    ));
    assert!(matches!(
        target("plain"),
        Err(OutputError::UnknownEnding(_))
    ));
    assert_eq!(target("a.JPG").unwrap().format, Format::Jpeg);
    let stdout = Target::parse(Path::new("-")).unwrap();
    assert_eq!(
        (&stdout.place, stdout.format),
        (&Place::Stdout, Format::Png)
    );

    let fine = target("a.png").unwrap().place;
    check(&[&fine, &stdout.place]).unwrap();
    assert!(names(folder.path()).is_empty(), "checking leaves nothing");
    assert!(matches!(check(&[&fine, &fine]), Err(OutputError::Twice(_))));
    let nowhere = target("no/a.png").unwrap().place;
    assert!(matches!(
        check(&[&fine, &nowhere]),
        Err(OutputError::Folder { .. })
    ));
    fs::create_dir(folder.path().join("folder.png")).unwrap();
    let is_folder = target("folder.png").unwrap().place;
    assert!(matches!(
        check(&[&is_folder]),
        Err(OutputError::IsFolder(_))
    ));
}
