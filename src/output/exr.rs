//! OpenEXR: linear Rec. 709 as 32-bit floats, lossless, with the facts of the render in the header.

use std::io::Cursor;

use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer};
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, Chromaticities, IntegerBounds, Text};
use exr::meta::header::LayerAttributes;
use exr::prelude::{SmallVec, WritableImage};

use super::{Channels, OutputError, Window};
use crate::film::{Film, FilmPixel};

/// The header attribute that holds the facts of the render as one JSON text. One and not many: the
/// exr crate keeps attributes in an unordered map, and files must come out the same each time.
pub const FACTS_ATTRIBUTE: &str = "snell";

/// R G B A, colours associated with alpha, and the further channels asked for. A crop keeps its place
/// in the whole picture: the data window within the display window.
pub fn encode(
    film: &Film,
    channels: Channels,
    window: Window,
    facts: &str,
) -> Result<Vec<u8>, OutputError> {
    let mut list: SmallVec<[AnyChannel<FlatSamples>; 4]> = SmallVec::new();
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        list.push(floats(film, name, |p| p.mean()[c]));
    }
    list.push(floats(film, "A", |p| {
        if channels.transparent {
            p.coverage()
        } else {
            1.0
        }
    }));
    if channels.variance {
        for (c, name) in ["variance.R", "variance.G", "variance.B"]
            .into_iter()
            .enumerate()
        {
            list.push(floats(film, name, |p| p.variance()[c]));
        }
    }
    if channels.samples {
        let counts = film.pixels.iter().map(|p| p.samples).collect();
        list.push(AnyChannel::new("samples", FlatSamples::U32(counts)));
    }

    let mut attributes = LayerAttributes {
        layer_position: vec2_i32(window.origin),
        software_name: Text::new_or_none(concat!("Snell ", env!("CARGO_PKG_VERSION"))),
        ..LayerAttributes::default()
    };
    if let Some(facts) = Text::new_or_none(facts) {
        attributes
            .other
            .insert(Text::from(FACTS_ATTRIBUTE), AttributeValue::Text(facts));
    }
    let layer = Layer::new(
        (film.width as usize, film.height as usize),
        attributes,
        Encoding::SMALL_LOSSLESS,
        AnyChannels::sort(list),
    );
    let mut image = Image::from_layer(layer);
    image.attributes.display_window = IntegerBounds::new(
        (0, 0),
        (window.full_size[0] as usize, window.full_size[1] as usize),
    );
    image.attributes.chromaticities = Some(REC_709);

    let mut bytes = Cursor::new(Vec::new());
    image
        .write()
        .to_buffered(&mut bytes)
        .map_err(|e| OutputError::Encode {
            format: "OpenEXR",
            reason: e.to_string(),
        })?;
    Ok(bytes.into_inner())
}

/// ITU-R BT.709-6, table 1: primaries and white point D65 as CIE xy.
const REC_709: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.30, 0.60),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.3290),
};

fn floats(film: &Film, name: &str, value: impl Fn(&FilmPixel) -> f64) -> AnyChannel<FlatSamples> {
    let values = film.pixels.iter().map(|p| value(p) as f32).collect();
    AnyChannel::new(name, FlatSamples::F32(values))
}

fn vec2_i32(v: [u32; 2]) -> Vec2<i32> {
    Vec2(v[0] as i32, v[1] as i32)
}
