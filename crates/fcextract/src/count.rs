//! How many triangles a selection draws, without drawing them.

use crate::criterion::{Boundary, Criterion, Everywhere, Seen};
use crate::eager::{Eager, Kept, Table};
use crate::part::{Settled, Sight};
use crate::stitch::{PagePolygon, Stitcher};
use crate::{Error, Selection, Shown, Stats};
use fct::{Branch, Child, Loops, Node, Page, Reader, Subtree};

/// What a selection comes to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    pub(crate) triangles: u64,
    pub(crate) clusters: u64,
}

/// A cut that was counted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Counted {
    pub(crate) counts: Counts,
    /// The factor on the tolerance below which the first of its nodes is refined.
    pub(crate) next: f64,
    /// The least factor below which one of the nodes above it is refined.
    pub(crate) last: f64,
}

/// Counts; keeps its memory from one time to the next.
#[derive(Debug, Default)]
pub(crate) struct Counter {
    stack: Vec<(Subtree, Settled)>,
    loops: Loops,
    corners: Vec<u32>,
    stitcher: Stitcher,
    branches: Vec<(Branch, Settled)>,
    page: PagePolygon,
    kept: Kept,
    drawn: Vec<u32>,
    /// Vertices that were looked at so far.
    pub(crate) looked_at: u64,
}

impl Counter {
    /// Counts a whole cut, with the tolerance multiplied by a factor; gives up, with what it has so far, as soon as
    /// `enough` says so.
    pub(crate) fn cut(
        &mut self,
        shown: &Shown<'_>,
        factor: f64,
        enough: impl Fn(&Counts) -> bool,
    ) -> Result<Counted, Error> {
        let Shown { tree, selection: shape } = shown;
        let selection = Selection { tolerance: shape.tolerance.scaled(factor), ..shape.clone() };
        let (reader, eager) = (tree.reader(), Eager::of(tree, selection.order));
        let mut stats = Stats::default();
        let mut cut = Counted { last: f64::INFINITY, ..Counted::default() };
        self.stack.clear();
        self.stack.push((reader.whole(), selection.settled()));
        while let Some((subtree, settled)) = self.stack.pop() {
            if self.page((&reader, eager), (shape, &selection), (&subtree, settled), &mut cut)? {
                if enough(&cut.counts) {
                    break;
                }
                continue;
            }
            if let Child::Face(_) = subtree.child.kind() {
                cut.counts.clusters += 1;
                cut.counts.triangles += 1;
                continue;
            }
            let node = reader.node(&subtree)?;
            match selection.sight(&subtree, &node, settled, &mut stats) {
                Sight::Culled => {}
                Sight::Refined { settled } => {
                    cut.last = cut.last.min(shape.level_of_node(&shape.tolerance, &node).1);
                    let [left, right] = reader.children(&subtree)?;
                    self.stack.extend([(right, settled), (left, settled)]);
                }
                Sight::Drawn => {
                    cut.counts.clusters += 1;
                    cut.counts.triangles += self.polygon((&reader, eager), &selection, &subtree, &node)?;
                    cut.next = cut.next.max(shape.level_of_node(&shape.tolerance, &node).1);
                    if enough(&cut.counts) {
                        break;
                    }
                }
            }
        }
        Ok(cut)
    }

