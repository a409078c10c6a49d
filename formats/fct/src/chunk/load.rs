//! The top of a chunk in memory: what is looked at before any of its pages is.

use std::ops::Range;
use std::path::{Path, PathBuf};

use zerocopy::little_endian::U32;

use super::crown::take;
use super::runs::{Runs, Wanted};
use crate::child::ChildRef;
use crate::error::{Error, Violation};
use crate::loops::{Loops, read_stored, read_top, read_varint};
use crate::node::Node;
use crate::octahedral::NormalRecord;
use crate::records::{NodeRecord, PAGE_BIT, PageRecord, TopRecord, VertexRecord};
use crate::rule::Rule;
use crate::subtree::{Place, Subtree};
use crate::walk::{Broken, Reader, to_index};

/// The top of a chunk: its nodes down to the roots of its pages, walked from [`Chunk::root`] with [`Chunk::children`].
///
/// Nodes and vertices are named as in the whole tree; faces are numbered from 0 on.
#[derive(Debug)]
pub struct Chunk {
    tops: Vec<TopRecord>,
    top_loops: Vec<u8>,
    /// With the faces and links of the chunk numbered from 0 on.
    pages: Vec<PageRecord>,
    links: Vec<U32>,
    roots: Vec<PageRoot>,
    /// Loops of the pages' roots, as local indices.
    root_loops: Vec<u8>,
    ids: Vec<u32>,
    vertices: Vec<VertexRecord>,
    normals: Vec<NormalRecord>,
    colors: Vec<[u8; 4]>,
    root: Subtree,
    first_page: u32,
    first_face: u32,
    vertex_count: u32,
    path: PathBuf,
}

/// The copy of a page's root.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PageRoot {
    /// Means nothing for a page of one face.
    node: NodeRecord,
    /// Where its loops begin.
    loops: u32,
    /// The first corner of its first face, as a local index.
    corner: u8,
}

impl Chunk {
    /// Numbers pages, top nodes and faces from 0 on, so that each reference can be checked against what the chunk has.
    pub(super) fn new(
        wanted: &Wanted,
        runs: Runs,
        attributes: [bool; 2],
        vertex_count: u32,
        path: &Path,
    ) -> Result<Self, Broken> {
        let Runs { tops, top_loops, pages, links, copies } = runs;
        let lost = || broken("section PAGE", "a page begins before its chunk");
        let first_face = pages.first().ok_or_else(lost)?.first_face.get();
        let face_end = pages.last().map_or(0, |p| p.first_face.get().saturating_add(u32::from(p.faces)));
        let faces = face_end.checked_sub(first_face).ok_or_else(lost)?;
        let mut chunk = Self {
            tops,
            top_loops,
            pages,
            links,
            roots: Vec::new(),
            root_loops: Vec::new(),
            ids: Vec::new(),
            vertices: Vec::new(),
            normals: Vec::new(),
            colors: Vec::new(),
            root: Subtree::default(),
            first_page: from_index(wanted.pages.start)?,
            first_face,
            vertex_count,
            path: path.to_owned(),
        };
        chunk.root = Subtree {
            child: if faces == 1 { ChildRef::face(0) } else { wanted.root },
            first_face: 0,
            face_end: faces,
            place: if chunk.pages.len() == 1 {
                Place::Page { page: 0, record: 0, loops: 0 }
            } else {
                Place::Top { record: 0 }
            },
        };
        chunk.number_pages(wanted)?;
        chunk.number_tops(wanted)?;
        chunk.take_copies(&copies, attributes)?;
        Ok(chunk)
    }

    fn number_pages(&mut self, wanted: &Wanted) -> Result<(), Broken> {
        let starts = [self.first_face, from_index(wanted.links.start)?];
        for page in &mut self.pages {
            for (field, start) in [&mut page.first_face, &mut page.first_link].into_iter().zip(starts) {
                let moved = field.get().checked_sub(start);
                *field =
                    moved.ok_or_else(|| broken("section PAGE", "a page begins before its chunk"))?.into();
            }
        }
        Ok(())
    }

    fn number_tops(&mut self, wanted: &Wanted) -> Result<(), Broken> {
        let lost = || broken("section TOPN", "a top node leaves the chunk");
        let (first_top, first_page) = (from_index(wanted.tops.start)?, self.first_page);
        let child = |name: u32| {
            if name & PAGE_BIT == 0 {
                name.checked_sub(first_top)
            } else {
                (name & !PAGE_BIT).checked_sub(first_page).map(|page| page | PAGE_BIT)
            }
        };
        let first_loop = from_index(wanted.top_loops.start)?;
        for top in &mut self.tops {
            top.left = child(top.left.get()).ok_or_else(lost)?.into();
            top.right = child(top.right.get()).ok_or_else(lost)?.into();
            for (field, start) in [
                (&mut top.first_face, self.first_face),
                (&mut top.loop_start, first_loop),
                (&mut top.loop_end, first_loop),
            ] {
                *field = field.get().checked_sub(start).ok_or_else(lost)?.into();
            }
        }
        Ok(())
    }

