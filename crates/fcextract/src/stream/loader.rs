//! The thread that reads what is missing.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};
use std::thread::JoinHandle;

use super::plan::Plan;
use super::slots::{Key, Loaded, Order, Slots};
use super::{Piece, Wish};
use crate::Selection;
use fct::{Chunk, ChunkFile, ChunkPage, OwnVertices};

/// What cache and thread share.
pub(super) struct Shared {
    pub(super) file: ChunkFile,
    slots: RwLock<Slots>,
    queue: Mutex<Queue>,
    changed: Condvar,
}

/// What is to be read.
#[derive(Default)]
struct Queue {
    /// The frame that the wishes are of; older ones are forgotten.
    frame: u64,
    /// Each piece once, the most urgent last.
    wishes: Vec<Queued>,
    busy: bool,
    stop: bool,
}

/// A wish that waits.
struct Queued {
    wish: Wish,
    /// What wants a chunk: when its top is there, this says which of its pages to read.
    selection: Option<Arc<Selection>>,
}

/// What became of a wish.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// The piece was read, or could not be.
    Tried,
    /// There is no room for it.
    NoRoom,
    /// It is there, is being read, is broken, or what it is read by is not there.
    Useless,
}

impl Queue {
    fn sort(&mut self) {
        // Of the wishes for one piece the most urgent stays.
        let by_piece = |a: &Wish, b: &Wish| a.piece.cmp(&b.piece).then(by_urgency(b, a));
        self.wishes.sort_by(|a, b| by_piece(&a.wish, &b.wish));
        self.wishes.dedup_by_key(|queued| queued.wish.piece);
        self.wishes.sort_by(|a, b| by_urgency(&a.wish, &b.wish));
    }
}

impl Shared {
    pub(super) fn new(file: ChunkFile, slots: Slots) -> Arc<Shared> {
        let queue = Mutex::new(Queue::default());
        Arc::new(Shared { file, slots: RwLock::new(slots), queue, changed: Condvar::new() })
    }

    /// Starts the thread.
    ///
    /// # Errors
    /// What the system says when it has no thread to give.
    pub(super) fn start(self: &Arc<Self>) -> std::io::Result<JoinHandle<()>> {
        let shared = Arc::clone(self);
        std::thread::Builder::new().name("chunk loader".to_owned()).spawn(move || shared.run())
    }

    /// Asks for pieces that a frame would use, and with chunks for those of their pages that `selection` would use.
    pub(super) fn wish(&self, frame: u64, wishes: Vec<Wish>, selection: &Selection) {
        let is_chunk = |wish: &Wish| matches!(wish.piece, Piece::Chunk(_));
        let shared = wishes.iter().any(is_chunk).then(|| Arc::new(selection.clone()));
        let queued = wishes.into_iter().map(|wish| {
            let selection = shared.clone().filter(|_| is_chunk(&wish));
            Queued { wish, selection }
        });
        let mut queue = self.queue();
        if queue.frame < frame {
            queue.frame = frame;
            queue.wishes.clear();
        }
        queue.wishes.extend(queued);
        queue.sort();
        drop(queue);
        self.changed.notify_all();
    }

    /// Takes back what was asked for and is not being read yet.
    pub(super) fn forget_wishes(&self) {
        self.queue().wishes.clear();
        self.changed.notify_all();
    }

