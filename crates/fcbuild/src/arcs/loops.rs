//! The boundary loops of every cluster.
//!
//! Loops are found from the faces up: the boundary of a node is the boundaries of its children without the edges
//! that they share. Taking a shared edge out splices two circular lists, so all loops together cost the sum of their
//! lengths (about 8 entries a face) and no search.

use crate::mesh::{NONE, next_in_face, prev_in_face};
use crate::partition::Split;
use crate::tree_order::TreeMesh;
use rayon::prelude::*;
use std::ops::Range;

/// Set on the last half-edge of each loop.
pub const LAST: u32 = 1 << 31;

/// Boundary loops of all nodes, as half-edges with the cluster on their left.
#[derive(Debug, Default)]
pub struct Loops {
    /// Half-edges of all loops, in postorder of the nodes. No node is cut apart.
    pieces: Vec<Entries>,
    /// Each node's first entry: the piece, and the place in it.
    start: Vec<(u32, u32)>,
    /// The number of entries of each node of a small subtree; others have a piece of their own.
    len: Vec<u16>,
    /// For each half-edge between two faces: the cut that it lies on ends, or branches, where it starts.
    ///
    /// Every such half-edge lies on the cut of exactly one node, the lowest one that owns both faces.
    pub starts_at_end: Vec<bool>,
}

impl Loops {
    /// Finds the loops of every node of the tree `splits`.
    pub fn of(mesh: &TreeMesh, splits: &[Split]) -> Loops {
        let faces = mesh.faces.len();
        let half_edges = (0..3 * faces as u32).into_par_iter();
        let mut next: Vec<u32> = half_edges.clone().map(next_in_face).collect();
        let mut prev: Vec<u32> = half_edges.map(prev_in_face).collect();
        let mut stamp = vec![0_u32; 3 * faces];
        let mut starts_at_end = vec![false; 3 * faces];
        let mut start = vec![(0, 0); splits.len()];
        let mut len = vec![0_u16; splits.len()];
        let subtree = Subtree {
            mesh,
            splits,
            base: 0,
            faces: 0..faces,
            next: &mut next,
            prev: &mut prev,
            stamp: &mut stamp,
            ends: &mut starts_at_end,
            start: &mut start,
            len: &mut len,
            added: Vec::new(),
        };
        let pieces = subtree.collect_parallel();
        drop((next, prev, stamp));
        for (i, piece) in pieces.iter().enumerate() {
            start[piece.nodes.clone()].iter_mut().for_each(|start| start.0 = i as u32);
        }
        let pieces = pieces.into_iter().map(|piece| piece.entries).collect();
        Loops { pieces, start, len, starts_at_end }
    }

    /// The loop entries of a node, written to `memory`; [`LAST`] marks each loop's last one.
    pub fn read<'m>(&self, node: usize, memory: &'m mut Vec<u32>) -> &'m [u32] {
        memory.clear();
        self.append(node, memory);
        memory
    }

    /// The same after what is in a list.
    pub fn append(&self, node: usize, out: &mut Vec<u32>) {
        let (piece, start) = self.start[node];
        let start = start as usize;
        self.pieces[piece as usize].append(start..start + usize::from(self.len[node]), out);
    }
}

/// Half-edges in a row; the last one of each loop has a mark.
#[derive(Debug)]
enum Entries {
    /// Half-edges anywhere, with [`LAST`], of one node.
    Far(Vec<u32>),
    /// Those of a small subtree, counted from its first one, with [`NEAR_LAST`]: half the memory, where most of it is.
    Near { first: u32, entries: Vec<u16> },
}

/// [`LAST`] in the entries of a small subtree.
const NEAR_LAST: u16 = 1 << 15;

// Its half-edges leave the mark free, and their number is told in 16 bits.
const _: () = assert!(3 * SERIAL_BELOW <= NEAR_LAST as usize);

impl Entries {
    fn near(first: u32, entries: &[u32]) -> Entries {
        let mark = |h: u32| if h & LAST != 0 { NEAR_LAST } else { 0 };
        let entries = entries.iter().map(|&h| ((h & !LAST) - first) as u16 | mark(h)).collect();
        Entries::Near { first, entries }
    }

