//! Promise: files of every released version open for ever, and mean the same.
//!
//! `formats/fct/golden/README.md` says how to add one. What is compared does not depend on how polygons are cut into
//! triangles: the faces, and the active vertices along the loops of one coarse cut.

#![allow(clippy::print_stdout, reason = "the line of a new file is copied from what is printed")]

use fcbuild::SplitMode;
use fcbuild::import::{Group, Positions, Soup};
use fcextract::{ChunkCache, Extraction, Order, Selection, Streamed, extract};
use fct::{Child, Tree};
use fctests::{meshes, trees};
use std::path::PathBuf;

/// What a golden file is, for ever.
struct Golden {
    name: &'static str,
    faces: usize,
    vertices: usize,
    /// Hash of the positions of all faces in order.
    full: u64,
    /// A tolerance, the clusters that it leaves, and the hash of their outlines.
    tolerance: f32,
    clusters: usize,
    coarse: u64,
}

const GOLDEN: &[Golden] = &[
    Golden {
        name: "1.0-tetrahedron.fct",
        faces: 4,
        vertices: 4,
        full: 0x97eb9d9f9b559b88,
        tolerance: 0.5,
        clusters: 4,
        coarse: 0xd0ce84124ba8edb8,
    },
    Golden {
        name: "1.0-patch.fct",
        faces: 392,
        vertices: 225,
        full: 0xd201d67196ce1e9c,
        tolerance: 0.02,
        clusters: 167,
        coarse: 0x1bf09015c1518cea,
    },
    Golden {
        name: "1.0-groups.fct",
        faces: 442,
        vertices: 221,
        full: 0x089920f6728743a9,
        tolerance: 0.05,
        clusters: 202,
        coarse: 0xa580451243a4423e,
    },
    Golden {
        name: "1.0-moebius.fct",
        faces: 192,
        vertices: 125,
        full: 0xb930524fd47caf61,
        tolerance: 0.02,
        clusters: 86,
        coarse: 0xfdb0d083f9a974f5,
    },
    Golden {
        name: "1.0-coloured.fct",
        faces: 128,
        vertices: 81,
        full: 0x468b09b19952ad1f,
        tolerance: 0.03,
        clusters: 64,
        coarse: 0x0d6a8f7bbc1711c9,
    },
    Golden {
        name: "1.1-chunks.fct",
        faces: 640,
        vertices: 320,
        full: 0x0d1e65c06eab176d,
        tolerance: 0.05,
        clusters: 224,
        coarse: 0x907ee6adca21cc17,
    },
    Golden {
        name: "1.2-shares.fct",
        faces: 320,
        vertices: 160,
        full: 0x8581573687146bf1,
        tolerance: 0.05,
        clusters: 221,
        coarse: 0x4d45fb29fee02864,
    },
    Golden {
        name: "1.3-pages.fct",
        faces: 672,
        vertices: 336,
        full: 0x95c568d57fedcc09,
        tolerance: 0.05,
        clusters: 266,
        coarse: 0xaf25a1bdfefc40a2,
    },
];

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../formats/fct/golden")
}

/// FNV-1a, which is short enough to be written down here.
fn hash(numbers: impl IntoIterator<Item = u32>) -> u64 {
    numbers
        .into_iter()
        .flat_map(u32::to_le_bytes)
        .fold(0xCBF2_9CE4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3))
}

fn bits(tree: &Tree, vertex: u32) -> [u32; 3] {
    tree.vertices()[vertex as usize].position().map(f32::to_bits)
}

/// The clusters of the cut at a tolerance, and the hash of their active vertices loop by loop, each from its lowest on.
fn coarse_cut(tree: &Tree, tolerance: f32) -> (usize, u64) {
    let (mut clusters, mut numbers) = (0, Vec::new());
    let mut stack = vec![tree.whole()];
    while let Some(subtree) = stack.pop() {
        if let Child::Node(_) = subtree.child.kind() {
            let node = tree.node(&subtree).unwrap_or_else(|e| panic!("{e}"));
            if node.bound > tolerance.min(f32::MAX) {
                stack.extend(tree.children(&subtree).unwrap_or_else(|e| panic!("{e}")));
                continue;
            }
            let loops = tree.loops_of(&subtree).unwrap_or_else(|e| panic!("{e}"));
            let mut rings: Vec<Vec<u32>> = loops
                .iter()
                .map(|ring| {
                    let is_active = |v: &u32| tree.vertices()[*v as usize].bound() > tolerance;
                    let mut ring: Vec<u32> = ring.iter().copied().filter(is_active).collect();
                    let lowest = (0..ring.len()).min_by_key(|i| ring[*i]).unwrap_or(0);
                    ring.rotate_left(lowest);
                    ring
                })
                .collect();
            rings.sort();
            numbers.extend(rings.iter().flatten().flat_map(|v| bits(tree, *v)));
        } else {
            let corners = tree.reader().face(&subtree).unwrap_or_else(|e| panic!("{e}"));
            numbers.extend(corners.iter().flat_map(|v| bits(tree, *v)));
        }
        clusters += 1;
    }
    (clusters, hash(numbers))
}

fn full(tree: &Tree) -> u64 {
    let faces = tree.faces().unwrap_or_else(|e| panic!("{e}"));
    hash(faces.iter().flatten().flat_map(|v| bits(tree, *v)))
}

