//! The walk over crown and chunks, and the mesh it leaves behind.

use std::collections::HashMap;

use crate::extra::Extra;
use crate::part::{Part, Settled, Sight};
use crate::stitch::Stitcher;
use crate::{Error, Extraction, Selection, Stats};
use fct::{Child, ChildRef, Chunk, Crown, CrownChild, Loops, NormalRecord, Patch, Subtree, VertexRecord};

/// A mesh with vertices of its own; reuse it to keep its memory.
#[derive(Debug, Default)]
pub struct Streamed {
    /// Indices into [`Streamed::vertices`], three a triangle, counter-clockwise.
    pub indices: Vec<u32>,
    /// The records of the vertices. One on the border of chunks may be there once for each, with equal ids.
    pub vertices: Vec<VertexRecord>,
    /// How the whole tree names the vertices.
    pub ids: Vec<u32>,
    /// Their normals; empty if the file has none.
    pub normals: Vec<NormalRecord>,
    /// Their colours; empty if the file has none.
    pub colors: Vec<[u8; 4]>,
    /// The chunks that are drawn within, in the order of the tree.
    pub entered: Vec<Wish>,
    /// The chunks that the selection goes into and that were not there: their roots are drawn.
    pub missing: Vec<Wish>,
    /// The chunks that a selection of half the tolerance would go into too.
    pub close: Vec<Wish>,
    /// Chunks that were there and are damaged: their roots are drawn.
    pub damaged: Vec<Damaged>,
    /// What was visited, culled and drawn.
    pub stats: Stats,
    scratch: Scratch,
}

/// A chunk that is used or worth reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wish {
    /// Its number.
    pub chunk: u32,
    /// The error of its root over what is allowed there: over 1 where the chunk is needed; may be infinite.
    pub urgency: f64,
    /// The same error as a length, which tells apart those of infinite urgency.
    pub key: f32,
}

/// A chunk that broke a rule where the walk came by.
#[derive(Debug)]
pub struct Damaged {
    /// Its number.
    pub chunk: u32,
    /// What is wrong with it.
    pub error: Error,
}

#[derive(Debug, Default)]
struct Scratch {
    stitcher: Stitcher,
    patch: Patch,
    loops: Loops,
    /// What is drawn below the root of a chunk, by the chunk's numbers.
    below: Extraction,
    /// Triangles by the numbers of the patch.
    triangles: Vec<u32>,
    /// What the vertices of a chunk are called in the mesh.
    numbers: Vec<u32>,
    /// For a vertex that is kin of entered chunks: one of them, by its place among those, and its number there.
    kin: HashMap<u32, (usize, u32)>,
    /// Nodes of the crown to be drawn.
    nodes: Vec<u32>,
}

/// Extracts the mesh of `selection` into `out` from a crown and the chunks that there are.
///
/// What a budget adds to a selection ([`Selection::extra`]) is not taken: it names nodes and vertices of whole trees.
/// Where parts are culled, vertices on their borders may be left out that [`crate::extract`] draws; what is drawn is
/// never finer. Of a missing chunk whose root cannot be drawn, since it joins components or is a closed one, nothing is
/// drawn.
///
/// # Errors
/// [`Error::Selection`] when the selection is not finite, [`Error::TooManyTriangles`]. Chunks that are damaged are no
/// error, but listed.
pub fn extract_chunks<'a>(
    crown: &Crown,
    chunks: &dyn Fn(u32) -> Option<&'a Chunk>,
    selection: &Selection,
    out: &mut Streamed,
) -> Result<(), Error> {
    selection.check()?;
    out.clear();
    if selection.extra.is_empty() {
        return Walk { crown, selection, entered: Vec::new() }.run(chunks, out);
    }
    let plain = Selection { extra: Extra::default(), ..selection.clone() };
    Walk { crown, selection: &plain, entered: Vec::new() }.run(chunks, out)
}

/// One extraction.
struct Walk<'a, 'b> {
    crown: &'b Crown,
    selection: &'b Selection,
    /// The chunks that are drawn within, in the order of the tree.
    entered: Vec<&'a Chunk>,
}

/// Where a vertex is found.
enum Found<'a> {
    Crown(usize),
    Chunk(&'a Chunk, usize),
}

