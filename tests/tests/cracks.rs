//! Promise: whatever the view, the tolerance and the mesh, an extracted mesh has no crack.
//!
//! Every directed edge is matched by its opposite, but for chords of the input's own borders.

#![allow(clippy::print_stdout, reason = "the counts are part of the promise")]

use fcbuild::import::Soup;
use fcextract::{Extraction, Order, Perspective, Region, Selection, extract};
use fct::Tree;
use fctests::cracks::Borders;
use fctests::random::Random;
use fctests::{meshes, trees};
use glam::DVec3;

/// Counts of what was looked at.
#[derive(Default)]
struct Looked {
    views: u64,
    triangles: u64,
    folded: u64,
}

fn size(tree: &Tree) -> (DVec3, f64) {
    let [low, high] =
        [tree.meta().bounds_min, tree.meta().bounds_max].map(|b| DVec3::from_array(b.map(f64::from)));
    ((low + high) * 0.5, (high - low).length())
}

/// A random tolerance: uniform or from an eye near or far, from the finest detail to almost none; with regions or
/// without.
fn random_selection(random: &mut Random, center: DVec3, size: f64) -> Selection {
    let order = if random.below(2) == 0 { Order::Bound } else { Order::Budget };
    // Evenly spread magnitudes, from a millionth of the size to more than all of it.
    let fraction = 10_f64.powf(random.between(-6.0, 0.3));
    let mut selection = if random.below(4) == 0 {
        Selection::uniform(size * fraction, order)
    } else {
        let eye = center + random.direction() * size * 10_f64.powf(random.between(-1.5, 1.2));
        let axis = if random.below(3) == 0 { DVec3::ZERO } else { random.direction() };
        let corner_cos = random.between(0.4, 1.0);
        Selection::perspective(Perspective { eye, axis, slope: fraction, corner_cos }, order)
    };
    for _ in 0..random.below(4).saturating_sub(1) {
        selection.regions.push(Region {
            center: center + random.direction() * size * random.between(0.0, 0.6),
            radius: size * random.between(0.0, 0.5),
            distance: size * 10_f64.powf(random.between(-5.0, 0.0)),
        });
    }
    selection
}

fn look(tree: &Tree, views: u64, seed: u64, name: &str) -> Looked {
    let borders = Borders::of(tree);
    let (center, size) = size(tree);
    let mut random = Random::new(seed);
    let mut out = Extraction::default();
    let mut looked = Looked::default();
    for view in 0..views {
        let selection = random_selection(&mut random, center, size);
        extract(tree, &selection, &mut out).unwrap_or_else(|e| panic!("{name}: {e}"));
        let cracks = borders.cracks(&out.indices);
        assert!(
            cracks.is_empty(),
            "{name}, view {view}: {} cracks in {} triangles, such as {:?}; {selection:?}",
            cracks.len(),
            out.stats.triangles,
            &cracks[..cracks.len().min(5)]
        );
        looked.views += 1;
        looked.triangles += out.stats.triangles;
        looked.folded += out.stats.folded;
    }
    looked
}

fn check(name: &str, soup: Soup, views: u64) {
    let tree = trees::tree_of(soup);
    tree.verify().unwrap_or_else(|e| panic!("{name}: {e}"));
    let looked = look(&tree, views, 1, name);
    println!(
        "{name}: {} faces, 0 cracks in {} views, {} triangles, {} folded",
        tree.face_count(),
        looked.views,
        looked.triangles,
        looked.folded
    );
}

#[test]
fn well_behaved_meshes() {
    check("torus", meshes::torus(40, 24, 3), 400);
    check("grid", meshes::grid(24, 5), 400);
    check("pieces", meshes::pieces(9), 400);
}

#[test]
fn seams() {
    check("moebius strip", meshes::moebius(60), 400);
    check("three sheets", meshes::three_sheets(12), 400);
}

#[test]
fn garbage() {
    for seed in 0..40 {
        check("tangle", meshes::tangle(30, 120, seed), 60);
        check("random bits", meshes::random_bits(seed), 60);
        check("flat garbage", meshes::flat_garbage(seed), 30);
    }
    check("sparse tangle", meshes::tangle(400, 300, 1), 100);
}

#[test]
fn sample_meshes() {
    for (name, views) in [("sculpture.ply", 60), ("terrain.ply", 100), ("parts.ply", 100)] {
        check(name, trees::read(&trees::data(name)), views);
    }
}

#[test]
fn tiny_meshes() {
    let triangle = meshes::soup(vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], vec![[0, 1, 2]]);
    check("one triangle", triangle, 20);
    let pair = meshes::soup(
        vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]],
        vec![[0, 1, 2], [0, 2, 3]],
    );
    check("two triangles", pair, 50);
    let tetrahedron = meshes::soup(
        vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]],
        vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    );
    check("tetrahedron", tetrahedron, 50);
}

#[test]
#[ignore = "needs the scans that FCT_DATA names; cargo xtask campaign runs it"]
fn scans() {
    for (name, views) in [("bunny.ply", 1000), ("armadillo.ply", 1000), ("dragon.ply", 150)] {
        check(name, trees::scan(name), views);
    }
}

/// The same promise over many more views.
#[test]
#[ignore = "takes minutes; cargo xtask campaign runs it"]
fn thousands_of_views() {
    for (name, views) in [("sculpture.ply", 1000), ("terrain.ply", 2000), ("parts.ply", 2000)] {
        check(name, trees::read(&trees::data(name)), views);
    }
    for seed in 0..1000 {
        check("tangle", meshes::tangle(40, 160, 1000 + seed), 20);
        check("random bits", meshes::random_bits(1000 + seed), 20);
    }
}
