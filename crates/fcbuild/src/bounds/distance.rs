//! How far the surface of a cluster can be from the polygon that stands for it.

use glam::{DVec3, Vec3};

/// The distance bound of one cluster, in the unit of the points.
///
/// The polygon's corners lie on the cluster's border, whichever of them are drawn. Along a direction in which no face
/// of the cluster is seen from behind, the cluster covers its outline once; with its own extent [lo, hi] and its
/// border's [bl, bh] along that direction, surface and polygon are at most max(hi - bl, bh - lo) apart there.
/// A cluster that folds over has no such direction: then every point is at most as far from the drawn mesh as from
/// the nearest of `corners`, vertices that are drawn whenever the cluster is.
///
/// `directions` are tried in turn and the best is taken; zero vectors are passed over. `inside` and `border` together
/// are the cluster's vertices. Says with the bound whether it is one from the corners.
pub(super) fn bound(
    normals: &[Vec3],
    directions: &[Vec3],
    inside: &[Vec3],
    border: &[Vec3],
    corners: &[Vec3],
) -> (f64, bool) {
    let mut best = f64::INFINITY;
    for direction in directions {
        if *direction != Vec3::ZERO
            && normals.iter().all(|n| *n == Vec3::ZERO || n.dot(*direction) > MIN_FACING)
        {
            best = best.min(slab(direction.as_dvec3(), inside, border));
        }
    }
    if best == f64::INFINITY {
        (farthest_from_corners(inside, border, corners), true)
    } else {
        (best * RIDGE, false)
    }
}

/// Cosine above which a face counts as facing a direction: about 89.4 degrees, so that rounding cannot turn it.
const MIN_FACING: f32 = 0.01;

/// 1 / cos(10 degrees): how much farther than either slab a point can be from a chord between two polygons that meet
/// at up to 20 degrees. Steeper meetings keep their vertices instead, see [`crate::arcs::flaps`].
const RIDGE: f64 = 1.0155;

fn slab(direction: DVec3, inside: &[Vec3], border: &[Vec3]) -> f64 {
    let extent = |points: &[Vec3], start: (f64, f64)| {
        points.iter().fold(start, |(low, high), p| {
            let h = direction.dot(p.as_dvec3());
            (low.min(h), high.max(h))
        })
    };
    let (border_low, border_high) = extent(border, (f64::INFINITY, f64::NEG_INFINITY));
    let (low, high) = extent(inside, (border_low, border_high));
    (high - border_low).max(border_high - low)
}

/// At most so many corners are tried: more would tighten the bound little and cost time on large clusters.
const MAX_CORNERS: usize = 24;

fn farthest_from_corners(inside: &[Vec3], border: &[Vec3], corners: &[Vec3]) -> f64 {
    let step = corners.len().div_ceil(MAX_CORNERS).max(1);
    let corners: Vec<Vec3> = corners.iter().step_by(step).copied().collect();
    let mut farthest = 0.0_f32;
    for p in inside.iter().chain(border) {
        let nearest = corners.iter().map(|c| c.distance_squared(*p)).fold(f32::INFINITY, f32::min);
        farthest = farthest.max(nearest);
    }
    // Single precision is enough for a bound this loose, once its rounding is paid for.
    f64::from(farthest).sqrt() * (1.0 + 1e-5)
}
