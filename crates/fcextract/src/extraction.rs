//! The walk from the root to the cut, and the mesh it leaves behind.

use crate::batch::{BATCH_TRIANGLES, Batch};
use crate::eager::{Eager, Table};
use crate::page::{Mesh, PageWalk};
use crate::part::{Part, Settled, Sight};
use crate::stitch::Stitcher;
use crate::{Error, Selection};
use fcgeom::Sphere;
use fct::{Child, Node, Reader, Subtree, Tree};
use std::cell::Cell;

/// A triangle mesh for one selection; reuse it to keep its memory.
#[derive(Debug, Default)]
pub struct Extraction {
    /// Vertex indices into the tree's vertices, three a triangle, counter-clockwise.
    pub indices: Vec<u32>,
    /// The first triangle of each cluster drawn, in order.
    pub clusters: Vec<u32>,
    /// The triangles in runs, each from one subtree.
    pub batches: Vec<Batch>,
    /// What was visited, culled and drawn.
    pub stats: Stats,
}

/// What a mesh is made from.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source<'a> {
    pub(crate) reader: Reader<'a>,
    pub(crate) selection: &'a Selection,
    /// What is known of the tree by the selection's order.
    pub(crate) eager: Option<&'a Table>,
}

/// What a mesh is made with: ten thousand bytes and more. A thread has one for all its meshes, since a view of many
/// instances has a million of those at once.
#[derive(Debug, Default)]
struct Work {
    stack: Vec<Step>,
    stitcher: Stitcher,
    page: PageWalk,
}

thread_local! {
    /// The thread's, while no mesh is made with it.
    static WORK: Cell<Option<Box<Work>>> = const { Cell::new(None) };
}

/// Counts of one extraction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Stats {
    /// Interior nodes looked at.
    pub nodes_visited: u64,
    /// Subtrees left out because their spheres lie outside the frustum.
    pub culled_frustum: u64,
    /// Subtrees left out because all their faces turn their back on the eye.
    pub culled_cone: u64,
    /// Faces of the subtrees left out, by frustum and cone together.
    pub faces_culled: u64,
    /// Clusters of the cut that were drawn, single faces included.
    pub clusters: u64,
    /// Triangles drawn.
    pub triangles: u64,
    /// Triangles of clusters that do not fold over whose own normals point away from the cluster's.
    pub folded: u64,
    /// Largest distance bound of a cluster drawn, in the tree's unit.
    pub bound: f32,
}

#[derive(Clone, Copy, Debug)]
enum Step {
    Visit {
        subtree: Subtree,
        settled: Settled,
    },
    /// The subtree's triangles and batches start here.
    Close {
        subtree: Subtree,
        first_index: u32,
        first_batch: usize,
    },
}

/// Extracts the mesh of `selection` from `tree` into `out`.
///
/// # Errors
/// [`Error::Tree`] when the file is damaged where the walk comes by, [`Error::Selection`] when a number of the
/// selection makes no sense. `out` then holds part of a mesh.
pub fn extract(tree: &Tree, selection: &Selection, out: &mut Extraction) -> Result<(), Error> {
    selection.check()?;
    out.clear();
    out.append(tree, selection, &Part::whole(tree, selection))
}

impl Extraction {
    /// Empties the mesh and keeps its memory.
    pub fn clear(&mut self) {
        self.indices.clear();
        self.clusters.clear();
        self.batches.clear();
        self.stats = Stats::default();
    }

    /// Adds the mesh of one part of a cut.
    ///
    /// Parts of one cut, divided in whatever way, draw what [`extract`] draws of the whole: the same triangles in the
    /// order of the parts. Counts are summed.
    ///
    /// # Errors
    /// As [`extract`].
    pub fn append(&mut self, tree: &Tree, selection: &Selection, part: &Part) -> Result<(), Error> {
        selection.check()?;
        let eager = Eager::of(tree, selection.order);
        self.append_from(&Source { reader: tree.reader(), selection, eager }, part)
    }

    /// The same for whatever the reader shows; the selection was checked.
    pub(crate) fn append_from(&mut self, source: &Source<'_>, part: &Part) -> Result<(), Error> {
        let mut work = WORK.take().unwrap_or_default();
        let done = self.walk(&mut work, source, part);
        WORK.set(Some(work));
        done
    }

