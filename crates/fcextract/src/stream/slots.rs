//! Which pieces are in memory, and which one goes when there is no room.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::Piece;
use super::loader::Outcome;
use fct::{Chunk, ChunkPage, OwnVertices, VertexRun};

/// The pieces in memory, within a budget of bytes.
pub(super) struct Slots {
    slots: BTreeMap<Key, Slot>,
    budget: u64,
    /// Bytes of the pieces that are there, and of those that are being read.
    taken: u64,
    peak: u64,
    evictions: u64,
    /// Those that go next, the last first, with the frame in which each was used when this was made.
    oldest: Vec<(u64, Key)>,
    /// Nothing was left that was used before this frame. Pieces are used later and never earlier, so that none comes.
    all_used_since: u64,
}

/// What has a place of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Key {
    Piece(Piece),
    /// The vertices of a page that is not there itself: others have needed them.
    Run(u32),
}

/// The place of a piece that was read, or tried to.
struct Slot {
    state: State,
    /// The frame in which it was used last.
    used: AtomicU64,
    /// How urgent it was then, as bits.
    urgency: AtomicU64,
}

enum State {
    /// Being read, with so many bytes set aside.
    Reading(u64),
    Here(Loaded),
    /// It could not be read; it is not tried again.
    Broken(Arc<fct::Error>),
}

/// A piece in memory. Whoever reads another one by it holds it until that is done, even if its place is given away.
#[derive(Clone)]
pub(super) enum Loaded {
    Chunk(Arc<Chunk>),
    Page(Arc<ChunkPage>),
    Run(Arc<VertexRun>),
}

impl Loaded {
    fn bytes(&self) -> u64 {
        match self {
            Loaded::Chunk(chunk) => chunk.bytes(),
            Loaded::Page(page) => page.bytes(),
            Loaded::Run(run) => run.bytes(),
        }
    }

    /// The vertices of a page that this holds.
    pub(super) fn own(&self) -> Option<OwnVertices<'_>> {
        match self {
            Loaded::Chunk(_) => None,
            Loaded::Page(page) => Some(page.own()),
            Loaded::Run(run) => Some(run.own()),
        }
    }
}

/// A piece that is to be read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Order {
    pub(super) key: Key,
    pub(super) bytes: u64,
    pub(super) urgency: f64,
    pub(super) frame: u64,
    /// What was used in this frame or later goes only for what is more urgent.
    pub(super) in_use_from: u64,
}

/// How much more urgent a piece must be to take the place of one that is in use: two do not take turns.
const MORE_URGENT: f64 = 1.25;

impl Slots {
    pub(super) fn new(budget: u64) -> Slots {
        Slots {
            slots: BTreeMap::new(),
            budget,
            taken: 0,
            peak: 0,
            evictions: 0,
            oldest: Vec::new(),
            all_used_since: 0,
        }
    }

    pub(super) fn chunk(&self, chunk: u32) -> Option<&Arc<Chunk>> {
        match &self.slots.get(&Key::Piece(Piece::Chunk(chunk)))?.state {
            State::Here(Loaded::Chunk(chunk)) => Some(chunk),
            _ => None,
        }
    }

    pub(super) fn page(&self, page: u32) -> Option<&Arc<ChunkPage>> {
        match &self.slots.get(&Key::Piece(Piece::Page(page)))?.state {
            State::Here(Loaded::Page(page)) => Some(page),
            _ => None,
        }
    }

    /// What holds the vertices of a page, if it is there.
    pub(super) fn run(&self, page: u32) -> Option<Loaded> {
        [Key::Piece(Piece::Page(page)), Key::Run(page)].iter().find_map(|key| {
            match &self.slots.get(key)?.state {
                State::Here(loaded) => Some(loaded.clone()),
                _ => None,
            }
        })
    }

    pub(super) fn is_here(&self, piece: Piece) -> bool {
        self.slots.get(&Key::Piece(piece)).is_some_and(|slot| matches!(slot.state, State::Here(_)))
    }

