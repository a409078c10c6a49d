//! What a cluster's bound leaves to vertices that are drawn beside their places.
//!
//! A bound holds for polygons whose vertices lie on the border, between the heights of its slab. A vertex that is drawn
//! beside its place takes the polygon with it; where the cluster bulges to one side of its border, as most do, it may move
//! that way and the polygon is as near as before, or nearer.

use super::slab::{EASE, RIDGE};
use fct::FineNormalRecord;
use glam::DVec3;

/// What a node's bound leaves, in shares of it that are rounded to the safe side.
#[derive(Clone, Copy, Debug)]
pub struct Slack {
    /// The direction of its slab.
    direction: FineNormalRecord,
    /// How far above the highest vertex of its border, and below the lowest one, vertices may be drawn.
    room: [u8; 2],
    /// What its bound must be for all that is not measured along the direction: all of it for a folded cluster.
    beside: u8,
}

const STEPS: f64 = 255.0;

fn down(share: f64) -> u8 {
    (share * STEPS).floor() as u8
}

fn up(share: f64) -> u8 {
    (share * STEPS).ceil() as u8
}

impl Slack {
    /// A cluster that leaves none.
    pub(super) const NONE: Slack =
        Slack { direction: FineNormalRecord { uv: [fct::I16::ZERO; 2] }, room: [0; 2], beside: u8::MAX };

    /// A slab of this bound, whose polygons may be `room` higher and lower than they are without displacement, with arcs
    /// that ask for a bound of `beside`.
    pub(super) fn of_slab(direction: FineNormalRecord, room: [f64; 2], beside: f64, bound: f64) -> Slack {
        if bound > 0.0 && bound.is_finite() {
            Slack { direction, room: room.map(|room| down(room / bound)), beside: up(beside / bound) }
        } else {
            Slack::NONE
        }
    }

    /// A folded cluster, which is measured from its corners.
    pub(super) fn of_folded(measured: f64) -> Slack {
        Slack::of_slab(FineNormalRecord::default(), [0.0; 2], measured, EASE * measured)
    }

    /// The same in shares of a bound that has been raised.
    pub(super) fn raised(self, bound: f32, raised: f32) -> Slack {
        let (bound, raised) = (f64::from(bound), f64::from(raised));
        if !(raised > bound && raised.is_finite()) {
            return self;
        }
        let room = |share: u8| down((f64::from(share) / STEPS * bound + (raised - bound) / RIDGE) / raised);
        Slack {
            room: self.room.map(room),
            beside: up(f64::from(self.beside) / STEPS * bound / raised),
            ..self
        }
    }

    /// The direction of the slab, of unit length.
    pub fn direction(&self) -> DVec3 {
        DVec3::from_array(self.direction.direction())
    }

    /// How far above the highest and below the lowest vertex of its border a vertex may be drawn where so much is
    /// allowed, if the node's bound is `bound`; what it moves across the direction counts too.
    pub fn room(&self, bound: f64, allowed: f64) -> [f64; 2] {
        self.room.map(|share| f64::from(share) / STEPS * bound + (allowed - bound) / RIDGE)
    }

    /// How far it may be drawn from its place at all.
    pub fn step(&self, bound: f64, allowed: f64) -> f64 {
        allowed - f64::from(self.beside) / STEPS * bound
    }
}