    fn walk(&mut self, work: &mut Work, source: &Source<'_>, part: &Part) -> Result<(), Error> {
        let first_index = self.indices.len() as u64;
        work.stack.clear();
        work.stack.push(Step::Visit { subtree: part.subtree, settled: part.settled });
        while let Some(step) = work.stack.pop() {
            match step {
                Step::Visit { subtree, settled } => {
                    // Left children are gone on with at once: half of the steps never wait.
                    let mut next = Some((subtree, settled));
                    while let Some((subtree, settled)) = next {
                        next = self.visit(work, source, subtree, settled)?;
                    }
                }
                Step::Close { subtree, first_index, first_batch } => {
                    let end = self.next_index()?;
                    self.close(subtree, first_index, end, first_batch);
                }
            }
        }
        self.stats.triangles += (self.indices.len() as u64 - first_index) / 3;
        Ok(())
    }

    /// Draws a subtree, leaves it out, or goes on with its left child, which is returned.
    fn visit(
        &mut self,
        work: &mut Work,
        source: &Source<'_>,
        subtree: Subtree,
        settled: Settled,
    ) -> Result<Option<(Subtree, Settled)>, Error> {
        if subtree.top().is_none() && self.draw_page(work, source, &subtree, settled)? {
            return Ok(None);
        }
        let Source { reader, selection, eager } = source;
        let first_index = self.next_index()?;
        if let Child::Face(_) = subtree.child.kind() {
            self.begin_cluster(first_index);
            self.indices.extend(reader.face(&subtree)?);
            self.batches.push(Batch { subtree, first_index, index_count: 3 });
            return Ok(None);
        }
        let node = reader.node(&subtree)?;
        match selection.sight(&subtree, &node, settled, &mut self.stats) {
            Sight::Culled => return Ok(None),
            Sight::Refined { settled } => {
                let [left, right] = reader.children(&subtree)?;
                // What the root of a page needs comes from memory while others are drawn.
                reader.touch(&left);
                reader.touch(&right);
                work.stack.push(Step::Close { subtree, first_index, first_batch: self.batches.len() });
                work.stack.push(Step::Visit { subtree: right, settled });
                return Ok(Some((left, settled)));
            }
            Sight::Drawn => {}
        }
        self.begin_cluster(first_index);
        self.stats.bound = self.stats.bound.max(node.bound);
        self.stats.folded +=
            work.stitcher.draw_top(reader, selection, *eager, (&subtree, &node), &mut self.indices)?;
        let added = self.indices.len() as u64 - u64::from(first_index);
        let count = u32::try_from(added).map_err(|_overflow| Error::TooManyTriangles)?;
        if count > 0 {
            self.batches.push(Batch { subtree, first_index, index_count: count });
        }
        Ok(None)
    }

    fn next_index(&self) -> Result<u32, Error> {
        u32::try_from(self.indices.len()).map_err(|_overflow| Error::TooManyTriangles)
    }

    /// Draws a subtree of a sound page; false if it is none, and then nothing is drawn.
    fn draw_page(
        &mut self,
        work: &mut Work,
        source: &Source<'_>,
        subtree: &Subtree,
        settled: Settled,
    ) -> Result<bool, Error> {
        let before = (self.indices.len(), self.clusters.len(), self.batches.len(), self.stats);
        let mut mesh = Mesh {
            indices: &mut self.indices,
            clusters: &mut self.clusters,
            batches: &mut self.batches,
            stats: &mut self.stats,
        };
        let drawn = work.page.draw(source, &mut work.stitcher, subtree, settled, &mut mesh)?;
        if !drawn {
            self.indices.truncate(before.0);
            self.clusters.truncate(before.1);
            self.batches.truncate(before.2);
            self.stats = before.3;
        }
        Ok(drawn)
    }

    fn begin_cluster(&mut self, first_index: u32) {
        self.stats.clusters += 1;
        self.clusters.push(first_index / 3);
    }

    /// Joins the batches of a subtree, which ends before `end`, if it is still small.
    pub(crate) fn close(&mut self, subtree: Subtree, first_index: u32, end: u32, first_batch: usize) {
        let count = end - first_index;
        if self.batches.len() > first_batch + 1 && count <= 3 * BATCH_TRIANGLES {
            self.batches.truncate(first_batch);
            self.batches.push(Batch { subtree, first_index, index_count: count });
        }
    }
}

impl Stats {
    /// Adds what another extraction came to.
    pub(crate) fn add(&mut self, other: &Stats) {
        self.nodes_visited += other.nodes_visited;
        self.culled_frustum += other.culled_frustum;
        self.culled_cone += other.culled_cone;
        self.faces_culled += other.faces_culled;
        self.clusters += other.clusters;
        self.triangles += other.triangles;
        self.folded += other.folded;
        self.bound = self.bound.max(other.bound);
    }
}

pub(crate) fn sphere_of(node: &Node) -> Sphere {
    Sphere { center: node.center.into(), radius: node.radius }
}
