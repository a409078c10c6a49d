//! Pages of vertices in a buffer on the GPU.

use super::level_order::LevelOrder;
use super::needs::Needs;
use super::parcels::{self, Parcel};
use super::slots::{Arrival, Slots};
use super::{PAGE_BYTES, PAGE_VERTICES, slots_within};
use crate::gpu::pages::Pages;
use crate::gpu::pipelines::SurfaceVertex;
use crate::gpu::vertices::Vertices;
use crate::scene::Scene;
use crate::stats::MemoryStats;
use crate::{Error, Gpu};
use rayon::prelude::*;
use std::ops::Range;

/// Bytes of pages that are handed to the driver at a time: what waits to be copied takes memory too.
const AT_A_TIME: u64 = 4 << 20;

/// A scene's vertices, some of which are on the GPU.
pub(crate) struct Paged {
    models: Vec<PagedModel>,
    /// All pages of all models.
    pages: u32,
    slots: Slots,
    buffer: wgpu::Buffer,
    staging: Pages,
    uploaded: u64,
    evicted: u64,
}

struct PagedModel {
    order: LevelOrder,
    /// The number of its first page among those of all models.
    first_page: u32,
}

impl Paged {
    /// A pool of at most so many bytes.
    ///
    /// # Errors
    /// [`Error::GpuMemory`] if it does not hold a triangle.
    pub(crate) fn new(gpu: &Gpu, scene: &Scene, bytes: u64) -> Result<Paged, Error> {
        let pages_of = |vertices: usize| (vertices as u64).div_ceil(u64::from(PAGE_VERTICES));
        let pages = scene.models.iter().map(|model| pages_of(model.tree.vertices().len())).sum();
        let slots = slots_within(bytes, pages, gpu.limits().max_buffer_size)?;
        // A model has less than 2^32 vertices; some hundred of the largest ones would be more pages than are counted.
        let pages = u32::try_from(pages).map_err(|_overflow| Error::GpuMemory { bytes, least: u64::MAX })?;
        let mut models = Vec::with_capacity(scene.models.len());
        let mut first_page = 0;
        for model in &scene.models {
            let records = model.tree.vertices();
            models.push(PagedModel { order: LevelOrder::new(records), first_page });
            first_page += pages_of(records.len()) as u32;
        }
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("vertex pages"),
            size: u64::from(slots.max(1)) * PAGE_BYTES,
            usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let staging = Pages::new(
            "vertex pages to copy",
            size_of::<SurfaceVertex>() as u64,
            wgpu::BufferUsages::COPY_SRC,
        );
        Ok(Paged { models, pages, slots: Slots::new(slots, pages), buffer, staging, uploaded: 0, evicted: 0 })
    }

    /// The size of the pool.
    pub(crate) fn bytes(&self) -> u64 {
        u64::from(self.slots.len()) * PAGE_BYTES
    }

    /// The pool.
    pub(crate) fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    /// The number of slots.
    pub(crate) fn slots(&self) -> u32 {
        self.slots.len()
    }

    /// The number of pages of all models.
    pub(crate) fn pages(&self) -> u32 {
        self.pages
    }

    pub(super) fn forget(&mut self) {
        self.slots.clear();
    }

    pub(super) fn stats(&self) -> MemoryStats {
        MemoryStats {
            bytes: self.bytes(),
            pages: u64::from(self.pages),
            pages_resident: u64::from(self.slots.resident()),
            pages_uploaded: self.uploaded,
            pages_evicted: self.evicted,
            coarser: 1.0,
        }
    }

    /// Begins a frame, of which it may be known which pages it needs.
    pub(crate) fn begin_frame(&mut self, needs: Option<&Needs>) {
        (self.uploaded, self.evicted) = (0, 0);
        if let Some(needs) = needs {
            self.slots.keep(|page| needs.holds(page));
        }
    }

    /// The page of a vertex of a model.
    #[inline]
    pub(crate) fn page(&self, model: usize, vertex: u32) -> u32 {
        let Some(model) = self.models.get(model) else { return 0 };
        model.first_page + model.order.place(vertex) / PAGE_VERTICES
    }

