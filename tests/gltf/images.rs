//! Images in the less common forms of their formats.

use crate::asset::{Asset, png, png_of};
use image::ImageFormat;
use serde_json::json;
use snell::scene::{Image, Pixels};
use std::io::Cursor;
use std::sync::Arc;

fn decoded(bytes: &[u8]) -> Arc<Image> {
    let mut asset = Asset::triangle();
    let texture = asset.texture(bytes);
    let texture = json!({"baseColorTexture": {"index": texture}});
    let asset = asset.with_material(json!({"pbrMetallicRoughness": texture}));
    Arc::clone(&asset.load().scene.images[0])
}

#[track_caller]
fn assert_bytes(bytes: &[u8], size: [u32; 2], expected: &[u8]) {
    let image = decoded(bytes);
    assert_eq!([image.width, image.height], size);
    match &image.pixels {
        Pixels::Rgba8(found) => assert_eq!(found, expected),
        Pixels::Rgba16(found) => panic!("16 bits: {found:?}"),
    }
}

#[track_caller]
fn assert_words(bytes: &[u8], expected: &[u16]) {
    match &decoded(bytes).pixels {
        Pixels::Rgba16(found) => assert_eq!(found, expected),
        Pixels::Rgba8(found) => panic!("8 bits: {found:?}"),
    }
}

const GREY: u8 = 0;
const RGB: u8 = 2;
const PALETTE: u8 = 3;
const GREY_ALPHA: u8 = 4;
const RGBA: u8 = 6;

#[test]
fn sixteen_bits_of_every_colour_type() {
    let grey = png(1, 2, 16, GREY, &[], &[0, 0x12, 0x34, 0, 0xab, 0xcd]);
    assert_words(
        &grey,
        &[
            0x1234, 0x1234, 0x1234, 0xffff, 0xabcd, 0xabcd, 0xabcd, 0xffff,
        ],
    );
    let grey_alpha = png(1, 1, 16, GREY_ALPHA, &[], &[0, 0x12, 0x34, 0x56, 0x78]);
    assert_words(&grey_alpha, &[0x1234, 0x1234, 0x1234, 0x5678]);
    let rgba = png(1, 1, 16, RGBA, &[], &[0, 1, 2, 3, 4, 5, 6, 7, 8]);
    assert_words(&rgba, &[0x0102, 0x0304, 0x0506, 0x0708]);
    // A colour that is transparent, and one that differs in a low byte.
    let key = [0x12, 0x34];
    let keyed = png_of(
        [2, 1],
        [16, GREY, 0],
        &[],
        &key,
        &[0, 0x12, 0x34, 0x12, 0x35],
    );
    assert_words(
        &keyed,
        &[0x1234, 0x1234, 0x1234, 0, 0x1235, 0x1235, 0x1235, 0xffff],
    );
}

#[test]
fn transparency_beside_the_colours() {
    // Fewer alphas than colours: the rest are opaque.
    let palette = [1, 2, 3, 4, 5, 6, 7, 8, 9];
    let indexed = png_of([3, 1], [8, PALETTE, 0], &palette, &[0, 77], &[0, 2, 1, 0]);
    assert_bytes(&indexed, [3, 1], &[7, 8, 9, 255, 4, 5, 6, 77, 1, 2, 3, 0]);
    // Two bits a texel: 0, 1, 2, 1 and a row that ends within its byte.
    let narrow = png_of([3, 1], [2, PALETTE, 0], &palette, &[9], &[0, 0b0001_1000]);
    assert_bytes(&narrow, [3, 1], &[1, 2, 3, 9, 4, 5, 6, 255, 7, 8, 9, 255]);
    let keyed = png_of(
        [2, 1],
        [8, RGB, 0],
        &[],
        &[0, 1, 0, 2, 0, 3],
        &[0, 1, 2, 3, 1, 2, 4],
    );
    assert_bytes(&keyed, [2, 1], &[1, 2, 3, 0, 1, 2, 4, 255]);
    let grey_alpha = png(1, 1, 8, GREY_ALPHA, &[], &[0, 5, 6]);
    assert_bytes(&grey_alpha, [1, 1], &[5, 5, 5, 6]);
}

