//! From a tree to its chunks, by a rule that leaves no choice: verifying makes them again and compares.

use std::ops::Range;
use std::path::Path;

use zerocopy::IntoBytes;
use zerocopy::little_endian::U32;

use super::{CHUNK_FACES, ChunkRecord, CrownHead, CrownRecord, PageEntry, belongs};
use crate::error::Violation;
use crate::hash::hash64_of;
use crate::loops::Loops;
use crate::node::Node;
use crate::octahedral::NormalRecord;
use crate::pack::{PackError, Packed, encode_top};
use crate::records::{LOOP_END, PAGE_BIT, PageRecord, TopRecord, VertexRecord, pack};
use crate::rule::Rule;
use crate::subtree::{Place, Subtree};
use crate::walk::{Broken, Reader, to_index};

/// The sections `CRPG` and `CHTP` of a tree.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ChunkData {
    /// Section `CRPG`.
    pub crown: Vec<u8>,
    /// Section `CHTP`.
    pub tops: Vec<u8>,
}

impl ChunkData {
    /// Divides a tree into chunks of at most [`CHUNK_FACES`] faces.
    ///
    /// # Errors
    /// [`PackError::NoTree`] when the records do not fit together.
    pub fn new(
        clusters: &Packed,
        vertices: &[VertexRecord],
        normals: Option<&[NormalRecord]>,
        colors: Option<&[[u8; 4]]>,
    ) -> Result<Self, PackError> {
        Self::with_faces(clusters, vertices, normals, colors, CHUNK_FACES)
    }

    /// The same for chunks of another size.
    ///
    /// # Errors
    /// As [`ChunkData::new`].
    pub fn with_faces(
        clusters: &Packed,
        vertices: &[VertexRecord],
        normals: Option<&[NormalRecord]>,
        colors: Option<&[[u8; 4]]>,
        chunk_faces: u32,
    ) -> Result<Self, PackError> {
        let reader = Reader {
            tops: &clusters.tops,
            top_loops: &clusters.top_loops,
            top_corners: &[],
            pages: &clusters.pages,
            nodes: &clusters.nodes,
            faces: &clusters.faces,
            links: &clusters.links,
            loops: &clusters.loops,
            vertices,
            path: Path::new(""),
        };
        let mut tops = Vec::new();
        let crown = build(&Source { reader, normals, colors }, chunk_faces, &mut |bytes| {
            tops.extend_from_slice(bytes);
            Ok(())
        })
        .map_err(|violation| PackError::NoTree(violation.to_string()))?;
        Ok(Self { crown, tops })
    }
}

/// What chunks are made of.
pub(crate) struct Source<'a> {
    pub(crate) reader: Reader<'a>,
    pub(crate) normals: Option<&'a [NormalRecord]>,
    pub(crate) colors: Option<&'a [[u8; 4]]>,
}

/// Makes section `CRPG`, and shows section `CHTP` chunk by chunk.
pub(crate) fn build(
    source: &Source<'_>,
    chunk_faces: u32,
    tops: &mut dyn FnMut(&[u8]) -> Result<(), Broken>,
) -> Result<Vec<u8>, Broken> {
    let mut parts = Parts::default();
    // A node of the crown, and the one above it if it is the right child there.
    let mut stack = vec![(source.reader.whole(), None::<usize>)];
    while let Some((subtree, parent)) = stack.pop() {
        let index = parts.nodes.len();
        if let Some(above) = parent.and_then(|p| parts.nodes.get_mut(p)) {
            above.top.right = count(index)?;
        }
        let mut node = parts.crown_node(&source.reader, &subtree)?;
        let divided = matches!(subtree.place, Place::Top { .. }) && subtree.face_count() > chunk_faces;
        if divided {
            node.top.left = count(index.saturating_add(1))?;
            let [left, right] = source.reader.split(&subtree)?;
            stack.push((right, Some(index)));
            stack.push((left, None));
        } else {
            let name = U32::new(count(parts.chunks.len())?.get() | PAGE_BIT);
            (node.top.left, node.top.right) = (name, name);
            let chunk = parts.chunk(source, &subtree, tops)?;
            parts.chunks.push(chunk);
        }
        parts.nodes.push(node);
    }
    for page in source.reader.pages {
        parts.pages.push(page_entry(source, parts.pages.len(), page)?);
    }
    parts.assemble(source, chunk_faces)
}

/// What section `CRPG` is put together from.
#[derive(Default)]
struct Parts {
    chunks: Vec<ChunkRecord>,
    pages: Vec<PageEntry>,
    nodes: Vec<CrownRecord>,
    /// Vertices of the crown, with repetitions.
    vertices: Vec<u32>,
    /// The first corner of each node.
    corners: Vec<u32>,
    loops: Vec<u8>,
    scratch: Loops,
    /// Bytes of section `CHTP` so far.
    copies: usize,
}

