//! A page in memory without the rest of its chunk: a small tree of its own, with indices from 0 on.

use std::ops::Range;
use std::path::{Path, PathBuf};

use zerocopy::IntoBytes;
use zerocopy::little_endian::U32;

use super::load::{broken, from_index};
use crate::child::ChildRef;
use crate::hash::hash64_of;
use crate::octahedral::NormalRecord;
use crate::records::{FaceRecord, NodeRecord, PageRecord, VertexRecord};
use crate::subtree::{Place, Subtree};
use crate::walk::{Broken, Reader};

/// A page with all vertices that it uses, to be walked from [`ChunkPage::root`] with [`ChunkPage::reader`].
///
/// Its faces are numbered from 0 on, and so are its vertices: first its own, then those that its links name;
/// [`ChunkPage::vertex_id`] names them as the whole tree does.
#[derive(Debug)]
pub struct ChunkPage {
    record: PageRecord,
    body: Body,
    links: Vec<U32>,
    /// The names of the vertices that are not its own.
    linked: Vec<u32>,
    vertices: VertexRun,
    path: PathBuf,
}

/// Vertices that a page owns, without the rest of it.
#[derive(Debug, Default)]
pub struct VertexRun {
    pub(super) first: u32,
    pub(super) vertices: Vec<VertexRecord>,
    pub(super) normals: Vec<NormalRecord>,
    pub(super) colors: Vec<[u8; 4]>,
}

/// The vertices that a page owns, from wherever they are.
#[derive(Clone, Copy, Debug)]
pub struct OwnVertices<'a> {
    pub(super) first: u32,
    pub(super) vertices: &'a [VertexRecord],
    pub(super) normals: &'a [NormalRecord],
    pub(super) colors: &'a [[u8; 4]],
}

/// Nodes, faces and loops of a page.
#[derive(Debug)]
pub(super) struct Body {
    pub(super) nodes: Vec<NodeRecord>,
    pub(super) faces: Vec<FaceRecord>,
    pub(super) loops: Vec<u8>,
}

impl Body {
    pub(super) fn hash(&self) -> u64 {
        hash64_of(&[self.nodes.as_bytes(), self.faces.as_bytes(), &self.loops])
    }
}

impl VertexRun {
    pub(super) fn hash(&self) -> u64 {
        hash64_of(&[self.vertices.as_bytes(), self.normals.as_bytes(), self.colors.as_flattened()])
    }

    /// The vertices.
    pub fn own(&self) -> OwnVertices<'_> {
        self.part(self.vertices.len())
    }

    /// Bytes of memory that it takes.
    pub fn bytes(&self) -> u64 {
        let bytes = [
            self.vertices.capacity().saturating_mul(size_of::<VertexRecord>()),
            self.normals.capacity().saturating_mul(size_of::<NormalRecord>()),
            self.colors.capacity().saturating_mul(size_of::<[u8; 4]>()),
            size_of::<Self>(),
        ];
        bytes.into_iter().map(|n| u64::try_from(n).unwrap_or(u64::MAX)).fold(0, u64::saturating_add)
    }

    fn part(&self, count: usize) -> OwnVertices<'_> {
        OwnVertices {
            first: self.first,
            vertices: self.vertices.get(..count).unwrap_or_default(),
            normals: self.normals.get(..count).unwrap_or_default(),
            colors: self.colors.get(..count).unwrap_or_default(),
        }
    }

    fn push(&mut self, from: &OwnVertices<'_>, at: usize) -> Option<()> {
        self.vertices.push(*from.vertices.get(at)?);
        self.normals.extend(from.normals.get(at));
        self.colors.extend(from.colors.get(at));
        Some(())
    }
}

