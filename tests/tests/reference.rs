//! Promise: what is extracted is what the definition says, cluster by cluster.
//!
//! The definition, slow and obvious: go down from the root while the error is over what is allowed; of each cluster's
//! boundary, found from its faces, keep the vertices that are over it too; draw the polygon that is left.

use fcextract::{Budget, Extraction, Order, Perspective, Region, Selection, Tolerance, extract, fit};
use fct::{Child, Subtree, Tree};
use fctests::random::Random;
use fctests::{meshes, trees};
use glam::DVec3;
use std::collections::BTreeMap;

/// What a selection allows in a ball, by angles.
fn allowed(selection: &Selection, center: DVec3, radius: f64) -> f64 {
    let mut outside = match selection.tolerance {
        Tolerance::Full => -1.0,
        Tolerance::Uniform { distance } => distance.min(f64::MAX),
        Tolerance::Perspective(view) => {
            let distance = center.distance(view.eye);
            let near = (distance - radius).max(0.0);
            let mut angle = 0.0;
            if view.axis != DVec3::ZERO && near > 0.0 {
                let to_center = ((center - view.eye).dot(view.axis) / distance).clamp(-1.0, 1.0).acos();
                angle = (to_center + (radius / distance).asin()).min(view.corner_cos.acos());
            }
            view.slope * near * angle.cos() * angle.cos()
        }
    };
    let mut inside = None;
    for region in &selection.regions {
        let apart = region.center.distance(center);
        if apart <= region.radius + radius {
            outside = outside.min(region.distance);
            if apart + radius <= region.radius {
                inside = Some(f64::INFINITY);
            }
        }
    }
    if inside.is_some() {
        let touched = |r: &&Region| r.center.distance(center) <= r.radius + radius;
        return selection.regions.iter().filter(touched).map(|r| r.distance).fold(f64::INFINITY, f64::min);
    }
    outside
}

/// The clusters of the cut in the order of the tree.
fn clusters(tree: &Tree, selection: &Selection, subtree: Subtree, out: &mut Vec<Subtree>) {
    if let Child::Node(_) = subtree.child.kind() {
        let node = tree.node(&subtree).unwrap_or_else(|e| panic!("{e}"));
        let key = if selection.order == Order::Bound { node.bound } else { node.budget };
        let least = allowed(selection, DVec3::from(node.center.map(f64::from)), f64::from(node.radius));
        if f64::from(key) > least.min(f64::MAX) {
            for child in tree.children(&subtree).unwrap_or_else(|e| panic!("{e}")) {
                clusters(tree, selection, child, out);
            }
            return;
        }
    }
    out.push(subtree);
}

/// Directed edges, each as often as it leads one way more than the other.
type Edges = BTreeMap<(u32, u32), i32>;

fn add(edges: &mut Edges, a: u32, b: u32) {
    if a != b {
        let (key, step) = if a < b { ((a, b), 1) } else { ((b, a), -1) };
        let count = edges.entry(key).or_insert(0);
        *count += step;
        if *count == 0 {
            edges.remove(&key);
        }
    }
}

/// The boundary of faces as cycles of vertices.
fn boundary(tree: &Tree, subtree: &Subtree, faces: &[[u32; 3]]) -> Vec<Vec<u32>> {
    // Where a vertex is passed twice the faces do not tell which way is gone on, and the file does.
    let stored = tree.loops_of(subtree).unwrap_or_else(|e| panic!("{e}"));
    let mut left = Edges::new();
    for [a, b, c] in subtree.of(faces) {
        for (a, b) in [(*a, *b), (*b, *c), (*c, *a)] {
            add(&mut left, a, b);
        }
    }
    let rings: Vec<Vec<u32>> = stored.iter().map(<[u32]>::to_vec).collect();
    let mut said = Edges::new();
    for ring in &rings {
        (0..ring.len()).for_each(|i| add(&mut said, ring[i], ring[(i + 1) % ring.len()]));
    }
    assert_eq!(said, left, "{subtree}: its loops are the boundary of its faces");
    rings
}

/// Compares an extraction in which nothing is culled with the definition.
fn check(name: &str, tree: &Tree, faces: &[[u32; 3]], selection: &Selection, out: &mut Extraction) -> u64 {
    extract(tree, selection, out).unwrap_or_else(|e| panic!("{name}: {e}"));
    let mut cut = Vec::new();
    clusters(tree, selection, tree.whole(), &mut cut);
    assert_eq!(out.clusters.len(), cut.len(), "{name}, {selection:?}");
    let is_active = |v: &u32| {
        let record = &tree.vertices()[*v as usize];
        let key = if selection.order == Order::Bound { record.bound() } else { record.budget() };
        f64::from(key) > allowed(selection, DVec3::from(record.center()), record.radius()).min(f64::MAX)
    };
    for (i, subtree) in cut.iter().enumerate() {
        let first = out.clusters[i] as usize;
        let end = out.clusters.get(i + 1).map_or(out.indices.len() / 3, |end| *end as usize);
        let drawn = &out.indices.as_chunks::<3>().0[first..end];
        if let Child::Face(face) = subtree.child.kind() {
            assert_eq!(drawn, [faces[face as usize]], "{name}, {subtree}");
            continue;
        }
        let mut rings = boundary(tree, subtree, faces);
        for ring in &mut rings {
            ring.retain(is_active);
        }
        rings.retain(|ring| ring.len() >= 3);
        let (mut expected, mut found) = (Edges::new(), Edges::new());
        for ring in &rings {
            (0..ring.len()).for_each(|i| add(&mut expected, ring[i], ring[(i + 1) % ring.len()]));
        }
        for [a, b, c] in drawn {
            for (a, b) in [(*a, *b), (*b, *c), (*c, *a)] {
                add(&mut found, a, b);
            }
        }
        assert_eq!(found, expected, "{name}, {subtree}, {selection:?}");
        let corners: usize = rings.iter().map(Vec::len).sum();
        let most = if corners == 0 { 0 } else { corners + 2 * rings.len() - 4 };
        let mut distinct: Vec<u32> = rings.concat();
        distinct.sort_unstable();
        distinct.dedup();
        let is_simple = rings.len() <= 1 && distinct.len() == corners;
        assert!(
            drawn.len() == most || !is_simple && drawn.len() < most,
            "{name}, {subtree}: {}",
            drawn.len()
        );
        assert!(drawn.as_flattened().iter().all(|v| distinct.binary_search(v).is_ok()), "{name}, {subtree}");
    }
    cut.len() as u64
}

