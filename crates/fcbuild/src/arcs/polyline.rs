//! Farthest points and Douglas-Peucker errors of boundary polylines.

use fcgeom::Sphere;
use glam::{DVec3, Vec3};

/// The way from the nearest point of a segment to a point.
pub(super) fn offset_from_segment(p: DVec3, a: DVec3, b: DVec3) -> DVec3 {
    let (ab, ap) = (b - a, p - a);
    let length_squared = ab.length_squared();
    let t = if length_squared > 0.0 { (ap.dot(ab) / length_squared).clamp(0.0, 1.0) } else { 0.0 };
    ap - ab * t
}

/// Distance of a point from a segment.
pub(super) fn distance_to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    offset_from_segment(p, a, b).length()
}

/// The item of largest value, the first of equals; none of an empty list.
fn farthest(n: usize, value: impl Fn(usize) -> f64) -> Option<(usize, f64)> {
    (0..n).map(|i| (i, value(i))).reduce(|best, x| if x.1 > best.1 { x } else { best })
}

/// Adds points of a closed polyline to `chosen` until there are three, each as far as possible from the chosen ones.
///
/// The first two of an empty choice are a pair found by two sweeps, nearly the farthest; the third is the farthest
/// from their segment. Fewer come back only if the polyline has fewer points.
pub(super) fn complete_to_three(points: &[Vec3], chosen: &mut Vec<usize>) {
    let at = |i: usize| points[i].as_dvec3();
    let n = points.len();
    while chosen.len() < 3.min(n) {
        let new = match chosen[..] {
            [] => {
                let Some((far, _)) = farthest(n, |i| (at(i) - at(0)).length_squared()) else { return };
                far
            }
            [a] => match farthest(n, |i| if i == a { -1.0 } else { (at(i) - at(a)).length_squared() }) {
                Some((far, _)) => far,
                None => return,
            },
            _ => {
                let taken = chosen.clone();
                let (a, b) = (at(taken[0]), at(taken[1]));
                match farthest(
                    n,
                    |i| if taken.contains(&i) { -1.0 } else { distance_to_segment(at(i), a, b) },
                ) {
                    Some((far, _)) => far,
                    None => return,
                }
            }
        };
        chosen.push(new);
    }
}

/// What leaving a point out of a polyline costs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Deviation {
    /// Index of the point.
    pub(super) point: usize,
    /// The stretch of the polyline whose chord the point breaks, both ends included.
    pub(super) from: usize,
    pub(super) to: usize,
    /// The stretch that this one is a part of, by its place in the list.
    pub(super) within: Option<usize>,
    /// The largest distance of the stretch from its chord, and at least that of every stretch inside it.
    pub(super) error: f64,
    /// Around the stretch; the spheres of the stretches inside it lie in it.
    pub(super) sphere: Sphere,
}

/// Stretches are cut at their middle beyond this depth, so that a spiral cannot make the work quadratic.
const MAX_DEPTH: u32 = 40;

/// The deviation of every inner point of an open polyline, stretches before those inside them.
///
/// Keeping all points whose error passes a tolerance leaves a polyline from which no left-out point is farther than
/// that tolerance ([Douglas and Peucker 1973], made monotone).
pub(super) fn deviations(points: &[Vec3]) -> Vec<Deviation> {
    let mut out: Vec<Deviation> = Vec::with_capacity(points.len());
    let mut stack = vec![(0, points.len().saturating_sub(1), None, 0_u32)];
    while let Some((from, to, within, depth)) = stack.pop() {
        if to < from + 2 {
            continue;
        }
        let (a, b) = (points[from].as_dvec3(), points[to].as_dvec3());
        let inner = &points[from + 1..to];
        let Some((far, error)) = farthest(inner.len(), |i| distance_to_segment(inner[i].as_dvec3(), a, b))
        else {
            continue;
        };
        let point = if depth < MAX_DEPTH { from + 1 + far } else { (from + to) / 2 };
        let own = out.len();
        let sphere = Sphere::of_points(&points[from..=to]);
        out.push(Deviation { point, from, to, within, error, sphere });
        stack.push((point, to, Some(own), depth + 1));
        stack.push((from, point, Some(own), depth + 1));
    }
    for i in (0..out.len()).rev() {
        if let Some(up) = out[i].within {
            let inside = out[i];
            out[up].error = out[up].error.max(inside.error);
            out[up].sphere = Sphere::enclosing(&out[up].sphere, &inside.sphere);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wiggle(n: usize) -> Vec<Vec3> {
        let mut state = 7_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 16_777_216.0
        };
        (0..n).map(|i| Vec3::new(i as f32, random() * 3.0, random())).collect()
    }

    #[test]
    fn points_left_out_at_a_tolerance_stay_within_it() {
        let points = wiggle(200);
        let deviations = deviations(&points);
        assert_eq!(deviations.len(), 198);
        for tolerance in [0.0, 0.3, 0.9, 1.7, 10.0] {
            let mut kept = vec![0, 199];
            kept.extend(deviations.iter().filter(|d| d.error > tolerance).map(|d| d.point));
            kept.sort_unstable();
            for ends in kept.windows(2) {
                for i in ends[0]..ends[1] {
                    let d = distance_to_segment(
                        points[i].as_dvec3(),
                        points[ends[0]].as_dvec3(),
                        points[ends[1]].as_dvec3(),
                    );
                    assert!(d <= tolerance, "{i} is {d} from its chord at {tolerance}");
                }
            }
        }
    }

    #[test]
    fn three_anchors_of_a_long_ellipse_span_it() {
        let points: Vec<Vec3> = wiggle(40).iter().map(|p| Vec3::new(p.x, p.y * 0.01, 0.0)).collect();
        let mut chosen = Vec::new();
        complete_to_three(&points, &mut chosen);
        chosen.sort_unstable();
        assert_eq!((chosen.len(), chosen[0], chosen[2]), (3, 0, 39));
    }

    #[test]
    fn short_loops_give_what_they_have() {
        let mut chosen = vec![1];
        complete_to_three(&wiggle(2), &mut chosen);
        assert_eq!(chosen, [1, 0]);
    }
}
