//! Pictures of differences, for the eye of whoever reads a failed test.

use std::fs;
use std::io;
use std::path::Path;

use crate::film::{Film, FilmPixel};
use crate::output::tonemap::Tonemap;
use crate::output::{Channels, Format, Look, Window, encode};

/// Writes `NAME-a.png`, `NAME-b.png` and `NAME-error.png` to `folder`, which is made where missing.
/// The error map is black where the films agree; red is where a is brighter, blue where b is, and full
/// brightness is a relative error of 1 (logarithmic, four decades down to black).
pub fn write_maps(folder: &Path, name: &str, a: &Film, b: &Film) -> io::Result<()> {
    fs::create_dir_all(folder)?;
    let map = error_map(a, b);
    let shown = [
        ("a", a, Tonemap::Neutral),
        ("b", b, Tonemap::Neutral),
        ("error", &map, Tonemap::Linear),
    ];
    for (suffix, film, tonemap) in shown {
        let look = Look {
            exposure_ev: 0.0,
            tonemap,
        };
        let png = encode(
            film,
            Format::Png,
            Channels::default(),
            look,
            Window::whole(film),
            "",
        )
        .map_err(io::Error::other)?;
        fs::write(folder.join(format!("{name}-{suffix}.png")), png)?;
    }
    Ok(())
}

/// The map itself, as a film of one sample.
fn error_map(a: &Film, b: &Film) -> Film {
    const DECADES: f64 = 4.0;
    let mut map = Film::new(a.width, a.height);
    for ((pixel, pa), pb) in map.pixels.iter_mut().zip(&a.pixels).zip(&b.pixels) {
        let (ma, mb) = (level(pa), level(pb));
        let error = (ma - mb).abs() / ma.abs().max(mb.abs());
        let brightness = if ma == mb {
            0.0
        } else if error.is_finite() {
            (1.0 + error.log10() / DECADES).clamp(0.0, 1.0)
        } else {
            1.0
        };
        let color = if ma > mb {
            [brightness, 0.0, 0.0]
        } else {
            [0.0, 0.0, brightness]
        };
        pixel.add(color, 1.0);
    }
    map
}

fn level(pixel: &FilmPixel) -> f64 {
    pixel.mean().iter().sum::<f64>()
}
