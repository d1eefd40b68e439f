//! Every file that is animated, in the midst of its first animation.

use crate::common::gpu;
use crate::every::models;
use crate::picture::*;
use snell::gltf::{AnimationChoice, Asset, LoadOptions, Moment};
use snell::pack::{Background, Packed, Packer, View};
use snell::scene::Scene;

const SIZE: [u32; 2] = [48, 36];

/// Of the way from the first key to the last: in the middle of a swing things may be as they rest.
const PART: f64 = 0.4;

/// Its animation turns nodes that hold nothing.
const STILL: &str = "blender-io/05_metallic_sphere_light/05_metallic_sphere_light.gltf";

#[test]
fn animated_files_move() {
    let Some(corpus) = corpus() else { return };
    let mut gpu = gpu();
    let mut packer = Packer::default();
    let mut faults = Vec::new();
    let mut moved = 0;
    for path in models(&corpus) {
        let name = path.strip_prefix(&corpus).unwrap().to_str().unwrap();
        let mut asset = Asset::open(&path, &LoadOptions::default())
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let Some(animation) = asset.animations().into_iter().next() else {
            continue;
        };
        let rest = asset.scene(&Moment::Rest).unwrap().scene;
        let moment = Moment::At {
            animation: AnimationChoice::Index(0),
            seconds: animation.start + PART * (animation.end - animation.start),
            shutter: 0.0,
        };
        let later = asset
            .scene(&moment)
            .unwrap_or_else(|error| panic!("{name}: {error}"))
            .scene;
        // From one place, so that it is the scene that moves.
        let view = View {
            background: Background::Transparent,
            ..view(&rest, SIZE)
        };
        let mut packed = |scene: &Scene| packer.pack(scene, &view).unwrap();
        let (rest, later) = (packed(&rest), packed(&later));
        let mut film = |packed: &Packed| on_gpu(&mut gpu, packed, &whole(packed, 1));
        let (rest, later) = (film(&rest), film(&later));
        if later.non_finite() > 0 {
            faults.push(format!("{name}: {} samples not finite", later.non_finite()));
        }
        if (rest != later) == (name == STILL) {
            faults.push(format!("{name}: differs is {}", rest != later));
        }
        moved += usize::from(rest != later);
    }
    println!("{moved} files move");
    assert!(moved > 20, "only {moved} files");
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
