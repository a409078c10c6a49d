//! Which vertices may be drawn, and where their records are.

use std::ops::Range;

use fct::{Chunk, ChunkPage, Crown, NormalRecord, VertexRecord};

/// The vertices of the crown and of the chunks and pages that are entered.
#[derive(Debug)]
pub(super) struct Vertices<'a, 'b> {
    pub(super) crown: &'b Crown,
    pub(super) chunks: Vec<&'a Chunk>,
    /// In the order of the tree.
    pub(super) pages: Vec<&'a ChunkPage>,
}

/// The memory of a list, for a list of the like: of references that live for another time.
///
/// Collecting keeps the memory where both are of one size; `tests/tests/allocations.rs` notices if it does not.
pub(super) fn emptied<A, B>(list: Vec<A>) -> Vec<B> {
    list.into_iter().filter_map(|_| None).collect()
}

/// Where the record of a vertex is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Found {
    Crown(usize),
    /// In the top of an entered chunk: its place among those, and that of the vertex.
    Chunk(u32, u32),
    /// In an entered page, likewise.
    Page(u32, u32),
}

/// Where vertices are, by their names; reuse it to keep its memory.
#[derive(Debug, Default)]
pub(super) struct Index {
    /// Those in the tops of chunks, and those that pages link to.
    places: Vec<(u32, Found)>,
    /// Those that pages own.
    runs: Vec<Range<u32>>,
    seen: Seen,
}

/// A glance at whether a vertex is among some.
#[derive(Debug, Default)]
struct Seen {
    /// A bit for the last digits of names.
    words: Vec<u64>,
}

impl Seen {
    /// Forgets all, and makes room for so many.
    fn reset(&mut self, count: usize) {
        self.words.clear();
        self.words.resize((count / 8).next_power_of_two(), 0);
    }

    fn place(&self, id: u32) -> (usize, u64) {
        ((id as usize / 64) & (self.words.len() - 1), 1 << (id % 64))
    }

    fn add(&mut self, id: u32) {
        let (word, bit) = self.place(id);
        self.words[word] |= bit;
    }

    fn may_have(&self, id: u32) -> bool {
        let (word, bit) = self.place(id);
        self.words.get(word).is_some_and(|word| word & bit != 0)
    }
}

impl<'a, 'b> Vertices<'a, 'b> {
    /// Finds out where the vertices are, all at once.
    pub(super) fn index(&self, out: &mut Index) {
        let places = &mut out.places;
        places.clear();
        for (place, chunk) in (0..).zip(&self.chunks) {
            places.extend(chunk.ids().iter().zip(0..).map(|(id, at)| (*id, Found::Chunk(place, at))));
        }
        for (place, page) in (0..).zip(&self.pages) {
            let own = page.own_vertices().len() as u32;
            places.extend(page.linked().iter().zip(own..).map(|(id, at)| (*id, Found::Page(place, at))));
        }
        // Copies are alike, but for damage that no hash shows: then the first counts for all.
        places.sort_unstable();
        places.dedup_by_key(|entry| entry.0);
        out.runs.clear();
        out.runs.extend(self.pages.iter().map(|page| page.own_vertices()));

        let own: usize = out.runs.iter().map(ExactSizeIterator::len).sum();
        let count = self.crown.vertices().len() + out.places.len() + own;
        out.seen.reset(count);
        self.crown.ids().for_each(|id| out.seen.add(id));
        out.places.iter().for_each(|(id, _)| out.seen.add(*id));
        out.runs.iter().flat_map(Range::clone).for_each(|id| out.seen.add(id));
    }

    /// Where a vertex is that may be drawn; `index` is what [`Vertices::index`] made.
    fn find(&self, index: &Index, id: u32) -> Option<Found> {
        if !index.seen.may_have(id) {
            return None;
        }
        if let Some(place) = self.crown.find(id) {
            return Some(Found::Crown(place));
        }
        // Pages own runs of vertices, in order.
        let after = index.runs.partition_point(|run| run.start <= id);
        let owner = after.checked_sub(1).and_then(|at| Some((at, index.runs.get(at)?)));
        if let Some((at, own)) = owner.filter(|(_, own)| own.contains(&id)) {
            return Some(Found::Page(at as u32, id - own.start));
        }
        let at = index.places.binary_search_by_key(&id, |entry| entry.0).ok()?;
        Some(index.places.get(at)?.1)
    }

    /// Whether [`Vertices::find_twin`] may find a vertex: a glance, since most on the loops of a node are not drawn.
    pub(super) fn may_find(&self, index: &Index, id: u32) -> bool {
        index.seen.may_have(id) || self.crown.twins(id).next().is_some()
    }

    /// The same as [`Vertices::find`], or where a vertex is that stands in the same place, where a seam was cut.
    pub(super) fn find_twin(&self, index: &Index, id: u32) -> Option<Found> {
        self.find(index, id).or_else(|| self.crown.twins(id).find_map(|twin| self.find(index, twin)))
    }

    pub(super) fn record(&self, found: Found) -> Option<VertexRecord> {
        match found {
            Found::Crown(at) => self.crown.vertices().get(at).copied(),
            Found::Chunk(chunk, at) => self.chunks.get(chunk as usize)?.vertices().get(at as usize).copied(),
            Found::Page(page, at) => {
                self.pages.get(page as usize)?.reader().vertices().get(at as usize).copied()
            }
        }
    }

    pub(super) fn attributes(&self, found: Found) -> (Option<NormalRecord>, Option<[u8; 4]>) {
        let (normals, colors, at): (&[NormalRecord], &[[u8; 4]], usize) = match found {
            Found::Crown(at) => (self.crown.normals(), self.crown.colors(), at),
            Found::Chunk(chunk, at) => match self.chunks.get(chunk as usize) {
                Some(chunk) => (chunk.normals(), chunk.colors(), at as usize),
                None => (&[], &[], 0),
            },
            Found::Page(page, at) => match self.pages.get(page as usize) {
                Some(page) => (page.normals(), page.colors(), at as usize),
                None => (&[], &[], 0),
            },
        };
        (normals.get(at).copied(), colors.get(at).copied())
    }
}
