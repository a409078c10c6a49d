//! Promise: a chunk and a page that are read alone hold what the tree holds there, and damage to them is found when they
//! are read.

mod sample;

use std::io;
use std::path::Path;
use std::sync::Arc;

use fct::{
    Child, Chunk, ChunkFile, ChunkPage, CrownChild, Loops, OwnVertices, ReadAt, Reader, Rule, Subtree, Tree,
    VertexRun,
};
use sample::{Sample, Split, read_u32, rehash, section};
use xxhash_rust::xxh3::xxh3_64;

fn open(bytes: Vec<u8>) -> Result<ChunkFile, fct::Error> {
    ChunkFile::new(Arc::new(bytes), Path::new("a.fct"))
}

/// A page with the vertices that it uses, read one after the other.
fn load_page(file: &ChunkFile, chunk: &Chunk, page: u32) -> Result<ChunkPage, fct::Error> {
    let owners = file.runs_of(chunk, page).unwrap_or_default();
    let runs: Vec<VertexRun> = owners.iter().map(|o| file.load_run(*o)).collect::<Result<_, _>>()?;
    for (run, owner) in runs.iter().zip(&owners) {
        assert!(run.bytes() <= file.run_bytes(*owner).unwrap());
    }
    let own: Vec<OwnVertices<'_>> = runs.iter().map(VertexRun::own).collect();
    file.load_page(chunk, page, &own)
}

/// Each loop from its lowest vertex on, in order.
fn sorted(loops: &Loops, name: impl Fn(u32) -> u32) -> Vec<Vec<u32>> {
    let mut rings: Vec<Vec<u32>> = loops.iter().map(|ring| ring.iter().map(|v| name(*v)).collect()).collect();
    for ring in &mut rings {
        let lowest = (0..ring.len()).min_by_key(|i| ring[*i]).unwrap();
        ring.rotate_left(lowest);
    }
    rings.sort();
    rings
}

/// Compares a page with the same subtree of the tree.
fn compare_page(tree: &Reader<'_>, whole: Subtree, page: &ChunkPage) {
    let part = page.reader();
    let id = |v: u32| page.vertex_id(v).unwrap();
    let mut stack = vec![(whole, page.root(whole.child))];
    while let Some((whole, here)) = stack.pop() {
        assert_eq!(whole.face_count(), here.face_count());
        if let Child::Face(_) = whole.child.kind() {
            assert_eq!(part.face(&here).unwrap().map(id), tree.face(&whole).unwrap());
            continue;
        }
        assert_eq!(whole.child, here.child);
        assert_eq!(part.node(&here).unwrap(), tree.node(&whole).unwrap());
        let (mut a, mut b) = (Loops::default(), Loops::default());
        tree.read_loops(&whole, &mut a).unwrap();
        part.read_loops(&here, &mut b).unwrap();
        assert_eq!(sorted(&a, |v| v), sorted(&b, id));
        assert_eq!(id(part.first_corner(&here).unwrap()), tree.first_corner(&whole).unwrap());
        let (whole, here) = (tree.children(&whole).unwrap(), part.children(&here).unwrap());
        stack.extend([(whole[0], here[0]), (whole[1], here[1])]);
    }
}

