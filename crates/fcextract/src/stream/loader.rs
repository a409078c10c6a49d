//! The thread that reads what is missing.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, RwLock};
use std::thread::JoinHandle;

use super::Wish;
use super::slots::Slots;
use fct::ChunkFile;

/// What cache and thread share.
pub(super) struct Shared {
    pub(super) file: ChunkFile,
    pub(super) slots: RwLock<Slots>,
    queue: Mutex<Queue>,
    changed: Condvar,
}

/// What is to be read.
#[derive(Default)]
struct Queue {
    /// The frame that the wishes are of; older ones are forgotten.
    frame: u64,
    /// Each chunk once, the most urgent last.
    wishes: Vec<Wish>,
    busy: bool,
    stop: bool,
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

    /// Asks for chunks that a frame would use.
    pub(super) fn wish(&self, frame: u64, wishes: impl Iterator<Item = Wish>) {
        let mut queue = self.queue();
        if queue.frame < frame {
            queue.frame = frame;
            queue.wishes.clear();
        }
        queue.wishes.extend(wishes);
        // Of the wishes for one chunk the most urgent stays.
        queue.wishes.sort_unstable_by(|a, b| a.chunk.cmp(&b.chunk).then(by_urgency(b, a)));
        queue.wishes.dedup_by_key(|wish| wish.chunk);
        queue.wishes.sort_unstable_by(by_urgency);
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

    /// Ends the thread after the chunk that it reads now.
    pub(super) fn stop(&self) {
        self.queue().stop = true;
        self.changed.notify_all();
    }

    /// Reads a chunk if there is room for it beside those used in frame `in_use_from` or later; whether it was tried.
    pub(super) fn load(&self, wish: &Wish, frame: u64, in_use_from: u64) -> bool {
        let Some(bytes) = self.file.chunk_bytes(wish.chunk) else { return false };
        if !self.slots.write().unwrap_or_else(PoisonError::into_inner).reserve(
            wish,
            bytes,
            frame,
            in_use_from,
        ) {
            return false;
        }
        let read = self.file.load(wish.chunk);
        self.slots.write().unwrap_or_else(PoisonError::into_inner).fill(wish.chunk, read);
        true
    }

    fn run(&self) {
        loop {
            let mut queue = self.queue();
            let (wish, frame) = loop {
                if queue.stop {
                    return;
                }
                if let Some(wish) = queue.wishes.pop() {
                    queue.busy = true;
                    break (wish, queue.frame);
                }
                queue = self.changed.wait(queue).unwrap_or_else(PoisonError::into_inner);
            };
            drop(queue);
            // What the frame before used may be drawn again in this one, which is not over.
            self.load(&wish, frame, frame.saturating_sub(1));
            self.queue().busy = false;
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
    key.then(b.chunk.cmp(&a.chunk))
}