impl Parts {
    /// The record of a node but for its children; its loops and vertices are added.
    fn crown_node(&mut self, reader: &Reader<'_>, subtree: &Subtree) -> Result<CrownRecord, Broken> {
        let mut top = match subtree.place {
            Place::Top { record } => *reader.top(record)?,
            Place::Page { .. } if subtree.face_count() == 1 => TopRecord::of_face(),
            Place::Page { .. } => reader.decode(subtree)?.to_top(),
        };
        top.first_face = subtree.first_face.into();
        top.loop_start = count(self.loops.len())?;
        // A node that is never drawn needs no loops, and may have none.
        if top.bound.get() != f32::INFINITY {
            reader.load_loops(subtree, &mut self.scratch)?;
            for &vertex in &self.scratch.vertices {
                if belongs(vertex_of(reader, vertex, subtree)?, [top.bound.get(), top.budget.get()]) {
                    self.vertices.push(vertex);
                }
            }
            let mut entries = self.scratch.vertices.clone();
            for end in &self.scratch.ends {
                if let Some(last) = end.checked_sub(1).and_then(|last| entries.get_mut(last)) {
                    *last |= LOOP_END;
                }
            }
            encode_top(&entries, &mut self.loops);
        }
        top.loop_end = count(self.loops.len())?;
        let corner = reader.corner_of(subtree)?;
        self.corners.push(corner);
        self.vertices.push(corner);
        Ok(CrownRecord { top, corner: U32::ZERO })
    }

    /// The record of a chunk; its part of section `CHTP` is shown.
    fn chunk(
        &mut self,
        source: &Source<'_>,
        subtree: &Subtree,
        tops: &mut dyn FnMut(&[u8]) -> Result<(), Broken>,
    ) -> Result<ChunkRecord, Broken> {
        let reader = &source.reader;
        let first_page = reader.pages.partition_point(|p| p.first_face.get() < subtree.first_face);
        let end_page = reader.pages.partition_point(|p| p.first_face.get() < subtree.face_end);
        let lost = || broken(format!("faces {}..{}", subtree.first_face, subtree.face_end));
        let pages = reader.pages.get(first_page..end_page).ok_or_else(lost)?;
        let (Some(first), Some(last)) = (pages.first(), pages.last()) else { return Err(lost()) };
        let top_range = match subtree.place {
            Place::Top { record } => {
                let start = to_index(record).ok_or_else(lost)?;
                start..start.saturating_add(pages.len()).saturating_sub(1)
            }
            Place::Page { .. } => 0..0,
        };
        let records = reader.tops.get(top_range.clone()).ok_or_else(lost)?;
        let top_loops = match (records.first(), records.last()) {
            (Some(first), Some(last)) => to_index(first.loop_start.get()).zip(to_index(last.loop_end.get())),
            _ => Some((0, 0)),
        };
        let (loop_start, loop_end) = top_loops.ok_or_else(lost)?;
        let top_loops = reader.top_loops.get(loop_start..loop_end).ok_or_else(lost)?;
        let links_end = last.first_link.get().checked_add(u32::from(last.links.get()));
        let links = run(reader.links, first.first_link.get(), links_end).ok_or_else(lost)?;

        let copies = super::copies::of_chunk(source, subtree)?;
        tops(&copies)?;
        let hash = hash64_of(&[records.as_bytes(), top_loops, pages.as_bytes(), links.as_bytes(), &copies]);
        let start = self.copies;
        self.copies = self.copies.saturating_add(copies.len());
        Ok(ChunkRecord {
            hash: hash.into(),
            root: subtree.child.raw().into(),
            top: count(top_range.start)?,
            top_loop: count(loop_start)?,
            top_loop_bytes: count(top_loops.len())?,
            page: count(first_page)?,
            link: first.first_link,
            copies: count(start)?,
        })
    }

    fn assemble(mut self, source: &Source<'_>, chunk_faces: u32) -> Result<Vec<u8>, Broken> {
        self.vertices.sort_unstable();
        self.vertices.dedup();
        for (node, corner) in self.nodes.iter_mut().zip(&self.corners) {
            node.corner = count(self.vertices.binary_search(corner).unwrap_or(0))?;
        }
        let head = CrownHead {
            chunk_faces: chunk_faces.into(),
            chunks: count(self.chunks.len())?,
            nodes: count(self.nodes.len())?,
            vertices: count(self.vertices.len())?,
            loop_bytes: count(self.loops.len())?,
            reserved: [U32::ZERO; 3],
        };
        let mut out = Vec::new();
        out.extend_from_slice(head.as_bytes());
        out.extend_from_slice(self.chunks.as_bytes());
        out.extend_from_slice(self.pages.as_bytes());
        out.extend_from_slice(self.nodes.as_bytes());
        for vertex in &self.vertices {
            out.extend_from_slice(&vertex.to_le_bytes());
        }
        append_vertices(source, &self.vertices, &mut out)?;
        out.extend_from_slice(&self.loops);
        Ok(out)
    }
}

