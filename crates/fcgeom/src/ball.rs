//! A small ball around a set of points, in `f64`: the common ground of spheres and normal cones.

use glam::DVec3;

/// A ball that holds a set of points up to rounding; the caller measures the final radius itself.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball {
    pub(crate) center: DVec3,
    pub(crate) radius: f64,
}

/// Rounds of shrinking and growing again at most. Each is one pass over the points.
const ROUNDS: usize = 4;

/// By how much the ball shrinks before it grows again: little finds nothing new, much forgets where it was.
const SHRINK: f64 = 0.9;

/// No ball is smaller than half the farthest distance. One within this factor of that is not worth another pass.
const GOOD_ENOUGH: f64 = 1.01;

/// Directions whose extreme points start the ball: the axes and the diagonals of the cube.
const DIRECTIONS: [DVec3; 7] = [
    DVec3::X,
    DVec3::Y,
    DVec3::Z,
    DVec3::new(1.0, 1.0, 1.0),
    DVec3::new(1.0, 1.0, -1.0),
    DVec3::new(1.0, -1.0, 1.0),
    DVec3::new(1.0, -1.0, -1.0),
];

impl Ball {
    /// A ball around the points, a few percent larger than the smallest one; `None` for no points.
    pub(crate) fn around(points: impl Iterator<Item = DVec3> + Clone) -> Option<Self> {
        Some(Self::across_extremes(points.clone())?.grown_around(points))
    }

    /// The ball whose diameter is the farthest of the pairs that are extreme along one direction: no ball around the
    /// points is smaller.
    pub(crate) fn across_extremes(mut points: impl Iterator<Item = DVec3>) -> Option<Self> {
        let first = points.next()?;
        let heights = |p: DVec3| DIRECTIONS.map(|d| d.dot(p));
        let (mut low, mut high) = (heights(first), heights(first));
        let (mut lowest, mut highest) = ([first; DIRECTIONS.len()], [first; DIRECTIONS.len()]);
        for p in points {
            let heights = heights(p);
            // Few points are extreme; to find that out without a branch for each direction halves the time.
            let mut extreme = false;
            for ((h, low), high) in heights.iter().zip(&low).zip(&high) {
                extreme |= (h < low) | (h > high);
            }
            if extreme {
                for (i, h) in heights.into_iter().enumerate() {
                    if h < low[i] {
                        (low[i], lowest[i]) = (h, p);
                    }
                    if h > high[i] {
                        (high[i], highest[i]) = (h, p);
                    }
                }
            }
        }
        let mut best = Self { center: first, radius: 0.0 };
        for (low, high) in lowest.into_iter().zip(highest) {
            let radius = low.distance(high) * 0.5;
            if radius > best.radius {
                best = Self { center: (low + high) * 0.5, radius };
            }
        }
        Some(best)
    }

    /// A ball around the points, started from that of their extremes.
    ///
    /// Ritter's method: grown by each point outside; then the same again from a shrunken ball, as long as that helps.
    pub(crate) fn grown_around(self, points: impl Iterator<Item = DVec3> + Clone) -> Self {
        let good_enough = self.radius * GOOD_ENOUGH;
        let mut best = self.grown(points.clone());
        for _ in 0..ROUNDS {
            if best.radius <= good_enough {
                break;
            }
            let ball = Self { radius: best.radius * SHRINK, ..best }.grown(points.clone());
            if ball.radius >= best.radius {
                break;
            }
            best = ball;
        }
        best
    }

    /// The ball grown, point by point, just so far that it holds the point and all that it held.
    fn grown(self, points: impl Iterator<Item = DVec3>) -> Self {
        let mut ball = self;
        for p in points {
            let offset = p - ball.center;
            let squared = offset.length_squared();
            if squared > ball.radius * ball.radius {
                let distance = squared.sqrt();
                let radius = 0.5 * (ball.radius + distance);
                ball.center += offset * ((distance - radius) / distance);
                ball.radius = radius;
            }
        }
        ball
    }
}
