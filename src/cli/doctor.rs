//! `snell doctor`: which adapters there are, what Snell can do with them, and what to do about it.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use crate::error::Error;
use crate::gpu::device::{AdapterSummary, DeviceError, adapters};

/// Nothing to choose: it looks at everything.
#[derive(Debug, clap::Args)]
pub struct DoctorArgs {}

/// Prints the findings; an error where no adapter can be used.
pub fn run(_: &DoctorArgs) -> Result<(), Error> {
    let adapters = adapters();
    super::print(&text(&adapters))?;
    Ok(verdict(&adapters)?)
}

/// Whether one of them can be used.
fn verdict(adapters: &[AdapterSummary]) -> Result<(), DeviceError> {
    let usable = adapters.iter().any(|a| a.missing.is_none());
    usable.then_some(()).ok_or(DeviceError::NoAdapter)
}

fn text(adapters: &[AdapterSummary]) -> String {
    let mut out = format!("Snell {}\n\n", env!("CARGO_PKG_VERSION"));
    for (i, adapter) in adapters.iter().enumerate() {
        describe(&mut out, i, adapter);
    }
    if adapters.is_empty() {
        out.push_str("No Vulkan, Metal or D3D12 adapter.\n");
    }
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    line(
        &mut out,
        &format!("\nCPU renderer: always there (--cpu), {threads} threads."),
    );
    out.push('\n');
    for finding in findings(adapters) {
        line(&mut out, &finding);
    }
    out
}

fn line(out: &mut String, text: &str) {
    out.push_str(text);
    out.push('\n');
}

fn describe(out: &mut String, index: usize, adapter: &AdapterSummary) {
    let (info, limits) = (&adapter.info, &adapter.limits);
    let number = index + 1;
    // Writing to a String cannot fail.
    let _ = writeln!(out, "{number}. {}", info.name);
    let _ = writeln!(out, "   type      {}", kind(info.device_type));
    let _ = writeln!(
        out,
        "   driver    {}",
        [info.driver.as_str(), info.driver_info.as_str()]
            .join(" ")
            .trim()
    );
    let _ = writeln!(out, "   backend   {}", info.backend);
    let _ = writeln!(
        out,
        "   limits    {} a storage binding, {} a buffer, {} storage buffers a stage,",
        bytes(limits.max_storage_buffer_binding_size),
        bytes(limits.max_buffer_size),
        limits.max_storage_buffers_per_shader_stage,
    );
    let _ = writeln!(
        out,
        "             textures to {} px, {} invocations a workgroup, {} workgroups a dispatch",
        limits.max_texture_dimension_2d,
        limits.max_compute_invocations_per_workgroup,
        limits.max_compute_workgroups_per_dimension,
    );
    match &adapter.missing {
        Some(missing) => line(out, &format!("   usable    no: {missing}")),
        None if index == 0 => line(out, "   usable    yes; taken by default"),
        None => line(out, &format!("   usable    yes: --adapter '{}'", info.name)),
    }
}

/// What an adapter is, in words.
pub fn kind(kind: wgpu::DeviceType) -> &'static str {
    match kind {
        wgpu::DeviceType::DiscreteGpu => "discrete GPU",
        wgpu::DeviceType::IntegratedGpu => "integrated GPU",
        wgpu::DeviceType::VirtualGpu => "virtual GPU",
        wgpu::DeviceType::Cpu => "software, on the CPU",
        wgpu::DeviceType::Other => "other",
    }
}

/// Binary multiples, as limits are made.
pub fn bytes(size: u64) -> String {
    const UNITS: [&str; 4] = ["bytes", "KiB", "MiB", "GiB"];
    let step = (0..UNITS.len() - 1).find(|&s| size >> (10 * (s + 1)) == 0);
    let step = step.unwrap_or(UNITS.len() - 1);
    format!("{} {}", size >> (10 * step), UNITS[step])
}

fn findings(adapters: &[AdapterSummary]) -> Vec<String> {
    let mut findings = Vec::new();
    let usable: Vec<_> = adapters.iter().filter(|a| a.missing.is_none()).collect();
    let only_software = usable
        .iter()
        .all(|a| a.info.device_type == wgpu::DeviceType::Cpu);
    if cfg!(target_os = "linux") {
        findings.extend(driver_variables());
        if usable.iter().any(|a| is_llvmpipe(&a.info)) {
            findings.extend(software_variables());
        }
        if usable.is_empty() {
            findings.extend(missing_parts());
        }
        if only_software {
            findings.extend(closed_nodes());
        }
    }
    let noise = device_select_noise();
    if findings.is_empty() && usable.is_empty() {
        findings.push(
            "Install or update the driver of the graphics card, or render with --cpu.".into(),
        );
    } else if findings.is_empty() && only_software {
        findings.push(
            "All is well. The only adapter is software: the pictures are the same, a GPU is faster."
                .into(),
        );
    } else if findings.is_empty() {
        findings.push("All is well.".into());
    }
    findings.extend(noise);
    findings
}