    /// Adds what a subtree in a page comes to; false, and nothing, if it does not lie in one or the page is strange.
    fn page(
        &mut self,
        known: (&Reader<'_>, Option<&Table>),
        (shape, selection): (&Selection, &Selection),
        (subtree, settled): (&Subtree, Settled),
        cut: &mut Counted,
    ) -> Result<bool, Error> {
        let Some((page, root)) = subtree.top().is_none().then(|| known.0.page(subtree)).flatten() else {
            return Ok(false);
        };
        let before = *cut;
        let place = (&page, (root, settled));
        let is_sound = if let Some(everywhere) = Everywhere::of(selection, &page, &root, settled) {
            self.walk(known, (shape, selection), place, &everywhere, cut)?
        } else if let Some(seen) = Seen::of(selection, &page, &root) {
            self.walk(known, (shape, selection), place, &seen, cut)?
        } else {
            self.walk(known, (shape, selection), place, selection, cut)?
        };
        if is_sound.is_none() {
            *cut = before;
        }
        Ok(is_sound.is_some())
    }

    /// Goes down from a branch of a page and counts what is in the cut; none if something is not there.
    fn walk<C: Criterion>(
        &mut self,
        (reader, eager): (&Reader<'_>, Option<&Table>),
        (shape, selection): (&Selection, &Selection),
        (page, root): (&Page<'_>, (Branch, Settled)),
        criterion: &C,
        cut: &mut Counted,
    ) -> Result<Option<()>, Error> {
        let level = |branch: &Branch| Some(shape.level_of_node(&shape.tolerance, &page.node(branch)?).1);
        let (mut stats, mut is_ready) = (Stats::default(), false);
        self.branches.clear();
        self.branches.push(root);
        while let Some((branch, settled)) = self.branches.pop() {
            if branch.face_count() == 1 {
                cut.counts.clusters += 1;
                cut.counts.triangles += 1;
                continue;
            }
            let Some((sight, level)) =
                criterion.sight(page, &branch, settled, &mut stats).zip(level(&branch))
            else {
                return Ok(None);
            };
            match sight {
                Sight::Culled => continue,
                Sight::Refined { settled } => {
                    cut.last = cut.last.min(level);
                    let Some([left, right]) = page.children(&branch) else { return Ok(None) };
                    self.branches.extend([(right, settled), (left, settled)]);
                    continue;
                }
                Sight::Drawn => {}
            }
            cut.counts.clusters += 1;
            cut.next = cut.next.max(level);
            let is_root = branch == page.whole();
            if !is_root && !is_ready {
                if self.page.begin(page, eager, criterion).is_none() {
                    return Ok(None);
                }
                is_ready = true;
            }
            let counted = if is_root { Some(None) } else { self.page.count(page, &branch) };
            cut.counts.triangles += match counted {
                None => return Ok(None),
                Some(Some(triangles)) => triangles,
                Some(None) => {
                    let subtree = page.subtree(&branch);
                    self.polygon((reader, eager), selection, &subtree, &reader.node(&subtree)?)?
                }
            };
        }
        Ok(Some(()))
    }

    /// The number of triangles of a subtree's root, single faces included.
    pub(crate) fn subtree(
        &mut self,
        (reader, eager): (&Reader<'_>, Option<&Table>),
        selection: &Selection,
        subtree: &Subtree,
    ) -> Result<u64, Error> {
        match subtree.child.kind() {
            Child::Face(_) => Ok(1),
            Child::Node(_) => self.polygon((reader, eager), selection, subtree, &reader.node(subtree)?),
        }
    }

    /// The number of triangles of a node that is drawn.
    ///
    /// A polygon of n corners that are all different is drawn with n - 2. Where holes are joined, or a corner occurs
    /// more than once, some come to nothing, and only drawing tells how many.
    pub(crate) fn polygon(
        &mut self,
        (reader, eager): (&Reader<'_>, Option<&Table>),
        selection: &Selection,
        subtree: &Subtree,
        node: &Node,
    ) -> Result<u64, Error> {
        let boundary = Boundary::of(selection, reader, node);
        self.corners.clear();
        if let Some(eager) = eager
            && eager.keep_of(reader, subtree, &boundary, &mut self.kept).is_some()
        {
            self.corners.extend(self.kept.vertices());
            if let Some(triangles) = self.triangles(self.kept.ends().len()) {
                return Ok(triangles);
            }
            self.drawn.clear();
            self.stitcher.draw_kept(reader, &self.kept, (subtree, node), &mut self.drawn)?;
            return Ok(self.drawn.len() as u64 / 3);
        }
        reader.read_loops(subtree, &mut self.loops)?;
        self.looked_at += self.loops.vertices.len() as u64;
        if let Some(eager) = eager {
            eager.fill(reader, (subtree, node), &self.loops)?;
        }
        let mut rings = 0;
        for ring in self.loops.iter() {
            let start = self.corners.len();
            self.corners.extend(ring.iter().copied().filter(|v| boundary.draws(*v)));
            if self.corners.len() < start + 3 {
                self.corners.truncate(start);
            } else {
                rings += 1;
            }
        }
        if let Some(triangles) = self.triangles(rings) {
            return Ok(triangles);
        }
        self.drawn.clear();
        self.stitcher.draw(reader, selection, subtree, node, &mut self.drawn)?;
        Ok(self.drawn.len() as u64 / 3)
    }

    /// The number of triangles of the corners of so many rings, if that says it; sorts them.
    fn triangles(&mut self, rings: usize) -> Option<u64> {
        let corners = self.corners.len();
        if rings == 0 || corners < 3 {
            return Some(0);
        }
        self.corners.sort_unstable();
        self.corners.dedup();
        (rings == 1 && self.corners.len() == corners).then_some(corners as u64 - 2)
    }
}
