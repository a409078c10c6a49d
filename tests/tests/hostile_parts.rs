//! Promise: a file that is drawn in parts may hold anything. Where hashes were made right again nothing panics, memory
//! stays within its budget, and what is drawn names vertices that are there.

use fcbuild::SplitMode;
use fcextract::{ChunkCache, Order, Perspective, Selection, Streamed};
use fct::{ChunkFile, Tree};
use fctests::random::Random;
use fctests::{meshes, trees};
use glam::DVec3;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use xxhash_rust::xxh3::xxh3_64;

/// A file whose hashes can be made right after an edit, for who reads it in parts.
struct Edited {
    bytes: Vec<u8>,
    sections: Vec<([u8; 4], Range<usize>)>,
}

impl Edited {
    fn new(bytes: Vec<u8>) -> Edited {
        let tree = Tree::from_bytes(bytes.clone()).unwrap_or_else(|e| panic!("{e}"));
        let range = |s: &fct::SectionInfo| s.offset as usize..(s.offset + s.length) as usize;
        let sections = tree.sections().iter().map(|s| (s.tag.0, range(s))).collect();
        Edited { bytes, sections }
    }

    fn section(&self, tag: &[u8; 4]) -> Range<usize> {
        self.sections.iter().find(|(t, _)| t == tag).map_or(0..0, |(_, range)| range.clone())
    }

    fn u32(&self, at: usize) -> usize {
        self.bytes.get(at..at + 4).map_or(0, |b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize)
    }

    fn u16(&self, at: usize) -> usize {
        self.bytes.get(at..at + 2).map_or(0, |b| usize::from(u16::from_le_bytes([b[0], b[1]])))
    }

    /// Some elements of a section; none if they leave it.
    fn run(&self, tag: &[u8; 4], size: usize, first: usize, count: usize) -> Option<&[u8]> {
        let section = self.section(tag);
        self.bytes.get(section)?.get(first.checked_mul(size)?..(first + count).checked_mul(size)?)
    }

    /// Hashes of chunks and pages, of section `CRPG`, and of the header.
    fn rehash(&mut self) {
        let crown = self.section(b"CRPG").start;
        let chunks = self.u32(crown + 4);
        let pages = self.section(b"PAGE").len() / 40;
        for chunk in 0..chunks {
            let record = crown + 32 + 36 * chunk;
            let end = |at: usize, all: usize| {
                if chunk + 1 < chunks { self.u32(record + 36 + at) } else { all }
            };
            let first = |at: usize| self.u32(record + at);
            let span = |tag: &[u8; 4], size: usize, at: usize| {
                let count = end(at, self.section(tag).len() / size).checked_sub(first(at))?;
                self.run(tag, size, first(at), count)
            };
            let count = end(24, pages).saturating_sub(first(24));
            let runs = [
                self.run(b"TOPN", 68, first(12), count.saturating_sub(1)),
                self.run(b"TOPL", 1, first(16), first(20)),
                span(b"PAGE", 40, 24),
                span(b"LINK", 4, 28),
                span(b"CHTP", 1, 32),
            ];
            self.put_hash(record, hash(&runs));
        }
        for page in 0..pages {
            let at = self.section(b"PAGE").start + 40 * page;
            let faces = self.bytes.get(at + 38).map_or(0, |faces| usize::from(*faces));
            let first_face = self.u32(at + 16);
            let body = [
                self.run(b"NODE", 16, first_face.saturating_sub(page), faces.saturating_sub(1)),
                self.run(b"FACE", 3, first_face, faces),
                self.run(b"LOOP", 1, self.u32(at + 28), self.u16(at + 36)),
            ];
            let entry = crown + 32 + 36 * chunks + 20 * page;
            let first = self.u32(entry + 16);
            let all = self.section(b"VERT").len() / 27;
            let end = if page + 1 < pages { self.u32(entry + 36) } else { all };
            let count = end.saturating_sub(first);
            let own = [self.run(b"VERT", 27, first, count), self.run(b"NORM", 2, first, count)];
            let hashes = [hash(&body), hash(&own)];
            self.put_hash(entry, hashes[0]);
            self.put_hash(entry + 8, hashes[1]);
        }
        let table = 128 + 64 * self.sections.len();
        for (index, (tag, range)) in self.sections.clone().into_iter().enumerate() {
            if tag == *b"CRPG" {
                self.put_hash(128 + 64 * index + 40, Some(xxh3_64(&self.bytes[range])));
            }
        }
        let head = [&self.bytes[..120], &self.bytes[128..table]].concat();
        self.put_hash(120, Some(xxh3_64(&head)));
    }

