//! Promise: an error says what is wrong, where, and what to do.

mod sample;

use std::fs;

use fct::{Error, Tree};
use sample::{Sample, Split};

fn message_for(bytes: &[u8]) -> (Error, String) {
    let error = Tree::from_bytes(bytes.to_vec()).unwrap_err();
    let text = error.to_string();
    (error, text)
}

#[test]
fn other_kinds_of_files_are_told_by_name() {
    let files: [(&[u8], &str); 9] = [
        (b"ply\nformat ascii 1.0\n", "build a tree of it first"),
        (b"ply", "build a tree of it first"),
        (b"glTF\x02\0\0\0", "GLB"),
        (b"solid cube\n", "STL"),
        (b"\x1F\x8B\x08\0", "unpack it first"),
        (b"\x8FFCT\n\x1A\n", "binary mode"),
        (b"\x0FFCT\r\n\x1A\n", "binary mode"),
        (b"v 0 0 0\n", "this is no .fct file: it starts with the text \"v 0 0 0\\n\""),
        (
            b"\x7FELF\x02\x01\x01\0\0",
            "this is no .fct file: it starts with the bytes 7F 45 4C 46 02 01 01 00",
        ),
    ];
    for (bytes, fragment) in files {
        let (error, text) = message_for(bytes);
        assert_eq!((error.code(), error.exit_code()), ("FC701", 7), "{text}");
        assert!(text.contains(fragment), "{text}");
        assert!(text.matches("fcbuild MESH").count() <= 1, "the remedy is given once: {text}");
    }
}

#[test]
fn an_empty_file_is_too_short() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("empty.fct");
    fs::write(&path, "").unwrap();
    let error = Tree::open(&path).unwrap_err();
    assert_eq!((error.code(), error.exit_code()), ("FC702", 7));
    assert!(error.to_string().contains("empty.fct: byte 0"), "{error}");
}

#[test]
fn what_is_no_file_is_an_error_of_the_system() {
    let folder = tempfile::tempdir().unwrap();
    let directory = Tree::open(folder.path()).unwrap_err();
    assert_eq!((directory.code(), directory.exit_code()), ("FC473", 4));
    let missing = Tree::open(folder.path().join("none.fct")).unwrap_err();
    assert_eq!((missing.code(), missing.exit_code()), ("FC471", 4));
    assert!(missing.to_string().contains("none.fct"), "{missing}");
}

#[cfg(unix)]
#[test]
fn a_device_is_refused_without_reading_it() {
    let error = Tree::open("/dev/zero").unwrap_err();
    assert_eq!(error.exit_code(), 4);
}

#[test]
fn versions_and_byte_order_say_what_was_found_and_what_is_read() {
    let mut bytes = Sample::fan(2, Split::Halves).bytes();
    bytes[8] = 9;
    let (error, text) = message_for(&bytes);
    assert_eq!(error.code(), "FC704");
    assert!(text.contains("version 9.3") && text.contains("reads 1.0"), "{text}");
    bytes[8] = 0;
    bytes[10] = 1;
    let (error, text) = message_for(&bytes);
    assert_eq!(error.code(), "FC704");
    assert!(text.contains("version 0.1") && text.contains("build it again from its mesh"), "{text}");
    bytes[8] = 1;
    bytes[12..16].reverse();
    let (error, text) = message_for(&bytes);
    assert_eq!(error.code(), "FC703");
    assert!(text.contains("big-endian"), "{text}");
}

#[test]
fn a_message_names_file_place_finding_rule_and_remedy() {
    let mut bytes = Sample::fan(2, Split::Halves).bytes();
    bytes.pop();
    let len = bytes.len();
    let (_, text) = message_for(&bytes);
    assert_eq!(
        text,
        format!(
            "<memory>: header byte 16: it announces {} bytes and the file has {len} \
             (rule file-length: the length in the header equals the length of the file); \
             the file is truncated or has bytes appended: copy it again or rebuild it with fcbuild",
            len + 1
        )
    );
}
