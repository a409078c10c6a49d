//! A walk over the faces around a cluster, within what is seen in a hull.

use super::beyond::Beyond;
use super::gaze::{Gaze, Seen};
use super::hull::{Hull, Side};
use super::node::Cluster;
use super::slab::Slab;
use crate::arcs::loops::LAST;
use crate::mesh::NONE;
use crate::tree_order::TreeMesh;
use glam::DVec3;

/// Cosine of the steepest angle (72.5 degrees) at which a face still counts as surface under a polygon. Steeper ones
/// raise slabs more than a corner costs that keeps the polygon away from them.
const STEEP: f64 = 0.3;

/// A vertex that the flood has come to.
#[derive(Clone, Copy, Debug)]
struct Reached {
    seen: Seen,
    side: Side,
}

/// A face to be looked at.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    /// The half-edge by which the flood comes to it.
    half_edge: u32,
    /// Where that starts and ends: places in the list of what is reached.
    ends: [u32; 2],
}

/// The memory of floods, one after the other.
#[derive(Debug, Default)]
pub(super) struct Flood {
    reached: Vec<Reached>,
    waiting: Vec<Waiting>,
    visited: Visited,
}

/// What a flood goes by.
#[derive(Clone, Copy)]
pub(super) struct Around<'a> {
    pub(super) mesh: &'a TreeMesh,
    pub(super) cluster: &'a Cluster<'a>,
    pub(super) border: Places<'a>,
    pub(super) gaze: Gaze,
    pub(super) hull: &'a Hull,
}

/// The half-edges of a cluster's border by their places: those of one loop, on the first round or the second, and then
/// those of the others, after each of which its first one stands once more.
#[derive(Clone, Copy)]
pub(super) struct Places<'a> {
    pub(super) ring: &'a [u32],
    pub(super) others: &'a [u32],
}

impl Places<'_> {
    #[inline]
    pub(super) fn half_edge(&self, place: usize) -> u32 {
        let n = self.ring.len();
        let entry = if place < n {
            self.ring[place]
        } else if place < 2 * n {
            self.ring[place - n]
        } else {
            self.others[place - 2 * n]
        };
        entry & !LAST
    }
}

/// A stretch of a loop.
#[derive(Clone, Copy)]
pub(super) struct Arc<'a> {
    /// The vertices of the loop, twice around, and of the others.
    pub(super) seen: &'a [Seen],
    /// The places where it starts and ends, on the first round or the second.
    pub(super) ends: (usize, usize),
    /// Places of other edges of the border that come near the arc's hull.
    pub(super) near: &'a [u32],
}

