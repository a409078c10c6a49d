//! Arcs along ridges and flaps, where a chord leaves part of the surface uncovered.
//!
//! A chord cuts a strip off one of the two clusters that share an arc. Where they meet at a flat angle, the other
//! cluster's polygon lies under that strip, within its own bound. Where they meet at a ridge, or fold back as at the
//! rim of an ear, a point of the arc may lie beyond both polygons: nothing is nearer to it than the chord. A vertex
//! that keeps such points near gets a record, up to the largest tolerance at which clusters meet there at such an
//! angle. In the order of bounds its key is the arc's deviation; in the budget order, where clusters meet at other
//! tolerances, it is what the error of the strip is worth.

use super::anchors;
use super::cluster_tree::{ClusterTree, Finder};
use super::curves::CurveRecord;
use super::loops::{LAST, split_loops};
use super::polyline::{self, Chord};
use super::uncovered::{FLAT, Meeting, Order, uncovered};
use crate::partition::Subtree;
use glam::{DVec3, Vec3};

/// The records that uncovered arcs ask for.
///
/// A node whose bound is a distance from its corners needs no polygon to lie under it.
pub fn records(tree: ClusterTree<'_>) -> Vec<CurveRecord> {
    tree.records(&Flaps { tree })
}

/// An arc, and the clusters that meet along one of its chords.
#[derive(Default)]
struct Arc {
    vertices: Vec<u32>,
    points: Vec<Vec3>,
    meetings: Vec<Meeting>,
}

/// A cluster on one side of an edge, on the way down to the face.
struct Side {
    at: Subtree,
    face: usize,
}

/// What is used again for each node: its loops, the edges of one arc, and the arc.
#[derive(Default)]
struct Memory {
    entries: Vec<u32>,
    edges: Vec<u32>,
    arc: Arc,
}

struct Flaps<'a> {
    tree: ClusterTree<'a>,
}

impl Finder for Flaps<'_> {
    type Memory = Memory;

    fn look(&self, at: &Subtree, _above: f32, memory: &mut Memory, found: &mut Vec<CurveRecord>) -> bool {
        // A cluster of fewer faces is cut into single ones at least on one side, which register all their corners:
        // no arc has a vertex to leave out.
        let may_have_any = at.faces.len() >= 4 && !self.tree.nodes[at.node].is_flat();
        if may_have_any {
            self.records_of_cut(at, memory, found);
        }
        may_have_any
    }
}

impl Flaps<'_> {
    /// The records of the arcs along which a node is cut.
    fn records_of_cut(&self, at: &Subtree, memory: &mut Memory, found: &mut Vec<CurveRecord>) {
        let ClusterTree { mesh, splits, loops, .. } = self.tree;
        let children = at.children(splits);
        if splits[at.node].joins_components || children.iter().any(Subtree::is_face) {
            return;
        }
        let right = 3 * children[1].faces.start..3 * children[1].faces.end;
        let on_cut = |h: u32| right.contains(&(mesh.opposite[h as usize] as usize));
        let Memory { entries, edges, arc } = memory;
        for entries in split_loops(loops.read(children[0].node, entries)) {
            let complete =
                |chosen: &mut Vec<usize>| anchors::complete(mesh, splits, at.node, entries, chosen);
            each_arc(entries, on_cut, &loops.starts_at_end, complete, edges, |edges| {
                // Without a vertex between its ends there is none to leave out.
                if edges.len() > 1 {
                    self.records_of_arc(at.node, edges, &children, arc, found);
                }
            });
        }
    }

    /// The same for an arc of these half-edges.
    fn records_of_arc(
        &self,
        node: usize,
        edges: &[u32],
        children: &[Subtree; 2],
        arc: &mut Arc,
        out: &mut Vec<CurveRecord>,
    ) {
        let ClusterTree { mesh, nodes, keys, .. } = self.tree;
        let Arc { vertices, points, meetings } = arc;
        vertices.clear();
        vertices.extend(edges.iter().map(|&h| mesh.origin(h)));
        vertices.extend(edges.last().map(|&h| mesh.target(h)));
        points.clear();
        points.extend(vertices.iter().map(|&v| mesh.positions[v as usize]));
        for order in [Order::Bound, Order::Budget] {
            let keys = |i: usize| &keys[mesh.weld[vertices[i] as usize] as usize];
            let key = |i: usize| order.of_vertex(keys(i));
            let drawn = |i: usize| order.sphere_of(keys(i));
            // The cut is there, and its ends are drawn, below the key of its node; small ones have anchors that come later.
            let highest = order.of_node(&nodes[node]).min(key(0)).min(key(points.len() - 1));
            let mut any = false;
            let raised = polyline::raise(points, key, highest, drawn, |chord| {
                let find = |above: f64, out: &mut Vec<Meeting>| {
                    let chord = Chord { lowest: above, ..chord };
                    self.find_meetings(order, node, children, edges[chord.from], chord, out);
                };
                let miss = uncovered(order, points, chord, meetings, find);
                any |= miss.is_some();
                miss
            });
            if any {
                out.extend(raised.iter().map(|r| order.record(mesh.weld[vertices[r.point] as usize], r)));
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
        children: &[Subtree; 2],
        half_edge: u32,
        chord: Chord,
        out: &mut Vec<Meeting>,
    ) {
        out.clear();
        let mut below = order.of_node(&self.tree.nodes[node]);
        let faces = [half_edge, self.tree.mesh.opposite[half_edge as usize]].map(|h| h as usize / 3);
        let side = |i: usize| Side { at: children[i].clone(), face: faces[i] };
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
            if sides.iter().all(|s| s.at.is_face()) {
                break;
            }
            // The cluster with the larger key is refined first as the tolerance falls.
            let coarser = usize::from(b > a);
            let coarser = if sides[coarser].at.is_face() { 1 - coarser } else { coarser };
            below = below.min(from);
            let side = &mut sides[coarser];
            side.at = side.at.child_with(side.face, self.tree.splits);
        }
    }

    /// Zero for a cluster whose bound needs no covering, in the order of bounds.
    fn normal(&self, order: Order, side: &Side) -> DVec3 {
        if side.at.is_face() {
            self.tree.mesh.normal_of_face(side.face).as_dvec3()
        } else if order == Order::Bound && self.tree.nodes[side.at.node].is_from_corners() {
            DVec3::ZERO
        } else {
            self.tree.splits[side.at.node].normal.as_dvec3()
        }
    }

    fn key(&self, order: Order, side: &Side) -> f64 {
        if side.at.is_face() { 0.0 } else { order.of_node(&self.tree.nodes[side.at.node]) }
    }
}

/// Shows the stretches of a loop that lie on the cut, from end to end of an arc; a closed cut starts and ends at
/// anchors, which `complete` finds. `arc` is memory for one stretch.
fn each_arc(
    entries: &[u32],
    on_cut: impl Fn(u32) -> bool,
    starts_at_end: &[bool],
    complete: impl FnOnce(&mut Vec<usize>),
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
            complete(&mut anchors);
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
