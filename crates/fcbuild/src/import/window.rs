//! A sliding window over a file: bounded memory, exact byte offsets, progress.

use std::io::{ErrorKind, Read, Seek, SeekFrom};

/// What a reader needs of a file.
pub(super) trait Stream: Read + Seek {}
impl<T: Read + Seek> Stream for T {}

/// Bytes asked of the operating system at a time; larger gains nothing, smaller costs calls.
const BLOCK: usize = 256 * 1024;

/// Bytes of a file from a known offset on, of which more are read as needed.
pub(super) struct Window<'a> {
    source: &'a mut dyn Stream,
    buffer: Vec<u8>,
    start: usize,
    end: usize,
    /// File offset of `buffer[start]`.
    offset: u64,
    total: u64,
    /// Of how many passes over the file, which one this is.
    pass: (u64, u64),
    progress: &'a (dyn Fn(u64, u64) + Sync),
    /// The first error of the operating system; afterwards the window behaves as at the file's end.
    failure: Option<std::io::Error>,
}

impl<'a> Window<'a> {
    /// Opens a window at the start of `source`, which holds `total` bytes.
    pub(super) fn new(
        source: &'a mut dyn Stream,
        total: u64,
        progress: &'a (dyn Fn(u64, u64) + Sync),
    ) -> Self {
        Self {
            source,
            buffer: vec![0; BLOCK],
            start: 0,
            end: 0,
            offset: 0,
            total,
            pass: (0, 1),
            progress,
            failure: None,
        }
    }

    /// Says that the file will be read `passes` times, for the progress.
    pub(super) fn expect_passes(&mut self, passes: u64) {
        self.pass = (0, passes.max(1));
    }

    /// Goes back to the start of the file for another pass.
    pub(super) fn rewind(&mut self) {
        (self.start, self.end, self.offset) = (0, 0, 0);
        self.pass.0 = self.pass.0.saturating_add(1);
        if let Err(e) = self.source.seek(SeekFrom::Start(0)) {
            self.failure = Some(e);
        }
    }

    /// File offset of the next byte.
    pub(super) fn offset(&self) -> u64 {
        self.offset
    }

    /// Bytes from here to the end, going by the size of the file when it was opened.
    pub(super) fn remaining(&self) -> u64 {
        self.total.saturating_sub(self.offset)
    }

    /// The bytes at hand, at least `need` of them unless the file ends before.
    #[inline]
    pub(super) fn peek(&mut self, need: usize) -> &[u8] {
        if self.end.saturating_sub(self.start) < need {
            self.fill(need);
        }
        self.buffer.get(self.start..self.end).unwrap_or_default()
    }

    /// Takes exactly `N` bytes; `None` when the file ends before, and then nothing is taken.
    #[inline]
    pub(super) fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let bytes = *self.peek(N).first_chunk::<N>()?;
        self.consume(N);
        Some(bytes)
    }

    /// Steps over `n` bytes, at most as many as the last `peek` showed.
    #[inline]
    pub(super) fn consume(&mut self, n: usize) {
        let n = n.min(self.end.saturating_sub(self.start));
        self.start = self.start.saturating_add(n);
        self.offset = self.offset.saturating_add(n as u64);
    }

    /// Steps over `n` bytes; false when the file ends before.
    pub(super) fn skip(&mut self, mut n: u64) -> bool {
        while n > 0 {
            let here = self.peek(1).len();
            if here == 0 {
                return false;
            }
            let step = usize::try_from(n).unwrap_or(usize::MAX).min(here);
            self.consume(step);
            n = n.saturating_sub(step as u64);
        }
        true
    }

    /// The error that ended the reading, if one did.
    pub(super) fn take_failure(&mut self) -> Option<std::io::Error> {
        self.failure.take()
    }

    #[cold]
    fn fill(&mut self, need: usize) {
        self.buffer.copy_within(self.start..self.end, 0);
        self.end = self.end.saturating_sub(self.start);
        self.start = 0;
        if self.buffer.len() < need {
            self.buffer.resize(need, 0);
        }
        while self.end < need && self.failure.is_none() {
            let Some(free) = self.buffer.get_mut(self.end..) else { break };
            match self.source.read(free) {
                Ok(0) => break,
                Ok(n) => self.end = self.end.saturating_add(n).min(self.buffer.len()),
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(e) => self.failure = Some(e),
            }
        }
        let (pass, passes) = self.pass;
        let done = self.total.saturating_mul(pass).saturating_add(self.offset);
        (self.progress)(done.checked_div(passes).unwrap_or(0).min(self.total), self.total);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn yields_every_byte_once_whatever_the_steps() {
        let bytes: Vec<u8> = (0..BLOCK * 2 + 77).map(|i| (i * 31 % 251) as u8).collect();
        let mut source = std::io::Cursor::new(&bytes);
        let mut w = Window::new(&mut source, bytes.len() as u64, &|_, _| {});
        let mut seen = 0usize;
        for step in (1..4000usize).cycle() {
            let got = w.peek(step);
            if got.len() < step {
                assert_eq!(got, &bytes[seen..]);
                break;
            }
            assert_eq!(got[..step], bytes[seen..seen + step]);
            w.consume(step);
            seen += step;
            assert_eq!((w.offset(), w.remaining()), (seen as u64, (bytes.len() - seen) as u64));
        }
        assert!(w.skip((bytes.len() - seen) as u64) && !w.skip(1) && w.take::<1>().is_none());
    }
}
