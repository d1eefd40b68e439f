//! The packed scene on the device: one buffer or texture for each array, bound as
//! `shaders/bindings.wgsl` says.

use super::device::{Fault, Gpu};
use super::fetch::ROW_BITS;
use super::link::Value;
use crate::pack::Packed;
use crate::shared::{LightNode, Material};
use thiserror::Error;

/// Group 0, in the order of its bindings.
pub struct Scene {
    pub frame: wgpu::Buffer,
    tables: wgpu::Buffer,
    arrays: Vec<Array>,
    light_nodes: wgpu::TextureView,
    environment: wgpu::TextureView,
    environment_cells: wgpu::TextureView,
    pages: Option<Pages>,
}

/// One of the packed arrays, where `Gpu::arrays_in_textures` says.
enum Array {
    Buffer(wgpu::Buffer),
    Texture(wgpu::TextureView),
}

/// Texels in textures, where one binding of a buffer does not hold them. All eight storage buffers
/// that WebGPU grants a stage are in use, so that there can be no second buffer of them.
struct Pages {
    views: Vec<wgpu::TextureView>,
    shape: PageShape,
}

/// Layers of a square of words, and how many of them are in a page; each as its logarithm.
#[derive(Clone, Copy)]
struct PageShape {
    side_bits: u32,
    layer_bits: u32,
}

/// The name of the texels among the packed arrays.
const TEXELS: &str = "texels";

impl PageShape {
    /// As many pages as the kernels have bindings for.
    const MOST_PAGES: u64 = 4;

    /// 4096 x 4096 words in 16 layers: 1 GiB, which drivers allocate in one piece; WebGPU's own
    /// limits allow for it.
    fn of(limits: &wgpu::Limits) -> Self {
        Self {
            side_bits: limits.max_texture_dimension_2d.ilog2().min(12),
            layer_bits: limits.max_texture_array_layers.ilog2().min(4),
        }
    }

    fn layer_bytes(self) -> u64 {
        4 << (2 * self.side_bits)
    }

    fn page_bytes(self) -> u64 {
        self.layer_bytes() << self.layer_bits
    }
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

/// Nodes of the light tree, three texels each, in a row of their texture: a power of two, as their number is.
const LIGHT_NODES_IN_ROW: usize = 2048;

/// A binding may not be empty; this covers one element of the largest structure.
const SMALLEST_BUFFER: u64 = size_of::<Material>() as u64;

impl Pages {
    fn upload(gpu: &Gpu, texels: &[u32], shape: PageShape) -> Self {
        let side = 1 << shape.side_bits;
        let views = texels
            .chunks((shape.page_bytes() / 4) as usize)
            .map(|page| {
                let layers = page.chunks((shape.layer_bytes() / 4) as usize);
                let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                    label: Some(TEXELS),
                    size: wgpu::Extent3d {
                        width: side as u32,
                        // A layer alone has no more rows than there are words for.
                        height: page.len().div_ceil(side).min(side) as u32,
                        depth_or_array_layers: layers.len() as u32,
                    },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format: wgpu::TextureFormat::R32Uint,
                    usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                    view_formats: &[],
                });
                for (layer, words) in (0..).zip(layers) {
                    let (rows, rest) = words.split_at(words.len() / side * side);
                    write_words(gpu, &texture, [0, layer], rows, side);
                    write_words(gpu, &texture, [rows.len() / side, layer], rest, rest.len());
                    // What is staged for a layer is let go before the next one's is.
                    gpu.queue.submit([]);
                }
                texture.create_view(&wgpu::TextureViewDescriptor {
                    dimension: Some(wgpu::TextureViewDimension::D2Array),
                    ..Default::default()
                })
            })
            .collect();
        Self { views, shape }
    }
}

/// Rows of `width` words from row `y` of a layer on.
fn write_words(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    [y, layer]: [usize; 2],
    words: &[u32],
    width: usize,
) {
    if words.is_empty() {
        return;
    }
    gpu.queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            origin: wgpu::Origin3d {
                x: 0,
                y: y as u32,
                z: layer as u32,
            },
            ..texture.as_image_copy()
        },
        bytemuck::cast_slice(words),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(4 * width as u32),
            rows_per_image: None,
        },
        wgpu::Extent3d {
            width: width as u32,
            height: (words.len() / width) as u32,
            depth_or_array_layers: 1,
        },
    );
}

impl Scene {
    /// Checks every size against the device's limits before anything is allocated.
    pub fn upload(gpu: &Gpu, packed: &Packed) -> Result<Self, UploadError> {
        let arrays = packed.arrays();
        let shape = PageShape::of(&gpu.limits);
        let paged = packed.texels.len() as u64 * 4 > largest_array(gpu, TEXELS);
        for (what, bytes) in arrays {
            let bytes = bytes.len() as u64;
            let limit = largest_array(gpu, what);
            let limit = match what {
                TEXELS => limit.max(PageShape::MOST_PAGES * shape.page_bytes()),
                _ => limit,
            };
            if bytes > limit {
                return Err(UploadError::TooLarge { what, bytes, limit });
            }
        }
        let [width, height] = packed.frame.environment_size;
        let limit = gpu.limits.max_texture_dimension_2d;
        let nodes = packed.light_nodes.len();
        let node_rows = nodes.div_ceil(LIGHT_NODES_IN_ROW);
        if node_rows > limit as usize {
            let row_bytes = (LIGHT_NODES_IN_ROW * size_of::<LightNode>()) as u64;
            return Err(UploadError::TooLarge {
                what: "light tree",
                bytes: node_rows as u64 * row_bytes,
                limit: u64::from(limit) * row_bytes,
            });
        }
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
        let tables = buffer(
            gpu,
            "tables",
            bytemuck::bytes_of(&*packed.tables),
            wgpu::BufferUsages::UNIFORM,
        );
        let arrays = arrays
            .into_iter()
            .map(|(what, bytes)| {
                let bytes = if paged && what == TEXELS { &[] } else { bytes };
                if gpu.arrays_in_textures {
                    Array::Texture(array_texture(gpu, what, bytes))
                } else {
                    let usage = wgpu::BufferUsages::STORAGE;
                    Array::Buffer(buffer(gpu, what, bytes, usage))
                }
            })
            .collect();
        let [cells_x, cells_y] = packed.frame.environment_cells;
        let scene = Self {
            frame,
            tables,
            arrays,
            light_nodes: texture(
                gpu,
                "light_nodes",
                [
                    (nodes.min(LIGHT_NODES_IN_ROW) * size_of::<LightNode>() / 16) as u32,
                    node_rows as u32,
                ],
                wgpu::TextureFormat::Rgba32Uint,
                bytemuck::cast_slice(&packed.light_nodes),
            ),
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
            pages: paged.then(|| Pages::upload(gpu, &packed.texels, shape)),
        };
        match gpu.take_fault() {
            None => Ok(scene),
            Some(Fault::OutOfMemory(message)) => Err(UploadError::OutOfMemory(message)),
            Some(Fault::Lost(message) | Fault::Other(message)) => Err(UploadError::Device(message)),
        }
    }

