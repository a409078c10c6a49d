//! Naive definitions: integrals as sums over sample points, smallest balls by trying all subsets.

use glam::{DMat3, DVec3};

/// A sample of a surface: its share of the area, its position and its normal.
pub(super) struct Sample {
    pub(super) weight: f64,
    pub(super) r: DVec3,
    pub(super) n: DVec3,
}

/// `a b^T`.
pub(super) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// The three midpoints of the edges with a third of the area each: exact for polynomials of degree two.
pub(super) fn samples(triangles: &[[DVec3; 3]]) -> Vec<Sample> {
    let mut samples = Vec::new();
    for [a, b, c] in triangles {
        let cross = (b - a).cross(c - a);
        let n = cross.normalize_or_zero();
        for r in [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5] {
            samples.push(Sample { weight: cross.length() / 6.0, r, n });
        }
    }
    samples
}

/// Every triangle cut into `k * k` congruent ones.
pub(super) fn subdivided(triangles: &[[DVec3; 3]], k: usize) -> Vec<[DVec3; 3]> {
    let mut out = Vec::new();
    for [a, b, c] in triangles {
        let at = |i: usize, j: usize| a + (b - a) * (i as f64 / k as f64) + (c - a) * (j as f64 / k as f64);
        for i in 0..k {
            for j in 0..k - i {
                out.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                if i + j + 1 < k {
                    out.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
    out
}

/// The covariances as the paper defines them: integrals of products of deviations from the means
/// (`[Tsuji07, eq. 3, 9, 12]`): `Z_rr`, `Z_nn`, `Z_rn`.
pub(super) fn covariances(samples: &[Sample]) -> (DMat3, DMat3, DMat3) {
    let area: f64 = samples.iter().map(|s| s.weight).sum();
    let mean_r = samples.iter().map(|s| s.r * s.weight).sum::<DVec3>() / area;
    let mean_n = samples.iter().map(|s| s.n * s.weight).sum::<DVec3>() / area;
    let (mut rr, mut nn, mut rn) = (DMat3::ZERO, DMat3::ZERO, DMat3::ZERO);
    for s in samples {
        let share = s.weight / area;
        rr += outer(s.r - mean_r, s.r - mean_r) * share;
        nn += outer(s.n - mean_n, s.n - mean_n) * share;
        rn += outer(s.r - mean_r, s.n - mean_n) * share;
    }
    (rr, nn, rn)
}

/// Centre and radius of the smallest ball: the smallest of all balls through two, three or four of the points that
/// contains the rest. For a dozen points.
pub(super) fn smallest_ball(points: &[DVec3]) -> (DVec3, f64) {
    let contains_all = |center: DVec3, radius: f64| {
        points.iter().all(|p| p.distance(center) <= radius * (1.0 + 1.0e-9) + 1.0e-12)
    };
    let mut best = (DVec3::ZERO, f64::INFINITY);
    if points.iter().all(|p| *p == points[0]) {
        return (points[0], 0.0);
    }
    let mut consider = |center: DVec3, on: DVec3| {
        let radius = center.distance(on);
        if radius < best.1 && contains_all(center, radius) {
            best = (center, radius);
        }
    };
    let n = points.len();
    for i in 0..n {
        for j in 0..i {
            consider((points[i] + points[j]) * 0.5, points[i]);
            for k in 0..j {
                let (u, v) = (points[j] - points[i], points[k] - points[i]);
                let w = u.cross(v);
                // The circumcentre of three points solves three linear equations, the last of which keeps it in
                // their plane; of four points, it is at the same distance from all.
                let rhs = DVec3::new(u.length_squared() * 0.5, v.length_squared() * 0.5, 0.0);
                if let Some(c) = solve(u, v, w, rhs) {
                    consider(points[i] + c, points[i]);
                }
                for l in 0..k {
                    let x = points[l] - points[i];
                    let rhs = DVec3::new(rhs.x, rhs.y, x.length_squared() * 0.5);
                    if let Some(c) = solve(u, v, x, rhs) {
                        consider(points[i] + c, points[i]);
                    }
                }
            }
        }
    }
    best
}

/// The point `c` with `c . u`, `c . v`, `c . w` as given.
fn solve(u: DVec3, v: DVec3, w: DVec3, rhs: DVec3) -> Option<DVec3> {
    let m = DMat3::from_cols(u, v, w).transpose();
    (m.determinant().abs() > 1.0e-12).then(|| m.inverse() * rhs)
}
