//! The walk over crown, chunks and pages, and the mesh it leaves behind.

use super::found::{Index, Vertices, emptied};
use super::plan::{Piece, Plan, Step, Wish};
use super::ready::Ready;
use crate::extra::Extra;
use crate::extraction::Source;
use crate::part::{Part, Settled, Sight};
use crate::stitch::Stitcher;
use crate::{Error, Extraction, Selection, Stats};
use fct::{
    Child, ChildRef, Chunk, ChunkPage, Crown, CrownChild, Loops, Node, NormalRecord, Patch, Subtree,
    VertexRecord,
};

/// A mesh with vertices of its own; reuse it to keep its memory. Once that has grown, extracting takes no more.
///
/// [`Mesh::fill_streamed`](crate::Mesh::fill_streamed) makes buffers for a GPU of it.
#[derive(Debug, Default)]
#[non_exhaustive]
pub struct Streamed {
    /// Indices into [`Streamed::vertices`], three a triangle, counter-clockwise.
    pub indices: Vec<u32>,
    /// The records of the vertices. One on the border of pages may be there once for each, with equal ids. Where to draw
    /// them, [`Selection::position`] says.
    pub vertices: Vec<VertexRecord>,
    /// How the whole tree names the vertices.
    pub ids: Vec<u32>,
    /// Their normals; empty if the file has none.
    pub normals: Vec<NormalRecord>,
    /// Their colours; empty if the file has none.
    pub colors: Vec<[u8; 4]>,
    /// The chunks and pages that are drawn within, in the order of the tree, a chunk before its pages.
    pub entered: Vec<Wish>,
    /// Those that the selection goes into and that were not there: their roots are drawn.
    pub missing: Vec<Wish>,
    /// Those that a selection of half the tolerance would go into too, as far as one can tell, there or not.
    pub close: Vec<Wish>,
    /// What was there and is damaged: the root is drawn.
    pub damaged: Vec<Damaged>,
    /// What was visited, culled and drawn.
    pub stats: Stats,
    scratch: Scratch,
}

/// A piece that broke a rule where the walk came by.
#[derive(Debug)]
pub struct Damaged {
    /// Which one.
    pub piece: Piece,
    /// What is wrong with it.
    pub error: Error,
}

/// The pieces that are in memory.
pub trait Resident<'a> {
    /// The top of a chunk, if it is there.
    fn chunk(&self, chunk: u32) -> Option<&'a Chunk>;

    /// A page, by its number in the file, if it is there.
    fn page(&self, page: u32) -> Option<&'a ChunkPage>;
}

#[derive(Debug, Default)]
struct Scratch {
    stitcher: Stitcher,
    patch: Patch,
    loops: Loops,
    plan: Plan,
    /// Nodes of the crown that are to be looked at.
    stack: Vec<(u32, Subtree, Settled)>,
    /// Empty between two extractions: the memory of what a walk enters and draws.
    chunks: Vec<&'static Chunk>,
    pages: Vec<&'static ChunkPage>,
    drawn: Vec<Drawn<'static>>,
    /// The same, made ready.
    ready: Vec<(Subtree, Option<Node>)>,
    /// What is drawn of a page, by the page's numbers.
    below: Extraction,
    /// Triangles by the numbers of the patch.
    triangles: Vec<u32>,
    /// What the vertices of a page are called in the mesh.
    numbers: Vec<u32>,
    index: Index,
}

/// Extracts the mesh of `selection` into `out` from a crown and the pieces that there are.
///
/// What a budget adds to a selection ([`Selection::extra`]) is not taken: it names nodes and vertices of whole trees.
/// Where parts are culled, vertices on their borders may be left out that [`crate::extract`] draws; what is drawn is
/// never finer. Of a missing piece whose root cannot be drawn, since it joins components or is a closed one, nothing is
/// drawn.
///
/// # Errors
/// [`Error::Selection`] when a number of the selection makes no sense, [`Error::TooManyTriangles`]. Pieces that are
/// damaged are no error, but listed.
pub fn extract_chunks<'a>(
    crown: &Crown,
    there: &dyn Resident<'a>,
    selection: &Selection,
    out: &mut Streamed,
) -> Result<(), Error> {
    walk_chunks(crown, there, selection, true, out)
}

