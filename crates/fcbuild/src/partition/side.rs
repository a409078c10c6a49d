//! The two sides of a cut.

/// The side of a cut that a face falls on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Side {
    Neither,
    Left,
    Right,
}
