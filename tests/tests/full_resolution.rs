//! Promise: the finest cut is the input, face for face and bit for bit.

use fcbuild::import::{Positions, Soup};
use fcextract::{Extraction, Selection, extract};
use fct::Tree;
use fctests::{meshes, trees};

/// A face as the bits of its corners, the smallest corner first, so that only the winding counts.
type Corners = [[u32; 3]; 3];

fn canonical(corners: [[f32; 3]; 3]) -> Corners {
    // -0 and +0 are the same place.
    let bits = corners.map(|p| p.map(|x| (x + 0.0).to_bits()));
    let first = (0..3).min_by_key(|&k| bits[k]).unwrap_or(0);
    [0, 1, 2].map(|k| bits[(first + k) % 3])
}

fn of_soup(soup: &Soup) -> Vec<Corners> {
    let Positions::F32(p) = &soup.positions else { panic!("single precision is meant here") };
    let mut faces: Vec<Corners> =
        soup.triangles.iter().map(|t| canonical(t.map(|v| p[v as usize]))).collect();
    faces.retain(|[a, b, c]| a != b && b != c && c != a);
    faces.sort_unstable();
    faces.dedup();
    faces
}

fn of_cut(tree: &Tree) -> Vec<Corners> {
    let mut out = Extraction::default();
    extract(tree, &Selection::full(), &mut out).unwrap_or_else(|e| panic!("{e}"));
    let at = |v: u32| tree.vertices()[v as usize].position();
    let mut faces: Vec<Corners> =
        out.indices.chunks_exact(3).map(|t| canonical([t[0], t[1], t[2]].map(at))).collect();
    faces.sort_unstable();
    faces
}

fn check(name: &str, soup: Soup) {
    let expected = of_soup(&soup);
    let tree = trees::tree_of(soup);
    assert!(of_cut(&tree) == expected, "{name}: the finest cut is not the input");
    let meta = tree.meta();
    let dropped: u64 = meta.dropped.iter().map(|(_, n)| n).sum();
    assert_eq!(meta.faces_in, meta.faces_kept + dropped, "{name}");
}

#[test]
fn the_finest_cut_is_the_input() {
    for name in ["sculpture.ply", "terrain.ply", "parts.ply"] {
        check(name, trees::read(&trees::data(name)));
    }
    check("torus", meshes::torus(30, 20, 1));
    check("moebius strip", meshes::moebius(40));
    check("three sheets", meshes::three_sheets(9));
    check("pieces", meshes::pieces(3));
    for seed in 0..50 {
        check("tangle", meshes::tangle(25, 90, seed));
        check("random bits", meshes::random_bits(seed));
        check("flat garbage", meshes::flat_garbage(seed));
    }
}

#[test]
#[ignore = "needs the scans that FCT_DATA names; cargo xtask campaign runs it"]
fn scans() {
    for name in ["bunny.ply", "armadillo.ply", "dragon.ply"] {
        check(name, trees::scan(name));
    }
}
