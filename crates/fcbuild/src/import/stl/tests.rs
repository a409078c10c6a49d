//! Promises of the STL readers, by the entries of the catalogue of bad inputs.

use super::super::testing::{
    is_f64, read, read_limited, refuse_truncation, refused, shape, survive_damage, warned,
};
use super::super::{DropReason, Soup};

const TETRAHEDRON: [[[f32; 3]; 3]; 4] = [
    [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]],
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
];

fn binary(header: &str, triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut out = header.as_bytes().to_vec();
    out.resize(80, b' ');
    out.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        out.extend([0; 12]);
        out.extend(t.iter().flatten().flat_map(|x| x.to_le_bytes()));
        out.extend([0; 2]);
    }
    out
}

fn ascii(name: &str, triangles: &[[[f32; 3]; 3]]) -> String {
    let mut out = format!("solid {name}\n");
    for t in triangles {
        out += " facet normal 0 0 0\n  outer loop\n";
        for [x, y, z] in t {
            out += &format!("   vertex {x} {y} {z}\n");
        }
        out += "  endloop\n endfacet\n";
    }
    out + &format!("endsolid {name}\n")
}

fn read_ok(bytes: &[u8]) -> Soup {
    read("part.stl", bytes).unwrap()
}

#[test]
fn binary_and_ascii_agree() {
    let b = read_ok(&binary("made by a scanner", &TETRAHEDRON));
    let a = read_ok(ascii("part", &TETRAHEDRON).as_bytes());
    assert_eq!((shape(&a), &a.groups), (shape(&b), &b.groups));
    assert_eq!(shape(&b)[3][0], [1.0, 0.0, 0.0]);
}

#[test]
fn the_size_decides_not_the_word_solid() {
    let bytes = binary("solid facet endsolid", &TETRAHEDRON);
    assert_eq!(read_ok(&bytes).triangles.len(), 4);
    // The content tells the format under any name.
    assert_eq!(read("noname", &bytes).unwrap().triangles.len(), 4);
    assert_eq!(read("noname", ascii("x", &TETRAHEDRON).as_bytes()).unwrap().triangles.len(), 4);
}

#[test]
fn broken_files_are_refused() {
    let good = binary("", &TETRAHEDRON);
    let with_count = |n: u32| {
        let mut bytes = good.clone();
        bytes[80..84].copy_from_slice(&n.to_le_bytes());
        bytes
    };
    let text = ascii("a", &TETRAHEDRON);
    let cases: [(&str, Vec<u8>, &str, &str); 9] = [
        ("empty", vec![], "FC200", "empty"),
        (
            "count too large",
            with_count(5),
            "FC205",
            "declares 5 triangles, the size of 284 bytes is that of 4",
        ),
        ("count zero with data", with_count(0), "FC205", "declares 0 triangles"),
        ("huge count", with_count(u32::MAX), "FC205", "4294967295"),
        ("header only", binary("", &[]), "FC207", "no faces"),
        ("unterminated facet", text.replacen("endloop", "", 1).into_bytes(), "FC206", "line 8 (byte"),
        (
            "four vertices",
            text.replacen("endloop", "vertex 1 1 1 endloop", 1).into_bytes(),
            "FC206",
            "`endloop`",
        ),
        (
            "no number",
            text.replacen("vertex 0 1 0", "vertex 0 1,5 0", 1).into_bytes(),
            "FC206",
            "decimal point",
        ),
        ("empty solid", b"solid a\nendsolid a\n".to_vec(), "FC207", "no faces"),
    ];
    for (what, bytes, code, part) in cases {
        refused(what, "part.stl", &bytes, code, part);
    }
}

#[test]
fn vertices_at_nan_drop_their_faces() {
    let mut triangles = TETRAHEDRON;
    triangles[1][2][0] = f32::NAN;
    let b = read_ok(&binary("", &triangles));
    let a = read_ok(ascii("", &triangles).replace("NaN", "1e39").as_bytes());
    for soup in [a, b] {
        assert_eq!((soup.triangles.len(), soup.tally.dropped.count(DropReason::NonFinite)), (3, 1));
        assert_eq!(soup.tally.dropped.first_ids(DropReason::NonFinite), [1]);
        assert_eq!(warned(&soup, "non_finite_vertices"), 1);
    }
}

#[test]
fn several_solids_are_groups() {
    let text = ascii("one", &TETRAHEDRON) + &ascii("", &TETRAHEDRON[..1]).to_uppercase();
    let soup = read_ok(text.replace('\n', "\r\n").as_bytes());
    let groups: Vec<_> = soup.groups.iter().map(|g| (g.name.as_str(), g.triangles.clone())).collect();
    assert_eq!(groups, [("one", 0..4), ("part", 4..5)]);
}

#[test]
fn text_far_from_the_origin_keeps_its_digits() {
    let text = ascii("map", &TETRAHEDRON)
        .replace("vertex 0", "vertex 4000000.125")
        .replace("vertex 1", "vertex 4000001.126");
    let soup = read_ok(text.as_bytes());
    assert!(is_f64(&soup) && !is_f64(&read_ok(ascii("", &TETRAHEDRON).as_bytes())));
    assert_eq!(shape(&soup)[3][0][0], 4_000_001.126);
}

#[test]
fn the_face_limit_holds() {
    for bytes in [binary("", &TETRAHEDRON), ascii("", &TETRAHEDRON).into_bytes()] {
        let e = read_limited("part.stl", &bytes, 3).unwrap_err();
        assert_eq!((e.code(), e.exit_code()), ("FC501", 5));
    }
}

#[test]
fn every_truncation_is_refused() {
    refuse_truncation("part.stl", &binary("x", &TETRAHEDRON), |_| false);
    let text = ascii("s", &TETRAHEDRON);
    let complete = text.rfind("endsolid").unwrap() + "endsolid".len();
    refuse_truncation("part.stl", text.as_bytes(), |end| end >= complete);
}

#[test]
fn damage_never_panics() {
    let seeds =
        [binary("solid", &TETRAHEDRON), ascii("a", &TETRAHEDRON).into_bytes(), binary("", &TETRAHEDRON)];
    survive_damage("part.stl", &seeds, 2000);
}