    /// Takes the part of section `CHTP` apart.
    fn take_copies(&mut self, copies: &[u8], [normals, colors]: [bool; 2]) -> Result<(), Broken> {
        let short = || broken("section CHTP", "it does not hold what belongs to the chunk's pages");
        let mut rest = copies;
        let nodes = self.pages.iter().filter(|page| page.faces > 1).count();
        let mut nodes = take::<NodeRecord>(&mut rest, nodes).ok_or_else(short)?.iter();
        let all_loops = rest;
        self.roots.reserve_exact(self.pages.len());
        for page in &self.pages {
            let node = if page.faces > 1 { nodes.next().copied().ok_or_else(short)? } else { <_>::default() };
            let (&corner, loops) = rest.split_first().ok_or_else(short)?;
            let start = all_loops.len().saturating_sub(loops.len());
            let end = read_stored(loops, |_| {}).ok_or_else(short)?;
            rest = loops.get(end..).ok_or_else(short)?;
            self.roots.push(PageRoot { node, loops: from_index(start)?, corner });
        }
        let end = all_loops.len().saturating_sub(rest.len());
        self.root_loops = all_loops.get(..end).ok_or_else(short)?.to_vec();
        let count = read_varint(&mut rest).and_then(to_index).ok_or_else(short)?;
        // Each takes a byte here, and more below.
        if count > rest.len() {
            return Err(short());
        }
        self.ids.reserve_exact(count);
        let mut id = 0_u32;
        for index in 0..count {
            let step = read_varint(&mut rest).ok_or_else(short)?;
            id = id.checked_add(step).filter(|id| *id < self.vertex_count).ok_or_else(short)?;
            if index > 0 && step == 0 {
                return Err(broken("section CHTP", "its vertices do not ascend"));
            }
            self.ids.push(id);
        }
        self.vertices = take(&mut rest, count).ok_or_else(short)?.to_vec();
        self.normals = take(&mut rest, if normals { count } else { 0 }).ok_or_else(short)?.to_vec();
        self.colors = take(&mut rest, if colors { count } else { 0 }).ok_or_else(short)?.to_vec();
        if rest.is_empty() { Ok(()) } else { Err(short()) }
    }

    /// The subtree whose root is the chunk's, which is drawn from the crown.
    pub fn root(&self) -> Subtree {
        self.root
    }

    /// The node at the root of a subtree of the top, which may be a page's.
    ///
    /// # Errors
    /// [`Error::Invalid`] when there is no such node, or when the subtree is a single face.
    pub fn node(&self, subtree: &Subtree) -> Result<Node, Error> {
        match self.page_at(subtree) {
            Some((index, page))
                if subtree.face_count() > 1 && subtree.face_count() == u32::from(page.faces) =>
            {
                let root = self.roots.get(index).ok_or_else(|| self.lost(subtree))?;
                Ok(Node::of_page(page, &root.node))
            }
            Some(_) => Err(self.lost(subtree)),
            None => self.reader().node(subtree),
        }
    }

    /// The two children of a top node, the left one first.
    ///
    /// # Errors
    /// [`Error::Invalid`] when they are not where they must be, or when the subtree is a page.
    pub fn children(&self, subtree: &Subtree) -> Result<[Subtree; 2], Error> {
        self.reader().children(subtree)
    }

    /// The number in the file of the page that a subtree is; none if it is a top node's.
    pub fn page(&self, subtree: &Subtree) -> Option<u32> {
        let (index, _) = self.page_at(subtree)?;
        self.first_page.checked_add(u32::try_from(index).ok()?)
    }

    /// The pages, by their numbers in the file.
    pub fn pages(&self) -> Range<u32> {
        self.first_page..self.first_page.saturating_add(u32::try_from(self.pages.len()).unwrap_or(u32::MAX))
    }

    /// The boundary loops of a subtree of the top. None if they do not end or name vertices that are not there.
    pub fn read_loops(&self, subtree: &Subtree, out: &mut Loops) -> Option<()> {
        out.clear();
        match subtree.place {
            Place::Top { record } => {
                let top = self.tops.get(to_index(record)?)?;
                let range = to_index(top.loop_start.get())?..to_index(top.loop_end.get())?;
                read_top(self.top_loops.get(range)?, out)?;
            }
            Place::Page { page, .. } => {
                let index = to_index(page)?;
                let bytes = self.root_loops.get(to_index(self.roots.get(index)?.loops)?..)?;
                let mut is_known = true;
                read_stored(bytes, |ring| {
                    for local in ring {
                        match self.name_of(index, *local) {
                            Some(vertex) => out.vertices.push(vertex),
                            None => is_known = false,
                        }
                    }
                    out.close();
                })?;
                is_known.then_some(())?;
            }
        }
        out.vertices.iter().all(|v| *v < self.vertex_count).then_some(())
    }

