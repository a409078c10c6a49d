//! glTF 2.0 and GLB: the `gltf` crate reads the JSON, everything after that is ours.
//!
//! That crate trusts offsets, counts and the node graph; here each is checked before it is used, and
//! an error names its place as a path into the JSON document.

mod accessor;
mod attributes;
mod buffers;
mod framing;
mod json;
mod mesh;
mod nodes;
mod transform;

use buffers::Buffers;

use super::soup::Soup;
use super::source::Source;
use super::tally::Tally;
use crate::error::Error;

/// Reads a scene from JSON text whose buffers are in it or beside it.
pub(super) fn read_gltf(source: &mut Source<'_>) -> Result<Soup, Error> {
    json::check_size(source.size())?;
    let text = source.all_bytes(json::MAX_SIZE)?;
    let root = json::parse(&text, 0)?;
    let buffers = Buffers::new(&root, source.path(), None);
    mesh::assemble(&root, &buffers, source, Tally::default())
}

/// Reads a scene from the binary container.
pub(super) fn read_glb(source: &mut Source<'_>) -> Result<Soup, Error> {
    let mut tally = Tally::default();
    let bytes = source.all_bytes(u64::MAX)?;
    let chunks = framing::split(&bytes, &mut tally)?;
    json::check_size(chunks.json.len() as u64)?;
    let root = json::parse(chunks.json, chunks.json_byte)?;
    let buffers = Buffers::new(&root, source.path(), chunks.binary);
    mesh::assemble(&root, &buffers, source, tally)
}

#[cfg(test)]
mod tests;
