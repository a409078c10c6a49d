//! A part of the tree: a node or a face, with what it owns.

use crate::child::{Child, ChildRef};
use crate::walk::to_index;

/// A node or a face with the range of faces that it owns, and where it stands in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Subtree {
    /// Its root: a node by its index in preorder, or a face.
    pub child: ChildRef,
    /// Its first face.
    pub first_face: u32,
    /// One past its last face.
    pub face_end: u32,
    pub(crate) place: Place,
}

/// Where the record of a subtree's root stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Place {
    /// In section `TOPN`.
    Top { record: u32 },
    /// In a page, whose node stands in section `NODE`, with its loops from this byte of the page's on.
    Page { page: u32, record: u32, loops: u32 },
}

impl Default for Subtree {
    /// The first face.
    fn default() -> Self {
        let place = Place::Page { page: 0, record: 0, loops: 0 };
        Self { child: ChildRef::face(0), first_face: 0, face_end: 1, place }
    }
}

impl Subtree {
    /// The number of faces, at least 1.
    #[inline]
    pub const fn face_count(&self) -> u32 {
        self.face_end.saturating_sub(self.first_face)
    }

    /// The number of its root's record among the nodes above the pages, if that is where it stands.
    #[inline]
    pub const fn top(&self) -> Option<u32> {
        match self.place {
            Place::Top { record } => Some(record),
            Place::Page { .. } => None,
        }
    }

    /// The subtree's part of an array with one element a face; empty if the array is too short.
    pub fn of<'a, T>(&self, per_face: &'a [T]) -> &'a [T] {
        match (to_index(self.first_face), to_index(self.face_end)) {
            (Some(start), Some(end)) => per_face.get(start..end).unwrap_or_default(),
            _ => &[],
        }
    }
}

impl std::fmt::Display for Subtree {
    /// How an error names a subtree: by its index, and by where its record stands.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.child.kind(), self.place) {
            (Child::Face(face), _) => write!(f, "section FACE, face {face}"),
            (Child::Node(node), Place::Top { record }) => {
                write!(f, "node {node} (section TOPN, record {record})")
            }
            (Child::Node(node), Place::Page { page, record, .. }) => {
                write!(f, "node {node} (section NODE, record {record}, page {page})")
            }
        }
    }
}
