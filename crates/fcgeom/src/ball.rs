//! A small ball around a set of points, in `f64`: the common ground of spheres and normal cones.

use glam::DVec3;

/// What the search for a ball asks of a set of points, however it is stored.
pub(crate) trait Cloud {
    /// The point farthest from `p` and about its square distance; `None` if no distance is a number.
    fn farthest_from(&self, p: DVec3) -> Option<(DVec3, f64)>;
}

/// The points of an iterator that can be gone through repeatedly.
///
/// Points that are not numbers are passed over by searches and make measurements NaN.
pub(crate) struct Each<I>(pub(crate) I);

impl<I: Iterator<Item = DVec3> + Clone> Each<I> {
    /// Any point; `None` if there is none.
    pub(crate) fn first(&self) -> Option<DVec3> {
        self.0.clone().next()
    }

    /// The largest square distance from `center`.
    pub(crate) fn largest_square_distance(&self, center: DVec3) -> f64 {
        let mut largest = 0.0f64;
        for p in self.0.clone() {
            let d = p.distance_squared(center);
            if d.is_nan() {
                return d;
            }
            largest = largest.max(d);
        }
        largest
    }
}

impl<I: Iterator<Item = DVec3> + Clone> Cloud for Each<I> {
    fn farthest_from(&self, p: DVec3) -> Option<(DVec3, f64)> {
        let (mut best, mut farthest) = (None, -1.0);
        for q in self.0.clone() {
            let d = p.distance_squared(q);
            if d > farthest {
                (best, farthest) = (Some((q, d)), d);
            }
        }
        best
    }
}

/// A ball that holds a set of points up to rounding; the caller measures the final radius itself.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    pub(crate) center: DVec3,
    pub(crate) radius: f64,
}

/// Passes over the points at most, after the two that find the first pair.
const PASSES: usize = 4;

/// No ball is smaller than that around two or three of the points. One within this factor of that is not worth
/// another pass.
const GOOD_ENOUGH: f64 = 1.02;

/// By how much the ball shrinks before it grows again: little finds nothing new, much forgets where it was.
const SHRINK: f64 = 0.94;

/// A pair of points nearly as far apart as any.
pub(crate) struct Pair {
    points: [DVec3; 2],
    from_start: f64,
}

impl Pair {
    /// The point farthest from `start`, and the point farthest from that.
    pub(crate) fn of(cloud: &impl Cloud, start: DVec3) -> Option<Self> {
        let (p, from_start) = cloud.farthest_from(start)?;
        let (q, _) = cloud.farthest_from(p)?;
        Some(Self { points: [p, q], from_start })
    }

    /// The square of the largest distance of any point from the start of the search.
    pub(crate) fn square_reach(&self) -> f64 {
        self.from_start
    }

    /// The ball across: no ball around the points is smaller.
    pub(crate) fn ball(&self) -> Ball {
        let [p, q] = self.points;
        Ball::across(p, q)
    }

    /// A ball around the points, a few percent larger than the smallest one.
    ///
    /// Few points touch the smallest ball, and mostly two or three where the points lie about a plane: the pair,
    /// and then the point farthest outside it, are tried first.
    /// From there it is Ritter's method with the farthest point first: the ball grows just so far that it holds the
    /// farthest point outside and all of the ball before, until no point is outside; then the same again from a
    /// shrunken ball. The smallest of the balls that the passes measure is taken.
    pub(crate) fn grown_around(&self, cloud: &impl Cloud) -> Ball {
        let mut ball = self.ball();
        let mut smallest = ball.radius;
        let mut best = Ball { radius: f64::INFINITY, ..ball };
        for pass in 0..PASSES {
            let Some((farthest, squared)) = cloud.farthest_from(ball.center) else { break };
            let distance = squared.sqrt();
            if distance < best.radius {
                best = Ball { center: ball.center, radius: distance };
            }
            if distance <= smallest * GOOD_ENOUGH {
                break;
            }
            if pass == 0 {
                ball = Ball::around_three(self.points[0], self.points[1], farthest);
                smallest = ball.radius;
                continue;
            }
            if distance <= ball.radius {
                ball.radius = distance * SHRINK;
            }
            let radius = 0.5 * (ball.radius + distance);
            ball.center += (farthest - ball.center) * ((distance - radius) / distance);
            ball.radius = radius;
        }
        best
    }
}

impl Ball {
    /// The ball whose diameter two points span.
    pub(crate) fn across(p: DVec3, q: DVec3) -> Ball {
        Ball { center: (p + q) * 0.5, radius: p.distance(q) * 0.5 }
    }

    /// The smallest ball around three points.
    fn around_three(p: DVec3, q: DVec3, r: DVec3) -> Ball {
        let (a, b) = (q - p, r - p);
        let (aa, bb, ab) = (a.length_squared(), b.length_squared(), a.dot(b));
        // Corners of 90 degrees and more: the ball across the side opposite.
        if ab <= 0.0 {
            return Self::across(q, r);
        }
        if aa <= ab {
            return Self::across(p, r);
        }
        if bb <= ab {
            return Self::across(p, q);
        }
        let det = 2.0 * (aa * bb - ab * ab);
        if det <= 0.0 {
            return Self::across(p, q);
        }
        let to_center = a * (bb * (aa - ab) / det) + b * (aa * (bb - ab) / det);
        Ball { center: p + to_center, radius: to_center.length() }
    }
}