#[test]
fn interlaced_texels_come_into_their_rows() {
    // (first column, first row, step in columns, in rows) of the seven passes: PNG section 8.2.
    const PASSES: [[usize; 4]; 7] = [
        [0, 0, 8, 8],
        [4, 0, 8, 8],
        [0, 4, 4, 8],
        [2, 0, 4, 4],
        [0, 2, 2, 4],
        [1, 0, 2, 2],
        [0, 1, 1, 2],
    ];
    let [width, height] = [11, 7];
    let mut stream = Vec::new();
    for [x, y, step_x, step_y] in PASSES {
        for y in (y..height).step_by(step_y) {
            stream.push(0);
            stream.extend((x..width).step_by(step_x).map(|x| (y * width + x) as u8));
        }
    }
    let expected: Vec<u8> = (0..77).flat_map(|i| [i, i, i, 255]).collect();
    let bytes = png_of([11, 7], [8, GREY, 1], &[], &[], &stream);
    assert_bytes(&bytes, [11, 7], &expected);
}

#[test]
fn webp_of_grey_and_of_lost_detail() {
    let grey = image::GrayAlphaImage::from_fn(3, 5, |x, y| {
        image::LumaA([(9 * x + y) as u8, 100 + y as u8])
    });
    let mut bytes = Vec::new();
    grey.write_to(&mut Cursor::new(&mut bytes), ImageFormat::WebP)
        .unwrap();
    let expected: Vec<u8> = grey
        .pixels()
        .flat_map(|p| [p.0[0], p.0[0], p.0[0], p.0[1]])
        .collect();
    assert_bytes(&bytes, [3, 5], &expected);
    // 4 x 4 texels of (200, 100, 50, 128), lossy, by libwebp.
    let lossy = hex(&[
        "524946465e00000057454250565038580a00000010000000030000030000414c50480a0000000107",
        "50c088084444ff03565038202e000000f001009d012a0400040001402625a00274ba01f80004c800",
        "00feae17ff36040cd0fa60ffd26cf136789b3e398000",
    ]);
    assert_near(&lossy, [4, 4], [200, 100, 50, 128]);
}

#[test]
fn jpeg_of_four_inks_and_in_passes() {
    // 8 x 8 texels of cyan 204, magenta 51, yellow 0, black 26 of 255, stored inverted as Adobe's marker
    // says, by libjpeg.
    let inks = hex(&[
        "ffd8ffee000e41646f626500640000000000ffdb0043000201010101010201010102020202020403",
        "020202020504040304060506060605060606070908060709070606080b08090a0a0a0a0a06080b0c",
        "0b0a0c090a0a0affc000140800080008044311004d11005911004b1100ffc4001400010000000000",
        "0000000000000000000009ffc40014100100000000000000000000000000000000ffda000e044300",
        "4d0059004b00003f0032c981fc328fffd9",
    ]);
    // What each pair of inks lets through: (255 - 204) (255 - 26) / 255 and so on.
    assert_near(&inks, [8, 8], [46, 183, 229, 255]);
    // 8 x 8 texels of grey 150, progressive.
    let passes = hex(&[
        "ffd8ffe000104a46494600010100000100010000ffdb004300020101010101020101010202020202",
        "0403020202020504040304060506060605060606070908060709070606080b08090a0a0a0a0a0608",
        "0b0c0b0a0c090a0a0affc2000b080008000801011100ffc400140001000000000000000000000000",
        "00000006ffda000801010000000159ffc40014100100000000000000000000000000000000ffda00",
        "080101000105027fffc40014100100000000000000000000000000000000ffda0008010100063f02",
        "7fffc40014100100000000000000000000000000000000ffda0008010100013f217fffda00080101",
        "000000107fffc40014100100000000000000000000000000000000ffda0008010100013f107fffd9",
    ]);
    assert_near(&passes, [8, 8], [150, 150, 150, 255]);
}

fn hex(rows: &[&str]) -> Vec<u8> {
    let digits: Vec<u8> = rows
        .concat()
        .bytes()
        .map(|d| (d as char).to_digit(16).unwrap() as u8)
        .collect();
    digits
        .as_chunks::<2>()
        .0
        .iter()
        .map(|[high, low]| high << 4 | low)
        .collect()
}

/// One colour, within the few steps that lossy coding moves it.
#[track_caller]
fn assert_near(bytes: &[u8], size: [u32; 2], expected: [u8; 4]) {
    let image = decoded(bytes);
    assert_eq!([image.width, image.height], size);
    let Pixels::Rgba8(found) = &image.pixels else {
        panic!("16 bits");
    };
    for (found, expected) in found.iter().zip(expected.iter().cycle()) {
        assert!(found.abs_diff(*expected) <= 3, "{found}, not {expected}");
    }
}
