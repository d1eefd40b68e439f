//! What tests share: lavapipe, and running a kernel that a test brings.
#![allow(dead_code, reason = "each test file uses a part of this")]
#![allow(clippy::unwrap_used, reason = "a test's unwrap is its assertion")]

pub mod packed;
pub mod rays;
pub mod shapes;
pub mod statistics;

use snell::gpu::device::{Gpu, open};
use snell::gpu::kernel::Kernel;
use snell::gpu::link::link_text;
use snell::gpu::read::read;
use snell::gpu::upload::Scene;
use snell::gpu::variant::constants;
use snell::pack::Packed;
use snell::pack::outline::Outline;

/// Opens lavapipe. No adapter is a failure that says what to install, never a skipped test.
pub fn gpu() -> Gpu {
    let gpu = open(Some("llvmpipe")).unwrap_or_else(|error| {
        panic!("the tests run on Mesa's lavapipe: {error}; tests/run.sh installs it")
    });
    assert!(
        gpu.info.name.contains("llvmpipe"),
        "opened {}",
        gpu.info.name
    );
    gpu
}

/// Runs the entry point `main` (workgroup size 64) of a root shader text on lavapipe. Its bindings
/// are group 3: the inputs (storage, read) at 0.., then the output (storage, read_write).
pub fn run(root: &str, inputs: &[&[u8]], output_bytes: usize, invocations: u32) -> Vec<u8> {
    run_on(&gpu(), root, None, inputs, output_bytes, invocations)
}

/// The same with group 0 bound to a packed scene.
pub fn run_scene(
    root: &str,
    packed: &Packed,
    inputs: &[&[u8]],
    output_bytes: usize,
    invocations: u32,
) -> Vec<u8> {
    run_on(
        &gpu(),
        root,
        Some(packed),
        inputs,
        output_bytes,
        invocations,
    )
}

/// The same on an adapter opened before, for tests that run many kernels.
pub fn run_on(
    gpu: &Gpu,
    root: &str,
    packed: Option<&Packed>,
    inputs: &[&[u8]],
    output_bytes: usize,
    invocations: u32,
) -> Vec<u8> {
    let linked = link_text("test", root).unwrap_or_else(|error| panic!("{error}"));
    // As the renderer has it: a driver takes many seconds for what no scene needs all of.
    // A scene of tables alone has nothing that lobes could be left out for.
    let mut constants = packed
        .filter(|packed| !packed.triangles.is_empty())
        .map(|packed| constants(&Outline::of(packed)))
        .unwrap_or_default();
    let scene = packed.map(|packed| Scene::upload(gpu, packed).unwrap());
    constants.extend(scene.iter().flat_map(Scene::constants));
    constants.extend(gpu.constants());
    let kernel = Kernel::with_constants(gpu, &linked, "main", &constants)
        .unwrap_or_else(|error| panic!("{error}"));
    let storage = |bytes: &[u8], size: usize| {
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size: size.max(16) as u64,
            usage: wgpu::BufferUsages::STORAGE
                | wgpu::BufferUsages::COPY_DST
                | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        gpu.queue.write_buffer(&buffer, 0, bytes);
        buffer
    };
    let mut buffers: Vec<_> = inputs
        .iter()
        .map(|bytes| storage(bytes, bytes.len()))
        .collect();
    buffers.push(storage(&[], output_bytes));
    let groups = kernel.bind(gpu, |group, binding| match group {
        0 => scene
            .as_ref()
            .expect("a scene for group 0")
            .resource(binding),
        _ => buffers[binding as usize].as_entire_binding(),
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&kernel.pipeline);
        for (index, group) in groups.iter().enumerate() {
            pass.set_bind_group(index as u32, group, &[]);
        }
        let groups = invocations.div_ceil(64);
        assert!(groups <= 65535, "one dispatch takes at most 65535 groups");
        pass.dispatch_workgroups(groups, 1, 1);
    }
    gpu.queue.submit([encoder.finish()]);
    read(gpu, buffers.last().unwrap(), output_bytes as u64)
        .unwrap_or_else(|fault| panic!("{fault:?}"))
}
