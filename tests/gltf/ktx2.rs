//! KHR_texture_basisu: KTX2 images of every coding, made in code and from the corpus.

use crate::asset::{Asset, corpus, pixel_png};
use crate::etc1s_file::{Blocks, Books};
use crate::ktx2_file::{BASIS_LZ, Ktx2File, LINEAR, SRGB, solid_block};
use crate::noted;
use basis_universal::{TranscodeParameters, Transcoder, TranscoderTextureFormat};
use serde_json::{Value, json};
use snell::gltf::{Loaded, Treatment};
use snell::scene::{Image, Pixels};

const R8: u32 = 9;
const R8G8_SRGB: u32 = 22;
const R8G8B8_SRGB: u32 = 29;
const B8G8R8: u32 = 30;
const R8G8B8A8: u32 = 37;
const R8G8B8A8_SRGB: u32 = 43;
const B8G8R8A8_SRGB: u32 = 50;
const R16G16: u32 = 77;
const R16G16B16A16: u32 = 91;

/// A triangle whose base colour is the image, by KHR_texture_basisu and without a fallback.
fn asset(ktx2: &[u8]) -> Asset {
    let mut asset = Asset::triangle();
    let texture = asset.texture(ktx2);
    asset.json["textures"][texture] = json!({"extensions": {"KHR_texture_basisu": {"source": 0}}});
    asset.json["images"][0]["mimeType"] = json!("image/ktx2");
    for list in ["extensionsUsed", "extensionsRequired"] {
        asset.json[list] = json!(["KHR_texture_basisu"]);
    }
    asset.with_material(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}}))
}

fn loaded(file: &Ktx2File) -> Loaded {
    asset(&file.bytes()).load()
}

fn rgba8(image: &Image) -> &[u8] {
    match &image.pixels {
        Pixels::Rgba8(bytes) => bytes,
        Pixels::Rgba16(_) => panic!("{} is of 16 bits", image.name),
    }
}

/// A step of the generator of Marsaglia (2003), "Xorshift RNGs".
fn next(state: &mut u64) -> usize {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (*state >> 16) as usize
}

#[test]
fn plain_texels_become_rgba() {
    let level: Vec<u8> = (1..=24).collect();
    let cases: [(u32, [u32; 2], Vec<u8>); 7] = [
        (R8, [2, 1], vec![1, 0, 0, 255, 2, 0, 0, 255]),
        (R8G8_SRGB, [1, 2], vec![1, 2, 0, 255, 3, 4, 0, 255]),
        (R8G8B8_SRGB, [2, 1], vec![1, 2, 3, 255, 4, 5, 6, 255]),
        (B8G8R8, [1, 2], vec![3, 2, 1, 255, 6, 5, 4, 255]),
        (R8G8B8A8, [2, 1], (1..=8).collect()),
        (R8G8B8A8_SRGB, [1, 2], (1..=8).collect()),
        (B8G8R8A8_SRGB, [2, 1], vec![3, 2, 1, 4, 7, 6, 5, 8]),
    ];
    for (format, size, expected) in cases {
        let file = Ktx2File::new(format, size, level.clone());
        for file in [file.clone(), file.zstandard()] {
            let scene = loaded(&file).scene;
            let image = &scene.images[0];
            assert_eq!([image.width, image.height], size);
            assert_eq!(
                rgba8(image),
                expected,
                "format {format}, scheme {}",
                file.scheme
            );
        }
    }
    for (format, size, expected) in [
        (R16G16, [1, 1], vec![0x0201, 0x0403, 0, 0xffff]),
        (R16G16B16A16, [1, 1], vec![0x0201, 0x0403, 0x0605, 0x0807]),
    ] {
        let scene = loaded(&Ktx2File::new(format, size, level.clone())).scene;
        match &scene.images[0].pixels {
            Pixels::Rgba16(values) => assert_eq!(values, &expected),
            Pixels::Rgba8(_) => panic!("{format} became 8 bits"),
        }
    }
}

#[test]
fn uastc_blocks_stand_where_they_belong() {
    // 2 x 2 blocks, the right and the lower ones cut.
    let colors = [
        [1, 2, 3, 4],
        [50, 60, 70, 80],
        [255, 0, 128, 9],
        [90, 91, 92, 93],
    ];
    let level: Vec<u8> = colors.into_iter().flat_map(solid_block).collect();
    let texel = |x: usize, y: usize| colors[y / 4 * 2 + x / 4];
    for (channel, expected) in [
        (0, (|[r, g, b, _]| [r, g, b, 255]) as fn([u8; 4]) -> [u8; 4]),
        (3, |color| color),
        // Red and green, the green in the place of alpha.
        (5, |[r, _, _, a]| [r, a, 0, 255]),
    ] {
        let file = Ktx2File::uastc([6, 7], channel, level.clone());
        for file in [file.clone(), file.zstandard()] {
            let scene = loaded(&file).scene;
            let got = rgba8(&scene.images[0]).as_chunks::<4>().0.to_vec();
            for (i, got) in got.into_iter().enumerate() {
                assert_eq!(
                    got,
                    expected(texel(i % 6, i / 6)),
                    "texel {i}, channel {channel}"
                );
            }
        }
    }
}

