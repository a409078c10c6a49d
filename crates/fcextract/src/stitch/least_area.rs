//! The triangulation of least area of a polygon in space.

use glam::DVec3;

fn mode() -> u32 { static M: std::sync::OnceLock<u32> = std::sync::OnceLock::new(); *M.get_or_init(|| std::env::var("MODE").ok().and_then(|m| m.parse().ok()).unwrap_or(0)) }


/// Up to so many corners it is sought: its time grows with the cube of their number.
pub(super) const LEAST_AREA_UP_TO: usize = 64;

/// Finds triangulations; keeps its memory from one to the next.
#[derive(Debug, Default)]
pub(super) struct LeastArea {
    /// By the first and the last corner: the least area of what is between, and the third corner of the triangle there.
    best: Vec<(f64, usize)>,
    waiting: Vec<(usize, usize)>,
}

impl LeastArea {
    /// Shows the triangles, in the direction of the polygon.
    pub(super) fn show(&mut self, corners: &[DVec3], axis: DVec3, mut show: impl FnMut([usize; 3])) {
        let n = corners.len();
        self.best.clear();
        self.best.resize(n * n, (0.0, 0));
        for span in 2..n {
            for first in 0..n - span {
                let last = first + span;
                let mut least = (f64::INFINITY, first + 1);
                for third in first + 1..last {
                    let (a, b, c) = (corners[first], corners[third], corners[last]);
                    let area = match mode() {
                        1 => (b - a).cross(c - a).length().powf(1.5),
                        2 => (b - a).cross(c - a).length() + 0.05 * ((b - a).length_squared() + (c - a).length_squared() + (c - b).length_squared()),
                        3 => (b - a).cross(c - a).length() + 0.15 * ((b - a).length_squared() + (c - a).length_squared() + (c - b).length_squared()),
                        4 => (b - a).length() + (c - a).length() + (c - b).length(),
                        7 => (b - a).length() + (c - a).length() + (c - b).length() + (b - a).cross(c - a).length().sqrt(),
                        8 => (b - a).length_squared() + (c - a).length_squared() + (c - b).length_squared(),
                        9 => (b - a).length().sqrt() + (c - a).length().sqrt() + (c - b).length().sqrt(),
                        5 => { let x = (b - a).cross(c - a); x.length() - 0.5 * x.dot(axis) }
                        6 => { let x = (b - a).cross(c - a); x.length() - 0.2 * x.dot(axis) }
                        _ => (b - a).cross(c - a).length(),
                    };
                    let sum = area + self.best[first * n + third].0 + self.best[third * n + last].0;
                    if sum < least.0 {
                        least = (sum, third);
                    }
                }
                self.best[first * n + last] = least;
            }
        }
        self.waiting.clear();
        self.waiting.push((0, n - 1));
        while let Some((first, last)) = self.waiting.pop() {
            if last < first + 2 {
                continue;
            }
            let third = self.best[first * n + last].1;
            show([first, third, last]);
            self.waiting.extend([(first, third), (third, last)]);
        }
    }
}
