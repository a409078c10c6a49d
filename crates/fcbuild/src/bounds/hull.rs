//! Convex hulls in the plane.

use glam::{DVec2, Vec4};

/// A convex polygon, counter-clockwise, without corners on its edges; of fewer than three corners if it has no inside.
/// One of very many corners is clipped to, and holds, a little more than what is in it.
/// Keeps its memory from one to the next.
#[derive(Debug, Default)]
pub(super) struct Hull {
    points: Vec<DVec2>,
    corners: Vec<DVec2>,
    edges: Vec<Edge>,
    /// The same edges side by side.
    fours: Vec<Four>,
    low: DVec2,
    high: DVec2,
    is_left: bool,
}

#[derive(Clone, Copy, Debug)]
struct Edge {
    start: DVec2,
    along: DVec2,
    /// By how much a cross product with it may be off.
    rounding: f64,
}

impl Edge {
    /// An edge of a hull that is at most so far across.
    fn new(start: DVec2, along: DVec2, across: f64) -> Edge {
        Edge { start, along, rounding: ROUNDING * (along.x.abs() + along.y.abs()) * across }
    }

    /// Positive for points to the left, inside.
    #[inline]
    fn cross(&self, p: DVec2) -> f64 {
        self.along.perp_dot(p - self.start)
    }

    /// Cuts off the part of a segment that lies beyond it; `None` if all of it does.
    #[inline]
    fn cut(&self, p: DVec2, q: DVec2, (from, to): &mut (f64, f64)) -> Option<()> {
        let (at_p, at_q) = (self.cross(p), self.cross(q));
        if at_p < 0.0 && at_q < 0.0 {
            return None;
        }
        if at_p < 0.0 {
            let share = at_p / (at_p - at_q);
            *from = if share > *from { share } else { *from };
        } else if at_q < 0.0 {
            let share = at_p / (at_p - at_q);
            *to = if share < *to { share } else { *to };
        }
        Some(())
    }
}

/// Four edges, so that a processor looks at two at a time. Those that fill up the last four have every point on them.
#[derive(Clone, Copy, Debug)]
struct Four {
    start: [[f64; 4]; 2],
    along: [[f64; 4]; 2],
    rounding: [f64; 4],
}

impl Four {
    fn of(edges: &[Edge]) -> Four {
        let mut four = Four { start: [[0.0; 4]; 2], along: [[0.0; 4]; 2], rounding: [-1.0; 4] };
        for (i, edge) in edges.iter().enumerate().take(4) {
            (four.start[0][i], four.start[1][i]) = edge.start.into();
            (four.along[0][i], four.along[1][i]) = edge.along.into();
            four.rounding[i] = edge.rounding;
        }
        four
    }

    /// [`Edge::cross`] of each.
    #[inline]
    fn cross(&self, p: DVec2) -> [f64; 4] {
        let ([from_x, from_y], [x, y]) = (&self.start, &self.along);
        std::array::from_fn(|i| x[i] * (p.y - from_y[i]) - y[i] * (p.x - from_x[i]))
    }
}

/// On which side of a hull's edges a point lies.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    /// A bit for each edge that it lies beyond.
    beyond: u64,
    /// Whether it is farther inside than rounding could put it.
    is_deep: bool,
}

impl Side {
    /// Of points that the hull was made of.
    pub(super) const WITHIN: Side = Side { beyond: 0, is_deep: false };

    /// Whether it lies inside or on an edge.
    #[inline]
    pub(super) fn is_in(self) -> bool {
        self.beyond == 0
    }

    /// Whether it lies inside, by more than rounding.
    #[inline]
    pub(super) fn is_deep(self) -> bool {
        self.is_deep
    }
}

/// Each has a bit of a word.
const MOST_EDGES: usize = 64;

/// A cross product counts as zero below this share of the lengths in it: points that are seen on a line then stay there.
const ROUNDING: f64 = 1e-12;