/// Compares a chunk and its pages with the same subtree of the tree; how many pages.
fn compare_chunk(tree: &Tree, whole: Subtree, file: &ChunkFile, chunk: &Chunk) -> usize {
    let reader = tree.reader();
    let attributes = |at: usize| (tree.normals().map(|n| n[at]), tree.colors().map(|c| c[at]));
    for (place, id) in chunk.ids().iter().enumerate() {
        let at = *id as usize;
        assert_eq!(chunk.find(*id), Some(place));
        assert_eq!(&chunk.vertices()[place], &tree.vertices()[at]);
        assert_eq!((chunk.normals().get(place).copied(), chunk.colors().get(place).copied()), attributes(at));
    }
    let (mut stack, mut pages) = (vec![(whole, chunk.root())], 0);
    while let Some((whole, here)) = stack.pop() {
        assert_eq!(whole.face_count(), here.face_count());
        let (mut a, mut b) = (Loops::default(), Loops::default());
        // The root is drawn from the crown.
        if here != chunk.root() {
            chunk.read_loops(&here, &mut b).unwrap();
            reader.read_loops(&whole, &mut a).unwrap();
            assert_eq!(sorted(&a, |v| v), sorted(&b, |v| v));
            let corner = chunk.corner(&here).unwrap();
            assert_eq!(corner, reader.first_corner(&whole).unwrap());
            assert!(chunk.find(corner).is_some());
        }
        if whole.face_count() > 1 {
            assert_eq!(whole.child, here.child);
            let (found, expected) = (chunk.node(&here).unwrap(), reader.node(&whole).unwrap());
            assert_eq!(found, expected);
            // What must be drawn when the node above is refined.
            for vertex in a.vertices {
                let record = &tree.vertices()[vertex as usize];
                let needed = record.bound() >= found.bound || record.budget() >= found.budget;
                assert!(!needed || chunk.find(vertex).is_some());
            }
        }
        let Some(number) = chunk.page(&here) else {
            let (whole, here) = (reader.children(&whole).unwrap(), chunk.children(&here).unwrap());
            stack.extend([(whole[1], here[1]), (whole[0], here[0])]);
            continue;
        };
        let page = load_page(file, chunk, number).unwrap();
        compare_page(&reader, whole, &page);
        for (v, record) in (0..).zip(page.reader().vertices()) {
            let at = page.vertex_id(v).unwrap() as usize;
            assert_eq!(record, &tree.vertices()[at]);
            let here = (page.normals().get(v as usize).copied(), page.colors().get(v as usize).copied());
            assert_eq!(here, attributes(at));
        }
        assert_eq!(file.crown().vertices_of(number), Some(page.own_vertices()));
        let room = file.page_bytes(chunk, number).unwrap();
        assert!(page.bytes() <= room, "{} of {room}", page.bytes());
        pages += 1;
    }
    assert_eq!(pages, chunk.pages().len());
    pages
}

fn check(sample: &Sample) {
    let bytes = sample.bytes();
    let tree = Tree::from_bytes(bytes.clone()).unwrap();
    tree.verify().unwrap();
    let file = open(bytes).unwrap();
    let reader = tree.reader();
    let crown = file.crown();
    let mut loops = Loops::default();
    let mut stack = vec![(0, tree.whole())];
    let (mut faces, mut chunks, mut pages) = (0, 0, 0);
    while let Some((node, subtree)) = stack.pop() {
        let drawn = match reader.node(&subtree) {
            Ok(expected) => {
                let found = crown.node(node).unwrap();
                assert_eq!((found.center, found.radius), (expected.center, expected.radius));
                assert_eq!((found.bound, found.budget), (expected.bound, expected.budget));
                assert_eq!((found.axis(), found.cos()), (expected.axis(), expected.cos()));
                assert_eq!(found.epsilon(), expected.epsilon());
                assert_eq!(found.plane(), expected.plane());
                expected.bound.is_finite()
            }
            Err(_) => true,
        };
        if drawn {
            crown.read_loops(node, &mut loops).unwrap();
            assert_eq!(sorted(&loops, |v| v), sorted(&tree.loops_of(&subtree).unwrap(), |v| v));
        }
        let (corner, place) = crown.corner(node).unwrap();
        assert_eq!(corner, reader.first_corner(&subtree).unwrap());
        assert_eq!(&crown.vertices()[place], &tree.vertices()[corner as usize]);
        match crown.below(node).unwrap() {
            CrownChild::Nodes(below) => {
                let children = reader.children(&subtree).unwrap();
                stack.extend([(below[1], children[1]), (below[0], children[0])]);
            }
            CrownChild::Chunk(number) => {
                let chunk = file.load(number).unwrap();
                pages += compare_chunk(&tree, subtree, &file, &chunk);
                assert!(chunk.pages().all(|page| crown.chunk_of(page) == number));
                let room = file.chunk_bytes(number).unwrap();
                assert!(chunk.bytes() <= room, "{} of {room}", chunk.bytes());
                faces += chunk.root().face_count();
                chunks += 1;
            }
        }
    }
    assert_eq!(faces as usize, tree.face_count());
    assert_eq!(chunks, crown.chunk_count());
    assert_eq!(pages as u32, crown.page_count());
}

