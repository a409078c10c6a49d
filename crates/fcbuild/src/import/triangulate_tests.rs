//! Promises: n - 2 triangles that use every corner, the polygon's area and winding, bounded time.

use std::time::{Duration, Instant};

use super::super::testing::Random;
use super::*;

fn cut(points: &[[f64; 3]]) -> (Vec<[u32; 3]>, Verdict) {
    let corners: Vec<u32> = (0..points.len() as u32).collect();
    let mut out = Vec::new();
    let verdict = Triangulator::default().triangulate(|i| points[i as usize], &corners, &mut out);
    assert_eq!(out.len(), points.len() - 2);
    let mut used = vec![false; points.len()];
    out.iter().flatten().for_each(|&i| used[i as usize] = true);
    assert!(used.iter().all(|&u| u), "every corner is used");
    (out, verdict)
}

fn area(points: &[[f64; 3]], t: [u32; 3]) -> [f64; 3] {
    let [a, b, c] = t.map(|i| points[i as usize]);
    cross(sub(b, a), sub(c, a)).map(|x| x / 2.0)
}

/// A simple polygon is tiled when no triangle is turned round and the areas add up.
fn assert_tiled(points: &[[f64; 3]]) {
    let (triangles, verdict) = cut(points);
    assert_eq!(verdict, Verdict::Simple);
    let whole = newell(points.iter().copied()).map(|x| x / 2.0);
    let mut sum = [0.0; 3];
    for &t in &triangles {
        let a = area(points, t);
        assert!(dot(a, whole) >= -1e-12 * dot(whole, whole), "triangle {t:?} is turned round");
        for k in 0..3 {
            sum[k] += a[k];
        }
    }
    let error = dot(sub(sum, whole), sub(sum, whole)).sqrt();
    assert!(error <= 1e-9 * dot(whole, whole).sqrt(), "areas differ by {error}");
}

fn flat(points: &[[f64; 2]]) -> Vec<[f64; 3]> {
    points.iter().map(|&[x, y]| [x, y, 0.0]).collect()
}

/// A star-shaped outline in a tilted plane with random radii: simple, and as concave as may be.
fn star(n: usize, random: &mut Random) -> Vec<[f64; 3]> {
    (0..n)
        .map(|i| {
            let angle = i as f64 / n as f64 * std::f64::consts::TAU;
            let r = 0.2 + random.unit();
            let (x, y) = (r * angle.cos(), r * angle.sin());
            [x, y * 0.6, y * 0.8 + 100.0]
        })
        .collect()
}

#[test]
fn quads_take_the_shorter_valid_diagonal() {
    let kite = flat(&[[0.0, 0.0], [1.0, -1.0], [5.0, 0.0], [1.0, 1.0]]);
    assert_eq!(cut(&kite).0, [[0, 1, 3], [1, 2, 3]]);
    let square = flat(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    assert_eq!(cut(&square).0, [[0, 1, 2], [0, 2, 3]]);
    for turn in 0..4 {
        // An arrow head: only the diagonal through the notch lies inside.
        let mut arrow = flat(&[[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [0.5, 1.0]]);
        arrow.rotate_left(turn);
        assert_tiled(&arrow);
        arrow.reverse();
        assert_tiled(&arrow);
    }
    let bow_tie = flat(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]);
    assert_eq!(cut(&bow_tie).1, Verdict::SelfCrossing);
}

#[test]
fn convex_polygons_become_fans() {
    let thirty: Vec<[f64; 3]> = (0..30)
        .map(|i| {
            let a = i as f64 / 30.0 * std::f64::consts::TAU;
            [a.cos(), 3.0, a.sin()]
        })
        .collect();
    assert_tiled(&thirty);
    assert!(cut(&thirty).0.iter().all(|t| t[0] == 0));
}

#[test]
fn concave_polygons_are_tiled() {
    let mut random = Random(7);
    for n in [5, 6, 7, 10, 33, 200, 3000] {
        for _ in 0..(3000 / n).clamp(1, 60) {
            let mut points = star(n, &mut random);
            assert_tiled(&points);
            points.reverse();
            assert_tiled(&points);
        }
    }
    // A comb, whose teeth block most ears of the far side.
    let mut comb = vec![[-1.0, -1.0], [201.0, -1.0]];
    comb.extend((0..=200).rev().map(|i| [i as f64, if i % 2 == 0 { 10.0 } else { 0.0 }]));
    assert_tiled(&flat(&comb));
}

#[test]
fn corners_on_a_straight_edge_are_kept() {
    let l = flat(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.0, 1.0], [0.0, 0.5]]);
    assert_tiled(&l);
    assert!(cut(&l).0.iter().all(|&t| area(&l, t)[2] > 0.0), "no sliver on the straight edge");
}

#[test]
fn a_hole_joined_by_a_double_edge_is_tiled() {
    let ring = [
        [0.0, 0.0],
        [4.0, 0.0],
        [4.0, 4.0],
        [0.0, 4.0],
        [0.0, 0.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [3.0, 3.0],
        [3.0, 1.0],
        [1.0, 1.0],
    ];
    assert_tiled(&flat(&ring));
}

#[test]
fn degenerate_and_huge_coordinates_end() {
    for points in [
        vec![[1.0; 3]; 9],
        (0..9).map(|i| [i as f64, 0.0, 0.0]).collect(),
        (0..9).map(|i| [1e300 * (i * i % 5) as f64, -1e300 * (i % 3) as f64, 1e308]).collect(),
    ] {
        cut(&points);
    }
}

#[test]
fn tangles_end_in_time() {
    let mut random = Random(3);
    let tangle: Vec<[f64; 3]> =
        (0..65_536).map(|_| [random.unit(), random.unit(), random.unit() * 0.01]).collect();
    let start = Instant::now();
    assert_ne!(cut(&tangle).1, Verdict::Simple);
    let few: Vec<[f64; 3]> = (0..65_536).map(|i| tangle[i % 250]).collect();
    cut(&few);
    let comb: Vec<[f64; 3]> =
        (0..65_536).map(|i| [i as f64, if i % 2 == 0 { 1e6 } else { 0.0 }, 0.0]).collect();
    cut(&comb);
    assert!(start.elapsed() < Duration::from_secs(6), "{:?}", start.elapsed());
}