/// Variables that tell the Vulkan loader which drivers to take, and name files that are not there.
fn driver_variables() -> Vec<String> {
    let mut findings = Vec::new();
    for name in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
        let Some(value) = std::env::var_os(name) else {
            continue;
        };
        for path in std::env::split_paths(&value) {
            if !path.exists() {
                findings.push(format!(
                    "{name} names '{}', which does not exist, so the Vulkan loader finds no driver by it; unset {name} or correct it.",
                    path.display()
                ));
            }
        }
    }
    findings
}

fn is_llvmpipe(info: &wgpu::AdapterInfo) -> bool {
    info.name.contains("llvmpipe")
}

/// Variables of Mesa's that make its software renderer slow or wrong.
fn software_variables() -> Vec<String> {
    let mut findings = Vec::new();
    if let Some(width) = std::env::var_os("LP_NATIVE_VECTOR_WIDTH") {
        findings.push(format!(
            "LP_NATIVE_VECTOR_WIDTH is {}: Mesa's shader cache does not tell widths apart and gives back code of another one; unset it, or give each width a MESA_SHADER_CACHE_DIR of its own.",
            width.to_string_lossy()
        ));
    }
    for name in ["MESA_SHADER_CACHE_DISABLE", "MESA_GLSL_CACHE_DISABLE"] {
        let value = std::env::var(name).unwrap_or_default();
        if ["1", "true", "yes", "y"].contains(&value.to_lowercase().as_str()) {
            findings.push(format!(
                "{name} is {value}: every process compiles its kernels anew, which takes seconds; unset it."
            ));
        }
    }
    if let Some(folder) = std::env::var_os("MESA_SHADER_CACHE_DIR")
        && !folder.is_empty()
        && !is_writable(Path::new(&folder))
    {
        findings.push(format!(
            "MESA_SHADER_CACHE_DIR is '{}', where nothing can be written: every process compiles its kernels anew, which takes seconds.",
            folder.display()
        ));
    }
    findings
}

/// Whether a file can be made in the folder, or in the nearest one above that is there: Mesa makes those
/// that are not.
fn is_writable(folder: &Path) -> bool {
    let Ok(folder) = std::path::absolute(folder) else {
        return false;
    };
    let there = folder.ancestors().find(|folder| folder.exists());
    there.is_some_and(|folder| tempfile::tempfile_in(folder).is_ok())
}

/// Mesa's device-select layer looks for a Wayland server and complains where there is none.
fn device_select_noise() -> Option<String> {
    let unset = |name| std::env::var_os(name).is_none();
    (cfg!(target_os = "linux") && unset("XDG_RUNTIME_DIR") && unset("NODEVICE_SELECT")).then(|| {
        "A line 'error: XDG_RUNTIME_DIR is invalid' comes from a Vulkan layer of Mesa's and is harmless; NODEVICE_SELECT=1 in the environment turns it off.".into()
    })
}

/// What a Linux without any adapter lacks.
fn missing_parts() -> Vec<String> {
    const INSTALL: &str = "on Debian and Ubuntu: apt-get install mesa-vulkan-drivers libvulkan1";
    const MANIFESTS: [&str; 3] = [
        "/usr/share/vulkan/icd.d",
        "/usr/local/share/vulkan/icd.d",
        "/etc/vulkan/icd.d",
    ];
    let mut findings = Vec::new();
    let loader = ["/usr/lib", "/usr/lib64", "/lib", "/lib64", "/usr/local/lib"]
        .iter()
        .any(|folder| holds(Path::new(folder), "libvulkan.so", true));
    if !loader {
        findings.push(format!(
            "The Vulkan loader (libvulkan.so.1) is not installed; {INSTALL}"
        ));
    }
    if !MANIFESTS.iter().any(|f| holds(Path::new(f), "", false)) {
        findings.push(format!(
            "No Vulkan driver is installed (no file in {}); {INSTALL}",
            MANIFESTS[0]
        ));
    }
    findings
}