#[test]
fn chunks_hold_what_the_tree_holds() {
    for chunk_faces in [1, 20, 60, 10_000] {
        check(&Sample::patches(6, 5, 12).in_chunks(chunk_faces));
        check(&Sample::patches(3, 2, 1).in_chunks(chunk_faces));
        check(&Sample::fan(40, Split::OneByOne).in_chunks(chunk_faces));
    }
    let mut plain = Sample::patches(6, 5, 12);
    (plain.normals, plain.colors) = (None, None);
    check(&plain.in_chunks(20));
}

/// Where a piece comes from is read with as few, long reads as there are sections.
#[test]
fn a_piece_takes_one_read_a_section() {
    let file = open(Sample::patches(6, 5, 12).in_chunks(40).bytes()).unwrap();
    let reads = |after: u64| {
        let [all, _] = file.reads();
        all - after
    };
    let before = reads(0);
    let chunk = file.load(1).unwrap();
    assert!(reads(before) <= 5, "{}", reads(before));
    let page = chunk.pages().start;
    let before = reads(0);
    let runs: Vec<_> =
        file.runs_of(&chunk, page).unwrap().iter().map(|o| file.load_run(*o).unwrap()).collect();
    assert!(reads(before) <= 3 * runs.len() as u64, "{}", reads(before));
    let before = reads(0);
    let own: Vec<_> = runs.iter().map(VertexRun::own).collect();
    file.load_page(&chunk, page, &own).unwrap();
    assert!(reads(before) <= 3, "{}", reads(before));
}

#[test]
fn a_file_without_chunks_is_refused_and_says_what_to_do() {
    let error = open(Sample::patches(4, 3, 12).bytes()).unwrap_err();
    assert_eq!(error.rule(), Some(Rule::SectionRequired));
    assert!(error.to_string().contains("build the file again"), "{error}");
}

/// Reads all chunks and pages; which of each could not be. None if the file is not opened.
fn unreadable(bytes: Vec<u8>) -> Option<(Vec<u32>, Vec<u32>)> {
    let file = open(bytes).ok()?;
    let (mut chunks, mut pages) = (Vec::new(), Vec::new());
    for number in 0..file.crown().chunk_count() {
        match file.load(number) {
            Ok(chunk) => pages.extend(chunk.pages().filter(|page| load_page(&file, &chunk, *page).is_err())),
            Err(_) => chunks.push(number),
        }
    }
    Some((chunks, pages))
}

#[test]
fn every_flipped_bit_is_found_by_the_piece_that_it_is_in() {
    let bytes = Sample::patches(5, 4, 12).in_chunks(24).bytes();
    assert_eq!(unreadable(bytes.clone()), Some((vec![], vec![])));
    let file = open(bytes.clone()).unwrap();
    assert!(file.crown().chunk_count() >= 3 && file.crown().page_count() > file.crown().chunk_count());
    let chunks: Vec<Chunk> = (0..file.crown().chunk_count()).map(|c| file.load(c).unwrap()).collect();
    let users = |owner: u32| -> Vec<u32> {
        let uses = |page: &u32| {
            let chunk = &chunks[file.crown().chunk_of(*page) as usize];
            file.runs_of(chunk, *page).unwrap().contains(&owner)
        };
        (0..file.crown().page_count()).filter(uses).collect()
    };
    let range = |tag: &[u8; 4]| {
        let (_, start, length) = section(&bytes, tag);
        start..start + length
    };
    let within = |at: usize, tags: &[&[u8; 4]]| tags.iter().any(|tag| range(tag).contains(&at));
    let mut neighbours = 0;
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (at % 8);
        let left = unreadable(damaged);
        if at < 128 || within(at, &[b"META", b"CRPG"]) {
            assert_eq!(left, None, "byte {at}");
        } else if within(at, &[b"CHTP", b"LINK", b"PAGE"]) {
            let (chunks, pages) = left.unwrap();
            assert_eq!((chunks.len(), pages.len()), (1, 0), "byte {at}");
        } else if within(at, &[b"NODE", b"FACE", b"LOOP"]) {
            let (chunks, pages) = left.unwrap();
            assert_eq!((chunks.len(), pages.len()), (0, 1), "byte {at}");
        } else if within(at, &[b"VERT"]) {
            // And by all that use vertices of the page.
            let vertex = (at - range(b"VERT").start) / 27;
            let expected = users(file.crown().owner_of(vertex as u32).unwrap());
            neighbours = neighbours.max(expected.len());
            assert_eq!(left, Some((vec![], expected)), "byte {at}");
        } else if within(at, &[b"WELD", b"BPOL", b"GRUP"]) {
            assert_eq!(left, Some((vec![], vec![])), "byte {at}");
        }
    }
    assert!(neighbours > 1);
}

