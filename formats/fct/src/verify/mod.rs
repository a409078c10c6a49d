//! The complete check of a file: what opening leaves out.
//!
//! Bytes first, so that damage is called damage; then the records that stand alone; then one walk from the root,
//! in which nodes, faces, loops, bounding polygons and groups are all met in file order.
//! The checks use arithmetic of their own, not the builder's, so that both must be wrong for a mistake to pass.

mod activity;
mod attached;
mod boundary;
mod bytes;
mod chunks;
mod cones;
mod descent;
mod pages;
mod polygons;
mod spheres;
mod values;
mod vector;

use crate::error::Error;
use crate::tree::Tree;

/// What was found in a file that keeps every rule.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Verified {
    /// Bytes of the file.
    pub bytes: u64,
    /// Interior nodes.
    pub nodes: u64,
    /// Faces.
    pub faces: u64,
    /// Vertices.
    pub vertices: u64,
    /// Entries in the boundary loops of all nodes, stored or not.
    pub loop_entries: u64,
    /// Child references on the longest way from the root to a face.
    pub depth: u32,
    /// XXH3-128 of all sections.
    pub content_id: u128,
}

/// Hashes, padding and vertices: what damage changes, and what a walk does not look at.
pub(crate) fn check_bytes(tree: &Tree) -> Result<(), Error> {
    let check = || {
        bytes::check(tree)?;
        values::check_vertices(tree.vertices())
    };
    check().map_err(|v| v.at(tree.path()))
}

/// Checks every rule; `done` is told how many faces the walk has met.
pub(crate) fn verify(tree: &Tree, done: &mut dyn FnMut(u64)) -> Result<Verified, Error> {
    let path = tree.path();
    check_bytes(tree)?;
    attached::check_weld(tree).map_err(|v| v.at(path))?;
    let reader = tree.reader();
    pages::check(&reader).map_err(|v| v.at(path))?;
    let found = descent::check(tree, &reader, done).map_err(|v| v.at(path))?;
    attached::check_meta(tree, &found).map_err(|v| v.at(path))?;
    chunks::check(tree).map_err(|v| v.at(path))?;
    let header = tree.header();
    Ok(Verified {
        bytes: header.file_len,
        nodes: header.node_count,
        faces: header.face_count,
        vertices: header.vertex_count,
        loop_entries: found.loop_entries,
        depth: found.depth,
        content_id: header.content_id,
    })
}
