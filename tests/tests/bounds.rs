//! Promise: no point of the surface is farther from the drawn mesh than the tolerance allows there.

#![allow(clippy::print_stdout, reason = "the counts are part of the promise")]

use fcbuild::SplitMode;
use fcextract::{Extraction, Order, Perspective, Selection, Tolerance, extract};
use fct::Tree;
use fctests::distance::{Surface, position};
use fctests::random::Random;
use fctests::{meshes, trees};
use glam::DVec3;

/// Points spread over the faces, the middle of every edge among them.
fn samples(tree: &Tree, per_face: usize) -> Vec<DVec3> {
    let mut random = Random::new(11);
    let mut points = Vec::new();
    for face in tree.faces().unwrap_or_else(|e| panic!("{e}")) {
        let [a, b, c] = face.map(|v| position(tree, v));
        points.push((a + b) * 0.5);
        points.push(c);
        for _ in 0..per_face {
            let (mut s, mut t) = (random.unit(), random.unit());
            if s + t > 1.0 {
                (s, t) = (1.0 - s, 1.0 - t);
            }
            points.push(a + (b - a) * s + (c - a) * t);
        }
    }
    points
}

/// Measured distances over the distance allowed.
struct Measured {
    worst: f64,
    /// Of those that are not zero.
    median: f64,
    /// How many points are farther off than allowed.
    beyond: usize,
    triangles: u64,
}

fn measure(tree: &Tree, selection: &Selection, points: &[DVec3]) -> Measured {
    let mut out = Extraction::default();
    extract(tree, selection, &mut out).unwrap_or_else(|e| panic!("{e}"));
    let surface = Surface::of(tree, &out.indices);
    // Positions are single precision; rounding of their own size is no error of the mesh.
    let rounding = 1e-6 * points.iter().map(|p| p.length()).fold(0.0, f64::max);
    let mut ratios: Vec<f64> = points
        .iter()
        .map(|p| {
            let allowed = match selection.tolerance {
                Tolerance::Full => 0.0,
                Tolerance::Uniform { distance } => distance,
                Tolerance::Perspective(view) => view.at(*p, 0.0),
            };
            (surface.distance(*p) - rounding).max(0.0) / allowed.max(rounding)
        })
        .collect();
    ratios.sort_unstable_by(f64::total_cmp);
    let worst = ratios.last().copied().unwrap_or(0.0);
    let beyond = ratios.iter().filter(|r| **r > 1.0).count();
    let off: Vec<f64> = ratios.into_iter().filter(|r| *r > 0.0).collect();
    let median = off.get(off.len() / 2).copied().unwrap_or(0.0);
    Measured { worst, median, beyond, triangles: out.stats.triangles }
}

/// Returns the largest distance over the tolerance, and the share of the points that are beyond it.
fn look(name: &str, tree: &Tree, per_face: usize) -> (f64, f64) {
    let points = samples(tree, per_face);
    let [low, high] =
        [tree.meta().bounds_min, tree.meta().bounds_max].map(|b| DVec3::from_array(b.map(f64::from)));
    let (center, size) = ((low + high) * 0.5, (high - low).length());
    let mut random = Random::new(4);
    let (mut worst_of_all, mut beyond) = (0.0_f64, 0);
    let mut selections: Vec<Selection> = [0.05, 0.015, 5e-3, 1.5e-3, 5e-4, 1.5e-4]
        .iter()
        .map(|f| Selection::uniform(size * f, Order::Bound))
        .collect();
    for slope in [0.03, 0.01, 3e-3, 1e-3] {
        let eye = center + random.direction() * size * random.between(0.2, 1.5);
        let view = Perspective { eye, axis: DVec3::ZERO, slope, corner_cos: 1.0 };
        selections.push(Selection::perspective(view, Order::Bound));
    }
    for selection in &selections {
        let m = measure(tree, selection, &points);
        println!(
            "{name}: {} triangles, worst {:.3}, median {:.3} of the tolerance, {} points beyond",
            m.triangles, m.worst, m.median, m.beyond
        );
        worst_of_all = worst_of_all.max(m.worst);
        beyond += m.beyond;
    }
    (worst_of_all, beyond as f64 / (points.len() * selections.len()) as f64)
}

fn check(name: &str, tree: &Tree, per_face: usize) {
    let (worst, _) = look(name, tree, per_face);
    assert!(worst <= 1.0, "{name}: the surface is {worst:.3} tolerances away");
}

#[test]
fn made_in_memory() {
    check("torus", &trees::tree_of(meshes::torus(60, 36, 3)), 6);
    check("grid", &trees::tree_of(meshes::grid(30, 5)), 6);
    check("pieces", &trees::tree_of(meshes::pieces(9)), 6);
    check("three sheets", &trees::tree_of(meshes::three_sheets(14)), 6);
    check("moebius strip", &trees::tree_of(meshes::moebius(60)), 6);
}

#[test]
fn sample_meshes() {
    for name in ["sculpture.ply", "terrain.ply", "parts.ply"] {
        let soup = trees::read(&trees::data(name));
        for split in [SplitMode::Quality, SplitMode::Paper, SplitMode::Merge] {
            let tree = trees::tree_by(soup.clone(), split);
            let name = format!("{name}, {}", split.as_str());
            if split == SplitMode::Quality {
                check(&name, &tree, 1);
            } else {
                // Known: five points of the parts, by 1.6 %.
                let (worst, beyond) = look(&name, &tree, 1);
                assert!(
                    worst <= 1.05 && beyond <= 3e-5,
                    "{name}: {worst:.3} tolerances, {beyond:.1e} of the points"
                );
            }
        }
    }
}

#[test]
#[ignore = "needs the scans that FCT_DATA names; cargo xtask campaign runs it"]
fn scans() {
    for name in ["bunny.ply", "armadillo.ply", "dragon.ply"] {
        // One ribbon on the dragon is known to break the bound; it must not become two.
        let (worst, beyond) = look(name, &trees::tree_of(trees::scan(name)), 0);
        assert!(worst <= 2.5 && beyond <= 5e-6, "{name}: {worst:.3} tolerances, {beyond:.1e} of the points");
    }
}
