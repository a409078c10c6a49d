//! Walking a tree that was not verified: every step checks what it hands out.
//!
//! Preorder and the counts of a binary tree fix where children stand, so each step is checked on its own in constant time:
//! a subtree of k faces has k - 1 nodes, hence the left child of node i is node i + 1 and the right one node i + k,
//! with k the faces on the left. A walk from the root by [`Tree::children`] therefore meets no cycle and no node twice.

use zerocopy::little_endian::U32;

use crate::child::{Child, ChildRef};
use crate::error::{Error, Violation};
use crate::records::{LOOP_END, NodeRecord};
use crate::rule::Rule;
use crate::tree::Tree;

/// A child reference with the range of faces that it owns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Subtree {
    /// Its root.
    pub child: ChildRef,
    /// Its first face.
    pub first_face: u32,
    /// One past its last face.
    pub face_end: u32,
}

impl Subtree {
    /// The number of faces, at least 1.
    pub const fn face_count(&self) -> u32 {
        self.face_end.saturating_sub(self.first_face)
    }

    /// The subtree's part of an array with one element a face; empty if the array is too short.
    pub fn of<'a, T>(&self, per_face: &'a [T]) -> &'a [T] {
        match (to_index(self.first_face), to_index(self.face_end)) {
            (Some(start), Some(end)) => per_face.get(start..end).unwrap_or_default(),
            _ => &[],
        }
    }
}

impl Tree {
    /// The whole tree.
    pub fn whole(&self) -> Subtree {
        Subtree {
            child: self.root(),
            first_face: 0,
            // Opening refuses more faces than 2^31 / 3.
            face_end: u32::try_from(self.faces().len()).unwrap_or(u32::MAX),
        }
    }

    /// The record of a node.
    ///
    /// # Errors
    /// [`Error::Invalid`] when there is no such node.
    pub fn node(&self, index: u32) -> Result<&NodeRecord, Error> {
        to_index(index).and_then(|i| self.nodes().get(i)).ok_or_else(|| {
            let found = format!("there are {} nodes", self.nodes().len());
            Violation::new(Rule::ChildPlace, format!("node {index}"), found).at(self.path())
        })
    }

    /// The two children of node `index`, whose faces end before `face_end`; the left one first.
    ///
    /// Face ranges are not stored whole: the left child's ends where the right child's begins,
    /// and the right child's ends where the parent's does. So the caller hands the end down, from [`Tree::whole`].
    ///
    /// # Errors
    /// [`Error::Invalid`] when the node or its children are not where preorder puts them.
    pub fn children(&self, index: u32, face_end: u32) -> Result<[Subtree; 2], Error> {
        children_of(self.node(index)?, self.nodes(), index, face_end)
            .map_err(|violation| violation.at(self.path()))
    }

    /// The boundary loops of node `index`, none for a closed surface. The cluster lies on the left of each.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the loops leave section `LOOP`, the last does not end, or a vertex index is out of range.
    pub fn loops_of(&self, index: u32) -> Result<Loops<'_>, Error> {
        loops_of(self.node(index)?, self.loops(), self.vertices().len(), index)
            .map_err(|violation| violation.at(self.path()))
    }

    /// The vertex indices of a face, which are in range.
    ///
    /// # Errors
    /// [`Error::Invalid`] when there is no such face or it uses vertices that are not there.
    pub fn face(&self, index: u32) -> Result<[u32; 3], Error> {
        let faces = self.faces();
        let vertices = self.vertices().len();
        let broken =
            |rule, found| Violation::new(rule, format!("section FACE, face {index}"), found).at(self.path());
        let face = to_index(index)
            .and_then(|i| faces.get(i))
            .ok_or_else(|| broken(Rule::ChildPlace, format!("there are {} faces", faces.len())))?;
        let corners = face.indices();
        match corners.into_iter().find(|v| to_index(*v).is_none_or(|v| v >= vertices)) {
            None => Ok(corners),
            Some(v) => Err(broken(Rule::VertexIndex, format!("it uses vertex {v} of {vertices}"))),
        }
    }
}

