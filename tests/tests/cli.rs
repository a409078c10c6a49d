//! What the commands promise: exit codes, messages that name file, place and remedy, and nothing left behind.

mod commands;

use commands::{accept, binary, folder, names, ply, refuse, run, sample};
use std::collections::HashSet;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

#[test]
fn bad_input_is_refused_with_file_place_and_remedy() {
    let folder = folder();
    for (line, exit, fragments) in [
        ("fcbuild empty.ply -o x.fct", 3, &["FC200", "empty.ply: ", "the file is empty"][..]),
        ("fcbuild cut.ply -o x.fct", 3, &["FC204", "cut.ply: line ", "; "]),
        ("fcbuild index.ply -o x.fct", 3, &["FC203", "index.ply: line 15", "90000", "4"]),
        ("fcbuild points.ply -o x.fct", 3, &["FC207", "points.ply: ", "no faces"]),
        (
            "fcbuild allnan.ply -o x.fct",
            3,
            &["FC207", "only face", "vertex 1, counted from 0", "coordinates"],
        ),
        ("fcbuild sliver.ply -o x.fct", 3, &["FC290", "sliver.ply: ", "degenerate"]),
        ("fcbuild notes.txt -o x.fct", 3, &["FC201", "notes.txt", "PLY, OBJ, STL"]),
        ("fcbuild good.fct -o x.fct", 3, &["FC201", "good.fct", "face-cluster tree", "fct export"]),
        ("fcbuild dir -o x.fct", 4, &["FC402", "dir: is a directory"]),
        ("fcbuild lost.ply -o x.fct", 4, &["FC401", "lost.ply", "cannot open"]),
        ("fcbuild nan.ply -o x.fct --strict", 3, &["FC213", "nan.ply", "non_finite", "--strict"]),
        ("fcbuild good.ply lost.ply -o x.fct", 4, &["FC401", "lost.ply"]),
        ("fct info good.ply", 7, &["FC701", "good.ply", "signature", "fcbuild"]),
        ("fct verify good.ply", 7, &["FC701", "good.ply"]),
        ("fct export good.ply -o x.ply", 7, &["FC701", "good.ply"]),
        ("fct info empty.ply", 7, &["FC70", "empty.ply"]),
        ("fct info lost.fct", 4, &["FC471", "lost.fct"]),
        ("fct info dir", 4, &["FC473", "dir"]),
    ] {
        refuse(folder.path(), line, exit, fragments);
    }
}

