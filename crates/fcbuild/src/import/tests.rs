//! Promises that hold for the import of any format: what a path or a file's first bytes may be.

use std::fs;
use std::path::Path;

use super::testing::{read, refused};
use super::{ImportOptions, import};

const TRIANGLE: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

#[test]
fn the_content_tells_the_format_before_the_extension() {
    for name in ["scan.ply", "scan.obj", "scan", "scan.txt"] {
        assert_eq!(read(name, TRIANGLE.as_bytes()).unwrap().triangles, [[0, 1, 2]], "{name}");
    }
}

#[test]
fn strangers_are_named() {
    let cases: [(&str, &[u8], &str); 6] = [
        ("model.fct", b"\x8fFCT\r\n\x1a\n", "fct info"),
        ("model.ply", b"\x8fFCT\r\n\x1a\n", "face-cluster tree"),
        ("scan.ply", b"\x1f\x8b\x08\0", "gzip"),
        ("model.3mf", b"PK\x03\x04", "zip"),
        ("model.xyz", b"hello", "\"hello\""),
        ("notes.ply", b"hello", "\"hello\""),
    ];
    for (name, bytes, part) in cases {
        let e = refused(name, name, bytes, "FC201", part);
        assert_eq!(e.exit_code(), 3);
    }
    for name in ["a.ply", "a.obj", "a.stl", "a.gltf", "a.glb", "a"] {
        refused(name, name, b"", "FC200", "empty");
    }
}

#[test]
fn paths_that_are_no_files_are_input_and_output_errors() {
    let options = ImportOptions { max_faces: 10, progress: &|_, _| {} };
    let dir = tempfile::tempdir().unwrap();
    let missing = dir.path().join("missing.ply");
    let mut cases = vec![(dir.path(), "FC402", "directory"), (&missing, "FC401", "missing.ply")];
    if cfg!(unix) {
        cases.push((Path::new("/dev/zero"), "FC402", "no regular file"));
    }
    for (path, code, part) in cases {
        let e = import(path, &options).unwrap_err();
        assert_eq!((e.code(), e.exit_code()), (code, 4));
        assert!(e.to_string().contains(part), "{e}");
    }
}

#[test]
fn a_file_is_read_from_disk_with_progress_to_the_end() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("t.ply");
    fs::write(&path, TRIANGLE).unwrap();
    let last = std::sync::Mutex::new((0, 0));
    let soup = import(
        &path,
        &ImportOptions { max_faces: 10, progress: &|done, total| *last.lock().unwrap() = (done, total) },
    );
    assert_eq!(soup.unwrap().groups[0].name, "t");
    assert_eq!(*last.lock().unwrap(), (TRIANGLE.len() as u64, TRIANGLE.len() as u64));
}
