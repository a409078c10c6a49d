//! A tree that is read as it is looked at.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::JoinHandle;

use super::draw::walk_chunks;
use super::loader::Outcome;
use super::loader::{Shared, by_urgency};
use super::slots::Slots;
use super::{Piece, Resident, Streamed, Wish};
use crate::{Error, Selection};
use fct::{Chunk, ChunkFile, ChunkPage};

/// The crown of a file, and the tops of chunks and pages that were used last, within a budget of bytes.
///
/// ```no_run
/// use fcextract::{ChunkCache, Mesh, Order, Selection, Streamed};
///
/// let cache = ChunkCache::open("city.fct", 256 << 20)?;
/// let (mut streamed, mut mesh) = (Streamed::default(), Mesh::default());
/// for distance in [0.5, 0.4, 0.3] {
///     let selection = Selection::uniform(distance, Order::Bound);
///     cache.begin_frame();
///     // Never waits for the disk: what is missing is drawn coarser and read in the background.
///     cache.extract(&selection, &mut streamed)?;
///     println!("{} triangles, {} pieces missing", streamed.stats.triangles, streamed.missing.len());
///     // Buffers for a GPU.
///     mesh.fill_streamed(cache.file().crown(), &streamed, &selection)?;
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// The example `streaming` of this crate does so for a camera.
///
/// It can be shared by threads. A chunk or page that cannot be read or is damaged is drawn as its root from then on, and
/// its error is kept, see [`ChunkCache::errors`].
pub struct ChunkCache {
    shared: Arc<Shared>,
    loader: Option<JoinHandle<()>>,
    frame: AtomicU64,
}

/// What a cache has done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct CacheStats {
    /// Bytes that it takes now, the crown included.
    pub bytes: u64,
    /// The most bytes that it took, pieces that were being read included.
    pub peak_bytes: u64,
    /// Bytes of the crown, which always stays.
    pub crown_bytes: u64,
    /// Tops of chunks and pages in memory.
    pub resident: u64,
    /// What had to go.
    pub evictions: u64,
    /// Reads of the file, the opening included.
    pub reads: u64,
    /// Bytes of those reads.
    pub bytes_read: u64,
}

impl ChunkCache {
    /// Opens a file and reads its crown. `budget` is the most bytes that crown, chunks and pages may take; while
    /// a page is read, the vertices of its neighbours, some ten KB, come on top.
    ///
    /// # Errors
    /// [`Error::Tree`] when the file cannot be read or has no chunks, [`Error::Memory`] when the crown and the top of
    /// one chunk do not fit into the budget, or no thread is to be had.
    pub fn open(path: impl AsRef<Path>, budget: u64) -> Result<ChunkCache, Error> {
        ChunkCache::new(ChunkFile::open(path)?, budget)
    }

    /// The same for a file that is open.
    ///
    /// # Errors
    /// As [`ChunkCache::open`].
    pub fn new(file: ChunkFile, budget: u64) -> Result<ChunkCache, Error> {
        let chunks = file.crown().chunk_count();
        let largest = (0..chunks).filter_map(|chunk| file.chunk_bytes(chunk)).max().unwrap_or(0);
        let needed = file.crown().bytes().saturating_add(largest);
        let Some(rest) = budget.checked_sub(file.crown().bytes()).filter(|rest| *rest >= largest) else {
            return Err(Error::Memory(format!(
                "a budget of {budget} bytes does not hold the upper part of the tree and the top of one chunk, {needed} bytes"
            )));
        };
        let shared = Shared::new(file, Slots::new(rest));
        let loader =
            shared.start().map_err(|error| Error::Memory(format!("no thread could be started: {error}")))?;
        Ok(ChunkCache { shared, loader: Some(loader), frame: AtomicU64::new(1) })
    }

    /// The file.
    pub fn file(&self) -> &ChunkFile {
        &self.shared.file
    }

    /// Begins a frame, of as many extractions as you like: what was wished for before is forgotten, and what is
    /// not used in this frame or the next may go.
    pub fn begin_frame(&self) {
        self.frame.fetch_add(1, Ordering::Relaxed);
    }

    /// Extracts what the pieces in memory allow, and asks for the others. Never waits for the disk.
    ///
    /// Where nothing is asked for, as for a view that rests once all is there, it takes no memory from the system as long as
    /// `out` has grown. What asks for pieces makes lists of them.
    ///
    /// # Errors
    /// As [`extract_chunks`](super::extract_chunks).
    pub fn extract(&self, selection: &Selection, out: &mut Streamed) -> Result<(), Error> {
        self.ask(selection, true, out)
    }

