//! Promise: a cache of chunks and pages stays within its budget, reads what is missing, and draws a closed mesh whatever
//! happens to the disk.

use fcextract::{ChunkCache, Order, Perspective, Piece, Selection, Streamed};
use fct::{ChunkFile, ReadAt, Rule, Tree};
use fctests::cracks::Borders;
use fctests::parts::{Model, named, open, size};
use fctests::random::Random;
use fctests::trees;
use glam::DVec3;
use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Reads from memory, breaks when told to, and counts.
#[derive(Default)]
struct Disk {
    bytes: Vec<u8>,
    broken: AtomicBool,
    reads: AtomicU64,
}

impl ReadAt for Disk {
    fn read_at(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        self.reads.fetch_add(1, Ordering::Relaxed);
        if self.broken.load(Ordering::Relaxed) {
            return Err(io::Error::other("the cable was pulled"));
        }
        self.bytes.read_at(offset, out)
    }

    fn length(&self) -> io::Result<u64> {
        self.bytes.length()
    }
}

fn cache_of(bytes: Vec<u8>, chunk_budget: impl Fn(&ChunkFile) -> u64) -> (Arc<Disk>, ChunkCache) {
    let disk = Arc::new(Disk { bytes, ..Disk::default() });
    let file = ChunkFile::new(Arc::clone(&disk) as Arc<dyn ReadAt>, Path::new("a.fct"))
        .unwrap_or_else(|e| panic!("{e}"));
    let budget = file.crown().bytes() + chunk_budget(&file);
    (disk, ChunkCache::new(file, budget).unwrap_or_else(|e| panic!("{e}")))
}

/// What all chunks and pages take.
fn all_bytes(file: &ChunkFile) -> u64 {
    let mut bytes = 0;
    for number in 0..file.crown().chunk_count() {
        let chunk = file.load(number).unwrap_or_else(|e| panic!("{e}"));
        bytes += file.chunk_bytes(number).unwrap_or(0);
        // And the vertices of pages that are read before their own.
        let of_page = |page| file.page_bytes(&chunk, page).unwrap_or(0) + file.run_bytes(page).unwrap_or(0);
        bytes += chunk.pages().map(of_page).sum::<u64>();
    }
    bytes
}

fn sculpture() -> Model {
    Model::new("sculpture.ply", trees::read(&trees::data("sculpture.ply")), 400)
}

/// An eye on a walk around the model, `step` of 1 once around.
fn walk(tree: &Tree, step: f64, slope: f64) -> Selection {
    let (center, size) = size(tree);
    let angle = step * std::f64::consts::TAU;
    let eye = center + DVec3::new(angle.cos(), 0.2, angle.sin()) * size * 0.6;
    let axis = (center - eye).normalize_or_zero();
    Selection::perspective(Perspective { eye, axis, slope, corner_cos: 0.8 }, Order::Bound)
}

#[test]
fn a_cache_stays_within_its_budget_and_its_meshes_closed() {
    let model = sculpture();
    let borders = Borders::of(&model.tree);
    let (_, cache) = cache_of(model.bytes.clone(), |file| all_bytes(file) / 4);
    let budget = cache.file().crown().bytes() + all_bytes(cache.file()) / 4;
    let mut out = Streamed::default();
    let mut missing = 0;
    for step in 0..60 {
        cache.begin_frame();
        let slope = if step % 7 == 0 { 1e-5 } else { 3e-3 };
        cache
            .extract(&walk(&model.tree, f64::from(step) / 60.0, slope), &mut out)
            .unwrap_or_else(|e| panic!("{e}"));
        assert!(borders.cracks(&named(&out)).is_empty());
        missing += out.missing.len();
        if step % 3 == 0 {
            cache.settle();
        }
        let stats = cache.stats();
        assert!(stats.peak_bytes <= budget && stats.bytes <= stats.peak_bytes, "{stats:?} of {budget}");
    }
    let stats = cache.stats();
    assert!(missing > 0 && stats.evictions > 10, "the budget must pinch: {stats:?}");
    assert!(stats.bytes * 2 > budget, "the budget is used: {stats:?}");
    assert!(cache.errors().is_empty());
}

