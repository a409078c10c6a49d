//! What is drawn of pages in a hurry is what the format says: every cluster of a cut is drawn as triangles that have
//! exactly its active boundary as their border.

use fcbuild::SplitMode;
use fcextract::{Extraction, Order, ParallelExtractor, Part, Perspective, Selection, Stats, extract};
use fct::{Child, Tree};
use fctests::random::Random;
use fctests::{meshes, trees};
use glam::DVec3;
use std::collections::BTreeMap;

/// Directed edges that are left when opposite ones are counted against each other.
fn border(edges: impl Iterator<Item = (u32, u32)>) -> BTreeMap<(u32, u32), i32> {
    let mut net = BTreeMap::new();
    for (a, b) in edges {
        let (key, step) = if a < b { ((a, b), 1) } else { ((b, a), -1) };
        *net.entry(key).or_insert(0) += step;
    }
    net.retain(|_, n| *n != 0);
    net
}

/// As [`Selection`] says it in words: a vertex is active when its own record passes the test that refines nodes.
fn is_active(tree: &Tree, selection: &Selection, vertex: u32) -> bool {
    let record = &tree.vertices()[vertex as usize];
    let key = match selection.order {
        Order::Bound => record.bound(),
        Order::Budget => record.budget(),
    };
    selection.tolerance.refines(key, || (DVec3::from_array(record.center()), record.radius()))
}

/// Compares a cut with what the slow walk finds; returns its number of clusters.
fn check(name: &str, tree: &Tree, selection: &Selection) -> usize {
    let mut drawn = Extraction::default();
    extract(tree, selection, &mut drawn).unwrap();
    // What is known of a page from the second time on, and used from the third time on, changes nothing.
    for _ in 0..2 {
        let mut again = Extraction::default();
        extract(tree, selection, &mut again).unwrap();
        assert_eq!(again.indices, drawn.indices, "{name}: {selection:?}");
        assert_eq!(again.clusters, drawn.clusters, "{name}: {selection:?}");
        assert_eq!(again.stats, drawn.stats, "{name}: {selection:?}");
    }
    let mut cut = Vec::new();
    let mut stats = Stats::default();
    let each = |part: Part, _: Option<&fct::Node>| cut.push(part.subtree);
    Part::whole(tree, selection).divide(tree, selection, &mut stats, |_, _| false, each).unwrap();
    assert_eq!(drawn.clusters.len(), cut.len(), "{name}: {selection:?}");
    assert_eq!(drawn.stats.nodes_visited, stats.nodes_visited, "{name}");
    assert_eq!(drawn.stats.clusters, cut.len() as u64);
    assert_eq!(drawn.stats.triangles, drawn.indices.len() as u64 / 3);
    let ends = drawn.clusters[1..].iter().copied().chain([drawn.stats.triangles as u32]);
    for ((subtree, first), end) in cut.iter().zip(&drawn.clusters).zip(ends) {
        let triangles = drawn.indices[3 * *first as usize..3 * end as usize].as_chunks::<3>().0;
        let mut rings = tree.loops_of(subtree).unwrap();
        if let Child::Node(_) = subtree.child.kind() {
            let mut thinned = fct::Loops::default();
            for ring in rings.iter() {
                let active = ring.iter().copied().filter(|v| is_active(tree, selection, *v));
                thinned.vertices.extend(active);
                thinned.ends.push(thinned.vertices.len());
            }
            rings = thinned;
        }
        let around = rings
            .iter()
            .filter(|ring| ring.len() > 2)
            .flat_map(|ring| (0..ring.len()).map(|i| (ring[i], ring[(i + 1) % ring.len()])));
        let of_triangles = triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
        assert_eq!(border(of_triangles), border(around), "{name}: {subtree} of {selection:?}");
    }
    let batches: Vec<(u32, u32)> = drawn.batches.iter().map(|b| (b.first_index, b.index_count)).collect();
    let mut at = 0;
    for (first, count) in batches {
        assert_eq!(first, at, "{name}: batches cover all, in order");
        assert!(count > 0);
        at += count;
    }
    assert_eq!(at as usize, drawn.indices.len());
    for batch in &drawn.batches {
        let faces = batch.subtree.first_face..batch.subtree.face_end;
        let first = cut[drawn.clusters.partition_point(|c| 3 * c <= batch.first_index) - 1];
        let last = cut[drawn.clusters.partition_point(|c| 3 * c < batch.first_index + batch.index_count) - 1];
        assert!(faces.start <= first.first_face && last.face_end <= faces.end, "{name}: {batch:?}");
    }
    cut.len()
}

