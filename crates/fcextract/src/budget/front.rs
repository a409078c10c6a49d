//! A cut while it is refined: its clusters, and who is touched when a vertex is drawn.

use super::candidate::Candidate;
use super::trial::Work;
use super::{Budget, Shown};
use crate::copies::Copies;
use crate::eager::Eager;
use crate::extra::{Bits, Places};
use crate::part::{Settled, Sight};
use crate::{Error, Stats, Tolerance};
use fct::{Child, Loops, Reader, Subtree};
use glam::DVec3;
use std::collections::HashMap;

/// The cut of one tree while it is refined.
#[derive(Debug, Default)]
pub(super) struct Front {
    pub(super) slots: Vec<Slot>,
    /// Vertices that are not drawn, each with the clusters of the cut on whose boundary it lies, two at most: where three
    /// meet it would be drawn.
    pub(super) watched: HashMap<u32, [u32; 2]>,
    /// The first slot of the last split.
    pub(super) last_split: usize,
}

/// Subtrees to look at, each with whether it lies in the frustum as a whole.
pub(super) type Stack = Vec<(Subtree, Settled)>;

/// What a split changes in what is counted.
pub(super) enum Change {
    /// So much.
    Made(i64),
    /// There is no room for so many more, and all is as it was.
    TooLarge(u64),
}

/// A cluster of the cut, or one that was.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slot {
    pub(super) subtree: Subtree,
    /// What is known of all below it.
    pub(super) settled: Settled,
    pub(super) is_drawn: bool,
}

const NO_SLOT: u32 = u32::MAX;

impl Front {
    /// Begins with the cut that the tolerance alone makes.
    pub(super) fn read(&mut self, shown: &Shown<'_>, stack: &mut Stack) -> Result<(), Error> {
        self.slots.clear();
        self.watched.clear();
        let reader = shown.tree.reader();
        stack.clear();
        stack.push((reader.whole(), shown.selection.settled()));
        add_pieces(&reader, shown, stack, &mut self.slots)
    }

    /// The nodes among the slots from one on, which could be refined.
    pub(super) fn candidates_from(
        &self,
        shown: &Shown<'_>,
        shape: &Tolerance,
        of: u32,
        first: usize,
    ) -> Result<Vec<Candidate>, Error> {
        let reader = shown.tree.reader();
        let mut found = Vec::new();
        for (slot, number) in self.slots.iter().zip(0_u32..).skip(first) {
            let Child::Node(node) = slot.subtree.child.kind() else { continue };
            let decoded = reader.node(&slot.subtree)?;
            let (key, level) = shown.selection.level_of_node(shape, &decoded);
            found.push(Candidate { level, key, of, node, slot: number });
        }
        Ok(found)
    }

    /// Watches nothing any more, and gives the memory back: there may be a million more.
    pub(super) fn forget_watched(&mut self) {
        self.watched = HashMap::new();
    }

    /// Watches the vertices on the boundaries of some clusters that are not drawn.
    pub(super) fn watch(
        &mut self,
        shown: &Shown<'_>,
        copies: &Copies,
        loops: &mut Loops,
        slots: impl Iterator<Item = u32>,
    ) -> Result<(), Error> {
        self.watched.clear();
        let (reader, selection) = (shown.tree.reader(), &shown.selection);
        let (mut is_wanted, mut places) = (Bits::default(), Places::default());
        for slot in slots.filter_map(|s| self.slots.get(s as usize)) {
            reader.read_loops(&slot.subtree, loops)?;
            for &vertex in &loops.vertices {
                // With one copy all of them are wanted.
                if !selection.draws(&reader, vertex) && !is_wanted.has(vertex) {
                    copies.each(shown.tree, vertex, |copy| {
                        if is_wanted.add(copy)
                            && let Some(record) = reader.vertices().get(copy as usize)
                        {
                            places.add(record.position());
                        }
                    });
                }
            }
        }
        if is_wanted.is_empty() {
            return Ok(());
        }
        for number in 0..self.slots.len() {
            let Some(slot) = self.slots.get(number).filter(|slot| slot.is_drawn) else { continue };
            if let Child::Node(_) = slot.subtree.child.kind() {
                let node = reader.node(&slot.subtree)?;
                if !places.any_within(DVec3::from(node.center.map(f64::from)), f64::from(node.radius)) {
                    continue;
                }
                reader.read_loops(&slot.subtree, loops)?;
                for &vertex in &loops.vertices {
                    if is_wanted.has(vertex) {
                        enter(&mut self.watched, &self.slots, vertex, number as u32);
                    }
                }
            }
        }
        Ok(())
    }

