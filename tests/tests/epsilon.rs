//! Promise: a cut by the paper's modelling error is the one of equations 17 and 18, on any tree, and has no crack.

use fcbuild::SplitMode;
use fcextract::{Extraction, Order, Perspective, Selection, Tolerance, by_epsilon, extract};
use fct::{Child, Tree};
use fctests::cracks::Borders;
use fctests::random::Random;
use fctests::{meshes, trees};
use glam::DVec3;

/// Goes down as the paper does, from the root to the first clusters that are fine enough, and compares.
fn check(name: &str, tree: &Tree, tolerance: Tolerance) {
    let asked = Selection { tolerance, ..Selection::full() };
    let cut = by_epsilon(tree, asked).unwrap_or_else(|e| panic!("{name}: {e}"));
    let mut clusters = 0;
    let mut stack = vec![tree.whole()];
    while let Some(subtree) = stack.pop() {
        let Child::Node(_) = subtree.child.kind() else {
            clusters += 1;
            continue;
        };
        let node = tree.node(&subtree).unwrap_or_else(|e| panic!("{name}: {e}"));
        let (center, radius) = (DVec3::from(node.center.map(f64::from)), f64::from(node.radius));
        let allowed = match tolerance {
            Tolerance::Full => -1.0,
            Tolerance::Uniform { distance } => distance * distance,
            Tolerance::Perspective(view) => {
                let near = (center.distance(view.eye) - radius).max(0.0);
                view.slope * view.slope * near * near
            }
        };
        let is_fine = node.bound.is_finite() && f64::from(node.epsilon()) <= allowed * (1.0 + 1e-12);
        assert_eq!(!is_fine, cut.refines_node(subtree.child, &node), "{name}, {tolerance:?}: {subtree}");
        if is_fine {
            clusters += 1;
        } else {
            stack.extend(tree.children(&subtree).unwrap_or_else(|e| panic!("{name}: {e}")));
        }
    }
    let mut out = Extraction::default();
    extract(tree, &cut, &mut out).unwrap_or_else(|e| panic!("{name}: {e}"));
    assert_eq!(out.stats.clusters, clusters, "{name}, {tolerance:?}");
    let cracks = Borders::of(tree).cracks(&out.indices);
    assert!(cracks.is_empty(), "{name}, {tolerance:?}: {} cracks, such as {:?}", cracks.len(), cracks[0]);
}

fn check_many(name: &str, tree: &Tree, rounds: u64) {
    let [low, high] =
        [tree.meta().bounds_min, tree.meta().bounds_max].map(|b| DVec3::from_array(b.map(f64::from)));
    let (center, size) = ((low + high) * 0.5, (high - low).length());
    let mut random = Random::new(17);
    for round in 0..rounds {
        let slope = 10_f64.powf(random.between(-6.0, 0.0));
        let eye = center + random.direction() * size * 10_f64.powf(random.between(-1.0, 1.0));
        let view = Perspective { eye, axis: DVec3::ZERO, slope, corner_cos: 1.0 };
        let everywhere = Tolerance::Uniform { distance: size * slope };
        check(name, tree, if round % 2 == 0 { everywhere } else { Tolerance::Perspective(view) });
    }
    check(name, tree, Tolerance::Uniform { distance: 0.0 });
    check(name, tree, Tolerance::Uniform { distance: f64::INFINITY });
}

#[test]
fn equations_17_and_18_choose_the_clusters() {
    for split in [SplitMode::Quality, SplitMode::Paper] {
        let sculpture = trees::tree_by(trees::read(&trees::data("sculpture.ply")), split);
        check_many("sculpture", &sculpture, 10);
        check_many("torus", &trees::tree_by(meshes::torus(40, 24, 3), split), 60);
        check_many("grid", &trees::tree_by(meshes::grid(24, 5), split), 60);
        check_many("pieces", &trees::tree_by(meshes::pieces(9), split), 60);
        check_many("moebius strip", &trees::tree_by(meshes::moebius(60), split), 60);
        check_many("three sheets", &trees::tree_by(meshes::three_sheets(12), split), 60);
    }
}

#[test]
fn garbage_has_no_cracks_either() {
    for seed in 0..30 {
        check_many("tangle", &trees::tree_of(meshes::tangle(30, 120, seed)), 10);
        check_many("random bits", &trees::tree_of(meshes::random_bits(seed)), 10);
        check_many("flat garbage", &trees::tree_of(meshes::flat_garbage(seed)), 10);
    }
}

/// A selection for one order says nothing about another key: epsilon has none.
#[test]
fn the_order_asked_for_has_no_say() {
    let tree = trees::tree_of(meshes::torus(40, 24, 3));
    let by = |order| by_epsilon(&tree, Selection::uniform(0.01, order)).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(by(Order::Bound).extra, by(Order::Budget).extra);
}
