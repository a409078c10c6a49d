//! Promise: the commands do what their flags say.

use fctests::commands::{accept, binary, folder, info, sample};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

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

/// Files of one name, and one file given twice, once made groups of one name.
#[test]
fn no_two_groups_have_one_name() {
    let folder = folder();
    let at = folder.path();
    fs::copy(at.join("quad.ply"), at.join("dir/good.ply")).expect("writable");
    fs::write(at.join("dir/good.obj"), "v 5 0 0\nv 6 0 0\nv 5 1 0\ng good_2\nf 1 2 3\n").expect("writable");
    let groups = |file: &str| {
        let names = info(at, file)["groups"].clone();
        names
            .as_array()
            .expect("a list")
            .iter()
            .map(|n| n.as_str().expect("a name").to_owned())
            .collect::<Vec<_>>()
    };
    fs::write(
        at.join("dir/good.stl"),
        "solid good\nfacet normal 0 0 1\nouter loop\nvertex 9 0 0\nvertex 10 0 0\n\
        vertex 9 1 0\nendloop\nendfacet\nendsolid good\n",
    )
    .expect("writable");
    accept(at, "fcbuild good.ply dir/good.obj dir/good.stl -o several.fct");
    assert_eq!(groups("several.fct"), ["good", "good_2", "good_3"]);
    let said = accept(at, "fcbuild good.ply good.ply dir/good.stl -o twice.fct");
    assert!(said.err.contains("FC297") && said.err.contains("not in the tree: good_2"), "{}", said.err);
    assert_eq!(groups("twice.fct"), ["good", "good_3"]);
}

/// An OBJ has groups where it has no objects, and comes back with them.
#[test]
fn groups_of_an_obj_are_kept() {
    let folder = folder();
    let at = folder.path();
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 1\n";
    fs::write(at.join("g.obj"), format!("{corners}g ear\nf 1 2 3\ng nose\nf 2 4 3\ng ear\nf 1 5 2\n"))
        .expect("writable");
    accept(at, "fcbuild g.obj -o g.fct");
    accept(at, "fct verify g.fct");
    let of_groups = info(at, "g.fct");
    assert_eq!(of_groups["groups"], serde_json::json!(["ear", "nose"]));
    let said = accept(at, "fcbuild g.obj -o g.fct --force");
    assert!(said.err.contains("FC294") && said.err.contains("--join-groups"), "{}", said.err);
    accept(at, "fcbuild g.obj -o one.fct --join-groups --strict --report r.json");
    accept(at, "fct verify one.fct");
    let joined = info(at, "one.fct");
    let counts = |info: &serde_json::Value| ["components", "groups"].map(|of| info["counts"][of].as_u64());
    assert_eq!([counts(&of_groups), counts(&joined)], [[Some(2); 2], [Some(1); 2]]);
    assert!(joined["generator"].as_str().is_some_and(|text| text.ends_with("--join-groups")));
    let report: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(at.join("r.json")).unwrap()).unwrap();
    assert_eq!(report["settings"]["join_groups"], true);
    fs::write(at.join("o.obj"), format!("{corners}o all\ng ear\nf 1 2 3\ng nose\nf 2 4 3\nf 1 5 2\n"))
        .expect("writable");
    let said = accept(at, "fcbuild o.obj -o o.fct --strict");
    assert!(said.err.contains("FC344") && said.err.contains("(2 times)"), "{}", said.err);
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
        let file = fct::ChunkFile::open(at.join("out.fct")).unwrap();
        let told = file.meta().generator.contains("--chunk-faces");
        assert_eq!(told, !flags.is_empty(), "{}", file.meta().generator);
        (file.crown().chunk_count(), report["settings"]["chunk_faces"].as_u64(), file.header().file_len)
    };
    let (many, fine) = (chunks_of(""), chunks_of("--chunk-faces 300"));
    assert_eq!([many.1, fine.1], [Some(u64::from(fct::CHUNK_FACES)), Some(300)]);
    assert!(fine.0 > 4 * many.0 && fine.2 > many.2, "{many:?} {fine:?}");
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
    let shown = |line: &str| accept(folder.path(), line).err.lines().map(str::to_owned).collect::<Vec<_>>();
    let said = shown("fct verify a.fct --progress always");
    for line in ["bytes", "rules 0 %", "rules 50 %", "rules 90 %"] {
        assert!(said.iter().any(|said| said == line), "no `{line}` in {said:?}");
    }
    for format in ["ply", "obj", "glb"] {
        let said = shown(&format!("fct export a.fct -o a.{format} --progress always"));
        for line in ["bytes", "cut", "mesh", "bound", "write 0 %", "write 60 %"] {
            assert!(said.iter().any(|said| said == line), "{format}: no `{line}` in {said:?}");
        }
    }
    // Nobody looks on.
    assert!(shown("fct verify a.fct").is_empty() && shown("fct export a.fct -o b.ply").is_empty());
    assert!(shown("fct verify a.fct --progress never").is_empty());
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

/// The same mesh under another name is the same tree; only the name that the file holds tells them apart.
#[test]
fn the_name_of_a_file_is_no_part_of_the_tree() {
    let folder = folder();
    fs::copy(folder.path().join("good.ply"), folder.path().join("copy.ply")).expect("writable");
    accept(folder.path(), "fcbuild copy.ply -o copy.fct");
    let [mut good, mut copy] = ["good.fct", "copy.fct"].map(|file| info(folder.path(), file));
    assert_eq!(good["source_id"], copy["source_id"]);
    for (name, of) in [("good", &mut good), ("copy", &mut copy)] {
        assert_eq!(of["source"], format!("{name}.ply"));
        for member in ["path", "source", "content_id"] {
            of[member] = serde_json::Value::Null;
        }
    }
    assert_eq!(good, copy);
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
