//! Promise: an output appears whole or not at all, and nothing stays beside it.

mod sample;

use std::fs;
use std::path::Path;
use std::time::{Duration, SystemTime};

use fct::{Error, Tree, WriteOptions, Writer, write};
use sample::{Sample, Split};

const REPLACE: WriteOptions = WriteOptions { overwrite: true, source_id: 0 };

fn names_in(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

#[test]
fn an_existing_file_stays_without_overwrite() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.fct");
    fs::write(&path, "mine").unwrap();
    let error = Writer::create(&path, false).unwrap_err();
    assert!(matches!(error, Error::Exists { .. }));
    assert_eq!(error.exit_code(), 4);
    assert!(error.to_string().contains("--force"), "{error}");
    assert_eq!(fs::read(&path).unwrap(), b"mine");
    assert_eq!(names_in(folder.path()), ["out.fct"]);
}

#[test]
fn a_file_that_appears_meanwhile_stays_without_overwrite() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.fct");
    let writer = Writer::create(&path, false).unwrap();
    fs::write(&path, "mine").unwrap();
    let error = writer.finish(&Sample::fan(3, Split::Halves).data(), 0).unwrap_err();
    assert!(matches!(error, Error::Exists { .. }));
    assert_eq!(fs::read(&path).unwrap(), b"mine");
    assert_eq!(names_in(folder.path()), ["out.fct"]);
}

/// `fcbuild scan.ply -o other.ply --force` must not cost a scan.
#[test]
fn overwrite_replaces_trees_only() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.fct");
    for mine in [&b"ply\nformat ascii 1.0\n"[..], b"", b"\x8FFCT"] {
        fs::write(&path, mine).unwrap();
        let error = Writer::create(&path, true).unwrap_err();
        assert_eq!((error.code(), error.exit_code()), ("FC474", 4));
        assert!(error.to_string().contains("out.fct: the file is no .fct file and is left alone"), "{error}");
        assert_eq!(fs::read(&path).unwrap(), mine);
    }
    fs::remove_file(&path).unwrap();
    let writer = Writer::create(&path, true).unwrap();
    fs::write(&path, "mine").unwrap();
    let error = writer.finish(&Sample::fan(3, Split::Halves).data(), 0).unwrap_err();
    assert_eq!((error.code(), fs::read(&path).unwrap()), ("FC474", b"mine".to_vec()));
    assert_eq!(names_in(folder.path()), ["out.fct"]);
}

#[test]
fn overwrite_replaces_while_readers_keep_what_they_opened() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.fct");
    write(&path, &Sample::fan(3, Split::Halves).data(), &REPLACE).unwrap();
    let old = Tree::open(&path).unwrap();
    write(&path, &Sample::fan(4, Split::Halves).data(), &REPLACE).unwrap();
    assert_eq!(old.verify().unwrap().faces, 3);
    assert_eq!(Tree::open(&path).unwrap().verify().unwrap().faces, 4);
    assert_eq!(names_in(folder.path()), ["out.fct"]);
}

#[test]
fn a_failure_leaves_the_old_file_and_no_temporary() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.fct");
    write(&path, &Sample::fan(3, Split::Halves).data(), &REPLACE).unwrap();
    let before = fs::read(&path).unwrap();
    let mut broken = Sample::fan(4, Split::Halves);
    broken.packed.nodes.pop();
    let error = write(&path, &broken.data(), &REPLACE).unwrap_err();
    assert_eq!(error.code(), "FC717");
    assert_eq!(fs::read(&path).unwrap(), before);
    assert_eq!(names_in(folder.path()), ["out.fct"]);
}

#[test]
fn a_writer_that_is_dropped_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let writer = Writer::create(&folder.path().join("out.fct"), false).unwrap();
    let [name] = names_in(folder.path()).try_into().unwrap();
    assert!(name.starts_with(".out.fct.") && name.ends_with(".fct-tmp"));
    drop(writer);
    assert!(names_in(folder.path()).is_empty());
}