/// Hashes made right again: whatever stands there, nothing panics and what can be read can be walked.
#[test]
fn edits_that_hashes_do_not_show_do_no_harm() {
    let bytes = Sample::patches(5, 4, 12).in_chunks(24).bytes();
    let mut state = 7_u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let (_, crown, crown_length) = section(&bytes, b"CRPG");
    let mut opened = 0;
    for _ in 0..4000 {
        let mut edited = bytes.clone();
        for _ in 0..=random(2) {
            let at = crown + 4 * random(crown_length / 4);
            let value = [0, 1, u32::MAX, 1 << 31, random(100) as u32, random(1 << 31) as u32][random(6)];
            edited[at..at + 4].copy_from_slice(&value.to_le_bytes());
        }
        rehash(&mut edited);
        let Ok(file) = open(edited) else { continue };
        opened += 1;
        let mut loops = Loops::default();
        for node in 0..2 * file.crown().chunk_count() {
            let _ = (file.crown().node(node), file.crown().read_loops(node, &mut loops));
            let _ = (file.crown().below(node), file.crown().corner(node));
        }
        for chunk in 0..=file.crown().chunk_count() {
            let Ok(chunk) = file.load(chunk) else { continue };
            for page in 0..=file.crown().page_count() {
                let _ = (file.page_bytes(&chunk, page), load_page(&file, &chunk, page));
            }
        }
    }
    assert!(opened > 500, "{opened}");
}

/// The same for what is within a chunk: its hashes are computed anew.
#[test]
fn chunks_of_any_bytes_are_walked_without_harm() {
    let sample = Sample::patches(5, 4, 12);
    let mut state = 3_u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let mut walked = 0;
    for _ in 0..150 {
        let mut sample = sample.clone();
        match random(4) {
            0 => {
                let page = random(sample.packed.pages.len());
                let page = &mut sample.packed.pages[page];
                [&mut page.own_vertices, &mut page.links, &mut page.loop_bytes][random(3)]
                    .set(random(300) as u16);
            }
            1 => {
                let node = random(sample.packed.nodes.len());
                sample.packed.nodes[node].left_faces = random(256) as u8;
            }
            2 => {
                let at = random(sample.packed.loops.len());
                sample.packed.loops[at] = random(256) as u8;
            }
            _ => {
                let face = random(sample.packed.faces.len());
                sample.packed.faces[face].vertices[random(3)] = random(256) as u8;
            }
        }
        let made = fct::ChunkData::with_faces(&sample.packed, &sample.vertices, None, None, 24);
        let Ok(chunks) = made else { continue };
        (sample.chunks, sample.normals, sample.colors) = (Some(chunks), None, None);
        let Ok(file) = open(sample.bytes()) else { continue };
        for number in 0..file.crown().chunk_count() {
            let Ok(chunk) = file.load(number) else { continue };
            let mut loops = Loops::default();
            let mut stack = vec![chunk.root()];
            while let Some(subtree) = stack.pop() {
                let _ = (chunk.node(&subtree), chunk.read_loops(&subtree, &mut loops));
                let _ = (chunk.corner(&subtree), chunk.record(&subtree));
                if let Ok(children) = chunk.children(&subtree) {
                    stack.extend(children);
                }
                let Some(Ok(page)) = chunk.page(&subtree).map(|page| load_page(&file, &chunk, page)) else {
                    continue;
                };
                let reader = page.reader();
                let mut stack = vec![page.root(subtree.child)];
                while let Some(subtree) = stack.pop() {
                    let _ = (reader.face(&subtree), reader.read_loops(&subtree, &mut loops));
                    if let Ok(children) = reader.children(&subtree) {
                        stack.extend(children);
                    }
                }
            }
            walked += 1;
        }
    }
    assert!(walked > 300, "{walked}");
}

