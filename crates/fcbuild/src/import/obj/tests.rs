//! Promises of the OBJ reader, by the entries of the catalogue of bad inputs.

use super::super::testing::{is_f64, read, read_limited, refused, shape, survive_damage, warned};
use super::super::{DropReason, Soup};

const PYRAMID: &str = "# a pyramid\nmtllib none.mtl\no base\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 4 3 2 1\n\
    o sides\nv 0.5 0.5 1\nvt 0.5 0.5\nvn 0 0 1\nusemtl red\ns 1\nf 1 2 5\nf 2/1 3/1 5/1\nf 3//1 4//1 5//1\nf -2/-1/-1 -5/1/1 -1/1/1\n";

fn ok(text: &str) -> Soup {
    read("pyramid.obj", text.as_bytes()).unwrap()
}

#[test]
fn objects_faces_and_relative_indices_are_read() {
    let soup = ok(PYRAMID);
    assert_eq!(soup.positions.len(), 5);
    let last = shape(&soup)[5];
    assert_eq!(last, [[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.5, 0.5, 1.0]]);
    let groups: Vec<_> = soup.groups.iter().map(|g| (g.name.as_str(), g.triangles.clone())).collect();
    assert_eq!(groups, [("base", 0..2), ("sides", 2..6)]);
    assert_eq!((soup.tally.polygons_in, soup.tally.faces_in), (5, 6));
    // The first face has no normals, so that none are kept; the missing material file does no harm.
    assert!(soup.normals.is_none() && soup.colors.is_none() && !is_f64(&soup));
    assert_eq!(warned(&soup, "missing_material_files"), 1);
}

#[test]
fn line_ends_blanks_and_continuations_do_not_matter() {
    let expected = ok(PYRAMID);
    for (what, text) in [
        ("CR LF", PYRAMID.replace('\n', "\r\n")),
        ("CR", PYRAMID.replace('\n', "\r")),
        ("tabs", PYRAMID.replace(' ', " \t")),
        ("vertical tabs", PYRAMID.replace("f 1 2 5", "f\x0b1\x0b2 5")),
        ("no last line end", PYRAMID.trim_end().to_owned()),
        ("mark", format!("\u{feff}{PYRAMID}")),
        ("continuations", PYRAMID.replace("4 3 2 1", "4 3\\\n 2 \\\r\n1").replace("v 1 0 0", "v 1\\\n0 0")),
        ("comments", PYRAMID.replace("v 1 0 0", "v 1 0 0 # C:\\models\\\n#\\")),
        ("faces before vertices", {
            let (faces, vertices): (Vec<&str>, Vec<&str>) =
                PYRAMID.lines().partition(|l| l.starts_with("f ") || l.starts_with("o "));
            let faces = faces.join("\n").replace("-2/-1/-1 -5/1/1 -1/1/1", "4 1 5");
            format!("{faces}\n{}", vertices.join("\n"))
        }),
    ] {
        let soup = ok(&text);
        assert_eq!((shape(&soup), &soup.groups), (shape(&expected), &expected.groups), "{what}");
    }
}