    fn put_hash(&mut self, at: usize, hash: Option<u64>) {
        if let (Some(hash), Some(slot)) = (hash, self.bytes.get_mut(at..at + 8)) {
            slot.copy_from_slice(&hash.to_le_bytes());
        }
    }
}

fn hash(runs: &[Option<&[u8]>]) -> Option<u64> {
    let runs: Option<Vec<&[u8]>> = runs.iter().copied().collect();
    Some(xxh3_64(&runs?.concat()))
}

fn selection(random: &mut Random) -> Selection {
    let slope = 10_f64.powf(random.between(-4.0, 0.0));
    let eye = random.direction() * random.between(0.0, 3.0);
    match random.below(4) {
        0 => Selection::full(),
        1 => Selection::uniform(slope, Order::Budget),
        _ => Selection::perspective(
            Perspective { eye, axis: DVec3::ZERO, slope, corner_cos: 0.5 },
            Order::Bound,
        ),
    }
}

#[test]
fn right_hashes_are_what_a_writer_makes() {
    let bytes = trees::bytes_in_chunks(meshes::torus(40, 24, 3), SplitMode::Quality, 600);
    let mut edited = Edited::new(bytes.clone());
    edited.rehash();
    assert!(edited.bytes == bytes);
}

#[test]
fn parts_of_any_bytes_are_drawn_without_harm() {
    let bytes = trees::bytes_in_chunks(meshes::torus(40, 24, 3), SplitMode::Quality, 600);
    let tags: [&[u8; 4]; 10] =
        [b"CRPG", b"CHTP", b"TOPN", b"TOPL", b"PAGE", b"LINK", b"NODE", b"FACE", b"LOOP", b"VERT"];
    let mut random = Random::new(5);
    let (mut opened, mut whole, mut broken, mut triangles) = (0, 0, 0, 0);
    for round in 0..800 {
        let mut edited = Edited::new(bytes.clone());
        let section = edited.section(tags[round % tags.len()]);
        for _ in 0..=random.below(3) {
            let at = section.start + random.below(section.len());
            edited.bytes[at] = [0, 1, 0x7F, 0x80, 0xFF, random.below(256) as u8][random.below(6)];
        }
        edited.rehash();
        let Ok(file) = ChunkFile::new(Arc::new(edited.bytes), Path::new("a.fct")) else { continue };
        let budget = 1 << 20;
        let Ok(cache) = ChunkCache::new(file, budget) else { continue };
        opened += 1;
        let mut out = Streamed::default();
        for _ in 0..4 {
            cache.begin_frame();
            let selection = selection(&mut random);
            // An error is an answer too.
            let drawn = cache.extract(&selection, &mut out);
            let now = cache.extract_now(&selection, &mut out);
            if drawn.is_err() || now.is_err() {
                continue;
            }
            assert!(out.indices.len() % 3 == 0 && out.ids.len() == out.vertices.len());
            assert!(out.indices.iter().all(|i| (*i as usize) < out.vertices.len()));
            triangles += out.stats.triangles;
        }
        assert!(cache.stats().peak_bytes <= budget);
        whole += u32::from(cache.errors().is_empty());
        broken += u32::from(!cache.errors().is_empty());
    }
    assert!(opened > 600 && whole > 100 && broken > 100 && triangles > 10_000, "{opened} {whole} {broken}");
}
