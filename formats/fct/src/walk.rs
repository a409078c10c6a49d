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
use crate::loops::{Loops, follow_faces, read_stored, read_top};
use crate::node::Node;
use crate::records::{
    FaceRecord, NodeRecord, PAGE_BIT, PageRecord, SMALL_FACES, STORES_LOOPS, TopRecord, VertexRecord,
};
use crate::rule::Rule;
use crate::tree::Tree;

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

    /// The subtree's part of an array with one element a face; empty if the array is too short.
    pub fn of<'a, T>(&self, per_face: &'a [T]) -> &'a [T] {
        match (to_index(self.first_face), to_index(self.face_end)) {
            (Some(start), Some(end)) => per_face.get(start..end).unwrap_or_default(),
            _ => &[],
        }
    }
}

/// The sections of a tree that a walk reads, for loops that take many steps.
#[derive(Clone, Copy, Debug)]
pub struct Reader<'a> {
    pub(crate) tops: &'a [TopRecord],
    pub(crate) top_loops: &'a [u8],
    pub(crate) pages: &'a [PageRecord],
    pub(crate) nodes: &'a [NodeRecord],
    pub(crate) faces: &'a [FaceRecord],
    pub(crate) links: &'a [U32],
    pub(crate) loops: &'a [u8],
    pub(crate) vertices: &'a [VertexRecord],
    pub(crate) path: &'a Path,
}

/// A broken rule on the way, not boxed up with its file yet.
type Broken = Box<Violation>;

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

    fn split_top(&self, subtree: &Subtree, index: u32) -> Result<[Subtree; 2], Broken> {
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

    /// Reads the boundary loops of a subtree's root, a single face included. A node that is never drawn may have none.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the loops leave their section or do not end, or when a vertex index is out of range.
    #[inline]
    pub fn read_loops(&self, subtree: &Subtree, out: &mut Loops) -> Result<(), Error> {
        self.load_loops(subtree, out).map_err(|violation| violation.at(self.path))
    }

    pub(crate) fn load_loops(&self, subtree: &Subtree, out: &mut Loops) -> Result<(), Broken> {
        out.clear();
        match subtree.place {
            Place::Top { record } => {
                let top = self.top(record)?;
                let range = to_index(top.loop_start.get()).zip(to_index(top.loop_end.get()));
                range
                    .and_then(|(start, end)| self.top_loops.get(start..end))
                    .and_then(|bytes| read_top(bytes, out))
                    .ok_or_else(|| loops_do_not_end(subtree))?;
                // The largest alone is looked at: all others are in range if it is.
                self.check_vertex(out.vertices.iter().copied().max().unwrap_or(0), || subtree.to_string())
            }
            Place::Page { page, loops, .. } => {
                let faces = subtree.face_count();
                let page = self.page_of(page, subtree)?;
                let locals = self.locals(page, subtree)?;
                let mut strange = None;
                let mut push = |out: &mut Loops, local| match locals.global(local) {
                    Some(vertex) => out.vertices.push(vertex),
                    None => strange = Some(local),
                };
                if faces <= SMALL_FACES && !self.small_stores_loops(subtree)? {
                    follow_faces(self.faces_of(subtree), |local, last| {
                        push(out, local);
                        if last {
                            out.close();
                        }
                    });
                } else {
                    let own = self.stored_loops(page, loops, subtree)?;
                    let mut show = |entries: &[u8]| {
                        for local in entries {
                            push(out, *local);
                        }
                        out.close();
                    };
                    own.get(2..)
                        .and_then(|own| read_stored(own, &mut show))
                        .ok_or_else(|| loops_do_not_end(subtree))?;
                }
                match strange {
                    None => Ok(()),
                    Some(local) => Err(locals.violation(local, subtree)),
                }
            }
        }
    }

    /// The vertex indices of a single face, which are in range.
    ///
    /// # Errors
    /// [`Error::Invalid`] when the subtree is no face of its page, or uses vertices that are not there.
    #[inline]
    pub fn face(&self, subtree: &Subtree) -> Result<[u32; 3], Error> {
        self.corners(subtree).map_err(|violation| violation.at(self.path))
    }

    /// The first corner of a subtree's first face, from which [`Node::plane`] counts heights.
    ///
    /// # Errors
    /// As [`Reader::face`].
    #[inline]
    pub fn first_corner(&self, subtree: &Subtree) -> Result<u32, Error> {
        let face = match subtree.place {
            Place::Page { page, .. } => Subtree {
                child: ChildRef::face(subtree.first_face),
                face_end: subtree.first_face.saturating_add(1),
                place: Place::Page { page, record: 0, loops: 0 },
                ..*subtree
            },
            Place::Top { .. } => self.single(subtree.first_face),
        };
        self.face(&face).map(|[first, ..]| first)
    }

    #[inline]
    pub(crate) fn corners(&self, subtree: &Subtree) -> Result<[u32; 3], Broken> {
        let Place::Page { page, .. } = subtree.place else {
            return Err(no_such_face(subtree));
        };
        let page = self.page_of(page, subtree)?;
        let locals = self.locals(page, subtree)?;
        let [face] = self.faces_of(subtree) else {
            return Err(no_such_face(subtree));
        };
        let [a, b, c] = *face;
        match (locals.global(a), locals.global(b), locals.global(c)) {
            (Some(a), Some(b), Some(c)) => Ok([a, b, c]),
            _ => Err(locals.violation(a.max(b).max(c), subtree)),
        }
    }

    /// A face by its index. Where pages do not ascend, some face or none.
    pub(crate) fn single(&self, face: u32) -> Subtree {
        let page = self.pages.partition_point(|p| p.first_face.get() <= face).saturating_sub(1);
        let page = u32::try_from(page).unwrap_or(u32::MAX);
        let place = Place::Page { page, record: 0, loops: 0 };
        Subtree { child: ChildRef::face(face), first_face: face, face_end: face.saturating_add(1), place }
    }

    fn top(&self, record: u32) -> Result<&'a TopRecord, Broken> {
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
    fn page_of(&self, page: u32, subtree: &Subtree) -> Result<&'a PageRecord, Broken> {
        let found = to_index(page).and_then(|i| self.pages.get(i)).filter(|p| {
            let first = p.first_face.get();
            first <= subtree.first_face && subtree.face_end <= first.saturating_add(u32::from(p.faces))
        });
        found.ok_or_else(|| not_owned(page, subtree))
    }

    /// The page and the record of a node within it.
    #[inline]
    fn page_node(
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

    #[inline]
    fn small_stores_loops(&self, subtree: &Subtree) -> Result<bool, Broken> {
        match subtree.place {
            Place::Page { page, record, .. } if subtree.face_count() > 1 => {
                let (_, node) = self.page_node(page, record, subtree)?;
                Ok(stores_loops(node, subtree.face_count()))
            }
            _ => Ok(false),
        }
    }

    /// The bytes of a page's loops from one of them on.
    #[inline]
    fn stored_loops(&self, page: &PageRecord, from: u32, subtree: &Subtree) -> Result<&'a [u8], Broken> {
        let first = page.first_loop.get();
        let end = first.saturating_add(u32::from(page.loop_bytes.get()));
        let range = to_index(first.saturating_add(from)).zip(to_index(end));
        range.and_then(|(start, end)| self.loops.get(start..end)).ok_or_else(|| loops_do_not_end(subtree))
    }

    /// The faces of a subtree of a page that owns them.
    #[inline]
    fn faces_of(&self, subtree: &Subtree) -> &'a [[u8; 3]] {
        // A face record is nothing but its three bytes.
        zerocopy::transmute_ref!(subtree.of(self.faces))
    }

    /// What the local indices of a page stand for.
    #[inline]
    fn locals(&self, page: &PageRecord, subtree: &Subtree) -> Result<Locals<'a>, Broken> {
        let first = to_index(page.first_link.get());
        let links =
            first.and_then(|first| self.links.get(first..first.checked_add(usize::from(page.links.get()))?));
        let Some(links) = links else {
            return Err(no_such_links(page, self.links.len(), subtree));
        };
        Ok(Locals {
            first_vertex: page.first_vertex.get(),
            own: u32::from(page.own_vertices.get()),
            links,
            vertices: u32::try_from(self.vertices.len()).unwrap_or(u32::MAX),
        })
    }

    fn check_vertex(&self, vertex: u32, place: impl FnOnce() -> String) -> Result<(), Broken> {
        if to_index(vertex).is_some_and(|v| v < self.vertices.len()) {
            return Ok(());
        }
        Err(Violation::new(
            Rule::VertexIndex,
            place(),
            format!("it uses vertex {vertex} of {}", self.vertices.len()),
        ))
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

/// What the local indices of a page stand for: its own run of vertices, then those that its links name.
struct Locals<'a> {
    first_vertex: u32,
    own: u32,
    links: &'a [U32],
    vertices: u32,
}

