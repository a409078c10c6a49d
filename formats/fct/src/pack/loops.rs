//! Loops in bytes: of pages by local indices, above them by differences.

use super::page::{Below, Names, Place};
use super::plan::PlannedPage;
use super::{ClusterData, Clusters, PackError};
use crate::loops::{MORE_LOOPS, NO_LOOPS, follow_faces};
use crate::records::{FaceRecord, LOOP_END, SMALL_FACES};

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
    faces: &[FaceRecord],
    names: &Names<'_>,
    entries: &mut Vec<u32>,
    out: &mut Vec<u8>,
) -> Result<Vec<Stored>, PackError> {
    let mut stored = vec![Stored::Yes; nodes.len()];
    let mut coded: Vec<Vec<u8>> = Vec::new();
    coded.resize(nodes.len(), Vec::new());
    for (index, place) in nodes.iter().enumerate().rev() {
        let node = page.node + index as u32;
        let drawn = data[index].bound != f32::INFINITY;
        entries.clear();
        if drawn {
            clusters.boundary(node, entries);
        }
        let own = &faces[place.first..place.first + place.faces];
        let below_stores = place
            .children(index)
            .iter()
            .any(|child| matches!(child, Below::Node(child) if stored[*child] == Stored::Yes));
        if place.faces <= SMALL_FACES as usize && !below_stores && (!drawn || tells(own, entries, names)) {
            stored[index] = Stored::No;
            continue;
        }
        coded[index] = encode(entries, names)
            .ok_or_else(|| PackError::NoTree(format!("the boundary of node {node} is not of its faces")))?;
    }
    // What a subtree takes, its root's skip of two bytes and its own loops counted.
    let mut taken = vec![0_usize; nodes.len()];
    for (index, place) in nodes.iter().enumerate().rev() {
        if stored[index] == Stored::Yes {
            let below: usize = place.children(index).iter().map(|child| bytes_of(child, &taken)).sum();
            taken[index] = 2 + coded[index].len() + below;
        }
    }
    for (index, place) in nodes.iter().enumerate() {
        if stored[index] == Stored::Yes {
            let skip = u16::try_from(bytes_of(&place.children(index)[0], &taken))
                .map_err(|_too_long| PackError::TooLong("the loops of a page"))?;
            out.extend(skip.to_le_bytes());
            out.extend_from_slice(&coded[index]);
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

/// Whether a reader finds these loops from the faces: the same cycles, and no vertex met twice.
fn tells(faces: &[FaceRecord], entries: &[u32], names: &Names<'_>) -> bool {
    // Each edge of the loops that follow, whether it was met in those that are given.
    let mut followed = [(0_u8, 0_u8, false); 3 * SMALL_FACES as usize];
    let (mut count, mut first) = (0, 0);
    follow_faces(zerocopy::transmute_ref!(faces), |local, last| {
        followed[count].0 = local;
        if count > first {
            followed[count - 1].1 = local;
        }
        count += 1;
        if last {
            followed[count - 1].1 = followed[first].0;
            first = count;
        }
    });
    let followed = &mut followed[..count];
    let mut met = 0;
    for ring in entries.split_inclusive(|v| v & LOOP_END != 0) {
        let next = ring.iter().skip(1).chain(ring.first());
        for (from, to) in ring.iter().zip(next) {
            let (Some(from), Some(to)) = (names.local(from & !LOOP_END), names.local(to & !LOOP_END)) else {
                return false;
            };
            // The first edge from a vertex: a second one from there is never found, so such loops do not agree.
            match followed.iter_mut().find(|e| e.0 == from) {
                Some(edge) if edge.1 == to && !edge.2 => edge.2 = true,
                _ => return false,
            }
            met += 1;
        }
    }
    met == count
}

/// A node's loops in the bytes of a page.
fn encode(entries: &[u32], names: &Names<'_>) -> Option<Vec<u8>> {
    if entries.is_empty() {
        return Some(vec![NO_LOOPS]);
    }
    let mut bytes = Vec::with_capacity(entries.len() + 2);
    let loops: Vec<&[u32]> = entries.split_inclusive(|v| v & LOOP_END != 0).collect();
    for (i, ring) in loops.iter().enumerate() {
        if i + 1 < loops.len() {
            bytes.push(MORE_LOOPS);
        }
        bytes.push(u8::try_from(ring.len()).ok().filter(|n| *n > NO_LOOPS)?);
        for vertex in *ring {
            bytes.push(names.local(vertex & !LOOP_END)?);
        }
    }
    Some(bytes)
}

/// Appends the loops of a node above the pages: lengths and differences in groups of seven bits.
pub(super) fn encode_top(entries: &[u32], out: &mut Vec<u8>) {
    let mut before = 0_u32;
    for ring in entries.split_inclusive(|v| v & LOOP_END != 0) {
        write_varint(ring.len() as u32, out);
        for vertex in ring {
            let vertex = vertex & !LOOP_END;
            let step = if vertex >= before { (vertex - before) << 1 } else { (before - vertex) << 1 | 1 };
            write_varint(step, out);
            before = vertex;
        }
    }
}

fn write_varint(mut value: u32, out: &mut Vec<u8>) {
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
