//! How far the surface around a cluster's border is from the polygon that may lie over it.
//!
//! Between two corners the border is an arc, and the polygon has a chain of chords there, whose ends lie on the arc:
//! whichever vertices are drawn, the chain stays in the convex hull of the arc. Seen along the direction of the
//! cluster's slab, polygon and cluster therefore differ only in these hulls. What of the surface is seen in a hull counts
//! into the slab, also where it belongs to neighbours: the polygon may lie over it, and it may be left to this polygon to
//! cover. `docs/bound.md` has the argument.

use super::beyond::Beyond;
use super::flood::{Arc, Around, Flood, Places};
use super::gaze::{Gaze, Seen};
use super::hull::Hull;
use super::node::{Above, Cluster};
use super::slab::Slab;
use crate::arcs::loops::{LAST, split_loops};
use crate::tree_order::TreeMesh;
use fcgeom::distance_to_segment;
use glam::{DVec2, DVec3, Vec4};
use std::ops::Range;

/// An arc over a steep place is left as it is if that raises the cluster's bound to at most so many times the height of
/// its slab, or to at most [`SHARE`]; else it gets a corner more. Less means more corners, more means larger bounds:
/// between 1.8 and 2.2 the number of triangles hardly changes.
const RAISE_UP_TO: f64 = 2.0;

/// The share of the bound of the node above that a cluster's may be raised to: corners that it gets for less are drawn in
/// meshes that are much coarser than it. A flat disc would get all of its rim.
const SHARE: f64 = 0.2;

/// By what part of the height of its slab an arc may reach beyond the chord of the next one: polygons overlap themselves by
/// as much at a corner.
const DEEP: f64 = 0.5;

/// Looks at clusters, one after the other in the same memory.
#[derive(Debug, Default)]
pub(super) struct Overhang {
    /// Where vertices of the border are seen, by their [`Places`]: those of one loop, twice around, and of the others.
    seen: Vec<Seen>,
    /// The same as four numbers each, see [`spot`].
    spots: Vec<Vec4>,
    /// The least of the spots of runs of [`RUN`] edges of the loop.
    runs: Vec<Vec4>,
    /// The half-edges of the other loops, and runs of their edges with the least of the spots of each.
    others: Vec<u32>,
    other_runs: Vec<(Vec4, Range<usize>)>,
    /// Places of edges of the border that come near the hull of an arc, without those of the arc.
    near: Vec<u32>,
    /// Places on the loop of the corners, ascending from the first one; the last is the first again, a turn on.
    corners: Vec<usize>,
    /// Half-edges that start at vertices to be corners too.
    added: Vec<u32>,
    beyond: Beyond,
    hull: Hull,
    flood: Flood,
}

/// What is found.
pub(super) struct Found<'a> {
    /// Half-edges of the cluster's loops that start at vertices which the node above must make corners.
    pub(super) added: &'a [u32],
    /// What is seen in the hulls of arcs, if it was asked for.
    pub(super) beyond: &'a Beyond,
}

/// A loop of a cluster's border.
struct Border<'a> {
    mesh: &'a TreeMesh,
    at: &'a Cluster<'a>,
    ring: &'a [u32],
}

impl Border<'_> {
    fn len(&self) -> usize {
        self.ring.len()
    }

    fn half_edge(&self, place: usize) -> u32 {
        Places { ring: self.ring, others: &[] }.half_edge(place)
    }

    fn is_corner(&self, place: usize) -> bool {
        self.at.registered[self.half_edge(place) as usize - 3 * self.at.faces.start]
    }

    fn position(&self, place: usize) -> DVec3 {
        self.mesh.positions[self.mesh.origin(self.half_edge(place)) as usize].as_dvec3()
    }

    /// The place of an arc that is farthest from the arc's chord.
    fn farthest(&self, from: usize, to: usize) -> usize {
        let (a, b) = (self.position(from), self.position(to));
        let off = |place: usize| (place, distance_to_segment(self.position(place), a, b));
        (from + 1..to).map(off).fold((from, -1.0), |best, x| if x.1 > best.1 { x } else { best }).0
    }
}

/// Edges of a border in one run: a hull that is far from a run is far from all of them.
const RUN: usize = 16;

/// A border of no more edges is not divided into runs.
const FEW: usize = 2 * RUN;

/// Where a point is seen as what can be compared at once with all four sides of a box: the larger, the farther to the
/// right and up, and to the left and down.
///
/// Rounding to single precision keeps the order: what is greater when rounded is greater.
#[inline]
fn spot(at: DVec2) -> Vec4 {
    let at = at.as_vec2();
    Vec4::new(at.x, at.y, -at.x, -at.y)
}

