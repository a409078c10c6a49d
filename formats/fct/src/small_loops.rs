//! Boundary loops of small nodes, which are not stored: they follow from the nodes' faces.

use crate::records::SMALL_FACES;

/// The most edges on the boundary of a small node.
const MOST_EDGES: usize = 3 * SMALL_FACES as usize;

/// The loops of a node of at most [`SMALL_FACES`] faces, as local indices: the cycles of the edges that no other face
/// walks the other way.
///
/// Exact where at most one of these edges starts at each vertex; the packer stores the loops of all other nodes.
/// Shows each entry, with whether it is the last of its loop.
#[inline]
pub(crate) fn follow_faces(faces: &[[u8; 3]], mut show: impl FnMut(u8, bool)) {
    let mut ring = Ring::default();
    for face in faces {
        // A face that does not touch the ones before along one stretch is for the slow way.
        if !ring.add(*face) {
            return follow_edges(faces, show);
        }
    }
    let edges = ring.edges.get(..ring.count).unwrap_or_default();
    for (i, (from, _)) in edges.iter().enumerate() {
        show(*from, i.saturating_add(1) == edges.len());
    }
}

/// A single loop of directed edges, each starting where the one before ends.
#[derive(Default)]
struct Ring {
    edges: [(u8, u8); MOST_EDGES],
    count: usize,
}

impl Ring {
    /// Grows around a face that shares one stretch of edges with the loop; says whether it does.
    #[inline]
    fn add(&mut self, [a, b, c]: [u8; 3]) -> bool {
        if self.count == 0 {
            if let Some(start) = self.edges.first_chunk_mut() {
                *start = [(a, b), (b, c), (c, a)];
            }
            self.count = 3;
            return true;
        }
        let mut shared = 0_usize;
        let mut at = 0_usize;
        let mut beyond = 0_u8;
        for (i, edge) in self.edges.iter().take(self.count).enumerate() {
            let corner = if *edge == (b, a) {
                c
            } else if *edge == (c, b) {
                a
            } else if *edge == (a, c) {
                b
            } else {
                continue;
            };
            shared = shared.saturating_add(1);
            at = i;
            beyond = corner;
        }
        // Two edges and more close around a vertex, or join the loop with itself.
        if shared != 1 || self.count >= MOST_EDGES {
            return false;
        }
        let after = at.saturating_add(1);
        self.edges.copy_within(after..self.count, after.saturating_add(1));
        if let Some([edge, added]) = self.edges.get_mut(at..).and_then(<[_]>::first_chunk_mut) {
            *added = (beyond, edge.1);
            edge.1 = beyond;
        }
        self.count = self.count.saturating_add(1);
        true
    }
}

/// The same for any few faces.
fn follow_edges(faces: &[[u8; 3]], mut show: impl FnMut(u8, bool)) {
    let mut edges = [(0_u8, 0_u8); MOST_EDGES];
    let mut count = 0_usize;
    for &[a, b, c] in faces {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let known = edges.get_mut(..count).unwrap_or_default();
            match known.iter().position(|e| *e == (to, from)) {
                // The order of the others does not matter.
                Some(twin) => {
                    let last = count.saturating_sub(1);
                    known.swap(twin, last);
                    count = last;
                }
                None => {
                    if let Some(slot) = edges.get_mut(count) {
                        *slot = (from, to);
                        count = count.saturating_add(1);
                    }
                }
            }
        }
    }
    // Each round takes an edge away, so this ends on any bytes.
    while let Some((&(first, mut to), _)) = edges.get(..count).and_then(<[_]>::split_last) {
        count = count.saturating_sub(1);
        let mut from = first;
        loop {
            let rest = edges.get_mut(..count).unwrap_or_default();
            let following = if to == first { None } else { rest.iter().position(|e| e.0 == to) };
            show(from, following.is_none());
            let Some(next) = following else { break };
            count = count.saturating_sub(1);
            rest.swap(next, count);
            (from, to) = edges.get(count).copied().unwrap_or_default();
        }
    }
}

