//! How far a run without a window is, on standard error.

use fct::MessageFormat;
use fcview::cli::Cli;
use std::io::{IsTerminal as _, Write as _};
use std::time::{Duration, Instant};

/// Between two changes of the line.
const EVERY: Duration = Duration::from_millis(200);

/// A line that changes in place, where a person may look at it.
pub(crate) struct Progress {
    frames: u32,
    /// When the line was last written; `None` where there is none.
    last: Option<Instant>,
    shown: bool,
}

impl Progress {
    /// Shows nothing until it is told something, nor for a single frame, nor where standard error is no terminal, or for
    /// programs.
    pub(crate) fn new(cli: &Cli) -> Progress {
        let frames = cli.frames;
        let is_for_people = cli.message_format == MessageFormat::Human;
        let wanted = frames > 1 && is_for_people && std::io::stderr().is_terminal();
        Progress { frames, last: wanted.then(Instant::now), shown: false }
    }

    /// Tells how many frames are done.
    pub(crate) fn tell(&mut self, done: u32) {
        if self.last.is_some_and(|last| last.elapsed() >= EVERY) {
            self.last = Some(Instant::now());
            self.shown = true;
            // The escape clears the rest of the line.
            let _ = write!(std::io::stderr().lock(), "\r{done} of {} frames\x1b[K", self.frames);
        }
    }

    /// Takes the line away, so that what follows stands alone.
    pub(crate) fn clear(&mut self) {
        if std::mem::take(&mut self.shown) {
            let _ = write!(std::io::stderr().lock(), "\r\x1b[K");
        }
    }
}
