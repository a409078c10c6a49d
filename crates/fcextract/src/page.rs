//! The part of a cut that lies in one page.
//!
//! Most of a mesh is drawn here. What a page holds fits in the nearest memory, its vertices are told by one byte and
//! looked at once, and its polygons are mostly drawn by [`PagePolygon`]; the few others go the general way.

use crate::batch::{BATCH_TRIANGLES, Batch};
use crate::criterion::{Criterion, Everywhere, Seen};
use crate::eager::{Kept, Table};
use crate::extraction::{Source, Stats};
use crate::part::{Settled, Sight};
use crate::stitch::{PagePolygon, Stitcher};
use crate::{Error, Tolerance};
use fct::{Branch, Loops, Page, Subtree};

/// Draws pages; keeps its memory from one to the next.
#[derive(Debug, Default)]
pub(crate) struct PageWalk {
    stack: Vec<(Branch, Settled)>,
    /// The clusters of the cut in the page, in order.
    drawn: Vec<Branch>,
    /// Branches to be divided into batches, and which of the clusters are in them.
    waiting: Vec<(Branch, usize, usize)>,
    polygon: PagePolygon,
    loops: Loops,
}

/// What is known of the boundary of a cluster that is drawn the general way.
#[derive(Clone, Copy, Debug)]
enum Known<'a> {
    Nothing,
    /// What is drawn of its loops.
    Loops(&'a Loops),
    Kept(&'a Kept),
}

/// Where the mesh goes.
pub(crate) struct Mesh<'a> {
    pub(crate) indices: &'a mut Vec<u32>,
    pub(crate) clusters: &'a mut Vec<u32>,
    pub(crate) batches: &'a mut Vec<Batch>,
    pub(crate) stats: &'a mut Stats,
}

/// A page's indices may begin up to here: so many more, which none has, still have a number of 32 bits.
const LAST_START: usize = (u32::MAX - (1 << 20)) as usize;

/// From so many active vertices on, most of a page's memory is soon needed.
const TOUCH_FROM: usize = 32;

