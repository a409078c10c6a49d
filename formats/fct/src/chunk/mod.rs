//! Parts of a tree that can be read alone, so that a file larger than the memory can be drawn.
//!
//! There are three storeys:
//!
//! - The *crown* are the nodes above the chunks and the roots of the chunks, copied to section `CRPG` with their loops
//!   and with the vertices that may be drawn when they are. It is small enough to stay in memory.
//! - A *chunk* is a subtree of at most so many faces. What is read of it first is its *top*: its top nodes and pages, and
//!   in section `CHTP` copies of its pages' roots and of the vertices that may be drawn with those and with its top nodes.
//! - A *page* is read if a view goes down into it: its nodes, faces and loops, its own vertices, and for its links the
//!   vertices of other pages, which are read without the rest of them.
//!
//! [`ChunkData`] makes both sections, [`ChunkFile`] reads a file by them.

mod build;
mod copies;
mod crown;
mod file;
mod load;
mod page;
mod patch;
mod runs;

pub use build::ChunkData;
pub(crate) use build::{Source, build};
pub use crown::{Crown, CrownChild};
pub use file::{ChunkFile, ReadAt};
pub use load::Chunk;
pub use page::{ChunkPage, OwnVertices, VertexRun};
pub use patch::Patch;

use zerocopy::little_endian::{U32, U64};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

use crate::records::{TopRecord, VertexRecord};

/// The most faces of a chunk that [`ChunkData::new`] makes.
///
/// More: fewer, longer reads, a smaller crown and file, and a view reads more tops of which it draws little.
/// At 8192 the top of a chunk takes some 20 KB, the crown 1 % of the file.
pub const CHUNK_FACES: u32 = 8192;

/// What section `CRPG` begins with. 32 bytes.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub(crate) struct CrownHead {
    /// The most faces of a chunk.
    pub(crate) chunk_faces: U32,
    pub(crate) chunks: U32,
    /// Nodes of the crown: one less than twice the chunks.
    pub(crate) nodes: U32,
    pub(crate) vertices: U32,
    /// Bytes of the loops, which end the section.
    pub(crate) loop_bytes: U32,
    pub(crate) reserved: [U32; 3],
}

/// A chunk. 36 bytes. Each run but those of the top nodes ends where that of the next chunk begins.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub(crate) struct ChunkRecord {
    /// XXH3-64 of its runs of `TOPN`, `TOPL`, `PAGE`, `LINK` and `CHTP`, one after the other.
    pub(crate) hash: U64,
    /// Its root: a [`crate::ChildRef`].
    pub(crate) root: U32,
    /// The first of its top nodes, of which it has one less than pages.
    pub(crate) top: U32,
    /// The first byte and the number of bytes of their loops.
    pub(crate) top_loop: U32,
    pub(crate) top_loop_bytes: U32,
    pub(crate) page: U32,
    pub(crate) link: U32,
    /// Its first byte of section `CHTP`.
    pub(crate) copies: U32,
}

/// What is known of every page while the file is open. 20 bytes.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub(crate) struct PageEntry {
    /// XXH3-64 of its runs of `NODE`, `FACE` and `LOOP`, one after the other.
    pub(crate) hash: U64,
    /// XXH3-64 of the runs of its own vertices in `VERT`, `NORM` and `COLR`, one after the other.
    pub(crate) vertex_hash: U64,
    /// As in its [`crate::PageRecord`].
    pub(crate) first_vertex: U32,
}

/// A node of the crown. 72 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned)]
#[repr(C)]
pub(crate) struct CrownRecord {
    /// As in section `TOPN`, but that children are nodes of the crown, or both name one chunk, with the top bit set; and
    /// that loops are those of the crown.
    pub(crate) top: TopRecord,
    /// The first corner of its first face, as an index into the vertices of the crown.
    pub(crate) corner: U32,
}

const _: () = assert!(size_of::<CrownHead>() == 32);
const _: () = assert!(size_of::<ChunkRecord>() == 36);
const _: () = assert!(size_of::<PageEntry>() == 20);
const _: () = assert!(size_of::<CrownRecord>() == 72);

/// Whether a vertex on the loops of a node is copied to where the node is drawn from: if either of its keys is at least
/// the node's. What is drawn in the right size shows no others, unless they are needed by a page that is read.
pub(crate) fn belongs(record: &VertexRecord, [bound, budget]: [f32; 2]) -> bool {
    record.bound() >= bound || record.budget() >= budget
}
