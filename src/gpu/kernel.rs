//! A linked shader as a compute pipeline, and its bind groups.

use super::device::Gpu;
use super::fetch::{FetchError, fetch_from_textures, load_as_storage};
use super::link::{LinkError, Linked, ShaderError, Value, link};
use super::prune::prune;
use super::upload;
use super::variant::Constants;
use crate::pack::ARRAYS;
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError};
use std::time::Instant;
use thiserror::Error;

/// One entry point, compiled.
pub struct Kernel {
    pub pipeline: wgpu::ComputePipeline,
    label: String,
    /// Bindings that the entry point reaches, by group: the pipeline's layout has just these.
    used: BTreeMap<u32, Vec<u32>>,
}

#[derive(Debug, Error)]
pub enum KernelError {
    #[error(transparent)]
    Link(#[from] LinkError),
    #[error(transparent)]
    Shader(#[from] ShaderError),
    #[error(transparent)]
    Fetch(#[from] FetchError),
    #[error("shader {shader} has no entry point {entry}")]
    NoEntry { shader: String, entry: String },
    #[error("the driver refused shader {shader}, entry point {entry}: {message}")]
    Refused {
        shader: String,
        entry: String,
        message: String,
    },
}

impl Kernel {
    /// Validates with naga (whose messages name our files), then hands to the driver what is reached.
    pub fn new(gpu: &Gpu, linked: &Linked, entry: &str) -> Result<Self, KernelError> {
        Self::with_constants(gpu, linked, entry, &[])
    }

    /// The same with values for those of the shader's constants that are named here.
    pub fn with_constants(
        gpu: &Gpu,
        linked: &Linked,
        entry: &str,
        constants: &[(&str, Value)],
    ) -> Result<Self, KernelError> {
        let linked = linked.with_constants(constants);
        let (module, _) = linked.validate()?;
        Self::of_module(gpu, &linked.name, module, entry)
    }

    /// One entry point of a module.
    fn of_module(
        gpu: &Gpu,
        name: &str,
        mut module: naga::Module,
        entry: &str,
    ) -> Result<Self, KernelError> {
        if !module.entry_points.iter().any(|point| point.name == entry) {
            return Err(KernelError::NoEntry {
                shader: name.to_owned(),
                entry: entry.to_owned(),
            });
        }
        prune(&mut module, entry);
        if gpu.arrays_in_textures {
            fetch_from_textures(&mut module, |name| ARRAYS.contains(&name))?;
            load_as_storage(&mut module, upload::storage_format);
        }
        // Only what the entry point reaches is left.
        let mut used: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (_, variable) in module.global_variables.iter() {
            if let Some(place) = &variable.binding {
                used.entry(place.group).or_default().push(place.binding);
            }
        }
        let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let shader = shader_module(gpu, name, module);
        let pipeline = gpu
            .device
            .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: None,
                module: &shader,
                entry_point: Some(entry),
                compilation_options: Default::default(),
                cache: None,
            });
        if let Some(error) = pollster::block_on(scope.pop()) {
            return Err(KernelError::Refused {
                shader: name.to_owned(),
                entry: entry.to_owned(),
                message: error.to_string(),
            });
        }
        Ok(Self {
            pipeline,
            label: entry.to_owned(),
            used,
        })
    }

    /// A kernel of shaders/kernels, compiled when this device is first asked for it with these
    /// constants: a driver can take a second over each, and one process may render many scenes.
    pub fn of_renderer(
        gpu: &Gpu,
        module: &str,
        entry: &str,
        constants: &[(&str, Value)],
    ) -> Result<Arc<Self>, KernelError> {
        let kernels = gpu.kernels.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(kernel) = kernels.get(&name_of(gpu, module, entry, constants)) {
            return Ok(Arc::clone(kernel));
        }
        drop(kernels);
        let linked = link(&format!("kernels/{module}"))?;
        let kernel = Arc::new(Self::with_constants(gpu, &linked, entry, constants)?);
        kernel.keep(gpu, module, entry, constants);
        Ok(kernel)
    }

    /// Compiles those of the renderer's kernels that this device does not have yet, side by side, for which the
    /// slowest should come first: module, entry point, constants. Neighbours of one module and with the same
    /// constants are parsed and validated once.
    pub fn compile(gpu: &Gpu, kernels: &[(&str, &str, &Constants)]) -> Result<(), KernelError> {
        let known = gpu.kernels.lock().unwrap_or_else(PoisonError::into_inner);
        let missing = kernels.iter().filter(|(module, entry, constants)| {
            !known.contains_key(&name_of(gpu, module, entry, constants))
        });
        let missing: Vec<(&str, &str, &Constants)> = missing.copied().collect();
        drop(known);
        let alike = missing.chunk_by(|a, b| a.0 == b.0 && a.2 == b.2);
        let alike: Vec<&[(&str, &str, &Constants)]> = alike.collect();
        let compile = |alike: &&[(&str, &str, &Constants)]| {
            let (module, _, constants) = alike[0];
            let start = Instant::now();
            let linked = link(&format!("kernels/{module}"))?.with_constants(constants);
            // wgpu validates what is left of each entry point. The whole, which names our files and lines, is
            // for those who change them.
            let parsed = match cfg!(debug_assertions) {
                true => linked.validate()?.0,
                false => linked.parse()?,
            };
            log::debug!("{module}: parsed in {:.1?}", start.elapsed());
            for (_, entry, _) in *alike {
                let start = Instant::now();
                let kernel = Self::of_module(gpu, &linked.name, parsed.clone(), entry)?;
                Arc::new(kernel).keep(gpu, module, entry, constants);
                log::debug!("{entry}: compiled in {:.1?}", start.elapsed());
            }
            Ok(())
        };
        let done: Vec<Result<(), KernelError>> = alike.par_iter().map(compile).collect();
        // The first in order, so that two faults always show the same one.
        done.into_iter().collect()
    }

    /// Stands for this one of the renderer's kernels on this device from now on, as a test's broken ones do.
    pub fn keep(
        self: &Arc<Self>,
        gpu: &Gpu,
        module: &str,
        entry: &str,
        constants: &[(&str, Value)],
    ) {
        let mut kernels = gpu.kernels.lock().unwrap_or_else(PoisonError::into_inner);
        kernels.insert(name_of(gpu, module, entry, constants), Arc::clone(self));
    }

    /// The bind groups 0 to the highest one used, with what `resource(group, binding)` gives.
    pub fn bind<'a>(
        &self,
        gpu: &Gpu,
        resource: impl Fn(u32, u32) -> wgpu::BindingResource<'a>,
    ) -> Vec<wgpu::BindGroup> {
        let groups = self.used.keys().max().map_or(0, |last| last + 1);
        (0..groups)
            .map(|group| {
                let bindings = self.used.get(&group).map_or(&[][..], Vec::as_slice);
                let entries: Vec<_> = bindings
                    .iter()
                    .map(|&binding| wgpu::BindGroupEntry {
                        binding,
                        resource: resource(group, binding),
                    })
                    .collect();
                gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some(&self.label),
                    layout: &self.pipeline.get_bind_group_layout(group),
                    entries: &entries,
                })
            })
            .collect()
    }
}

