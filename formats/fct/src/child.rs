//! A reference to a child: an interior node or a single face.

/// What a [`ChildRef`] stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Child {
    /// The index of an interior node in section `NODE`.
    Node(u32),
    /// The index of a face in section `FACE`: a leaf of the tree.
    Face(u32),
}

/// A 32-bit reference to a node or, when the top bit is set, to a face.
///
/// A mesh of F faces has F leaves, more than half of all references, so a leaf is told by a bit and needs no record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ChildRef(u32);

impl ChildRef {
    /// The bit that says "this child is a face".
    pub const FACE_BIT: u32 = 1 << 31;

    /// The reference as it stands in the file. Every value is a reference; whether it is in range is for the reader to check.
    pub const fn from_raw(raw: u32) -> Self {
        Self(raw)
    }

    /// The value as it stands in the file.
    pub const fn raw(self) -> u32 {
        self.0
    }

    /// A reference to node `index`, which must be below 2^31: the top bit is dropped.
    pub const fn node(index: u32) -> Self {
        Self(index & !Self::FACE_BIT)
    }

    /// A reference to face `index`, which must be below 2^31.
    pub const fn face(index: u32) -> Self {
        Self(index | Self::FACE_BIT)
    }

    /// What the reference stands for.
    pub const fn kind(self) -> Child {
        if self.0 & Self::FACE_BIT == 0 { Child::Node(self.0) } else { Child::Face(self.0 & !Self::FACE_BIT) }
    }
}

#[cfg(test)]
mod tests {
    use super::{Child, ChildRef};

    #[test]
    fn references_keep_kind_and_index() {
        for index in [0, 1, 77, (1 << 31) - 1] {
            assert_eq!(ChildRef::node(index).kind(), Child::Node(index));
            assert_eq!(ChildRef::face(index).kind(), Child::Face(index));
            let raw = ChildRef::face(index).raw();
            assert_eq!(ChildRef::from_raw(raw), ChildRef::face(index));
        }
    }
}
