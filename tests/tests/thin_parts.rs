//! Promise: meshes for a budget keep thin parts: the rims of sheets and of open surfaces, and the holes of flat rings.

#![allow(clippy::print_stdout, reason = "the distances are part of the promise")]

use fcextract::{Budget, Extraction, Selection, extract, fit};
use fct::Tree;
use fctests::distance::{Surface, position};
use fctests::random::Random;
use fctests::trees;
use glam::DVec3;

/// Samples of a drawn triangle.
const SAMPLES: usize = 20;

/// The largest distance between the surface and the mesh of so many triangles, both ways, over the model's diagonal.
fn largest_distance(tree: &Tree, triangles: u64) -> [f64; 2] {
    let mut cut = Extraction::default();
    extract(tree, &Selection::full(), &mut cut).unwrap();
    let surface = Surface::of(tree, &cut.indices);
    let points: Vec<DVec3> = (0..tree.vertices().len() as u32).map(|v| position(tree, v)).collect();
    let (selection, _) = fit(tree, Selection::by_budget(), Budget::Triangles(triangles), &mut cut).unwrap();
    let place = |v: &u32| selection.position(&tree.vertices()[*v as usize]);
    let drawn: Vec<[DVec3; 3]> =
        cut.indices.as_chunks::<3>().0.iter().map(|t| t.each_ref().map(place)).collect();
    let mut random = Random::new(7);
    let samples = drawn.iter().flat_map(|t| (0..SAMPLES).map(|_| random.in_triangle(*t)).collect::<Vec<_>>());
    let samples: Vec<DVec3> = samples.collect();
    let mesh = Surface::of_triangles(drawn);
    let farthest = |points: &[DVec3], to: &Surface| {
        points.iter().map(|p| p.distance(to.nearest(*p))).fold(0.0, f64::max)
    };
    let (low, high) = points.iter().fold((points[0], points[0]), |(l, h), p| (l.min(*p), h.max(*p)));
    [farthest(&points, &mesh), farthest(&samples, &surface)].map(|d| d / low.distance(high))
}

/// The ears of the elephant are two sheets that fold back: no polygon covers what a chord of the rim cuts off. Without
/// keys for that in the budget order one ear was missing, 0.099 of the diagonal deep.
#[test]
fn an_ear_keeps_its_rim() {
    let tree = trees::tree_of(trees::read(&trees::data("sculpture.ply")));
    let [missing, extra] = largest_distance(&tree, 640);
    println!("sculpture: {missing:.4} of it missing, {extra:.4} too much");
    assert!(missing < 0.045 && extra < 0.045, "{missing} {extra}");
}

/// A ring whose outline has fewer vertices than its hole is drawn over the hole: 0.020 of the diagonal from anything.
#[test]
fn a_flat_ring_keeps_its_hole() {
    let tree = trees::tree_of(trees::read(&trees::data("parts.ply")));
    let [missing, extra] = largest_distance(&tree, 1461);
    println!("parts: {missing:.4} of them missing, {extra:.4} too much");
    assert!(missing < 0.01 && extra < 0.01, "{missing} {extra}");
}

/// A collar around three quarters of a hole in the bunny's base was turned over by one chord, so that the polygon beside
/// it covered the hole: 0.019 of the diagonal from anything.
#[test]
#[ignore = "needs the scans that FCT_DATA names; cargo xtask campaign runs it"]
fn scans_keep_their_holes() {
    let tree = trees::tree_of(trees::scan("bunny.ply"));
    let [missing, extra] = largest_distance(&tree, 1500);
    println!("bunny: {missing:.4} of it missing, {extra:.4} too much");
    assert!(missing < 0.011 && extra < 0.011, "{missing} {extra}");
}

/// Where a surface ends, a chord may cut a cluster short, however flat that is. The vertices in between had keys for the
/// order of bounds, and for that reason none in the budget order: a bay at the rim was 0.029 of the diagonal deep.
#[test]
fn an_open_surface_keeps_its_rim() {
    let tree = trees::tree_of(trees::read(&trees::data("terrain.ply")));
    let [missing, extra] = largest_distance(&tree, 1000);
    println!("terrain: {missing:.4} of it missing, {extra:.4} too much");
    assert!(missing < 0.02 && extra < 0.02, "{missing} {extra}");
}
