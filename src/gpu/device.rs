//! Finding and opening an adapter.

use super::kernel::Kernel;
use super::link::Value;
use super::variant::Constants;
use crate::pack::ARRAYS;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};
use thiserror::Error;

/// An opened adapter. Errors that wgpu reports outside any scope, and the loss of the device, are
/// kept here for the renderer to ask about: the default handler would end the process.
pub struct Gpu {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub info: wgpu::AdapterInfo,
    pub limits: wgpu::Limits,
    /// Whether kernels read the packed scene from storage textures: see `gpu::fetch`.
    pub arrays_in_textures: bool,
    /// Whether the driver jumps over a branch that no lane takes: see `shaders/bvh.wgsl`.
    pub skips_branches: bool,
    /// Whether kernels check each index and bound each loop, as debug builds let them, tests among them.
    pub checked: bool,
    /// What `open` was asked for, to open it again.
    wanted: Option<String>,
    faults: Arc<Mutex<Vec<Fault>>>,
    /// Our kernels by module, entry point and constants, as far as they have been asked for.
    pub(super) kernels: Mutex<HashMap<String, Arc<Kernel>>>,
}

/// What went wrong on the device since it was opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fault {
    Lost(String),
    OutOfMemory(String),
    Other(String),
}

/// What `snell doctor` prints of an adapter.
#[derive(Clone, Debug)]
pub struct AdapterSummary {
    pub info: wgpu::AdapterInfo,
    pub limits: wgpu::Limits,
    /// What of WebGPU's defaults it lacks; such an adapter cannot be used.
    pub missing: Option<String>,
}

#[derive(Debug, Error)]
pub enum DeviceError {
    #[error(
        "no Vulkan, Metal or D3D12 adapter was found; install a driver (Debian, Ubuntu: apt-get install mesa-vulkan-drivers libvulkan1) or render with --cpu"
    )]
    NoAdapter,
    #[error("no adapter's name contains \"{wanted}\"; there are: {found}")]
    NotFound { wanted: String, found: String },
    #[error(
        "{name} does not offer what WebGPU asks of every adapter ({fault}); choose another with --adapter, or --cpu"
    )]
    BelowDefaults { name: String, fault: String },
    #[error("{name} refused to open: {fault}")]
    Refused { name: String, fault: String },
}

fn instance() -> wgpu::Instance {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = wgpu::Backends::VULKAN | wgpu::Backends::METAL | wgpu::Backends::DX12;
    // Debug builds would otherwise look for validation layers that servers do not have.
    descriptor.flags = wgpu::InstanceFlags::empty();
    wgpu::Instance::new(descriptor)
}

/// All adapters, best first; the driver's own order among equals, so that the choice is the same
/// every time.
fn enumerate(instance: &wgpu::Instance) -> Vec<wgpu::Adapter> {
    let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    adapters.sort_by_key(|adapter| match adapter.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    });
    adapters
}

/// All adapters, the one that `open(None)` takes first.
pub fn adapters() -> Vec<AdapterSummary> {
    enumerate(&instance())
        .iter()
        .map(|adapter| AdapterSummary {
            info: adapter.get_info(),
            limits: adapter.limits(),
            missing: missing(adapter),
        })
        .collect()
}

/// The first of WebGPU's default limits, or compute shaders, that an adapter does not offer.
fn missing(adapter: &wgpu::Adapter) -> Option<String> {
    let flags = adapter.get_downlevel_capabilities().flags;
    if !flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS) {
        return Some("it has no compute shaders".to_owned());
    }
    let mut missing = None;
    wgpu::Limits::default().check_limits_with_fail_fn(
        &adapter.limits(),
        false,
        |name, wanted, offered| {
            missing.get_or_insert_with(|| format!("{name} is {offered}, not {wanted}"));
        },
    );
    missing
}

