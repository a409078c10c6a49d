//! Boundary loops, and how they are stored.
//!
//! In a page a loop is a byte with its length and a byte an entry. A byte of 0 before a loop says that another one
//! follows it; a byte of 1 in the place of a length says that there are none.

/// The boundary loops of one node; reuse it to keep its memory.
///
/// The cluster lies on the left of each loop.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Loops {
    /// The vertex indices of all loops, one loop after the other.
    pub vertices: Vec<u32>,
    /// Where each loop ends in `vertices`.
    pub ends: Vec<usize>,
}

impl Loops {
    /// Forgets all loops.
    pub fn clear(&mut self) {
        self.vertices.clear();
        self.ends.clear();
    }

    /// The loops as runs of vertex indices. An edge leads from the last of each to its first.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> + Clone {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, end)| self.vertices.get(start..*end).unwrap_or_default())
    }

    /// Leaves out the entries that are not to be kept; a loop of which none is left counts for nothing.
    pub fn retain(&mut self, mut keep: impl FnMut(u32) -> bool) {
        let (mut start, mut kept) = (0, 0_usize);
        for end in &mut self.ends {
            for at in start..*end {
                let vertex = self.vertices.get(at).copied().unwrap_or_default();
                if keep(vertex)
                    && let Some(slot) = self.vertices.get_mut(kept)
                {
                    *slot = vertex;
                    kept = kept.saturating_add(1);
                }
            }
            (start, *end) = (*end, kept);
        }
        self.vertices.truncate(kept);
        self.ends.dedup();
        self.ends.retain(|end| *end > 0);
    }

    /// Ends a loop that was pushed entry by entry; an empty one counts for nothing.
    pub(crate) fn close(&mut self) {
        let end = self.vertices.len();
        if self.ends.last().copied().unwrap_or(0) < end {
            self.ends.push(end);
        }
    }
}

/// Stands in the place of a loop's length: there is no loop.
pub(crate) const NO_LOOPS: u8 = 1;

/// Stands before a loop that is not the last.
pub(crate) const MORE_LOOPS: u8 = 0;

/// Goes through the loops that a page stores at the start of `bytes`, shows each, and says where they end; none if they
/// do not end.
#[inline]
pub(crate) fn read_stored<'a>(bytes: &'a [u8], mut show: impl FnMut(&'a [u8])) -> Option<usize> {
    let mut at = 0_usize;
    loop {
        let mut length = *bytes.get(at)?;
        at = at.saturating_add(1);
        if length == NO_LOOPS {
            return Some(at);
        }
        let more = length == MORE_LOOPS;
        if more {
            length = *bytes.get(at)?;
            at = at.saturating_add(1);
            if length <= NO_LOOPS {
                return None;
            }
        }
        let end = at.saturating_add(usize::from(length));
        show(bytes.get(at..end)?);
        at = end;
        if !more {
            return Some(at);
        }
    }
}

/// Reads a number in groups of seven bits, the lowest first, the top bit set in all bytes but the last.
pub(crate) fn read_varint(bytes: &mut &[u8]) -> Option<u32> {
    let mut value = 0_u32;
    for shift in [0, 7, 14, 21, 28] {
        let (&byte, rest) = bytes.split_first()?;
        *bytes = rest;
        let group = u32::from(byte & 0x7F);
        value |= group.checked_shl(shift).filter(|v| v >> shift == group)?;
        if byte & 0x80 == 0 {
            return Some(value);
        }
    }
    None
}

/// Goes through the loops of a top node, whose bytes these are; none if they are broken. Vertices are not checked.
///
/// A loop is its length, then each entry's difference from the one before, from 0 for the very first, its sign in bit 0.
pub(crate) fn read_top(mut bytes: &[u8], out: &mut Loops) -> Option<()> {
    let mut vertex = 0_u32;
    while !bytes.is_empty() {
        let length = read_varint(&mut bytes)?;
        // An entry takes a byte at least, so no length allocates more than the file holds.
        if length < 2 || usize::try_from(length).ok()? > bytes.len() {
            return None;
        }
        for _ in 0..length {
            let step = read_varint(&mut bytes)?;
            let magnitude = step >> 1;
            vertex =
                if step & 1 == 0 { vertex.checked_add(magnitude)? } else { vertex.checked_sub(magnitude)? };
            out.vertices.push(vertex);
        }
        out.close();
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::{Loops, read_stored, read_top, read_varint};

    #[test]
    fn entries_can_be_left_out() {
        let mut loops = Loops { vertices: vec![1, 2, 3, 4, 5, 6, 7, 8], ends: vec![2, 5, 8] };
        loops.retain(|v| v > 2 && v != 7);
        assert!(loops.iter().eq([[3, 4, 5].as_slice(), &[6, 8]]));
        loops.retain(|v| v == 8);
        assert!(loops.iter().eq([[8].as_slice()]));
        loops.retain(|_| false);
        assert_eq!(loops, Loops::default());
    }

    #[test]
    fn stored_loops_are_shown_one_by_one() {
        let read = |bytes: &[u8]| {
            let mut loops = Vec::new();
            read_stored(bytes, |l| loops.push(l.to_vec())).map(|end| (end, loops))
        };
        assert_eq!(read(&[1, 9]), Some((1, vec![])));
        assert_eq!(read(&[3, 7, 8, 9, 2]), Some((4, vec![vec![7, 8, 9]])));
        assert_eq!(read(&[0, 2, 5, 6, 3, 7, 8, 9]), Some((8, vec![vec![5, 6], vec![7, 8, 9]])));
        for broken in [&[][..], &[3, 1, 2], &[0], &[0, 0], &[0, 1], &[0, 2, 5, 6], &[0, 2, 5]] {
            assert_eq!(read(broken), None, "{broken:?}");
        }
    }

    #[test]
    fn numbers_of_any_size_are_read_and_no_more_than_32_bits() {
        let read = |mut bytes: &[u8]| read_varint(&mut bytes).filter(|_| bytes.is_empty());
        assert_eq!(read(&[0x7F]), Some(127));
        assert_eq!(read(&[0x80, 1]), Some(128));
        assert_eq!(read(&[0xFF, 0xFF, 0xFF, 0xFF, 0x0F]), Some(u32::MAX));
        for broken in [&[][..], &[0x80], &[0xFF, 0xFF, 0xFF, 0xFF, 0x1F], &[0x80; 6]] {
            assert_eq!(read(broken), None, "{broken:?}");
        }
    }

    #[test]
    fn differences_lead_from_vertex_to_vertex() {
        let mut out = Loops::default();
        // A loop of 300, 298, 299.
        assert_eq!(read_top(&[3, 0xD8, 4, 5, 2], &mut out), Some(()));
        assert_eq!(out.iter().collect::<Vec<_>>(), [[300, 298, 299]]);
        for broken in [&[3, 0, 0][..], &[1, 0], &[0], &[2, 1, 3], &[0xFF, 0xFF, 3, 0]] {
            assert_eq!(read_top(broken, &mut Loops::default()), None, "{broken:?}");
        }
    }
}
