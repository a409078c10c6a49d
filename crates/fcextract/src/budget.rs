//! Selections that ask for a number instead of a tolerance.

use crate::{Error, Extraction, Order, Selection, extract};
use fct::Tree;

/// What to stay within.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Budget {
    /// At most so many triangles.
    Triangles(u64),
    /// At most so many clusters.
    Clusters(u64),
}

/// The selection found for a budget.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// A uniform tolerance in [`Order::Budget`], with vertices displaced.
    pub selection: Selection,
    /// Whether the result is within the budget; not if even the coarsest mesh is over it.
    pub within: bool,
}

/// Finds the finest cut in [`Order::Budget`] that stays within `budget`, and leaves its mesh in `out`.
///
/// Vertices are to be drawn where [`Selection::position`] says.
/// Only tolerances between two neighbouring keys of the tree differ, so the keys are bisected; nodes of equal keys
/// are refined together.
///
/// # Errors
/// As [`extract`].
pub fn fit(tree: &Tree, budget: Budget, out: &mut Extraction) -> Result<Fitted, Error> {
    // Vertices on boundaries may have larger keys than all nodes.
    let of_vertices = tree.vertices().iter().map(|v| v.budget());
    let mut keys: Vec<f32> =
        tree.keys().map(|[_, budget]| budget).chain(of_vertices).filter(|k| k.is_finite()).collect();
    keys.sort_unstable_by(|a, b| b.total_cmp(a));
    keys.dedup();
    let within = |out: &Extraction| match budget {
        Budget::Triangles(n) => out.stats.triangles <= n,
        Budget::Clusters(n) => out.stats.clusters <= n,
    };
    // The full mesh first: it may fit, and flat clusters have key 0, which no tolerance refines.
    let full = Selection { order: Order::Budget, ..Selection::full() };
    if tree.face_count() as u64 <= wanted(budget) {
        extract(tree, &full, out)?;
        return Ok(Fitted { selection: full, within: true });
    }
    // keys[i] as tolerance refines all nodes of larger keys, that is, keys[..i].
    let at = |i: usize| Selection {
        displaced: true,
        ..Selection::uniform(keys.get(i).copied().map_or(0.0, f64::from), Order::Budget)
    };
    let (mut fits, mut over) = (0, keys.len());
    while over - fits > 1 {
        let middle = fits + (over - fits) / 2;
        extract(tree, &at(middle), out)?;
        if within(out) {
            fits = middle;
        } else {
            over = middle;
        }
    }
    let selection = at(fits);
    extract(tree, &selection, out)?;
    Ok(Fitted { within: within(out), selection })
}

fn wanted(budget: Budget) -> u64 {
    match budget {
        Budget::Triangles(n) | Budget::Clusters(n) => n,
    }
}