/// With wgpu's checks of indices and loops, or without (`Gpu::checked`): they take 8 to 10 % of a ray's time.
#[expect(unsafe_code, reason = "the only way that wgpu offers")]
fn shader_module(gpu: &Gpu, name: &str, module: naga::Module) -> wgpu::ShaderModule {
    let descriptor = wgpu::ShaderModuleDescriptor {
        label: Some(name),
        source: wgpu::ShaderSource::Naga(Cow::Owned(module)),
    };
    if gpu.checked {
        return gpu.device.create_shader_module(descriptor);
    }
    // SAFETY: wgpu has naga validate the module. Its kernels index the arrays of `Packed`, whose indices
    // `pack` makes itself from a checked scene and whose sizes `upload` keeps, tables by clamped places,
    // and state by slots below `frame.capacity`, for which the wavefront has made room. Every loop ends:
    // those of traversals with a stack that `bvh::MAX_DEPTH` bounds, the others after a number of steps
    // that does not depend on data. The tests run with the checks and compare both.
    unsafe {
        let checks = wgpu::ShaderRuntimeChecks::unchecked();
        gpu.device.create_shader_module_trusted(descriptor, checks)
    }
}

/// By which a device finds a kernel of the renderer's again.
fn name_of(gpu: &Gpu, module: &str, entry: &str, constants: &[(&str, Value)]) -> String {
    let (textures, checked) = (gpu.arrays_in_textures, gpu.checked);
    format!("{module} {entry} {textures} {checked} {constants:?}")
}
