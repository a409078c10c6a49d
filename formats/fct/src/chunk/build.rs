//! From a tree to its chunks, by a rule that leaves no choice: verifying makes them again and compares.

use std::path::Path;

use zerocopy::IntoBytes;
use zerocopy::little_endian::U32;

use super::{CHUNK_FACES, CROWN_SHARE, ChunkRecord, CrownHead, CrownRecord};
use crate::error::Violation;
use crate::hash::hash64_of;
use crate::loops::Loops;
use crate::node::Node;
use crate::octahedral::NormalRecord;
use crate::pack::{PackError, Packed, encode_top};
use crate::records::{LOOP_END, PAGE_BIT, TopRecord, VertexRecord, pack};
use crate::rule::Rule;
use crate::subtree::{Place, Subtree};
use crate::walk::{Broken, Reader, to_index};

/// The sections `CRWN` and `KINS` of a tree.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ChunkData {
    /// Section `CRWN`.
    pub crown: Vec<u8>,
    /// Section `KINS`.
    pub kins: Vec<u8>,
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
        let mut kins = Vec::new();
        let crown = build(&Source { reader, normals, colors }, chunk_faces, &mut |bytes| {
            kins.extend_from_slice(bytes);
            Ok(())
        })
        .map_err(|violation| PackError::NoTree(violation.to_string()))?;
        Ok(Self { crown, kins })
    }
}

/// What chunks are made of.
pub(crate) struct Source<'a> {
    pub(crate) reader: Reader<'a>,
    pub(crate) normals: Option<&'a [NormalRecord]>,
    pub(crate) colors: Option<&'a [[u8; 4]]>,
}

/// Makes section `CRWN`, and shows section `KINS` chunk by chunk.
pub(crate) fn build(
    source: &Source<'_>,
    chunk_faces: u32,
    kins: &mut dyn FnMut(&[u8]) -> Result<(), Broken>,
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
            let chunk = parts.chunk(source, &subtree, kins)?;
            parts.chunks.push(chunk);
        }
        parts.nodes.push(node);
    }
    parts.assemble(source, chunk_faces)
}

/// What section `CRWN` is put together from.
#[derive(Default)]
struct Parts {
    chunks: Vec<ChunkRecord>,
    nodes: Vec<CrownRecord>,
    /// Vertices of the crown, with repetitions.
    vertices: Vec<u32>,
    /// The first corner of each node.
    corners: Vec<u32>,
    loops: Vec<u8>,
    scratch: Loops,
    kins: usize,
}

