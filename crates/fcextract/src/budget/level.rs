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
}

/// How much of a budget may be left for refining node by node, which takes longer.
fn is_close(left: u64, wanted: u64) -> bool {
    left <= (wanted / 256).max(8)
}

/// The search ends after so many steps even if it has come to nothing; each one halves the way at least in the end.
const MOST_STEPS: usize = 64;

/// Finds a factor whose cut is within the budget and close to it, or after which only one set of equal keys comes.
///
/// If even the coarsest cut is over the budget, that one comes back.
pub(super) fn find(counters: &mut [Counter], shown: &[Shown<'_>], budget: Budget) -> Result<Level, Error> {
    let wanted = budget.wanted();
    let faces: u64 = shown.iter().map(|one| one.tree.face_count() as u64).sum();
    // More than this is not worth the time: a number that is exact tells how far to go back.
    let enough = wanted.saturating_add(wanted / 8 + 64);
    let mut count = |factor: f64, enough: u64| count(counters, shown, budget, factor, enough);
    if faces <= wanted {
        return count(0.0, u64::MAX);
    }
    let mut fits = count(f64::INFINITY, u64::MAX)?;
    let mut over: Option<Level> = None;
    for _ in 0..MOST_STEPS {
        let below = over.map_or(0.0, |over| over.factor);
        let above = fits.factor.min(fits.next);
        if fits.count > wanted || is_close(wanted - fits.count, wanted) || above <= below || above == 0.0 {
            break;
        }
        let factor = match over {
            // The eye may be within a node, which then is refined whatever the factor.
            None => above.min(f64::MAX.sqrt()) / 4.0,
            Some(over) => {
                let Some(factor) = between(&fits, above, &over, wanted, enough) else { break };
                factor
            }
        };
        let next = count(factor, enough)?;
        if next.count <= wanted {
            fits = next;
        } else {
            over = Some(next);
        }
    }
    Ok(fits)
}

/// Where the budget is met if numbers are a power of the factor; none if nothing lies between.
fn between(fits: &Level, above: f64, over: &Level, wanted: u64, enough: u64) -> Option<f64> {
    let (high, low) = (above.min(f64::MAX).ln(), over.factor.ln());
    // A little less than the budget is what is aimed at: just above it is a lost step.
    let target = wanted as f64 * (1.0 - 1.0 / 512.0);
    let share = if over.count < enough && fits.count > 0 {
        (target / fits.count as f64).ln() / (over.count as f64 / fits.count as f64).ln()
    } else {
        0.5
    };
    let factor = (high + (low - high) * share.clamp(0.1, 0.9)).exp();
    (factor < above && factor > over.factor).then_some(factor)
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
    let nothing = Level { factor, count: 0, next: 0.0 };
    let of_one = |(counter, one): (&mut Counter, &Shown<'_>)| {
        let cut = counter.cut(one, factor, |counts| budget.of(counts) >= enough)?;
        Ok(Level { factor, count: budget.of(&cut.counts), next: cut.next })
    };
    let sum = |a: Level, b: Level| Ok(Level { factor, count: a.count + b.count, next: a.next.max(b.next) });
    if let ([counter, ..], [one]) = (&mut *counters, shown) {
        return of_one((counter, one));
    }
    counters.par_iter_mut().zip(shown).map(of_one).try_reduce(|| nothing, sum)
}
