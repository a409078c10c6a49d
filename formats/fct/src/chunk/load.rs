//! A chunk in memory: a small tree of its own, with indices from 0 on.

use std::ops::Range;
use std::path::{Path, PathBuf};

use zerocopy::IntoBytes;
use zerocopy::little_endian::U32;

use super::ChunkRecord;
use super::build::kin_of;
use super::crown::take;
use crate::child::ChildRef;
use crate::container::Spans;
use crate::error::Violation;
use crate::hash::hash64_of;
use crate::loops::{Loops, read_top};
use crate::octahedral::NormalRecord;
use crate::pack::encode_top;
use crate::records::{FaceRecord, LOOP_END, NodeRecord, PAGE_BIT, PageRecord, TopRecord, VertexRecord};
use crate::rule::Rule;
use crate::subtree::{Place, Subtree};
use crate::walk::{Broken, Reader, to_index};

/// A chunk, to be walked from [`Chunk::root`] with [`Chunk::reader`].
///
/// Its nodes are named as in the whole tree. Its faces are numbered from 0 on, and so are its vertices: first its own,
/// then its kin; [`Chunk::vertex_id`] names them as the whole tree does.
#[derive(Debug)]
pub struct Chunk {
    runs: Runs,
    root: Subtree,
    first_vertex: u32,
    own: u32,
    kin: Vec<u32>,
    path: PathBuf,
}

/// The elements of each section that make a chunk.
#[derive(Clone, Debug)]
pub(super) struct Wanted {
    pub(super) hash: u64,
    pub(super) root: ChildRef,
    pub(super) tops: Range<usize>,
    pub(super) top_loops: Range<usize>,
    pub(super) pages: Range<usize>,
    pub(super) nodes: Range<usize>,
    pub(super) faces: Range<usize>,
    pub(super) loops: Range<usize>,
    pub(super) links: Range<usize>,
    pub(super) vertices: Range<usize>,
    pub(super) kin: Range<usize>,
    pub(super) attributes: [bool; 2],
}

impl Wanted {
    /// None if the chunk is not there, or its runs leave their sections or are too short for a tree.
    pub(super) fn of(chunks: &[ChunkRecord], chunk: u32, spans: &Spans, kins: usize) -> Option<Self> {
        let index = to_index(chunk)?;
        let record = chunks.get(index)?;
        let next = chunks.get(index.checked_add(1)?);
        let run = |field: fn(&ChunkRecord) -> U32, section: &Range<usize>, size: usize| {
            let end = section.len().checked_div(size)?;
            let next = next.map_or(Some(end), |n| to_index(field(n).get()))?;
            let start = to_index(field(record).get())?;
            (start <= next && next <= end).then_some(start..next)
        };
        let pages = run(|c| c.page, &spans.page, size_of::<PageRecord>())?;
        let faces = run(|c| c.face, &spans.face, size_of::<FaceRecord>())?;
        let top = to_index(record.top.get())?;
        let tops = top..top.checked_add(pages.len().checked_sub(1)?)?;
        let top_loop = to_index(record.top_loop.get())?;
        let top_loops = top_loop..top_loop.checked_add(to_index(record.top_loop_bytes.get())?)?;
        let first_node = faces.start.checked_sub(pages.start)?;
        let nodes = first_node..first_node.checked_add(faces.len().checked_sub(pages.len())?)?;
        let inside = |run: &Range<usize>, section: &Range<usize>, size: usize| {
            section.len().checked_div(size).is_some_and(|end| run.end <= end)
        };
        let lies = inside(&tops, &spans.topn, size_of::<TopRecord>())
            && inside(&top_loops, &spans.topl, 1)
            && inside(&nodes, &spans.node, size_of::<NodeRecord>());
        lies.then_some(())?;
        let all_kins = 0..kins;
        Some(Self {
            hash: record.hash.get(),
            root: ChildRef::from_raw(record.root.get()),
            tops,
            top_loops,
            pages,
            nodes,
            faces,
            loops: run(|c| c.page_loop, &spans.loops, 1)?,
            links: run(|c| c.link, &spans.link, size_of::<U32>())?,
            vertices: run(|c| c.vertex, &spans.vert, size_of::<VertexRecord>())?,
            kin: run(|c| c.kin, &all_kins, 1)?,
            attributes: [spans.norm.is_some(), spans.colr.is_some()],
        })
    }