/// The same, each loop as a whole; none where loops do not end, or meet a vertex twice.
///
/// Faster than [`follow_faces`]: an edge is compared with many others at once.
#[inline]
pub(crate) fn follow_small(faces: &[[u8; 3]], mut show: impl FnMut(&[u8])) -> Option<()> {
    if let [one, other] = faces
        && let Some(ring) = quad(*one, *other)
    {
        show(&ring);
        return Some(());
    }
    match faces.len() {
        0..=5 => follow_rest::<5, 16>(faces, show),
        _ => follow_rest::<8, MOST_EDGES>(faces, show),
    }
}

/// The loop of two faces that share an edge.
#[inline]
fn quad(one: [u8; 3], [d, e, f]: [u8; 3]) -> Option<[u8; 4]> {
    let [a, b, c] = one;
    for [a, b, c] in [[a, b, c], [b, c, a], [c, a, b]] {
        for [from, to, beyond] in [[d, e, f], [e, f, d], [f, d, e]] {
            if (from, to) == (b, a) && beyond != c {
                return Some([a, beyond, b, c]);
            }
        }
    }
    None
}

/// The same, for up to so many faces, and no fewer than so many edges.
fn follow_rest<const FACES: usize, const EDGES: usize>(
    faces: &[[u8; 3]],
    mut show: impl FnMut(&[u8]),
) -> Option<()> {
    // Pairs of vertices in 16 bits. No edge leads from a vertex to itself, so those of missing faces are 0, and twins.
    let mut all = [[0_u8; 3]; FACES];
    all.get_mut(..faces.len())?.copy_from_slice(faces);
    let mut edges = [0_u16; EDGES];
    for (slot, [a, b, c]) in edges.as_chunks_mut::<3>().0.iter_mut().zip(all) {
        *slot = [[a, b], [b, c], [c, a]].map(u16::from_le_bytes);
    }
    let mut has_twin = [0_u16; EDGES];
    for edge in edges {
        let twin = edge.swap_bytes();
        for (has_twin, edge) in has_twin.iter_mut().zip(&edges) {
            *has_twin |= if *edge == twin { u16::MAX } else { 0 };
        }
    }
    let mut onward = STAY;
    let mut starts = [0_u8; EDGES];
    let mut left = 0_usize;
    for (edge, has_twin) in edges.iter().zip(&has_twin) {
        let [from, to] = edge.to_le_bytes();
        *starts.get_mut(left)? = from;
        if *has_twin == 0 {
            *onward.get_mut(usize::from(from))? = to;
            left = left.saturating_add(1);
        }
    }
    let mut ring = [0_u8; EDGES];
    for start in starts.get(..left)? {
        let mut length = 0_usize;
        let mut at = *start;
        // Every step takes an edge away, so this ends on any bytes.
        while let Some(next) = onward.get_mut(usize::from(at)).filter(|next| **next != at) {
            *ring.get_mut(length)? = at;
            length = length.saturating_add(1);
            at = std::mem::replace(next, at);
        }
        if at != *start {
            return None;
        }
        if length > 0 {
            left = left.checked_sub(length)?;
            show(ring.get(..length)?);
        }
        if left == 0 {
            return Some(());
        }
    }
    (left == 0).then_some(())
}

/// Leads from every vertex to itself.
const STAY: [u8; 256] = {
    let mut stay = [0; 256];
    let mut vertex = 0_u8;
    while let Some(slot) = stay.split_at_mut(vertex as usize).1.first_mut() {
        *slot = vertex;
        vertex = match vertex.checked_add(1) {
            Some(next) => next,
            None => break,
        };
    }
    stay
};

#[cfg(test)]
mod tests {
    use super::{follow_faces, follow_small};

