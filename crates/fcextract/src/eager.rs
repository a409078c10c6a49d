//! The most eager vertices of pages and of nodes above them, found once for a tree and kept beside it.
//!
//! A node that is drawn from afar has few active vertices among the many that its page has or its loops pass. Which of
//! them may be active at all follows from their keys, so they are sorted out by these before a view looks at them. That
//! depends on the tree alone: any view, before or after, finds the same.

use crate::Order;
use crate::criterion::least_over;
use fct::{LOOP_END, Loops, Node, Page, ShortFloat, Tree, VertexRecord};
use std::sync::OnceLock;
use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::{Acquire, Relaxed, Release};
use zerocopy::FromZeros;

/// What is kept beside a tree.
#[derive(Debug, Default)]
pub(crate) struct Eager {
    by_bound: OnceLock<Option<Table>>,
    by_budget: OnceLock<Option<Table>>,
}

/// The most eager vertices by one order: 256 bytes a page and 128 bytes a node above the pages, together about 2.3 bytes
/// a face, of which only those are ever touched that were drawn.
///
/// A row is written whole before its first number is, and any thread that writes it writes the same.
#[derive(Debug)]
pub(crate) struct Table {
    order: Order,
    /// How far it is, then vertices from the most eager one on: [`rank_of`] and local index.
    pages: Vec<[AtomicU32; PAGE_ROW]>,
    /// How far it is, then vertices of loops in order; the last of each loop has [`LOOP_END`].
    tops: Vec<[AtomicU32; TOP_ROW]>,
}

/// A row has one number more than vertices. More of them take memory and serve views that draw more of a page, where
/// looking at all its vertices is soon done.
const PAGE_ROW: usize = 64;

/// The same above the pages. The polygon of a node has 6 corners in the mean.
const TOP_ROW: usize = 32;

/// It was drawn once. What is drawn but once is not worth sorting.
const DRAWN: u32 = 1;

/// The row of a page is there.
const READY: u32 = 1 << 31;

/// So many ranks below a node's own key, half of it, its row ends: where less is allowed near the node than that, the eye
/// is so near that all its vertices are looked at.
const RANKS_BELOW: i16 = 128;

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
        })
    }

    /// Shows the local indices of all vertices of a page that may be active where vertices with keys below `least` are
    /// not, unless their spheres are larger than the page's; false, and none, if it does not know.
    pub(crate) fn show_of_page(&self, page: &Page<'_>, least: i16, mut show: impl FnMut(u8)) -> bool {
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
            show(local);
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

    /// Finds the loops of a node above the pages without vertices that are not active where those with keys below `least`
    /// are not, unless their spheres are larger than the node's; false if it does not know.
    pub(crate) fn read_top(&self, top: u32, least: i16, out: &mut Loops) -> bool {
        let Some([state, entries @ ..]) = self.tops.get(top as usize) else { return false };
        // The least rank of what is in the row, its length, and whether it is there.
        let [low, high, count, ready] = state.load(Acquire).to_le_bytes();
        let known = i16::from_le_bytes([low, high]);
        if ready == 0 || least < known || known == i16::MAX {
            return false;
        }
        out.clear();
        for entry in entries.iter().take(count.into()) {
            let vertex = entry.load(Relaxed);
            out.vertices.push(vertex & !LOOP_END);
            if vertex & LOOP_END != 0 {
                out.ends.push(out.vertices.len());
            }
        }
        true
    }

    /// Writes down what there is to know of a node above the pages, by its loops.
    pub(crate) fn fill_top(&self, top: u32, node: &Node, records: &[VertexRecord], loops: &Loops) {
        let Some([state, entries @ ..]) = self.tops.get(top as usize) else { return };
        match state.load(Relaxed) {
            0 => return note_drawn(state),
            DRAWN => {}
            _ => return,
        }
        let small = small(node);
        let rank = |vertex: u32| records.get(vertex as usize).map_or(i16::MAX, |r| self.rank_of(r, small));
        // The ranks of as many vertices as fit, and one more: from its rank on there are too many.
        let mut most = [i16::MIN; TOP_ROW];
        for vertex in &loops.vertices {
            let mut rank = rank(*vertex);
            if most.last().is_some_and(|least| rank > *least) {
                for slot in &mut most {
                    let higher = rank.max(*slot);
                    (*slot, rank) = (higher, rank.min(*slot));
                }
            }
        }
        let own = ShortFloat::down(f64::from(self.order.of_node(node))).rank();
        let too_many = most.last().copied().unwrap_or(i16::MAX);
        let least = too_many.saturating_add(1).max(own.saturating_sub(RANKS_BELOW)).max(0);
        let mut kept = [0_u32; TOP_ROW - 1];
        let mut count = 0_usize;
        for ring in loops.iter() {
            let start = count;
            for vertex in ring.iter().filter(|v| rank(**v) >= least) {
                // If there are too many of the highest rank, the row is never read.
                count = count.min(kept.len() - 1);
                kept[count] = *vertex;
                count += 1;
            }
            if count < start + 3 {
                // It would vanish in any case.
                count = start;
            } else {
                kept[count - 1] |= LOOP_END;
            }
        }
        for (entry, vertex) in entries.iter().zip(&kept).take(count) {
            entry.store(*vertex, Relaxed);
        }
        let [low, high] = least.to_le_bytes();
        // A row is shorter than a byte can tell.
        state.store(u32::from_le_bytes([low, high, count as u8, 1]), Release);
    }

    /// The rank of a vertex's key; the highest if its sphere is not `small`, since its key says nothing then.
    fn rank_of(&self, vertex: &VertexRecord, small: i16) -> i16 {
        if vertex.radius.rank() < small {
            self.order.of([vertex.bound, vertex.budget]).rank().max(0)
        } else {
            i16::MAX
        }
    }
}

/// Notes that something was drawn for the first time, unless another thread has gone on meanwhile.
fn note_drawn(state: &AtomicU32) {
    let _ = state.compare_exchange(0, DRAWN, Relaxed, Relaxed);
}

/// Spheres whose radii have a lower rank than this are no larger than a node's.
fn small(node: &Node) -> i16 {
    least_over(f64::from(node.radius))
}