    /// Asks for what a selection would go into, such as that of the view that comes next, and draws nothing.
    ///
    /// It belongs to the frame, as [`ChunkCache::extract`] does: what is there counts as used in it, and of what is missing
    /// the most urgent is read first, whoever asks for it.
    ///
    /// # Errors
    /// [`Error::Selection`] when the selection cannot be used.
    pub fn prefetch(&self, selection: &Selection) -> Result<(), Error> {
        self.ask(selection, false, &mut Streamed::default())
    }

    fn ask(&self, selection: &Selection, draws: bool, out: &mut Streamed) -> Result<(), Error> {
        let frame = self.frame.load(Ordering::Relaxed);
        self.draw(selection, frame, draws, out)?;
        let wishes: Vec<Wish> = {
            let slots = self.shared.slots();
            let wanted = out.missing.iter().chain(&out.close);
            wanted.filter(|wish| !slots.is_here(wish.piece)).copied().collect()
        };
        self.shared.wish(frame, wishes, selection);
        Ok(())
    }

    /// Extracts exactly what is asked for, reading what is missing first.
    ///
    /// The result depends on file and selection alone as long as nothing is [missing](Streamed::missing) in it: that
    /// can only be what does not fit into the budget, or could not be read.
    ///
    /// # Errors
    /// As [`extract_chunks`](super::extract_chunks).
    pub fn extract_now(&self, selection: &Selection, out: &mut Streamed) -> Result<(), Error> {
        let frame = self.frame.load(Ordering::Relaxed);
        loop {
            self.draw(selection, frame, true, out)?;
            out.missing.sort_unstable_by(|a, b| by_urgency(b, a));
            // What the loader is reading is waited for; it is either there afterwards, or broken.
            self.shared.forget_wishes();
            self.shared.settle();
            let load = |wish| self.shared.load(wish, frame, frame) == Outcome::Tried;
            let read = out.missing.iter().filter(|wish| load(wish)).count();
            let now_there = {
                let slots = self.shared.slots();
                out.missing.iter().any(|wish| slots.is_here(wish.piece))
            };
            if read == 0 && !now_there {
                return Ok(());
            }
        }
    }

    /// Waits until all is read that was asked for and for which there is room.
    pub fn settle(&self) {
        self.shared.settle();
    }

    /// The tops of chunks and the pages in memory, in order.
    pub fn resident(&self) -> Vec<Piece> {
        self.shared.slots().resident()
    }

    /// What could not be read, and why.
    pub fn errors(&self) -> Vec<(Piece, Arc<fct::Error>)> {
        self.shared.slots().errors()
    }

    /// Lets what could not be read be tried again.
    pub fn retry(&self) {
        self.shared.slots_mut().retry();
    }

    /// What the cache has done so far.
    pub fn stats(&self) -> CacheStats {
        let slots = self.shared.slots();
        let [taken, peak, evictions] = slots.counts();
        let crown_bytes = self.shared.file.crown().bytes();
        let [reads, bytes_read] = self.shared.file.reads();
        CacheStats {
            bytes: taken + crown_bytes,
            peak_bytes: peak + crown_bytes,
            crown_bytes,
            resident: slots.resident().len() as u64,
            evictions,
            reads,
            bytes_read,
        }
    }

    fn draw(&self, selection: &Selection, frame: u64, draws: bool, out: &mut Streamed) -> Result<(), Error> {
        {
            let slots = self.shared.slots();
            walk_chunks(self.shared.file.crown(), &There(&slots), selection, draws, out)?;
            // What is close counts as in use, but goes for what is entered: it would be read again at once.
            for wish in out.entered.iter().chain(&out.close) {
                slots.touch(wish.piece, frame, wish.urgency);
            }
        }
        for damaged in out.damaged.drain(..) {
            if let Error::Tree(error) = damaged.error {
                self.shared.slots_mut().break_piece(damaged.piece, error);
            }
        }
        Ok(())
    }
}

/// What the slots hold.
struct There<'a>(&'a Slots);

impl<'a> Resident<'a> for There<'a> {
    fn chunk(&self, chunk: u32) -> Option<&'a Chunk> {
        self.0.chunk(chunk).map(|chunk| &**chunk)
    }

    fn page(&self, page: u32) -> Option<&'a ChunkPage> {
        self.0.page(page).map(|page| &**page)
    }
}

impl Drop for ChunkCache {
    fn drop(&mut self) {
        self.shared.stop();
        if let Some(loader) = self.loader.take() {
            // It ends with the piece that it reads now; that it panicked is nothing to act on here.
            let _ended = loader.join();
        }
    }
}

impl std::fmt::Debug for ChunkCache {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ChunkCache").field("file", self.file()).field("stats", &self.stats()).finish()
    }
}

// A cache is shared by the threads that draw from it.
const _: () = {
    const fn shared<T: Send + Sync>() {}
    shared::<ChunkCache>();
};
