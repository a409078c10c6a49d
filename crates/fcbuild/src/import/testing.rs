//! What the tests of all readers share: invariants of every success, damage at random.

use std::path::Path;
use std::time::{Duration, Instant};

use super::{ImportOptions, Positions, Soup, import_bytes};
use crate::error::Error;

/// The limit on faces in these tests.
pub(crate) const MAX_FACES: u64 = 2_000_000;

/// Reads bytes as a file of that name; a success must keep the promises of [`Soup`].
pub(crate) fn read(name: &str, bytes: &[u8]) -> Result<Soup, Error> {
    read_limited(name, bytes, MAX_FACES)
}

pub(crate) fn read_limited(name: &str, bytes: &[u8], max_faces: u64) -> Result<Soup, Error> {
    let options = ImportOptions { max_faces, progress: &|done, total| assert!(done <= total) };
    let soup = import_bytes(Path::new(name), bytes, &options)?;
    check(&soup);
    Ok(soup)
}

fn check(soup: &Soup) {
    let count = soup.positions.len();
    assert_eq!(soup.tally.faces_in, soup.triangles.len() as u64 + soup.tally.dropped.total());
    assert!(!soup.triangles.is_empty() && !soup.groups.is_empty());
    for &corner in soup.triangles.iter().flatten() {
        let p = soup.positions.get(corner as usize).expect("an index below the number of vertices");
        assert!(p.iter().all(|x| x.is_finite()), "vertex {corner} is used and not finite");
    }
    let mut end = 0;
    for group in &soup.groups {
        assert_eq!(group.triangles.start, end);
        end = group.triangles.end;
    }
    assert_eq!(end, soup.triangles.len());
    assert!(soup.normals.as_ref().is_none_or(|n| n.len() == count));
    assert!(soup.colors.as_ref().is_none_or(|c| c.len() == count));
}

/// The triangles as positions, whatever the numbering of vertices.
pub(crate) fn shape(soup: &Soup) -> Vec<[[f64; 3]; 3]> {
    soup.triangles.iter().map(|t| t.map(|i| soup.positions.get(i as usize).unwrap())).collect()
}

/// Reads a file that must fail with `code` and a message holding `part`.
#[track_caller]
pub(crate) fn refused(what: &str, name: &str, bytes: &[u8], code: &str, part: &str) -> Error {
    match read(name, bytes) {
        Ok(soup) => panic!("{what}: read as {} triangles instead of {code}", soup.triangles.len()),
        Err(e) => {
            assert_eq!(e.code(), code, "{what}: {e}");
            assert!(e.to_string().contains(part), "{what}: {part:?} is not in {e}");
            assert_eq!(e.file(), Some(Path::new(name)), "{what}");
            e
        }
    }
}

/// The count of a warning, 0 when it was not given.
pub(crate) fn warned(soup: &Soup, code: &str) -> u64 {
    soup.tally.warnings.iter().find(|w| w.code == code).map_or(0, |w| w.count)
}

pub(crate) fn is_f64(soup: &Soup) -> bool {
    matches!(soup.positions, Positions::F64(_))
}

/// A generator of numbers with a fixed sequence.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }

    /// From 0 to 1.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Words that mean something to one reader or another.
const WORDS: [&[u8]; 22] = [
    b"-1",
    b"0",
    b"4294967295",
    b"9223372036854775808",
    b"6148914691236517207",
    b"nan",
    b"1e39",
    b"inf",
    b" ",
    b"\n",
    b"\r",
    b"\\\n",
    b"\xff\xff\xff\xff",
    b"\0\0\0\0",
    b"\0\0\x80\x7f",
    b"element face 9\n",
    b"property list uchar int vertex_indices\n",
    b"f -1 -2 -3\n",
    b"facet",
    b"[[[[",
    b"\"count\":1e18,",
    b"#",
];

/// Damages `seeds` in `rounds` ways; every outcome but a bug or a long wait is right.
pub(crate) fn survive_damage(name: &str, seeds: &[Vec<u8>], rounds: usize) {
    let mut random = Random(0x5eed);
    let mut read_well = 0;
    for round in 0..rounds {
        let mut bytes = seeds[round % seeds.len()].clone();
        for _ in 0..1 + random.below(4) {
            let at = random.below(bytes.len());
            match random.below(7) {
                0 => bytes[at] ^= 1 << random.below(8),
                1 => bytes[at] = random.next() as u8,
                2 => bytes.truncate(at.max(1)),
                3 => drop(bytes.drain(at..(at + 1 + random.below(16)).min(bytes.len()))),
                4 => {
                    let piece = bytes[at..(at + 1 + random.below(64)).min(bytes.len())].to_vec();
                    let to = random.below(bytes.len());
                    bytes.splice(to..to, piece);
                }
                _ => {
                    let word = WORDS[random.below(WORDS.len())];
                    let end = if random.below(2) == 0 { at } else { (at + word.len()).min(bytes.len()) };
                    bytes.splice(at..end, word.iter().copied());
                }
            }
            if bytes.is_empty() {
                bytes.push(b'x');
            }
        }
        let start = Instant::now();
        match read(name, &bytes) {
            Ok(_) => read_well += 1,
            Err(e) => assert_ne!(e.code(), "FC901", "round {round}: {e}"),
        }
        assert!(start.elapsed() < Duration::from_secs(1), "round {round} took {:?}", start.elapsed());
    }
    // Damage that never leaves a mesh, or always does, would test nothing.
    assert!(read_well > 0 && read_well < rounds, "{read_well} of {rounds} were read");
}

/// Every shorter form of `bytes` must be refused as bad input or, where `may_read`, read.
pub(crate) fn refuse_truncation(name: &str, bytes: &[u8], may_read: impl Fn(usize) -> bool) {
    assert!(read(name, bytes).is_ok());
    for end in 0..bytes.len() {
        match read(name, &bytes[..end]) {
            Ok(_) => assert!(may_read(end), "{end} of {} bytes were taken for a mesh", bytes.len()),
            Err(e) => assert_eq!(e.exit_code(), 3, "{end} bytes: {e}"),
        }
    }
}
