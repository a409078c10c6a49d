//! What becomes of the nodes and vertices of a page.

use crate::eager::UNKNOWN;
use crate::extraction::Stats;
use crate::part::{Settled, Sight};
use crate::{Order, Perspective, Selection, Tolerance, region};
use fct::{Branch, Node, Page, Reader, ShortFloat, VertexRecord};
use glam::DVec3;

/// Decides about nodes and vertices. A selection does; what decides as it does and sooner does too.
pub(crate) trait Criterion {
    /// What becomes of a node of a page, and counts it; none if it is not there.
    fn sight(&self, page: &Page<'_>, branch: &Branch, settled: Settled, stats: &mut Stats) -> Option<Sight>;

    /// Whether the vertex of this index is drawn.
    fn activates(&self, index: u32, vertex: &VertexRecord) -> bool;

    /// What the rank of a vertex's key says about it.
    fn thresholds(&self) -> Thresholds;
}

/// What the ranks of keys say about vertices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Thresholds {
    /// Vertices with keys from here on are active.
    pub(crate) active: i16,
    /// Vertices with smaller keys than this are not active, unless their spheres are larger than that of the page or of
    /// the node on whose boundary they are.
    pub(crate) inactive: i16,
}

impl Thresholds {
    /// Nothing.
    const NOTHING: Thresholds = Thresholds { active: UNKNOWN, inactive: i16::MIN };

    /// Whether a vertex of this rank is active; none if it takes a closer look. [`UNKNOWN`] always does.
    #[inline]
    pub(crate) fn of(self, rank: i16) -> Option<bool> {
        let is_active = (rank >= self.active) & (rank != UNKNOWN);
        (is_active | (rank < self.inactive)).then_some(is_active)
    }
}

impl Criterion for Selection {
    #[inline]
    fn sight(&self, page: &Page<'_>, branch: &Branch, settled: Settled, stats: &mut Stats) -> Option<Sight> {
        let node = page.node(branch)?;
        Some(Selection::sight(self, &page.subtree(branch), &node, settled, stats))
    }

    #[inline]
    fn activates(&self, index: u32, vertex: &VertexRecord) -> bool {
        Selection::activates(self, index, vertex)
    }

    #[inline]
    fn thresholds(&self) -> Thresholds {
        Thresholds::NOTHING
    }
}

/// A view's tolerance alone decides, and about most nodes and vertices of a page at a glance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen<'a> {
    selection: &'a Selection,
    view: &'a Perspective,
    /// With keys from here on nodes are refined and vertices active, wherever they are in the page.
    refined: i16,
    /// With smaller keys than this, nodes are drawn.
    drawn: i16,
    /// A vertex whose sphere has a smaller radius than this has it in [`WIDER`] times the sphere of the whole page's root.
    small: i16,
    /// There vertices with smaller keys than this are not active.
    inactive: i16,
    /// Whether regions allow other errors elsewhere, and thus in spheres that reach there.
    has_regions: bool,
}

/// A vertex lies in the sphere of each node whose boundary it is on. The centre of its own sphere is less than sqrt 3
/// radii from it, so a sphere of a quarter of the node's radius reaches less than 0.69 of that beyond.
const WIDER: f64 = 3.8;

/// What rounding may do to what is allowed in nested spheres, and more.
const ROUNDING: f64 = 1e-6;

/// How much more eager than its stored key a vertex is, and more.
const EAGERNESS: f64 = 2e-5;

impl<'a> Seen<'a> {
    /// What a selection comes to in a branch of a page, if it comes to that.
    pub(crate) fn of(selection: &'a Selection, page: &Page<'_>, root: &Branch) -> Option<Seen<'a>> {
        let whole = page.whole();
        if !selection.extra.is_clear_of_nodes(&page.subtree(root)) {
            return None;
        }
        let seen = Seen::below(selection, &page.node(&whole)?)?;
        if *root == whole {
            return Some(seen);
        }
        // What is known of the whole page's vertices holds for some of them too.
        let Seen { refined, drawn, .. } = Seen::below(selection, &page.node(root)?)?;
        Some(Seen { refined, drawn, ..seen })
    }

    /// The same for a node, all below it but what is extra, and their boundaries.
    pub(crate) fn below(selection: &'a Selection, node: &Node) -> Option<Seen<'a>> {
        let Tolerance::Perspective(view) = &selection.tolerance else { return None };
        let center = DVec3::from_array(node.center.map(f64::from));
        let radius = f64::from(node.radius);
        // Beyond a right angle the square of a cosine grows again.
        if view.corner_cos < 0.0
            || !is_clear_of_extra(selection, node)
            || region::touches(&selection.regions, center, WIDER * radius)
        {
            return None;
        }
        let near = view.near(center, radius, WIDER);
        Some(Seen {
            selection,
            view,
            refined: least_over(near.most * (1.0 + ROUNDING)),
            drawn: least_over(near.least * (1.0 - ROUNDING)),
            small: least_over(radius),
            inactive: least_over(near.least_wider * (1.0 - ROUNDING - EAGERNESS)),
            has_regions: !selection.regions.is_empty(),
        })
    }
}

/// Decides about the vertices on the boundary of a node: most of a long one's are out of the question at a glance.
pub(crate) struct Boundary<'a> {
    records: &'a [VertexRecord],
    selection: &'a Selection,
    seen: Option<Seen<'a>>,
    /// As those of a [`Criterion`].
    pub(crate) thresholds: Thresholds,
}