/// Codebooks and blocks with repetitions for the encoder to make use of.
fn random_books(state: &mut u64, grey: bool, raw: bool, blocks: usize) -> (Books, [Blocks; 2]) {
    let books = Books {
        endpoints: (0..37)
            .map(|_| {
                let color: [u8; 3] = std::array::from_fn(|_| (next(state) % 32) as u8);
                let color = if grey { [color[0]; 3] } else { color };
                (color, (next(state) % 8) as u8)
            })
            .collect(),
        selectors: (0..45)
            .map(|_| std::array::from_fn(|_| next(state) as u8))
            .collect(),
        raw,
        grey,
    };
    let slices = std::array::from_fn(|_| {
        let (mut endpoint, mut selector, mut calm) = (0, 0, 0);
        (0..blocks)
            .map(|_| {
                if calm > 0 {
                    calm -= 1;
                } else {
                    if !next(state).is_multiple_of(3) {
                        endpoint = next(state) % 37;
                    }
                    if !next(state).is_multiple_of(4) {
                        selector = next(state) % 45;
                    }
                    if next(state).is_multiple_of(40) {
                        // Long runs need the first of the recent selectors.
                        selector = 0;
                        calm = next(state) % 150;
                    }
                }
                (endpoint, selector)
            })
            .collect()
    });
    (books, slices)
}

