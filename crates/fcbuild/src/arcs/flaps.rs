//! Arcs along ridges and flaps, where a chord leaves part of the surface uncovered.
//!
//! A chord cuts a strip off one of the two clusters that share an arc. Where they meet at a flat angle, the other
//! cluster's polygon lies under that strip, within its own bound. Where they meet at a ridge, or fold back as at the
//! rim of an ear, a point of the arc may lie beyond both polygons: nothing is nearer to it than the chord. A vertex
//! that keeps such points within the tolerance gets a record from the arc's deviation, up to the largest tolerance
//! at which clusters meet there at such an angle.

use super::activity::Activity;
use super::curves::CurveRecord;
use super::loops::{LAST, Loops, split_loops};
use super::polyline::{self, Chord};
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
    edges: Vec<u32>,
    arc: Arc,
}

/// An arc with the clusters that meet along it.
#[derive(Default)]
struct Arc {
    vertices: Vec<u32>,
    meetings: Meetings,
}

/// Meetings at each edge of an arc: those of edge `i` end at `ends[i]`.
#[derive(Default)]
struct Meetings {
    all: Vec<Meeting>,
    ends: Vec<usize>,
}

impl Meetings {
    fn at(&self, edge: usize) -> &[Meeting] {
        let start = edge.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.all[start..self.ends[edge]]
    }
}

/// A cluster on one side of an edge, on the way down to the face.
#[derive(Clone)]
struct Side {
    node: usize,
    faces: Range<usize>,
    face: usize,
}

/// Two clusters that meet at an edge for tolerances in [from, below), with a ridge or a fold between them.
#[derive(Clone, Copy, Debug)]
struct Meeting {
    from: f64,
    below: f64,
    /// Normal of the plane on either side; zero if that cluster needs no covering.
    normals: [DVec3; 2],
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
        let Found { records, edges, arc } = found;
        for entries in split_loops(self.loops.of_node(children[0].0)) {
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
        let Arc { vertices, meetings } = arc;
        vertices.clear();
        vertices.extend(edges.iter().map(|&h| self.mesh.origin(h)));
        vertices.extend(edges.last().map(|&h| self.mesh.target(h)));
        let key = |i: usize| f64::from(self.keys[self.mesh.weld[vertices[i] as usize] as usize].bound);
        // Meetings at each edge, as far as one of its ends is not drawn anyway.
        let last = vertices.len() - 1;
        let drawn_below = |i: usize| if i == 0 || i == last { f64::INFINITY } else { key(i) };
        meetings.all.clear();
        meetings.ends.clear();
        for (i, &h) in edges.iter().enumerate() {
            let down_to = drawn_below(i).min(drawn_below(i + 1));
            self.add_meetings(node, h, children, down_to, &mut meetings.all);
            meetings.ends.push(meetings.all.len());
        }
        if meetings.all.is_empty() {
            return;
        }
        let points: Vec<Vec3> = vertices.iter().map(|&v| self.mesh.positions[v as usize]).collect();
        // The cut is there, and its ends are drawn, below the bound of its node.
        let highest = f64::from(self.nodes[node].bound);
        for r in polyline::raise(&points, key, highest, |chord| uncovered(&points, chord, meetings)) {
            let vertex = self.mesh.weld[vertices[r.point] as usize];
            out.push(CurveRecord { vertex, error: r.key, sphere: r.sphere });
        }
    }

