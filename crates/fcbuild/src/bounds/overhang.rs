//! How far the surface around a cluster's border is from the polygon that may lie over it.
//!
//! Between two corners the border is an arc, and the polygon has a chain of chords there, whose ends lie on the arc:
//! whichever vertices are drawn, the chain stays in the convex hull of the arc. Seen along the direction of the
//! cluster's slab, polygon and cluster therefore differ only in these hulls. What of the surface is seen in a hull counts
//! into the slab, also where it belongs to neighbours: the polygon may lie over it, and it may be left to this polygon to
//! cover. `docs/bound.md` has the argument.

use super::distance::Slab;
use super::hull::Hull;
use super::node::Cluster;
use crate::arcs::loops::LAST;
use crate::arcs::polyline;
use crate::mesh::NONE;
use crate::tree_order::TreeMesh;
use glam::{DVec2, DVec3};
use std::collections::HashSet;

/// Cosine of the steepest angle (60 degrees) at which a face still counts as surface under a polygon. Steeper ones raise
/// slabs more than a corner costs that keeps the polygon away from them.
const STEEP: f64 = 0.5;

/// An arc over a steep place is left as it is if it is at most so many times the cluster's bound from its chord, and
/// the bound is raised to that; else it gets a corner more. Less means more corners, more means larger bounds: between
/// 1.2 and 2 the number of triangles hardly changes.
const RAISE_UP_TO: f64 = 1.5;

/// By what part of the cluster's bound an arc may reach beyond the chord of the next one: polygons overlap themselves by
/// as much at a corner.
const DEEP: f64 = 0.5;

/// Looks at clusters, one after the other in the same memory.
#[derive(Debug, Default)]
pub(super) struct Overhang {
    /// Of the border's vertices: where they are seen.
    seen: Vec<DVec2>,
    /// Places on the border of the corners, ascending from the first one; beyond the border's end they go on around it.
    corners: Vec<usize>,
    /// Half-edges that start at vertices to be corners too.
    added: Vec<u32>,
    hull: Hull,
    flood: Flood,
}

/// A cluster's only loop, and how it is seen.
struct Border<'a> {
    mesh: &'a TreeMesh,
    at: &'a Cluster<'a>,
    x: DVec3,
    y: DVec3,
}

impl Border<'_> {
    fn len(&self) -> usize {
        self.at.loops.len()
    }

    fn half_edge(&self, place: usize) -> u32 {
        self.at.loops[place % self.len()] & !LAST
    }

    fn is_corner(&self, place: usize) -> bool {
        self.at.registered[self.half_edge(place) as usize - 3 * self.at.faces.start]
    }

    fn position(&self, place: usize) -> DVec3 {
        self.mesh.positions[self.mesh.origin(self.half_edge(place)) as usize].as_dvec3()
    }

    fn project(&self, p: DVec3) -> DVec2 {
        DVec2::new(self.x.dot(p), self.y.dot(p))
    }

    /// The place of an arc that is farthest from the arc's chord, and its distance.
    fn farthest(&self, from: usize, to: usize) -> (usize, f64) {
        let (a, b) = (self.position(from), self.position(to));
        let off = |place: usize| (place, polyline::distance_to_segment(self.position(place), a, b));
        (from + 1..to).map(off).fold((from, -1.0), |best, x| if x.1 > best.1 { x } else { best })
    }
}

impl Overhang {
    /// Widens the slab of a cluster with one loop by what is seen in the hulls of its arcs. Returns half-edges of the
    /// loop that start at vertices which must be corners for that, none unless `may_add`.
    pub(super) fn widen(
        &mut self,
        mesh: &TreeMesh,
        at: &Cluster<'_>,
        slab: &mut Slab,
        may_add: bool,
    ) -> &[u32] {
        let (x, y) = fcgeom::tangent_frame(slab.direction);
        let border = Border { mesh, at, x, y };
        let n = border.len();
        self.added.clear();
        self.corners.clear();
        self.corners.extend((0..n).filter(|&place| border.is_corner(place)));
        if self.corners.len() < n && !self.corners.is_empty() {
            self.seen.clear();
            self.seen.extend((0..n).map(|place| border.project(border.position(place))));
            if may_add {
                self.untangle(&border, DEEP * slab.bound());
            }
            self.corners.push(self.corners[0] + n);
            self.widen_by_arcs(&border, slab, may_add);
        }
        &self.added
    }

