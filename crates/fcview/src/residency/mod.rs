//! Which vertices are on the GPU: all of them, or pages of them that come and go.
//!
//! Where a budget or the adapter does not allow all vertices, they are ordered by how early they are drawn and divided
//! into pages, which live in the slots of one buffer. A page is uploaded when triangles first use it, and the least
//! recently used one makes room for it. See `docs/decisions/0018-vertex-pages.md`.

mod level_order;
mod needs;
mod paged;
mod parcels;
mod slots;

pub(crate) use needs::{Needs, needs};
pub(crate) use paged::Paged;

use crate::gpu::vertices::{VERTEX_BYTES, Vertices};
use crate::scene::Scene;
use crate::stats::MemoryStats;
use crate::{Error, Gpu};

/// Vertices of a page. Larger ones hold more that a view does not use, smaller ones take more copies: near a surface, views
/// need up to 1.4 times less memory with 64 and 1.4 times more with 1,024.
pub(crate) const PAGE_VERTICES: u32 = 256;

/// Bytes of a page on the GPU.
pub(crate) const PAGE_BYTES: u64 = PAGE_VERTICES as u64 * VERTEX_BYTES;

/// The fewest slots: a triangle has its corners in up to three pages.
const FEWEST_SLOTS: u64 = 3;

/// A pool that had to be made smaller is never made smaller than this, bytes: what is missing then is no memory for
/// vertices.
const LEAST_SHRUNK: u64 = 1 << 17;

/// The vertices of a scene's models on the GPU.
pub(crate) enum Residency {
    /// All of them, a buffer for each model.
    Whole(Vec<wgpu::Buffer>),
    /// Pages of them.
    Paged(Box<Paged>),
}

impl Residency {
    /// Uploads all vertices if that takes no more than `budget` bytes and the adapter has such buffers; else makes a pool
    /// for pages, smaller ones until the device has the memory.
    ///
    /// # Errors
    /// [`Error::GpuMemory`] if the budget does not hold a triangle, or what the driver says.
    pub(crate) fn new(gpu: &Gpu, scene: &Scene, budget: Option<u64>) -> Result<Residency, Error> {
        let budget = budget.unwrap_or(u64::MAX);
        let total = total_bytes(scene);
        if is_whole(scene, budget, gpu.limits().max_buffer_size) {
            let mut buffers = Vec::with_capacity(scene.models.len());
            for model in &scene.models {
                buffers.push(Vertices::of(&model.tree).upload(gpu, &model.name));
                // Submitting now frees the staging memory before the next model needs its own.
                gpu.queue.submit([]);
            }
            match gpu.check() {
                Err(Error::DeviceMemory { .. }) if total / 2 >= LEAST_SHRUNK => {}
                done => return done.map(|()| Residency::Whole(buffers)),
            }
        }
        let mut bytes = budget.min(total);
        loop {
            let pool = Paged::new(gpu, scene, bytes)?;
            match gpu.check() {
                Err(Error::DeviceMemory { .. }) if bytes / 2 >= LEAST_SHRUNK => bytes /= 2,
                done => return done.map(|()| Residency::Paged(Box::new(pool))),
            }
        }
    }

    /// Half the bytes of what there is, for a device that has run out of memory; none if that would not help.
    pub(crate) fn half(&self, scene: &Scene) -> Option<u64> {
        let bytes = match self {
            Residency::Whole(_) => total_bytes(scene),
            Residency::Paged(paged) => paged.bytes(),
        } / 2;
        (bytes >= LEAST_SHRUNK).then_some(bytes)
    }

    /// Forgets which pages are there, for when it is not known what a device has done.
    pub(crate) fn forget(&mut self) {
        if let Residency::Paged(paged) = self {
            paged.forget();
        }
    }

    /// The buffer that holds a model's vertices.
    pub(crate) fn buffer(&self, model: usize) -> Option<&wgpu::Buffer> {
        match self {
            Residency::Whole(buffers) => buffers.get(model),
            Residency::Paged(paged) => Some(paged.buffer()),
        }
    }

    /// What is there, and what has come and gone since the frame began.
    pub(crate) fn stats(&self, coarser: f64) -> MemoryStats {
        match self {
            Residency::Whole(buffers) => {
                let bytes: u64 = buffers.iter().map(wgpu::Buffer::size).sum();
                let pages = buffers.iter().map(|buffer| buffer.size().div_ceil(PAGE_BYTES)).sum();
                MemoryStats { bytes, pages, pages_resident: pages, coarser, ..MemoryStats::default() }
            }
            Residency::Paged(paged) => MemoryStats { coarser, ..paged.stats() },
        }
    }
}

/// Bytes of all vertices of a scene's models.
fn total_bytes(scene: &Scene) -> u64 {
    scene.models.iter().map(|model| model.tree.vertices().len() as u64 * VERTEX_BYTES).sum()
}

/// Whether all vertices may be there at once.
fn is_whole(scene: &Scene, budget: u64, largest_buffer: u64) -> bool {
    let fits = |vertices: usize| vertices as u64 * VERTEX_BYTES <= largest_buffer;
    total_bytes(scene) <= budget && scene.models.iter().all(|model| fits(model.tree.vertices().len()))
}

/// The slots of a pool.
///
/// # Errors
/// [`Error::GpuMemory`] if a triangle might not fit.
fn slots_within(bytes: u64, pages: u64, largest_buffer: u64) -> Result<u32, Error> {
    // The pool's vertices are counted in 32 bits.
    let most = u64::from(u32::MAX / PAGE_VERTICES);
    let slots = (bytes.min(largest_buffer) / PAGE_BYTES).min(most);
    let enough = pages.min(FEWEST_SLOTS);
    if slots < enough {
        return Err(Error::GpuMemory { bytes, least: FEWEST_SLOTS * PAGE_BYTES });
    }
    Ok(slots.min(pages) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pool_has_the_slots_that_budget_pages_and_adapter_allow() {
        let slots = |bytes, pages, largest| slots_within(bytes, pages, largest).ok();
        assert_eq!(slots(u64::MAX, 1000, u64::MAX), Some(1000), "no more than there are pages");
        assert_eq!(slots(10 * PAGE_BYTES + 7, 1000, u64::MAX), Some(10));
        assert_eq!(slots(u64::MAX, 1000, 100 * PAGE_BYTES), Some(100), "one buffer of the adapter");
        assert_eq!(slots(u64::MAX, u64::MAX, u64::MAX), Some(u32::MAX / PAGE_VERTICES), "32-bit indices");
        assert_eq!(slots(3 * PAGE_BYTES, 1000, u64::MAX), Some(3), "one triangle");
        assert_eq!(slots(3 * PAGE_BYTES - 1, 1000, u64::MAX), None);
        assert_eq!(slots(PAGE_BYTES, 1, u64::MAX), Some(1));
        let error = slots_within(5, 1000, u64::MAX).unwrap_err();
        assert_eq!((error.code(), error.exit_code()), ("FC524", 5));
        assert!(error.to_string().contains("15360"), "{error}");
    }
}