    /// Appends those of a node; the range is where they are in a small subtree.
    fn append(&self, range: Range<usize>, out: &mut Vec<u32>) {
        match self {
            Entries::Far(entries) => out.extend_from_slice(entries),
            Entries::Near { first, entries } => {
                let mark = |e: u16| u32::from(e & NEAR_LAST) << 16;
                // No half-edge is beyond 2^31: without a look at that, some are read at a time.
                let half_edge = |e: u16| first.wrapping_add(u32::from(e & !NEAR_LAST));
                out.extend(entries[range].iter().map(|&e| half_edge(e) | mark(e)));
            }
        }
    }
}

/// The loops in one run of entries, each without its mark.
pub fn split_loops(entries: &[u32]) -> impl Iterator<Item = &[u32]> {
    entries.split_inclusive(|h| h & LAST != 0)
}

/// The loops of a subtree, or of one node.
struct Piece {
    nodes: Range<usize>,
    /// In postorder of the nodes.
    entries: Entries,
}

/// A subtree and its share of the working arrays; half-edge `h` is at `h - 3 * faces.start`.
struct Subtree<'a> {
    mesh: &'a TreeMesh,
    splits: &'a [Split],
    /// Index of the subtree's root among all nodes.
    base: usize,
    faces: Range<usize>,
    next: &'a mut [u32],
    prev: &'a mut [u32],
    /// The last node whose loops a half-edge was written to, plus one.
    stamp: &'a mut [u32],
    ends: &'a mut [bool],
    /// Each node's first entry: the piece, which is not known yet, and the place in it.
    start: &'a mut [(u32, u32)],
    len: &'a mut [u16],
    /// The loops of the node in hand, while those of its children are read.
    added: Vec<u32>,
}

/// Subtrees of fewer faces write one list on one thread.
const SERIAL_BELOW: usize = 8192;

