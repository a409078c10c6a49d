//! Signed distances of simple solids, negative inside, and ways to join them.
//!
//! All are exact or nearly so close to the surface; far away some are estimates, which only guide the search for it.

use glam::{DVec2, DVec3};

/// Ball-like solid with three radii.
pub(crate) fn ellipsoid(p: DVec3, radii: DVec3) -> f64 {
    let near = (p / radii).length();
    let slope = (p / (radii * radii)).length();
    if slope > 0.0 { near * (near - 1.0) / slope } else { -radii.min_element() }
}

/// Box by its half extents.
pub(crate) fn cuboid(p: DVec3, half: DVec3) -> f64 {
    let q = p.abs() - half;
    q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
}

/// Rectangle in the plane by its half extents.
pub(crate) fn rectangle(p: DVec2, half: DVec2) -> f64 {
    let q = p.abs() - half;
    q.max(DVec2::ZERO).length() + q.max_element().min(0.0)
}

/// A plane outline at distance `outline`, given the thickness that `across` measures; the rims are sharp.
pub(crate) fn extruded(outline: f64, across: f64) -> f64 {
    DVec2::new(outline.max(0.0), across.max(0.0)).length() + outline.max(across).min(0.0)
}

/// Union whose seam is rounded within `k`; equals the minimum where the two differ by `k` or more.
pub(crate) fn blend(a: f64, b: f64, k: f64) -> f64 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * h * k / 6.0
}

/// `a` with `b` cut out of it, the edge sharp.
pub(crate) fn without(a: f64, b: f64) -> f64 {
    a.max(-b)
}

/// Periodic wave of period 1 between 0 and 1, made of parabolas.
pub(crate) fn wave(x: f64) -> f64 {
    let t = x - x.floor();
    4.0 * t * (1.0 - t)
}

/// Periodic wave of period 1 between 0 and 1, made of straight lines with sharp corners.
pub(crate) fn zigzag(x: f64) -> f64 {
    let t = x - x.floor();
    1.0 - (2.0 * t - 1.0).abs()
}

/// 0 below `from`, 1 above `to`, smooth between.
pub(crate) fn ramp(x: f64, from: f64, to: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A rope with varying radius along a smooth curve.
#[derive(Debug)]
pub(crate) struct Rope {
    /// Points, radii and the arc length so far.
    knots: Vec<(DVec3, f64, f64)>,
    centre: DVec3,
    reach: f64,
}

impl Rope {
    /// A Catmull-Rom curve through `stations` (position, radius), each gap cut into `steps`.
    pub(crate) fn new(stations: &[(DVec3, f64)], steps: u32) -> Rope {
        let last = stations.len().saturating_sub(1);
        let mut knots: Vec<(DVec3, f64, f64)> = Vec::new();
        for i in 0..last {
            let at = |k: usize| stations[k.min(last)];
            let (a, b, c, d) = (at(i.saturating_sub(1)), at(i), at(i + 1), at(i + 2));
            let from = u32::from(i > 0);
            for step in from..=steps {
                let t = f64::from(step) / f64::from(steps);
                let p = catmull(a.0, b.0, c.0, d.0, t);
                let r = b.1 + (c.1 - b.1) * t;
                let along = knots.last().map_or(0.0, |k| k.2 + (p - k.0).length());
                knots.push((p, r, along));
            }
        }
        let low = knots.iter().fold(DVec3::INFINITY, |m, k| m.min(k.0));
        let high = knots.iter().fold(DVec3::NEG_INFINITY, |m, k| m.max(k.0));
        let centre = (low + high) * 0.5;
        let reach = knots.iter().fold(0.0_f64, |m, k| m.max((k.0 - centre).length() + k.1));
        Rope { knots, centre, reach }
    }

    /// True when the rope may be nearer to `p` than `limit`.
    pub(crate) fn within(&self, p: DVec3, limit: f64) -> bool {
        (p - self.centre).length() - self.reach < limit
    }

    /// Distance, and the arc length of the nearest point of the curve.
    pub(crate) fn distance(&self, p: DVec3) -> (f64, f64) {
        let mut best = (f64::INFINITY, 0.0);
        for pair in self.knots.windows(2) {
            let ((a, ra, sa), (b, rb, sb)) = (pair[0], pair[1]);
            let ab = b - a;
            // Nothing of the segment is nearer than this; most are left here, without a root.
            let limit = best.0 + ra.max(rb) + (sb - sa);
            if limit > 0.0 && (p - a).length_squared() > limit * limit {
                continue;
            }
            let t = ((p - a).dot(ab) / ab.length_squared()).clamp(0.0, 1.0);
            let d = (p - a - ab * t).length() - (ra + (rb - ra) * t);
            if d < best.0 {
                best = (d, sa + (sb - sa) * t);
            }
        }
        best
    }
}

fn catmull(a: DVec3, b: DVec3, c: DVec3, d: DVec3, t: f64) -> DVec3 {
    let (t2, t3) = (t * t, t * t * t);
    (b * 2.0 + (c - a) * t + (a * 2.0 - b * 5.0 + c * 4.0 - d) * t2 + (b * 3.0 - a - c * 3.0 + d) * t3) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solids_have_their_surface_where_they_should() {
        let zero = |d: f64| assert!(d.abs() < 1e-12, "{d}");
        zero(ellipsoid(DVec3::new(0.0, 2.0, 0.0), DVec3::new(1.0, 2.0, 3.0)));
        zero(cuboid(DVec3::new(1.0, 0.3, -0.2), DVec3::ONE));
        assert!((cuboid(DVec3::splat(2.0), DVec3::ONE) - 3.0_f64.sqrt()).abs() < 1e-12);
        let rope = Rope::new(&[(DVec3::ZERO, 0.5), (DVec3::X * 4.0, 0.5)], 4);
        let (d, along) = rope.distance(DVec3::new(2.0, 3.0, 0.0));
        assert!((d - 2.5).abs() < 1e-12 && (along - 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_blend_is_the_minimum_away_from_the_seam_and_below_it_on_the_seam() {
        assert_eq!(blend(0.5, 0.1, 0.4).to_bits(), 0.1_f64.to_bits());
        assert!(blend(0.1, 0.1, 0.4) < 0.1);
    }
}