#[test]
fn places_that_cannot_be_written_are_told_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    for path in [
        folder.path().to_owned(),
        folder.path().join("missing").join("out.fct"),
        folder.path().join(".."),
        "".into(),
    ] {
        let error = Writer::create(&path, true).unwrap_err();
        assert_eq!(error.exit_code(), 4, "{error}");
    }
    let error = Writer::create(&folder.path().join("missing").join("out.fct"), true).unwrap_err().to_string();
    assert!(error.contains("missing does not exist; make it first") && !error.contains("fct-tmp"), "{error}");
    fs::write(folder.path().join("file"), "").unwrap();
    let error = Writer::create(&folder.path().join("file").join("out.fct"), true).unwrap_err().to_string();
    assert!(error.contains("file is no folder"), "{error}");
}

#[test]
fn long_and_foreign_names_work() {
    let folder = tempfile::tempdir().unwrap();
    let sample = Sample::fan(2, Split::Halves);
    // 255 bytes, and a character that the shortened temporary name must not cut in half.
    for name in ["x".repeat(251) + ".fct", "ä".repeat(125) + "b.fct"] {
        let path = folder.path().join(&name);
        write(&path, &sample.data(), &REPLACE).unwrap();
        Tree::open(&path).unwrap();
    }
    assert_eq!(names_in(folder.path()).len(), 2);
}

#[cfg(unix)]
#[test]
fn names_need_not_be_unicode() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(OsStr::from_bytes(b"\xFF\xFE.fct"));
    write(&path, &Sample::fan(2, Split::Halves).data(), &REPLACE).unwrap();
    Tree::open(&path).unwrap();
}

#[cfg(unix)]
#[test]
fn a_published_file_is_readable_as_the_umask_says() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let plain = folder.path().join("plain");
    fs::write(&plain, "").unwrap();
    let path = folder.path().join("out.fct");
    write(&path, &Sample::fan(2, Split::Halves).data(), &REPLACE).unwrap();
    let mode = |p: &Path| fs::metadata(p).unwrap().permissions().mode();
    assert_eq!(mode(&path), mode(&plain));
}

#[cfg(unix)]
#[test]
fn a_symbolic_link_is_replaced_not_followed() {
    let folder = tempfile::tempdir().unwrap();
    let (real, link) = (folder.path().join("real"), folder.path().join("out.fct"));
    fs::write(&real, "mine").unwrap();
    std::os::unix::fs::symlink(&real, &link).unwrap();
    write(&link, &Sample::fan(2, Split::Halves).data(), &REPLACE).unwrap();
    assert_eq!(fs::read(&real).unwrap(), b"mine");
    assert!(!fs::symlink_metadata(&link).unwrap().is_symlink());
}

#[test]
fn what_a_killed_run_left_is_removed_and_what_a_live_one_holds_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.fct");
    let hour_ago = SystemTime::now() - Duration::from_secs(3600);
    let stale = folder.path().join(".out.fct.abc123.fct-tmp");
    let stranger = folder.path().join(".other.fct.abc123.fct-tmp");
    let forgotten = folder.path().join(".third.ply.abc123.fct-tmp");
    let mine = folder.path().join("notes.fct-tmp");
    let days_ago = hour_ago - Duration::from_secs(2 * 24 * 3600);
    for (leftover, age) in
        [(&stale, hour_ago), (&stranger, hour_ago), (&forgotten, days_ago), (&mine, days_ago)]
    {
        let file = fs::File::create(leftover).unwrap();
        file.set_modified(age).unwrap();
    }
    let live = Writer::create(&path, false).unwrap();
    assert!(!stale.exists() && !forgotten.exists());
    assert!(stranger.exists() && mine.exists());

    let held = names_in(folder.path());
    let held = held.iter().find(|n| n.starts_with(".out.fct.")).unwrap();
    let file = fs::File::options().write(true).open(folder.path().join(held)).unwrap();
    file.set_modified(hour_ago).unwrap();
    let second = Writer::create(&path, false).unwrap();
    assert!(folder.path().join(held).exists());
    drop(second);
    file.set_modified(days_ago).unwrap();
    drop(Writer::create(&folder.path().join("other.fct"), false).unwrap());
    assert!(folder.path().join(held).exists());
    live.finish(&Sample::fan(2, Split::Halves).data(), 0).unwrap();
}