    /// Waits until there is nothing left to read, or no room for it.
    pub(super) fn settle(&self) {
        let mut queue = self.queue();
        while queue.busy || !queue.wishes.is_empty() {
            queue = self.changed.wait(queue).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Ends the thread after the piece that it reads now.
    pub(super) fn stop(&self) {
        self.queue().stop = true;
        self.changed.notify_all();
    }

    /// Reads a piece if there is room for it beside those used in frame `in_use_from` or later.
    pub(super) fn load(&self, wish: &Wish, frame: u64, in_use_from: u64) -> Outcome {
        let order = |key, bytes, urgency| Order { key, bytes, urgency, frame, in_use_from };
        let key = Key::Piece(wish.piece);
        match wish.piece {
            Piece::Chunk(chunk) => {
                let Some(bytes) = self.file.chunk_bytes(chunk) else { return Outcome::Useless };
                if let Err(why) = self.reserve(&order(key, bytes, wish.urgency)) {
                    return why;
                }
                let read = self.file.load(chunk).map(|chunk| Loaded::Chunk(Arc::new(chunk)));
                self.slots_mut().fill(key, read);
            }
            Piece::Page(page) => {
                let chunk = self.slots().chunk(self.file.crown().chunk_of(page)).cloned();
                let Some(chunk) = chunk else { return Outcome::Useless };
                let Some(bytes) = self.file.page_bytes(&chunk, page) else { return Outcome::Useless };
                if let Err(why) = self.reserve(&order(key, bytes, wish.urgency)) {
                    return why;
                }
                let read = self.load_page(&chunk, page, &|key, bytes| order(key, bytes, 0.0));
                self.slots_mut().fill(key, read.map(|page| Loaded::Page(Arc::new(page))));
            }
        }
        Outcome::Tried
    }

    /// Reads a page, and the vertices of others that it uses where they are not there.
    ///
    /// Those are kept as long as nobody needs the room, since more pages are likely to use them.
    fn load_page(
        &self,
        chunk: &Chunk,
        page: u32,
        order: &dyn Fn(Key, u64) -> Order,
    ) -> Result<ChunkPage, fct::Error> {
        let mut runs = Vec::new();
        for owner in self.file.runs_of(chunk, page).unwrap_or_default() {
            let there = self.slots().run(owner);
            let run = match there {
                Some(loaded) => loaded,
                None => {
                    let key = Key::Run(owner);
                    let bytes = self.file.run_bytes(owner).unwrap_or(u64::MAX);
                    let is_kept = owner != page && self.reserve(&order(key, bytes)).is_ok();
                    match self.file.load_run(owner).map(Arc::new) {
                        Ok(run) => {
                            let loaded = Loaded::Run(run);
                            if is_kept {
                                self.slots_mut().fill(key, Ok(loaded.clone()));
                            }
                            loaded
                        }
                        Err(error) => {
                            if is_kept {
                                self.slots_mut().give_back(key);
                            }
                            return Err(error);
                        }
                    }
                }
            };
            runs.push(run);
        }
        let own: Vec<OwnVertices<'_>> = runs.iter().filter_map(Loaded::own).collect();
        self.file.load_page(chunk, page, &own)
    }

    fn reserve(&self, order: &Order) -> Result<(), Outcome> {
        self.slots_mut().reserve(order)
    }

    pub(super) fn slots(&self) -> RwLockReadGuard<'_, Slots> {
        self.slots.read().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn slots_mut(&self) -> RwLockWriteGuard<'_, Slots> {
        self.slots.write().unwrap_or_else(PoisonError::into_inner)
    }

    fn run(&self) {
        let (mut plan, mut pages) = (Plan::default(), Vec::new());
        loop {
            let mut queue = self.queue();
            let (Queued { wish, selection }, frame) = loop {
                if queue.stop {
                    return;
                }
                if let Some(queued) = queue.wishes.pop() {
                    queue.busy = true;
                    break (queued, queue.frame);
                }
                queue = self.changed.wait(queue).unwrap_or_else(PoisonError::into_inner);
            };
            drop(queue);
            pages.clear();
            // What the frame before used may be drawn again in this one, which is not over.
            let outcome = self.load(&wish, frame, frame.saturating_sub(1));
            if let (Piece::Chunk(chunk), Some(selection), Outcome::Tried) = (wish.piece, selection, outcome) {
                let chunk = self.slots().chunk(chunk).cloned();
                if let Some(chunk) = chunk {
                    plan.add_pages(&chunk, &selection, &wish, &mut pages);
                }
            }
            let mut queue = self.queue();
            queue.busy = false;
            if queue.frame == frame && !pages.is_empty() {
                queue.wishes.extend(pages.drain(..).map(|wish| Queued { wish, selection: None }));
                queue.sort();
            }
            // There is no room for what is less urgent either.
            if outcome == Outcome::NoRoom && queue.frame == frame {
                queue.wishes.clear();
            }
            drop(queue);
            self.changed.notify_all();
        }
    }

    /// A thread that panicked has left nothing half done in there.
    fn queue(&self) -> MutexGuard<'_, Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The less urgent first; ties by number, so that the order depends on the wishes alone.
pub(super) fn by_urgency(a: &Wish, b: &Wish) -> std::cmp::Ordering {
    let key = a.urgency.total_cmp(&b.urgency).then(a.key.total_cmp(&b.key));
    key.then(b.piece.cmp(&a.piece))
}
