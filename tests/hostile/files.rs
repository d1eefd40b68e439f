//! Files that are not there, cut off, too large, or not theirs to read.

use crate::asset::{Asset, load_bytes};
use crate::{edited, expect, invalid};
use serde_json::json;
use snell::gltf::{GltfError, LoadOptions, load};
use std::path::Path;

#[test]
fn missing_and_irregular_files() {
    let folder = tempfile::tempdir().unwrap();
    for (path, words) in [
        (folder.path().join("missing.gltf"), "No such file"),
        (folder.path().to_owned(), "not a regular file"),
    ] {
        let result = load(&path, &LoadOptions::default()).map(|_| ());
        expect(result, 3, "", words);
    }
    let empty = folder.path().join("empty.glb");
    std::fs::write(&empty, b"").unwrap();
    expect(
        load(&empty, &LoadOptions::default()).map(|_| ()),
        3,
        "",
        "neither",
    );
    for text in ["[]", "{", "not JSON", "null", "\u{feff}{}"] {
        let error = load_bytes(text.as_bytes(), &LoadOptions::default()).unwrap_err();
        assert_eq!(error.exit_status(), 3, "{text}");
    }
}

#[test]
fn a_glb_cut_off_anywhere() {
    let whole = Asset::triangle().glb();
    assert!(load_bytes(&whole, &LoadOptions::default()).is_ok());
    for length in 0..whole.len() {
        let error = load_bytes(&whole[..length], &LoadOptions::default()).unwrap_err();
        assert!(
            matches!(error, GltfError::Invalid { .. }),
            "{length}: {error}"
        );
        if length >= 12 {
            assert!(error.to_string().contains("cut off"), "{error}");
        }
        // With a length that fits, the chunks show it.
        if length >= 12 {
            let mut bytes = whole[..length].to_vec();
            bytes[8..12].copy_from_slice(&(length as u32).to_le_bytes());
            let error = load_bytes(&bytes, &LoadOptions::default()).unwrap_err();
            assert_eq!(error.exit_status(), 3, "{length}: {error}");
        }
    }
    for (at, value) in [
        (4, 1u32),
        (4, 3),
        (8, 4),
        (8, u32::MAX),
        (12, u32::MAX),
        (16, 0),
    ] {
        let mut bytes = whole.clone();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        let error = load_bytes(&bytes, &LoadOptions::default()).unwrap_err();
        assert!(error.to_string().contains("GLB"), "{error}");
    }
}

#[test]
fn versions() {
    invalid(
        &edited(|json| json["asset"] = json!({"version": "1.0"})),
        "asset.version",
        "1.0",
    );
    invalid(
        &edited(|json| json["asset"] = json!({})),
        "asset",
        "`version` is missing",
    );
    invalid(
        &edited(|json| drop(json.as_object_mut().unwrap().remove("asset"))),
        "",
        "`asset`",
    );
    let newer = json!({"version": "2.5", "minVersion": "2.5"});
    invalid(
        &edited(|json| json["asset"] = newer),
        "asset.minVersion",
        "2.5",
    );
    assert!(
        edited(|json| json["asset"] = json!({"version": "2.5"}))
            .try_load()
            .is_ok()
    );
}

#[test]
fn a_ceiling_on_memory() {
    let options = LoadOptions {
        max_memory: 100,
        ..LoadOptions::default()
    };
    let error = load_bytes(&Asset::triangle().glb(), &options).unwrap_err();
    assert_eq!((error.exit_status(), error.at()), (6, ""));
}

/// A scene whose buffer is at `uri`, in `folder`.
fn with_uri(folder: &Path, uri: &str, options: &LoadOptions) -> Result<(), GltfError> {
    let asset = edited(|json| json["buffers"] = json!([{"byteLength": 36, "uri": uri}]));
    let path = folder.join("scene.gltf");
    std::fs::write(&path, asset.json.to_string()).unwrap();
    load(&path, options).map(|_| ())
}

#[test]
fn paths_that_lead_outside() {
    let top = tempfile::tempdir().unwrap();
    let inside = top.path().join("inside");
    let outside = top.path().join("outside");
    std::fs::create_dir_all(inside.join("sub")).unwrap();
    std::fs::create_dir(&outside).unwrap();
    let data = Asset::triangle().bin;
    for place in [
        inside.join("sub/in.bin"),
        inside.join("in.bin"),
        outside.join("out.bin"),
    ] {
        std::fs::write(place, &data).unwrap();
    }
    let plain = LoadOptions::default();
    let uri = |uri: &str| with_uri(&inside, uri, &plain);
    uri("in.bin").unwrap();
    uri("./sub/in.bin").unwrap();
    uri("sub%2Fin.bin").unwrap();
    uri("sub\\in.bin").unwrap();
    let absolute = outside.join("out.bin").display().to_string();
    for escape in [
        "../outside/out.bin",
        "..%2foutside%2Fout.bin",
        "..\\outside\\out.bin",
        &absolute,
        "sub/../../outside/out.bin",
        "../missing.bin",
        "/etc/passwd",
        "/missing",
        "../inside/in.bin",
    ] {
        let result = uri(escape);
        assert!(
            matches!(result, Err(GltfError::Forbidden { .. })),
            "{escape}: {result:?}"
        );
        expect(result, 3, "buffers[0].uri", "outside");
    }
    for url in [
        "http://example.com/a.bin",
        "file:///etc/passwd",
        "ftp:a",
        "C:/a.bin",
    ] {
        expect(uri(url), 3, "buffers[0].uri", "URLs are not read");
    }
    expect(uri("missing.bin"), 3, "buffers[0].uri", "missing.bin");
    expect(uri("sub"), 3, "buffers[0].uri", "regular");
    expect(uri(""), 3, "buffers[0].uri", "regular");
    expect(uri("a%00b"), 3, "buffers[0].uri", "zero byte");
    expect(uri("a%ffb"), 3, "buffers[0].uri", "UTF-8");
    let wider = LoadOptions {
        allow_paths: vec![outside.clone()],
        ..LoadOptions::default()
    };
    for allowed in ["../outside/out.bin", &absolute] {
        with_uri(&inside, allowed, &wider).unwrap();
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(outside.join("out.bin"), inside.join("link.bin")).unwrap();
        std::os::unix::fs::symlink(inside.join("in.bin"), inside.join("own.bin")).unwrap();
        expect(uri("link.bin"), 3, "buffers[0].uri", "outside");
        uri("own.bin").unwrap();
        with_uri(&inside, "link.bin", &wider).unwrap();
    }
}

#[test]
fn data_uris_that_are_none() {
    let folder = tempfile::tempdir().unwrap();
    for (uri, words) in [
        ("data:", "no comma"),
        ("data:;base64,****", "base64"),
        ("data:;base64,AAAAA", "base64"),
        ("data:;base64,AAAA", "only 3 bytes"),
        ("data:,abc", "only 3 bytes"),
    ] {
        let error = with_uri(folder.path(), uri, &LoadOptions::default()).unwrap_err();
        assert_eq!(error.exit_status(), 3);
        assert!(error.to_string().contains(words), "{uri}: {error}");
    }
}
