//! Promise: exported meshes are what was asked for, and their trees are those that were built.

use fctests::commands::{accept, face_count, folder, info, names, ply, refuse, sample};
use std::collections::HashSet;
use std::fs;
use std::path::Path;

#[test]
fn a_tree_exported_and_built_again_has_the_same_faces() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    let input = sample("sculpture.ply");
    let said = accept(at, &format!("fcbuild {} -o a.fct --report a.json", input.display()));
    for word in ["faces", "dropped", "component", "depth", "bytes a face", "at the peak", "a second"] {
        assert!(said.out.contains(word), "no `{word}` in: {}", said.out);
    }
    assert!(accept(at, "fct verify a.fct").out.contains("valid"));
    let first = info(at, "a.fct");
    assert_eq!(first["counts"]["faces"], first["counts"]["faces_in"]);
    for name in ["full.ply", "full.obj", "full.glb"] {
        accept(at, &format!("fct export a.fct -o {name}"));
        accept(at, &format!("fcbuild {name} -o again.fct --force --strict"));
        accept(at, "fct verify again.fct");
        let again = info(at, "again.fct");
        for count in ["faces", "vertices", "boundary_edges", "seam_edges", "components"] {
            assert_eq!(again["counts"][count], first["counts"][count], "{name}: {count}");
        }
    }

    accept(at, "fct export a.fct -o few.ply --triangles 5000");
    assert!((4996..=5000).contains(&face_count(&at.join("few.ply"))));
    let full = face_count(&at.join("full.ply"));
    for detail in [
        "--clusters 900",
        "--error 0.01",
        "--eye 0,1,9 --pixels 2 --height 1080",
        "--eye 0,1,9 --triangles 5000",
        "--ortho 4 --pixels 3",
        "--epsilon 1e-6",
        "--epsilon 1e-7 --eye 0,1,9",
        "--error 0.05 --region 0,1,0,1=0.001 --region 0,1,0,0.2=0.0001",
    ] {
        let said = accept(at, &format!("fct export a.fct -o part.ply --force {detail}"));
        assert!(
            said.out.contains("wrote part.ply: ")
                && said.out.contains("surface and mesh are no farther apart than"),
            "{}",
            said.out
        );
        assert!((1..full).contains(&face_count(&at.join("part.ply"))), "{detail}");
    }
    let left: Vec<_> = names(at).into_iter().filter(|n| n.starts_with('.')).collect();
    assert!(left.is_empty(), "{left:?}");
}

/// The lines of a kind in an OBJ file.
fn lines(path: &Path, kind: &str) -> Vec<String> {
    let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{e}"));
    text.lines().filter(|line| line.starts_with(kind)).map(str::to_owned).collect()
}

/// With `--in-place` there are vertices of the input only; without, the same triangles may lie beside them.
#[test]
fn vertices_stay_where_that_is_asked_for() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    accept(at, &format!("fcbuild {} -o a.fct", sample("sculpture.ply").display()));
    accept(at, "fct export a.fct -o full.obj");
    let input: HashSet<String> = lines(&at.join("full.obj"), "v ").into_iter().collect();
    for detail in ["--error 0.02", "--eye 0,1,9 --pixels 2", "--triangles 3000"] {
        let bound = |name: &str, more: &str| {
            let said = accept(at, &format!("fct export a.fct -o {name} --force --json {detail} {more}"));
            let json: serde_json::Value = serde_json::from_str(&said.out).unwrap_or_else(|e| panic!("{e}"));
            json["meshes"][0]["bound"].as_f64().expect("a bound")
        };
        let bounds = [bound("moved.obj", ""), bound("kept.obj", "--in-place")];
        let [moved, kept] = ["moved.obj", "kept.obj"].map(|name| at.join(name));
        assert_eq!(lines(&moved, "f ").len(), lines(&kept, "f ").len(), "{detail}");
        assert!(lines(&kept, "v ").iter().all(|v| input.contains(v)), "{detail}: all are the input's");
        assert!(lines(&moved, "v ").iter().any(|v| !input.contains(v)), "{detail}: some are moved");
        assert!(bounds[1] <= bounds[0], "{detail}: {bounds:?}");
        if detail.starts_with("--error") {
            assert!(bounds[0] <= 0.02, "{detail}: {bounds:?}");
        }
    }
}

/// The bound that is printed is what was allowed at the most, though vertices lie beside their places: once the longest
/// step was added wherever there was a region or an eye.
#[test]
fn the_bound_is_no_more_than_what_was_allowed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    accept(at, &format!("fcbuild {} -o a.fct", sample("sculpture.ply").display()));
    let bound = |detail: &str| {
        let said = accept(at, &format!("fct export a.fct -o x.ply --force --json {detail}"));
        let json: serde_json::Value = serde_json::from_str(&said.out).unwrap_or_else(|e| panic!("{e}"));
        (json["meshes"][0]["bound"].as_f64().expect("a bound"), said.err)
    };
    let [low, high] = ["input_min", "input_max"].map(|corner| {
        let corner = info(at, "a.fct")[corner].clone();
        [0, 1, 2].map(|k: usize| corner[k].as_f64().expect("a number"))
    });
    let [x, y, z] = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
    // How far a region is allowed less or more, and where; in all of them 0.02 is the most that counts.
    for (region, is_empty) in [
        ("90,90,90,0.1=0.0002".to_owned(), true),
        ("90,90,90,0.1=0.5".to_owned(), true),
        (format!("{x},{y},{},0.3=0.0002", high[2]), false),
        (format!("{x},{},{z},0.5=0.004", high[1]), false),
    ] {
        let (bound, said) = bound(&format!("--error 0.02 --region {region}"));
        assert!(bound > 0.01 && bound <= 0.02, "{region}: {bound}");
        assert_eq!(
            said.contains("FC353") && said.contains("nothing of the model"),
            is_empty,
            "{region}: {said}"
        );
    }
    // Of the whole model, in a region of its own.
    let (bound_within, said) = bound(&format!("--error 0.0002 --region {x},{y},{z},99=0.02"));
    assert!(bound_within > 0.01 && bound_within <= 0.02 && said.is_empty(), "{bound_within}");
}

