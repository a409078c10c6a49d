//! How coarse all tolerances together have to be.

use super::{Budget, Shown};
use crate::Error;
use crate::count::Counter;
use rayon::prelude::*;

/// A factor on the tolerances, and what it comes to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Level {
    pub(super) factor: f64,
    pub(super) count: u64,
    /// The factor below which the next node is refined; 0 if there is none but nodes of key 0.
    next: f64,
    /// The largest factor below which the last of the refined nodes is still refined.
    last: f64,
}

/// How much of a budget may be left for refining node by node, which takes longer.
fn is_close(left: u64, wanted: u64) -> bool {
    left <= (wanted / 256).max(8)
}

/// The search ends after so many steps even if it has come to nothing; each one halves the way at least in the end.
const MOST_STEPS: usize = 64;

/// So many times more triangles than asked for are counted, not to stop short of a number that tells how far to go back.
const ENOUGH: u64 = 2;

/// How much finer the next try is as long as none had too many triangles, at most.
const LONGEST_STEP: f64 = 8.0;

/// Finds a factor whose cut is within the budget and close to it, or after which only one set of equal keys comes.
///
/// If even the coarsest cut is over the budget, that one comes back.
pub(super) fn find(counters: &mut [Counter], shown: &[Shown<'_>], budget: Budget) -> Result<Level, Error> {
    let wanted = budget.wanted();
    let faces: u64 = shown.iter().map(|one| one.tree.face_count() as u64).sum();
    let enough = wanted.saturating_mul(ENOUGH);
    let mut count = |factor: f64, enough: u64| count(counters, shown, budget, factor, enough);
    if faces <= wanted {
        return count(0.0, u64::MAX);
    }
    let mut fits = count(f64::INFINITY, u64::MAX)?;
    let mut over: Option<Level> = None;
    // The power of the factor that numbers go with: on a smooth surface errors fall as triangles grow.
    let mut power = 1.0;
    for _ in 0..MOST_STEPS {
        let above = fits.factor.min(fits.next);
        if fits.count > wanted || is_close(wanted - fits.count, wanted) || above == 0.0 {
            break;
        }
        // A factor of the last key leaves out just the nodes that have it.
        let below = over.map_or(0.0, |over| over.factor.max(over.last));
        if below >= above {
            // Nothing lies between, or nodes of one key alone.
            break;
        }
        // A little less than the budget is what is aimed at: just above it is a lost step.
        let growth = wanted as f64 * (1.0 - 1.0 / 512.0) / fits.count.max(1) as f64;
        let step = growth.powf(1.0 / power).clamp(1.0 + 1e-9, LONGEST_STEP);
        let factor = match over {
            // The eye may be within a node, which then is refined whatever the factor.
            None => above.min(f64::MAX.sqrt()) / step,
            Some(over) => {
                let way = (above.min(f64::MAX) / below).ln();
                let share = if over.count < enough && fits.count > 0 {
                    growth.ln() / (over.count as f64 / fits.count as f64).ln()
                } else {
                    step.ln() / way
                };
                below * (way * (1.0 - share.clamp(0.05, 0.95))).exp()
            }
        };
        if factor <= below || factor >= above {
            break;
        }
        let next = count(factor, enough)?;
        if next.count <= wanted {
            let (finer, more) = (fits.factor / factor, next.count as f64 / fits.count.max(1) as f64);
            if finer.is_finite() && finer > 1.1 {
                power = (more.ln() / finer.ln()).clamp(0.5, 3.0);
            }
            fits = next;
        } else {
            over = Some(next);
        }
    }
    Ok(fits)
}

/// What all that is shown comes to with tolerances multiplied by a factor; some number of `enough` or more where that
/// is reached.
fn count(
    counters: &mut [Counter],
    shown: &[Shown<'_>],
    budget: Budget,
    factor: f64,
    enough: u64,
) -> Result<Level, Error> {
    let nothing = Level { factor, count: 0, next: 0.0, last: f64::INFINITY };
    let sum = |a: Level, b: Level| {
        let (next, last) = (a.next.max(b.next), a.last.min(b.last));
        Ok(Level { factor, count: a.count + b.count, next, last })
    };
    let of_some = |(counter, some): (&mut Counter, &[Shown<'_>])| -> Result<Level, Error> {
        some.iter().try_fold(nothing, |so_far, one| {
            let cut = counter.cut(one, factor, |counts| budget.of(counts) >= enough)?;
            sum(so_far, Level { factor, count: budget.of(&cut.counts), next: cut.next, last: cut.last })
        })
    };
    let mut level = if let ([counter, ..], [_]) = (&mut *counters, shown) {
        of_some((counter, shown))?
    } else {
        let each = shown.len().div_ceil(counters.len().max(1)).max(1);
        counters.par_iter_mut().zip(shown.par_chunks(each)).map(of_some).try_reduce(|| nothing, sum)?
    };
    if level.count >= enough {
        // The walk was not finished.
        level.last = 0.0;
    }
    Ok(level)
}
