//! The binary tree of clusters, before anything is measured on it.

use super::SplitMode;
use glam::Vec3;

/// An interior node: how many faces go left, and the plane of the whole cluster.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Split {
    /// Faces of the left child; the rest of the node's faces belong to the right one.
    pub left_faces: u32,
    /// True above the roots of components: the node's faces are not connected, so it is never drawn.
    pub joins_components: bool,
    /// Mean square distance of the cluster from its plane, in square normal units (`[Tsuji07]` 4.1).
    pub epsilon: f32,
    /// Budget key, a length in normal units: nodes of larger keys are refined first. Not monotone yet.
    pub key: f32,
    /// Where the plane is: `normal . x` for its points, in normal units.
    pub offset: f32,
    /// Unit normal of the cluster's plane, on the side of the mean normal; zero if it has none.
    pub normal: Vec3,
}

impl Split {
    pub(super) const EMPTY: Split = Split {
        left_faces: 0,
        joins_components: false,
        epsilon: 0.0,
        key: 0.0,
        offset: 0.0,
        normal: Vec3::ZERO,
    };
}

/// A binary tree over faces whose nodes stand in preorder.
///
/// A node of `m` faces heads a run of `m - 1` nodes: itself, then its left child's run, then its right child's.
/// With `l` faces to the left, node `i` has its left child at `i + 1` (if `l > 1`) and its right child at `i + l`
/// (if `m - l > 1`); a child of one face is that face.
#[derive(Debug)]
pub struct Hierarchy {
    /// Interior nodes, one fewer than faces.
    pub splits: Vec<Split>,
    /// The mesh's face at each place of the tree's order.
    pub order: Vec<u32>,
    /// How it was made: as asked, or by [`SplitMode::Paper`] where merging made it too deep.
    pub mode: SplitMode,
    /// Length of the longest path from the root to a face, counted in edges.
    pub depth: u32,
}

/// Below this many nodes a subtree stays on one thread.
const SERIAL_BELOW: usize = 1 << 14;

/// The depth of a tree by its nodes.
pub(super) fn depth(splits: &[Split]) -> u32 {
    if splits.len() >= SERIAL_BELOW {
        // A subtree of n faces has n - 1 nodes.
        let (left, right) = splits[1..].split_at(splits[0].left_faces as usize - 1);
        let (left, right) = rayon::join(|| depth(left), || depth(right));
        return 1 + left.max(right);
    }
    let mut deepest = 0;
    let mut stack = vec![(0_usize, splits.len() + 1, 0_u32)];
    while let Some((node, faces, depth)) = stack.pop() {
        deepest = deepest.max(depth);
        if faces > 1 {
            let left = splits[node].left_faces as usize;
            stack.push((node + 1, left, depth + 1));
            stack.push((node + left, faces - left, depth + 1));
        }
    }
    deepest
}
