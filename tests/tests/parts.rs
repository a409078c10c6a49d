//! Promise: a cut that is extracted part by part, however it is divided, is the cut that is extracted at once.

use fcextract::{Extraction, Order, ParallelExtractor, Part, Perspective, Selection, Stats, extract};
use fcgeom::Frustum;
use fct::Tree;
use fctests::random::Random;
use fctests::{meshes, trees};
use glam::DVec3;

/// A view from near, far or inside, with culling or without.
fn random_selection(random: &mut Random, center: DVec3, size: f64) -> Selection {
    let order = if random.below(2) == 0 { Order::Bound } else { Order::Budget };
    if random.below(8) == 0 {
        return Selection { order, ..Selection::full() };
    }
    let eye = center + random.direction() * size * random.between(0.1, 2.0);
    let axis = (center + random.direction() * size * random.between(0.0, 0.5) - eye).normalize_or(DVec3::X);
    let up = if axis.y.abs() < 0.9 { DVec3::Y } else { DVec3::X };
    let projection = glam::dcamera::rh::proj::directx::perspective(0.7, 1.6, size * 1e-3, size * 20.0)
        * glam::dcamera::rh::view::look_at_mat4(eye, eye + axis, up);
    let slope = 10_f64.powf(random.between(-5.0, -1.0));
    Selection {
        frustum: (random.below(3) > 0).then(|| Frustum::from_view_projection(&projection)),
        backface_eye: (random.below(3) > 0).then_some(eye),
        ..Selection::perspective(Perspective { eye, axis, slope, corner_cos: 0.8 }, order)
    }
}

fn check(name: &str, tree: &Tree, views: u64) {
    let [low, high] =
        [tree.meta().bounds_min, tree.meta().bounds_max].map(|b| DVec3::from_array(b.map(f64::from)));
    let (center, size) = ((low + high) * 0.5, (high - low).length());
    let mut random = Random::new(5);
    let (mut whole, mut joined) = (Extraction::default(), Extraction::default());
    let (mut parts_seen, mut culled) = (0, 0);
    for view in 0..views {
        let selection = random_selection(&mut random, center, size);
        extract(tree, &selection, &mut whole).unwrap_or_else(|e| panic!("{name}: {e}"));
        let mut walked = Stats::default();
        let mut parts = vec![Part::whole(tree, &selection)];
        // Divided again and again, as someone would who looks closer at some.
        for _ in 0..1 + random.below(3) {
            let most = 1 + random.below(tree.face_count());
            let mut finer = Vec::new();
            for part in &parts {
                let stop = |subtree: &fct::Subtree, _: &fct::Node| subtree.face_count() as usize <= most;
                part.divide(tree, &selection, &mut walked, stop, |part, _| finer.push(part))
                    .unwrap_or_else(|e| panic!("{name}: {e}"));
            }
            parts = finer;
        }
        joined.clear();
        for part in &parts {
            joined.append(tree, &selection, part).unwrap_or_else(|e| panic!("{name}: {e}"));
        }
        assert_eq!(joined.indices, whole.indices, "{name}, view {view}");
        assert_eq!(joined.clusters, whole.clusters, "{name}, view {view}");
        assert_eq!(joined.stats.triangles, whole.stats.triangles, "{name}, view {view}");
        assert_eq!(
            joined.stats.faces_culled + walked.faces_culled,
            whole.stats.faces_culled,
            "{name}, view {view}: faces are left out once"
        );
        assert!(parts.windows(2).all(|p| p[0].subtree.face_end <= p[1].subtree.first_face), "out of order");
        parts_seen += parts.len();
        culled += whole.stats.faces_culled;
    }
    assert!(parts_seen as u64 > 3 * views && culled > 0, "{name}: {parts_seen} parts, {culled} faces culled");
}

#[test]
fn parts_join_to_the_whole() {
    check("torus", &trees::tree_of(meshes::torus(120, 60, 3)), 120);
    check("grid", &trees::tree_of(meshes::grid(60, 2)), 120);
    check("sculpture", &trees::tree_of(trees::read(&trees::data("sculpture.ply"))), 40);
}

/// Everything that an extraction says, from one thread and from several.
#[test]
fn threads_extract_what_one_thread_does() {
    let tree = trees::tree_of(trees::read(&trees::data("sculpture.ply")));
    let [low, high] =
        [tree.meta().bounds_min, tree.meta().bounds_max].map(|b| DVec3::from_array(b.map(f64::from)));
    let (center, size) = ((low + high) * 0.5, (high - low).length());
    let mut random = Random::new(6);
    let (mut serial, mut parallel) = (Extraction::default(), Extraction::default());
    let mut extractor = ParallelExtractor::default();
    let mut triangles = 0;
    for threads in [1, 2, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        for view in 0..20 {
            let selection = random_selection(&mut random, center, size);
            extract(&tree, &selection, &mut serial).unwrap_or_else(|e| panic!("{e}"));
            pool.install(|| extractor.extract(&tree, &selection, &mut parallel))
                .unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(parallel.indices, serial.indices, "{threads} threads, view {view}");
            assert_eq!(parallel.clusters, serial.clusters, "{threads} threads, view {view}");
            assert_eq!(parallel.stats, serial.stats, "{threads} threads, view {view}");
            assert_eq!(
                format!("{:?}", parallel.batches),
                format!("{:?}", serial.batches),
                "{threads} threads, view {view}"
            );
            triangles += serial.stats.triangles;
        }
    }
    assert!(triangles > 100_000, "the views show next to nothing: {triangles}");
}
