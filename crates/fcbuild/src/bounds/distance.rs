//! How far the surface of a cluster can be from the polygon that stands for it.
//!
//! The polygon's corners lie on the cluster's border, whichever of them are drawn. Along a direction in which no face
//! of the cluster is seen from behind, the cluster covers its outline once; with its own extent [lo, hi] and its
//! border's [bl, bh] along that direction, surface and polygon are at most max(hi - bl, bh - lo) apart there. Around the
//! border more of the surface counts, see [`super::overhang`].
//! A cluster that folds over has no such direction: then every point is at most as far from the drawn mesh as from
//! the nearest of its corners, vertices that are drawn whenever the cluster is. The other way, a triangle between points
//! of a ball is nowhere farther from the nearest of them than the ball's radius.

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
}

impl Slab {
    /// How far polygon and surface may be from each other along its direction.
    pub(super) fn height(&self) -> f64 {
        (self.extent.1 - self.border.0).max(self.border.1 - self.extent.0)
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
        let room = [along - (self.border.1 - self.extent.0), along - (self.extent.1 - self.border.0)];
        Slack::of_slab(self.stored, room, self.least, self.bound())
    }

    /// Widens the extent to a height.
    #[inline]
    pub(super) fn add(&mut self, height: f64) {
        let (low, high) = self.extent;
        self.extent = (if height < low { height } else { low }, if height > high { height } else { high });
    }

    /// Raises the bound to a distance.
    pub(super) fn raise(&mut self, distance: f64) {
        self.least = self.least.max(distance);
    }
}

/// The slab of least bound along `directions`, unit vectors that no face turns its back on; `None` without any.
/// Of the points the groups `border` lie on the cluster's border and `inside` do not.
pub(super) fn slab(
    directions: [Option<Vec3>; 2],
    points: &Quads,
    border: Range<usize>,
    inside: Range<usize>,
) -> Option<Slab> {
    let along = |direction: Vec3| {
        let stored = FineNormalRecord::encode(direction.to_array());
        let direction = DVec3::from_array(stored.direction());
        let border = points.extent(border.clone(), direction);
        let inside = points.extent(inside.clone(), direction);
        let extent = (inside.0.min(border.0), inside.1.max(border.1));
        Slab { stored, direction, border, extent, least: 0.0 }
    };
    let slabs = directions.into_iter().flatten().map(along);
    slabs.reduce(|best, other| if other.bound() < best.bound() { other } else { best })
}

/// At most so many corners are tried: more would tighten the bound little and cost time on large clusters.
const MAX_CORNERS: usize = 24;

/// The largest distance of a point of the cluster's faces from the nearest of some of the corners; infinite if there
/// is no corner.
///
/// No point of a face is farther from a vertex of it than its longest edge over the root of 3.
pub(super) fn from_corners(points: &Quads, longest_edge: f32, corners: &mut Vec<Vec3>) -> f64 {
    let step = corners.len().div_ceil(MAX_CORNERS).max(1);
    let mut place = 0;
    corners.retain(|_| {
        place += 1;
        (place - 1) % step == 0
    });
    // Single precision is enough for a bound this loose, once its rounding is paid for.
    let inside_faces = f64::from(longest_edge) * (1.0 / 1.732);
    (f64::from(points.farthest_from_sites(corners)).sqrt() + inside_faces) * (1.0 + 1e-5)
}
