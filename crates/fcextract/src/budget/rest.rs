//! What is left of a budget, spent node by node.

use super::{Budget, Shown};
use crate::copies::Copies;
use crate::corners::Corners;
use crate::count::Counter;
use crate::part::{Settled, Sight};
use crate::{Error, Selection, Stats, Tolerance};
use fct::{Child, Loops, Reader, Subtree, Tree};
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap, VecDeque};

/// A budget of triangles is met when no more than this is left of it, see [`PATIENCE`].
const NEARLY: u64 = 4;

/// So many splits in a row may fail to fit before a budget that is nearly met is left at that.
const PATIENCE: usize = 32;

/// Spends the rest of budgets; keeps its memory from one to the next.
#[derive(Debug, Default)]
pub(super) struct Rest {
    fronts: Vec<Front>,
    /// Of each tree, however many instances show it.
    copies: Vec<Copies>,
    /// Of each front, the place of its tree's copies.
    copies_of: Vec<usize>,
    work: Work,
    /// Nodes to be refined, the next one on top.
    waiting: BinaryHeap<Candidate>,
    /// The next ones of them, for which the fronts watch.
    next: VecDeque<Candidate>,
    /// Nodes that came from splits.
    fresh: BinaryHeap<Candidate>,
}

/// A node of a cut that could be refined.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    /// The factor below which the tolerance would refine it.
    level: f64,
    key: f32,
    /// Its tree's place in what is shown.
    of: u32,
    node: u32,
    slot: u32,
}