/// The same, or, if nothing is to be drawn, only what it enters, misses and comes close to.
pub(super) fn walk_chunks<'a>(
    crown: &Crown,
    there: &dyn Resident<'a>,
    selection: &Selection,
    draws: bool,
    out: &mut Streamed,
) -> Result<(), Error> {
    selection.check()?;
    out.clear();
    let plain;
    let selection = if selection.extra.is_empty() {
        selection
    } else {
        plain = Selection { extra: Extra::default(), ..selection.clone() };
        &plain
    };
    let Scratch { chunks, pages, drawn, .. } = &mut out.scratch;
    let (chunks, pages, drawn) =
        (emptied(std::mem::take(chunks)), emptied(std::mem::take(pages)), emptied(std::mem::take(drawn)));
    let vertices = Vertices { crown, chunks, pages };
    let mut walk = Walk { crown, selection, there, draws, vertices, drawn };
    let done = walk.run(out);
    out.scratch.chunks = emptied(walk.vertices.chunks);
    out.scratch.pages = emptied(walk.vertices.pages);
    out.scratch.drawn = emptied(walk.drawn);
    done
}

/// One extraction.
struct Walk<'a, 'b> {
    crown: &'b Crown,
    selection: &'b Selection,
    there: &'b dyn Resident<'a>,
    draws: bool,
    vertices: Vertices<'a, 'b>,
    /// What is drawn as one polygon outside the pages that are entered.
    drawn: Vec<Drawn<'a>>,
}

/// A node to be drawn as one polygon, or a single face.
#[derive(Clone, Copy, Debug)]
enum Drawn<'a> {
    Crown(u32),
    Top(&'a Chunk, Subtree),
}

