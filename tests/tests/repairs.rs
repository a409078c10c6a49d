//! Promise: what is repaired, dropped or missed is counted and told, and `--strict` refuses it.

use fctests::commands::{accept, folder, info, ply, refuse, run, sample};
use std::fs;

/// A disc has no corner until a split registers many at once.
#[test]
fn a_budget_that_no_split_comes_near_is_told() {
    let folder = folder();
    let angle = |i: i32| std::f64::consts::TAU * f64::from(i) / 256.0;
    let rim: Vec<_> = (0..256).map(|i| format!("v {} {} 0\n", angle(i).cos(), angle(i).sin())).collect();
    let corners: Vec<_> = (1..=256).map(|i| i.to_string()).collect();
    let disc = format!("{}f {}\n", rim.concat(), corners.join(" "));
    fs::write(folder.path().join("disc.obj"), disc).expect("writable");
    accept(folder.path(), "fcbuild disc.obj -o p.fct --split paper");
    let export = "fct --message-format json export p.fct --json -o";
    // More than there is are not missed.
    for (triangles, is_missed) in [(20, true), (254, false), (9000, false)] {
        let said = accept(folder.path(), &format!("{export} {triangles}.ply --triangles {triangles}"));
        let mesh: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
        let mesh = &mesh["meshes"][0];
        assert_eq!(said.err.contains("FC352"), is_missed, "{mesh} {}", said.err);
        assert_eq!(mesh["next"].as_u64().is_some_and(|next| next > 20), is_missed, "{mesh}");
    }
}

/// Where the surface had to be cut is told, and is no mesh for `--strict`.
#[test]
fn seams_are_repairs() {
    let folder = folder();
    let input = sample("odd").join("nonmanifold.ply");
    let said = accept(folder.path(), &format!("fcbuild {} -o x.fct --report r.json", input.display()));
    assert!(said.err.contains("warning[FC294]") && said.err.contains("4 edges were shared"), "{}", said.err);
    assert!(!said.err.contains("times)"), "the count is said once: {}", said.err);
    let report = fs::read_to_string(folder.path().join("r.json")).expect("a report");
    assert!(report.contains("\"seam_edges\"") && report.contains("FC294"), "{report}");
    let line = format!("fcbuild {} -o y.fct --strict", input.display());
    refuse(folder.path(), &line, 3, &["FC213", "seam_edges (FC294, 4)"]);
}

#[test]
fn odd_meshes_are_built_and_verified() {
    let folder = folder();
    for (name, faces) in [("quad", 2), ("polygon", 28), ("triangle", 1)] {
        accept(folder.path(), &format!("fcbuild {name}.ply -o {name}.fct --strict"));
        accept(folder.path(), &format!("fct verify {name}.fct"));
        assert_eq!(info(folder.path(), &format!("{name}.fct"))["counts"]["faces"], faces, "{name}");
        accept(folder.path(), &format!("fct export {name}.fct -o {name}.obj"));
    }
    for name in ["moebius.ply", "nonmanifold.ply", "quads.ply", "tetra.obj", "cube.glb", "single.stl"] {
        let input = sample("odd").join(name);
        accept(folder.path(), &format!("fcbuild {} -o odd.fct --force", input.display()));
        accept(folder.path(), "fct verify odd.fct");
    }
}