impl Hull {
    /// Makes it the hull of points. Its edges are found by [`Hull::find_edges`], once they are needed.
    pub(super) fn surround(&mut self, points: impl Iterator<Item = DVec2>) {
        let Hull { points: sorted, corners, edges, .. } = self;
        sorted.clear();
        sorted.extend(points);
        corners.clear();
        edges.clear();
        self.is_left = false;
        let turn = if let [a, b, c, ..] = sorted[..] { (b - a).perp_dot(c - a) } else { 0.0 };
        if turn < 0.0 {
            sorted.reverse();
        }
        if turn != 0.0 && (sorted.len() == 3 || sorted.len() <= MOST_TURNS && turns_left(sorted)) {
            // Most arcs bend to one side.
            self.is_left = turn > 0.0;
            corners.extend_from_slice(sorted);
        } else {
            sorted.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then_with(|| a.y.total_cmp(&b.y)));
            add_chain(corners, sorted.iter());
            add_chain(corners, sorted.iter().rev());
        }
        self.low = corners.iter().fold(DVec2::INFINITY, |low, p| low.min(*p));
        self.high = corners.iter().fold(DVec2::NEG_INFINITY, |high, p| high.max(*p));
    }

    /// Finds its edges, if that has not been done: before points are looked at.
    pub(super) fn find_edges(&mut self) {
        let Hull { corners, edges, fours, low, high, .. } = self;
        if !edges.is_empty() {
            return;
        }
        // No less than the diagonal of its box.
        let size = *high - *low;
        let across = size.x + size.y;
        let edge = |start: DVec2, along: DVec2| Edge::new(start, along, across);
        if let (Some(first), Some(last)) = (corners.first(), corners.last()) {
            edges.extend(corners.array_windows().map(|[u, v]| edge(*u, *v - *u)));
            edges.push(edge(*last, *first - *last));
        }
        if edges.len() > MOST_EDGES {
            // Fewer edges hold more: the long ones, some of the others, and the box.
            let across = size.length();
            let step = edges.len().div_ceil(MOST_EDGES / 2);
            let mut number = 0;
            edges.retain(|edge| {
                number += 1;
                number % step == 0 || edge.along.length() > 0.125 * across
            });
            let (x, y) = (DVec2::X * across, DVec2::Y * across);
            edges.extend([edge(*low, x), edge(*high, -x), edge(*high, y), edge(*low, -y)]);
        }
        fours.clear();
        fours.extend(edges.chunks(4).map(Four::of));
    }

    /// Whether it has an inside.
    pub(super) fn has_area(&self) -> bool {
        self.corners.len() > 2
    }

    /// Whether it is known to lie to the left of all segments from one of its points to the next.
    #[inline]
    pub(super) fn is_left(&self) -> bool {
        self.is_left
    }

    /// Right, upper, left and lower side of its box in single precision, the latter two with the other sign.
    pub(super) fn limits(&self) -> Vec4 {
        let (low, high) = (self.low.as_vec2(), self.high.as_vec2());
        Vec4::new(high.x, high.y, -low.x, -low.y)
    }

    /// Whether a point lies inside, not on an edge.
    #[inline]
    pub(super) fn holds(&mut self, p: DVec2) -> bool {
        if !(p.cmpgt(self.low).all() && p.cmplt(self.high).all()) {
            return false;
        }
        self.find_edges();
        self.edges.iter().all(|edge| is_left(edge.along, p - edge.start))
    }

    /// On which side of its edges a point lies.
    #[inline]
    pub(super) fn side(&self, p: DVec2) -> Side {
        let (mut beyond, mut is_deep) = (0, true);
        for four in self.fours.iter().rev() {
            let cross = four.cross(p);
            let is_beyond = cross.map(|cross| u64::from(cross < 0.0));
            let [a, b, c, d] = is_beyond;
            beyond = beyond << 4 | (a | b << 1 | c << 2 | d << 3);
            is_deep &= (0..4).fold(true, |deep, i| deep & (cross[i] > four.rounding[i]));
        }
        Side { beyond, is_deep }
    }

    /// Whether a segment comes near.
    #[inline]
    pub(super) fn is_near(&self, p: DVec2, q: DVec2) -> bool {
        p.max(q).cmpge(self.low).all() && p.min(q).cmple(self.high).all()
    }

    /// The part of a segment that lies in it, as shares of the segment's length; of its ends it is known on which sides
    /// they lie.
    #[inline]
    pub(super) fn clip(&self, (p, p_side): (DVec2, Side), (q, q_side): (DVec2, Side)) -> Option<(f64, f64)> {
        let mut part = (0.0_f64, 1.0_f64);
        let mut crossed = p_side.beyond | q_side.beyond;
        if crossed == 0 {
            return Some(part);
        }
        if p_side.beyond & q_side.beyond != 0 {
            return None;
        }
        while crossed != 0 {
            self.edges[crossed.trailing_zeros() as usize].cut(p, q, &mut part)?;
            crossed &= crossed - 1;
        }
        (part.0 <= part.1).then_some(part)
    }

    /// Whether some of it lies to the right of the line from `p` to `q`.
    #[inline]
    pub(super) fn reaches_right(&self, p: DVec2, q: DVec2) -> bool {
        let back = p - q;
        self.corners.iter().any(|c| is_left(back, *c - p))
    }
}

/// Whether `to` points to the left of `along`, by more than rounding.
#[inline]
fn is_left(along: DVec2, to: DVec2) -> bool {
    let cross = along.perp_dot(to);
    cross > 0.0 && cross * cross > ROUNDING * ROUNDING * along.length_squared() * to.length_squared()
}

/// An arc of more points hardly ever bends to one side, and is not asked for it.
const MOST_TURNS: usize = 16;

/// Whether points are the corners of a convex polygon, counter-clockwise.
fn turns_left(points: &[DVec2]) -> bool {
    let n = points.len();
    let triples = || (0..n).map(|i| [i, i + 1, i + 2].map(|i| points[if i < n { i } else { i - n }]));
    let is_before = |a: DVec2, b: DVec2| a.x < b.x || a.x == b.x && a.y < b.y;
    triples().all(|[a, b, c]| (b - a).perp_dot(c - a) > 0.0)
        // Once around and not more often.
        && triples().filter(|[a, b, c]| is_before(*b, *a) && is_before(*b, *c)).count() == 1
}