impl<'a> Walk<'a, '_> {
    fn run(&mut self, out: &mut Streamed) -> Result<(), Error> {
        let mut whole = Subtree::default();
        whole.face_end = self.crown.face_count();
        if whole.face_end > 1 {
            whole.child = ChildRef::node(0);
        }
        out.scratch.stack.clear();
        out.scratch.stack.push((0, whole, self.selection.settled()));
        while let Some((node, subtree, settled)) = out.scratch.stack.pop() {
            let Some(record) = self.crown.node(node) else { continue };
            if subtree.face_count() == 1 {
                self.drawn.push(Drawn::Crown(node));
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
                    let stack = &mut out.scratch.stack;
                    stack.push((right, right_faces, settled));
                    stack.push((left, left_faces, settled));
                    continue;
                }
                (Some(CrownChild::Chunk(chunk)), settled) => {
                    let piece = Piece::Chunk(chunk);
                    let found = self.there.chunk(chunk);
                    let wish = Wish::below(&record, piece, self.selection, settled.is_some());
                    match (found, settled) {
                        (Some(found), Some(settled)) => {
                            if self.enter_chunk(found, settled, wish, out)? {
                                continue;
                            }
                        }
                        (None, Some(_)) => out.missing.push(wish),
                        (found, None) if wish.is_close() => {
                            out.close.push(wish);
                            if let Some(chunk) = found {
                                out.scratch.plan.add_pages(chunk, self.selection, &wish, &mut out.close);
                            }
                        }
                        (_, None) => {}
                    }
                }
                (_, None) | (None, Some(_)) => {}
            }
            self.drawn.push(Drawn::Crown(node));
        }
        if self.draws {
            self.draw_nodes(out)?;
        }
        out.stats.triangles = out.indices.len() as u64 / 3;
        Ok(())
    }

    /// Goes down into a chunk below its root, which is refined; false if it is damaged, and then nothing of it is drawn.
    fn enter_chunk(
        &mut self,
        chunk: &'a Chunk,
        settled: Settled,
        wish: Wish,
        out: &mut Streamed,
    ) -> Result<bool, Error> {
        let mut stats = Stats::default();
        let mut plan = std::mem::take(&mut out.scratch.plan);
        if let Err(error) = plan.make(chunk, self.selection, settled, &wish, &mut stats) {
            out.damaged.push(Damaged { piece: wish.piece, error: Error::Tree(error) });
            return Ok(false);
        }
        out.stats.add(&stats);
        out.entered.push(wish);
        self.vertices.chunks.push(chunk);
        for step in &plan.steps {
            match *step {
                Step::Draw(subtree) => self.drawn.push(Drawn::Top(chunk, subtree)),
                Step::Ahead(wish) => out.close.push(wish),
                Step::Enter(subtree, settled, wish) => {
                    if !self.enter_page(&subtree, settled, wish, out)? {
                        self.drawn.push(Drawn::Top(chunk, subtree));
                    }
                }
            }
        }
        out.scratch.plan = plan;
        Ok(true)
    }

    /// Draws a page whose root is refined; false if it is missing or damaged, and then nothing of it is drawn.
    fn enter_page(
        &mut self,
        subtree: &Subtree,
        settled: Settled,
        wish: Wish,
        out: &mut Streamed,
    ) -> Result<bool, Error> {
        let Piece::Page(number) = wish.piece else { return Ok(false) };
        let Some(page) = self.there.page(number) else {
            out.missing.push(wish);
            return Ok(false);
        };
        if !self.draws {
            out.entered.push(wish);
            return Ok(true);
        }
        let reader = page.reader();
        let below = &mut out.scratch.below;
        below.clear();
        let part = Part { subtree: page.root(subtree.child), settled };
        match below.append_from(&Source { reader, selection: self.selection, eager: None }, &part) {
            Ok(()) => {}
            Err(error @ Error::Tree(_)) => {
                out.damaged.push(Damaged { piece: wish.piece, error });
                return Ok(false);
            }
            Err(error) => return Err(error),
        }
        // The root was counted before, and triangles are counted with all others.
        let visited = below.stats.nodes_visited.saturating_sub(1);
        out.stats.add(&Stats { triangles: 0, nodes_visited: visited, ..below.stats });
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
                out.ids.push(page.vertex_id(vertex).unwrap_or(u32::MAX));
                out.normals.extend(page.normals().get(at));
                out.colors.extend(page.colors().get(at));
            }
            out.indices.push(*number);
        }
        out.entered.push(wish);
        self.vertices.pages.push(page);
        Ok(true)
    }

    /// Draws what is outside the pages that are entered: nodes that are in the cut, or stand for what is missing.
    fn draw_nodes(&self, out: &mut Streamed) -> Result<(), Error> {
        let Scratch { stitcher, patch, triangles, numbers, loops, index, ready: drawn, .. } =
            &mut out.scratch;
        patch.clear();
        triangles.clear();
        self.vertices.index(index);
        let find = |id: u32| self.vertices.find_twin(index, id);
        let record = |id: u32| self.vertices.record(find(id)?);
        drawn.clear();
        for item in &self.drawn {
            // Sections were checked when they were read, but for loops; what those leave out is not drawn.
            let ready = match item {
                Drawn::Crown(node) => Ready::of_crown(self.crown, *node, loops),
                Drawn::Top(chunk, subtree) => Ready::of_chunk(chunk, subtree, loops),
            };
            let Some(ready) = ready else { continue };
            loops.retain(|id| self.vertices.may_find(index, id));
            drawn.extend(patch.push(ready.top, loops, ready.corner, record).map(|place| (place, ready.node)));
        }
        let reader = patch.reader();
        for (subtree, node) in &*drawn {
            out.stats.clusters += 1;
            let Some(node) = node else {
                reader.read_loops(subtree, loops)?;
                if loops.vertices.len() == 3 {
                    triangles.extend_from_slice(&loops.vertices);
                }
                continue;
            };
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
                let (normal, color) = find(*id).map_or((None, None), |found| self.vertices.attributes(found));
                out.normals.extend(normal);
                out.colors.extend(color);
            }
            out.indices.push(*number);
        }
        Ok(())
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
    }
}
