//! The nodes above the chunks, and their roots: what stays in memory.

use std::mem::size_of;
use std::ops::Range;

use zerocopy::little_endian::U32;
use zerocopy::{FromBytes, Immutable, KnownLayout, Unaligned};

use super::{ChunkRecord, CrownHead, CrownRecord, PageEntry};
use crate::error::Violation;
use crate::loops::{Loops, read_top};
use crate::node::Node;
use crate::octahedral::NormalRecord;
use crate::records::{PAGE_BIT, TopRecord, VertexRecord, WeldRecord};
use crate::rule::Rule;
use crate::walk::{Broken, to_index};

/// The upper part of a tree, decoded from section `CRPG`; see [`crate::ChunkFile::crown`].
///
/// Its nodes are numbered in preorder, the root is 0. Vertices are named as in the whole tree.
#[derive(Debug, Default)]
pub struct Crown {
    pub(super) chunks: Vec<ChunkRecord>,
    pub(super) pages: Vec<PageEntry>,
    pub(super) nodes: Vec<CrownRecord>,
    pub(super) ids: Vec<U32>,
    pub(super) vertices: Vec<VertexRecord>,
    pub(super) normals: Vec<NormalRecord>,
    pub(super) colors: Vec<[u8; 4]>,
    pub(super) loops: Vec<u8>,
    /// Copies made by cutting seams and what they are copies of, both ways, in order.
    pub(super) twins: Vec<[u32; 2]>,
    /// Vertices and faces of the whole tree.
    pub(super) vertex_count: u32,
    pub(super) face_count: u32,
}

/// What is below a node of the crown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CrownChild {
    /// Two nodes of the crown, the left one first.
    Nodes([u32; 2]),
    /// The inside of a chunk, whose root the node is.
    Chunk(u32),
}

impl Crown {
    /// Reads a section and checks what later steps rely on.
    pub(super) fn parse(
        bytes: &[u8],
        weld: &[WeldRecord],
        [vertex_count, face_count]: [u32; 2],
        pages: usize,
        [normals, colors]: [bool; 2],
    ) -> Result<Self, Broken> {
        let mut rest = bytes;
        let short = || broken("section CRPG".to_owned(), "it ends too early".to_owned());
        let head = take::<CrownHead>(&mut rest, 1).and_then(<[_]>::first).copied().ok_or_else(short)?;
        let [chunks, nodes, vertices] = [head.chunks, head.nodes, head.vertices].map(|n| to_index(n.get()));
        let (Some(chunks), Some(nodes), Some(vertices)) = (chunks, nodes, vertices) else {
            return Err(short());
        };
        let crown = Self {
            chunks: take(&mut rest, chunks).ok_or_else(short)?.to_vec(),
            pages: take(&mut rest, pages).ok_or_else(short)?.to_vec(),
            nodes: take(&mut rest, nodes).ok_or_else(short)?.to_vec(),
            ids: take(&mut rest, vertices).ok_or_else(short)?.to_vec(),
            vertices: take(&mut rest, vertices).ok_or_else(short)?.to_vec(),
            normals: take(&mut rest, if normals { vertices } else { 0 }).ok_or_else(short)?.to_vec(),
            colors: take(&mut rest, if colors { vertices } else { 0 }).ok_or_else(short)?.to_vec(),
            loops: rest.to_vec(),
            twins: twins_of(weld),
            vertex_count,
            face_count,
        };
        if to_index(head.loop_bytes.get()) != Some(rest.len()) {
            return Err(short());
        }
        crown.check_order()?;
        Ok(crown)
    }

