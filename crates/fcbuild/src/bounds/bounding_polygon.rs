//! An octagonal prism around a cluster, from which a viewer makes the polygon of an occlusion query.

use fcgeom::{Quads, round_down, round_up, tangent_frame};
use glam::{DVec3, Vec3};

/// The cluster lies in `{ origin + x t + y b + z n }` with `b = n x t`, `low <= z <= high` and, for k = 0 to 7,
/// `x cos(k 45 deg) + y sin(k 45 deg) <= support[k]`; lengths in normal units.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundingPolygon {
    /// A point near the cluster.
    pub origin: Vec3,
    /// Unit normal n of the cluster's plane.
    pub normal: Vec3,
    /// Unit tangent t.
    pub tangent: Vec3,
    /// Lowest z.
    pub low: f32,
    /// Highest z.
    pub high: f32,
    /// Supports of the octagon.
    pub support: [f32; 8],
}

impl BoundingPolygon {
    /// The prism around `points` over the plane with this unit normal.
    pub fn around(points: &Quads, origin: Vec3, normal: Vec3) -> BoundingPolygon {
        let tangent = tangent_frame(normal.as_dvec3()).0.as_vec3();
        // The frame as a reader finds it, from the stored single-precision vectors.
        let (n, t) = (normal.as_dvec3(), tangent.as_dvec3());
        let b = n.cross(t);
        const HALF: f64 = std::f64::consts::FRAC_1_SQRT_2;
        let directions = [t, (t + b) * HALF, b, (b - t) * HALF, n].map(DVec3::as_vec3);
        let extents = points.extents(origin, directions);
        let (low, high) = (extents.map(|e| f64::from(e.0)), extents.map(|e| f64::from(e.1)));
        // The stored vectors are not exactly orthonormal, so a point comes back from its coordinates a little off;
        // nor are the extents exact.
        let slack = 2e-6 * (0..5).map(|i| high[i].abs().max(low[i].abs())).fold(0.0, f64::max);
        let up = |h: f64| round_up(h + slack);
        BoundingPolygon {
            origin,
            normal,
            tangent,
            low: round_down(low[4] - slack),
            high: up(high[4]),
            support: [
                up(high[0]),
                up(high[1]),
                up(high[2]),
                up(high[3]),
                up(-low[0]),
                up(-low[1]),
                up(-low[2]),
                up(-low[3]),
            ],
        }
    }
}
