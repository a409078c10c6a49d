//! A page as a whole: found and checked once, then walked by numbers of one byte.
//!
//! It shows what [`Reader`] shows of the same subtrees, in a fraction of the time. Where a page is damaged it shows
//! nothing, and whoever asks the [`Reader`] instead learns why.

use zerocopy::IntoBytes;
use zerocopy::little_endian::U32;

use crate::child::{Child, ChildRef};
use crate::loops::read_stored;
use crate::node::{ConeFrame, Node};
use crate::outline::stores_loops;
use crate::plane::PlaneFrame;
use crate::records::{NodeRecord, PageRecord, SMALL_FACES, STORES_LOOPS, VertexRecord};
use crate::short_float::ShortFloat;
use crate::small_loops::follow_small;
use crate::subtree::{Place, Subtree};
use crate::walk::{Reader, to_index};

/// A page whose parts were found to be there.
#[derive(Clone, Copy, Debug)]
pub struct Page<'a> {
    index: u32,
    record: &'a PageRecord,
    /// Makes steps of its grid of lengths.
    per_quantum: f32,
    /// Its root's number in preorder, or what it would be for a single face.
    first_node: u32,
    first_record: u32,
    nodes: &'a [NodeRecord],
    faces: &'a [[u8; 3]],
    loops: &'a [u8],
    links: &'a [U32],
    vertices: &'a [VertexRecord],
}

/// Bytes that come from memory together. If that is wrong, a few more or less come in time.
const LINE: usize = 64;

/// A node or a face of a page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Branch {
    /// The node, counted from the page's root; means nothing for a face.
    node: u8,
    /// Its first face, counted from the page's.
    first_face: u8,
    faces: u8,
    /// Where the loops that it stores would begin in the page's.
    loops: u16,
}

impl Branch {
    /// The number of faces; 1 for a face.
    #[inline]
    pub const fn face_count(&self) -> u32 {
        self.faces as u32
    }

    /// Its first face, counted from the page's first.
    #[inline]
    pub const fn first_face(&self) -> u8 {
        self.first_face
    }
}

impl<'a> Reader<'a> {
    /// The page that a subtree lies in, and where it stands there. None for a subtree above the pages, and where the
    /// page is damaged or does not own the subtree.
    pub fn page(&self, subtree: &Subtree) -> Option<(Page<'a>, Branch)> {
        let Place::Page { page: index, record, loops } = subtree.place else { return None };
        let page = self.page_of(index, subtree).ok()?;
        let first_face = page.first_face.get();
        let faces = u32::from(page.faces);
        let first_record = first_face.checked_sub(index)?;
        let node = if subtree.face_count() > 1 { record.checked_sub(first_record)? } else { 0 };
        let range = |first: u32, count: u32| to_index(first).zip(to_index(first.checked_add(count)?));
        let (first, end) = range(first_record, faces.checked_sub(1)?)?;
        let nodes = self.nodes.get(first..end)?;
        let (first, end) = range(first_face, faces)?;
        let faces = zerocopy::transmute_ref!(self.faces.get(first..end)?);
        let (first, end) = range(page.first_loop.get(), u32::from(page.loop_bytes.get()))?;
        let loops_of_page = self.loops.get(first..end)?;
        let (first, end) = range(page.first_link.get(), u32::from(page.links.get()))?;
        let links = self.links.get(first..end)?;
        // All own vertices are there if the last one is; links are looked at as they are used.
        let own_end = page.first_vertex.get().checked_add(u32::from(page.own_vertices.get()))?;
        if to_index(own_end)? > self.vertices.len() {
            return None;
        }
        let first_node = match subtree.child.kind() {
            Child::Node(number) => number.checked_sub(node)?,
            Child::Face(_) => 0,
        };
        let branch = Branch {
            node: u8::try_from(node).ok()?,
            first_face: u8::try_from(subtree.first_face.checked_sub(first_face)?).ok()?,
            faces: u8::try_from(subtree.face_count()).ok()?,
            loops: u16::try_from(loops).ok()?,
        };
        let vertices = self.vertices;
        let page = Page {
            index,
            record: page,
            per_quantum: 1.0 / page.quantum.get(),
            first_node,
            first_record,
            nodes,
            faces,
            loops: loops_of_page,
            links,
            vertices,
        };
        Some((page, branch))
    }
}

