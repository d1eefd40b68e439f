//! Bringing a buffer's bytes back from the device.

use super::device::{Fault, Gpu};

/// Copies the first `bytes` of `source` (which has COPY_SRC) to the host, waiting for all that was
/// submitted before. The error is the fault that stopped it.
pub fn read(gpu: &Gpu, source: &wgpu::Buffer, bytes: u64) -> Result<Vec<u8>, Fault> {
    let staging = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("staging"),
        size: bytes,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(source, 0, &staging, 0, bytes);
    gpu.queue.submit([encoder.finish()]);
    let (sender, receiver) = std::sync::mpsc::channel();
    staging
        .slice(..)
        .map_async(wgpu::MapMode::Read, move |result| {
            // The receiver is gone only when waiting has failed already.
            sender.send(result).ok();
        });
    wait(gpu)?;
    match receiver.try_recv() {
        Ok(Ok(())) => {}
        Ok(Err(error)) => return Err(fault(gpu, &error)),
        Err(error) => return Err(fault(gpu, &error)),
    }
    let data = staging
        .slice(..)
        .get_mapped_range()
        .map_err(|error| fault(gpu, &error))?
        .to_vec();
    Ok(data)
}

/// Waits until the device has done all that was submitted.
pub fn wait(gpu: &Gpu) -> Result<(), Fault> {
    gpu.device
        .poll(wgpu::PollType::wait_indefinitely())
        .map_err(|error| fault(gpu, &error))?;
    gpu.take_fault().map_or(Ok(()), Err)
}

/// The fault that the device reported, or else the error that was seen.
fn fault(gpu: &Gpu, seen: &dyn std::error::Error) -> Fault {
    gpu.take_fault()
        .unwrap_or_else(|| Fault::Other(seen.to_string()))
}
