//! `snell info`: what is in a glTF file, and what a picture will show of it.

use std::fmt::Write;
use std::path::PathBuf;

use serde::Serialize;

use super::doctor::bytes;
use crate::error::Error;
use crate::gltf::{
    self, AnimationInfo, Asset, Counts, ExtensionUse, LoadOptions, Loaded, Metadata, Moment, Skin,
    Treatment,
};
use crate::scene::{Pixels, Projection, PunctualKind};

/// Which file, and how to say it.
#[derive(Debug, clap::Args)]
pub struct InfoArgs {
    /// A .gltf or .glb file.
    pub scene: PathBuf,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
    /// A folder beside the scene's own that it may read; repeat for more.
    #[arg(long, value_name = "FOLDER")]
    pub allow_path: Vec<PathBuf>,
    /// The most memory that the scene may take, in MiB.
    #[arg(long, value_name = "MIB", default_value_t = gltf::DEFAULT_MAX_MEMORY >> 20)]
    pub max_memory: u64,
}

/// What there is to say, as JSON has it: see schema/info.schema.json.
#[derive(Serialize)]
struct Info {
    file: PathBuf,
    counts: Counts,
    bounds: Option<[[f32; 3]; 2]>,
    cameras: Vec<Named>,
    lights: Vec<Named>,
    animations: Vec<AnimationInfo>,
    variants: Vec<String>,
    skins: Vec<Skin>,
    materials: Vec<String>,
    images: Vec<ImageInfo>,
    extensions: Vec<ExtensionUse>,
    metadata: Vec<Metadata>,
    notes: Vec<String>,
    default_camera: bool,
    default_light: bool,
}

#[derive(Serialize)]
struct Named {
    name: String,
    kind: &'static str,
}

#[derive(Serialize)]
struct ImageInfo {
    name: String,
    format: &'static str,
    width: u32,
    height: u32,
    bits: u32,
}

/// Loads the scene and prints what is in it.
pub fn run(args: &InfoArgs) -> Result<(), Error> {
    let options = LoadOptions {
        allow_paths: args.allow_path.clone(),
        max_memory: args.max_memory.saturating_mul(1 << 20),
        ..LoadOptions::default()
    };
    let mut asset = Asset::open(&args.scene, &options)?;
    let loaded = asset.scene(&Moment::Rest)?;
    let info = info(args, &asset, loaded)?;
    if args.json {
        let json = serde_json::to_string_pretty(&info).expect("an Info has string keys only");
        super::print(&(json + "\n"))
    } else {
        super::print(&text(&info))
    }
}

fn info(args: &InfoArgs, asset: &Asset, loaded: Loaded) -> Result<Info, Error> {
    let Loaded {
        scene,
        extensions,
        notes,
        counts,
        metadata,
        default_light,
        image_time: _,
    } = loaded;
    let bounds = gltf::bounds(&scene);
    Ok(Info {
        file: args.scene.clone(),
        counts,
        bounds: bounds.map(|(low, high)| [low.to_array(), high.to_array()]),
        default_camera: scene.cameras.is_empty(),
        default_light,
        cameras: scene
            .cameras
            .into_iter()
            .map(|camera| Named {
                name: camera.name,
                kind: match camera.projection {
                    Projection::Perspective { .. } => "perspective",
                    Projection::Orthographic { .. } => "orthographic",
                    Projection::Panorama => "panorama",
                    Projection::Intrinsics(_) => "intrinsics",
                },
            })
            .collect(),
        lights: scene
            .lights
            .into_iter()
            .map(|light| Named {
                name: light.name,
                kind: match light.kind {
                    PunctualKind::Point => "point",
                    PunctualKind::Spot { .. } => "spot",
                    PunctualKind::Directional => "directional",
                    PunctualKind::Profile { .. } => "profile",
                },
            })
            .collect(),
        materials: scene
            .materials
            .into_iter()
            .map(|material| material.name)
            .collect(),
        images: scene
            .images
            .into_iter()
            .zip(asset.image_formats())
            .map(|(image, format)| ImageInfo {
                name: image.name.clone(),
                format,
                width: image.width,
                height: image.height,
                bits: match image.pixels {
                    Pixels::Rgba8(_) => 8,
                    Pixels::Rgba16(_) => 16,
                },
            })
            .collect(),
        animations: asset.animations(),
        variants: asset.variants(),
        skins: asset.skins()?,
        extensions,
        metadata,
        notes,
    })
}

