//! What becomes of the nodes and vertices of a page.

use crate::extraction::Stats;
use crate::part::Sight;
use crate::{Order, Perspective, Selection, Tolerance};
use fct::{Branch, Page, VertexRecord};
use glam::DVec3;

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

/// A view's tolerance alone decides about vertices, and most of those of a page at a glance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen<'a> {
    selection: &'a Selection,
    view: &'a Perspective,
    /// A vertex whose sphere is no larger than this has it in [`WIDER`] times the sphere of the page's root.
    radius: f32,
    /// There no less than this is allowed.
    allowed: f64,
}

/// A vertex lies in the sphere of each node whose boundary it is on. The centre of its own sphere is less than sqrt 3
/// radii from it, so a sphere of a quarter of the node's radius reaches less than 0.69 of that beyond.
const WIDER: f64 = 3.8;

/// What rounding may do to what is allowed in nested spheres, and more.
const ROUNDING: f64 = 1.0 - 1e-6;

impl<'a> Seen<'a> {
    /// What a selection comes to in a branch of a page, if it comes to that.
    pub(crate) fn of(selection: &'a Selection, page: &Page<'_>, root: &Branch) -> Option<Seen<'a>> {
        let Tolerance::Perspective(view) = &selection.tolerance else { return None };
        if !selection.regions.is_empty() || !selection.extra.is_empty() {
            return None;
        }
        let node = page.node(root)?;
        let wide = view.at(DVec3::from_array(node.center.map(f64::from)), WIDER * f64::from(node.radius));
        Some(Seen { selection, view, radius: node.radius, allowed: wide * ROUNDING })
    }
}

impl Criterion for Seen<'_> {
    #[inline]
    fn sight(&self, page: &Page<'_>, branch: &Branch, inside: bool, stats: &mut Stats) -> Option<Sight> {
        Criterion::sight(self.selection, page, branch, inside, stats)
    }

    #[inline]
    fn activates(&self, _index: u32, vertex: &VertexRecord) -> bool {
        let key = self.selection.order.of_vertex(vertex);
        let is_small = vertex.radius.get() <= self.radius;
        if is_small && f64::from(key) <= self.allowed {
            return false;
        }
        self.view.is_exceeded(f64::from(key), vertex.center().into(), vertex.radius())
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
