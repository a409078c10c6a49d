//! The most eager vertices of pages and of nodes above them, found once for a tree and kept beside it.
//!
//! A node that is drawn from afar has few active vertices among the many that its page has or its loops pass. Which of
//! them may be active at all follows from their keys, so they are sorted out by these before a view looks at them. That
//! depends on the tree alone: any view, before or after, finds the same.

mod ring;

pub(crate) use ring::Kept;

use crate::criterion::{Boundary, Thresholds, least_over};
use crate::{Error, Order};
use fct::{Loops, Node, Page, Reader, SMALL_FACES, ShortFloat, Subtree, Tree, VertexRecord};
use ring::{Row, is_due};
use std::sync::OnceLock;
use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::{Acquire, Relaxed, Release};
use zerocopy::{FromZeros, IntoBytes};

/// What is kept beside a tree.
#[derive(Debug, Default)]
pub(crate) struct Eager {
    by_bound: OnceLock<Option<Table>>,
    by_budget: OnceLock<Option<Table>>,
}

/// The most eager vertices by one order: 444 bytes a page and 188 bytes a node above the pages, together about 4.1 bytes
/// a face, of which only those are ever touched that were drawn.
///
/// A row is written whole before its first number is, and any thread that writes it writes the same.
#[derive(Debug)]
pub(crate) struct Table {
    order: Order,
    /// How far it is, then vertices from the most eager one on: [`rank_of`] and local index.
    pages: Vec<[AtomicU32; PAGE_ROW]>,
    /// The boundaries of nodes above the pages.
    tops: Vec<Row>,
    /// Those of the roots of pages.
    roots: Vec<Row>,
}

/// A row has one number more than vertices. More of them take memory and serve views that draw more of a page, where
/// looking at all its vertices is soon done.
const PAGE_ROW: usize = 64;

/// Stands for the rank of a vertex about which its key says nothing.
pub(crate) const UNKNOWN: i16 = i16::MAX;

/// It was drawn once. What is drawn but once is not worth sorting.
const DRAWN: u32 = 1;

/// The row of a page is there.
const READY: u32 = 1 << 31;

impl Eager {
    /// The table of a tree; none if there is no memory for it.
    pub(crate) fn of(tree: &Tree, order: Order) -> Option<&Table> {
        let eager = tree.derived(Eager::default)?;
        let table = match order {
            Order::Bound => &eager.by_bound,
            Order::Budget => &eager.by_budget,
        };
        table.get_or_init(|| Table::new(tree, order)).as_ref()
    }
}

impl Table {
    fn new(tree: &Tree, order: Order) -> Option<Table> {
        let (tops, pages) = tree.top_and_page_counts();
        Some(Table {
            order,
            pages: FromZeros::new_vec_zeroed(pages).ok()?,
            tops: FromZeros::new_vec_zeroed(tops).ok()?,
            roots: FromZeros::new_vec_zeroed(pages).ok()?,
        })
    }

    /// Shows the local indices and ranks of all vertices of a page that may be active where vertices with keys below
    /// `least` are not, unless their spheres are larger than the page's, which have [`UNKNOWN`]; false, and none, if it
    /// does not know.
    #[inline]
    pub(crate) fn show_of_page(&self, page: &Page<'_>, least: i16, mut show: impl FnMut(u8, i16)) -> bool {
        let Some(row) = self.pages.get(page.number() as usize) else { return false };
        let [state, entries @ ..] = row;
        let state = match state.load(Acquire) {
            0 => {
                note_drawn(state);
                return false;
            }
            DRAWN => {
                if !self.fill_page(page, entries) {
                    return false;
                }
                state.store(READY, Release);
                READY
            }
            state => state,
        };
        if state != READY {
            return false;
        }
        let count = page.vertex_count();
        let read = |entry: &AtomicU32| {
            let [local, low, high, _] = entry.load(Relaxed).to_le_bytes();
            (local, i16::from_le_bytes([low, high]))
        };
        if count > entries.len() && entries.last().is_none_or(|entry| read(entry).1 >= least) {
            return false;
        }
        for (local, rank) in entries.iter().take(count).map(read) {
            if rank < least {
                break;
            }
            show(local, rank);
        }
        true
    }

    /// Writes the most eager vertices of a page; false if it does not have what it says.
    #[cold]
    fn fill_page(&self, page: &Page<'_>, entries: &[AtomicU32]) -> bool {
        let Some(root) = page.node(&page.whole()) else { return false };
        let small = small(&root);
        let mut all = [0_u32; 256];
        let count = page.vertex_count();
        for (local, slot) in (0..=u8::MAX).zip(all.iter_mut()).take(count) {
            let Some((_, record)) = page.vertex(local) else { return false };
            let [low, high] = self.rank_of(record, small).to_le_bytes();
            *slot = u32::from_le_bytes([local, low, high, 0]);
        }
        let Some(all) = all.get_mut(..count) else { return false };
        // Ranks are not negative.
        all.sort_unstable_by(|a, b| b.cmp(a));
        for (entry, found) in entries.iter().zip(all) {
            entry.store(*found, Relaxed);
        }
        true
    }

