//! Arcs along ridges and flaps, where a chord leaves part of the surface uncovered.
//!
//! A chord cuts a strip off one of the two clusters that share an arc. Where they meet at a flat angle, the other
//! cluster's polygon lies under that strip, within its own bound. Where they meet at a ridge, or fold back as at the
//! rim of an ear, a point of the arc may lie beyond both polygons: nothing is nearer to it than the chord. A vertex
//! that keeps such points near gets a record, up to the largest tolerance at which clusters meet there at such an
//! angle. In the order of bounds its key is the arc's deviation; in the budget order, where clusters meet at other
//! tolerances, it is what the error of the strip is worth.

use super::activity::Activity;
use super::curves::CurveRecord;
use super::loops::{LAST, Loops, split_loops};
use super::polyline::{self, Chord};
use super::uncovered::{FLAT, Meeting, Order, uncovered};
use crate::bounds::NodeBounds;
use crate::partition::Split;
use crate::tree_order::TreeMesh;
use glam::{DVec3, Vec3};
use std::ops::Range;

/// The records that uncovered arcs ask for.
///
/// A node whose bound is a distance from its corners needs no polygon to lie under it; `keys` are the welded vertices' records as far as splits register them.
pub fn records(
    mesh: &TreeMesh,
    splits: &[Split],
    loops: &Loops,
    nodes: &[NodeBounds],
    keys: &[Activity],
) -> Vec<CurveRecord> {
    let tree = Tree { mesh, splits, loops, nodes, keys };
    tree.records_below(0, 0..mesh.faces.len()).concat()
}

/// Below this many faces a subtree stays on one thread.
const SERIAL_BELOW: usize = 4096;

/// The records found by one thread, and memory that is used again for each arc.
#[derive(Default)]
struct Found {
    records: Vec<CurveRecord>,
    entries: Vec<u32>,
    edges: Vec<u32>,
    arc: Arc,
}

/// An arc, and the clusters that meet along one of its chords.
#[derive(Default)]
struct Arc {
    vertices: Vec<u32>,
    points: Vec<Vec3>,
    meetings: Vec<Meeting>,
}

/// A cluster on one side of an edge, on the way down to the face.
#[derive(Clone)]
struct Side {
    node: usize,
    faces: Range<usize>,
    face: usize,
}

struct Tree<'a> {
    mesh: &'a TreeMesh,
    splits: &'a [Split],
    loops: &'a Loops,
    nodes: &'a [NodeBounds],
    keys: &'a [Activity],
}

