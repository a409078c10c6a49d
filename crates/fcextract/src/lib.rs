//! Chooses a cut of a face-cluster tree and stitches it into one crack-free triangle mesh.
//!
//! A *cut* (or front) is a set of nodes whose clusters cover the surface once. Each node of the cut is drawn as the
//! polygon of its active boundary vertices. Whether a vertex is active follows from its own record and the selection
//! alone, so two clusters that share a boundary see the same vertices on it and their polygons fit. Nothing looks at a
//! neighbour or at the last frame: a jump of the viewpoint costs nothing extra.
//!
//! This crate knows no GPU and no window. It reads [`fct::Tree`] and fills index lists:
//!
//! ```no_run
//! use fcextract::{Extraction, Order, Selection, Tolerance, extract};
//!
//! let tree = fct::Tree::open("dragon.fct")?;
//! let mut mesh = Extraction::default();
//! // No point of the surface is farther off than this, in the unit of the input.
//! extract(&tree, &Selection::uniform(0.001, Order::Bound), &mut mesh)?;
//! for triangle in mesh.indices.chunks_exact(3) {
//!     let corner = &tree.vertices()[triangle[0] as usize];
//!     // In single precision, beside the origin that coordinates of the input count from.
//!     println!("{:?} and {:?}", corner.position(), tree.meta().origin);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Paper
//! `[Tsuji07]` 5.1 and 5.2.

mod batch;
mod bound;
mod budget;
mod copies;
mod corners;
mod count;
mod criterion;
mod eager;
mod epsilon;
mod error;
mod extra;
mod extraction;
mod local_space;
mod mesh;
mod page;
mod parallel;
mod part;
mod region;
mod selection;
mod stitch;
mod stream;
mod tolerance;

pub use batch::Batch;
pub use budget::{Budget, Fitted, Fitter, Shown, fit};
pub use epsilon::by_epsilon;
pub use error::Error;
pub use extra::Extra;
pub use extraction::{Extraction, Stats, extract};
/// What a selection is culled by, and what that is made of.
pub use fcgeom::{Containment, Frustum, Plane, Sphere};
pub use mesh::Mesh;
pub use parallel::ParallelExtractor;
pub use part::{Part, Settled};
pub use region::Region;
pub use selection::{Order, Selection};
pub use stream::{CacheStats, ChunkCache, Damaged, Piece, Resident, Streamed, Wish, extract_chunks};
pub use tolerance::{Perspective, Tolerance};