    /// Leaves what is drawn of the boundary of a node in `kept`; none if it does not know, as within pages.
    #[inline]
    pub(crate) fn keep_of(
        &self,
        reader: &Reader<'_>,
        subtree: &Subtree,
        boundary: &Boundary<'_>,
        kept: &mut Kept,
    ) -> Option<()> {
        let row = if let Some(top) = subtree.top() {
            self.tops.get(top as usize)?
        } else {
            let (page, root) = reader.page(subtree)?;
            self.roots.get(page.number() as usize).filter(|_| root == page.whole())?
        };
        let touch = |vertex: u32| reader.vertices().get(vertex as usize).map_or(0, touched);
        kept.read(row, boundary.thresholds, touch, |vertex| boundary.draws(vertex))
    }

    /// The same of a page's root.
    #[inline]
    pub(crate) fn keep_of_page(
        &self,
        page: &Page<'_>,
        thresholds: Thresholds,
        kept: &mut Kept,
        draws: impl FnMut(u32) -> bool,
    ) -> Option<()> {
        let touch = |vertex| page.record_of_vertex(vertex).map_or(0, touched);
        kept.read(self.roots.get(page.number() as usize)?, thresholds, touch, draws)
    }

    /// Writes down what there is to know of a node, by its loops and the first corner of its first face; of those in pages
    /// only of roots.
    pub(crate) fn fill(
        &self,
        reader: &Reader<'_>,
        (subtree, node): (&Subtree, &Node),
        loops: &Loops,
    ) -> Result<(), Error> {
        let Some(top) = subtree.top() else {
            if let Some((page, root)) = reader.page(subtree)
                && root == page.whole()
            {
                let _ = self.fill_root(&page);
            }
            return Ok(());
        };
        let Some(row) = self.tops.get(top as usize) else { return Ok(()) };
        if !is_due(row) {
            return Ok(());
        }
        let first_corner = reader.first_corner(subtree)?;
        let entries = loops.iter().flat_map(|ring| {
            let last = ring.len() - 1;
            ring.iter().enumerate().map(move |(i, vertex)| (*vertex, i == last))
        });
        let records = reader.vertices();
        let small = small(node);
        let rank = |vertex: u32| records.get(vertex as usize).map_or(UNKNOWN, |r| self.rank_of(r, small));
        ring::fill(row, first_corner, self.own_rank(node), entries.map(|(v, last)| (v, rank(v), last)));
        Ok(())
    }

    /// The same of a page's root; none if the page does not have what it says.
    pub(crate) fn fill_root(&self, page: &Page<'_>) -> Option<()> {
        let row = self.roots.get(page.number() as usize)?;
        let whole = page.whole();
        // The loops of smaller nodes follow from their faces, in whatever order.
        if whole.face_count() <= SMALL_FACES || !is_due(row) {
            return None;
        }
        let node = page.node(&whole)?;
        let small = small(&node);
        let mut all = [(0_u32, 0_i16, false); 256];
        let (mut count, mut is_whole) = (0, true);
        page.rings(&whole, |locals| {
            for (i, local) in locals.iter().enumerate() {
                match all.get_mut(count).zip(page.vertex(*local)) {
                    Some((slot, (vertex, record))) => {
                        *slot = (vertex, self.rank_of(record, small), i + 1 == locals.len());
                        count += 1;
                    }
                    None => is_whole = false,
                }
            }
        })?;
        let (first_corner, _) = page.vertex(page.first_face(&whole)?[0])?;
        if is_whole {
            ring::fill(row, first_corner, self.own_rank(&node), all.get(..count)?.iter().copied());
        }
        Some(())
    }

    fn own_rank(&self, node: &Node) -> i16 {
        ShortFloat::down(f64::from(self.order.of_node(node))).rank()
    }

    /// The rank of a vertex's key; the highest if its sphere is not `small`, since its key says nothing then.
    fn rank_of(&self, vertex: &VertexRecord, small: i16) -> i16 {
        if vertex.radius.rank() < small {
            self.order.of([vertex.bound, vertex.budget]).rank().max(0)
        } else {
            UNKNOWN
        }
    }
}

/// A number that takes reading a record's bytes, from all lines of memory that they are on.
fn touched(record: &VertexRecord) -> u8 {
    // What is asked for is the key, the sphere and the place: from the first byte to the radius' offset.
    let [x, ..] = record.position;
    x.as_bytes().first().copied().unwrap_or(0) ^ record.offset[2] as u8
}

/// Notes that something was drawn for the first time, unless another thread has gone on meanwhile.
fn note_drawn(state: &AtomicU32) {
    let _ = state.compare_exchange(0, DRAWN, Relaxed, Relaxed);
}

/// Spheres whose radii have a lower rank than this are no larger than a node's.
fn small(node: &Node) -> i16 {
    least_over(f64::from(node.radius))
}