impl Parts {
    /// The record of a node but for its children; its loops and vertices are added.
    fn crown_node(&mut self, reader: &Reader<'_>, subtree: &Subtree) -> Result<CrownRecord, Broken> {
        let mut top = match subtree.place {
            Place::Top { record } => *reader.top(record)?,
            Place::Page { .. } if subtree.face_count() == 1 => {
                TopRecord { axis: pack([0.0, 0.0, 1.0]), cos: (-1.0).into(), ..TopRecord::default() }
            }
            Place::Page { .. } => reader.decode(subtree)?.to_top(),
        };
        top.first_face = subtree.first_face.into();
        top.loop_start = count(self.loops.len())?;
        // A node that is never drawn needs no loops, and may have none.
        if top.bound.get() != f32::INFINITY {
            reader.load_loops(subtree, &mut self.scratch)?;
            let (bound, budget) = (top.bound.get() * CROWN_SHARE, top.budget.get() * CROWN_SHARE);
            for &vertex in &self.scratch.vertices {
                let record = vertex_of(reader, vertex, subtree)?;
                if record.bound() >= bound || record.budget() >= budget {
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

    /// The record of a chunk; its kin are shown.
    fn chunk(
        &mut self,
        source: &Source<'_>,
        subtree: &Subtree,
        kins: &mut dyn FnMut(&[u8]) -> Result<(), Broken>,
    ) -> Result<ChunkRecord, Broken> {
        let reader = &source.reader;
        let first_page = reader.pages.partition_point(|p| p.first_face.get() < subtree.first_face);
        let end_page = reader.pages.partition_point(|p| p.first_face.get() < subtree.face_end);
        let lost = || broken(format!("faces {}..{}", subtree.first_face, subtree.face_end));
        let pages = reader.pages.get(first_page..end_page).ok_or_else(lost)?;
        let (Some(first), Some(last)) = (pages.first(), pages.last()) else { return Err(lost()) };
        let end_of = |first: U32, count: U32| Some(to_index(first.get())?..to_index(count.get())?);
        let plus = |first: U32, count: u16| first.get().checked_add(u32::from(count)).map(U32::new);

        let tops = match subtree.place {
            Place::Top { record } => {
                let start = to_index(record).ok_or_else(lost)?;
                start..start.saturating_add(pages.len()).saturating_sub(1)
            }
            Place::Page { .. } => 0..0,
        };
        let top_records = reader.tops.get(tops.clone()).ok_or_else(lost)?;
        let top_loops = match (top_records.first(), top_records.last()) {
            (Some(first), Some(last)) => end_of(first.loop_start, last.loop_end),
            _ => Some(0..0),
        };
        let nodes = to_index(subtree.first_face).and_then(|face| {
            let start = face.checked_sub(first_page)?;
            let faces = to_index(subtree.face_count())?;
            Some(start..start.checked_add(faces.checked_sub(pages.len())?)?)
        });
        let page_loops =
            plus(last.first_loop, last.loop_bytes.get()).and_then(|end| end_of(first.first_loop, end));
        let links = plus(last.first_link, last.links.get()).and_then(|end| end_of(first.first_link, end));
        let vertices =
            plus(last.first_vertex, last.own_vertices.get()).and_then(|end| end_of(first.first_vertex, end));
        let (Some(top_loops), Some(nodes), Some(page_loops), Some(links), Some(vertices)) =
            (top_loops, nodes, page_loops, links, vertices)
        else {
            return Err(lost());
        };

        let links = reader.links.get(links).ok_or_else(lost)?;
        let kin = kin_of(links, first.first_vertex.get());
        let mut copies = Vec::new();
        append_vertices(source, &kin, &mut copies)?;
        kins(&copies)?;
        let normals = match source.normals {
            Some(normals) => normals.get(vertices.clone()).ok_or_else(lost)?.as_bytes(),
            None => &[],
        };
        let colors = match source.colors {
            Some(colors) => colors.get(vertices.clone()).ok_or_else(lost)?.as_flattened(),
            None => &[],
        };
        let hash = hash64_of(&[
            top_records.as_bytes(),
            reader.top_loops.get(top_loops.clone()).ok_or_else(lost)?,
            pages.as_bytes(),
            reader.nodes.get(nodes).ok_or_else(lost)?.as_bytes(),
            subtree.of(reader.faces).as_bytes(),
            reader.loops.get(page_loops).ok_or_else(lost)?,
            links.as_bytes(),
            reader.vertices.get(vertices).ok_or_else(lost)?.as_bytes(),
            normals,
            colors,
            &copies,
        ]);
        let first_kin = self.kins;
        self.kins = self.kins.saturating_add(kin.len());
        Ok(ChunkRecord {
            hash: hash.into(),
            root: subtree.child.raw().into(),
            top: count(tops.start)?,
            top_loop: count(top_loops.start)?,
            top_loop_bytes: count(top_loops.len())?,
            page: count(first_page)?,
            face: subtree.first_face.into(),
            page_loop: first.first_loop,
            link: first.first_link,
            vertex: first.first_vertex,
            kin: count(first_kin)?,
            reserved: U32::ZERO,
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
        out.extend_from_slice(self.nodes.as_bytes());
        for vertex in &self.vertices {
            out.extend_from_slice(&vertex.to_le_bytes());
        }
        append_vertices(source, &self.vertices, &mut out)?;
        out.extend_from_slice(&self.loops);
        Ok(out)
    }
}

/// The vertices that links name before `first_vertex`, in order.
pub(super) fn kin_of(links: &[U32], first_vertex: u32) -> Vec<u32> {
    let mut kin: Vec<u32> = links.iter().map(|v| v.get()).filter(|v| *v < first_vertex).collect();
    kin.sort_unstable();
    kin.dedup();
    kin
}

/// Appends copies of vertices: records, then normals and colours where there are any.
fn append_vertices(source: &Source<'_>, vertices: &[u32], out: &mut Vec<u8>) -> Result<(), Broken> {
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

fn vertex_of<'a>(reader: &Reader<'a>, vertex: u32, subtree: &Subtree) -> Result<&'a VertexRecord, Broken> {
    to_index(vertex).and_then(|v| reader.vertices.get(v)).ok_or_else(|| broken(subtree.to_string()))
}

fn count(n: usize) -> Result<U32, Broken> {
    u32::try_from(n).map(U32::new).map_err(|_too_long| broken("section CRWN".to_owned()))
}

fn broken(place: String) -> Broken {
    Violation::new(Rule::Chunk, place, "it cannot be put into chunks".to_owned())
}

impl Node {
    /// A record that reads as this node; without children, faces and loops.
    fn to_top(self) -> TopRecord {
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