fn random_selection(random: &mut Random, center: DVec3, size: f64) -> Selection {
    let order = if random.below(2) == 0 { Order::Bound } else { Order::Budget };
    let fraction = 10_f64.powf(random.between(-6.0, 0.3));
    let eye = center + random.direction() * size * 10_f64.powf(random.between(-1.5, 1.2));
    let mut selection = match random.below(5) {
        0 => Selection { order, ..Selection::full() },
        1 => Selection {
            tolerance: Tolerance::orthographic(1.0, size * fraction * 720.0, 720.0),
            ..Selection::uniform(1.0, order)
        },
        _ => {
            let axis = if random.below(3) == 0 { DVec3::ZERO } else { random.direction() };
            let corner_cos = random.between(0.4, 1.0);
            Selection::perspective(Perspective { eye, axis, slope: fraction, corner_cos }, order)
        }
    };
    for _ in 0..random.below(3) {
        selection.regions.push(Region {
            center: center + random.direction() * size * random.between(0.0, 0.6),
            radius: size * random.between(0.0, 0.5),
            distance: size * 10_f64.powf(random.between(-5.0, 0.0)),
        });
    }
    selection
}

fn check_many(name: &str, tree: &Tree, views: u64) {
    let [low, high] =
        [tree.meta().bounds_min, tree.meta().bounds_max].map(|b| DVec3::from_array(b.map(f64::from)));
    let (center, size) = ((low + high) * 0.5, (high - low).length());
    let faces = tree.faces().unwrap_or_else(|e| panic!("{name}: {e}"));
    let mut random = Random::new(11);
    let mut out = Extraction::default();
    let clusters: u64 = (0..views)
        .map(|_| check(name, tree, &faces, &random_selection(&mut random, center, size), &mut out))
        .sum();
    assert!(clusters > views, "{name}: next to nothing is drawn");
}

#[test]
fn fast_and_obvious_agree_on_well_behaved_meshes() {
    check_many("torus", &trees::tree_of(meshes::torus(40, 24, 3)), 150);
    check_many("grid", &trees::tree_of(meshes::grid(24, 5)), 150);
    check_many("pieces", &trees::tree_of(meshes::pieces(9)), 150);
    check_many("terrain", &trees::tree_of(trees::read(&trees::data("terrain.ply"))), 20);
    check_many("parts", &trees::tree_of(trees::read(&trees::data("parts.ply"))), 20);
}

#[test]
fn fast_and_obvious_agree_on_hostile_meshes() {
    check_many("moebius strip", &trees::tree_of(meshes::moebius(60)), 150);
    check_many("three sheets", &trees::tree_of(meshes::three_sheets(12)), 150);
    for seed in 0..20 {
        check_many("tangle", &trees::tree_of(meshes::tangle(30, 120, seed)), 40);
        check_many("random bits", &trees::tree_of(meshes::random_bits(seed)), 40);
        check_many("flat garbage", &trees::tree_of(meshes::flat_garbage(seed)), 40);
    }
}

/// Greedy by the definition: of all clusters that can be split the one of the largest key, unless the whole mesh,
/// extracted anew, has too many triangles.
#[test]
fn a_budget_is_spent_in_the_order_of_keys() {
    let tree = trees::tree_of(meshes::torus(30, 20, 3));
    let mut out = Extraction::default();
    for n in [60, 100, 101, 250, 600, 1000, 1150] {
        let shape = Selection::by_budget();
        let (selection, fitted) =
            fit(&tree, shape, Budget::Triangles(n), &mut out).unwrap_or_else(|e| panic!("{e}"));
        assert!(fitted.within && out.stats.triangles + 4 >= n, "{n}: {fitted:?}");
        // What is refined has no smaller key than what is not, but for the last few that did not fit.
        let (mut refined, mut waiting) = (Vec::new(), Vec::new());
        let mut stack = vec![tree.whole()];
        while let Some(subtree) = stack.pop() {
            let Child::Node(_) = subtree.child.kind() else { continue };
            let node = tree.node(&subtree).unwrap_or_else(|e| panic!("{e}"));
            if selection.refines_node(subtree.child, &node) {
                refined.push(node.budget);
                stack.extend(tree.children(&subtree).unwrap_or_else(|e| panic!("{e}")));
            } else {
                waiting.push(node.budget);
            }
        }
        let most = waiting.iter().copied().fold(0.0, f32::max);
        let early = refined.iter().filter(|key| **key < most).count();
        assert!(early <= 10, "{n}: {early} clusters are refined though one of a larger key is not");
    }
}
