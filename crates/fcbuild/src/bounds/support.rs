//! Pairs of planes that lean, kept for displaced vertices: how far they may go is measured between the same planes.

use super::slab::RIDGE;
use glam::{DVec2, Vec2};

/// Sine and cosine of 10 degrees: a point may be seen from a chord so far off the direction, see [`RIDGE`].
const SIN: f64 = 0.173_648_177_666_930_35;
const COS: f64 = 0.984_807_753_012_208;

/// How much farther than along the direction a point may be from a chord, over what it may be where planes are level.
///
/// Between level planes that are b apart it is b / cos(10 degrees), between ones that lean by a slope s at most
/// b / (cos(10 degrees) - |s| sin(10 degrees)).
#[inline]
pub(crate) fn farther(slope: DVec2) -> f64 {
    1.0 / (RIDGE * (COS - slope.length() * SIN))
}

/// Two parallel planes over and under a cluster's border, as they are kept for displaced vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Support {
    /// The cluster, counted from the first of its piece.
    pub(super) place: u16,
    /// How they lean.
    pub(super) slope: Slope,
    /// How far what was measured between them may be above the polygon, and the polygon above it, in shares of the
    /// farthest that anything is, rounded up and 1 more; 0 if nothing was.
    pub(super) apart: [u8; 2],
}

/// The whole of a share.
pub(super) const STEPS: f64 = 254.0;

impl Support {
    /// By how much the planes lean.
    pub(crate) fn slope(&self) -> DVec2 {
        self.slope.get()
    }

    /// How far what was measured between them may be above the polygon, and the polygon above it, if that is known of
    /// all that was measured; negative if nothing was.
    pub(crate) fn apart(&self, all: [f64; 2]) -> [f64; 2] {
        let of = |side: usize| match self.apart[side] {
            0 => f64::NEG_INFINITY,
            share => f64::from(share - 1) / STEPS * all[side],
        };
        [of(0), of(1)]
    }
}

/// By how much planes lean against a direction, in both ways across it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Slope([i16; 2]);

impl Slope {
    const UNIT: f32 = 8192.0;

    /// The nearest to this, where it is less than 4.
    pub(super) fn near(slope: Vec2) -> Slope {
        Slope((slope * Slope::UNIT).round().to_array().map(|s| s as i16))
    }

    pub(super) fn get(self) -> DVec2 {
        DVec2::from(self.0.map(f64::from)) / f64::from(Slope::UNIT)
    }
}

/// Those of some clusters, in the order of the nodes.
#[derive(Clone, Debug, Default)]
pub struct Piece {
    /// The node that places count from.
    pub first: u32,
    /// Those of each cluster side by side.
    pub supports: Vec<Support>,
}

/// Those of all clusters, in pieces that are in the order of the nodes too.
#[derive(Clone, Debug, Default)]
pub struct AllSupports(Vec<Piece>);

impl AllSupports {
    /// Puts pieces together that are in order.
    pub fn of_pieces(pieces: impl Iterator<Item = Piece>) -> AllSupports {
        AllSupports(pieces.filter(|piece| !piece.supports.is_empty()).collect())
    }

    /// Those of a node; none if it is not measured between planes that lean.
    pub(crate) fn of_node(&self, node: usize) -> &[Support] {
        let after = self.0.partition_point(|piece| piece.first as usize <= node);
        let Some(Piece { first, supports }) = after.checked_sub(1).map(|piece| &self.0[piece]) else {
            return &[];
        };
        let place = node - *first as usize;
        let some = &supports[supports.partition_point(|support| usize::from(support.place) < place)..];
        // There are four at most.
        &some[..some.iter().take_while(|support| usize::from(support.place) == place).count()]
    }
}
