//! Arcs along ridges and flaps, where a chord leaves part of the surface uncovered.
//!
//! A chord cuts a strip off one of the two clusters that share an arc. Where they meet at a flat angle, the other
//! cluster's polygon lies under that strip, within its own bound. Where they meet at a ridge, or fold back as at the
//! rim of an ear, a point of the arc may lie beyond both polygons: nothing is nearer to it than the chord. A vertex
//! that keeps such points within the tolerance gets a record from the arc's deviation, up to the largest tolerance
//! at which clusters meet there at such an angle.

use super::curves::CurveRecord;
use super::loops::{LAST, Loops, split_loops};
use super::polyline;
use crate::bounds::NodeBounds;
use crate::mesh::NONE;
use crate::partition::Split;
use crate::tree_order::TreeMesh;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// The records that uncovered arcs ask for.
///
/// `covered` says of each node that its bound is a distance from its corners, which needs no polygon to lie under
/// it; `keys` are the vertices' bounds as far as splits register them.
pub fn records(
    mesh: &TreeMesh,
    splits: &[Split],
    loops: &Loops,
    nodes: &[NodeBounds],
    covered: &[bool],
    keys: &[f64],
) -> Vec<CurveRecord> {
    let ranges = face_ranges(splits, mesh.faces.len());
    let tree = Tree { mesh, splits, loops, nodes, covered, keys };
    (0..splits.len())
        .into_par_iter()
        .filter(|&node| !splits[node].joins_components)
        .flat_map_iter(|node| tree.records_of_cut(node, ranges[node].clone()))
        .collect()
}

/// The range of faces of each node.
fn face_ranges(splits: &[Split], faces: usize) -> Vec<Range<usize>> {
    let mut ranges = vec![0..0; splits.len()];
    let mut stack = vec![(0, 0..faces)];
    while let Some((node, range)) = stack.pop() {
        if range.len() > 1 {
            let left = splits[node].left_faces as usize;
            let middle = range.start + left;
            stack.push((node + left, middle..range.end));
            stack.push((node + 1, range.start..middle));
            ranges[node] = range;
        }
    }
    ranges
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
    covered: &'a [bool],
    keys: &'a [f64],
}

impl Tree<'_> {
    /// The records of the arcs that `node` cuts.
    fn records_of_cut(&self, node: usize, faces: Range<usize>) -> Vec<CurveRecord> {
        let left = self.splits[node].left_faces as usize;
        let middle = faces.start + left;
        let mut out = Vec::new();
        // A single face registers all its corners: its arcs have no vertex to leave out.
        if left < 2 || faces.len() - left < 2 {
            return out;
        }
        let children = [(node + 1, faces.start..middle), (node + left, middle..faces.end)];
        let on_cut = |h: u32| {
            let across = self.mesh.opposite[h as usize];
            across != NONE && children[1].1.contains(&(across as usize / 3))
        };
        for entries in split_loops(self.loops.of_node(children[0].0)) {
            let ring: Vec<u32> = entries.iter().map(|h| h & !LAST).collect();
            for arc in arcs_of_ring(&ring, &on_cut, &self.loops.starts_at_end, self.mesh) {
                if arc.len() > 1 {
                    self.records_of_arc(node, &arc, &children, &mut out);
                }
            }
        }
        out
    }

    fn records_of_arc(
        &self,
        node: usize,
        arc: &[u32],
        children: &[(usize, Range<usize>); 2],
        out: &mut Vec<CurveRecord>,
    ) {
        let vertices: Vec<u32> = arc
            .iter()
            .map(|&h| self.mesh.origin(h))
            .chain(arc.last().map(|&h| self.mesh.target(h)))
            .collect();
        let key = |i: usize| self.keys[self.mesh.weld[vertices[i] as usize] as usize];
        // Meetings at each edge, as far as one of its ends is not drawn anyway.
        let last = vertices.len() - 1;
        let meetings: Vec<Vec<Meeting>> = arc
            .iter()
            .enumerate()
            .map(|(i, &h)| {
                let drawn_below = |i: usize| if i == 0 || i == last { f64::INFINITY } else { key(i) };
                self.meetings(node, h, children, drawn_below(i).min(drawn_below(i + 1)))
            })
            .collect();
        if meetings.iter().all(Vec::is_empty) {
            return;
        }
        let points: Vec<Vec3> = vertices.iter().map(|&v| self.mesh.positions[v as usize]).collect();
        let stretches = polyline::deviations(&points);
        let mut uncovered: Vec<f64> =
            stretches.iter().map(|d| uncovered(&points, d.from, d.to, &meetings)).collect();
        for (i, d) in stretches.iter().enumerate().rev() {
            if let Some(up) = d.within {
                uncovered[up] = uncovered[up].max(uncovered[i]);
            }
            if uncovered[i] > key(d.point) {
                let vertex = self.mesh.weld[vertices[d.point] as usize];
                out.push(CurveRecord { vertex, error: uncovered[i], sphere: d.sphere });
            }
        }
    }

    /// The clusters that meet at an edge of the cut of `node`, for tolerances above `down_to`.
    fn meetings(
        &self,
        node: usize,
        half_edge: u32,
        children: &[(usize, Range<usize>); 2],
        down_to: f64,
    ) -> Vec<Meeting> {
        let faces = [half_edge, self.mesh.opposite[half_edge as usize]].map(|h| h as usize / 3);
        let side = |i: usize| Side { node: children[i].0, faces: children[i].1.clone(), face: faces[i] };
        let mut sides = [side(0), side(1)];
        let mut below = self.nodes[node].bound;
        let mut out = Vec::new();
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
        out
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
            self.mesh.face_normals[side.face].as_dvec3()
        } else if self.covered[side.node] {
            DVec3::ZERO
        } else {
            self.splits[side.node].normal.as_dvec3()
        }
    }

    fn bound(&self, side: &Side) -> f64 {
        if side.faces.len() == 1 { 0.0 } else { self.nodes[side.node].bound }
    }
}