#[test]
fn colours_normals_and_weights_are_read() {
    let soup = ok(
        "v 0 0 0 1 0 0\nv 1 0 0 0 1 0.5\nv 0 1 0 0 0 1 1\nvn 0 0 3\nvn 0 4 0\nf 1//1 2//1 3//2\nf 1//2 3 2//1\n",
    );
    assert_eq!(soup.colors.unwrap(), [[255, 0, 0, 255], [0, 255, 128, 255], [0, 0, 255, 255]]);
    let half = 0.5f32.sqrt();
    assert_eq!(soup.normals.unwrap(), [[0.0, half, half], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]);
    let soup = ok("v 0 0 0 2\nv 1 0 0 1\nv 0 1 0\nv 9 9 9\nf 1 2 3\n");
    assert_eq!((warned(&soup, "vertex_weights"), warned(&soup, "unused_vertices")), (1, 1));
    assert_eq!(shape(&soup)[0][1], [1.0, 0.0, 0.0]);
    let soup = ok("v 0 0 0 1 1 1\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert_eq!(warned(&soup, "partial_colors"), 2);
}

/// Exports of polygroups have no objects, and come back to a group again and again.
#[test]
fn groups_are_kept_where_there_are_no_objects() {
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
    let named = |soup: &Soup| -> Vec<_> {
        soup.groups.iter().map(|g| (g.name.clone(), soup.triangles[g.triangles.clone()].to_vec())).collect()
    };
    let expect = |groups: &[(&str, &[[u32; 3]])]| -> Vec<_> {
        groups.iter().map(|(name, faces)| ((*name).to_owned(), faces.to_vec())).collect()
    };
    let (a, b, c, d) = ([0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]);
    let soup =
        ok(&format!("{corners}g left ear\nf 1 2 3\ng nose\nf 1 2 4\ng left ear\nf 1 3 4\ng\nf 2 3 4\n"));
    assert_eq!(named(&soup), expect(&[("left ear", &[a, c]), ("nose", &[b]), ("pyramid", &[d])]));
    assert_eq!(warned(&soup, "groups_in_objects"), 0);
    // Before the first one, and without a name, there is no group; of two at one place the last one counts.
    let soup = ok(&format!("{corners}f 1 2 3\ng x\ng y\nf 1 2 4\ng\nf 1 3 4\ng x\nf 2 3 4\ng z\n"));
    assert_eq!(named(&soup), expect(&[("pyramid", &[a, c]), ("y", &[b]), ("x", &[d])]));
    let soup = ok(&format!("{corners}g all\nf 1 2 3 4\n"));
    assert_eq!((soup.groups.len(), soup.groups[0].name.as_str()), (1, "all"));
    // Objects come first; a group that only repeats the object's name is no loss.
    let soup = ok(&format!(
        "{corners}g a\no one\ng one\nf 1 2 3\ng b\nf 1 2 4\no two\ng\nf 1 3 4\no one\nf 2 3 4\n"
    ));
    assert_eq!(named(&soup), expect(&[("one", &[a, b]), ("two", &[c]), ("one", &[d])]));
    assert_eq!(warned(&soup, "groups_in_objects"), 2);
}

#[test]
fn coordinates_far_from_the_origin_keep_their_digits() {
    let soup = ok("v 4000000.001 0 0\nv 4000001.002 0 0\nv 4000000.001 1 0\nf 1 2 3\n");
    assert!(is_f64(&soup));
    assert_eq!(shape(&soup)[0][1][0], 4_000_001.002);
}

#[test]
fn harmless_oddities_are_counted() {
    let odd = "mtllib ../../etc/passwd\nmtllib C:\\a.mtl\nl 1 2\np 1\ncurv 0 1\nsurf 0 1 0 1 1\nfoo\nKd 0.5\nf 1 2\nf\nf 1\n";
    let soup = ok(&format!("{PYRAMID}{odd}"));
    assert_eq!(soup.triangles.len(), 6);
    assert_eq!(soup.tally.dropped.first_ids(DropReason::TooFewVertices), [5, 6, 7]);
    for (code, count) in [
        ("outside_material_files", 2),
        ("missing_material_files", 1),
        ("lines_and_points", 2),
        ("free_form_geometry", 2),
        ("unknown_statements", 2),
    ] {
        assert_eq!(warned(&soup, code), count, "{code}");
    }
    for bad in ["nan", "inf", "1e39", "-1.#IND"] {
        let soup = ok(&PYRAMID.replace("0.5 0.5 1", &format!("0.5 {bad} 1")));
        assert_eq!((soup.triangles.len(), soup.tally.dropped.count(DropReason::NonFinite)), (2, 4), "{bad}");
    }
}

#[test]
fn concave_polygons_are_cut_by_ears() {
    let soup = ok("v 0 0 0\nv 2 1 0\nv 0 2 0\nv 0.2 1.2 0\nv 0.2 0.8 0\nf 1 2 3 4 5\n");
    let area: f64 = shape(&soup)
        .iter()
        .map(|[a, b, c]| ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2.0)
        .inspect(|area| assert!(*area > 0.0))
        .sum();
    assert!((area - 1.76).abs() < 1e-6 && soup.triangles.len() == 3, "{area}");
}

#[test]
fn broken_files_are_refused() {
    let with = |line: &str| format!("{PYRAMID}{line}\n").into_bytes();
    let utf16: Vec<u8> =
        std::iter::once(0xfeffu16).chain(PYRAMID.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    let cases: Vec<(&str, Vec<u8>, &str, &str)> = vec![
        ("O1 empty", vec![], "FC200", "empty"),
        ("O1 no faces", b"v 0 0 0\n".to_vec(), "FC207", "no faces"),
        (
            "O2 zero",
            with("f 0 1 2"),
            "FC203",
            "line 19 (byte 196): face 6 uses vertex 0 of 5; vertices and faces count from 1",
        ),
        ("O3 before start", with("f -6 1 2"), "FC203", "vertex -6 of 5"),
        ("O4 2^63", with("f 9223372036854775808 1 2"), "FC203", "of 5"),
        ("O4 2^64", with("f 18446744073709551616 1 2"), "FC203", "of 5"),
        ("O4 wraps", with("f 6148914691236517207 1 2"), "FC203", "vertex 6148914691236517207 of 5"),
        ("O4 -2^63", with("f -9223372036854775808 1 2"), "FC203", "of 5"),
        ("O4 normal", with("f 1//1 2//2 3//1"), "FC203", "normal 2 of 1"),
        ("O6 letters", with("f a b c"), "FC206", "\"a\""),
        ("O6 four parts", with("f 1/2/3/4 2 3"), "FC206", "\"1/2/3/4\""),
        ("O6 no vertex", with("f /1 2 3"), "FC206", "\"/1\""),
        ("O7 two numbers", with("v 1 2"), "FC206", "three numbers"),
        ("O7 five numbers", with("v 1 2 3 4 5"), "FC206", "3, 4, 6 or 7"),
        ("O11 UTF-16", utf16, "FC210", "UTF-16"),
        ("O12 endless line", [b"v 0 0 0 ".to_vec(), vec![b'1'; 2_000_000]].concat(), "FC502", "1048576"),
        ("O12 endless continuation", b"f 1 \\\n".repeat(300_000), "FC502", "1048576"),
        ("O13 decimal comma", with("v 1,5 2,5 3,5"), "FC206", "not a comma"),
        ("corners", with(&format!("f{}", " 1".repeat(65_537))), "FC503", "65536"),
        ("binary", [PYRAMID.as_bytes(), b"v \xff\0 1 2\n"].concat(), "FC206", "line 19"),
    ];
    for (what, bytes, code, part) in cases {
        let e = refused(what, "pyramid.obj", &bytes, code, part);
        assert_eq!(e.exit_code(), if code.starts_with("FC5") { 5 } else { 3 }, "{what}");
    }
}

#[test]
fn many_groups_and_the_face_limit() {
    let mut text = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    (0..20_000).for_each(|i| text += &format!("o part {i}\nf 1 2 3\n"));
    let soup = ok(&text.replace("o part", "g part"));
    assert_eq!((soup.groups.len(), soup.groups[7].name.as_str()), (20_000, "part 7"));
    let soup = ok(&text);
    assert_eq!((soup.groups.len(), soup.positions.len()), (20_000, 3));
    assert_eq!((soup.groups[7].name.as_str(), soup.groups[7].triangles.clone()), ("part 7", 7..8));
    let e = read_limited("a.obj", text.as_bytes(), 7).unwrap_err();
    assert_eq!(
        (e.code(), e.found()),
        ("FC501", Some(20_000)),
        "all faces are counted, not those read so far"
    );
}

#[test]
fn damage_never_panics() {
    let colored = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0.5\nv 0 1 0 0 0 1 1\nvn 0 0 3\nf 1//1 2//1 \\\n3//1\nl 1 2\ng a\nf 1 2 3\ng b\nf 3 2 1\ng a\nf 2 1 3\n";
    survive_damage("pyramid.obj", &[PYRAMID.into(), colored.into()], 2000);
}
