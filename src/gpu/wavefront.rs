//! The wavefront's kernels and buffers, and one dispatch of the whole loop over a tile's samples.

use super::device::{Fault, Gpu};
use super::kernel::{Kernel, KernelError};
use super::read::{read, wait};
use super::upload::Scene;
use super::variant::{Constants, Variants};
use crate::render::Counts;
use crate::shared::{CLASS_MISS, CLASSES, Frame};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Bytes of one path's state: `PLANES` of 16 (shaders/kernels/state.wgsl).
pub const PATH_BYTES: u64 = 208;
/// `COUNTERS` words, of which some are for the record.
pub const COUNTER_BYTES: u64 = 56;
const CLOSEST_RAYS: usize = 4;
const SHADOW_RAYS: usize = 5;
const CLAMPED: usize = 6;
/// Byte offset of the shadow stage's dispatch size; that of the path stages comes first.
const SHADOW_ARGUMENTS: u64 = 16;
/// The same of the first class' shading; the others' follow at these steps.
const CLASS_ARGUMENTS: u64 = 32;
const ARGUMENTS: u64 = 16;
pub const WORKGROUP: u32 = 64;

/// What `run_timed` tells apart.
pub const STAGES: [&str; 6] = [
    "generate",
    "advance",
    "trace closest",
    "shade",
    "trace shadow",
    "accumulate",
];

/// Twin of `FilmCell` in shaders/kernels/accumulate.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct FilmCell {
    pub sum: [f32; 4],
    pub lost: [f32; 4],
    pub squares: [f32; 3],
    pub non_finite: u32,
    pub weight: f32,
    pub weight_lost: f32,
    pub weight_squares: f32,
    pub reserved: u32,
}

/// A kernel bound to this wavefront's buffers.
struct Stage {
    kernel: Arc<Kernel>,
    groups: Vec<wgpu::BindGroup>,
}

/// All kernels of a scene: module, entry point, constants. Those that drivers take longest over come first,
/// and those of one module and its constants beside each other.
pub fn kernels(variants: &Variants) -> Vec<(&'static str, &'static str, &Constants)> {
    // The plainest class has the lowest number.
    let mut classes: Vec<&(u32, Constants)> = variants.classes.iter().rev().collect();
    classes.sort_by_key(|(class, _)| *class == CLASS_MISS);
    let shade = classes.into_iter().map(|(class, constants)| {
        let (module, entry) = shading(*class);
        (module, entry, constants)
    });
    let scene = [
        ("trace_shadow", "trace_shadow_kernel"),
        ("trace_closest", "trace_closest_kernel"),
        ("generate", "generate"),
        ("accumulate", "accumulate_kernel"),
        ("advance", "advance_start"),
        ("advance", "advance_bounce"),
        ("advance", "advance_shade"),
        ("advance", "advance_shadow"),
    ];
    let scene = scene.map(|(module, entry)| (module, entry, &variants.scene));
    shade.chain(scene).collect()
}

/// Module and entry point that shade a class.
fn shading(class: u32) -> (&'static str, &'static str) {
    match class {
        CLASS_MISS => ("miss", "miss_kernel"),
        _ => ("shade", "shade_kernel"),
    }
}

/// Compiled kernels and their buffers; holds up to `capacity` paths at a time.
pub struct Wavefront {
    pub capacity: u32,
    scene: Scene,
    counters: wgpu::Buffer,
    arguments: wgpu::Buffer,
    film: wgpu::Buffer,
    generate: Stage,
    advance_start: Stage,
    advance_bounce: Stage,
    trace_closest: Stage,
    advance_shade: Stage,
    /// By class, of those that the scene has, misses among them.
    shade: Vec<(u32, Stage)>,
    advance_shadow: Stage,
    trace_shadow: Stage,
    accumulate: Stage,
}

impl Wavefront {
    /// The most paths that an adapter's limits allow.
    pub fn largest_capacity(gpu: &Gpu) -> u64 {
        let limit = gpu
            .limits
            .max_storage_buffer_binding_size
            .min(gpu.limits.max_buffer_size);
        limit / PATH_BYTES
    }

