//! The record of a render, `--report FILE.json`: all that is needed to make the picture again and to
//! judge it. `schema/report.schema.json` describes it; the EXR header holds its repeatable part.

use std::collections::BTreeMap;
use std::time::Duration;

use rayon::prelude::*;
use serde::Serialize;

use crate::film::Film;
use crate::gltf::{ExtensionUse, Metadata};
use crate::pack::Packed;

/// Everything that is known after a render.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    #[serde(flatten)]
    pub facts: Facts,
    /// Milliseconds of each stage.
    pub times_ms: Times,
    pub memory: Memory,
    /// The files written, as named on the command line.
    pub outputs: Vec<String>,
    /// KHR_xmp_json_ld, whole.
    pub metadata: Vec<Metadata>,
    /// What the scene holds and the picture does not show, and other remarks.
    pub notes: Vec<String>,
}

/// What is the same each time that the same scene is rendered in the same way on the same adapter.
#[derive(Clone, Debug, Serialize)]
pub struct Facts {
    /// Snell's version.
    pub snell: &'static str,
    pub scene: Input,
    /// `--env`.
    pub environment: Option<LitBy>,
    /// Of the arrays that the renderer read, so of everything that a picture depends on but the code.
    pub packed_hash: String,
    /// Of all shaders in the binary.
    pub shader_hash: String,
    pub adapter: Adapter,
    pub limits: BTreeMap<&'static str, u64>,
    /// Features of wgpu beyond WebGPU's defaults.
    pub features: Vec<String>,
    /// Of the whole picture, in pixels.
    pub size: [u32; 2],
    /// x, y, width, height in pixels of the whole picture.
    pub crop: [u32; 4],
    /// Running numbers of each pixel's samples: first, and one past the last.
    pub samples: [u32; 2],
    pub seed: u32,
    pub max_depth: u32,
    /// Limit of a sample's largest channel; `None`: samples are as they come.
    pub clamp: Option<f64>,
    /// Samples that the limit has darkened; `None` without one.
    pub clamped_samples: Option<u64>,
    /// What plays; `None`: the pose that the file rests in.
    pub moment: Option<Moment>,
    /// The material variant shown; `None`: the default materials.
    pub variant: Option<String>,
    /// The number of this picture in its sequence; `None`: it is the only one.
    pub frame: Option<u32>,
    pub camera: String,
    pub background: String,
    pub exposure_ev: f64,
    pub tonemap: &'static str,
    pub rays: Option<Rays>,
    /// `None` below two samples a pixel.
    pub error: Option<Achieved>,
    /// Samples that were infinite or not a number, and were left out.
    pub non_finite_samples: u64,
    pub extensions: Vec<ExtensionUse>,
}

/// Light from all around.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum LitBy {
    File(Input),
    /// As it is written on the command line.
    Computed(String),
}

/// A file that was read.
#[derive(Clone, Debug, Serialize)]
pub struct Input {
    /// Its name without the folder, so that the record does not depend on where it lies.
    pub file: String,
    pub bytes: u64,
    pub hash: String,
}

impl Input {
    pub fn of(path: &std::path::Path, bytes: &[u8]) -> Input {
        Input {
            file: path
                .file_name()
                .map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
            bytes: bytes.len() as u64,
            hash: hash(bytes),
        }
    }
}

/// When a picture is taken.
#[derive(Clone, Debug, Serialize)]
pub struct Moment {
    /// Its name or else its number, or `all`.
    pub animation: String,
    /// On the animation's clock, when the shutter opens.
    pub seconds: f64,
    /// How long the shutter is open, in seconds.
    pub shutter: f64,
}

/// What rendered.
#[derive(Clone, Debug, Serialize)]
pub struct Adapter {
    /// `gpu` (an adapter, software included) or `cpu` (the reference renderer).
    pub renderer: &'static str,
    pub name: String,
    #[serde(rename = "type")]
    pub kind: String,
    pub backend: String,
    pub driver: String,
    pub driver_info: String,
}

impl Adapter {
    pub fn cpu() -> Adapter {
        Adapter {
            renderer: "cpu",
            name: "CPU reference, float64".into(),
            kind: "software, on the CPU".into(),
            backend: "none".into(),
            driver: String::new(),
            driver_info: String::new(),
        }
    }

    pub fn gpu(info: &wgpu::AdapterInfo) -> Adapter {
        Adapter {
            renderer: "gpu",
            name: info.name.clone(),
            kind: crate::cli::doctor::kind(info.device_type).into(),
            backend: info.backend.to_string(),
            driver: info.driver.clone(),
            driver_info: info.driver_info.clone(),
        }
    }
}

/// The limits that decide what fits on an adapter.
pub fn limits_in_use(limits: &wgpu::Limits) -> BTreeMap<&'static str, u64> {
    BTreeMap::from([
        ("max_buffer_size", limits.max_buffer_size),
        (
            "max_storage_buffer_binding_size",
            limits.max_storage_buffer_binding_size,
        ),
        (
            "max_storage_buffers_per_shader_stage",
            limits.max_storage_buffers_per_shader_stage.into(),
        ),
        (
            "max_texture_dimension_2d",
            limits.max_texture_dimension_2d.into(),
        ),
        (
            "max_compute_workgroups_per_dimension",
            limits.max_compute_workgroups_per_dimension.into(),
        ),
        (
            "max_compute_invocations_per_workgroup",
            limits.max_compute_invocations_per_workgroup.into(),
        ),
    ])
}

#[derive(Clone, Copy, Debug, Serialize)]
pub struct Rays {
    pub closest: u64,
    pub shadow: u64,
}