#[test]
fn outputs_are_checked_before_the_work() {
    let folder = folder();
    let scene = "{\"asset\": {\"generator\": \"another program\", \"version\": \"2.0\"}}";
    fs::write(folder.path().join("scene.json"), scene).expect("writable");
    for (line, exit, fragments) in [
        ("fcbuild good.ply -o good.fct", 4, &["FC472", "good.fct", "exists", "--force"][..]),
        ("fcbuild good.ply -o good.ply", 2, &["FC101", "good.ply", "the output is an input"]),
        ("fcbuild good.ply -o dir/../good.ply --force", 2, &["FC101", "the output is an input"]),
        ("fcbuild good.ply -o x.fct --report ./x.fct", 2, &["FC101", "one file"]),
        ("fcbuild good.ply -o x.fct --report notes.txt", 4, &["FC472", "notes.txt", "--force"]),
        (
            "fcbuild good.ply -o x.fct --report no/r.json",
            4,
            &["FC412", "no/r.json", "the folder no does not exist", "make it"],
        ),
        (
            "fcbuild good.ply -o notes.txt --force",
            4,
            &["FC474", "notes.txt", "no .fct file", "left alone", "; "],
        ),
        ("fcbuild good.ply -o quad.ply --force", 2, &["FC103", "quad.ply", "name of a mesh", ".fct"]),
        ("fcbuild good.ply -o new.OBJ", 2, &["FC103", "new.OBJ", "fct export"]),
        ("fcbuild good.ply -o empty --force", 4, &["FC474", "empty", "left alone"]),
        ("fcbuild good.ply -o x.fct --force --report notes.txt", 4, &["FC474", "notes.txt", "no report"]),
        ("fcbuild good.ply -o x.fct --force --report scene.json", 4, &["FC474", "scene.json", "no report"]),
        ("fcbuild good.ply -o x.fct --report new.gltf", 2, &["FC103", "new.gltf", "a report", ".json"]),
        ("fcbuild good.ply -o dir", 4, &["FC473", "dir", "a directory"]),
        (
            "fcbuild good.ply -o no/x.fct",
            4,
            &["FC471", "no/x.fct", "the folder no does not exist", "make it"],
        ),
        ("fcbuild empty.ply -o no/x.fct", 4, &["FC471"]),
        ("fcbuild - -o x.fct", 2, &["FC102", "standard input"]),
        ("fct export good.fct -o good.ply", 4, &["FC472", "good.ply", "--force"]),
        ("fct export good.fct -o good.ply --force", 4, &["FC474", "good.ply", "left alone"]),
        ("fct export good.fct -o empty.ply --force", 4, &["FC474", "empty.ply", "left alone"]),
        (
            "fct export good.fct -o no/x.ply",
            4,
            &["FC412", "no/x.ply", "the folder no does not exist", "make it"],
        ),
        ("fct export good.fct -o x.stl", 2, &["FC111", "x.stl", ".obj"]),
        ("fct export good.fct -o x.ply --error 1 --eye 0,0,1", 2, &["cannot be used with"]),
    ] {
        refuse(folder.path(), line, exit, fragments);
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("good.ply", folder.path().join("link.fct")).expect("writable");
        fs::hard_link(folder.path().join("good.fct"), folder.path().join("tree.ply")).expect("writable");
        refuse(folder.path(), "fcbuild good.ply -o link.fct --force", 2, &["FC101"]);
        refuse(folder.path(), "fct export good.fct -o tree.ply --force", 2, &["FC101"]);
    }
}

/// A report that cannot be written leaves the old tree; so does a tree, and no limit on files ends a program unheard.
#[cfg(target_os = "linux")]
#[test]
fn a_tree_without_its_report_does_not_take_its_place() {
    let folder = folder();
    let before = fs::read(folder.path().join("good.fct")).expect("a tree");
    // The report names the output as it was typed, so that it can be made longer than the tree.
    let output = format!("{}good.fct", "./".repeat(1800));
    let words = ["triangle.ply", "--force", "--report", "r.json", "-o"];
    // Shells count in blocks of 512 or 1024 bytes.
    for (blocks, code) in [(4, "FC412"), (1, "FC471")] {
        let limited = format!("ulimit -f {blocks}; exec \"$0\" \"$@\"");
        let mut command = Command::new("sh");
        command.args(["-c", &limited]).arg(binary("fcbuild")).args(words).arg(&output);
        let names_before = names(folder.path());
        let done = command.current_dir(folder.path()).output().expect("the command ends");
        let said = String::from_utf8_lossy(&done.stderr);
        assert!(done.status.code() == Some(4) && said.contains(code), "{:?} {said}", done.status);
        assert_eq!(names(folder.path()), names_before);
        assert!(fs::read(folder.path().join("good.fct")).expect("a tree") == before);
    }
    accept(folder.path(), &format!("fcbuild {} {output}", words.join(" ")));
    assert!(folder.path().join("r.json").is_file());
    assert!(fs::read(folder.path().join("good.fct")).expect("a tree") != before);
}

/// A folder without write permission keeps everybody out but the administrator.
#[cfg(unix)]
#[test]
fn an_unwritable_folder_is_an_error_of_the_system() {
    use std::os::unix::fs::PermissionsExt as _;
    let folder = folder();
    let closed = folder.path().join("dir");
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o555)).expect("ours");
    if fs::write(closed.join("probe"), b"").is_ok() {
        fs::remove_file(closed.join("probe")).expect("ours");
        // The administrator may write anywhere but into the kernel's own files.
        if Path::new("/proc/self").is_dir() {
            refuse(folder.path(), "fcbuild good.ply -o /proc/x.fct", 4, &["FC471", "/proc/x.fct"]);
        }
    } else {
        refuse(folder.path(), "fcbuild good.ply -o dir/x.fct", 4, &["FC471", "dir/x.fct"]);
        refuse(folder.path(), "fct export good.fct -o dir/x.ply", 4, &["FC412", "dir/x.ply"]);
    }
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o755)).expect("ours");
}