#[test]
fn golden_files_open_and_mean_what_they_meant() {
    for golden in GOLDEN {
        let path = folder().join(golden.name);
        let tree = Tree::open(&path).unwrap_or_else(|e| panic!("{e}"));
        tree.verify().unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(
            (tree.face_count(), tree.vertices().len()),
            (golden.faces, golden.vertices),
            "{}",
            golden.name
        );
        assert_eq!(full(&tree), golden.full, "{}: the faces", golden.name);
        let found = coarse_cut(&tree, golden.tolerance);
        assert_eq!(found, (golden.clusters, golden.coarse), "{}: the coarse cut", golden.name);
    }
}

/// In parts since version 1.3; who streams an older file is told to build it again.
#[test]
fn golden_files_are_read_in_parts_or_refused() {
    let mut read = 0;
    for golden in GOLDEN {
        let path = folder().join(golden.name);
        let tree = Tree::open(&path).unwrap_or_else(|e| panic!("{e}"));
        match ChunkCache::open(&path, 1 << 20) {
            Ok(cache) => {
                let selection = Selection::uniform(f64::from(golden.tolerance), Order::Bound);
                let (mut whole, mut parts) = (Extraction::default(), Streamed::default());
                extract(&tree, &selection, &mut whole).unwrap_or_else(|e| panic!("{e}"));
                cache.extract_now(&selection, &mut parts).unwrap_or_else(|e| panic!("{e}"));
                assert!(parts.missing.is_empty(), "{}", golden.name);
                assert_eq!(parts.stats.clusters, whole.stats.clusters, "{}", golden.name);
                assert!(parts.entered.len() > cache.file().crown().chunk_count() as usize);
                read += 1;
            }
            Err(error) => {
                assert!(tree.header().minor < 3, "{}: {error}", golden.name);
                assert!(error.to_string().contains("build the file again"), "{error}");
            }
        }
    }
    assert!(read > 0);
}

#[test]
fn every_golden_file_is_listed() {
    let mut found: Vec<String> = std::fs::read_dir(folder())
        .unwrap_or_else(|e| panic!("{e}"))
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| name.ends_with(".fct"))
        .collect();
    found.sort();
    let mut listed: Vec<&str> = GOLDEN.iter().map(|g| g.name).collect();
    listed.sort_unstable();
    assert_eq!(found, listed);
}

/// What golden files were made of, and a tolerance for each.
fn sources() -> Vec<(&'static str, Soup, f32)> {
    let tetrahedron = meshes::soup(
        vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
    );
    let mut coloured = meshes::grid(8, 5);
    coloured.colors = Some((0..81).map(|i| [3 * i as u8, 255 - i as u8, 7, 255]).collect());
    if let Positions::F32(p) = coloured.positions {
        // Double precision, far from the origin.
        let far = |p: [f32; 3]| [f64::from(p[0]) + 500_000.0, f64::from(p[1]) + 4e6, f64::from(p[2])];
        coloured.positions = Positions::F64(p.into_iter().map(far).collect());
    }
    // Two components, a group each.
    let mut groups = meshes::torus(22, 8, 1);
    let second = meshes::torus(9, 5, 2);
    if let (Positions::F32(all), Positions::F32(more)) = (&mut groups.positions, second.positions) {
        let (first, faces) = (all.len() as u32, groups.triangles.len());
        all.extend(more.into_iter().map(|[x, y, z]| [x + 4.0, y, z]));
        groups.triangles.extend(second.triangles.iter().map(|t| t.map(|v| v + first)));
        groups.groups = vec![
            Group { name: "large".to_owned(), triangles: 0..faces },
            Group { name: "small".to_owned(), triangles: faces..groups.triangles.len() },
        ];
        groups.tally.faces_in = groups.triangles.len() as u64;
    }
    vec![
        ("1.0-tetrahedron.fct", tetrahedron, 0.5),
        ("1.0-patch.fct", meshes::grid(14, 3), 0.02),
        ("1.0-groups.fct", groups, 0.05),
        ("1.0-moebius.fct", meshes::moebius(24), 0.02),
        ("1.0-coloured.fct", coloured, 0.03),
        ("1.1-chunks.fct", meshes::torus(20, 16, 4), 0.05),
        ("1.2-shares.fct", meshes::torus(16, 10, 7), 0.05),
        ("1.3-pages.fct", meshes::torus(24, 14, 9), 0.05),
    ]
}

/// Writes the golden files that are not there, and prints a line for each.
#[test]
#[ignore = "adds golden files; see formats/fct/golden/README.md"]
fn add_golden_files() {
    for (name, soup, tolerance) in sources() {
        let path = folder().join(name);
        if path.exists() {
            continue;
        }
        // Since 1.3 a chunk is more than a page only if it has two.
        let chunk_faces = if name == "1.3-pages.fct" { 400 } else { 100 };
        let bytes = trees::bytes_in_chunks(soup, SplitMode::Paper, chunk_faces);
        std::fs::write(&path, bytes).unwrap_or_else(|e| panic!("{e}"));
        let tree = Tree::open(&path).unwrap_or_else(|e| panic!("{e}"));
        let (clusters, coarse) = coarse_cut(&tree, tolerance);
        println!(
            "    Golden {{ name: {name:?}, faces: {}, vertices: {}, full: {:#018x}, tolerance: {tolerance}, \
             clusters: {clusters}, coarse: {coarse:#018x} }},",
            tree.face_count(),
            tree.vertices().len(),
            full(&tree),
        );
    }
}
