//! Points of arcs that lie beyond the polygons on both sides of a chord, and what it is worth to draw them.

use super::activity::Activity;
use super::curves::CurveRecord;
use super::polyline::{Chord, Raised};
use crate::bounds::NodeBounds;
use fcgeom::{Sphere, offset_from_segment};
use glam::{DVec3, Vec3};

/// Which of its two keys a node or a vertex goes by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Order {
    Bound,
    Budget,
}

impl Order {
    pub(super) fn of_node(self, node: &NodeBounds) -> f64 {
        f64::from(match self {
            Order::Bound => node.bound,
            Order::Budget => node.budget,
        })
    }

    pub(super) fn of_vertex(self, vertex: &Activity) -> f64 {
        f64::from(match self {
            Order::Bound => vertex.bound,
            Order::Budget => vertex.budget,
        })
    }

    /// Where a vertex is drawn, if that is promised.
    pub(super) fn sphere_of(self, vertex: &Activity) -> Sphere {
        match self {
            Order::Bound => vertex.sphere,
            Order::Budget => Sphere::EMPTY,
        }
    }

    /// What a vertex is raised to.
    pub(super) fn record(self, vertex: u32, raised: &Raised) -> CurveRecord {
        let (bound, budget) = match self {
            Order::Bound => (raised.key, 0.0),
            Order::Budget => (0.0, raised.key),
        };
        CurveRecord { vertex, bound, budget, sphere: raised.sphere }
    }
}

/// Two clusters that meet along a chord for tolerances in [from, below), with a ridge or a fold between them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    pub(super) from: f64,
    pub(super) below: f64,
    /// Normal of the plane on either side; zero if that cluster's bound needs no covering.
    pub(super) normals: [DVec3; 2],
}

/// Cosine of the angle (20 degrees) between planes up to which an arc is taken to be covered: a point in both slabs
/// and beyond both polygons is at most 1 / cos(10 degrees) times the larger bound from the chord.
pub(super) const FLAT: f64 = 0.94;

/// Cosine of the angle (120 degrees) between planes from which on a chord must be near its arc on either side: the
/// clusters fold back, and a polygon that juts out beyond the arc has no surface under it.
const FOLDED: f64 = -0.5;

/// What the squared error of a strip comes to, over its length and the cube of its depth, for each triangle that a
/// vertex more costs.
///
/// Over a parabola the square of the distance from the chord sums up to 0.15 times both, and both sheets of a flap
/// have such a strip; a vertex brings two triangles, and the cost of a merge is per triangle and one. Half of that is
/// best in the mean: the vertex leaves strips behind.
pub(super) const STRIP: f64 = 0.05;

/// A vertex is not worth a key that is larger than the next one by less than this factor: it comes soon anyway.
pub(super) const WORTH: f64 = 1.4;

/// The same for a vertex of a flap, by what it is worth. Its key may be less: clusters that fold back often meet at few
/// tolerances.
const WORTH_OF_FLAP: f64 = 1.2;

/// What a vertex is worth in the budget order that keeps a strip of such a length and depth, both lengths, of which
/// `share` of their product with the square of the depth counts: the fourth root of an area times a squared distance, as
/// the keys of merges are.
pub(super) fn worth_of_strip(share: f64, length: f64, depth: f64) -> f64 {
    (share * length * depth * depth * depth).sqrt().sqrt()
}

/// The point of largest key for a chord among those that lie beyond the polygons on both sides of it, and its key:
/// its distance or what that is worth, but not over the tolerance up to which those polygons are drawn. None if all
/// points are covered.
pub(super) fn uncovered(
    order: Order,
    points: &[Vec3],
    chord: Chord,
    meetings: &mut Vec<Meeting>,
    find: impl FnOnce(f64, &mut Vec<Meeting>),
) -> Option<(usize, f64)> {
    let (a, b) = (points[chord.from].as_dvec3(), points[chord.to].as_dvec3());
    let along = b - a;
    let length = along.length();
    let least = if order == Order::Bound { chord.lowest } else { WORTH_OF_FLAP * chord.lowest };
    let mut worst = (0, chord.lowest);
    let mut find = Some(find);
    for (i, p) in points.iter().enumerate().take(chord.to).skip(chord.from + 1) {
        let offset = offset_from_segment(p.as_dvec3(), a, b);
        let distance = offset.length();
        let key = match order {
            Order::Bound => distance,
            Order::Budget => worth_of_strip(STRIP, length, distance),
        };
        if key <= worst.1.max(least) {
            continue;
        }
        if let Some(find) = find.take() {
            find(chord.lowest, meetings);
        }
        for m in &*meetings {
            // The left cluster lies to the left of the chord in its plane, the other one to the right.
            let into_left = m.normals[0].cross(along);
            let into_right = along.cross(m.normals[1]);
            let counts = m.normals.contains(&DVec3::ZERO)
                || m.normals[0].dot(m.normals[1]) < FOLDED
                || (offset.dot(into_left) <= 0.0 && offset.dot(into_right) <= 0.0);
            let at = key.min(m.below);
            if counts && key > m.from && at > worst.1 {
                worst = (i, at);
            }
        }
    }
    (worst.0 > 0).then_some(worst)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meeting(a: DVec3, b: DVec3) -> Meeting {
        Meeting { from: 0.0, below: 9.0, normals: [a, b] }
    }

    fn uncovered(points: &[Vec3], meeting: &Meeting) -> f64 {
        let chord = Chord { from: 0, to: 2, lowest: 0.0, highest: 9.0 };
        let [distance, worth] = [Order::Bound, Order::Budget].map(|order| {
            super::uncovered(order, points, chord, &mut Vec::new(), |_, out| out.push(*meeting))
                .map_or(0.0, |worst| worst.1)
        });
        assert_eq!(distance > 0.0, worth > 0.0);
        distance
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