#[test]
fn usage_errors_and_limits_have_their_codes() {
    let folder = folder();
    for line in [
        "fcbuild",
        "fcbuild good.ply",
        "fcbuild good.ply -o x.fct --faster",
        "fcbuild good.ply -o x.fct --threads 0",
        "fcbuild good.ply -o x.fct --split best",
        "fcbuild good.ply -o x.fct --threads 257",
        "fct",
        "fct look good.fct",
    ] {
        refuse(folder.path(), line, 2, &["--help"]);
    }
    // Negative numbers are values, not flags, so that the answer is about what is allowed.
    for (line, expected) in [
        ("fcbuild good.ply -o x.fct --weld -3", "a distance above 0"),
        ("fcbuild good.ply -o x.fct --max-memory -3", "a size above 0"),
        ("fct export good.fct -o x.ply --triangles 0", "a number of triangles, 1 or more"),
        ("fct export good.fct -o x.ply --clusters -7", "a number of clusters, 1 or more"),
        ("fct export good.fct -o x.ply --error -1", "a distance, 0 or more, or a percentage"),
        ("fct export good.fct -o x.ply --eye -1,0", "three numbers"),
        ("fct export good.fct -o x.ply --epsilon -1", "a number, 0 or more"),
        ("fct export good.fct -o x.ply --error 1 --region 0,0,0=1", "a place, a radius and an error"),
    ] {
        refuse(folder.path(), line, 2, &["invalid value '", expected]);
    }
    let line = "fcbuild good.ply -o x.fct --max-memory 1M";
    refuse(folder.path(), line, 5, &["1M", "memory", "raise --max-memory", "need 17M or more"]);
    accept(folder.path(), "fct export good.fct -o x.ply --eye -1,0,2");
}

/// What the error recommends must work.
#[test]
fn a_budget_below_the_coarsest_mesh_is_refused_with_what_there_is() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    accept(at, &format!("fcbuild {} -o a.fct", sample("sculpture.ply").display()));
    let said = run(at, "fct export a.fct -o x.ply --triangles 1");
    assert!(said.exit == 5 && said.err.starts_with("error[FC511]: a.fct: "), "{}", said.err);
    let (_, advice) = said.err.trim().rsplit_once("ask for ").expect("advice");
    let least: u64 = advice.strip_suffix(" or more").and_then(|n| n.parse().ok()).expect("a number");
    let said = accept(at, &format!("fct export a.fct -o x.ply --triangles {least}"));
    assert!(said.out.contains("--error"), "it says that the bound is loose: {}", said.out);
    assert_eq!(face_count(&at.join("x.ply")), least);
    let line = format!("fct export a.fct -o y.ply --triangles {}", least - 1);
    refuse(at, &line, 5, &["FC511", &format!("ask for {least} or more")]);
}

/// Where the surface had to be cut is told, and is no mesh for `--strict`.
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
    for (triangles, is_missed) in [(20, true), (254, false)] {
        let said = accept(folder.path(), &format!("{export} {triangles}.ply --triangles {triangles}"));
        let mesh: serde_json::Value = serde_json::from_str(&said.out).expect("JSON");
        let mesh = &mesh["meshes"][0];
        assert_eq!(said.err.contains("FC352"), is_missed, "{mesh} {}", said.err);
        assert_eq!(mesh["next"].as_u64().is_some_and(|next| next > 20), is_missed, "{mesh}");
    }
}

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

