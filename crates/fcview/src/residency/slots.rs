//! Which page is in which slot, and which one goes when another one comes.

/// No page, no slot.
const NONE: u32 = u32::MAX;

/// Slots for pages, a fixed number of each. Knows no device.
pub(crate) struct Slots {
    /// The slot of each page.
    slot_of: Vec<u32>,
    /// The page in each slot.
    page_of: Vec<u32>,
    /// When each slot was last used; 0 for never.
    used: Vec<u64>,
    now: u64,
    resident: u32,
}

/// A page and the slot that it comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Arrival {
    pub(crate) slot: u32,
    pub(crate) page: u32,
}

impl Slots {
    /// Empty slots.
    pub(crate) fn new(slots: u32, pages: u32) -> Slots {
        Slots {
            slot_of: vec![NONE; pages as usize],
            page_of: vec![NONE; slots as usize],
            used: vec![0; slots as usize],
            now: 0,
            resident: 0,
        }
    }

    /// The number of slots.
    pub(crate) fn len(&self) -> u32 {
        self.page_of.len() as u32
    }

    /// The number of pages that are somewhere in a slot.
    pub(crate) fn resident(&self) -> u32 {
        self.resident
    }

    /// The slot of a page.
    #[inline]
    pub(crate) fn slot(&self, page: u32) -> Option<u32> {
        self.slot_of.get(page as usize).copied().filter(|slot| *slot != NONE)
    }

    /// Empties all slots.
    pub(crate) fn clear(&mut self) {
        self.slot_of.fill(NONE);
        self.page_of.fill(NONE);
        self.used.fill(0);
        self.resident = 0;
    }

    /// Counts those pages as used now that are there and will be needed, so that others go first.
    pub(crate) fn keep(&mut self, is_needed: impl Fn(u32) -> bool) {
        self.now += 1;
        for (page, used) in self.page_of.iter().zip(&mut self.used) {
            if *page != NONE && is_needed(*page) {
                *used = self.now;
            }
        }
    }

    /// Makes room for pages that are used together, distinct ones and no more than there are slots: those that are not
    /// there take free slots first, then those of the least recently used pages. Returns them by slot, and how many
    /// pages went.
    pub(crate) fn place(&mut self, pages: &[u32]) -> (Vec<Arrival>, u32) {
        self.now += 1;
        let mut missing = Vec::new();
        for page in pages {
            match self.slot(*page) {
                Some(slot) => {
                    if let Some(used) = self.used.get_mut(slot as usize) {
                        *used = self.now;
                    }
                }
                None => missing.push(*page),
            }
        }
        if missing.is_empty() {
            return (Vec::new(), 0);
        }
        let mut oldest: Vec<(u64, u32)> =
            self.used.iter().copied().zip(0..).filter(|(used, _)| *used < self.now).collect();
        if let Some(last) = missing.len().checked_sub(1).filter(|last| *last < oldest.len()) {
            oldest.select_nth_unstable(last);
            oldest.truncate(missing.len());
        }
        // Neighbours are copied together.
        oldest.sort_unstable_by_key(|(_, slot)| *slot);
        let mut arrivals = Vec::with_capacity(missing.len());
        let mut gone = 0;
        for ((_, slot), page) in oldest.into_iter().zip(missing) {
            let (Some(held), Some(used)) =
                (self.page_of.get_mut(slot as usize), self.used.get_mut(slot as usize))
            else {
                continue;
            };
            let before = std::mem::replace(held, page);
            *used = self.now;
            match self.slot_of.get_mut(before as usize) {
                Some(left) => {
                    *left = NONE;
                    gone += 1;
                }
                None => self.resident += 1,
            }
            if let Some(taken) = self.slot_of.get_mut(page as usize) {
                *taken = slot;
            }
            arrivals.push(Arrival { slot, page });
        }
        (arrivals, gone)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pages(arrivals: &[Arrival]) -> Vec<u32> {
        arrivals.iter().map(|arrival| arrival.page).collect()
    }

    #[test]
    fn the_least_recently_used_page_goes() {
        let mut slots = Slots::new(3, 10);
        let (came, gone) = slots.place(&[4, 7]);
        assert_eq!((pages(&came), gone, slots.resident()), (vec![4, 7], 0, 2));
        assert_eq!(slots.place(&[7]), (vec![], 0));
        let (came, gone) = slots.place(&[1]);
        assert_eq!((pages(&came), gone, slots.resident()), (vec![1], 0, 3));
        // Of 4, 7 and 1 the first was used before the others.
        let (came, gone) = slots.place(&[2]);
        assert_eq!((pages(&came), gone, slots.resident()), (vec![2], 1, 3));
        assert_eq!([4, 7, 1, 2].map(|page| slots.slot(page).is_some()), [false, true, true, true]);
        slots.clear();
        assert_eq!((slots.resident(), slots.slot(7)), (0, None));
    }

    #[test]
    fn what_is_kept_stays_while_others_can_go() {
        let mut slots = Slots::new(4, 10);
        slots.place(&[0]);
        slots.place(&[1]);
        slots.place(&[2]);
        slots.place(&[3]);
        slots.keep(|page| page < 2);
        let (_, gone) = slots.place(&[8, 9]);
        assert_eq!(gone, 2);
        assert_eq!([0, 1, 2, 3].map(|page| slots.slot(page).is_some()), [true, true, false, false]);
    }

    #[test]
    fn at_random_each_page_is_in_the_slot_that_names_it() {
        let mut random = crate::random::Random::new(3);
        let mut slots = Slots::new(16, 50);
        for _ in 0..2000 {
            let mut wanted: Vec<u32> = (0..random.below(17)).map(|_| random.below(50) as u32).collect();
            wanted.sort_unstable();
            wanted.dedup();
            let before = slots.resident();
            let (came, gone) = slots.place(&wanted);
            assert_eq!(slots.resident(), before + came.len() as u32 - gone);
            assert!(came.is_sorted_by(|a, b| a.slot < b.slot));
            for page in &wanted {
                let slot = slots.slot(*page).expect("it was placed");
                assert_eq!(slots.page_of[slot as usize], *page);
            }
            let held = slots.page_of.iter().filter(|page| **page != NONE).count();
            let known = slots.slot_of.iter().filter(|slot| **slot != NONE).count();
            assert_eq!((held as u32, known as u32), (slots.resident(), slots.resident()));
        }
    }
}
