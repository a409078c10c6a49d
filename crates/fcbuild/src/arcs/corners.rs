//! Which vertices each split registers as corners of its children's polygons.

use super::loops::{LAST, Loops, split_loops};
use super::polyline;
use crate::mesh::NONE;
use crate::partition::Split;
use crate::tree_order::TreeMesh;
use glam::Vec3;
use std::ops::Range;

/// A vertex that must be drawn whenever a node is refined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Registration {
    /// The vertex.
    pub vertex: u32,
    /// The node whose split needs it.
    pub node: u32,
}

/// What a visitor is shown of a node: its corners registered by ancestors, present whenever the node is drawn.
pub struct Cornered<'a> {
    /// The node.
    pub node: usize,
    /// Its faces.
    pub faces: Range<usize>,
    /// Its loops, as in [`Loops::of_node`].
    pub loops: &'a [u32],
    /// Vertices of the loops that an ancestor registers.
    pub corners: &'a [u32],
}

/// Walks the tree from the root down, registers corners, and shows each interior node with the corners it has got.
///
/// `anchored` says of each vertex whether it is drawn in every mesh. Each node's answer from `measure` comes back in
/// node order; registrations come back with ancestors before descendants.
pub fn register<T: Send + Default + Clone>(
    mesh: &TreeMesh,
    splits: &[Split],
    loops: &Loops,
    anchored: &[bool],
    measure: &(dyn Fn(Cornered<'_>) -> T + Sync),
) -> (Vec<Registration>, Vec<T>) {
    let mut measured = vec![T::default(); splits.len()];
    let mut registered: Vec<bool> = vec![false; mesh.opposite.len()];
    let Some(first) = measured.first_mut() else {
        // A single face: nothing is split, its corners are always drawn.
        return (Vec::new(), measured);
    };
    let walk = Walk { mesh, splits, loops, measure };
    for &h in loops.of_node(0) {
        registered[(h & !LAST) as usize] = anchored[mesh.origin(h & !LAST) as usize];
    }
    *first = walk.show(0, 0..mesh.faces.len(), &registered);
    let pieces = walk.descend(0, 0..mesh.faces.len(), &mut registered, &mut measured[1..]);
    (pieces.concat(), measured)
}

struct Walk<'a, T> {
    mesh: &'a TreeMesh,
    splits: &'a [Split],
    loops: &'a Loops,
    measure: &'a (dyn Fn(Cornered<'_>) -> T + Sync),
}

/// Below this many faces a subtree stays on one thread.
const SERIAL_BELOW: usize = 4096;

/// One child of a split.
#[derive(Clone)]
struct Child {
    node: usize,
    faces: Range<usize>,
}