/// Checks the children of a node against preorder and its range of faces.
pub(crate) fn children_of(
    node: &NodeRecord,
    nodes: &[NodeRecord],
    index: u32,
    face_end: u32,
) -> Result<[Subtree; 2], Box<Violation>> {
    let first_face = node.first_face.get();
    let [left, right] = [node.left, node.right].map(|c| ChildRef::from_raw(c.get()));
    let split = match right.kind() {
        Child::Face(face) => face,
        Child::Node(right) => {
            to_index(right).and_then(|i| nodes.get(i)).map(|n| n.first_face.get()).ok_or_else(|| {
                let found = format!("its right child is node {right} of {}", nodes.len());
                Violation::new(Rule::ChildPlace, node_place(index), found)
            })?
        }
    };
    if !(first_face < split && split < face_end) {
        return Err(Violation::new(
            Rule::FaceRange,
            node_place(index),
            format!("its faces {first_face}..{face_end} are split at {split}"),
        ));
    }
    let after_left = index.saturating_add(split.saturating_sub(first_face));
    let children = [(left, first_face, split, index.saturating_add(1)), (right, split, face_end, after_left)];
    for (child, first, end, node_here) in children {
        // A subtree of one face is the face itself; a larger one is the node that preorder puts here.
        let single = end.saturating_sub(first) == 1;
        let expected = if single { ChildRef::face(first) } else { ChildRef::node(node_here) };
        if child != expected {
            return Err(Violation::new(
                Rule::ChildPlace,
                node_place(index),
                format!(
                    "its child over the faces {first}..{end} is {:?}, expected {:?}",
                    child.kind(),
                    expected.kind()
                ),
            ));
        }
        let starts_at = match child.kind() {
            Child::Face(face) => Some(face),
            Child::Node(node) => to_index(node).and_then(|i| nodes.get(i)).map(|n| n.first_face.get()),
        };
        if starts_at != Some(first) {
            return Err(Violation::new(
                Rule::FaceRange,
                node_place(index),
                format!(
                    "its child {:?} should begin at face {first} and begins at {}",
                    child.kind(),
                    starts_at.map_or_else(|| "none".to_owned(), |s| s.to_string()),
                ),
            ));
        }
    }
    Ok(children.map(|(child, first_face, face_end, _)| Subtree { child, first_face, face_end }))
}

/// Checks the loops of a node: their place, their end, their vertices.
pub(crate) fn loops_of<'a>(
    node: &NodeRecord,
    loops: &'a [U32],
    vertices: usize,
    index: u32,
) -> Result<Loops<'a>, Box<Violation>> {
    let (start, len) = (node.loop_start.get(), node.loop_len.get());
    let entries = to_index(start)
        .zip(to_index(len))
        .and_then(|(start, len)| loops.get(start..start.checked_add(len)?))
        .ok_or_else(|| {
            let found = format!("{len} entries from {start} on, of {}", loops.len());
            Violation::new(Rule::LoopRange, node_place(index), found)
        })?;
    if entries.last().is_some_and(|e| e.get() & LOOP_END == 0) {
        return Err(Violation::new(
            Rule::LoopRange,
            node_place(index),
            "its last loop does not end".to_owned(),
        ));
    }
    let strange =
        entries.iter().map(|e| e.get() & !LOOP_END).find(|v| to_index(*v).is_none_or(|v| v >= vertices));
    match strange {
        None => Ok(Loops { entries }),
        Some(v) => Err(Violation::new(
            Rule::VertexIndex,
            node_place(index),
            format!("its loops use vertex {v} of {vertices}"),
        )),
    }
}

/// The boundary loops of a node.
#[derive(Clone, Debug)]
pub struct Loops<'a> {
    entries: &'a [U32],
}

impl<'a> Loops<'a> {
    /// The entries of section `LOOP` that are left, with the flag [`LOOP_END`] in the last of each loop.
    pub fn entries(&self) -> &'a [U32] {
        self.entries
    }
}

impl<'a> Iterator for Loops<'a> {
    type Item = BoundaryLoop<'a>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.entries.is_empty() {
            return None;
        }
        let last = self.entries.iter().position(|e| e.get() & LOOP_END != 0);
        let len = last.map_or(self.entries.len(), |i| i.saturating_add(1));
        let (entries, rest) = self.entries.split_at_checked(len)?;
        self.entries = rest;
        Some(BoundaryLoop { entries })
    }
}

/// One closed curve of vertices.
#[derive(Clone, Copy, Debug)]
pub struct BoundaryLoop<'a> {
    entries: &'a [U32],
}

impl<'a> BoundaryLoop<'a> {
    /// The vertex indices in order, without flags. An edge leads from the last to the first.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = u32> + DoubleEndedIterator + Clone + 'a {
        self.entries.iter().map(|e| e.get() & !LOOP_END)
    }

    /// The number of vertices, at least 1.
    #[allow(clippy::len_without_is_empty, reason = "a loop is never empty")]
    pub fn len(&self) -> usize {
        self.entries.len()
    }
}

/// A 32-bit index as one of memory; none on machines that small.
pub(crate) fn to_index(index: u32) -> Option<usize> {
    usize::try_from(index).ok()
}

/// How an error names a node: by index and by byte within its section.
pub(crate) fn node_place(index: u32) -> String {
    format!("section NODE, node {index} (byte {} of the section)", u64::from(index).saturating_mul(64))
}
