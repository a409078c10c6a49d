//! The split under trial: which vertices it adds, which clusters they touch, and what that comes to.

use super::Shown;
use super::front::{Front, Slot, Stack};
use crate::copies::Copies;
use crate::corners::Corners;
use crate::count::Counter;
use crate::eager::Table;
use crate::{Error, Selection};
use fct::{Loops, Reader, Subtree};

/// What the split under trial is found out with, of whichever front; one for all, since an instance may be one of a million.
#[derive(Debug, Default)]
pub(super) struct Work {
    pub(super) corners: Corners,
    pub(super) counter: Counter,
    pub(super) loops: Loops,
    /// Vertices that need to be drawn, once for all their copies.
    pub(super) needed: Vec<u32>,
    /// Vertices that the split adds.
    pub(super) added: Vec<u32>,
    pub(super) pieces: Vec<Slot>,
    pub(super) stack: Stack,
    /// Slots of the clusters that get more corners by it.
    pub(super) touched: Vec<u32>,
    looked_at: u64,
}
impl Work {
    /// How many vertices were looked at so far.
    pub(super) fn looked_at(&self) -> u64 {
        self.counter.looked_at + self.looked_at
    }

    /// Finds the vertices that a split adds to those that are drawn.
    pub(super) fn find_added(
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
        self.looked_at += self.added.len() as u64;
        Ok(())
    }

    /// Finds the clusters, other than the one that is split, that get more corners by that.
    pub(super) fn find_touched(&mut self, front: &Front, split: u32) {
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
    pub(super) fn count(
        &mut self,
        (reader, eager): (&Reader<'_>, Option<&Table>),
        selection: &Selection,
        drawn: &[Slot],
        slots: &[Slot],
    ) -> Result<i64, Error> {
        let around = self.touched.iter().filter_map(|s| slots.get(*s as usize));
        let mut sum = 0;
        for slot in drawn.iter().chain(around) {
            sum += self.counter.subtree((reader, eager), selection, &slot.subtree)? as i64;
        }
        Ok(sum)
    }
}
