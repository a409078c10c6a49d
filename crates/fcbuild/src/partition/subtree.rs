//! A node with the faces below it: a step of a walk down the tree.

use super::Split;
use std::ops::Range;

/// A node and its faces; one of a single face is that face, and its number of a node means nothing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Subtree {
    /// Its place in preorder.
    pub node: usize,
    /// Places in the tree's order.
    pub faces: Range<usize>,
}

impl Subtree {
    /// The whole tree of so many faces.
    pub fn whole(faces: usize) -> Subtree {
        Subtree { node: 0, faces: 0..faces }
    }

    /// Whether it is a single face.
    pub fn is_face(&self) -> bool {
        self.faces.len() == 1
    }

    /// Both parts of one that is more than a face.
    pub fn children(&self, splits: &[Split]) -> [Subtree; 2] {
        let left = splits[self.node].left_faces as usize;
        let middle = self.faces.start + left;
        [
            Subtree { node: self.node + 1, faces: self.faces.start..middle },
            Subtree { node: self.node + left, faces: middle..self.faces.end },
        ]
    }

    /// The child that holds one of its faces.
    pub fn child_with(&self, face: usize, splits: &[Split]) -> Subtree {
        let [left, right] = self.children(splits);
        if left.faces.contains(&face) { left } else { right }
    }
}
