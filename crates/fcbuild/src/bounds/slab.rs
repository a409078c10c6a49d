//! A cluster between two planes: how high it is along a direction that all its faces face.
//!
//! The corners of its polygon lie on the cluster's border, whichever of them are drawn. Along a direction in which no face
//! of the cluster is seen from behind, the cluster covers its outline once; with its own extent [lo, hi] and its
//! border's [bl, bh] along that direction, surface and polygon are at most max(hi - bl, bh - lo) apart there. Around the
//! border more of the surface counts, see [`super::overhang`].

use super::slack::Slack;
use fcgeom::Quads;
use fct::FineNormalRecord;
use glam::{DVec3, Vec3};
use std::ops::Range;

/// Cosine above which a face counts as facing a direction: about 89.4 degrees, so that rounding cannot turn it.
pub(super) const MIN_FACING: f32 = 0.01;

/// 1 / cos(10 degrees): how much farther than either slab a point can be from a chord between two polygons that meet
/// at up to 20 degrees. Steeper meetings keep their vertices besides, see [`crate::arcs::flaps`].
pub(crate) const RIDGE: f64 = 1.0155;

/// How much larger bounds are than what is measured: room for vertices that are drawn beside their places. Without any
/// nearly all of them would have to stay; twice as much lets them go hardly farther.
pub(super) const EASE: f64 = 1.03;

/// A cluster along one direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slab {
    /// The direction as it is kept.
    stored: FineNormalRecord,
    /// Unit length.
    pub(super) direction: DVec3,
    /// Heights between which the cluster's border lies, and with it every polygon.
    border: (f64, f64),
    /// Heights between which the cluster lies, and what else its polygon may lie over.
    extent: (f64, f64),
    /// What the bound is at least.
    least: f64,
    /// How far the surface may be above the polygon, and the polygon above the surface, if that is known to be less.
    supported: Option<[f64; 2]>,
}

impl Slab {
    /// How far polygon and surface may be from each other along its direction.
    pub(super) fn height(&self) -> f64 {
        let [above, below] = self.apart();
        above.max(below)
    }

    /// How far the surface may be above the polygon, and the polygon above the surface.
    pub(super) fn apart(&self) -> [f64; 2] {
        self.supported.unwrap_or([self.extent.1 - self.border.0, self.border.1 - self.extent.0])
    }

    /// Takes what was measured between planes that lean for what it may be.
    pub(super) fn support(&mut self, apart: [f64; 2]) {
        self.supported = Some(apart);
    }

    /// From the lowest to the highest of what it holds.
    pub(super) fn thickness(&self) -> f64 {
        self.extent.1.max(self.border.1) - self.extent.0.min(self.border.0)
    }

    /// How far cluster and polygon may be along its direction from points of some heights.
    pub(super) fn reach(&self, heights: impl Iterator<Item = f64>) -> f64 {
        heights.map(|h| (self.extent.1 - h).max(h - self.extent.0)).fold(0.0, f64::max)
    }

    /// How far polygon and surface may be from each other.
    pub(super) fn bound(&self) -> f64 {
        EASE * (self.height() * RIDGE).max(self.least)
    }

    /// What the bound leaves to displaced vertices.
    pub(super) fn slack(&self) -> Slack {
        let along = self.bound() / RIDGE;
        let [above, below] = self.apart();
        let room = [along - below, along - above];
        Slack::of_slab(self.stored, room, self.least, self.bound())
    }

    /// Widens the extent to a height.
    #[inline]
    pub(super) fn add(&mut self, height: f64) {
        let (low, high) = self.extent;
        self.extent = (if height < low { height } else { low }, if height > high { height } else { high });
    }

    /// The least that its height could be by any planes over and under the border: no plane under the border is over its
    /// highest vertex there, and none over it under the lowest one.
    pub(super) fn least_height(&self) -> f64 {
        (self.extent.1 - self.border.1).max(self.border.0 - self.extent.0).max(self.least / RIDGE)
    }

    /// Raises the bound to a distance.
    pub(super) fn raise(&mut self, distance: f64) {
        self.least = self.least.max(distance);
    }
}

/// The points of a cluster: of the groups those of `border` lie on its border and those of `inside` do not.
#[derive(Clone, Debug)]
pub(super) struct Points<'a> {
    pub(super) all: &'a Quads,
    pub(super) border: Range<usize>,
    pub(super) inside: Range<usize>,
}