    /// Adds corners until no vertex of an arc is seen in the hull of another that does not meet it: then chains of
    /// different arcs do not cross, and the polygon does not overlap itself. Arcs that meet mostly reach into each other's
    /// hulls near their common corner; there a vertex counts that lies beyond the chord by more than `deep`.
    fn untangle(&mut self, border: &Border<'_>, deep: f64) {
        let n = border.len();
        let mut i = 0;
        while i < self.corners.len() {
            let count = self.corners.len();
            let corner = |i: usize| self.corners[i % count] + i / count * n;
            let (from, to) = (corner(i), corner(i + 1));
            self.hull.surround((from..=to).map(|place| self.seen[place % n]));
            let (a, b) = (self.seen[from % n], self.seen[to % n]);
            let next = to..=corner(i + 2).min(from + n);
            let last = corner(i + count - 1).max(to)..=from + n;
            let is_tangled = |place: usize| {
                let p = self.seen[place % n];
                let meets = next.contains(&place) || last.contains(&place);
                let is_beyond = || (b - a).perp_dot(p - a) < -deep * (b - a).length();
                self.hull.holds(p) && (!meets || is_beyond())
            };
            if to > from + 1 && self.hull.has_area() && (to + 1..from + n).any(is_tangled) {
                let (far, _) = border.farthest(from, to);
                self.add_corner(border, i + 1, far);
            } else {
                i += 1;
            }
        }
    }

    /// Makes a place of the border the corner at `index`.
    fn add_corner(&mut self, border: &Border<'_>, index: usize, place: usize) {
        self.added.push(border.half_edge(place));
        self.corners.insert(index, place);
    }

    fn widen_by_arcs(&mut self, border: &Border<'_>, slab: &mut Slab, may_add: bool) {
        let n = border.len();
        let narrow = slab.bound();
        let mut i = 0;
        while i + 1 < self.corners.len() {
            let (from, to) = (self.corners[i], self.corners[i + 1]);
            if to > from + 1 {
                self.hull.surround((from..=to).map(|place| self.seen[place % n]));
                let mut wide = *slab;
                if !self.flood.look(border, &self.seen, &self.hull, &mut wide) {
                    let (far, distance) = border.farthest(from, to);
                    if may_add && distance > RAISE_UP_TO * narrow {
                        self.add_corner(border, i + 1, far);
                        continue;
                    }
                    wide.raise(distance);
                }
                *slab = wide;
            }
            i += 1;
        }
    }
}

/// A walk over the faces around a cluster, from its border on.
#[derive(Debug, Default)]
struct Flood {
    waiting: Vec<u32>,
    visited: Visited,
}

impl Flood {
    /// Widens the slab by what is seen in a hull of the surface beyond the border; false if some of it is steep, and left
    /// out.
    fn look(&mut self, border: &Border<'_>, seen: &[DVec2], hull: &Hull, slab: &mut Slab) -> bool {
        let Border { mesh, at, .. } = *border;
        let Flood { waiting, visited } = self;
        if !hull.has_area() {
            return true;
        }
        waiting.clear();
        visited.clear();
        for (place, p) in seen.iter().enumerate() {
            let q = seen[if place + 1 == seen.len() { 0 } else { place + 1 }];
            let across = mesh.opposite[border.half_edge(place) as usize];
            // Beyond an edge of the surface there is nothing; see [`crate::arcs::curves`].
            if across != NONE && hull.clip(*p, q).is_some() && hull.reaches_right(*p, q) {
                waiting.push(across / 3);
            }
        }
        let mut is_covered = true;
        while let Some(face) = waiting.pop() {
            if !visited.insert(face) {
                continue;
            }
            let normal = mesh.face_normals[face as usize].as_dvec3();
            // A face without area is a line, whichever way it is seen.
            if normal != DVec3::ZERO && normal.dot(slab.direction) < STEEP {
                is_covered = false;
                continue;
            }
            let corners = mesh.faces[face as usize].map(|v| mesh.positions[v as usize].as_dvec3());
            let corners = corners.map(|p| (border.project(p), slab.direction.dot(p)));
            for (edge, (p, p_height)) in corners.into_iter().enumerate() {
                let (q, q_height) = corners[(edge + 1) % 3];
                let Some((from, to)) = hull.clip(p, q) else { continue };
                for share in [from, to] {
                    slab.add(p_height + (q_height - p_height) * share);
                }
                let across = mesh.opposite[3 * face as usize + edge];
                let is_beyond = across != NONE && !at.faces.contains(&(across as usize / 3));
                if is_beyond && from < to && hull.reaches_right(p, q) {
                    waiting.push(across / 3);
                }
            }
        }
        is_covered
    }
}

/// Faces that a flood has come by: mostly a handful.
#[derive(Debug, Default)]
struct Visited {
    few: Vec<u32>,
    many: HashSet<u32>,
}

impl Visited {
    const FEW: usize = 32;

    fn clear(&mut self) {
        self.few.clear();
        self.many.clear();
    }

    /// Whether the face is new.
    fn insert(&mut self, face: u32) -> bool {
        if self.few.contains(&face) {
            return false;
        }
        if self.few.len() < Visited::FEW {
            self.few.push(face);
            return true;
        }
        self.many.insert(face)
    }
}
