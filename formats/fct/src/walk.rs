//! Walking a tree that was not verified: every step checks what it hands out.
//!
//! Preorder and the counts of a binary tree fix where children stand: a subtree of k faces has k - 1 nodes, hence the
//! left child of node i is node i + 1 and the right one node i + k, with k the faces on the left. Within a page that
//! is all there is to a step. Above the pages a child is named, and must own the faces that follow. So a walk from the
//! root meets no cycle and no node twice.

use std::path::Path;

use zerocopy::little_endian::U32;

use crate::child::{Child, ChildRef};
use crate::error::{Error, Violation};
use crate::loops::{Loops, read_stored};
use crate::node::Node;
use crate::outline::{loops_do_not_end, stores_loops};
use crate::records::{
    FaceRecord, NodeRecord, PAGE_BIT, PageRecord, SMALL_FACES, STORES_LOOPS, TopRecord, VertexRecord,
};
use crate::rule::Rule;
use crate::subtree::{Place, Subtree};
use crate::tree::Tree;

/// The sections of a tree that a walk reads, for loops that take many steps.
#[derive(Clone, Copy, Debug)]
pub struct Reader<'a> {
    pub(crate) tops: &'a [TopRecord],
    pub(crate) top_loops: &'a [u8],
    /// The first corner of each top node's first face, where faces are not at hand; else empty.
    pub(crate) top_corners: &'a [U32],
    pub(crate) pages: &'a [PageRecord],
    pub(crate) nodes: &'a [NodeRecord],
    pub(crate) faces: &'a [FaceRecord],
    pub(crate) links: &'a [U32],
    pub(crate) loops: &'a [u8],
    pub(crate) vertices: &'a [VertexRecord],
    pub(crate) path: &'a Path,
}

/// A broken rule on the way, not boxed up with its file yet.
pub(crate) type Broken = Box<Violation>;

