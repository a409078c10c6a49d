//! Farthest points of boundary polylines, and the keys that keep their chords near.

use fcgeom::{Sphere, distance_to_segment};
use glam::Vec3;

/// The item of largest value, the first of equals; none of an empty list.
fn farthest(n: usize, value: impl Fn(usize) -> f64) -> Option<(usize, f64)> {
    (0..n).map(|i| (i, value(i))).reduce(|best, x| if x.1 > best.1 { x } else { best })
}

/// Adds points of a closed polyline to `chosen` until there are three, each as far as possible from the chosen ones.
///
/// The first two of an empty choice are a pair found by two sweeps, nearly the farthest; the third is the farthest
/// from their segment. A distance counts as `weight` of its point says. Fewer come back only if the polyline has fewer
/// points.
pub(super) fn complete_to_three(points: &[Vec3], chosen: &mut Vec<usize>, weight: impl Fn(usize) -> f64) {
    let at = |i: usize| points[i].as_dvec3();
    let weighed = |i: usize, from: usize| weight(i) * weight(i) * (at(i) - at(from)).length_squared();
    let n = points.len();
    while chosen.len() < 3.min(n) {
        let new = match chosen[..] {
            [] => {
                let Some((far, _)) = farthest(n, |i| weighed(i, 0)) else { return };
                far
            }
            [a] => match farthest(n, |i| if i == a { -1.0 } else { weighed(i, a) }) {
                Some((far, _)) => far,
                None => return,
            },
            _ => {
                let taken = chosen.clone();
                let (a, b) = (at(taken[0]), at(taken[1]));
                match farthest(n, |i| {
                    if taken.contains(&i) { -1.0 } else { weight(i) * distance_to_segment(at(i), a, b) }
                }) {
                    Some((far, _)) => far,
                    None => return,
                }
            }
        };
        chosen.push(new);
    }
}

/// A point of a polyline that has to be drawn at larger tolerances than its key says.
#[derive(Clone, Copy, Debug)]
pub(super) struct Raised {
    /// Index of the point.
    pub(super) point: usize,
    /// Its new key.
    pub(super) key: f64,
    /// Around the stretch that is too far from its chord without the point; the spheres of the points raised inside
    /// it lie in it. If the key is that of an end of the chord, the sphere in which that is drawn lies in it too.
    pub(super) sphere: Sphere,
}

/// A stretch of a polyline whose chord is drawn at tolerances in [lowest, highest): its ends are drawn there, and no
/// point between them is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chord {
    /// Both ends.
    pub(super) from: usize,
    pub(super) to: usize,
    pub(super) lowest: f64,
    pub(super) highest: f64,
}

/// Stretches are cut at their middle beyond this depth, so that a spiral cannot make the work quadratic.
const MAX_DEPTH: u32 = 60;