impl Locals<'_> {
    #[inline]
    fn global(&self, local: u8) -> Option<u32> {
        let local = u32::from(local);
        let vertex = match local.checked_sub(self.own) {
            None => self.first_vertex.checked_add(local)?,
            Some(link) => self.links.get(to_index(link)?)?.get(),
        };
        (vertex < self.vertices).then_some(vertex)
    }

    #[cold]
    fn violation(&self, local: u8, subtree: &Subtree) -> Broken {
        Violation::new(
            Rule::VertexIndex,
            subtree.to_string(),
            format!(
                "it uses vertex {local} of its page, which has {} from {} on and {} links, of {} in all",
                self.own,
                self.first_vertex,
                self.links.len(),
                self.vertices
            ),
        )
    }
}

/// Whether a node of a page has loops in section `LOOP`.
#[inline]
pub(crate) fn stores_loops(node: &NodeRecord, faces: u32) -> bool {
    faces > SMALL_FACES || node.left_faces & STORES_LOOPS != 0
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
fn no_such_links(page: &PageRecord, links: usize, subtree: &Subtree) -> Broken {
    let found = format!("its page has {} links from {} on, of {links}", page.links, page.first_link);
    Violation::new(Rule::VertexIndex, subtree.to_string(), found)
}

#[cold]
fn wrong_split(left: u32, subtree: &Subtree) -> Broken {
    let found = format!("{left} of its {} faces are on the left", subtree.face_count());
    Violation::new(Rule::FaceRange, subtree.to_string(), found)
}

#[cold]
fn loops_do_not_end(subtree: &Subtree) -> Broken {
    Violation::new(
        Rule::LoopRange,
        subtree.to_string(),
        "its loops leave their section or do not end".to_owned(),
    )
}

#[cold]
fn no_such_face(subtree: &Subtree) -> Broken {
    Violation::new(Rule::ChildPlace, subtree.to_string(), "it is not a single face of a page".to_owned())
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