impl Points<'_> {
    /// The slab along a unit vector that no face turns its back on.
    fn slab(&self, direction: Vec3) -> Slab {
        let stored = FineNormalRecord::encode(direction.to_array());
        let direction = DVec3::from_array(stored.direction());
        let border = self.all.extent(self.border.clone(), direction);
        let inside = self.all.extent(self.inside.clone(), direction);
        let extent = (inside.0.min(border.0), inside.1.max(border.1));
        Slab { stored, direction, border, extent, least: 0.0, supported: None }
    }

    /// From the point of the polygon to that of the cluster, or the other way, that are farthest apart along the
    /// direction of a slab.
    fn farthest(&self, direction: DVec3) -> Option<DVec3> {
        let [bl, bh] = self.all.extremes(self.border.clone(), direction)?;
        let [lo, hi] = self.all.extremes(self.inside.clone(), direction).unwrap_or([bl, bh]);
        let lower = |a: DVec3, b: DVec3| if direction.dot(b) < direction.dot(a) { b } else { a };
        let up = -lower(-bh, -hi) - bl;
        let down = bh - lower(bl, lo);
        Some(-lower(-up, -down))
    }
}

/// The slab of least bound along `directions`, unit vectors that no face turns its back on; `None` without any.
pub(super) fn slab(directions: impl Iterator<Item = Vec3>, points: &Points<'_>) -> Option<Slab> {
    let slabs = directions.map(|direction| points.slab(direction));
    slabs.reduce(|best, other| if other.bound() < best.bound() { other } else { best })
}

/// How often a slab is turned. More turns make cuts by less than a hundredth coarser.
const TURNS: u32 = 6;

/// By how much a turn would lower a slab if the same points stayed the farthest ones.
const LOWERED_BY: f64 = 0.5;

/// The slab after some turns that made it lower; `face` says whether all faces face a direction.
///
/// The height is the largest of all distances along the direction between a point of the border and one of the cluster,
/// one over the other. A turn away from the pair that is farthest apart makes its distance less: they are the steps of
/// a descent along subgradients.
pub(super) fn turned(mut slab: Slab, points: &Points<'_>, face: impl Fn(DVec3) -> bool) -> Slab {
    let mut share = LOWERED_BY;
    for _ in 0..TURNS {
        let Some(apart) = points.farthest(slab.direction) else { return slab };
        let height = slab.direction.dot(apart);
        let across = apart - slab.direction * height;
        let step = across * (share * height / across.length_squared());
        let Some(direction) = (slab.direction - step).try_normalize() else { return slab };
        let next = points.slab(direction.as_vec3());
        if next.height() < slab.height() && face(next.direction) {
            slab = next;
        } else {
            share *= 0.5;
        }
    }
    slab
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The slab of these points along a direction, and after it was turned; all faces face directions up from z.
    fn slabs(border: &[Vec3], inside: &[Vec3], direction: Vec3) -> [Slab; 2] {
        let mut all = Quads::default();
        let first = all.extend(border, |p| *p);
        let end = all.extend(inside, |p| *p);
        let points = Points { all: &all, border: 0..first, inside: first..end };
        let slab = slab(std::iter::once(direction), &points).unwrap();
        [slab, turned(slab, &points, |direction| direction.z > 0.3)]
    }

    #[test]
    fn a_tilted_disc_is_found_to_be_flat() {
        let place = |i: i32, r: f32| {
            let (x, y) = (r * (i as f32).cos(), r * (i as f32).sin());
            Vec3::new(x, y, 0.4 * x - 0.2 * y)
        };
        let border: Vec<Vec3> = (0..30).map(|i| place(i, 1.0)).collect();
        let inside: Vec<Vec3> = (0..30).map(|i| place(i, 0.5)).collect();
        let [slab, turned] = slabs(&border, &inside, Vec3::Z);
        assert!(slab.height() > 0.8 && turned.height() < 0.2, "{} {}", slab.height(), turned.height());
    }

    proptest! {
        #[test]
        fn a_turn_never_raises_a_slab(
            points in prop::collection::vec([-1.0_f32..1.0, -1.0_f32..1.0, -0.3_f32..0.3], 1..60),
            border in 1_usize..20,
            direction in [-0.4_f32..0.4, -0.4_f32..0.4],
        ) {
            let points: Vec<Vec3> = points.into_iter().map(Vec3::from).collect();
            let (border, inside) = points.split_at(border.min(points.len()));
            let [slab, turned] = slabs(border, inside, Vec3::new(direction[0], direction[1], 1.0).normalize_or_zero());
            prop_assert!(turned.height() <= slab.height());
            prop_assert!(turned.direction.z > 0.3);
            // It is a slab: heights are those of the points.
            let heights = |points: &[Vec3]| {
                let all = points.iter().map(|p| turned.direction.dot(p.as_dvec3()));
                all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)))
            };
            let ((low, high), (bl, bh)) = (heights(&points), heights(border));
            prop_assert!((turned.height() - (high - bl).max(bh - low)).abs() < 1e-12);
        }
    }
}
