//! Selections that ask for a number instead of a tolerance.
//!
//! Nodes are refined in the order of their keys, the largest first, until the number is reached: a greedy choice.
//! How much of the order a multiple of the tolerance covers is found by counting; what is left of the number is spent
//! node by node.

mod candidate;
mod front;
mod level;
mod rest;
mod trial;

use crate::count::Counter;
use crate::{Error, Extraction, Selection, Tolerance, extract};
use fct::Tree;
use rest::Rest;

/// What to stay within.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Budget {
    /// At most so many triangles.
    Triangles(u64),
    /// At most so many clusters.
    Clusters(u64),
}

impl Budget {
    pub(crate) fn wanted(self) -> u64 {
        match self {
            Budget::Triangles(n) | Budget::Clusters(n) => n,
        }
    }

    /// The same of another number.
    fn with(self, wanted: u64) -> Budget {
        match self {
            Budget::Triangles(_) => Budget::Triangles(wanted),
            Budget::Clusters(_) => Budget::Clusters(wanted),
        }
    }

    pub(crate) fn of(self, counts: &crate::count::Counts) -> u64 {
        match self {
            Budget::Triangles(_) => counts.triangles,
            Budget::Clusters(_) => counts.clusters,
        }
    }
}

/// A tree and what is to be shown of it.
#[derive(Clone, Debug)]
pub struct Shown<'a> {
    /// The tree.
    pub tree: &'a Tree,
    /// How it is looked at. Before a fit its tolerance says where errors weigh how much, after it what is drawn.
    pub selection: Selection,
}

/// What became of a budget.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Fitted {
    /// How many triangles, or clusters, are drawn.
    pub count: u64,
    /// Whether that is within the budget; not if even the coarsest meshes are over it.
    pub within: bool,
    /// How many there would be with the smallest of the splits that did not fit, about; `None` where none was tried in
    /// vain. Far above the budget where the tree has splits that bring much at once.
    pub next: Option<u64>,
    /// By how much the tolerances were multiplied; 0 where everything is drawn in full, infinite for the coarsest cut.
    pub factor: f64,
}

/// So many counters a thread share what is shown evenly enough.
const COUNTERS: usize = 8;

/// Divides budgets; keeps most of its memory from one to the next.
///
/// A fit counts the cut some eight times, on all threads, and spends what is left node by node: it takes three to ten
/// times as long as extracting what it finds. Where a frame has no time for that, a tolerance does, found by steering it.
#[derive(Debug, Default)]
pub struct Fitter {
    counters: Vec<Counter>,
    rest: Rest,
}

impl Fitter {
    /// Divides one budget among all that is shown, and leaves in each selection what is to be drawn.
    ///
    /// All tolerances are multiplied by the same factor, so an error weighs everywhere as much as they say: a
    /// [`Tolerance::Perspective`] of one slope for all counts errors on screen, a [`Tolerance::Uniform`] with a distance
    /// that allows for its instance's scale counts lengths. What culling leaves out counts for nothing.
    /// Nodes are refined in the order of their keys over what is allowed to them; equal ones in the order of the trees
    /// here and of the nodes in them. One that would not fit is skipped. A selection's regions keep their own errors,
    /// and what it had in [`Selection::extra`] is forgotten.
    ///
    /// The number of triangles ends at most four below the budget, unless all is drawn in full or every split left
    /// needs more: splits of a closed surface bring two or four, seldom more. It is the number that [`extract`] draws,
    /// exactly.
    ///
    /// # Errors
    /// As [`extract`].
    pub fn fit(&mut self, shown: &mut [Shown<'_>], budget: Budget) -> Result<Fitted, Error> {
        for one in shown.iter_mut() {
            one.selection.extra.clear();
            if one.selection.tolerance == Tolerance::Full {
                one.selection.tolerance = Tolerance::Uniform { distance: 1.0 };
            }
            one.selection.check()?;
        }
        // Not one for each that is shown: a million instances would take all memory.
        let counters = shown.len().min(COUNTERS * rayon::current_num_threads());
        if self.counters.len() < counters {
            self.counters.resize_with(counters, Counter::default);
        }
        let found = level::find(&mut self.counters, shown, budget)?;
        let shape: Vec<Tolerance> = shown.iter().map(|one| one.selection.tolerance).collect();
        for one in shown.iter_mut() {
            one.selection.tolerance = one.selection.tolerance.scaled(found.factor);
        }
        let mut fitted = Fitted {
            count: found.count,
            within: found.count <= budget.wanted(),
            next: None,
            factor: found.factor,
        };
        if fitted.within && fitted.factor > 0.0 {
            (fitted.count, fitted.next) = self.rest.spend(shown, &shape, budget, found.count)?;
        }
        Ok(fitted)
    }
}

/// Finds the finest cut of a single tree that stays within `budget`, and leaves its mesh in `out`.
///
/// `selection` is as in [`Shown`]; [`Selection::by_budget`] is one for a mesh without a view. The selection that is
/// drawn comes back; vertices are to be drawn where its [`Selection::position`] says.
///
/// # Errors
/// As [`extract`].
pub fn fit(
    tree: &Tree,
    selection: Selection,
    budget: Budget,
    out: &mut Extraction,
) -> Result<(Selection, Fitted), Error> {
    let mut shown = [Shown { tree, selection }];
    let fitted = Fitter::default().fit(&mut shown, budget)?;
    let [Shown { selection, .. }] = shown;
    extract(tree, &selection, out)?;
    Ok((selection, fitted))
}