/// What is asked for ahead is there when it is drawn, without a frame of its own.
#[test]
fn a_view_that_was_asked_for_ahead_misses_nothing() {
    let model = sculpture();
    let view = walk(&model.tree, 0.3, 3e-3);
    let mut out = Streamed::default();
    let (_, cold) = cache_of(model.bytes.clone(), all_bytes);
    cold.extract(&view, &mut out).unwrap_or_else(|e| panic!("{e}"));
    assert!(!out.missing.is_empty());
    let (_, cache) = cache_of(model.bytes.clone(), all_bytes);
    cache.prefetch(&view).unwrap_or_else(|e| panic!("{e}"));
    cache.settle();
    let there = cache.stats();
    cache.begin_frame();
    cache.extract(&view, &mut out).unwrap_or_else(|e| panic!("{e}"));
    assert!(out.missing.is_empty(), "{:?}", out.missing);
    let entered: Vec<Piece> = out.entered.iter().map(|wish| wish.piece).collect();
    assert!(!entered.is_empty() && entered.iter().all(|piece| cache.resident().contains(piece)));
    cache.settle();
    assert_eq!(cache.stats(), there, "an extraction asks for nothing more");
    let bad = Selection::uniform(-1.0, Order::Bound);
    assert!(matches!(cache.prefetch(&bad), Err(fcextract::Error::Selection(_))));
}

/// Against a list of when each was used last: of those that a frame does not use, the oldest go.
#[test]
fn pieces_go_that_were_used_longest_ago() {
    let model = sculpture();
    let (_, cache) = cache_of(model.bytes.clone(), |file| all_bytes(file) / 8);
    let mut out = Streamed::default();
    let mut random = Random::new(11);
    let (center, size) = size(&model.tree);
    let mut used: BTreeMap<Piece, u64> = BTreeMap::new();
    let mut gone = 0;
    for frame in 1..150 {
        let before = cache.resident();
        cache.begin_frame();
        // Near one side of the model, so that each view needs others.
        let eye = center + random.direction() * size * 0.4;
        let perspective = Perspective { eye, axis: DVec3::ZERO, slope: 0.2, corner_cos: 0.8 };
        let selection = Selection::perspective(perspective, Order::Bound);
        cache.extract_now(&selection, &mut out).unwrap_or_else(|e| panic!("{e}"));
        let after = cache.resident();
        let entered: Vec<Piece> = out.entered.iter().map(|wish| wish.piece).collect();
        assert!(out.missing.is_empty() && entered.iter().all(|piece| after.contains(piece)));
        // What is close counts as used.
        let now: Vec<Piece> =
            entered.iter().copied().chain(out.close.iter().map(|wish| wish.piece)).collect();
        let last = |piece: &Piece| used.get(piece).copied().unwrap_or(0);
        let kept = before.iter().filter(|c| after.contains(c) && !now.contains(c));
        let oldest_kept = kept.map(last).min().unwrap_or(frame);
        for piece in before.iter().filter(|piece| !after.contains(piece)) {
            assert!(last(piece) <= oldest_kept, "{piece:?} went, and others stay from frame {oldest_kept}");
            gone += 1;
        }
        for piece in now {
            used.insert(piece, frame);
        }
    }
    assert!(gone > 50, "{gone}");
}

/// After any history, and from any thread.
#[test]
fn what_is_waited_for_depends_on_the_selection_alone() {
    let model = sculpture();
    let (_, cache) = cache_of(model.bytes.clone(), |file| all_bytes(file) / 2);
    let (mut out, mut expected) = (Streamed::default(), Streamed::default());
    let mut random = Random::new(2);
    for _ in 0..40 {
        let selection = walk(&model.tree, random.between(0.0, 1.0), random.between(0.05, 0.3));
        model.streamed(&|_| true, &selection, &mut expected);
        cache.begin_frame();
        if random.below(2) == 0 {
            cache.extract(&selection, &mut out).unwrap_or_else(|e| panic!("{e}"));
        }
        cache.extract_now(&selection, &mut out).unwrap_or_else(|e| panic!("{e}"));
        assert!(out.missing.is_empty(), "{} of {}", out.missing.len(), out.entered.len());
        assert_eq!((&out.indices, &out.ids), (&expected.indices, &expected.ids));
        // And the picture settles on the same.
        cache.begin_frame();
        cache.extract(&selection, &mut out).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!((&out.indices, &out.ids), (&expected.indices, &expected.ids));
    }
}

/// The background thread gets there by itself, the most urgent first.
#[test]
fn the_picture_settles() {
    let model = sculpture();
    let (_, cache) = cache_of(model.bytes.clone(), |file| all_bytes(file) / 2);
    let selection = walk(&model.tree, 0.3, 0.06);
    let (mut out, mut expected) = (Streamed::default(), Streamed::default());
    model.streamed(&|_| true, &selection, &mut expected);
    let mut least = f64::INFINITY;
    for frame in 0.. {
        cache.begin_frame();
        cache.extract(&selection, &mut out).unwrap_or_else(|e| panic!("{e}"));
        let urgent = out.missing.iter().map(|wish| wish.urgency).fold(0.0, f64::max);
        assert!(urgent <= least, "the most urgent come first");
        least = urgent;
        if out.missing.is_empty() {
            break;
        }
        cache.settle();
        assert!(frame < 3);
    }
    assert_eq!(out.indices, expected.indices);
}

