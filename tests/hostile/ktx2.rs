//! KTX2 images that are broken or mean harm.

use crate::asset::{Asset, load_bytes};
use crate::etc1s_file::Books;
use crate::expect;
use crate::ktx2_file::{Ktx2File, ZSTANDARD, solid_block};
use serde_json::json;
use snell::gltf::LoadOptions;

const R8G8B8A8: u32 = 37;

fn asset(ktx2: &[u8]) -> Asset {
    let mut asset = Asset::triangle();
    let texture = asset.texture(ktx2);
    asset.json["textures"][texture] = json!({"extensions": {"KHR_texture_basisu": {"source": 0}}});
    asset.with_material(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}}))
}

/// One file of each coding.
fn files() -> [(&'static str, Ktx2File); 5] {
    let plain = Ktx2File::new(R8G8B8A8, [8, 8], (0..=255).collect());
    let blocks: Vec<u8> = (0..4).flat_map(|i| solid_block([i, 2, 3, 4])).collect();
    let uastc = Ktx2File::uastc([8, 8], 3, blocks);
    let books = Books {
        endpoints: (0..20).map(|i| ([i, 31 - i, 5], i & 7)).collect(),
        selectors: (0..30).map(|i| [i, 3 * i, 5 * i, 7 * i]).collect(),
        raw: false,
        grey: false,
    };
    let slices = [7, 3].map(|step| {
        (0..16)
            .map(|i| (i * step % 20, i / 5 * step % 30))
            .collect()
    });
    let etc1s = books.file([16, 16], &slices.each_ref(), &[0, 15]);
    [
        ("plain, Zstandard", plain.clone().zstandard()),
        ("UASTC, Zstandard", uastc.clone().zstandard()),
        ("plain", plain),
        ("UASTC", uastc),
        ("ETC1S", etc1s),
    ]
}

#[track_caller]
fn refused(file: &Ktx2File, words: &str) {
    expect(
        asset(&file.bytes()).try_load().map(|_| ()),
        3,
        "images[0]",
        words,
    );
}

#[test]
fn whole_files_load() {
    for (name, file) in files() {
        let loaded = asset(&file.bytes()).try_load();
        assert!(loaded.is_ok(), "{name}: {}", loaded.unwrap_err());
    }
}

#[test]
fn cut_anywhere() {
    for (name, file) in files() {
        let bytes = file.bytes();
        // Before the twelfth byte it is no KTX2 file.
        for length in 12..bytes.len() {
            let error = asset(&bytes[..length]).try_load().unwrap_err();
            assert_eq!(
                (error.exit_status(), error.at()),
                (3, "images[0]"),
                "{name} at {length}"
            );
            assert!(
                error.to_string().contains("the KTX2 image is damaged"),
                "{error}"
            );
        }
    }
}

#[test]
fn shapes_that_gltf_has_not() {
    let [.., (_, file)] = files();
    let with = |edit: &dyn Fn(&mut Ktx2File)| {
        let mut file = file.clone();
        edit(&mut file);
        file
    };
    refused(&with(&|f| f.faces = 6), "cube map");
    refused(&with(&|f| f.layers = 3), "array");
    refused(&with(&|f| f.size[2] = 2), "volume");
    refused(&with(&|f| f.size[1] = 0), "one-dimensional");
    refused(&with(&|f| f.size[0] = 0), "zero");
    refused(&with(&|f| f.scheme = 0), "ETC1S without BasisLZ");
    refused(&with(&|f| f.scheme = ZSTANDARD), "ETC1S without BasisLZ");
    refused(
        &with(&|f| f.color_model = 166),
        "BasisLZ is defined for ETC1S only",
    );
    refused(
        &with(&|f| f.vk_format = 131),
        "BasisLZ is defined for ETC1S only",
    );
    refused(&with(&|f| f.channels = vec![]), "neither one slice nor two");
    // A video's frame.
    refused(&with(&|f| f.global[20] = 2), "video");
    let [_, _, (_, plain), (_, uastc), _] = &files();
    let astc = Ktx2File {
        color_model: 162,
        ..uastc.clone()
    };
    refused(&astc, "color model 162");
    let compressed = Ktx2File {
        vk_format: 131,
        ..plain.clone()
    };
    refused(&compressed, "BC1_RGB_UNORM_BLOCK");
    let zlib = Ktx2File {
        scheme: 3,
        ..plain.clone()
    };
    refused(&zlib, "scheme 3");
}

#[test]
fn sizes_that_lie() {
    for (name, file) in files() {
        for size in [[u32::MAX; 2], [1 << 20, 4], [4, 1 << 31]] {
            let wild = Ktx2File {
                size: [size[0], size[1], 0],
                ..file.clone()
            };
            refused(&wild, "sides of up to 65536");
        }
        for levels in [u32::MAX, 1 << 20] {
            refused(
                &Ktx2File {
                    levels,
                    ..file.clone()
                },
                "list of levels",
            );
        }
        // 16 GiB of texels out of a few bytes: too little data, or more than may be had.
        let large = Ktx2File {
            size: [1 << 16, 1 << 16, 0],
            ..file.clone()
        };
        let error = asset(&large.bytes()).try_load().unwrap_err();
        let status = if name == "ETC1S" { 6 } else { 3 };
        assert_eq!(
            (error.exit_status(), error.at()),
            (status, "images[0]"),
            "{name}: {error}"
        );
    }
    let [(_, packed), ..] = files();
    refused(
        &Ktx2File {
            unpacked: 255,
            ..packed.clone()
        },
        "too short once unpacked",
    );
    let more = Ktx2File {
        size: [8, 16, 0],
        unpacked: 512,
        ..packed.clone()
    };
    refused(&more, "holds too little");
    let wild = Ktx2File {
        size: [8, 16, 0],
        unpacked: u64::MAX,
        ..packed
    };
    refused(&wild, "holds too little");
}

#[test]
fn places_outside_the_file() {
    // Header fields: the descriptor, the values, the global data, the level; offset and length.
    for (name, file) in files() {
        for (at, long) in [(48, false), (56, false), (64, true), (80, true)] {
            let width = if long { 8 } else { 4 };
            for field in [at, at + width] {
                for value in [1 << 31, u64::MAX, u64::MAX - 3, 1 << 63] {
                    let mut bytes = file.bytes();
                    bytes[field..][..width].copy_from_slice(&value.to_le_bytes()[..width]);
                    if bytes == file.bytes() || value as u32 == 0 && !long {
                        continue;
                    }
                    let error = asset(&bytes).try_load().unwrap_err();
                    assert_eq!(error.exit_status(), 3, "{name}, field {field}: {error}");
                }
            }
        }
    }
    // Streams and slices of ETC1S.
    let [.., (_, file)] = files();
    for at in [4, 8, 12, 24, 28, 32, 36] {
        let mut file = file.clone();
        file.global[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
        refused(&file, "damaged");
    }
    for at in [0, 2] {
        let mut file = file.clone();
        file.global[at..at + 2].fill(0);
        refused(&file, "codebooks are empty");
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
fn flipped_bits_end_in_a_picture_or_a_sentence() {
    const ROUNDS: usize = 2_000;
    let options = LoadOptions {
        max_memory: 64 << 20,
        ..LoadOptions::default()
    };
    let mut state = 0x9E37_79B9_7F4A_7C15;
    for (name, file) in files() {
        let whole = file.bytes();
        let (mut loaded, mut refused) = (0, 0);
        for _ in 0..ROUNDS {
            let mut bytes = whole.clone();
            for _ in 0..=next(&mut state) % 4 {
                let bit = 8 * 12 + next(&mut state) % (8 * (bytes.len() - 12));
                bytes[bit / 8] ^= 1 << (bit % 8);
            }
            match load_bytes(&asset(&bytes).glb(), &options) {
                Ok(_) => loaded += 1,
                Err(error) => {
                    refused += 1;
                    assert!([3, 6].contains(&error.exit_status()), "{name}: {error}");
                    assert!(error.at().starts_with("images[0]"), "{name}: {error}");
                }
            }
        }
        println!("{name}: {loaded} loaded, {refused} were refused");
        assert!(loaded > ROUNDS / 50 && refused > ROUNDS / 50);
    }
}
