//! How many triangles a selection draws, without drawing them.

use crate::criterion::Boundary;
use crate::eager::{Eager, Kept, Table};
use crate::part::{Settled, Sight};
use crate::stitch::Stitcher;
use crate::{Error, Selection, Shown, Stats};
use fct::{Child, Loops, Node, Reader, Subtree};

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