fn look(name: &str, tree: &Tree, seed: u64) {
    let mut random = Random::new(seed);
    let vertices = tree.vertices();
    let size = f64::from(tree.meta().bounds_max[0] - tree.meta().bounds_min[0]).max(1e-3);
    check(name, tree, &Selection::full());
    let mut clusters = 0;
    for round in 0..24 {
        let order = if round % 2 == 0 { Order::Bound } else { Order::Budget };
        let distance = size * 10.0_f64.powf(random.between(-5.0, 0.0));
        let selection = if round % 3 == 0 {
            Selection::uniform(distance, order)
        } else {
            let near = DVec3::from_array(vertices[random.below(vertices.len())].position().map(f64::from));
            let eye = near + random.direction() * size * random.between(0.0, 2.0);
            let view = Perspective { eye, axis: random.direction(), slope: distance / size, corner_cos: 0.5 };
            let backface_eye = (round % 3 == 1).then_some(eye);
            Selection { backface_eye, ..Selection::perspective(view, order) }
        };
        clusters += check(name, tree, &selection);
    }
    assert!(clusters > 24, "{name}: nothing was drawn");
}

/// A tree that has been looked at from everywhere shows what a tree shows that was just opened, on any number of threads.
#[test]
fn what_was_seen_before_does_not_matter() {
    let bytes = trees::bytes_of(trees::read(&trees::data("sculpture.ply")), SplitMode::Quality);
    let seen = Tree::from_bytes(bytes.clone()).unwrap();
    let [low, high] =
        [seen.meta().bounds_min, seen.meta().bounds_max].map(|b| DVec3::from_array(b.map(f64::from)));
    let (center, size) = (low.midpoint(high), (high - low).length());
    let mut random = Random::new(11);
    let mut views: Vec<Selection> = Vec::new();
    for round in 0..60 {
        let order = if round % 2 == 0 { Order::Bound } else { Order::Budget };
        let eye = center + random.direction() * size * 10.0_f64.powf(random.between(-1.0, 1.5));
        let slope = 10.0_f64.powf(random.between(-4.0, -1.5));
        let axis = (center - eye).normalize_or_zero();
        let view = Perspective { eye, axis, slope, corner_cos: 0.6 };
        let selection = Selection { backface_eye: Some(eye), ..Selection::perspective(view, order) };
        views.push(match round % 5 {
            0 => Selection::uniform(slope * size, order),
            _ => selection,
        });
    }
    let mut parallel = ParallelExtractor::default();
    assert_eq!(Tree::from_bytes(bytes.clone()).unwrap().derived(|| 7_u8), Some(&7));
    let (mut warm, mut on_threads, mut cold) =
        (Extraction::default(), Extraction::default(), Extraction::default());
    for (round, selection) in views.iter().cycle().take(3 * views.len()).enumerate() {
        parallel.extract(&seen, selection, &mut on_threads).unwrap();
        extract(&seen, selection, &mut warm).unwrap();
        assert_eq!(warm.indices, on_threads.indices, "{round}: {selection:?}");
        if round % 3 == 0 {
            let fresh = Tree::from_bytes(bytes.clone()).unwrap();
            extract(&fresh, selection, &mut cold).unwrap();
            assert_eq!(warm.indices, cold.indices, "{round}: {selection:?}");
            assert_eq!(warm.clusters, cold.clusters, "{round}: {selection:?}");
            assert_eq!(warm.stats, cold.stats, "{round}: {selection:?}");
        }
    }
    assert!(seen.derived(|| 7_u8).is_none(), "nothing was kept beside the tree");
}

#[test]
fn meshes_made_in_memory() {
    look("grid", &trees::tree_of(meshes::grid(40, 1)), 1);
    look("torus", &trees::tree_of(meshes::torus(60, 30, 2)), 2);
    look("moebius", &trees::tree_of(meshes::moebius(60)), 3);
    look("sheets", &trees::tree_of(meshes::three_sheets(12)), 4);
    look("pieces", &trees::tree_of(meshes::pieces(5)), 5);
    for seed in 0..6 {
        look("tangle", &trees::tree_of(meshes::tangle(60, 400, seed)), seed);
        look("flat garbage", &trees::tree_of(meshes::flat_garbage(seed)), seed);
        look("random bits", &trees::tree_of(meshes::random_bits(seed)), seed);
    }
}

#[test]
fn sample_meshes() {
    for name in ["sculpture.ply", "terrain.ply", "parts.ply"] {
        look(name, &trees::tree_of(trees::read(&trees::data(name))), 7);
    }
}
