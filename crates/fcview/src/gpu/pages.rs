//! The triangles of a frame on the GPU: buffers ("pages") that are filled anew and reused.

use super::device::Gpu;
use crate::Error;

/// Pages that hold elements of one stride.
pub(crate) struct Pages {
    label: &'static str,
    stride: u64,
    usage: wgpu::BufferUsages,
    pages: Vec<Page>,
}

struct Page {
    buffer: wgpu::Buffer,
    used: u64,
}

/// Where a run of elements was put.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Place {
    /// The page.
    pub(crate) page: usize,
    /// The first element within it.
    pub(crate) first: u32,
}

/// The smallest page, bytes: below it many small pages would cost more than the memory they save.
const SMALLEST_PAGE: u64 = 4 << 20;

impl Pages {
    /// No pages yet.
    pub(crate) fn new(label: &'static str, stride: u64, usage: wgpu::BufferUsages) -> Pages {
        Pages { label, stride, usage: usage | wgpu::BufferUsages::COPY_DST, pages: Vec::new() }
    }

    /// Gives all pages back.
    pub(crate) fn clear(&mut self) {
        self.pages.clear();
    }

    /// Forgets what the pages hold and makes the first one large enough for `bytes`, as far as the adapter allows.
    pub(crate) fn restart(&mut self, gpu: &Gpu, bytes: u64) {
        let capacity: u64 = self.pages.iter().map(|page| page.buffer.size()).sum();
        // Also given back when a quarter would do, so that one full-resolution frame does not hold memory for ever.
        if capacity < bytes || capacity / 4 > bytes.max(SMALLEST_PAGE) {
            self.pages.clear();
            if bytes > 0 {
                let size = bytes.saturating_add(bytes / 4).max(SMALLEST_PAGE).min(self.limit(gpu));
                self.add_page(gpu, size);
            }
        }
        for page in &mut self.pages {
            page.used = 0;
        }
    }

    /// Copies elements, some slices of them one after the other, into a page with room for all of them.
    ///
    /// # Errors
    /// [`Error::BufferSize`] if no buffer of the adapter can hold them in one piece.
    pub(crate) fn push(&mut self, gpu: &Gpu, what: &str, data: &[&[u8]]) -> Result<Place, Error> {
        let bytes: u64 = data.iter().map(|slice| slice.len() as u64).sum();
        let limit = self.limit(gpu);
        if bytes > limit {
            return Err(Error::BufferSize {
                what: format!("{what}: its triangles"),
                bytes,
                limit,
                remedy: "draw fewer with --pixels or --triangles",
            });
        }
        let fits = |page: &Page| page.buffer.size() - page.used >= bytes;
        let number = match self.pages.iter().position(fits) {
            Some(number) => number,
            None => {
                self.add_page(gpu, bytes.max(SMALLEST_PAGE).min(limit));
                self.pages.len() - 1
            }
        };
        let Some(page) = self.pages.get_mut(number) else { return Ok(Place::default()) };
        let place = Place { page: number, first: (page.used / self.stride) as u32 };
        if let Some(size) = wgpu::BufferSize::new(bytes)
            && let Some(mut view) = gpu.queue.write_buffer_with(&page.buffer, page.used, size)
        {
            let mut start = 0;
            for slice in data {
                view.slice(start..start + slice.len()).copy_from_slice(slice);
                start += slice.len();
            }
        }
        page.used += bytes;
        Ok(place)
    }

    /// Bytes in use.
    pub(crate) fn used(&self) -> u64 {
        self.pages.iter().map(|page| page.used).sum()
    }

    /// The buffer of a page.
    pub(crate) fn buffer(&self, page: usize) -> Option<&wgpu::Buffer> {
        self.pages.get(page).map(|page| &page.buffer)
    }

    /// The most bytes of a page: whole elements, countable in 32 bits.
    fn limit(&self, gpu: &Gpu) -> u64 {
        let bytes = gpu.limits().max_buffer_size.min(u64::from(u32::MAX) * self.stride);
        bytes - bytes % (self.stride * 4)
    }

    fn add_page(&mut self, gpu: &Gpu, bytes: u64) {
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(self.label),
            size: bytes.next_multiple_of(self.stride * 4).min(self.limit(gpu)),
            usage: self.usage,
            mapped_at_creation: false,
        });
        self.pages.push(Page { buffer, used: 0 });
    }
}
