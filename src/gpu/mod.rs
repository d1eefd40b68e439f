//! The GPU side: an adapter, linked kernels, the packed scene uploaded, and the wavefront loop.

pub mod device;
pub mod fetch;
pub mod kernel;
pub mod link;
pub mod prune;
pub mod read;
pub mod render;
pub mod shaders;
pub mod upload;
pub mod variant;
pub mod wavefront;