impl<T: Send> Walk<'_, T> {
    /// Registers what the split of `node` needs, and all splits below.
    ///
    /// `registered` holds, for each half-edge of the node's faces that lies on a boundary, whether its start is a
    /// corner registered by an ancestor; `measured` are the answers of the nodes below.
    fn descend(
        &self,
        node: usize,
        faces: Range<usize>,
        registered: &mut [bool],
        measured: &mut [T],
    ) -> Vec<Vec<Registration>> {
        let mut own = Vec::new();
        if faces.len() < SERIAL_BELOW {
            self.descend_serial(node, faces, registered, measured, &mut own);
            return vec![own];
        }
        let [left, right] = self.split(node, &faces, registered, measured, &mut own);
        let (registered_l, registered_r) = registered.split_at_mut(3 * left.faces.len());
        let (measured_l, measured_r) = measured.split_at_mut(left.faces.len() - 1);
        let go = |child: Child, registered: &mut [bool], measured: &mut [T]| match measured {
            [] => Vec::new(),
            [_, below @ ..] => self.descend(child.node, child.faces, registered, below),
        };
        let (l, r) =
            rayon::join(|| go(left, registered_l, measured_l), || go(right, registered_r, measured_r));
        let mut pieces = vec![own];
        pieces.extend(l);
        pieces.extend(r);
        pieces
    }

    fn descend_serial(
        &self,
        node: usize,
        faces: Range<usize>,
        registered: &mut [bool],
        measured: &mut [T],
        out: &mut Vec<Registration>,
    ) {
        let [left, right] = self.split(node, &faces, registered, measured, out);
        let (registered_l, registered_r) = registered.split_at_mut(3 * left.faces.len());
        let (measured_l, measured_r) = measured.split_at_mut(left.faces.len() - 1);
        if let [_, below @ ..] = measured_l {
            self.descend_serial(left.node, left.faces, registered_l, below, out);
        }
        if let [_, below @ ..] = measured_r {
            self.descend_serial(right.node, right.faces, registered_r, below, out);
        }
    }

    /// Registers the corners of one split and measures its children.
    fn split(
        &self,
        node: usize,
        faces: &Range<usize>,
        registered: &mut [bool],
        measured: &mut [T],
        out: &mut Vec<Registration>,
    ) -> [Child; 2] {
        let left_faces = self.splits[node].left_faces as usize;
        let middle = faces.start + left_faces;
        let children = [
            Child { node: node + 1, faces: faces.start..middle },
            Child { node: node + left_faces, faces: middle..faces.end },
        ];
        let mut marks = Marks { mesh: self.mesh, registered, base: 3 * faces.start, node, out };
        for (i, child) in children.iter().enumerate() {
            let other = &children[1 - i].faces;
            if let [_] = self.mesh.faces[child.faces.clone()] {
                marks.register_face(child.faces.start);
            }
            // Both sides see the same ends of arcs; they are recorded once.
            self.inherit(child, other, i == 0, &mut marks);
        }
        for (i, child) in children.iter().enumerate() {
            self.keep_three(child, &children[1 - i].faces, &mut marks);
        }
        for (child, slot) in children.iter().zip([0, left_faces - 1]) {
            if child.faces.len() > 1 {
                measured[slot] = self.show(
                    child.node,
                    child.faces.clone(),
                    &registered[3 * (child.faces.start - faces.start)..],
                );
            }
        }
        children
    }

    /// Finds which corners of a child its ancestors register, this split included (steps 1 and 2 of `[Tsuji07]` 4.3).
    fn inherit(&self, child: &Child, sibling: &Range<usize>, record: bool, marks: &mut Marks<'_>) {
        if child.faces.len() == 1 && !record {
            return;
        }
        let face_loop = face_loop(child.faces.start);
        for entries in split_loops(self.loops_of(child, &face_loop)) {
            let cut = |h: u32| self.on_cut(h, sibling);
            let Some(&last) = entries.last() else { continue };
            let mut after_cut = cut(last & !LAST);
            let mut open = false;
            for &h in entries {
                let h = h & !LAST;
                let now_cut = cut(h);
                let ends_here = if now_cut { self.loops.starts_at_end[h as usize] } else { after_cut };
                if now_cut {
                    marks.set(h, ends_here);
                } else if ends_here {
                    marks.set(h, true);
                }
                if ends_here && record {
                    marks.record(self.mesh.origin(h));
                }
                open |= ends_here || !now_cut;
                after_cut = now_cut;
            }
            // A closed cut has no ends: three anchors stand in for them.
            if !open && record {
                self.anchor(entries, sibling, marks);
            }
        }
    }

    /// Adds corners until the child's longest loop has three, so that its polygon does not collapse.
    fn keep_three(&self, child: &Child, sibling: &Range<usize>, marks: &mut Marks<'_>) {
        if child.faces.len() == 1 {
            return;
        }
        let loops = split_loops(self.loops.of_node(child.node));
        // The first of the longest.
        let longest = loops.reduce(|best, entries| if entries.len() > best.len() { entries } else { best });
        if let Some(entries) = longest
            && entries.iter().filter(|&&h| marks.get(h & !LAST)).take(3).count() < 3
        {
            self.anchor(entries, sibling, marks);
        }
    }

    /// Completes a loop's corners to three.
    fn anchor(&self, entries: &[u32], sibling: &Range<usize>, marks: &mut Marks<'_>) {
        let points: Vec<Vec3> =
            entries.iter().map(|&h| self.mesh.positions[self.mesh.origin(h & !LAST) as usize]).collect();
        let mut chosen: Vec<usize> =
            (0..entries.len()).filter(|&i| marks.get(entries[i] & !LAST)).take(3).collect();
        let had = chosen.len();
        polyline::complete_to_three(&points, &mut chosen);
        for &i in &chosen[had..] {
            let h = entries[i] & !LAST;
            let before = entries[if i == 0 { entries.len() - 1 } else { i - 1 }] & !LAST;
            marks.set(h, true);
            marks.record(self.mesh.origin(h));
            // The sibling's half-edge that starts at the same vertex of the cut.
            if self.on_cut(before, sibling) {
                marks.set(self.mesh.opposite[before as usize], true);
            }
        }
    }

    fn on_cut(&self, half_edge: u32, sibling: &Range<usize>) -> bool {
        let across = self.mesh.opposite[half_edge as usize];
        across != NONE && sibling.contains(&(across as usize / 3))
    }

    fn loops_of<'b>(&'b self, child: &Child, face_loop: &'b [u32; 3]) -> &'b [u32] {
        if child.faces.len() == 1 { face_loop } else { self.loops.of_node(child.node) }
    }

    fn show(&self, node: usize, faces: Range<usize>, registered: &[bool]) -> T {
        let loops = self.loops.of_node(node);
        let base = 3 * faces.start;
        let corners: Vec<u32> = loops
            .iter()
            .map(|h| h & !LAST)
            .filter(|&h| registered[h as usize - base])
            .map(|h| self.mesh.origin(h))
            .collect();
        (self.measure)(Cornered { node, faces, loops, corners: &corners })
    }
}

fn face_loop(face: usize) -> [u32; 3] {
    let h = 3 * face as u32;
    [h, h + 1, (h + 2) | LAST]
}

/// The corner marks of a split's faces, and the list that its registrations go to.
struct Marks<'a> {
    mesh: &'a TreeMesh,
    registered: &'a mut [bool],
    base: usize,
    node: usize,
    out: &'a mut Vec<Registration>,
}

impl Marks<'_> {
    fn get(&self, half_edge: u32) -> bool {
        self.registered[half_edge as usize - self.base]
    }

    fn set(&mut self, half_edge: u32, is_corner: bool) {
        self.registered[half_edge as usize - self.base] = is_corner;
    }

    fn record(&mut self, vertex: u32) {
        self.out.push(Registration { vertex, node: self.node as u32 });
    }

    /// A child of a single face is drawn as that face: all three corners are needed.
    fn register_face(&mut self, face: usize) {
        for vertex in self.mesh.faces[face] {
            self.record(vertex);
        }
    }
}
