//! The GPU side: device, pipelines, vertex buffers, occlusion queries, read-back. Knows triangles and polygons,
//! nothing of trees or of what is worth drawing.

pub(crate) mod census;
mod device;
pub(crate) mod occlusion;
pub(crate) mod outlines;
pub(crate) mod pages;
pub(crate) mod pipelines;
pub(crate) mod readback;
pub(crate) mod target;
pub(crate) mod vertices;

pub use device::Gpu;
#[cfg(feature = "window")]
pub(crate) use device::first_that_works;