    /// The triangles of some meshes (their model and corners) in parcels, and these in groups that are drawn at once.
    pub(crate) fn parcels(&self, meshes: &[(usize, &[u32])]) -> (Vec<Parcel>, Vec<Range<usize>>) {
        let parcels: Vec<Vec<Parcel>> = meshes
            .par_iter()
            .enumerate()
            .map(|(number, (model, corners))| {
                parcels::parcels(number, corners, self.slots(), |vertex| self.page(*model, vertex))
            })
            .collect();
        let parcels: Vec<Parcel> = parcels.into_iter().flatten().collect();
        let groups = parcels::groups(&parcels, self.slots(), self.pages);
        (parcels, groups)
    }

    /// Puts the pages of a group of parcels into slots, for what is submitted next.
    ///
    /// # Errors
    /// As [`Pages::push`].
    pub(crate) fn load(&mut self, gpu: &Gpu, scene: &Scene, parcels: &[Parcel]) -> Result<(), Error> {
        let mut pages: Vec<u32> = parcels.iter().flat_map(|parcel| parcel.pages.iter().copied()).collect();
        pages.sort_unstable();
        pages.dedup();
        let (arrivals, gone) = self.slots.place(&pages);
        self.uploaded += arrivals.len() as u64;
        self.evicted += u64::from(gone);
        for some in arrivals.chunks((AT_A_TIME / PAGE_BYTES) as usize) {
            self.copy(gpu, scene, some)?;
        }
        Ok(())
    }

    /// The corners of a parcel as indices into the pool, when its pages were loaded.
    pub(crate) fn indices(&self, model: usize, corners: &[u32]) -> Vec<u32> {
        let Some(of) = self.models.get(model) else { return Vec::new() };
        let index = |vertex: &u32| {
            let place = of.order.place(*vertex);
            let slot = self.slots.slot(of.first_page + place / PAGE_VERTICES).unwrap_or(0);
            slot * PAGE_VERTICES + place % PAGE_VERTICES
        };
        corners.iter().map(index).collect()
    }

    /// Copies pages to their slots, neighbours at once.
    fn copy(&mut self, gpu: &Gpu, scene: &Scene, arrivals: &[Arrival]) -> Result<(), Error> {
        let data: Vec<SurfaceVertex> =
            arrivals.par_iter().flat_map_iter(|arrival| self.vertices(scene, arrival.page)).collect();
        let bytes: &[u8] = bytemuck::cast_slice(&data);
        self.staging.restart(gpu, bytes.len() as u64);
        let place = self.staging.push(gpu, "the scene", &[bytes])?;
        let Some(staging) = self.staging.buffer(place.page) else { return Ok(()) };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let mut from = u64::from(place.first) * size_of::<SurfaceVertex>() as u64;
        for run in arrivals.chunk_by(|a, b| a.slot + 1 == b.slot) {
            let Some(first) = run.first() else { continue };
            let bytes = run.len() as u64 * PAGE_BYTES;
            let to = u64::from(first.slot) * PAGE_BYTES;
            encoder.copy_buffer_to_buffer(staging, from, &self.buffer, to, bytes);
            from += bytes;
        }
        gpu.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// The vertices of a page; zeros after the last one of a model.
    fn vertices(&self, scene: &Scene, page: u32) -> impl Iterator<Item = SurfaceVertex> {
        let number = self.models.partition_point(|model| model.first_page <= page).saturating_sub(1);
        let mut out = vec![SurfaceVertex::default(); PAGE_VERTICES as usize];
        if let (Some(of), Some(model)) = (self.models.get(number), scene.models.get(number)) {
            let start = (page.saturating_sub(of.first_page)) as usize * PAGE_VERTICES as usize;
            let all = Vertices::of(&model.tree);
            let places = of.order.vertices(start..start + PAGE_VERTICES as usize);
            for (out, vertex) in out.iter_mut().zip(places) {
                *out = all.get(*vertex as usize);
            }
        }
        out.into_iter()
    }
}
