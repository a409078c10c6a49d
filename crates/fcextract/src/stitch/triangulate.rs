//! Triangles of one polygon in the plane.
//!
//! Of a polygon with few corners the best of all triangulations is taken: the one that lies nearest to the plane of
//! the cluster, in the mean of the squared height. One with more corners gets a fan if there is one that has all its
//! triangles the right way round, else ears.
//!
//! A polygon that does not cross itself has an ear, and what an ear leaves does not cross itself either. If none is found
//! the polygon crosses itself, and a triangulation of which least is turned over is sought, or, of very many corners, the
//! best of bad ears is cut. The border comes out right in any case.

use super::best::{BEST_UP_TO, Best};
use super::bridge::opens;
use super::grid;
use super::least_turned::{LEAST_TURNED_UP_TO, LeastTurned};
use glam::DVec2;

/// Triangulates polygons; keeps its memory from one to the next.
#[derive(Debug, Default)]
pub(super) struct Triangulator {
    best: Best,
    next: Vec<usize>,
    prev: Vec<usize>,
    /// Of each corner that is left.
    ears: Vec<Ear>,
    least_turned: LeastTurned,
    /// Corners of what ears have left, their places and heights.
    rest: Vec<usize>,
    rest_points: Vec<DVec2>,
    rest_heights: Vec<f64>,
}

/// What is known of the triangle between a corner and those before and after it.
#[derive(Clone, Copy, Debug)]
struct Ear {
    /// Its [`shape`]. That of a corner that has been cut off is what no triangle has.
    quality: f64,
    /// A corner that may be in it: it is not looked at again before that has been cut off. Itself if none is known to be.
    within: usize,
    is_empty: bool,
}

const CUT_OFF: f64 = f64::NEG_INFINITY;

/// Up to so many corners every fan is tried; more corners have a valid fan too seldom to look for it.
const FAN_UP_TO: usize = 16;

impl Triangulator {
    /// Appends the best triangulation of a counter-clockwise polygon, as vertex indices.
    ///
    /// `points` are the corners' places in a plane and `heights` how far they lie above the one that fits best.
    /// A vertex may occur more than once, where a hole was joined; triangles with a vertex twice are left out.
    /// False, and nothing, if it has too many to look for the best, or none is valid.
    pub(super) fn find_best(
        &mut self,
        vertices: &[u32],
        points: &[DVec2],
        heights: &[f64],
        out: &mut Vec<u32>,
    ) -> bool {
        self.set(points, heights) && self.best.show(vertices.len(), |t| push(out, t.map(|k| vertices[k])))
    }

    /// Appends a triangulation of any other polygon, whose corners are on the grid. One that lies `in_plane`, of a cluster
    /// that does not fold over, is worth some time if it crosses itself.
    pub(super) fn find_any(
        &mut self,
        vertices: &[u32],
        points: &[DVec2],
        heights: &[f64],
        in_plane: bool,
        out: &mut Vec<u32>,
    ) {
        let n = vertices.len();
        if n <= FAN_UP_TO
            && let Some(apex) = best_fan(points)
        {
            for i in 1..n - 1 {
                push(out, [apex, (apex + i) % n, (apex + i + 1) % n].map(|k| vertices[k]));
            }
        } else {
            self.cut_ears(vertices, points, heights, in_plane, out);
        }
    }

    /// Hands a polygon of few corners on, in a unit of its own; false if it has too many.
    fn set(&mut self, points: &[DVec2], heights: &[f64]) -> bool {
        if points.len() > BEST_UP_TO {
            return false;
        }
        let size = points.iter().fold(0.0_f64, |size, p| size.max(p.x.abs()).max(p.y.abs()));
        for (i, (p, height)) in points.iter().zip(heights).enumerate() {
            self.best.x[i] = (p.x / size) as f32;
            self.best.y[i] = (p.y / size) as f32;
            self.best.height[i] = (height / size) as f32;
        }
        true
    }

