//! Promise: what a command cannot do is refused with a code, the file, the place and a remedy, and changes nothing.

use fctests::commands::{accept, binary, face_count, folder, info, names, refuse, run, sample};
use std::fs;
use std::path::Path;
use std::process::Command;

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
    refuse(
        folder.path(),
        line,
        5,
        &["1M", "memory", "raise --max-memory", "FC506", "need 17M of memory at least"],
    );
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