    /// Bytes of a vertex with its attributes.
    pub(super) const fn vertex_size([normals, colors]: [bool; 2]) -> usize {
        let normal = if normals { size_of::<NormalRecord>() } else { 0 };
        let color = if colors { size_of::<[u8; 4]>() } else { 0 };
        size_of::<VertexRecord>().saturating_add(normal).saturating_add(color)
    }

    /// The bytes of the kin in section `KINS`.
    pub(super) fn kin_bytes(&self, size: usize) -> Range<usize> {
        self.kin.start.saturating_mul(size)..self.kin.end.saturating_mul(size)
    }

    /// The most bytes of memory that the chunk takes, the reading included.
    pub(super) fn memory(&self) -> u64 {
        let vertices = self.vertices.len().saturating_add(self.kin.len());
        // A loop entry takes at most five bytes when its vertices are numbered anew.
        let sizes = [
            (self.tops.len(), size_of::<TopRecord>()),
            (self.top_loops.len(), 6),
            (self.pages.len(), size_of::<PageRecord>()),
            (self.nodes.len(), size_of::<NodeRecord>()),
            (self.faces.len(), size_of::<FaceRecord>()),
            (self.loops.len(), 1),
            (self.links.len(), size_of::<U32>()),
            (vertices, Self::vertex_size(self.attributes)),
            (self.kin.len(), Self::vertex_size(self.attributes).saturating_add(4)),
            (1, size_of::<Chunk>()),
        ];
        let bytes =
            sizes.iter().map(|(count, size)| count.saturating_mul(*size)).fold(0, usize::saturating_add);
        u64::try_from(bytes).unwrap_or(u64::MAX)
    }
}

/// The sections of a chunk.
#[derive(Debug)]
pub(super) struct Runs {
    pub(super) tops: Vec<TopRecord>,
    pub(super) top_loops: Vec<u8>,
    pub(super) pages: Vec<PageRecord>,
    pub(super) nodes: Vec<NodeRecord>,
    pub(super) faces: Vec<FaceRecord>,
    pub(super) loops: Vec<u8>,
    pub(super) links: Vec<U32>,
    pub(super) vertices: Vec<VertexRecord>,
    pub(super) normals: Vec<NormalRecord>,
    pub(super) colors: Vec<[u8; 4]>,
    /// Copies of vertices of other chunks, until they stand with the others.
    pub(super) kins: Vec<u8>,
}

impl Runs {
    pub(super) fn hash(&self) -> u64 {
        hash64_of(&[
            self.tops.as_bytes(),
            &self.top_loops,
            self.pages.as_bytes(),
            self.nodes.as_bytes(),
            self.faces.as_bytes(),
            &self.loops,
            self.links.as_bytes(),
            self.vertices.as_bytes(),
            self.normals.as_bytes(),
            self.colors.as_flattened(),
            &self.kins,
        ])
    }
}

