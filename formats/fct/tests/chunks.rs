//! Promise: a chunk that is read alone holds what the tree holds there, and damage to it is found when it is read.

mod sample;

use std::io;
use std::path::Path;
use std::sync::Arc;

use fct::{Child, ChunkFile, CrownChild, Loops, ReadAt, Reader, Rule, Subtree, Tree};
use sample::{Sample, Split, rehash, section};

fn open(bytes: Vec<u8>) -> Result<ChunkFile, fct::Error> {
    ChunkFile::new(Arc::new(bytes), Path::new("a.fct"))
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

/// Compares a subtree of a chunk, or what is below it, with the same subtree of the tree.
fn compare(tree: &Reader<'_>, whole: Subtree, part: &Reader<'_>, here: Subtree, id: &dyn Fn(u32) -> u32) {
    let mut stack = vec![(whole, here, true)];
    while let Some((whole, here, is_root)) = stack.pop() {
        assert_eq!(whole.face_count(), here.face_count());
        if let Child::Face(_) = whole.child.kind() {
            assert_eq!(part.face(&here).unwrap().map(id), tree.face(&whole).unwrap());
            continue;
        }
        assert_eq!(whole.child, here.child);
        assert_eq!(part.node(&here).unwrap(), tree.node(&whole).unwrap());
        let (mut a, mut b) = (Loops::default(), Loops::default());
        // The root is drawn from the crown.
        if !is_root {
            tree.read_loops(&whole, &mut a).unwrap();
            part.read_loops(&here, &mut b).unwrap();
            assert_eq!(sorted(&a, |v| v), sorted(&b, id));
            assert_eq!(id(part.first_corner(&here).unwrap()), tree.first_corner(&whole).unwrap());
        }
        let (whole, here) = (tree.children(&whole).unwrap(), part.children(&here).unwrap());
        stack.extend([(whole[0], here[0], false), (whole[1], here[1], false)]);
    }
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
    let (mut faces, mut chunks) = (0, 0);
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
                let id = |v: u32| chunk.vertex_id(v).unwrap();
                compare(&reader, subtree, &chunk.reader(), chunk.root(), &id);
                for (v, record) in (0..).zip(chunk.reader().vertices()) {
                    assert_eq!(record, &tree.vertices()[id(v) as usize]);
                    let at = id(v) as usize;
                    assert_eq!(chunk.normals().get(v as usize), tree.normals().and_then(|n| n.get(at)));
                    assert_eq!(chunk.colors().get(v as usize), tree.colors().and_then(|n| n.get(at)));
                }
                assert!(
                    chunk.bytes() <= file.chunk_bytes(number).unwrap(),
                    "announced {:?}",
                    file.chunk_bytes(number)
                );
                faces += chunk.root().face_count();
                chunks += 1;
            }
        }
    }
    assert_eq!(faces as usize, tree.face_count());
    assert_eq!(chunks, crown.chunk_count());
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

/// Where a chunk comes from is read with as few, long reads as there are sections.
#[test]
fn a_chunk_takes_one_read_a_section() {
    let file = open(Sample::patches(6, 5, 12).in_chunks(40).bytes()).unwrap();
    let [before, _] = file.reads();
    file.load(1).unwrap();
    let [after, _] = file.reads();
    assert!(after - before <= 11, "{} reads", after - before);
}

#[test]
fn a_file_without_chunks_is_refused_and_says_what_to_do() {
    let error = open(Sample::patches(4, 3, 12).bytes()).unwrap_err();
    assert_eq!(error.rule(), Some(Rule::SectionRequired));
    assert!(error.to_string().contains("build the file again"), "{error}");
}

/// Reads all chunks; how many could be.
fn readable(bytes: Vec<u8>) -> Option<u32> {
    let file = open(bytes).ok()?;
    Some((0..file.crown().chunk_count()).filter(|c| file.load(*c).is_ok()).count() as u32)
}

#[test]
fn every_flipped_bit_is_found_by_the_chunk_that_it_is_in() {
    let bytes = Sample::patches(5, 4, 12).in_chunks(24).bytes();
    let all = readable(bytes.clone()).unwrap();
    assert!(all >= 3);
    let range = |tag: [u8; 4]| {
        let (_, start, length) = section(&bytes, &tag);
        start..start + length
    };
    let within = |at: usize, tags: &[&[u8; 4]]| tags.iter().any(|tag| range(**tag).contains(&at));
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (at % 8);
        let left = readable(damaged);
        if at < 128 || within(at, &[b"META", b"CRWN"]) {
            assert_eq!(left, None, "byte {at}");
        } else if within(at, &[b"NODE", b"FACE", b"LOOP", b"LINK", b"VERT", b"NORM", b"COLR", b"KINS"]) {
            assert_eq!(left, Some(all - 1), "byte {at}");
        } else if within(at, &[b"WELD", b"BPOL", b"GRUP"]) {
            assert_eq!(left, Some(all), "byte {at}");
        }
    }
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
    let (_, crown, crown_length) = section(&bytes, b"CRWN");
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
            let _ = file.load(chunk);
        }
    }
    assert!(opened > 500, "{opened}");
}

/// The same for what is within a chunk: its hash is computed anew.
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
            let reader = chunk.reader();
            let mut stack = vec![chunk.root()];
            let mut loops = Loops::default();
            while let Some(subtree) = stack.pop() {
                let _ = (reader.face(&subtree), reader.read_loops(&subtree, &mut loops));
                if let Ok(children) = reader.children(&subtree) {
                    stack.extend(children);
                }
            }
            walked += 1;
        }
    }
    assert!(walked > 300, "{walked}");
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
        let load = || ChunkFile::new(Arc::new(source), Path::new("a.fct"))?.load(0);
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