/// Cosine of the angle (20 degrees) between planes up to which an arc is taken to be covered: a point in both slabs
/// and beyond both polygons is at most 1 / cos(10 degrees) times the larger bound from the chord.
const FLAT: f64 = 0.94;

/// The largest distance from the chord of `from..=to` of a point that lies beyond the polygons on both sides of it,
/// capped by the tolerance up to which those polygons are drawn; 0 if all points are covered.
fn uncovered(points: &[Vec3], from: usize, to: usize, meetings: &[Vec<Meeting>]) -> f64 {
    let (a, b) = (points[from].as_dvec3(), points[to].as_dvec3());
    let along = b - a;
    let mut worst = 0.0_f64;
    for i in from + 1..to {
        let offset = polyline::offset_from_segment(points[i].as_dvec3(), a, b);
        let distance = offset.length();
        if distance <= worst {
            continue;
        }
        for m in meetings[i - 1].iter().chain(&meetings[i]) {
            // The left cluster lies to the left of the chord in its plane, the other one to the right.
            let into_left = m.normals[0].cross(along);
            let into_right = along.cross(m.normals[1]);
            if distance > m.from && offset.dot(into_left) <= 0.0 && offset.dot(into_right) <= 0.0 {
                worst = worst.max(distance.min(m.below));
            }
        }
    }
    worst
}

/// The stretches of a loop that lie on the cut, from end to end of an arc; a closed cut starts and ends at anchors.
fn arcs_of_ring(
    ring: &[u32],
    on_cut: &dyn Fn(u32) -> bool,
    starts_at_end: &[bool],
    mesh: &TreeMesh,
) -> Vec<Vec<u32>> {
    let n = ring.len();
    let begins = |i: usize| {
        let before = ring[(i + n - 1) % n];
        on_cut(ring[i]) && (starts_at_end[ring[i] as usize] || !on_cut(before))
    };
    let mut starts: Vec<usize> = (0..n).filter(|&i| begins(i)).collect();
    if starts.is_empty() && on_cut(ring[0]) {
        let points: Vec<Vec3> = ring.iter().map(|&h| mesh.positions[mesh.origin(h) as usize]).collect();
        polyline::complete_to_three(&points, &mut starts);
        starts.sort_unstable();
    }
    let is_start = |i: usize| starts.binary_search(&i).is_ok();
    starts
        .iter()
        .map(|&start| {
            let mut arc = vec![ring[start]];
            let mut i = (start + 1) % n;
            while !is_start(i) && on_cut(ring[i]) && i != start {
                arc.push(ring[i]);
                i = (i + 1) % n;
            }
            arc
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meeting(a: DVec3, b: DVec3) -> Vec<Vec<Meeting>> {
        vec![vec![Meeting { from: 0.0, below: 9.0, normals: [a, b] }]; 2]
    }

    #[test]
    fn a_point_is_uncovered_only_beyond_both_polygons() {
        // An arc along x whose middle vertex leaves the chord sideways.
        let arc = |y: f32, z: f32| [Vec3::ZERO, Vec3::new(1.0, y, z), Vec3::new(2.0, 0.0, 0.0)];
        // A flat meeting: the strip lies over one polygon or the other.
        let flat = meeting(DVec3::Z, DVec3::Z);
        assert_eq!(uncovered(&arc(0.5, 0.0), 0, 2, &flat), 0.0);
        assert_eq!(uncovered(&arc(-0.5, 0.0), 0, 2, &flat), 0.0);
        // The rim of an ear: both clusters lie at y > 0, one above the other.
        let rim = meeting(DVec3::Z, -DVec3::Z);
        assert_eq!(uncovered(&arc(-0.5, 0.0), 0, 2, &rim), 0.5);
        assert_eq!(uncovered(&arc(0.5, 0.0), 0, 2, &rim), 0.0);
        // A right-angled ridge: the left cluster is flat at y > 0, the right one goes down from it.
        let ridge = meeting(DVec3::Z, -DVec3::Y);
        assert!((uncovered(&arc(-0.3, 0.4), 0, 2, &ridge) - 0.5).abs() < 1e-6);
        assert_eq!(uncovered(&arc(-0.3, -0.4), 0, 2, &ridge), 0.0);
    }
}