/// A mesh of every face is the surface itself, which is no loose bound, however it was chosen.
#[test]
fn a_bound_of_zero_is_not_called_loose() {
    let folder = folder();
    let said = accept(folder.path(), "fct export good.fct -o all.ply --triangles 999999999").out;
    assert!(said.contains("no farther apart than 0\n") && !said.contains("loose"), "{said}");
}

/// Meshes of several sizes come from one command, all or none of them.
#[test]
fn a_chain_of_levels_of_detail_is_written_at_once() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    accept(at, &format!("fcbuild {} -o a.fct", sample("sculpture.ply").display()));
    let chain = "fct export a.fct --triangles 20000,5000,1000";
    let said = accept(at, &format!("{chain} -o lod_{{n}}.ply"));
    assert_eq!(said.out.lines().count(), 3, "{}", said.out);
    for n in [20000, 5000, 1000] {
        let name = format!("lod_{n}.ply");
        assert!(said.out.contains(&format!("wrote {name}: ")), "{}", said.out);
        assert!((n - 4..=n).contains(&face_count(&at.join(&name))), "{name}");
    }
    accept(at, &format!("{chain} -o lod_{{n}}.glb"));
    accept(at, "fcbuild lod_5000.glb -o again.fct");
    // Where thin parts collapse two triangles may be one, which the builder keeps once.
    let again = info(at, "again.fct");
    let faces = again["counts"]["faces"].as_u64().expect("a number");
    assert!((4980..=5000).contains(&faces), "{faces}");
    refuse(at, &format!("{chain} -o lod_{{n}}.glb"), 4, &["FC472", "lod_20000.glb", "--force"]);
    refuse(at, &format!("{chain} -o lod.glb"), 2, &["FC111", "lod.glb", "{n}"]);
    refuse(at, "fct export a.fct -o b_{n}.ply --error 1", 2, &["FC111", "b_{n}.ply", "--triangles"]);
    refuse(at, "fct export a.fct -o b_{n}.ply --triangles 5000,1", 5, &["FC511", "a.fct"]);
}

#[test]
fn what_is_measured_is_within_the_bound_and_falls_with_more_triangles() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    accept(at, &format!("fcbuild {} -o a.fct", sample("sculpture.ply").display()));
    let told = |detail: &str| -> serde_json::Value {
        let said = accept(at, &format!("fct export a.fct -o m.ply --force --json {detail}")).out;
        let told: serde_json::Value = serde_json::from_str(&said).expect("JSON");
        told["meshes"][0].clone()
    };
    let number = |value: &serde_json::Value| value.as_f64().expect("a number");
    let mut last = f64::INFINITY;
    for triangles in [500, 2_000, 8_000] {
        let mesh = told(&format!("--triangles {triangles} --measure"));
        let [rms, max] = ["rms", "max"].map(|what| number(&mesh["measured"][what]));
        assert!(0.0 < rms && rms < max && max <= number(&mesh["bound"]) && rms < last, "{mesh}");
        last = rms;
    }
    let tight = told("--error 0.02 --measure");
    assert!(number(&tight["measured"]["max"]) <= number(&tight["bound"]), "{tight}");
    let full = told("--measure");
    assert!(number(&full["measured"]["max"]) < 1e-5, "every face of the input is where it was: {full}");
    assert!(told("--error 0.02")["measured"].is_null());
}

#[test]
fn coordinates_far_from_the_origin_come_back() {
    let folder = folder();
    let far = ["500000.001 4000000 7", "500000.002 4000000 7", "500000.002 4000000.001 7"];
    let text = ply(&far, &["3 0 1 2"]).replace("float", "double");
    fs::write(folder.path().join("far.ply"), text).expect("writable");
    accept(folder.path(), "fcbuild far.ply -o far.fct");
    let told = info(folder.path(), "far.fct");
    for (corner, expected) in
        [("input_min", [500_000.001, 4e6, 7.0]), ("input_max", [500_000.002, 4_000_000.001, 7.0])]
    {
        for (k, x) in expected.into_iter().enumerate() {
            assert!((told[corner][k].as_f64().expect("a number") - x).abs() < 1e-5, "{told}");
        }
    }
    let text = accept(folder.path(), "fct info far.fct").out;
    assert!(text.contains("box        500000.001"), "the box is in coordinates of the input: {text}");
    accept(folder.path(), "fct export far.fct -o far.obj");
    let obj = fs::read_to_string(folder.path().join("far.obj")).expect("readable");
    let corners: Vec<Vec<f64>> = obj
        .lines()
        .filter_map(|l| l.strip_prefix("v "))
        .map(|l| l.split(' ').map(|x| x.parse().expect("a number")).collect())
        .collect();
    assert_eq!(corners.len(), 3);
    for (corner, line) in corners.iter().zip(far) {
        for (x, text) in corner.iter().zip(line.split(' ')) {
            assert!((x - text.parse::<f64>().expect("a number")).abs() < 1e-5, "{x} is not {text}");
        }
    }
}