/// Finds keys for the inner points of a polyline, such that every chord is near enough wherever it is drawn.
///
/// A point is drawn at tolerances below its key, so the keys say of every chord at which tolerances it is drawn; the
/// ends are drawn below `highest`. `miss` tells the worst point of a chord and its distance, at least of those points
/// whose distance is over the chord's lowest tolerance. Where that is over a tolerance at which the chord is drawn, the
/// point is raised: keys only grow, and what they were raised for before still holds, since the chords inside a stretch
/// are looked at with the keys that it leaves.
///
/// In views, keys are held against the tolerances around spheres, and `drawn` tells those that points have already. A
/// point that breaks a chord must be drawn wherever one of those is that it is drawn before, and one whose key is limited
/// by that of an end wherever the end is: each gets their spheres too.
///
/// # Paper
/// [Douglas and Peucker 1973] is the case in which all keys are 0 at first.
pub(super) fn raise(
    points: &[Vec3],
    key: impl Fn(usize) -> f64,
    highest: f64,
    drawn: impl Fn(usize) -> Sphere,
    mut miss: impl FnMut(Chord) -> Option<(usize, f64)>,
) -> Vec<Raised> {
    if let [_, _, _] = points {
        // Most arcs have one vertex between their ends.
        let lowest = key(1).min(highest);
        let missed = if lowest < highest { miss(Chord { from: 0, to: 2, lowest, highest }) } else { None };
        let breaks_at = missed.map_or(lowest, |(_, distance)| distance.clamp(lowest, highest));
        if breaks_at <= key(1) {
            return Vec::new();
        }
        let around = Sphere::of_points(points);
        let sphere = if breaks_at == highest { both(&around, &drawn(0)) } else { around };
        return vec![Raised { point: 1, key: breaks_at, sphere }];
    }
    struct Stretch {
        within: Option<usize>,
        chord: Chord,
        /// The end of the chord that is drawn last.
        last: usize,
        /// The point that breaks the chord, at which tolerance, and whether that is more than its key.
        point: usize,
        breaks_at: f64,
        is_raised: bool,
    }
    let mut stretches: Vec<Stretch> = Vec::new();
    let mut stack = vec![(0, points.len().saturating_sub(1), highest, None, 0, 0_u32)];
    while let Some((from, to, highest, within, last, depth)) = stack.pop() {
        if to < from + 2 {
            continue;
        }
        let first = (from + 1, key(from + 1));
        let (drawn_first, lowest) =
            (from + 2..to).map(|i| (i, key(i))).fold(first, |best, x| if x.1 > best.1 { x } else { best });
        let lowest = lowest.min(highest);
        let chord = Chord { from, to, lowest, highest };
        let missed = if lowest < highest { miss(chord) } else { None };
        let missed = missed.map(|(i, distance)| (i, distance.min(highest))).filter(|m| m.1 > lowest);
        let (mut point, breaks_at) = missed.unwrap_or((drawn_first, lowest));
        if depth >= MAX_DEPTH {
            point = usize::midpoint(from, to);
        }
        let own = stretches.len();
        stretches.push(Stretch { within, chord, last, point, breaks_at, is_raised: breaks_at > key(point) });
        let last = if key(point) > highest { last } else { point };
        stack.push((point, to, breaks_at, Some(own), last, depth + 1));
        stack.push((from, point, breaks_at, Some(own), last, depth + 1));
    }
    // From the inside out: a point is drawn wherever one is that its chord's halves leave out before it.
    let mut spheres = vec![Sphere::EMPTY; stretches.len()];
    for (i, stretch) in stretches.iter().enumerate().rev() {
        spheres[i] = both(&drawn(stretch.point), &spheres[i]);
        if stretch.is_raised {
            let own = Sphere::of_points(&points[stretch.chord.from..=stretch.chord.to]);
            spheres[i] = both(&own, &spheres[i]);
        }
        if let Some(up) = stretch.within {
            spheres[up] = both(&spheres[up], &spheres[i]);
        }
    }
    // And back: with a key that is limited by an end's, wherever that end is.
    let mut out = Vec::new();
    for (i, stretch) in stretches.iter().enumerate() {
        let Stretch { chord, last, point, breaks_at, is_raised, .. } = *stretch;
        if is_raised && breaks_at == chord.highest {
            let end = stretch.within.filter(|up| stretches[*up].point == last).map(|up| spheres[up]);
            spheres[i] = both(&spheres[i], &end.unwrap_or_else(|| drawn(last)));
        }
        if is_raised || !drawn(point).is_empty() && !drawn(point).contains_sphere(&spheres[i]) {
            out.push(Raised { point, key: breaks_at, sphere: spheres[i] });
        }
    }
    out
}

/// A sphere around two, one of which may be empty.
fn both(a: &Sphere, b: &Sphere) -> Sphere {
    match (a.is_empty(), b.is_empty()) {
        (_, true) => *a,
        (true, false) => *b,
        _ if a.contains_sphere(b) => *a,
        _ => Sphere::enclosing(a, b),
    }
}