#[test]
fn etc1s_is_decoded_as_it_was_written() {
    let mut state = 0x9E37_79B9_7F4A_7C15;
    for case in 0..24 {
        let (grey, raw) = (case % 2 == 1, case % 3 == 1);
        let size = [1 + next(&mut state) % 90, 1 + next(&mut state) % 90];
        let [blocks_x, blocks_y] = size.map(|side| side.div_ceil(4));
        let (books, [color, second]) = random_books(&mut state, grey, raw, blocks_x * blocks_y);
        let sides = size.map(|side| side as u32);
        let opaque = books.file(sides, &[&color], &[0]);
        let alpha = books.file(sides, &[&color, &second], &[0, 15]);
        let green = books.file(sides, &[&color, &second], &[3, 4]);
        for (kind, file) in [("opaque", opaque), ("alpha", alpha), ("green", green)] {
            let scene = loaded(&file).scene;
            let got = rgba8(&scene.images[0]).as_chunks::<4>().0;
            for (i, got) in got.iter().enumerate() {
                let (x, y) = (i % size[0], i / size[0]);
                let (block, texel) = (y / 4 * blocks_x + x / 4, y % 4 * 4 + x % 4);
                let [r, g, b] = books.texels(color[block])[texel];
                let [_, other, _] = books.texels(second[block])[texel];
                let expected = match kind {
                    "opaque" => [r, g, b, 255],
                    "alpha" => [r, g, b, other],
                    _ => [r, other, 0, 255],
                };
                assert_eq!(
                    *got, expected,
                    "case {case}, {kind}, {size:?}, texel {x}, {y}"
                );
            }
            if kind != "green" {
                assert_eq!(
                    got.as_flattened(),
                    reference(&file.bytes(), 1),
                    "case {case}"
                );
            }
        }
    }
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

/// The largest level as it is stored.
fn level(ktx2: &[u8]) -> &[u8] {
    &ktx2[word(ktx2, 80) as usize..][..word(ktx2, 88) as usize]
}

/// The largest level of an ETC1S file as the transcoder of its authors has it.
fn reference(ktx2: &[u8], levels: usize) -> Vec<u8> {
    let size = [word(ktx2, 20), word(ktx2, 24)];
    let global = &ktx2[word(ktx2, 64) as usize..][..word(ktx2, 72) as usize];
    let level = level(ktx2);
    let mut place = 20 + 20 * levels;
    let streams = [4, 8, 12].map(|at| {
        let stream = &global[place..][..word(global, at) as usize];
        place += stream.len();
        stream
    });
    let slices: Vec<&[u8]> = [24, 32]
        .map(|at| &level[word(global, at) as usize..][..word(global, at + 4) as usize])
        .into_iter()
        .filter(|slice| !slice.is_empty())
        .collect();
    transcoded(size, &slices, Some((&global[..4], streams))).unwrap()
}

/// What the authors' transcoder makes of slices, put into the container that it reads (.basis;
/// basisu_file_headers.h of Basis Universal 1.16): of ETC1S with the numbers and streams of its
/// codebooks, or of UASTC.
fn transcoded(
    [width, height]: [u32; 2],
    slices: &[&[u8]],
    codebooks: Option<(&[u8], [&[u8]; 3])>,
) -> Option<Vec<u8>> {
    const HEADER: usize = 77;
    const SLICE: usize = 23;
    let (counts, streams) = codebooks.unwrap_or((&[0; 4], [&[]; 3]));
    let mut body = vec![0; SLICE * slices.len()];
    let mut append = |stream: &[u8]| {
        body.extend(stream);
        (HEADER + body.len() - stream.len()) as u32
    };
    let places = streams.map(&mut append);
    let slice_places: Vec<u32> = slices.iter().map(|slice| append(slice)).collect();
    for (i, slice) in slices.iter().enumerate() {
        let mut out = vec![0, 0, 0, 0, i as u8];
        for side in [width, height, width.div_ceil(4), height.div_ceil(4)] {
            out.extend((side as u16).to_le_bytes());
        }
        out.extend(slice_places[i].to_le_bytes());
        out.extend((slice.len() as u32).to_le_bytes());
        body[SLICE * i..][..out.len()].copy_from_slice(&out);
    }
    let mut basis = b"sB\x13\0".to_vec();
    basis.extend((HEADER as u16).to_le_bytes());
    basis.extend([0; 2]);
    basis.extend((body.len() as u32).to_le_bytes());
    basis.extend([0, 0, slices.len() as u8, 0, 0, 1, 0, 0]);
    basis.push(u8::from(codebooks.is_none()));
    let alpha = if slices.len() == 2 { 4 } else { 0 };
    basis.extend([u8::from(codebooks.is_some()) | alpha, 0, 0]);
    basis.extend([0; 15]);
    let lengths = streams.map(|stream| (stream.len() as u32).to_le_bytes());
    basis.extend(&counts[..2]);
    basis.extend(places[0].to_le_bytes());
    basis.extend(&lengths[0][..3]);
    basis.extend(&counts[2..]);
    basis.extend(places[1].to_le_bytes());
    basis.extend(&lengths[1][..3]);
    basis.extend(places[2].to_le_bytes());
    basis.extend(lengths[2]);
    basis.extend((HEADER as u32).to_le_bytes());
    basis.extend([0; 8]);
    assert_eq!(basis.len(), HEADER);
    basis.extend(body);
    let mut transcoder = Transcoder::new();
    transcoder.prepare_transcoding(&basis).unwrap();
    let rgba = TranscoderTextureFormat::RGBA32;
    let result = transcoder.transcode_image_level(&basis, rgba, TranscodeParameters::default());
    result.ok()
}

#[test]
fn uastc_blocks_of_every_mode_are_decoded_as_the_authors_do() {
    // The prefix codes of the 19 modes, as bits from the lowest and their number.
    const CODES: [(u128, u32); 19] = [
        (0x01, 4),
        (0x35, 6),
        (0x1d, 5),
        (0x03, 5),
        (0x13, 5),
        (0x0b, 5),
        (0x1b, 5),
        (0x07, 5),
        (0x17, 5),
        (0x0f, 5),
        (0x02, 3),
        (0x00, 2),
        (0x06, 3),
        (0x1f, 5),
        (0x0d, 5),
        (0x05, 7),
        (0x15, 6),
        (0x25, 6),
        (0x09, 4),
    ];
    const SIDE: u32 = 4 * 64;
    let mut state = 0x9E37_79B9_7F4A_7C15;
    for (mode, (code, bits)) in CODES.into_iter().enumerate() {
        let mut level = Vec::new();
        let mut refused = 0;
        while level.len() < 64 * 64 * 16 {
            let random: [u8; 16] = std::array::from_fn(|_| next(&mut state) as u8);
            let block = u128::from_le_bytes(random) >> bits << bits | code;
            let block = block.to_le_bytes();
            // A number of a pattern that there is not.
            if transcoded([4, 4], &[&block], None).is_none() {
                refused += 1;
                if refused <= 20 {
                    let file = Ktx2File::uastc([4, 4], 3, block.to_vec());
                    let error = asset(&file.bytes()).try_load().unwrap_err();
                    assert!(
                        error.to_string().contains("block data are damaged"),
                        "{error}"
                    );
                }
                continue;
            }
            level.extend(block);
        }
        let patterned = [2, 3, 4, 7, 9, 16].contains(&mode);
        assert_eq!(
            refused > 0,
            patterned,
            "mode {mode}: {refused} were refused"
        );
        let expected = transcoded([SIDE; 2], &[&level], None).unwrap();
        let scene = loaded(&Ktx2File::uastc([SIDE; 2], 3, level)).scene;
        assert_eq!(rgba8(&scene.images[0]), expected, "mode {mode}");
    }
}

#[test]
fn the_corpus_is_decoded_as_its_authors_do() {
    let Some(corpus) = corpus() else { return };
    let read = |name: &str| {
        let bytes = std::fs::read(corpus.join("compressed/ktx2").join(name)).unwrap();
        let scene = asset(&bytes).load().scene;
        let image = &scene.images[0];
        assert_eq!([image.width, image.height], [40, 40]);
        (rgba8(image).to_vec(), bytes)
    };
    let (plain, bytes) = read("2d_rgba8.ktx2");
    assert_eq!(plain, level(&bytes));
    let (etc1s, bytes) = read("2d_etc1s.ktx2");
    assert_eq!(etc1s, reference(&bytes, 6));
    let (uastc, bytes) = read("2d_uastc.ktx2");
    assert_eq!(uastc, transcoded([40; 2], &[level(&bytes)], None).unwrap());
    for (kind, image) in [("plain", plain), ("ETC1S", etc1s), ("UASTC", uastc)] {
        // White letters above; the lower quarter is of one colour.
        let brightest = |rows: &[u8]| rows.chunks(4).map(|texel| texel[2]).max().unwrap();
        let (upper, lower) = image.split_at(image.len() / 4 * 3);
        let (upper, lower) = (brightest(upper), brightest(lower));
        assert!(upper > 180 && lower < 90, "{kind}: {upper} {lower}");
    }
}

#[test]
fn the_best_source_is_taken_and_the_report_says_so() {
    let mut asset = asset(&Ktx2File::new(R8G8B8A8_SRGB, [1, 1], vec![9, 9, 9, 9]).bytes());
    let png = asset.texture(&pixel_png([1, 2, 3, 4]));
    let both = json!({"source": 1, "extensions": {"KHR_texture_basisu": {"source": 0}}});
    asset.json["textures"][png] = both;
    let sample = |asset: &Asset, texture: &Value| {
        let mut asset = asset.clone();
        asset.json["textures"][0] = texture.clone();
        let loaded = asset.load();
        let image = &loaded.scene.images[0];
        (rgba8(image).to_vec(), loaded.extensions[0].treatment)
    };
    let textures = asset.json["textures"].clone();
    assert_eq!(
        sample(&asset, &textures[0]),
        (vec![9; 4], Treatment::Supported)
    );
    assert_eq!(sample(&asset, &textures[1]).0, [9; 4]);
    let webp = json!({"extensions": {"KHR_texture_basisu": {"source": 0},
                                     "EXT_texture_webp": {"source": 1}}});
    assert_eq!(sample(&asset, &webp).0, [1, 2, 3, 4]);
}

#[test]
fn what_the_container_says_otherwise_is_noted() {
    let file = Ktx2File::new(R8G8B8A8_SRGB, [4, 4], vec![5; 64]);
    assert!(!noted(&loaded(&file), "KTX2"));
    let linear = Ktx2File {
        transfer: LINEAR,
        ..file.clone()
    };
    assert!(noted(
        &loaded(&linear),
        "says linear and is used as sRGB (materials[0]"
    ));
    let mut used_as_data = asset(&file.bytes());
    used_as_data.json["materials"][0] = json!({"normalTexture": {"index": 0}});
    assert!(noted(
        &used_as_data.load(),
        "says sRGB and is used as linear"
    ));
    let up = Ktx2File {
        values: vec![("KTXorientation", "ru")],
        ..file.clone()
    };
    assert!(noted(&loaded(&up), "another order"));
    let swizzled = Ktx2File {
        values: vec![("KTXswizzle", "bgra")],
        ..file.clone()
    };
    assert!(noted(&loaded(&swizzled), "swizzle"));
    let plain = vec![
        ("KTXswizzle", "rgba"),
        ("KTXwriter", "ru"),
        ("KTXorientation", "rd"),
    ];
    assert!(!noted(
        &loaded(&Ktx2File {
            values: plain,
            ..file.clone()
        }),
        "KTX2"
    ));
    let odd = Ktx2File {
        size: [3, 4, 0],
        ..file
    };
    assert!(noted(&loaded(&odd), "multiples of four"));
    assert_eq!(odd.transfer, SRGB);
    assert_ne!(odd.scheme, BASIS_LZ);
}