    /// Splits a cluster if there is room for it.
    pub(super) fn split(
        &mut self,
        shown: &mut Shown<'_>,
        copies: &Copies,
        work: &mut Work,
        candidate: Candidate,
        budget: Budget,
        room: u64,
    ) -> Result<Change, Error> {
        let Some(&old) = self.slots.get(candidate.slot as usize) else {
            return Ok(Change::TooLarge(u64::MAX));
        };
        let (reader, eager) = (shown.tree.reader(), Eager::of(shown.tree, shown.selection.order));
        let children = reader.children(&old.subtree)?;
        work.find_added(shown, copies, &children, candidate.key)?;
        let counts_triangles = matches!(budget, Budget::Triangles(_));
        let mut change = -1;
        if counts_triangles {
            work.find_touched(self, candidate.slot);
            change = -work.count((&reader, eager), &shown.selection, &[old], &self.slots)?;
        }
        let extra = &mut shown.selection.extra;
        extra.nodes.add(candidate.node);
        for &vertex in &work.added {
            extra.add_vertex(vertex, reader.vertices().get(vertex as usize));
        }
        work.pieces.clear();
        work.stack.clear();
        work.stack.extend(children.iter().rev().map(|child| (*child, old.settled)));
        add_pieces(&reader, shown, &mut work.stack, &mut work.pieces)?;
        let pieces = std::mem::take(&mut work.pieces);
        change += if counts_triangles {
            work.count((&reader, eager), &shown.selection, &pieces, &self.slots)?
        } else {
            pieces.len() as i64
        };
        work.pieces = pieces;
        if change > 0 && change as u64 > room {
            let extra = &mut shown.selection.extra;
            extra.nodes.remove(candidate.node);
            for &vertex in &work.added {
                extra.remove_vertex(vertex, reader.vertices().get(vertex as usize));
            }
            return Ok(Change::TooLarge(change as u64));
        }
        if let Some(slot) = self.slots.get_mut(candidate.slot as usize) {
            slot.is_drawn = false;
        }
        self.last_split = self.slots.len();
        self.slots.extend(&work.pieces);
        if counts_triangles {
            self.enter_from(&reader, shown, &mut work.loops, self.last_split)?;
        }
        Ok(Change::Made(change))
    }

    /// Enters the clusters of the slots from one on with the vertices on their boundaries.
    fn enter_from(
        &mut self,
        reader: &Reader<'_>,
        shown: &Shown<'_>,
        loops: &mut Loops,
        first: usize,
    ) -> Result<(), Error> {
        for number in first..self.slots.len() {
            let Some(slot) = self.slots.get(number) else { continue };
            if let Child::Node(_) = slot.subtree.child.kind() {
                reader.read_loops(&slot.subtree, loops)?;
                for &vertex in &loops.vertices {
                    if !shown.selection.draws(reader, vertex) {
                        enter(&mut self.watched, &self.slots, vertex, number as u32);
                    }
                }
            }
        }
        Ok(())
    }
}
/// Goes on from the stack to the clusters that are drawn.
fn add_pieces(
    reader: &Reader<'_>,
    shown: &Shown<'_>,
    stack: &mut Stack,
    out: &mut Vec<Slot>,
) -> Result<(), Error> {
    let mut stats = Stats::default();
    while let Some((subtree, settled)) = stack.pop() {
        let slot = Slot { subtree, settled, is_drawn: true };
        if let Child::Face(_) = subtree.child.kind() {
            out.push(slot);
            continue;
        }
        let node = reader.node(&subtree)?;
        match shown.selection.sight(&subtree, &node, settled, &mut stats) {
            Sight::Culled => {}
            Sight::Refined { settled } => {
                let [left, right] = reader.children(&subtree)?;
                stack.extend([(right, settled), (left, settled)]);
            }
            Sight::Drawn => out.push(slot),
        }
    }
    Ok(())
}
/// Notes that a cluster has a vertex on its boundary, in the place of one that is not drawn any more.
fn enter(watched: &mut HashMap<u32, [u32; 2]>, slots: &[Slot], vertex: u32, slot: u32) {
    let around = watched.entry(vertex).or_insert([NO_SLOT; 2]);
    if !around.contains(&slot) {
        let is_free = |s: &&mut u32| slots.get(**s as usize).is_none_or(|slot| !slot.is_drawn);
        if let Some(place) = around.iter_mut().find(is_free) {
            *place = slot;
        }
    }
}