impl Chunk {
    /// Numbers everything from 0 on, so that each reference can be checked against what the chunk has.
    pub(super) fn new(wanted: &Wanted, mut runs: Runs, path: &Path) -> Result<Self, Broken> {
        let [normals, colors] = wanted.attributes;
        let first_vertex = from_index(wanted.vertices.start)?;
        let own = from_index(runs.vertices.len())?;
        let kin = kin_of(&runs.links, first_vertex);
        let mut copies = std::mem::take(&mut runs.kins);
        {
            let mut rest = copies.as_slice();
            let short = || broken("section KINS", "it does not hold the kin that links name");
            runs.vertices.reserve_exact(kin.len());
            runs.vertices.extend_from_slice(take(&mut rest, kin.len()).ok_or_else(short)?);
            if normals {
                runs.normals.reserve_exact(kin.len());
                runs.normals.extend_from_slice(take(&mut rest, kin.len()).ok_or_else(short)?);
            }
            if colors {
                runs.colors.reserve_exact(kin.len());
                runs.colors.extend_from_slice(take(&mut rest, kin.len()).ok_or_else(short)?);
            }
            if !rest.is_empty() || wanted.kin.len() != kin.len() {
                return Err(short());
            }
        }
        copies.clear();
        let mut chunk = Self {
            root: Subtree {
                // Nodes keep their names, faces are numbered from 0 on.
                child: if runs.faces.len() == 1 { ChildRef::face(0) } else { wanted.root },
                first_face: 0,
                face_end: from_index(runs.faces.len())?,
                place: if runs.pages.len() == 1 {
                    Place::Page { page: 0, record: 0, loops: 0 }
                } else {
                    Place::Top { record: 0 }
                },
            },
            runs,
            first_vertex,
            own,
            kin,
            path: path.to_owned(),
        };
        chunk.number_links()?;
        chunk.number_pages(wanted)?;
        chunk.number_tops(wanted)?;
        Ok(chunk)
    }

    /// The subtree whose root is the chunk's.
    pub fn root(&self) -> Subtree {
        self.root
    }