    fn cut_ears(
        &mut self,
        vertices: &[u32],
        points: &[DVec2],
        heights: &[f64],
        in_plane: bool,
        out: &mut Vec<u32>,
    ) {
        let n = vertices.len();
        let start = out.len();
        self.next.clear();
        self.next.extend((0..n).map(|i| (i + 1) % n));
        self.prev.clear();
        self.prev.extend((0..n).map(|i| (i + n - 1) % n));
        self.ears.clear();
        for corner in 0..n {
            self.ears.push(self.ear(points, corner));
        }
        let mut at = 0;
        for left in (3..=n).rev() {
            let is_good;
            (at, is_good) = self.find_ear(points, at, left);
            if !is_good && in_plane && left <= LEAST_TURNED_UP_TO {
                self.rest.clear();
                if n <= LEAST_TURNED_UP_TO {
                    out.truncate(start);
                    self.rest.extend(0..n);
                } else {
                    let following = std::iter::successors(Some(at), |at| Some(self.next[*at]));
                    self.rest.extend(following.take(left));
                }
                self.turn_least(vertices, points, heights, out);
                return;
            }
            let (a, c) = (self.prev[at], self.next[at]);
            push(out, [a, at, c].map(|k| vertices[k]));
            self.next[a] = c;
            self.prev[c] = a;
            self.ears[at].quality = CUT_OFF;
            self.ears[a] = self.ear(points, a);
            self.ears[c] = self.ear(points, c);
            // Going on two corners further spreads the ears around the polygon.
            at = self.next[c];
        }
    }

    /// Appends the triangulation of the corners in `rest` of which least is turned over.
    fn turn_least(&mut self, vertices: &[u32], points: &[DVec2], heights: &[f64], out: &mut Vec<u32>) {
        let Triangulator { least_turned, rest, rest_points, rest_heights, .. } = self;
        rest_points.clear();
        rest_points.extend(rest.iter().map(|&k| points[k]));
        rest_heights.clear();
        rest_heights.extend(rest.iter().map(|&k| heights[k]));
        least_turned.show(rest_points, rest_heights, |t| push(out, t.map(|k| vertices[rest[k]])));
    }

    fn ear(&self, points: &[DVec2], corner: usize) -> Ear {
        let (a, c) = (self.prev[corner], self.next[corner]);
        Ear { quality: shape(points[a], points[corner], points[c]), within: corner, is_empty: false }
    }

    /// The first good ear from `from` on, else the best one, and whether it may be cut: else all are bad.
    fn find_ear(&mut self, points: &[DVec2], from: usize, left: usize) -> (usize, bool) {
        let mut best = (f64::NEG_INFINITY, from);
        let mut corner = from;
        for _ in 0..left {
            let quality = self.ears[corner].quality;
            if quality > best.0 && (quality <= 0.0 || left == 3 || self.is_empty(points, corner)) {
                best = (quality, corner);
                if quality > GOOD_EAR {
                    break;
                }
            }
            corner = self.next[corner];
        }
        (best.1, best.0 > 0.0 || (left == 3 && best.0 == 0.0))
    }

    /// Whether no other corner of the polygon lies in the triangle at one.
    fn is_empty(&mut self, points: &[DVec2], corner: usize) -> bool {
        let ear = self.ears[corner];
        if ear.is_empty || (ear.within != corner && self.ears[ear.within].quality != CUT_OFF) {
            return ear.is_empty;
        }
        let (a, c) = (self.prev[corner], self.next[corner]);
        let [pa, pb, pc] = [a, corner, c].map(|k| points[k]);
        let (low, high) = (pa.min(pb).min(pc), pa.max(pb).max(pc));
        let mut k = self.next[c];
        while k != a {
            let p = points[k];
            let is_near = (p.x >= low.x) & (p.x <= high.x) & (p.y >= low.y) & (p.y <= high.y);
            if is_near && self.is_in(points, [pa, pb, pc], k) {
                // A copy of the tip stays, but its edges may go elsewhere later.
                self.ears[corner].within = if p == pb { corner } else { k };
                return false;
            }
            k = self.next[k];
        }
        self.ears[corner].is_empty = true;
        true
    }

    /// Whether a corner lies in a triangle, or the polygon goes into that from there.
    fn is_in(&self, points: &[DVec2], [a, b, c]: [DVec2; 3], k: usize) -> bool {
        let p = points[k];
        // The other copy of a bridge's end touches the triangle without being in it. Only from the tip the polygon may go
        // through the triangle and out across the cut.
        if p == b {
            return [self.prev[k], self.next[k]].iter().any(|end| opens([a, b, c], points[*end]));
        }
        p != a
            && p != c
            && grid::area(a, b, p) >= 0.0
            && grid::area(b, c, p) >= 0.0
            && grid::area(c, a, p) >= 0.0
    }
}

/// An ear of this shape is taken without looking for a better one (an equilateral triangle has 1).
const GOOD_EAR: f64 = 0.5;