impl Tree<'_> {
    /// The records of a node and of all below, in pieces in the order of the nodes.
    fn records_below(&self, node: usize, faces: Range<usize>) -> Vec<Vec<CurveRecord>> {
        let mut found = Found::default();
        if faces.len() < SERIAL_BELOW {
            self.records_below_serial(node, faces, &mut found);
            return vec![found.records];
        }
        self.records_of_cut(node, faces.clone(), &mut found);
        let [left, right] = self.children(node, &faces);
        let (l, r) =
            rayon::join(|| self.records_below(left.0, left.1), || self.records_below(right.0, right.1));
        let mut pieces = vec![found.records];
        pieces.extend(l);
        pieces.extend(r);
        pieces
    }

    fn records_below_serial(&self, node: usize, faces: Range<usize>, found: &mut Found) {
        // A cluster of fewer faces is cut into single ones at least on one side, which register all their corners:
        // no arc has a vertex to leave out.
        if faces.len() >= 4 && !self.nodes[node].is_flat() {
            self.records_of_cut(node, faces.clone(), found);
            let [left, right] = self.children(node, &faces);
            self.records_below_serial(left.0, left.1, found);
            self.records_below_serial(right.0, right.1, found);
        }
    }

    fn children(&self, node: usize, faces: &Range<usize>) -> [(usize, Range<usize>); 2] {
        let left = self.splits[node].left_faces as usize;
        let middle = faces.start + left;
        [(node + 1, faces.start..middle), (node + left, middle..faces.end)]
    }

    /// The records of the arcs that `node` cuts.
    fn records_of_cut(&self, node: usize, faces: Range<usize>, found: &mut Found) {
        let children = self.children(node, &faces);
        let is_face = children.iter().any(|(_, faces)| faces.len() == 1);
        if self.splits[node].joins_components || is_face {
            return;
        }
        let right = 3 * children[1].1.start..3 * children[1].1.end;
        let on_cut = |h: u32| right.contains(&(self.mesh.opposite[h as usize] as usize));
        let Found { records, entries, edges, arc } = found;
        for entries in split_loops(self.loops.read(children[0].0, entries)) {
            each_arc(self.mesh, entries, on_cut, &self.loops.starts_at_end, edges, |edges| {
                // Without a vertex between its ends there is none to leave out.
                if edges.len() > 1 {
                    self.records_of_arc(node, edges, &children, arc, records);
                }
            });
        }
    }

    /// The same for an arc of these half-edges.
    fn records_of_arc(
        &self,
        node: usize,
        edges: &[u32],
        children: &[(usize, Range<usize>); 2],
        arc: &mut Arc,
        out: &mut Vec<CurveRecord>,
    ) {
        let Arc { vertices, points, meetings } = arc;
        vertices.clear();
        vertices.extend(edges.iter().map(|&h| self.mesh.origin(h)));
        vertices.extend(edges.last().map(|&h| self.mesh.target(h)));
        points.clear();
        points.extend(vertices.iter().map(|&v| self.mesh.positions[v as usize]));
        for order in [Order::Bound, Order::Budget] {
            let key = |i: usize| order.of_vertex(&self.keys[self.mesh.weld[vertices[i] as usize] as usize]);
            // The cut is there, and its ends are drawn, below the key of its node.
            let highest = order.of_node(&self.nodes[node]);
            let mut any = false;
            let raised = polyline::raise(points, key, highest, |chord| {
                let find = |above: f64, out: &mut Vec<Meeting>| {
                    let chord = Chord { lowest: above, ..chord };
                    self.find_meetings(order, node, children, edges[chord.from], chord, out);
                };
                let miss = uncovered(order, points, chord, meetings, find);
                any |= miss.is_some();
                miss
            });
            if any {
                out.extend(
                    raised.iter().map(|r| order.record(self.mesh.weld[vertices[r.point] as usize], r)),
                );
            }
        }
    }

    /// Finds the clusters that meet along a chord of the cut of `node`, whose first edge is `half_edge`, at the
    /// tolerances at which it is drawn.
    ///
    /// They are the same along the whole chord: where another cluster begins, a vertex is drawn.
    fn find_meetings(
        &self,
        order: Order,
        node: usize,
        children: &[(usize, Range<usize>); 2],
        half_edge: u32,
        chord: Chord,
        out: &mut Vec<Meeting>,
    ) {
        out.clear();
        let mut below = order.of_node(&self.nodes[node]);
        let faces = [half_edge, self.mesh.opposite[half_edge as usize]].map(|h| h as usize / 3);
        let side = |i: usize| Side { node: children[i].0, faces: children[i].1.clone(), face: faces[i] };
        let mut sides = [side(0), side(1)];
        while below > chord.lowest {
            let [a, b] = [0, 1].map(|i| self.key(order, &sides[i]));
            let from = a.max(b);
            if from < below.min(chord.highest) {
                let normals = [0, 1].map(|i| self.normal(order, &sides[i]));
                if normals[0].dot(normals[1]) <= FLAT && normals != [DVec3::ZERO; 2] {
                    out.push(Meeting { from, below, normals });
                }
            }
            if sides.iter().all(|s| s.faces.len() == 1) {
                break;
            }
            // The cluster with the larger key is refined first as the tolerance falls.
            let coarser = usize::from(b > a);
            let coarser = if sides[coarser].faces.len() == 1 { 1 - coarser } else { coarser };
            below = below.min(from);
            self.descend(&mut sides[coarser]);
        }
    }

    fn descend(&self, side: &mut Side) {
        let left = self.splits[side.node].left_faces as usize;
        let middle = side.faces.start + left;
        if side.face < middle {
            *side = Side { node: side.node + 1, faces: side.faces.start..middle, face: side.face };
        } else {
            *side = Side { node: side.node + left, faces: middle..side.faces.end, face: side.face };
        }
    }

    /// Zero for a cluster whose bound needs no covering, in the order of bounds.
    fn normal(&self, order: Order, side: &Side) -> DVec3 {
        if side.faces.len() == 1 {
            self.mesh.normal_of_face(side.face).as_dvec3()
        } else if order == Order::Bound && self.nodes[side.node].from_corners {
            DVec3::ZERO
        } else {
            self.splits[side.node].normal.as_dvec3()
        }
    }

    fn key(&self, order: Order, side: &Side) -> f64 {
        if side.faces.len() == 1 { 0.0 } else { order.of_node(&self.nodes[side.node]) }
    }
}

/// Shows the stretches of a loop that lie on the cut, from end to end of an arc; a closed cut starts and ends at
/// anchors. `arc` is memory for one stretch.
fn each_arc(
    mesh: &TreeMesh,
    entries: &[u32],
    on_cut: impl Fn(u32) -> bool,
    starts_at_end: &[bool],
    arc: &mut Vec<u32>,
    mut show: impl FnMut(&[u32]),
) {
    let half_edge = |i: usize| entries[i] & !LAST;
    let Some(last) = entries.len().checked_sub(1) else { return };
    let mut after_cut = on_cut(half_edge(last));
    let mut begins = |i: usize| {
        let is_on_cut = on_cut(half_edge(i));
        let begins = is_on_cut && (!after_cut || starts_at_end[half_edge(i) as usize]);
        after_cut = is_on_cut;
        begins
    };
    let mut anchors = Vec::new();
    let first = match (0..entries.len()).find(|&i| begins(i)) {
        Some(first) => first,
        None if on_cut(half_edge(0)) => {
            let points: Vec<Vec3> =
                entries.iter().map(|&h| mesh.positions[mesh.origin(h & !LAST) as usize]).collect();
            polyline::complete_to_three(&points, &mut anchors);
            anchors.iter().copied().min().unwrap_or(0)
        }
        None => return,
    };
    arc.clear();
    for i in (first..entries.len()).chain(0..first) {
        let h = half_edge(i);
        let is_on_cut = on_cut(h);
        if !arc.is_empty() && (!is_on_cut || starts_at_end[h as usize] || anchors.contains(&i)) {
            show(arc);
            arc.clear();
        }
        if is_on_cut {
            arc.push(h);
        }
    }
    if !arc.is_empty() {
        show(arc);
    }
}
