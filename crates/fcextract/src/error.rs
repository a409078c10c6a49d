//! What can go wrong in an extraction.

/// Why no mesh was extracted.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file is damaged, or does not hold what its header says.
    #[error(transparent)]
    Tree(#[from] fct::Error),
    /// The selection has a number that is no number, or a direction of no length.
    #[error("the selection cannot be used: {0}")]
    Selection(&'static str),
    /// A cache cannot be had.
    #[error("the file cannot be read in parts: {0}")]
    Memory(String),
    /// The mesh would have more indices than 32 bits count.
    #[error("the selection needs more than {} triangles; ask for a coarser one", u32::MAX / 3)]
    TooManyTriangles,
}
