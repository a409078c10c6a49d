//! The logical lines of an OBJ file: of bounded length, with continuations joined and comments gone.

use super::super::window::Window;
use crate::error::{Error, ErrorKind};

/// Longest logical line; without a limit one line could take all memory.
const MAX_LINE: usize = 1 << 20;

/// Reads a file line by line; ends are LF, CR LF or CR.
pub(super) struct Lines<'a> {
    pub(super) window: Window<'a>,
    text: Vec<u8>,
    /// Number of the line that follows the one read last.
    next_line: u64,
    place: (u64, u64),
}

impl<'a> Lines<'a> {
    pub(super) fn new(window: Window<'a>) -> Self {
        let mut lines = Self { window, text: Vec::new(), next_line: 1, place: (1, 0) };
        lines.skip_mark();
        lines
    }

    /// Starts again at the first line.
    pub(super) fn rewind(&mut self) {
        self.window.rewind();
        self.next_line = 1;
        self.skip_mark();
    }

    fn skip_mark(&mut self) {
        if self.window.peek(3).starts_with(b"\xef\xbb\xbf") {
            self.window.consume(3);
        }
    }

    /// Adds the line and byte where the current line begins.
    pub(super) fn locate(&self, error: Error) -> Error {
        error.at_line(self.place.0).at_byte(self.place.1)
    }

    /// The next line without comment and end; `None` at the end of the file.
    pub(super) fn next(&mut self) -> Result<Option<&[u8]>, Error> {
        self.text.clear();
        self.place = (self.next_line, self.window.offset());
        if self.window.peek(1).is_empty() {
            return Ok(None);
        }
        while self.append_line()? {}
        Ok(Some(&self.text))
    }

    /// Appends one line of the file; true when the next one continues it.
    fn append_line(&mut self) -> Result<bool, Error> {
        let from = self.text.len();
        loop {
            let bytes = self.window.peek(2);
            let end = bytes.iter().position(|&b| b == b'\n' || b == b'\r');
            let part = bytes.get(..end.unwrap_or(bytes.len())).unwrap_or_default();
            let length = self.text.len().saturating_add(part.len());
            if length > MAX_LINE {
                return Err(self.locate(
                    Error::new(
                        ErrorKind::Limit,
                        "FC502",
                        format!("the line is longer than {MAX_LINE} bytes"),
                    )
                    .limit(MAX_LINE as u64, length as u64)
                    .remedy("this is no OBJ file, or it is damaged"),
                ));
            }
            self.text.extend_from_slice(part);
            let length = part.len();
            let at_end = bytes.is_empty();
            self.window.consume(length);
            if end.is_some() || at_end {
                break;
            }
        }
        if self.window.peek(2).starts_with(b"\r\n") {
            self.window.consume(2);
        } else {
            self.window.consume(1);
        }
        self.next_line = self.next_line.saturating_add(1);
        // Only a `#` at the start of a word begins a comment: names may contain one.
        let line = self.text.get(from..).unwrap_or_default();
        let comment = (0..line.len()).find(|&i| {
            line.get(i) == Some(&b'#')
                && i.checked_sub(1)
                    .and_then(|before| line.get(before))
                    .is_none_or(|b| b.is_ascii_whitespace())
        });
        if let Some(at) = comment {
            self.text.truncate(from.saturating_add(at));
            return Ok(false);
        }
        // A backslash at the very end joins the next line; comments, which hold Windows paths, never do.
        if self.text.last() == Some(&b'\\') {
            self.text.pop();
            self.text.push(b' ');
            return Ok(!self.window.peek(1).is_empty());
        }
        Ok(false)
    }
}
