//! Thin clusters that go around something, whose polygons need enough vertices on each loop.
//!
//! The outline of a flat ring that is drawn with four vertices may lie within its hole that is drawn with six: the
//! polygon then covers the hole and none of the ring. In the order of bounds such clusters count as folded and are
//! split early; in the budget order the loops of thin ones get vertices until no chord takes off, or adds, more than a
//! share of the cluster's area.
//!
//! A collar, a ring that is not closed, may be turned over just so: one chord from end to end takes off more than there
//! is. Its neighbour's polygon goes over what the collar goes around.

use super::cluster_tree::{ClusterTree, Finder};
use super::curves::CurveRecord;
use super::loops::{LAST, split_loops};
use super::uncovered::{STRIP, WORTH, worth_of_strip};
use crate::partition::Subtree;
use fcgeom::Sphere;
use glam::DVec3;
use std::ops::Range;

/// The records that clusters with holes ask for, in the budget order.
pub fn records(tree: ClusterTree<'_>) -> Vec<CurveRecord> {
    tree.records(&Holes { tree })
}

/// Clusters of fewer faces have no holes that matter.
const LEAST_FACES: usize = 8;

/// A cluster is thin if it covers no more than this share of what its largest loop goes around. Others have room for
/// chords, and vertices would cost them more than they mend.
const THIN: f64 = 0.7;

/// A chord may take off, or add, this share of the area of its cluster.
const SHARE: f64 = 0.15;

/// A cluster with one loop may be a collar if the square of its edges on the border is more than so many times the number
/// of its faces; of a square it is eight times that.
const COLLAR: usize = 20;

/// Stretches are halved so often at most.
const MAX_DEPTH: u32 = 6;

struct Holes<'a> {
    tree: ClusterTree<'a>,
}

/// A loop as it is seen along the normal of its cluster's plane.
struct Ring<'a> {
    entries: &'a [u32],
    normal: DVec3,
    /// What a chord may take off or add: twice an area.
    most: f64,
    /// The largest tolerance at which the cluster is drawn.
    key: f32,
    /// Whether a vertex may come later, where it is worth less than that.
    by_worth: bool,
}

impl Finder for Holes<'_> {
    /// For the loops of a node.
    type Memory = Vec<u32>;

    fn look(&self, at: &Subtree, above: f32, memory: &mut Vec<u32>, found: &mut Vec<CurveRecord>) -> bool {
        let has_faces = at.faces.len() >= LEAST_FACES;
        if has_faces {
            self.records_of_node(at, above, memory, found);
        }
        has_faces
    }
}

impl Holes<'_> {
    /// `memory` is for the node's loops.
    fn records_of_node(
        &self,
        at: &Subtree,
        parent_key: f32,
        memory: &mut Vec<u32>,
        out: &mut Vec<CurveRecord>,
    ) {
        let ClusterTree { splits, loops, nodes, .. } = self.tree;
        let node = at.node;
        let is_drawn = nodes[node].budget < parent_key && parent_key.is_finite();
        if !is_drawn || splits[node].joins_components {
            return;
        }
        let entries = loops.read(node, memory);
        let has_holes = entries.iter().rev().skip(1).any(|h| h & LAST != 0);
        let normal = splits[node].normal.as_dvec3();
        if !has_holes {
            if entries.len() * entries.len() > COLLAR * at.faces.len() {
                let most = self.area(entries, 0, entries.len(), normal).abs();
                self.records_of_ring(&Ring { entries, normal, most, key: parent_key, by_worth: true }, out);
            }
            return;
        }
        let areas = || split_loops(entries).map(|ring| self.area(ring, 0, ring.len(), normal));
        let (whole, largest) = (areas().sum::<f64>().abs(), areas().map(f64::abs).fold(0.0, f64::max));
        if whole > THIN * largest {
            return;
        }
        let most = SHARE * whole;
        for entries in split_loops(entries) {
            self.records_of_ring(&Ring { entries, normal, most, key: parent_key, by_worth: false }, out);
        }
    }

    fn records_of_ring(&self, ring: &Ring<'_>, out: &mut Vec<CurveRecord>) {
        let n = ring.entries.len();
        let is_drawn = |i: &usize| self.key(ring.entries, *i) >= ring.key;
        let mut drawn: Vec<usize> = (0..n).filter(is_drawn).collect();
        // A loop of fewer than three is left out as a whole.
        if drawn.len() < 3 {
            return;
        }
        drawn.push(drawn[0] + n);
        for ends in drawn.windows(2) {
            self.records_of_chord(ring, ends[0]..ends[1], 0, out);
        }
    }

    /// Adds the farthest vertex of a chord that is too far from its arc, and those of what is left of it.
    fn records_of_chord(&self, ring: &Ring<'_>, chord: Range<usize>, depth: u32, out: &mut Vec<CurveRecord>) {
        let Range { start, end } = chord;
        if end < start + 2 || depth > MAX_DEPTH {
            return;
        }
        if self.area(ring.entries, start, end, ring.normal).abs() <= ring.most {
            return;
        }
        let (a, b) = (self.place(ring.entries, start), self.place(ring.entries, end));
        let across = ring.normal.cross(b - a);
        let height = |i: usize| (self.place(ring.entries, i) - a).dot(across).abs();
        let farthest = (start + 1..end).map(|i| (i, height(i))).reduce(|x, y| if y.1 > x.1 { y } else { x });
        let Some((farthest, depth_of_strip)) = farthest else { return };
        let mut key = f64::from(ring.key);
        if ring.by_worth {
            let length = (b - a).length();
            let worth = worth_of_strip(STRIP, length, depth_of_strip / length.max(f64::MIN_POSITIVE));
            let next = (start + 1..end).map(|i| self.key(ring.entries, i)).fold(0.0, f32::max);
            if worth <= WORTH * f64::from(next) {
                return;
            }
            key = key.min(worth);
        }
        let points = (start..=end).map(|i| self.place(ring.entries, i).as_vec3());
        out.push(CurveRecord {
            vertex: self.vertex(ring.entries, farthest),
            bound: 0.0,
            budget: key,
            sphere: Sphere::of_points(points),
        });
        self.records_of_chord(ring, start..farthest, depth + 1, out);
        self.records_of_chord(ring, farthest..end, depth + 1, out);
    }

    /// Twice the area between a stretch of a loop and its chord, seen along the normal.
    fn area(&self, ring: &[u32], start: usize, end: usize, normal: DVec3) -> f64 {
        let a = self.place(ring, start);
        let spoke = |i: usize| self.place(ring, i) - a;
        (start + 1..end).map(|i| spoke(i).cross(spoke(i + 1)).dot(normal)).sum()
    }

    fn place(&self, ring: &[u32], i: usize) -> DVec3 {
        self.tree.mesh.positions[self.tree.mesh.origin(ring[i % ring.len()] & !LAST) as usize].as_dvec3()
    }

    /// The vertex's key, as far as it is known.
    fn key(&self, ring: &[u32], i: usize) -> f32 {
        self.tree.keys[self.vertex(ring, i) as usize].budget
    }

    /// The welded vertex.
    fn vertex(&self, ring: &[u32], i: usize) -> u32 {
        self.tree.mesh.weld[self.tree.mesh.origin(ring[i % ring.len()] & !LAST) as usize]
    }
}