/// Copies that are not those of the tree, under a hash that is right: whatever stands there, nothing panics, and no
/// count takes more memory than was announced.
#[test]
fn copies_of_any_bytes_do_no_harm() {
    let bytes = Sample::patches(5, 4, 12).in_chunks(24).bytes();
    let mut state = 11_u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let place = |tag: &[u8; 4]| {
        let (_, start, length) = section(&bytes, tag);
        (start, length)
    };
    let chunk_count = open(bytes.clone()).unwrap().crown().chunk_count() as usize;
    // The fields of a chunk's record, and where the next chunk's begin.
    let field = |chunk: usize, at: usize| read_u32(&bytes, place(b"CRPG").0 + 32 + 36 * chunk + at) as usize;
    let run = |chunk: usize, at: usize, tag: &[u8; 4], size: usize| {
        let (start, length) = place(tag);
        let end = if chunk + 1 < chunk_count { field(chunk + 1, at) } else { length / size };
        start + size * field(chunk, at)..start + size * end
    };
    let (mut loaded, mut refused) = (0, 0);
    for round in 0..3000 {
        let chunk = random(chunk_count);
        let copies = run(chunk, 32, b"CHTP", 1);
        let mut edited = bytes.clone();
        for _ in 0..=random(2) {
            // Mostly what stands before the vertices, which may be anything.
            let part = [1, 4][random(2)];
            let at = copies.start + random(copies.len() / part);
            edited[at] = [0, 1, 0x7F, 0x80, u8::MAX, random(256) as u8][random(6)];
        }
        let pages = run(chunk, 24, b"PAGE", 40);
        let tops = place(b"TOPN").0 + 68 * field(chunk, 12);
        let loops = place(b"TOPL").0 + field(chunk, 16);
        let runs = [
            tops..tops + 68 * (pages.len() / 40 - 1),
            loops..loops + field(chunk, 20),
            pages,
            run(chunk, 28, b"LINK", 4),
            copies,
        ];
        let hashed: Vec<u8> = runs.iter().flat_map(|run| edited[run.clone()].to_vec()).collect();
        let record = place(b"CRPG").0 + 32 + 36 * chunk;
        if round == 0 {
            let unedited: Vec<u8> = runs.iter().flat_map(|run| bytes[run.clone()].to_vec()).collect();
            assert_eq!(xxh3_64(&unedited).to_le_bytes(), bytes[record..record + 8], "what a hash covers");
        }
        edited[record..record + 8].copy_from_slice(&xxh3_64(&hashed).to_le_bytes());
        rehash(&mut edited);
        let file = open(edited).unwrap();
        let room = file.chunk_bytes(chunk as u32).unwrap();
        let Ok(chunk) = file.load(chunk as u32) else {
            refused += 1;
            continue;
        };
        assert!(chunk.bytes() <= room, "{} of {room}", chunk.bytes());
        loaded += 1;
        let mut loops = Loops::default();
        let mut stack = vec![chunk.root()];
        while let Some(subtree) = stack.pop() {
            let _ = (chunk.node(&subtree), chunk.read_loops(&subtree, &mut loops), chunk.record(&subtree));
            let _ = chunk.corner(&subtree).and_then(|corner| chunk.find(corner));
            if let Ok(children) = chunk.children(&subtree) {
                stack.extend(children);
            }
        }
    }
    assert!(loaded > 500 && refused > 150, "{loaded} loaded, {refused} refused");
}

/// Fails after so many reads.
struct Failing(Vec<u8>, std::sync::atomic::AtomicU64);

impl ReadAt for Failing {
    fn read_at(&self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        use std::sync::atomic::Ordering;
        if self.1.fetch_sub(1, Ordering::Relaxed) == 0 {
            return Err(io::Error::other("the cable was pulled"));
        }
        self.0.read_at(offset, out)
    }

    fn length(&self) -> io::Result<u64> {
        self.0.length()
    }
}

#[test]
fn each_failing_read_is_an_error_that_says_where() {
    let bytes = Sample::patches(5, 4, 12).in_chunks(24).bytes();
    for reads in 0..40 {
        let source = Failing(bytes.clone(), reads.into());
        let load = || {
            let file = ChunkFile::new(Arc::new(source), Path::new("a.fct"))?;
            let chunk = file.load(0)?;
            load_page(&file, &chunk, chunk.pages().start)
        };
        match load() {
            Err(error) => {
                assert_eq!(error.exit_code(), 4, "{error}");
                assert!(error.to_string().contains("a.fct: cannot read"), "{error}");
                assert!(error.to_string().contains("the cable was pulled"), "{error}");
            }
            Ok(_) => {
                assert!(reads >= 12, "{reads}");
                return;
            }
        }
    }
    panic!("it never succeeds");
}