impl Rest {
    /// Refines nodes as long as one fits; returns what is drawn then, of which `count` is drawn already, and what would be
    /// with the smallest of the splits that did not fit.
    ///
    /// `shape` are the tolerances by which nodes are ordered.
    pub(super) fn spend(
        &mut self,
        shown: &mut [Shown<'_>],
        shape: &[Tolerance],
        budget: Budget,
        mut count: u64,
    ) -> Result<(u64, Option<u64>), Error> {
        let wanted = budget.wanted();
        let mut smallest: Option<u64> = None;
        self.begin(shown, shape)?;
        let mut failed = 0;
        while count < wanted {
            if self.next.is_empty() && !self.waiting.is_empty() {
                let some = ((wanted - count) / 2).max(64);
                self.watch(shown, usize::try_from(some).unwrap_or(usize::MAX), budget)?;
            }
            let from_split = self.fresh.peek() > self.next.front();
            let next = if from_split { self.fresh.pop() } else { self.next.pop_front() };
            let Some(candidate) = next else { break };
            let of = candidate.of as usize;
            let copies = self.copies_of.get(of).and_then(|place| self.copies.get(*place));
            let (Some(front), Some(one), Some(shape), Some(copies)) =
                (self.fronts.get_mut(of), shown.get_mut(of), shape.get(of), copies)
            else {
                continue;
            };
            match front.split(one, copies, &mut self.work, candidate, budget, wanted - count)? {
                Change::Made(change) => {
                    count = count.saturating_add_signed(change);
                    self.fresh.extend(front.candidates_from(one, shape, candidate.of, front.last_split)?);
                    failed = 0;
                }
                Change::TooLarge(change) => {
                    smallest = Some(smallest.map_or(change, |so_far| so_far.min(change)));
                    failed += 1;
                }
            }
            if failed >= PATIENCE && wanted - count <= NEARLY {
                break;
            }
        }
        Ok((count, smallest.map(|change| count.saturating_add(change))))
    }

    /// Finds all nodes of the cuts.
    fn begin(&mut self, shown: &[Shown<'_>], shape: &[Tolerance]) -> Result<(), Error> {
        if self.fronts.len() < shown.len() {
            self.fronts.resize_with(shown.len(), Front::default);
        }
        self.read_copies(shown);
        self.next.clear();
        self.fresh.clear();
        let mut all = std::mem::take(&mut self.waiting).into_vec();
        all.clear();
        let found: Vec<Vec<Candidate>> = self
            .fronts
            .par_iter_mut()
            .zip(shown)
            .zip(shape)
            .enumerate()
            .map_init(Vec::new, |stack, (of, ((front, one), shape))| {
                front.read(one, stack)?;
                front.candidates_from(one, shape, of as u32, 0)
            })
            .collect::<Result<_, Error>>()?;
        all.extend(found.into_iter().flatten());
        self.waiting = BinaryHeap::from(all);
        Ok(())
    }

    fn read_copies(&mut self, shown: &[Shown<'_>]) {
        let mut places: HashMap<*const Tree, usize> = HashMap::new();
        self.copies_of.clear();
        for one in shown {
            let next = places.len();
            let place = *places.entry(std::ptr::from_ref(one.tree)).or_insert(next);
            if place == next {
                if self.copies.len() <= place {
                    self.copies.push(Copies::default());
                }
                if let Some(copies) = self.copies.get_mut(place) {
                    copies.read(one.tree);
                }
            }
            self.copies_of.push(place);
        }
    }

    /// Takes the next nodes from those that wait, and lets their fronts watch the vertices that they may need.
    fn watch(&mut self, shown: &[Shown<'_>], some: usize, budget: Budget) -> Result<(), Error> {
        while self.next.len() < some
            && let Some(candidate) = self.waiting.pop()
        {
            self.next.push_back(candidate);
        }
        if let Budget::Clusters(_) = budget {
            return Ok(());
        }
        let mut tried: Vec<(u32, u32)> =
            self.next.iter().chain(self.fresh.iter()).map(|c| (c.of, c.slot)).collect();
        tried.sort_unstable();
        let (copies, copies_of) = (&self.copies, &self.copies_of);
        self.fronts.par_iter_mut().zip(shown).zip(copies_of).enumerate().try_for_each_init(
            Loops::default,
            |loops, (of, ((front, one), copies_of))| {
                let of = of as u32;
                let first = tried.partition_point(|(other, _)| *other < of);
                let slots = tried.iter().skip(first).take_while(|(other, _)| *other == of);
                let Some(copies) = copies.get(*copies_of) else { return Ok(()) };
                front.watch(one, copies, loops, slots.map(|(_, slot)| *slot))
            },
        )
    }
}

/// The cut of one tree while it is refined.
#[derive(Debug, Default)]
struct Front {
    slots: Vec<Slot>,
    /// Vertices that are not drawn, each with the clusters of the cut on whose boundary it lies, two at most: where three
    /// meet it would be drawn.
    watched: HashMap<u32, [u32; 2]>,
    /// The first slot of the last split.
    last_split: usize,
}

/// Subtrees to look at, each with whether it lies in the frustum as a whole.
type Stack = Vec<(Subtree, Settled)>;

/// What the split under trial is found out with, of whichever front; one for all, since an instance may be one of a million.
#[derive(Debug, Default)]
struct Work {
    corners: Corners,
    counter: Counter,
    loops: Loops,
    /// Vertices that need to be drawn, once for all their copies.
    needed: Vec<u32>,
    /// Vertices that the split adds.
    added: Vec<u32>,
    pieces: Vec<Slot>,
    stack: Stack,
    /// Slots of the clusters that get more corners by it.
    touched: Vec<u32>,
}

/// What a split changes in what is counted.
enum Change {
    Made(i64),
    /// There is no room for so many more, and all is as it was.
    TooLarge(u64),
}

/// A cluster of the cut, or one that was.
#[derive(Clone, Copy, Debug)]
struct Slot {
    subtree: Subtree,
    settled: Settled,
    is_drawn: bool,
}

const NO_SLOT: u32 = u32::MAX;

impl Front {
    /// Begins with the cut that the tolerance alone makes.
    fn read(&mut self, shown: &Shown<'_>, stack: &mut Stack) -> Result<(), Error> {
        self.slots.clear();
        self.watched.clear();
        let reader = shown.tree.reader();
        stack.clear();
        stack.push((reader.whole(), shown.selection.settled()));
        add_pieces(&reader, shown, stack, &mut self.slots)
    }

    /// The nodes among the slots from one on, which could be refined.
    fn candidates_from(
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

    /// Watches the vertices on the boundaries of some clusters that are not drawn.
    fn watch(
        &mut self,
        shown: &Shown<'_>,
        copies: &Copies,
        loops: &mut Loops,
        slots: impl Iterator<Item = u32>,
    ) -> Result<(), Error> {
        self.watched.clear();
        let (reader, selection) = (shown.tree.reader(), &shown.selection);
        let mut is_wanted = crate::extra::Bits::default();
        for slot in slots.filter_map(|s| self.slots.get(s as usize)) {
            reader.read_loops(&slot.subtree, loops)?;
            for &vertex in &loops.vertices {
                // With one copy all of them are wanted.
                if !selection.draws(&reader, vertex) && !is_wanted.has(vertex) {
                    copies.each(shown.tree, vertex, |copy| {
                        is_wanted.add(copy);
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
    fn split(
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
        let reader = shown.tree.reader();
        let children = reader.children(&old.subtree)?;
        work.find_added(shown, copies, &children, candidate.key)?;
        let counts_triangles = matches!(budget, Budget::Triangles(_));
        let mut change = -1;
        if counts_triangles {
            work.find_touched(self, candidate.slot);
            change = -work.count(&reader, &shown.selection, &[old], &self.slots)?;
        }
        let extra = &mut shown.selection.extra;
        extra.nodes.add(candidate.node);
        for &vertex in &work.added {
            extra.vertices.add(vertex);
        }
        work.pieces.clear();
        work.stack.clear();
        work.stack.extend(children.iter().rev().map(|child| (*child, old.settled)));
        add_pieces(&reader, shown, &mut work.stack, &mut work.pieces)?;
        let pieces = std::mem::take(&mut work.pieces);
        change += if counts_triangles {
            work.count(&reader, &shown.selection, &pieces, &self.slots)?
        } else {
            pieces.len() as i64
        };
        work.pieces = pieces;
        if change > 0 && change as u64 > room {
            let extra = &mut shown.selection.extra;
            extra.nodes.remove(candidate.node);
            for &vertex in &work.added {
                extra.vertices.remove(vertex);
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

impl Work {
    /// Finds the vertices that a split adds to those that are drawn.
    fn find_added(
        &mut self,
        shown: &Shown<'_>,
        copies: &Copies,
        children: &[Subtree; 2],
        key: f32,
    ) -> Result<(), Error> {
        let Shown { tree, selection } = shown;
        let reader = tree.reader();
        let needed = self
            .corners
            .of_split(&reader, children, selection.order, key, |v| selection.draws(&reader, v))?;
        // One of many copies stands for all of them: they are drawn together.
        self.needed.clear();
        let missing = needed.iter().filter(|v| !selection.draws(&reader, **v));
        self.needed.extend(missing.map(|v| tree.original(*v)));
        self.needed.sort_unstable();
        self.needed.dedup();
        self.added.clear();
        for &vertex in &self.needed {
            copies.each(tree, vertex, |copy| {
                if !selection.draws(&reader, copy) {
                    self.added.push(copy);
                }
            });
        }
        self.added.sort_unstable();
        self.added.dedup();
        Ok(())
    }

    /// Finds the clusters, other than the one that is split, that get more corners by that.
    fn find_touched(&mut self, front: &Front, split: u32) {
        self.touched.clear();
        let is_drawn =
            |s: &u32| *s != split && front.slots.get(*s as usize).is_some_and(|slot| slot.is_drawn);
        for around in self.added.iter().filter_map(|vertex| front.watched.get(vertex)) {
            self.touched.extend(around.iter().copied().filter(is_drawn));
        }
        self.touched.sort_unstable();
        self.touched.dedup();
    }

    /// Counts the triangles that the split may change, as the selection is now: of the clusters that are drawn for the
    /// one that is split, and of those around.
    fn count(
        &mut self,
        reader: &Reader<'_>,
        selection: &Selection,
        drawn: &[Slot],
        slots: &[Slot],
    ) -> Result<i64, Error> {
        let around = self.touched.iter().filter_map(|s| slots.get(*s as usize));
        let mut sum = 0;
        for slot in drawn.iter().chain(around) {
            sum += self.counter.subtree(reader, selection, &slot.subtree)? as i64;
        }
        Ok(sum)
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

impl Ord for Candidate {
    /// The one to be refined first is the greatest.
    fn cmp(&self, other: &Candidate) -> Ordering {
        let by_key = self.level.total_cmp(&other.level).then(self.key.total_cmp(&other.key));
        by_key.then((other.of, other.node).cmp(&(self.of, self.node)))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Candidate) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Candidate) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}
