//! Runs of triangles worth a question to the depth buffer.

use fct::Subtree;

/// Subtrees of at most this many triangles become one batch: small enough to be hidden as a whole; who asks for fewer
/// occlusion queries joins them further along the tree.
pub(crate) const BATCH_TRIANGLES: u32 = 64;

/// A run of an extraction's triangles that comes from one subtree.
///
/// The batches of an extraction are disjoint, in order, and cover all its indices.
#[derive(Clone, Copy, Debug)]
pub struct Batch {
    /// The subtree.
    pub subtree: Subtree,
    /// Where the run starts in [`Extraction::indices`](crate::Extraction::indices).
    pub first_index: u32,
    /// Its length, three a triangle.
    pub index_count: u32,
}

impl Batch {
    /// The same run, so many indices further on.
    pub(crate) fn moved(&self, by: u32) -> Batch {
        Batch { first_index: self.first_index + by, ..*self }
    }
}
