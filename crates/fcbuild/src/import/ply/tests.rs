//! Promises of the PLY reader, by the entries of the catalogue of bad inputs.

use super::super::testing::{is_f64, read, read_limited, refuse_truncation, refused, survive_damage, warned};
use super::super::{DropReason, Positions, Soup};

/// A value of a body, written by [`file`] in any encoding.
#[derive(Clone, Copy)]
enum V {
    C(i64),
    S(i64),
    I(i64),
    F(f32),
    D(f64),
    /// The end of a record, of which only text shows a trace.
    End,
}
use V::{C, D, End, F, I, S};

const ENCODINGS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

fn file(encoding: &str, declarations: &str, values: &[V]) -> Vec<u8> {
    let mut out = format!("ply\nformat {encoding} 1.0\n{declarations}end_header\n").into_bytes();
    for (i, v) in values.iter().enumerate() {
        if encoding == "ascii" {
            let text = match *v {
                C(n) | S(n) | I(n) => n.to_string(),
                F(x) => x.to_string(),
                D(x) => x.to_string(),
                End => "\n".into(),
            };
            let glue = if matches!(v, End) || matches!(values.get(i.wrapping_sub(1)), None | Some(End)) {
                ""
            } else {
                " "
            };
            out.extend(format!("{glue}{text}").bytes());
            continue;
        }
        let mut bytes = match *v {
            C(n) => vec![n as u8],
            S(n) => (n as i16).to_le_bytes().to_vec(),
            I(n) => (n as i32).to_le_bytes().to_vec(),
            F(x) => x.to_le_bytes().to_vec(),
            D(x) => x.to_le_bytes().to_vec(),
            End => vec![],
        };
        if encoding == "binary_big_endian" {
            bytes.reverse();
        }
        out.extend(bytes);
    }
    out
}

const VERTICES: &str = "element vertex 5\nproperty float x\nproperty float y\nproperty float z\n";
const FACES: &str = "element face 3\nproperty list uchar int vertex_indices\n";

fn five() -> Vec<V> {
    let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.1], [0.0, 1.0, 0.0], [0.5, 0.5, 2.0]];
    points.iter().flat_map(|p| [F(p[0]), F(p[1]), F(p[2]), End]).collect()
}

fn quad_and_two() -> Vec<V> {
    let mut v = vec![C(4), I(3), I(2), I(1), I(0), End];
    v.extend([C(3), I(0), I(1), I(4), End, C(3), I(1), I(2), I(4), End]);
    v
}

fn simple(encoding: &str) -> Vec<u8> {
    file(encoding, &format!("{VERTICES}{FACES}"), &[five(), quad_and_two()].concat())
}

fn ascii(body: &str) -> Vec<u8> {
    format!(
        "ply\nformat ascii 1.0\n{VERTICES}{FACES}end_header\n0 0 0\n1 0 0\n1 1 0.1\n0 1 0\n0.5 0.5 2\n{body}"
    )
    .into_bytes()
}

fn ok(bytes: &[u8]) -> Soup {
    read("a/scan.ply", bytes).unwrap()
}

#[test]
fn all_encodings_agree() {
    let soups = ENCODINGS.map(|e| ok(&simple(e)));
    assert_eq!(soups[0].triangles.len(), 4);
    assert_eq!((soups[0].tally.polygons_in, soups[0].tally.faces_in), (3, 4));
    assert_eq!((soups[0].groups[0].name.as_str(), soups[0].tally.warnings.len()), ("scan", 0));
    assert!(soups[0] == soups[1] && soups[1] == soups[2]);
}

