//! The triangulation of a polygon in the plane of which least is turned over.
//!
//! Where the polygon has a valid triangulation nothing is, and this is one: triangles that are all the right way round
//! cover what the polygon winds around, as often as it does. Where it crosses itself the overlap stays as small as it
//! can be. Of several triangulations the one is taken that lies nearest to the plane of the cluster, as in
//! [`super::best`], without thin triangles if possible.

use super::grid;
use glam::DVec2;

/// Up to so many corners it is sought: its time grows with the cube of their number.
pub(super) const LEAST_TURNED_UP_TO: usize = 128;

/// Twice the area of a triangle that counts as thin, over its squared edges.
const THIN: f64 = 1e-4;

/// What a long edge costs beside height: it decides where all is flat, and nowhere else.
const WELL_SHAPED: f64 = 1e-8;

/// Finds triangulations; keeps its memory from one to the next.
#[derive(Debug, Default)]
pub(super) struct LeastTurned {
    /// By the first and the last corner of a part of the polygon.
    parts: Vec<Part>,
    waiting: Vec<(usize, usize)>,
}

/// The best triangulation of a part of the polygon.
#[derive(Clone, Copy, Debug, Default)]
struct Part {
    /// Twice the area that is turned over.
    turned: f64,
    /// How far it is from the plane of the cluster, and how thin its triangles are.
    cost: f64,
    /// The third corner of the triangle on the part's chord.
    third: usize,
}

impl LeastTurned {
    /// Shows the triangles, corner by corner in the direction of the polygon: its corners are on the grid, and above
    /// the plane of the cluster by `heights`, in steps of the grid.
    pub(super) fn show(&mut self, points: &[DVec2], heights: &[f64], mut show: impl FnMut([usize; 3])) {
        let n = points.len().min(heights.len());
        if n < 3 {
            return;
        }
        let size = points.iter().fold(1.0_f64, |size, p| size.max(p.x.abs()).max(p.y.abs()));
        self.parts.clear();
        self.parts.resize(n * n, Part::default());
        for span in 2..n {
            for first in 0..n - span {
                self.join(points, heights, size, (first, first + span));
            }
        }
        self.waiting.clear();
        self.waiting.push((0, n - 1));
        while let Some((first, last)) = self.waiting.pop() {
            if last - first > 1 {
                let third = self.parts[first * n + last].third;
                show([first, third, last]);
                self.waiting.extend([(third, last), (first, third)]);
            }
        }
    }

    /// Finds the best triangulation of a part by those of smaller ones.
    fn join(&mut self, points: &[DVec2], heights: &[f64], size: f64, (first, last): (usize, usize)) {
        let n = points.len().min(heights.len());
        let mut least = Part { turned: f64::INFINITY, cost: f64::INFINITY, third: first + 1 };
        let (a, c) = (points[first], points[last]);
        let part = |p: usize, q: usize| {
            let height = heights[p] + heights[q];
            let squared = points[p].distance_squared(points[q]);
            (0.5 * height * height + WELL_SHAPED * squared, squared)
        };
        let (own, squared) = part(first, last);
        for (third, b) in (first + 1..).zip(&points[first + 1..last]) {
            let (left, right) = (&self.parts[first * n + third], &self.parts[third * n + last]);
            let turned = left.turned + right.turned;
            if turned > least.turned {
                continue;
            }
            let area = grid::area(a, *b, c);
            let turned = turned + (-area).max(0.0);
            if turned > least.turned {
                continue;
            }
            let ((before, ab), (after, bc)) = (part(first, third), part(third, last));
            let missing = (THIN * (squared + ab + bc) - area).max(0.0);
            let cost = left.cost + right.cost + area.abs() * (own + before + after) + missing * (size * size);
            if turned < least.turned || cost < least.cost {
                least = Part { turned, cost, third };
            }
        }
        self.parts[first * n + last] = least;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Tries all triangulations of the corners from `first` to `last`, one by one.
    fn naive(points: &[DVec2], first: usize, last: usize) -> f64 {
        let with = |third: usize| {
            let turned = (-grid::area(points[first], points[third], points[last])).max(0.0);
            turned + naive(points, first, third) + naive(points, third, last)
        };
        (first + 1..last).map(with).reduce(f64::min).unwrap_or(0.0)
    }

    fn found(points: &[DVec2], heights: &[f64]) -> Vec<[usize; 3]> {
        let mut least_turned = LeastTurned::default();
        // What a larger polygon has left must not matter.
        least_turned.show(&[DVec2::ONE; 12], &[3.0; 12], |_| ());
        let mut triangles = Vec::new();
        least_turned.show(points, heights, |t| triangles.push(t));
        triangles
    }

    proptest! {
        /// Corners anywhere, many on others or in line with them.
        #[test]
        fn no_triangulation_turns_less_over(
            corners in prop::collection::vec([-6_i32..6, -6_i32..6, -3_i32..3], 3..=9)
        ) {
            let points: Vec<DVec2> =
                corners.iter().map(|[x, y, _]| DVec2::new(f64::from(*x), f64::from(*y))).collect();
            let heights: Vec<f64> = corners.iter().map(|[_, _, h]| f64::from(*h)).collect();
            let triangles = found(&points, &heights);
            prop_assert_eq!(triangles.len(), points.len() - 2);
            let turned = |t: &[usize; 3]| {
                let [a, b, c] = t.map(|k| points[k]);
                (-grid::area(a, b, c)).max(0.0)
            };
            let sum: f64 = triangles.iter().map(turned).sum();
            prop_assert_eq!(sum, naive(&points, 0, points.len() - 1));
        }
    }

    /// A saddle: both ways are valid, and the one along the ridge that the plane goes through is nearer to it.
    #[test]
    fn of_valid_ones_the_nearest_to_the_plane_is_taken() {
        let square = [(0.0, 0.0), (8.0, 0.0), (8.0, 8.0), (0.0, 8.0)].map(DVec2::from);
        let has_edge = |triangles: &[[usize; 3]], a: usize, b: usize| {
            triangles.iter().all(|t| t.contains(&a) && t.contains(&b))
        };
        assert!(has_edge(&found(&square, &[0.0, -2.0, 0.0, -2.0]), 0, 2));
        assert!(has_edge(&found(&square, &[-2.0, 0.0, -2.0, 0.0]), 1, 3));
    }
}