#[test]
fn nothing_is_exported_from_a_damaged_file() {
    let folder = folder();
    let path = folder.path().join("good.fct");
    let vertices = &info(folder.path(), "good.fct")["sections"]["VERT"]["offset"];
    let mut bytes = fs::read(&path).expect("a tree");
    bytes[vertices.as_u64().expect("a number") as usize + 3] ^= 1;
    fs::write(&path, bytes).expect("writable");
    refuse(
        folder.path(),
        "fct export good.fct -o x.ply",
        7,
        &["FC721", "good.fct", "section VERT", "damaged"],
    );
}

#[test]
fn verify_says_in_json_what_is_wrong() {
    let folder = folder();
    let path = folder.path().join("good.fct");
    let json = |out: &str| serde_json::from_str::<serde_json::Value>(out).expect("JSON");
    assert_eq!(json(&accept(folder.path(), "fct verify good.fct --json").out)["valid"], true);
    let mut bytes = fs::read(&path).expect("readable");
    // In the first section, the description: the end of a file may be padding.
    let first_section =
        usize::try_from(u64::from_le_bytes(bytes[136..144].try_into().expect("eight"))).expect("small");
    bytes[first_section + 20] ^= 1;
    fs::write(folder.path().join("bad.fct"), bytes).expect("writable");
    let said = run(folder.path(), "fct verify bad.fct --json");
    assert_eq!((said.exit, &json(&said.out)["valid"]), (7, &false.into()));
    assert!(said.err.starts_with("error[FC721]: bad.fct: "), "{}", said.err);
}

fn info(folder: &Path, file: &str) -> serde_json::Value {
    let said = accept(folder, &format!("fct info {file} --json"));
    serde_json::from_str(&said.out).expect("JSON")
}

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

/// The number of faces that the header of a PLY file declares.
fn face_count(path: &Path) -> u64 {
    let bytes = fs::read(path).expect("readable");
    let header = String::from_utf8_lossy(&bytes[..bytes.len().min(2000)]).into_owned();
    let line = header.lines().find_map(|l| l.strip_prefix("element face ")).expect("faces are declared");
    line.parse().expect("a number")
}

#[test]
fn several_files_become_groups_of_one_tree() {
    let folder = folder();
    let other = sample("odd/tetra.obj");
    accept(folder.path(), &format!("fcbuild good.ply {} -o both.fct", other.display()));
    accept(folder.path(), "fct verify both.fct");
    let both = info(folder.path(), "both.fct");
    assert_eq!(both["counts"]["faces"], 6);
    assert_eq!(both["source"], "good.ply, tetra.obj");
    assert_eq!(both["groups"].as_array().map(Vec::len), Some(2));
    for name in ["both.obj", "both.glb"] {
        accept(folder.path(), &format!("fct export both.fct -o {name}"));
        accept(folder.path(), &format!("fcbuild {name} -o again.fct --strict --force"));
        let again = info(folder.path(), "again.fct");
        for what in [&["groups"][..], &["counts", "faces"], &["counts", "vertices"]] {
            let of = |info: &serde_json::Value| what.iter().fold(info.clone(), |v, key| v[key].clone());
            assert_eq!(of(&again), of(&both), "{name}: {what:?}");
        }
    }
}

/// `--chunk-faces` divides the same tree into more parts, which costs bytes; a report and the file tell.
#[test]
fn parts_that_are_read_alone_have_the_size_that_was_asked_for() {
    let folder = folder();
    let at = folder.path();
    fs::copy(sample("sculpture.ply"), at.join("in.ply")).unwrap();
    let chunks_of = |flags: &str| {
        accept(at, &format!("fcbuild in.ply -o out.fct --force --report r.json {flags}"));
        accept(at, "fct verify out.fct");
        let report: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(at.join("r.json")).unwrap()).unwrap();
        let file = fct::ChunkFile::open(&at.join("out.fct")).unwrap();
        let told = file.meta().generator.contains("--chunk-faces");
        assert_eq!(told, !flags.is_empty(), "{}", file.meta().generator);
        (file.crown().chunk_count(), report["settings"]["chunk_faces"].as_u64(), file.header().file_len)
    };
    let (many, fine) = (chunks_of(""), chunks_of("--chunk-faces 300"));
    assert_eq!([many.1, fine.1], [Some(u64::from(fct::CHUNK_FACES)), Some(300)]);
    assert!(fine.0 > 4 * many.0 && fine.2 > many.2, "{many:?} {fine:?}");
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

