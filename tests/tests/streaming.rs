//! Promise: whatever chunks and pages of a file are in memory, an extracted mesh has no crack and is never finer than asked;
//! with all of them it is the mesh of the whole tree.

#![allow(clippy::print_stdout, reason = "the counts are part of the promise")]

use fcbuild::SplitMode;
use fcbuild::import::Soup;
use fcextract::{
    ChunkCache, Extraction, Order, Perspective, Piece, Resident, Selection, Streamed, Tolerance, extract,
    extract_chunks,
};
use fcgeom::Frustum;
use fct::{Chunk, ChunkFile, ChunkPage, CrownChild, OwnVertices, ReadAt, Rule, Tree, VertexRun};
use fctests::cracks::Borders;
use fctests::random::Random;
use fctests::{meshes, trees};
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// A tree, and all its chunks and pages.
struct Model {
    name: &'static str,
    tree: Tree,
    bytes: Vec<u8>,
    chunks: Vec<Chunk>,
    pages: Vec<ChunkPage>,
    /// The bounds of the chunks' roots, and of the pages'.
    chunk_roots: Vec<f32>,
    page_roots: Vec<f32>,
    file: ChunkFile,
}

/// Some of a model's pieces.
struct Present<'a> {
    model: &'a Model,
    there: &'a dyn Fn(Piece) -> bool,
}

impl<'a> Resident<'a> for Present<'a> {
    fn chunk(&self, chunk: u32) -> Option<&'a Chunk> {
        self.model.chunks.get(chunk as usize).filter(|_| (self.there)(Piece::Chunk(chunk)))
    }

    fn page(&self, page: u32) -> Option<&'a ChunkPage> {
        self.model.pages.get(page as usize).filter(|_| (self.there)(Piece::Page(page)))
    }
}

/// Whether chance has a piece in memory: some of the chunks and some of the pages.
fn chance(random: &mut Random, model: &Model) -> (Vec<bool>, Vec<bool>) {
    let share = |random: &mut Random| match random.below(4) {
        0 => 1.0,
        _ => random.between(0.0, 1.0),
    };
    let mut some = |count: usize| {
        let share = share(random);
        (0..count).map(|_| random.between(0.0, 1.0) < share).collect()
    };
    (some(model.chunks.len()), some(model.pages.len()))
}

/// All pages of a file, which is sound.
fn all_pages(file: &ChunkFile, chunks: &[Chunk]) -> Result<Vec<ChunkPage>, fct::Error> {
    let mut pages = Vec::new();
    for chunk in chunks {
        for page in chunk.pages() {
            let owners = file.runs_of(chunk, page).unwrap_or_default();
            let runs: Vec<VertexRun> =
                owners.iter().map(|owner| file.load_run(*owner)).collect::<Result<_, _>>()?;
            let own: Vec<OwnVertices<'_>> = runs.iter().map(VertexRun::own).collect();
            pages.push(file.load_page(chunk, page, &own)?);
        }
    }
    Ok(pages)
}

impl Model {
    fn new(name: &'static str, soup: Soup, chunk_faces: u32) -> Model {
        let bytes = trees::bytes_in_chunks(soup, SplitMode::Quality, chunk_faces);
        let tree = Tree::from_bytes(bytes.clone()).unwrap_or_else(|e| panic!("{name}: {e}"));
        tree.verify().unwrap_or_else(|e| panic!("{name}: {e}"));
        let file = open(bytes.clone()).unwrap_or_else(|e| panic!("{name}: {e}"));
        let load = |c| file.load(c).unwrap_or_else(|e| panic!("{name}: {e}"));
        let chunks: Vec<Chunk> = (0..file.crown().chunk_count()).map(load).collect();
        let pages = all_pages(&file, &chunks).unwrap_or_else(|e| panic!("{name}: {e}"));
        let (mut chunk_roots, mut page_roots) = (Vec::new(), Vec::new());
        for node in 0..2 * file.crown().chunk_count() {
            if let Some(CrownChild::Chunk(_)) = file.crown().below(node) {
                chunk_roots.push(file.crown().node(node).map_or(0.0, |root| root.bound));
            }
        }
        for chunk in &chunks {
            let mut stack = vec![chunk.root()];
            while let Some(subtree) = stack.pop() {
                match chunk.page(&subtree) {
                    Some(_) => page_roots.push(chunk.node(&subtree).map_or(0.0, |root| root.bound)),
                    None => {
                        let [left, right] =
                            chunk.children(&subtree).unwrap_or_else(|e| panic!("{name}: {e}"));
                        stack.extend([right, left]);
                    }
                }
            }
        }
        Model { name, tree, bytes, chunks, pages, chunk_roots, page_roots, file }
    }

    /// Whether a mesh can stand in for all of a piece: whether its root can be drawn.
    fn is_drawable(&self, piece: Piece) -> bool {
        match piece {
            Piece::Chunk(chunk) => self.chunk_roots[chunk as usize].is_finite(),
            Piece::Page(page) => self.page_roots[page as usize].is_finite(),
        }
    }