/// Opens the best adapter, or the first whose name contains `wanted` (letter case aside).
///
/// All limits that the adapter offers are asked for; nothing beyond WebGPU's defaults is needed.
pub fn open(wanted: Option<&str>) -> Result<Gpu, DeviceError> {
    let instance = instance();
    let adapters = enumerate(&instance);
    if adapters.is_empty() && wanted.is_none() {
        return Err(DeviceError::NoAdapter);
    }
    let names: Vec<String> = adapters
        .iter()
        .map(|adapter| adapter.get_info().name)
        .collect();
    let position = match wanted {
        None => 0,
        Some(wanted) => names
            .iter()
            .position(|name| name.to_lowercase().contains(&wanted.to_lowercase()))
            .ok_or_else(|| DeviceError::NotFound {
                wanted: wanted.to_owned(),
                found: match names.len() {
                    0 => "none".to_owned(),
                    _ => names.join(", "),
                },
            })?,
    };
    let adapter = &adapters[position];
    let info = adapter.get_info();
    if let Some(fault) = missing(adapter) {
        return Err(DeviceError::BelowDefaults {
            name: info.name,
            fault,
        });
    }
    let limits = adapter.limits();
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        label: Some("snell"),
        required_features: wgpu::Features::empty(),
        required_limits: limits.clone(),
        ..Default::default()
    }))
    .map_err(|error| DeviceError::Refused {
        name: info.name.clone(),
        fault: error.to_string(),
    })?;

    let faults = Arc::new(Mutex::new(Vec::new()));
    let keep = |faults: &Arc<Mutex<Vec<Fault>>>| {
        let faults = Arc::clone(faults);
        move |seen: Fault| {
            faults
                .lock()
                .unwrap_or_else(|poisoned| poisoned.into_inner())
                .push(seen);
        }
    };
    let keep_error = keep(&faults);
    device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
        keep_error(match error {
            wgpu::Error::OutOfMemory { .. } => Fault::OutOfMemory(error.to_string()),
            other => Fault::Other(other.to_string()),
        });
    }));
    let keep_loss = keep(&faults);
    device.set_device_lost_callback(move |_reason, message| keep_loss(Fault::Lost(message)));
    Ok(Gpu {
        device,
        queue,
        arrays_in_textures: info.device_type == wgpu::DeviceType::Cpu
            && limits.max_storage_textures_per_shader_stage >= ARRAYS.len() as u32,
        skips_branches: skips_branches(&info.driver, &info.driver_info),
        checked: cfg!(debug_assertions),
        info,
        limits,
        wanted: wanted.map(str::to_owned),
        faults,
        kernels: Mutex::default(),
    })
}

/// llvmpipe of Mesa 22 carries out every branch for all lanes, that of Mesa 25 does not. Of those between,
/// it is taken for granted, since to be wrong costs less so.
fn skips_branches(driver: &str, driver_info: &str) -> bool {
    let mesa = driver_info.strip_prefix("Mesa ");
    let major = mesa.and_then(|version| version.split('.').next()?.parse::<u32>().ok());
    driver != "llvmpipe" || major.is_some_and(|major| major >= 25)
}

impl Gpu {
    /// What went wrong since this was asked last: the loss of the device if it was lost (other errors
    /// are then its consequences), else the first error.
    pub fn take_fault(&self) -> Option<Fault> {
        let faults = std::mem::take(
            &mut *self
                .faults
                .lock()
                .unwrap_or_else(|poisoned| poisoned.into_inner()),
        );
        let lost = faults
            .iter()
            .position(|fault| matches!(fault, Fault::Lost(_)));
        faults.into_iter().nth(lost.unwrap_or(0))
    }

    /// What kernels may take for granted of the driver: see `shaders/variant.wgsl`.
    pub fn constants(&self) -> Constants {
        vec![("SKIPS_BRANCHES", Value::Bool(self.skips_branches))]
    }

    /// How many of the renderer's kernels are compiled.
    pub fn kernel_count(&self) -> usize {
        self.kernels
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
            .len()
    }

    /// Opens the adapter anew, as after the loss of the device.
    pub fn reopen(&mut self) -> Result<(), DeviceError> {
        let (checked, arrays_in_textures) = (self.checked, self.arrays_in_textures);
        let skips_branches = self.skips_branches;
        *self = open(self.wanted.as_deref())?;
        self.checked = checked;
        self.arrays_in_textures = arrays_in_textures;
        self.skips_branches = skips_branches;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::skips_branches;

    #[test]
    fn branches_are_skipped_from_mesa_25_on_and_by_all_other_drivers() {
        for (driver, driver_info, skips) in [
            ("llvmpipe", "Mesa 22.3.6 (LLVM 15.0.6)", false),
            ("llvmpipe", "Mesa 24.3.4", false),
            ("llvmpipe", "Mesa 25.0.7-2~bpo12+1 (LLVM 15.0.6)", true),
            ("llvmpipe", "Mesa 25.1.0-devel (git-0123456789)", true),
            ("llvmpipe", "Mesa 100.0.0", true),
            ("llvmpipe", "Mesa 2.30", false),
            ("radv", "Mesa 22.3.6", true),
            ("NVIDIA", "535.183.01", true),
            ("", "", true),
            // What cannot be read is taken for old, since to be wrong costs less so.
            ("llvmpipe", "", false),
            ("llvmpipe", "Mesa", false),
            ("llvmpipe", "Mesa git-25", false),
            ("llvmpipe", "Mesa -25.0", false),
            ("llvmpipe", "25.0.7", false),
            ("llvmpipe", "Mesa 99999999999.1", false),
        ] {
            assert_eq!(
                skips_branches(driver, driver_info),
                skips,
                "{driver}, {driver_info}"
            );
        }
    }
}