    /// The chunk as a walk reads it. Faces and vertices are numbered from 0 on.
    pub fn reader(&self) -> Reader<'_> {
        Reader {
            tops: &self.runs.tops,
            top_loops: &self.runs.top_loops,
            top_corners: &[],
            pages: &self.runs.pages,
            nodes: &self.runs.nodes,
            faces: &self.runs.faces,
            links: &self.runs.links,
            loops: &self.runs.loops,
            vertices: &self.runs.vertices,
            path: &self.path,
        }
    }

    /// The name of a vertex in the whole tree.
    pub fn vertex_id(&self, vertex: u32) -> Option<u32> {
        match vertex.checked_sub(self.own) {
            None => self.first_vertex.checked_add(vertex),
            Some(kin) => self.kin.get(to_index(kin)?).copied(),
        }
    }

    /// The number here of a vertex of the whole tree that is the chunk's own.
    pub fn own_vertex(&self, id: u32) -> Option<u32> {
        id.checked_sub(self.first_vertex).filter(|v| *v < self.own)
    }

    /// The kin: names of vertices of other chunks, in order, which stand after the chunk's own.
    pub fn kin(&self) -> &[u32] {
        &self.kin
    }

    /// The names of its own vertices; chunks have runs of them one after the other, which may be empty.
    pub fn own_vertices(&self) -> Range<u32> {
        self.first_vertex..self.first_vertex.saturating_add(self.own)
    }

    /// The normals of its vertices; empty if the file has none.
    pub fn normals(&self) -> &[NormalRecord] {
        &self.runs.normals
    }

    /// The colours of its vertices; empty if the file has none.
    pub fn colors(&self) -> &[[u8; 4]] {
        &self.runs.colors
    }

    /// Bytes of memory that it takes.
    pub fn bytes(&self) -> u64 {
        let runs = &self.runs;
        let bytes = [
            runs.tops.capacity().saturating_mul(size_of::<TopRecord>()),
            runs.top_loops.capacity(),
            runs.pages.capacity().saturating_mul(size_of::<PageRecord>()),
            runs.nodes.capacity().saturating_mul(size_of::<NodeRecord>()),
            runs.faces.capacity().saturating_mul(size_of::<FaceRecord>()),
            runs.loops.capacity(),
            runs.links.capacity().saturating_mul(size_of::<U32>()),
            runs.vertices.capacity().saturating_mul(size_of::<VertexRecord>()),
            runs.normals.capacity().saturating_mul(size_of::<NormalRecord>()),
            runs.colors.capacity().saturating_mul(size_of::<[u8; 4]>()),
            self.kin.capacity().saturating_mul(size_of::<u32>()),
            size_of::<Self>(),
        ];
        bytes.into_iter().map(|n| u64::try_from(n).unwrap_or(u64::MAX)).fold(0, u64::saturating_add)
    }

    /// The number here of a vertex of the whole tree.
    fn local(&self, id: u32) -> Option<u32> {
        self.own_vertex(id).or_else(|| {
            let kin = u32::try_from(self.kin.binary_search(&id).ok()?).ok()?;
            self.own.checked_add(kin)
        })
    }

    fn number_links(&mut self) -> Result<(), Broken> {
        for index in 0..self.runs.links.len() {
            let link = self.runs.links.get(index).copied().unwrap_or_default();
            let local =
                self.local(link.get()).ok_or_else(|| broken("section LINK", "a link leaves the chunk"))?;
            if let Some(slot) = self.runs.links.get_mut(index) {
                *slot = local.into();
            }
        }
        Ok(())
    }

    fn number_pages(&mut self, wanted: &Wanted) -> Result<(), Broken> {
        let starts = [wanted.faces.start, wanted.vertices.start, wanted.links.start, wanted.loops.start];
        for page in &mut self.runs.pages {
            let fields =
                [&mut page.first_face, &mut page.first_vertex, &mut page.first_link, &mut page.first_loop];
            for (field, start) in fields.into_iter().zip(starts) {
                let moved = field.get().checked_sub(from_index(start)?);
                *field =
                    moved.ok_or_else(|| broken("section PAGE", "a page begins before its chunk"))?.into();
            }
        }
        Ok(())
    }

    fn number_tops(&mut self, wanted: &Wanted) -> Result<(), Broken> {
        let lost = || broken("section TOPN", "a top node leaves the chunk");
        let starts = (from_index(wanted.tops.start)?, from_index(wanted.pages.start)?);
        let first_face = from_index(wanted.faces.start)?;
        let child = |name: u32| {
            if name & PAGE_BIT == 0 {
                name.checked_sub(starts.0)
            } else {
                (name & !PAGE_BIT).checked_sub(starts.1).map(|page| page | PAGE_BIT)
            }
        };
        let old = std::mem::take(&mut self.runs.top_loops);
        let mut loops = Vec::new();
        let mut scratch = Loops::default();
        let mut tops = std::mem::take(&mut self.runs.tops);
        for (index, top) in tops.iter_mut().enumerate() {
            top.left = child(top.left.get()).ok_or_else(lost)?.into();
            top.right = child(top.right.get()).ok_or_else(lost)?.into();
            top.first_face = top.first_face.get().checked_sub(first_face).ok_or_else(lost)?.into();
            let bytes = [top.loop_start, top.loop_end]
                .map(|at| to_index(at.get()).and_then(|at| at.checked_sub(wanted.top_loops.start)));
            let [Some(start), Some(end)] = bytes else { return Err(lost()) };
            top.loop_start = from_index(loops.len())?.into();
            // The root is drawn from the crown.
            if index > 0 {
                scratch.clear();
                old.get(start..end).and_then(|bytes| read_top(bytes, &mut scratch)).ok_or_else(lost)?;
                for vertex in &mut scratch.vertices {
                    *vertex = self.local(*vertex).ok_or_else(lost)?;
                }
                for end in &scratch.ends {
                    if let Some(last) = end.checked_sub(1).and_then(|last| scratch.vertices.get_mut(last)) {
                        *last |= LOOP_END;
                    }
                }
                encode_top(&scratch.vertices, &mut loops);
            }
            top.loop_end = from_index(loops.len())?.into();
        }
        loops.shrink_to_fit();
        (self.runs.tops, self.runs.top_loops) = (tops, loops);
        Ok(())
    }
}

fn from_index(index: usize) -> Result<u32, Broken> {
    u32::try_from(index).map_err(|_too_large| broken("section CRWN", "a chunk is too large"))
}

fn broken(place: &str, found: &str) -> Broken {
    Violation::new(Rule::Chunk, place.to_owned(), found.to_owned())
}