/// The corner whose fan has the best worst triangle; none if every fan has one that is flat or turned over.
fn best_fan(points: &[DVec2]) -> Option<usize> {
    let n = points.len();
    let mut best = (1e-6, None);
    for apex in 0..n {
        let around = |i: usize| points[if apex + i < n { apex + i } else { apex + i - n }];
        // Most fans have a bad triangle soon.
        let mut worst = f64::INFINITY;
        for i in 1..n - 1 {
            worst = worst.min(shape(points[apex], around(i), around(i + 1)));
            if worst <= best.0 {
                break;
            }
        }
        if worst > best.0 {
            best = (worst, Some(apex));
        }
    }
    best.1
}

/// Area over squared edge lengths: 1 for an equilateral triangle, 0 for a flat one, negative if turned over.
fn shape(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let edges = ab.length_squared() + bc.length_squared() + ca.length_squared();
    // 2 sqrt(3) makes it 1 for equal edges.
    if edges > 0.0 { grid::area(a, b, c) * 3.464_101_615_137_754_6 / edges } else { 0.0 }
}

/// Appends a triangle, if it has three corners.
pub(super) fn push(out: &mut Vec<u32>, triangle: [u32; 3]) {
    let [a, b, c] = triangle;
    if a != b && b != c && c != a {
        out.extend(triangle);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    fn run_with(vertices: &[u32], points: &[DVec2], heights: &[f64], out: &mut Vec<u32>) {
        let mut triangulator = Triangulator::default();
        let mut points = points.to_vec();
        let scale = grid::snap(&mut points);
        let heights: Vec<f64> = heights.iter().map(|h| h * scale).collect();
        if !triangulator.find_best(vertices, &points, &heights, out) {
            triangulator.find_any(vertices, &points, &heights, true, out);
        }
    }

    fn run(points: &[DVec2]) -> Vec<u32> {
        let mut out = Vec::new();
        let vertices: Vec<u32> = (0..points.len() as u32).collect();
        run_with(&vertices, points, &vec![0.0; points.len()], &mut out);
        out
    }

    fn border(triangles: &[u32]) -> Vec<(u32, u32)> {
        let mut net = BTreeMap::new();
        for t in triangles.chunks(3) {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                *net.entry((a, b)).or_insert(0) += 1;
                *net.entry((b, a)).or_insert(0) -= 1;
            }
        }
        net.into_iter().filter(|(_, n)| *n > 0).map(|(e, _)| e).collect()
    }

    fn area(points: &[DVec2], triangles: &[u32]) -> (f64, f64) {
        let double = |t: &[u32]| {
            let [a, b, c] = [t[0], t[1], t[2]].map(|k| points[k as usize]);
            (b - a).perp_dot(c - a)
        };
        let signed = triangles.chunks(3).map(double).sum();
        (signed, triangles.chunks(3).map(|t| double(t).abs()).sum())
    }

    /// A saddle: the chord between the low corners or the one between the high ones, by where the plane is.
    #[test]
    fn diagonals_follow_the_plane() {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec2::new(x, y));
        let has_edge =
            |triangles: &[u32], a: u32, b: u32| triangles.chunks(3).all(|t| t.contains(&a) && t.contains(&b));
        for (level, [a, b]) in [(0.1, [0, 2]), (-0.1, [1, 3])] {
            // Corners 0 and 2 are high.
            let heights = [1.0, -1.0, 1.0, -1.0].map(|h| h - 5.0 * level);
            let mut out = Vec::new();
            run_with(&[0, 1, 2, 3], &square, &heights, &mut out);
            assert!(has_edge(&out, a, b), "{level}: {out:?}");
        }
    }

    #[test]
    fn simple_polygons_are_covered_once_and_garbage_keeps_its_border() {
        let mut state = 5_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f64 / (1 << 24) as f64
        };
        for round in 0..400 {
            let n = 3 + round % 40;
            let star: Vec<DVec2> = (0..n)
                .map(|i| {
                    let angle = std::f64::consts::TAU * (i as f64 + 0.5 * random()) / n as f64;
                    DVec2::new(angle.cos(), angle.sin()) * (0.3 + random())
                })
                .collect();
            let ring: Vec<(u32, u32)> = (0..n as u32).map(|i| (i, (i + 1) % n as u32)).collect();
            let sorted = |mut edges: Vec<(u32, u32)>| {
                edges.sort_unstable();
                edges
            };
            let triangles = run(&star);
            let (signed, absolute) = area(&star, &triangles);
            assert_eq!(triangles.len(), 3 * (n - 2));
            assert_eq!(border(&triangles), sorted(ring.clone()));
            assert!(absolute - signed < 1e-9 * absolute, "{n} corners overlap: {signed} of {absolute}");
            let garbage: Vec<DVec2> = (0..n).map(|_| DVec2::new(random(), random())).collect();
            assert_eq!(border(&run(&garbage)), sorted(ring));
        }
    }
}