/// Adds one side of a hull, from the first point to the last one, which begins the other side.
fn add_chain<'a>(corners: &mut Vec<DVec2>, points: impl Iterator<Item = &'a DVec2>) {
    let start = corners.len();
    for p in points {
        while let [.., a, b] = corners[start..] {
            if (b - a).perp_dot(*p - a) > 0.0 {
                break;
            }
            corners.pop();
        }
        corners.push(*p);
    }
    corners.pop();
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random_points(n: usize, state: &mut u64) -> Vec<DVec2> {
        let mut unit = || {
            *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            // On a coarse grid, so that points repeat and lie on lines.
            f64::from((*state >> 40) as u32 % 9)
        };
        (0..n).map(|_| DVec2::new(unit(), unit())).collect()
    }

    /// By definition: a point is in the hull unless a line through two of the points has all of them on one side and it
    /// on the other.
    fn is_outside(p: DVec2, points: &[DVec2]) -> bool {
        points.iter().any(|a| {
            points.iter().any(|b| {
                let side = |q: DVec2| (*b - *a).perp_dot(q - *a);
                a != b && side(p) < 0.0 && points.iter().all(|q| side(*q) >= 0.0)
            })
        })
    }

    #[test]
    fn segments_are_clipped_to_what_the_definition_calls_inside() {
        let mut state = 3;
        for n in 3..12 {
            for _ in 0..40 {
                let points = random_points(n, &mut state);
                let mut hull = Hull::default();
                hull.surround(points.iter().copied());
                hull.find_edges();
                if !hull.has_area() {
                    continue;
                }
                let ends = random_points(2, &mut state);
                let (p, q) = (ends[0] * 1.3 - 1.0, ends[1] * 1.3 - 1.0);
                let clipped = hull.clip((p, hull.side(p)), (q, hull.side(q)));
                for i in 0..=200 {
                    let t = f64::from(i) / 200.0;
                    let at = p + (q - p) * t;
                    let within = |room: f64| clipped.is_some_and(|(a, b)| t > a - room && t < b + room);
                    if is_outside(at, &points) {
                        assert!(!within(-1e-9), "{at} is outside");
                        assert!(!hull.holds(at));
                    } else {
                        assert!(within(1e-9), "{at} is inside");
                    }
                }
            }
        }
    }

    /// Half of a disc: one long edge, and far more short ones than there are bits.
    #[test]
    fn a_hull_of_many_corners_holds_all_of_it_and_little_more() {
        let round: Vec<DVec2> = (0..=4000)
            .map(|i| f64::from(i - 2000) / 2000.0)
            .map(|x| DVec2::new(x, (1.0 - x * x).sqrt()))
            .collect();
        let mut hull = Hull::default();
        hull.surround(round.iter().copied());
        hull.find_edges();
        let is_in = |p: DVec2| hull.side(p).is_in();
        assert!(round.iter().all(|p| is_in(*p * 0.999_999)));
        assert!(!round.iter().any(|p| is_in(*p * 1.05)));
        assert!(!is_in(DVec2::new(0.3, -1e-9)) && !is_in(DVec2::new(-40.0, 0.5)));
    }

    /// A star's corners turn to the left as well.
    #[test]
    fn arcs_that_bend_to_one_side_have_the_hull_of_their_points_in_any_order() {
        let corner = |i: usize| [(3., 0.), (1., 3.), (-2., 2.), (-2., -2.), (1., -3.)][i % 5];
        for (step, is_left) in [(1, true), (4, false), (2, false), (3, false)] {
            let points: Vec<DVec2> = (0..5).map(|i| corner(i * step).into()).collect();
            let mut hull = Hull::default();
            hull.surround(points.iter().copied());
            assert_eq!(hull.is_left(), is_left);
            assert_eq!(hull.corners.len(), 5);
            let first = hull.corners.iter().position(|c| *c == points[0]).unwrap();
            let around: Vec<DVec2> = (0..5).map(|i| hull.corners[(first + i) % 5]).collect();
            assert_eq!(around, (0..5).map(|i| corner(i).into()).collect::<Vec<DVec2>>());
        }
    }

    #[test]
    fn a_line_has_some_of_a_square_to_its_right_unless_it_passes_by() {
        let corner = |x: f64, y: f64| DVec2::new(x, y);
        let mut hull = Hull::default();
        hull.surround([corner(0., 0.), corner(1., 0.), corner(1., 1.), corner(0., 1.)].into_iter());
        // Along an edge with the square to the left, and the other way round.
        assert!(!hull.reaches_right(corner(0., 0.), corner(1., 0.)));
        assert!(hull.reaches_right(corner(1., 0.), corner(0., 0.)));
        assert!(hull.reaches_right(corner(0.5, -1.), corner(0.6, 2.)));
    }
}