/// Stages that count show how far they are, the others that they have begun.
#[test]
fn progress_counts_where_the_time_goes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let input = sample("sculpture.ply");
    let said = accept(folder.path(), &format!("fcbuild {} -o a.fct --progress always", input.display()));
    for line in ["partition 50 %", "bounds 50 %", "bounds 90 %", "mesh", "records", "write"] {
        assert!(said.err.lines().any(|said| said == line), "no `{line}` in {}", said.err);
    }
}

#[test]
fn coordinates_far_from_the_origin_come_back() {
    let folder = folder();
    let far = ["500000.001 4000000 7", "500000.002 4000000 7", "500000.002 4000000.001 7"];
    let text = ply(&far, &["3 0 1 2"]).replace("float", "double");
    fs::write(folder.path().join("far.ply"), text).expect("writable");
    accept(folder.path(), "fcbuild far.ply -o far.fct");
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

#[test]
fn help_and_version_go_to_standard_output() {
    let here = Path::new(".");
    for line in ["fcbuild --help", "fct --help", "fct info --help", "fct verify --help", "fct export --help"]
    {
        let said = accept(here, line);
        assert!(said.out.contains("Examples:") && said.out.contains("Exit codes:"), "{line}: {}", said.out);
        assert!(said.err.is_empty());
    }
    // Names with a number stand there as they can be typed; no line is so long that it breaks in the middle.
    for (line, name) in [("fct export --help", "'lod_{n}.glb'"), ("fcview --help", "'f{n}.png'")] {
        let out = accept(here, line).out;
        assert!(out.contains(&format!(" {name}")) && !out.contains("{#}"), "{line}: {out}");
    }
    for line in ["fcbuild --help", "fct --help", "fct export --help", "fct verify --help", "fcview --help"] {
        let out = accept(here, line).out;
        let (_, tail) = out.split_once("Examples:").expect("examples");
        for text in tail.lines() {
            assert!(text.chars().count() <= 100 && !text.ends_with([' ', '{']), "{line}: {text}");
        }
        for code in ["129", "130", "143"] {
            assert!(tail.contains(code), "{line}: {code}");
        }
    }
    assert!(accept(here, "fcbuild --version").out.starts_with("fcbuild "));
    assert!(accept(here, "fct --version").out.starts_with("fct "));
}

/// A reader that goes away early, as `head` does, is no error and no panic.
#[cfg(unix)]
#[test]
fn a_closed_pipe_is_no_failure() {
    let folder = folder();
    let mut child = Command::new(binary("fct"))
        .args(["info", "good.fct"])
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command starts");
    drop(child.stdout.take());
    let done = child.wait_with_output().expect("the command ends");
    assert_eq!((done.status.code(), done.stderr.len()), (Some(0), 0));
}

/// Ctrl-C during the build removes the temporary and ends with 130.
#[cfg(unix)]
#[test]
fn a_signal_stops_the_build_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    // Sixteen copies make the job long enough to be caught in the middle, however fast the machine is.
    let inputs = vec![sample("sculpture.ply"); 16];
    let mut command = Command::new(binary("fcbuild"));
    command.args(&inputs).args(["-o", "x.fct", "--threads", "1"]).current_dir(folder.path());
    assert_eq!(stopped(command, folder.path(), "INT"), 130);
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

/// A terminal that goes away ends the build in the same way, but not one that `nohup` protects.
#[cfg(target_os = "linux")]
#[test]
fn a_terminal_that_goes_away_stops_the_build_unless_it_is_told_not_to() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let status = fs::read_to_string("/proc/self/status").expect("a kernel");
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).expect("a mask");
    let ignored = u64::from_str_radix(ignored.trim(), 16).expect("a mask");
    let inputs = vec![sample("sculpture.ply"); 16];
    let words = ["-o", "x.fct", "--threads", "1"];
    for (signal, exit) in [("HUP", 129), ("QUIT", 131), ("XCPU", 152)] {
        // Where these tests run under `nohup`, the build does too.
        if ignored >> (exit - 129) & 1 == 1 {
            continue;
        }
        let mut command = Command::new(binary("fcbuild"));
        command.args(&inputs).args(words).current_dir(folder.path());
        assert_eq!(stopped(command, folder.path(), signal), exit);
        assert_eq!(names(folder.path()), Vec::<String>::new());
    }
    let mut command = Command::new("nohup");
    command.arg(binary("fcbuild")).args(&inputs[..2]).args(words).current_dir(folder.path());
    let done = signalled(command, folder.path(), "HUP");
    assert_eq!(done.status.code(), Some(0), "{}", String::from_utf8_lossy(&done.stderr));
    assert_eq!(names(folder.path()), ["x.fct"]);
}

