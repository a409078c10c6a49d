//! Floats in two bytes: the upper half of a single, rounded to the side that errs safely.

use zerocopy::little_endian::U16;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

/// The upper half of an `f32`: its sign, its exponent and 7 bits of its digits. 2 bytes.
///
/// It has the range of an `f32`, infinities too, and steps of less than a hundredth.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(transparent)]
pub struct ShortFloat(U16);

impl ShortFloat {
    /// Zero.
    pub const ZERO: Self = Self(U16::ZERO);

    /// Plus infinity.
    pub const INFINITY: Self = Self(U16::new(0x7F80));

    /// The value with these bits.
    pub const fn from_bits(bits: u16) -> Self {
        Self(U16::new(bits))
    }

    /// The stored bits.
    pub const fn bits(self) -> u16 {
        self.0.get()
    }

    /// The smallest value that is not less than `x`; NaN stays NaN.
    pub fn up(x: f64) -> Self {
        let single = single_up(x);
        if single.is_nan() {
            return Self::from_bits(0x7FC0);
        }
        let bits = single.to_bits();
        // Away from zero for positive numbers, towards zero for negative ones: both are upwards.
        let raised = if single > 0.0 { bits.saturating_add(0xFFFF) } else { bits };
        Self::from_bits(upper_half(raised))
    }

    /// The largest value that is not greater than `x`; NaN stays NaN.
    pub fn down(x: f64) -> Self {
        let negated = Self::up(-x);
        Self::from_bits(negated.bits() ^ 0x8000)
    }

    /// The next larger value of a number that is not negative and finite.
    pub(crate) fn next_up(self) -> Self {
        Self::from_bits(self.bits().saturating_add(1))
    }

    /// Its place among all short floats: of two that are not negative, the larger one has the larger rank. Negative
    /// numbers rank below these, and NaN without a sign above infinity.
    #[inline]
    pub const fn rank(self) -> i16 {
        self.bits().cast_signed()
    }

    /// The value.
    #[inline]
    pub fn get(self) -> f32 {
        f32::from_bits(u32::from(self.bits()) << 16)
    }
}

#[allow(clippy::cast_possible_truncation, reason = "the shift leaves 16 bits")]
const fn upper_half(bits: u32) -> u16 {
    (bits >> 16) as u16
}

/// The smallest `f32` that is not less than `x`.
#[allow(clippy::cast_possible_truncation, reason = "rounding is what it is for, and it is corrected")]
pub(crate) fn single_up(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
}

#[cfg(test)]
mod tests {
    use super::ShortFloat;
    use proptest::prelude::*;

    #[test]
    fn what_fits_stays_and_ends_are_kept() {
        for x in [0.0, 1.0, -1.0, 0.375, 2.0_f64.powi(-126), -2.0_f64.powi(100), f64::INFINITY] {
            assert_eq!(f64::from(ShortFloat::up(x).get()), x);
            assert_eq!(f64::from(ShortFloat::down(x).get()), x);
        }
        assert_eq!(ShortFloat::up(f64::from(f32::MAX)).get(), f32::INFINITY);
        assert!(ShortFloat::down(f64::from(f32::MAX)).get().is_finite());
        assert!(ShortFloat::up(f64::NAN).get().is_nan() && ShortFloat::down(f64::NAN).get().is_nan());
        assert!(ShortFloat::up(1e-60).get() > 0.0 && ShortFloat::down(-1e-60).get() < 0.0);
    }

    proptest! {
        #[test]
        fn neighbours_enclose(x: f32) {
            prop_assume!(x.is_finite());
            let x = f64::from(x);
            let (down, up) = (ShortFloat::down(x), ShortFloat::up(x));
            prop_assert!(f64::from(down.get()) <= x && x <= f64::from(up.get()));
            // Nothing is between them.
            let next = if up.get() > 0.0 { up.bits() - 1 } else { up.bits() };
            prop_assert!(up.get() <= 0.0 || f64::from(ShortFloat::from_bits(next).get()) < x || x == 0.0);
            prop_assert!(f64::from(up.get()) - f64::from(down.get()) <= x.abs() / 127.0 + 1e-38);
        }

        #[test]
        fn order_is_kept(a in 0.0_f32..1e30, b in 0.0_f32..1e30) {
            let (low, high) = (a.min(b), a.max(b));
            let [low, high] = [low, high].map(|x| ShortFloat::up(f64::from(x)));
            prop_assert!(low.get() <= high.get());
            prop_assert_eq!(low.get().total_cmp(&high.get()), low.rank().cmp(&high.rank()));
            let beside = [ShortFloat::down(-1.0), ShortFloat::INFINITY, ShortFloat::up(f64::NAN)];
            let [negative, infinite, nan] = beside.map(ShortFloat::rank);
            prop_assert!(negative < low.rank() && high.rank() < infinite && infinite < nan);
        }
    }
}