impl<'a> Reader<'a> {
    /// Vertices in order of first use by the faces.
    #[inline]
    pub fn vertices(&self) -> &'a [VertexRecord] {
        self.vertices
    }

    /// The whole tree.
    pub fn whole(&self) -> Subtree {
        // Opening refuses more faces than 2^31 / 3.
        let faces = u32::try_from(self.faces.len()).unwrap_or(u32::MAX);
        Subtree {
            child: if faces == 1 { ChildRef::face(0) } else { ChildRef::node(0) },
            first_face: 0,
            face_end: faces,
            place: if self.tops.is_empty() {
                Place::Page { page: 0, record: 0, loops: 0 }
            } else {
                Place::Top { record: 0 }
            },
        }
    }

    /// The node at the root of a subtree.
    ///
    /// # Errors
    /// [`Error::Invalid`] when there is no such node, or when the subtree is a single face.
    #[inline]
    pub fn node(&self, subtree: &Subtree) -> Result<Node, Error> {
        self.decode(subtree).map_err(|violation| violation.at(self.path))
    }

    #[inline]
    pub(crate) fn decode(&self, subtree: &Subtree) -> Result<Node, Broken> {
        match subtree.place {
            Place::Top { record } => Ok(Node::of_top(self.top(record)?)),
            Place::Page { page, record, .. } => {
                let (page, node) = self.page_node(page, record, subtree)?;
                Ok(Node::of_page(page, node))
            }
        }
    }

    /// The two children of a node, the left one first.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the children are not where preorder puts them, or when the subtree is a single face.
    #[inline]
    pub fn children(&self, subtree: &Subtree) -> Result<[Subtree; 2], Error> {
        self.split(subtree).map_err(|violation| violation.at(self.path))
    }

    #[inline]
    pub(crate) fn split(&self, subtree: &Subtree) -> Result<[Subtree; 2], Broken> {
        match subtree.place {
            Place::Top { record } => self.split_top(subtree, record),
            Place::Page { page, record, loops } => self.split_in_page(subtree, page, record, loops),
        }
    }

    #[inline]
    fn split_in_page(
        &self,
        subtree: &Subtree,
        page_index: u32,
        record: u32,
        loops: u32,
    ) -> Result<[Subtree; 2], Broken> {
        let (page, node) = self.page_node(page_index, record, subtree)?;
        let faces = subtree.face_count();
        let stores = stores_loops(node, faces);
        let left_faces =
            u32::from(if faces <= SMALL_FACES { node.left_faces & !STORES_LOOPS } else { node.left_faces });
        if left_faces == 0 || left_faces >= faces {
            return Err(wrong_split(left_faces, subtree));
        }
        let (mut left_loops, mut right_loops) = (loops, loops);
        if stores {
            let own = self.stored_loops(page, loops, subtree)?;
            let after = own.first_chunk::<2>().and_then(|skip| {
                let end = read_stored(own.get(2..)?, |_| {})?;
                Some((u16::from_le_bytes(*skip), u32::try_from(end).ok()?))
            });
            let Some((skip, end)) = after else {
                return Err(loops_do_not_end(subtree));
            };
            left_loops = loops.saturating_add(2).saturating_add(end);
            right_loops = left_loops.saturating_add(u32::from(skip));
        }
        let split = subtree.first_face.saturating_add(left_faces);
        let left = Subtree {
            child: child_of(subtree, 1, left_faces, subtree.first_face),
            first_face: subtree.first_face,
            face_end: split,
            place: Place::Page { page: page_index, record: record.saturating_add(1), loops: left_loops },
        };
        let right = Subtree {
            child: child_of(subtree, left_faces, faces.saturating_sub(left_faces), split),
            first_face: split,
            face_end: subtree.face_end,
            place: Place::Page {
                page: page_index,
                record: record.saturating_add(left_faces),
                loops: right_loops,
            },
        };
        Ok([left, right])
    }

    #[inline]
    fn split_top(&self, subtree: &Subtree, index: u32) -> Result<[Subtree; 2], Broken> {
        // What is sound is soon found.
        match self.halves_of_top(subtree, index) {
            Some(halves) => Ok(halves),
            None => self.split_top_closely(subtree, index),
        }
    }

    /// The same step by step, to say what is wrong.
    #[cold]
    fn split_top_closely(&self, subtree: &Subtree, index: u32) -> Result<[Subtree; 2], Broken> {
        let record = self.top(index)?;
        let [left, right] = [record.left.get(), record.right.get()];
        let (first, end) = (subtree.first_face, subtree.face_end);
        let split = self.first_face_of(right, subtree)?;
        if !(first < split && split < end) {
            return Err(Violation::new(
                Rule::FaceRange,
                subtree.to_string(),
                format!("its faces {first}..{end} are split at {split}"),
            ));
        }
        let left_faces = split.saturating_sub(first);
        let sides = [(left, first, split, 1), (right, split, end, left_faces)];
        let mut children = [*subtree; 2];
        for (slot, (child, first, end, node)) in children.iter_mut().zip(sides) {
            let faces = end.saturating_sub(first);
            // A page owns what it says; of a top node only the walk below can tell.
            let (place, owns) = if child & PAGE_BIT != 0 {
                let page = child & !PAGE_BIT;
                let owns = to_index(page).and_then(|p| self.pages.get(p)).map(|p| u32::from(p.faces));
                let record = first.saturating_sub(page);
                (Place::Page { page, record, loops: 0 }, owns)
            } else {
                (Place::Top { record: child }, (child > index && faces > 1).then_some(faces))
            };
            let starts_at = self.first_face_of(child, subtree)?;
            if starts_at != first || owns != Some(faces) {
                return Err(Violation::new(
                    Rule::ChildPlace,
                    subtree.to_string(),
                    format!(
                        "its child {} begins at face {starts_at}, expected one of the faces {first}..{end}",
                        name_of(child)
                    ),
                ));
            }
            *slot = Subtree {
                child: child_of(subtree, node, faces, first),
                first_face: first,
                face_end: end,
                place,
            };
        }
        Ok(children)
    }

    fn first_face_of(&self, child: u32, parent: &Subtree) -> Result<u32, Broken> {
        let found = if child & PAGE_BIT != 0 {
            to_index(child & !PAGE_BIT).and_then(|i| self.pages.get(i)).map(|p| p.first_face.get())
        } else {
            to_index(child).and_then(|i| self.tops.get(i)).map(|t| t.first_face.get())
        };
        found.ok_or_else(|| {
            Violation::new(
                Rule::ChildPlace,
                parent.to_string(),
                format!(
                    "its child is {}, and there are {} top nodes and {} pages",
                    name_of(child),
                    self.tops.len(),
                    self.pages.len()
                ),
            )
        })
    }

    pub(crate) fn top(&self, record: u32) -> Result<&'a TopRecord, Broken> {
        to_index(record).and_then(|i| self.tops.get(i)).ok_or_else(|| {
            Violation::new(
                Rule::ChildPlace,
                format!("top node {record}"),
                format!("there are {} of them", self.tops.len()),
            )
        })
    }

    /// A page that owns the faces of a subtree.
    #[inline]
    pub(crate) fn page_of(&self, page: u32, subtree: &Subtree) -> Result<&'a PageRecord, Broken> {
        let found = to_index(page).and_then(|i| self.pages.get(i)).filter(|p| {
            let first = p.first_face.get();
            first <= subtree.first_face && subtree.face_end <= first.saturating_add(u32::from(p.faces))
        });
        found.ok_or_else(|| not_owned(page, subtree))
    }

    /// The page and the record of a node within it.
    #[inline]
    pub(crate) fn page_node(
        &self,
        page_index: u32,
        record: u32,
        subtree: &Subtree,
    ) -> Result<(&'a PageRecord, &'a NodeRecord), Broken> {
        let page = self.page_of(page_index, subtree)?;
        let found = to_index(record).filter(|_| subtree.face_count() > 1).and_then(|i| self.nodes.get(i));
        match found {
            Some(node) => Ok((page, node)),
            None => Err(no_such_node(record, self.nodes.len(), subtree)),
        }
    }

    /// The subtree of a node or face by its name, found by walking down to it.
    ///
    /// # Errors
    /// [`Error::Invalid`] when there is none, or when the file is damaged on the way.
    pub fn find(&self, child: ChildRef) -> Result<Subtree, Error> {
        let mut at = self.whole();
        while at.child != child {
            let [left, right] = if at.face_count() > 1 {
                self.children(&at)?
            } else {
                let violation = Violation::new(
                    Rule::ChildPlace,
                    format!("{:?}", child.kind()),
                    "the tree does not have it".to_owned(),
                );
                return Err(violation.at(self.path));
            };
            let goes_right = match child.kind() {
                Child::Face(face) => face >= right.first_face,
                Child::Node(node) => match right.child.kind() {
                    Child::Node(first) => node >= first,
                    Child::Face(_) => false,
                },
            };
            at = if goes_right { right } else { left };
        }
        Ok(at)
    }
}

