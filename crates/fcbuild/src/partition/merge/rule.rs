//! Which two clusters to merge next.

use super::cluster::Cluster;

/// How the cost of a merge is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
    /// The rise of the error for each triangle saved.
    Quality,
    /// Flatness, orientation and compactness of the union, after Garland.
    ///
    /// As totals over the cluster: his means make a large cluster swallow small ones one by one, and trees of large
    /// scans a hundred levels deep and more.
    Garland,
}

impl Rule {
    #[inline]
    /// The cost of making `union` of `a` and `b`, not negative; `removed` triangles fewer are drawn then.
    pub(super) fn cost<C>(self, a: &Cluster<C>, b: &Cluster<C>, union: &Cluster<C>, removed: u32) -> f64 {
        let cost = match self {
            Rule::Quality => {
                let rise = (union.lost - a.lost - b.lost).max(0.0);
                let width = f64::from(union.perimeter);
                let floor = FLOOR * union.area * width * width + LEAST * f64::from(union.faces);
                (rise + floor) / f64::from(1 + removed) * depth_penalty(union)
            }
            Rule::Garland => {
                let direction = 2.0 * (union.area - union.normal.length()).max(0.0);
                let perimeter = f64::from(union.perimeter);
                let irregularity = perimeter * perimeter * (0.25 * std::f64::consts::FRAC_1_PI);
                (union.error + direction + SHAPE * irregularity) * depth_penalty(union)
            }
        };
        if cost.is_nan() { 0.0 } else { cost.clamp(0.0, f64::MAX) }
    }

    /// The budget key of a merge, a length: nodes of larger keys are refined first.
    pub(super) fn key<C>(self, cost: f64, union: &Cluster<C>) -> f32 {
        let key = match self {
            // The cost is an area times a squared distance.
            Rule::Quality => cost.sqrt().sqrt(),
            Rule::Garland => (union.error / union.area).sqrt(),
        };
        if key.is_finite() { key as f32 } else { 0.0 }
    }
}

/// Where everything is flat, small and compact clusters merge first: the rise counts as if a cluster with a boundary
/// of length 1 were rough by the root of this. With ties instead, flat clusters get ragged outlines, whose polygons
/// overlap themselves.
const FLOOR: f64 = 3e-9;

/// And among clusters without area those of few faces.
const LEAST: f64 = 1e-60;

/// What compactness counts beside orientation in Garland's cost, which leaves the weight to the user.
const SHAPE: f64 = 1e-3;

/// Levels that a tree may have above one and a half times those of an even one before its growth is held back.
const SPARE_LEVELS: u32 = 6;

/// 2 for each half level too deep: deep trees make slow walks, and lopsided ones come from no shape but from ties.
fn depth_penalty<C>(union: &Cluster<C>) -> f64 {
    let twice = (2 * union.depth).saturating_sub(3 * union.faces.ilog2() + 2 * SPARE_LEVELS);
    f64::from_bits(u64::from(1023 + twice.min(200)) << 52)
}
