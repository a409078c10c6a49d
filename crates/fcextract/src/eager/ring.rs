//! What may be active of a node's boundary: one row a node, loop by loop.

use super::{DRAWN, UNKNOWN, note_drawn};
use crate::criterion::Thresholds;
use fct::LOOP_END;
use std::sync::atomic::AtomicU32;
use std::sync::atomic::Ordering::{Acquire, Relaxed, Release};

/// Vertices in a row. The polygon of a node has 6 corners in the mean, of which a view looks at 16.
const ENTRIES: usize = 30;

/// State, first corner of the first face, vertices of loops in order of which the last of each loop has [`LOOP_END`],
/// and their ranks two by two. The state is the least rank of what is in the row, its length, and whether it is there.
pub(super) type Row = [AtomicU32; 2 + ENTRIES + ENTRIES / 2];

/// So many ranks below a node's own key, half of it, its row ends: where less is allowed near the node than that, the eye
/// is so near that all its vertices are looked at.
const RANKS_BELOW: i16 = 128;

/// What is drawn of a boundary.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Kept {
    vertices: [u32; ENTRIES + 2],
    ends: [usize; ENTRIES / 2 + 1],
    count: usize,
    loops: usize,
    /// The first corner of the node's first face.
    pub(crate) first_corner: u32,
}

impl Kept {
    /// The vertices of all loops of three or more, one loop after the other.
    #[inline]
    pub(crate) fn vertices(&self) -> &[u32] {
        self.vertices.get(..self.count).unwrap_or_default()
    }

    /// Where each loop ends among them.
    #[inline]
    pub(crate) fn ends(&self) -> &[usize] {
        self.ends.get(..self.loops).unwrap_or_default()
    }

    /// Reads a row and leaves out what is not drawn, about which `draws` is asked in doubt, and `touch` before; none if
    /// there is no row, or not enough in it.
    #[inline]
    pub(super) fn read(
        &mut self,
        row: &Row,
        thresholds: Thresholds,
        touch: impl Fn(u32) -> u8,
        mut draws: impl FnMut(u32) -> bool,
    ) -> Option<()> {
        let [state, first_corner, entries @ ..] = row;
        let (vertices, ranks) = entries.split_first_chunk::<ENTRIES>()?;
        let [low, high, count, ready] = state.load(Acquire).to_le_bytes();
        let known = i16::from_le_bytes([low, high]);
        if ready == 0 || thresholds.inactive < known || known == UNKNOWN {
            return None;
        }
        self.first_corner = first_corner.load(Relaxed);
        // Records are anywhere in memory: all at once they come far sooner than one after the other.
        let in_doubt = if thresholds.inactive < thresholds.active { usize::from(count) } else { 0 };
        let mut touched = 0;
        for (pair, ranks) in vertices.as_chunks::<2>().0.iter().zip(ranks).take(in_doubt.div_ceil(2)) {
            let ranks = ranks.load(Relaxed);
            for (vertex, rank) in pair.iter().zip([ranks as i16, (ranks >> 16) as i16]) {
                if thresholds.of(rank).is_none() {
                    touched ^= touch(vertex.load(Relaxed) & !LOOP_END);
                }
            }
        }
        std::hint::black_box(touched);
        let (mut kept, mut start, mut loops) = (0_usize, 0_usize, 0_usize);
        let mut left = usize::from(count);
        for (pair, ranks) in vertices.as_chunks::<2>().0.iter().zip(ranks) {
            let ranks = ranks.load(Relaxed);
            for (vertex, rank) in pair.iter().zip([ranks as i16, (ranks >> 16) as i16]) {
                if left == 0 {
                    break;
                }
                left -= 1;
                let vertex = vertex.load(Relaxed);
                // Room for all of them, and a power of two.
                self.vertices[kept % (ENTRIES + 2)] = vertex & !LOOP_END;
                let is_drawn = match thresholds.of(rank) {
                    Some(is_drawn) => is_drawn,
                    None => draws(vertex & !LOOP_END),
                };
                kept += usize::from(is_drawn);
                if vertex & LOOP_END != 0 {
                    if kept < start + 3 {
                        kept = start;
                    } else {
                        self.ends[loops % (ENTRIES / 2 + 1)] = kept;
                        (start, loops) = (kept, loops + 1);
                    }
                }
            }
        }
        (self.count, self.loops) = (kept, loops);
        Some(())
    }
}

/// Whether a row is to be written: its node is drawn for the second time.
pub(super) fn is_due(row: &Row) -> bool {
    let [state, ..] = row;
    match state.load(Relaxed) {
        0 => {
            note_drawn(state);
            false
        }
        state => state == DRAWN,
    }
}

/// Writes a row of a node whose own key has that rank, by all vertices of its loops: their ranks, and whether each is the
/// last of its loop.
pub(super) fn fill(
    row: &Row,
    first_corner: u32,
    own: i16,
    entries: impl Iterator<Item = (u32, i16, bool)> + Clone,
) {
    let [state, corner, slots @ ..] = row;
    let Some((vertices, ranks)) = slots.split_first_chunk::<ENTRIES>() else { return };
    // The ranks of as many vertices as fit, and one more: from its rank on there are too many.
    let mut most = [i16::MIN; ENTRIES + 1];
    for (_, mut rank, _) in entries.clone() {
        if most.last().is_some_and(|least| rank > *least) {
            for slot in &mut most {
                let higher = rank.max(*slot);
                (*slot, rank) = (higher, rank.min(*slot));
            }
        }
    }
    let too_many = most.last().copied().unwrap_or(UNKNOWN);
    let least = too_many.saturating_add(1).max(own.saturating_sub(RANKS_BELOW)).max(0);
    let mut kept = [(0_u32, 0_i16); ENTRIES];
    let (mut start, mut count) = (0_usize, 0_usize);
    for (vertex, rank, is_last) in entries {
        if rank >= least {
            // If there are too many of the highest rank, the row is never read.
            count = count.min(ENTRIES - 1);
            kept[count] = (vertex, rank);
            count += 1;
        }
        if is_last {
            if count < start + 3 {
                // It would vanish in any case.
                count = start;
            } else {
                kept[count - 1].0 |= LOOP_END;
            }
            start = count;
        }
    }
    corner.store(first_corner, Relaxed);
    for (slot, (vertex, _)) in vertices.iter().zip(&kept) {
        slot.store(*vertex, Relaxed);
    }
    for (slot, [(_, one), (_, other)]) in ranks.iter().zip(kept.as_chunks::<2>().0) {
        let ([a, b], [c, d]) = (one.to_le_bytes(), other.to_le_bytes());
        slot.store(u32::from_le_bytes([a, b, c, d]), Relaxed);
    }
    let [low, high] = least.to_le_bytes();
    // A row is shorter than a byte can tell.
    state.store(u32::from_le_bytes([low, high, count as u8, 1]), Release);
}
