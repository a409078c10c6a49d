//! The `.fct` file: a binary tree of face clusters, written once and used in place.
//!
//! `SPEC.md` beside this crate is the contract of the format; this crate is its implementation:
//!
//! - [`Writer`] (or [`write()`]) makes a file out of [`TreeData`], all or nothing; [`Packed`] makes its clusters out of plain ones.
//! - [`Tree::open`] maps a file and checks its container in constant time.
//! - [`ChunkFile::open`] reads a file in parts instead, for those larger than the memory.
//! - [`Tree::verify`] checks everything else: hashes, structure, values, geometry.
//!
//! A file is not to be trusted: its hashes find damage, not malice.
//! Code that reads a [`Tree`] without verifying it first walks down with [`Tree::whole`] and [`Tree::children`]
//! and reads faces and boundaries with [`Reader::face`] and [`Reader::read_loops`], which check whatever they hand out.
//!
//! All lengths are in the unit of the input mesh; coordinates are right-handed.
//!
//! # Invariants
//! - No panic and no unbounded recursion or allocation on any bytes.
//! - The only `unsafe` is the map itself, in `map.rs`.
//! - A published file is never edited, only replaced by rename.
#![cfg_attr(
    not(test),
    deny(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::unreachable,
        clippy::indexing_slicing,
        clippy::arithmetic_side_effects,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss
    )
)]

mod child;
mod chunk;
mod container;
mod displacement;
mod error;
mod halves;
mod hash;
mod header;
#[cfg(feature = "command")]
pub mod heap;
#[cfg(feature = "command")]
mod interrupt;
mod loops;
mod map;
#[cfg(feature = "command")]
mod message;
mod meta;
mod node;
mod octahedral;
mod outline;
mod pack;
mod page;
mod plane;
#[cfg(feature = "command")]
mod progress;
mod publish;
mod records;
mod rule;
mod section;
mod short_float;
#[cfg(feature = "command")]
mod size;
mod small_loops;
mod subtree;
mod tree;
mod verify;
mod walk;
#[cfg(feature = "command")]
mod words;
mod writer;

pub use child::{Child, ChildRef};
pub use chunk::{
    CHUNK_FACES, Chunk, ChunkData, ChunkFile, ChunkPage, Crown, CrownChild, OwnVertices, Patch, ReadAt,
    VertexRun,
};
pub use displacement::Displacement;
pub use error::{Error, Violation};
pub use header::{ENDIAN_TAG, HEADER_LEN, Header, MAGIC, MAJOR, MINOR};
#[cfg(feature = "command")]
pub use interrupt::{Interrupt, Stopped, end_with};
pub use loops::Loops;
#[cfg(feature = "command")]
pub use message::{MessageFormat, tell, usage_sentence};
pub use meta::{MAX_META_LEN, Meta};
pub use node::{BoundingPolygon, ConeFrame, Node};
pub use octahedral::{FineNormalRecord, NormalRecord};
pub use pack::{ClusterData, Clusters, Decoded, PackError, Packed, PageRun, PlainClusters, Plan};
pub use page::{Branch, Page};
pub use plane::{PlaneFrame, PlaneRecord};
#[cfg(feature = "command")]
pub use progress::{Progress, ProgressForm, ShowProgress, Stage};
pub use publish::Pending;
pub use records::{
    BoundingPolygonRecord, FaceRecord, GroupRecord, LOOP_END, MAX_DEPTH, MAX_FACES, MAX_PAGE_FACES,
    MAX_PAGE_VERTICES, NodeRecord, PageRecord, SMALL_FACES, TopRecord, VertexRecord, WeldRecord, pack,
    unpack,
};
pub use rule::Rule;
pub use section::{MAX_SECTIONS, SectionInfo, Tag};
pub use short_float::ShortFloat;
#[cfg(feature = "command")]
pub use size::Size;
pub use subtree::Subtree;
pub use tree::Tree;
pub use verify::Verified;
pub use walk::Reader;
#[cfg(feature = "command")]
pub use words::{counted, grouped};
pub use writer::{Complete, TreeData, WriteOptions, Writer, Written, write};
pub use zerocopy::little_endian::{F32, I16, U16, U32};