/// The name of a child that stands `nodes` places behind its parent.
#[inline]
fn child_of(parent: &Subtree, nodes: u32, faces: u32, first_face: u32) -> ChildRef {
    match parent.child.kind() {
        Child::Node(index) if faces > 1 => ChildRef::node(index.saturating_add(nodes)),
        _ => ChildRef::face(first_face),
    }
}

fn name_of(child: u32) -> String {
    if child & PAGE_BIT == 0 { format!("top node {child}") } else { format!("page {}", child & !PAGE_BIT) }
}

#[cold]
fn not_owned(page: u32, subtree: &Subtree) -> Broken {
    let found = format!("it does not own the faces {}..{}", subtree.first_face, subtree.face_end);
    Violation::new(Rule::ChildPlace, format!("section PAGE, page {page}"), found)
}

#[cold]
fn no_such_node(record: u32, nodes: usize, subtree: &Subtree) -> Broken {
    let found = format!("its record would be number {record} of {nodes} in section NODE");
    Violation::new(Rule::ChildPlace, subtree.to_string(), found)
}

#[cold]
fn wrong_split(left: u32, subtree: &Subtree) -> Broken {
    let found = format!("{left} of its {} faces are on the left", subtree.face_count());
    Violation::new(Rule::FaceRange, subtree.to_string(), found)
}

impl Tree {
    /// The whole tree.
    pub fn whole(&self) -> Subtree {
        self.reader().whole()
    }

    /// The node at the root of a subtree, see [`Reader::node`].
    ///
    /// # Errors
    /// As [`Reader::node`].
    pub fn node(&self, subtree: &Subtree) -> Result<Node, Error> {
        self.reader().node(subtree)
    }

    /// The two children of a node, see [`Reader::children`].
    ///
    /// # Errors
    /// As [`Reader::children`].
    pub fn children(&self, subtree: &Subtree) -> Result<[Subtree; 2], Error> {
        self.reader().children(subtree)
    }

    /// The boundary loops of a subtree's root, see [`Reader::read_loops`].
    ///
    /// # Errors
    /// As [`Reader::read_loops`].
    pub fn loops_of(&self, subtree: &Subtree) -> Result<Loops, Error> {
        let mut loops = Loops::default();
        self.reader().read_loops(subtree, &mut loops)?;
        Ok(loops)
    }

    /// The subtree of a node or face by its name, see [`Reader::find`].
    ///
    /// # Errors
    /// As [`Reader::find`].
    pub fn find(&self, child: ChildRef) -> Result<Subtree, Error> {
        self.reader().find(child)
    }

    /// The vertex indices of all faces, in tree order.
    ///
    /// # Errors
    /// [`Error::Invalid`] when pages do not own the faces one after the other, or use vertices that are not there.
    pub fn faces(&self) -> Result<Vec<[u32; 3]>, Error> {
        let reader = self.reader();
        let mut faces = Vec::new();
        for (page, record) in (0_u32..).zip(reader.pages) {
            let first = record.first_face.get();
            for face in first..first.saturating_add(u32::from(record.faces)) {
                let place = Place::Page { page, record: 0, loops: 0 };
                let child = ChildRef::face(face);
                let subtree = Subtree { child, first_face: face, face_end: face.saturating_add(1), place };
                faces.push(reader.face(&subtree)?);
            }
        }
        Ok(faces)
    }

    /// The bound and the budget key of every node, in no order that a walk would know.
    pub fn keys(&self) -> impl Iterator<Item = [f32; 2]> {
        let reader = self.reader();
        let tops = reader.tops.iter().map(|t| [t.bound.get(), t.budget.get()]);
        tops.chain(reader.nodes.iter().map(|n| [n.bound.get(), n.budget.get()]))
    }
}

/// A 32-bit index as one of memory; none on machines that small.
#[inline]
pub(crate) fn to_index(index: u32) -> Option<usize> {
    usize::try_from(index).ok()
}
