//! Models of others: all load.

use crate::asset::{corpus, models};
use snell::gltf::{ExtensionUse, LoadOptions, Treatment, load, load_environment};
use std::time::Instant;

#[test]
fn every_model_loads() {
    let Some(corpus) = corpus() else {
        println!("NOT RUN: there is no corpus of models beside this checkout");
        return;
    };
    let models = models(&corpus);
    assert!(models.len() > 100);
    for path in models {
        let name = path.strip_prefix(&corpus).unwrap().to_str().unwrap();
        let start = Instant::now();
        let result = load(&path, &LoadOptions::default());
        println!("{name}: {:.1} ms", start.elapsed().as_secs_f64() * 1e3);
        let loaded = result.unwrap_or_else(|error| panic!("{error}"));
        let triangles = loaded.counts.drawn_triangles;
        assert!(triangles > 0, "{name}");
        check(&loaded.scene, name);
    }
}

/// The promises that `Scene` makes.
fn check(scene: &snell::scene::Scene, name: &str) {
    for primitive in scene.meshes.iter().flat_map(|mesh| &mesh.primitives) {
        let count = primitive.positions.len();
        assert_eq!(primitive.normals.len(), count, "{name}");
        for normal in &primitive.normals {
            assert!((normal.length() - 1.0).abs() < 1e-5, "{name}: {normal}");
        }
        for tangent in primitive.tangents.iter().flatten() {
            assert!(
                (tangent.truncate().length() - 1.0).abs() < 1e-5,
                "{name}: {tangent}"
            );
            assert!(tangent.w.abs() == 1.0, "{name}: {tangent}");
        }
        assert!(
            primitive
                .tangents
                .as_ref()
                .is_none_or(|list| list.len() == count)
        );
        assert!(
            primitive
                .colors
                .as_ref()
                .is_none_or(|list| list.len() == count)
        );
        assert!(primitive.texcoords.iter().all(|list| list.len() == count));
        let corners = primitive.triangles.iter().flatten();
        assert!(
            corners.copied().all(|index| (index as usize) < count),
            "{name}"
        );
        assert!(primitive.material < scene.materials.len());
    }
    assert!(
        scene
            .instances
            .iter()
            .all(|instance| instance.mesh < scene.meshes.len())
    );
}

#[test]
fn every_environment_loads() {
    let Some(corpus) = corpus() else {
        println!("NOT RUN: there is no corpus of models beside this checkout");
        return;
    };
    for entry in std::fs::read_dir(corpus.join("env")).unwrap() {
        let path = entry.unwrap().path();
        if path
            .extension()
            .is_some_and(|ending| ending == "hdr" || ending == "exr")
        {
            let map = load_environment(&path).unwrap();
            assert_eq!(map.radiance.len(), (map.width * map.height) as usize);
        }
    }
}

#[test]
fn our_own_scenes_load_and_use_nothing_that_is_ignored() {
    let folder = std::path::PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes"));
    for path in models(&folder) {
        let loaded = load(&path, &LoadOptions::default()).unwrap();
        check(&loaded.scene, &path.display().to_string());
        assert!(!loaded.scene.cameras.is_empty(), "{}", path.display());
        let ignored = |e: &ExtensionUse| e.treatment != Treatment::Supported;
        assert!(!loaded.extensions.iter().any(ignored), "{}", path.display());
        assert_eq!(loaded.notes, [""; 0], "{}", path.display());
    }
}
