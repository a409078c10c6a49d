//! Runs the commands as the user runs them. They must have been built: they lie beside the tests.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// Where a command lies: `target/<profile>/NAME`, two folders above this test.
pub fn binary(name: &str) -> PathBuf {
    let mut path = std::env::current_exe().expect("this test has a path");
    path.pop();
    path.pop();
    path.push(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    assert!(path.is_file(), "{} is missing: run `cargo build --release --workspace` first", path.display());
    path
}

/// A sample mesh of this project.
pub fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../data").join(name)
}

/// What a command said, and how it ended.
pub struct Said {
    /// The exit code; -1 if a signal has ended it.
    pub exit: i32,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

/// Runs a command in `folder`; the words of `line` are its arguments.
pub fn run(folder: &Path, line: &str) -> Said {
    let mut words = line.split_whitespace();
    let name = words.next().expect("a command");
    let Output { status, stdout, stderr } =
        Command::new(binary(name)).args(words).current_dir(folder).output().expect("the command starts");
    let text = |bytes| String::from_utf8(bytes).expect("messages are UTF-8");
    let said = Said { exit: status.code().unwrap_or(-1), out: text(stdout), err: text(stderr) };
    assert!(!said.err.contains("panicked"), "{line}: {}", said.err);
    said
}

/// What is in a folder, in order.
pub fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder)
        .expect("the folder can be read")
        .map(|entry| entry.expect("the entry can be read").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

/// Runs a command that must fail with `exit` and a single line that holds all `fragments`, and change no file.
pub fn refuse(folder: &Path, line: &str, exit: i32, fragments: &[&str]) {
    let before = names(folder);
    let said = run(folder, line);
    assert_eq!(said.exit, exit, "{line}: {}", said.err);
    for fragment in fragments {
        assert!(said.err.contains(fragment), "{line}: no `{fragment}` in: {}", said.err);
    }
    if exit != 2 || said.err.contains("error[") {
        assert_eq!(said.err.lines().count(), 1, "{line} says it once: {}", said.err);
        assert!(said.err.starts_with("error[FC"), "{line}: {}", said.err);
    }
    assert!(said.out.is_empty(), "{line}: {}", said.out);
    assert_eq!(names(folder), before, "{line} leaves nothing behind");
}

/// Runs a command that must succeed.
pub fn accept(folder: &Path, line: &str) -> Said {
    let said = run(folder, line);
    assert_eq!(said.exit, 0, "{line}: {}", said.err);
    said
}

/// An ASCII PLY file of these lines.
pub fn ply(vertices: &[&str], faces: &[&str]) -> String {
    let xyz = "property float x\nproperty float y\nproperty float z";
    let (n, m) = (vertices.len(), faces.len());
    let list = "property list uchar int vertex_indices";
    let body = [vertices, faces].concat().join("\n");
    format!(
        "ply\nformat ascii 1.0\nelement vertex {n}\n{xyz}\nelement face {m}\n{list}\nend_header\n{body}\n"
    )
}

const SQUARE: [&str; 4] = ["0 0 0", "1 0 0", "1 1 0", "0 1 0"];

/// A folder with a good mesh `good.ply`, its tree `good.fct`, and many bad inputs.
pub fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).expect("writable");
    let good = ply(&SQUARE, &["3 0 1 2", "3 0 2 3"]);
    write("good.ply", good.as_bytes());
    write("empty.ply", b"");
    write("empty", b"");
    write("cut.ply", &good.as_bytes()[..good.len() - 6]);
    write("nan.ply", ply(&["0 0 0", "1 0 0", "1 1 0", "nan 1 0"], &["3 0 1 2", "3 0 2 3"]).as_bytes());
    write("allnan.ply", ply(&["0 0 0", "nan 0 0", "1 1 0"], &["3 0 1 2"]).as_bytes());
    write("index.ply", ply(&SQUARE, &["3 0 1 2", "3 0 2 90000"]).as_bytes());
    write("points.ply", ply(&SQUARE, &[]).as_bytes());
    write("quad.ply", ply(&SQUARE, &["4 0 1 2 3"]).as_bytes());
    write("triangle.ply", ply(&SQUARE[..3], &["3 0 1 2"]).as_bytes());
    write("sliver.ply", ply(&SQUARE, &["3 0 1 1"]).as_bytes());
    // Thirty points of a parabola: a convex polygon.
    let ring: Vec<String> = (0..30).map(|i| format!("{} {} 0", i * i, 60 * i)).collect();
    let ring: Vec<&str> = ring.iter().map(String::as_str).collect();
    let corners: Vec<String> = (0..30).map(|i| i.to_string()).collect();
    write("polygon.ply", ply(&ring, &[&format!("30 {}", corners.join(" "))]).as_bytes());
    write("notes.txt", b"dear diary");
    fs::create_dir(folder.path().join("dir")).expect("writable");
    accept(folder.path(), "fcbuild good.ply -o good.fct");
    folder
}

/// What `fct info --json` says of a tree.
pub fn info(folder: &Path, file: &str) -> serde_json::Value {
    let said = accept(folder, &format!("fct info {file} --json"));
    serde_json::from_str(&said.out).expect("JSON")
}

/// The number of faces that the header of a PLY file declares.
pub fn face_count(path: &Path) -> u64 {
    let bytes = fs::read(path).expect("readable");
    let header = String::from_utf8_lossy(&bytes[..bytes.len().min(2000)]).into_owned();
    let line = header.lines().find_map(|l| l.strip_prefix("element face ")).expect("faces are declared");
    line.parse().expect("a number")
}
