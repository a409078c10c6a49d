//! Meshes from files that are only partly in memory.
//!
//! The crown of a tree, see [`fct::ChunkFile`], is there, and so are some of its chunks. [`extract_chunks`] draws what
//! [`crate::extract`] draws, but for a chunk that is missing its root, and says what was missing. Which vertices are
//! drawn is decided alike by all: those that pass the test of activity and whose record is in the crown or in a chunk
//! that the selection enters. So a mesh has no crack whatever is missing, and the same selection gives the same mesh
//! whenever nothing is.
//!
//! [`ChunkCache`] keeps the chunks that were used last within a budget of bytes, and loads missing ones in the
//! background, those first whose error shows most.

mod cache;
mod draw;
mod loader;
mod slots;

pub use cache::{CacheStats, ChunkCache};
pub use draw::{Damaged, Streamed, Wish, extract_chunks};