impl PageWalk {
    /// Appends what is drawn of a subtree that lies in a page; false if it does not lie in one, or if anything about the
    /// page is strange: then the mesh may hold a part.
    pub(crate) fn draw(
        &mut self,
        source: &Source<'_>,
        stitcher: &mut Stitcher,
        subtree: &Subtree,
        settled: Settled,
        mesh: &mut Mesh<'_>,
    ) -> Result<bool, Error> {
        let Source { reader, selection, .. } = source;
        let Some((page, root)) = reader.page(subtree) else { return Ok(false) };
        if mesh.indices.len() > LAST_START {
            return Ok(false);
        }
        self.drawn.clear();
        let first_cluster = mesh.clusters.len();
        let mut general = |branch: &Branch, known: Known<'_>, indices: &mut Vec<u32>| {
            let subtree = page.subtree(branch);
            let node = reader.node(&subtree)?;
            match known {
                Known::Nothing => stitcher.draw(reader, selection, &subtree, &node, indices),
                Known::Loops(loops) => stitcher.draw_loops(reader, loops, (&subtree, &node), indices),
                Known::Kept(kept) => stitcher.draw_kept(reader, kept, (&subtree, &node), indices),
            }
        };
        let all = selection.tolerance == Tolerance::Full && selection.is_plain() && settled.is_shown();
        let sound = if all {
            self.draw_faces(&page, root, mesh)
        } else if let Some(everywhere) = Everywhere::of(selection, &page, &root, settled) {
            self.walk((&page, source.eager), (root, settled), &everywhere, mesh, &mut general)?
        } else if let Some(seen) = Seen::of(selection, &page, &root) {
            self.walk((&page, source.eager), (root, settled), &seen, mesh, &mut general)?
        } else {
            self.walk((&page, source.eager), (root, settled), *selection, mesh, &mut general)?
        };
        mesh.stats.clusters += self.drawn.len() as u64;
        let starts = mesh.clusters.get(first_cluster..).unwrap_or_default();
        let end = mesh.indices.len() as u32 / 3;
        Ok(sound.is_some() && self.divide(&page, root, starts, end, mesh.batches).is_some())
    }

    /// Draws all faces of a branch; none if some are not there.
    fn draw_faces(&mut self, page: &Page<'_>, root: Branch, mesh: &mut Mesh<'_>) -> Option<()> {
        mesh.stats.nodes_visited += u64::from(root.face_count()) - 1;
        for face in page.single_faces(&root) {
            self.begin_cluster(face, mesh);
            mesh.indices.extend_from_slice(&page.corners(&face)?);
        }
        Some(())
    }

    #[inline]
    fn begin_cluster(&mut self, branch: Branch, mesh: &mut Mesh<'_>) {
        self.drawn.push(branch);
        mesh.clusters.push(mesh.indices.len() as u32 / 3);
    }

    /// Goes down from a branch and draws what is in the cut, in `general` what [`PagePolygon`] does not; none if
    /// something is not there.
    fn walk<C: Criterion>(
        &mut self,
        (page, eager): (&Page<'_>, Option<&Table>),
        root: (Branch, Settled),
        criterion: &C,
        mesh: &mut Mesh<'_>,
        general: &mut impl FnMut(&Branch, Known<'_>, &mut Vec<u32>) -> Result<u64, Error>,
    ) -> Result<Option<()>, Error> {
        let mut is_ready = false;
        self.stack.clear();
        self.stack.push(root);
        while let Some((mut branch, mut settled)) = self.stack.pop() {
            // Left children are gone on with at once: half of the steps never wait.
            while branch.face_count() > 1 {
                let Some(sight) = criterion.sight(page, &branch, settled, mesh.stats) else {
                    return Ok(None);
                };
                match sight {
                    Sight::Culled => break,
                    Sight::Refined { settled: of_all } => {
                        let Some([left, right]) = page.children(&branch) else { return Ok(None) };
                        settled = of_all;
                        self.stack.push((right, settled));
                        branch = left;
                    }
                    Sight::Drawn => {
                        self.begin_cluster(branch, mesh);
                        if branch == page.whole()
                            && let Some(eager) = eager
                            && let Some(is_drawn) = self.polygon.draw_root(page, eager, criterion, mesh)
                        {
                            if !is_drawn {
                                let known = Known::Kept(self.polygon.kept());
                                mesh.stats.folded += general(&branch, known, mesh.indices)?;
                            }
                            break;
                        }
                        if !is_ready {
                            let Some(active) = self.polygon.begin(page, eager, criterion) else {
                                return Ok(None);
                            };
                            is_ready = true;
                            if active > TOUCH_FROM {
                                page.touch();
                            }
                        }
                        let Some(is_drawn) = self.polygon.draw(page, &branch, mesh) else {
                            return Ok(None);
                        };
                        if !is_drawn {
                            let known = match self.polygon.read_loops(page, &branch, &mut self.loops) {
                                true => Known::Loops(&self.loops),
                                false => Known::Nothing,
                            };
                            mesh.stats.folded += general(&branch, known, mesh.indices)?;
                        }
                        break;
                    }
                }
            }
            if branch.face_count() == 1 {
                let Some(corners) = page.corners(&branch) else { return Ok(None) };
                self.begin_cluster(branch, mesh);
                mesh.indices.extend_from_slice(&corners);
            }
        }
        Ok(Some(()))
    }

    /// Appends batches of the clusters drawn of a branch, which begin at the triangles `starts`; none if a branch has no
    /// children where it must.
    fn divide(
        &mut self,
        page: &Page<'_>,
        root: Branch,
        starts: &[u32],
        end: u32,
        out: &mut Vec<Batch>,
    ) -> Option<()> {
        let PageWalk { drawn, waiting, .. } = self;
        let start = |i: usize| starts.get(i).copied().unwrap_or(end);
        waiting.clear();
        waiting.push((root, 0, drawn.len()));
        while let Some((mut branch, mut first, mut last)) = waiting.pop() {
            while start(first) < start(last) {
                let triangles = start(last) - start(first);
                let batch =
                    |subtree| Batch { subtree, first_index: 3 * start(first), index_count: 3 * triangles };
                if last - first == 1 {
                    out.push(batch(page.subtree(drawn.get(first)?)));
                    break;
                }
                let [left, right] = page.children(&branch)?;
                let split = drawn.get(first..last)?.partition_point(|b| b.first_face() < right.first_face());
                let middle = first + split;
                if start(middle) == start(last) {
                    // Nothing is drawn on the right, so that the left is all there is.
                    (branch, last) = (left, middle);
                } else if start(first) == start(middle) {
                    (branch, first) = (right, middle);
                } else if triangles <= BATCH_TRIANGLES {
                    out.push(batch(page.subtree(&branch)));
                    break;
                } else {
                    waiting.push((right, middle, last));
                    (branch, last) = (left, middle);
                }
            }
        }
        Some(())
    }
}
