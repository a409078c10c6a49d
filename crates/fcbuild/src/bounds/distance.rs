//! How far the surface of a cluster without a slab can be from the polygon that stands for it.
//!
//! It folds over, or goes around holes at the top of a tree (see [`super::slab`]). But every point is at most as far from
//! the drawn mesh as from the nearest of the cluster's corners, vertices that are drawn whenever the cluster is. The other
//! way, a triangle between points of a ball is nowhere farther from the nearest of them than the ball's radius.

use fcgeom::Quads;
use glam::Vec3;

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
