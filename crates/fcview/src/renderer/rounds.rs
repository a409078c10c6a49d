//! Drawing front to back, and leaving out what is hidden by what is drawn, before it is cut.
//!
//! A frame is drawn in rounds. Each takes the instances and pieces that begin nearer than some distance. Instances are
//! asked about as a whole; those that show are divided into pieces, which are asked about in their turn; those of them
//! that show are cut, uploaded and drawn, and may hide what the next round asks about. Nothing is known from earlier
//! frames, so a jump of the camera costs nothing.
//!
//! # Paper
//! [Tsuji07, 5.3]: clusters that nearer ones hide are found by occlusion queries and not drawn.

use super::passes::Ends;
use super::{Frame, Renderer, lap};
use crate::Error;
use crate::frame::pieces::{self, Piece};
use crate::frame::questions::{Asking, Question};
use crate::gpu::occlusion::PolygonList;
use crate::gpu::readback;
use crate::options::{FrameOptions, Occlusion};
use crate::stats::FrameStats;
use std::time::Instant;

impl Renderer {
    /// Draws a frame.
    pub(super) fn draw_in_rounds(
        &mut self,
        frame: &Frame<'_>,
        clock: &mut Instant,
        stats: &mut FrameStats,
    ) -> Result<(), Error> {
        self.begin_geometry();
        self.hidden.clear();
        self.drawn.clear();
        self.outlines.clear();
        let rounds = match frame.options.occlusion {
            Occlusion::Exact | Occlusion::Queries => FrameOptions::rounds(frame.plan.pieces),
            Occlusion::Off => 1,
        };
        let mut waiting = frame.plan.whole(frame.scene);
        self.depths_are_current = false;
        for round in 0..rounds {
            let first = round == 0;
            let end = if round + 1 == rounds { i32::MAX } else { end_of_round(round, rounds, &waiting) };
            let enough = frame.options.only_occluders && round + 1 >= rounds / 2;
            let last = round + 1 == rounds || enough;
            let mut now = self.due(frame, &mut waiting, end, !first, clock, stats)?;
            pieces::front_to_back(&mut now);
            stats.counts.batches += now.len() as u64;
            if !first {
                now = self.shown(frame, now, stats)?;
                stats.milliseconds.queries += lap(clock);
            }
            self.draw_pieces(frame, &now, Ends { first, last }, clock, stats)?;
            self.depths_are_current = false;
            self.drawn.append(&mut now);
            if !last {
                self.finish_stage(frame.options, "drawing")?;
                let stage =
                    if first { &mut stats.milliseconds.occluders } else { &mut stats.milliseconds.draw };
                *stage += lap(clock);
            } else {
                break;
            }
        }
        if let (Some(pipelines), Some(target)) = (&self.pipelines, &self.target) {
            self.outlines.draw(&self.gpu, pipelines, target)?;
        }
        Ok(())
    }

    /// Takes the pieces up to band `end` out of those that wait, in no order; on the way whole instances are asked
    /// about, if `ask`, and divided.
    fn due(
        &mut self,
        frame: &Frame<'_>,
        waiting: &mut Vec<Piece>,
        end: i32,
        ask: bool,
        clock: &mut Instant,
        stats: &mut FrameStats,
    ) -> Result<Vec<Piece>, Error> {
        let (due, rest): (Vec<Piece>, Vec<Piece>) = waiting.drain(..).partition(|piece| piece.band <= end);
        *waiting = rest;
        let (mut now, mut whole): (Vec<Piece>, Vec<Piece>) = due.into_iter().partition(|piece| piece.divided);
        if ask {
            let before = whole.len();
            whole = self.shown(frame, whole, stats)?;
            stats.counts.instances_hidden += (before - whole.len()) as u64;
            stats.milliseconds.queries += lap(clock);
        }
        let mut walked = fcextract::Stats::default();
        let divided = pieces::divide(frame.scene, frame.plan, &whole, &mut walked)?;
        stats.counts.add(&walked);
        let (near, far): (Vec<Piece>, Vec<Piece>) = divided.into_iter().partition(|piece| piece.band <= end);
        now.extend(near);
        waiting.extend(far);
        stats.milliseconds.cut += lap(clock);
        Ok(now)
    }

    /// Those of some pieces that show, or may. The others are noted as hidden.
    fn shown(
        &mut self,
        frame: &Frame<'_>,
        pieces: Vec<Piece>,
        stats: &mut FrameStats,
    ) -> Result<Vec<Piece>, Error> {
        let answered = self.answered(frame, &pieces)?;
        let mut shown = Vec::with_capacity(pieces.len());
        stats.counts.queries += answered.len() as u64;
        for (piece, (question, is_shown)) in pieces.into_iter().zip(&answered) {
            if let Some(question) = question
                && frame.options.show_questions
            {
                self.outlines.add(question.corners(), !is_shown);
            }
            if *is_shown {
                shown.push(piece);
                continue;
            }
            stats.counts.batches_culled_occlusion += 1;
            stats.counts.faces_hidden += u64::from(piece.part.subtree.face_count());
            self.hidden.push(piece);
        }
        Ok(shown)
    }

    /// What was asked about each of some pieces, and whether it may show.
    fn answered(
        &mut self,
        frame: &Frame<'_>,
        pieces: &[Piece],
    ) -> Result<Vec<(Option<Question>, bool)>, Error> {
        let asking = Asking::new(frame.scene, frame.view, frame.plan);
        let (Some(pipelines), Some(target)) = (&self.pipelines, &self.target) else {
            return Ok(pieces.iter().map(|_| (None, true)).collect());
        };
        if frame.options.occlusion == Occlusion::Queries || !self.looks_at_depth(target.samples) {
            let asked = asking.questions(pieces);
            let mut polygons = PolygonList::default();
            for question in asked.iter().flatten() {
                polygons.push(question.corners());
            }
            let mut answers = self.queries.visible(&self.gpu, pipelines, target, &polygons)?.into_iter();
            let answer = |question: Option<Question>| {
                let is_shown = question.is_none() || answers.next() != Some(false);
                (question, is_shown)
            };
            return Ok(asked.into_iter().map(answer).collect());
        }
        if !self.depths_are_current && !pieces.is_empty() {
            let depths = &mut self.depths;
            readback::depth_rows(&self.gpu, target, &mut self.depth_staging, |rows, row| {
                depths.fill(target.size, rows, row);
            })?;
            self.depths_are_current = true;
        }
        Ok(asking.answered(pieces, &self.depths, frame.options.show_questions))
    }
}

fn triangles(pieces: &[Piece]) -> f64 {
    pieces.iter().map(|piece| piece.triangles).sum()
}

/// The last band of a round: the bands up to there have about the round's share of what waits. Less in the first rounds,
/// whose pieces hide the most and are hidden the least.
fn end_of_round(round: u32, rounds: u32, waiting: &[Piece]) -> i32 {
    let until = |round: u32| (f64::from(round) / f64::from(rounds)).powf(1.5);
    let share = (until(round + 1) - until(round)) / (1.0 - until(round));
    let wanted = share * triangles(waiting);
    let mut by_middle: Vec<(i32, f64)> =
        waiting.iter().map(|piece| (piece.middle, piece.triangles)).collect();
    by_middle.sort_unstable_by_key(|(middle, _)| *middle);
    let mut sum = 0.0;
    for (middle, triangles) in by_middle {
        sum += triangles;
        if sum >= wanted {
            return middle;
        }
    }
    i32::MAX
}
