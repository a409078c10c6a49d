//! What is read of a chunk's top: where it is, how much it takes, and whether it is whole.

use std::ops::Range;

use zerocopy::IntoBytes;
use zerocopy::little_endian::U32;

use super::ChunkRecord;
use super::load::{Chunk, PageRoot};
use crate::child::ChildRef;
use crate::container::Spans;
use crate::hash::hash64_of;
use crate::records::{PageRecord, TopRecord};
use crate::walk::to_index;

/// The elements of each section that make the top of a chunk.
#[derive(Clone, Debug)]
pub(super) struct Wanted {
    pub(super) hash: u64,
    pub(super) root: ChildRef,
    pub(super) tops: Range<usize>,
    pub(super) top_loops: Range<usize>,
    pub(super) pages: Range<usize>,
    pub(super) links: Range<usize>,
    pub(super) copies: Range<usize>,
}

impl Wanted {
    /// None if the chunk is not there, or its runs leave their sections.
    pub(super) fn of(chunks: &[ChunkRecord], chunk: u32, spans: &Spans, copies: usize) -> Option<Self> {
        let index = to_index(chunk)?;
        let record = chunks.get(index)?;
        let next = chunks.get(index.checked_add(1)?);
        let run = |field: fn(&ChunkRecord) -> U32, end: usize| {
            let next = next.map_or(Some(end), |n| to_index(field(n).get()))?;
            let start = to_index(field(record).get())?;
            (start <= next && next <= end).then_some(start..next)
        };
        let count = |section: &Range<usize>, size: usize| section.len().checked_div(size).unwrap_or(0);
        let pages = run(|c| c.page, count(&spans.page, size_of::<PageRecord>()))?;
        let top = to_index(record.top.get())?;
        let tops = top..top.checked_add(pages.len().checked_sub(1)?)?;
        let top_loop = to_index(record.top_loop.get())?;
        let top_loops = top_loop..top_loop.checked_add(to_index(record.top_loop_bytes.get())?)?;
        let inside =
            tops.end <= count(&spans.topn, size_of::<TopRecord>()) && top_loops.end <= spans.topl.len();
        inside.then_some(())?;
        Some(Self {
            hash: record.hash.get(),
            root: ChildRef::from_raw(record.root.get()),
            tops,
            top_loops,
            pages,
            links: run(|c| c.link, count(&spans.link, size_of::<U32>()))?,
            copies: run(|c| c.copies, copies)?,
        })
    }

    /// The most bytes of memory that the top takes, the reading included.
    pub(super) fn memory(&self) -> u64 {
        // A vertex takes more bytes in the file than its name does here.
        let sizes = [
            (self.tops.len(), size_of::<TopRecord>()),
            (self.top_loops.len(), 1),
            (self.pages.len(), size_of::<PageRecord>().saturating_add(size_of::<PageRoot>())),
            (self.links.len(), size_of::<U32>()),
            (self.copies.len(), 3),
            (1, size_of::<Chunk>()),
        ];
        let bytes =
            sizes.iter().map(|(count, size)| count.saturating_mul(*size)).fold(0, usize::saturating_add);
        u64::try_from(bytes).unwrap_or(u64::MAX)
    }
}

/// What is read of a chunk's top.
#[derive(Debug)]
pub(super) struct Runs {
    pub(super) tops: Vec<TopRecord>,
    pub(super) top_loops: Vec<u8>,
    pub(super) pages: Vec<PageRecord>,
    pub(super) links: Vec<U32>,
    pub(super) copies: Vec<u8>,
}

impl Runs {
    pub(super) fn hash(&self) -> u64 {
        hash64_of(&[
            self.tops.as_bytes(),
            &self.top_loops,
            self.pages.as_bytes(),
            self.links.as_bytes(),
            &self.copies,
        ])
    }
}