impl<'a> Walk<'a, '_> {
    fn run(mut self, chunks: &dyn Fn(u32) -> Option<&'a Chunk>, out: &mut Streamed) -> Result<(), Error> {
        let mut whole = Subtree::default();
        whole.face_end = self.crown.face_count();
        if whole.face_end > 1 {
            whole.child = ChildRef::node(0);
        }
        let mut stack = vec![(0, whole, self.selection.settled())];
        while let Some((node, subtree, settled)) = stack.pop() {
            let Some(record) = self.crown.node(node) else { continue };
            if subtree.face_count() == 1 {
                out.scratch.nodes.push(node);
                continue;
            }
            let settled = match self.selection.sight(&subtree, &record, settled, &mut out.stats) {
                Sight::Culled => continue,
                Sight::Refined { settled } => Some(settled),
                Sight::Drawn => None,
            };
            match (self.crown.below(node), settled) {
                (Some(CrownChild::Nodes([left, right])), Some(settled)) => {
                    let Some(split) = self.crown.first_face(right) else { continue };
                    let [left_faces, right_faces] = halves(&subtree, split);
                    stack.push((right, right_faces, settled));
                    stack.push((left, left_faces, settled));
                    continue;
                }
                (Some(CrownChild::Chunk(chunk)), settled) => {
                    let (key, urgency) = self.selection.level_of_node(&self.selection.tolerance, &record);
                    // Where nothing is allowed flat chunks are needed too.
                    let urgency = if settled.is_some() { urgency.max(1.0) } else { urgency };
                    let wish = Wish { chunk, urgency, key };
                    match (settled, chunks(chunk)) {
                        (Some(settled), Some(found)) => match self.draw_chunk(found, settled, out) {
                            Ok(()) => {
                                out.entered.push(wish);
                                continue;
                            }
                            Err(Error::Tree(error)) => {
                                out.damaged.push(Damaged { chunk, error: Error::Tree(error) });
                            }
                            Err(error) => return Err(error),
                        },
                        (Some(_), None) => out.missing.push(wish),
                        (None, None) if urgency > 0.5 => out.close.push(wish),
                        (None, _) => {}
                    }
                }
                (_, None) | (None, Some(_)) => {}
            }
            out.scratch.nodes.push(node);
        }
        self.draw_crown(out)?;
        out.stats.triangles = out.indices.len() as u64 / 3;
        Ok(())
    }

    /// Draws what is below the root of a chunk, or nothing of it.
    fn draw_chunk(&mut self, chunk: &'a Chunk, settled: Settled, out: &mut Streamed) -> Result<(), Error> {
        let reader = chunk.reader();
        let below = &mut out.scratch.below;
        below.clear();
        for subtree in reader.children(&chunk.root())? {
            below.append_from(&reader, self.selection, &Part { subtree, settled })?;
        }
        // Its triangles are counted with all others.
        out.stats.add(&Stats { triangles: 0, ..below.stats });
        let records = reader.vertices();
        let numbers = &mut out.scratch.numbers;
        numbers.clear();
        numbers.resize(records.len(), u32::MAX);
        for &vertex in &out.scratch.below.indices {
            let at = vertex as usize;
            // What was drawn is in range.
            let (Some(number), Some(record)) = (numbers.get_mut(at), records.get(at)) else { continue };
            if *number == u32::MAX {
                *number = next_number(&out.vertices)?;
                out.vertices.push(*record);
                out.ids.push(chunk.vertex_id(vertex).unwrap_or(u32::MAX));
                out.normals.extend(chunk.normals().get(at));
                out.colors.extend(chunk.colors().get(at));
            }
            out.indices.push(*number);
        }
        let place = self.entered.len();
        for (&id, number) in chunk.kin().iter().zip(chunk.own_vertices().len() as u32..) {
            out.scratch.kin.insert(id, (place, number));
        }
        self.entered.push(chunk);
        Ok(())
    }

    /// Draws the nodes of the crown that are in the cut, or stand for chunks that are missing.
    fn draw_crown(&self, out: &mut Streamed) -> Result<(), Error> {
        let Scratch { stitcher, patch, kin, triangles, numbers, nodes, loops, .. } = &mut out.scratch;
        patch.clear();
        triangles.clear();
        let find = |id: u32| {
            self.find(kin, id).or_else(|| self.crown.twins(id).find_map(|twin| self.find(kin, twin)))
        };
        let mut drawn = Vec::with_capacity(nodes.len());
        for &node in &*nodes {
            let subtree = patch.push(self.crown, node, |id| find(id).map(|found| self.record(&found)));
            // A crown was checked when it was opened, but for its loops; what those leave out is not drawn.
            drawn.extend(subtree.zip(self.crown.node(node)));
        }
        let reader = patch.reader();
        for (subtree, node) in &drawn {
            out.stats.clusters += 1;
            // A single face has no plane and no bound of its own.
            if node.bound == 0.0 && node.radius == 0.0 {
                reader.read_loops(subtree, loops)?;
                triangles.extend_from_slice(&loops.vertices);
                continue;
            }
            out.stats.bound = out.stats.bound.max(node.bound);
            out.stats.folded += stitcher.draw(&reader, self.selection, subtree, node, triangles)?;
        }
        numbers.clear();
        numbers.resize(reader.vertices().len(), u32::MAX);
        for &vertex in &*triangles {
            let at = vertex as usize;
            let (Some(number), Some(record), Some(id)) =
                (numbers.get_mut(at), reader.vertices().get(at), patch.ids().get(at))
            else {
                continue;
            };
            if *number == u32::MAX {
                *number = next_number(&out.vertices)?;
                out.vertices.push(*record);
                out.ids.push(*id);
                let (normal, color) = find(*id).map_or((None, None), |found| self.attributes(&found));
                out.normals.extend(normal);
                out.colors.extend(color);
            }
            out.indices.push(*number);
        }
        Ok(())
    }

    /// Where a vertex is that may be drawn.
    fn find(&self, kin: &HashMap<u32, (usize, u32)>, id: u32) -> Option<Found<'a>> {
        if let Some(place) = self.crown.find(id) {
            return Some(Found::Crown(place));
        }
        // Chunks own runs of vertices, in order.
        let after = self.entered.partition_point(|chunk| chunk.own_vertices().start <= id);
        let owner = after.checked_sub(1).and_then(|at| self.entered.get(at));
        if let Some((chunk, own)) = owner.and_then(|chunk| Some((*chunk, chunk.own_vertex(id)?))) {
            return Some(Found::Chunk(chunk, own as usize));
        }
        let &(place, number) = kin.get(&id)?;
        Some(Found::Chunk(self.entered.get(place)?, number as usize))
    }

    fn record(&self, found: &Found<'_>) -> VertexRecord {
        let record = match found {
            Found::Crown(place) => self.crown.vertices().get(*place),
            Found::Chunk(chunk, at) => chunk.reader().vertices().get(*at),
        };
        record.copied().unwrap_or_default()
    }

    fn attributes(&self, found: &Found<'_>) -> (Option<NormalRecord>, Option<[u8; 4]>) {
        let (normals, colors, at) = match found {
            Found::Crown(place) => (self.crown.normals(), self.crown.colors(), *place),
            Found::Chunk(chunk, at) => (chunk.normals(), chunk.colors(), *at),
        };
        (normals.get(at).copied(), colors.get(at).copied())
    }
}

/// The children of a node of the crown whose right child begins at face `split`.
fn halves(subtree: &Subtree, split: u32) -> [Subtree; 2] {
    let name = |first: u32, end: u32, offset: u32| match subtree.child.kind() {
        Child::Node(node) if end.saturating_sub(first) > 1 => ChildRef::node(node.wrapping_add(offset)),
        _ => ChildRef::face(first),
    };
    let (mut left, mut right) = (*subtree, *subtree);
    left.face_end = split;
    left.child = name(subtree.first_face, split, 1);
    right.first_face = split;
    right.child = name(split, subtree.face_end, left.face_count());
    [left, right]
}

fn next_number(vertices: &[VertexRecord]) -> Result<u32, Error> {
    u32::try_from(vertices.len()).ok().filter(|n| *n < u32::MAX).ok_or(Error::TooManyTriangles)
}

impl Streamed {
    fn clear(&mut self) {
        self.indices.clear();
        self.vertices.clear();
        self.ids.clear();
        self.normals.clear();
        self.colors.clear();
        self.entered.clear();
        self.missing.clear();
        self.close.clear();
        self.damaged.clear();
        self.stats = Stats::default();
        self.scratch.kin.clear();
        self.scratch.nodes.clear();
    }
}
