//! The values of a PLY body, read one by one from text or from either byte order.

use super::super::number;
use super::super::window::Window;
use super::super::words::{Lack, Words};
use super::header::Scalar;
use crate::error::Error;

/// A source of values in the order of the file.
pub(super) trait Values {
    /// The next value as a float; whole numbers of any type of the format are exact.
    fn float(&mut self, kind: Scalar) -> Result<f64, Lack>;
    /// The next value, of an integer type.
    fn integer(&mut self, kind: Scalar) -> Result<i64, Lack>;
    /// Steps over `n` values.
    fn skip(&mut self, kind: Scalar, n: u64) -> Result<(), Lack>;
    /// Ends a record: in a text file nothing may be left on its line.
    fn end_record(&mut self) -> Result<(), Lack>;
    /// Adds the line or the byte to an error.
    fn locate(&self, error: Error) -> Error;
    /// Bytes that are left in the file.
    fn remaining(&self) -> u64;
    /// Fewest bytes that `n` values take.
    fn smallest(&self, kind: Scalar, n: u64) -> u64;
    /// Bytes that the last value of a file may lack of that: a text file may end without a line end.
    fn slack(&self) -> u64;
    /// Whether anything but white space is left.
    fn has_more(&mut self) -> bool;
}

/// Values of a binary body; `BIG` says big-endian.
pub(super) struct Binary<'w, 'a, const BIG: bool> {
    window: &'w mut Window<'a>,
}

impl<'w, 'a, const BIG: bool> Binary<'w, 'a, BIG> {
    pub(super) fn new(window: &'w mut Window<'a>) -> Self {
        Self { window }
    }

    #[inline]
    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], Lack> {
        let mut bytes = self.window.take::<N>().ok_or(Lack::End)?;
        if BIG {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

impl<const BIG: bool> Values for Binary<'_, '_, BIG> {
    #[inline]
    fn float(&mut self, kind: Scalar) -> Result<f64, Lack> {
        Ok(match kind {
            Scalar::F32 => f32::from_le_bytes(self.bytes()?).into(),
            Scalar::F64 => f64::from_le_bytes(self.bytes()?),
            Scalar::I8 => i8::from_le_bytes(self.bytes()?).into(),
            Scalar::U8 => u8::from_le_bytes(self.bytes()?).into(),
            Scalar::I16 => i16::from_le_bytes(self.bytes()?).into(),
            Scalar::U16 => u16::from_le_bytes(self.bytes()?).into(),
            Scalar::I32 => i32::from_le_bytes(self.bytes()?).into(),
            Scalar::U32 => u32::from_le_bytes(self.bytes()?).into(),
        })
    }

    #[inline]
    fn integer(&mut self, kind: Scalar) -> Result<i64, Lack> {
        Ok(match kind {
            Scalar::I8 => i8::from_le_bytes(self.bytes()?).into(),
            Scalar::U8 => u8::from_le_bytes(self.bytes()?).into(),
            Scalar::I16 => i16::from_le_bytes(self.bytes()?).into(),
            Scalar::U16 => u16::from_le_bytes(self.bytes()?).into(),
            Scalar::I32 => i32::from_le_bytes(self.bytes()?).into(),
            Scalar::U32 => u32::from_le_bytes(self.bytes()?).into(),
            // The header's checks keep float types away from here.
            Scalar::F32 | Scalar::F64 => {
                return Err(Lack::Bad(Error::bad_input("FC202", "a float where an integer belongs")));
            }
        })
    }

    fn skip(&mut self, kind: Scalar, n: u64) -> Result<(), Lack> {
        if self.window.skip(n.saturating_mul(kind.size())) { Ok(()) } else { Err(Lack::End) }
    }

    #[inline]
    fn end_record(&mut self) -> Result<(), Lack> {
        Ok(())
    }

    fn locate(&self, error: Error) -> Error {
        error.at_byte(self.window.offset())
    }

    fn remaining(&self) -> u64 {
        self.window.remaining()
    }

    fn smallest(&self, kind: Scalar, n: u64) -> u64 {
        n.saturating_mul(kind.size())
    }

    fn slack(&self) -> u64 {
        0
    }

    fn has_more(&mut self) -> bool {
        !self.window.peek(1).is_empty()
    }
}

/// Values of a text body.
pub(super) struct Text<'w, 'a> {
    words: Words<'w, 'a>,
}

impl<'w, 'a> Text<'w, 'a> {
    /// Starts at the window's place, which is the start of line `line`.
    pub(super) fn new(window: &'w mut Window<'a>, line: u64) -> Self {
        Self { words: Words::new(window, line) }
    }

    fn word<T>(&mut self, what: &str, read: impl Fn(&[u8]) -> Option<T>) -> Result<T, Lack> {
        self.words.next(what, read)
    }
}

impl Values for Text<'_, '_> {
    fn float(&mut self, kind: Scalar) -> Result<f64, Lack> {
        match kind {
            Scalar::F32 => self.word("a number", number::float32).map(f64::from),
            Scalar::F64 => self.word("a number", number::float64),
            _ => {
                let (low, high) = range(kind);
                self.word("a number of the declared type", |w| {
                    number::float64(w).filter(|&x| (low as f64..=high as f64).contains(&x))
                })
            }
        }
    }

    fn integer(&mut self, kind: Scalar) -> Result<i64, Lack> {
        let (low, high) = range(kind);
        self.word("a whole number of the declared type", |w| {
            number::integer(w).filter(|x| (low..=high).contains(x))
        })
    }

    fn skip(&mut self, _: Scalar, n: u64) -> Result<(), Lack> {
        for _ in 0..n {
            self.word("a value", |_| Some(()))?;
        }
        Ok(())
    }

    fn end_record(&mut self) -> Result<(), Lack> {
        if self.words.at_line_end() {
            return Ok(());
        }
        Err(Lack::Bad(
            Error::bad_input("FC206", "the line has more values than the header declares")
                .remedy("correct the header or export the file again"),
        ))
    }

    fn locate(&self, error: Error) -> Error {
        self.words.locate(error)
    }

    fn remaining(&self) -> u64 {
        self.words.remaining()
    }

    fn smallest(&self, _: Scalar, n: u64) -> u64 {
        n.saturating_mul(2)
    }

    fn slack(&self) -> u64 {
        1
    }

    fn has_more(&mut self) -> bool {
        self.words.has_more()
    }
}

fn range(kind: Scalar) -> (i64, i64) {
    match kind {
        Scalar::I8 => (i8::MIN.into(), i8::MAX.into()),
        Scalar::U8 => (0, u8::MAX.into()),
        Scalar::I16 => (i16::MIN.into(), i16::MAX.into()),
        Scalar::U16 => (0, u16::MAX.into()),
        Scalar::I32 => (i32::MIN.into(), i32::MAX.into()),
        Scalar::U32 | Scalar::F32 | Scalar::F64 => (0, u32::MAX.into()),
    }
}