/// What is kept of a page in memory.
fn page_entry(source: &Source<'_>, index: usize, page: &PageRecord) -> Result<PageEntry, Broken> {
    let reader = &source.reader;
    let lost = || broken(format!("section PAGE, page {index}"));
    let faces = u32::from(page.faces);
    let first_face = page.first_face.get();
    let first_node = count(index)?.get();
    let first_node = first_face.checked_sub(first_node).ok_or_else(lost)?;
    let nodes_end = first_node.checked_add(faces).and_then(|end| end.checked_sub(1));
    let nodes = run(reader.nodes, first_node, nodes_end).ok_or_else(lost)?;
    let faces = run(reader.faces, first_face, first_face.checked_add(faces)).ok_or_else(lost)?;
    let first_loop = page.first_loop.get();
    let loops = run(reader.loops, first_loop, first_loop.checked_add(u32::from(page.loop_bytes.get())))
        .ok_or_else(lost)?;
    let first_vertex = page.first_vertex.get();
    let vertices_end = first_vertex.checked_add(u32::from(page.own_vertices.get()));
    let vertices = run(reader.vertices, first_vertex, vertices_end).ok_or_else(lost)?;
    let normals = match source.normals {
        Some(normals) => run(normals, first_vertex, vertices_end).ok_or_else(lost)?.as_bytes(),
        None => &[],
    };
    let colors = match source.colors {
        Some(colors) => run(colors, first_vertex, vertices_end).ok_or_else(lost)?.as_flattened(),
        None => &[],
    };
    Ok(PageEntry {
        hash: hash64_of(&[nodes.as_bytes(), faces.as_bytes(), loops]).into(),
        vertex_hash: hash64_of(&[vertices.as_bytes(), normals, colors]).into(),
        first_vertex: page.first_vertex,
    })
}

/// Elements from one on, up to another; none if there are not so many.
fn run<T>(elements: &[T], start: u32, end: Option<u32>) -> Option<&[T]> {
    let range: Range<usize> = to_index(start)?..to_index(end?)?;
    elements.get(range)
}

/// Appends copies of vertices: records, then normals and colours where there are any.
pub(super) fn append_vertices(
    source: &Source<'_>,
    vertices: &[u32],
    out: &mut Vec<u8>,
) -> Result<(), Broken> {
    let lost = |vertex: u32| move || broken(format!("vertex {vertex}"));
    for &vertex in vertices {
        let record = to_index(vertex).and_then(|v| source.reader.vertices.get(v)).ok_or_else(lost(vertex))?;
        out.extend_from_slice(record.as_bytes());
    }
    if let Some(normals) = source.normals {
        for &vertex in vertices {
            let normal = to_index(vertex).and_then(|v| normals.get(v)).ok_or_else(lost(vertex))?;
            out.extend_from_slice(normal.as_bytes());
        }
    }
    if let Some(colors) = source.colors {
        for &vertex in vertices {
            out.extend_from_slice(to_index(vertex).and_then(|v| colors.get(v)).ok_or_else(lost(vertex))?);
        }
    }
    Ok(())
}

pub(super) fn vertex_of<'a>(
    reader: &Reader<'a>,
    vertex: u32,
    subtree: &Subtree,
) -> Result<&'a VertexRecord, Broken> {
    to_index(vertex).and_then(|v| reader.vertices.get(v)).ok_or_else(|| broken(subtree.to_string()))
}

pub(super) fn count(n: usize) -> Result<U32, Broken> {
    u32::try_from(n).map(U32::new).map_err(|_too_long| broken("section CRPG".to_owned()))
}

pub(super) fn broken(place: String) -> Broken {
    Violation::new(Rule::Chunk, place, "it cannot be put into chunks".to_owned())
}

impl Node {
    /// A record that reads as this node; without children, faces and loops.
    pub(super) fn to_top(self) -> TopRecord {
        TopRecord {
            center: pack(self.center),
            radius: self.radius.into(),
            bound: self.bound.into(),
            budget: self.budget.into(),
            axis: pack(self.axis()),
            cos: self.cos().into(),
            epsilon: self.epsilon().into(),
            plane: self.plane_record(),
            ..TopRecord::default()
        }
    }
}

impl TopRecord {
    /// What stands in the place of a node where there is a single face.
    pub(super) fn of_face() -> Self {
        TopRecord { axis: pack([0.0, 0.0, 1.0]), cos: (-1.0).into(), ..TopRecord::default() }
    }
}