/// The relative standard error of a pixel, averaged over the picture, and its 95 % interval.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Achieved {
    pub relative_standard_error: f64,
    pub confidence_95: [f64; 2],
}

impl Achieved {
    pub fn of(film: &Film) -> Option<Achieved> {
        film.error().map(|error| Achieved {
            relative_standard_error: error.relative,
            confidence_95: error.confidence,
        })
    }
}

/// Stages in their order; those that a renderer does not have are left out.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Times {
    pub load: f64,
    /// Of loading: reading and decoding the textures.
    pub images: f64,
    pub pack: f64,
    /// Of packing: meshes, their hierarchies, and the one over them.
    pub geometry: f64,
    /// Goes on beside loading and packing.
    pub open_adapter: f64,
    pub upload: Option<f64>,
    /// For the first picture, mostly beside packing.
    pub compile: Option<f64>,
    pub render: f64,
    /// Making the files' bytes; writing them comes after the report is made.
    pub encode: f64,
}

impl Times {
    /// A line for each stage, for people; `write`: of the files, which the record cannot hold.
    pub fn lines(&self, write: Option<f64>) -> Vec<String> {
        let part = |name: &str, whole: &str| format!("{name} (of {whole})");
        let stages = [
            ("load".into(), Some(self.load)),
            (part("images", "load"), Some(self.images)),
            ("pack".into(), Some(self.pack)),
            (part("geometry", "pack"), Some(self.geometry)),
            ("open adapter, meanwhile".into(), Some(self.open_adapter)),
            ("upload".into(), self.upload),
            ("compile, partly meanwhile".into(), self.compile),
            ("render".into(), Some(self.render)),
            ("encode".into(), write.map(|_| self.encode)),
            ("write".into(), write),
        ];
        let there = stages
            .into_iter()
            .filter_map(|(name, time): (String, _)| Some((name, time?)));
        there
            .map(|(name, time)| format!("{name:<26}{time:>10.1} ms"))
            .collect()
    }
}

pub fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// Bytes.
#[derive(Clone, Debug, Serialize)]
pub struct Memory {
    pub packed: BTreeMap<&'static str, u64>,
    /// The process's most, where the system tells.
    pub peak_resident: Option<u64>,
}

impl Memory {
    pub fn of(packed: &Packed) -> Memory {
        Memory {
            packed: arrays(packed)
                .map(|(name, bytes)| (name, bytes.len() as u64))
                .collect(),
            peak_resident: peak_resident(),
        }
    }
}

/// The arrays of a packed scene by name, the light tree's and the environment's included, as bytes.
fn arrays(packed: &Packed) -> impl Iterator<Item = (&'static str, &[u8])> {
    packed.arrays().into_iter().chain([
        ("light_nodes", bytemuck::cast_slice(&packed.light_nodes)),
        ("environment", bytemuck::cast_slice(&packed.environment)),
        (
            "environment_cells",
            bytemuck::cast_slice(&packed.environment_cells),
        ),
    ])
}

/// The hash of a packed scene: of the hashes of its arrays' pieces, and of its frame.
pub fn packed_hash(packed: &Packed) -> String {
    /// Bytes that one core takes at a time: a large scene has a gigabyte.
    const PIECE: usize = 1 << 20;
    arrays(packed)
        .map(|(_, bytes)| bytes)
        .chain([bytemuck::bytes_of(&packed.frame)])
        .fold(Fnv1a64::new(), |all, bytes| {
            let pieces: Vec<u64> = bytes
                .par_chunks(PIECE)
                .map(|piece| Fnv1a64::new().add(piece).0)
                .collect();
            all.add(&(bytes.len() as u64).to_le_bytes())
                .add(bytemuck::cast_slice(&pieces))
        })
        .text()
}

/// The hash of all shader texts.
pub fn shader_hash() -> String {
    crate::gpu::shaders::MODULES
        .iter()
        .flat_map(|(name, text)| [name.as_bytes(), text.as_bytes()])
        .fold(Fnv1a64::new(), Fnv1a64::add_part)
        .text()
}

/// FNV-1a with 64 bits (Fowler, Noll, Vo 1991). It tells versions of a file apart; it is no
/// protection against one made to collide.
struct Fnv1a64(u64);

impl Fnv1a64 {
    fn new() -> Fnv1a64 {
        Fnv1a64(0xcbf2_9ce4_8422_2325)
    }

    fn add(self, bytes: &[u8]) -> Fnv1a64 {
        const PRIME: u64 = 0x0000_0100_0000_01b3;
        Fnv1a64(bytes.iter().fold(self.0, |hash, byte| {
            (hash ^ u64::from(*byte)).wrapping_mul(PRIME)
        }))
    }

    /// Adds the length first, so that no bytes can move from one part to the next unseen.
    fn add_part(self, bytes: &[u8]) -> Fnv1a64 {
        self.add(&(bytes.len() as u64).to_le_bytes()).add(bytes)
    }

    fn text(self) -> String {
        format!("fnv1a64:{:016x}", self.0)
    }
}

/// The hash of some bytes, as it stands in reports.
pub fn hash(bytes: &[u8]) -> String {
    Fnv1a64::new().add(bytes).text()
}

/// Linux keeps the high-water mark of resident memory in `/proc/self/status`.
fn peak_resident() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kibibytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes * 1024)
}

impl Report {
    /// As written to the file: indented, one line break at the end.
    pub fn json(&self) -> String {
        let mut text =
            serde_json::to_string_pretty(self).expect("invariant: a report has only text keys");
        text.push('\n');
        text
    }
}

impl Facts {
    /// As it stands in the EXR header.
    pub fn json(&self) -> String {
        serde_json::to_string(self).expect("invariant: facts have only text keys")
    }
}