impl Flood {
    /// Widens the slab by what is seen in a hull of the surface beyond the border, which is also collected; false if some of
    /// it is steep, and left out.
    ///
    /// The border itself lies in the slab.
    pub(super) fn look(
        &mut self,
        around: Around<'_>,
        arc: Arc<'_>,
        slab: &mut Slab,
        beyond: &mut Beyond,
    ) -> bool {
        let Around { mesh, cluster, border, gaze, hull } = around;
        let Flood { reached, waiting, visited } = self;
        reached.clear();
        waiting.clear();
        let reach_at = |seen: Seen| Reached { seen, side: hull.side(seen.at) };
        // Beyond an edge of the surface there is nothing; see [`crate::arcs::curves`].
        let across_border = |place: usize| {
            let across = mesh.opposite[border.half_edge(place) as usize];
            (across != NONE).then_some(across)
        };
        let mut wait = |reached: &[Reached], half_edge: u32| {
            let start = reached.len() as u32 - 2;
            waiting.push(Waiting { half_edge, ends: [start + 1, start] });
        };
        if !hull.is_left() {
            let (from, to) = arc.ends;
            let mut follows = None;
            for (place, [p, q]) in (from..to).zip(arc.seen[from..=to].array_windows()) {
                if !hull.reaches_right(p.at, q.at) {
                    continue;
                }
                let Some(across) = across_border(place) else { continue };
                if follows != Some(place) {
                    reached.push(Reached { seen: *p, side: Side::WITHIN });
                }
                follows = Some(place + 1);
                reached.push(Reached { seen: *q, side: Side::WITHIN });
                wait(reached, across);
            }
        }
        // The place after that of the last edge that was near: its start is reached.
        let mut follows = None;
        for &place in arc.near {
            let place = place as usize;
            let Some(across) = across_border(place) else { continue };
            if follows != Some(place) {
                reached.push(reach_at(arc.seen[place]));
            }
            follows = Some(place + 1);
            reached.push(reach_at(arc.seen[place + 1]));
            if let [.., from, to] = reached[..]
                && hull
                    .clip((from.seen.at, from.side), (to.seen.at, to.side))
                    .is_some_and(|part| goes_beyond(hull, &from, &to, part))
            {
                wait(reached, across);
            }
        }
        if waiting.is_empty() {
            return true;
        }
        visited.clear();
        let own = 3 * cluster.faces.start as u32..3 * cluster.faces.end as u32;
        let mut is_covered = true;
        while let Some(Waiting { half_edge, ends: [p, q] }) = waiting.pop() {
            let face = half_edge / 3;
            if !visited.insert(face) {
                continue;
            }
            let normal = mesh.face_normals[face as usize].as_dvec3();
            // A face without area is a line, whichever way it is seen.
            if normal.dot(slab.direction) < STEEP && normal != DVec3::ZERO {
                is_covered = false;
                continue;
            }
            let first = 3 * face;
            let (after, before) = match half_edge - first {
                0 => (first + 1, first + 2),
                1 => (first + 2, first),
                _ => (first, first + 1),
            };
            if beyond.is_wanted() {
                add_clipped(hull, [&reached[p as usize], &reached[q as usize]], beyond);
            }
            let apex = reach_at(gaze.see(mesh.positions[mesh.origin(before) as usize].as_dvec3()));
            if apex.side.is_in() {
                slab.add(apex.seen.height);
                beyond.add(apex.seen);
            }
            let place = reached.len() as u32;
            let mut look_across = |edge: u32, from: &Reached, to: &Reached, ends: [u32; 2]| {
                if reach(hull, from, to, slab, beyond) {
                    let across = mesh.opposite[edge as usize];
                    if across != NONE && !own.contains(&across) && !visited.has(across / 3) {
                        waiting.push(Waiting { half_edge: across, ends });
                        return true;
                    }
                }
                false
            };
            let goes_on = look_across(after, &reached[q as usize], &apex, [place, q])
                | look_across(before, &apex, &reached[p as usize], [p, place]);
            if goes_on {
                reached.push(apex);
            }
            beyond.end_part();
        }
        is_covered
    }
}

/// Widens the slab by the part of an edge that lies in the hull. Returns whether there is such a part, and some of the
/// hull to the right of it.
#[inline]
fn reach(hull: &Hull, from: &Reached, to: &Reached, slab: &mut Slab, beyond: &mut Beyond) -> bool {
    let Some((start, end)) = hull.clip((from.seen.at, from.side), (to.seen.at, to.side)) else {
        return false;
    };
    for (share, end) in [(start, from), (end, to)] {
        if !end.side.is_in() {
            let seen = between(from, to, share);
            slab.add(seen.height);
            beyond.add(seen);
        }
    }
    goes_beyond(hull, from, to, (start, end))
}

/// Adds the ends of the part of an edge that lies in the hull.
fn add_clipped(hull: &Hull, [from, to]: [&Reached; 2], beyond: &mut Beyond) {
    if let Some((start, end)) = hull.clip((from.seen.at, from.side), (to.seen.at, to.side)) {
        for (share, end) in [(start, from), (end, to)] {
            beyond.add(if end.side.is_in() { end.seen } else { between(from, to, share) });
        }
    }
}