impl Overhang {
    /// Widens the slab of a cluster by what is seen in the hulls of its arcs, for which the node `above` must make some
    /// vertices corners.
    ///
    /// Of a cluster with several loops each must have a corner, and there must be such a node.
    pub(super) fn widen(
        &mut self,
        mesh: &TreeMesh,
        at: &Cluster<'_>,
        slab: &mut Slab,
        above: Above,
        wants_beyond: bool,
    ) -> Found<'_> {
        self.added.clear();
        self.beyond.clear(wants_beyond);
        let narrow = *slab;
        let mut start = 0;
        for ring in split_loops(at.loops) {
            let end = start + ring.len();
            let others = [&at.loops[..start], &at.loops[end..]];
            self.widen_by_loop(&Border { mesh, at, ring }, others, (narrow, slab), above);
            start = end;
        }
        Found { added: &self.added, beyond: &self.beyond }
    }

    /// The same for one of the loops; `others` are those before it and those after it.
    fn widen_by_loop(
        &mut self,
        border: &Border<'_>,
        others: [&[u32]; 2],
        (narrow, slab): (Slab, &mut Slab),
        above: Above,
    ) {
        let n = border.len();
        self.corners.clear();
        self.corners.extend((0..n).filter(|&place| border.is_corner(place)));
        if self.corners.len() < n && !self.corners.is_empty() {
            let gaze = Gaze::along(slab.direction);
            self.seen.clear();
            self.seen.extend((0..n).map(|place| gaze.see(border.position(place))));
            self.seen.extend_from_within(..);
            self.spots.clear();
            self.spots.extend(self.seen.iter().map(|seen| spot(seen.at)));
            self.runs.clear();
            if n > FEW {
                let least = |run: &[Vec4]| run.iter().fold(Vec4::INFINITY, |least, spot| least.min(*spot));
                let runs = (0..n).step_by(RUN).map(|first| least(&self.spots[first..=n.min(first + RUN)]));
                self.runs.extend(runs);
            }
            self.others.clear();
            self.other_runs.clear();
            for ring in others.into_iter().flat_map(split_loops) {
                self.add_other(border.mesh, ring, gaze);
            }
            self.corners.push(self.corners[0] + n);
            self.widen_by_arcs(border, gaze, (narrow, slab), above);
        }
    }

    /// Adds another loop to what may be seen in the hulls of arcs.
    fn add_other(&mut self, mesh: &TreeMesh, ring: &[u32], gaze: Gaze) {
        let first = self.spots.len();
        for h in ring.iter().chain(ring.first()) {
            let seen = gaze.see(mesh.positions[mesh.origin(h & !LAST) as usize].as_dvec3());
            self.seen.push(seen);
            self.spots.push(spot(seen.at));
            self.others.push(*h);
        }
        for start in (0..ring.len()).step_by(RUN) {
            let run = first + start..first + ring.len().min(start + RUN);
            let least = self.spots[run.start..=run.end].iter().fold(Vec4::INFINITY, |a, b| a.min(*b));
            self.other_runs.push((least, run));
        }
    }

    fn widen_by_arcs(
        &mut self,
        border: &Border<'_>,
        gaze: Gaze,
        (narrow, slab): (Slab, &mut Slab),
        above: Above,
    ) {
        let n = border.len();
        let height = narrow.height();
        let (gets_corners, raise_up_to) = match above {
            Above::Nothing => (false, f64::INFINITY),
            Above::NeverDrawn => (true, RAISE_UP_TO * height),
            Above::Drawn(bound) => (true, (RAISE_UP_TO * height).max(SHARE * bound)),
        };
        let mut i = 0;
        while let [from, to, ..] = self.corners[i..] {
            if to == from + 1 {
                i += 1;
                continue;
            }
            self.hull.surround(self.seen[from..=to].iter().map(|seen| seen.at));
            if !self.hull.has_area() {
                i += 1;
                continue;
            }
            if self.find_near(i, n, gets_corners.then_some(DEEP * height)) {
                self.add_corner(border, i + 1, border.farthest(from, to));
                continue;
            }
            if self.hull.is_left() && self.near.is_empty() {
                i += 1;
                continue;
            }
            self.hull.find_edges();
            let mut wide = *slab;
            let places = Places { ring: border.ring, others: &self.others };
            let around =
                Around { mesh: border.mesh, cluster: border.at, border: places, gaze, hull: &self.hull };
            let arc = Arc { seen: &self.seen, ends: (from, to), near: &self.near };
            let before = self.beyond.mark();
            if !self.flood.look(around, arc, &mut wide, &mut self.beyond) {
                let arc = self.seen[from..=to].iter().map(|seen| seen.height);
                let distance = self.aside(from, to).hypot(narrow.reach(arc));
                if distance > raise_up_to {
                    self.beyond.truncate(before);
                    self.add_corner(border, i + 1, border.farthest(from, to));
                    continue;
                }
                wide.raise(distance);
            }
            *slab = wide;
            i += 1;
        }
    }

    /// Finds the edges of the border that come near the hull of an arc, and whether the arc is tangled, which ends it.
    ///
    /// It is if a vertex of an arc that does not meet it is seen in its hull: if none is, then chains of different arcs do
    /// not cross, and the polygon does not overlap itself. Arcs that meet mostly reach into each other's hulls near their
    /// common corner; there a vertex counts that lies beyond the chord by more than `deep`. Not asked without that. Arcs of
    /// other loops never meet it.
    fn find_near(&mut self, arc: usize, n: usize, deep: Option<f64>) -> bool {
        let Overhang { seen, spots, runs, other_runs, near, corners, hull, .. } = self;
        let count = corners.len() - 1;
        // Places count from the turn in which the arc starts.
        let turn = if corners[arc] < n { 0 } else { n };
        let corner = |i: usize| if i < count { corners[i] - turn } else { corners[i - count] + n - turn };
        let (from, to) = (corner(arc), corner(arc + 1));
        // The ends of the arcs before and after.
        let next = corner(arc + 2).min(from + n);
        let last = corner(arc + count - 1).max(to);
        let (a, b) = (seen[from].at, seen[to].at);
        let limits = hull.limits();
        let beyond = |spot: Vec4| spot.cmpgt(limits).bitmask();
        near.clear();
        let mut is_tangled = |edges: Range<usize>, own: bool| {
            let mut before = beyond(spots[edges.start]);
            for (place, spot) in (edges.start + 1..).zip(&spots[edges.start + 1..=edges.end]) {
                let here = beyond(*spot);
                if before & here == 0 && hull.is_near(seen[place - 1].at, seen[place].at) {
                    near.push(place as u32 - 1);
                }
                before = here;
                if here == 0
                    && (place < from + n || !own)
                    && let Some(deep) = deep
                {
                    let p = seen[place].at;
                    let meets = own && (place <= next || place >= last);
                    let is_aside = || (b - a).perp_dot(p - a) < -deep * (b - a).length();
                    if hull.holds(p) && (!meets || is_aside()) {
                        return true;
                    }
                }
            }
            false
        };
        for (least, run) in other_runs.iter() {
            if !least.cmpgt(limits).any() && is_tangled(run.clone(), false) {
                return true;
            }
        }
        if runs.is_empty() {
            return is_tangled(to..from + n, true);
        }
        let near_runs = runs.iter().enumerate().filter(|(_, least)| !least.cmpgt(limits).any());
        near_runs.map(|(run, _)| RUN * run..n.min(RUN * run + RUN)).any(|run| {
            [run.clone(), run.start + n..run.end + n].into_iter().any(|run| {
                let others = run.start.max(to)..run.end.min(from + n);
                !others.is_empty() && is_tangled(others, true)
            })
        })
    }

    /// How far, as they are seen, a point in the hull of an arc may be from any curve in the hull that joins the arc's
    /// ends: across the chord all such curves pass between the arc's farthest vertices to the left and to the right.
    fn aside(&self, from: usize, to: usize) -> f64 {
        let (a, b) = (self.seen[from].at, self.seen[to].at);
        let along = (b - a).normalize_or_zero();
        let (mut left, mut right, mut beyond) = (0.0_f64, 0.0_f64, 0.0_f64);
        for seen in &self.seen[from..=to] {
            let way = seen.at - a;
            let across = along.perp_dot(way);
            (left, right) = (left.max(across), right.max(-across));
            let past = way - along * way.dot(along).clamp(0.0, (b - a).length());
            beyond = beyond.max(past.length());
        }
        beyond.max(left + right)
    }

    /// Makes a place of the border the corner at `index`.
    fn add_corner(&mut self, border: &Border<'_>, index: usize, place: usize) {
        self.added.push(border.half_edge(place));
        self.corners.insert(index, place);
    }
}
