//! Which chunks are in memory, and which one goes when there is no room.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::Wish;
use fct::Chunk;

/// The chunks in memory, within a budget of bytes.
pub(super) struct Slots {
    slots: Vec<Slot>,
    budget: u64,
    /// Bytes of the chunks that are there, and of those that are being read.
    taken: u64,
    peak: u64,
    evictions: u64,
}

/// A chunk's place.
#[derive(Default)]
struct Slot {
    state: State,
    /// The frame in which it was used last.
    used: AtomicU64,
    /// How urgent it was then, as bits.
    urgency: AtomicU64,
}

#[derive(Default)]
enum State {
    #[default]
    Missing,
    /// Being read, with so many bytes set aside.
    Reading(u64),
    Here(Box<Chunk>),
    /// It could not be read; it is not tried again.
    Broken(Arc<fct::Error>),
}

/// How much more urgent a chunk must be to take the place of one that is in use: two chunks do not take turns.
const MORE_URGENT: f64 = 1.25;

impl Slots {
    pub(super) fn new(chunks: u32, budget: u64) -> Slots {
        let slots = (0..chunks).map(|_| Slot::default()).collect();
        Slots { slots, budget, taken: 0, peak: 0, evictions: 0 }
    }

    pub(super) fn get(&self, chunk: u32) -> Option<&Chunk> {
        match &self.slots.get(chunk as usize)?.state {
            State::Here(chunk) => Some(chunk),
            _ => None,
        }
    }

    /// Notes that a chunk is used. Needs no lock but that of a reader.
    pub(super) fn touch(&self, chunk: u32, frame: u64, urgency: f64) {
        if let Some(slot) = self.slots.get(chunk as usize) {
            let before = slot.used.fetch_max(frame, Ordering::Relaxed);
            let bits = urgency.max(0.0).to_bits();
            // Bits of numbers that are not negative stand in their order.
            if before < frame {
                slot.urgency.store(bits, Ordering::Relaxed);
            } else {
                slot.urgency.fetch_max(bits, Ordering::Relaxed);
            }
        }
    }

    /// Sets room aside for a chunk that is to be read; false if it is there or being read or broken, or if there is no
    /// room. Those used longest ago go first; those used in frame `in_use_from` or later
    /// only for more urgent ones.
    pub(super) fn reserve(&mut self, wish: &Wish, bytes: u64, frame: u64, in_use_from: u64) -> bool {
        let Some(slot) = self.slots.get(wish.chunk as usize) else { return false };
        if !matches!(slot.state, State::Missing) || bytes > self.budget {
            return false;
        }
        let goes = self.victims(wish, bytes, in_use_from);
        let freed: u64 = goes.iter().map(|(_, bytes)| bytes).sum();
        if self.taken - freed + bytes > self.budget {
            return false;
        }
        for (chunk, _) in goes {
            self.evict(chunk);
        }
        self.taken += bytes;
        self.peak = self.peak.max(self.taken);
        if let Some(slot) = self.slots.get_mut(wish.chunk as usize) {
            slot.state = State::Reading(bytes);
            // It counts as used now, so that it does not go before it was drawn.
            slot.used.store(frame, Ordering::Relaxed);
            slot.urgency.store(wish.urgency.max(0.0).to_bits(), Ordering::Relaxed);
        }
        true
    }

    /// The chunks that go to make room, as few as can be, and their bytes.
    fn victims(&self, wish: &Wish, bytes: u64, in_use_from: u64) -> Vec<(usize, u64)> {
        let mut needed = (self.taken + bytes).saturating_sub(self.budget);
        if needed == 0 {
            return Vec::new();
        }
        let mut there: Vec<(u64, f64, usize, u64)> = Vec::new();
        for (index, slot) in self.slots.iter().enumerate() {
            let State::Here(chunk) = &slot.state else { continue };
            let used = slot.used.load(Ordering::Relaxed);
            let urgency = f64::from_bits(slot.urgency.load(Ordering::Relaxed));
            if used < in_use_from {
                there.push((used, urgency, index, chunk.bytes()));
            } else if urgency * MORE_URGENT < wish.urgency {
                // After all that are not in use, the least urgent first.
                there.push((u64::MAX, urgency, index, chunk.bytes()));
            }
        }
        there.sort_unstable_by_key(|entry| (entry.0, entry.2));
        let in_use = there.partition_point(|entry| entry.0 < u64::MAX);
        if let Some(in_use) = there.get_mut(in_use..) {
            in_use.sort_unstable_by(|a, b| a.1.total_cmp(&b.1).then(a.2.cmp(&b.2)));
        }
        let mut goes = Vec::new();
        for (_, _, index, bytes) in there {
            if needed == 0 {
                break;
            }
            needed = needed.saturating_sub(bytes);
            goes.push((index, bytes));
        }
        goes
    }

    fn evict(&mut self, index: usize) {
        let Some(slot) = self.slots.get_mut(index).filter(|slot| matches!(slot.state, State::Here(_))) else {
            return;
        };
        if let State::Here(chunk) = std::mem::take(&mut slot.state) {
            self.taken -= chunk.bytes();
            self.evictions += 1;
        }
    }

    /// Puts a chunk where room was set aside for it, or notes why it is not there.
    pub(super) fn fill(&mut self, chunk: u32, read: Result<Chunk, fct::Error>) {
        let Some(slot) = self.slots.get_mut(chunk as usize) else { return };
        let State::Reading(reserved) = slot.state else { return };
        self.taken -= reserved;
        slot.state = match read {
            // A chunk never takes more than was set aside; if it did it would have to go.
            Ok(chunk) if chunk.bytes() <= reserved => {
                self.taken += chunk.bytes();
                State::Here(Box::new(chunk))
            }
            Ok(_) => State::Missing,
            Err(error) => State::Broken(Arc::new(error)),
        };
    }

    /// Throws a chunk away that turned out to be damaged.
    pub(super) fn break_chunk(&mut self, chunk: u32, error: fct::Error) {
        let index = chunk as usize;
        self.evict(index);
        // Another thread may have found it first, and its error stays.
        if let Some(slot) = self.slots.get_mut(index).filter(|slot| matches!(slot.state, State::Missing)) {
            slot.state = State::Broken(Arc::new(error));
        }
    }

    /// The errors of the chunks that could not be read, in order.
    pub(super) fn errors(&self) -> Vec<(u32, Arc<fct::Error>)> {
        let broken = |(index, slot): (u32, &Slot)| match &slot.state {
            State::Broken(error) => Some((index, error.clone())),
            _ => None,
        };
        (0..).zip(&self.slots).filter_map(broken).collect()
    }

    /// Chunks that could not be read may be tried again.
    pub(super) fn retry(&mut self) {
        for slot in &mut self.slots {
            if matches!(slot.state, State::Broken(_)) {
                slot.state = State::Missing;
            }
        }
    }

    /// The chunks that are there, in order.
    pub(super) fn resident(&self) -> Vec<u32> {
        (0..).zip(&self.slots).filter(|(_, s)| matches!(s.state, State::Here(_))).map(|(i, _)| i).collect()
    }

    /// Bytes taken now and at most, and chunks that had to go.
    pub(super) fn counts(&self) -> [u64; 3] {
        [self.taken, self.peak, self.evictions]
    }
}
