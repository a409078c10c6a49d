//! Where a vertex is drawn in coarse meshes.
//!
//! All vertices of a mesh lie on its surface, so that every chord cuts below a bump and above a hollow. A vertex may be
//! drawn beside its place instead, as far as its own record and the tolerance say: all clusters that share it agree, and
//! at full resolution it is where it was.

use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout, Unaligned};

use crate::records::VertexRecord;
use crate::short_float::ShortFloat;

/// Where a vertex is best drawn at two tolerances, and how much of that its bound allows. 6 bytes.
///
/// Each coordinate has seven bits, in steps of 1/128 of the vertex's budget key. The lowest bits of the six bytes are
/// the share, in 1/63, of the displacement that is drawn where distances are promised; in files before version 1.2
/// they mean nothing.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, FromBytes, IntoBytes, Immutable, KnownLayout, Unaligned,
)]
#[repr(transparent)]
pub struct Displacement {
    bytes: [[i8; 3]; 2],
}

/// Steps of a byte, whose lowest bit is not part of it, in a budget key.
const STEPS: f64 = 256.0;

/// The longest coordinate: not quite half the key.
const LONGEST: f64 = 126.0;

impl Displacement {
    /// The shares of a vertex's key at which the two displacements are its own: between them they are interpolated,
    /// above the first it stays, below the second it shrinks with the square of the tolerance.
    pub const AT: [f64; 2] = [0.7, 0.35];

    /// The largest share.
    pub const WHOLE: u8 = 63;

    /// Stores displacements (length) for the two shares of the key; the share for promised distances is 0. An infinite
    /// key, or one of 0, has none.
    #[must_use]
    pub fn encode(displacement: [[f64; 3]; 2], budget: ShortFloat) -> Displacement {
        let unit = f64::from(budget.get()) / STEPS;
        let bytes = displacement.map(|d| {
            if unit > 0.0 && unit.is_finite() && d.iter().all(|x| x.is_finite()) {
                let longest = d.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                // A longer one keeps its direction.
                let fit = if longest > LONGEST * unit { LONGEST * unit / longest } else { 1.0 };
                #[allow(clippy::cast_possible_truncation, reason = "at most 63")]
                d.map(|x| ((0.5 * x * fit / unit).round() as i8) << 1)
            } else {
                [0; 3]
            }
        });
        Displacement { bytes }
    }

    /// Whether it is none at all tolerances.
    pub fn is_none(self) -> bool {
        self.bytes.as_flattened().iter().all(|byte| byte & !1 == 0)
    }

    /// How much of it is drawn where distances are promised, in 1/63: what the bounds of all clusters around allow.
    pub fn share(self) -> u8 {
        self.bytes.as_flattened().iter().fold(0, |share, byte| share << 1 | (byte & 1).cast_unsigned())
    }

    /// The same displacement with another share, at most [`Displacement::WHOLE`].
    #[must_use]
    pub fn with_share(mut self, share: u8) -> Displacement {
        for (i, byte) in self.bytes.as_flattened_mut().iter_mut().rev().enumerate() {
            *byte = (*byte & !1) | (share.min(Self::WHOLE) >> i & 1).cast_signed();
        }
        self
    }

    /// The displacements at the two tolerances of [`Displacement::AT`], in budget keys.
    #[inline]
    #[must_use]
    pub fn stored(self) -> [[f64; 3]; 2] {
        self.bytes.map(|d| d.map(|byte| f64::from(byte & !1) / STEPS))
    }

    /// The displacement at a tolerance of so many keys, in budget keys.
    #[inline]
    pub fn at(self, tolerance: f64) -> [f64; 3] {
        if tolerance.is_nan() || tolerance <= 0.0 {
            return [0.0; 3];
        }
        let [high, low] = Self::AT;
        let (of_high, of_low) = if tolerance >= low {
            let along = ((tolerance - low) / (high - low)).min(1.0);
            (along, 1.0 - along)
        } else {
            (0.0, tolerance * tolerance / (low * low))
        };
        let [[a, b, c], [d, e, f]] = self.stored();
        [(a, d), (b, e), (c, f)].map(|(high, low)| of_high * high + of_low * low)
    }
}

