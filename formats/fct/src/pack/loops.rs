//! Loops in bytes: of pages by local indices, above them by differences.

use super::page::{Below, Names, Place};
use super::plan::PlannedPage;
use super::{ClusterData, Clusters, PackError};
use crate::loops::{MORE_LOOPS, NO_LOOPS};
use crate::records::{LOOP_END, SMALL_FACES};

/// The packer leaves the loops of nodes of at most this many faces to be found from their faces.
///
/// It may do so up to [`SMALL_FACES`]. Finding them takes longer than reading them where a node has more faces than a
/// few, and storing those of 5 to 8 faces takes 2 bytes a face of the mesh.
const FOLLOWED_FACES: usize = 4;

const _: () = assert!(FOLLOWED_FACES <= SMALL_FACES as usize);

/// Whether the loops of a node are in section `LOOP`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stored {
    Yes,
    No,
}

/// Appends the loops of a page's nodes in preorder: each with the bytes of its left child's, then its own.
///
/// A small node stores its loops only if its faces do not tell them, or if a node below has stored its own, since a
/// walk finds those through it.
#[allow(clippy::too_many_arguments, reason = "one caller, which has all of these in its hands")]
pub(super) fn page_loops(
    clusters: &impl Clusters,
    page: &PlannedPage,
    nodes: &[Place],
    data: &[ClusterData],
    names: &Names<'_>,
    entries: &mut Vec<u32>,
    out: &mut Vec<u8>,
) -> Result<Vec<Stored>, PackError> {
    let mut stored = vec![Stored::Yes; nodes.len()];
    // The loops from the last node to the first, and where each node's are.
    let mut coded = Vec::new();
    let mut place_of = vec![0..0; nodes.len()];
    for (index, place) in nodes.iter().enumerate().rev() {
        let node = page.node + index as u32;
        let drawn = data[index].bound != f32::INFINITY;
        entries.clear();
        if drawn {
            clusters.boundary(node, entries);
        }
        let below_stores = place
            .children(index)
            .iter()
            .any(|child| matches!(child, Below::Node(child) if stored[*child] == Stored::Yes));
        if place.faces <= FOLLOWED_FACES && !below_stores && (!drawn || follow(entries)) {
            stored[index] = Stored::No;
            continue;
        }
        let start = coded.len();
        encode(entries, names, &mut coded)
            .ok_or_else(|| PackError::NoTree(format!("the boundary of node {node} is not of its faces")))?;
        place_of[index] = start..coded.len();
    }
    // What a subtree takes, its root's skip of two bytes and its own loops counted.
    let mut taken = vec![0_usize; nodes.len()];
    for (index, place) in nodes.iter().enumerate().rev() {
        if stored[index] == Stored::Yes {
            let below: usize = place.children(index).iter().map(|child| bytes_of(child, &taken)).sum();
            taken[index] = 2 + place_of[index].len() + below;
        }
    }
    for (index, place) in nodes.iter().enumerate() {
        if stored[index] == Stored::Yes {
            let skip = u16::try_from(bytes_of(&place.children(index)[0], &taken))
                .map_err(|_too_long| PackError::TooLong("the loops of a page"))?;
            out.extend(skip.to_le_bytes());
            out.extend_from_slice(&coded[place_of[index].clone()]);
        }
    }
    Ok(stored)
}

fn bytes_of(child: &Below, taken: &[usize]) -> usize {
    match *child {
        Below::Node(child) => taken[child],
        Below::Face(_) => 0,
    }
}

/// Whether a reader finds these loops of a small node from its faces.
///
/// It counts edges against their opposites by vertices, the builder by faces. What is left can differ only by pairs of
/// opposite edges, and loops of three vertices and more that meet none twice have no such pair.
fn follow(entries: &[u32]) -> bool {
    let vertex = |e: &u32| e & !LOOP_END;
    let meets_once = |(i, e): (usize, &u32)| entries[..i].iter().all(|f| vertex(f) != vertex(e));
    let mut rings = entries.split_inclusive(|v| v & LOOP_END != 0);
    rings.all(|ring| ring.len() > 2) && entries.iter().enumerate().all(meets_once)
}

/// Appends a node's loops in the bytes of a page.
fn encode(entries: &[u32], names: &Names<'_>, bytes: &mut Vec<u8>) -> Option<()> {
    if entries.is_empty() {
        bytes.push(NO_LOOPS);
    }
    let mut rest = entries.len();
    for ring in entries.split_inclusive(|v| v & LOOP_END != 0) {
        rest -= ring.len();
        if rest > 0 {
            bytes.push(MORE_LOOPS);
        }
        bytes.push(u8::try_from(ring.len()).ok().filter(|n| *n > NO_LOOPS)?);
        for vertex in ring {
            bytes.push(names.local(vertex & !LOOP_END)?);
        }
    }
    Some(())
}

/// Appends the loops of a node above the pages: lengths and differences in groups of seven bits.
pub(crate) fn encode_top(entries: &[u32], out: &mut Vec<u8>) {
    let mut before = 0_u32;
    for ring in entries.split_inclusive(|v| v & LOOP_END != 0) {
        push_varint(ring.len() as u32, out);
        for vertex in ring {
            let vertex = vertex & !LOOP_END;
            let step = if vertex >= before { (vertex - before) << 1 } else { (before - vertex) << 1 | 1 };
            push_varint(step, out);
            before = vertex;
        }
    }
}

/// Appends a number in groups of seven bits, the lowest first, with the top bit set in all bytes but the last.
pub(crate) fn push_varint(mut value: u32, out: &mut Vec<u8>) {
    while value >= 0x80 {
        out.push((value & 0x7F) as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
}

#[cfg(test)]
mod tests {
    use super::encode_top;
    use crate::loops::{Loops, read_top};
    use crate::records::LOOP_END;

    #[test]
    fn loops_above_the_pages_come_back() {
        let last = LOOP_END;
        let entries = [5, 1_000_000, ((1 << 31) - 1) | last, 7, 0, 700_000_000 | last];
        let mut bytes = Vec::new();
        encode_top(&entries, &mut bytes);
        let mut loops = Loops::default();
        assert_eq!(read_top(&bytes, &mut loops), Some(()));
        let expected = [[5, 1_000_000, (1 << 31) - 1], [7, 0, 700_000_000]];
        assert!(loops.iter().eq(expected.iter().map(<[u32; 3]>::as_slice)));
    }
}
