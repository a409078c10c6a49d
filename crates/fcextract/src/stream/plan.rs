//! Which pieces of a chunk a selection needs, by the top of the chunk alone.

use crate::part::{Settled, Sight};
use crate::{Selection, Stats};
use fct::{Chunk, Node, Subtree};

/// A part of a file that is read alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Piece {
    /// The top of a chunk, by its number.
    Chunk(u32),
    /// A page, by its number in the file. It can be read once the top of its chunk is there.
    Page(u32),
}

/// A piece that is used or worth reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wish {
    /// Which one.
    pub piece: Piece,
    /// The error of its root over what is allowed there: over 1 where the piece is needed; may be infinite.
    pub urgency: f64,
    /// The same error as a length, which tells apart those of infinite urgency.
    pub key: f32,
}

/// What a walk through the top of a chunk comes to.
#[derive(Clone, Copy, Debug)]
pub(super) enum Step {
    /// A node that is drawn as one polygon, or a face.
    Draw(Subtree),
    /// A page that may be needed soon.
    Ahead(Wish),
    /// A page whose root is refined, and what is known of it as a whole.
    Enter(Subtree, Settled, Wish),
}

/// Walks through the tops of chunks; reuse it to keep its memory.
#[derive(Debug, Default)]
pub(super) struct Plan {
    /// What [`Plan::make`] has found.
    pub(super) steps: Vec<Step>,
    stack: Vec<(Subtree, Settled)>,
    ahead: Ahead,
}

/// Looks for pages that may be needed soon.
#[derive(Debug, Default)]
struct Ahead {
    stack: Vec<(Subtree, Settled)>,
}

impl Plan {
    /// Finds what is to be done about a chunk whose root is refined.
    pub(super) fn make(
        &mut self,
        chunk: &Chunk,
        selection: &Selection,
        settled: Settled,
        wish: &Wish,
        stats: &mut Stats,
    ) -> Result<(), fct::Error> {
        let Plan { steps, stack, ahead } = self;
        steps.clear();
        let root = chunk.root();
        if let Some(page) = chunk.page(&root) {
            steps.push(Step::Enter(root, settled, Wish { piece: Piece::Page(page), ..*wish }));
            return Ok(());
        }
        let [left, right] = chunk.children(&root)?;
        stack.clear();
        stack.extend([(right, settled), (left, settled)]);
        while let Some((subtree, settled)) = stack.pop() {
            if subtree.face_count() == 1 {
                steps.push(Step::Draw(subtree));
                continue;
            }
            let node = chunk.node(&subtree)?;
            match (selection.sight(&subtree, &node, settled, stats), chunk.page(&subtree)) {
                (Sight::Culled, _) => {}
                (Sight::Drawn, _) => {
                    steps.push(Step::Draw(subtree));
                    ahead.look(chunk, selection, subtree, settled, |page| steps.push(Step::Ahead(page)))?;
                }
                (Sight::Refined { settled }, Some(page)) => {
                    let wish = Wish::below(&node, Piece::Page(page), selection, true);
                    steps.push(Step::Enter(subtree, settled, wish));
                }
                (Sight::Refined { settled }, None) => {
                    let [left, right] = chunk.children(&subtree)?;
                    stack.push((right, settled));
                    stack.push((left, settled));
                }
            }
        }
        Ok(())
    }

    /// Adds the pages of a chunk that a selection goes into, or would with half the tolerance; `wish` is that for the
    /// chunk. None of a damaged one: that is found when it is drawn.
    pub(super) fn add_pages(
        &mut self,
        chunk: &Chunk,
        selection: &Selection,
        wish: &Wish,
        pages: &mut Vec<Wish>,
    ) {
        let (settled, before) = (selection.settled(), pages.len());
        if wish.urgency < 1.0 {
            let looked = self.ahead.look(chunk, selection, chunk.root(), settled, |page| pages.push(page));
            if looked.is_err() {
                pages.truncate(before);
            }
            return;
        }
        if self.make(chunk, selection, settled, wish, &mut Stats::default()).is_err() {
            return;
        }
        pages.extend(self.steps.iter().filter_map(|step| match step {
            Step::Enter(_, _, wish) | Step::Ahead(wish) => Some(*wish),
            Step::Draw(_) => None,
        }));
    }
}

impl Ahead {
    /// Shows the pages of a subtree, which a selection does not go into, that one of half the tolerance would go into.
    fn look(
        &mut self,
        chunk: &Chunk,
        selection: &Selection,
        subtree: Subtree,
        settled: Settled,
        mut show: impl FnMut(Wish),
    ) -> Result<(), fct::Error> {
        let mut stats = Stats::default();
        self.stack.clear();
        self.stack.push((subtree, settled));
        while let Some((subtree, settled)) = self.stack.pop() {
            if subtree.face_count() == 1 {
                continue;
            }
            let node = chunk.node(&subtree)?;
            let Some(settled) = selection.shows(&node, subtree.face_count(), settled, &mut stats) else {
                continue;
            };
            let page = chunk.page(&subtree);
            let wish = Wish::below(&node, Piece::Page(page.unwrap_or_default()), selection, false);
            if !wish.is_close() {
                continue;
            }
            if page.is_some() {
                show(wish);
            } else {
                let [left, right] = chunk.children(&subtree)?;
                self.stack.push((right, settled));
                self.stack.push((left, settled));
            }
        }
        Ok(())
    }
}

impl Wish {
    /// How much a piece below a root is wished for; `needed` if the selection goes below it.
    pub(super) fn below(root: &Node, piece: Piece, selection: &Selection, needed: bool) -> Wish {
        let (key, urgency) = selection.level_of_node(&selection.tolerance, root);
        // Where nothing is allowed flat pieces are needed too.
        let urgency = if needed { urgency.max(1.0) } else { urgency };
        Wish { piece, urgency, key }
    }

    /// Whether half the tolerance would need the piece.
    pub(super) fn is_close(&self) -> bool {
        self.urgency > 0.5
    }
}
