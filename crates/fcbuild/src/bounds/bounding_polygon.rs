//! An octagonal prism around a cluster, from which a viewer makes the polygon of an occlusion query.

use fcgeom::{round_down, round_up, tangent_frame};
use glam::Vec3;

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
    pub fn around(points: impl Iterator<Item = Vec3>, origin: Vec3, normal: Vec3) -> BoundingPolygon {
        let tangent = tangent_frame(normal.as_dvec3()).0.as_vec3();
        // The frame as a reader finds it, from the stored single-precision vectors.
        let (o, n, t) = (origin.as_dvec3(), normal.as_dvec3(), tangent.as_dvec3());
        let b = n.cross(t);
        let mut low = [f64::INFINITY; 5];
        let mut high = [f64::NEG_INFINITY; 5];
        const HALF: f64 = std::f64::consts::FRAC_1_SQRT_2;
        for p in points {
            let d = p.as_dvec3() - o;
            let (x, y, z) = (t.dot(d), b.dot(d), n.dot(d));
            for (i, h) in [x, (x + y) * HALF, y, (y - x) * HALF, z].into_iter().enumerate() {
                low[i] = low[i].min(h);
                high[i] = high[i].max(h);
            }
        }
        // The stored vectors are not exactly orthonormal: a point comes back from its coordinates a little off.
        let slack = 1e-6 * (0..5).map(|i| high[i].abs().max(low[i].abs())).fold(0.0, f64::max);
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