impl VertexRecord {
    /// How far beside its place the vertex is drawn (length) when its tolerance in the budget order is `allowed`.
    ///
    /// Zero where nothing is allowed, and for a vertex that is in every mesh; never longer than the key.
    pub fn displaced_by_budget(&self, allowed: f64) -> [f64; 3] {
        let key = f64::from(self.budget.get());
        self.displaced(allowed / key, 1.0)
    }

    /// The same where its tolerance is a distance that is promised: a share of the displacement at as large a part of the
    /// bound, see [`Displacement::share`]. Longer than a quarter of what is allowed it never is.
    ///
    /// Files before version 1.2 store no share, see [`crate::Tree::promises_displaced`].
    pub fn displaced_by_bound(&self, allowed: f64) -> [f64; 3] {
        let key = f64::from(self.bound.get());
        self.displaced(allowed / key, f64::from(self.displacement.share()) / f64::from(Displacement::WHOLE))
    }

    fn displaced(&self, tolerance: f64, share: f64) -> [f64; 3] {
        let key = f64::from(self.budget.get());
        if self.displacement.is_none() || !key.is_finite() {
            return [0.0; 3];
        }
        self.displacement.at(tolerance).map(|x| x * key * share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn length(d: [f64; 3]) -> f64 {
        d.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    fn vertex(displacement: [[f64; 3]; 2], bound: f64, budget: f64) -> VertexRecord {
        let [bound, budget] = [bound, budget].map(ShortFloat::up);
        let displacement = Displacement::encode(displacement, budget);
        VertexRecord { bound, budget, displacement, ..VertexRecord::default() }
    }

    #[test]
    fn a_displacement_comes_back_at_its_tolerances_and_vanishes_with_them() {
        let given = [[0.5, -0.25, 0.125], [0.25, 0.0, -0.5]];
        let record = vertex(given, 1.0, 2.0);
        let key = f64::from(record.budget.get());
        for (share, d) in Displacement::AT.into_iter().zip(given) {
            let back = record.displaced_by_budget(share * key);
            assert!((0..3).all(|k| (back[k] - d[k]).abs() <= key / 256.0), "{back:?}");
        }
        assert_eq!(record.displaced_by_budget(key), record.displaced_by_budget(0.7 * key));
        assert_eq!(record.displaced_by_budget(0.0), [0.0; 3]);
        assert_eq!(record.displaced_by_budget(f64::NAN), [0.0; 3]);
        assert!(length(record.displaced_by_budget(0.01)) < 1e-3);
        // Continuous, and never beyond the key.
        let wild = vertex([[9.0; 3], [-9.0; 3]], 1.0, 2.0);
        let mut last = wild.displaced_by_budget(0.0);
        for i in 1..=1000 {
            let next = wild.displaced_by_budget(f64::from(i) / 1000.0 * key);
            assert!(length([0, 1, 2].map(|k| next[k] - last[k])) < 0.02 * key && length(next) <= key);
            last = next;
        }
    }

    #[test]
    fn every_share_comes_back_and_leaves_the_displacement() {
        let record = vertex([[0.5, -0.25, 0.125], [0.25, 0.0, -0.5]], 3.0, 2.0);
        let whole = record.displaced_by_budget(0.5);
        for share in 0..=Displacement::WHOLE {
            let displacement = record.displacement.with_share(share);
            assert_eq!(displacement.share(), share);
            assert_eq!(displacement.with_share(0), record.displacement);
            let record = VertexRecord { displacement, ..record };
            assert_eq!(record.displaced_by_budget(0.5), whole);
            // A quarter of the bound is what a quarter of the budget key is.
            let part = record.displaced_by_bound(0.75);
            let expected = whole.map(|x| x * f64::from(share) / 63.0);
            assert!(length([0, 1, 2].map(|k| part[k] - expected[k])) < 1e-12, "{part:?}, not {expected:?}");
        }
    }

    #[test]
    fn vertices_of_every_mesh_stay() {
        let record = vertex([[1.0; 3]; 2], f64::INFINITY, f64::INFINITY);
        assert!(record.displacement.is_none());
        let record = VertexRecord { bound: ShortFloat::INFINITY, ..vertex([[0.5; 3]; 2], 1.0, 1.0) };
        let displacement = record.displacement.with_share(Displacement::WHOLE);
        assert_eq!(VertexRecord { displacement, ..record }.displaced_by_bound(1.0), [0.0; 3]);
    }
}
