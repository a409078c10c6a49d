//! The dual graph: which faces meet across which edges.

use super::shares::shares;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// No half-edge: the edge is a boundary or a seam.
pub const NONE: u32 = u32::MAX;

/// What kind of edge a half-edge belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeKind {
    /// Exactly two faces use the edge, in opposite directions: they are adjacent.
    Interior,
    /// One face uses the edge.
    Boundary,
    /// Three or more faces, two with inconsistent winding, or two of different groups: adjacency is cut here.
    Seam,
}

/// Adjacency of faces by half-edges: half-edge `3 f + e` runs from corner `e` of face `f` to the next corner.
#[derive(Debug, Default)]
pub struct DualGraph {
    /// The half-edge on the other side of each half-edge, or [`NONE`].
    pub opposite: Vec<u32>,
    /// Half-edges on seams, ascending.
    pub seams: Vec<u32>,
    /// Edges with one face.
    pub boundary_edges: u64,
    /// Edges at which adjacency is cut.
    pub seam_edges: u64,
}

impl DualGraph {
    /// Finds the adjacency of `faces` over `vertex_count` vertices.
    ///
    /// Faces of different groups (`face_group` is empty when there is one) are never adjacent: where they share an
    /// edge, it is a seam.
    pub fn of(faces: &[[u32; 3]], vertex_count: usize, face_group: &[u32]) -> DualGraph {
        let opposite: Vec<AtomicU32> =
            (0..faces.len() * 3).into_par_iter().map(|_| AtomicU32::new(NONE)).collect();
        let finder = Finder { faces, face_group, opposite: &opposite };
        let found: Vec<Found> = shares(vertex_count).map(|own| finder.edges_of(own)).collect();
        let mut graph = DualGraph::default();
        for mut part in found {
            graph.seams.append(&mut part.seams);
            graph.boundary_edges += part.boundary_edges;
            graph.seam_edges += part.seam_edges;
        }
        graph.seams.sort_unstable();
        graph.opposite = opposite.into_iter().map(AtomicU32::into_inner).collect();
        graph
    }
}

/// What stands beside the opposites of some edges.
#[derive(Default)]
struct Found {
    seams: Vec<u32>,
    boundary_edges: u64,
    seam_edges: u64,
}

struct Finder<'a> {
    faces: &'a [[u32; 3]],
    face_group: &'a [u32],
    /// Every half-edge is written once, by the thread that has its lower vertex.
    opposite: &'a [AtomicU32],
}

impl Finder<'_> {
    /// The edges whose lower vertex is one of `own`.
    fn edges_of(&self, own: Range<usize>) -> Found {
        let Finder { faces, .. } = self;
        // Half-edges in buckets of their lower vertex, as (upper vertex, half-edge) in one word.
        let mut start = vec![0_u32; own.len() + 1];
        let bucket = |from: u32, to: u32| {
            Some(from.min(to) as usize).filter(|v| own.contains(v)).map(|v| v - own.start)
        };
        for_each_half_edge(faces, |_, from, to| {
            if let Some(v) = bucket(from, to) {
                start[v] += 1;
            }
        });
        let mut sum = 0;
        for s in &mut start {
            sum += std::mem::replace(s, sum);
        }
        let mut bucketed = vec![0_u64; sum as usize];
        for_each_half_edge(faces, |half_edge, from, to| {
            if let Some(v) = bucket(from, to) {
                let slot = &mut start[v];
                bucketed[*slot as usize] = u64::from(from.max(to)) << 32 | u64::from(half_edge);
                *slot += 1;
            }
        });
        let mut found = Found::default();
        let mut low = 0;
        for &high in &start[..own.len()] {
            let bucket = &mut bucketed[low as usize..high as usize];
            bucket.sort_unstable();
            for edge in bucket.chunk_by(|a, b| a >> 32 == b >> 32) {
                self.add_edge(edge, &mut found);
            }
            low = high;
        }
        found
    }

    fn add_edge(&self, users: &[u64], found: &mut Found) {
        let half_edge = |user: u64| user as u32;
        let group = |user: u64| self.face_group.get(half_edge(user) as usize / 3);
        match *users {
            [_] => found.boundary_edges += 1,
            [a, b]
                if origin(self.faces, half_edge(a)) != origin(self.faces, half_edge(b))
                    && group(a) == group(b) =>
            {
                self.opposite[half_edge(a) as usize].store(half_edge(b), Relaxed);
                self.opposite[half_edge(b) as usize].store(half_edge(a), Relaxed);
            }
            _ => {
                found.seam_edges += 1;
                found.seams.extend(users.iter().map(|&u| half_edge(u)));
            }
        }
    }
}

/// The vertex that a half-edge starts at.
pub(crate) fn origin(faces: &[[u32; 3]], half_edge: u32) -> u32 {
    faces[half_edge as usize / 3][half_edge as usize % 3]
}

/// The half-edge that follows inside the same face.
pub(crate) fn next_in_face(half_edge: u32) -> u32 {
    if half_edge % 3 == 2 { half_edge - 2 } else { half_edge + 1 }
}

/// The half-edge that precedes inside the same face.
pub(crate) fn prev_in_face(half_edge: u32) -> u32 {
    if half_edge.is_multiple_of(3) { half_edge + 2 } else { half_edge - 1 }
}

fn for_each_half_edge(faces: &[[u32; 3]], mut act: impl FnMut(u32, u32, u32)) {
    for (f, face) in faces.iter().enumerate() {
        for e in 0..3 {
            act((3 * f + e) as u32, face[e], face[(e + 1) % 3]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn naive(faces: &[[u32; 3]]) -> Vec<u32> {
        let mut all = Vec::new();
        for_each_half_edge(faces, |h, a, b| all.push((h, a, b)));
        let users = |a, b| all.iter().filter(move |x| (x.1, x.2) == (a, b) || (x.1, x.2) == (b, a)).count();
        all.iter()
            .map(|&(_, a, b)| {
                let other = all.iter().find(|x| (x.1, x.2) == (b, a));
                other.filter(|_| users(a, b) == 2).map_or(NONE, |x| x.0)
            })
            .collect()
    }

    #[test]
    fn equals_the_definition() {
        let tetra = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let three_sheets = [[0, 1, 2], [0, 1, 3], [1, 0, 4], [4, 0, 5]];
        let flipped = [[0, 1, 2], [0, 1, 3], [2, 1, 4]];
        for faces in [&tetra[..], &three_sheets, &flipped] {
            assert_eq!(DualGraph::of(faces, 6, &[]).opposite, naive(faces));
        }
        let graph = DualGraph::of(&three_sheets, 6, &[]);
        assert_eq!((graph.seams.as_slice(), graph.boundary_edges), (&[0, 3, 6][..], 7));
    }
}
