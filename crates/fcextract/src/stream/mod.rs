//! Meshes from files that are only partly in memory.
//!
//! The crown of a tree, see [`fct::ChunkFile`], is there, and so are the tops of some of its chunks and some of their
//! pages. [`extract_chunks`] draws what [`crate::extract`] draws, but for a chunk or page that is missing its root, and
//! says what was missing. Which vertices are drawn is decided alike by all: those that pass the test of activity and
//! whose record is in the crown, in the top of a chunk that the selection enters, or in a page that it enters. So a mesh
//! has no crack whatever is missing, and the same selection gives the same mesh whenever nothing is.
//!
//! [`ChunkCache`] keeps what was used last within a budget of bytes, and loads what is missing in the background, that
//! first whose error shows most.

mod cache;
mod draw;
mod found;
mod loader;
mod plan;
mod ready;
mod slots;

pub use cache::{CacheStats, ChunkCache};
pub use draw::{Damaged, Resident, Streamed, extract_chunks};
pub use plan::{Piece, Wish};