    /// Notes that a piece is used. Needs no lock but that of a reader.
    pub(super) fn touch(&self, piece: Piece, frame: u64, urgency: f64) {
        if let Some(slot) = self.slots.get(&Key::Piece(piece)) {
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

    /// Sets room aside for a piece that is to be read, unless it is there, being read or broken. Those used longest ago
    /// go first, those in use only for more urgent ones.
    ///
    /// # Errors
    /// What stands in the way.
    pub(super) fn reserve(&mut self, order: &Order) -> Result<(), Outcome> {
        if self.slots.contains_key(&order.key) {
            return Err(Outcome::Useless);
        }
        let needed = self.taken.saturating_add(order.bytes).saturating_sub(self.budget);
        if order.bytes > self.budget || !self.make_room(needed, order) {
            return Err(Outcome::NoRoom);
        }
        self.taken += order.bytes;
        self.peak = self.peak.max(self.taken);
        let slot = Slot {
            state: State::Reading(order.bytes),
            // It counts as used now, so that it does not go before it was drawn.
            used: AtomicU64::new(order.frame),
            urgency: AtomicU64::new(order.urgency.max(0.0).to_bits()),
        };
        self.slots.insert(order.key, slot);
        Ok(())
    }

    /// Lets pieces go until so many bytes are free; false if that cannot be.
    fn make_room(&mut self, needed: u64, order: &Order) -> bool {
        let mut freed = 0;
        while freed < needed {
            let Some(key) = self.next_idle(order.in_use_from) else { break };
            freed += self.evict(key);
        }
        if freed >= needed {
            return true;
        }
        // All that is left is in use: the least urgent go, if they free enough.
        let mut in_use: Vec<(f64, Key, u64)> = Vec::new();
        for (key, slot) in &self.slots {
            let State::Here(loaded) = &slot.state else { continue };
            let urgency = f64::from_bits(slot.urgency.load(Ordering::Relaxed));
            if urgency * MORE_URGENT < order.urgency {
                in_use.push((urgency, *key, loaded.bytes()));
            }
        }
        if freed + in_use.iter().map(|(_, _, bytes)| bytes).sum::<u64>() < needed {
            return false;
        }
        in_use.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (_, key, _) in in_use {
            if freed >= needed {
                break;
            }
            freed += self.evict(key);
        }
        true
    }

    /// The piece that was used longest ago, if that was before a frame.
    fn next_idle(&mut self, in_use_from: u64) -> Option<Key> {
        let mut is_new = false;
        loop {
            while let Some((used, key)) = self.oldest.pop() {
                let slot = self.slots.get(&key).filter(|slot| matches!(slot.state, State::Here(_)));
                // One that was used meanwhile is no longer the oldest.
                if slot.is_none_or(|slot| slot.used.load(Ordering::Relaxed) != used) {
                    continue;
                }
                if used < in_use_from {
                    return Some(key);
                }
                self.oldest.push((used, key));
                break;
            }
            if is_new || in_use_from <= self.all_used_since {
                self.all_used_since = self.all_used_since.max(in_use_from);
                return None;
            }
            is_new = true;
            self.oldest.clear();
            for (key, slot) in &self.slots {
                if matches!(slot.state, State::Here(_)) {
                    self.oldest.push((slot.used.load(Ordering::Relaxed), *key));
                }
            }
            self.oldest.sort_unstable_by(|a, b| b.cmp(a));
        }
    }

    /// Gives the place of a piece away; how many bytes it took.
    fn evict(&mut self, key: Key) -> u64 {
        match self.slots.remove(&key) {
            Some(Slot { state: State::Here(loaded), .. }) => {
                let bytes = loaded.bytes();
                self.taken -= bytes;
                self.evictions += 1;
                bytes
            }
            Some(slot) => {
                self.slots.insert(key, slot);
                0
            }
            None => 0,
        }
    }

    /// Puts a piece where room was set aside for it, or notes why it is not there.
    pub(super) fn fill(&mut self, key: Key, read: Result<Loaded, fct::Error>) {
        let Some(slot) = self.slots.get_mut(&key) else { return };
        let State::Reading(reserved) = slot.state else { return };
        self.taken -= reserved;
        match read {
            // A piece never takes more than was set aside; if it did it would have to go.
            Ok(loaded) if loaded.bytes() <= reserved => {
                self.taken += loaded.bytes();
                slot.state = State::Here(loaded);
            }
            Ok(_) => {
                self.slots.remove(&key);
            }
            Err(error) => slot.state = State::Broken(Arc::new(error)),
        }
        // A page has its vertices itself.
        if let Key::Piece(Piece::Page(page)) = key
            && self.is_here(Piece::Page(page))
            && self.slots.contains_key(&Key::Run(page))
        {
            self.evict(Key::Run(page));
        }
    }

    /// Takes back what was set aside for a piece that is not read after all.
    pub(super) fn give_back(&mut self, key: Key) {
        if let Some(Slot { state: State::Reading(reserved), .. }) = self.slots.get(&key) {
            self.taken -= reserved;
            self.slots.remove(&key);
        }
    }

    /// Throws a piece away that turned out to be damaged.
    pub(super) fn break_piece(&mut self, piece: Piece, error: fct::Error) {
        let key = Key::Piece(piece);
        self.evict(key);
        // Another thread may have found it first, and its error stays.
        self.slots.entry(key).or_insert_with(|| Slot {
            state: State::Broken(Arc::new(error)),
            used: AtomicU64::new(0),
            urgency: AtomicU64::new(0),
        });
    }

    /// The errors of the pieces that could not be read, in order.
    pub(super) fn errors(&self) -> Vec<(Piece, Arc<fct::Error>)> {
        let broken = |(key, slot): (&Key, &Slot)| match (key, &slot.state) {
            (Key::Piece(piece), State::Broken(error)) => Some((*piece, error.clone())),
            _ => None,
        };
        self.slots.iter().filter_map(broken).collect()
    }

    /// Pieces that could not be read may be tried again.
    pub(super) fn retry(&mut self) {
        self.slots.retain(|_, slot| !matches!(slot.state, State::Broken(_)));
    }

    /// The pieces that are there, in order.
    pub(super) fn resident(&self) -> Vec<Piece> {
        let here = |(key, slot): (&Key, &Slot)| match (key, &slot.state) {
            (Key::Piece(piece), State::Here(_)) => Some(*piece),
            _ => None,
        };
        self.slots.iter().filter_map(here).collect()
    }

    /// Bytes taken now and at most, and pieces that had to go.
    pub(super) fn counts(&self) -> [u64; 3] {
        [self.taken, self.peak, self.evictions]
    }
}