#[test]
fn pieces_that_are_close_are_read_ahead() {
    let model = sculpture();
    let (_, cache) = cache_of(model.bytes.clone(), all_bytes);
    let mut out = Streamed::default();
    cache.extract(&walk(&model.tree, 0.1, 0.08), &mut out).unwrap_or_else(|e| panic!("{e}"));
    let close = out.close.len();
    assert!(close > 0);
    cache.settle();
    // A step nearer, by less than is read ahead. What lies below a node of the crown that was not refined before the step
    // could not be known.
    cache.extract(&walk(&model.tree, 0.1, 0.06), &mut out).unwrap_or_else(|e| panic!("{e}"));
    assert!(out.missing.len() * 8 <= close, "{:?} of {close}", out.missing);
}

#[test]
fn a_failing_disk_leaves_a_coarse_mesh_and_says_so() {
    let model = sculpture();
    let borders = Borders::of(&model.tree);
    let (disk, cache) = cache_of(model.bytes.clone(), all_bytes);
    let mut out = Streamed::default();
    let selection = walk(&model.tree, 0.1, 3e-3);
    disk.broken.store(true, Ordering::Relaxed);
    cache.extract_now(&selection, &mut out).unwrap_or_else(|e| panic!("{e}"));
    assert!(!out.missing.is_empty() && out.stats.triangles > 0);
    assert!(borders.cracks(&named(&out)).is_empty());
    let errors = cache.errors();
    assert_eq!(errors.len(), out.missing.len(), "one error a piece");
    assert!(errors[0].1.to_string().contains("the cable was pulled"), "{}", errors[0].1);
    // It does not try for ever.
    let reads = disk.reads.load(Ordering::Relaxed);
    cache.extract_now(&selection, &mut out).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(disk.reads.load(Ordering::Relaxed), reads);
    disk.broken.store(false, Ordering::Relaxed);
    cache.retry();
    cache.extract_now(&selection, &mut out).unwrap_or_else(|e| panic!("{e}"));
    assert!(out.missing.is_empty() && cache.errors().is_empty());
}

#[test]
fn a_damaged_page_is_drawn_as_its_root() {
    let model = sculpture();
    let borders = Borders::of(&model.tree);
    let node =
        model.tree.sections().iter().find(|s| s.tag.to_string() == "NODE").map(|s| s.offset + s.length / 2);
    let mut bytes = model.bytes.clone();
    bytes[node.unwrap_or(0) as usize] ^= 4;
    let (_, cache) = cache_of(bytes, all_bytes);
    let mut out = Streamed::default();
    cache.extract_now(&Selection::full(), &mut out).unwrap_or_else(|e| panic!("{e}"));
    let errors = cache.errors();
    assert_eq!((errors.len(), out.missing.len()), (1, 1));
    assert!(matches!(errors[0].0, Piece::Page(_)));
    assert_eq!(errors[0].1.rule(), Some(Rule::Chunk));
    assert!(borders.cracks(&named(&out)).is_empty());
    assert!(out.stats.triangles > model.tree.face_count() as u64 * 9 / 10);
}

#[test]
fn many_threads_share_a_cache() {
    let model = sculpture();
    let borders = Borders::of(&model.tree);
    let (_, cache) = cache_of(model.bytes.clone(), |file| all_bytes(file) / 3);
    let budget = cache.file().crown().bytes() + all_bytes(cache.file()) / 3;
    std::thread::scope(|scope| {
        for thread in 0..4 {
            let (cache, borders, tree) = (&cache, &borders, &model.tree);
            scope.spawn(move || {
                let mut out = Streamed::default();
                for step in 0..30 {
                    let selection = walk(tree, f64::from(step * (thread + 1)) / 30.0, 4e-3);
                    if thread == 0 {
                        cache.begin_frame();
                    }
                    let drawn = if step % 5 == thread {
                        cache.extract_now(&selection, &mut out)
                    } else {
                        cache.extract(&selection, &mut out)
                    };
                    drawn.unwrap_or_else(|e| panic!("{e}"));
                    assert!(borders.cracks(&named(&out)).is_empty());
                    assert!(cache.stats().peak_bytes <= budget);
                }
            });
        }
    });
    assert!(cache.errors().is_empty());
}

#[test]
fn a_budget_that_is_too_small_is_refused() {
    let model = sculpture();
    let file = open(model.bytes.clone()).unwrap_or_else(|e| panic!("{e}"));
    let crown = file.crown().bytes();
    let error = ChunkCache::new(file, crown + 100).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains(&format!("a budget of {} bytes", crown + 100)), "{error}");
}