    /// Each loop from its lowest vertex on, in order.
    fn loops_of(faces: &[[u8; 3]]) -> Vec<Vec<u8>> {
        let mut loops = vec![Vec::new()];
        follow_faces(faces, |vertex, last| {
            loops.last_mut().unwrap().push(vertex);
            if last {
                loops.push(Vec::new());
            }
        });
        assert_eq!(loops.pop(), Some(Vec::new()), "the last loop ends");
        for ring in &mut loops {
            let lowest = (0..ring.len()).min_by_key(|i| ring[*i]).unwrap();
            ring.rotate_left(lowest);
        }
        loops.sort();
        loops
    }

    #[test]
    fn small_clusters_have_the_loops_of_their_faces() {
        assert_eq!(loops_of(&[[4, 5, 6]]), [[4, 5, 6]]);
        for turn in 0..3 {
            let mut other = [0, 2, 3];
            other.rotate_left(turn);
            assert_eq!(loops_of(&[[0, 1, 2], other]), [[0, 1, 2, 3]]);
            assert_eq!(loops_of(&[other, [0, 1, 2], [3, 2, 4]]), [[0, 1, 2, 4, 3]]);
        }
        // A fan that closes around vertex 0.
        assert_eq!(loops_of(&[[0, 1, 2], [0, 2, 3], [0, 3, 1]]), [[1, 2, 3]]);
        // A tetrahedron has none, two faces apart have two, until a third joins them.
        assert!(loops_of(&[[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]).is_empty());
        assert_eq!(loops_of(&[[0, 1, 2], [3, 4, 5]]), [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(loops_of(&[[0, 1, 2], [3, 4, 5], [3, 5, 6]]), [vec![0, 1, 2], vec![3, 4, 5, 6]]);
        assert_eq!(loops_of(&[[0, 1, 2], [3, 4, 1], [1, 4, 2]]), [[0, 1, 3, 4, 2]]);
        // A ring of six faces has an inner and an outer rim.
        let ring = [[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [2, 0, 3], [2, 3, 5]];
        assert_eq!(loops_of(&ring), [[0, 1, 2], [3, 5, 4]]);
    }

    #[test]
    fn any_faces_have_loops_that_end() {
        let mut state = 1_u32;
        for _ in 0..10_000 {
            let mut random = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 28) as u8 % 6
            };
            let faces: Vec<_> = (0..8).map(|_| [random(), random(), random()]).collect();
            let mut open = false;
            follow_faces(&faces, |_, last| open = !last);
            assert!(!open);
        }
    }

    /// The quick way finds what the slow one finds, or nothing where a vertex is met twice.
    #[test]
    fn both_ways_to_follow_agree() {
        let mut state = 1_u32;
        let mut random = |n: u8| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8 % n
        };
        let (mut found, mut refused) = (0, 0);
        for _ in 0..30_000 {
            // Faces of a strip or a fan, some left out, or any.
            let wild = random(8) == 0;
            let faces: Vec<[u8; 3]> = (0..1 + random(8))
                .map(|i| match (wild, i % 2 == 0) {
                    (true, _) => [random(9), random(9), random(9)],
                    (false, true) => [i, i + 1, i + 2],
                    (false, false) => [i + 1, i, i + 2],
                })
                .filter(|[a, b, c]| a != b && b != c && c != a)
                .collect();
            let mut edges: Vec<_> = faces.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
            edges.sort_unstable();
            if edges.windows(2).any(|pair| pair[0] == pair[1]) {
                continue; // No orderly mesh has an edge twice.
            }
            let mut quick = Vec::new();
            match follow_small(&faces, |ring| quick.push(ring.to_vec())) {
                Some(()) => {
                    for ring in &mut quick {
                        let lowest = (0..ring.len()).min_by_key(|i| ring[*i]).unwrap();
                        ring.rotate_left(lowest);
                    }
                    quick.sort();
                    assert_eq!(quick, loops_of(&faces), "{faces:?}");
                    found += 1;
                }
                None => {
                    let mut met = loops_of(&faces).concat();
                    met.sort_unstable();
                    assert!(met.windows(2).any(|pair| pair[0] == pair[1]), "{faces:?}");
                    refused += 1;
                }
            }
        }
        assert!(found > 20_000 && refused > 100, "{found} {refused}");
    }
}