impl<'a> Page<'a> {
    /// Its number among the pages of the tree.
    #[inline]
    pub const fn number(&self) -> u32 {
        self.index
    }

    /// All of it as a branch.
    #[inline]
    pub const fn whole(&self) -> Branch {
        Branch { node: 0, first_face: 0, faces: self.record.faces, loops: 0 }
    }

    /// Reads a byte of each line of memory that the nodes and loops take, for whoever goes down into the page.
    ///
    /// All lines at once come from the file, or from memory, far sooner than one by one as the walk finds its way.
    #[inline]
    pub fn touch(&self) {
        let mut all = 0;
        for bytes in [self.nodes.as_bytes(), self.loops] {
            for [first, ..] in bytes.as_chunks::<LINE>().0 {
                all ^= first;
            }
        }
        std::hint::black_box(all);
    }

    /// A branch as a subtree of the whole tree.
    #[inline]
    pub fn subtree(&self, branch: &Branch) -> Subtree {
        let node = u32::from(branch.node);
        let first_face = self.record.first_face.get().saturating_add(u32::from(branch.first_face));
        Subtree {
            child: if branch.faces > 1 {
                ChildRef::node(self.first_node.saturating_add(node))
            } else {
                ChildRef::face(first_face)
            },
            first_face,
            face_end: first_face.saturating_add(branch.face_count()),
            place: Place::Page {
                page: self.index,
                record: self.first_record.saturating_add(node),
                loops: u32::from(branch.loops),
            },
        }
    }

    /// The node at the root of a branch; none for a face.
    #[inline]
    pub fn node(&self, branch: &Branch) -> Option<Node> {
        self.record_of(branch).map(|record| Node::of_page(self.record, record))
    }

    /// Where the root of a branch lies and its faces turn; none for a face, and where they turn every way.
    #[inline]
    pub fn cone(&self, branch: &Branch) -> Option<ConeFrame> {
        ConeFrame::of(self.record, self.record_of(branch)?)
    }

    /// The bound and the budget key of the node at the root of a branch; none for a face.
    #[inline]
    pub fn keys(&self, branch: &Branch) -> Option<[ShortFloat; 2]> {
        self.record_of(branch).map(|record| [record.bound, record.budget])
    }

    /// The two children of a branch, the left one first; none if they are not there.
    #[inline]
    pub fn children(&self, branch: &Branch) -> Option<[Branch; 2]> {
        let record = self.record_of(branch)?;
        let faces = branch.faces;
        let stores = stores_loops(record, u32::from(faces));
        let left_faces = if u32::from(faces) <= SMALL_FACES {
            record.left_faces & !STORES_LOOPS
        } else {
            record.left_faces
        };
        if left_faces == 0 || left_faces >= faces {
            return None;
        }
        let (mut left_loops, mut right_loops) = (branch.loops, branch.loops);
        if stores {
            let own = self.loops.get(usize::from(branch.loops)..)?;
            let (skip, rings) = own.split_first_chunk::<2>()?;
            let end = u16::try_from(read_stored(rings, |_| {})?).ok()?;
            left_loops = branch.loops.checked_add(2)?.checked_add(end)?;
            right_loops = left_loops.checked_add(u16::from_le_bytes(*skip))?;
        }
        let left = Branch {
            node: branch.node.saturating_add(1),
            first_face: branch.first_face,
            faces: left_faces,
            loops: left_loops,
        };
        let right = Branch {
            node: branch.node.saturating_add(left_faces),
            first_face: branch.first_face.saturating_add(left_faces),
            faces: faces.saturating_sub(left_faces),
            loops: right_loops,
        };
        Some([left, right])
    }

    /// The faces of a branch, one by one.
    #[inline]
    pub fn single_faces(&self, branch: &Branch) -> impl Iterator<Item = Branch> {
        let Branch { first_face, faces, .. } = *branch;
        (first_face..first_face.saturating_add(faces)).map(|first_face| Branch {
            node: 0,
            first_face,
            faces: 1,
            loops: 0,
        })
    }

