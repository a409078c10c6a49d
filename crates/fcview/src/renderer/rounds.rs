//! Drawing front to back, and leaving out what is hidden by what is drawn.
//!
//! Every piece is asked about once, just before its turn, so that all that is drawn before it may hide it; pieces of
//! one round do not hide one another.
//!
//! # Paper
//! [Tsuji07, 5.3]: clusters that nearer ones hide are found by occlusion queries and not drawn.

use super::{Drawing, Renderer, lap};
use crate::Error;
use crate::frame::order;
use crate::frame::pieces::Piece;
use crate::frame::questions::questions;
use crate::gpu::occlusion::PolygonList;
use crate::options::FrameOptions;
use crate::stats::FrameStats;
use std::time::Instant;

/// The part of the triangles asked about that must have been hidden for the asking to go on, once it has had its
/// chance with a quarter of the frame. More gives up on pictures where little is hidden, but some.
const LEAST_YIELD: f64 = 0.04;

impl Renderer {
    /// Draws the nearest pieces, then asks round by round which of the next ones show, and draws those. Returns the
    /// number of indices drawn.
    pub(super) fn draw_in_rounds(
        &mut self,
        drawing: &Drawing<'_>,
        pieces: &[Piece],
        options: &FrameOptions,
        clock: &mut Instant,
        stats: &mut FrameStats,
    ) -> Result<u64, Error> {
        let total = order::indices(pieces);
        let rounds = options.rounds.max(1);
        let mut left = pieces;
        let (mut drawn, mut asked_about, mut hidden) = (0, 0, 0);
        for round in 0..rounds {
            let first = round == 0;
            let last = round + 1 == rounds;
            let count =
                if last { left.len() } else { order::leading(left, share_of_round(round, rounds, total)) };
            let (next, rest) = left.split_at_checked(count).unwrap_or((left, &[]));
            left = rest;
            let pays = asked_about < total / 4 || hidden as f64 >= LEAST_YIELD * asked_about as f64;
            if first || !pays {
                drawn += self.draw_pieces(drawing, next, first, last)?;
            } else {
                let (shown, queries) = self.shown(drawing, next)?;
                asked_about += order::indices(next);
                hidden += order::indices(next) - order::indices(&shown);
                stats.counts.queries += queries;
                stats.counts.batches_culled_occlusion += (next.len() - shown.len()) as u64;
                stats.milliseconds.queries += lap(clock);
                drawn += self.draw_pieces(drawing, &shown, first, last)?;
            }
            if !last {
                self.finish_stage(options, "drawing")?;
                let stage = match round {
                    0 => &mut stats.milliseconds.occluders,
                    _ => &mut stats.milliseconds.draw,
                };
                *stage += lap(clock);
            }
        }
        Ok(drawn)
    }

    /// Those of some pieces that show, or may, and the number of queries that it took to know. The others are noted
    /// as hidden.
    fn shown(&mut self, drawing: &Drawing<'_>, pieces: &[Piece]) -> Result<(Vec<Piece>, u64), Error> {
        let (Some(pipelines), Some(target)) = (&self.pipelines, &self.target) else {
            return Ok((pieces.to_vec(), 0));
        };
        let asked = questions(drawing.scene, drawing.view, &self.cuts, pieces, drawing.fewest);
        let mut polygons = PolygonList::default();
        for question in asked.iter().flatten() {
            question.ask(&mut polygons);
        }
        let answers = self.queries.visible(&self.gpu, pipelines, target, &polygons)?;
        let queries = answers.len() as u64;
        let mut answers = answers.into_iter();
        let mut shown = Vec::with_capacity(pieces.len());
        for (piece, question) in pieces.iter().zip(&asked) {
            if question.is_none() || answers.next() != Some(false) {
                shown.push(*piece);
            } else {
                self.hidden.push(*piece);
            }
        }
        Ok((shown, queries))
    }
}

/// How many of `total` indices a round draws or asks about: less in the first ones, whose pieces hide the most and
/// are hidden the least.
fn share_of_round(round: u32, rounds: u32, total: u64) -> u64 {
    let until = |round: u32| (f64::from(round) / f64::from(rounds)).powf(1.5) * total as f64;
    (until(round + 1) - until(round)) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_grow_and_share_everything() {
        for rounds in [1, 2, 4, 32] {
            let shares: Vec<u64> =
                (0..rounds).map(|round| share_of_round(round, rounds, 3_000_000)).collect();
            assert!(shares.is_sorted() && shares[0] > 0, "{shares:?}");
            let sum: u64 = shares.iter().sum();
            assert!((3_000_000 - 64..=3_000_000).contains(&sum), "{shares:?}");
        }
    }
}