/// Whether a folder, or a folder right below it (`/usr/lib/x86_64-linux-gnu`), holds such a file.
fn holds(folder: &Path, prefix: &str, below: bool) -> bool {
    let Ok(entries) = fs::read_dir(folder) else {
        return false;
    };
    entries.flatten().any(|entry| {
        let path = entry.path();
        entry.file_name().to_string_lossy().starts_with(prefix) && !path.is_dir()
            || below && path.is_dir() && holds(&path, prefix, false)
    })
}

/// Render nodes of graphics cards that this user may not open.
fn closed_nodes() -> Vec<String> {
    let Ok(entries) = fs::read_dir("/dev/dri") else {
        return Vec::new();
    };
    let mut closed: Vec<String> = entries
        .flatten()
        .map(|e| e.path())
        .filter(|p| p.to_string_lossy().contains("renderD"))
        .filter(|p| {
            fs::OpenOptions::new()
                .read(true)
                .write(true)
                .open(p)
                .is_err_and(|e| e.kind() == std::io::ErrorKind::PermissionDenied)
        })
        .map(|p| {
            format!(
                "There is a graphics card at {}, which you may not open; add yourself to the group that owns it (often 'render').",
                p.display()
            )
        })
        .collect();
    closed.sort();
    closed
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two that can be used and one that cannot, with numbers that differ all over.
    fn adapters() -> [AdapterSummary; 3] {
        let kinds = [
            wgpu::DeviceType::DiscreteGpu,
            wgpu::DeviceType::Cpu,
            wgpu::DeviceType::IntegratedGpu,
        ];
        let backends = [
            wgpu::Backend::Vulkan,
            wgpu::Backend::Vulkan,
            wgpu::Backend::Metal,
        ];
        [0, 1, 2].map(|i| {
            let mut info = wgpu::AdapterInfo::new(kinds[i], backends[i]);
            info.name = ["Quick", "Patient", "Old"][i].to_owned();
            info.driver = ["driver", "software", ""][i].to_owned();
            info.driver_info = ["1.5", "", "0.1"][i].to_owned();
            AdapterSummary {
                info,
                limits: wgpu::Limits {
                    max_storage_buffer_binding_size: 3 << 30,
                    max_buffer_size: (5 << 20) + i as u64,
                    max_storage_buffers_per_shader_stage: 7,
                    max_texture_dimension_2d: 11,
                    max_compute_invocations_per_workgroup: 13,
                    max_compute_workgroups_per_dimension: 17,
                    ..wgpu::Limits::default()
                },
                missing: (i == 2).then(|| "it has no shaders".to_owned()),
            }
        })
    }

    #[test]
    fn every_adapter_is_described_line_by_line() {
        let limits =
            "   limits    3 GiB a storage binding, 5 MiB a buffer, 7 storage buffers a stage,
             textures to 11 px, 13 invocations a workgroup, 17 workgroups a dispatch";
        let expected = format!(
            "1. Quick
   type      discrete GPU
   driver    driver 1.5
   backend   vulkan
{limits}
   usable    yes; taken by default
2. Patient
   type      software, on the CPU
   driver    software
   backend   vulkan
{limits}
   usable    yes: --adapter 'Patient'
3. Old
   type      integrated GPU
   driver    0.1
   backend   metal
{limits}
   usable    no: it has no shaders

CPU renderer: always there (--cpu), "
        );
        let text = text(&adapters());
        let (version, rest) = text.split_once("\n\n").unwrap_or_default();
        assert_eq!(version, concat!("Snell ", env!("CARGO_PKG_VERSION")));
        assert!(rest.starts_with(&expected), "{text}");
    }

    #[test]
    fn one_adapter_that_can_be_used_is_enough() {
        let [quick, patient, old] = adapters();
        assert!(verdict(&[quick, patient.clone()]).is_ok());
        assert!(verdict(&[old.clone(), patient]).is_ok());
        assert!(verdict(&[old]).is_err());
        assert!(verdict(&[]).is_err());
    }

    #[test]
    fn sizes_are_in_the_largest_unit_that_they_fill() {
        let shown = [0, 1023, 1024, (1 << 20) - 1, 1 << 20, 1 << 31, 1 << 45].map(bytes);
        let expected = [
            "0 bytes",
            "1023 bytes",
            "1 KiB",
            "1023 KiB",
            "1 MiB",
            "2 GiB",
            "32768 GiB",
        ];
        assert_eq!(shown, expected);
    }
}