    /// The corners of a face, as indices in the tree.
    #[inline]
    pub fn corners(&self, branch: &Branch) -> Option<[u32; 3]> {
        let [a, b, c] = self.first_face(branch)?;
        let corner =
            |local| self.index_of(local).filter(|v| to_index(*v).is_some_and(|v| v < self.vertices.len()));
        Some([corner(a)?, corner(b)?, corner(c)?])
    }

    /// The corners of a face or of the first face of a node, as local indices.
    #[inline]
    pub fn first_face(&self, branch: &Branch) -> Option<[u8; 3]> {
        self.faces.get(usize::from(branch.first_face)).copied()
    }

    /// The corners of all faces of a branch, as local indices.
    #[inline]
    pub fn faces(&self, branch: &Branch) -> Option<&'a [[u8; 3]]> {
        let first = usize::from(branch.first_face);
        self.faces.get(first..first.saturating_add(usize::from(branch.faces)))
    }

    /// Shows the boundary loops of a branch of two faces or more, each as local indices; none if they do not end.
    #[inline]
    pub fn rings(&self, branch: &Branch, show: impl FnMut(&[u8])) -> Option<()> {
        let record = self.record_of(branch)?;
        if stores_loops(record, u32::from(branch.faces)) {
            let rings = self.loops.get(usize::from(branch.loops).saturating_add(2)..)?;
            read_stored(rings, show).map(|_end| ())
        } else {
            follow_small(self.faces(branch)?, show)
        }
    }

    /// Where a branch's plane lies, if all its faces face the axis of its cone, and its distance bound; none for a face.
    #[inline(always)]
    pub fn plane(&self, branch: &Branch) -> Option<(Option<PlaneFrame>, f32)> {
        let record = self.record_of(branch)?;
        let frame = (record.width < u8::MAX).then(|| PlaneFrame::of(record, self.per_quantum));
        Some((frame, record.bound.get()))
    }

    /// What makes steps of the page's grid of lengths: a power of two.
    #[inline]
    pub fn per_quantum(&self) -> f32 {
        self.per_quantum
    }

    /// How many vertices the page has: local indices are below it.
    #[inline]
    pub fn vertex_count(&self) -> usize {
        usize::from(self.record.own_vertices.get()).saturating_add(self.links.len())
    }

    /// A vertex by its local index: its index in the tree, and its record.
    #[inline]
    pub fn vertex(&self, local: u8) -> Option<(u32, &'a VertexRecord)> {
        let vertex = self.index_of(local)?;
        Some((vertex, self.vertices.get(to_index(vertex)?)?))
    }

    /// The vertices that its faces are the first to use, which have the first local indices, and the index of the first
    /// of them in the tree.
    #[inline]
    pub fn own_vertices(&self) -> (u32, &'a [VertexRecord]) {
        let first = self.record.first_vertex.get();
        let own = to_index(first).and_then(|start| {
            let end = start.checked_add(usize::from(self.record.own_vertices.get()))?;
            self.vertices.get(start..end)
        });
        (first, own.unwrap_or_default())
    }

    /// The indices of its other vertices in the tree.
    #[inline]
    pub fn links(&self) -> &'a [U32] {
        self.links
    }

    /// The record of a vertex by its index in the tree.
    #[inline]
    pub fn record_of_vertex(&self, vertex: u32) -> Option<&'a VertexRecord> {
        self.vertices.get(to_index(vertex)?)
    }

    #[inline]
    fn index_of(&self, local: u8) -> Option<u32> {
        match u16::from(local).checked_sub(self.record.own_vertices.get()) {
            None => self.record.first_vertex.get().checked_add(u32::from(local)),
            Some(link) => self.links.get(usize::from(link)).map(|link| link.get()),
        }
    }

    #[inline]
    fn record_of(&self, branch: &Branch) -> Option<&'a NodeRecord> {
        if branch.faces < 2 {
            return None;
        }
        self.nodes.get(usize::from(branch.node))
    }
}