#[test]
fn attributes_of_every_type_are_read() {
    let declarations = "comment \u{fc}\nelement vertex 3\nproperty uchar red\nproperty list uchar short skipped\n\
        property double x\nproperty short y\nproperty float z\nproperty float nx\nproperty float ny\nproperty double nz\n\
        property float green\nproperty uchar blue\nproperty char quality\n\
        element face 1\nproperty int flags\nproperty list int short vertex_index\nproperty list uchar float texcoord\n";
    let mut values = vec![];
    for i in 0..3 {
        values.extend([C(10 + i), C(i), S(7), S(8)].into_iter().take(2 + i as usize));
        values.extend([
            D(0.1 + i as f64),
            S(-i * i),
            F(2.5),
            F(0.0),
            F(0.6),
            D(0.8),
            F(0.5),
            C(200),
            C(-3),
            End,
        ]);
    }
    values.extend([I(9), I(3), S(0), S(1), S(2), C(2), F(0.5), F(0.25), End]);
    let soups = ENCODINGS.map(|e| {
        // The values of red and blue are unsigned, which the writer of the tests does not tell apart.
        ok(&file(e, declarations, &values))
    });
    assert!(soups[0] == soups[1] && soups[1] == soups[2]);
    assert_eq!(soups[0].positions, Positions::F64(vec![[0.1, 0.0, 2.5], [1.1, -1.0, 2.5], [2.1, -4.0, 2.5]]));
    assert_eq!(soups[0].normals.as_ref().unwrap()[2], [0.0, 0.6, 0.8]);
    assert_eq!(soups[0].colors.as_ref().unwrap()[1], [11, 128, 200, 255]);
}

#[test]
fn doubles_and_integers_are_kept_and_small_types_stay_single() {
    for (kind, wide) in
        [("float", false), ("uchar", false), ("short", false), ("int", true), ("double", true)]
    {
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty {kind} x\nproperty {kind} y\nproperty {kind} z\n\
             element face 1\nproperty list uchar uint vertex_index\nend_header\n0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n"
        );
        assert_eq!(is_f64(&ok(text.as_bytes())), wide, "{kind}");
    }
}

#[test]
fn element_order_and_strangers_do_not_matter() {
    let edges = "element edge 2\nproperty int vertex1\nproperty int vertex2\nelement range_grid 1\nproperty list uchar int vertex_indices\n";
    let between = vec![I(0), I(1), End, I(1), I(2), End, C(2), I(0), I(5), End];
    for e in ENCODINGS {
        let reordered = file(
            e,
            &format!("{FACES}{edges}{VERTICES}"),
            &[quad_and_two(), between.clone(), five()].concat(),
        );
        assert_eq!(ok(&reordered), ok(&simple(e)), "{e}");
    }
}

#[test]
fn any_line_end_and_comment_is_read() {
    let lf = simple("binary_little_endian");
    let split = lf.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    // The first byte of the body is a line feed: a reader that trims white space loses it.
    let declarations = "comment caf\u{e9} \nobj_info x\n";
    for end in ["\n", "\r\n", "\r"] {
        let mut bytes =
            String::from_utf8_lossy(&lf[..split]).replacen("element", &format!("{declarations}element"), 1);
        bytes = bytes.replace('\n', end);
        let mut bytes: Vec<u8> = bytes.bytes().map(|b| if b == 0xc3 { 0xff } else { b }).collect();
        let mut body = lf[split..].to_vec();
        body[0] = 0x0a;
        bytes.extend(body);
        let soup = ok(&bytes);
        assert_eq!(
            soup.positions.get(0).unwrap()[0],
            f64::from(f32::from_le_bytes([0x0a, 0, 0, 0])),
            "{end:?}"
        );
        assert_eq!(soup.triangles.len(), 4);
    }
    let crlf = String::from_utf8(simple("ascii")).unwrap().replace('\n', "\r\n\r\n");
    assert_eq!(ok(crlf.replacen("\r\n\r\n", "\r\n", 12).as_bytes()), ok(&simple("ascii")));
}

#[test]
fn polygons_are_dropped_or_cut() {
    let soup = ok(&ascii("5 0 1 4 2 3\n2 0 1\n0\n"));
    assert_eq!((soup.tally.polygons_in, soup.tally.faces_in, soup.triangles.len()), (3, 5, 3));
    assert_eq!(soup.tally.dropped.first_ids(DropReason::TooFewVertices), [1, 2]);
    let text = String::from_utf8(simple("ascii")).unwrap().replace("0.5 0.5 2", "nan 1e39 -inf");
    let soup = ok(text.as_bytes());
    assert_eq!((soup.triangles.len(), soup.tally.dropped.count(DropReason::NonFinite)), (2, 2));
    assert_eq!(warned(&soup, "non_finite_vertices"), 1);
}