/// The inner point of a stretch that is farthest from its chord, and how far it is.
pub(super) fn farthest_from_chord(points: &[Vec3], from: usize, to: usize) -> Option<(usize, f64)> {
    let (a, b) = (points[from].as_dvec3(), points[to].as_dvec3());
    let inner = points.get(from + 1..to)?;
    let (far, distance) = farthest(inner.len(), |i| distance_to_segment(inner[i].as_dvec3(), a, b))?;
    Some((from + 1 + far, distance))
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

    fn nowhere(_: usize) -> Sphere {
        Sphere::EMPTY
    }

    /// With no keys before, and with keys of others in between: those bend chords away from the ones that a deviation
    /// would be measured against.
    #[test]
    fn points_left_out_at_a_tolerance_stay_within_it() {
        let points = wiggle(200);
        for others in [0, 3, 7] {
            let mut keys: Vec<f64> = (0..200)
                .map(|i| if others > 0 && i % others == 1 { f64::from(i as u32 % 11) * 0.2 } else { 0.0 })
                .collect();
            for r in raise(&points, |i| keys[i], 2.5, nowhere, |c| farthest_from_chord(&points, c.from, c.to))
            {
                assert!(r.key > keys[r.point]);
                keys[r.point] = r.key;
            }
            for tolerance in [0.0, 0.1, 0.3, 0.5, 0.9, 1.3, 1.7, 2.4] {
                let mut kept = vec![0];
                kept.extend((1..199).filter(|&i| keys[i] > tolerance));
                kept.push(199);
                for ends in kept.windows(2) {
                    let far = farthest_from_chord(&points, ends[0], ends[1]);
                    assert!(far.is_none_or(|f| f.1 <= tolerance), "{far:?} from its chord at {tolerance}");
                }
            }
            assert!(keys.iter().all(|k| *k <= 2.5), "none is drawn before the ends are");
        }
    }

    /// Where tolerances differ from place to place, and vertices are drawn by the least one in their spheres.
    #[test]
    fn in_views_too_points_left_out_stay_within_what_is_allowed_there() {
        let mut state = 11_u32;
        let mut random = |low: f32, high: f32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            low + (high - low) * (state >> 8) as f32 / 16_777_216.0
        };
        let (mut with, mut without) = (0, 0);
        for _ in 0..300 {
            let points = wiggle(40);
            let mut records: Vec<(f64, Sphere)> = points
                .iter()
                .map(|p| (f64::from(random(0.0, 1.0)), Sphere { center: *p, radius: random(0.0, 6.0) }))
                .collect();
            records[0].0 = 9.0;
            records[39].0 = 9.0;
            let before = records.clone();
            let chord = |c: Chord| farthest_from_chord(&points, c.from, c.to);
            let nested = raise(&points, |i| before[i].0, 9.0, |i| before[i].1, chord);
            let plain = raise(&points, |i| before[i].0, 9.0, nowhere, chord);
            let slope = Vec3::new(random(-0.02, 0.02), 0.0, 0.0);
            let middle = random(0.3, 2.0);
            let tolerance = |p: Vec3| f64::from(middle + slope.dot(p - points[20]));
            let mut beyond = |raised: &[Raised]| {
                records.clone_from(&before);
                for r in raised {
                    let (key, sphere) = &mut records[r.point];
                    (*key, *sphere) = (key.max(r.key), both(sphere, &r.sphere));
                }
                let least = |s: &Sphere| tolerance(s.center) - f64::from(slope.length() * s.radius);
                let drawn: Vec<usize> = (0..40).filter(|&i| records[i].0 > least(&records[i].1)).collect();
                let far = drawn.windows(2).filter_map(|ends| farthest_from_chord(&points, ends[0], ends[1]));
                far.filter(|(i, far)| *far > tolerance(points[*i])).count()
            };
            with += beyond(&nested);
            without += beyond(&plain);
        }
        assert!(with == 0 && without > 0, "{with} and {without}");
    }

    #[test]
    fn the_only_vertex_of_an_arc_is_raised_to_its_distance_unless_it_is_drawn_before() {
        let points = [Vec3::ZERO, Vec3::new(1.0, 0.5, 0.0), Vec3::new(2.0, 0.0, 0.0)];
        for (key, highest, expected) in [(0.0, 2.0, 0.5), (0.0, 0.25, 0.25), (0.375, 2.0, 0.5)] {
            let raised =
                raise(&points, |_| key, highest, nowhere, |c| farthest_from_chord(&points, c.from, c.to));
            assert_eq!(raised.iter().map(|r| (r.point, r.key)).collect::<Vec<_>>(), [(1, expected)]);
            assert!(points.iter().all(|p| raised[0].sphere.center.distance(*p) <= raised[0].sphere.radius));
        }
        for (key, highest) in [(0.5, 2.0), (0.75, 2.0), (0.75, 0.25)] {
            assert!(
                raise(&points, |_| key, highest, nowhere, |c| farthest_from_chord(&points, c.from, c.to))
                    .is_empty()
            );
        }
    }

    #[test]
    fn three_anchors_of_a_long_ellipse_span_it() {
        let points: Vec<Vec3> = wiggle(40).iter().map(|p| Vec3::new(p.x, p.y * 0.01, 0.0)).collect();
        let mut chosen = Vec::new();
        complete_to_three(&points, &mut chosen, |_| 1.0);
        chosen.sort_unstable();
        assert_eq!((chosen.len(), chosen[0], chosen[2]), (3, 0, 39));
    }

    /// Around a square of eight points, of which two corners count little.
    #[test]
    fn anchors_keep_away_from_points_that_count_less() {
        let square = [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)];
        let points = square.map(|(x, y)| Vec3::new(x as f32, y as f32, 0.0));
        let mut chosen = vec![0];
        complete_to_three(&points, &mut chosen, |i| if [2, 4].contains(&i) { 0.3 } else { 1.0 });
        assert_eq!(chosen, [0, 3, 6]);
    }

    #[test]
    fn short_loops_give_what_they_have() {
        let mut chosen = vec![1];
        complete_to_three(&wiggle(2), &mut chosen, |_| 1.0);
        assert_eq!(chosen, [1, 0]);
    }
}