    /// The mesh from some of the pieces.
    fn streamed(&self, there: &dyn Fn(Piece) -> bool, selection: &Selection, out: &mut Streamed) {
        extract_chunks(self.file.crown(), &Present { model: self, there }, selection, out)
            .unwrap_or_else(|e| panic!("{}: {e}", self.name));
        assert!(out.damaged.is_empty(), "{}: {:?}", self.name, out.damaged);
        for (id, record) in out.ids.iter().zip(&out.vertices) {
            assert_eq!(record.position(), self.tree.vertices()[*id as usize].position());
        }
        assert_eq!(out.normals.len(), out.ids.len());
    }
}

fn open(bytes: Vec<u8>) -> Result<ChunkFile, fct::Error> {
    ChunkFile::new(Arc::new(bytes), Path::new("a.fct"))
}

/// Meshes of every kind in chunks that are small enough to be many.
fn models() -> Vec<Model> {
    let mut models = vec![
        Model::new("torus", meshes::torus(40, 24, 3), 60),
        Model::new("grid", meshes::grid(24, 5), 40),
        Model::new("pieces", meshes::pieces(9), 20),
        Model::new("moebius strip", meshes::moebius(60), 20),
        Model::new("three sheets", meshes::three_sheets(12), 30),
        Model::new("sparse tangle", meshes::tangle(400, 300, 1), 10),
        Model::new("sculpture.ply", trees::read(&trees::data("sculpture.ply")), 700),
        Model::new("terrain.ply", trees::read(&trees::data("terrain.ply")), 300),
        Model::new("parts.ply", trees::read(&trees::data("parts.ply")), 300),
    ];
    for seed in 0..6 {
        models.push(Model::new("tangle", meshes::tangle(40, 160, seed), 6));
        models.push(Model::new("random bits", meshes::random_bits(seed), 6));
    }
    models
}

fn size(tree: &Tree) -> (DVec3, f64) {
    let [low, high] =
        [tree.meta().bounds_min, tree.meta().bounds_max].map(|b| DVec3::from_array(b.map(f64::from)));
    ((low + high) * 0.5, (high - low).length())
}

/// A random tolerance: uniform or from an eye near or far, from the finest detail to almost none.
fn random_selection(random: &mut Random, tree: &Tree) -> Selection {
    let (center, size) = size(tree);
    let order = if random.below(2) == 0 { Order::Bound } else { Order::Budget };
    let fraction = 10_f64.powf(random.between(-6.0, 0.3));
    match random.below(6) {
        0 => Selection::full(),
        1 => Selection::uniform(size * fraction, order),
        _ => {
            let eye = center + random.direction() * size * 10_f64.powf(random.between(-1.5, 1.2));
            let axis = if random.below(3) == 0 { DVec3::ZERO } else { random.direction() };
            let corner_cos = random.between(0.4, 1.0);
            Selection::perspective(Perspective { eye, axis, slope: fraction, corner_cos }, order)
        }
    }
}

/// The triangles by the names of their vertices, each from its lowest on, in order.
fn triangles(indices: &[u32], name: impl Fn(u32) -> u32) -> Vec<[u32; 3]> {
    let turned = |t: &[u32]| {
        let mut t = [t[0], t[1], t[2]].map(&name);
        let lowest = (0..3).min_by_key(|i| t[*i]).unwrap_or(0);
        t.rotate_left(lowest);
        t
    };
    let mut all: Vec<_> = indices.chunks_exact(3).map(turned).collect();
    all.sort_unstable();
    all
}

fn named(out: &Streamed) -> Vec<u32> {
    out.indices.iter().map(|i| out.ids[*i as usize]).collect()
}

/// Closed, and no finer: fewer clusters, and no vertex that the whole tree does not show.
#[test]
fn missing_pieces_leave_no_crack() {
    let (mut looked, mut coarser, mut pages_missing, mut drawn) = (0, 0, 0, 0);
    for model in models() {
        let (borders, seams) = (Borders::of(&model.tree), Borders::with_seams(&model.tree));
        let mut random = Random::new(7);
        let (mut out, mut whole) = (Streamed::default(), Extraction::default());
        for view in 0..40 {
            let selection = random_selection(&mut random, &model.tree);
            extract(&model.tree, &selection, &mut whole).unwrap_or_else(|e| panic!("{e}"));
            let shown: BTreeSet<u32> = whole.indices.iter().copied().collect();
            for _ in 0..4 {
                let (chunks, pages) = chance(&mut random, &model);
                let there = |piece: Piece| match piece {
                    Piece::Chunk(chunk) => chunks[chunk as usize],
                    Piece::Page(page) => pages[page as usize],
                };
                model.streamed(&there, &selection, &mut out);
                // A piece that nothing can be drawn for takes whole components with it, and beyond a seam of
                // those there is nothing.
                let whole_surface = out.missing.iter().all(|wish| model.is_drawable(wish.piece));
                let borders = if whole_surface { &borders } else { &seams };
                let cracks = borders.cracks(&named(&out));
                assert!(
                    cracks.is_empty(),
                    "{}, view {view}: {} cracks such as {:?} in {} triangles; {selection:?}",
                    model.name,
                    cracks.len(),
                    cracks.first(),
                    out.stats.triangles
                );
                assert!(out.stats.clusters <= whole.stats.clusters, "{}", model.name);
                assert!(out.ids.iter().all(|id| shown.contains(id)), "{}, view {view}: finer", model.name);
                assert!(out.entered.iter().all(|wish| there(wish.piece)));
                assert!(out.missing.iter().all(|wish| !there(wish.piece) && wish.urgency >= 1.0));
                looked += 1;
                coarser += u64::from(!out.missing.is_empty());
                pages_missing += u64::from(out.missing.iter().any(|w| matches!(w.piece, Piece::Page(_))));
                drawn += out.stats.triangles;
            }
        }
    }
    println!("no crack in {looked} meshes of {drawn} triangles, {coarser} of them with pieces missing");
    assert!(coarser * 3 > looked && pages_missing * 5 > looked, "too few tests have something missing");
}

