//! What becomes of the nodes and vertices of a page.

use crate::extraction::Stats;
use crate::part::Sight;
use crate::{Order, Selection, Tolerance};
use fct::{Branch, Page, VertexRecord};

/// Decides about nodes and vertices. A selection does; what decides as it does and sooner does too.
pub(crate) trait Criterion {
    /// What becomes of a node of a page, and counts it; none if it is not there.
    fn sight(&self, page: &Page<'_>, branch: &Branch, inside: bool, stats: &mut Stats) -> Option<Sight>;

    /// Whether the vertex of this index is drawn.
    fn activates(&self, index: u32, vertex: &VertexRecord) -> bool;
}

impl Criterion for Selection {
    #[inline]
    fn sight(&self, page: &Page<'_>, branch: &Branch, inside: bool, stats: &mut Stats) -> Option<Sight> {
        let node = page.node(branch)?;
        Some(Selection::sight(self, &page.subtree(branch), &node, inside, stats))
    }

    #[inline]
    fn activates(&self, index: u32, vertex: &VertexRecord) -> bool {
        Selection::activates(self, index, vertex)
    }
}

/// The same tolerance everywhere, and nothing left out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Everywhere {
    order: Order,
    distance: f64,
}

impl Everywhere {
    /// What a selection comes to in a subtree, if it comes to that; `inside` if its frustum holds the subtree.
    pub(crate) fn of(selection: &Selection, inside: bool) -> Option<Everywhere> {
        match selection.tolerance {
            Tolerance::Uniform { distance } if inside && selection.is_plain() => {
                Some(Everywhere { order: selection.order, distance: distance.min(f64::MAX) })
            }
            _ => None,
        }
    }

    /// As [`Tolerance::refines`]: NaN is refined.
    #[inline]
    fn refines(&self, key: f32) -> bool {
        let key = f64::from(key);
        key > self.distance || key.is_nan()
    }
}

impl Criterion for Everywhere {
    #[inline]
    fn sight(&self, page: &Page<'_>, branch: &Branch, inside: bool, stats: &mut Stats) -> Option<Sight> {
        stats.nodes_visited += 1;
        let [bound, budget] = page.keys(branch)?;
        let key = if self.order == Order::Bound { bound } else { budget };
        Some(if self.refines(key) { Sight::Refined { inside } } else { Sight::Drawn })
    }

    #[inline]
    fn activates(&self, _index: u32, vertex: &VertexRecord) -> bool {
        self.refines(self.order.of_vertex(vertex))
    }
}