impl ChunkPage {
    /// Puts a page together. `own` are its own vertices; `owner` finds those of the page that owns a vertex.
    pub(super) fn new<'a>(
        mut record: PageRecord,
        body: Body,
        names: &[U32],
        own: OwnVertices<'a>,
        owner: impl Fn(u32) -> Option<OwnVertices<'a>>,
        path: &Path,
    ) -> Result<Self, Broken> {
        let lost = || broken("section LINK", "a link names a vertex that is not there");
        if own.first != record.first_vertex.get()
            || own.vertices.len() != usize::from(record.own_vertices.get())
        {
            return Err(broken("section CRPG", "a page has other vertices than it says"));
        }
        let count = own.vertices.len().saturating_add(names.len());
        let mut vertices = VertexRun { first: own.first, ..VertexRun::default() };
        vertices.vertices.reserve_exact(count);
        vertices.vertices.extend_from_slice(own.vertices);
        vertices.normals.reserve_exact(if own.normals.is_empty() { 0 } else { count });
        vertices.normals.extend_from_slice(own.normals);
        vertices.colors.reserve_exact(if own.colors.is_empty() { 0 } else { count });
        vertices.colors.extend_from_slice(own.colors);
        let mut links = Vec::with_capacity(names.len());
        let mut linked = Vec::with_capacity(names.len());
        for name in names {
            let from = owner(name.get()).ok_or_else(lost)?;
            let at = name.get().checked_sub(from.first).and_then(|at| usize::try_from(at).ok());
            links.push(from_index(vertices.vertices.len())?.into());
            linked.push(name.get());
            at.and_then(|at| vertices.push(&from, at)).ok_or_else(lost)?;
        }
        for field in
            [&mut record.first_face, &mut record.first_vertex, &mut record.first_link, &mut record.first_loop]
        {
            *field = U32::ZERO;
        }
        Ok(Self { record, body, links, linked, vertices, path: path.to_owned() })
    }

    /// The most bytes of memory that a page with so many links and bytes a vertex takes.
    pub(super) fn memory(record: &PageRecord, vertex_size: usize) -> u64 {
        let (own, links) = (usize::from(record.own_vertices.get()), usize::from(record.links.get()));
        // A vector grown by single elements may have twice the room; none is here.
        let sizes = [
            (usize::from(record.faces), size_of::<NodeRecord>().saturating_add(size_of::<FaceRecord>())),
            (usize::from(record.loop_bytes.get()), 1),
            (links, size_of::<U32>().saturating_add(size_of::<u32>())),
            (own.saturating_add(links), vertex_size),
            (1, size_of::<Self>()),
        ];
        let bytes =
            sizes.iter().map(|(count, size)| count.saturating_mul(*size)).fold(0, usize::saturating_add);
        u64::try_from(bytes).unwrap_or(u64::MAX)
    }

    /// The subtree that the page is, whose root has this name in the whole tree.
    pub fn root(&self, child: ChildRef) -> Subtree {
        Subtree {
            child: if self.record.faces == 1 { ChildRef::face(0) } else { child },
            first_face: 0,
            face_end: u32::from(self.record.faces),
            place: Place::Page { page: 0, record: 0, loops: 0 },
        }
    }

    /// The page as a walk reads it.
    pub fn reader(&self) -> Reader<'_> {
        Reader {
            tops: &[],
            top_loops: &[],
            top_corners: &[],
            pages: std::slice::from_ref(&self.record),
            nodes: &self.body.nodes,
            faces: &self.body.faces,
            links: &self.links,
            loops: &self.body.loops,
            vertices: &self.vertices.vertices,
            path: &self.path,
        }
    }

    /// The name of a vertex in the whole tree.
    pub fn vertex_id(&self, vertex: u32) -> Option<u32> {
        match vertex.checked_sub(u32::from(self.record.own_vertices.get())) {
            None => self.vertices.first.checked_add(vertex),
            Some(link) => self.linked.get(usize::try_from(link).ok()?).copied(),
        }
    }

    /// The names of its own vertices; pages have runs of them one after the other, which may be empty.
    pub fn own_vertices(&self) -> Range<u32> {
        let own = u32::from(self.record.own_vertices.get());
        self.vertices.first..self.vertices.first.saturating_add(own)
    }

    /// The names of its other vertices, which stand after its own.
    pub fn linked(&self) -> &[u32] {
        &self.linked
    }

    /// Its own vertices.
    pub fn own(&self) -> OwnVertices<'_> {
        self.vertices.part(usize::from(self.record.own_vertices.get()))
    }

    /// The normals of its vertices; empty if the file has none.
    pub fn normals(&self) -> &[NormalRecord] {
        &self.vertices.normals
    }

    /// The colours of its vertices; empty if the file has none.
    pub fn colors(&self) -> &[[u8; 4]] {
        &self.vertices.colors
    }

    /// Bytes of memory that it takes.
    pub fn bytes(&self) -> u64 {
        let bytes = [
            self.body.nodes.capacity().saturating_mul(size_of::<NodeRecord>()),
            self.body.faces.capacity().saturating_mul(size_of::<FaceRecord>()),
            self.body.loops.capacity(),
            self.links.capacity().saturating_mul(size_of::<U32>()),
            self.linked.capacity().saturating_mul(size_of::<u32>()),
            size_of::<Self>().saturating_sub(size_of::<VertexRun>()),
        ];
        let rest = bytes.into_iter().map(|n| u64::try_from(n).unwrap_or(u64::MAX));
        rest.fold(self.vertices.bytes(), u64::saturating_add)
    }
}