/// A verification has nothing to leave, and says what ended it.
#[cfg(target_os = "linux")]
#[test]
fn a_signal_stops_a_verification_with_a_message() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let inputs = ["sculpture.ply", "terrain.ply", "parts.ply"].map(|name| sample(name).display().to_string());
    accept(folder.path(), &format!("fcbuild {} -o a.fct", inputs.join(" ")));
    let mut command = Command::new("nice");
    command.args(["-n", "19"]).arg(binary("fct")).args(["verify", "a.fct"]).current_dir(folder.path());
    let mut child = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().expect("the command starts");
    // A signal before the program listens would end it without a word.
    let listens = |process: u32| {
        let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
        caught.is_some_and(|mask| u64::from_str_radix(mask.trim(), 16).is_ok_and(|mask| mask & 2 != 0))
    };
    while !listens(child.id()) {
        assert!(child.try_wait().expect("ours").is_none(), "it ends before it listens");
    }
    send(child.id(), "INT");
    let done = child.wait_with_output().expect("the command ends");
    let said = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.code() == Some(130) && said.starts_with("error[FC902]"), "{:?} {said}", done.status);
}

/// The same during an export, and for termination.
#[cfg(unix)]
#[test]
fn a_signal_stops_an_export_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    accept(folder.path(), &format!("fcbuild {} -o a.fct", sample("sculpture.ply").display()));
    // Searching for a budget takes longest, and a polite process is slow where the machine is busy.
    let mut command = Command::new("nice");
    let line = "export a.fct -o x.obj --triangles 60000";
    command.args(["-n", "19"]).arg(binary("fct")).args(line.split(' ')).current_dir(folder.path());
    assert_eq!(stopped(command, folder.path(), "TERM"), 143);
    assert_eq!(names(folder.path()), ["a.fct"]);
}

/// Starts `command`, sends it the signal once its temporary is there, and gives its exit code.
#[cfg(unix)]
fn stopped(command: Command, folder: &Path, signal: &str) -> i32 {
    let done = signalled(command, folder, signal);
    let said = String::from_utf8_lossy(&done.stderr);
    assert!(said.contains("FC902") && said.lines().count() == 1, "{said}");
    done.status.code().unwrap_or(-1)
}

/// Starts `command`, sends it the signal once its temporary is there, and waits for its end.
#[cfg(unix)]
fn signalled(mut command: Command, folder: &Path, signal: &str) -> std::process::Output {
    use std::time::{Duration, Instant};
    let before = names(folder).len();
    let child = command.stderr(Stdio::piped()).stdout(Stdio::null()).spawn().expect("the command starts");
    let start = Instant::now();
    while names(folder).len() == before {
        assert!(start.elapsed() < Duration::from_secs(20), "no temporary appears");
        std::thread::sleep(Duration::from_millis(1));
    }
    send(child.id(), signal);
    child.wait_with_output().expect("the command ends")
}

#[cfg(unix)]
fn send(process: u32, signal: &str) {
    let sent = Command::new("sh").args(["-c", &format!("kill -{signal} {process}")]).status();
    assert!(sent.is_ok_and(|s| s.success()), "the signal is sent");
}