    /// What the kernels have to know of where their arrays are: values of `shaders/variant.wgsl`, none
    /// where all is as it stands there.
    pub fn constants(&self) -> Vec<(&'static str, Value)> {
        self.pages.as_ref().map_or(Vec::new(), |pages| {
            vec![
                ("TEXEL_PAGES", Value::Uint(pages.views.len() as u32)),
                ("TEXEL_SIDE_BITS", Value::Uint(pages.shape.side_bits)),
                ("TEXEL_LAYER_BITS", Value::Uint(pages.shape.layer_bits)),
            ]
        })
    }

    /// What is bound at `binding` of group 0.
    pub fn resource(&self, binding: u32) -> wgpu::BindingResource<'_> {
        match binding {
            0 => self.frame.as_entire_binding(),
            9 => wgpu::BindingResource::TextureView(&self.environment),
            10 => wgpu::BindingResource::TextureView(&self.environment_cells),
            15 => wgpu::BindingResource::TextureView(&self.light_nodes),
            page @ 11..15 => {
                let pages = self.pages.as_ref().expect("kernels were told of pages");
                wgpu::BindingResource::TextureView(&pages.views[page as usize - 11])
            }
            1 => self.tables.as_entire_binding(),
            other => match &self.arrays[other as usize - 2] {
                Array::Buffer(buffer) => buffer.as_entire_binding(),
                Array::Texture(view) => wgpu::BindingResource::TextureView(view),
            },
        }
    }
}

/// Bytes that one array may have on the device.
fn largest_array(gpu: &Gpu, what: &str) -> u64 {
    let limits = &gpu.limits;
    if gpu.arrays_in_textures {
        // No driver says how large a texture may be in all; a buffer of that size it does offer.
        let rows = u64::from(limits.max_texture_dimension_2d);
        ((texel_of(what).0 as u64 * rows) << ROW_BITS).min(limits.max_buffer_size)
    } else {
        limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size)
    }
}

/// The format of the scene's textures that are no array and no page.
pub fn storage_format(what: &str) -> Option<naga::StorageFormat> {
    match what {
        "light_nodes" => Some(naga::StorageFormat::Rgba32Uint),
        "environment" => Some(naga::StorageFormat::Rgba32Float),
        "environment_cells" => Some(naga::StorageFormat::Rg32Float),
        _ => None,
    }
}

/// Bytes of one texel of an array's texture, and its format: as `fetch_from_textures` has them.
fn texel_of(what: &str) -> (u32, wgpu::TextureFormat) {
    match what {
        "vertices" | TEXELS => (4, wgpu::TextureFormat::R32Uint),
        _ => (16, wgpu::TextureFormat::Rgba32Uint),
    }
}

/// Most bytes that are staged at once.
const STAGED: usize = 64 << 20;

/// An array as rows of 2^ROW_BITS texels, the last one as far as it goes.
fn array_texture(gpu: &Gpu, what: &str, bytes: &[u8]) -> wgpu::TextureView {
    let (texel_bytes, format) = texel_of(what);
    let row_bytes = (texel_bytes as usize) << ROW_BITS;
    let texels = bytes.len() / texel_bytes as usize;
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(what),
        size: wgpu::Extent3d {
            width: texels.clamp(1, 1 << ROW_BITS) as u32,
            height: bytes.len().div_ceil(row_bytes).max(1) as u32,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let (rows, rest) = bytes.split_at(bytes.len() / row_bytes * row_bytes);
    let mut y = 0;
    for part in rows
        .chunks((STAGED / row_bytes).max(1) * row_bytes)
        .chain([rest])
    {
        let width = part.len().min(row_bytes);
        if width == 0 {
            continue;
        }
        let height = (part.len() / width) as u32;
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d { x: 0, y, z: 0 },
                ..texture.as_image_copy()
            },
            part,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(width as u32),
                rows_per_image: None,
            },
            wgpu::Extent3d {
                width: width as u32 / texel_bytes,
                height,
                depth_or_array_layers: 1,
            },
        );
        // What is staged for a part is let go before the next one's is.
        gpu.queue.submit([]);
        y += height;
    }
    texture.create_view(&wgpu::TextureViewDescriptor::default())
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
        usage: wgpu::TextureUsages::COPY_DST
            | if gpu.arrays_in_textures {
                wgpu::TextureUsages::STORAGE_BINDING
            } else {
                wgpu::TextureUsages::TEXTURE_BINDING
            },
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
