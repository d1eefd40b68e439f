//! The same files through the `gltf` crate's own readers: an independent opinion on buffers,
//! accessors and indices, and on the tangents that exporters wrote.

use crate::asset::{corpus, models};
use gltf::accessor::DataType;
use gltf::buffer::Source;
use gltf::mesh::{Mode, Semantic};
use snell::gltf::{LoadOptions, load};
use snell::scene::Scene;
use std::path::Path;

pub fn buffers(file: &gltf::Gltf, folder: &Path) -> Option<Vec<Vec<u8>>> {
    let read = |buffer: gltf::Buffer<'_>| match buffer.source() {
        Source::Bin => file.blob.clone(),
        Source::Uri(uri) if !uri.starts_with("data:") => std::fs::read(folder.join(uri)).ok(),
        Source::Uri(_) => None,
    };
    file.buffers().map(read).collect()
}

/// The scene's primitives next to the crate's, where neither pose nor missing data changes them.
fn compare(scene: &Scene, file: &gltf::Gltf, data: &[Vec<u8>], name: &str) -> usize {
    let mut compared = 0;
    for instance in &scene.instances {
        let node = file.nodes().nth(instance.node).unwrap();
        let mesh = node.mesh().unwrap();
        if node.skin().is_some()
            || mesh.primitives().count() != scene.meshes[instance.mesh].primitives.len()
        {
            continue;
        }
        for (theirs, ours) in mesh
            .primitives()
            .zip(&scene.meshes[instance.mesh].primitives)
        {
            // The crate's readers panic on the types that KHR_mesh_quantization adds.
            let quantized = theirs.attributes().any(|(semantic, accessor)| {
                matches!(semantic, Semantic::Positions | Semantic::Normals)
                    && accessor.data_type() != DataType::F32
            });
            if quantized || theirs.morph_targets().len() > 0 {
                continue;
            }
            let reader = theirs.reader(|buffer| data.get(buffer.index()).map(Vec::as_slice));
            let (Some(normals), Mode::Triangles) = (reader.read_normals(), theirs.mode()) else {
                continue;
            };
            let positions: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
            let normals: Vec<[f32; 3]> = normals.collect();
            let texcoords: Option<Vec<[f32; 2]>> = reader
                .read_tex_coords(0)
                .map(|set| set.into_f32().collect());
            let colors: Option<Vec<[f32; 4]>> = reader
                .read_colors(0)
                .map(|set| set.into_rgba_f32().collect());
            let indices: Vec<u32> = match reader.read_indices() {
                Some(indices) => indices.into_u32().collect(),
                None => (0..positions.len() as u32).collect(),
            };
            let theirs = indices
                .chunks_exact(3)
                .filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
            // Vertices may have been split for tangents: corners are compared, not numbers.
            let pairs: Vec<_> = theirs.zip(&ours.triangles).collect();
            assert_eq!(pairs.len(), ours.triangles.len(), "{name}");
            for (their_corner, our_corner) in pairs
                .into_iter()
                .flat_map(|(a, b)| a.iter().copied().zip(*b))
            {
                let (a, b) = (their_corner as usize, our_corner as usize);
                assert_eq!(positions[a], ours.positions[b].to_array(), "{name}");
                let normal = glam::Vec3::from(normals[a]).normalize_or_zero();
                if normal != glam::Vec3::ZERO {
                    assert!((normal - ours.normals[b]).length() < 1e-6, "{name}");
                }
                if let Some(texcoords) = &texcoords {
                    assert_eq!(texcoords[a], ours.texcoords[0][b].to_array(), "{name}");
                }
                if let Some(colors) = &colors {
                    let color = ours.colors.as_ref().unwrap()[b];
                    assert!(
                        (color - glam::Vec4::from(colors[a])).length() < 1e-6,
                        "{name}"
                    );
                }
            }
            compared += 1;
        }
    }
    compared
}

#[test]
fn another_reader_sees_the_same_vertices() {
    let Some(corpus) = corpus() else {
        println!("NOT RUN: there is no corpus of models beside this checkout");
        return;
    };
    let mut compared = 0;
    for path in models(&corpus) {
        let Ok(loaded) = load(&path, &LoadOptions::default()) else {
            continue;
        };
        let bytes = std::fs::read(&path).unwrap();
        let Ok(file) = gltf::Gltf::from_slice_without_validation(&bytes) else {
            println!("{}: the other reader refuses it", path.display());
            continue;
        };
        if let Some(data) = buffers(&file, path.parent().unwrap()) {
            compared += compare(&loaded.scene, &file, &data, &path.display().to_string());
        }
    }
    assert!(compared > 100, "{compared} primitives");
}

/// MikkTSpace on a model whose exporter wrote its tangents: they are made anew and compared.
#[test]
fn generated_tangents_agree_with_an_exporters() {
    let Some(corpus) = corpus() else {
        println!("NOT RUN: there is no corpus of models beside this checkout");
        return;
    };
    let path = corpus.join("core/FlightHelmet/FlightHelmet.gltf");
    let text = std::fs::read_to_string(&path).unwrap();
    let given = load(&path, &LoadOptions::default()).unwrap().scene;
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(path.parent().unwrap()).unwrap() {
        let entry = entry.unwrap();
        std::fs::copy(entry.path(), folder.path().join(entry.file_name())).unwrap();
    }
    // Attributes with a leading underscore are the application's own.
    let stripped = folder.path().join("FlightHelmet.gltf");
    std::fs::write(&stripped, text.replace("\"TANGENT\"", "\"_TANGENT\"")).unwrap();
    let made = load(&stripped, &LoadOptions::default()).unwrap().scene;
    let (mut good, mut total) = (0, 0);
    for (a, b) in given.meshes.iter().zip(&made.meshes) {
        for (a, b) in a.primitives.iter().zip(&b.primitives) {
            let (Some(x), Some(y)) = (&a.tangents, &b.tangents) else {
                continue;
            };
            for (a, b) in a.triangles.iter().zip(&b.triangles) {
                for (a, b) in a.iter().zip(b) {
                    let (x, y) = (x[*a as usize], y[*b as usize]);
                    total += 1;
                    good += usize::from(x.w == y.w && x.truncate().dot(y.truncate()) > 0.9);
                }
            }
        }
    }
    println!("{good} of {total} corners agree");
    assert!(
        total > 10_000 && good as f64 > 0.95 * f64::from(total as u32),
        "{good}/{total}"
    );
}