    /// Adds the clusters that meet at an edge of the cut of `node`, for tolerances above `down_to`.
    fn add_meetings(
        &self,
        node: usize,
        half_edge: u32,
        children: &[(usize, Range<usize>); 2],
        down_to: f64,
        out: &mut Vec<Meeting>,
    ) {
        let mut below = f64::from(self.nodes[node].bound);
        if below <= down_to {
            return;
        }
        let faces = [half_edge, self.mesh.opposite[half_edge as usize]].map(|h| h as usize / 3);
        let side = |i: usize| Side { node: children[i].0, faces: children[i].1.clone(), face: faces[i] };
        let mut sides = [side(0), side(1)];
        while below > down_to {
            let [a, b] = [0, 1].map(|i| self.bound(&sides[i]));
            let from = a.max(b);
            let normals = [0, 1].map(|i| self.normal(&sides[i]));
            let is_flat = normals[0].dot(normals[1]) > FLAT;
            if from < below && !is_flat && normals != [DVec3::ZERO; 2] {
                out.push(Meeting { from, below, normals });
            }
            if sides.iter().all(|s| s.faces.len() == 1) {
                break;
            }
            // The cluster with the larger bound is refined first as the tolerance falls.
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

    /// Zero for a cluster whose bound needs no covering.
    fn normal(&self, side: &Side) -> DVec3 {
        if side.faces.len() == 1 {
            self.mesh.normal_of_face(side.face).as_dvec3()
        } else if self.nodes[side.node].from_corners {
            DVec3::ZERO
        } else {
            self.splits[side.node].normal.as_dvec3()
        }
    }

    fn bound(&self, side: &Side) -> f64 {
        if side.faces.len() == 1 { 0.0 } else { f64::from(self.nodes[side.node].bound) }
    }
}

/// Cosine of the angle (20 degrees) between planes up to which an arc is taken to be covered: a point in both slabs
/// and beyond both polygons is at most 1 / cos(10 degrees) times the larger bound from the chord.
const FLAT: f64 = 0.94;

/// Cosine of the angle (120 degrees) between planes from which on a chord must be near its arc on either side: the
/// clusters fold back, and a polygon that juts out beyond the arc has no surface under it.
const FOLDED: f64 = -0.5;

/// The point that is farthest from a chord among those that lie beyond the polygons on both sides of it, and its
/// distance, capped by the tolerance up to which those polygons are drawn; none if all points are covered.
fn uncovered(points: &[Vec3], chord: Chord, meetings: &Meetings) -> Option<(usize, f64)> {
    let (a, b) = (points[chord.from].as_dvec3(), points[chord.to].as_dvec3());
    let along = b - a;
    let mut worst = (0, chord.lowest);
    for (i, p) in points.iter().enumerate().take(chord.to).skip(chord.from + 1) {
        let offset = polyline::offset_from_segment(p.as_dvec3(), a, b);
        let distance = offset.length();
        if distance <= worst.1 {
            continue;
        }
        for m in meetings.at(i - 1).iter().chain(meetings.at(i)) {
            // The left cluster lies to the left of the chord in its plane, the other one to the right.
            let into_left = m.normals[0].cross(along);
            let into_right = along.cross(m.normals[1]);
            let counts = m.normals.contains(&DVec3::ZERO)
                || m.normals[0].dot(m.normals[1]) < FOLDED
                || (offset.dot(into_left) <= 0.0 && offset.dot(into_right) <= 0.0);
            let at = distance.min(m.below);
            if counts && distance > m.from && m.from < chord.highest && at > worst.1 {
                worst = (i, at);
            }
        }
    }
    (worst.0 > 0).then_some(worst)
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

#[cfg(test)]
mod tests {
    use super::*;

    fn meeting(a: DVec3, b: DVec3) -> Meetings {
        let one = Meeting { from: 0.0, below: 9.0, normals: [a, b] };
        Meetings { all: vec![one; 2], ends: vec![1, 2] }
    }

    fn uncovered(points: &[Vec3], meetings: &Meetings) -> f64 {
        let chord = Chord { from: 0, to: 2, lowest: 0.0, highest: 9.0 };
        super::uncovered(points, chord, meetings).map_or(0.0, |worst| worst.1)
    }

    #[test]
    fn a_point_is_uncovered_only_beyond_both_polygons() {
        // An arc along x whose middle vertex leaves the chord sideways.
        let arc = |y: f32, z: f32| [Vec3::ZERO, Vec3::new(1.0, y, z), Vec3::new(2.0, 0.0, 0.0)];
        // A flat meeting: the strip lies over one polygon or the other.
        let flat = meeting(DVec3::Z, DVec3::Z);
        assert_eq!(uncovered(&arc(0.5, 0.0), &flat), 0.0);
        assert_eq!(uncovered(&arc(-0.5, 0.0), &flat), 0.0);
        // The rim of an ear: both clusters lie at y > 0, one above the other; a chord over a notch has nothing under it.
        let rim = meeting(DVec3::Z, -DVec3::Z);
        assert_eq!(uncovered(&arc(-0.5, 0.0), &rim), 0.5);
        assert_eq!(uncovered(&arc(0.5, 0.0), &rim), 0.5);
        // A right-angled ridge: the left cluster is flat at y > 0, the right one goes down from it.
        let ridge = meeting(DVec3::Z, -DVec3::Y);
        assert!((uncovered(&arc(-0.3, 0.4), &ridge) - 0.5).abs() < 1e-6);
        assert_eq!(uncovered(&arc(-0.3, -0.4), &ridge), 0.0);
    }
}