#[test]
fn strips_alternate_and_restart() {
    let declarations = format!("{VERTICES}element tristrips 1\nproperty list int int vertex_indices\n");
    let strip = [I(8), I(0), I(1), I(2), I(3), I(-1), I(2), I(3), I(4), End];
    for e in ENCODINGS {
        let soup = ok(&file(e, &declarations, &[five(), strip.to_vec()].concat()));
        assert_eq!(soup.triangles, [[0, 1, 2], [2, 1, 3], [2, 3, 4]], "{e}");
        assert_eq!(soup.tally.polygons_in, 3);
    }
}

#[test]
fn a_polygon_of_a_thousand_corners_is_cut() {
    let n = 1000;
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {n}\nproperty float x\nproperty float y\nproperty float z\n\
         element face 1\nproperty list ushort ushort vertex_indices\nend_header\n"
    );
    (0..n).for_each(|i| text += &format!("{i} {} 0\n", if i % 2 == 0 { i * i } else { i * i + 3 }));
    text += &format!("{n} {}", (0..n).map(|i| i.to_string()).collect::<Vec<_>>().join(" "));
    assert_eq!(ok(text.as_bytes()).triangles.len(), n - 2);
}

#[test]
fn broken_files_are_refused() {
    let good = String::from_utf8(simple("ascii")).unwrap();
    let swap = |from: &str, to: &str| good.replacen(from, to, 1).into_bytes();
    let long = |n: usize, c: u8| [b"ply\ncomment ".to_vec(), vec![c; n]].concat();
    let many = [b"ply\n".to_vec(), b"comment xxxxxxxxxxxxxxxxxxxxxx\n".repeat(40_000)].concat();
    let u32_list = file(
        "binary_little_endian",
        &format!("{VERTICES}element face 1\nproperty list uint uchar vertex_indices\n"),
        &[five(), vec![I(-1), C(0), C(0)]].concat(),
    );
    let i8_list = file(
        "binary_little_endian",
        &format!("{VERTICES}element face 1\nproperty list char uchar vertex_indices\n"),
        &[five(), vec![C(-3), C(0), C(0)]].concat(),
    );
    let corners = file(
        "binary_little_endian",
        &format!("{VERTICES}element face 1\nproperty list uint uchar vertex_indices\n"),
        &[five(), vec![I(65_537)], vec![C(0); 65_537]].concat(),
    );
    let cases: Vec<(&str, Vec<u8>, &str, &str)> = vec![
        ("P1 empty", vec![], "FC200", "empty"),
        ("P1 magic", b"plx\nabc".to_vec(), "FC201", "\"plx\\na"),
        ("P2 endless header", many, "FC202", "1048576 bytes"),
        ("P3 long line", long(70_000, b'x'), "FC202", "65536 bytes"),
        ("P4 count no u64", swap("vertex 5", "vertex 99999999999999999999"), "FC202", "line 3"),
        (
            "P5 count too large",
            swap("vertex 5", "vertex 4000000000"),
            "FC205",
            "4000000000 vertex records, the file has room for",
        ),
        ("P5 faces too large", swap("face 3", "face 4000000000"), "FC205", "4000000000 face records"),
        (
            "P6 no properties",
            swap("element face", "element void 9999999999999\nelement face"),
            "FC202",
            "line 7: element void",
        ),
        ("P7 negative count", swap("vertex 5", "vertex -5"), "FC202", "\"-5\""),
        ("P8 text cut off", good.as_bytes()[..good.len() - 8].to_vec(), "FC204", "face 2 of 3"),
        ("P10 float length", swap("list uchar", "list float"), "FC202", "length"),
        ("P10 negative length", i8_list, "FC206", "length -3"),
        ("P10 huge length", u32_list, "FC205", "4294967295 values"),
        ("P11 too many corners", corners, "FC503", "65537 corners"),
        (
            "P12 index too large",
            swap("3 0 1 4", "3 0 1 5"),
            "FC203",
            "line 16 (byte 206): face 1 uses vertex 5 of 5",
        ),
        ("P12 index negative", swap("3 0 1 4", "3 0 1 -1"), "FC203", "uses vertex -1 of 5"),
        ("P12 index no integer", swap("3 0 1 4", "3 0 1 4.0"), "FC206", "\"4.0\""),
        ("P13 other list", swap("vertex_indices", "indices"), "FC208", "found: indices"),
        ("P17 no z", swap("float z", "float w"), "FC208", "found: x, y, w"),
        ("P17 list z", swap("float z", "list uchar float z"), "FC208", "scalar"),
        (
            "P19 two vertex elements",
            swap("element face", "element vertex 1\nproperty int a\nelement face"),
            "FC202",
            "twice",
        ),
        (
            "P21 no face element",
            [
                &good.as_bytes()[..good.find("element face").unwrap()],
                b"end_header\n0 0 0\n1 0 0\n1 1 0.1\n0 1 0\n0.5 0.5 2\n",
            ]
            .concat(),
            "FC207",
            "no faces",
        ),
        ("P23 gzip", b"\x1f\x8b\x08".to_vec(), "FC201", "unpack it first"),
        ("P24 version", swap("ascii 1.0", "ascii 2.0"), "FC202", "ascii 2.0"),
        ("P24 format", swap("ascii", "binary_middle_endian"), "FC202", "binary_middle_endian"),
        ("no format", swap("format ascii 1.0\n", ""), "FC202", "no format"),
        ("type", swap("float x", "int64 x"), "FC202", "int64"),
        ("property twice", swap("float y", "float x"), "FC202", "two properties x"),
        ("more values", swap("1 0 0", "1 0 0 7"), "FC206", "line 11 (byte 166): the line has more values"),
        ("decimal comma", swap("0.5 0.5", "0,5 0,5"), "FC206", "not a comma"),
        ("no vertices", swap("element vertex", "element vertices"), "FC208", "found: vertices, face"),
    ];
    for (what, bytes, code, part) in cases {
        let e = refused(what, "scan.ply", &bytes, code, part);
        assert_eq!(e.exit_code(), if code == "FC503" { 5 } else { 3 }, "{what}");
    }
}