    /// Nodes stand in preorder, chunks in the order in which nodes name them, vertices ascend.
    fn check_order(&self) -> Result<(), Broken> {
        let mut rights = Vec::new();
        let (mut expected, mut chunks) = (Some(0_usize), 0_u32);
        for (index, node) in self.nodes.iter().enumerate() {
            let lost = || broken(format!("crown node {index}"), "it is not in preorder".to_owned());
            if expected != Some(index) {
                return Err(lost());
            }
            let (left, right) = (node.top.left.get(), node.top.right.get());
            if left & PAGE_BIT == 0 {
                expected = index.checked_add(1);
                if to_index(left) != expected || right & PAGE_BIT != 0 {
                    return Err(lost());
                }
                rights.push(to_index(right));
            } else {
                if left != chunks | PAGE_BIT || right != left {
                    return Err(lost());
                }
                chunks = chunks.saturating_add(1);
                expected = rights.pop().unwrap_or(None);
            }
            let corner = to_index(node.corner.get());
            if corner.is_none_or(|c| c >= self.vertices.len()) {
                return Err(lost());
            }
        }
        let ordered = self.ids.iter().zip(self.ids.iter().skip(1)).all(|(a, b)| a.get() < b.get());
        let in_range = self.ids.last().is_none_or(|id| id.get() < self.vertex_count);
        // Each chunk has pages of its own, and each page its run of vertices.
        let pages = self.chunks.iter().map(|chunk| chunk.page.get());
        let owned = pages.clone().zip(pages.skip(1)).all(|(a, b)| a < b)
            && self.chunks.first().is_none_or(|chunk| chunk.page.get() == 0);
        let firsts = self.pages.iter().map(|page| page.first_vertex.get());
        let runs = firsts.clone().zip(firsts.skip(1)).all(|(a, b)| a <= b)
            && self.pages.last().is_none_or(|page| page.first_vertex.get() <= self.vertex_count);
        let all = to_index(chunks) == Some(self.chunks.len());
        if expected.is_some() || !all || !ordered || !in_range || !owned || !runs {
            let found = "its chunks, pages or vertices do not stand in order".to_owned();
            return Err(broken("section CRPG".to_owned(), found));
        }
        Ok(())
    }

    /// Number of chunks.
    pub fn chunk_count(&self) -> u32 {
        u32::try_from(self.chunks.len()).unwrap_or(u32::MAX)
    }

    /// Number of pages of the whole tree.
    pub fn page_count(&self) -> u32 {
        u32::try_from(self.pages.len()).unwrap_or(u32::MAX)
    }

    /// The chunk that a page lies in; some chunk where there is no such page.
    pub fn chunk_of(&self, page: u32) -> u32 {
        let after = self.chunks.partition_point(|chunk| chunk.page.get() <= page);
        u32::try_from(after.saturating_sub(1)).unwrap_or(u32::MAX)
    }

    /// The page that owns a vertex; none if there is no such vertex.
    pub fn owner_of(&self, vertex: u32) -> Option<u32> {
        if vertex >= self.vertex_count {
            return None;
        }
        let after = self.pages.partition_point(|page| page.first_vertex.get() <= vertex);
        u32::try_from(after.checked_sub(1)?).ok()
    }

    /// The vertices that a page owns.
    pub fn vertices_of(&self, page: u32) -> Option<Range<u32>> {
        let index = to_index(page)?;
        let start = self.pages.get(index)?.first_vertex.get();
        let next = self.pages.get(index.checked_add(1)?);
        Some(start..next.map_or(self.vertex_count, |next| next.first_vertex.get()))
    }

    /// A node, decoded.
    pub fn node(&self, node: u32) -> Option<Node> {
        Some(Node::of_top(&self.record(node)?.top))
    }

    /// What is below a node.
    pub fn below(&self, node: u32) -> Option<CrownChild> {
        let top = &self.record(node)?.top;
        let (left, right) = (top.left.get(), top.right.get());
        Some(if left & PAGE_BIT == 0 {
            CrownChild::Nodes([left, right])
        } else {
            CrownChild::Chunk(left & !PAGE_BIT)
        })
    }

    /// The boundary loops of a node, by the names of vertices in the whole tree.
    ///
    /// None if the loops do not end or name vertices that are not there.
    pub fn read_loops(&self, node: u32, out: &mut Loops) -> Option<()> {
        out.clear();
        let top = &self.record(node)?.top;
        let bytes = self.loops.get(to_index(top.loop_start.get())?..to_index(top.loop_end.get())?)?;
        read_top(bytes, out)?;
        out.vertices.iter().all(|v| *v < self.vertex_count).then_some(())
    }

