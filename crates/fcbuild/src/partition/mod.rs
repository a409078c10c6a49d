//! From components of faces to one binary tree of clusters: merged from the faces up (`merge`), or cut from the top.
//!
//! # Paper
//! `[Tsuji07]` 4.1 and 4.2: a cluster is cut by a plane through its centroid, perpendicular to the principal vector
//! of the position covariance (PCA) or of the canonical correlation of normals with positions (CCA); two clusters
//! grow from the faces farthest to either side, and of the two cuts the one with the smaller summed error is kept.
//! That is [`SplitMode::Paper`]; what the default does is written in `merge`.
//!
//! # Deviations
//! A cut so lopsided that the tree could pass [`DEPTH_LIMIT`] is replaced by the most even cut of a spanning tree.
//! Several components are joined by virtual nodes above their roots.

mod balance;
mod cluster;
mod growth;
mod hierarchy;
mod merge;
mod side;
mod subtree;
mod top;

pub use hierarchy::{Hierarchy, Split};
pub use subtree::Subtree;

use crate::colors::Weights;
use crate::mesh::{Components, Mesh};

/// How a cluster is cut in two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SplitMode {
    /// Neighbours merged where that costs least for each triangle saved: the best meshes.
    Quality,
    /// The better of the two cuts below, as `[Tsuji07]` does.
    Paper,
    /// Across the principal component of the positions (eq. 8).
    Pca,
    /// Across the principal canonical correlation of normals with positions (eq. 15).
    Cca,
    /// Neighbours merged by flatness, orientation and shape, after Garland: what `[TsujiJa]` compares with.
    Merge,
}

impl SplitMode {
    /// The name on the command line and in the file.
    pub fn as_str(self) -> &'static str {
        match self {
            SplitMode::Quality => "quality",
            SplitMode::Merge => "merge",
            SplitMode::Paper => "paper",
            SplitMode::Pca => "pca",
            SplitMode::Cca => "cca",
        }
    }
}

/// No path from the root to a face is longer; what reads the tree recurses without fear.
pub const DEPTH_LIMIT: u32 = 90;

/// Splits the faces of `mesh` until every cluster is a single face.
///
/// `colors` tells merging what they count. `progress` is told of faces that have reached their place in the tree, in any order and from any thread.
pub fn partition(
    mesh: &Mesh,
    components: &Components,
    mode: SplitMode,
    colors: Option<Weights>,
    progress: &(dyn Fn(u64) + Sync),
) -> Hierarchy {
    let rule = match mode {
        SplitMode::Quality => Some(merge::Rule::Quality),
        SplitMode::Merge => Some(merge::Rule::Garland),
        SplitMode::Paper | SplitMode::Pca | SplitMode::Cca => None,
    };
    let merged = rule.and_then(|rule| merge::merge_all(mesh, components, rule, colors, progress));
    // What merges into a tree too deep is split from the top, where depth can be held.
    merged.unwrap_or_else(|| {
        let mode = if rule.is_some() { SplitMode::Paper } else { mode };
        top::join_components(mesh, components, mode, progress)
    })
}