    /// Compiles the kernels and makes room for `capacity` paths and a tile of `tile_pixels`.
    pub fn new(
        gpu: &Gpu,
        scene: Scene,
        variants: &Variants,
        capacity: u32,
        tile_pixels: u32,
    ) -> Result<Self, KernelError> {
        Kernel::compile(gpu, &kernels(variants))?;
        let storage = |label: &str, bytes: u64, more: wgpu::BufferUsages| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: bytes,
                usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | more,
                mapped_at_creation: false,
            })
        };
        let paths = storage(
            "paths",
            u64::from(capacity) * PATH_BYTES,
            wgpu::BufferUsages::empty(),
        );
        let counters = storage("counters", COUNTER_BYTES, wgpu::BufferUsages::COPY_SRC);
        let arguments = storage(
            "arguments",
            CLASS_ARGUMENTS + u64::from(CLASSES) * ARGUMENTS,
            wgpu::BufferUsages::INDIRECT,
        );
        let film = storage(
            "film",
            u64::from(tile_pixels) * size_of::<FilmCell>() as u64,
            wgpu::BufferUsages::COPY_SRC,
        );
        let stage_of = |module: &str, entry: &str, third: &wgpu::Buffer, constants: &Constants| {
            let kernel = Kernel::of_renderer(gpu, module, entry, constants)?;
            let groups = kernel.bind(gpu, |group, binding| match (group, binding) {
                (0, _) => scene.resource(binding),
                (_, 0) => paths.as_entire_binding(),
                (_, 1) => counters.as_entire_binding(),
                _ => third.as_entire_binding(),
            });
            Ok::<_, KernelError>(Stage { kernel, groups })
        };
        let stage = |module: &str, entry: &str, third: &wgpu::Buffer| {
            stage_of(module, entry, third, &variants.scene)
        };
        let shade = |(class, constants): &(u32, Constants)| {
            let (module, entry) = shading(*class);
            Ok((*class, stage_of(module, entry, &film, constants)?))
        };
        Ok(Self {
            generate: stage("generate", "generate", &film)?,
            advance_start: stage("advance", "advance_start", &arguments)?,
            advance_bounce: stage("advance", "advance_bounce", &arguments)?,
            trace_closest: stage("trace_closest", "trace_closest_kernel", &film)?,
            advance_shade: stage("advance", "advance_shade", &arguments)?,
            shade: variants
                .classes
                .iter()
                .map(shade)
                .collect::<Result<_, KernelError>>()?,
            advance_shadow: stage("advance", "advance_shadow", &arguments)?,
            trace_shadow: stage("trace_shadow", "trace_shadow_kernel", &film)?,
            accumulate: stage("accumulate", "accumulate_kernel", &film)?,
            capacity,
            scene,
            counters,
            arguments,
            film,
        })
    }

    /// Renders `frame`'s samples of `frame`'s tile and adds them to the film, which is cleared first
    /// if `first`. Waits for the device.
    ///
    /// All bounces go in one submission: the sizes of later dispatches are computed on the device.
    pub fn run(&self, gpu: &Gpu, frame: &Frame, first: bool) -> Result<Counts, Fault> {
        gpu.queue
            .write_buffer(&self.scene.frame, 0, bytemuck::bytes_of(frame));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(&self.counters, 0, None);
        if first {
            encoder.clear_buffer(&self.film, 0, None);
        }
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            let tile_pixels = frame.tile_size[0] * frame.tile_size[1];
            dispatch(&mut pass, &self.generate, frame.capacity);
            dispatch(&mut pass, &self.advance_start, 1);
            // One round more than there are interactions: the last only adds what is emitted.
            for _ in 0..=frame.max_depth {
                dispatch(&mut pass, &self.advance_bounce, 1);
                self.dispatch_queue(&mut pass, &self.trace_closest, 0);
                dispatch(&mut pass, &self.advance_shade, 1);
                for (class, stage) in &self.shade {
                    self.dispatch_queue(&mut pass, stage, class_arguments(*class));
                }
                dispatch(&mut pass, &self.advance_shadow, 1);
                self.dispatch_queue(&mut pass, &self.trace_shadow, SHADOW_ARGUMENTS);
            }
            dispatch(&mut pass, &self.accumulate, tile_pixels);
        }
        gpu.queue.submit([encoder.finish()]);
        let counters = read(gpu, &self.counters, COUNTER_BYTES)?;
        let counters: &[u32] = bytemuck::cast_slice(&counters);
        Ok(Counts {
            closest_rays: u64::from(counters[CLOSEST_RAYS]),
            shadow_rays: u64::from(counters[SHADOW_RAYS]),
            clamped_samples: u64::from(counters[CLAMPED]),
        })
    }

    fn dispatch_queue(&self, pass: &mut wgpu::ComputePass<'_>, stage: &Stage, offset: u64) {
        bind(pass, stage);
        pass.dispatch_workgroups_indirect(&self.arguments, offset);
    }

    /// `run` with each dispatch submitted and waited for by itself: the time of each stage, in the order of
    /// `STAGES`, the device's answer included. Slower than `run`, and the same film.
    pub fn run_timed(
        &self,
        gpu: &Gpu,
        frame: &Frame,
        first: bool,
    ) -> Result<[Duration; STAGES.len()], Fault> {
        gpu.queue
            .write_buffer(&self.scene.frame, 0, bytemuck::bytes_of(frame));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.clear_buffer(&self.counters, 0, None);
        if first {
            encoder.clear_buffer(&self.film, 0, None);
        }
        gpu.queue.submit([encoder.finish()]);
        wait(gpu)?;
        let mut times = [Duration::ZERO; STAGES.len()];
        let mut timed = |stage: usize, record: &dyn Fn(&mut wgpu::ComputePass<'_>)| {
            let start = Instant::now();
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            record(&mut encoder.begin_compute_pass(&Default::default()));
            gpu.queue.submit([encoder.finish()]);
            wait(gpu)?;
            times[stage] += start.elapsed();
            Ok::<_, Fault>(())
        };
        timed(0, &|pass| dispatch(pass, &self.generate, frame.capacity))?;
        timed(1, &|pass| dispatch(pass, &self.advance_start, 1))?;
        for _ in 0..=frame.max_depth {
            timed(1, &|pass| dispatch(pass, &self.advance_bounce, 1))?;
            timed(2, &|pass| self.dispatch_queue(pass, &self.trace_closest, 0))?;
            timed(1, &|pass| dispatch(pass, &self.advance_shade, 1))?;
            for (class, stage) in &self.shade {
                timed(3, &|pass| {
                    self.dispatch_queue(pass, stage, class_arguments(*class))
                })?;
            }
            timed(1, &|pass| dispatch(pass, &self.advance_shadow, 1))?;
            timed(4, &|pass| {
                self.dispatch_queue(pass, &self.trace_shadow, SHADOW_ARGUMENTS)
            })?;
        }
        let tile_pixels = frame.tile_size[0] * frame.tile_size[1];
        timed(5, &|pass| dispatch(pass, &self.accumulate, tile_pixels))?;
        Ok(times)
    }

    /// The film of the tile that was rendered last, by rows.
    pub fn read_film(&self, gpu: &Gpu, tile_pixels: u32) -> Result<Vec<FilmCell>, Fault> {
        let bytes = u64::from(tile_pixels) * size_of::<FilmCell>() as u64;
        Ok(bytemuck::pod_collect_to_vec(&read(gpu, &self.film, bytes)?))
    }
}

fn class_arguments(class: u32) -> u64 {
    CLASS_ARGUMENTS + u64::from(class) * ARGUMENTS
}

fn bind(pass: &mut wgpu::ComputePass<'_>, stage: &Stage) {
    pass.set_pipeline(&stage.kernel.pipeline);
    for (index, group) in stage.groups.iter().enumerate() {
        pass.set_bind_group(index as u32, group, &[]);
    }
}

fn dispatch(pass: &mut wgpu::ComputePass<'_>, stage: &Stage, invocations: u32) {
    bind(pass, stage);
    pass.dispatch_workgroups(invocations.div_ceil(WORKGROUP), 1, 1);
}