#[test]
fn trailing_bytes_are_a_warning() {
    for e in ENCODINGS {
        let mut bytes = simple(e);
        bytes.extend(b"\n \n");
        assert_eq!(warned(&ok(&bytes), "trailing_bytes"), u64::from(e != "ascii"));
        bytes.extend(b"1 2 3");
        assert_eq!(warned(&ok(&bytes), "trailing_bytes"), 1);
    }
}

#[test]
fn the_face_limit_holds() {
    for e in ENCODINGS {
        assert!(read_limited("scan.ply", &simple(e), 4).is_ok());
        let error = read_limited("scan.ply", &simple(e), 3).unwrap_err();
        assert_eq!((error.code(), error.exit_code()), ("FC501", 5));
    }
}

#[test]
fn every_truncation_is_refused() {
    for e in ENCODINGS {
        let bytes = simple(e);
        // A text file may lack its last line end.
        refuse_truncation("scan.ply", &bytes, |end| e == "ascii" && end + 1 == bytes.len());
    }
}

#[test]
fn damage_never_panics() {
    let strips = file(
        "binary_big_endian",
        &format!("{VERTICES}element tristrips 1\nproperty list int int vertex_indices\n"),
        &[five(), vec![I(8), I(0), I(1), I(2), I(3), I(-1), I(2), I(3), I(4), End]].concat(),
    );
    let seeds = ENCODINGS.map(simple);
    survive_damage("scan.ply", &[&seeds[..], &[strips]].concat(), 2000);
}
