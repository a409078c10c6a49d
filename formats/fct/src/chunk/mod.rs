//! Parts of a tree that can be read alone, so that a file larger than the memory can be drawn.
//!
//! A *chunk* is a subtree of at most so many faces. All its records are runs of their sections, and what its pages'
//! links name outside it, its *kin*, is copied to section `KINS`: so a chunk is read without any other. The nodes above
//! the chunks and the roots of the chunks are the *crown*. They are copied to section `CRWN`, with their loops and with
//! the vertices that may be drawn when they are, and are small enough to stay in memory.
//!
//! [`ChunkData`] makes both sections, [`ChunkFile`] reads a file by them.

mod build;
mod crown;
mod file;
mod load;
mod patch;

pub use build::ChunkData;
pub(crate) use build::{Source, build};
pub use crown::{Crown, CrownChild};
pub use file::{ChunkFile, ReadAt};
pub use load::Chunk;
pub use patch::Patch;

use zerocopy::little_endian::{U32, U64};
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

use crate::records::TopRecord;

/// The most faces of a chunk that [`ChunkData::new`] makes.
///
/// More: fewer, longer reads, fewer copies, and a view reads more that it does not draw. Less: a larger crown.
/// At 4096 a chunk takes some 100 KB, the crown 1.7 % of the file, and crown and copies 2.2 bytes a face.
pub const CHUNK_FACES: u32 = 4096;

/// A vertex is in the crown if its bound or budget key is at least this part of that of a crown node on whose loops it
/// lies. Whatever is drawn in the right size shows no others, but where a view is much nearer to the vertex than to
/// the node.
pub(crate) const CROWN_SHARE: f32 = 0.5;

/// What section `CRWN` begins with. 32 bytes.
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

/// A chunk. 52 bytes. Each run but that of the top nodes' loops ends where that of the next chunk begins.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(C)]
pub(crate) struct ChunkRecord {
    /// XXH3-64 of its runs, one after the other in the order of their sections, `KINS` last.
    pub(crate) hash: U64,
    /// Its root: a [`crate::ChildRef`].
    pub(crate) root: U32,
    /// The first of its top nodes, of which it has one less than pages.
    pub(crate) top: U32,
    /// The first byte and the number of bytes of their loops.
    pub(crate) top_loop: U32,
    pub(crate) top_loop_bytes: U32,
    pub(crate) page: U32,
    pub(crate) face: U32,
    pub(crate) page_loop: U32,
    pub(crate) link: U32,
    pub(crate) vertex: U32,
    /// The first of its kin, counted through all chunks.
    pub(crate) kin: U32,
    pub(crate) reserved: U32,
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
const _: () = assert!(size_of::<ChunkRecord>() == 52);
const _: () = assert!(size_of::<CrownRecord>() == 72);