    /// The first corner of a subtree's first face.
    pub fn corner(&self, subtree: &Subtree) -> Option<u32> {
        let index = match subtree.place {
            Place::Page { page, .. } => to_index(page)?,
            Place::Top { .. } => {
                self.pages.partition_point(|p| p.first_face.get() <= subtree.first_face).checked_sub(1)?
            }
        };
        self.name_of(index, self.roots.get(index)?.corner)
    }

    /// The record of a top node, or what a page's root would have as one; loops and children mean nothing.
    pub fn record(&self, subtree: &Subtree) -> Option<TopRecord> {
        match subtree.place {
            Place::Top { record } => self.tops.get(to_index(record)?).copied(),
            Place::Page { .. } if subtree.face_count() == 1 => Some(TopRecord::of_face()),
            Place::Page { .. } => self.node(subtree).ok().map(Node::to_top),
        }
    }

    /// The place of a vertex among those of the top, if it is there.
    pub fn find(&self, vertex: u32) -> Option<usize> {
        self.ids.binary_search(&vertex).ok()
    }

    /// The names of the vertices of the top, which ascend.
    pub fn ids(&self) -> &[u32] {
        &self.ids
    }

    /// The records of those vertices.
    pub fn vertices(&self) -> &[VertexRecord] {
        &self.vertices
    }

    /// Their normals; empty if the file has none.
    pub fn normals(&self) -> &[NormalRecord] {
        &self.normals
    }

    /// Their colours; empty if the file has none.
    pub fn colors(&self) -> &[[u8; 4]] {
        &self.colors
    }

    /// Bytes of memory that it takes.
    pub fn bytes(&self) -> u64 {
        let bytes = [
            self.tops.capacity().saturating_mul(size_of::<TopRecord>()),
            self.top_loops.capacity(),
            self.pages.capacity().saturating_mul(size_of::<PageRecord>()),
            self.links.capacity().saturating_mul(size_of::<U32>()),
            self.roots.capacity().saturating_mul(size_of::<PageRoot>()),
            self.root_loops.capacity(),
            self.ids.capacity().saturating_mul(size_of::<u32>()),
            self.vertices.capacity().saturating_mul(size_of::<VertexRecord>()),
            self.normals.capacity().saturating_mul(size_of::<NormalRecord>()),
            self.colors.capacity().saturating_mul(size_of::<[u8; 4]>()),
            size_of::<Self>(),
        ];
        bytes.into_iter().map(|n| u64::try_from(n).unwrap_or(u64::MAX)).fold(0, u64::saturating_add)
    }

    /// The first face of the chunk in the whole tree.
    pub(super) fn first_face(&self) -> u32 {
        self.first_face
    }

    /// The record of a page by its number in the file, with its links and its first face in the chunk.
    pub(super) fn page_record(&self, page: u32) -> Option<(&PageRecord, &[U32])> {
        let record = self.pages.get(to_index(page.checked_sub(self.first_page)?)?)?;
        Some((record, self.links_of(record)?))
    }

    fn links_of(&self, page: &PageRecord) -> Option<&[U32]> {
        let start = to_index(page.first_link.get())?;
        self.links.get(start..start.checked_add(usize::from(page.links.get()))?)
    }

    /// What a page calls a vertex by a byte, by its name in the whole tree.
    fn name_of(&self, page: usize, local: u8) -> Option<u32> {
        let page = self.pages.get(page)?;
        match u16::from(local).checked_sub(page.own_vertices.get()) {
            None => page.first_vertex.get().checked_add(u32::from(local)),
            Some(link) => self.links_of(page)?.get(usize::from(link)).map(|link| link.get()),
        }
    }

    fn page_at(&self, subtree: &Subtree) -> Option<(usize, &PageRecord)> {
        let Place::Page { page, .. } = subtree.place else { return None };
        let index = to_index(page)?;
        Some((index, self.pages.get(index)?))
    }

    fn reader(&self) -> Reader<'_> {
        Reader {
            tops: &self.tops,
            top_loops: &self.top_loops,
            top_corners: &[],
            pages: &self.pages,
            nodes: &[],
            faces: &[],
            links: &[],
            loops: &[],
            vertices: &[],
            path: &self.path,
        }
    }

    fn lost(&self, subtree: &Subtree) -> Error {
        broken(&subtree.to_string(), "the chunk has no such node").at(&self.path)
    }
}

pub(super) fn from_index(index: usize) -> Result<u32, Broken> {
    u32::try_from(index).map_err(|_too_large| broken("section CRPG", "a chunk is too large"))
}

pub(super) fn broken(place: &str, found: &str) -> Broken {
    Violation::new(Rule::Chunk, place.to_owned(), found.to_owned())
}