#[test]
fn repairs_are_counted_and_told() {
    let folder = folder();
    let said = accept(folder.path(), "fcbuild nan.ply -o x.fct --report r.json --message-format json");
    let lines: Vec<serde_json::Value> =
        said.err.lines().map(|line| serde_json::from_str(line).expect("a JSON object a line")).collect();
    assert!(lines.iter().all(|l| l["level"] == "warning" && l["path"] == "nan.ply"), "{}", said.err);
    assert!(lines.iter().any(|l| l["name"] == "non_finite_vertices"), "{}", said.err);

    let report = fs::read_to_string(folder.path().join("r.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
    let counts = &report["counts"];
    assert_eq!((&counts["faces_in"], &counts["faces_kept"]), (&2.into(), &1.into()));
    let number = |v: &serde_json::Value| v.as_u64().expect("a count");
    let dropped: u64 =
        report["dropped"].as_array().expect("a list").iter().map(|d| number(&d["count"])).sum();
    assert_eq!(number(&counts["faces_in"]), number(&counts["faces_kept"]) + dropped);
    assert_eq!(report["dropped"][0]["first_ids"], serde_json::json!([1]));
    for phase in ["import", "mesh", "partition", "boundaries", "bounds", "records", "write", "total"] {
        assert!(report["seconds"][phase].is_number(), "{phase}");
    }
    assert_eq!(report["file"]["content_id"], info(folder.path(), "x.fct")["content_id"]);

    let said = run(folder.path(), "fcbuild cut.ply -o y.fct --message-format json");
    let error: serde_json::Value = serde_json::from_str(&said.err).expect("one JSON object");
    assert_eq!((said.exit, &error["level"], &error["code"]), (3, &"error".into(), &"FC204".into()));
    assert!(error["line"].is_number() && error["remedy"].is_string(), "{error}");
}

/// A mesh that looks inwards is told, and `--flip` turns it over, normals and all.
#[test]
fn faces_that_look_inwards_are_turned_over() {
    let folder = folder();
    let tetrahedron = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"];
    let inwards = ply(&tetrahedron, &["3 0 1 2", "3 0 3 1", "3 1 3 2", "3 2 3 0"]);
    fs::write(folder.path().join("in.ply"), inwards).expect("writable");
    let said = accept(folder.path(), "fcbuild in.ply -o in.fct");
    assert!(said.err.contains("FC293") && said.err.contains("--flip"), "{}", said.err);
    let said = accept(folder.path(), "fcbuild in.ply -o out.fct --flip --strict --report r.json");
    assert!(said.err.is_empty(), "{}", said.err);
    let report = fs::read_to_string(folder.path().join("r.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_str(&report).expect("JSON");
    assert_eq!(report["settings"]["flip"], true);
    let generators = ["in.fct", "out.fct"].map(|file| info(folder.path(), file)["generator"].to_string());
    assert!(generators[1].contains("--flip") && !generators[0].contains("--flip"), "{generators:?}");
    accept(folder.path(), "fct export out.fct -o out.obj");
    let said = accept(folder.path(), "fcbuild out.obj -o again.fct --strict");
    assert!(said.err.is_empty(), "{}", said.err);
    // Normals are turned with the faces.
    let obj = fs::read_to_string(folder.path().join("out.obj")).expect("readable");
    let rows = |key: &str| -> Vec<Vec<f64>> {
        let numbers = |l: &str| l.split(' ').map(|x| x.parse().expect("a number")).collect();
        obj.lines().filter_map(|l| l.strip_prefix(key)).map(numbers).collect()
    };
    for (place, normal) in rows("v ").iter().zip(rows("vn ")) {
        let outwards: f64 = place.iter().zip(&normal).map(|(x, n)| (x - 0.25) * n).sum();
        assert!(outwards > 0.0, "{obj}");
    }
}

/// What a tree has no place for is told and counted, and is no repair that `--strict` refuses.
#[test]
fn textures_materials_and_normals_of_corners_are_told() {
    let folder = folder();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("writable");
    let corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\n";
    let normals = "vn 0 0 1\nvn 1 0 0\n";
    let faces = "usemtl red\nf 1/1/1 2/2/1 3/1/1\nf 1/1/2 3/2/2 4/1/2\n";
    write("full.obj", &format!("{corners}vt 0 0\nvt 1 0\n{normals}{faces}"));
    let textured = ply(&["0 0 0", "1 0 0", "1 1 0"], &["3 0 1 2"]);
    write("full.ply", &textured.replace("float y", "float y\nproperty float s").replace(" 0\n", " 0 0\n"));
    // Two faces that meet at an edge with vertices of their own.
    let edge = ply(
        &["0 0 0 0 0 1", "1 0 0 0 0 1", "1 1 0 0 0 1", "0 0 0 0 1 0", "1 1 0 0 1 0", "0 1 1 0 1 0"],
        &["3 0 1 2", "3 3 4 5"],
    );
    let with = "float z\nproperty float nx\nproperty float ny\nproperty float nz";
    write("edge.ply", &edge.replace("float z", with));
    for (file, expected) in [
        ("full.obj", &[("texture_coordinates", 2), ("materials", 1), ("mixed_normals", 2)][..]),
        ("full.ply", &[("texture_coordinates", 3)]),
        ("edge.ply", &[("mixed_normals", 2)]),
        ("good.ply", &[]),
    ] {
        let line = format!("fcbuild {file} -o x.fct --force --strict --message-format json");
        let said = accept(folder.path(), &line);
        let warnings: Vec<serde_json::Value> =
            said.err.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
        assert_eq!(warnings.len(), expected.len(), "{file}: {}", said.err);
        for (name, count) in expected {
            assert!(
                warnings.iter().any(|w| w["name"] == *name && w["count"] == *count),
                "{file}: {}",
                said.err
            );
        }
    }
}

/// A file that is given twice leaves nothing of its second group, which is named.
#[test]
fn groups_without_faces_are_named() {
    let folder = folder();
    fs::copy(folder.path().join("good.ply"), folder.path().join("twin.ply")).expect("writable");
    let said = accept(folder.path(), "fcbuild good.ply twin.ply -o x.fct");
    assert!(said.err.contains("FC334") && said.err.contains("FC297"), "{}", said.err);
    assert!(said.err.contains("not in the tree: twin"), "{}", said.err);
}

/// What no number of single precision is as large as has no place in a tree, and its reason is not said to be NaN alone.
#[test]
fn coordinates_that_are_too_large_are_told_in_words() {
    let folder = folder();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("writable");
    let corners = ["1e308 0 0", "0 1 0", "0 0 1", "1 1 1"];
    let (floats, beyond) = (ply(&corners, &["3 0 1 2", "3 1 2 3"]), "beyond 3.4e38");
    write("floats.ply", &floats);
    write("doubles.ply", &floats.replace("float", "double"));
    write("some.obj", "v 1e308 0 0\nv 0 1 0\nv 0 0 1\nv 1 1 1\nf 1 2 3\nf 2 3 4\n");
    write("all.obj", "v -1e308 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n");
    let facet = |z: &str| {
        let vertices = format!("vertex 0 0 {z}\nvertex 0 1 0\nvertex 1 0 1");
        format!("facet normal 0 0 1\nouter loop\n{vertices}\nendloop\nendfacet\n")
    };
    write("some.stl", &format!("solid a\n{}{}endsolid a\n", facet("1e308"), facet("-1")));
    for name in ["floats.ply", "some.obj", "some.stl"] {
        let said = accept(folder.path(), &format!("fcbuild {name} -o out.fct --force"));
        assert!(said.err.contains("warning[FC303]") && said.err.contains(beyond), "{name}: {}", said.err);
        assert!(said.err.contains("warning[FC333]"), "{name}: {}", said.err);
        refuse(folder.path(), &format!("fcbuild {name} -o strict.fct --strict"), 3, &["FC213"]);
    }
    refuse(
        folder.path(),
        "fcbuild all.obj -o all.fct",
        3,
        &["FC207", "all.obj", beyond, "scale the model down"],
    );
    refuse(
        folder.path(),
        "fcbuild doubles.ply -o doubles.fct",
        3,
        &["FC292", "doubles.ply", "scale it down"],
    );
}

/// Double precision that a tree cannot hold is told, and not what it holds.
#[test]
fn positions_that_are_rounded_by_much_are_told() {
    let folder = folder();
    let write = |name: &str, text: String| fs::write(folder.path().join(name), text).expect("writable");
    // Scales are powers of two, so that the numbers have all their digits at each.
    let grid = |name: &str, scale: f64, stray: bool| {
        let row = |i: u32| f64::from(i) / 29.0;
        let mut vertices: Vec<[f64; 3]> = (0..900)
            .map(|i| {
                [4_500_000.0 + row(i % 30), 560_000.0 + row(i / 30), 300.0 + f64::from(i * i % 7) / 70.0]
            })
            .collect();
        let square = |i: u32| [[i, i + 1, i + 31], [i, i + 31, i + 30]];
        let mut faces: Vec<[u32; 3]> = (0..870).filter(|i| i % 30 < 29).flat_map(square).collect();
        if stray {
            vertices.extend([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
            faces.push([900, 901, 902]);
        }
        let text = |v: &[f64; 3]| v.map(|x| (x * scale).to_string()).join(" ");
        if name.ends_with(".obj") {
            let vertices = vertices.iter().map(|v| format!("v {}\n", text(v)));
            let faces = faces.iter().map(|f| format!("f {}\n", f.map(|v| (v + 1).to_string()).join(" ")));
            return write(name, vertices.chain(faces).collect());
        }
        let vertices: Vec<String> = vertices.iter().map(text).collect();
        let faces: Vec<String> =
            faces.iter().map(|f| format!("3 {}", f.map(|v| v.to_string()).join(" "))).collect();
        let words = |lines: &[String]| lines.iter().map(String::as_str).collect::<Vec<_>>().join("\n");
        let ply = ply(&[&words(&vertices)], &[&words(&faces)]);
        let counted = [("vertex 1", vertices.len()), ("face 1", faces.len())];
        let ply = counted.iter().fold(ply, |ply, (what, n)| {
            ply.replace(&format!("element {what}\n"), &format!("element {}{n}\n", &what[..what.len() - 1]))
        });
        write(name, ply.replace("float", if name.starts_with("float") { "float" } else { "double" }));
    };
    let told = |line: &str| {
        let said = accept(folder.path(), &format!("fcbuild {line} -o x.fct --force --message-format json"));
        let lines =
            said.err.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).expect("JSON"));
        lines.filter(|l| l["code"] == "FC298").collect::<Vec<_>>()
    };

    grid("alone.ply", 1.0, false);
    grid("alone.obj", 1.0, false);
    for file in ["alone.ply", "alone.obj"] {
        accept(folder.path(), &format!("fcbuild {file} -o {file}.fct --strict"));
    }
    // In single precision nothing is lost that a file had.
    grid("float.ply", 1.0, true);
    assert!(told("float.ply").is_empty());

    grid("stray.ply", 1.0, true);
    grid("stray.obj", 1.0, true);
    grid("small.ply", 1.0 / 65_536.0, true);
    grid("large.ply", 65_536.0, true);
    write("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_owned());
    for line in ["stray.ply", "stray.obj", "small.ply", "large.ply", "alone.ply one.obj"] {
        let lines = told(line);
        assert!(lines.len() == 1 && lines[0]["name"] == "rounded_positions", "{line}: {lines:?}");
        assert_eq!(lines[0]["count"], 1682, "{line}: {lines:?}");
        let message = lines[0]["message"].as_str().expect("text");
        assert!(
            message.contains("two corners fall together") && message.contains("files of their own"),
            "{message}"
        );
    }
    let message = told("stray.ply")[0]["message"].to_string();
    assert!(message.contains("by up to 0.12") && message.contains("are about 0.0"), "{message}");
    refuse(
        folder.path(),
        "fcbuild stray.ply -o y.fct --strict",
        3,
        &["FC213", "rounded_positions (FC298, 1,682)"],
    );

    // Nothing is left at all.
    let dots = ["4500000 0 0", "4500000.0000001 0 0", "4500000 0.0000001 0", "0 0 0", "1e-7 0 0", "0 1e-7 0"];
    write("dots.ply", ply(&dots, &["3 0 1 2", "3 3 4 5"]).replace("float", "double"));
    let said = run(folder.path(), "fcbuild dots.ply -o z.fct");
    assert!(
        said.exit == 3 && said.err.contains("FC290") && said.err.contains("files of their own"),
        "{}",
        said.err
    );
}