/// A point of an edge.
#[inline]
fn between(from: &Reached, to: &Reached, share: f64) -> Seen {
    let (from, to) = (from.seen, to.seen);
    Seen { at: from.at + (to.at - from.at) * share, height: from.height + (to.height - from.height) * share }
}

/// Whether some of the hull lies to the right of an edge, of which a part lies in the hull.
#[inline]
fn goes_beyond(hull: &Hull, from: &Reached, to: &Reached, (start, end): (f64, f64)) -> bool {
    let crosses = from.side.is_deep() || to.side.is_deep();
    crosses || (start < end && hull.reaches_right(from.seen.at, to.seen.at))
}

/// A set of faces that is emptied at once.
///
/// Most floods come to a handful of faces, a few to thousands: the part of the table that is in use grows with them and
/// starts anew, so that small ones stay in a corner of the memory.
#[derive(Debug)]
struct Visited {
    /// Faces near the place that their number comes to, below the round in which each came.
    slots: Vec<u64>,
    /// The last of the slots in use, whose number is a power of two; at most half of them are full.
    last: usize,
    /// A product with so many bits cut off is a slot in use.
    cut: u32,
    round: u32,
    faces: Vec<u32>,
}

/// The logarithm of the least number of slots.
const LEAST: u32 = 6;

impl Default for Visited {
    fn default() -> Visited {
        let slots = vec![0; 1 << LEAST];
        Visited { last: slots.len() - 1, slots, cut: u32::BITS - LEAST, round: 1, faces: Vec::new() }
    }
}

impl Visited {
    fn clear(&mut self) {
        self.faces.clear();
        self.last = (1 << LEAST) - 1;
        self.cut = u32::BITS - LEAST;
        self.next_round();
    }

    /// Empties all slots.
    fn next_round(&mut self) {
        self.round = self.round.wrapping_add(1);
        if self.round == 0 {
            self.slots.fill(0);
            self.round = 1;
        }
    }

    /// What stands for a face.
    #[inline]
    fn entry(&self, face: u32) -> u64 {
        u64::from(self.round) << 32 | u64::from(face)
    }

    /// Where a face is, or where it would be, and whether it is there.
    #[inline]
    fn place(&self, face: u32) -> (usize, bool) {
        let entry = self.entry(face);
        // Faces come in runs of near numbers, and runs in the same slots would make long ones: a product with the golden
        // ratio sets them apart.
        let mut place = (face.wrapping_mul(0x9E37_79B9) >> self.cut) as usize;
        loop {
            let differs = self.slots[place] ^ entry;
            if differs == 0 || differs >> 32 != 0 {
                return (place, differs == 0);
            }
            place = (place + 1) & self.last;
        }
    }

    #[inline]
    fn has(&self, face: u32) -> bool {
        self.place(face).1
    }

    /// Whether the face is new.
    #[inline]
    fn insert(&mut self, face: u32) -> bool {
        let (place, is_there) = self.place(face);
        if is_there {
            return false;
        }
        self.slots[place] = self.entry(face);
        self.faces.push(face);
        if self.faces.len() > self.last / 2 {
            self.grow();
        }
        true
    }

    #[cold]
    fn grow(&mut self) {
        self.last = 2 * self.last + 1;
        self.cut -= 1;
        if self.slots.len() <= self.last {
            self.slots.resize(self.last + 1, 0);
        }
        self.next_round();
        for i in 0..self.faces.len() {
            let (place, _) = self.place(self.faces[i]);
            self.slots[place] = self.entry(self.faces[i]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn faces_are_visited_once_a_round() {
        let mut visited = Visited::default();
        let mut state = 1_u64;
        for round in 0..50 {
            visited.clear();
            let mut expected = HashSet::new();
            for _ in 0..10 * round {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let face = (state >> 40) as u32 % 1000 * 64;
                assert_eq!(visited.has(face), expected.contains(&face));
                assert_eq!(visited.insert(face), expected.insert(face));
            }
        }
    }
}
