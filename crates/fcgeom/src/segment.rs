//! Segments and the distance of points from them.

use glam::DVec3;

/// The way from the nearest point of the segment between `a` and `b` to `p`, whose length is the distance of the point
/// from the segment. A segment of no length is a point.
pub fn offset_from_segment(p: DVec3, a: DVec3, b: DVec3) -> DVec3 {
    let (ab, ap) = (b - a, p - a);
    let length_squared = ab.length_squared();
    let t = if length_squared > 0.0 { (ap.dot(ab) / length_squared).clamp(0.0, 1.0) } else { 0.0 };
    ap - ab * t
}

/// Distance of the point `p` from the segment between `a` and `b`.
pub fn distance_to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    offset_from_segment(p, a, b).length()
}