impl Subtree<'_> {
    /// Postorder pieces; the root's own loops are the end of the last piece.
    fn collect_parallel(mut self) -> Vec<Piece> {
        if self.faces.len() < SERIAL_BELOW {
            let mut out = Vec::with_capacity(self.faces.len() * 6);
            if self.faces.len() > 1 {
                self.collect(0, self.faces.clone(), &mut out);
            }
            let entries = Entries::near(3 * self.faces.start as u32, &out);
            return vec![Piece { nodes: self.base..self.base + self.splits.len(), entries }];
        }
        let left = self.splits[0].left_faces as usize;
        let middle = self.faces.start + left;
        let (mut pieces, right_pieces) = {
            let (next_l, next_r) = self.next.split_at_mut(3 * left);
            let (prev_l, prev_r) = self.prev.split_at_mut(3 * left);
            let (stamp_l, stamp_r) = self.stamp.split_at_mut(3 * left);
            let (ends_l, ends_r) = self.ends.split_at_mut(3 * left);
            let (start_l, start_r) = self.start[1..].split_at_mut(left - 1);
            let (len_l, len_r) = self.len[1..].split_at_mut(left - 1);
            let l = Subtree {
                mesh: self.mesh,
                splits: &self.splits[1..left],
                base: self.base + 1,
                faces: self.faces.start..middle,
                next: next_l,
                prev: prev_l,
                stamp: stamp_l,
                ends: ends_l,
                start: start_l,
                len: len_l,
                added: Vec::new(),
            };
            let r = Subtree {
                mesh: self.mesh,
                splits: &self.splits[left..],
                base: self.base + left,
                faces: middle..self.faces.end,
                next: next_r,
                prev: prev_r,
                stamp: stamp_r,
                ends: ends_r,
                start: start_r,
                len: len_r,
                added: Vec::new(),
            };
            rayon::join(|| l.collect_parallel(), || r.collect_parallel())
        };
        let mut own = Vec::new();
        {
            let len_l = if left > 1 { self.len[1] } else { 0 };
            let len_r = if self.faces.len() - left > 1 { self.len[left] } else { 0 };
            let loops_l = tail(&pieces, len_l, self.faces.start, left);
            let loops_r = tail(&right_pieces, len_r, middle, self.faces.len() - left);
            self.join(0, self.faces.clone(), middle, &loops_l, &loops_r, &mut own);
        }
        pieces.extend(right_pieces);
        pieces.push(Piece { nodes: self.base..self.base + 1, entries: Entries::Far(own) });
        pieces
    }

    /// The same on one thread: `node` counts from the subtree's root. Appends the subtree's loops in postorder.
    fn collect(&mut self, node: usize, faces: Range<usize>, out: &mut Vec<u32>) {
        let left = self.splits[node].left_faces as usize;
        let middle = faces.start + left;
        if left > 1 {
            self.collect(node + 1, faces.start..middle, out);
        }
        let end_l = out.len();
        let len_l = if left > 1 { usize::from(self.len[node + 1]) } else { 0 };
        if faces.end - middle > 1 {
            self.collect(node + left, middle..faces.end, out);
        }
        let end_r = out.len();
        let len_r = if faces.end - middle > 1 { usize::from(self.len[node + left]) } else { 0 };
        let mut added = std::mem::take(&mut self.added);
        added.clear();
        {
            let single_l;
            let loops_l = if left > 1 {
                &out[end_l - len_l..end_l]
            } else {
                single_l = loop_of_face(faces.start);
                &single_l[..]
            };
            let single_r;
            let loops_r = if faces.end - middle > 1 {
                &out[end_r - len_r..end_r]
            } else {
                single_r = loop_of_face(middle);
                &single_r[..]
            };
            self.join(node, faces, middle, loops_l, loops_r, &mut added);
        }
        self.start[node].1 = out.len() as u32;
        self.len[node] = added.len() as u16;
        out.extend_from_slice(&added);
        self.added = added;
    }

    /// Takes the shared edges out of the children's loops and writes the node's own.
    fn join(
        &mut self,
        node: usize,
        faces: Range<usize>,
        middle: usize,
        loops_l: &[u32],
        loops_r: &[u32],
        out: &mut Vec<u32>,
    ) {
        let offset = 3 * self.faces.start;
        let at = |h: u32| h as usize - offset;
        let right = 3 * middle as u32..3 * faces.end as u32;
        let left = 3 * faces.start as u32..3 * middle as u32;
        let opposite = &self.mesh.opposite;
        let cuts_right = |h: u32| right.contains(&opposite[h as usize]);
        let cuts_left = |h: u32| left.contains(&opposite[h as usize]);

        // Where the cut's arcs end, while the children's loops are still whole: an arc passes through a vertex only
        // if it is one and the same path, with nothing else of either boundary between, on both sides.
        for &h in loops_l {
            let h = h & !LAST;
            if cuts_right(h) {
                let across = opposite[h as usize];
                let (before_h, before_across) = (self.prev[at(h)], self.prev[at(across)]);
                let after_across = self.next[at(across)];
                self.ends[at(h)] = !(cuts_right(before_h) && opposite[before_h as usize] == after_across);
                let after_h = self.next[at(h)];
                self.ends[at(across)] =
                    !(cuts_left(before_across) && opposite[before_across as usize] == after_h);
            }
        }
        let stamp = (self.base + node + 1) as u32;
        for &h in loops_l {
            let h = h & !LAST;
            if cuts_right(h) {
                let across = opposite[h as usize];
                let (prev_h, next_h) = (self.prev[at(h)], self.next[at(h)]);
                let (prev_a, next_a) = (self.prev[at(across)], self.next[at(across)]);
                self.next[at(prev_h)] = next_a;
                self.prev[at(next_a)] = prev_h;
                self.next[at(prev_a)] = next_h;
                self.prev[at(next_h)] = prev_a;
                self.stamp[at(h)] = stamp;
                self.stamp[at(across)] = stamp;
            }
        }
        for &h in loops_l.iter().chain(loops_r) {
            let first = h & !LAST;
            if self.stamp[at(first)] == stamp {
                continue;
            }
            let mut h = first;
            loop {
                self.stamp[at(h)] = stamp;
                let following = self.next[at(h)];
                if following == first {
                    out.push(h | LAST);
                    break;
                }
                out.push(h);
                h = following;
            }
        }
    }
}

fn loop_of_face(face: usize) -> [u32; 3] {
    let h = 3 * face as u32;
    [h, h + 1, (h + 2) | LAST]
}

/// The root's own loops at the end of a child's pieces; their number tells where they begin in a small subtree.
fn tail(pieces: &[Piece], len: u16, first_face: usize, faces: usize) -> Vec<u32> {
    let mut own = Vec::new();
    match pieces.last() {
        Some(Piece { entries, .. }) if faces > 1 => {
            let end = if let Entries::Near { entries, .. } = entries { entries.len() } else { 0 };
            entries.append(end.saturating_sub(usize::from(len))..end, &mut own);
        }
        _ => own.extend(loop_of_face(first_face)),
    }
    own
}

/// True if the half-edge lies between two faces of the mesh.
pub fn is_inner(mesh: &TreeMesh, half_edge: u32) -> bool {
    mesh.opposite[half_edge as usize] != NONE
}
