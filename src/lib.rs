//! Snell renders glTF 2.0 to physically based images with no window, no display server and no SDK.
//!
//! # The data flow
//!
//! ```text
//! glTF -> Scene -> Packed -> { GPU kernels | CPU reference } -> Film -> EXR, PNG, ..., report
//! ```
//!
//! Each arrow goes one way, and a module uses only what stands to its left:
//!
//! - [`gltf`] reads files that nobody vouches for and leaves a checked [`scene::Scene`], with a word on
//!   each extension and on all that is not drawn.
//! - [`pack`] makes the flat arrays of [`pack::Packed`] of it: hierarchies ([`bvh`]), triangles,
//!   materials, lights, texels. This is the fork: both renderers read these same bytes, so that packing
//!   is tested by comparing them. [`shared`] has the structures that Rust and WGSL both define,
//!   [`tables`] what reflection models look up, and [`spectrum`] what colour a spectrum has.
//! - [`gpu`] opens an adapter, links `shaders/`, and runs the path loop as a wavefront of kernels:
//!   generate, trace closest, shade, trace shadow, accumulate.
//! - [`cpu`] is the same in float64, file by file the twin of `shaders/`: the reference that tests hold
//!   the kernels against, and the renderer where there is no adapter. [`cpu::path::Li`] is the whole
//!   estimator in one function; read it first.
//! - [`film`] holds sums of samples; [`output`] makes pictures of it, [`report`] the record, and
//!   [`compare`] says whether two films show the same.
//! - [`lab`] evaluates reflection functions one query at a time, [`plot`] draws figures of them, and
//!   [`cli`] is the program around it all, with [`error`] giving each failure its sentence and its exit
//!   status.
//!
//! # Conventions
//!
//! Right-handed, y up, metres, radians; colours linear Rec. 709. `wo` points to the viewer, `wi` to the
//! light, both away from the surface; in the local frame z is the shading normal. `f` is without the
//! cosine, `pdf` per solid angle, `eta` the far side's index over the near side's as seen from `wo`, and
//! `alpha` is roughness squared.
//!
//! # One picture, from Rust
//!
//! ```no_run
//! use snell::{cpu, gltf, pack, render};
//!
//! let loaded = gltf::load("scene.glb".as_ref(), &gltf::LoadOptions::default())?;
//! let view = pack::View {
//!     camera: gltf::default_camera(&loaded.scene, 4.0 / 3.0),
//!     film_size: [640, 480],
//!     seed: 0,
//!     max_depth: 12,
//!     clamp: None,
//!     background: pack::Background::Environment,
//! };
//! let packed = pack::pack(&loaded.scene, &view)?;
//! let settings = render::Settings { crop: [0, 0, 640, 480], samples: 0..16 };
//! let (film, _) = cpu::render::render(&packed, &settings, &|_| {});
//! println!("{:?}", film.pixel(320, 240).mean());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod bvh;
pub mod cli;
pub mod compare;
pub mod cpu;
pub mod error;
pub mod film;
pub mod gltf;
pub mod gpu;
pub mod lab;
pub mod output;
pub mod pack;
pub mod plot;
pub mod progress;
pub mod render;
pub mod report;
pub mod scene;
pub mod shared;
pub mod spectrum;
pub mod tables;
