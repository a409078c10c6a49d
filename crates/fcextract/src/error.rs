//! What can go wrong in an extraction.

/// Why no mesh was extracted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The file is damaged, or does not hold what its header says.
    #[error(transparent)]
    Tree(#[from] fct::Error),
    /// The selection has a number that it must not have: the text names it, says where it stands and what is allowed. Or it
    /// is for another tree, or cannot be taken into the space of a model.
    #[error("the selection cannot be used: {0}")]
    Selection(String),
    /// A cache cannot be had.
    #[error("the file cannot be read in parts: {0}")]
    Memory(String),
    /// The mesh would have more indices than 32 bits count.
    #[error("the selection needs more than {} triangles; ask for a coarser one", u32::MAX / 3)]
    TooManyTriangles,
}
