//! The laboratory on an adapter.

use super::{Input, LabError, Output, Stage};
use crate::gpu::device::Gpu;
use crate::gpu::kernel::{Kernel, KernelError};
use crate::gpu::link::Linked;
use crate::gpu::read::read;
use crate::shared::{LabAnswer, LabQuery};
use crate::tables::tables;
use std::cell::OnceCell;

/// Queries in one dispatch: 7 MiB of them, and well under a second on the slowest adapter.
const BATCH: usize = 65_536;
const WORKGROUP: u32 = 64;

pub struct GpuLab {
    gpu: Gpu,
    linked: Linked,
    /// In the order of `Stage`; compiled when first asked for, which takes a second on lavapipe.
    kernels: [OnceCell<Kernel>; 3],
    tables: wgpu::Buffer,
    queries: wgpu::Buffer,
    answers: wgpu::Buffer,
}

impl GpuLab {
    /// `linked` is `kernels/bsdf_lab`, or what a test has made of it.
    pub fn new(gpu: Gpu, linked: Linked) -> Self {
        let buffer = |label, size: usize, usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: size as u64,
                usage,
                mapped_at_creation: false,
            })
        };
        let storage = wgpu::BufferUsages::STORAGE;
        let (upload, download) = (wgpu::BufferUsages::COPY_DST, wgpu::BufferUsages::COPY_SRC);
        let made = tables();
        let bytes = bytemuck::bytes_of(&*made);
        let tables = buffer("tables", bytes.len(), wgpu::BufferUsages::UNIFORM | upload);
        gpu.queue.write_buffer(&tables, 0, bytes);
        Self {
            linked,
            kernels: Default::default(),
            tables,
            queries: buffer("queries", BATCH * size_of::<LabQuery>(), storage | upload),
            answers: buffer(
                "answers",
                BATCH * size_of::<LabAnswer>(),
                storage | download,
            ),
            gpu,
        }
    }

    fn kernel(&self, stage: Stage) -> Result<&Kernel, KernelError> {
        let cell = &self.kernels[stage as usize];
        if let Some(kernel) = cell.get() {
            return Ok(kernel);
        }
        let entry = match stage {
            Stage::Fresnel => "fresnel",
            Stage::Eval => "eval",
            Stage::Sample => "sample",
        };
        let kernel = Kernel::new(&self.gpu, &self.linked, entry)?;
        Ok(cell.get_or_init(|| kernel))
    }

    pub fn run(&self, stage: Stage, inputs: &[Input]) -> Result<Vec<Output>, LabError> {
        let mut outputs = Vec::with_capacity(inputs.len());
        for batch in inputs.chunks(BATCH) {
            let queries: Vec<LabQuery> = batch.iter().map(LabQuery::from).collect();
            let bytes = self.dispatch(stage, &queries)?;
            outputs.extend(
                bytemuck::pod_collect_to_vec::<u8, LabAnswer>(&bytes)
                    .iter()
                    .map(Output::from),
            );
        }
        Ok(outputs)
    }

    fn dispatch(&self, stage: Stage, queries: &[LabQuery]) -> Result<Vec<u8>, LabError> {
        let device = &self.gpu.device;
        self.gpu
            .queue
            .write_buffer(&self.queries, 0, bytemuck::cast_slice(queries));
        // The bindings' sizes tell the kernel how many queries there are.
        let part = |buffer, item: usize| {
            wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                buffer,
                offset: 0,
                size: std::num::NonZeroU64::new((queries.len() * item) as u64),
            })
        };
        let kernel = self.kernel(stage)?;
        let groups = kernel.bind(&self.gpu, |group, binding| match (group, binding) {
            (0, _) => self.tables.as_entire_binding(),
            (_, 0) => part(&self.queries, size_of::<LabQuery>()),
            _ => part(&self.answers, size_of::<LabAnswer>()),
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&kernel.pipeline);
            for (index, group) in groups.iter().enumerate() {
                pass.set_bind_group(index as u32, group, &[]);
            }
            pass.dispatch_workgroups((queries.len() as u32).div_ceil(WORKGROUP), 1, 1);
        }
        self.gpu.queue.submit([encoder.finish()]);
        let size = (queries.len() * size_of::<LabAnswer>()) as u64;
        read(&self.gpu, &self.answers, size).map_err(LabError::Device)
    }
}