fn text(info: &Info) -> String {
    let counts = &info.counts;
    let mut out = format!("{}\n", info.file.display());
    // Writing to a String cannot fail.
    let _ = writeln!(
        out,
        "  drawn       {} triangles in {} instances",
        counts.drawn_triangles, counts.drawn_instances
    );
    let _ = writeln!(
        out,
        "  in the file {} scenes, {} nodes, {} meshes with {} primitives, {} materials, \
         {} textures, {} images, {} cameras, {} lights, {} skins, {} animations",
        counts.scenes,
        counts.nodes,
        counts.meshes,
        counts.primitives,
        counts.materials,
        counts.textures,
        counts.images,
        counts.cameras,
        counts.lights,
        counts.skins,
        counts.animations,
    );
    let _ = writeln!(
        out,
        "  memory      {} at most, {} of it buffers",
        bytes(counts.memory_bytes),
        bytes(counts.buffer_bytes)
    );
    if let Some([low, high]) = info.bounds {
        let _ = writeln!(out, "  bounds      {low:?} to {high:?} m");
    }
    for camera in &info.cameras {
        let _ = writeln!(out, "  camera      {}, {}", camera.name, camera.kind);
    }
    if info.default_camera {
        out.push_str("  camera      none: one is placed to frame the scene\n");
    }
    for light in &info.lights {
        let _ = writeln!(out, "  light       {}, {}", light.name, light.kind);
    }
    if info.default_light {
        out.push_str("  light       none: a neutral studio lights the scene, or --env does\n");
    }
    for animation in &info.animations {
        let _ = writeln!(
            out,
            "  animation   {}, {} s to {} s, {} channels",
            animation.name, animation.start, animation.end, animation.channels
        );
    }
    for variant in &info.variants {
        let _ = writeln!(out, "  variant     {variant}");
    }
    for skin in &info.skins {
        let _ = writeln!(out, "  skin        {}, {} joints", skin.name, skin.joints);
    }
    for image in &info.images {
        let _ = writeln!(
            out,
            "  image       {}, {}, {} x {}, {} bits",
            image.name, image.format, image.width, image.height, image.bits
        );
    }
    for extension in &info.extensions {
        extension_line(&mut out, extension);
    }
    for metadata in &info.metadata {
        let _ = writeln!(
            out,
            "  metadata    XMP about {} ({})",
            metadata.about.join(", "),
            metadata.at
        );
    }
    for note in &info.notes {
        let _ = writeln!(out, "  note        {note}");
    }
    out
}

/// So many places of an extension are printed.
const PLACES: usize = 4;

fn extension_line(out: &mut String, extension: &ExtensionUse) {
    let treatment = match extension.treatment {
        Treatment::Supported => "supported",
        Treatment::Approximated => "approximated",
        Treatment::Ignored => "ignored",
    };
    let _ = write!(out, "  extension   {}, {treatment}", extension.name);
    if extension.required {
        out.push_str(", required");
    }
    match (extension.declared, extension.uses) {
        (true, 0) => out.push_str(", declared and not used"),
        (false, 1..) => out.push_str(", not declared"),
        _ => {}
    }
    if !extension.detail.is_empty() {
        let _ = write!(out, ": {}", extension.detail);
    }
    if extension.uses > 0 {
        let _ = write!(out, " ({})", extension.places_text(PLACES));
    }
    out.push('\n');
}
