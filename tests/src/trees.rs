//! Trees built from soups, through the file format.

use fcbuild::import::{ImportOptions, Soup, import};
use fcbuild::{BuildOptions, SplitMode};
use fct::Tree;
use std::path::{Path, PathBuf};

/// Builds, writes and opens a tree; panics with the error, for tests.
pub fn tree_of(soup: Soup) -> Tree {
    tree_by(soup, SplitMode::Quality)
}

/// The same by another way to split.
pub fn tree_by(soup: Soup, split: SplitMode) -> Tree {
    Tree::from_bytes(bytes_of(soup, split)).unwrap_or_else(|e| panic!("{e}"))
}

/// The bytes of the file that a soup becomes.
pub fn bytes_of(soup: Soup, split: SplitMode) -> Vec<u8> {
    bytes_in_chunks(soup, split, fct::CHUNK_FACES)
}

/// The same with chunks of at most so many faces.
pub fn bytes_in_chunks(soup: Soup, split: SplitMode, chunk_faces: u32) -> Vec<u8> {
    bytes_with(soup, &BuildOptions { split, ..BuildOptions::default() }, chunk_faces)
}

/// A tree by options of one's own.
pub fn tree_with(soup: Soup, options: &BuildOptions<'_>) -> Tree {
    Tree::from_bytes(bytes_with(soup, options, fct::CHUNK_FACES)).unwrap_or_else(|e| panic!("{e}"))
}

fn bytes_with(soup: Soup, options: &BuildOptions<'_>, chunk_faces: u32) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap_or_else(|e| panic!("{e}"));
    let path = folder.path().join("tree.fct");
    let mut built = fcbuild::build(soup, options).unwrap_or_else(|e| panic!("{e}"));
    built.set_chunk_faces(chunk_faces).unwrap_or_else(|e| panic!("{e}"));
    fct::write(&path, &built.data(), &fct::WriteOptions { overwrite: true, source_id: 0 })
        .unwrap_or_else(|e| panic!("{e}"));
    std::fs::read(&path).unwrap_or_else(|e| panic!("{e}"))
}

/// Reads a mesh file; panics with the error, for tests.
pub fn read(path: &Path) -> Soup {
    import(path, &ImportOptions { max_faces: u64::MAX, progress: &|_, _| {} })
        .unwrap_or_else(|e| panic!("{e}"))
}

/// A file of the repository's `data` folder.
pub fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../data").join(name)
}

/// A scan in the folder that `FCT_DATA` names; panics if it is not there, and says how to get it.
pub fn scan(name: &str) -> Soup {
    let Some(folder) = std::env::var_os("FCT_DATA") else {
        panic!("set FCT_DATA to a folder that holds {name}, of the Stanford 3D Scanning Repository");
    };
    let path = PathBuf::from(folder).join(name);
    assert!(path.is_file(), "{} is missing; get it from the Stanford 3D Scanning Repository", path.display());
    read(&path)
}
