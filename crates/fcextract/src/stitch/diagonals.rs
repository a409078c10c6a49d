//! The triangulation of a polygon in space that has the shortest diagonals.
//!
//! The polygon of a cluster that folds over mostly overlaps itself in every plane. The diagonals whose squares sum up to
//! the least join what is near in space. Where a hole is joined to the outline, both may come out closed, each for
//! itself: the two copies of an end of the bridge are as near as can be.

use glam::DVec3;

/// Up to so many corners it is sought: its time grows with the cube of their number.
pub(super) const DIAGONALS_UP_TO: usize = 64;

/// Finds triangulations; keeps its memory from one to the next.
#[derive(Debug, Default)]
pub(super) struct Diagonals {
    /// By the first and the last corner: the least sum between them, their own diagonal included, and the third corner
    /// of the triangle there.
    best: Vec<(f64, usize)>,
    waiting: Vec<(usize, usize)>,
}

impl Diagonals {
    /// Shows the triangles, corner by corner in the direction of the polygon.
    pub(super) fn show(&mut self, corners: &[DVec3], mut show: impl FnMut([usize; 3])) {
        let n = corners.len();
        if n < 3 {
            return;
        }
        self.best.clear();
        self.best.resize(n * n, (0.0, 0));
        for span in 2..n {
            for first in 0..n - span {
                let last = first + span;
                let mut least = (f64::INFINITY, first + 1);
                for third in first + 1..last {
                    let sum = self.best[first * n + third].0 + self.best[third * n + last].0;
                    least = if sum < least.0 { (sum, third) } else { least };
                }
                self.best[first * n + last] =
                    (least.0 + corners[first].distance_squared(corners[last]), least.1);
            }
        }
        self.waiting.clear();
        self.waiting.push((0, n - 1));
        while let Some((first, last)) = self.waiting.pop() {
            if last - first > 1 {
                let third = self.best[first * n + last].1;
                show([first, third, last]);
                self.waiting.extend([(third, last), (first, third)]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn found(corners: &[DVec3]) -> Vec<[usize; 3]> {
        let mut triangles = Vec::new();
        let mut diagonals = Diagonals::default();
        // What a larger polygon has left must not matter.
        diagonals.show(&[DVec3::ONE; 9], |_| ());
        diagonals.show(corners, |t| triangles.push(t));
        triangles
    }

    /// Tries all triangulations of the corners from `first` to `last`, one by one.
    fn naive(corners: &[DVec3], first: usize, last: usize) -> f64 {
        let diagonal =
            |a: usize, b: usize| if b - a > 1 { corners[a].distance_squared(corners[b]) } else { 0.0 };
        let with = |third: usize| {
            let sides = diagonal(first, third) + diagonal(third, last);
            sides + naive(corners, first, third) + naive(corners, third, last)
        };
        (first + 1..last).map(with).reduce(f64::min).unwrap_or(0.0)
    }

    /// Squares of all edges of the triangles, those of the border once and diagonals twice.
    fn edges(corners: &[DVec3], triangles: &[[usize; 3]]) -> f64 {
        let edge = |a: usize, b: usize| corners[a].distance_squared(corners[b]);
        triangles.iter().map(|[a, b, c]| edge(*a, *b) + edge(*b, *c) + edge(*c, *a)).sum()
    }

    proptest! {
        #[test]
        fn no_triangulation_has_shorter_diagonals(
            corners in prop::collection::vec((-1.0..1.0, -1.0..1.0, -1.0..1.0), 3..=9)
        ) {
            let corners: Vec<DVec3> = corners.into_iter().map(DVec3::from).collect();
            let n = corners.len();
            let triangles = found(&corners);
            prop_assert_eq!(triangles.len(), n - 2);
            for [a, b, c] in &triangles {
                prop_assert!(a < b && b < c && *c < n);
            }
            let border: f64 = (0..n).map(|i| corners[i].distance_squared(corners[(i + 1) % n])).sum();
            let diagonals = 0.5 * (edges(&corners, &triangles) - border);
            prop_assert!((diagonals - naive(&corners, 0, n - 1)).abs() < 1e-9);
        }
    }

    /// A strip bent over to a U: its plane would show it as a line.
    #[test]
    fn a_bent_strip_gets_rungs() {
        let along = |i: usize| [(0.0, 0.0), (1.0, 0.0), (2.0, 0.5), (1.0, 1.0), (0.0, 1.0)][i];
        let corner = |i: usize| if i < 5 { (along(i), 0.0) } else { (along(9 - i), 0.3) };
        let corners: Vec<DVec3> = (0..10).map(corner).map(|((x, z), y)| DVec3::new(x, y, z)).collect();
        for [a, b, c] in found(&corners) {
            let longest = [(a, b), (b, c), (c, a)].map(|(a, b)| corners[a].distance(corners[b])).into_iter();
            assert!(longest.fold(0.0, f64::max) < 1.2, "{a} {b} {c}");
        }
    }

    #[test]
    fn what_is_no_polygon_has_no_triangles() {
        assert!(found(&[]).is_empty() && found(&[DVec3::ZERO; 2]).is_empty());
        // Numbers that are none still leave the border as it is.
        assert_eq!(found(&[DVec3::NAN; 5]).len(), 3);
    }
}
