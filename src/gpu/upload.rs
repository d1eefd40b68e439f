//! The packed scene on the device: one buffer or texture for each array, bound as
//! `shaders/bindings.wgsl` says.

use super::device::{Fault, Gpu};
use crate::pack::Packed;
use crate::shared::Material;
use thiserror::Error;

/// Group 0, in the order of its bindings.
pub struct Scene {
    pub frame: wgpu::Buffer,
    buffers: Vec<wgpu::Buffer>,
    environment: wgpu::TextureView,
    environment_cells: wgpu::TextureView,
}

#[derive(Debug, Error)]
pub enum UploadError {
    #[error(
        "the scene's {what} need {bytes} bytes and this adapter binds at most {limit} at once; use an adapter with a higher limit (see `snell doctor`), --cpu, or a smaller scene"
    )]
    TooLarge {
        what: &'static str,
        bytes: u64,
        limit: u64,
    },
    #[error(
        "the environment map of {width} x {height} is larger than the {limit} x {limit} that this adapter takes; scale it down, or use --cpu"
    )]
    EnvironmentTooLarge { width: u32, height: u32, limit: u32 },
    #[error("the device has no memory left for the scene ({0}); use --cpu or a smaller scene")]
    OutOfMemory(String),
    #[error("the device failed while the scene was uploaded: {0}")]
    Device(String),
}

/// A binding may not be empty; this covers one element of the largest structure.
const SMALLEST_BUFFER: u64 = size_of::<Material>() as u64;

impl Scene {
    /// Checks every size against the device's limits before anything is allocated.
    pub fn upload(gpu: &Gpu, packed: &Packed) -> Result<Self, UploadError> {
        let arrays = packed.arrays();
        let limit = gpu
            .limits
            .max_storage_buffer_binding_size
            .min(gpu.limits.max_buffer_size);
        for (what, bytes) in arrays {
            let bytes = bytes.len() as u64;
            if bytes > limit {
                return Err(UploadError::TooLarge { what, bytes, limit });
            }
        }
        let [width, height] = packed.frame.environment_size;
        let limit = gpu.limits.max_texture_dimension_2d;
        if width.max(height) > limit {
            return Err(UploadError::EnvironmentTooLarge {
                width,
                height,
                limit,
            });
        }

        let frame = buffer(
            gpu,
            "frame",
            bytemuck::bytes_of(&packed.frame),
            wgpu::BufferUsages::UNIFORM,
        );
        let mut buffers = vec![buffer(
            gpu,
            "tables",
            bytemuck::bytes_of(&*packed.tables),
            wgpu::BufferUsages::UNIFORM,
        )];
        for (what, bytes) in arrays {
            buffers.push(buffer(gpu, what, bytes, wgpu::BufferUsages::STORAGE));
        }
        let [cells_x, cells_y] = packed.frame.environment_cells;
        let scene = Self {
            frame,
            buffers,
            environment: texture(
                gpu,
                "environment",
                [width, height],
                wgpu::TextureFormat::Rgba32Float,
                bytemuck::cast_slice(&packed.environment),
            ),
            environment_cells: texture(
                gpu,
                "environment_cells",
                [cells_x + 1, cells_y],
                wgpu::TextureFormat::Rg32Float,
                bytemuck::cast_slice(&packed.environment_cells),
            ),
        };
        match gpu.take_fault() {
            None => Ok(scene),
            Some(Fault::OutOfMemory(message)) => Err(UploadError::OutOfMemory(message)),
            Some(Fault::Lost(message) | Fault::Other(message)) => Err(UploadError::Device(message)),
        }
    }

    /// What is bound at `binding` of group 0.
    pub fn resource(&self, binding: u32) -> wgpu::BindingResource<'_> {
        match binding {
            0 => self.frame.as_entire_binding(),
            9 => wgpu::BindingResource::TextureView(&self.environment),
            10 => wgpu::BindingResource::TextureView(&self.environment_cells),
            other => self.buffers[other as usize - 1].as_entire_binding(),
        }
    }
}

fn buffer(gpu: &Gpu, label: &str, bytes: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: (bytes.len() as u64).max(SMALLEST_BUFFER),
        usage: usage | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    gpu.queue.write_buffer(&buffer, 0, bytes);
    buffer
}

fn texture(
    gpu: &Gpu,
    label: &str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
    bytes: &[u8],
) -> wgpu::TextureView {
    let size = wgpu::Extent3d {
        width,
        height,
        depth_or_array_layers: 1,
    };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    gpu.queue.write_texture(
        texture.as_image_copy(),
        bytes,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(bytes.len() as u32 / height),
            rows_per_image: None,
        },
        size,
    );
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}