impl<'a> Boundary<'a> {
    pub(crate) fn of(selection: &'a Selection, reader: &Reader<'a>, node: &Node) -> Boundary<'a> {
        let seen = Seen::below(selection, node);
        let thresholds = match &seen {
            Some(seen) => seen.thresholds(),
            None => Everywhere::within(selection)
                .filter(|_| is_clear_of_extra(selection, node))
                .map_or(Thresholds::NOTHING, |everywhere| everywhere.thresholds()),
        };
        Boundary { records: reader.vertices(), selection, seen, thresholds }
    }

    /// Whether the vertex of this index is drawn; not if there is none.
    #[inline]
    pub(crate) fn draws(&self, index: u32) -> bool {
        self.records.get(index as usize).is_some_and(|vertex| match &self.seen {
            Some(seen) => seen.activates(index, vertex),
            None => self.selection.activates(index, vertex),
        })
    }
}

impl Criterion for Seen<'_> {
    #[inline]
    fn sight(&self, page: &Page<'_>, branch: &Branch, settled: Settled, stats: &mut Stats) -> Option<Sight> {
        stats.nodes_visited += 1;
        let mut settled = settled;
        if !settled.is_shown() {
            match self.selection.shows_of_page(page, branch, settled, stats)? {
                Some(now_settled) => settled = now_settled,
                None => return Some(Sight::Culled),
            }
        }
        let key = self.selection.order.of(page.keys(branch)?).rank();
        let is_refined = key >= self.refined
            || key >= self.drawn && {
                let node = page.node(branch)?;
                let key = f64::from(self.selection.order.of_node(&node));
                self.view.is_exceeded(
                    key,
                    DVec3::from_array(node.center.map(f64::from)),
                    f64::from(node.radius),
                )
            };
        Some(if is_refined { Sight::Refined { settled } } else { Sight::Drawn })
    }

    #[inline]
    fn activates(&self, index: u32, vertex: &VertexRecord) -> bool {
        if self.has_regions && vertex.radius.rank() >= self.small {
            return self.selection.activates(index, vertex);
        }
        let key = self.selection.order.of([vertex.bound, vertex.budget]).rank();
        if key >= self.refined {
            return true;
        }
        if key < self.inactive && vertex.radius.rank() < self.small {
            return false;
        }
        let key = self.selection.order.of_vertex(vertex);
        self.view.is_exceeded(f64::from(key), vertex.center().into(), vertex.radius())
    }

    #[inline]
    fn thresholds(&self) -> Thresholds {
        Thresholds { active: self.refined, inactive: self.inactive }
    }
}

/// The same tolerance everywhere, and nothing left out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Everywhere {
    order: Order,
    /// With keys from here on nodes are refined.
    refined: i16,
    /// With keys from here on vertices are active, which are a little more eager.
    active: i16,
}

impl Everywhere {
    /// What a selection comes to in a branch of a page, if it comes to that.
    pub(crate) fn of(
        selection: &Selection,
        page: &Page<'_>,
        root: &Branch,
        settled: Settled,
    ) -> Option<Everywhere> {
        let everywhere = Everywhere::within(selection).filter(|_| settled.is_shown())?;
        let is_alone = selection.extra.is_empty()
            || selection.extra.is_clear_of_nodes(&page.subtree(root))
                && is_clear_of_extra(selection, &page.node(&page.whole())?);
        is_alone.then_some(everywhere)
    }

    /// The same without what is extra, where it does not matter what is left out.
    fn within(selection: &Selection) -> Option<Everywhere> {
        match selection.tolerance {
            Tolerance::Uniform { distance } if selection.regions.is_empty() => {
                let distance = distance.min(f64::MAX);
                let refined = least_over(distance);
                // Eagerness is less than a step of short floats.
                let below = VertexRecord { bound: ShortFloat::down(distance), ..VertexRecord::default() };
                let active = refined - i16::from(f64::from(below.bound()) > distance);
                Some(Everywhere { order: selection.order, refined, active })
            }
            _ => None,
        }
    }
}

impl Criterion for Everywhere {
    #[inline]
    fn sight(&self, page: &Page<'_>, branch: &Branch, settled: Settled, stats: &mut Stats) -> Option<Sight> {
        stats.nodes_visited += 1;
        let key = self.order.of(page.keys(branch)?).rank();
        Some(if key >= self.refined { Sight::Refined { settled } } else { Sight::Drawn })
    }

    #[inline]
    fn activates(&self, _index: u32, vertex: &VertexRecord) -> bool {
        self.order.of([vertex.bound, vertex.budget]).rank() >= self.active
    }

    #[inline]
    fn thresholds(&self) -> Thresholds {
        Thresholds { active: self.active, inactive: self.active }
    }
}

/// Whether no vertex is drawn in a node's sphere, where all vertices of its faces are, but those that keys ask for.
#[inline]
fn is_clear_of_extra(selection: &Selection, node: &Node) -> bool {
    selection.extra.is_clear_of(DVec3::from_array(node.center.map(f64::from)), f64::from(node.radius))
}

/// The rank of the least short float that is more than this; the least rank of all for a number that is negative or none.
#[inline]
pub(crate) fn least_over(x: f64) -> i16 {
    if x.is_nan() || x < 0.0 {
        return i16::MIN;
    }
    let near = x.min(f64::from(f32::MAX)) as f32;
    let below = near.to_bits().saturating_sub(u32::from(f64::from(near) > x));
    // The upper half of a single that is not negative.
    ((below >> 16) + 1) as i16
}