    /// The place of a vertex among those of the crown, if it is there.
    pub fn find(&self, vertex: u32) -> Option<usize> {
        self.ids.binary_search_by_key(&vertex, |id| id.get()).ok()
    }

    /// The vertices that stand in the same place as one, where a seam was cut. They are drawn if it is.
    pub fn twins(&self, vertex: u32) -> impl Iterator<Item = u32> {
        let of = |vertex: u32| {
            let start = self.twins.partition_point(|[v, _]| *v < vertex);
            let run = self.twins.get(start..).unwrap_or_default().iter();
            run.take_while(move |[v, _]| *v == vertex).map(|[_, twin]| *twin)
        };
        // Of a copy: what it is a copy of, and its other copies.
        of(vertex).flat_map(move |twin| std::iter::once(twin).chain(of(twin))).filter(move |v| *v != vertex)
    }

    /// The first face of a node.
    pub fn first_face(&self, node: u32) -> Option<u32> {
        Some(self.record(node)?.top.first_face.get())
    }

    /// Number of faces of the whole tree.
    pub fn face_count(&self) -> u32 {
        self.face_count
    }

    /// The names of its vertices, which ascend.
    pub fn ids(&self) -> impl Iterator<Item = u32> {
        self.ids.iter().map(|id| id.get())
    }

    /// The records of its vertices.
    pub fn vertices(&self) -> &[VertexRecord] {
        &self.vertices
    }

    /// The normals of its vertices; empty if the file has none.
    pub fn normals(&self) -> &[NormalRecord] {
        &self.normals
    }

    /// The colours of its vertices; empty if the file has none.
    pub fn colors(&self) -> &[[u8; 4]] {
        &self.colors
    }

    /// The record of a node as that of a top node; loops and children mean nothing.
    pub fn top(&self, node: u32) -> Option<TopRecord> {
        Some(self.record(node)?.top)
    }

    /// The first corner of a node's first face: its name, and its place among the vertices of the crown.
    pub fn corner(&self, node: u32) -> Option<(u32, usize)> {
        let place = to_index(self.record(node)?.corner.get())?;
        Some((self.ids.get(place)?.get(), place))
    }

    /// Bytes of memory that it takes.
    pub fn bytes(&self) -> u64 {
        let bytes = [
            size_of_val(self.chunks.as_slice()),
            size_of_val(self.pages.as_slice()),
            size_of_val(self.nodes.as_slice()),
            size_of_val(self.ids.as_slice()),
            size_of_val(self.vertices.as_slice()),
            size_of_val(self.normals.as_slice()),
            size_of_val(self.colors.as_slice()),
            size_of_val(self.twins.as_slice()),
            self.loops.len(),
            size_of::<Self>(),
        ];
        bytes.into_iter().map(|n| u64::try_from(n).unwrap_or(u64::MAX)).fold(0, u64::saturating_add)
    }

    pub(super) fn record(&self, node: u32) -> Option<&CrownRecord> {
        self.nodes.get(to_index(node)?)
    }
}

/// The first elements of a run of bytes, which are taken off it.
pub(super) fn take<'a, T>(bytes: &mut &'a [u8], count: usize) -> Option<&'a [T]>
where
    T: FromBytes + Immutable + KnownLayout + Unaligned,
{
    let (taken, rest) = bytes.split_at_checked(count.checked_mul(size_of::<T>())?)?;
    *bytes = rest;
    <[T]>::ref_from_bytes(taken).ok()
}

fn twins_of(weld: &[WeldRecord]) -> Vec<[u32; 2]> {
    let pairs = weld.iter().map(|w| [w.vertex.get(), w.representative.get()]);
    let mut twins: Vec<[u32; 2]> = pairs.flat_map(|[a, b]| [[a, b], [b, a]]).collect();
    twins.sort_unstable();
    twins
}

fn broken(place: String, found: String) -> Broken {
    Violation::new(Rule::Chunk, place, found)
}
