//! How coarse all tolerances together have to be.

use super::{Budget, Shown};
use crate::Error;
use crate::count::Counter;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

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

/// The search ends after so many steps even if it has come to nothing; of three steps one halves the way at least.
const MOST_STEPS: u32 = 64;

/// So many times more triangles than asked for are counted, not to stop short of a number that tells how far to go back.
const ENOUGH: u64 = 2;

/// How much finer or coarser the next try is as long as none was on the other side, at most.
const LONGEST_STEP: f64 = 8.0;

/// A way, of the factor's logarithm, that is hardly worth halving further.
const SHORT_WAY: f64 = 0.02;

/// Among more than so many that are shown, every so many-th stands for its neighbours in a first guess: counting all of
/// a million takes a minute.
const SAMPLE: usize = 512;

/// Finds a factor whose cut is within the budget and close to it, or after which only one set of equal keys comes.
///
/// If even the coarsest cut is over the budget, that one comes back.
pub(super) fn find(counters: &mut [Counter], shown: &[Shown<'_>], budget: Budget) -> Result<Level, Error> {
    let wanted = budget.wanted();
    let faces: u64 = shown.iter().map(|one| one.tree.face_count() as u64).sum();
    if faces <= wanted {
        return count(counters, shown, budget, 0.0, u64::MAX);
    }
    let mut guess = None;
    let each = shown.len() / SAMPLE;
    if each > 1 {
        let sample: Vec<Shown<'_>> = shown.iter().step_by(each).cloned().collect();
        let share = wanted as f64 * sample.len() as f64 / shown.len() as f64;
        let budget = budget.with(share as u64);
        let found =
            search(None, budget.wanted(), |factor, enough| count(counters, &sample, budget, factor, enough))?;
        guess = Some(found.factor);
    }
    search(guess, wanted, |factor, enough| count(counters, shown, budget, factor, enough))
}

/// Looks for the factor, beginning at `guess` where there is one; `count` finds out what one comes to, as [`count()`].
fn search(
    guess: Option<f64>,
    wanted: u64,
    mut count: impl FnMut(f64, u64) -> Result<Level, Error>,
) -> Result<Level, Error> {
    let enough = wanted.saturating_mul(ENOUGH);
    let mut bracket = Bracket { wanted, enough, fits: None, over: None, power: 1.0, slow: 0 };
    if let Some(guess) = guess.filter(|guess| *guess > 0.0 && guess.is_finite()) {
        bracket.note(count(guess, enough)?);
    }
    for _ in 0..MOST_STEPS {
        let Some(factor) = bracket.next() else { break };
        // A leap that takes up all of a short way is seen to be one only where it is counted to its end.
        let to_the_end = factor == f64::INFINITY || bracket.way() < SHORT_WAY;
        let found = count(factor, if to_the_end { u64::MAX } else { enough })?;
        if factor == f64::INFINITY && found.count > wanted {
            return Ok(found);
        }
        bracket.note(found);
    }
    match bracket.fits {
        Some(fits) => Ok(fits),
        None => count(f64::INFINITY, u64::MAX),
    }
}

/// What the search knows.
struct Bracket {
    wanted: u64,
    enough: u64,
    /// The finest level within the budget.
    fits: Option<Level>,
    /// The coarsest over it.
    over: Option<Level>,
    /// The power of the factor that numbers go with: on a smooth surface errors fall as triangles grow.
    power: f64,
    /// Steps since the way between the two was last halved.
    slow: u32,
}

impl Bracket {
    /// The factor to be tried next; none where the search is at its end.
    fn next(&self) -> Option<f64> {
        let Some(fits) = self.fits else {
            let Some(over) = self.over else { return Some(f64::INFINITY) };
            // The guess was too fine, and a little too much soon is: not far from there it fits.
            let step = (over.count as f64 / self.wanted.max(1) as f64).powf(1.0 / self.power);
            let factor = over.factor * step.clamp(1.01, LONGEST_STEP);
            return Some(if self.slow < 2 && factor.is_finite() { factor } else { f64::INFINITY });
        };
        if is_close(self.wanted - fits.count, self.wanted) {
            return None;
        }
        // A little less than the budget is what is aimed at: just above it is a lost step.
        let growth = self.wanted as f64 * (1.0 - 1.0 / 512.0) / fits.count.max(1) as f64;
        let step = growth.powf(1.0 / self.power).clamp(1.0 + 1e-9, LONGEST_STEP);
        let Some(over) = self.over else {
            // The eye may be within a node, which then is refined whatever the factor.
            let above = fits.factor.min(fits.next).min(f64::MAX.sqrt());
            // Steps that come to little grow, so that one goes too far.
            let patience = f64::from(self.slow.saturating_sub(2));
            let factor = (above / step.powf(patience.exp2())).max(f64::MIN_POSITIVE);
            return (factor < above).then_some(factor);
        };
        let (below, above) = self.between(&fits, &over);
        if below >= above {
            // Nothing lies between, or nodes of one key: all vertices that are more eager than those come before them.
            return (fits.next < fits.factor && fits.next > over.factor).then_some(fits.next);
        }
        let way = (above.min(f64::MAX) / below).ln();
        if (over.factor >= fits.next || over.last >= fits.factor) && way < SHORT_WAY {
            // Vertices of about one key, and no node or those of one key.
            return None;
        }
        if above == f64::INFINITY {
            let factor = below * LONGEST_STEP.powf(f64::from(self.slow).exp2());
            return factor.is_finite().then_some(factor);
        }
        let tells = over.count != self.enough && fits.count > 0;
        let share = if self.slow > u32::from(tells) {
            0.5
        } else if tells {
            growth.ln() / (over.count as f64 / fits.count as f64).ln()
        } else {
            step.ln() / way
        };
        let factor = below * (way * (1.0 - share.clamp(0.05, 0.95))).exp();
        (factor > below && factor < above).then_some(factor)
    }

    /// The factors between which the search goes on. Those of keys leave out just the nodes that have them; where all
    /// nodes are on one side it is about vertices alone.
    fn between(&self, fits: &Level, over: &Level) -> (f64, f64) {
        let below = if over.last < fits.factor { over.factor.max(over.last) } else { over.factor };
        let above = if fits.next > over.factor { fits.factor.min(fits.next) } else { fits.factor };
        (below, above)
    }

    /// Notes what a factor came to.
    fn note(&mut self, found: Level) {
        let before = self.way();
        if found.count > self.wanted {
            self.over = Some(found);
        } else {
            if let Some(fits) = self.fits {
                let (finer, more) =
                    (fits.factor / found.factor, found.count as f64 / fits.count.max(1) as f64);
                if finer.is_finite() && finer > 1.1 {
                    self.power = (more.ln() / finer.ln()).clamp(0.5, 3.0);
                }
            }
            self.fits = Some(found);
        }
        let is_halved = self.way() <= 0.5 * before && before.is_finite();
        self.slow = if is_halved { 0 } else { self.slow + 1 };
    }

    /// The logarithm of the way between the two factors; infinite where one is missing.
    fn way(&self) -> f64 {
        let (Some(fits), Some(over)) = (self.fits, self.over) else { return f64::INFINITY };
        let (below, above) = self.between(&fits, &over);
        (above.min(f64::MAX) / below.max(f64::MIN_POSITIVE)).ln()
    }
}

/// What all that is shown comes to with tolerances multiplied by a factor; `enough` where it comes to that or more.
fn count(
    counters: &mut [Counter],
    shown: &[Shown<'_>],
    budget: Budget,
    factor: f64,
    enough: u64,
) -> Result<Level, Error> {
    let nothing = Level { factor, count: 0, next: 0.0, last: f64::INFINITY };
    let so_far = AtomicU64::new(0);
    let of_some = |(counter, some): (&mut Counter, &[Shown<'_>])| -> Result<Level, Error> {
        let mut level = nothing;
        for one in some {
            // Whoever comes first says so; that it is said does not depend on it.
            let others = so_far.load(Ordering::Relaxed);
            if others >= enough {
                break;
            }
            let cut = counter.cut(one, factor, |counts| budget.of(counts) >= enough - others)?;
            let count = budget.of(&cut.counts);
            so_far.fetch_add(count, Ordering::Relaxed);
            level.next = level.next.max(cut.next);
            level.last = level.last.min(cut.last);
        }
        Ok(level)
    };
    let mut level = if let ([counter, ..], [_]) = (&mut *counters, shown) {
        of_some((counter, shown))?
    } else {
        let each = shown.len().div_ceil(counters.len().max(1)).max(1);
        let sum =
            |a: Level, b: Level| Ok(Level { next: a.next.max(b.next), last: a.last.min(b.last), ..nothing });
        counters.par_iter_mut().zip(shown.par_chunks(each)).map(of_some).try_reduce(|| nothing, sum)?
    };
    level.count = so_far.into_inner();
    if level.count >= enough {
        // The walk was not finished, and how far it came is left to chance.
        level = Level { count: enough, last: 0.0, ..nothing };
    }
    Ok(level)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Searches among nodes that each add two triangles below some factor, and says how many factors were tried.
    fn steps(levels: &[f64], wanted: u64, guess: Option<f64>) -> (Level, u32) {
        let mut tried = 0;
        let found = search(guess, wanted, |factor, enough| {
            tried += 1;
            let refined = || levels.iter().copied().filter(|level| *level > factor);
            let count = (1 + 2 * refined().count() as u64).min(enough);
            let next = levels.iter().copied().filter(|level| *level <= factor).fold(0.0, f64::max);
            let last = if count < enough { refined().fold(f64::INFINITY, f64::min) } else { 0.0 };
            Ok(Level { factor, count, next, last })
        });
        (found.unwrap(), tried)
    }

    /// Numbers that grow in ways in which meshes' do, evenly, by leaps, and in ways in which none does.
    fn shapes() -> Vec<(&'static str, Vec<f64>)> {
        let of = |level: fn(f64) -> f64| (0..40_000).map(|i| level(f64::from(i) / 4e4)).collect::<Vec<f64>>();
        vec![
            ("plane", of(|t| 1.0 / (t + 1e-6))),
            ("far and near", of(|t| (1.0 / (t + 1e-9)).powi(3))),
            ("much at once", of(|t| if t < 0.1 { 5.0 - t } else { 1.0 - 1e-3 * t })),
            ("leaps", of(|t| (-(20.0 * t).floor()).exp())),
            ("steep", of(|t| (-50.0 * t).exp())),
            ("flat", of(|t| 1.0 + 1e-7 * t)),
        ]
    }

    #[test]
    fn the_search_is_short_whatever_the_numbers_grow_like() {
        for (name, levels) in shapes() {
            for wanted in [1, 50, 333, 4_001, 20_000, 79_000] {
                for guess in [None, Some(1e-9), Some(0.3), Some(1.0), Some(1e12)] {
                    let (found, tried) = steps(&levels, wanted, guess);
                    assert!(found.count <= wanted, "{name}, {wanted}: {found:?}");
                    let equal = levels.iter().filter(|level| **level == found.next).count() as u64;
                    let is_next = found.count + 2 * equal > wanted;
                    let near = is_close(wanted - found.count, wanted) || is_next;
                    assert!(near, "{name}, {wanted}, {guess:?}: {found:?} after {tried}");
                    assert!(tried <= 40, "{name}, {wanted}, {guess:?}: {tried} steps");
                }
            }
        }
    }

    #[test]
    fn a_good_guess_saves_steps() {
        let (_, levels) = shapes().swap_remove(0);
        let (found, tried) = steps(&levels, 4_001, None);
        let (_, with_guess) = steps(&levels, 4_001, Some(found.factor * 0.98));
        assert!(with_guess < tried && with_guess <= 4, "{with_guess} instead of {tried}");
    }

    #[test]
    fn what_never_fits_is_said_soon() {
        for guess in [None, Some(1.0)] {
            let mut tried = 0;
            let found = search(guess, 50, |factor, enough| {
                tried += 1;
                Ok(Level { factor, count: 201.min(enough), next: 0.0, last: f64::INFINITY })
            });
            let found = found.unwrap();
            assert!(found.count == 201 && found.factor == f64::INFINITY, "{found:?}");
            assert!(tried <= if guess.is_some() { 4 } else { 1 }, "{tried}");
        }
    }
}
