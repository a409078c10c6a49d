//! Promise: extracting takes no memory from the system once the buffers have grown, and any thread may do it.

use fcbuild::SplitMode;
use fcextract::{
    Batch, Budget, ChunkCache, Extraction, Fitter, Mesh, Order, ParallelExtractor, Part, Perspective, Region,
    Selection, Shown, Streamed, Tolerance, extract,
};
use fct::Tree;
use fctests::random::Random;
use fctests::{meshes, parts, trees};
use glam::DVec3;

/// Views from a path that jumps.
fn views(tree: &Tree, count: u64) -> Vec<Selection> {
    let [low, high] =
        [tree.meta().bounds_min, tree.meta().bounds_max].map(|b| DVec3::from_array(b.map(f64::from)));
    let (center, size) = ((low + high) * 0.5, (high - low).length());
    let mut random = Random::new(8);
    let mut view = || {
        let eye = center + random.direction() * size * random.between(0.1, 3.0);
        let order = if random.below(2) == 0 { Order::Bound } else { Order::Budget };
        let slope = 10_f64.powf(random.between(-4.0, -1.5));
        let regions = vec![Region { center, radius: size * random.between(0.0, 0.3), distance: 1e-3 * size }];
        Selection {
            displaced: true,
            regions: if random.below(3) == 0 { regions } else { Vec::new() },
            backface_eye: (random.below(2) == 0).then_some(eye),
            ..Selection::perspective(Perspective { eye, axis: DVec3::ZERO, slope, corner_cos: 1.0 }, order)
        }
    };
    (0..count).map(|_| view()).collect()
}

fn check(name: &str, tree: &Tree) {
    let views = views(tree, 40);
    let (mut cut, mut mesh) = (Extraction::default(), Mesh::default());
    let mut triangles = 0;
    let mut pass = || {
        for selection in &views {
            extract(tree, selection, &mut cut).unwrap_or_else(|e| panic!("{name}: {e}"));
            mesh.fill(tree, &cut, selection).unwrap_or_else(|e| panic!("{name}: {e}"));
            triangles += mesh.indices.len() / 3;
        }
    };
    let first = allocation_counter::measure(&mut pass);
    assert!(first.count_total > 0, "{name}: buffers grow from nothing, or nothing is counted");
    let again = allocation_counter::measure(&mut pass);
    assert_eq!(again.count_total, 0, "{name}: {again:?}");
    assert!(triangles > 1000, "{name}: the views show next to nothing: {triangles}");
}

#[test]
fn views_cost_no_allocation_once_the_buffers_have_grown() {
    check("sculpture", &trees::tree_of(trees::read(&trees::data("sculpture.ply"))));
    check("terrain", &trees::tree_of(trees::read(&trees::data("terrain.ply"))));
    // Clusters with holes, and with corners that occur twice.
    check("tangle", &trees::tree_of(meshes::tangle(400, 300, 1)));
    check("pieces", &trees::tree_of(meshes::pieces(9)));
}

/// A still camera before a file in parts, all of which that it needs are there.
#[test]
fn a_still_view_of_a_file_in_parts_costs_no_allocation() {
    let bytes = trees::bytes_in_chunks(trees::read(&trees::data("sculpture.ply")), SplitMode::Quality, 700);
    let tree = Tree::from_bytes(bytes.clone()).unwrap_or_else(|e| panic!("{e}"));
    let file = parts::open(bytes).unwrap_or_else(|e| panic!("{e}"));
    let cache = ChunkCache::new(file, 1 << 30).unwrap_or_else(|e| panic!("{e}"));
    let (mut streamed, mut mesh) = (Streamed::default(), Mesh::default());
    let (mut entered, mut close) = (0, 0);
    for (view, selection) in views(&tree, 12).iter().enumerate() {
        cache.extract_now(selection, &mut streamed).unwrap_or_else(|e| panic!("{e}"));
        let mut frame = || {
            cache.begin_frame();
            cache.extract(selection, &mut streamed).unwrap_or_else(|e| panic!("{e}"));
            mesh.fill_streamed(cache.file().crown(), &streamed, selection).unwrap_or_else(|e| panic!("{e}"));
            cache.settle();
        };
        // What is close is read, and the buffers grow.
        for _ in 0..3 {
            frame();
        }
        let again = allocation_counter::measure(&mut frame);
        assert_eq!(again.count_total, 0, "view {view}: {again:?}");
        assert!(streamed.missing.is_empty());
        entered += streamed.entered.len();
        close += streamed.close.len();
    }
    assert!(entered > 100 && close > 20, "{entered} pieces entered, {close} close");
}

/// What the caller's thread takes; the others need no more for many instances than for few.
#[test]
fn a_budget_for_many_instances_takes_little_memory_for_each() {
    const INSTANCES: u64 = 5000;
    let tree = trees::tree_of(trees::read(&trees::data("terrain.ply")));
    let mut shown: Vec<Shown<'_>> =
        (0..INSTANCES).map(|_| Shown { tree: &tree, selection: Selection::by_budget() }).collect();
    // Less than the coarsest meshes have, and a little more.
    let mut coarsest = 0;
    for more in [10, 100] {
        let mut fitter = Fitter::default();
        let taken = allocation_counter::measure(|| {
            let budget = Budget::Triangles(coarsest + more);
            coarsest = fitter.fit(&mut shown, budget).expect("a tree").count;
        });
        assert!(coarsest >= INSTANCES && taken.bytes_max < 3000 * INSTANCES, "{coarsest}: {taken:?}");
    }
}

#[test]
fn everything_may_be_sent_and_shared() {
    const fn all<T: Send + Sync>() {}
    const _: () = {
        all::<Selection>();
        all::<Tolerance>();
        all::<Region>();
        all::<Extraction>();
        all::<ParallelExtractor>();
        all::<Part>();
        all::<Batch>();
        all::<Mesh>();
        all::<Fitter>();
        all::<Shown<'_>>();
        all::<fcextract::Error>();
    };
}