fn vertices(triangles: &[[u32; 3]]) -> BTreeSet<u32> {
    triangles.iter().flatten().copied().collect()
}

/// The same clusters, and the same triangles, but for vertices that are only a little too eager to be drawn.
#[test]
fn with_all_chunks_it_is_the_mesh_of_the_tree() {
    let (mut all, mut others, mut equal, mut looked) = (0, 0, 0, 0);
    for model in models() {
        let mut random = Random::new(3);
        let (mut out, mut whole) = (Streamed::default(), Extraction::default());
        for view in 0..50 {
            let selection = random_selection(&mut random, &model.tree);
            extract(&model.tree, &selection, &mut whole).unwrap_or_else(|e| panic!("{e}"));
            model.streamed(&|_| true, &selection, &mut out);
            assert!(out.missing.is_empty());
            assert_eq!(out.stats.clusters, whole.stats.clusters, "{}, view {view}", model.name);
            assert_eq!(out.stats.nodes_visited, whole.stats.nodes_visited, "{}, view {view}", model.name);
            assert_eq!(out.stats.bound, whole.stats.bound, "{}, view {view}", model.name);
            let expected = triangles(&whole.indices, |v| v);
            let found = triangles(&out.indices, |v| out.ids[v as usize]);
            let uniform = matches!(selection.tolerance, Tolerance::Uniform { .. } | Tolerance::Full);
            // Roots of pages are drawn from copies, in another precision than in a page: of equally good diagonals one
            // may choose another.
            let same = found.len() == expected.len() && vertices(&found) == vertices(&expected);
            assert!(same || !uniform, "{}, view {view}: {selection:?}", model.name);
            let there: BTreeSet<_> = found.iter().collect();
            others += expected.iter().filter(|t| !there.contains(t)).count();
            all += expected.len();
            equal += usize::from(found == expected);
            looked += 1;
        }
    }
    println!("{others} of {all} triangles differ, {} of {looked} meshes", looked - equal);
    assert!(others * 200 < all, "{others} of {all} triangles differ");
}

/// Only what shows is needed: with a frustum, pieces outside are neither entered nor missed.
#[test]
fn culled_pieces_are_not_asked_for() {
    let model = Model::new("sculpture.ply", trees::read(&trees::data("sculpture.ply")), 700);
    let borders = Borders::of(&model.tree);
    let (center, size) = size(&model.tree);
    let mut out = Streamed::default();
    let mut random = Random::new(5);
    let mut shares = 0.0;
    for _ in 0..20 {
        let eye = center + random.direction() * size * 0.4;
        let forward = random.direction();
        let up = forward.any_orthonormal_vector();
        let view = glam::dcamera::rh::proj::directx::perspective_infinite_reverse(0.8, 1.0, size * 1e-3)
            * glam::dcamera::rh::view::look_to_mat4(eye, forward, up);
        let perspective = Perspective { eye, axis: forward, slope: 1e-3, corner_cos: 0.85 };
        let mut selection = Selection::perspective(perspective, Order::Bound);
        model.streamed(&|_| true, &selection, &mut out);
        let all = out.entered.len();
        selection.frustum = Some(Frustum::from_view_projection(&view));
        model.streamed(&|piece| matches!(piece, Piece::Chunk(_)), &selection, &mut out);
        let missing = out.missing.len() + out.entered.len();
        model.streamed(&|_| true, &selection, &mut out);
        assert_eq!(missing, out.entered.len(), "what is missing is what is entered when it is there");
        shares += out.entered.len() as f64 / all.max(1) as f64;
        // Borders of what was culled aside, nothing gapes: the parts in sight fit.
        assert!(borders.cracks(&named(&out)).len() <= out.indices.len());
    }
    assert!(shares / 20.0 < 0.7, "{}", shares / 20.0);
}

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
