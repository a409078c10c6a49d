//! What is left of a budget, spent node by node.

use super::candidate::Candidate;
use super::front::{Change, Front};
use super::trial::Work;
use super::{Budget, Shown};
use crate::copies::Copies;
use crate::{Error, Tolerance};
use fct::{Loops, Tree};
use rayon::prelude::*;
use std::collections::{BinaryHeap, HashMap, HashSet, VecDeque};

/// A budget of triangles is met when no more than this is left of it, see [`PATIENCE`].
const NEARLY: u64 = 4;

/// So many splits in a row may fail to fit before a budget that is nearly met is left at that.
const PATIENCE: usize = 32;

/// So many vertices may be looked at for splits that do not fit, which takes a second or two. Where thousands of vertices
/// stand at one place each try looks at the clusters around all of them, and where no split is small enough every
/// cluster is tried.
const MOST_IN_VAIN: u64 = 1 << 27;

/// So many fronts watch at once, at most: one takes some ten thousand bytes for that.
const MOST_WATCHING: usize = 4096;

/// So many nodes are taken from those that wait, at least.
const FEWEST_AT_ONCE: u64 = 64;

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
    /// The fronts that watch.
    watching: Vec<u32>,
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
        let (mut failed, mut in_vain, mut taken) = (0, 0, 0);
        while count < wanted && in_vain < MOST_IN_VAIN {
            if self.next.is_empty() && !self.waiting.is_empty() {
                // As many as before, at least: watching them takes a look at all clusters of their fronts.
                let some = ((wanted - count) / 2).max(taken).max(FEWEST_AT_ONCE);
                taken += some;
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
            let before = self.work.looked_at();
            match front.split(one, copies, &mut self.work, candidate, budget, wanted - count)? {
                Change::Made(change) => {
                    count = count.saturating_add_signed(change);
                    self.fresh.extend(front.candidates_from(one, shape, candidate.of, front.last_split)?);
                    failed = 0;
                }
                Change::TooLarge(change) => {
                    smallest = Some(smallest.map_or(change, |so_far| so_far.min(change)));
                    failed += 1;
                    in_vain += self.work.looked_at() - before;
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
        self.watching.clear();
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
        // Those from splits wait with the others: whose turn is far off need not be watched for.
        self.waiting.extend(self.fresh.drain());
        let mut of = HashSet::new();
        while self.next.len() < some
            && of.len() < MOST_WATCHING
            && let Some(candidate) = self.waiting.pop()
        {
            of.insert(candidate.of);
            self.next.push_back(candidate);
        }
        if let Budget::Clusters(_) = budget {
            return Ok(());
        }
        let mut tried: Vec<(u32, u32)> = self.next.iter().map(|c| (c.of, c.slot)).collect();
        tried.sort_unstable();
        // Of a million fronts few have a node among these.
        let before = std::mem::take(&mut self.watching);
        for front in fronts(&mut self.fronts, before) {
            front.forget_watched();
        }
        let slots: Vec<&[(u32, u32)]> = tried.chunk_by(|a, b| a.0 == b.0).collect();
        self.watching = slots.iter().filter_map(|slots| slots.first()).map(|(of, _)| *of).collect();
        let (copies, copies_of) = (&self.copies, &self.copies_of);
        let some = fronts(&mut self.fronts, self.watching.iter().copied());
        some.into_par_iter().zip(slots).try_for_each_init(Loops::default, |loops, (front, slots)| {
            let Some(of) = slots.first().map(|(of, _)| *of as usize) else { return Ok(()) };
            let copies = copies_of.get(of).and_then(|place| copies.get(*place));
            let (Some(one), Some(copies)) = (shown.get(of), copies) else { return Ok(()) };
            front.watch(one, copies, loops, slots.iter().map(|(_, slot)| *slot))
        })
    }
}

/// The fronts at some places, which are in order.
fn fronts(all: &mut [Front], places: impl IntoIterator<Item = u32>) -> Vec<&mut Front> {
    let mut found = Vec::new();
    let (mut rest, mut first) = (all, 0);
    for place in places {
        let Some((front, behind)) =
            rest.get_mut((place as usize).saturating_sub(first)..).and_then(<[Front]>::split_first_mut)
        else {
            break;
        };
        found.push(front);
        (rest, first) = (behind, place as usize + 1);
    }
    found
}
