//! The words of a text file, one by one, with the line and byte of each.

use super::number::{self, LONGEST, shown};
use super::window::Window;
use crate::error::Error;

/// Why a word or value could not be had.
pub(super) enum Lack {
    /// The file ends here.
    End,
    /// It is not what belongs here; the error says so.
    Bad(Error),
}

/// Words between white space; line ends are LF, CR LF or CR.
pub(super) struct Words<'w, 'a> {
    window: &'w mut Window<'a>,
    line: u64,
    /// Where the word that was read last begins.
    word_byte: u64,
    after_cr: bool,
}

impl<'w, 'a> Words<'w, 'a> {
    /// Starts at the window's place, which is the start of line `line`.
    pub(super) fn new(window: &'w mut Window<'a>, line: u64) -> Self {
        let word_byte = window.offset();
        Self { window, line, word_byte, after_cr: false }
    }

    /// Steps over white space, and over line ends too if `lines`.
    fn blank(&mut self, lines: bool) {
        loop {
            let bytes = self.window.peek(1);
            let mut steps = 0usize;
            let mut stop = bytes.is_empty();
            for &b in bytes {
                let ends_line = b == b'\n' || b == b'\r';
                if !is_blank(b) || (ends_line && !lines) {
                    stop = true;
                    break;
                }
                if ends_line && !(b == b'\n' && self.after_cr) {
                    self.line = self.line.saturating_add(1);
                }
                self.after_cr = b == b'\r';
                steps = steps.saturating_add(1);
            }
            self.window.consume(steps);
            if stop {
                return;
            }
        }
    }

    /// Takes the next word and reads it as `what`.
    pub(super) fn next<T>(&mut self, what: &str, read: impl Fn(&[u8]) -> Option<T>) -> Result<T, Lack> {
        self.blank(true);
        self.after_cr = false;
        self.word_byte = self.window.offset();
        let bytes = self.window.peek(LONGEST);
        let end = bytes.iter().take(LONGEST).position(|&b| is_blank(b));
        let word = bytes.get(..end.unwrap_or(bytes.len().min(LONGEST))).unwrap_or_default();
        if word.is_empty() {
            return Err(Lack::End);
        }
        match read(word) {
            Some(value) => {
                let length = word.len();
                self.window.consume(length);
                Ok(value)
            }
            None => Err(Lack::Bad(
                Error::bad_input("FC206", format!("found {} instead of {what}", shown(word)))
                    .remedy(number::advice(word)),
            )),
        }
    }

    /// Whether nothing but blanks is left on the line.
    pub(super) fn at_line_end(&mut self) -> bool {
        self.blank(false);
        self.word_byte = self.window.offset();
        matches!(self.window.peek(1).first(), None | Some(b'\n' | b'\r'))
    }

    /// Takes the rest of the line, of which at most 1,000 bytes are kept.
    pub(super) fn rest_of_line(&mut self) -> Vec<u8> {
        let mut rest = Vec::new();
        loop {
            let bytes = self.window.peek(1);
            let end = bytes.iter().position(|&b| b == b'\n' || b == b'\r');
            let part = bytes.get(..end.unwrap_or(bytes.len())).unwrap_or_default();
            rest.extend(part.iter().take(1000usize.saturating_sub(rest.len())));
            let (length, done) = (part.len(), end.is_some() || bytes.is_empty());
            self.window.consume(length);
            if done {
                return rest.trim_ascii().to_vec();
            }
        }
    }

    /// Adds line and byte of the last word to an error.
    pub(super) fn locate(&self, error: Error) -> Error {
        error.at_line(self.line).at_byte(self.word_byte)
    }

    /// Bytes that are left in the file.
    pub(super) fn remaining(&self) -> u64 {
        self.window.remaining()
    }

    /// Whether anything but white space is left.
    pub(super) fn has_more(&mut self) -> bool {
        self.blank(true);
        !self.window.peek(1).is_empty()
    }
}

/// Space, tab, line feed, vertical tab, form feed, carriage return.
fn is_blank(b: u8) -> bool {
    b == b' ' || (9..=13).contains(&b)
}
